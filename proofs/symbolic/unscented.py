"""The points and weights of the unscented transformation, (8.9)-(8.12)."""

from sympy import Matrix, Rational, simplify, symbols

alpha = symbols("alpha", positive=True)


def moments(n: int) -> bool:
    """(8.12): with gamma_0 = (alpha - n) / alpha the mean is x and the covariance P = SS'."""
    x = Matrix(symbols(f"x:{n}"))
    S = Matrix(n, n, symbols(f"s:{n * n}"))
    points = [
        x,
        *(x + sign * alpha ** Rational(1, 2) * S[:, i] for sign in (1, -1) for i in range(n)),
    ]
    weights = [(alpha - n) / alpha, *[1 / (2 * alpha)] * (2 * n)]
    mean = sum((g * X for g, X in zip(weights, points, strict=True)), Matrix.zeros(n, 1))
    spread = sum(
        (g * (X - x) * (X - x).T for g, X in zip(weights, points, strict=True)), Matrix.zeros(n, n)
    )
    return bool(simplify(mean - x).is_zero_matrix and simplify(spread - S * S.T).is_zero_matrix)
