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
