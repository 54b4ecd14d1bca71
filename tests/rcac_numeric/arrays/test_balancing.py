"""Balanced matrices against their similarity, and as far as float64 reaches."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory.errors import IllConditionedError
from rcac_numeric.arrays._balancing import balancing_scales, scaled_states
from rcac_numeric.designing._plants import balanced

POWERS = st.lists(st.integers(-450, 450), min_size=2, max_size=5)


@given(POWERS, st.integers(0, 2**32 - 1))
def test_any_scales_of_the_states_are_undone(powers, seed):
    """Scales of 2^900 apart, of which a factor that SciPy makes an integer is no int64."""
    rng, n = np.random.default_rng(seed), len(powers)
    A, B, C = rng.uniform(0.5, 2, (n, n)), rng.uniform(0.5, 2, (n, 1)), rng.uniform(0.5, 2, (1, n))
    moved = scaled_states(A, np.exp2(powers))
    scale = balancing_scales(moved)
    assert (np.log2(scale) % 1 == 0).all()
    result = scaled_states(moved, scale)
    assert result.max() <= 64 * result.min()
    by = np.exp2(powers)
    a, b, c = balanced(moved, B / by[:, None], C * by)
    assert np.log2([np.abs(v).max() for v in (a, b, c)]) == pytest.approx(0, abs=8)
    points = 3 * n * np.exp(1j * np.arange(3.0))
    for p in points:
        expected = C @ np.linalg.solve(p * np.eye(n) - A, B)
        assert c @ np.linalg.solve(p * np.eye(n) - a, b) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("size", [np.inf, np.nan, 1e300])
def test_what_leaves_float64_is_refused(size):
    with pytest.raises(IllConditionedError, match="leaves float64"):
        balanced(np.array([[0.5]]), np.array([[size]]), np.array([[size]]))


@pytest.mark.parametrize("a", [[[1.0, 1.0], [-1.0, 1.0]], [[2.0, -2.0], [1.0, 0.0]]])
def test_poles_at_the_point_where_the_gain_is_read(a):
    B, C = np.eye(2, 1), np.eye(1, 2)
    result = balanced(np.array(a), B, C)
    assert np.poly(result[0]) == pytest.approx([1, -2, 2])
