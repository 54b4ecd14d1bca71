"""Prepared runs: checked, compiled, with arrays; and their results."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import FunctionFailedError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import instance_of, integer, number, real_array, signal_array
from rcac_numeric.compiled import _kernel
from rcac_numeric.compiled._callbacks import Failures
from rcac_numeric.compiled._controllers import fitted_denominator
from rcac_numeric.compiled._plants import initial_state
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._supervision import SupervisionRecord
from rcac_numeric.engine._changes import AppliedChange, ControllerChange
from rcac_numeric.engine._compatibility import OneController
from rcac_numeric.engine._learner import DataDrivenLearner, LearningLoop, Restorable
from rcac_numeric.engine._live_control import apply_change
from rcac_numeric.engine._loops import PreparedLoop
from rcac_numeric.engine._runs import OUTCOMES, Run
from rcac_numeric.engine._states import SavedState, saved_state
from rcac_numeric.engine._stepwise import StepwiseLoop
from rcac_numeric.plants._any_plant import AnyPlant

# A signal this many times larger than all inputs has no correct digit of them in float64.
NO_DIGIT_LEFT = 1e15


class PreparedRun:
    """The compiled job of a run and its output arrays; arguments as for `simulate`."""

    def __init__(
        self,
        loop: PreparedLoop,
        w: ArrayLike,
        *,
        x_0: ArrayLike | None = None,
        stride: int = 1,
        divergence_limit: float | None = None,
        start: SavedState | None = None,
        into: tuple[Array, Array, Array] | None = None,
    ) -> None:
        """`into` are preallocated arrays for u, y and z, with as many rows as w."""
        self.prepared, self.plant, self.settings = loop, loop.plant, loop.settings
        plant = loop.plant
        # A copy: a frozen twin needs it after the caller changes the array.
        self.x_0 = None if x_0 is None else real_array(x_0, "x_0").reshape(-1)
        self._failures = Failures()
        self.changes: list[AppliedChange] = []
        self.w, peak = _read(w, plant)
        self.stride = integer(stride, "stride", at_least=1)
        self._before = 0.0 if start is None else saved_state(start, "start").scale
        self._scale = scale_of(max(self._before, peak), self.x_0)
        self.divergence_limit = divergence_limit_of(divergence_limit, self._scale)
        self.learner: DataDrivenLearner | None = None
        self._into = into
        self.first_step, self._is_ready, self._start = 0, False, start
        # Errors are raised before anything runs; a loop of data needs only the check of x_0.
        if start is not None or not loop.is_data:
            self.make_ready()
        elif self.x_0 is not None:
            initial_state(self.x_0, plant.n)

    @property
    def kind(self) -> tuple[int, int]:
        """Key of runs that can share a SIMD batch, and an estimate of their cost."""
        return self.prepared.width, self.plant.n

    def make_ready(self) -> None:
        """Create the loop, its job and the arrays on first use."""
        if self._is_ready:
            return
        self._is_ready = True
        loop, plant, saturation = self.prepared, self.plant, self.prepared.saturation
        self._loop = loop.started(self.x_0, self.divergence_limit, self._failures)
        self._kernels = [] if isinstance(self._loop, StepwiseLoop) else self._loop.controllers
        if loop.learns:
            self.learner = _learner(loop.controllers)
        whole = self._loop if self.learner is None else LearningLoop(self._loop, self.learner)
        self._whole: Restorable = whole
        if self.learner is not None:
            self._kernels[0].freeze(True)  # frozen until the first target model
        if self._start is not None:
            self._continue(self._start)
        steps, empty = len(self.w), np.empty
        if self._into is None:
            self.u, self.y = empty((steps, plant.l_u)), empty((steps, plant.l_y))
            self.z = empty((steps, plant.l_z))
        else:
            self.u, self.y, self.z = self._into
        self.u_applied = self.u if saturation is None else np.empty_like(self.u)
        # theta of a fixed controller is constant: it is stored once.
        stride = self.stride if loop.adapts else max(steps, 1)
        width = loop.width or self._loop.theta_before().size
        self._theta = empty((-(-steps // stride), width))
        applied = None if saturation is None else self.u_applied
        outputs = self.y, self.z, self._theta, stride
        self.job: _kernel.Job | StepwiseLoop
        if isinstance(self._loop, StepwiseLoop):
            self.job = self._loop.job(self.w, self.u, *outputs)
        else:
            self.job = _kernel.Job(self._loop, self.w, self.u, applied, *outputs)
        self._hold, self._learnt, self._looked_at = steps, 0, -1

    def _continue(self, start: SavedState) -> None:
        if self.x_0 is not None:
            raise InputError("give either x_0 or start: the saved state holds the plant's state.")
        if isinstance(self._loop, StepwiseLoop) and not self._loop.resumes:
            raise InputError(
                "a schedule with state_map or delay cannot be continued with a stepwise "
                "controller: run it in one piece."
            )
        saved_state(start, "start").restored(
            "loop", self.prepared.name,
            save=self._whole.save, restore=self._whole.restore, steps=lambda: self._k,
        )  # fmt: skip
        self.first_step = start.k

    @property
    def _k(self) -> int:
        return self._loop.k if isinstance(self._loop, StepwiseLoop) else self._kernels[0].k

    def hold(self, row: int) -> None:
        """Limit the job to a number of rows."""
        self.make_ready()
        self._hold = row
        self._pause()

    def _pause(self) -> None:
        stop, k = self._hold, self.first_step + self.job.done
        if self.learner is not None:
            stop = min(stop, self.learner.next_look(k) - self.first_step)
        self.job.pause_at(max(stop, self.job.done))

    def proceed(self) -> bool:
        """Learn and update the target at a pause of the job; return whether steps remain."""
        if self.learner is None or self.job.outcome != 0:
            return False
        self._learn(self.learner)
        if self.job.done >= self._hold:
            return False
        k = self.first_step + self.job.done
        if self.learner.is_due(k) and self._looked_at != k:
            self._looked_at = k
            if (change := self.learner.look(self._kernels[0].theta)) is not None:
                self.change(*change)
                self._kernels[0].freeze(False)
        self._pause()
        return True

    def _learn(self, learner: DataDrivenLearner) -> None:
        new, self._learnt = slice(self._learnt, self.job.done), self.job.done
        first, width = self.prepared.command
        r = self.w[new, first : first + width]
        learner.take(self.u_applied[new], self.z[new], self.y[new], r)

    @property
    def has_ended(self) -> bool:
        """Whether every step is done, or one failed."""
        return self.job.outcome != 0 or self.job.done == len(self.w)

    def change(self, change: ControllerChange, evidence: str = "") -> AppliedChange:
        """Apply a change to the controller between two steps."""
        (settings,), (kernel,) = self.prepared.controllers, self._kernels
        settings = instance_of(settings, "settings", ControllerSettings)
        self.changes.append(apply_change(kernel, settings, change, evidence))
        return self.changes[-1]

    def result(self, interrupted: bool = False, with_state: bool = True) -> Run:
        """Return the run so far, with the state for a continuation.

        A function of the user that failed is an outcome, "plant failed" or "weight failed", and
        `Run.failure` says how. Where the job was interrupted in a function of the user, or in a
        step that is Python, its state is in the middle of a step, and none is handed out.
        """
        self.make_ready()
        done, outcome, failures = self.job.done, self.job.outcome, self._failures
        if self.learner is not None and outcome == 0:
            self._learn(self.learner)
        # The kernel reports a user function interrupted by Ctrl-C as failed.
        in_function = (
            failures.guards_something
            and OUTCOMES[outcome] in ("plant failed", "overflow")
            and failures.error is None
        )
        is_done = done == len(self.w)
        stopped = interrupted and not is_done and (outcome == 0 or in_function)
        state = None
        if with_state and outcome == 0 and self._is_whole(stopped):
            scale = self._scale if is_done else scale_of(self._before, self.w[:done], self.x_0)
            values, k = self._whole.save(), self.first_step + done
            state = SavedState.of_values("loop", k, values, self.prepared.name, scale)
        guards, first, reflections, resets, bounded = self._counts
        signals = self.w, self.u, self.y, self.z, self.u_applied
        w, u, y, z, u_applied = signals if is_done else (signal[:done] for signal in signals)
        return Run(
            plant=self.plant,
            settings=self.settings,
            w=w,
            u=u,
            y=y,
            z=z,
            theta=self._recorded_theta(done),
            theta_final=self._last(outcome),
            stride=self.stride,
            outcome="interrupted" if stopped else self._name_of(outcome),
            guard_count=guards,
            guard_first_step=first,
            u_applied=u_applied,
            reflections=reflections,
            resets=resets,
            bounded=bounded,
            first_step=self.first_step,
            state=state,
            saturation=self.prepared.saturation,
            x_0=self.x_0,
            divergence_limit=self.divergence_limit,
            failure=failures.words or self._failure_of_controller,
            changes=tuple(self.changes),
            D_f=self._fitted(outcome),
            supervision=self._noted(),
        )

    @property
    def ending(self) -> tuple[int, str, int, Array, str]:
        """Return steps, outcome, guards, final theta and failure of a completed run."""
        outcome = self.job.outcome
        failure = self._failures.words
        return self.job.done, self._name_of(outcome), self._counts[0], self._last(outcome), failure

    def require_no_failure(self, run: Run) -> None:
        """Raise if a user function failed; the error has the run so far."""
        if self._failures.error is not None:
            raise FunctionFailedError(
                "a function of the plant or of a weight failed at step "
                f"{self.first_step + run.steps}: {run.failure} The steps before are in the "
                "attribute run of this error.",
                run=run,
            ) from self._failures.error

    @property
    def _counts(self) -> tuple[int, int, int, int, int]:
        """Return the counts of guards, reflections, resets and bounds, and the first guard step."""
        return (0, -1, 0, 0, 0) if isinstance(self._loop, StepwiseLoop) else self._loop.counts

    def _is_whole(self, stopped: bool) -> bool:
        """Whether the state is complete and between two steps."""
        if isinstance(self._loop, StepwiseLoop):
            return self._loop.resumes and not self._loop.in_step
        return not (stopped and self._failures.guards_something)

    @property
    def _failure_of_controller(self) -> str:
        return self._loop.failure if isinstance(self._loop, StepwiseLoop) else ""

    def _name_of(self, outcome: int) -> str:
        if OUTCOMES[outcome] == "overflow" and self._failures.error is not None:
            return "weight failed"  # the kernel received NaN instead
        return OUTCOMES[outcome]

    def _recorded_theta(self, done: int) -> Array:
        rows = -(-done // self.stride)
        return self._theta[:rows] if self.prepared.adapts else np.zeros((rows, 0))

    def _fitted(self, outcome: int) -> Array | None:
        """Return the D_f of theta_final; None after a failed step."""
        if outcome != 0 or not isinstance(self.settings, ControllerSettings):
            return None
        return fitted_denominator(self.settings, self._kernels[0])

    def _noted(self) -> SupervisionRecord | None:
        """Return the supervision record of a single adaptive controller, else None."""
        if not isinstance(self.settings, ControllerSettings):
            return None
        return SupervisionRecord.of(self._kernels[0].troubles)

    def _last(self, outcome: int) -> Array:
        if not self.prepared.adapts:
            return np.zeros(0)
        if outcome == 0 and self._kernels:
            parts = [kernel.theta for kernel in self._kernels]
            return parts[0] if len(parts) == 1 else np.concatenate(parts)
        return self._loop.theta_before()


def _learner(controllers: tuple[OneController, ...]) -> DataDrivenLearner | None:
    """Return the learner of a single controller with DataDriven, else None."""
    adaptive = [one for one in controllers if isinstance(one, ControllerSettings)]
    learning = [one.learning for one in adaptive if one.learning is not None]
    if learning and len(controllers) > 1:
        raise InputError("DataDriven learns u -> z for one controller; several would act on z.")
    return DataDrivenLearner(learning[0], adaptive[0].structure) if learning else None


def _read(w: ArrayLike, plant: AnyPlant) -> tuple[Array, float]:
    """Return w as an array, and its largest entry, which proves that w is finite."""
    if type(w) is np.ndarray and w.dtype == np.float64 and w.shape[1:] == (plant.l_w,):
        w_array = np.array(w, order="C")
        if (peak := scale_of(0.0, w_array)) < np.inf:
            w_array.setflags(write=False)
            return w_array, peak
    w_array = signal_array(w, "w", plant.l_w, blocks=plant.blocks)
    return w_array, scale_of(0.0, w_array)


def scale_of(before: float, *from_outside: Array | None) -> float:
    """Return the largest entry of w and x_0 in this run and in those that it continues."""
    for values in from_outside:
        if values is not None:
            before = np.maximum.reduce(np.abs(values), axis=None, initial=before)
    return float(before)


def divergence_limit_of(limit: float | None, scale: float) -> float:
    """Return the magnitude at which a loop counts as diverged."""
    if limit is None:
        return NO_DIGIT_LEFT * max(1.0, scale)
    limit = number(limit, "divergence_limit")
    if limit <= 0:
        raise InputError(f"divergence_limit = {limit} must be positive.")
    return limit


# Seconds between two checks for Ctrl-C.
CHUNK = 0.05


class RunInterrupted(KeyboardInterrupt):
    """Ctrl-C during a run; a subclass of KeyboardInterrupt.

    Attributes
    ----------
    runs : tuple of Run
        What had been computed, in the order of the cases. Those that were stopped have the
        outcome "interrupted"; `simulate` goes on from their `state`, where they have one.
    """

    def __init__(self, runs: Sequence[Run]) -> None:
        self.runs = tuple(runs)
        steps = ", ".join(str(run.steps) for run in self.runs[:3])
        more = f" and {len(self.runs) - 3} more" if len(self.runs) > 3 else ""
        super().__init__(f"interrupted after {steps}{more} steps; they are in the attribute runs")

    @property
    def run(self) -> Run:
        """The first run; the only one of `simulate`."""
        return self.runs[0]


def run_to_end(prepared: Sequence[PreparedRun], threads: int = 1, lanes: bool = False) -> None:
    """Run every job to its end."""
    for _ in in_slices(prepared, threads, lanes):
        pass


def in_slices(
    prepared: Sequence[PreparedRun], threads: int = 1, lanes: bool = False, keep: bool = True
) -> Iterator[None]:
    """Run every job to its end; yield after each slice of time and at the end."""
    for one in prepared:
        one.make_ready()
    jobs = [one.job for one in prepared if isinstance(one.job, _kernel.Job)]
    stepwise = [one.job for one in prepared if isinstance(one.job, StepwiseLoop)]
    learning = [one for one in prepared if one.learner is not None]
    go_on = True
    for one in learning:
        one.proceed()
    while go_on:
        try:
            go_on = _kernel.run_jobs(jobs, threads, CHUNK, lanes)
            go_on = sum(job.go_on(CHUNK) for job in stepwise) > 0 or go_on
            go_on = sum(one.proceed() for one in learning) > 0 or go_on  # proceeds in all jobs
        except KeyboardInterrupt:
            if not keep:
                raise
            raise RunInterrupted([one.result(interrupted=True) for one in prepared]) from None
        yield
