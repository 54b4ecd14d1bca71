"""The Riccati layer: published equations, another algorithm, and what SciPy does not say."""

from types import SimpleNamespace

import mpmath
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are, solve_discrete_lyapunov

import rcac_numeric as rcac
from compensator_theory import InputError, solve_riccati
from compensator_theory.errors import NoSolutionError, NotControllableError, UnitCircleError
from rcac_numeric.analysis._gramians import stein_solution
from tests.support.dare_cases import DAREX, SCIPY
from tests.support.strategies import seeds

CASES = [pytest.param(case, id=case.name) for case in (*DAREX, *SCIPY)]
EPS = np.finfo(float).eps


def newton(case, gain, digits=50, steps=8):
    """The stabilising solution in 50 digits by Newton-Kleinman from a stabilising gain."""
    with mpmath.workdps(digits):
        m = mpmath.matrix
        A, B, R_1, R_2 = (
            m(np.array(x, float).tolist()) for x in (case.A, case.B, case.R_1, case.R_2)
        )
        S = m(A.rows, B.cols) if case.R_12 is None else m(np.array(case.R_12, float).tolist())
        K = m(gain.tolist())
        P = None
        for _ in range(steps):
            closed = A + B * K
            X, power = R_1 + S * K + K.T * S.T + K.T * R_2 * K, closed.T
            for _ in range(60):
                X, power = X + power * X * power.T, power * power
                if mpmath.mnorm(power, 1) < mpmath.mpf(10) ** -(digits // 2):
                    break
            else:
                raise AssertionError("the gain does not stabilise")
            P, K = X, -((R_2 + B.T * X * B) ** -1) * (S.T + B.T * X * A)
        return np.array(P.tolist(), dtype=float)


@pytest.mark.costly
@pytest.mark.parametrize("case", CASES)
def test_published_equations(case):
    solution = rcac.solve_riccati(case.A, case.B, *case.weights, time="discrete")
    # The gain, and with it the residual of a rounded P, is solved for with the innovation.
    assert solution.residual < 10 * len(solution.P) * EPS * np.linalg.cond(solution.innovation)
    assert 0 < solution.margin == 1 - np.abs(solution.poles).max()
    left = solution.closed_loop.T @ solution.P @ solution.closed_loop - solution.P
    left += (
        np.vstack([np.eye(len(left)), solution.K]).T
        @ np.block([[solution.Q, solution.N], [solution.N.T, solution.R]])
        @ np.vstack([np.eye(len(left)), solution.K])
    )
    assert np.abs(left).max() < 1e-11 * np.abs(solution.P).max()
    size = max(np.linalg.norm(solution.P, 2), np.linalg.norm(solution.Q, 2))
    accuracy = 10 * len(left) * EPS * max(solution.condition, 1.0) * size
    if case.P is not None:
        assert np.linalg.norm(solution.P - case.P, 2) <= accuracy
    if len(left) < 20:
        oracle = newton(case, solution.K)
        assert np.linalg.norm(solution.P - oracle, 2) <= accuracy


def test_the_accuracy_bound_is_a_bound_and_not_idle():
    """Perturb the data by delta: P moves by at most condition * delta, and near to it once."""
    rng = np.random.default_rng(3)
    case = DAREX[4]
    solution = rcac.solve_riccati(case.A, case.B, *case.weights, time="discrete")
    moves = []
    for _ in range(60):
        delta = 1e-7
        A, B, R_1, R_2 = (
            _moved(np.array(x, float), delta, rng) for x in (case.A, case.B, case.R_1, case.R_2)
        )
        other = rcac.solve_riccati(A, B, R_1, R_2, time="discrete")
        moves.append(
            np.linalg.norm(other.P - solution.P, 2) / np.linalg.norm(solution.P, 2) / delta
        )
    assert 1e-3 * solution.condition < max(moves) <= 2 * solution.condition


def _moved(x, delta, rng):
    e = rng.standard_normal(x.shape)
    e = e + e.T if len(x) == x.shape[1] else e
    return x + delta * np.linalg.norm(x, 2) * e / np.linalg.norm(e, 2)


# Chains with the output polynomial N(q) over det(qI - A), R_2 = 0.
def chain(numerator, last_row=(0.1, 0.2, 0.5)):
    n = len(last_row)
    A = np.eye(n, k=1)
    A[-1] = last_row
    E_1 = np.zeros((1, n))
    E_1[0, : len(numerator)] = numerator[::-1]
    return A, np.eye(n)[:, [n - 1]], E_1


@pytest.mark.costly
@pytest.mark.parametrize(
    "numerator, last_row, zero",
    [
        ([1, -1], (0.1, 0.2, 0.5), " 1 "),
        ([1, -1.5, 0.5], (0.1, 0.2, 0.5), " 1 "),
        ([1, 1], (0.1, 0.2, 0.5), " -1 "),
        ([1, 0, 1], (0.1, 0.2, 0.5), " 1j "),
        ([1, -2, 1], (0.1, 0.2, 0.5), " 1 "),  # a double zero
        ([1, 3, 3, 1], (0.75, -0.5, 0.25, 0.5), " -1"),  # a triple one
        ([1, -1.2, 1], (0.1, 0.2, 0.5, 1.5), " 0.6"),
        ([1, -3, 2], (0.1, 0.2, 2.5), " 1 "),  # beside a zero outside
        ([-5, 4, 9, -8], (0.875, 0.375, 0.0, -0.5), " 1 "),  # SciPy's poles are 0.1 off
    ],
)
def test_a_zero_on_the_unit_circle_is_named(numerator, last_row, zero):
    """For a zero at 1 SciPy returns a solution with a closed-loop pole there, and no warning."""
    A, B, E_1 = chain(numerator, last_row)
    with pytest.raises(UnitCircleError, match="G_zu has a zero on the unit circle at" + zero):
        rcac.solve_riccati(A, B, E_1.T @ E_1, time="discrete")


def test_scipy_is_silent_about_a_zero_at_1():
    A, B, E_1 = chain([1, -1])
    P = solve_discrete_are(A, B, E_1.T @ E_1, [[0.0]])
    K = -np.linalg.solve(B.T @ P @ B, B.T @ P @ A)
    assert np.abs(np.linalg.eigvals(A + B @ K)).max() > 1 - 1e-6


@pytest.mark.parametrize("distance", [1e-2, 1e-4, 1e-6, -1e-6, -1e-4])
def test_a_zero_beside_the_circle_is_solved(distance):
    """The closed loop has a pole at the zero or at its reciprocal, and the margin says so."""
    zero = 1 + distance
    A, B, E_1 = chain([1, -zero])
    solution = rcac.solve_riccati(A, B, E_1.T @ E_1, time="discrete")
    expected = min(zero, 1 / zero)
    assert solution.margin == pytest.approx(1 - expected, abs=10 * EPS * solution.condition)
    # R_2 + B'PB of (A.15)'s spectral factor: H^2 times the squared zeros outside
    assert solution.innovation[0, 0] == pytest.approx(max(zero, 1.0) ** 2, rel=1e-9)


@given(seeds, st.integers(1, 5), st.integers(1, 2), st.floats(-5, -1))
@example(seed=938, n=3, m=2, distance=-3.9779766779117742)  # where SciPy finds no solution
def test_a_square_map_with_zeros_inside_costs_nothing(seed, n, m, distance):
    """u = -E_2^{-1} E_1 x keeps z at zero and moves the poles to the zeros, so that P = 0."""
    rng = np.random.default_rng(seed)
    zeros, B = rng.standard_normal((n, n)), rng.standard_normal((n, m))
    zeros *= (1 - 10**distance) / np.abs(np.linalg.eigvals(zeros)).max()
    E_1, E_2 = rng.standard_normal((m, n)), np.eye(m) + rng.uniform(-0.3, 0.3, (m, m))
    gain = -np.linalg.solve(E_2, E_1)
    solution = rcac.solve_riccati(
        zeros - B @ gain, B, E_1.T @ E_1, E_2.T @ E_2, E_1.T @ E_2, time="discrete"
    )
    assert solution.residual < 1e-13 and solution.margin > 0
    accuracy = 1e3 * EPS * max(solution.condition, 1.0)
    assert np.abs(solution.P).max() <= accuracy * np.linalg.norm(solution.Q, 2)
    assert np.abs(solution.K - gain).max() <= accuracy * np.linalg.norm(gain, 2)


def test_an_unobservable_mode_on_the_circle_counts_as_a_zero():
    A = np.diag([1.0, 0.5])
    with pytest.raises(UnitCircleError, match="at 1 "):
        rcac.solve_riccati(A, np.ones((2, 1)), np.diag([0.0, 1.0]), [[1.0]], time="discrete")


@given(seeds, st.integers(2, 4), st.integers(1, 3), st.integers(2, 3))
def test_more_inputs_than_outputs_are_refused_by_rank(seed, n, l_z, l_u):
    rng = np.random.default_rng(seed)
    if l_u <= l_z:
        l_z = l_u - 1
    A, B = rng.standard_normal((n, n)) / n, rng.standard_normal((n, l_u))
    E_1 = rng.standard_normal((l_z, n))
    with pytest.raises(NoSolutionError, match=f"rank {min(l_z, n)} .*{l_u} component"):
        rcac.solve_riccati(A, B, E_1.T @ E_1, time="discrete")


def test_scipy_is_silent_about_more_inputs_than_outputs():
    """It returns an answer whose innovation is singular, or fails with another reason."""
    unreported = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        A, B, E_1 = (rng.standard_normal(s) for s in ((3, 3), (3, 2), (1, 3)))
        try:
            P = solve_discrete_are(A, B, E_1.T @ E_1, np.zeros((2, 2)))
        except ValueError:  # LinAlgError is one; ordqz raises the bare one
            continue
        unreported += np.linalg.cond(B.T @ P @ B) > 1e10
    assert unreported > 0


def test_scipys_user_reported_case_with_cross_terms():
    """Eight states, weights near 1e-6, from the data file of SciPy's own tests."""
    from importlib.resources import files

    data = files("scipy.linalg") / "tests" / "data" / "gendare_20170120_data.npz"
    if not data.is_file():
        pytest.skip("this SciPy comes without the data of its tests")
    with data.open("rb") as file:
        case = SimpleNamespace(**np.load(file))
        solution = rcac.solve_riccati(case.A, case.B, case.Q, case.R, case.S, time="discrete")
    assert solution.residual < 1e-15 and solution.margin > 0.02


def test_indefinite_weights_without_a_solution():
    with pytest.raises(NoSolutionError, match="not positive semidefinite"):
        rcac.solve_riccati([[0.5]], [[1.0]], [[-1.0]], [[1.0]], time="discrete")


def test_an_input_that_does_not_reach_z():
    with pytest.raises(NoSolutionError, match="rank 0"):
        rcac.solve_riccati(
            [[0.2, 1.0], [0.0, 0.5]], [[1.0], [0.0]], np.diag([0.0, 1.0]), time="discrete"
        )


@pytest.mark.parametrize(
    "A, B, mode",
    [
        (np.diag([1.5, 0.5]), [[0.0], [1.0]], "1.5"),
        (np.diag([1.0, 0.5]), [[0.0], [1.0]], "1"),
        ([[1.0, 1.0], [0.0, 1.0]], [[1.0], [0.0]], "1"),  # a Jordan block, its eigenvalues split
        ([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.3]], [[0.0], [0.0], [1.0]], "1j"),
        (np.diag([-2.0, 0.5]), [[0.0], [1e-9]], "-2"),
    ],
)
def test_a_mode_that_no_gain_moves_is_named(A, B, mode):
    with pytest.raises(NotControllableError, match=rf"the mode -?{mode} of A"):
        rcac.solve_riccati(A, B, np.eye(len(A)), [[1.0]], time="discrete")


def test_stable_uncontrollable_modes_stay():
    solution = rcac.solve_riccati(
        np.diag([1.5, 0.5, 0.99]), [[1.0], [0.0], [0.0]], np.eye(3), [[1.0]], time="discrete"
    )
    assert {0.5, 0.99} <= set(solution.poles.real.round(12))


@given(seeds, st.integers(1, 5), st.integers(1, 3), st.booleans())
def test_random_equations_agree_with_fifty_digits(seed, n, m, singular):
    rng = np.random.default_rng(seed)
    A, B = rng.standard_normal((n, n)), rng.standard_normal((n, m))
    E = rng.standard_normal((m + 1, n + m))
    if singular:
        E[:, n:] = 0
    weight = E.T @ E
    R_1, R_12, R_2 = weight[:n, :n], weight[:n, n:], weight[n:, n:]
    if n < m and singular:
        return
    try:
        solution = rcac.solve_riccati(A, B, R_1, R_2, R_12, time="discrete")
    except NoSolutionError:
        assert singular
        return
    case = SimpleNamespace(A=A, B=B, R_1=R_1, R_2=R_2, R_12=R_12)
    oracle = newton(case, solution.K)
    gap = np.linalg.norm(solution.P - oracle, 2) / max(
        np.linalg.norm(oracle, 2), np.linalg.norm(R_1, 2)
    )
    assert gap <= 10 * (n + m) * EPS * solution.condition * max(1, solution.innovation_condition)


@given(st.lists(st.integers(-9, 9), min_size=2, max_size=4), seeds)
def test_one_input_agrees_with_the_exact_solution(numerator, seed):
    """With R_2 = 0 P is exact in compensator_theory, through the zeros alone."""
    if not any(numerator):
        return
    rng = np.random.default_rng(seed)
    A, B, E_1 = chain(numerator, rng.integers(-9, 10, len(numerator)) / 8)
    try:
        exact = solve_riccati(A.tolist(), B.tolist(), E_1=E_1.tolist(), time="discrete")
    except UnitCircleError:
        with pytest.raises(UnitCircleError):
            rcac.solve_riccati(A, B, E_1.T @ E_1, time="discrete")
        return
    solution = rcac.solve_riccati(A, B, E_1.T @ E_1, time="discrete")
    P = np.array([[float(c.centre) for c in row] for row in exact.P_enclosure])
    assert np.abs(solution.P - P).max() <= 1e-13 * max(solution.condition, 1) * np.abs(P).max()


@pytest.mark.parametrize(
    "arguments, words",
    [
        (([[1.0, 2.0]], [[1.0]], [[1.0]]), "A has shape"),
        (([[1.0]], [[1.0], [1.0]], [[1.0]]), "B has shape"),
        (([[1.0]], [[1.0]], [[1.0]], [[1.0, 2.0]]), "R has shape"),
        (([[0.0, 1.0], [0.0, 0.0]], [[0.0], [1.0]], [[1.0, 2.0], [0.0, 1.0]]), "Q is not symm"),
        (([[np.nan]], [[1.0]], [[1.0]]), "A has the entry nan"),
        ((np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((0, 0)), [[1.0]]), "A is 0 x 0"),
        (([[2, 1 - 2j], [0, -3j]], [[0], [1]], np.eye(2)), "A must be an array of real"),
    ],
)
def test_bad_input(arguments, words):
    with pytest.raises(InputError, match=words):
        rcac.solve_riccati(*arguments, time="discrete")


@given(seeds, st.integers(1, 6), st.floats(0.1, 0.99))
def test_the_lyapunov_equation_agrees_with_scipy(seed, n, radius):
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    A *= radius / max(np.abs(np.linalg.eigvals(A)).max(), 1e-3)
    if np.linalg.norm(A) > 100:
        return
    root = rng.standard_normal((n, 2))
    X = stein_solution(A, root @ root.T)
    assert np.abs(X - solve_discrete_lyapunov(A, root @ root.T)).max() < 1e-9 * np.abs(X).max()
    assert np.linalg.eigvalsh(X).min() > -1e-12 * np.abs(X).max()
