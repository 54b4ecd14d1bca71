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


def weights_of_the_ukf() -> Facts:
    """The sum of the weights (8.11) for n = 3."""
    n = 3

    def total(alpha: int, over: int) -> Fraction:
        return Fraction(alpha - n, over) + 2 * n * Fraction(1, 2 * alpha)

    yield "as printed the weights add up to 7/3 for n = 3, alpha = 1", total(1, n) == Fraction(7, 3)
    yield "as printed they add up to 1 for alpha = n only", _only_at(n, total)
    right = all(total(alpha, alpha) == 1 for alpha in range(1, 10))
    yield "with (alpha - n)/alpha they add up to 1 for every alpha", right


def _only_at(n: int, total: object) -> bool:
    assert callable(total)
    return [alpha for alpha in range(1, 10) if total(alpha, n) == 1] == [n]


def process_noise_of_the_ukf() -> Facts:
    """x(k+1) = x/2 + w with x = 2 or -2 and w = 3 or -3, all four equally likely."""
    P, Q = Fraction(4), Fraction(9)
    values = [Fraction(x, 2) + w for x in (2, -2) for w in (3, -3)]
    covariance = sum((value**2 for value in values), Fraction(0)) / 4
    spread = Fraction(1, 4) * P  # of the points of (8.22), which leave w out
    yield "the sum of (8.24) is not Q", spread != Q
    yield "the sum plus Q is the covariance of x(k+1)", spread + Q == covariance


def redrawn_points() -> Facts:
    """The gain for x(k+1) = a x + w, y = x + v, from the points of (8.22) and from new ones."""
    a, P, Q, R = Fraction(1, 2), Fraction(4), Fraction(2), Fraction(1)
    predicted = a * a * P + Q
    kalman = predicted / (predicted + R)

    def gain(spread: Fraction) -> Fraction:
        """(8.17)-(8.19), where the points deviate by sqrt(alpha spread), alpha = n = 1."""
        return spread / (spread + R)

    yield "from the points of (8.22) it is not the Kalman gain", gain(a * a * P) != kalman
    yield "from points drawn anew it is", gain(predicted) == kalman


def singular_hessian() -> Facts:
    """A(k) of (8.53) for H~ = [H_1 H_2], R = 1, eta = 0, and for H~ = H_2."""
    H = np.array([[1.2, 0.6]])
    yield "H~'H~ has rank 1 and order 2", np.linalg.matrix_rank(H.T @ H) == 1
    held = np.linalg.pinv(H) @ H @ np.array([1.0, 1.0])
    yield "its pseudoinverse moves u* off u where z = 0", bool(np.abs(held - 1).max() > 0.1)
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
