"""Statements about plants and compensators: what is found exactly, and whether it is as claimed."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, NamedTuple

import compensator_theory as exact
from compensator_theory.matrices.exact_matrices import exact_matrix
from rcac_numeric.experiments.exact.system import Entry, ExactSystem


class Found(NamedTuple):
    """Whether a statement is so, None where that is undecided; and what was found."""

    holds: bool | None
    words: str


def regulator_gain(system: ExactSystem, poles: Entry, equals: Entry) -> Found:
    """The gain K with the eigenvalues of A + BK, (7.27).

    Parameters
    ----------
    poles : numbers
        The eigenvalues asked for.
    equals : matrix
        The gain that is claimed.
    """
    plant = system.plant
    K = exact.regulator_gain(plant.A, plant.B, poles)
    return Found(exact_matrix(equals, "equals") == K, f"K = {_row(K)}")


def observer_gain(system: ExactSystem, poles: Entry, equals: Entry) -> Found:
    """The gain F with the eigenvalues of A - FC, (7.30).

    Parameters
    ----------
    poles : numbers
        The eigenvalues asked for.
    equals : matrix
        The gain that is claimed.
    """
    plant = system.plant
    F = exact.observer_gain(plant.A, plant.C, poles)
    return Found(exact_matrix(equals, "equals") == F, f"F = {_row(F.T)}'")


def observer_based_compensator(
    system: ExactSystem, regulator: Entry, observer: Entry, equals: str
) -> Found:
    """The pair (N_c, D_c) of the compensator (7.11), (7.12), with the sign of the loop.

    Parameters
    ----------
    regulator, observer : numbers
        The eigenvalues of A + BK and of A - FC.
    equals : str
        The transfer function that is claimed.
    """
    made = exact.observer_based_compensator(system.plant, regulator, observer).transfer_function
    pair = exact.TransferFunction(made.numerator * system.feedback, made.denominator)
    return Found(_same_pair(pair, exact.transfer_function(equals)), f"G_c = {pair}")


def closed_loop(system: ExactSystem, compensator: str, polynomial: str) -> Found:
    """The closed-loop polynomial of a pair, (7.23), common factors kept.

    Parameters
    ----------
    compensator : str
        The pair N_c/D_c.
    polynomial : str
        The closed-loop polynomial that is claimed.
    """
    G, G_c = system.transfer_function, exact.transfer_function(compensator)
    loop = G.denominator * G_c.denominator - system.feedback * G.numerator * G_c.numerator
    return Found(loop == exact.polynomial(polynomial), f"D~ = {loop.as_expr()}")


def placement(
    system: ExactSystem, poles: Entry, compensator: str, n_c: int | None = None, decimals: int = -1
) -> Found:
    """The compensator that places poles, (7.37), and that there is no other with deg N_c < n.

    Parameters
    ----------
    poles : numbers
        The closed-loop poles asked for.
    compensator : str
        The compensator that is claimed.
    n_c : int, optional
        Its order, where it is not the number of poles less n.
    decimals : int
        To how many decimals its coefficients are rounded; exact where it is left out.
    """
    found = exact.place_poles(system.transfer_function, poles, n_c, feedback=system.feedback)
    claimed, words = exact.transfer_function(compensator), f"G_c = {found.compensator}"
    if decimals < 0:
        is_claimed = _same_pair(found.compensator, claimed)
    else:
        is_claimed = _rounds_to(found.compensator, claimed, decimals)
    if not found.is_unique:
        return Found(False, f"{words}, and others")
    return Found(is_claimed, f"{words}, unique")


def no_unique_placement(
    system: ExactSystem, poles: Entry, n_c: int, numerator_degree: int
) -> Found:
    """That several compensators of some degrees place the same poles.

    Parameters
    ----------
    poles : numbers
        The closed-loop poles.
    n_c, numerator_degree : int
        The order, and the largest degree of N_c.
    """
    found = exact.place_poles(
        system.transfer_function,
        poles,
        n_c,
        feedback=system.feedback,
        numerator_degree=numerator_degree,
    )
    count = len(found.homogeneous)
    return Found(not found.is_unique, f"a family with {count} free parameter{'s'[: count != 1]}")


def observer_based(
    system: ExactSystem, compensator: str, answer: bool = True, forms: int = -1
) -> Found:
    """Whether a pair is observer-based over the reals, Theorem 1.

    Parameters
    ----------
    compensator : str
        The pair N_c/D_c.
    answer : bool
        What is claimed.
    forms : int
        In how many forms; not looked at where it is left out.
    """
    decision = exact.pair_is_observer_based(
        system.transfer_function, compensator, feedback=system.feedback
    )
    words = f"{decision.answer}: {decision.reason}"
    if decision.answer is None:
        return Found(None, words)
    counted = forms < 0 or decision.number_of_forms == forms
    return Found(decision.answer is answer and counted, words)


def placed_pair_is_observer_based(system: ExactSystem, poles: Entry, answer: bool = True) -> Found:
    """Whether the compensator of order n that places poles is observer-based over the reals.

    Parameters
    ----------
    poles : numbers
        The 2n closed-loop poles.
    answer : bool
        What is claimed.
    """
    found = exact.place_poles(system.transfer_function, poles, feedback=system.feedback)
    decision = exact.pair_is_observer_based(
        system.transfer_function, found.compensator, feedback=system.feedback
    )
    is_claimed = None if decision.answer is None else decision.answer is answer
    return Found(is_claimed, f"{decision.answer}: {decision.reason}")


def _row(matrix: Any) -> str:
    return f"[{', '.join(map(str, matrix))}]"


def _same_pair(a: exact.TransferFunction, b: exact.TransferFunction) -> bool:
    """Whether numerators and monic denominators are the same, common factors included."""
    return bool(a.numerator == b.numerator and a.denominator == b.denominator)


def _rounds_to(
    found: exact.TransferFunction, claimed: exact.TransferFunction, decimals: int
) -> bool:
    """Whether every coefficient, rounded to so many decimals, is the claimed one."""
    half = Fraction(1, 2) / 10**decimals
    pairs = [
        (found.numerator, claimed.numerator),
        (found.denominator, claimed.denominator),
    ]
    for exactly, rounded in pairs:
        if exactly.degree() != rounded.degree():
            return False
        for difference in (exactly - rounded).all_coeffs():
            if abs(Fraction(int(difference.p), int(difference.q))) > half:
                return False
    return True
