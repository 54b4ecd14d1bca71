"""High-authority LQG and the Riccati equation, solved exactly where the zeros are rational."""

from hypothesis import assume
from hypothesis import strategies as st
from sympy import Matrix, Poly, Rational, Symbol, kronecker_product, prod

from compensator_theory import polynomial, polynomial_from_roots, solve_riccati, solve_stein
from compensator_theory.matrices._linear_algebra import characteristic_polynomial, rank
from compensator_theory.polynomials._poly import canonical
from compensator_theory.strategies import (
    matrices,
    nonzero_rationals,
    polynomials,
    schur_spectra,
    standard_problems,
)
from compensator_theory.strategies.plants import disguised, unimodular_matrices
from compensator_theory.systems._state_space import controllable_canonical_form
from compensator_theory.systems._transfer_functions import TransferFunction

from ..ledger.checks import for_all

q = Symbol("q")
Case = tuple[tuple[Matrix, Matrix, Matrix], list[Rational], Rational, int]


@st.composite
def plants_with_rational_zeros(draw: st.DrawFn) -> Case:
    """Draw a controllable (A, B, E_1), its zeros, none on the unit circle, H and d."""
    D = draw(polynomials("q", 1, 4, is_monic=True))
    n = int(D.degree())
    off_circle = nonzero_rationals().filter(lambda x: abs(x) != 1)
    roots = draw(st.lists(st.one_of(off_circle, st.just(Rational(0))), max_size=n - 1))
    H = draw(nonzero_rationals())
    N = polynomial(H * prod(q - zero for zero in roots), "q")
    A, B, E_1, _ = controllable_canonical_form(TransferFunction(N, D))
    return disguised(A, B, E_1, draw(unimodular_matrices(n))), roots, H, n - len(roots)


@for_all(case=plants_with_rational_zeros())
def high_authority_poles(case: Case) -> bool:
    """For R_2 = 0 the poles of A + BC_c are d times 0, the zeros of N_zu inside the unit circle and
    the reciprocals of those outside; B'PB = H_d^2 times the squares of those outside.
    """
    (A, B, E_1), poles, H, d = case
    outside = [zero for zero in poles if abs(zero) > 1]
    reflected = [1 / zero if abs(zero) > 1 else zero for zero in poles]
    chi = canonical(Poly(q**d * prod(q - zero for zero in reflected), q))
    solution = solve_riccati(A, B, E_1=E_1, time="discrete")
    P, K = Matrix(solution.P), Matrix(solution.K)
    W = (B.T * P * B)[0]
    return bool(
        characteristic_polynomial(A + B * K, q) == chi
        and H**2 * prod(zero**2 for zero in outside) == W
        and W * K == -B.T * P * A
        and P == A.T * P * A + E_1.T * E_1 - K.T * W * K
        and P == P.T
    )


@st.composite
def plants_and_gains(draw: st.DrawFn) -> tuple[Matrix, ...]:
    """Draw (A, B, C, D_0) and the gains C_c and B_c, with any number of signals."""
    plant = draw(standard_problems(max_order=3, has_direct_term=True))
    A, B, C, D_0 = (Matrix(getattr(plant, name)) for name in ("A", "B", "C", "D_0"))
    C_c, B_c = draw(matrices(B.cols, A.rows)), draw(matrices(A.rows, C.rows))
    return A, B, C, D_0, Matrix(C_c), Matrix(B_c)


@for_all(loop=plants_and_gains())
def separation(loop: tuple[Matrix, ...]) -> bool:
    """(A.11): det(qI - A~) is the product for any number of signals, with D_0, for any gains."""
    A, B, C, D_0, C_c, B_c = loop
    A_c = A + B * C_c - B_c * C - B_c * D_0 * C_c
    upper = Matrix.hstack(A, B * C_c)
    loop = Matrix.vstack(upper, Matrix.hstack(B_c * C, A_c + B_c * D_0 * C_c))
    product = characteristic_polynomial(A + B * C_c, q) * characteristic_polynomial(A - B_c * C, q)
    return bool(characteristic_polynomial(loop, q) == product)


@for_all(A=matrices(2, 2), B=matrices(2, 1), root=matrices(2, 2), start=matrices(2, 2))
def gap_is_carried(A: Matrix, B: Matrix, root: Matrix, start: Matrix) -> bool:
    """With R_1 such that P >= 0 solves (A.7), one step of (8.96) from P(0) >= 0 turns the gap
    P(0) - P into (A + BK)'(P(0) - P)(A + BK(0)).
    """
    A, B, root, start = (Matrix(M) for M in (A, B, root, start))

    def gain(P: Matrix) -> Matrix:
        return -(B.T * P * A) / (1 + (B.T * P * B)[0])

    P, P_0 = root.T * root, start.T * start
    R_1 = P - A.T * P * (A + B * gain(P))
    step = A.T * P_0 * (A + B * gain(P_0)) + R_1
    return bool(step - P == (A + B * gain(P)).T * (P_0 - P) * (A + B * gain(P_0)))


@for_all(A=matrices(3, 3), B=matrices(3, 2), E=matrices(2, 3), start=matrices(3, 3))
def forward_propagation(A: Matrix, B: Matrix, E: Matrix, start: Matrix) -> bool:
    """One step of (8.96) from P >= 0 with R_1 = E'E, R_2 = 1 gives P+ >= 0, and x'P+x is at most
    x'(A'PA + R_1)x.
    """
    A, B, E, start = (Matrix(M) for M in (A, B, E, start))
    P = start.T * start
    free = A.T * P * A + E.T * E
    W = Matrix.eye(2) + B.T * P * B
    step = free - A.T * P * B * W.inv() * B.T * P * A
    return _is_semidefinite(step) and _is_semidefinite(free - step)


def _is_semidefinite(M: Matrix) -> bool:
    """By the signs of the characteristic polynomial's coefficients: all roots are real."""
    if M != M.T:
        return False
    descending = characteristic_polynomial(M, q).all_coeffs()
    return all((-1) ** i * coefficient >= 0 for i, coefficient in enumerate(descending))


@st.composite
def regulators(draw: st.DrawFn) -> tuple[Matrix, Matrix, Matrix, Matrix]:
    """Draw A and B with two inputs, and E_1, E_2 with R_1 > 0 and R_2 > 0 and a cross weight."""
    n = draw(st.integers(1, 2))
    A, B, X, U = (Matrix(draw(matrices(*size))) for size in ((n, n), (n, 2), (n, 2), (2, 2)))
    assume(rank(Matrix.hstack(B, A * B)) == n)
    E_1 = Matrix.vstack(Matrix.eye(n), X.T, Matrix.zeros(2, n))
    E_2 = Matrix.vstack(Matrix.zeros(n, 2), U, Matrix.eye(2))
    return A, B, E_1, E_2


@for_all(case=regulators())
def several_inputs(case: tuple[Matrix, Matrix, Matrix, Matrix]) -> bool:
    """With two inputs and R_2 > 0 there is a solution P > 0 of (A.7) with its closed loop Schur: a
    rational P near it leaves a residual as small as its distance and M = A + BK allow.

    The Riccati map moves by M'DM where P moves by D, but for terms in D^2.
    """
    A, B, E_1, E_2 = case
    n = A.rows
    balls = solve_riccati(A, B, E_1=E_1, E_2=E_2, time="discrete").P_enclosure
    P = Matrix(n, n, lambda i, j: balls[i][j].centre)
    W = E_2.T * E_2 + B.T * P * B
    gain = -W.inv() * (B.T * P * A + E_2.T * E_1)
    M = A + B * gain
    residual = A.T * P * A + E_1.T * E_1 - gain.T * W * gain - P
    distance = n * max(ball.radius for row in balls for ball in row)
    allowed = 2 * distance * (1 + sum(entry**2 for entry in M))
    chi = characteristic_polynomial(M, q)
    inside = chi.eval(1) > 0 and (-1) ** n * chi.eval(-1) > 0 and abs(chi.eval(0)) < 1
    positive = all(P[:k, :k].det() > 0 for k in range(1, n + 1))
    return bool(inside and positive and all(abs(entry) <= allowed for entry in residual))


@st.composite
def schur_matrices_and_weights(draw: st.DrawFn) -> tuple[Matrix, Matrix]:
    """Draw a Schur matrix with a rational spectrum, not always diagonalisable, and a V = E'E."""
    n = draw(st.integers(1, 3))
    poly = polynomial_from_roots(draw(schur_spectra(n)), "q")
    S = Matrix(draw(unimodular_matrices(n)))
    companion = Matrix(n, n, lambda i, j: -poly.nth(j) if i == n - 1 else int(j == i + 1))
    E = Matrix(draw(matrices(n, n)))
    return S * companion * S.inv(), E.T * E


@for_all(case=schur_matrices_and_weights())
def stein_equation(case: tuple[Matrix, Matrix]) -> bool:
    """(4.23) with a Schur A~ has one solution: I - A~ (x) A~ is regular, and Q~ is symmetric and
    positive semidefinite where V~ is.
    """
    A, V = case
    n = A.rows
    Q = Matrix(solve_stein(A, V).X)
    regular = rank(Matrix.eye(n * n) - kronecker_product(A, A)) == n * n
    return bool(regular and A * Q * A.T + V == Q and _is_semidefinite(Q))
