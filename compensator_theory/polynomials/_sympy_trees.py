"""SymPy expressions taken apart, and roots put together, under an allow-list and a budget."""

from __future__ import annotations

import math
from collections import Counter

import sympy
from sympy import Expr, Float, Poly, Rational, Symbol

from compensator_theory.errors import InputError
from compensator_theory.polynomials._budget import ask, decimal_digits, limit_of
from compensator_theory.polynomials._quotients import (
    Addition,
    Leaf,
    Power,
    Product,
    Tree,
    multiplied_out,
)

_IRRATIONAL = (
    sympy.NumberSymbol, sympy.core.numbers.ImaginaryUnit, sympy.polys.rootoftools.ComplexRootOf,
    sympy.exp, sympy.log, sympy.functions.elementary.trigonometric.TrigonometricFunction, sympy.Abs,
    sympy.re, sympy.im, sympy.conjugate, sympy.sign,
)  # fmt: skip
_ARITHMETIC = (sympy.Add, sympy.Mul, sympy.Pow)
_RADICAND_DIGITS = 300  # SymPy looks for powers in it, and has their size in floats
_SMALL_PRIMES = 1000  # to which bases of roots are factored, to see what they share
_X = Symbol("x")


def require_readable(expression: Expr) -> None:
    """Refuse an expression that is not built from numbers, symbols and elementary functions."""
    most, deepest = limit_of("characters"), limit_of("nesting")
    waiting: list[tuple[sympy.Basic, int]] = [(expression, 0)]
    nodes = 0
    while waiting:
        part, depth = waiting.pop()
        nodes += 1
        if nodes > most or depth > deepest:
            ask("characters", nodes, "the expression")
            ask("nesting", depth, "the expression")
        if part in (sympy.nan, sympy.oo, -sympy.oo, sympy.zoo):
            raise InputError("the expression is not finite; exact data must be finite")
        if part.is_Rational:
            continue
        if isinstance(part, sympy.polys.rootoftools.ComplexRootOf):
            ask("field_degree", int(part.poly.degree()), f"the number {part}")
        elif isinstance(part, _ARITHMETIC) or (isinstance(part, _IRRATIONAL) and part.args):
            waiting += [(argument, depth + 1) for argument in part.args]
        elif not (part.is_Symbol or isinstance(part, (Float, *_IRRATIONAL))):
            raise InputError(
                f"a {type(part).__name__} in the expression has no supported exact value; give "
                "numbers, symbols, + - * / ** and roots"
            )
        if part.is_Symbol:
            require_scalar_symbol(part)


def require_scalar_symbol(symbol: Symbol) -> None:
    """Refuse a symbol that stands for no real number (a variable may: it may be complex=True)."""
    if symbol.is_commutative is False:
        raise InputError(f"the symbol {symbol} is not commutative; exact data are scalars")
    if symbol.is_real is False:
        kind = "imaginary" if symbol.is_imaginary else "not real"
        raise InputError(
            f"the symbol {symbol} is declared {kind}, but symbols stand for real numbers; "
            f"write I times a real symbol for it where conjugate pairs remain, or declare {symbol} "
            "without"
        )


def tree_of(expression: Expr) -> Tree:
    """Decompose an expression without floats; other than polynomial operations are leaves."""
    if isinstance(expression, sympy.Add):
        return Addition([tree_of(term) for term in expression.args])
    if isinstance(expression, sympy.Mul):
        return Product([tree_of(factor) for factor in expression.args])
    if isinstance(expression, sympy.Pow) and expression.exp.is_Integer:
        return Power(tree_of(expression.base), int(expression.exp))
    if isinstance(expression, sympy.Pow) and expression.exp.is_Rational and expression.exp.p != 1:
        root = sympy.Pow(expression.base, Rational(1, expression.exp.q))  # one unknown a root
        return Power(tree_of(root), int(expression.exp.p))
    return Leaf(expression)


def rational_floats(expression: Expr, binary: bool) -> Expr:
    """Replace every float by the rational number that it means."""
    floats = expression.atoms(Float)
    if not floats:
        return expression
    return expression.xreplace({number: _rational(number, binary) for number in floats})


def _rational(number: Float, binary: bool) -> Rational:
    double_digits, double_range = 15, 300
    sign, mantissa, exponent, _ = number._mpf_
    decades = abs(int(exponent)) * 3 // 10
    ask("digits", decades, "a number")
    if binary:
        return (-1 if sign else 1) * Rational(int(mantissa)) * Rational(2) ** int(exponent)
    is_double = number._prec <= Float(1, double_digits)._prec and decades < double_range
    return Rational(repr(float(number)) if is_double else str(number))


def square_root(argument: Expr) -> Expr:
    """Return SymPy's square root of an expression that is small enough for it."""
    _require_short_radicand(argument)
    require_small_field([argument, sympy.Pow(argument, sympy.S.Half, evaluate=False)])
    return sympy.sqrt(argument)


def _require_short_radicand(argument: Expr) -> None:
    for number in argument.atoms(Rational):  # SymPy writes sqrt(p/q) as sqrt(p q)/q
        if (int(number.p) * int(number.q)).bit_length() > 3.33 * _RADICAND_DIGITS:
            raise InputError(
                f"a number under a root has more than {_RADICAND_DIGITS} digits; give a rational "
                "number close to the root"
            )


def real_power(base: Expr, exponent: Expr) -> Expr:
    """Return the principal value of a rational power; refuse odd roots of negative numbers.

    The real number -2 and a complex one are both called the third root of -8.
    """
    if not exponent.is_Rational:
        raise InputError(
            f"the exponent {str(exponent)[:60]} is not a rational number; roots are written "
            "sqrt(...)"
        )
    if base.is_zero or (exponent.q % 2 and exponent.q > 1 and base.is_extended_negative):
        raise InputError(
            f"({str(base)[:60]})**({exponent}) has several meanings; write the root that you mean"
        )
    _require_short_radicand(base)
    require_small_field([base, sympy.Pow(base, exponent, evaluate=False)])
    ask("field_degree", int(exponent.q), "a root")
    ask("degree", abs(int(exponent.p)), "a power")
    return sympy.Pow(base, exponent)


def indexed_root(polynomial: Expr, index: Expr) -> Expr:
    """Return SymPy's CRootOf, as it prints itself."""
    symbols = polynomial.free_symbols
    if len(symbols) != 1 or not polynomial.is_polynomial() or not sympy.sympify(index).is_Integer:
        raise InputError("write CRootOf(p, k) with a polynomial p in one symbol and an integer k")
    poly = Poly(polynomial, *symbols)
    ask("field_degree", int(poly.degree()), "a root")
    if not (poly.domain.is_ZZ or poly.domain.is_QQ) or not 0 <= index < poly.degree():
        raise InputError(f"{polynomial} is no rational polynomial with a root of number {index}")
    return sympy.CRootOf(poly.as_expr().xreplace({poly.gen: _X}), int(index))


def settled(expression: Expr) -> Expr:
    """Return the form of an expression that reads back to itself."""
    for _ in range(5):
        again = multiplied_out(tree_of(expression), least_denominators=True).value()
        if again == expression:
            break
        expression = again
    return expression


def by_powers(expression: Expr, variable: Symbol) -> dict[int, Expr] | None:
    """Collect an expanded expression by powers; None if it is no polynomial in the variable."""
    if expression == 0:
        return {}  # SymPy takes 0 for a power of the variable
    terms_by_power: dict[int, list[Expr]] = {}
    for term in sympy.Add.make_args(expression):
        rest, power = term.as_independent(variable, as_Add=False)
        base, exponent = power.as_base_exp()
        if power != 1 and not (base == variable and exponent.is_Integer and exponent > 0):
            return None
        terms_by_power.setdefault(0 if power == 1 else int(exponent), []).append(rest)
    return {k: sympy.Add(*terms) for k, terms in terms_by_power.items()}


def require_small_field(numbers: list[Expr]) -> None:
    """Check the budget for the number field of irrational numbers: degree and discriminant.

    The discriminant of a polynomial of degree n has about n (n - 1) times the digits of its
    coefficients, and to find the field is to factor polynomials of that size.
    """
    degree = 1
    by_base: Counter[Expr] = Counter()  # the powers of one base lie in the field of one root of it
    by_prime: Counter[int] = Counter()  # and those of rational bases in that of roots of primes
    for atom in set().union(*(irrational_parts(number) for number in numbers)):
        if isinstance(atom, sympy.Pow):
            index = int(atom.exp.q) if atom.exp.is_Rational else 1
            by_base[atom.base] = math.lcm(by_base[atom.base] or 1, index)
            if atom.base.is_Rational:
                for prime in sympy.factorrat(atom.base, limit=_SMALL_PRIMES):
                    root = index if prime > 0 else 2 * index
                    by_prime[prime] = math.lcm(by_prime[prime] or 1, root)
        elif isinstance(atom, sympy.polys.rootoftools.ComplexRootOf):
            degree *= int(atom.poly.degree())
        else:
            degree *= 2
    others = math.prod(index for base, index in by_base.items() if not base.is_Rational)
    rational = math.prod(index for base, index in by_base.items() if base.is_Rational)
    degree *= others * min(rational, math.prod(by_prime.values()))
    ask("field_degree", degree, "the irrational numbers together")
    longest = decimal_digits(max((_bits(number) for number in numbers), default=0))
    subject = f"the discriminant of irrational numbers of degree {degree}"
    ask("digits", degree * (degree - 1) * longest, subject)


def _bits(number: Expr) -> int:
    """Bound the bits of the rational numbers in a number that is multiplied out."""
    if isinstance(number, sympy.Rational):
        return max(int(number.p).bit_length(), int(number.q).bit_length())
    if isinstance(number, sympy.Pow) and number.exp.is_Rational:
        return int(sympy.ceiling(abs(number.exp))) * _bits(number.base)
    return sum(_bits(part) for part in number.args)


def irrational_parts(number: Expr) -> set[Expr]:
    """Return the roots, the imaginary unit and the indexed roots in a number."""
    constants: set[Expr] = set()
    waiting = [number]
    while waiting:
        part = waiting.pop()
        if part.is_number or isinstance(part, sympy.Pow):
            if isinstance(part, sympy.Pow) and not part.exp.is_Integer:
                constants.add(part)
            elif part == sympy.I or isinstance(part, sympy.polys.rootoftools.ComplexRootOf):
                constants.add(part)
                continue
        waiting += part.args
    return constants
