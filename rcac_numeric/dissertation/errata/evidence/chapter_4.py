"""Chapter 4 as it is printed: costs of LQG and noise intensities."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np
from scipy.linalg import solve_discrete_lyapunov

from rcac_numeric.h2.lqg import lqg
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.problems import standard_plant

Facts = Iterator[tuple[str, bool]]
G_2 = "(q - 0.5)*(q**2 - 1.92*q + 1.44)/((q - 1)*(q - 0.9)*(q**2 - 1.62*q + 0.81))"
G_3 = (
    "(q**2 - 1.7*q + 0.785)*(q**2 - 1.4*q + 0.85)"
    "/((q - 0.5)*(q**2 - 1.8*q + 0.97)*(q**2 - 1.4*q + 0.98))"
)
A_4 = [
    [0.9, 1, 0, 0, 0],
    [0, 0.95, -0.1507, -0.1674, 0.5189],
    [0, 0, 0.65, 1, 0],
    [0, 0, -0.4225, 0.65, 0.434],
    [0, 0, 0, 0, 0.95],
]
B_4 = [[0], [0], [0], [0], [1]]
C_4 = [[0.1596, 0.3991, -0.2405, -0.2672, 0.8283]]


def cross_term() -> Facts:
    """x(k+1) = x/2 + u + w, u = x_c, x_c(k+1) = x/4, z = x + u: the terms of E z^2."""
    A = np.array([[0.5, 1.0], [0.25, 0.0]])
    Q = solve_discrete_lyapunov(A, np.diag([1.0, 0.0]))
    cost = np.array([1.0, 1.0]) @ Q @ np.array([1.0, 1.0])
    printed = Q[0, 0] + Q[1, 1]
    yield "tr(Q_1 R_1) + tr(Q_2 C_c'R_2 C_c) is not the cost", abs(printed - cost) > 0.1
    yield "with 2 tr(R_12 C_c Q_12') it is", abs(printed + 2 * Q[0, 1] - cost) < 1e-12


def direct_term() -> Facts:
    """x(k+1) = x/2 + d, z = x + v: the variance of z beside tr(Q_1 R_1)."""
    Q = 1 / (1 - 0.5**2)
    response = np.array([1.0, *0.5 ** np.arange(60)])  # of z to v, then to d
    cost = float((response**2).sum())
    yield "the mean square of z is tr(Q_1 R_1) + 1", abs(cost - (Q + 1)) < 1e-12
    yield "tr(Q_1 R_1) alone is less", cost - Q > 0.5


def cost_of_example_4_2() -> Facts:
    """The LQG cost of (4.29), and that of the scaled plant."""
    cost = lqg(standard_plant(G_2)).cost.value
    scaled = 0.60864 * cost  # z = y, and G_zw scales by the factor's root
    yield "the LQG cost of (4.29) is 47.57", round(cost, 2) == 47.57
    yield "that of sqrt(0.60864) G is 28.96, as printed", abs(scaled - 28.96) < 0.01


def cost_of_example_4_3() -> Facts:
    """The LQG cost of (4.30), and the least that a strictly proper controller can reach."""
    plant = standard_plant(G_3)
    cost = lqg(plant).cost.value
    first = float((plant.C @ plant.D_1)[0, 0])
    second = float((plant.C @ plant.A @ plant.D_1)[0, 0])
    yield (
        "no control comes before two steps: J >= 1 + 0.6^2",
        np.allclose([first, second], [1, 0.6]),
    )
    yield "LQG attains 1.36", abs(cost - 1.36) < 1e-6
    yield "1.072 is that of sqrt(0.78869) G", abs(0.78869 * cost - 1.0726) < 1e-4


def independent_noises() -> Facts:
    """The LQG cost of Example 4.4 with two noises, and with one for both."""
    B = np.array(B_4, dtype=float)
    zero = np.zeros((5, 1))
    two = Plant(A=A_4, B=B_4, D_1=np.hstack([B, zero]), C=C_4, D_2=[[0, 1]], E_1=C_4, E_0=[[0, 0]])
    one = Plant(A=A_4, B=B_4, D_1=B, C=C_4, D_2=[[1]], E_1=C_4, E_0=[[0]])
    yield "independent d and v give the printed 2.5437", abs(lqg(two).cost.value - 2.5437) < 3e-4
    yield "one signal for both gives 0.686", abs(lqg(one).cost.value - 0.686) < 1e-3


def sensor_noise() -> Facts:
    """V_2 in units in which d has variance 1."""
    d, v = Fraction("0.05"), Fraction("0.025")
    yield "(sigma_v/sigma_d)^2 = 0.25", (v / d) ** 2 == Fraction(1, 4)
    yield "0.025 [1 0 -1][1 0 -1]' = 0.05 holds a deviation and counts r", v * 2 == Fraction("0.05")
    yield "with the variance and v alone it would be 0.000625", v**2 == Fraction("0.000625")
