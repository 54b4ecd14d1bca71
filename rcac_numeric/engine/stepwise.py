"""The closed loop of a controller whose steps are Python, with the plant of the kernel."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import (
    CompensatorError,
    DivergedError,
    FunctionFailedError,
    InputError,
)
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import instance_of, integer, real_array, signal_array
from rcac_numeric.arrays.values import fingerprint
from rcac_numeric.controllers.stepwise import StepwiseController
from rcac_numeric.engine.compatibility import command_position, require_stepwise_fits
from rcac_numeric.engine.compiled.callbacks import Failures
from rcac_numeric.engine.compiled.plants import compiled_plant, initial_state
from rcac_numeric.engine.interruption import RunInterrupted
from rcac_numeric.engine.jobs import divergence_limit_of, scale_of
from rcac_numeric.engine.runs import Run
from rcac_numeric.engine.states import SavedState, saved_state
from rcac_numeric.plants.any_plant import AnyPlant
from rcac_numeric.plants.saturation import Saturation
from rcac_numeric.plants.schedules import PlantSchedule


class StepwiseLoop:
    """A plant, a stepwise controller and where they are; arguments as for `simulate`."""

    def __init__(
        self,
        plant: AnyPlant,
        settings: StepwiseController,
        w: ArrayLike,
        *,
        x_0: ArrayLike | None = None,
        stride: int = 1,
        divergence_limit: float | None = None,
        saturation: Saturation | None = None,
        start: SavedState | None = None,
    ) -> None:
        instance_of(settings, "settings", StepwiseController)
        if saturation is not None:
            raise InputError(
                f"a {type(settings).__name__} is run without saturation: the model that it "
                "identifies would not know which part of u was applied. Leave saturation out."
            )
        self.plant, self.settings = plant, settings
        self.x_0 = None if x_0 is None else real_array(x_0, "x_0").reshape(-1)
        self._failures = Failures()
        self._body = compiled_plant(plant, self.x_0, self._failures)
        self.w = signal_array(w, "w", plant.l_w)
        self.stride = integer(stride, "stride", at_least=1)
        self._before = 0.0 if start is None else saved_state(start, "start").scale
        scale = scale_of(self._before, self.w, self.x_0)
        self.limit = divergence_limit_of(divergence_limit, scale)
        require_stepwise_fits(plant, settings)
        self._r = command_position(plant, settings.l_r)
        self._controller = settings.started()
        self._name = fingerprint((plant, settings))
        if start is not None:
            self._continue(start)
        self.first_step = self._controller.k
        steps = len(self.w)
        self.u, self.y, self.z = (np.empty((steps, n)) for n in (plant.l_u, plant.l_y, plant.l_z))
        self.theta = np.empty((-(-steps // self.stride), settings.l_theta))
        self._last = self._controller.theta.copy()
        self.done, self.outcome, self.failure = 0, "completed", ""

    def _continue(self, start: SavedState) -> None:
        if self.x_0 is not None:
            raise InputError("give either x_0 or start: the saved state holds the plant's state.")
        if not _resumes(self.plant):
            raise InputError(
                "a schedule with state_map or delay is not continued with a stepwise controller: "
                "run it whole."
            )
        saved_state(start, "start").restored(
            "loop", self._name,
            save=self._save, restore=self._restore, steps=lambda: self._controller.k,
        )  # fmt: skip

    def _save(self) -> Array:
        """The controller's numbers and the plant's state."""
        return np.concatenate([self._controller.save(), self._body.x])

    def _restore(self, values: Array) -> None:
        n = self.plant.n
        self._controller.take_up(values[: len(values) - n])
        x = initial_state(values[len(values) - n :], n)
        self._body = compiled_plant(self.plant, x, self._failures)

    def run(self) -> Run:
        """Run it to its end.

        Raises
        ------
        RunInterrupted
            On Ctrl-C; its run ends with the last whole step, and goes on from its state where the
            step itself was not torn.
        """
        whole = True
        try:
            while self.done < len(self.w) and self.outcome == "completed":
                whole = False
                self._step(self.done)
                whole = True
        except KeyboardInterrupt:
            self.outcome = "interrupted"
            raise RunInterrupted([self.result(whole)]) from None
        return self.result(whole=self.outcome == "completed")

    def _step(self, row: int) -> None:
        k, w = self.first_step + row, self.w[row]
        works, y, _ = self._body.output(k, np.zeros(self.plant.l_u), w)
        if not works:
            return self._end("plant failed")
        try:
            u = self._controller.step(y, w[self._r : self._r + self.settings.l_r])
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
        self.u[row], self.y[row], self.z[row] = u, y, z
        if row % self.stride == 0:
            self.theta[row // self.stride] = theta
        self._last = theta.copy()
        self.done = row + 1
        return None

    def _is_small(self, *values: Array) -> bool:
        return all(bool((np.abs(value) <= self.limit).all()) for value in values)

    def _end(self, outcome: str, failure: str = "") -> None:
        self.outcome, self.failure = outcome, failure or self._failures.words

    def result(self, whole: bool) -> Run:
        """What was done so far; `whole` where it can go on from there."""
        done, state = self.done, None
        if whole and _resumes(self.plant):
            k = self.first_step + done
            scale = scale_of(self._before, self.w[: self.done], self.x_0)
            state = SavedState.taken("loop", k, self._save(), self._name, scale)
        return Run(
            plant=self.plant,
            settings=self.settings,
            w=self.w[:done],
            u=self.u[:done],
            y=self.y[:done],
            z=self.z[:done],
            theta=self.theta[: -(-done // self.stride)],
            theta_final=self._last,
            stride=self.stride,
            outcome=self.outcome,
            guard_count=0,
            guard_first_step=-1,
            u_applied=self.u[:done],
            first_step=self.first_step,
            state=state,
            x_0=self.x_0,
            divergence_limit=self.limit,
            failure=self.failure,
        )

    def require_no_failure(self, run: Run) -> None:
        """Raise where a function of the plant failed; the run so far goes with the error."""
        if self._failures.error is not None:
            raise FunctionFailedError(
                f"a function of the plant failed at step {self.first_step + run.steps}: "
                f"{run.failure} The steps before are in the attribute run of this error.",
                run,
            ) from self._failures.error


def _resumes(plant: AnyPlant) -> bool:
    """Whether x(k) and k are all of the plant's state."""
    if not isinstance(plant, PlantSchedule):
        return True
    return not any(c.delay or c.state_map is not None for c in plant.changes)
