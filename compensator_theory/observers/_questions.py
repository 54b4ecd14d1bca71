"""Whether a polynomial pair or a transfer function is observer-based: Theorem 1 as it is true."""

from __future__ import annotations

from sympy import Poly, Symbol

from compensator_theory.loops._siso import LoopPart, closed_loop_of_pair, siso_loop
from compensator_theory.observers._counting import count_observer_forms
from compensator_theory.observers._decisions import ObserverDecision
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._poly import is_rational
from compensator_theory.roots._counts import has_real_root, number_of_real_roots
from compensator_theory.systems._conversions import TransferFunctionLike


@refusing
def pair_is_observer_based(
    plant: LoopPart,
    compensator: TransferFunctionLike,
    *,
    feedback: int,
    variable: str | Symbol | None = None,
) -> ObserverDecision:
    r"""Decide whether a polynomial pair, common factors included, is observer-based.

    .. math:: \exists K, F: \quad D_c = \det(sI - A - BK + FC), \quad
              f N_c = K\,\mathrm{adj}(sI - A - BK + FC)\,F

    Parameters
    ----------
    plant : transfer function or Realisation
        SISO of order n, without hidden modes.
    compensator : transfer function
        The pair :math:`(N_c, D_c)` as it stands, for instance a tuple of two polynomials.
    feedback : {+1, -1}
        The sign f in :math:`u = f G_c y`. The text uses +1 in (7.11), (7.12) and -1 from (7.22) on.
    variable : str or Symbol, optional
        Of the plant; default: evident.

    Returns
    -------
    ObserverDecision
        Yes if and only if :math:`\deg D_c = n`, :math:`\deg N_c < n`, and n is even or
        :math:`\tilde D = D D_c - f N N_c` has a real root; the forms are as many as the real
        monic divisors of degree n.

    Raises
    ------
    NotCoprimeError
        If the plant has hidden modes; ask :func:`realisation_is_observer_based` then.
    ImproperError
        If plant or compensator is improper.
    InputError
        If the variables differ or `feedback` is neither +1 nor -1.

    Notes
    -----
    Source: Theorem 1, which is true in this reading. For odd n a polynomial of degree 2n has an
    even number of real roots, counted with multiplicity, so that "at least two" is "any".

    Examples
    --------
    >>> from compensator_theory.observers import pair_is_observer_based
    >>> plant = "1/(s**3 + s**2 + 2*s)"
    >>> print(pair_is_observer_based(plant, ("2*(s**2 + 4*s + 5)", "(s + 1)*(s**2 + 4*s + 5)"),
    ...                              feedback=-1))
    Is the pair observer-based? no: n = 3 is odd and the closed loop has no real root, so that no
    real regulator of degree 3 divides it. Forms: 0.
    Closed loop: s**6 + 6*s**5 + 16*s**4 + 24*s**3 + 25*s**2 + 18*s + 10
    """
    question = "Is the pair observer-based?"
    G, G_c = siso_loop(plant, compensator, feedback, variable)
    n, n_c = G.order, G_c.order
    if n_c != n:
        return ObserverDecision(
            question, False,
            f"D_c has degree {n_c}, and an observer of this plant has {n} states", 0,
        )  # fmt: skip
    if not G_c.is_strictly_proper:
        return ObserverDecision(
            question, False, "it is not strictly proper, and a state estimate has no direct term", 0
        )
    return decide_by_parity(question, n, closed_loop_of_pair(G, G_c, feedback))


@refusing
def transfer_function_is_observer_based(
    plant: LoopPart, compensator: LoopPart, *, feedback: int, variable: str | Symbol | None = None
) -> ObserverDecision:
    r"""Decide whether some full-order observer-based compensator has this transfer function.

    .. math:: \exists K, F: \quad f G_c = K(sI - A - BK + FC)^{-1}F

    Parameters
    ----------
    plant : transfer function or Realisation
        SISO of order n, without hidden modes.
    compensator : transfer function or Realisation
        :math:`G_c`; common factors are removed first.
    feedback : {+1, -1}
        The sign f in :math:`u = f G_c y`.
    variable : str or Symbol, optional
        Of the plant; default: evident.

    Returns
    -------
    ObserverDecision
        With r the number of poles of :math:`G_c` in lowest terms: yes, with a continuum of forms,
        if r < n; as :func:`pair_is_observer_based` says if r = n; no if r > n or if
        :math:`G_c` is not strictly proper.

    Raises
    ------
    NotCoprimeError
        If the plant has hidden modes.
    ImproperError
        If plant or compensator is improper.
    InputError
        If the variables differ or `feedback` is neither +1 nor -1.

    Notes
    -----
    Erratum: Theorem 1 speaks of :math:`G_c`, but for r < n the parity condition holds or fails with
    the common factor that is written into :math:`N_c` and :math:`D_c`, and one with a real root can
    always be chosen.

    Examples
    --------
    >>> from compensator_theory.observers import transfer_function_is_observer_based
    >>> print(transfer_function_is_observer_based("1/(s**3 + s**2 + 2*s)", "2/(s + 1)",
    ...                                           feedback=-1))
    Is the transfer function observer-based? yes: in lowest terms it has 1 pole(s), fewer than
    n = 3, so that a common factor of degree 2 is free and can be given a real root. Forms: a
    continuum.
    Closed loop: s**4 + 2*s**3 + 3*s**2 + 2*s + 2
    """
    question = "Is the transfer function observer-based?"
    G, G_c = siso_loop(plant, compensator, feedback, variable)
    n, reduced = G.order, G_c.reduced()
    r = reduced.order
    if not reduced.is_strictly_proper:
        return ObserverDecision(
            question, False, "it is not strictly proper, and a state estimate has no direct term", 0
        )
    if r > n:
        return ObserverDecision(
            question, False,
            f"in lowest terms it has {r} poles, and an observer of this plant has {n} states", 0,
        )  # fmt: skip
    if r < n:
        return ObserverDecision(
            question, True,
            f"in lowest terms it has {r} pole(s), fewer than n = {n}, so that a common factor of "
            f"degree {n - r} is free and can be given a real root", "a continuum",
            closed_loop_of_pair(G, reduced, feedback),
        )  # fmt: skip
    return decide_by_parity(question, n, closed_loop_of_pair(G, reduced, feedback))


def decide_by_parity(question: str, n: int, Dtilde: Poly) -> ObserverDecision:
    r"""Decide whether a closed-loop polynomial of degree 2n has a real divisor of degree n."""
    count = count_observer_forms(Dtilde, n) if is_rational(Dtilde) else None
    if n % 2 == 0:
        reason = f"n = {n} is even, so that the closed loop has real divisors of degree {n}"
        return ObserverDecision(question, True, reason, count, Dtilde)
    answer = has_real_root(Dtilde)
    if answer is None:
        reason = f"n = {n} is odd, and whether the closed loop has a real root depends on symbols"
    elif answer:
        several = f"{number_of_real_roots(Dtilde)} real roots" if count else "real roots"
        reason = f"n = {n} is odd and the closed loop has {several}, counted with multiplicity"
    else:
        count = 0
        reason = (
            f"n = {n} is odd and the closed loop has no real root, so that no real regulator of "
            f"degree {n} divides it"
        )
    return ObserverDecision(question, answer, reason, count, Dtilde)
