"""What an estimator leaves behind, and what every estimator can be asked."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.values import Value
from rcac_numeric.experiments.estimation.true_systems import TrueSystem


@dataclass(frozen=True, eq=False)
class EstimatedRun(Value):
    """An estimate over the steps of one seed.

    Attributes
    ----------
    estimate, truth : arrays, shape (steps,)
    z : array, shape (steps, l_z)
        C x^ - y of RCMR, the innovation of a filter, r - C_r x of a loop.
    left : float
        Of RCMR: the share of the initial estimate that is left in theta at the end, 1 where the
        data say nothing, 0 where they say all.
    outcome : {"completed", "diverged"}
        A run that diverged holds what came before.
    """

    estimate: Array
    truth: Array
    z: Array
    left: float = math.nan
    outcome: str = "completed"


@dataclass(frozen=True, eq=False)
class Estimation(Value, ABC):
    """An estimator with its settings, as an experiment has it."""

    @property
    @abstractmethod
    def words(self) -> str:
        """What it is, in a word or two."""

    @abstractmethod
    def execute(self, system: TrueSystem, steps: int, seed: int) -> EstimatedRun:
        """Estimate with the record, or in the loop, of one seed."""
