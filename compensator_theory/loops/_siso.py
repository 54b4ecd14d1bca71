"""The loop of a SISO plant and compensator: its sign and its polynomial D D_c - f N N_c."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, TypeVar

from sympy import Poly, Symbol

from compensator_theory.errors import Advice, ImproperError, InputError, NotCoprimeError
from compensator_theory.polynomials._budget import repr_of
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import canonical, over_one_field
from compensator_theory.polynomials._reading import is_one_of, read_plain_text
from compensator_theory.polynomials._variables import is_operator
from compensator_theory.systems._conversions import TransferFunctionLike, transfer_function
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._sample_times import shared_sample_time
from compensator_theory.systems._transfer_functions import (
    TransferFunction,
    require_proper,
)
from compensator_theory.systems._transfer_matrices import TransferMatrix

LoopPart: TypeAlias = TransferFunctionLike | Realisation
"""A transfer function in any form, or a realisation."""


def require_sign(feedback: object) -> None:
    """Refuse a sign of feedback other than +1 and -1."""
    if not is_one_of(feedback, (1, -1)):
        raise InputError(
            f"feedback = {repr_of(feedback)} must be +1 (u = G_c y) or -1 (u = -G_c y)"
        )


def agreed_sign(compensator: TransferFunction | Realisation, feedback: int | None) -> int:
    """Return the sign of a loop; a compensator that was designed for another one is refused."""
    sign = 1 if feedback is None else feedback
    require_sign(sign)
    designed = compensator.feedback
    if designed is not None and designed != sign:
        raise InputError(
            f"this compensator was designed for feedback = {designed:+d} and the loop is to be "
            f"closed with {sign:+d}, which would be another loop; write feedback={designed:+d}, or "
            "change the sign of the compensator"
        )
    return int(sign)


def closed_loop_of_pair(G: TransferFunction, G_c: TransferFunction, feedback: int) -> Poly:
    r"""Return the closed-loop polynomial, every common factor kept.

    .. math:: D D_c - f\,N N_c

    Notes
    -----
    Source: the denominator of (7.22); chapters 2 and 4 use f = +1, Section 7.3 and after -1.
    """
    N, D, N_c, D_c = over_one_field(G.numerator, G.denominator, G_c.numerator, G_c.denominator)
    if N_c.domain.is_FractionField and not (N.domain.is_Field or D.domain.is_Field):
        (above, n), (below, d) = (p.clear_denoms(convert=True) for p in (N_c, D_c))
        if above == below:  # products without denominators, divided once
            whole = (D * d - N * n * feedback).set_domain(N_c.domain)
            return canonical(whole.quo_ground(above))
    return canonical(D * D_c - N * N_c * feedback)


def is_well_posed(closed: Poly, *parts: TransferFunction) -> bool:
    r"""Tell whether a loop has all its poles: :math:`D D_c - f N N_c` keeps the degree.

    Where :math:`G G_c` tends to f at infinity the degree drops: a root went to infinity, and no
    other root is reason to call such a loop stable.
    """
    return not closed.is_zero and bool(closed.degree() >= sum(part.order for part in parts))


def well_posed_loop(G: TransferFunction, G_c: TransferFunction, feedback: int) -> Poly:
    r"""Return :math:`D D_c - f N N_c` of a loop that has all its poles."""
    Dtilde = closed_loop_of_pair(G, G_c, feedback)
    if not is_well_posed(Dtilde, G, G_c):
        raise ImproperError(
            f"the loop of {G} and {G_c} is not well posed: G G_c tends to {feedback} at infinity, "
            f"so that the direct terms cancel and the closed loop {format_polynomial(Dtilde)} has "
            f"too few poles"
        )
    return Dtilde


def read_loop(
    plant: LoopPart,
    compensator: LoopPart,
    feedback: int,
    *,
    name: str = "compensator",
    variable: str | Symbol | None = None,
) -> tuple[TransferFunction, TransferFunction]:
    """Read a plant and the other part of the loop; a constant has the variable of the plant."""
    require_sign(feedback)
    if isinstance(plant, Realisation):
        G = plant.transfer_function()
    else:
        G = transfer_function(plant, variable)
    if isinstance(compensator, Realisation):
        G_c = compensator.transfer_function()
    else:
        G_c = in_variable_of(G, compensator, transfer_function)
    if G_c.variable != G.variable:
        raise InputError(
            f"the plant is written in the variable {G.variable} and the {name} in {G_c.variable}; "
            "they need the same variable"
        )
    shared_sample_time(G, G_c)
    agreed_sign(G_c, feedback)
    return G, G_c


def siso_loop(
    plant: LoopPart, compensator: LoopPart, feedback: int, variable: str | Symbol | None = None
) -> tuple[TransferFunction, TransferFunction]:
    """Read the proper parts of a loop whose plant is free of hidden modes."""
    G, G_c = read_loop(plant, compensator, feedback, variable=variable)
    require_proper(G, "plant")
    require_proper(G_c, "compensator")
    if G.order == 0:
        raise InputError(f"the plant {G} has no state to estimate")
    factor = G.common_factor()
    if factor.degree() > 0:
        raise NotCoprimeError(
            f"the plant {G} has the hidden modes {format_polynomial(factor)}, whose observers "
            "depend on its realisation; ",
            Advice("realisation_is_observer_based", (), "reduce it, or use {function}"),
        )
    return G, G_c


Read = TypeVar("Read", TransferFunction, TransferMatrix)


def in_variable_of(G: Read, part: Any, read: Callable[[Any, str | Symbol | None], Read]) -> Read:
    """Read the other part of a loop in the variable of G, unless it names another operator."""
    part = read_plain_text(part)
    try:
        sides = read(part, None)
    except InputError:
        return read(part, G.variable)
    if sides.variable == G.variable or is_operator(sides.variable):
        return sides
    return read(part, G.variable)
