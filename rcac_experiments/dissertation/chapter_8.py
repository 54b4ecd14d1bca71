"""Chapter 8 as it is printed: filters."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

Facts = Iterator[tuple[str, bool]]


def index_of_the_jacobian() -> Facts:
    """The covariance after one step of x^2, and the Jacobian at x^(k-1) and at x^(k-2)."""
    before, now, spread = 1.0, 2.0, 1e-4  # x^(k-2), x^(k-1), and the deviation of the latter
    propagated = (((now + spread) ** 2 - (now - spread) ** 2) / 2) ** 2
    right, printed = (2 * now * spread) ** 2, (2 * before * spread) ** 2
    yield "the Jacobian at x^(k-1) propagates P(k-1)", abs(right / propagated - 1) < 1e-6
    yield "A^(k-1) of (8.8), taken at x^(k-2), does not", abs(printed / propagated - 1) > 0.5


def process_noise_of_the_ukf() -> Facts:
    """x(k+1) = x/2 + w with x = 2 or -2 and w = 3 or -3, all four equally likely."""
    P, Q = Fraction(4), Fraction(9)
    values = [Fraction(x, 2) + w for x in (2, -2) for w in (3, -3)]
    covariance = sum((value**2 for value in values), Fraction(0)) / 4
    spread = Fraction(1, 4) * P  # of the points of (8.22), which leave w out
    yield "the sum of (8.24) is not Q", spread != Q
    yield "the sum plus Q is the covariance of x(k+1)", spread + Q == covariance


def singular_hessian() -> Facts:
    """A(k) of (8.53) for H~ = [H_1 H_2], R = 1, eta = 0, and for H~ = H_2."""
    H = np.array([[1.2, 0.6]])
    yield "H~'H~ has rank 1 and order 2", np.linalg.matrix_rank(H.T @ H) == 1
    projected = np.linalg.pinv(H) @ H @ np.array([1.0, 1.0])
    yield "its pseudoinverse moves u* off u where z = 0", bool(np.abs(projected - 1).max() > 0.1)
    yield "H_2 alone is regular", H[0, 1] ** 2 > 0


def dimensions_of_8_81() -> Facts:
    """Shapes in (8.81) for three rows of Z, two of U~ and a scalar parameter."""
    H, Y, Z = np.ones((3, 2)), np.ones((2, 1)), np.ones((3, 1))
    try:
        (H.T @ Z) @ Y
    except ValueError:
        fits = False
    else:
        fits = True
    yield "H~'R[Z - H~U~] Y^ has no meaning", not fits
    yield "Y^'H~'R[Z - H~U~] is a scalar", (Y.T @ H.T @ Z).shape == (1, 1)


def unexciting_ramp() -> Facts:
    """The mass of Example 8.3, m = 1, c = 5, kappa = 10, h = 0.1, under w = 0.1k."""
    x, h, late = np.array([0.1, 0.01]), 0.1, []
    for k in range(101):
        acceleration = 0.1 * k - 5 * x[1] - 10 * x[0]
        late.append(acceleration)
        x = x + h * np.array([x[1], acceleration])
    yield "the acceleration at k = 100 is below 1e-4 of its largest value", _died_out(late)


def _died_out(values: list[float]) -> bool:
    return abs(values[-1]) < 1e-4 * max(map(abs, values))


# What (8.25) to (8.63) say of inputs, outputs and sizes, on the system of Example 8.1.

_A = np.array([[1.0, 0.1], [0.0, 0.5]])  # the stiffness enters by u = -kappa y_0
_B, _D = np.array([0.0, -0.1]), np.array([0.0, 0.1])
_E, _C = np.array([1.0, 0.0]), np.array([0.0, 1.0])  # y_0 = x_1 and y = x_2


def _responses(w: np.ndarray, kappa: float, noise: np.ndarray | None = None) -> np.ndarray:
    """The velocity y of the stiffness kappa, driven by y_0 plus `noise`."""
    x, outputs = np.array([0.1, 0.01]), []
    for k, now in enumerate(w):
        outputs.append(_C @ x)
        y_0 = _E @ x + (0.0 if noise is None else noise[k])
        x = _A @ x + _B * kappa * y_0 + _D * now
    return np.array(outputs)


def model_without_the_input() -> Facts:
    """A model with the right stiffness, with and without w."""
    w = 100 * np.cos(0.8 * np.arange(200))
    true = _responses(w, 10.0)
    yield "with w and the right parameter it follows", np.allclose(_responses(w, 10.0), true)
    error = np.abs(_responses(0 * w, 10.0) - true).max() / np.abs(true).max()
    yield "without w it does not, though the parameter is right", error > 0.5


def noise_in_the_dynamics() -> Facts:
    """Noise in y_0, which drives the unknown subsystem, and noise in the measured y."""
    w, v = np.cos(0.8 * np.arange(200)), 0.1 * np.cos(2.1 * np.arange(200))
    true = _responses(w, 10.0)
    driven = _responses(w, 10.0, v)
    yield "noise added to y_0 moves the true state", np.abs(driven - true).max() > 1e-3
    yield "and is not what (8.65) adds to y", not np.allclose(driven, true + v)


def gain_of_the_update() -> Facts:
    """The covariance after an update with a gain, and that of (8.16)."""
    P, R = Fraction(3), Fraction(1)
    K = P / (P + R)
    after = (1 - K) ** 2 * P + K**2 * R  # of the error after x + K (y - y^), any K
    yield "with K_k of (8.17) it is P - K (P + R) K' of (8.16)", after == P - K * (P + R) * K
    other = Fraction(1, 2)
    wrong = (1 - other) ** 2 * P + other**2 * R
    yield "with another gain it is not", wrong != P - K * (P + R) * K


def measured_output() -> Facts:
    """The residual of the right parameter, from the measured y and from y_0."""
    w = np.cos(0.8 * np.arange(50))
    y = _responses(w, 10.0)
    x, y_0 = np.array([0.1, 0.01]), []
    for now in w:
        y_0.append(_E @ x)
        x = _A @ x + _B * 10.0 * y_0[-1] + _D * now
    residual, printed = _responses(w, 10.0) - y, _responses(w, 10.0) - np.array(y_0)
    yield "y^ - y is zero for the right parameter", np.abs(residual).max() < 1e-12
    yield "y^ - y_0 is not: y is the velocity, y_0 the position", np.abs(printed).max() > 1e-2


def stacked_residuals() -> Facts:
    """z(k) split by two choices of the retained entries, two rows of S."""
    markov, past = np.array([3.0, -2.0, 0.5]), np.array([1.0, 4.0, -1.0])
    z = float(markov @ past)
    columns = ([0], [1])  # H~_1 holds the first Markov parameter, H~_2 the second
    S = [z - float(markov[j] @ past[j]) for j in columns]
    yield "S_1 and S_2 of one k differ", abs(S[0] - S[1]) > 1
    rows = [S[i] + float(markov[j] @ past[j]) for i, j in enumerate(columns)]
    yield "each row needs its own S_j to add up to z", np.allclose(rows, z)
    wrong = [S[0] + float(markov[j] @ past[j]) for j in columns]
    yield "one S for both rows does not", not np.allclose(wrong, z)


def linear_term() -> Facts:
    """The expansion of the squared norm of Z - H~U~ + H~U in U, and B(k) as a column."""
    H, U, R = np.array([[1.0, 2.0], [0.5, -1.0], [3.0, 0.0]]), np.array([0.3, -0.7]), np.eye(3)
    rest = np.array([1.0, -2.0, 0.5])
    B = 2 * H.T @ R @ rest
    whole = (rest + H @ U) @ R @ (rest + H @ U)
    yield "B is a column of as many entries as U", B.shape == U.shape and H.shape[1] == 2
    parts = U @ H.T @ R @ H @ U + B @ U + rest @ R @ rest
    yield "the linear term is B'U", abs(whole - parts) < 1e-12


def index_of_the_sum() -> Facts:
    """The least squares of a sum whose summand has the index i, and with the index k."""
    phi, u = np.array([1.0, 2.0, -1.0]), np.array([2.0, 4.0, -2.0])  # u = 2 phi
    yield "with i the parameter 2 is the minimiser", abs(phi @ u / (phi @ phi) - 2) < 1e-12
    u_noisy = u + np.array([0.3, 0.0, 0.0])
    whole, last = phi @ u_noisy / (phi @ phi), u_noisy[-1] / phi[-1]
    yield "with k in every summand only the last data count", abs(whole - last) > 1e-3


def transpose_of_8_62() -> Facts:
    """The update P phi u' for a row theta of two outputs: sizes with and without the transpose."""
    P, phi, u = np.eye(3), np.ones((3, 1)), np.ones((2, 1))
    yield "P phi u' has the size of theta'", (P @ phi @ u.T).shape == (3, 2)
    try:
        P @ phi @ u
        fits = True
    except ValueError:
        fits = False
    yield "P phi u has none", not fits
