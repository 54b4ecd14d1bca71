"""The sensitivity function of a loop, and the compensator that it determines."""

from __future__ import annotations

from sympy import Poly, Symbol

from compensator_theory.errors import ImproperError, InputError
from compensator_theory.loops._siso import LoopPart, read_loop, well_posed_loop
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.polynomials._poly import canonical, over_one_field
from compensator_theory.systems._sample_times import shared_sample_time
from compensator_theory.systems._transfer_functions import TransferFunction


@holds_where_defined
@carrying()
def sensitivity_function(
    plant: LoopPart, compensator: LoopPart, *, feedback: int, variable: str | Symbol | None = None
) -> TransferFunction:
    r"""Return the sensitivity function with the unreduced closed-loop polynomial below.

    .. math:: S = \frac{1}{1 - f\,G\,G_c} = \frac{D D_c}{\tilde D}, \qquad
              \tilde D = D D_c - f\,N N_c

    Parameters
    ----------
    plant, compensator : transfer function
        N/D and :math:`N_c/D_c` in one variable; anything :func:`transfer_function` reads, symbols
        allowed.
    feedback : {+1, -1}
        The sign f; -1 is the one of (7.22).
    variable : str or Symbol, optional
        Of the plant; default: evident.

    Raises
    ------
    ImproperError
        If :math:`\tilde D = 0` or its degree is below that of :math:`D D_c`: the loop is not well
        posed.
    InputError
        If the variables differ or `feedback` is neither +1 nor -1.

    Notes
    -----
    Source: (7.22), (7.23).

    Examples
    --------
    >>> from compensator_theory import sensitivity_function
    >>> print(sensitivity_function("1/(s - 1)", "3", feedback=-1))
    (s - 1)/(s + 2)
    """
    G, G_c = read_loop(plant, compensator, feedback, variable=variable)
    closed = well_posed_loop(G, G_c, feedback)
    D, D_c = over_one_field(G.denominator, G_c.denominator)
    return TransferFunction(canonical(D * D_c), closed, sample_time=shared_sample_time(G, G_c))


@carrying()
def compensator_from_sensitivity(
    plant: LoopPart, sensitivity: LoopPart, *, feedback: int, variable: str | Symbol | None = None
) -> TransferFunction:
    r"""Return the only transfer function that gives a loop this sensitivity function.

    .. math:: G_c = f\,\frac{S - 1}{S\,G}

    Parameters
    ----------
    plant, sensitivity : transfer function
        In one variable, neither of them zero; anything :func:`transfer_function` reads.
    feedback : {+1, -1}
        The sign f; -1 is the one of (7.24).
    variable : str or Symbol, optional
        Of the plant; default: evident.

    Returns
    -------
    TransferFunction
        Reduced: common factors of :math:`N_c` and :math:`D_c` do not show in S.

    Raises
    ------
    ImproperError
        If it would be improper: 1 - S must fall off at infinity as fast as G.
    InputError
        If S or the plant is zero, the variables differ, or `feedback` is neither +1 nor -1.

    Notes
    -----
    Source: (7.24). The characteristic polynomial alone does not determine the compensator; S does.
    Whether the loop is stable S does not say: where a stable S is not 0 at an unstable pole of the
    plant, or not 1 at an unstable zero, the compensator cancels it.

    Examples
    --------
    >>> from compensator_theory.loops import compensator_from_sensitivity
    >>> print(compensator_from_sensitivity("1/(s - 1)", "(s - 1)/(s + 2)", feedback=-1))
    (3)/(1)
    """
    G, S = read_loop(plant, sensitivity, feedback, name="sensitivity function", variable=variable)
    for name, function in (("plant", G), ("sensitivity function", S)):
        if function.numerator.is_zero:
            raise InputError(f"the {name} is zero, which no compensator gives")
    N, D, above, below = over_one_field(G.numerator, G.denominator, S.numerator, S.denominator)
    change = canonical(above - below)
    G_c = TransferFunction(
        canonical(change * D * feedback),
        canonical(above * N),
        sample_time=shared_sample_time(G, S),
    ).reduced()
    if not G_c.is_proper:
        raise ImproperError(
            f"S = {S} needs the improper compensator {G_c}: 1 - S has relative degree "
            f"{_relative_degree(change, S)}, which must be at least that of the plant, "
            f"{G.relative_degree}"
        )
    return G_c


def _relative_degree(change: Poly, S: TransferFunction) -> int | str:
    return "infinity" if change.is_zero else S.order - int(change.degree())
