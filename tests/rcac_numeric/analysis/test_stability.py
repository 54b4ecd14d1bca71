"""Stability is decided right where computed eigenvalues are wrong."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_lyapunov

from compensator_theory.errors import IllConditionedError, InputError
from rcac_numeric.analysis._gramians import enclosed_gramians, rational
from rcac_numeric.analysis._stability import counted_stable, is_schur_stable
from tests.support.strategies import seeds


def known(rng, n, eigenvalues, coupling):
    """A matrix of float64 numbers that has exactly these eigenvalues: L T L^{-1}, L unimodular."""
    T = np.diag(eigenvalues) + np.triu(rng.integers(-coupling, coupling + 1, (n, n)), 1)
    L = np.eye(n) + np.tril(rng.integers(-1, 2, (n, n)), -1)
    inverse = np.rint(np.linalg.inv(L))
    assert (L @ inverse == np.eye(n)).all()
    return L @ T @ inverse


@given(seeds, st.integers(1, 7), st.sampled_from([1, 30, 1000]), st.booleans())
def test_matrices_with_known_eigenvalues(seed, n, coupling, one_outside):
    """Multiples of 1/64: every product is exact in float64, and so is the truth."""
    rng = np.random.default_rng(seed)
    eigenvalues = rng.integers(-63, 64, n) / 64
    if one_outside:
        eigenvalues[rng.integers(n)] = rng.choice([-65, -64, 64, 65]) / 64
    A = known(rng, n, eigenvalues, coupling)
    assert is_schur_stable(A) is not one_outside
    assert counted_stable(rational(A)) is not one_outside


@given(st.floats(0.5, 0.999), st.floats(1e-6, 0.1), st.integers(1, 4))
def test_an_uncertainty_that_reaches_the_circle_is_not_stable(diagonal, beyond, n):
    """Of all the matrices that are meant one, A + uncertainty, has a row sum above 1."""
    uncertainty = np.full((n, n), (1 + beyond - diagonal) / n)
    with pytest.raises(IllConditionedError, match="float64 does not determine"):
        is_schur_stable(diagonal * np.eye(n), uncertainty)


def test_computed_eigenvalues_would_be_wrong():
    """A Jordan block of 7/8 in another basis: eigenvalues outside, and stable all the same."""
    rng = np.random.default_rng(0)
    wrong = 0
    for _ in range(20):
        A = known(rng, 14, np.full(14, 7 / 8), 3)
        assert is_schur_stable(A)
        wrong += np.abs(np.linalg.eigvals(A)).max() >= 1
    assert wrong > 5


@given(seeds, st.integers(1, 6), st.floats(0.0, 2.0))
def test_ordinary_matrices_agree_with_their_eigenvalues(seed, n, size):
    A = np.random.default_rng(seed).standard_normal((n, n)) * size / np.sqrt(n)
    radius = np.abs(np.linalg.eigvals(A)).max()
    if abs(radius - 1) > 1e-6:
        assert is_schur_stable(A) == (radius < 1)


def test_a_neighbour_that_is_not_stable_is_seen():
    A = np.array([[0.5, 1e6], [0.0, 0.5]])
    assert is_schur_stable(A)
    assert is_schur_stable(A, 1e-9 * np.eye(2))
    with pytest.raises(IllConditionedError, match="float64 does not determine"):
        is_schur_stable(A, 1e-5 * np.ones((2, 2)))  # 0.5 +- sqrt(1e6 1e-5) is outside
    with pytest.raises(InputError, match="not finite"):
        is_schur_stable(np.array([[np.nan]]))


@given(seeds, st.integers(1, 4))
def test_balls_hold_the_gramians(seed, n):
    rng = np.random.default_rng(seed)
    A = rng.integers(-8, 9, (n, n)) / (8 * n)
    B, C = rng.integers(-9, 10, (n, 2)), rng.integers(-9, 10, (1, n))
    if not is_schur_stable(A):
        assert enclosed_gramians(*map(rational, (A, A, A)), 128) is None
        return
    X, Y = enclosed_gramians(rational(A), rational(B @ B.T), rational(C.T @ C), 128)
    for ball, expected in (
        (X, solve_discrete_lyapunov(A, B @ B.T)),
        (Y, solve_discrete_lyapunov(A.T, C.T @ C)),
    ):
        middles = np.array([float(e.mid()) for e in ball.entries()]).reshape(n, n)
        assert np.allclose(middles, expected, rtol=1e-6, atol=1e-9 * max(1, np.abs(expected).max()))
        # what is left out when doubling ends is 2^-64 of the Frobenius norm
        size = 2.0**-63 * n * (1 + np.abs(expected).max())
        assert all(float(e.rad()) < size for e in ball.entries())
