"""The intercalated transfer function beside the target model, over frequency."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from compensator_theory import figures
from rcac_numeric.analysis.closed_loop import ClosedLoop
from rcac_numeric.arrays.array_types import Array, ComplexArray
from rcac_numeric.arrays.showing import picture_of
from rcac_numeric.arrays.validation import integer
from rcac_numeric.arrays.values import Value
from rcac_numeric.targets.model import TargetModel


@dataclass(frozen=True, eq=False)
class IntercalatedMatch(Value):
    """How far the intercalated transfer function is from the target model, over frequency.

    Attributes
    ----------
    omega : array
        Frequencies, rad/sample.
    reached, wanted : arrays, shape (len(omega), l_z, l_u)
        The intercalated transfer function and G_f.
    """

    omega: Array
    reached: ComplexArray
    wanted: ComplexArray

    @property
    def error(self) -> Array:
        """Distance at each frequency, relative to G_f there (Frobenius norms)."""
        norms = np.linalg.norm(self.wanted, axis=(1, 2))
        difference = np.linalg.norm(self.reached - self.wanted, axis=(1, 2))
        return np.asarray(difference / np.maximum(norms, np.finfo(float).tiny))

    @property
    def worst(self) -> float:
        """Largest relative distance."""
        return float(self.error.max())

    @property
    def median(self) -> float:
        """Median relative distance."""
        return float(np.median(self.error))

    def plot(self) -> figures.Figure:
        """Gain and phase of both, on one branch."""
        return picture_of(self)

    def __repr__(self) -> str:
        return f"IntercalatedMatch(worst={self.worst:.3g}, median={self.median:.3g})"


def intercalated_match(
    loop: ClosedLoop, target: TargetModel, points: int = 1000
) -> IntercalatedMatch:
    """Compare the intercalated transfer function (4.16) with G_f on a grid in (0, pi).

    Parameters
    ----------
    loop : ClosedLoop
    target : TargetModel
    points : int
        Number of frequencies, in the middles of as many equal parts of (0, pi).

    Examples
    --------
    >>> from rcac_numeric import (
    ...     ClosedLoop, Compensator, fir_target, intercalated_match, standard_plant)
    >>> plant = standard_plant("1/(q - 2)")
    >>> loop = ClosedLoop(plant, Compensator(past_u=[[[-2.0]]], past_y=[[[0.0]], [[-4.0]]]))
    >>> intercalated_match(loop, fir_target(plant)).worst < 1e-12  # both poles at zero: 1/q
    True
    """
    integer(points, "points", at_least=1)
    omega = (np.arange(points) + 0.5) * np.pi / points
    return IntercalatedMatch(
        omega, loop.intercalated_response(omega), target.frequency_response(omega)
    )
