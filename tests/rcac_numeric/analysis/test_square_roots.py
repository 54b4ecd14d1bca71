"""Riccati equations in square roots beside sixty digits, and beside what squared weights lose."""

import mpmath
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy import linalg

from compensator_theory.errors import InputError
from rcac_numeric import Plant, lqg_controller, solve_riccati
from rcac_numeric.analysis._square_roots import (
    best_gain,
    is_stable,
    kleinman,
    least_squares,
    pencil_gain,
    starting_gains,
    stein_factor,
    triangle,
)
from tests.support.riccati_digits import design_60_digits, hard_design


def distance(root, exact):
    exact = np.array(exact.tolist(), dtype=float)
    return np.linalg.norm(root - exact) / np.linalg.norm(exact)


def test_the_design_that_was_refused():
    """Three sensors of one state with noise of 1e-5: sixty digits say 9.38779688608."""
    D_2 = np.array([[0.7, -0.3, 1.7, -0.4], [-1.1, -0.8, -0.7, 0.8], [0, 0.3, -0.3, 1.4]])
    for size in (1e-5, 1e-6, 1e-7):
        plant = Plant(
            A=[[0.6]], B=[[1.0]], C=[[0.3], [0.6], [-1.4]], D_1=[[1.6, 2, 0.7, -0.5]],
            D_2=size * D_2, E_1=[[1.0], [0]], E_2=[[0], [1.0]],
        )  # fmt: skip
        controller = lqg_controller(plant)
        K, P = design_60_digits(plant.A, plant.B, plant.E_1, plant.E_2, controller.regulator.K)
        _, Q = design_60_digits(
            plant.A.T, plant.C.T, plant.D_1.T, plant.D_2.T, controller.estimator.K
        )
        noise = mpmath.matrix(plant.D_1.tolist())
        J = sum((noise.T * P * noise)[i, i] for i in range(noise.cols))
        J += ((1 + P[0, 0]) * K * Q * K.T)[0, 0]
        assert controller.cost.value == pytest.approx(float(J), rel=1e-8)
        if size == 1e-5:
            assert controller.cost.value == pytest.approx(9.38779688608, rel=1e-11)
        lqg_controller(plant, form="filter")


@pytest.mark.costly
@pytest.mark.parametrize("seed", range(20))
def test_hard_designs_against_sixty_digits(seed):
    plant = hard_design(seed)
    controller = lqg_controller(plant)
    for one, system in (
        (controller.regulator, (plant.A, plant.B, plant.E_1, plant.E_2)),
        (controller.estimator, (plant.A.T, plant.C.T, plant.D_1.T, plant.D_2.T)),
    ):
        _, P = design_60_digits(*system, one.K)
        bound = 1e-13 * max(one.condition, 1.0) * len(plant.A)
        assert distance(one.P, P) < bound
        E_K = system[2] + system[3] @ one.K
        S = stein_factor(one.closed_loop, E_K)  # the cost of this gain, beside the least
        assert np.trace(S.T @ S) == pytest.approx(
            float(sum(P[i, i] for i in range(P.rows))), rel=bound
        )


@given(seed=st.integers(0, 2**32 - 1))
def test_a_factor_is_that_of_the_lyapunov_equation(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 5))
    A = rng.standard_normal((n, n))
    A *= 0.9 / max(np.abs(np.linalg.eigvals(A)).max(), 1e-3)
    E = rng.standard_normal((int(rng.integers(1, 4)), n))
    S = stein_factor(A, E)
    P = linalg.solve_discrete_lyapunov(A.T, E.T @ E)
    assert np.allclose(S.T @ S, P, rtol=1e-7, atol=1e-9 * np.abs(P).max())
    assert np.allclose(np.tril(S, -1), 0)


@given(seed=st.integers(0, 2**32 - 1), power=st.integers(-60, 60), units=st.integers(-40, 40))
@example(seed=1_248_820_907, power=29, units=0)  # a column of 0 in the large row
@example(seed=450, power=26, units=26)  # and it is the larger column
def test_rows_and_columns_of_any_size_are_fitted(seed, power, units):
    """A row that is 2^power times the others has its weight in the normal equations, exactly."""
    rng = np.random.default_rng(seed)
    X, Y = rng.integers(-9, 10, (5, 2)).astype(float), rng.integers(-9, 10, (5, 3)).astype(float)
    if np.linalg.matrix_rank(X[1:]) < 2:
        return
    X[0], Y[0] = X[0] * 2.0**power, Y[0] * 2.0**power
    K = least_squares(X * [1.0, 2.0**units], Y) * [[1.0], [2.0**units]]
    with mpmath.workdps(80):
        x, y = mpmath.matrix(X.tolist()), mpmath.matrix(Y.tolist())
        exact = -mpmath.inverse(x.T * x) * (x.T * y)
        exact = np.array(exact.tolist(), dtype=float)
    assert np.allclose(K, exact, rtol=1e-9, atol=1e-9 * (np.abs(exact).max() + 1))


def test_the_pencil_and_larger_weights_give_gains_to_start_from():
    A, B = np.array([[1.2, 1.0], [0.0, 0.7]]), np.array([[0.0], [1.0]])
    E_1, E_2 = np.array([[1.0, 0.0], [0.0, 0.0]]), np.array([[0.0], [1e-3]])
    expected = solve_riccati(A, B, E_1.T @ E_1, E_2.T @ E_2, time="discrete").K
    for balanced in (True, False):
        assert pencil_gain(A, B, E_1, E_2, balanced=balanced) == pytest.approx(expected, rel=1e-9)
    for K in starting_gains(A, B, E_1, E_2):  # the later ones are for other weights
        assert is_stable(A + B @ K)
        gain, S = kleinman(A, B, E_1, E_2, K)
        assert gain == pytest.approx(expected, rel=1e-12)
        assert best_gain(A, B, E_1, E_2, S) == pytest.approx(gain, rel=1e-12)


def test_what_is_not_determined_or_not_stable_is_refused():
    with pytest.raises(np.linalg.LinAlgError, match="zeros"):
        least_squares(np.array([[1.0, 0.0]]), np.ones((1, 1)))
    with pytest.raises(np.linalg.LinAlgError, match="dependent"):
        least_squares(np.ones((1, 2)), np.ones((1, 1)))
    with pytest.raises(np.linalg.LinAlgError):
        stein_factor(np.array([[1.5]]), np.ones((1, 1)))
    with pytest.raises(np.linalg.LinAlgError, match="no stabilising"):
        kleinman(
            np.array([[2.0]]), np.ones((1, 1)), np.ones((1, 1)), np.ones((1, 1)), np.zeros((1, 1))
        )
    assert not is_stable(np.array([[np.nan]])) and not triangle(np.zeros((0, 2))).any()


@given(seed=st.integers(0, 2**32 - 1))
def test_continuous_time_agrees_with_scipy_and_leaves_no_residual(seed):
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(1, 5)), int(rng.integers(1, 3))
    A, B = rng.standard_normal((n, n)), rng.standard_normal((n, m))
    E_1 = np.vstack([np.eye(n), np.zeros((m, n))])
    E_2 = np.vstack([rng.standard_normal((n, m)) / 10, np.eye(m)])
    solution = solve_riccati(A, B, E_1=E_1, E_2=E_2, time="continuous")
    P = linalg.solve_continuous_are(A, B, E_1.T @ E_1, E_2.T @ E_2, s=E_1.T @ E_2)
    assert solution.margin > 0 and solution.residual < 1e-11
    assert np.allclose(solution.P, P, rtol=1e-6, atol=1e-7 * np.abs(P).max())


@pytest.mark.parametrize("size", [1.0, 1e-3, 1e-7])
def test_cheap_control_of_a_double_integrator(size):
    """Textbook: u = -(x / rho + sqrt(2 / rho) v) for the weight rho^2 of u."""
    solution = solve_riccati(
        [[0.0, 1.0], [0.0, 0.0]], [[0.0], [1.0]],
        E_1=[[1.0, 0.0], [0.0, 0.0]], E_2=[[0.0], [size]], time="continuous",
    )  # fmt: skip
    np.testing.assert_allclose(solution.K, [[-1 / size, -np.sqrt(2 / size)]], rtol=1e-7)
    with pytest.raises(InputError, match="dependent columns"):
        solve_riccati([[1.0]], [[1.0]], E_1=[[1.0]], E_2=[[0.0]], time="continuous")
