"""All gains with which a loop is stable, exact."""

from __future__ import annotations

from dataclasses import replace

from sympy import Poly, Symbol

from compensator_theory.loops._siso import LoopPart, read_loop
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.polynomials._letters import introduced, names_in_all
from compensator_theory.polynomials._poly import (
    ask_for_coefficients,
    canonical,
    from_coefficients,
    over_one_field,
)
from compensator_theory.stability._stability_intervals import (
    StabilityIntervals,
    stability_intervals,
)
from compensator_theory.stability._stability_regions import StabilityRegion, region_of_gains


@holds_where_defined
@refusing
def stabilising_gains(
    plant: LoopPart,
    compensator: LoopPart = 1,
    *,
    feedback: int,
    gain: str | Symbol | None = None,
    variable: str | Symbol | None = None,
) -> StabilityIntervals | StabilityRegion:
    r"""Find all real gains k with which k G_c stabilises G.

    .. math:: \tilde D(s) = D D_c - f\,k\,N N_c

    Parameters
    ----------
    plant, compensator : transfer function
        N/D and :math:`N_c/D_c` in one variable; anything :func:`transfer_function` reads. Their
        coefficients are rational, or polynomials in other symbols with rational coefficients. By
        default the compensator is the gain alone.
    feedback : {+1, -1}
        The sign f.
    gain : str or Symbol, optional
        The name of the gain in the result: k, or "gain" where k is a symbol of the plant or of
        the compensator.
    variable : str or Symbol, optional
        Of the plant; default: evident.

    Returns
    -------
    StabilityIntervals or StabilityRegion
        A region where there are other symbols: they come in the order of their names, and the gain
        is the last parameter. Of intervals ``around(1)`` is the gain margin of the loop as it is,
        downwards and upwards, exact, and conditional stability shows as several intervals. A mode
        that is hidden and not stable leaves none, and a gain at which the degree drops is not
        stable: a root went to infinity (1 - f k G G_c vanishes there, and the loop is not well
        posed).

    Raises
    ------
    InputError
        If a coefficient is irrational, the variables differ, `feedback` is neither +1 nor -1, or
        `gain` names a symbol that the plant or the compensator has.

    Examples
    --------
    >>> from compensator_theory import stabilising_gains
    >>> print(stabilising_gains("1/(s*(s + 1)*(s + 2))", feedback=-1))
    s**3 + 3*s**2 + 2*s + k is stable for k in (0, 6)
    >>> print(stabilising_gains("1/(s*(s + 1)*(s + a))", feedback=-1))
    a in (0, oo): k in (0, a**2 + a)

    A symbol k of the plant is another gain than that of the loop:

    >>> print(stabilising_gains("k/(s*(s + 1)*(s + 2))", feedback=-1))
    k in (-oo, 0): gain in (6/k, 0)
    k in (0, oo): gain in (0, 6/k)

    All PI controllers k (1 + r/s) that stabilise an unstable plant:

    >>> print(stabilising_gains("1/((s - 1)*(s + 2))", "1 + r/s", feedback=-1))
    r in (0, 1): k in (-2/(r - 1), oo)
    """
    polynomial, k = _polynomial(plant, compensator, feedback, gain, variable)
    others = sorted(polynomial.free_symbols_in_domain - {k}, key=str)
    if others:
        return region_of_gains(polynomial.clear_denoms(convert=True)[1], (*others, k))
    return intervals_of_loop(polynomial, k)


def intervals_of_gains(
    plant: LoopPart, compensator: LoopPart = 1, *, feedback: int
) -> StabilityIntervals:
    """`stabilising_gains` of rational coefficients; InputError where there are symbols."""
    return intervals_of_loop(*_polynomial(plant, compensator, feedback, None, None))


def intervals_of_loop(polynomial: Poly, k: Symbol) -> StabilityIntervals:
    """The stable values of a gain in D + k N, where a degree that drops is a root at infinity."""
    ask_for_coefficients(polynomial, int(polynomial.degree()), "the gains that stabilise")
    return replace(stability_intervals(polynomial, k), points=())


def _polynomial(
    plant: LoopPart,
    compensator: LoopPart,
    feedback: int,
    gain: str | Symbol | None,
    variable: str | Symbol | None,
) -> tuple[Poly, Symbol]:
    """The characteristic polynomial of the loop with a gain, and the gain."""
    G, G_c = read_loop(plant, compensator, feedback, variable=variable)
    k = introduced(
        gain, names_in_all(G, G_c), "k", "gain",
        meaning="the gain of the loop", owner="a symbol of the plant or of the compensator",
    )  # fmt: skip
    N, D, N_c, D_c = over_one_field(G.numerator, G.denominator, G_c.numerator, G_c.denominator)
    through, around = N * N_c, D * D_c
    size = max(through.degree(), around.degree())
    polynomial = from_coefficients(
        [
            around.coeff_monomial(G.variable**i) - feedback * k * through.coeff_monomial(
                G.variable**i
            )
            for i in range(int(size), -1, -1)
        ],
        G.variable,
    )  # fmt: skip
    return canonical(polynomial), k
