"""Runs of controllers with Python steps on a compiled plant."""

from __future__ import annotations

from time import monotonic

import numpy as np

from compensator_theory.errors import CompensatorError, DivergedError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.compiled import _kernel
from rcac_numeric.compiled._callbacks import Failures
from rcac_numeric.compiled._plants import compiled_plant, initial_state
from rcac_numeric.controllers._stepwise import StepwiseController, stepper_of
from rcac_numeric.engine._runs import OUTCOMES
from rcac_numeric.identification import _predictive_cost  # noqa: F401  # registers its steps
from rcac_numeric.plants._any_plant import AnyPlant
from rcac_numeric.plants._schedules import PlantSchedule


class StepwiseLoop:
    """Python replacement of `_kernel.Loop` and `_kernel.Job` for one run."""

    def __init__(
        self,
        plant: AnyPlant,
        settings: StepwiseController,
        body: _kernel.Plant,
        failures: Failures,
        limit: float,
        r_in_w: int,
    ) -> None:
        self._plant, self._body, self._failures = plant, body, failures
        self._controller, self._limit = stepper_of(settings), limit
        self._r = slice(r_in_w, r_in_w + settings.l_r)
        self._last = self._controller.theta.copy()
        self.done, self.outcome, self.failure = 0, 0, ""
        self.in_step = False  # stays set if the step is interrupted

    @property
    def k(self) -> int:
        """Number of completed steps, those before a saved state included."""
        return self._controller.k

    @property
    def resumes(self) -> bool:
        """Whether x(k) and k are all of the plant's state."""
        plant = self._plant
        return not isinstance(plant, PlantSchedule) or not any(
            change.delay or change.state_map is not None for change in plant.changes
        )

    def save(self) -> Array:
        """The controller's numbers and the plant's state."""
        return np.concatenate([self._controller.save(), self._body.x])

    def restore(self, values: Array) -> None:
        """Restore the state that `save` returned."""
        n = self._plant.n
        self._controller.take_up(values[: len(values) - n])
        x = initial_state(values[len(values) - n :], n)
        self._body = compiled_plant(self._plant, x, self._failures)
        self._last = self._controller.theta.copy()

    def theta_before(self) -> Array:
        """Theta after the last completed step."""
        return self._last

    def job(
        self, w: Array, u: Array, y: Array, z: Array, theta: Array, stride: int
    ) -> StepwiseLoop:
        """The loop, which reads w and writes the signals of each step."""
        self._w, self._u, self._y, self._z = w, u, y, z
        self._theta, self._stride = theta, stride
        self._stop = len(w)
        return self

    def pause_at(self, step: int) -> None:
        """Pause at this row of w."""
        self._stop = step

    def go_on(self, seconds: float) -> bool:
        """Run for about this many seconds; return whether steps remain."""
        end = monotonic() + seconds
        while (left := self.outcome == 0 and self.done < self._stop) and monotonic() < end:
            self.in_step = True
            self._step(self.done)
            self.in_step = False
        return left

    def _step(self, row: int) -> None:
        k, w = self._controller.k, self._w[row]
        works, y, _ = self._body.output(k, np.zeros(self._plant.l_u), w)
        if not works:
            return self._end("plant failed")
        try:
            u = self._controller.step(y, w[self._r])
        except DivergedError as error:
            return self._end("overflow", str(error))
        except CompensatorError as error:
            if np.isfinite(y).all():
                raise
            return self._end("plant not finite", str(error))
        works, y, z = self._body.output(k, u, w)
        theta = self._controller.theta
        if not self._is_small(u, y, z, theta):
            return self._end("diverged")
        if not (works and self._body.advance(k, u, w)):
            return self._end("plant failed")
        if not self._is_small(self._body.x):
            return self._end("diverged")
        self._u[row], self._y[row], self._z[row] = u, y, z
        if row % self._stride == 0:
            self._theta[row // self._stride] = theta
        self._last = theta.copy()
        self.done = row + 1
        return None

    def _is_small(self, *values: Array) -> bool:
        return all(bool((np.abs(value) <= self._limit).all()) for value in values)

    def _end(self, outcome: str, failure: str = "") -> None:
        self.outcome, self.failure = OUTCOMES.index(outcome), failure
