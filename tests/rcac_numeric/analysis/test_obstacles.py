"""Zeros on the unit circle, on systems with known zeros, in coordinates drawn anew."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from compensator_theory.errors import UnitCircleError
from rcac_numeric.analysis._obstacles import require_no_zero_on_circle
from tests.support.strategies import seeds

WHOLE = np.exp(1j * np.linspace(0, np.pi, 64))


def factor_of(zero):
    """The real polynomial of a zero and its conjugate."""
    return np.array([1, -zero.real]) if zero.imag == 0 else np.array([1, -2 * zero.real, 1.0])


def scalar(numerator, n, rng):
    """One input and output of order n, in orthogonal coordinates, stable; E_2 = 0."""
    A, E_1 = np.eye(n, k=1), np.zeros((1, n))
    A[-1] = -np.poly(rng.uniform(-0.9, 0.9, n))[1:][::-1]
    E_1[0, : len(numerator)] = numerator[::-1]
    T = np.linalg.qr(rng.standard_normal((n, n)))[0]
    return T.T @ A @ T, T.T[:, [n - 1]], E_1 @ T, np.zeros((1, 1))


def tall(block, n, outputs, delayed, rng):
    """Two inputs whose zeros are the eigenvalues of `block` and others inside, and more outputs."""
    Z = 0.2 * rng.standard_normal((n, n)) / np.sqrt(n)
    Z[: len(block)] = 0
    Z[: len(block), : len(block)] = block
    T = np.linalg.qr(rng.standard_normal((n, n)))[0]
    B, E_1 = rng.standard_normal((n, 2)), rng.standard_normal((2, n))
    A, E_2, W = T.T @ Z @ T + B @ E_1, np.eye(2), rng.standard_normal((outputs, 2))
    if not delayed:
        return A, B, W @ E_1, W @ E_2
    A = np.block([[A, np.zeros((n, 2))], [E_1, np.zeros((2, 2))]])
    return A, np.vstack([B, E_2]), W @ np.eye(2, n + 2, k=n), np.zeros((outputs, 2))


@given(
    seeds,
    st.integers(6, 12),
    st.sampled_from([1 + 0j, -1 + 0j, 1j, np.exp(0.3j), np.exp(2j)]),
    st.integers(1, 2),
)
@example(260, 12, 1 + 0j, 2)  # a step from the eigenvalue leads away
def test_a_simple_or_double_zero_on_the_circle_is_named(seed, n, zero, multiplicity):
    numerator = np.array([1.0])
    for _ in range(multiplicity):
        numerator = np.polymul(numerator, factor_of(zero))
    system = scalar(numerator, n, np.random.default_rng(seed))
    with pytest.raises(UnitCircleError, match="zero on the unit circle"):
        require_no_zero_on_circle(*system, near=WHOLE)


@given(
    seeds, st.integers(3, 12), st.floats(0, np.pi), st.integers(2, 5), st.booleans(),
    st.sampled_from([0.0, 1e-15, -1e-15]),
)  # fmt: skip
def test_several_signals_have_their_zero_on_the_circle(seed, n, angle, outputs, delayed, distance):
    cosine, sine = np.cos(angle), np.sin(angle)
    block = (1 + distance) * np.array([[cosine, -sine], [sine, cosine]])
    system = tall(block, n, outputs, delayed, np.random.default_rng(seed))
    with pytest.raises(UnitCircleError, match="zero on the unit circle"):
        require_no_zero_on_circle(*system, near=WHOLE)


@given(
    seeds, st.integers(3, 12), st.floats(0, np.pi), st.integers(2, 5), st.booleans(),
    st.sampled_from([1e-2, 1e-4, 1e-6, -1e-6, -1e-4, -1e-2]),
)  # fmt: skip
def test_a_zero_beside_the_circle_is_none(seed, n, angle, outputs, delayed, distance):
    cosine, sine = np.cos(angle), np.sin(angle)
    block = (1 + distance) * np.array([[cosine, -sine], [sine, cosine]])
    system = tall(block, n, outputs, delayed, np.random.default_rng(seed))
    require_no_zero_on_circle(*system, near=WHOLE)


def test_zeros_of_100_states_take_few_decompositions(monkeypatch):
    decompositions, svd = [], np.linalg.svd
    monkeypatch.setattr(np.linalg, "svd", lambda *a, **o: decompositions.append(1) or svd(*a, **o))
    system = tall(np.diag([1.0, 0.5]), 100, 3, True, np.random.default_rng(1))
    with pytest.raises(UnitCircleError, match="at 1 "):
        require_no_zero_on_circle(*system, near=WHOLE)
    assert len(decompositions) < 10
