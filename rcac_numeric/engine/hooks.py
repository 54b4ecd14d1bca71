"""A run that asks a function, every so many steps, what to change in the controller."""

from __future__ import annotations

from collections.abc import Callable

from compensator_theory.errors import CompensatorError, FunctionFailedError, InputError
from rcac_numeric.arrays.validation import instance_of, integer
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.engine.interruption import RunInterrupted, run_to_end
from rcac_numeric.engine.jobs import PreparedRun
from rcac_numeric.engine.live.changes import ControllerChange
from rcac_numeric.engine.live.device_learner import require_not_learnt
from rcac_numeric.engine.runs import Run

Hook = Callable[[Run], ControllerChange | None]


def require_hook(on_step: object, every: object, settings: object) -> int:
    """The period of a hook; raises where the hook, its period or the controller is none for it."""
    period = integer(every, "every", at_least=1)
    if not callable(on_step):
        raise InputError(f"on_step = {on_step!r} must be a function of the run so far.")
    if not isinstance(settings, ControllerSettings):
        raise InputError(
            f"on_step changes one adaptive controller; settings = {settings!r} are none."
        )
    return period


def run_with_hook(prepared: PreparedRun, on_step: Hook, every: int) -> None:
    """Run to the end; before every step k = every, 2 every, ... the hook is asked.

    Parameters
    ----------
    prepared : PreparedRun
    on_step : function of the run so far
    every : int

    Raises
    ------
    FunctionFailedError
        Where the hook raised or returned no change that fits.
    RunInterrupted
        On Ctrl-C, as `run_to_end`.
    """
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
        raise FunctionFailedError(f"on_step at step {k}: {error}", so_far) from error
    except Exception as error:
        raise FunctionFailedError(
            f"on_step failed at step {k}: {type(error).__name__}: {error}", so_far
        ) from error
