"""In continuous time `solve_riccati` speaks of its own equation: CAREX, stiff plants, obstacles."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import linalg

from compensator_theory.errors import (
    CompensatorError,
    InputError,
    NoSolutionError,
    NotControllableError,
    UnitCircleError,
)
from rcac_numeric import solve_riccati

I_2 = np.eye(2)
# Benner, Laub and Mehrmann (1995), examples 3 and 4 have sums of squares; 11 is indefinite.
INDEFINITE = {
    "one unstable mode": ([[1.0]], [[1.0]], [[-0.5]], [[1.0]], None),
    "a cross term": ([[-1.0, 2.0], [0.0, 0.5]], [[0.0], [1.0]], [[2.0, 0], [0, -0.1]], [[2.0]],
                     [[0.3], [-0.2]]),
    "a game": ([[-1.0]], [[1.0, 1.0]], [[1.0]], np.diag([1.0, -4.0]), None),
}  # fmt: skip


def left_over(A, B, Q, R, N, P):
    N = np.zeros_like(B) if N is None else np.asarray(N)
    gain = np.linalg.solve(R, N.T + B.T @ P)
    return A.T @ P + P @ A + Q - (P @ B + N) @ gain


@pytest.mark.parametrize("name", INDEFINITE)
def test_an_indefinite_weight_has_the_stabilising_solution(name):
    A, B, Q, R, N = (None if one is None else np.array(one) for one in INDEFINITE[name])
    solution = solve_riccati(A, B, Q, R, N, time="continuous")
    assert solution.P_root is None and solution.margin > 0
    assert np.abs(left_over(A, B, Q, R, N, solution.P)).max() < 1e-13 * (
        1 + np.abs(solution.P).max()
    )
    assert np.allclose(solution.P, linalg.solve_continuous_are(A, B, Q, R, s=N), rtol=1e-9)


@given(seed=st.integers(0, 2**32 - 1))
def test_weights_and_their_factors_have_one_solution(seed):
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(1, 5)), int(rng.integers(1, 3))
    A, B = rng.standard_normal((n, n)), rng.standard_normal((n, m))
    E_1, E_2 = rng.standard_normal((n + m, n)), rng.standard_normal((n + m, m))
    one = solve_riccati(A, B, E_1=E_1, E_2=E_2, time="continuous")
    other = solve_riccati(A, B, E_1.T @ E_1, E_2.T @ E_2, E_1.T @ E_2, time="continuous")
    weights = np.linalg.cond(E_2.T @ E_2) ** 2 * np.linalg.cond(one.P)
    assert np.allclose(one.P, other.P, rtol=0, atol=1e-11 * weights * np.abs(one.P).max())


@pytest.mark.parametrize("slow", [1e-3, 1e-9, 1e-13])
@pytest.mark.parametrize("fast", [1.0, 1e6, 1e12])
@pytest.mark.parametrize("reached", [0.0, 1.0])
def test_a_stable_plant_is_never_called_unstabilisable(slow, fast, reached):
    """By hand: the slow mode is reached by nothing, the fast one by itself alone."""
    try:
        solution = solve_riccati(
            np.diag([-slow, -fast]), [[0.0], [reached]], I_2, [[1.0]], time="continuous"
        )
    except NoSolutionError as error:  # float64 cannot hold both modes in one Schur form
        assert slow / fast < 1e-15 and "found in float64" in str(error)
        return
    p = 1 / (fast + np.hypot(fast, 1.0)) if reached else 1 / (2 * fast)
    assert np.diag(solution.P) == pytest.approx([1 / (2 * slow), p], rel=1e-9)


@pytest.mark.parametrize("slow", [1e-3, 1e-9])
def test_a_slow_mode_that_z_does_not_show_is_no_zero_on_the_axis(slow):
    solution = solve_riccati(
        np.diag([-slow, -1e6]), [[0.0], [1.0]], np.diag([0.0, 1.0]), [[1.0]], time="continuous"
    )
    assert np.diag(solution.P) == pytest.approx([0.0, 1 / 2e6], rel=1e-9)
    with pytest.raises(UnitCircleError, match="zero on the imaginary axis at 0 "):
        solve_riccati(
            np.diag([0.0, -1e6]), [[1.0], [1.0]], np.diag([0.0, 1.0]), [[1.0]], time="continuous"
        )


OBSTACLES = {
    "an unstable mode": (
        np.diag([1.0, -1.0]), I_2, NotControllableError, r"the mode 1 of A, which is on or right",
    ),
    "an integrator": (
        np.diag([0.0, -1.0]), I_2, NotControllableError, r"the mode 0 of A, which is on or right",
    ),
    "an unseen oscillation": (
        np.array([[0.0, 1.0], [-4.0, 0.0]]), np.zeros((2, 2)), UnitCircleError,
        r"zero on the imaginary axis at -?2j",
    ),
    "an unseen integrator": (
        np.array([[0.0, 1.0], [0.0, 0.0]]), np.diag([0.0, 1.0]), UnitCircleError,
        "zero on the imaginary axis at 0 ",
    ),
    "no real solution": (
        np.array([[1.0, 0.0], [0.0, -1.0]]), np.diag([-2.0, 1.0]), CompensatorError, ".",
    ),
    "CAREX 11": (  # its loop has the poles 1j and -1j
        np.array([[3.0, 1.0], [4.0, 2.0]]), np.array([[-11.0, -5.0], [-5.0, -2.0]]),
        UnitCircleError, r"eigenvalue on the imaginary axis at -?(1|0\.99999999\d*)j",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", OBSTACLES)
def test_an_obstacle_is_named_in_continuous_time(name):
    A, Q, error, words = OBSTACLES[name]
    B = np.array([[1.0], [1.0]]) if name == "CAREX 11" else np.array([[0.0], [1.0]])
    if name == "no real solution":
        B = I_2[:, :1]
    with pytest.raises(error, match=words) as caught:
        solve_riccati(A, B, Q, [[1.0]], time="continuous")
    assert "circle" not in str(caught.value)


def test_what_is_no_weight_is_refused_by_its_name():
    with pytest.raises(InputError, match="R is singular"):
        solve_riccati([[1.0]], [[1.0]], [[1.0]], [[0.0]], time="continuous")
    with pytest.raises(InputError, match="R is singular"):
        solve_riccati([[1.0]], [[1.0, 1.0]], [[1.0]], np.ones((2, 2)), time="continuous")
    with pytest.raises(InputError, match="Q is not symmetric"):
        solve_riccati(-I_2, I_2, [[1.0, 1.0], [0.0, 1.0]], I_2, time="continuous")
    with pytest.raises(InputError, match=r"E_1=E_1, E_2=E_2"):
        solve_riccati([[1.0]], [[1.0]], [[1.0], [0.0]], [[0.0], [1.0]], time="continuous")
    with pytest.raises(InputError, match="either as Q, R and N"):
        solve_riccati([[1.0]], [[1.0]], [[1.0]], E_1=[[1.0]], E_2=[[1.0]], time="continuous")
    with pytest.raises(InputError, match="R is singular"):
        solve_riccati([[1.0]], [[1.0]], [[1.0]], time="continuous")
    with pytest.raises(NoSolutionError, match="continuous-time Riccati equation"):
        solve_riccati([[1e200]], [[1.0]], [[1.0]], [[1.0]], time="continuous")
