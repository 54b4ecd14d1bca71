"""A run that is ready to start: checked, compiled, with its arrays; and what it leaves behind."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import FunctionFailedError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import instance_of, integer, number, real_array, signal_array
from rcac_numeric.arrays._values import fingerprint
from rcac_numeric.compiled import _kernel
from rcac_numeric.compiled._callbacks import Failures
from rcac_numeric.compiled._controllers import compiled_controller, fitted_denominator
from rcac_numeric.compiled._plants import compiled_plant
from rcac_numeric.controllers._decentralized import Decentralized
from rcac_numeric.controllers._recursive import RecursiveLeastSquares
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._stepwise import StepwiseController
from rcac_numeric.controllers._supervision import Supervision, SupervisionRecord
from rcac_numeric.engine._changes import AppliedChange, ControllerChange
from rcac_numeric.engine._compatibility import (
    AnyController,
    OneController,
    command_position,
    controllers_of,
    require_fit,
)
from rcac_numeric.engine._learner import DataDrivenLearner, LearningLoop, Restorable
from rcac_numeric.engine._live_control import apply_change
from rcac_numeric.engine._runs import OUTCOMES, Run
from rcac_numeric.engine._states import SavedState, saved_state
from rcac_numeric.engine._stepwise import StepwiseLoop
from rcac_numeric.plants._any_plant import AnyPlant
from rcac_numeric.plants._saturation import Saturation

# A signal so many times larger than all that comes from outside holds no digit of it in float64.
NO_DIGIT_LEFT = 1e15


class PreparedRun:
    """The compiled job of a run, and the arrays that it writes; arguments as for `simulate`."""

    def __init__(
        self,
        plant: AnyPlant,
        settings: AnyController,
        w: ArrayLike,
        *,
        x_0: ArrayLike | None = None,
        stride: int = 1,
        divergence_limit: float | None = None,
        saturation: Saturation | None = None,
        start: SavedState | None = None,
        supervision: Supervision | None = None,
    ) -> None:
        # A copy: a frozen twin starts from it, whatever becomes of the caller's array.
        self.x_0 = None if x_0 is None else real_array(x_0, "x_0").reshape(-1)
        self._failures = Failures()
        self.changes: list[AppliedChange] = []
        body = compiled_plant(plant, self.x_0, self._failures)
        self._controllers = _compiled_controllers(settings, saturation, supervision)
        if saturation is not None:
            instance_of(saturation, "saturation", Saturation)
        if supervision is not None:
            instance_of(supervision, "supervision", Supervision)
        self.plant, self.settings, self.saturation = plant, settings, saturation
        self.supervision = None if supervision == Supervision() else supervision
        self.w = signal_array(w, "w", plant.l_w, blocks=plant.blocks)
        require_fit(plant, settings)
        self.stride = integer(stride, "stride", at_least=1)
        self._before = 0.0 if start is None else saved_state(start, "start").scale
        self.divergence_limit = divergence_limit_of(
            divergence_limit, scale_of(self._before, self.w, self.x_0)
        )
        self._kernels = [
            compiled_controller(one, plant.l_z, self._failures, supervision=self.supervision)
            for one in self._controllers
        ]
        parts = self._controllers or (settings,)
        l_r = max(one.l_r for one in parts)
        self._command = command_position(plant, l_r), l_r
        self._loop = self._loop_of(body)
        self.learner = _learner(self._controllers)
        whole = self._loop if self.learner is None else LearningLoop(self._loop, self.learner)
        self._whole: Restorable = whole
        if self.learner is not None:
            self._kernels[0].freeze(True)  # until there is a target model
        self.first_step = 0
        if start is not None:
            self._continue(start)
        steps = len(self.w)
        self.u, self.y, self.z = (np.empty((steps, n)) for n in (plant.l_u, plant.l_y, plant.l_z))
        self.u_applied = self.u if saturation is None else np.empty_like(self.u)
        # What the kernel calls theta of a fixed controller never changes: it is kept once.
        self._adapts = any(one.l_theta for one in parts)
        kept_every = self.stride if self._adapts else max(steps, 1)
        self._theta = np.empty((-(-steps // kept_every), self._loop.theta_before().size))
        applied = None if saturation is None else self.u_applied
        outputs = self.y, self.z, self._theta, kept_every
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
                "a schedule with state_map or delay is not continued with a stepwise controller: "
                "run it whole."
            )
        saved_state(start, "start").restored(
            "loop", self._name,
            save=self._whole.save, restore=self._whole.restore, steps=lambda: self._k,
        )  # fmt: skip
        self.first_step = start.k

    @property
    def _k(self) -> int:
        return self._loop.k if isinstance(self._loop, StepwiseLoop) else self._kernels[0].k

    def hold(self, row: int) -> None:
        """Let the job go no further than so many rows."""
        self._hold = row
        self._pause()

    def _pause(self) -> None:
        stop, k = self._hold, self.first_step + self.job.done
        if self.learner is not None:
            stop = min(stop, self.learner.next_look(k) - self.first_step)
        self.job.pause_at(max(stop, self.job.done))

    def proceed(self) -> bool:
        """Where the job stands still: learn, look, and say whether there is more to do."""
        if self.learner is None or self.job.outcome != 0:
            return False
        self._learn(self.learner)
        if self.job.done >= self._hold:
            return False
        k = self.first_step + self.job.done
        if self.learner.is_due(k) and self._looked_at != k:
            self._looked_at = k
            if (asked := self.learner.look(self._kernels[0].theta)) is not None:
                self.change(*asked)
                self._kernels[0].freeze(False)
        self._pause()
        return True

    def _learn(self, learner: DataDrivenLearner) -> None:
        new, self._learnt = slice(self._learnt, self.job.done), self.job.done
        first, width = self._command
        r = self.w[new, first : first + width]
        learner.take(self.u_applied[new], self.z[new], self.y[new], r)

    @cached_property
    def _name(self) -> str:
        """What a state of this loop is recognised by."""
        parts = (self.plant, self.settings, self.saturation)
        if isinstance(self._loop, StepwiseLoop):
            return fingerprint(parts[:2])
        return fingerprint(parts if self.supervision is None else (*parts, self.supervision))

    @property
    def has_ended(self) -> bool:
        """Whether every step is done, or one failed."""
        return self.job.outcome != 0 or self.job.done == len(self.w)

    def change(self, change: ControllerChange, evidence: str = "") -> AppliedChange:
        """Change the one controller between two steps."""
        (settings,), (kernel,) = self._controllers, self._kernels
        settings = instance_of(settings, "settings", ControllerSettings)
        self.changes.append(apply_change(kernel, settings, change, evidence))
        return self.changes[-1]

    def result(self, interrupted: bool = False, with_state: bool = True) -> Run:
        """What the job has done so far, as a run; with the state that it can go on from.

        A function of the user that failed is an outcome, "plant failed" or "weight failed", and
        `Run.failure` says how. Where the job was interrupted in a function of the user, or in a
        step that is Python, its state is in the middle of a step, and none is handed out.
        """
        done, outcome, kernels = self.job.done, self.job.outcome, self._kernels
        if self.learner is not None and outcome == 0:
            self._learn(self.learner)
        # A function in which the key was pressed looks to the kernel like one that failed.
        in_function = (
            OUTCOMES[outcome] in ("plant failed", "overflow")
            and self._failures.guards_something
            and self._failures.error is None
        )
        stopped = interrupted and done < len(self.w) and (outcome == 0 or in_function)
        state = None
        if with_state and outcome == 0 and self._is_whole(stopped):
            scale = scale_of(self._before, self.w[:done], self.x_0)
            values, k = self._whole.save(), self.first_step + done
            state = SavedState.taken("loop", k, values, self._name, scale)
        return Run(
            plant=self.plant,
            settings=self.settings,
            w=self.w[:done],
            u=self.u[:done],
            y=self.y[:done],
            z=self.z[:done],
            theta=self._kept(done),
            theta_final=self._last(outcome),
            stride=self.stride,
            outcome="interrupted" if stopped else self._name_of(outcome),
            guard_count=sum(kernel.guard_count for kernel in kernels),
            guard_first_step=min(
                (k.guard_first_step for k in kernels if k.guard_first_step >= 0), default=-1
            ),
            u_applied=self.u_applied[:done],
            reflections=sum(kernel.reflections for kernel in kernels),
            resets=sum(kernel.resets for kernel in kernels),
            bounded=sum(kernel.bounded for kernel in kernels),
            first_step=self.first_step,
            state=state,
            saturation=self.saturation,
            x_0=self.x_0,
            divergence_limit=self.divergence_limit,
            failure=self._failures.words or self._failure_of_controller,
            changes=tuple(self.changes),
            D_f=self._fitted(outcome),
            supervision=self._noted(),
        )

    def require_no_failure(self, run: Run) -> None:
        """Raise where a function of the user failed; the run so far goes with the error."""
        if self._failures.error is not None:
            raise FunctionFailedError(
                "a function of the plant or of a weight failed at step "
                f"{self.first_step + run.steps}: {run.failure} The steps before are in the "
                "attribute run of this error.",
                run,
            ) from self._failures.error

    def _is_whole(self, stopped: bool) -> bool:
        """Whether a state is that between two steps, and all that later steps depend on."""
        if isinstance(self._loop, StepwiseLoop):
            return self._loop.resumes and not self._loop.in_step
        return not (stopped and self._failures.guards_something)

    @property
    def _failure_of_controller(self) -> str:
        return self._loop.failure if isinstance(self._loop, StepwiseLoop) else ""

    def _name_of(self, outcome: int) -> str:
        if OUTCOMES[outcome] == "overflow" and self._failures.error is not None:
            return "weight failed"  # the kernel was handed a NaN in its place
        return OUTCOMES[outcome]

    def _kept(self, done: int) -> Array:
        rows = -(-done // self.stride)
        return self._theta[:rows] if self._adapts else np.zeros((rows, 0))

    def _fitted(self, outcome: int) -> Array | None:
        """D_f that belongs to theta_final; None where a step failed half-way."""
        if outcome != 0 or not isinstance(self.settings, ControllerSettings):
            return None
        return fitted_denominator(self.settings, self._kernels[0])

    def _noted(self) -> SupervisionRecord | None:
        """What was noted of the one adaptive controller; None of others."""
        if not isinstance(self.settings, ControllerSettings):
            return None
        return SupervisionRecord.of(self._kernels[0].troubles)

    def _last(self, outcome: int) -> Array:
        if not self._adapts:
            return np.zeros(0)
        if outcome == 0 and self._kernels:
            return np.concatenate([kernel.theta for kernel in self._kernels])
        return self._loop.theta_before()

    def _loop_of(self, body: _kernel.Plant) -> _kernel.Loop | StepwiseLoop:
        plant, settings, saturation = self.plant, self.settings, self.saturation
        limit, r_in_w = self.divergence_limit, self._command[0]
        if isinstance(settings, StepwiseController):
            return StepwiseLoop(plant, settings, body, self._failures, limit, r_in_w)
        no_bounds = (np.zeros(0), np.zeros(0), np.zeros(0))
        low, high, rate = no_bounds if saturation is None else saturation.bounds(plant.l_u)
        shared = settings.shared_u if isinstance(settings, Decentralized) else True
        if saturation is not None and not shared and len(self._controllers) > 1:
            raise InputError(
                "with saturation, controllers that hold their own u cannot know which part of it "
                "was applied. Use Decentralized(..., shared_u=True)."
            )
        updates = [o.update for o in self._controllers if isinstance(o, ControllerSettings)]
        stops = [u.stop_where_unsupported for u in updates if isinstance(u, RecursiveLeastSquares)]
        return _kernel.Loop(
            controllers=self._kernels,
            plant=body,
            low=low,
            high=high,
            rate=rate,
            limit=limit,
            stop_where_unsupported=any(stops),
            shared_u=shared,
            r_in_w=r_in_w,
        )


def _compiled_controllers(
    settings: AnyController, saturation: Saturation | None, supervision: Supervision | None
) -> tuple[OneController, ...]:
    """Those of which the kernel makes the steps: none where they are Python."""
    if not isinstance(settings, StepwiseController):
        return controllers_of(settings)
    name = type(settings).__name__
    if saturation is not None:
        raise InputError(
            f"a {name} is run without saturation: it would not know which part of u was applied. "
            "Leave saturation out."
        )
    if supervision is not None:
        raise InputError(
            f"a {name} is run without supervision, which watches P of an RCAC controller; leave "
            "supervision out."
        )
    return ()


def _learner(controllers: tuple[OneController, ...]) -> DataDrivenLearner | None:
    """What learns the target model of the one controller, if it is to be learnt."""
    adaptive = [one for one in controllers if isinstance(one, ControllerSettings)]
    learning = [one.learning for one in adaptive if one.learning is not None]
    if learning and len(controllers) > 1:
        raise InputError("DataDriven learns u -> z for one controller; several would act on z.")
    return DataDrivenLearner(learning[0], adaptive[0].structure) if learning else None


def scale_of(before: float, *from_outside: Array | None) -> float:
    """The largest size of what comes from outside, in this run and those that it goes on from."""
    peaks = [np.abs(values).max(initial=0.0) for values in from_outside if values is not None]
    return float(max(before, *peaks))


def divergence_limit_of(given: float | None, scale: float) -> float:
    """The size at which a loop counts as diverged."""
    if given is None:
        return NO_DIGIT_LEFT * max(1.0, scale)
    limit = number(given, "divergence_limit")
    if limit <= 0:
        raise InputError(f"divergence_limit = {limit} must be positive.")
    return limit


# Seconds that the kernel runs before Python may look at a key that was pressed.
CHUNK = 0.05


class RunInterrupted(KeyboardInterrupt):
    """Ctrl-C while something ran; whoever catches KeyboardInterrupt catches this too.

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
    """Run every job to its end; hands over after each slice of time, and once at the end."""
    jobs = [one.job for one in prepared if isinstance(one.job, _kernel.Job)]
    stepwise = [one.job for one in prepared if isinstance(one.job, StepwiseLoop)]
    go_on = True
    for one in prepared:
        one.proceed()
    while go_on:
        try:
            go_on = _kernel.run_jobs(jobs, threads, CHUNK, lanes)
            go_on = sum(job.go_on(CHUNK) for job in stepwise) > 0 or go_on
            go_on = sum(one.proceed() for one in prepared) > 0 or go_on  # each of them proceeds
        except KeyboardInterrupt:
            if not keep:
                raise
            raise RunInterrupted([one.result(interrupted=True) for one in prepared]) from None
        yield
