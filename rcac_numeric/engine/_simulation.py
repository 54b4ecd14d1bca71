"""Simulation of the closed loop."""

from __future__ import annotations

from collections.abc import Callable

from numpy.typing import ArrayLike

from compensator_theory.errors import (
    CompensatorError,
    FunctionFailedError,
    InputError,
)
from rcac_numeric.arrays._validation import instance_of, integer
from rcac_numeric.arrays._values import replaced
from rcac_numeric.controllers._decentralized import Decentralized
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._stepwise import StepwiseController
from rcac_numeric.controllers._supervision import Supervision
from rcac_numeric.engine._changes import ControllerChange
from rcac_numeric.engine._compatibility import AnyController
from rcac_numeric.engine._device_learner import require_not_learnt
from rcac_numeric.engine._jobs import (
    PreparedRun,
    RunInterrupted,
    run_to_end,
)
from rcac_numeric.engine._loops import PreparedLoop
from rcac_numeric.engine._runs import Run
from rcac_numeric.engine._states import SavedState
from rcac_numeric.plants._any_plant import AnyPlant
from rcac_numeric.plants._foreign import as_plant
from rcac_numeric.plants._saturation import Saturation


def simulate(
    plant: AnyPlant,
    settings: AnyController,
    w: ArrayLike,
    *,
    x_0: ArrayLike | None = None,
    stride: int = 1,
    divergence_limit: float | None = None,
    saturation: Saturation | None = None,
    start: SavedState | None = None,
    on_step: Hook | None = None,
    every: int = 1,
    supervision: Supervision | None = None,
) -> Run:
    """Run a controller on a plant.

    Parameters
    ----------
    plant : Plant, PlantSchedule or FunctionPlant
        Or a text in q, a transfer function or a discrete system of python-control, SciPy or
        SymPy, read by `plant_of`.
    settings : ControllerSettings, Decentralized, FixedController, GainSchedule, PredictiveCost or
        IndirectSettings
    w : array, shape (steps, l_w)
        The exogenous input; its length is the number of steps. Where the structure reads a
        command, that is the block "r" of w.
    x_0 : array, shape (n,), optional
        Initial state; zero by default.
    stride : int
        theta is kept at every stride-th step.
    divergence_limit : float, optional
        The loop counts as diverged where an entry of u, y, z, x or theta exceeds it in size. By
        default 1e15 times the largest entry of w and x_0, those of the runs before `start` too, or
        1e15 if that is more: in a signal of that size float64 holds no digit of w.
    saturation : Saturation, optional
    start : SavedState, optional
        The state of an earlier run with the same plant, settings and saturation; this run goes on
        from there, bit for bit as if it had not been cut, changes of the controller included.
    on_step : function, optional
        Called with the run so far (its steps and signals, without a `state`) before every step
        k = every, 2 every, ...; returns a `ControllerChange` to make, or None. `Run.changes` says
        what was made.
    every : int
    supervision : Supervision, optional
        What watches the controller and acts in trouble; by default it only notes, and nothing of
        the run is different. Not for a stepwise controller.

    Raises
    ------
    InputError
        Where sizes do not fit, or `start` belongs to another loop.
    ImproperError
        Where u(k) and y(k) depend on each other.
    FunctionFailedError
        Where a function of the plant, of a weight or on_step raised or returned what does not fit;
        the attribute `run` of the error holds what came before.
    RunInterrupted
        On Ctrl-C, within about 0.1 s; its attribute `run` holds the run so far, whose `state`
        goes on from there.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, Step, exogenous, fir_target, iir, servo_plant, simulate)
    >>> plant = servo_plant("(q - 0.85)/((q - 0.8)*(q - 0.9))")
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=3), target=fir_target(plant), update=UD(R_theta=0.2))
    >>> w = exogenous([Step(), Step(0), Step(0)], steps=1000)
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
    plant = as_plant(plant)
    prepared = PreparedRun(
        PreparedLoop(plant, settings, saturation, supervision),
        w,
        x_0=x_0,
        stride=stride,
        divergence_limit=divergence_limit,
        start=start,
    )
    if on_step is None:
        run_to_end([prepared])
    else:
        run_with_hook(prepared, on_step, require_hook(on_step, every, settings))
    run = prepared.result()
    prepared.require_no_failure(run)
    return run


def frozen_twin(run: Run, k: int) -> Run:
    """Return the run with the adaptation frozen from step k on.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, PlantChange, PlantSchedule, WhiteNoise, exogenous, fir_target,
    ...     frozen_twin, iir, simulate, standard_plant)
    >>> slow, fast = standard_plant("1/(q - 0.9)"), standard_plant("4/(q - 0.9)")
    >>> plant = PlantSchedule(
    ...     [PlantChange(start=0, plant=slow), PlantChange(start=500, plant=fast)])
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=1), target=fir_target(slow), update=UD(R_theta=1e-3))
    >>> run = simulate(plant, settings, exogenous([WhiteNoise()], 1000))
    >>> run.outcome, frozen_twin(run, 500).outcome
    ('completed', 'diverged')
    """
    if instance_of(run, "run", Run).first_step != 0:
        raise InputError("the run continues another run; freeze the whole run instead.")
    if run.changes:
        raise InputError(
            "the controller was changed during the run; the frozen twin would not "
            "apply the changes."
        )
    if isinstance(run.settings, StepwiseController):
        raise InputError(f"a {type(run.settings).__name__} has no freeze; RCAC controllers have.")
    from_k = ((integer(k, "k"), None),)
    settings = run.settings
    if isinstance(settings, Decentralized):
        parts = [replaced(c, freeze=(*c.freeze, *from_k)) for c in settings.controllers]
        settings = Decentralized(parts, settings.shared_u)
    elif isinstance(settings, ControllerSettings):
        settings = replaced(settings, freeze=(*settings.freeze, *from_k))
    return simulate(
        run.plant,
        settings,
        run.w,
        x_0=run.x_0,
        stride=run.stride,
        divergence_limit=run.divergence_limit,
        saturation=run.saturation,
    )


# Runs with a hook: a function that returns changes of the controller.

Hook = Callable[[Run], ControllerChange | None]


def require_hook(on_step: object, every: object, settings: object) -> int:
    """Return the period of a hook; raise for an invalid hook, period or controller."""
    period = integer(every, "every", at_least=1)
    if not callable(on_step):
        raise InputError(f"on_step = {on_step!r} must be a function of the run so far.")
    if not isinstance(settings, ControllerSettings):
        raise InputError(
            f"on_step changes one adaptive controller; settings = {settings!r} are none."
        )
    return period


def run_with_hook(prepared: PreparedRun, on_step: Hook, every: int) -> None:
    """Run to the end and call the hook before steps k = every, 2 every, ..."""
    prepared.make_ready()
    steps = len(prepared.w)
    while prepared.job.outcome == 0 and prepared.job.done < steps:
        k = prepared.first_step + prepared.job.done
        if k > 0 and k % every == 0:
            _ask(prepared, on_step, k)
        prepared.hold(min(steps, prepared.job.done + every - k % every))
        run_to_end([prepared])


def _ask(prepared: PreparedRun, on_step: Hook, k: int) -> None:
    so_far = prepared.result(with_state=False)
    try:
        change = on_step(so_far)
        if change is not None:
            instance_of(change, "what on_step returned", ControllerChange)
            if isinstance(prepared.settings, ControllerSettings):
                require_not_learnt(prepared.settings, change)
            prepared.change(change)
    except KeyboardInterrupt:
        raise RunInterrupted([prepared.result(interrupted=True)]) from None
    except CompensatorError as error:
        raise FunctionFailedError(f"on_step at step {k}: ", *error.args, run=so_far) from error
    except Exception as error:
        raise FunctionFailedError(
            f"on_step failed at step {k}: {type(error).__name__}: {error}", run=so_far
        ) from error
