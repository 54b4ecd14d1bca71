"""The closed loop at full speed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import FunctionFailedError, ImproperError, InputError
from rcac_numeric import _kernel
from rcac_numeric.actuators import Saturation
from rcac_numeric.controller_settings import ControllerSettings
from rcac_numeric.decentralized import Decentralized
from rcac_numeric.fingerprints import fingerprint
from rcac_numeric.function_plants import FunctionPlant
from rcac_numeric.kernel_controllers import Failures, compiled_controller
from rcac_numeric.plant_schedules import PlantSchedule
from rcac_numeric.plants import Plant
from rcac_numeric.runs import OUTCOMES, Run, controllers_of
from rcac_numeric.saved_states import SavedState, saved_state
from rcac_numeric.validation import Array, instance_of, integer, number, signal_array

AnyPlant = Plant | PlantSchedule | FunctionPlant

# Rows that the kernel runs before Python may look at a key that was pressed.
CHUNK = 1 << 16


def simulate(
    plant: AnyPlant,
    settings: ControllerSettings | Decentralized,
    w: ArrayLike,
    *,
    x_0: Array | None = None,
    stride: int = 1,
    divergence_limit: float = 1e100,
    saturation: Saturation | None = None,
    start: SavedState | None = None,
) -> Run:
    """Run a controller on a plant.

    Parameters
    ----------
    plant : Plant, PlantSchedule or FunctionPlant
    settings : ControllerSettings or Decentralized
    w : array, shape (steps, l_w)
        The exogenous input; its length is the number of steps. Where the structure reads a
        command, that is the block "r" of w.
    x_0 : array, shape (n,), optional
        Initial state; zero by default.
    stride : int
        theta is kept at every stride-th step.
    divergence_limit : float
        The loop counts as diverged where an entry of u, y, z, x or theta exceeds it in size.
    saturation : Saturation, optional
    start : SavedState, optional
        The state of an earlier run with the same plant, settings and saturation; this run goes on
        from there, bit for bit as if it had not been cut.

    Raises
    ------
    InputError
        Where sizes do not fit, or `start` belongs to another loop.
    ImproperError
        Where u(k) and y(k) depend on each other.
    FunctionFailedError
        Where a function of the plant or of a weight raised or returned the wrong shape; the
        attribute `run` of the error holds what came before.

    Examples
    --------
    >>> from rcac_numeric import *
    >>> plant = servo_plant("(q - 0.85)/((q - 0.8)*(q - 0.9))")
    >>> settings = ControllerSettings(structure=iir(n_c=3), target=fir_target(plant), R_theta=0.2)
    >>> w = exogenous([step(), step(0), step(0)], steps=1000)
    >>> run = simulate(plant, settings, w)
    >>> run
    Run(completed, steps=1000, Plant(n=2, l_u=1, l_w=3, l_y=1, l_z=1))
    >>> bool(abs(run.z[-1, 0]) < 0.01)
    True
    >>> half = simulate(plant, settings, w[:500])
    >>> rest = simulate(plant, settings, w[500:], start=half.state)
    >>> bool((rest.theta_final == run.theta_final).all())
    True
    """
    instance_of(plant, "plant", AnyPlant)
    instance_of(settings, "settings", ControllerSettings | Decentralized)
    if saturation is not None:
        instance_of(saturation, "saturation", Saturation)
    w = signal_array(w, "w", plant.l_w)
    check_sizes(plant, settings)
    steps, stride = len(w), integer(stride, "stride", at_least=1)
    limit = number(divergence_limit, "divergence_limit")
    if limit <= 0:
        raise InputError(f"divergence_limit = {limit} must be positive.")
    failures = Failures()
    kernels = [compiled_controller(c, failures) for c in controllers_of(settings)]
    loop = compiled_loop(
        plant,
        settings,
        kernels,
        x_0=x_0,
        limit=limit,
        saturation=saturation,
        failures=failures,
    )
    first_step = 0
    name = fingerprint((plant, settings, saturation))
    if start is not None:
        if x_0 is not None:
            raise InputError("give either x_0 or start: the saved state holds the plant's state.")
        saved_state(start, "start").restore_into(loop, "loop", name)
        first_step = start.k
    u, y, z = (np.empty((steps, width)) for width in (plant.l_u, plant.l_y, plant.l_z))
    u_applied = u if saturation is None else np.empty_like(u)
    l_theta = sum(c.structure.l_theta for c in controllers_of(settings))
    theta = np.empty((-(-steps // stride), l_theta))
    chunk = max(CHUNK // stride, 1) * stride
    done, outcome = 0, 0
    while done < steps and outcome == 0:
        count = min(chunk, steps - done)
        moved, outcome = loop.run(
            w, u, None if u_applied is u else u_applied, y, z, theta, stride, done, count
        )
        done += moved
    run = Run(
        plant=plant,
        settings=settings,
        w=w[:done],
        u=u[:done],
        y=y[:done],
        z=z[:done],
        theta=theta[: -(-done // stride)],
        theta_final=(
            np.concatenate([kernel.theta for kernel in kernels])
            if outcome == 0
            else loop.theta_before()
        ),
        stride=stride,
        outcome=OUTCOMES[outcome],
        guard_count=sum(kernel.guard_count for kernel in kernels),
        guard_first_step=min(
            (k.guard_first_step for k in kernels if k.guard_first_step >= 0), default=-1
        ),
        u_applied=u_applied[:done],
        reflections=sum(kernel.reflections for kernel in kernels),
        resets=sum(kernel.resets for kernel in kernels),
        first_step=first_step,
        state=SavedState("loop", first_step + done, loop.save(), name) if outcome == 0 else None,
        saturation=saturation,
        x_0=x_0,
    )
    if failures.error is not None:
        raise FunctionFailedError(
            f"a function of the plant or of a weight failed at step {first_step + done}: "
            f"{type(failures.error).__name__}: {failures.error} The steps before are in the "
            "attribute run of this error.",
            run,
        ) from failures.error
    return run


def frozen_twin(run: Run, k: int) -> Run:
    """The same run with the adaptation stopped at step k: the fixed controller beside it.

    Examples
    --------
    >>> from rcac_numeric import *
    >>> slow, fast = standard_plant("1/(q - 0.9)"), standard_plant("4/(q - 0.9)")
    >>> plant = PlantSchedule([Change(start=0, plant=slow), Change(start=500, plant=fast)])
    >>> settings = ControllerSettings(structure=iir(n_c=1), target=fir_target(slow), R_theta=1e-3)
    >>> run = simulate(plant, settings, exogenous([white_noise()], 1000))
    >>> run.outcome, frozen_twin(run, 500).outcome
    ('completed', 'completed')
    """
    if instance_of(run, "run", Run).first_step != 0:
        raise InputError("the run is the continuation of another; freeze the whole run instead.")
    freeze = ((integer(k, "k"), None),)
    if isinstance(run.settings, Decentralized):
        frozen: Any = replace(
            run.settings,
            controllers=[replace(c, freeze=(*c.freeze, *freeze)) for c in run.settings.controllers],
        )
    else:
        frozen = replace(run.settings, freeze=(*run.settings.freeze, *freeze))
    return simulate(
        run.plant,
        frozen,
        run.w,
        x_0=run.x_0,
        stride=run.stride,
        saturation=run.saturation,
    )


def compiled_loop(
    plant: AnyPlant,
    settings: Any,
    kernels: list[Any],
    *,
    x_0: Array | None,
    limit: float,
    saturation: Saturation | None,
    failures: Failures,
) -> _kernel.Loop:
    """Controllers, actuator and plant in one compiled object."""
    no_bounds = (np.zeros(0), np.zeros(0), np.zeros(0))
    low, high, rate = no_bounds if saturation is None else saturation.bounds(plant.l_u)
    shared = getattr(settings, "shared_u", True)
    if saturation is not None and not shared and len(kernels) > 1:
        raise InputError(
            "with saturation, controllers that hold their own u cannot know which part of it was "
            "applied. Use Decentralized(..., shared_u=True)."
        )
    body = (
        plant.simulator(x_0, failures) if isinstance(plant, FunctionPlant) else plant.simulator(x_0)
    )
    return _kernel.Loop(
        controllers=kernels,
        plant=body,
        low=low,
        high=high,
        rate=rate,
        limit=limit,
        stop_where_unsupported=any(c.stop_where_unsupported for c in controllers_of(settings)),
        shared_u=shared,
        r_in_w=command_position(plant, max(c.structure.l_r for c in controllers_of(settings))),
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
