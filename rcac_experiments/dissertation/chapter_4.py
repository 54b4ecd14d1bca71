"""Chapter 4 as it is printed: costs of LQG and noise intensities."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np
from scipy.linalg import solve_discrete_lyapunov

from rcac_experiments.dissertation._tables import example_table
from rcac_numeric.analysis._lqg import lqg_controller
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._problems import servo_plant, standard_plant

Facts = Iterator[tuple[str, bool]]


def cross_term() -> Facts:
    """x(k+1) = x/2 + u + w, u = x_c, x_c(k+1) = x/4, z = x + u: the terms of E z^2."""
    A = np.array([[0.5, 1.0], [0.25, 0.0]])
    Q = solve_discrete_lyapunov(A, np.diag([1.0, 0.0]))
    cost = np.array([1.0, 1.0]) @ Q @ np.array([1.0, 1.0])
    printed = Q[0, 0] + Q[1, 1]
    yield "tr(Q_1 R_1) + tr(Q_2 C_c'R_2 C_c) is not the cost", abs(printed - cost) > 0.1
    yield "with 2 tr(R_12 C_c Q_12') it is", abs(printed + 2 * Q[0, 1] - cost) < 1e-12


def direct_term() -> Facts:
    """x(k+1) = x/2 + d, z = x + v: the variance of z compared with tr(Q_1 R_1)."""
    Q = 1 / (1 - 0.5**2)
    response = np.array([1.0, *0.5 ** np.arange(60)])  # of z to v, then to d
    cost = float((response**2).sum())
    yield "the mean square of z is tr(Q_1 R_1) + 1", abs(cost - (Q + 1)) < 1e-12
    yield "tr(Q_1 R_1) alone is less", cost - Q > 0.5


def cascade_scales() -> Facts:
    """LQG for G over norm(B) norm(C) of its cascade: u, a strictly proper block, proper blocks.

    Each block is the real form [a 1; c a] or the pole itself, b = e_n, balanced so that norm(b) =
    norm(c) for what stands beside the direct 1. The blocks are those of the text's factors.
    """
    q_8, q_9 = np.array([1, -1.8, 0.97]), np.array([1, -1.4, 0.98])
    cases = (
        ("4.2", 28.96, 5e-3, [([1, -0.5], [1, -1.62, 0.81])], [([1, -1.92, 1.44], [1, -1.9, 0.9])]),
        ("4.3", 1.072, 1e-3, [([1], [1, -0.5])], [([1, -1.7, 0.785], q_8), ([1, -1.4, 0.85], q_9)]),
        ("6.1", 1.4798, 5e-5, [([1, -1.1], [1, -1.9, 1])], [([1, -0.8], [1, -0.5])]),
        ("6.2", 1.7252, 5e-5, [([1], [1, -0.85])], [([1, -1.52, 0.9025], [1, -1.8, 1])]),
    )
    for example, printed, half, first, others in cases:
        n_s, *n = [_size(*block) for block in (*first, *others)]
        gain = float(1 / np.sqrt(n_s * (n_s + sum(n))))
        plant = _plant([*first, *others], gain)
        noise = {"d": 1.0} if example == "4.3" else None
        cost = lqg_controller(plant, noise=noise).cost.value
        words = f"LQG of {example} costs {printed} for {gain:.5f} G"
        yield words, abs(cost - printed) <= half


def _size(numerator: list[float], denominator: list[float]) -> float:
    """The norm of c of a block with b = e_n, compared with its direct term."""
    a = np.asarray(denominator, dtype=float)
    rest = np.concatenate([np.zeros(len(a) - len(numerator)), numerator]) - a * (
        len(numerator) == len(a)
    )
    if len(a) == 2:
        return abs(float(rest[1]))
    corner = 0.9 if np.allclose(a, [1, -1.9, 0.9]) else -a[1] / 2  # a real pair of poles: (1,1)
    return float(np.hypot(rest[1], rest[2] + corner * rest[1]))


def _plant(blocks: list[tuple[list[float], list[float]]], gain: float) -> Plant:
    factors = [
        f"({'+'.join(f'({c!r})*q**{len(p) - 1 - i}' for i, c in enumerate(map(float, p)))})"
        for block in blocks
        for p in block
    ]
    tops, bottoms = "*".join(factors[::2]), "*".join(factors[1::2])
    G = f"{gain!r}*{tops}/({bottoms})"
    return servo_plant(G) if len(blocks) == 3 else standard_plant(G)


def labels() -> Facts:
    """The subjects of the examples of those numbers, and their figures."""
    title, source = (
        {n: str(example_table(n)[key]) for n in ("4.2", "4.6", "A.2")}
        for key in ("title", "source")
    )
    yield "an internal model of a disturbance is that of 4.2", "Biased" in title["4.2"]
    yield (
        "Figure 4.10 is of 4.6, which places poles",
        ("4.10" in source["4.6"] and "Pole placement" in title["4.6"]),
    )
    yield "Figure A.2 is of A.2", "figure A.2" in source["A.2"]


def sensor_noise() -> Facts:
    """V_2 in units in which d has variance 1."""
    d, v = Fraction("0.05"), Fraction("0.025")
    yield "(sigma_v/sigma_d)^2 = 0.25", (v / d) ** 2 == Fraction(1, 4)
    yield "0.025 [1 0 -1][1 0 -1]' = 0.05 holds a deviation and counts r", v * 2 == Fraction("0.05")
    yield "with the variance and v alone it would be 0.000625", v**2 == Fraction("0.000625")
