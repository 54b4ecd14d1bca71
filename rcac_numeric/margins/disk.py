"""Disk margins and the peaks of sensitivity, from H-infinity norms that are found, not sampled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.analysis.closed_loop import ClosedLoop
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import instance_of, one_of
from rcac_numeric.arrays.values import Value
from rcac_numeric.margins.opened_loop import OpenedLoop

Matrices = tuple[Array, Array, Array, Array]
# A response below this is not refined: divided by it, the matrices of its level set leave float64.
SMALLEST = 1e-150


@dataclass(frozen=True, eq=False)
class DiskMargin(Value):
    """The symmetric disk margin, based on S - T (sigma = 0), and the peaks of S and T.

    Every factor (1 + d/2) / (1 - d/2) with complex abs(d) < alpha, and every factor of a gain and
    a phase in it, leaves the loop stable; where there are several channels, an own one in each.

    Attributes
    ----------
    alpha : float
        2 / max abs(S - T), the largest singular value for several channels. For one channel the
        margin is exact; for several it is guaranteed, for it allows more than diagonal factors.
    omega : float
        Where the maximum is, rad/sample.
    S_peak, T_peak : float
        The largest singular values of S = (1 + L)^{-1} and T = L S over frequency.
    S_omega, T_omega : float
    radius_at : float
        For one channel: the spectral radius of the loop with the factor that ends the margin.
        1 verifies it. NaN for several channels.
    """

    alpha: float
    omega: float
    S_peak: float
    S_omega: float
    T_peak: float
    T_omega: float
    radius_at: float

    @property
    def gain(self) -> tuple[float, float]:
        """The range of gains in the disk: (2 - alpha) / (2 + alpha) and its inverse."""
        if self.alpha >= 2:
            return 0.0, float("inf")
        return (2 - self.alpha) / (2 + self.alpha), (2 + self.alpha) / (2 - self.alpha)

    @property
    def phase(self) -> float:
        """The turn, in degrees, in both directions: 2 arctan(alpha / 2)."""
        return float(np.degrees(2 * np.arctan(self.alpha / 2)))

    def __str__(self) -> str:
        low, high = self.gain
        return (
            f"alpha {self.alpha:.6g} at {self.omega:.6g} rad/sample: gain {low:.4g} to {high:.4g}, "
            f"phase {self.phase:.4g} deg; peaks of S {self.S_peak:.4g}, of T {self.T_peak:.4g}"
        )


def disk_margin_of(loop: OpenedLoop) -> DiskMargin:
    """The disk margin of a stable scalar loop."""
    return _disk_margin((loop.A, loop.B, loop.C, loop.D), loop)


def multivariable_disk_margin(loop: ClosedLoop, *, at: str = "u") -> DiskMargin:
    """The disk margin against simultaneous, independent factors in every channel of u or of y.

    Parameters
    ----------
    loop : ClosedLoop
    at : {"u", "y"}

    Raises
    ------
    InputError
        Where the loop is not stable: then it has no margin.

    Examples
    --------
    >>> from rcac_numeric import ClosedLoop, Compensator, Plant, multivariable_disk_margin
    >>> two = Plant(A=[[2, 0], [0, 0.5]], B=[[1, 0], [0, 1]], D_1=[[1], [1]], C=[[1, 0], [0, 1]])
    >>> gains = Compensator(past_u=[[[0, 0], [0, 0]]], past_y=[[[-2, 0], [0, 0]], [[0, 0], [0, 0]]])
    >>> round(multivariable_disk_margin(ClosedLoop(two, gains)).alpha, 9)   # L = 2/(q - 2)
    0.4
    """
    if not instance_of(loop, "loop", ClosedLoop).is_stable:
        raise InputError(
            f"the loop is unstable, spectral radius {loop.spectral_radius:.6g}: it has no margins."
        )
    plant, controller = loop.plant, loop.compensator.state_space()
    one_of(at, "at", ("u", "y"))
    first: Matrices = (plant.A, plant.B, plant.C, plant.D_0)
    second: Matrices = controller
    if at == "y":
        first, second = second, first
    A_1, B_1, C_1, D_1 = first
    A_2, B_2, C_2, D_2 = second
    A = np.block([[A_1, np.zeros((len(A_1), len(A_2)))], [B_2 @ C_1, A_2]])
    B = np.vstack([B_1, B_2 @ D_1])
    return _disk_margin((A, B, -np.hstack([D_2 @ C_1, C_2]), -D_2 @ D_1), None)


def _disk_margin(L: Matrices, scalar: OpenedLoop | None) -> DiskMargin:
    A, B, C, D = L
    one = np.eye(len(D))
    # S is the response from a signal added after L to what is fed back: (I + L)^{-1}.
    inverse: Array = np.asarray(np.linalg.inv(one + D), dtype=np.float64)
    S: Matrices = (A - B @ inverse @ C, B @ inverse, -inverse @ C, inverse)
    T: Matrices = (S[0], S[1], -S[2], one - inverse)
    difference: Matrices = (S[0], S[1], 2 * S[2], 2 * inverse - one)
    peak, omega = hinf_norm(difference)
    radius = float("nan")
    if scalar is not None and peak > 0:
        value = scalar.response(omega)[0]
        S_minus_T = (1 - value) / (1 + value) if np.isfinite(value) else -1.0  # at a pole of L
        # 1 + f L = 0 with f = (1 + d/2)/(1 - d/2) means d = 2/(S - T)
        if abs(S_minus_T - 1) > 1e-100:  # else L is too small for any factor to matter
            factor = (S_minus_T + 1) / (S_minus_T - 1)
            radius = scalar.radius(factor)
    return DiskMargin(
        2 / peak if peak > 0 else float("inf"), omega, *hinf_norm(S), *hinf_norm(T), radius
    )


def hinf_norm(system: Matrices, rtol: float = 1e-10) -> tuple[float, float]:
    """The largest singular value of a stable system over the unit circle, and where it is.

    The level-set method of Bruinsma and Steinbuch: the frequencies at which a singular value
    equals a level are eigenvalues of a symplectic pencil on the unit circle; the level is raised
    to the best value at the midpoints between them until there is none.

    Returns
    -------
    (norm, omega in rad/sample)
    """
    A, B, C, D = system
    n, m, p = len(A), B.shape[1], len(C)

    def value(omega: float) -> float:
        response: np.ndarray = D.astype(np.complex128)
        if n:
            response = response + C @ np.linalg.solve(np.exp(1j * omega) * np.eye(n) - A, B)
        return float(np.linalg.norm(response, 2))

    starts = [0.0, np.pi, *np.abs(np.angle(np.linalg.eigvals(A)))] if n else [0.0]
    best, where = max((value(w), float(w)) for w in starts)
    for _ in range(60):
        if not n or best < SMALLEST:
            break
        level = best * (1 + rtol)
        crossings = _level_crossings(system, level, n, m, p)
        ends = np.concatenate([[0.0], crossings, [np.pi]])
        middles = (ends[1:] + ends[:-1]) / 2
        higher, at = max((value(w), float(w)) for w in middles)
        if higher <= level:
            break
        best, where = higher, at
    return _refined(value, best, where)


def _level_crossings(system: Matrices, level: float, n: int, m: int, p: int) -> Array:
    """The omega in [0, pi] at which a singular value equals `level`."""
    from scipy.linalg import eigvals

    A, B, C, D = (np.asarray(part) for part in system)
    B, D = B / level, D / level
    # z x = A x + B v, lambda = z A' lambda + C' y, y = C x + D v, v = z B' lambda + D' y
    left = np.block([
        [A, np.zeros((n, n)), B, np.zeros((n, p))],
        [np.zeros((n, n)), np.eye(n), np.zeros((n, m)), -C.T],
        [np.zeros((m, 2 * n)), np.eye(m), -D.T],
        [C, np.zeros((p, n)), D, -np.eye(p)],
    ])  # fmt: skip
    right = np.zeros_like(left)
    right[:n, :n] = np.eye(n)
    right[n : 2 * n, n : 2 * n] = A.T
    right[2 * n : 2 * n + m, n : 2 * n] = B.T
    values = eigvals(left, right)
    values = values[np.isfinite(values)]
    # Near a maximum two crossings merge and rounding moves them off the circle by sqrt(eps).
    return np.unique(np.abs(np.angle(values[np.abs(np.abs(values) - 1) < 1e-5])))


def _refined(value: Callable[[float], float], best: float, where: float) -> tuple[float, float]:
    """The top of the peak that the level sets have isolated."""
    from scipy.optimize import minimize_scalar

    width = 1e-4
    low, high = max(where - width, 0.0), min(where + width, np.pi)
    found = minimize_scalar(
        lambda w: -value(w),
        bounds=(low, high),
        method="bounded",
        options={"xatol": 1e-12},
    )
    return (-float(found.fun), float(found.x)) if -found.fun > best else (best, where)
