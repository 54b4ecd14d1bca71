"""Chapter 8, estimation, as it is worded."""

from collections.abc import Iterator

from sympy import Rational

Facts = Iterator[tuple[str, bool]]


def printed_weight() -> Facts:
    """n = 1, alpha = 2: with gamma_0 = (alpha - n) / n of (8.11) the weights add up to 3/2."""
    n, alpha = 1, 2
    rest = 2 * n * Rational(1, 2 * alpha)
    yield (
        "gamma_0 + gamma_1 + gamma_2 = 3/2 as printed",
        Rational(alpha - n, n) + rest == Rational(3, 2),
    )
    yield "they add up to 1 with (alpha - n) / alpha", Rational(alpha - n, alpha) + rest == 1


def points_of_the_forecast() -> Facts:
    """x(k + 1) = x(k) + w, y = x + v, P^+ = Q = R = 1: the Kalman gain is 2/3, and (8.17)-(8.20)
    with the points of (8.22) give 1/2.
    """
    P, Q, R = 1, 1, 1
    forecast = P + Q
    yield "the Kalman gain is 2/3", Rational(forecast, forecast + R) == Rational(2, 3)
    weight = Rational(1, 2)  # alpha = 1: gamma_0 = 0, gamma_1 = gamma_2 = 1/2
    points = [1, -1]  # of x^+ = 0, which f leaves as they are
    spread = sum(weight * point**2 for point in points)
    yield "that of the points of (8.22) is 1/2", spread / (spread + R) == Rational(1, 2)
