"""For which values of two symbols a polynomial is stable: an exact decomposition of the plane."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import sympy
from sympy import QQ, Expr, Poly, Rational, Symbol

from compensator_theory.errors import InputError
from compensator_theory.latex import displayed, latex, words
from compensator_theory.polynomials.budget import ask
from compensator_theory.polynomials.formatting import format_polynomial
from compensator_theory.polynomials.numbers import NumberLike, exact_number
from compensator_theory.polynomials.reading import PolynomialLike, polynomial
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.polynomials.variables import as_symbol, is_discrete
from compensator_theory.printing import text
from compensator_theory.stabilisation.critical_values import cells_between, even_and_odd, real_roots
from compensator_theory.stabilisation.half_plane import half_plane_polynomial
from compensator_theory.stabilisation.stability_intervals import (
    StabilityIntervals,
    stability_intervals,
)


@dataclass(frozen=True)
class StabilitySlab(ExactValue):
    """A strip of the plane in which no boundary crosses another or turns back.

    Attributes
    ----------
    lower, upper : sympy.Expr
        The open range of the first parameter; exact, -oo and oo at the ends.
    sample : sympy.Rational
        A value inside.
    section : StabilityIntervals
        The stable values of the second parameter there. In the whole strip there are as many
        intervals, with ends that move along the boundary curves.
    """

    lower: Expr
    upper: Expr
    sample: Rational
    section: StabilityIntervals

    def _repr_latex_(self) -> str:
        where = rf"{latex((self.lower, self.upper))} \ni {latex(self.sample)}"
        return displayed(where, latex(self.section))


@dataclass(frozen=True)
class StabilityRegion(ExactValue):
    """The pairs of values of two parameters for which all roots are stable.

    Attributes
    ----------
    polynomial : sympy.Poly
        As asked.
    parameters : tuple of sympy.Symbol
    boundaries : tuple of sympy.Expr
        Irreducible, in both parameters: a root can reach the boundary of stability only on these
        curves.
    slabs : tuple of StabilitySlab
        From left to right, all of the plane but finitely many lines. What is stable on curves
        where the leading coefficient vanishes only, `in` and `section` tell: there what is left of
        the polynomial is judged.
    """

    polynomial: Poly
    parameters: tuple[Symbol, Symbol]
    boundaries: tuple[Expr, ...]
    slabs: tuple[StabilitySlab, ...]

    @property
    def is_empty(self) -> bool:
        """Whether no open set of pairs is stable; where the degree drops, ask for a `section`."""
        return not any(slab.section.intervals for slab in self.slabs)

    def section(self, value: NumberLike) -> StabilityIntervals:
        """Return the stable values of the second parameter for one of the first."""
        number = sympy.sympify(exact_number(value))
        if not number.is_Rational:
            raise InputError(f"{self.parameters[0]} = {number} must be a rational number")
        return _section(self.polynomial, self.parameters, number)

    def __contains__(self, pair: tuple[NumberLike, NumberLike]) -> bool:
        first, second = pair
        return second in self.section(first)

    def __str__(self) -> str:
        k_1, k_2 = self.parameters
        stable = [slab for slab in self.slabs if slab.section.intervals]
        lines = [
            f"{k_1} in ({text(slab.lower)}, {text(slab.upper)}), "
            f"for instance {text(slab.sample)}: {k_2} in "
            + " or ".join(map(str, slab.section.intervals))
            for slab in stable
        ]
        none = f"stable for no open set of {k_1}, {k_2}"
        if set(sympy.sympify(self.polynomial.LC()).free_symbols):
            drop = f"where {text(self.polynomial.LC())} = 0 what is left is judged, see section()"
            return "\n".join([*(lines or [none]), drop])
        return "\n".join(lines) or f"stable for no real {k_1}, {k_2}"

    def _repr_latex_(self) -> str:
        first, second = map(latex, self.parameters)
        stable = []
        for slab in self.slabs:
            if cells := r" \cup ".join(map(latex, slab.section.intervals)):
                there = rf"{first} = {latex(slab.sample)}: {second} \in {cells}"
                stable.append(rf"{first} \in {latex((slab.lower, slab.upper))} \; ({there})")
        verdict = stable or [words("stable for no ") + rf"\left({first}, {second}\right)"]
        curves = r", \; ".join(f"{latex(curve)} = 0" for curve in self.boundaries)
        return displayed(*verdict, f"{words('bounded by ')} {curves}" if curves else "")


def stability_region(
    poly: PolynomialLike,
    first: str | Symbol,
    second: str | Symbol,
    *,
    variable: str | Symbol | None = None,
) -> StabilityRegion:
    r"""Find all pairs of real values of two parameters for which every root is stable.

    The boundary curves are the constant and the leading coefficient and :math:`\mathrm{Res}_t(E,
    O)` of the polynomial :math:`E(s^2) + s\,O(s^2)`; where they meet or turn, by their resultants
    and discriminants, the first parameter is cut into slabs (a cylindrical decomposition).

    Parameters
    ----------
    poly : polynomial
        In s, or in z or q; its coefficients polynomials in both parameters.
    first, second : str or Symbol
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
    isolated component is missed. ``rcac_numeric.plot_stability_region`` draws it.

    Examples
    --------
    >>> from compensator_theory import stability_region
    >>> found = stability_region("s*(s + 1)**3 + k_p*s + k_i", "k_p", "k_i")
    >>> [(slab.lower, slab.upper) for slab in found.slabs if slab.section.intervals]
    [(-1, 8)]
    >>> ("1", "1/2") in found, ("1", "2") in found
    (True, False)
    """
    p = polynomial(poly, variable)
    if p.is_zero:
        raise InputError("every number is a root of the zero polynomial")
    discrete = is_discrete(p.gen, "stability")
    symbols = {symbol.name: symbol for symbol in p.free_symbols_in_domain}
    k_1, k_2 = (symbols.get(as_symbol(k).name, as_symbol(k)) for k in (first, second))
    others = sorted(set(symbols) - {k_1.name, k_2.name})
    if others or k_1 == k_2 or p.gen in (k_1, k_2):
        raise InputError(
            f"{format_polynomial(p)} is to be stable for values of {k_1} and {k_2}, and beside the "
            f"variable {p.gen} it has {', '.join(others) or 'these'}; name two different "
            "parameters, and give other symbols values"
        )
    if p.domain.is_FractionField:
        raise InputError("a coefficient is a fraction; multiply by its denominator first")
    ask("degree", int(p.degree()) ** 2, "the region of stability")
    boundaries = _boundaries(p, k_1, k_2, discrete)
    ends = real_roots(_critical(boundaries, k_1, k_2))
    slabs = [
        StabilitySlab(lower, upper, sample, _section(p, (k_1, k_2), sample))
        for lower, upper, sample in cells_between(ends)
    ]
    return StabilityRegion(
        p, (k_1, k_2), tuple(curve.as_expr() for curve in boundaries), tuple(slabs)
    )


def _section(p: Poly, parameters: tuple[Symbol, Symbol], value: Rational) -> StabilityIntervals:
    k_1, k_2 = parameters
    there = polynomial(sympy.expand(p.as_expr().subs(k_1, value)), p.gen)
    return stability_intervals(there, k_2)


def _boundaries(p: Poly, k_1: Symbol, k_2: Symbol, discrete: bool) -> list[Poly]:
    q = half_plane_polynomial(p) if discrete else p
    even, odd = even_and_odd(q)
    parts = [p.LC(), q.LC(), q.TC()]
    if q.degree() > 1:
        parts.append(even.resultant(odd))
    found: dict[Poly, None] = {}
    for part in parts:
        curve = Poly(part, k_1, k_2, domain=QQ)
        if curve.is_zero or q.degree() < p.degree():
            raise InputError(
                f"{format_polynomial(p)} has a root on the boundary of stability, or a pair of "
                "roots symmetric about it, for all values of the parameters; divide it out first"
            )
        for factor, _ in curve.factor_list()[1]:
            found[factor.primitive()[1]] = None
    return list(found)


def _critical(boundaries: list[Poly], k_1: Symbol, k_2: Symbol) -> list[Poly]:
    """Return polynomials in the first parameter where curves meet, turn, or go to infinity."""
    found = []
    in_second = []
    for curve in boundaries:
        if curve.degree(k_2) == 0:
            found.append(curve.as_expr())
        else:
            in_second.append(Poly(curve.as_expr(), k_2))
    for curve in in_second:
        found.append(curve.LC())
        if curve.degree() > 1:
            found.append(curve.discriminant())
    found += [one.resultant(two) for one, two in combinations(in_second, 2)]
    return [Poly(part, k_1, domain=QQ) for part in found]
