"""A Stein equation is answered with a residual of rounding, or refused."""

from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq_mat
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory.errors import IllConditionedError
from rcac_numeric import design
from rcac_numeric.analysis._gramians import _from_schur, rational, stein_residual, stein_solution

EPS = np.finfo(float).eps


def exactly(A, Q):
    """The solution over the rationals, by Kronecker products."""
    n = len(A)
    A, Q = rational(A), rational(Q)
    rows = fmpq_mat(n * n, n * n, [
        (i == k and j == m) - A[i, k] * A[j, m]
        for i in range(n) for j in range(n) for k in range(n) for m in range(n)
    ])  # fmt: skip
    X = rows.solve(fmpq_mat(n * n, 1, Q.entries()))
    return np.reshape([float(Fraction(int(e.p), int(e.q))) for e in X.entries()], (n, n))


@given(n=st.integers(2, 5), coupling=st.sampled_from([1e2, 1e6, 1e12]), seed=st.integers(0, 10**6))
def test_strongly_non_normal_equations_have_the_exact_solution_or_none(n, coupling, seed):
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.standard_normal((n, n)))
    T = np.triu(coupling * rng.standard_normal((n, n)), 1) + np.diag(rng.uniform(-0.9, 0.9, n))
    A, Q = turn @ T @ turn.T, np.eye(n)
    if not np.abs(np.linalg.eigvals(A)).max() < 1:
        with pytest.raises(IllConditionedError):
            stein_solution(A, Q)
        return
    try:
        X = stein_solution(A, Q)
    except IllConditionedError:  # by its exact entries it need not be stable
        return
    left = np.abs(A @ X @ A.T + Q - X).max()
    assert left <= 2000 * (n + 1) * EPS * (np.abs(A) @ np.abs(X) @ np.abs(A).T + Q).max()
    # What a backward error of that size moves: X of |A||X||A|' in place of Q, by norms.
    size = np.linalg.norm(A, 2) ** 2 * np.linalg.norm(X, 2)
    allowed = 1e4 * n**2 * EPS * size * np.linalg.norm(X, 2)
    assert np.abs(X - exactly(A, Q)).max() <= allowed


@pytest.mark.parametrize(
    ("A", "Q"),
    [
        ([[1.0]], [[1.0]]),
        ([[1.5, 0], [0, 0.5]], np.eye(2)),
        ([[0, 1e200], [0, 0]], np.eye(2)),
        ([[np.inf]], [[1.0]]),
        ([[0.5]], [[np.nan]]),
    ],
)
def test_what_has_no_solution_in_float64_is_refused(A, Q):
    with pytest.raises(IllConditionedError, match="no solution that float64 holds"):
        stein_solution(np.array(A), np.array(Q))


def test_a_residual_that_is_not_finite_is_infinite():
    nan = np.full((1, 1), np.nan)
    assert stein_residual(np.eye(1), nan, nan) == np.inf
    assert stein_residual(np.zeros((2, 2)), np.zeros((2, 2)), np.zeros((2, 2))) == 0.0


@pytest.mark.costly
@pytest.mark.parametrize("noise", [0.02])
def test_the_column_of_wood_and_berry_is_designed_at_every_level_of_noise(noise):
    G = [["12.8/(16.7*s + 1)", "-18.9/(21*s + 1)"], ["6.6/(10.9*s + 1)", "-19.4/(14.4*s + 1)"]]
    late = [[1, 3], [7, 3]]
    designed = design(
        G, sample_time=1.0, dead_time=late, disturbance=0.1, noise=noise, seeds=1, steps=100
    )
    assert np.isfinite(designed.controller.theta_0).all()


@given(n=st.integers(1, 6), radius=st.sampled_from([0.3, 0.9, 0.999]), seed=st.integers(0, 10**6))
def test_the_schur_form_of_many_states_has_a_residual_of_rounding(n, radius, seed):
    rng = np.random.default_rng(seed)
    A, root = rng.standard_normal((n, n)), rng.standard_normal((n, n))
    A *= radius / np.abs(np.linalg.eigvals(A)).max()
    assert stein_residual(A, root @ root.T, _from_schur(A, root @ root.T)) <= 50 * n * EPS
