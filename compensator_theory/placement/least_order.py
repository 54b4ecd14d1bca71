"""The compensator of least order that places poles from a list."""

from __future__ import annotations

from collections.abc import Iterable

from sympy import Symbol

from compensator_theory.errors import ImproperError, InputError, NoSolutionError
from compensator_theory.placement.pole_placement import place_poles
from compensator_theory.placement.solutions import PolePlacement
from compensator_theory.polynomials.from_roots import polynomial_from_roots, read_roots
from compensator_theory.polynomials.numbers import NumberLike
from compensator_theory.systems.conversions import TransferFunctionLike, transfer_function
from compensator_theory.transfer_functions.transfer_functions import require_proper


def place_poles_at_least_order(
    plant: TransferFunctionLike,
    poles: str | Iterable[NumberLike],
    *,
    feedback: int,
    properness: str | None = None,
    variable: str | Symbol | None = None,
) -> PolePlacement:
    r"""Find the compensator of least order that places the first poles of a list.

    .. math:: \min n_c: \quad D D_c - f N N_c = \prod_{i=1}^{n+n_c} (s - \lambda_i)

    Parameters
    ----------
    plant : transfer function
        Proper, of order n.
    poles : sequence
        :math:`\lambda_1, \lambda_2, \ldots` in the order in which they are wanted. A loop with a
        compensator of order n_c has n + n_c of them; the rest of the list is not used.
    feedback, properness, variable
        As for :func:`place_poles`.

    Returns
    -------
    PolePlacement

    Raises
    ------
    NoSolutionError
        If no order up to the length of the list does; with 2n - 1 poles (2n for a strictly proper
        compensator) and a coprime plant one always does, pairs of complex poles permitting.
    NotCoprimeError
        If plant poles that cannot be moved are not in the list.
    InputError
        If there are fewer than n poles, or the argument is no list of roots.

    Notes
    -----
    Orders at which a pair of complex poles would be divided are passed over. Below n - 1 the
    equation has more coefficients than unknowns and is solvable only for special poles.

    Examples
    --------
    >>> from compensator_theory import place_poles_at_least_order
    >>> found = place_poles_at_least_order("1/(s*(s + 3))", [-1, -2, -5, -6], feedback=-1)
    >>> print(found.compensator)  # D + 2 = (s + 1)(s + 2), so that no dynamics are needed
    (2)/(1)
    """
    poles = read_roots(poles)
    G = transfer_function(plant, variable)
    require_proper(G, "plant")
    if len(poles) < G.order:
        raise InputError(
            f"there are {len(poles)} poles, but the loop has at least {G.order}; give more"
        )
    polynomial_from_roots(poles, G.variable)  # complain about the whole list first
    reason: Exception | None = None
    for count in range(G.order, len(poles) + 1):
        try:
            target = polynomial_from_roots(poles[:count], G.variable)
        except InputError:
            continue  # a conjugate pair is divided here
        try:
            return place_poles(G, target, feedback=feedback, properness=properness)
        except (NoSolutionError, ImproperError) as error:
            reason = error
    raise NoSolutionError(
        f"no order n_c from 0 to {len(poles) - G.order} places the first n + n_c of these "
        f"{len(poles)} poles; with {2 * G.order} of them one would. Last reason: {reason}"
    ) from reason
