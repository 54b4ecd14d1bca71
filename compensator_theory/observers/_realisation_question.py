"""Whether a realisation, in its given basis and with its hidden modes, is observer-based."""

from __future__ import annotations

from dataclasses import replace

from sympy import Poly, Symbol

from compensator_theory.loops._closed_loop_matrix import closed_loop_matrix
from compensator_theory.loops._siso import agreed_sign
from compensator_theory.matrices._invariant_subspaces import derogatory_factor
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.observers._ball_proofs import prove_forms
from compensator_theory.observers._counting import (
    count_observer_forms,
    count_partitions,
    number_of_selections,
)
from compensator_theory.observers._decisions import NumberOfForms, ObserverDecision
from compensator_theory.observers._enumeration import observer_forms
from compensator_theory.observers._form_lists import ObserverForms
from compensator_theory.observers._questions import decide_by_parity
from compensator_theory.observers._youla import youla_forms
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import canonical, is_rational, monic
from compensator_theory.roots._certified import real_multiplicities
from compensator_theory.systems._canonical_forms import RealisationLike, realisation
from compensator_theory.systems._realisations import Realisation

QUESTION = "Is the realisation observer-based?"


@refusing
def realisation_is_observer_based(
    plant: RealisationLike,
    compensator: RealisationLike,
    *,
    feedback: int | None = None,
    variable: str | Symbol | None = None,
) -> ObserverDecision:
    r"""Decide whether some change of basis turns a realisation into an observer with feedback.

    .. math:: \exists K, F, T: \quad T^{-1}A_cT = A + BK - FC, \quad T^{-1}B_c = F, \quad C_cT = K

    Parameters
    ----------
    plant : realisation
        (A, B, C), of order n; anything :func:`realisation` reads.
    compensator : realisation
        :math:`(A_c, B_c, C_c)` with :math:`u = C_c x_c`. For :math:`n_c < n` the question is
        whether it observes a function Tx of the state, for :math:`n_c > n` whether it is an
        observer with a Youla parameter.
    feedback : {+1, -1}, optional
        The sign f in :math:`u = f C_c x_c`; default +1. With -1 the compensator of the result has
        the sign in its output matrix. A compensator of :func:`place_poles` knows its sign, and
        another one is refused.
    variable : str or Symbol, optional
        Of both; default: evident, bare matrices need it.

    Returns
    -------
    ObserverDecision
        With the number of forms. For a minimal SISO plant it is decided by counting divisors of the
        closed-loop polynomial; otherwise every rational subspace is tested, then irrational ones
        in certified balls, which can prove a yes. The answer is None if all of these fail while
        some real subspace was not excluded.

    Raises
    ------
    InputError
        If signals or variables do not fit, or one of the two has no state.

    Notes
    -----
    Minimal SISO plant, any :math:`n_c = n` compensator without several Jordan blocks for one root:
    the subspace of :math:`p_R` gives a form if and only if no root of :math:`p_R` is an
    unobservable mode of the compensator and no root of :math:`p_O` an uncontrollable one. So
    Theorem 1 fails for realisations both ways that it can: even n without a form, and
    odd n with real roots and without a form.

    Source: Theorem 1, and the theorem that every real n-dimensional invariant subspace of a
    minimal closed loop works.

    Examples
    --------
    >>> from compensator_theory.observers import realisation_is_observer_based
    >>> plant = ([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]])
    >>> hidden = ([[-6, 0], [0, -7]], [[1], [0]], [[12, 0]])
    >>> print(realisation_is_observer_based(plant, hidden, variable="s"))
    Is the realisation observer-based? no: the mode(s) s + 7 of the compensator are both
    uncontrollable and unobservable, and the closed loop has them only once. Forms: 0.
    Closed loop: s**4 + 16*s**3 + 83*s**2 + 140*s
    """
    system, controller_realisation = (
        realisation(plant, variable),
        realisation(compensator, variable),
    )
    controller = controller_realisation.with_sign(agreed_sign(controller_realisation, feedback))
    if controller.is_strictly_proper is False:
        return ObserverDecision(
            QUESTION, False,
            f"it has the direct term {controller.D.tolist()}, and a state estimate has none", 0,
        )  # fmt: skip
    loop = closed_loop_matrix(system, controller)
    Dtilde = characteristic_polynomial(loop, system.variable)
    minimal = system.is_siso and False not in (system.is_minimal, controller.is_minimal)
    if minimal and not is_rational(Dtilde) and controller.n == system.n:
        decision = decide_by_parity(QUESTION, system.n, Dtilde)
        where = ", wherever plant and compensator are minimal"
        return replace(decision, reason=decision.reason + where)
    if system.is_siso and system.is_minimal and controller.n and is_rational(Dtilde):
        hidden = (controller.uncontrollable_modes, controller.unobservable_modes)
        is_hidden = any(modes.degree() > 0 for modes in hidden)
        if not is_hidden:
            return _of_minimal(system, controller, Dtilde)
        if controller.n == system.n and derogatory_factor(loop, Dtilde) is None:
            return _of_hidden_modes(system, Dtilde, *hidden)
    return _by_enumeration(system, controller, Dtilde)


def _of_minimal(plant: Realisation, compensator: Realisation, Dtilde: Poly) -> ObserverDecision:
    n, n_c = plant.n, compensator.n
    if n_c > n:
        count = count_partitions(Dtilde, (n, n, n_c - n))
        kind = f"a regulator, an observer (degree {n} each) and a Youla parameter ({n_c - n})"
    else:
        count = count_observer_forms(Dtilde, n)
        kind = f"a regulator (degree {n}) and an observer (degree {n_c})"
    able = "splits" if count else "does not split"
    reason = (
        f"plant and compensator are minimal, and the closed loop {able} "
        f"into real polynomials of {kind}"
    )
    return ObserverDecision(QUESTION, count > 0, reason, count, Dtilde)


def _of_hidden_modes(
    plant: Realisation, Dtilde: Poly, uncontrollable: Poly, unobservable: Poly
) -> ObserverDecision:
    both = monic(canonical(uncontrollable.gcd(unobservable)))
    if both.degree() > 0:
        reason = (
            f"the mode(s) {format_polynomial(both)} of the compensator are both uncontrollable and "
            "unobservable, and the closed loop has them only once"
        )
        return ObserverDecision(QUESTION, False, reason, 0, Dtilde)
    to_regulator, rest = _shared(Dtilde, uncontrollable)
    to_observer, free = _shared(rest, unobservable)
    missing = plant.n - int(to_regulator.degree())
    count = number_of_selections(real_multiplicities(free), missing) if missing >= 0 else 0
    parts = [
        f"its {kind} modes put {format_polynomial(forced)} into the {place}"
        for kind, forced, place in (
            ("uncontrollable", to_regulator, "regulator"),
            ("unobservable", to_observer, "observer"),
        )
        if forced.degree() > 0
    ]
    able = "has" if count else "has no"
    reason = (
        f"{' and '.join(parts)}; the remaining factor, {format_polynomial(free)}, {able} real "
        f"divisor(s) of degree {missing}"
    )
    return ObserverDecision(QUESTION, count > 0, reason, count, Dtilde)


def _by_enumeration(plant: Realisation, compensator: Realisation, Dtilde: Poly) -> ObserverDecision:
    if compensator.n > plant.n:
        return _by_youla_forms(plant, compensator, Dtilde)
    forms = observer_forms(plant, compensator)
    number: NumberOfForms = None
    if forms.has_continuum:
        answer, number = True, "a continuum"
        reason = "the closed loop has several Jordan blocks for one root, and subspaces of it work"
    elif forms.forms:
        answer, number = True, len(forms.forms) if forms.is_complete else None
        reason = f"{len(forms.forms)} of {_tested(forms.forms, forms.rejections)} work"
    elif forms.is_complete and not forms.undecided:
        answer, number = False, 0
        reason = f"all {len(forms.rejections)} real regulator polynomials were tested and fail"
    else:
        proof = _by_balls(plant, compensator, Dtilde)
        if isinstance(proof, ObserverDecision):
            return replace(proof, forms=forms)
        answer = None
        reason = (
            f"the {len(forms.rejections)} rational regulator polynomials fail, but others are "
            f"irrational, symbolic or have a continuum of subspaces{_continua(forms)}{proof}"
        )
    return ObserverDecision(QUESTION, answer, reason, number, Dtilde, forms)


def _continua(forms: ObserverForms) -> str:
    sizes = [f"{forms.continuum(p)} for {format_polynomial(p)}" for p in forms.undecided]
    return f" ({'; '.join(sizes)})" if sizes else ""


def _by_youla_forms(plant: Realisation, compensator: Realisation, Dtilde: Poly) -> ObserverDecision:
    n, n_c = plant.n, compensator.n
    forms = youla_forms(plant, compensator)
    all_ways = count_partitions(Dtilde, (n, n, n_c - n)) if is_rational(Dtilde) else None
    if forms:
        reason = f"{len(forms)} rational splits into regulator, observer and Youla parameter work"
        number = len(forms) if all_ways and _every_real_factor_is_rational(Dtilde) else None
        return ObserverDecision(QUESTION, True, reason, number, Dtilde)
    if all_ways == 0 or (all_ways and _every_real_factor_is_rational(Dtilde)):
        reason = (
            f"all {all_ways} real splits into regulator, observer and Youla parameter were tested "
            "and fail"
        )
        return ObserverDecision(QUESTION, False, reason, 0, Dtilde)
    proof = _by_balls(plant, compensator, Dtilde)
    if isinstance(proof, ObserverDecision):
        return proof
    reason = (
        f"{all_ways} real splits into regulator, observer and Youla parameter exist, and no "
        f"rational split gives a form{proof}"
    )
    return ObserverDecision(QUESTION, None, reason, None, Dtilde)


def _by_balls(plant: Realisation, compensator: Realisation, Dtilde: Poly) -> ObserverDecision | str:
    """Prove the decision through irrational subspaces, or return a phrase with the attempts."""
    if not is_rational(Dtilde):
        return ""
    proof = prove_forms(closed_loop_matrix(plant, compensator), Dtilde, plant.n)
    attempts = f"{proof.tried} real splits of the spectrum, irrational ones included,"
    if not proof.proved:
        return f"; certified balls prove a form for none of the {attempts} tested"
    minimal = derogatory_factor(closed_loop_matrix(plant, compensator), Dtilde) is None
    complete = minimal and proof.is_exhaustive and proof.proved == proof.tried
    number = proof.proved if complete else None
    return ObserverDecision(
        QUESTION, True, f"{proof.proved} of {attempts} are proved to work in certified balls",
        number, Dtilde,
    )  # fmt: skip


def _every_real_factor_is_rational(poly: Poly) -> bool:
    """Tell whether the irreducible factors over the rationals are irreducible over the reals."""
    return all(
        factor.degree() == 1 or (factor.degree() == 2 and factor.discriminant() < 0)
        for factor, _ in poly.factor_list()[1]
    )


def _tested(forms: tuple[object, ...], rejections: tuple[object, ...]) -> str:
    return f"{len(forms) + len(rejections)} rational regulator polynomials that were tested"


def _shared(poly: Poly, modes: Poly) -> tuple[Poly, Poly]:
    """Split off everything of a polynomial that has roots in common with another one."""
    shared, rest = canonical(Poly(1, poly.gen)), poly
    while (factor := monic(canonical(rest.gcd(modes)))).degree() > 0:
        shared, rest = canonical(shared * factor), canonical(rest.exquo(factor))
    return shared, rest
