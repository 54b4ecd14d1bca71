"""Consequences of the observer-based structure for optimality."""

from __future__ import annotations

import sympy
from sympy import Poly, Symbol

from compensator_theory.loops._siso import LoopPart, siso_loop, well_posed_loop
from compensator_theory.observers._decisions import ObserverDecision
from compensator_theory.observers._questions import (
    pair_is_observer_based,
    transfer_function_is_observer_based,
)
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._poly import is_rational
from compensator_theory.polynomials._variables import Time, time_of
from compensator_theory.roots._counts import count_roots
from compensator_theory.roots._stability import decide_stability
from compensator_theory.systems._conversions import TransferFunctionLike


@refusing
def is_lqg_suboptimal(
    plant: LoopPart,
    compensator: TransferFunctionLike,
    *,
    feedback: int,
    variable: str | Symbol | None = None,
) -> ObserverDecision:
    r"""Decide whether a compensator is suboptimal for every LQG problem on the plant.

    .. math:: J = \mathrm{E}\,|u - Kx|^2, \qquad \dot x = Ax + Bu + Fw, \quad y = Cx + w

    is the problem for which an observer-based compensator with stable A + BK and A - FC is optimal,
    with J = 0.

    Parameters
    ----------
    plant : transfer function or Realisation
        SISO of order n, without hidden modes.
    compensator : transfer function
        The pair :math:`(N_c, D_c)`; common factors are part of the loop, not of the cost.
    feedback : {+1, -1}
        The sign f in :math:`u = f G_c y`.
    variable : str or Symbol, optional
        Of the plant; default: evident.

    Returns
    -------
    ObserverDecision
        Yes if the loop is unstable, or if :math:`G_c` in lowest terms is not observer-based. No if
        it is observer-based and the loop is stable: the problem above has it as its optimum. None
        if a root lies on the boundary of stability, symbols decide, or, in discrete time, it is not
        strictly proper; `reason` names the case.

    Raises
    ------
    NotCoprimeError, ImproperError, InputError
        See :func:`pair_is_observer_based`; also if the variable is none of s (continuous time), z
        and q (discrete time).

    Notes
    -----
    Erratum: Sections 7.1 and 7.6 conclude "suboptimal" from "not observer-based". That is true of
    coprime :math:`(N_c, D_c)`. A pair with a common factor can fail to be observer-based while its
    transfer function, on which alone the cost depends, is optimal. Stable means Hurwitz in the
    variable s and Schur in z and q. LQG problems may have correlated noises and a cross weight, as
    in (A.1)-(A.12), and :math:`R_2` and :math:`V_2` are positive definite, so that the optimal
    transfer function is unique.

    Examples
    --------
    >>> from compensator_theory.observers import is_lqg_suboptimal
    >>> plant, g = "1/(s**3 + 3*s**2 + 8*s + 6)", "(s**2 + 4*s + 5)"
    >>> is_lqg_suboptimal(plant, (f"4*{g}", f"(s + 1)*{g}"), feedback=-1).answer
    False
    """
    G, G_c = siso_loop(plant, compensator, feedback, variable)
    time = time_of(G.variable, "LQG")
    question = f"Is it suboptimal for every LQG problem in {time} time?"
    Dtilde = well_posed_loop(G, G_c.reduced(), feedback)
    stable = _is_stable(Dtilde)
    if stable is False:
        return ObserverDecision(question, True, "the closed loop is unstable", None, Dtilde)
    if not G_c.reduced().is_strictly_proper:
        if time == "continuous":
            reason = "it is not strictly proper and passes white sensor noise on to u unfiltered"
            return ObserverDecision(question, True, reason, 0, Dtilde)
        reason = "it uses the current measurement, which LQG with one step of delay does not"
        return ObserverDecision(question, None, reason, None, Dtilde)
    structure = transfer_function_is_observer_based(G, G_c, feedback=feedback)
    if structure.answer is False:
        reason = f"in lowest terms it is not observer-based: {structure.reason}"
        return ObserverDecision(question, True, reason, 0, Dtilde)
    if structure.answer is None or stable is None:
        unknown = structure.reason if stable else _why_undecided(Dtilde)
        return ObserverDecision(question, None, unknown, None, Dtilde)
    pair = pair_is_observer_based(G, G_c, feedback=feedback)
    hidden = "" if pair.answer else " (the pair as it is written is not, but the cost ignores that)"
    reason = (
        f"its transfer function is observer-based{hidden} and the closed loop is stable, so that "
        "it is optimal for the cost |u - Kx|^2 with process noise Fw and sensor noise w"
    )
    return ObserverDecision(question, False, reason, structure.number_of_forms, Dtilde)


def _is_stable(poly: Poly) -> bool | None:
    """Decide exactly; None on the boundary and where symbols decide."""
    time = time_of(poly.gen, "stability")
    if not is_rational(poly):
        if decide_stability(poly, time=time).is_stable:
            return True
        return False if _is_certainly_unstable(poly, time) else None
    count = count_roots(poly, time=time)
    return False if count.unstable else None if count.boundary else True


def _is_certainly_unstable(poly: Poly, time: Time) -> bool:
    """Roots up to the boundary alone have coefficients of one sign, or a product of at most 1."""
    if time == "discrete":
        return bool((sympy.Abs(poly.TC() / poly.LC()) - 1).is_positive)
    return any(sympy.factor(c / poly.LC()).is_negative for c in poly.all_coeffs())


def _why_undecided(poly: Poly) -> str:
    time = time_of(poly.gen, "stability")
    if not is_rational(poly):
        if decide_stability(poly, time=time).is_stable is False:
            return "the closed loop is not stable, but its roots may lie on the boundary only"
        return "the stability of the closed loop depends on the values of symbols"
    boundary = count_roots(poly, time=time).boundary
    return (
        f"{boundary} root(s) of the closed loop lie on the boundary of stability, "
        "where the cost of an LQG problem need not have a stabilising optimum"
    )
