"""Simultaneous stabilisation of two plants, by strong stabilisability of an auxiliary plant."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import QQ, Poly, Rational, Symbol

from compensator_theory._latex import displayed, latex, words
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.loops._siso import require_sign, well_posed_loop
from compensator_theory.matrices._certificates import Certificate, evaluated
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import time_of
from compensator_theory.stability._stable_compensators import (
    LOOP,
    loop_residuals,
    search_by_order,
)
from compensator_theory.stability._strong_stabilisability import (
    StrongStabilisability,
    decide_strong_stabilisability,
)
from compensator_theory.systems._conversions import TransferFunctionLike, transfer_function
from compensator_theory.systems._sample_times import shared_sample_time
from compensator_theory.systems._transfer_functions import TransferFunction


@dataclass(frozen=True)
class SimultaneousStabilisability(ExactValue):
    """Whether one compensator stabilises both of two plants, with such a compensator.

    Attributes
    ----------
    plants : tuple of TransferFunction
        In lowest terms.
    is_stabilisable : bool
        The answer, decided.
    auxiliary : TransferFunction or None
        Its strong stabilisability is the question; None where the plants are equal.
    decision : StrongStabilisability or None
        The answer to it with its evidence; None where the plants are equal.
    compensator : TransferFunction or None
        One that stabilises both, where the search found one; None for the reason in `reason`.
    characteristic_polynomials : tuple of sympy.Poly
        Of both loops with it, both stable; empty without it.
    reason : str
        Why there is no compensator: none exists, or none was found; "" if there is one.
    """

    _ANSWER = "is_stabilisable"

    plants: tuple[TransferFunction, TransferFunction]
    is_stabilisable: bool
    auxiliary: TransferFunction | None
    decision: StrongStabilisability | None
    compensator: TransferFunction | None
    characteristic_polynomials: tuple[Poly, ...]
    reason: str = ""

    @property
    def certificate(self) -> Certificate | None:
        """Both loops and the counts of their roots, evaluated anew; None without a compensator."""
        if self.compensator is None:
            return None
        loops = zip(self.plants, self.characteristic_polynomials, strict=True)
        left = [loop_residuals(plant, self.compensator, loop) for plant, loop in loops]
        return evaluated(f"{LOOP}, for both plants", [part for parts in left for part in parts])

    def __str__(self) -> str:
        if self.compensator is None:
            return self.reason
        return f"{self.compensator} stabilises both plants"

    def _repr_latex_(self) -> str:
        if self.compensator is None:
            return displayed(words(str(self)))
        loops = (
            rf"\tilde D_{k} = {latex(p)}" for k, p in enumerate(self.characteristic_polynomials, 1)
        )
        return displayed(f"G_c = {latex(self.compensator)}", *loops)


@refusing
def decide_simultaneous_stabilisability(
    first: TransferFunctionLike,
    second: TransferFunctionLike,
    *,
    feedback: int,
    variable: str | Symbol | None = None,
) -> SimultaneousStabilisability:
    r"""Decide whether one compensator stabilises two plants, and search one.

    With :math:`P_i = N_i M_i^{-1}` and :math:`M_1 V + N_1 U = 1` over the stable proper functions,
    all compensators of the first are :math:`(U + M_1 Q)/(V - N_1 Q)`, and one of them stabilises
    the second if and only if a stable Q stabilises

    .. math:: P = \frac{N_2 M_1 - N_1 M_2}{M_2 V + N_2 U}

    Parameters
    ----------
    first, second : transfer function
        Strictly proper, rational, in one variable s, z or q, without unstable hidden modes;
        anything :func:`transfer_function` reads.
    feedback : {+1, -1}
        The sign with which the loops are closed.
    variable : str or Symbol, optional
        Of both plants; default: evident.

    Returns
    -------
    SimultaneousStabilisability
        The compensator comes from :func:`stable_compensator` of P.

    Raises
    ------
    InputError
        If a plant is not strictly proper, symbolic, zero or has a hidden unstable mode, the
        variables differ, or `feedback` is neither +1 nor -1.

    Notes
    -----
    For three plants no procedure with rational operations and signs decides (V. Blondel, M. Gevers,
    Math. Control Signals Systems 6 (1993) 135-145). Source: M. Vidyasagar, N. Viswanadham, IEEE
    Transactions on Automatic Control 27 (1982) 1085-1094.

    Examples
    --------
    >>> from compensator_theory import decide_simultaneous_stabilisability
    >>> print(decide_simultaneous_stabilisability("1/(s - 1)", "1/(s - 2)", feedback=-1))
    (3*s + 1)/(s) stabilises both plants
    >>> print(decide_simultaneous_stabilisability("1/(s - 1)", "-1/(s - 1)", feedback=-1))
    no compensator stabilises both plants
    """
    require_sign(feedback)
    plants = [transfer_function(plant, variable) for plant in (first, second)]
    s = plants[0].variable
    time = time_of(s, "stabilisability")
    if plants[1].variable != s:
        raise InputError(f"one plant is in {s} and the other in {plants[1].variable}")
    period = shared_sample_time(*plants)
    reduced = _reduced(plants[0]), _reduced(plants[1])
    (n_1, d_1), (n_2, d_2) = ((G.numerator, G.denominator) for G in reduced)
    h = Poly(s if time == "discrete" else s + 1, s, domain=QQ)
    size = int(d_1.degree())
    # d_1 v + n_1 u = h^(2 size), deg u < size = deg v
    u = (h ** (2 * size) * n_1.invert(d_1)).rem(d_1) if size else Poly(0, s, domain=QQ)
    v = (h ** (2 * size) - n_1 * u).exquo(d_1)
    top, bottom = n_2 * d_1 - n_1 * d_2, d_2 * v + n_2 * u
    if top.is_zero:
        return _result(True, None, None, reduced, (u, v), feedback, period)
    auxiliary = TransferFunction(canonical(top), canonical(bottom), sample_time=period)
    if auxiliary.numerator.degree() > auxiliary.denominator.degree():
        raise InputError("the auxiliary plant is improper, which strictly proper plants exclude")
    decision = decide_strong_stabilisability(auxiliary)
    possible = decision.is_strongly_stabilisable
    if not possible:
        return SimultaneousStabilisability(
            reduced, False, auxiliary, decision, None, (), "no compensator stabilises both plants"
        )
    size = max(0, auxiliary.reduced().order - 1)
    ask("degree", 28 * size, "the search for a stable compensator of the auxiliary plant")
    compensator = search_by_order(auxiliary, size, feedback=-1, between=False).compensator
    if compensator is None:
        reason = (
            "some compensator stabilises both plants; the search for a stable compensator of the "
            f"auxiliary plant {auxiliary} up to order {size} found none, which is no proof that "
            "there is none: try stable_compensator with a larger max_order"
        )
        return SimultaneousStabilisability(reduced, True, auxiliary, decision, None, (), reason)
    # C = (U + M_1 Q)/(V - N_1 Q) with U = u/h^size, V = v/h^size, M_1 = d_1/h^size
    a, b = compensator.numerator, compensator.denominator
    chosen = u * b + d_1 * a, v * b - n_1 * a
    return _result(True, auxiliary, decision, reduced, chosen, feedback, period)


def _reduced(plant: TransferFunction) -> TransferFunction:
    if not plant.is_strictly_proper or plant.numerator.is_zero:
        raise InputError(f"the plant {plant} must be strictly proper and not zero")
    decision = decide_strong_stabilisability(plant)
    if not decision.is_stabilisable:
        raise InputError(f"{decision}; no compensator stabilises it")
    return plant.reduced()


def _result(
    answer: bool,
    auxiliary: TransferFunction | None,
    decision: StrongStabilisability | None,
    plants: tuple[TransferFunction, TransferFunction],
    compensator: tuple[Poly, Poly],
    feedback: int,
    period: Rational | None,
) -> SimultaneousStabilisability:
    top, bottom = compensator
    C = TransferFunction(
        canonical(-feedback * top), canonical(bottom), feedback=feedback, sample_time=period
    ).reduced()
    loops = tuple(well_posed_loop(plant, C, feedback) for plant in plants)
    result = SimultaneousStabilisability(plants, answer, auxiliary, decision, C, loops)
    if not C.is_proper or result.certificate is None or not result.certificate.holds:
        raise NoSolutionError(f"{C} does not stabilise both plants; please report it")
    return result
