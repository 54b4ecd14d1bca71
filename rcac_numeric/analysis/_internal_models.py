"""Convergence of the coefficients, and internal models of the controller."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rcac_numeric.analysis._closed_loop import ClosedLoop
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._values import Value
from rcac_numeric.controllers._compensator import Compensator

# A controller pole this close to the unit circle counts as an internal model.
NEAR = 1e-2
# theta has converged if its relative change in the last tenth is below this.
CONVERGED = 1e-3


@dataclass(frozen=True)
class Drift:
    """The change of the coefficients in the last tenth of a log.

    Attributes
    ----------
    start : int
        The first step of that part: the last tenth.
    relative : float
        Largest change of a coefficient from there to the end, over the largest coefficient.
    """

    start: int
    relative: float

    @property
    def is_converged(self) -> bool:
        """Whether that is at most 1e-3."""
        return self.relative <= CONVERGED

    def __str__(self) -> str:
        verdict = "has converged" if self.is_converged else "is STILL MOVING"
        moved = f"relative change {self.relative:.2g} from step {self.start} on"
        return f"theta {verdict}: {moved}"


@dataclass(frozen=True, eq=False)
class InternalModel(Value):
    """A controller pole on or near the unit circle.

    Attributes
    ----------
    pole : complex
        With nonnegative imaginary part.
    omega : float
        Its angle, rad/sample.
    gains : mapping from channel of w to float
        abs(G_zw) of the closed loop at omega: the attenuation of a signal of that frequency. Empty
        without a plant and for an unstable loop.
    """

    pole: complex
    omega: float
    gains: dict[str, float]

    @property
    def distance(self) -> float:
        """Distance of the pole from the unit circle, positive inside."""
        return 1 - abs(self.pole)

    @property
    def rejects(self) -> str:
        """The rejected signals, as text."""
        if self.omega < NEAR:
            return "constant signals"
        if self.omega > np.pi - NEAR:
            return "signals that alternate in sign"
        return (
            f"harmonics of {self.omega:.4g} rad/sample, period {2 * np.pi / self.omega:.4g} steps"
        )


def drift_of(theta: Array) -> Drift:
    """Return the drift of coefficients logged at every step; shape (steps, l_theta)."""
    start = len(theta) - max(len(theta) // 10, min(len(theta), 2))
    moved = float(np.abs(theta[start:] - theta[-1]).max())
    size = float(np.abs(theta[-1]).max())
    return Drift(start, moved / size if size else (0.0 if not moved else np.inf))


def internal_models(compensator: Compensator, loop: ClosedLoop | None) -> tuple[InternalModel, ...]:
    """Return the controller poles within 0.01 of the unit circle, by frequency."""
    poles = compensator.poles()
    near = poles[(np.abs(np.abs(poles) - 1) <= NEAR) & (poles.imag >= 0)]
    models = []
    for pole in sorted(near, key=lambda p: float(np.angle(p))):
        omega = float(np.angle(pole))
        gains: dict[str, float] = {}
        if loop is not None and loop.is_stable:
            response = np.linalg.norm(loop.frequency_response([omega])[0], axis=0)
            gains = dict(zip(loop.plant.channels, map(float, response), strict=True))
        models.append(InternalModel(complex(pole), omega, gains))
    return tuple(models)
