"""Loops that vary in time: contraction in one P, motions of theta, predictive control."""

from hypothesis import strategies as st
from sympy import Matrix, Poly, Rational, Symbol, eye, zeros

from compensator_theory import (
    closed_loop_matrix,
    decide_stability,
    solve_stein,
)
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.strategies import matrices, schur_matrices

from ..ledger.checks import for_all

q = Symbol("q")
weights = st.lists(st.integers(0, 4), min_size=3, max_size=3).filter(any)


def _value(P: Matrix, x: Matrix) -> Rational:
    return (x.T * P * x)[0]


def _is_semidefinite(M: Matrix) -> bool:
    """Whether the coefficients of det(tI - M) alternate: all roots of a symmetric M are real."""
    coefficients = characteristic_polynomial(M, Symbol("t")).all_coeffs()
    return M == M.T and all((-1) ** k * c >= 0 for k, c in enumerate(coefficients))


def _contracts(P: Matrix, r: Rational, A: Matrix) -> bool:
    return _is_semidefinite(r * P - A.T * P * A)


def _rate(P: Matrix, A: Matrix) -> Rational:
    """Return the trace of P^-1 A'PA, an r with A'PA <= r P."""
    return (P.inv() * A.T * P * A).trace()


@for_all(
    theta=st.lists(matrices(1, 2), min_size=3, max_size=3),
    A=st.lists(matrices(2, 2), min_size=3, max_size=3),
    shares=st.lists(weights, min_size=4, max_size=4),
    x=matrices(2, 1),
)
def motion_in_the_hull(
    theta: list[Matrix], A: list[Matrix], shares: list[list[int]], x: Matrix
) -> bool:
    """Theta moves in the hull of three points, A is affine in theta: at every step x'Px loses at
    least the rate that the three points have, P = [2 1; 1 3].
    """
    P = Matrix([[2, 1], [1, 3]])
    A_0, A_1, A_2 = map(Matrix, A)

    def loop(at: Matrix) -> Matrix:
        return A_0 + at[0] * A_1 + at[1] * A_2

    r = max(_rate(P, loop(Matrix(at))) for at in theta)
    x = Matrix(x)
    for share in shares:
        at = sum(
            (Rational(w, sum(share)) * Matrix(t) for w, t in zip(share, theta, strict=True)),
            zeros(1, 2),
        )
        before, x = _value(P, x), loop(at) * x
        if _value(P, x) > r * before:
            return False
    return True


@for_all(A=st.integers(1, 3).flatmap(schur_matrices))
def strict_contraction_is_stable(A: Matrix) -> bool:
    """P - A'PA = I has for a stable A a solution P > 0 that gives a rate r < 1, and no
    eigenvalue of A A is larger than r.
    """
    A = Matrix(A)
    P = Matrix(solve_stein(A.T, eye(A.rows)).X)
    r = 1 - 1 / (1 + P.trace())  # P <= (trace P) I
    shrunk = characteristic_polynomial(A * A / r * Rational(999, 1000), q)
    return bool(
        _contracts(P, r, A) and r < 1 and decide_stability(shrunk, time="discrete").is_stable
    )


@for_all(
    A=matrices(2, 2), B=matrices(2, 2), C=matrices(2, 2), S=matrices(2, 2), Delta=matrices(2, 2)
)
def ellipsoid_contracts(A: Matrix, B: Matrix, C: Matrix, S: Matrix, Delta: Matrix) -> bool:
    """With P = I, S > 0 and a W that makes the matrix of the bounded real lemma positive definite,
    A + B Delta C contracts for Delta on the surface Delta' S Delta <= W and r = 1.
    """
    A, B, C, Delta = (Matrix(M) for M in (A, B, C, Delta))
    size = 1 + max(sum(abs(x) for x in M) for M in (A, B, C, Delta))
    A, B, C = A / (4 * size), B / (4 * size), C / size
    S = Matrix(S).T * Matrix(S) + eye(2)
    W = eye(2) / 4
    rows, outputs = A.row_join(B), C.row_join(zeros(2, 2))
    lmi = Matrix.diag(eye(2), S) - rows.T * rows - outputs.T * W * outputs
    inside = Delta / (4 * size * S.trace())
    if not (_is_semidefinite(lmi) and _is_semidefinite(W - inside.T * S * inside)):
        return False  # both are so by the sizes chosen
    return _contracts(eye(2), Rational(1), A + B * inside * C)


@st.composite
def arx_models(draw: st.DrawFn) -> tuple[int, int, Matrix, Matrix, Matrix]:
    """Draw n and p, and Phi, Gamma and K of a model with p outputs and p inputs."""
    n, p = draw(st.sampled_from([(1, 1), (2, 1), (3, 1), (1, 2), (2, 2)]))
    Phi, Gamma, K = (draw(matrices(*shape)) for shape in ((n * p, p), (n * p, p), (p, n * p)))
    return n, p, Matrix(Phi), Matrix(Gamma), Matrix(K)


def _form(n: int, p: int, Phi: Matrix) -> tuple[Matrix, Matrix]:
    """Return (A, C) of the block observable form."""
    shift = Matrix(n * p, n * p, lambda i, j: int(j == i + p))
    C = eye(p).row_join(zeros(p, (n - 1) * p))
    return shift + Phi * C, C


@for_all(model=arx_models())
def predictive_loop(model: tuple[int, int, Matrix, Matrix, Matrix]) -> bool:
    """The loop of a model of p outputs with u = K x^ has the polynomial chi(A + Gamma K) times the
    power n p of q.
    """
    n, p, Phi, Gamma, K = model
    A, C = _form(n, p, Phi)
    A_c = A + Gamma * K - Phi * C
    loop = Matrix(closed_loop_matrix((A, Gamma, C), (A_c, Phi, K), feedback=1, variable="q"))
    target = Poly(q ** (n * p), q) * characteristic_polynomial(A + Gamma * K, q)
    return bool(characteristic_polynomial(loop, q) == target)


@for_all(model=arx_models(), x=matrices(4, 1), u=matrices(2, 8))
def form_obeys_arx(model: tuple[int, int, Matrix, Matrix, Matrix], x: Matrix, u: Matrix) -> bool:
    """The output of the block observable form obeys the equation with the blocks Phi_i, Gamma_i."""
    n, p, Phi, Gamma, _ = model
    A, C = _form(n, p, Phi)
    state, y = Matrix(x)[: n * p, :], []
    controls = [Matrix(u)[:p, k] for k in range(8)]
    for control in controls:
        y.append(C * state)
        state = A * state + Gamma * control

    def block(M: Matrix, i: int) -> Matrix:
        return M[i * p : (i + 1) * p, :]

    return all(
        y[k]
        == sum(
            (
                block(Phi, i) * y[k - i - 1] + block(Gamma, i) * controls[k - i - 1]
                for i in range(n)
            ),
            zeros(p, 1),
        )
        for k in range(n, 8)
    )
