"""Controllability, coprimeness and the gains of single-input, single-output realisations."""

from hypothesis import strategies as st
from sympy import Expr, Matrix, Poly, Symbol

from compensator_theory import (
    TransferFunction,
    markov_parameters,
    observer_gain,
    polynomial_from_roots,
    regulator_gain,
)
from compensator_theory.matrices._linear_algebra import characteristic_polynomial, rank
from compensator_theory.strategies import matrices, minimal_plants, spectra

from ..ledger.checks import for_all

s = Symbol("s")


@st.composite
def plants_and_spectra(draw: st.DrawFn) -> tuple[Matrix, Matrix, Matrix, tuple[Expr, ...]]:
    """Draw a minimal plant and as many poles."""
    plant = draw(minimal_plants(max_order=4))
    A, B, C = Matrix(plant.A), Matrix(plant.B), Matrix(plant.C)
    return A, B, C, draw(spectra(A.rows))


@for_all(case=plants_and_spectra())
def gains_place(case: tuple[Matrix, Matrix, Matrix, tuple[Expr, ...]]) -> bool:
    """For every spectrum of n roots there are K and F with det(sI - A - BK) and det(sI - A + FC) as
    asked for, and the map from K to det(sI - A - BK) is affine and injective.
    """
    A, B, C, poles = case
    target = polynomial_from_roots(poles, "s")
    K, F = (Matrix(gain(A, M, target)) for gain, M in ((regulator_gain, B), (observer_gain, C)))
    # column i: how the coefficients move with K_i
    origin = characteristic_polynomial(A, s)
    moves = []
    for i in range(A.rows):
        unit = Matrix(1, A.rows, lambda _, j, i=i: int(i == j))
        moved = (characteristic_polynomial(A + B * unit, s) - origin).all_coeffs()
        moves.append([0] * (A.rows - len(moved)) + moved)
    return bool(
        characteristic_polynomial(A + B * K, s) == target
        and characteristic_polynomial(A - F * C, s) == target
        and rank(Matrix(moves)) == A.rows
    )


@for_all(A=matrices(3, 3), B=matrices(3, 1), C=matrices(1, 3), hidden=st.integers(0, 2))
def minimal_is_coprime(A: Matrix, B: Matrix, C: Matrix, hidden: int) -> bool:
    """Both Kalman ranks are n if and only if det(sI - A) and C adj(sI - A) B are coprime."""
    A, B, C = (Matrix(M) for M in (A, B, C))
    A[hidden:, :hidden] = Matrix.zeros(3 - hidden, hidden)  # modes that B may miss
    if hidden:
        B[hidden:, 0] = Matrix.zeros(3 - hidden, 1)
    reached = rank(Matrix.hstack(B, A * B, A * A * B))
    rows = rank(Matrix.vstack(C, C * A, C * A * A))
    D = characteristic_polynomial(A, s)
    N = D - characteristic_polynomial(A + B * C, s)
    return bool((reached == rows == 3) == (D.gcd(N).degree() == 0))


@for_all(A=matrices(3, 3), B=matrices(3, 1), C=matrices(1, 3), terms=st.integers(0, 5))
def markov_expansion(A: Matrix, B: Matrix, C: Matrix, terms: int) -> bool:
    """s^N times the numerator is det(sI - A) times H_1 s^(N-1) + ... + H_N, plus the numerator of
    C A^N, where H_i = C A^(i-1) B are the coefficients of the expansion at infinity.
    """
    A, B, C = (Matrix(M) for M in (A, B, C))
    D = characteristic_polynomial(A, s)

    def numerator(row: Matrix) -> Poly:
        return D - characteristic_polynomial(A + B * row, s)

    H = [(C * A**i * B)[0] for i in range(terms)]
    head = Poly([*H, 0], s).quo(Poly(s, s)) if H else Poly(0, s)
    left = Poly(s**terms, s) * numerator(C)
    same = markov_parameters(TransferFunction(numerator(C), D), terms + 1)[1:]
    return bool(left == D * head + numerator(C * A**terms) and list(same) == H)
