"""Propositions 2 to 5: existence and uniqueness of the compensator."""

from hypothesis import strategies as st
from sympy import Expr, Matrix, Poly

from compensator_theory import TransferFunction, place_poles, polynomial, polynomial_from_roots
from compensator_theory.bezout import (
    check_proposition_3,
    check_proposition_4,
    sylvester_m,
    sylvester_m1,
)
from compensator_theory.errors import NotReachableTargetError
from compensator_theory.loops import target_characteristic_polynomial
from compensator_theory.matrices._linear_algebra import determinant, solve_affine
from compensator_theory.strategies import polynomials, spectra, strictly_proper_plants

from ..ledger.checks import for_all

plants = strictly_proper_plants(max_order=4)


@st.composite
def plant_and_poles(draw: st.DrawFn) -> tuple[TransferFunction, tuple[Expr, ...]]:
    """Draw a coprime plant of order n and n + n_c poles, n - 1 <= n_c <= n + 2."""
    plant = draw(strictly_proper_plants(max_order=3))
    n_c = draw(st.integers(plant.order - 1, plant.order + 2))
    return plant, draw(spectra(plant.order + n_c))


@for_all(
    plant=plants,
    D_c=polynomials(max_degree=5),
    N_c=polynomials(max_degree=3),
    room=st.integers(0, 2),
)
def uniqueness(plant: TransferFunction, D_c: Poly, N_c: Poly, room: int) -> bool:
    """D D_c + N N_c with deg N_c < n determines D_c and N_c; D_c of any degree, monic or not, and
    the other D_c of a degree that may be larger.
    """
    D, N = plant.denominator, plant.numerator
    n, N_c = plant.order, N_c.rem(D)
    l = max(int(D_c.degree()), int(N.degree())) + 1 + room  # noqa: E741  (columns for D_c)
    matrix = sylvester_m1(D, N, n, l)
    pair = Matrix([*_coefficients(D_c, l), *_coefficients(N_c, n)])
    target = Matrix(_coefficients(D * D_c + N * N_c, n + l))
    solution = solve_affine(matrix, target)
    return bool(not solution.nullspace and solution.particular == pair)


def _coefficients(poly: Poly, size: int) -> list[Expr]:
    """List coefficients in descending order, with leading zeros."""
    coefficients = [] if poly.is_zero else poly.all_coeffs()
    return [0] * (size - len(coefficients)) + coefficients


@for_all(case=plant_and_poles())
def existence(case: tuple[TransferFunction, tuple[Expr, ...]]) -> bool:
    """For every n_c >= n - 1 exactly one proper pair with deg N_c < n and monic D_c of degree n_c
    has the closed-loop polynomial asked for.
    """
    plant, poles = case
    D, N = plant.denominator, plant.numerator
    target = polynomial_from_roots(poles, "s")
    compensator = place_poles(plant, target, feedback=-1).compensator
    n_c = len(poles) - plant.order
    matrix = sylvester_m(D, N, n_c, plant.order - 1)
    placed = D * compensator.denominator + N * compensator.numerator
    return bool(
        placed == target
        and compensator.denominator.is_monic
        and compensator.denominator.degree() == n_c
        and compensator.numerator.degree() < plant.order
        and determinant(matrix) != 0
    )


@for_all(plant=plants, excess=st.integers(0, 4), m_hat=st.integers(0, 5))
def shapes(plant: TransferFunction, excess: int, m_hat: int) -> bool:
    """M of (7.38) is M_1(D, N), N with formal degree n_c, if and only if m^_c = n - 1; it is
    M_2(D, N) if and only if also n_c = n.
    """
    m, n = int(plant.numerator.degree()), plant.order
    n_c = max(m + excess, 1)
    if m + m_hat >= n + n_c:
        return True  # a column of N would not fit into M
    D, N = plant.denominator, plant.numerator
    return (
        check_proposition_3(D, N, n_c, m_hat).holds and check_proposition_4(D, N, n_c, m_hat).holds
    )


Target = tuple[Poly, Poly, Poly, int, int]  # N_s, N_u, D_p, d, n_c


@st.composite
def targets(draw: st.DrawFn) -> Target:
    """Draw N_zu,s, N_zu,u, d_zu, n_c and a D_p of the degrees that (4.39) allows, and one more."""
    small, large = st.sampled_from(["0", "1/2", "-1/3"]), st.sampled_from(["2", "-3/2"])
    inside, outside = draw(st.lists(small, max_size=2)), draw(st.lists(large, max_size=2))
    d, n_c = draw(st.integers(1, 2)), draw(st.integers(0, 3))
    n_p = d + len(outside) + draw(st.integers(0, n_c + 1))
    poles = draw(st.lists(st.sampled_from(["0", "1/4", "-1/5"]), min_size=n_p, max_size=n_p))
    N_s, N_u, D_p = (polynomial_from_roots(roots, "q") for roots in (inside, outside, poles))
    return N_s, N_u, D_p, d, n_c


@for_all(case=targets())
def target_poles(case: Target) -> bool:
    """(4.39) is matched by q^(n_c + d_zu + n_u - n_p) N_zu,s D_p alone where that is a polynomial,
    and for more poles where N_zu,s D_p has the root 0 as often only.
    """
    N_s, N_u, D_p, d, n_c = case
    q = polynomial("q")
    n, least = d + N_s.degree() + N_u.degree(), d + N_u.degree()
    target = TransferFunction(3 * q ** (D_p.degree() - least) * N_u, D_p)
    spare = n_c + least - D_p.degree()
    try:
        matched = target_characteristic_polynomial((3 * N_s * N_u, n), n_c, target)
    except NotReachableTargetError:
        return bool(spare < 0 and (N_s * D_p).rem(q**-spare) != 0)
    return bool(matched * q ** max(-spare, 0) == q ** max(spare, 0) * N_s * D_p)
