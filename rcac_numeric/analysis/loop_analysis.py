"""What a fixed controller does to a plant, beside a target model: each analysis once, on demand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.analysis.closed_loop import ClosedLoop
from rcac_numeric.analysis.exact_comparison import ExactComparison, compare_exactly
from rcac_numeric.analysis.match import IntercalatedMatch, intercalated_match
from rcac_numeric.analysis.residual_split import ResidualSplit, split_residual
from rcac_numeric.arrays.array_types import Array, ComplexArray
from rcac_numeric.arrays.validation import signal_array
from rcac_numeric.arrays.values import Value
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.plants.frozen import measuring_command
from rcac_numeric.plants.linear import Plant
from rcac_numeric.targets.model import TargetModel

Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class LoopAnalysis(Value):
    """A plant with a fixed controller, held against a target model.

    Parameters
    ----------
    plant : Plant
    compensator : Compensator
        It reads y, or [y; r].
    target : TargetModel, optional
        Without it there is nothing to compare with: `comparison`, `match` and `split` raise.

    Examples
    --------
    >>> from rcac_numeric import Compensator, fir_target, standard_plant
    >>> from rcac_numeric.analysis.loop_analysis import LoopAnalysis, attempted
    >>> plant = standard_plant("1/(q - 2)")
    >>> compensator = Compensator(past_u=[[[-2.0]]], past_y=[[[0.0]], [[-4.0]]])
    >>> analysis = LoopAnalysis(plant, compensator, fir_target(plant))
    >>> analysis.comparison.worst_distance, analysis.match.worst < 1e-12
    (0.0, True)
    >>> attempted(lambda: LoopAnalysis(plant, compensator).match)
    (None, 'the target model is not known')
    """

    plant: Plant
    compensator: Compensator
    target: TargetModel | None = None

    @property
    def reads_command(self) -> bool:
        """Whether the controller reads the command r beside y."""
        return self.compensator.l_y > self.plant.l_y

    @cached_property
    def obstacle(self) -> str:
        """Why the exact comparison does not apply; empty where it does."""
        plant = self.plant
        sizes = {"l_u": self.compensator.l_u, "l_y": plant.l_y, "l_z": plant.l_z}
        if set(sizes.values()) != {1}:
            words = ", ".join(f"{name} = {size}" for name, size in sizes.items())
            return f"it is for scalar signals, and the plant has {words}"
        if self.reads_command:
            return "it is for a controller that reads y alone, and this one reads the command too"
        return ""

    @cached_property
    def loop(self) -> ClosedLoop:
        """The closed loop, whose measurement is what the controller reads."""
        plant = measuring_command(self.plant) if self.reads_command else self.plant
        return ClosedLoop(plant, self.compensator)

    @cached_property
    def comparison(self) -> ExactComparison:
        """The controller beside the exact prediction."""
        if self.obstacle:
            raise InputError(f"there is no exact comparison here: {self.obstacle}.")
        return compare_exactly(self.plant, self.compensator, self._target)

    @cached_property
    def zeros(self) -> dict[str, ComplexArray]:
        """Closed-loop zeros from each channel of w to z; exact where the comparison is."""
        if self.target is not None and not self.obstacle:
            found, _ = attempted(lambda: self.comparison.zeros)
            if found is not None:
                return dict(found)
        return dict(self.loop.zeros())

    @cached_property
    def match(self) -> IntercalatedMatch:
        """The intercalated transfer function beside G_f."""
        return intercalated_match(self.loop, self._target)

    def split(
        self, *, u: ArrayLike, y: ArrayLike, z: ArrayLike, w: ArrayLike, r: ArrayLike | None = None
    ) -> ResidualSplit:
        """The retrospective residual of recorded signals, which begin at rest, split for it.

        Where the controller reads the command, r is its record; by default the one that w holds.
        """
        plant, inputs = self.loop.plant, signal_array(y, "y", self.plant.l_y)
        driven = signal_array(w, "w", plant.l_w)
        if self.reads_command:
            own = self.plant.l_y
            read = driven @ plant.D_2[own:].T if r is None else np.asarray(r, dtype=np.float64)
            inputs = np.hstack([inputs, read])
        return split_residual(
            plant, self.compensator, self._target,
            u=_signal(u), y=inputs, z=_signal(z), w=driven,
        )  # fmt: skip

    @property
    def _target(self) -> TargetModel:
        if self.target is None:
            raise InputError("the target model is not known.")
        sizes = (self.target.l_z, self.target.l_u)
        if sizes != (self.plant.l_z, self.plant.l_u):
            raise InputError(
                f"the target model is {sizes[0]} x {sizes[1]}; the plant's G_zu is "
                f"{self.plant.l_z} x {self.plant.l_u}."
            )
        return self.target


def attempted(analysis: Callable[[], Result]) -> tuple[Result | None, str]:
    """An analysis, or None and why there is none."""
    try:
        return analysis(), ""
    except CompensatorError as error:
        return None, str(error).rstrip(".")


def _signal(values: ArrayLike) -> Array:
    array = np.asarray(values, dtype=np.float64)
    return array.reshape(-1, 1) if array.ndim == 1 else array
