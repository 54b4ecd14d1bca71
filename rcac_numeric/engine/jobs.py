"""A run that is ready to start: checked, compiled, with its arrays; and what it leaves behind."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import FunctionFailedError, ImproperError, InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import instance_of, integer, number, real_array, signal_array
from rcac_numeric.arrays.values import fingerprint
from rcac_numeric.controllers.decentralized import Decentralized
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.engine import _kernel
from rcac_numeric.engine.compiled_controllers import Failures, compiled_controller
from rcac_numeric.engine.runs import OUTCOMES, Run, controllers_of
from rcac_numeric.engine.states import SavedState, saved_state
from rcac_numeric.plants.functions import FunctionPlant
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.saturation import Saturation
from rcac_numeric.plants.schedules import PlantSchedule

AnyPlant = Plant | PlantSchedule | FunctionPlant


class PreparedRun:
    """The compiled job of a run, and the arrays that it writes; arguments as for `simulate`."""

    def __init__(
        self,
        plant: AnyPlant,
        settings: ControllerSettings | Decentralized,
        w: ArrayLike,
        *,
        x_0: Array | None = None,
        stride: int = 1,
        divergence_limit: float = 1e100,
        saturation: Saturation | None = None,
        start: SavedState | None = None,
    ) -> None:
        instance_of(plant, "plant", AnyPlant)
        instance_of(settings, "settings", ControllerSettings | Decentralized)
        if saturation is not None:
            instance_of(saturation, "saturation", Saturation)
        self.plant, self.settings, self.saturation = plant, settings, saturation
        # A copy: a frozen twin starts from it, whatever becomes of the caller's array.
        self.x_0 = None if x_0 is None else real_array(x_0, "x_0").reshape(-1)
        self.w = signal_array(w, "w", plant.l_w)
        check_sizes(plant, settings)
        self.stride = integer(stride, "stride", at_least=1)
        limit = number(divergence_limit, "divergence_limit")
        if limit <= 0:
            raise InputError(f"divergence_limit = {limit} must be positive.")
        self.divergence_limit = limit
        self._failures = Failures()
        controllers = controllers_of(settings)
        self._kernels = [compiled_controller(c, self._failures) for c in controllers]
        self._loop = self._compiled_loop(limit)
        self._name = fingerprint((plant, settings, saturation))
        self.first_step = 0
        if start is not None:
            self._continue(start)
        steps = len(self.w)
        self.u, self.y, self.z = (np.empty((steps, n)) for n in (plant.l_u, plant.l_y, plant.l_z))
        self.u_applied = self.u if saturation is None else np.empty_like(self.u)
        l_theta = sum(c.structure.l_theta for c in controllers)
        self.theta = np.empty((-(-steps // self.stride), l_theta))
        applied = None if saturation is None else self.u_applied
        self.job = _kernel.Job(
            self._loop, self.w, self.u, applied, self.y, self.z, self.theta, self.stride
        )

    def _continue(self, start: SavedState) -> None:
        if self.x_0 is not None:
            raise InputError("give either x_0 or start: the saved state holds the plant's state.")
        saved_state(start, "start").restore_into(self._loop, "loop", self._name)
        self.first_step = start.k

    def result(self) -> Run:
        """What the job has done so far, as a run; raises where a function of the user failed."""
        done, outcome = self.job.done, self.job.outcome
        kernels = self._kernels
        name = OUTCOMES[outcome]
        if name == "overflow" and self._failures.error is not None:
            name = "weight failed"  # the kernel was handed a NaN in its place
        state = None
        if outcome == 0:
            state = SavedState("loop", self.first_step + done, self._loop.save(), self._name)
        run = Run(
            plant=self.plant,
            settings=self.settings,
            w=self.w[:done],
            u=self.u[:done],
            y=self.y[:done],
            z=self.z[:done],
            theta=self.theta[: -(-done // self.stride)],
            theta_final=(
                np.concatenate([kernel.theta for kernel in kernels])
                if outcome == 0
                else self._loop.theta_before()
            ),
            stride=self.stride,
            outcome=name,
            guard_count=sum(kernel.guard_count for kernel in kernels),
            guard_first_step=min(
                (k.guard_first_step for k in kernels if k.guard_first_step >= 0), default=-1
            ),
            u_applied=self.u_applied[:done],
            reflections=sum(kernel.reflections for kernel in kernels),
            resets=sum(kernel.resets for kernel in kernels),
            first_step=self.first_step,
            state=state,
            saturation=self.saturation,
            x_0=self.x_0,
            divergence_limit=self.divergence_limit,
        )
        if self._failures.error is not None:
            error = self._failures.error
            raise FunctionFailedError(
                f"a function of the plant or of a weight failed at step {self.first_step + done}: "
                f"{type(error).__name__}: {error} The steps before are in the attribute run of "
                "this error.",
                run,
            ) from error
        return run

    def _compiled_loop(self, limit: float) -> Any:
        plant, settings = self.plant, self.settings
        controllers = controllers_of(settings)
        no_bounds = (np.zeros(0), np.zeros(0), np.zeros(0))
        saturation = self.saturation
        low, high, rate = no_bounds if saturation is None else saturation.bounds(plant.l_u)
        shared = getattr(settings, "shared_u", True)
        if saturation is not None and not shared and len(controllers) > 1:
            raise InputError(
                "with saturation, controllers that hold their own u cannot know which part of it "
                "was applied. Use Decentralized(..., shared_u=True)."
            )
        body = (
            plant.compiled(self.x_0, self._failures)
            if isinstance(plant, FunctionPlant)
            else plant.compiled(self.x_0)
        )
        return _kernel.Loop(
            controllers=self._kernels,
            plant=body,
            low=low,
            high=high,
            rate=rate,
            limit=limit,
            stop_where_unsupported=any(c.stop_where_unsupported for c in controllers),
            shared_u=shared,
            r_in_w=command_position(plant, max(c.structure.l_r for c in controllers)),
        )


def command_position(plant: AnyPlant, l_r: int) -> int:
    """Where the command begins in w; raises where the plant has none of the right width."""
    if l_r == 0:
        return 0
    width = plant.blocks.get("r", 0)
    if width != l_r:
        raise InputError(
            f"the controller reads a command with l_r = {l_r}; the plant's exogenous input has "
            f"the blocks {dict(plant.blocks)}. Use servo_plant, or name a block 'r' of that width."
        )
    position = 0
    for name, size in plant.blocks.items():
        if name == "r":
            break
        position += size
    return position


def check_sizes(plant: AnyPlant, settings: Any) -> None:
    """Raise where a plant and a controller do not fit together."""
    for controller in controllers_of(settings):
        structure, target = controller.structure, controller.target
        pairs = {
            "l_u": (plant.l_u, structure.l_u),
            "l_y": (plant.l_y, structure.l_y),
            "l_z": (plant.l_z, target.l_z),
        }
        for name, (of_plant, of_controller) in pairs.items():
            if of_plant != of_controller:
                raise InputError(
                    f"the plant has {name} = {of_plant} and the controller {name} = "
                    f"{of_controller}."
                )
        command_position(plant, structure.l_r)
        if structure.measures_first and plant.y_needs_u:
            raise ImproperError(
                "the controller is exactly proper (k_c = 0) and D_0 is not zero, so u(k) and y(k) "
                "depend on each other. Use k_c = 1."
            )
        if controller.form == "filter" and (plant.y_needs_u or plant.z_needs_u):
            raise ImproperError(
                'form = "filter" needs y(k) and z(k) before u(k), but D_0 or E_2 is not zero. Use '
                'form = "predictor".'
            )
