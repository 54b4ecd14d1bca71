"""Propositions 2 to 5: existence and uniqueness of the compensator."""

from hypothesis import strategies as st
from sympy import Expr, Matrix, Poly

from compensator_theory import TransferFunction, place_poles, polynomial_from_roots
from compensator_theory.bezout import (
    check_proposition_3,
    check_proposition_4,
    sylvester_m,
    sylvester_m1,
)
from compensator_theory.matrices.linear_algebra import determinant, solve_affine
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
    given = Matrix([*_coefficients(D_c, l), *_coefficients(N_c, n)])
    wanted = Matrix(_coefficients(D * D_c + N * N_c, n + l))
    solution = solve_affine(matrix, wanted)
    return bool(not solution.nullspace and solution.particular == given)


def _coefficients(poly: Poly, size: int) -> list[Expr]:
    """List coefficients in descending order, with leading zeros."""
    given = [] if poly.is_zero else poly.all_coeffs()
    return [0] * (size - len(given)) + given


@for_all(case=plant_and_poles())
def existence(case: tuple[TransferFunction, tuple[Expr, ...]]) -> bool:
    """For every n_c >= n - 1 exactly one proper pair with deg N_c < n and monic D_c of degree n_c
    has the closed-loop polynomial asked for.
    """
    plant, poles = case
    D, N = plant.denominator, plant.numerator
    wanted = polynomial_from_roots(poles, "s")
    found = place_poles(plant, wanted, feedback=-1).compensator
    n_c = len(poles) - plant.order
    matrix = sylvester_m(D, N, n_c, plant.order - 1)
    placed = D * found.denominator + N * found.numerator
    return bool(
        placed == wanted
        and found.denominator.is_monic
        and found.denominator.degree() == n_c
        and found.numerator.degree() < plant.order
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
