"""A linear recursion in blocks is the recursion step by step."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rcac_numeric import TargetModel
from rcac_numeric.analysis._closed_loop import FEW, linear_states
from rcac_numeric.analysis._match import filtered


def one_by_one(A, drive):
    states = [np.zeros(len(A))]
    for d in drive:
        states.append(A @ states[-1] + d)
    return np.array(states)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32), st.integers(1, 5), st.integers(1, 3 * FEW), st.floats(0.1, 1.002))
def test_in_blocks_as_one_by_one(seed, n, steps, radius):
    """With any number of steps, about the size where blocks begin too; also where it grows."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    A *= radius / np.abs(np.linalg.eigvals(A)).max()
    drive = rng.standard_normal((steps, n))
    expected = one_by_one(A, drive)
    result = linear_states(A, drive)
    assert result.shape == (steps + 1, n)
    assert np.allclose(result, expected, rtol=0, atol=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize("steps", [0, 1, FEW - 1, FEW, FEW + 1, FEW + 40])
def test_every_length(steps):
    A, drive = np.array([[0.5, 1.0], [0.0, 0.9]]), np.ones((steps, 2))
    assert np.allclose(linear_states(A, drive), one_by_one(A, drive), rtol=1e-13)


def test_a_target_model_with_matrix_denominator():
    """(2.38) as it is written: z(k) = sum N_i u(k-i) - sum D_i z(k-i)."""
    rng = np.random.default_rng(3)
    N = rng.standard_normal((3, 2, 1))
    D = np.stack([np.eye(2), 0.3 * np.eye(2), 0.1 * rng.standard_normal((2, 2))])
    N[0] = 0
    target, u = TargetModel(N, D), rng.standard_normal((FEW + 300, 1))
    z = np.zeros((len(u), 2))
    for k in range(len(u)):
        for i in range(1, min(k, 2) + 1):
            z[k] += N[i] @ u[k - i] - D[i] @ z[k - i]
    assert np.allclose(filtered(target, u), z, rtol=1e-10, atol=1e-12)
