"""Stability intervals of one parameter, with exact end points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import sympy
from sympy import QQ, Expr, Poly, Symbol

from compensator_theory._latex import displayed, latex, words
from compensator_theory._printing import text
from compensator_theory.errors import InputError
from compensator_theory.polynomials._budget import repr_of
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._decidable import irrational_constants
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import from_coefficients, scaled
from compensator_theory.polynomials._reading import PolynomialLike, polynomial
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import Time, as_symbol, time_of
from compensator_theory.roots._counts import count_roots
from compensator_theory.roots._root_counts import RootCount
from compensator_theory.stability._conditions import stability_conditions
from compensator_theory.stability._critical_values import (
    CriticalValue,
    approximation,
    cells_between,
    critical_polynomials,
    is_less,
    real_roots,
    signs_at_real_roots,
)


@dataclass(frozen=True)
class StabilityCell(ExactValue):
    """An open interval in which no root crosses the boundary, or a value at which the degree drops.

    Attributes
    ----------
    lower, upper : sympy.Expr
        Exact; -oo and oo at the ends. Equal where it is one value.
    sample : sympy.Expr
        A rational value inside; the value itself where it is one value.
    count : RootCount
        Where the roots lie there, and so in the whole interval.

    Examples
    --------
    >>> from compensator_theory import stability_intervals
    >>> stability_intervals("s + k", "k", variable="s").cells[0].count.unstable
    1
    """

    lower: Expr
    upper: Expr
    sample: Expr
    count: RootCount

    @property
    def is_stable(self) -> bool:
        """Whether every root is stable."""
        return self.count.stable == self.count.total

    def __contains__(self, value: object) -> bool:
        number = exact_number(value)
        if self.lower == self.upper:
            return bool(sympy.Eq(self.lower, number))
        return is_less(self.lower, number) and is_less(number, self.upper)

    def __str__(self) -> str:
        if self.lower == self.upper:
            return f"{{{_written(self.lower)}}}"
        return f"({_written(self.lower)}, {_written(self.upper)})"

    def _repr_latex_(self) -> str:
        if self.lower == self.upper:
            return displayed(rf"\left\{{{latex(self.lower)}\right\}}")
        return displayed(latex((self.lower, self.upper)))


@dataclass(frozen=True)
class StabilityIntervals(ExactValue):
    """The values of a parameter for which all roots are stable, and the root counts elsewhere.

    Attributes
    ----------
    polynomial : sympy.Poly
        As requested.
    parameter : sympy.Symbol
    cells : tuple of StabilityCell
        In ascending order, all of the real line but their end points, at which a root lies on the
        boundary or the degree drops. Empty where that is so for every value.
    points : tuple of StabilityCell
        The values at which the leading coefficient vanishes and all roots of the remaining
        polynomial are stable; empty for the gains of a loop, where a root that goes to infinity is
        no stable one.

    Examples
    --------
    >>> from compensator_theory import stability_intervals
    >>> print(stability_intervals("k*s**3 + s + 1", "k"))
    k*s**3 + s + 1 is stable for k in {0}, where the degree drops
    >>> print(stability_intervals("z*(z - 1)*(z - 1/2) + k", "k", variable="z"))
    z**3 - 3*z**2/2 + z/2 + k is stable for k in (0, -3/4 + sqrt(17)/4 = 0.280776)
    """

    polynomial: Poly
    parameter: Symbol
    cells: tuple[StabilityCell, ...]
    points: tuple[StabilityCell, ...] = ()

    @property
    def intervals(self) -> tuple[StabilityCell, ...]:
        """The cells in which every root is stable."""
        return tuple(cell for cell in self.cells if cell.is_stable)

    def __contains__(self, value: NumberLike) -> bool:
        number = exact_number(value)
        return any(number in cell for cell in (*self.intervals, *self.points))

    def around(self, value: NumberLike) -> StabilityCell:
        """Return the stable interval or point that holds a value; InputError if none does."""
        number = exact_number(value)
        for cell in (*self.intervals, *self.points):
            if number in cell:
                return cell
        raise InputError(f"{self.parameter} = {number} is not stable. {self}")

    def __str__(self) -> str:
        where = " or ".join(map(str, (*self.intervals, *self.points)))
        verdict = f"is stable for {self.parameter} in {where}" if where else (
            f"is stable for no real {self.parameter}"
        )  # fmt: skip
        if self.points:
            verdict += ", where the degree drops"
        return f"{format_polynomial(self.polynomial)} {verdict}"

    def _repr_latex_(self) -> str:
        cells = r" \cup ".join(map(latex, (*self.intervals, *self.points))) or r"\emptyset"
        stable = rf"{latex(self.polynomial)} {words(' is stable ')}"
        return displayed(rf"{stable} \iff {latex(self.parameter)} \in {cells}")


@holds_where_defined
@refusing
def stability_intervals(
    poly: PolynomialLike, parameter: str | Symbol, *, variable: str | Symbol | None = None
) -> StabilityIntervals:
    r"""Find all real values of one parameter for which every root is stable.

    The roots of :func:`critical_polynomials` cut the line into cells; in each the roots are counted
    exactly at one rational value. Where the leading coefficient vanishes, what is left of the
    polynomial is judged, as everywhere: :math:`ks^2 + s + 1` is :math:`s + 1` at k = 0.

    Parameters
    ----------
    poly : polynomial
        In s, or in z or q; its coefficients rational functions of the parameter.
    parameter : str or Symbol
    variable : str or Symbol, optional
        Default: evident.

    Returns
    -------
    StabilityIntervals
        End points are rational, in square roots, or SymPy's CRootOf.

    Raises
    ------
    InputError
        If the polynomial is zero, has other symbols or irrational coefficients, or its variable is
        none of s, z and q.

    Examples
    --------
    >>> from compensator_theory import stability_intervals
    >>> intervals = stability_intervals("s*(s - 1)*(s**2 + 4*s + 16) + k*(s + 1)", "k")
    >>> [(cell.lower, cell.upper) for cell in intervals.intervals]
    [(59/2 - 3*sqrt(17)/2, 3*sqrt(17)/2 + 59/2)]
    """
    p, k = polynomial(poly, variable), as_symbol(parameter)
    if p.is_zero:
        raise InputError("every number is a root of the zero polynomial")
    time = time_of(p.gen, "stability")
    symbols = {symbol.name: symbol for symbol in p.free_symbols_in_domain}
    others = sorted(set(symbols) - {k.name})
    if others or k == p.gen:
        raise InputError(
            f"{format_polynomial(p)} has the symbols {', '.join(others) or k} beside the variable "
            f"{p.gen}; intervals need one parameter, so give the others values"
            if others
            else f"{k} is the variable of {format_polynomial(p)} and cannot be the parameter"
        )
    if irrational := irrational_constants(p.all_coeffs()):
        raise InputError(
            f"{format_polynomial(p)} has the irrational number "
            f"{repr_of(min(irrational, key=str))}, "
            "but stability intervals need rational coefficients; give a rational number close to it"
        )
    k = symbols.get(k.name, k)
    divided, cleared = p.clear_denoms()
    divisor = Poly(divided, k, domain=QQ)
    points = tuple(_stable_drops(cleared, k, divisor))
    critical = critical_polynomials(cleared, k, discrete=time == "discrete")
    if critical is None:
        return StabilityIntervals(p, k, (), points)
    ends = real_roots([*critical, divisor])
    return StabilityIntervals(p, k, tuple(_cells(cleared, k, ends, time)), points)


def _stable_drops(poly: Poly, parameter: Symbol, divisor: Poly) -> Iterator[StabilityCell]:
    """Yield the values where the degree drops and the remaining polynomial is stable."""
    coefficients = [Poly(c, parameter, domain=QQ) for c in poly.all_coeffs()]
    for factor, _ in coefficients[0].factor_list()[1]:
        if divisor.rem(factor).is_zero:
            continue  # the polynomial is not defined there
        left = [c.rem(factor) for c in coefficients]
        while left and left[0].is_zero:
            left = left[1:]
        if not left:
            continue  # every number is a root of the remaining polynomial
        lower = from_coefficients([c.as_expr() for c in left], poly.gen)
        degree = RootCount(len(left) - 1, 0, 0)
        leading = signs_at_real_roots(left[0], factor)
        conditions = {
            sign: [
                signs_at_real_roots(Poly(c, parameter, domain=QQ), factor)
                for c in stability_conditions(scaled(lower, sympy.Integer(sign)))
            ]
            for sign in set(leading)
        }
        for index, root in enumerate(real_roots([factor])):
            if all(signs[index] > 0 for signs in conditions[leading[index]]):
                yield StabilityCell(root.value, root.value, root.value, degree)


def _cells(
    poly: Poly, parameter: Symbol, ends: list[CriticalValue], time: Time
) -> list[StabilityCell]:
    cells = []
    whole = poly.clear_denoms(convert=True)[1]  # has none; of a ring, not of its field
    flat = whole.inject() if whole.domain.is_PolynomialRing else whole
    for lower, upper, sample in cells_between(ends):
        there = flat.eval(parameter, sample) if parameter in flat.gens else flat
        cells.append(StabilityCell(lower, upper, sample, count_roots(there, time=time)))
    return cells


def _written(end: Expr) -> str:
    if end.is_Rational or end in (-sympy.oo, sympy.oo):  # is_finite would isolate an indexed root
        return text(end)
    # SymPy's own value of an indexed root sets mpmath's precision, which all threads share.
    return f"{text(end)} = {float(approximation(end)):.6g}"
