"""Stability regions of several parameters: exact cells, each with a sample."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, combinations_with_replacement
from math import comb
from typing import ClassVar, TypeAlias

import sympy
from sympy import QQ, Expr, Poly, Rational, Symbol

from compensator_theory._latex import displayed, latex, words
from compensator_theory._printing import text
from compensator_theory.errors import InputError
from compensator_theory.polynomials._budget import ask, repr_of
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._decidable import irrational_constants
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import ask_for_coefficients, canonical
from compensator_theory.polynomials._reading import PolynomialLike, polynomial
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import as_symbol, is_discrete
from compensator_theory.roots._half_plane import half_plane_polynomial
from compensator_theory.stability._critical_values import cells_between, even_and_odd, real_roots
from compensator_theory.stability._stability_intervals import (
    StabilityIntervals,
    stability_intervals,
)

Ends: TypeAlias = tuple[Expr | None, Expr | None]
# For each parameter the curves, in it and those before it, on which something may change.
Levels: TypeAlias = tuple[tuple[Poly, ...], ...]


@dataclass(frozen=True)
class StabilitySlab(ExactValue):
    """An interval of a parameter over which no boundary crosses another or turns back.

    Attributes
    ----------
    lower, upper : sympy.Expr
        Its open range, where parameters before it have the values of their samples; exact, -oo and
        oo at the ends.
    sample : sympy.Rational
        A value inside.
    section : StabilityIntervals or StabilityRegion
        The stable values of the remaining parameters at `sample`. The whole slab has as many cells,
        with ends that move along the boundary curves.
    range : (sympy.Expr or None, sympy.Expr or None)
        `lower` and `upper` as functions of the parameters before it: roots of degree one or two;
        None where the curve has a higher degree.
    ends : tuple of (sympy.Expr or None, sympy.Expr or None)
        The same of each interval of a section that is intervals; empty otherwise.
    """

    lower: Expr
    upper: Expr
    sample: Rational
    section: StabilityIntervals | StabilityRegion
    range: Ends
    ends: tuple[Ends, ...]

    @property
    def is_empty(self) -> bool:
        """Whether the slab has no stable values."""
        if isinstance(self.section, StabilityRegion):
            return self.section.is_empty
        return not self.section.intervals

    def _repr_latex_(self) -> str:
        where = rf"{latex((self.lower, self.upper))} \ni {latex(self.sample)}"
        return displayed(where, latex(self.section))


@dataclass(frozen=True)
class StabilityRegion(ExactValue):
    """The values of two or more parameters for which all roots are stable.

    Attributes
    ----------
    polynomial : sympy.Poly
        As requested.
    parameters : tuple of sympy.Symbol
    boundaries : tuple of sympy.Expr
        Irreducible, in the parameters: a root can reach the boundary of stability only on these
        curves, or surfaces.
    slabs : tuple of StabilitySlab
        Of the first parameter, from left to right, all of the space but finitely many surfaces.
        What is stable where the leading coefficient vanishes only, `in` and `section` tell: there
        the remaining polynomial is decided.
    of_a_loop : bool
        Whether the parameters are gains of a loop, which is not well posed where the degree drops:
        there `in` and `section` say not stable.
    """

    _REST: ClassVar[str] = ".slabs lists them"
    polynomial: Poly
    parameters: tuple[Symbol, ...]
    boundaries: tuple[Expr, ...]
    slabs: tuple[StabilitySlab, ...]
    of_a_loop: bool = False

    @property
    def is_empty(self) -> bool:
        """Whether no open set is stable; where the degree drops, see `section`."""
        return all(slab.is_empty for slab in self.slabs)

    def section(self, value: NumberLike) -> StabilityIntervals | StabilityRegion:
        """Return the stable values of the other parameters for one of the first."""
        number = sympy.sympify(exact_number(value))
        if not number.is_Rational:
            raise InputError(f"{self.parameters[0]} = {number} must be a rational number")
        there = _at(self.polynomial, self.parameters[0], number)
        rest = self.parameters[1:]
        if len(rest) == 1:
            return _intervals(there, rest[0], of_a_loop=self.of_a_loop)
        return _region(there, rest, of_a_loop=self.of_a_loop)

    def __contains__(self, values: tuple[NumberLike, ...]) -> bool:
        if not isinstance(values, tuple | list) or len(values) != len(self.parameters):
            raise InputError(f"a value is needed for each of {_listed(self.parameters)}")
        first, *rest = values
        return (rest[0] if len(rest) == 1 else tuple(rest)) in self.section(first)

    def __str__(self) -> str:
        none = f"stable for no real {_listed(self.parameters)}"
        lines = _lines(self, _knows_formulas(self))
        if set(sympy.sympify(self.polynomial.LC()).free_symbols) and not self.of_a_loop:
            drop = f"where {text(self.polynomial.LC())} = 0 the degree drops; see section()"
            none = f"stable for no open set of {_listed(self.parameters)}"
            return "\n".join([*(lines or [none]), drop])
        return "\n".join(lines) or none

    def _repr_latex_(self) -> str:
        stable = _latex_lines(self, _knows_formulas(self))
        curves = r", \; ".join(f"{latex(curve)} = 0" for curve in self.boundaries)
        listed = r", \; ".join(map(latex, self.parameters))
        verdict = stable or [words("stable for no ") + listed]
        return displayed(*verdict, f"{words('bounded by ')} {curves}" if curves else "")


@holds_where_defined
@refusing
def stability_region(
    poly: PolynomialLike,
    first: str | Symbol,
    second: str | Symbol,
    *others: str | Symbol,
    variable: str | Symbol | None = None,
) -> StabilityRegion:
    r"""Find all real values of two or more parameters for which every root is stable.

    The boundaries are the constant and the leading coefficient and :math:`\mathrm{Res}_t(E, O)` of
    the polynomial :math:`E(s^2) + s\,O(s^2)`. Where they meet, turn or go to infinity, by their
    resultants, discriminants and leading coefficients, the parameters are cut into cells one after
    the other (a cylindrical decomposition, its open cells).

    Parameters
    ----------
    poly : polynomial
        In s, or in z or q; its coefficients polynomials in the parameters.
    first, second, *others : str or Symbol
        In the order in which they are cut; the last is free where the others have values.
    variable : str or Symbol, optional
        Default: evident.

    Returns
    -------
    StabilityRegion

    Raises
    ------
    InputError, BudgetError
        If the polynomial is zero, has other symbols, a coefficient is a fraction, or a root lies on
        the boundary of stability for all values.

    Notes
    -----
    Source: the parameter plane of D. Mitrovic (1959) and D. D. Siljak (1969), here with proof: no
    isolated component is missed; open cells by the projection of G. E. Collins (1975).
    ``rcac_numeric.plots.plot_stability_region`` draws it for two parameters.

    Examples
    --------
    >>> from compensator_theory import stability_region
    >>> region = stability_region("s*(s + 1)**3 + k_p*s + k_i", "k_p", "k_i")
    >>> print(region)
    k_p in (-1, 8): k_i in (0, -k_p**2/9 + 7*k_p/9 + 8/9)
    >>> ("1", "1/2") in region, ("1", "2") in region
    (True, False)

    All PID controllers k_p + k_i/s + k_d s of 1/(s (s + 1)):

    >>> print(stability_region("s**2*(s + 1) + k_d*s**2 + k_p*s + k_i", "k_d", "k_p", "k_i"))
    k_d in (-1, oo): k_p in (0, oo): k_i in (0, k_d*k_p + k_p)
    """
    p = polynomial(poly, variable)
    if p.is_zero:
        raise InputError("every number is a root of the zero polynomial")
    is_discrete(p.gen, "stability")
    symbols = {symbol.name: symbol for symbol in p.free_symbols_in_domain}
    parameters = tuple(
        symbols.get(as_symbol(k).name, as_symbol(k)) for k in (first, second, *others)
    )
    unknown = sorted(set(symbols) - {k.name for k in parameters})
    if unknown or len(set(parameters)) < len(parameters) or p.gen in parameters:
        raise InputError(
            f"{format_polynomial(p)} is to be stable for values of {_listed(parameters)}, and "
            f"besides the variable {p.gen} it has {', '.join(unknown) or 'these'}; name different "
            "parameters, and give other symbols values"
        )
    return _region(p, parameters)


def region_of_gains(poly: Poly, parameters: tuple[Symbol, ...]) -> StabilityRegion:
    """The region of a loop's characteristic polynomial; where its degree drops, none is stable."""
    return _region(poly, parameters, of_a_loop=True)


def _region(p: Poly, parameters: tuple[Symbol, ...], *, of_a_loop: bool = False) -> StabilityRegion:
    if p.domain.is_FractionField:
        raise InputError("a coefficient is a fraction; multiply by its denominator first")
    if irrational := irrational_constants(p.all_coeffs()):
        raise InputError(
            f"{format_polynomial(p)} has the irrational number "
            f"{repr_of(min(irrational, key=str))}, "
            "but stability regions need rational coefficients; give a rational number close to it"
        )
    ask("degree", int(p.degree()) ** len(parameters), "the region of stability")
    ask_for_coefficients(p, int(p.degree()) ** 2 // 4, "the region of stability", 10)
    boundaries = _boundaries(p, parameters)
    levels = _levels(boundaries, parameters)
    return _decomposed(p, parameters, levels, {}, of_a_loop)


def _decomposed(
    p: Poly,
    parameters: tuple[Symbol, ...],
    levels: Levels,
    before: dict[Symbol, Rational],
    of_a_loop: bool,
) -> StabilityRegion:
    """Return the cells of the remaining parameters, with those `before` at their samples."""
    first, *rest = parameters
    curves = levels[len(before)]
    slabs = []
    for lower, upper, sample in cells_between(real_roots(_there(curves, first, before))):
        place = {**before, first: sample}
        section: StabilityIntervals | StabilityRegion
        left = _at(p, first, sample)
        ends: tuple[Ends, ...] = ()
        if len(rest) == 1:
            section = _intervals(left, rest[0], of_a_loop=of_a_loop)
            ends = tuple(
                (_formula(levels[-1], rest[0], place, cell.lower),
                 _formula(levels[-1], rest[0], place, cell.upper))
                for cell in section.intervals
            )  # fmt: skip
        else:
            section = _decomposed(left, tuple(rest), levels, place, of_a_loop)
        range_ = (
            _formula(curves, first, before, lower), _formula(curves, first, before, upper)
        )  # fmt: skip
        slabs.append(StabilitySlab(lower, upper, sample, section, range_, ends))
    there = tuple(curve.as_expr().subs(before) for curve in levels[-1])
    return StabilityRegion(p, parameters, there, tuple(slabs), of_a_loop)


def _at(p: Poly, parameter: Symbol, value: Rational) -> Poly:
    if parameter not in p.free_symbols_in_domain:
        return p
    flat = p.inject().eval(parameter, value)
    return canonical(flat.eject(*flat.gens[1:]))


def _intervals(p: Poly, parameter: Symbol, *, of_a_loop: bool) -> StabilityIntervals:
    intervals = stability_intervals(p, parameter)
    if not of_a_loop:
        return intervals
    return StabilityIntervals(intervals.polynomial, intervals.parameter, intervals.cells)


def _boundaries(p: Poly, parameters: tuple[Symbol, ...]) -> list[Poly]:
    q = half_plane_polynomial(p) if is_discrete(p.gen, "stability") else p
    even, odd = even_and_odd(q)
    parts = [p.LC(), q.LC(), q.TC()]
    if q.degree() > 1:
        parts.append(even.resultant(odd))
    if q.degree() < p.degree() or any(sympy.expand(part).is_zero for part in parts):
        raise InputError(
            f"{format_polynomial(p)} has a root on the boundary of stability, or a pair of "
            "roots symmetric about it, for all values of the parameters; divide it out first"
        )
    return _factors(parts, parameters)


def _levels(boundaries: list[Poly], parameters: tuple[Symbol, ...]) -> Levels:
    """Return for each parameter the critical curves in it and the earlier ones."""
    levels = [tuple(boundaries)]
    for last in range(len(parameters) - 1, 0, -1):
        ask("degree", sum(int(c.total_degree()) for c in levels[0]), "the region of stability")
        levels.insert(0, tuple(_projected(levels[0], parameters[: last + 1])))
    return tuple(levels)


def _projected(curves: tuple[Poly, ...], parameters: tuple[Symbol, ...]) -> list[Poly]:
    """Project curves: where they meet, turn, or go to infinity in the last parameter."""
    *rest, last = parameters
    conditions = []
    in_last = []
    for curve in curves:
        if curve.degree(last) == 0:
            conditions.append(curve.as_expr())
        else:
            in_last.append(Poly(curve.as_expr(), last))
    for one, two in combinations_with_replacement([c for c in curves if c.degree(last) > 0], 2):
        degree = int(one.degree(last) * two.total_degree() + two.degree(last) * one.total_degree())
        # As many terms as a polynomial of the degree of their resultant may have.
        ask("terms", comb(degree + len(rest), len(rest)), "the region of stability")
    for curve in in_last:
        conditions.append(curve.LC())
        if curve.degree() > 1:
            conditions.append(curve.discriminant())
    conditions += [one.resultant(two) for one, two in combinations(in_last, 2)]
    return _factors(conditions, tuple(rest))


def _factors(parts: list[Expr], parameters: tuple[Symbol, ...]) -> list[Poly]:
    """The distinct irreducible factors that are not constant."""
    factors: dict[Poly, None] = {}
    for part in parts:
        for factor, _ in Poly(part, *parameters, domain=QQ).factor_list()[1]:
            factors[factor.primitive()[1]] = None
    return list(factors)


def _there(curves: tuple[Poly, ...], last: Symbol, before: dict[Symbol, Rational]) -> list[Poly]:
    """The curves as polynomials in one parameter, those before it at their samples."""
    return [curve.eval(before) if before else curve for curve in curves]


def _formula(
    curves: tuple[Poly, ...], last: Symbol, before: dict[Symbol, Rational], end: Expr
) -> Expr | None:
    """The end of an interval as a function of the parameters before it; None beyond degree two."""
    if end.is_infinite or not before:
        return end
    for curve, there in zip(curves, _there(curves, last, before), strict=True):
        degree = there.degree()
        if degree not in (1, 2):
            continue
        roots = [root.value for root in real_roots([there])]
        if end not in roots:
            continue
        # The roots of a cell neither meet nor change their order in it, and a keeps its sign.
        sign = (-1 if roots.index(end) == 0 else 1) * (1 if there.LC() > 0 else -1)
        return _root_formula(curve, last, sign if degree == 2 else 0)
    return None


@lru_cache(maxsize=128)  # the cells of a region have few formulas
def _root_formula(curve: Poly, last: Symbol, sign: int) -> Expr:
    """Return the root of a curve of degree two of this sign, or the one of degree one."""
    coefficients = Poly(curve.as_expr(), last).all_coeffs()
    if sign == 0:
        return sympy.cancel(-coefficients[1] / coefficients[0])
    a, b, c = coefficients
    root = sympy.sqrt(sympy.factor(b**2 - 4 * a * c))
    return sympy.cancel(-b / (2 * a)) + sign * root / (2 * a)


def _listed(parameters: tuple[Symbol, ...]) -> str:
    return ", ".join(map(str, parameters))


def _knows_formulas(region: StabilityRegion) -> bool:
    """Whether all ends of stable cells are functions of the earlier parameters."""
    for slab in region.slabs:
        if slab.is_empty:
            continue
        if None in slab.range or any(None in ends for ends in slab.ends):
            return False
        if isinstance(slab.section, StabilityRegion) and not _knows_formulas(slab.section):
            return False
    return True


def _lines(region: StabilityRegion, formulas: bool) -> list[str]:
    """Return the stable cells, one line for each cell of all but the last parameter.

    Where not all ends have formulas, they are those at the samples, which are named.
    """
    lines = []
    for slab in region.slabs:
        if slab.is_empty:
            continue
        if formulas:
            low, high = slab.range
            cell = f"{region.parameters[0]} in ({text(low)}, {text(high)})"
        else:
            cell = f"{region.parameters[0]} in ({text(slab.lower)}, {text(slab.upper)})"
            cell += f", for instance {text(slab.sample)}"
        if isinstance(slab.section, StabilityRegion):
            lines += [f"{cell}: {line}" for line in _lines(slab.section, formulas)]
            continue
        cells = [f"({text(low)}, {text(high)})" for low, high in slab.ends]
        written = cells if formulas else map(str, slab.section.intervals)
        lines.append(f"{cell}: {slab.section.parameter} in {' or '.join(written)}")
    return lines


def _latex_lines(region: StabilityRegion, formulas: bool) -> list[str]:
    lines = []
    first = latex(region.parameters[0])
    for slab in region.slabs:
        if slab.is_empty:
            continue
        cell = rf"{first} \in {latex(slab.range if formulas else (slab.lower, slab.upper))}"
        if not formulas:
            cell += rf" \; ({first} = {latex(slab.sample)})"
        if isinstance(slab.section, StabilityRegion):
            lines += [rf"{cell}: \; {line}" for line in _latex_lines(slab.section, formulas)]
            continue
        cells = r" \cup ".join(map(latex, slab.ends if formulas else slab.section.intervals))
        lines.append(rf"{cell}: \; {latex(slab.section.parameter)} \in {cells}")
    return lines
