"""Chapter 3 as it is printed: the discretised aircraft."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.signal import cont2discrete, ss2tf

from rcac_numeric.arrays._array_types import Array, ComplexArray

Facts = Iterator[tuple[str, bool]]
H = 0.1  # seconds
C = np.array([[0.0, 0.0, 0.0, 1.0]])  # the roll angle

A_0 = np.array(
    [
        [-0.0771, 0.269, -0.9631, 0.0397],
        [-25.60, 0.0218, 0.0995, 0],
        [0.6160, 0.0376, -0.2687, 0],
        [0, 1, -0.4202, 0.0058],
    ]
)
B_0 = np.array([[-0.0002], [2.519], [-0.0222], [0]])
A_1, B_1 = A_0.copy(), B_0.copy()
A_1[1, 0], A_1[2, 0], B_1[2, 0] = -108.8, 0.4107, -0.0665

PRINTED_0 = (
    np.array(
        [
            [0.9553, 0.0265, -0.0934, 0.0039],
            [-2.5210, 0.9680, 0.1310, -0.0050],
            [0.0551, 0.0045, 0.9708, 0.0001],
            [-0.1282, 0.0989, -0.0369, 1.0004],
        ]
    ),
    np.array([[0.0034], [0.2492], [-0.0017], [0.0126]]),
)
PRINTED_1 = (
    np.array(
        [
            [0.9482, 0.0255, -0.0900, 0.0038],
            [-10.3212, 0.9595, 0.5152, -0.0210],
            [0.0186, 0.0041, 0.9723, 0.0001],
            [-0.5304, 0.0953, -0.0239, 0.9999],
        ]
    ),
    np.array([[0.0036], [0.2390], [-0.0061], [0.0124]]),
)
ROUNDING = 5.1e-5  # of four decimals


def zero_order_hold() -> Facts:
    """(3.3) compared with both discretisations of (3.1), and where Euler's method leads."""
    A, B = _sampled(A_0, B_0)
    off = max(np.abs(A - PRINTED_0[0]).max(), np.abs(B - PRINTED_0[1]).max())
    yield "(3.3) is the zero-order hold to four decimals", off < ROUNDING
    euler = np.eye(4) + H * A_0
    yield "Euler's A differs from (3.3) by 0.128", round(_distance(euler, PRINTED_0[0]), 3) == 0.128
    radii = [_radius(np.eye(4) + H * A) for A in (A_0, A_1)]
    yield "Euler's plants are unstable, nominal and off-nominal", min(radii) > 1.03


def two_digits() -> Facts:
    """(3.4) compared with the zero-order hold of (3.2)."""
    A, B = _sampled(A_1, B_1)
    difference = PRINTED_1[0] - A
    yield "(1,1) and (2,2) are off by 0.1", np.abs(np.diag(difference)[:2] - 0.1).max() < ROUNDING
    corrected = _corrected()
    off = max(_distance(A, corrected[0]), _distance(B, corrected[1]))
    yield "with 0.8482 and 0.8595 nothing else is off", off < ROUNDING
    yield "as printed the spectral radius is 1.084", round(_radius(PRINTED_1[0]), 3) == 1.084
    yield "corrected the plant is stable", _radius(corrected[0]) < 1


def nominal_zero() -> Facts:
    """The sampling zero of the nominal plant, of four decimals and of all of them."""
    printed, sampled = _zeros(*PRINTED_0), _zeros(*_sampled(A_0, B_0))
    yield "of the printed matrices it is -0.9959", _has(printed, -0.9959, 1e-4)
    yield "of the zero-order hold it is -1.0004", _has(sampled, -1.0004, 1e-4)


def off_nominal_zero() -> Facts:
    """The zeros after the transition, of four decimals and of all of them."""
    printed, sampled = _zeros(*_corrected()), _zeros(*_sampled(A_1, B_1))
    yield "of four decimals: -1.0027 and 1.1369", _has(printed, -1.0027) and _has(printed, 1.1369)
    yield (
        "of the zero-order hold: -1.0004 and 1.1359",
        _has(sampled, -1.0004) and _has(sampled, 1.1359),
    )
    before = _zeros(*_sampled(A_0, B_0))
    crossing = int((np.abs(sampled) > 1).sum() - (np.abs(before) > 1).sum())
    yield "one zero crosses the unit circle, not two", crossing == 1


def first_markov_parameters() -> Facts:
    """The impulse response of (3.8) for mu = 2, n_mod = 1, each with separate coefficients."""
    H_0, H_1, b, a = 3.0, 5.0, 7.0, -0.5
    u, y = [0.0, 0.0, 1.0, 0.0, 0.0], [0.0] * 5  # two steps of rest come first
    for k in range(2, 5):
        y[k] = H_0 * u[k] + H_1 * u[k - 1] + b * u[k - 2] - a * y[k - 2]
    yield "the first mu = 2 outputs are H_0 and H_1", y[2:4] == [H_0, H_1]
    H_2 = y[4]
    yield "and not H_1 and H_2", y[2:4] != [H_1, H_2]


def _corrected() -> tuple[Array, Array]:
    A = PRINTED_1[0].copy()
    A[0, 0], A[1, 1] = 0.8482, 0.8595
    return A, PRINTED_1[1]


def _sampled(A: Array, B: Array) -> tuple[Array, Array]:
    discrete = cont2discrete((A, B, C, np.zeros((1, 1))), H)
    return discrete[0], discrete[1]


def _zeros(A: Array, B: Array) -> ComplexArray:
    numerator = ss2tf(A, B, C, np.zeros((1, 1)))[0][0]
    return np.roots(numerator[1:]).astype(complex)  # strictly proper


def _has(zeros: ComplexArray, value: float, within: float = 1e-4) -> bool:
    return bool(np.abs(zeros - value).min() < within)


def _distance(a: Array, b: Array) -> float:
    return float(np.abs(a - b).max())


def _radius(A: Array) -> float:
    return float(np.abs(np.linalg.eigvals(A)).max())
