"""The H2 cost of strongly non-normal loops, against 60-digit arithmetic by another method."""

import mpmath
import numpy as np
import pytest
from mpmath import mp

from compensator_theory.errors import IllConditionedError
from rcac_numeric import Plant, h2_cost, lqg_controller
from tests.support.delayed_plants import delayed_plant


def exact(array):
    return mpmath.matrix(array.tolist()) if array.size else mpmath.matrix(*array.shape)


def beside(*parts):
    whole = mpmath.matrix(parts[0].rows, sum(p.cols for p in parts))
    first = 0
    for p in parts:
        for i in range(p.rows):
            for j in range(p.cols):
                whole[i, first + j] = p[i, j]
        first += p.cols
    return whole


def above(*parts):
    return beside(*(p.T for p in parts)).T


def loop_of(plant, compensator):
    """A, B, Z, W of x(k+1) = A x + B w, z = Z x + W w."""
    A_c, B_c, C_c, D_c = map(exact, compensator)
    names = ("A", "B", "C", "D_0", "D_1", "D_2", "E_1", "E_2", "E_0")
    A, B, C, D_0, D_1, D_2, E_1, E_2, E_0 = (exact(getattr(plant, name)) for name in names)
    n, n_c = plant.n, A_c.rows
    inverse = (mpmath.eye(plant.l_u) - D_c * D_0) ** -1
    K_x, K_w = inverse * beside(D_c * C, C_c), inverse * D_c * D_2
    y_x, y_w = beside(C, mpmath.zeros(plant.l_y, n_c)) + D_0 * K_x, D_2 + D_0 * K_w
    ours = above(beside(A, mpmath.zeros(n, n_c)), beside(mpmath.zeros(n_c, n), A_c))
    return (
        ours + above(B * K_x, B_c * y_x), above(D_1 + B * K_w, B_c * y_w),
        beside(E_1, mpmath.zeros(plant.l_z, n_c)) + E_2 * K_x, E_0 + E_2 * K_w,
    )  # fmt: skip


def oracle(plant, compensator):
    """J by eigenvalues and the linear equations of (4.23), all in 60 digits and more."""
    A, B, Z, W = loop_of(plant, compensator)
    n = A.rows
    if max(abs(pole) for pole in mpmath.eig(A)[0]) >= 1:
        return mp.inf
    pairs = [(i, j) for i in range(n) for j in range(i, n)]
    place = {pair: k for k, pair in enumerate(pairs)}
    equations, Q = mpmath.eye(len(pairs)), B * B.T
    for k, (i, j) in enumerate(pairs):
        for a in range(n):
            for b in range(n):
                if A[i, a] and A[j, b]:
                    equations[k, place[min(a, b), max(a, b)]] -= A[i, a] * A[j, b]
    result = mpmath.lu_solve(equations, mpmath.matrix([Q[pair] for pair in pairs]))
    X = mpmath.matrix(n, n)
    for k, (i, j) in enumerate(pairs):
        X[i, j] = X[j, i] = result[k]
    ZX = Z * X
    return sum(ZX[i, j] * Z[i, j] for i in range(Z.rows) for j in range(n)) + sum(w * w for w in W)


def non_normal(rng, n, big):
    """Triangular with large couplings, as it is or turned; or poles in a cluster."""
    edge = 1 - 10.0 ** rng.uniform(-6, -0.3)
    A = np.triu(rng.standard_normal((n, n)), 1) * big + np.diag(rng.uniform(-edge, edge, n))
    kind = rng.integers(4)
    if kind == 0:
        return np.round(A, 1)
    if kind == 1:
        Q = np.linalg.qr(rng.standard_normal((n, n)))[0]
        return Q @ A @ Q.T
    if kind == 2:
        p = np.poly(np.full(n, rng.uniform(0.7, 1) * edge))
        return np.vstack([-p[1:], np.eye(n)[:-1]])
    return A


def non_normal_loop(rng):
    n, n_c, l_u, l_y = (int(rng.integers(*ends)) for ends in ((2, 5), (0, 4), (1, 3), (1, 3)))
    big = 10.0 ** rng.uniform(0, 6)
    gain = 10.0 ** rng.uniform(-8, 0) * (rng.random() < 0.7)
    shapes = {"B": (n, l_u), "C": (l_y, n), "D_1": (n, 2), "D_2": (l_y, 2), "E_1": (2, n)}
    shapes |= {"E_2": (2, l_u), "E_0": (2, 2), "D_0": (l_y, l_u)}
    matrices = {name: rng.standard_normal(shape) for name, shape in shapes.items()}
    compensator = (
        non_normal(rng, n_c, big) if n_c else np.zeros((0, 0)),
        gain * rng.standard_normal((n_c, l_y)), gain * rng.standard_normal((l_u, n_c)),
        gain * rng.standard_normal((l_u, l_y)) * (rng.random() < 0.5),
    )  # fmt: skip
    return Plant(A=non_normal(rng, n, big), **matrices), compensator


@pytest.mark.costly
@mp.workdps(60)
def test_strongly_non_normal_loops(in_full):
    rng = np.random.default_rng(1)
    stable, undecided, in_balls, worst = 0, 0, 0, 0.0
    while stable < (2000 if in_full else 40):
        plant, compensator = non_normal_loop(rng)
        J = oracle(plant, compensator)
        stable += not mpmath.isinf(J)
        try:
            cost = h2_cost(plant, compensator)
        except IllConditionedError:
            undecided += not mpmath.isinf(J)
            continue
        if mpmath.isinf(J):
            assert cost.value == np.inf
            continue
        assert cost.value == pytest.approx(float(J), rel=1e-6)
        in_balls += cost.evidence == "ball arithmetic"
        worst = max(worst, float(abs(cost.value - J) / J))
        assert float(abs(cost.value - J) / J) <= cost.error_bound + 1e-13
    assert undecided < stable / 5
    print(f"{stable} stable loops: {undecided} undecided, {in_balls} in balls, worst {worst:.1e}")


def jordan_loop(n, pole, coupling, turned):
    """A Jordan block, whose computed poles are off by coupling times the n-th root of rounding."""
    A = pole * np.eye(n) + coupling * np.eye(n, k=1)
    if turned:
        L = np.eye(n) + np.eye(n, k=-1)
        A = L @ A @ np.rint(np.linalg.inv(L))
    drive = np.ones((n, 1))
    return Plant(A=A, B=drive, D_1=np.eye(n)[:, [0]], C=np.ones((1, n)))


NONE = (np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.zeros((1, 1)))


@pytest.mark.exact_data  # entries that moved apart are no Jordan block, and its poles go outside
@mp.workdps(60)
@pytest.mark.parametrize("n", [6, 10, 14])
def test_a_jordan_block_whose_computed_poles_are_outside(n):
    """Only the first state is driven, so that J = 1/(1 - pole^2) times a sum of squares."""
    straight = h2_cost(jordan_loop(n, 0.75, 4.0, turned=False), NONE)
    assert straight.value == pytest.approx(1 / (1 - 0.75**2), rel=1e-12)
    plant = jordan_loop(n, 0.75, 4.0, turned=True)
    try:
        turned = h2_cost(plant, NONE)
    except IllConditionedError as error:
        assert "float64 does not determine" in str(error)
        return
    if n == 6:
        assert turned.value == pytest.approx(float(oracle(plant, NONE)), rel=1e-9)
    assert np.isfinite(turned.value)


def test_the_cost_of_a_delayed_design_is_that_of_its_riccati_solutions():
    rng = np.random.default_rng(3)
    balls = 0
    for _ in range(30):
        try:
            design = lqg_controller(delayed_plant(rng))
        except ValueError:
            continue
        assert design.cost_gap < 1e-9
        assert design.cost.value == pytest.approx(design.cost_from_riccati, rel=1e-8, abs=1e-12)
        balls += design.cost.evidence == "ball arithmetic"
    assert balls > 0


def test_the_bound_and_the_sensitivity_say_what_rounding_does():
    near, far = (
        h2_cost(Plant(A=[[pole]], B=[[1.0]], D_1=[[1.0]], C=[[1.0]]), NONE)
        for pole in (1 - 1e-9, 0.5)
    )
    # J = 1/(1 - a^2), dJ/J = 2 a^2/(1 - a^2) da/a, and as much as 2 and 2 of B and Z
    eps = np.finfo(float).eps
    assert near.sensitivity == pytest.approx(1e9 * eps, rel=1e-5)
    assert far.sensitivity == pytest.approx((2 / 3 + 4) * eps)
    assert far.error_bound < 1e-13 and far.evidence == "float64"
