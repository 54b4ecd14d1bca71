"""Proposition 1 and Theorem 1, for pairs and for transfer functions."""

from hypothesis import strategies as st
from sympy import Expr, I, Rational, conjugate

from compensator_theory import (
    TransferFunction,
    observer_based_compensator,
    place_poles,
    polynomial,
    polynomial_from_roots,
)
from compensator_theory.observers import pair_is_observer_based, transfer_function_is_observer_based
from compensator_theory.strategies import (
    polynomials,
    rationals,
    spectra,
    strictly_proper_plants,
)

from ..ledger.checks import for_all

Case = tuple[TransferFunction, tuple[Expr, ...]]


@st.composite
def plant_and_spectrum(draw: st.DrawFn, max_order: int = 3) -> Case:
    """Draw a coprime plant of order n and a real spectrum of 2n poles."""
    plant = draw(strictly_proper_plants(max_order=max_order))
    return plant, draw(spectra(2 * plant.order))


@st.composite
def plant_and_two_shares(draw: st.DrawFn) -> tuple[TransferFunction, list[Rational], list[int]]:
    """Draw a plant, 2n real poles and an order of them."""
    plant = draw(strictly_proper_plants(max_order=3))
    size = 2 * plant.order
    poles = draw(st.lists(rationals(), min_size=size, max_size=size))
    return plant, poles, draw(st.permutations(range(size)))


@st.composite
def plant_and_short_compensator(draw: st.DrawFn) -> tuple[TransferFunction, TransferFunction]:
    """Draw a plant of order n and a strictly proper compensator with fewer than n poles."""
    plant = draw(strictly_proper_plants(max_order=4))
    r = draw(st.integers(0, plant.order - 1))
    if r == 0:
        return plant, TransferFunction(polynomial("0", "s"), polynomial("1", "s"))
    D_c = draw(polynomials(min_degree=r, max_degree=r, is_monic=True))
    return plant, TransferFunction(draw(polynomials(max_degree=r - 1)), D_c)


def real_share(roots: tuple[Expr, ...], n: int) -> list[Expr] | None:
    """Find n of the roots, closed under conjugation; None if there are none.

    Examples
    --------
    >>> from sympy import I, S
    >>> from proofs.properties.observer_based import real_share
    >>> real_share((I, -I, 2 * I, -2 * I, S.One, S.One), 3)
    [I, -I, 1]
    >>> real_share((I, -I), 1)
    """
    real = [root for root in roots if root.is_real]
    upper = [root for root in roots if not root.is_real and (root / I).as_real_imag()[0] > 0]
    for pairs in range(min(len(upper), n // 2), -1, -1):
        if n - 2 * pairs <= len(real):
            chosen = [r for root in upper[:pairs] for r in (root, conjugate(root))]
            return chosen + real[: n - 2 * pairs]
    return None


@for_all(case=plant_and_two_shares())
def proposition_1(case: tuple[TransferFunction, list[Rational], list[int]]) -> bool:
    """The compensator does not depend on how 2n poles are shared out between regulator and
    observer; it is C_c adj(sI - A_c) B_c over det(sI - A_c), unreduced, and D D_c - N N_c has the
    2n poles.
    """
    plant, poles, order = case
    n = plant.order
    first = observer_based_compensator(plant, poles[:n], poles[n:])
    moved = [poles[i] for i in order]
    second = observer_based_compensator(plant, moved[:n], moved[n:])
    one, two = first.transfer_function, second.transfer_function
    placed = plant.denominator * one.denominator - plant.numerator * one.numerator
    return bool(
        one.numerator == two.numerator
        and one.denominator == two.denominator
        and placed == polynomial_from_roots(poles, "s")
    )


@for_all(case=plant_and_spectrum())
def theorem_1_pairs(case: Case) -> bool:
    """The pair (N_c, D_c) that places 2n poles is observer-based if and only if n of the poles are
    closed under conjugation, that is, n is even or there is a real pole; K and F are then found.
    """
    plant, roots = case
    n = plant.order
    pair = place_poles(plant, list(roots), feedback=-1).compensator
    decided = pair_is_observer_based(plant, pair, feedback=-1).answer
    share = real_share(roots, n)
    parity = n % 2 == 0 or any(root.is_real for root in roots)
    if share is None:
        return decided is False and not parity
    rest = list(roots)
    for root in share:
        rest.remove(root)
    built = observer_based_compensator(plant, share, rest).transfer_function
    return bool(
        decided is True
        and parity
        and built.denominator == pair.denominator
        and built.numerator == -pair.numerator
    )


@for_all(case=plant_and_short_compensator(), root=rationals())
def theorem_1_transfer_functions(
    case: tuple[TransferFunction, TransferFunction], root: Rational
) -> bool:
    """A strictly proper transfer function of McMillan degree r < n is always observer-based: the
    pair with the common factor (s - x)^(n - r), x any real number, is.
    """
    plant, compensator = case
    G_c = compensator.reduced()
    factor = polynomial(f"(s - ({root}))**{plant.order - G_c.order}", "s")
    pair = TransferFunction(G_c.numerator * factor, G_c.denominator * factor)
    answers = (
        transfer_function_is_observer_based(plant, G_c, feedback=-1).answer,
        pair_is_observer_based(plant, pair, feedback=-1).answer,
    )
    return answers == (True, True)
