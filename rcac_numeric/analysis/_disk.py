"""Disk margins and sensitivity peaks, from H-infinity norms without a frequency grid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from compensator_theory import figures
from compensator_theory.errors import InputError
from rcac_numeric.analysis._closed_loop import OTHER_SIGN, ClosedLoop
from rcac_numeric.analysis._loop_analysis import closed_loop
from rcac_numeric.analysis._opened_loop import OpenedLoop
from rcac_numeric.analysis._peaks import Matrices, hinf_norm, level_crossings, response_of
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import one_of
from rcac_numeric.arrays._values import Result
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.engine._runs import Run
from rcac_numeric.plants._any_plant import AnyPlant

# Exponents of the Schatten norms that lead to the largest singular value, the last to 1e-7 of it.
EXPONENTS = (8, 64, 512, 4096, 2**15, 2**18, 2**22)
# Relative distance of the bound to the largest value found, and what it may grow to if a bound at
# every frequency needs more than that many scalings.
CLOSE, WIDER, SCALINGS = 1e-8, 10.0, 60


def structured_peak(system: Matrices) -> tuple[float, float]:
    """Return an upper bound of mu over the unit circle for complex diagonal factors.

    At each frequency mu(M) <= min over D of the largest singular value of D M D^{-1}, D diagonal
    and positive, with equality for up to three channels; it is the same in all units. A scaling
    that is best at one frequency bounds mu at all of them, and the frequencies where it exceeds
    a level are found as eigenvalues on the unit circle: more scalings are added where none stays
    below, until none is needed. So the bound holds at every frequency, not on a grid.
    """
    A = system[0]
    omega = np.linspace(0, np.pi, 17) if len(A) else np.zeros(1)
    if len(A):
        omega = np.unique(np.concatenate([omega, np.abs(np.angle(np.linalg.eigvals(A)))]))
    best, where, scalings = 0.0, 0.0, []

    def peak_at(at: float) -> float:
        nonlocal best, where
        peak, scaling = best_scaling(response_of(system, at))
        scalings.append(scaling)
        if peak > best:
            best, where = peak, at
        return peak

    values = [peak_at(float(at)) for at in omega]
    if best == 0 or not len(A):
        return best, where
    i = int(np.argmax(values))
    low, high = omega[max(i - 1, 0)], omega[min(i + 1, len(omega) - 1)]
    from scipy.optimize import minimize_scalar  # imported here: it takes 0.17 s

    minimize_scalar(
        lambda at: -peak_at(float(at)),
        bounds=(low, high),
        method="bounded",
        options={"xatol": 1e-9},
    )
    scalings = [best_scaling(response_of(system, where))[1]]
    close = CLOSE
    while True:
        level = best * (1 + close)
        open_ = [(0.0, float(np.pi))]
        for scaling in scalings:
            open_ = _overlap(open_, _above(system, scaling, level))
        if not open_:
            return level, where
        if len(scalings) >= SCALINGS:
            close *= WIDER
            continue
        widest = max(open_, key=lambda part: part[1] - part[0])
        peak_at((widest[0] + widest[1]) / 2)


def best_scaling(M: ComplexArray) -> tuple[float, Array]:
    """Minimise the largest singular value of D M D^{-1} over positive diagonal D; return log D too.

    Convex in log D. From Osborne's balancing, which is the least Frobenius norm, by BFGS on
    Schatten norms of growing exponent, which are smooth.
    """
    from scipy.optimize import minimize

    logs = _balanced(M)
    best = (_largest(M, logs), logs)
    if len(M) > 1:
        for exponent in EXPONENTS:
            optimum = minimize(
                _schatten(M, exponent), logs[1:], jac=True, method="BFGS",
                options={"gtol": 1e-10, "maxiter": 100},
            )  # fmt: skip
            logs = np.concatenate([[0.0], optimum.x])
            best = min(best, (_largest(M, logs), logs), key=lambda pair: pair[0])
    return best


def _schatten(M: ComplexArray, exponent: int) -> Callable[[Array], tuple[float, Array]]:
    def log_norm(x: Array) -> tuple[float, Array]:
        left, values, right = np.linalg.svd(_scaled(M, np.concatenate([[0.0], x])))
        if values[0] == 0:
            return -np.inf, np.zeros(len(x))
        shares = (values / values[0]) ** exponent
        total = float(shares.sum())
        slope = (np.abs(left) ** 2 @ shares - np.abs(right.T) ** 2 @ shares) / total
        return float(np.log(values[0]) + np.log(total) / exponent), np.asarray(slope[1:])

    return log_norm


def _balanced(M: ComplexArray) -> Array:
    """Return log D that balances D M D^{-1} off the diagonal, by Osborne's sweeps."""
    squares = np.abs(M) ** 2
    np.fill_diagonal(squares, 0.0)
    logs = np.zeros(len(M))
    for _ in range(30):
        before = logs.copy()
        for i in range(len(M)):
            column, row = (
                squares[:, i] @ np.exp(2 * (logs - logs[i])),
                squares[i] @ np.exp(2 * (logs[i] - logs)),
            )
            if column > 0 and row > 0:
                logs[i] += np.log(column / row) / 4
        if np.abs(logs - before).max(initial=0.0) < 1e-3:
            break
    return np.asarray(logs - logs[0])


def _scaled(M: ComplexArray, logs: Array) -> ComplexArray:
    D = np.exp(np.clip(logs - logs.mean(), -200, 200))
    return np.asarray(D[:, None] * M / D)


def _largest(M: ComplexArray, logs: Array) -> float:
    return float(np.linalg.norm(_scaled(M, logs), 2))


def _above(system: Matrices, logs: Array, level: float) -> list[tuple[float, float]]:
    """Return the frequency intervals where a singular value exceeds the level for this scaling."""
    D = np.exp(np.clip(logs - logs.mean(), -200, 200))
    A, B, C, direct = system
    scaled: Matrices = (A, B / D, D[:, None] * C, D[:, None] * direct / D)
    ends = np.concatenate([[0.0], level_crossings(scaled, level), [np.pi]])
    return [
        (float(a), float(b))
        for a, b in pairwise(ends)
        if b > a and np.linalg.norm(response_of(scaled, (a + b) / 2), 2) > level
    ]


def _overlap(
    first: list[tuple[float, float]], second: list[tuple[float, float]]
) -> list[tuple[float, float]]:
    both = [(max(a, c), min(b, d)) for a, b in first for c, d in second]
    return [(low, high) for low, high in both if low < high]


@dataclass(frozen=True, eq=False)
class DiskMargin(Result):
    """The symmetric disk margin, based on S - T (sigma = 0), and the peaks of S and T.

    Every factor (1 + d/2) / (1 - d/2) with complex abs(d) < alpha, and every factor of a gain and
    a phase in it, leaves the loop stable; where there are several channels, an own one in each.

    Attributes
    ----------
    alpha : float
        2 / max mu(S - T). mu is the structured singular value for one complex factor in each
        channel, by its upper bound min over D of the largest singular value of D (S - T) D^{-1},
        D diagonal. So the margin is guaranteed; for up to three channels the bound is mu itself,
        and the margin exact. The units of the channels do not matter.
    frequency : float
        Where the maximum is, rad/sample.
    S_peak, T_peak : float
        The largest singular values of S = (1 + L)^{-1} and T = L S over frequency; for several
        channels in their units.
    S_frequency, T_frequency : float
        Where these are, rad/sample.
    radius_at : float
        For one channel: the spectral radius of the loop with the factor that ends the margin.
        1 verifies it. NaN for several channels.
    """

    alpha: float
    frequency: float
    S_peak: float
    S_frequency: float
    T_peak: float
    T_frequency: float
    radius_at: float

    @property
    def gain(self) -> tuple[float, float]:
        """The range of gains of the disk: (2 - alpha) / (2 + alpha) and its inverse."""
        if self.alpha >= 2:
            return 0.0, float("inf")
        return (2 - self.alpha) / (2 + self.alpha), (2 + self.alpha) / (2 - self.alpha)

    @property
    def phase(self) -> float:
        """The phase margin of the disk in degrees, in both directions: 2 arctan(alpha / 2)."""
        return float(np.degrees(2 * np.arctan(self.alpha / 2)))

    def plot(self, **options: Any) -> figures.Figure:
        """Plot the simultaneous gain and phase changes; options `ax` and `width`."""
        from rcac_numeric.plots._margins import plot_disk_margin

        return plot_disk_margin(self, **options)

    def __str__(self) -> str:
        low, high = self.gain
        return (
            f"alpha {self.alpha:.6g} at {self.frequency:.6g} rad/sample: "
            f"gain {low:.4g} to {high:.4g}, phase {self.phase:.4g} deg; "
            f"peaks of S {self.S_peak:.4g}, of T {self.T_peak:.4g}"
        )


def disk_margin_of(loop: OpenedLoop) -> DiskMargin:
    """Return the disk margin of a stable scalar loop."""
    return _disk_margin((loop.A, loop.B, loop.C, loop.D), loop)


def multivariable_disk_margin(
    loop: ClosedLoop | Run | tuple[AnyPlant, Compensator], *, at: str = "u"
) -> DiskMargin:
    """Return the disk margin for simultaneous, independent factors in every channel of u or y.

    Parameters
    ----------
    loop : Run, ClosedLoop, or pair of a plant and a Compensator
    at : {"u", "y"}

    Raises
    ------
    InputError
        Where the loop is not stable: then it has no margin.

    Notes
    -----
    Source: P. Seiler, A. Packard and P. Gahinet, IEEE Control Systems 40(5) (2020) 78-95.

    Examples
    --------
    >>> from rcac_numeric import ClosedLoop, Compensator, Plant, multivariable_disk_margin
    >>> two = Plant(A=[[2, 0], [0, 0.5]], B=[[1, 0], [0, 1]], D_1=[[1], [1]], C=[[1, 0], [0, 1]])
    >>> gains = Compensator(past_u=[[[0, 0], [0, 0]]], past_y=[[[-2, 0], [0, 0]], [[0, 0], [0, 0]]])
    >>> round(multivariable_disk_margin(ClosedLoop(two, gains)).alpha, 6)   # L = 2/(q - 2)
    0.4
    """
    loop = closed_loop(loop)
    if not loop.is_stable:
        raise InputError(
            f"the loop is unstable, spectral radius {loop.spectral_radius:.6g}: it has no margins."
            f"{OTHER_SIGN * loop.has_stable_opposite}"
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
    # S = (I + L)^{-1} is the response from a signal added after L to the fed-back signal.
    inverse: Array = np.asarray(np.linalg.inv(one + D), dtype=np.float64)
    S: Matrices = (A - B @ inverse @ C, B @ inverse, -inverse @ C, inverse)
    T: Matrices = (S[0], S[1], -S[2], one - inverse)
    difference: Matrices = (S[0], S[1], 2 * S[2], 2 * inverse - one)
    if scalar is None:
        peak, omega = structured_peak(difference)
    else:
        peak, omega = hinf_norm(difference, response=_by_sensitivity(scalar, -1, 2))
    radius = float("nan")
    if scalar is not None and peak > 0:
        value = scalar.response(omega)[0]
        S_minus_T = (1 - value) / (1 + value) if np.isfinite(value) else -1.0  # at a pole of L
        # 1 + f L = 0 with f = (1 + d/2)/(1 - d/2) means d = 2/(S - T)
        if abs(S_minus_T - 1) > 1e-100:  # else L is below rounding: every factor is allowed
            factor = (S_minus_T + 1) / (S_minus_T - 1)
            radius = scalar.radius(factor)
    return DiskMargin(
        2 / peak if peak > 0 else float("inf"),
        omega,
        *hinf_norm(S, response=_by_sensitivity(scalar, 0, 1)),
        *hinf_norm(T, response=_by_sensitivity(scalar, 1, -1)),
        radius,
    )


def _by_sensitivity(
    loop: OpenedLoop | None, constant: int, factor: int
) -> Callable[[Array], ComplexArray] | None:
    """Return the evaluator of constant + factor S without delay states; None without a delay."""
    if loop is None or not loop.undelayed[0]:
        return None
    return lambda omega: constant + factor / (1 + loop.response(omega))
