"""Text to exact SymPy expressions, without ever evaluating the text as Python code."""

import ast
import re
from dataclasses import dataclass, replace
from fractions import Fraction
from math import comb

import sympy
from sympy import Expr, Integer, Rational, Symbol

from compensator_theory.errors import InputError

MAX_LENGTH = 20_000
MAX_POWER = 1_000
MAX_TERMS = 2_000

_LITERAL = re.compile(r"(?P<real>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)(?P<imaginary>[jJ]?)")
_NAME = re.compile(r"(?!\w*__)[^\W\d_]\w*")
_CONSTANTS = {"I": sympy.I, "j": sympy.I, "pi": sympy.pi}
_NOT_NUMBERS = frozenset({"nan", "inf", "infinity", "oo", "zoo"})
_GRAMMAR = "numbers, names, + - * / ** ^, parentheses and sqrt(...)"


@dataclass(frozen=True)
class _Quotient:
    """Numerator and denominator kept apart, and bounds on what they are multiplied out.

    `power` bounds the total degree of both in the symbols and square roots named in `generators`,
    `terms` and `terms_below` their numbers of terms.
    """

    numerator: Expr
    denominator: Expr
    power: int
    terms: int = 1
    terms_below: int = 1
    generators: frozenset[str] = frozenset()

    def value(self) -> Expr:
        return self.numerator / self.denominator


def parse_expression(text: str) -> Expr:
    r"""Read an arithmetic expression exactly: decimals become rationals.

    ``0.1`` :math:`= 1/10`, ``0.8j`` :math:`= \tfrac{4}{5}\,\mathrm{j}`, and ``^`` means ``**``.

    Parameters
    ----------
    text : str
        Numbers, names, ``+ - * / ** ^``, parentheses and ``sqrt``. ``j`` and ``I`` are the
        imaginary unit, ``pi`` is the constant, every other name is a symbol. Attribute access,
        indexing, other calls, names with a double underscore, powers above 1000 and expressions
        that may multiply out to more than 2000 terms are refused.

    Returns
    -------
    sympy.Expr
        The exact value; SymPy cancels common factors (see :func:`parse_quotient`).

    Raises
    ------
    InputError
        If the text is empty, is not such an expression, divides by zero or is not finite.

    Examples
    --------
    >>> from compensator_theory import parse_expression
    >>> parse_expression("0.1*a + 1/3 - 0.8j")
    a/10 + 1/3 - 4*I/5
    """
    numerator, denominator = parse_quotient(text)
    return numerator / denominator


def parse_quotient(text: str) -> tuple[Expr, Expr]:
    """Read a quotient without cancelling factors that its two sides share.

    Products multiply numerators and denominators, sums use the product of two different
    denominators, so that an expression means the connection of blocks that it shows.

    Parameters
    ----------
    text : str
        As for :func:`parse_expression`.

    Returns
    -------
    tuple of sympy.Expr
        Numerator and denominator.

    Raises
    ------
    InputError
        As for :func:`parse_expression`.

    Examples
    --------
    >>> from compensator_theory.polynomials.expressions import parse_quotient
    >>> parse_quotient("(s + 1)/((s + 1)*(s + 2))")
    (s + 1, (s + 1)*(s + 2))
    """
    if not isinstance(text, str):
        raise InputError(f"{text!r} is not a string; write for instance 's**2 + 0.1*s + 1/3'")
    if len(text) > MAX_LENGTH:
        raise InputError(
            f"the expression has {len(text)} characters; at most {MAX_LENGTH} are read"
        )
    if not text.strip():
        raise InputError("the expression is empty; write for instance 's**2 + 0.1*s + 1/3'")
    source = " ".join(text.split()).replace("^", "**")
    try:
        result = _read(ast.parse(source, mode="eval").body, source.encode())
    except (SyntaxError, MemoryError, RecursionError) as error:
        raise InputError(
            f"cannot read {_short(text)}: write {_GRAMMAR}, spell products out as in 2*s"
        ) from error
    return result.numerator, result.denominator


def _read(node: ast.expr, source: bytes) -> _Quotient:
    match node:
        case ast.Constant():
            return _literal(source[node.col_offset : node.end_col_offset].decode())
        case ast.Name(id=name):
            symbol = _named(name)
            own = frozenset([name]) if symbol.is_Symbol else frozenset()
            return _Quotient(symbol, Integer(1), 1, generators=own)
        case ast.UnaryOp(op=ast.UAdd(), operand=operand):
            return _read(operand, source)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            inner = _read(operand, source)
            return replace(inner, numerator=-inner.numerator)
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            return _power(_read(left, source), _read(right, source).value())
        case ast.BinOp(left=left, op=operator, right=right):
            return _combine(_read(left, source), operator, _read(right, source))
        case ast.Call(func=ast.Name(id="sqrt"), args=[argument], keywords=[]):
            inner = _read(argument, source)
            own = inner.generators | {source[node.col_offset : node.end_col_offset].decode()}
            root = sympy.sqrt(inner.value())
            return replace(
                inner, numerator=root, denominator=Integer(1), terms_below=1, generators=own
            )
        case _:
            piece = source[node.col_offset : node.end_col_offset].decode()
            raise InputError(f"{_short(piece)} is not allowed in an expression: write {_GRAMMAR}")


def _literal(text: str) -> _Quotient:
    found = _LITERAL.fullmatch(text)
    if found is None:
        raise InputError(f"{_short(text)} is not a number; write decimals such as 0.25 or 1e-3")
    try:
        value = Fraction(found["real"])
    except ValueError as error:  # more digits than Python converts
        raise InputError(f"the number {_short(text)} has too many digits") from error
    number = Rational(value.numerator, value.denominator)
    return _Quotient(number * sympy.I if found["imaginary"] else number, Integer(1), 1)


def _named(name: str) -> Expr:
    if name in _CONSTANTS:
        return _CONSTANTS[name]
    if name.lower() in _NOT_NUMBERS:
        raise InputError(f"{name!r} is not a finite number; exact data must be finite")
    if name == "i":
        raise InputError("'i' is ambiguous here; write the imaginary unit as j or I")
    if _NAME.fullmatch(name) is None:
        raise InputError(f"{_short(name)} is not a name for a symbol; use letters and digits")
    return Symbol(name)


def _combine(left: _Quotient, operator: ast.operator, right: _Quotient) -> _Quotient:
    n_1, d_1, n_2, d_2 = left.numerator, left.denominator, right.numerator, right.denominator
    t_1, b_1, t_2, b_2 = left.terms, left.terms_below, right.terms, right.terms_below
    power, generators = left.power + right.power, left.generators | right.generators
    match operator:
        case ast.Mult():
            return _bounded(
                _Quotient(n_1 * n_2, d_1 * d_2, power, t_1 * t_2, b_1 * b_2, generators)
            )
        case ast.Div() if n_2.is_zero:
            raise InputError("the expression divides by zero")
        case ast.Div():
            up, down = (n_1 * d_2 / n_2, d_1) if n_2.is_number else (n_1 * d_2, d_1 * n_2)
            return _bounded(_Quotient(up, down, power, t_1 * b_2, b_1 * t_2, generators))
        case ast.Add() | ast.Sub():
            sign = 1 if isinstance(operator, ast.Add) else -1
            if d_1 == d_2:
                power = max(left.power, right.power)
                return _bounded(_Quotient(n_1 + sign * n_2, d_1, power, t_1 + t_2, b_1, generators))
            up, down = n_1 * d_2 + sign * n_2 * d_1, d_1 * d_2
            terms = t_1 * b_2 + t_2 * b_1
            return _bounded(_Quotient(up, down, power, terms, b_1 * b_2, generators))
        case _:
            raise InputError(f"this operator is not allowed in an expression: write {_GRAMMAR}")


def _power(base: _Quotient, exponent: Expr) -> _Quotient:
    if not exponent.is_Integer:
        raise InputError(f"the exponent {exponent} is not an integer; roots are written sqrt(...)")
    size = abs(int(exponent))
    if size > MAX_POWER:
        raise InputError(f"the exponent {_short(str(exponent))} exceeds {MAX_POWER}")
    if exponent < 0 and base.numerator.is_zero:
        raise InputError("the expression divides by zero")
    bounds = _Quotient(
        base.numerator,
        base.denominator,
        max(1, base.power * size),
        _terms_of_power(base.terms, size),
        _terms_of_power(base.terms_below, size),
        base.generators,
    )
    _bounded(bounds)  # before the power is taken
    up, down = base.numerator**size, base.denominator**size
    above, below = bounds.terms, bounds.terms_below
    if exponent < 0:
        up, down, above, below = down, up, below, above
    return _bounded(replace(bounds, numerator=up, denominator=down, terms=above, terms_below=below))


def _terms_of_power(terms: int, size: int) -> int:
    return comb(terms + size - 1, size)  # monomials of that degree in so many unknowns


def _bounded(quotient: _Quotient) -> _Quotient:
    """Return the quotient with its tightest bounds, or refuse it if they are too large."""
    if quotient.power > MAX_POWER:
        raise InputError(f"the expression multiplies out to powers above {MAX_POWER}")
    kinds = len(quotient.generators)
    monomials = comb(quotient.power + kinds, kinds)
    above, below = min(quotient.terms, monomials), min(quotient.terms_below, monomials)
    if max(above, below) > MAX_TERMS:
        raise InputError(
            f"the expression may multiply out to {max(above, below):.2g} terms, and at most "
            f"{MAX_TERMS} are read: lower its powers (total degree {quotient.power}) or give fewer "
            f"of its {kinds} symbols at once"
        )
    return replace(quotient, terms=above, terms_below=below)


def _short(text: str) -> str:
    return repr(text if len(text) <= 60 else text[:57] + "...")
