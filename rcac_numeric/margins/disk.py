"""Disk margins and the peaks of sensitivity, from H-infinity norms that are found, not sampled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from compensator_theory import figures
from compensator_theory.errors import InputError
from rcac_numeric.analysis.closed_loop import ClosedLoop
from rcac_numeric.analysis.loop_analysis import closed_loop
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.showing import picture_of
from rcac_numeric.arrays.validation import one_of
from rcac_numeric.arrays.values import Value
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.engine.runs import Run
from rcac_numeric.margins.opened_loop import OpenedLoop
from rcac_numeric.margins.peaks import Matrices, hinf_norm
from rcac_numeric.margins.structured import structured_peak
from rcac_numeric.plants.any_plant import AnyPlant


@dataclass(frozen=True, eq=False)
class DiskMargin(Value):
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
    omega : float
        Where the maximum is, rad/sample.
    S_peak, T_peak : float
        The largest singular values of S = (1 + L)^{-1} and T = L S over frequency; for several
        channels in their units.
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

    def plot(self, **options: Any) -> figures.Figure:
        """The gains and turns of phase that may change together; options `ax` and `width`."""
        return picture_of(self, **options)

    def __str__(self) -> str:
        low, high = self.gain
        return (
            f"alpha {self.alpha:.6g} at {self.omega:.6g} rad/sample: gain {low:.4g} to {high:.4g}, "
            f"phase {self.phase:.4g} deg; peaks of S {self.S_peak:.4g}, of T {self.T_peak:.4g}"
        )


def disk_margin_of(loop: OpenedLoop) -> DiskMargin:
    """The disk margin of a stable scalar loop."""
    return _disk_margin((loop.A, loop.B, loop.C, loop.D), loop)


def multivariable_disk_margin(
    loop: ClosedLoop | Run | tuple[AnyPlant, Compensator], *, at: str = "u"
) -> DiskMargin:
    """The disk margin against simultaneous, independent factors in every channel of u or of y.

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
    peak, omega = hinf_norm(difference) if scalar is not None else structured_peak(difference)
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
