"""Functions of symbols as unknowns: one dictionary for all arguments of a call."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Set
from math import comb, gcd, lcm

import sympy
from sympy import Expr, Rational, Symbol

from compensator_theory._printing import formula
from compensator_theory.polynomials._decidable import irrational_constants, is_algebraic
from compensator_theory.polynomials._expressions import POSITIVE, UNKNOWN
from compensator_theory.polynomials._sympy_trees import rational_floats
from compensator_theory.polynomials._variables import OPERATORS

_HYPERBOLIC = (sympy.sinh, sympy.cosh, sympy.tanh, sympy.coth, sympy.sech, sympy.csch)
_CIRCULAR = (sympy.sin, sympy.cos, sympy.tan, sympy.cot, sympy.sec, sympy.csc)
_MULTIPLE = 24  # of an angle or an exponent, over the least: powers as high are multiplied out

Terms = list[tuple[Expr, Rational]]


class NotCarriedError(Exception):
    """A function of symbols that cannot be an unknown; the coefficient domains refuse it."""

    def __init__(self, part: Expr | None = None) -> None:
        super().__init__(part)
        self.part = part


class Unknowns:
    r"""The functions of symbols in the input as unknowns, with the relations between them.

    Carried are :math:`e^{cM}` for rational c and monomials M of symbols, or M = 1; sines and
    cosines of cM, rational in one tangent; and rational powers of a symbol. Exponentials of
    different M, and of jM, are algebraically independent over the algebraic functions of the
    symbols (Ax), and those of rational numbers over the algebraic numbers (Lindemann). Each M has
    one unknown, of the greatest common divisor of its c, so that no relation is left. One logarithm
    of a rational number is carried where no other transcendental number occurs. Roots
    of other expressions stay: they leave where all conjugates are listed, and else are refused.
    """

    def __init__(
        self,
        expressions: Iterable[Expr],
        used_names: Set[str] = frozenset(),
        *,
        real: bool = False,
        shifted: bool = False,
    ) -> None:
        self.shifted = shifted
        self.texts: dict[str, str] = {}
        """Texts in unknowns, and the original texts."""
        self.inner: set[Symbol] = set()
        self._exponents: dict[Expr, Rational] = {}
        self._angles: dict[Expr, Rational] = {}
        self._roots: dict[Symbol, int] = {}
        self._written: dict[Expr, Expr] = {}  # a function of the input by its monomial or base
        self._logarithms: set[Expr] = set()
        self._named: set[Expr] = set()
        self._nested: set[Expr] = set()
        exact = (rational_floats(expression, binary=False) for expression in expressions)
        for part in sorted(irrational_constants(exact), key=sympy.default_sort_key):
            self._note(part)
        self._join_powers_of_e()
        self._require_independent(real)
        barred = {x for x in self.inner if x.name in OPERATORS or x.is_real is False}
        if (function := self.function_of(barred)) is not None:
            raise NotCarriedError(function)
        self._used_names = set(used_names)
        self.functions: dict[Symbol, Expr] = {}
        self._exponential = {
            m: self._unknown(sympy.exp(m * c), positive=True) for m, c in self._exponents.items()
        }
        self._tangent = {m: self._unknown(sympy.tan(m * c / 2)) for m, c in self._angles.items()}
        self._tangents = {t: m * self._angles[m] for m, t in self._tangent.items()}
        self._root = {
            k: self._unknown(k ** Rational(1, n), positive=k.is_positive or None)
            for k, n in self._roots.items()
        }
        self._logarithm = {x: self._unknown(x) for x in self._logarithms}

    @property
    def angles(self) -> tuple[Expr, ...]:
        """The angles of which sines and cosines are carried; pi is no value of their tangents."""
        return tuple(self._tangents.values())

    def conditions(self, nonzero: Iterable[Expr]) -> Iterator[Expr]:
        """Write exceptional polynomials: a root vanishes where its radicand does.

        No exponential does, nor does 1 + tan^2, which is 1/cos^2.
        """
        radicands = {r: k for k, r in self._root.items()}
        never = {*self._exponential.values(), *(t**2 + 1 for t in self._tangents)}
        for factor in nonzero:
            if factor not in never:
                yield radicands[factor] if factor in radicands else self.with_functions(factor)
        for angle in self.angles:
            yield 1 + sympy.cos(angle)

    @property
    def renamed(self) -> set[str]:
        """Symbols that are powers of an unknown."""
        return {symbol.name for symbol in self._roots}

    def _unknown(self, function: Expr, positive: bool | None = None) -> Symbol:
        stem = re.sub(r"\W+", "_", str(function)).strip("_")
        last = POSITIVE if positive else UNKNOWN
        name, count = stem + last, 1
        while name in self._used_names:
            count += 1
            name = f"{stem}_{count}{last}"
        self._used_names.add(name)
        symbol = Symbol(name, positive=True) if positive else Symbol(name)
        self.functions[symbol] = function
        return symbol

    def _note(self, part: Expr) -> None:
        kind = _kind(part)
        if kind == "named":
            self._named.add(part)
        elif kind == "logarithm":
            self._logarithms.add(part)
        elif kind == "angle":
            self._note_terms(self._angles, part)
        elif kind == "exponent":
            self._note_terms(self._exponents, part)
        elif kind == "root":
            self.inner.add(part.base)
            self._written.setdefault(part.base, part)
            self._roots[part.base] = lcm(self._roots.get(part.base, 1), int(part.exp.q))
        elif kind == "nested":
            self._nested.add(part)
            for inner in irrational_constants([part.base]):
                self._note(inner)
        elif kind == "other":
            raise NotCarriedError(part)

    def _note_terms(self, kinds: dict[Expr, Rational], part: Expr) -> None:
        for monomial, factor in _terms(part):
            self.inner |= monomial.free_symbols
            self._written.setdefault(monomial, part)
            kinds[monomial] = _common(kinds.get(monomial, sympy.S.Zero), factor)

    def _join_powers_of_e(self) -> None:
        """Treat E as an unknown if its least exponent is an integer."""
        least = self._exponents.get(sympy.S.One)
        if least is not None and sympy.E in self._named:
            least = self._exponents[sympy.S.One] = _common(least, sympy.S.One)
        if least is not None and least.is_Integer:
            self._named.add(sympy.E)
            del self._exponents[sympy.S.One]

    def _require_independent(self, real: bool) -> None:
        one = sympy.S.One
        numbers = bool(self._named) + (one in self._exponents) + (one in self._angles)
        if len(self._logarithms) + numbers > 1 and self._logarithms:
            raise NotCarriedError(max(self._logarithms, key=str))
        if one in self._angles and self._named - {sympy.E}:
            raise NotCarriedError(sympy.sin(self._angles[one]))
        for k, n in self._roots.items():
            if n > _MULTIPLE or (real and not k.is_nonnegative):
                raise NotCarriedError(k ** Rational(1, n))
        for part in self._nested:
            if part.free_symbols & set(self._roots):
                raise NotCarriedError(part)
        if real and one in self._exponents:  # its sign is that of a number, and of no symbol
            raise NotCarriedError(sympy.exp(self._exponents[one]))
        if real and self._logarithms:
            raise NotCarriedError(max(self._logarithms, key=str))
        if real and self._angles:
            raise NotCarriedError(sympy.sin(min(self._angles, key=str)))

    def function_of(self, symbols: Iterable[Symbol]) -> Expr | None:
        """Return a function of one of these symbols as it was written, if there is any."""
        names = set(symbols)
        written = self._written.items()
        return next((part for inner, part in written if inner.free_symbols & names), None)

    def image(self, expression: Expr) -> Expr:
        """Replace functions by unknowns in an expression."""
        expression = rational_floats(expression, binary=False)
        parts: dict[Expr, Expr] = {k: r ** self._roots[k] for k, r in self._root.items()}
        for part in irrational_constants([expression]):
            parts[part] = self._image_of(part)
        return expression.xreplace(parts)

    def _image_of(self, part: Expr) -> Expr:
        kind = _kind(part)
        if kind == "logarithm":
            return self._logarithm[part]
        if part is sympy.E and sympy.S.One in self._exponential:
            return self._power_of_e(part)
        if kind == "root":
            return self._root[part.base] ** (part.exp * self._roots[part.base])
        if kind == "nested":
            return self.image(part.base) ** part.exp
        if kind == "angle":
            cosine, sine = self._pair(part)
            return _ratio(_CIRCULAR.index(type(part)), sine, cosine)
        if isinstance(part, _HYPERBOLIC):
            power = self._power_of_e(sympy.exp(part.args[0]))
            sine, cosine = (power - 1 / power) / 2, (power + 1 / power) / 2
            return _ratio(_HYPERBOLIC.index(type(part)), sine, cosine)
        return self._power_of_e(part) if kind == "exponent" else part

    def _power_of_e(self, part: Expr) -> Expr:
        power: Expr = sympy.S.One
        for monomial, factor in _terms(part):
            unknown = self._exponential.get(monomial)
            if unknown is None:
                power *= sympy.exp(factor)
            else:
                power *= unknown ** _multiple(factor, self._exponents[monomial], part)
        return power

    def _pair(self, part: Expr) -> tuple[Expr, Expr]:
        """Return cosine and sine."""
        cosine, sine = sympy.S.One, sympy.S.Zero
        for monomial, factor in _terms(part):
            t, n = self._tangent[monomial], _multiple(factor, self._angles[monomial], part)
            below = (1 + t**2) ** abs(n)
            sign = (-1) ** n if self.shifted else 1
            signs = [sign * (-1) ** (k // 2) for k in range(2 * abs(n) + 1)]
            terms = [signs[k] * comb(2 * abs(n), k) * t**k for k in range(2 * abs(n) + 1)]
            c = sympy.Add(*terms[::2]) / below
            s = sympy.Add(*terms[1::2]) / below * (1 if n > 0 else -1)
            cosine, sine = cosine * c - sine * s, cosine * s + sine * c
        return cosine, sine

    def with_functions(self, expression: Expr) -> Expr:
        """Replace unknowns by functions in an expression."""
        for t, angle in self._tangents.items():
            if isinstance(expression, Expr) and t in expression.free_symbols:
                expression = _in_sine_and_cosine(expression, t, angle)
        return expression.xreplace(self.functions)

    def words(self, text: str, *, as_latex: bool = False) -> str:
        """Replace unknowns by functions in a sentence."""
        for written, meaning in self.texts.items():
            text = text.replace(written, meaning)
        if not self.functions:
            return text
        write = formula if as_latex else str
        names = {write(symbol): write(function) for symbol, function in self.functions.items()}
        pattern = "|".join(sorted(map(re.escape, names), key=len, reverse=True))
        return re.sub(rf"(?<!\w)(?:{pattern})(?!\w)", lambda match: names[match[0]], text)


def _kind(part: Expr) -> str:
    """Return the kind of a function or number; "decided" for algebraic numbers."""
    if isinstance(part, sympy.NumberSymbol):
        return "named"
    if isinstance(part, sympy.log) and part.args[0].is_Rational:
        return "logarithm"
    if part.is_Float or (not part.free_symbols and is_algebraic(part)):
        return "decided"
    if isinstance(part, _CIRCULAR):
        return "angle"
    if isinstance(part, (sympy.exp, *_HYPERBOLIC)):
        return "exponent"
    if isinstance(part, sympy.Pow) and part.exp.is_Rational and part.free_symbols:
        return "root" if part.base.is_Symbol else "nested"
    return "other"


def _terms(part: Expr) -> Terms:
    """Take the argument of a function apart, a sum of rational multiples of monomials."""
    argument = sympy.S.One if part is sympy.E else part.args[0]
    terms: Terms = []
    for term in sympy.Add.make_args(sympy.expand(argument)):
        factor, monomial = term.as_coeff_Mul()
        powers = monomial.as_powers_dict()
        plain = all(p.is_Integer and (b.is_Symbol or b == 1) for b, p in powers.items())
        if not (factor.is_Rational and plain) or not all(b.is_commutative for b in powers):
            raise NotCarriedError(part)
        if factor.p.bit_length() > 64 or max(abs(p) for p in powers.values()) > _MULTIPLE:
            raise NotCarriedError(part)
        terms.append((monomial, factor))
    return terms


def _common(first: Rational, second: Rational) -> Rational:
    """Return the greatest number of which both are multiples by integers."""
    below = lcm(int(first.q), int(second.q))
    return Rational(gcd(int(first * below), int(second * below)), below)


def _multiple(number: Rational, unit: Rational, part: Expr) -> int:
    multiple = int(number / unit)
    if abs(multiple) > _MULTIPLE:
        raise NotCarriedError(part)
    return multiple


def _ratio(kind: int, sine: Expr, cosine: Expr) -> Expr:
    """Sine, cosine, tangent, cotangent, secant, cosecant."""
    return (sine, cosine, sine / cosine, cosine / sine, 1 / cosine, 1 / sine)[kind]


def _in_sine_and_cosine(expression: Expr, t: Symbol, angle: Expr) -> Expr:
    """Write powers of t = tan(angle/2) over one power of 1 + t**2 = 2/(1 + cos(angle))."""
    others = sorted(expression.free_symbols - {t}, key=str)
    try:
        top, bottom = (
            sympy.Poly(side, t, *others) for side in sympy.fraction(sympy.together(expression))
        )
    except sympy.PolynomialError:  # it stands under a root
        return expression.xreplace({t: sympy.sin(angle) / (1 + sympy.cos(angle))})
    half = (max(top.degree(t), bottom.degree(t)) + 1) // 2
    c, s = sympy.Dummy("c"), sympy.Dummy("s")
    less, more = (sympy.Poly(1 + sign * c, c, s, *others) for sign in (-1, 1))
    sides = []
    for side in (top, bottom):
        polynomial = sympy.Poly(0, c, s, *others)
        for (k, *powers), coefficient in side.terms():
            monomial = {(0, k % 2, *powers): coefficient}
            term = sympy.Poly.from_dict(monomial, c, s, *others)
            polynomial += term * less ** (k // 2) * more ** (half - k // 2 - k % 2)
        sides.append(polynomial)
    factor, above, below = sides[0].cancel(sides[1])
    polynomial = factor * above.as_expr() / below.as_expr()
    return polynomial.xreplace({c: sympy.cos(angle), s: sympy.sin(angle)})


def functions_in(expressions: Iterable[Expr]) -> Iterator[Expr]:
    """Yield the parts that are no algebraic numbers and no named ones."""
    for part in irrational_constants(expressions):
        if part.free_symbols or not (
            isinstance(part, sympy.NumberSymbol)
            or (isinstance(part, sympy.exp) and part.args[0].is_Integer)
            or part.is_Number  # a float, or infinite
            or is_algebraic(part)
        ):
            yield part
