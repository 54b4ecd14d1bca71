"""The state after r steps of x(k + 1) = A x(k) + D_1 w(k) + B u(k), letters that do not commute."""

from sympy import Expr, expand

from .letters import letters

A, B, C, D_1, x, y = letters("A B C D_1 x y")


def state(r: int) -> Expr:
    """Return x(k) from x(k - r), by the recursion; w_i is w(k - i)."""
    value = x
    for i in range(r, 0, -1):
        w, u = letters(f"w_{i} u_{i}")
        value = A * value + D_1 * w + B * u
    return value


def past_inputs(r: int) -> bool:
    """(8.36), (8.37): the r last inputs enter x(k) with A^(i-1) B, and C x(k) - y(k) with their
    Markov parameters.
    """
    past = [letters(f"w_{i} u_{i}") for i in range(1, r + 1)]
    claimed = A**r * x + sum(
        A ** (i - 1) * (D_1 * w + B * u) for i, (w, u) in enumerate(past, start=1)
    )
    performance = (
        C * A**r * x
        - y
        + sum(C * A ** (i - 1) * (D_1 * w + B * u) for i, (w, u) in enumerate(past, start=1))
    )
    value = state(r)
    return bool(expand(value - claimed) == 0 and expand(C * value - y - performance) == 0)
