"""Certified sets: ellipsoids of several inputs, gains beside theta, peaks, dependent regressors."""

from hypothesis import strategies as st
from sympy import Expr, I, Matrix, Poly, Rational, Symbol, diag, expand, eye, zeros

from compensator_theory import TransferFunction, decide_simultaneous_stabilisability
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.strategies import matrices

from ..ledger.checks import for_all

q, s = Symbol("q"), Symbol("s")
shares = st.lists(st.integers(-4, 4).map(lambda i: Rational(i, 4)), min_size=4, max_size=4)
positive = st.builds(Rational, st.integers(1, 9), st.integers(1, 4))


def _is_definite(M: Matrix) -> bool:
    return M == M.T and all(M[:k, :k].det() > 0 for k in range(1, M.rows + 1))


def _small(M: Matrix, size: Rational) -> Matrix:
    """Return a multiple of M of which the sum of absolute values is at most size."""
    return Matrix(M) * size / (1 + sum(abs(x) for x in M))


@for_all(K=matrices(2, 2), V=matrices(2, 2), scale=st.tuples(positive, positive))
def factors_stay_in_the_ellipsoid(K: Matrix, V: Matrix, scale: tuple[Rational, Rational]) -> bool:
    """For L = diag(scale) and the sum of the squares of V below 1, Delta = L V K' has Delta' L^-2
    Delta below K K'; three times a V of rank 1 on the boundary is outside.
    """
    K, L = Matrix(K) + 99 * eye(2), diag(*scale)
    S = L.inv() ** 2

    def gap(V: Matrix) -> Matrix:
        Delta = L * V * K.T
        return K * K.T - Delta.T * S * Delta

    corner = Matrix([[1, 0], [0, 0]])
    return _is_definite(gap(_small(V, Rational(1)))) and not _is_definite(gap(3 * corner))


@for_all(
    A=matrices(2, 2),
    B=matrices(2, 2),
    C=matrices(3, 2),
    d=shares,
    theta=st.lists(matrices(1, 2), min_size=4, max_size=4),
    delta=shares,
    x=matrices(2, 1),
)
def gains_beside_theta(
    A: Matrix, B: Matrix, C: Matrix, d: list[Rational], theta: list[Matrix], delta: list[Rational],
    x: Matrix,
) -> bool:  # fmt: skip
    """x' = A x + B (v, e), phi = C_1 x, q = C_2 x + d v, v = Delta phi and e = delta q: where the
    scaled matrix is definite for P = I, W = I/4 and the multiplier 1/2, x'x falls at every step,
    for abs(delta) <= 1 and Delta'Delta <= W.
    """
    A, B, C = (_small(M, Rational(1, 4)) for M in (A, B, C))
    direct = Matrix([[0, 0], [0, 0], [d[0] / 4, 0]])
    weight = diag(Rational(1, 4), Rational(1, 4), Rational(1, 2))
    rows, outputs = A.row_join(B), C.row_join(direct)
    lmi = diag(1, 1, 1, Rational(1, 2)) - rows.T * rows - outputs.T * weight * outputs
    if not _is_definite(lmi):
        return False  # it is, by the sizes chosen
    x = Matrix(x)
    for Delta, gain in zip(theta, delta, strict=True):
        v = (_small(Delta, Rational(1, 2)) * C[:2, :] * x)[0]
        e = gain * ((C[2, :] * x)[0] + direct[2, 0] * v)
        before, x = x, A * x + B * Matrix([v, e])
        if (x.T * x)[0] > (before.T * before)[0]:
            return False
    return True


@for_all(
    A=matrices(2, 2),
    B=matrices(2, 1),
    E=matrices(2, 1),
    C=matrices(1, 2),
    Delta=shares,
    w=shares,
    c=matrices(1, 2),
)
def states_stay_below_the_level(
    A: Matrix, B: Matrix, E: Matrix, C: Matrix, Delta: list[Rational], w: list[Rational], c: Matrix
) -> bool:
    """x' = A x + B Delta C x + E w with abs(Delta) and abs(w) at most 1, from rest: where the
    matrix with the supply mu is definite for r = 1/2, x'x stays below 2 mu and (c x)^2 below
    2 mu c c'.
    """
    A, B, C = (_small(M, Rational(1, 4)) for M in (A, B, C))
    E, c, r = Matrix(E), Matrix(c), Rational(1, 2)
    mu = 3 * (E.T * E)[0] + 1
    rows, outputs = A.row_join(B).row_join(E), C.row_join(zeros(1, 2))
    if not _is_definite(diag(r, r, 1, mu) - rows.T * rows - outputs.T * outputs):
        return False  # it is, by the sizes chosen
    x, level = zeros(2, 1), mu / (1 - r)
    for gain, w_k in zip(Delta * 3, w * 3, strict=True):
        x = A * x + B * gain * (C * x) + E * w_k
        if (x.T * x)[0] > level or (c * x)[0] ** 2 > (c * c.T)[0] * level:
            return False
    return True


@for_all(
    A=matrices(3, 3), B=matrices(1, 2), Delta=matrices(2, 1), C=matrices(1, 2), T=matrices(3, 3)
)
def dependent_directions_keep_the_poles(
    A: Matrix, B: Matrix, Delta: Matrix, C: Matrix, T: Matrix
) -> bool:
    """Where what Delta weights is a state that no input reaches, in any basis, det(zI - A - B Delta
    C) is det(zI - A).
    """
    A, B, C = Matrix(A), Matrix(B), Matrix(C)
    A[1:, 0] = zeros(2, 1)
    A[2, 1] = 0
    B = B.col_join(zeros(2, 2))  # reaches the first state alone
    C = zeros(1, 1).row_join(C)
    T = Matrix(T) + 99 * eye(3)
    moved = A + B * Matrix(Delta) * C
    return bool(
        characteristic_polynomial(T * moved * T.inv(), q) == characteristic_polynomial(A, q)
    )


@for_all(
    A=matrices(2, 2),
    B=matrices(2, 1),
    C=matrices(2, 2),
    D=matrices(2, 1),
    place=st.sampled_from([1, -1, I, (3 + 4 * I) / 5]),
)
def certificate_bounds_the_gain(A: Matrix, B: Matrix, C: Matrix, D: Matrix, place: Expr) -> bool:
    """Where P = I makes the matrix of the bounded real lemma definite for W = I and S = 1/2, the
    square of the length of T(z) is at most 1/2 on the unit circle.
    """
    A, B, C, D = (_small(M, Rational(1, 4)) for M in (A, B, C, D))
    rows, outputs = A.row_join(B), C.row_join(D)
    if not _is_definite(diag(1, 1, Rational(1, 2)) - rows.T * rows - outputs.T * outputs):
        return False  # it is, by the sizes chosen
    response = C * (place * eye(2) - A).inv() * B + D
    return bool(expand((response.H * response)[0], complex=True) <= Rational(1, 2))


gains = st.integers(-9, 9).filter(bool).map(lambda i: Rational(i, 2))
unstable = st.integers(0, 9).map(lambda i: Rational(i, 2))


@for_all(gain=st.tuples(gains, gains), pole=st.tuples(unstable, unstable))
def two_unstable_plants_of_first_order(
    gain: tuple[Rational, Rational], pole: tuple[Rational, Rational]
) -> bool:
    """k_1/(s - a_1) and k_2/(s - a_2) with a_i >= 0 have a common compensator if and only if k_1
    and k_2 have one sign: then a large gain of that sign is one, and otherwise the auxiliary plant
    has one pole above its zero.
    """
    plants = (TransferFunction(Poly(k, s), Poly(s, s) - a) for k, a in zip(gain, pole, strict=True))
    decision = decide_simultaneous_stabilisability(*plants, feedback=-1)
    return decision.is_stabilisable == bool(gain[0] * gain[1] > 0)


signs = st.tuples(st.integers(-2, 3), st.integers(-2, 3))


@for_all(X=matrices(2, 2), Y=matrices(2, 2), sizes=signs)
def inertia_shows_in_the_coefficients(X: Matrix, Y: Matrix, sizes: tuple[int, int]) -> bool:
    """E* diag(d) E is semidefinite for an invertible complex E if and only if no d is negative, and
    so if and only if no coefficient of det(xI + M) is.
    """
    E = Matrix(X) + 99 * eye(2) + I * Matrix(Y)
    M = (E.H * diag(*sizes) * E).applyfunc(expand)
    trace, minor = expand(M.trace()), expand(M.det())
    return bool(trace >= 0 and minor >= 0) == (min(sizes) >= 0)


@for_all(X=matrices(2, 2), Y=matrices(2, 2), sizes=signs)
def cayley_transform_exchanges_the_properties(X: Matrix, Y: Matrix, sizes: tuple[int, int]) -> bool:
    """G = diag(d) + K with K* = -K has G + G* semidefinite if and only if no d is negative, and so
    if and only if I - W*W is for W = (G - I)(G + I)^-1.
    """
    K = Matrix(X) - Matrix(X).T + I * (Matrix(Y) + Matrix(Y).T)
    G = diag(*sizes) + K + I * 99 * diag(1, -2)  # det(G + I) is not 0
    W = (G - eye(2)) * (G + eye(2)).inv()
    M = (eye(2) - W.H * W).applyfunc(lambda e: expand(e, complex=True))
    trace, minor = (expand(e, complex=True) for e in (M.trace(), M.det()))
    return bool(trace >= 0 and minor >= 0) == (min(sizes) >= 0)
