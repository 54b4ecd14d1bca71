"""All gains with which a loop is stable, exact."""

from __future__ import annotations

from dataclasses import replace

from sympy import Symbol

from compensator_theory.loops.siso import LoopPart, read_loop
from compensator_theory.polynomials.poly import canonical, from_coefficients, over_one_field
from compensator_theory.polynomials.variables import as_symbol
from compensator_theory.stabilisation.stability_intervals import (
    StabilityIntervals,
    stability_intervals,
)


def stabilising_gains(
    plant: LoopPart,
    compensator: LoopPart = 1,
    *,
    feedback: int,
    gain: str | Symbol = "k",
    variable: str | Symbol | None = None,
) -> StabilityIntervals:
    r"""Find all real gains k with which k G_c stabilises G.

    .. math:: \tilde D(s) = D D_c - f\,k\,N N_c

    Parameters
    ----------
    plant, compensator : transfer function
        N/D and :math:`N_c/D_c` with rational coefficients in one variable; anything
        :func:`transfer_function` reads. By default the compensator is the gain alone.
    feedback : {+1, -1}
        The sign f.
    gain : str or Symbol
        What the gain is called in the result.
    variable : str or Symbol, optional
        Of the plant; default: evident.

    Returns
    -------
    StabilityIntervals
        ``around(1)`` is the gain margin of the loop as it is, downwards and upwards, exact, and
        conditional stability shows as several intervals. A mode that is hidden and not stable
        leaves none, and a gain at which the degree drops is not stable: a root went to infinity
        (1 - f k G G_c vanishes there, and the loop is not well posed).

    Raises
    ------
    InputError
        If a coefficient is symbolic or irrational, the variables differ, or `feedback` is neither
        +1 nor -1.

    Examples
    --------
    >>> from compensator_theory import stabilising_gains
    >>> print(stabilising_gains("1/(s*(s + 1)*(s + 2))", feedback=-1))
    s**3 + 3*s**2 + 2*s + k is stable for k in (0, 6)
    """
    G, G_c = read_loop(plant, compensator, feedback, variable=variable)
    k = as_symbol(gain)
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
    return replace(stability_intervals(canonical(polynomial), k), points=())
