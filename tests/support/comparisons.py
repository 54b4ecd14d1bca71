"""When two runs are the same run, and which runs may be compared digit by digit."""

import numpy as np
from hypothesis import assume

from rcac_numeric import Gradient, simulate
from tests.support.engine_cases import with_update
from tests.support.textbook_loop import book_loop


def tame(run):
    """Runs that do not grow beyond what a comparison to nine digits means."""
    assume(run.outcome == "completed" and np.abs(run.u).max() < 1e2)
    return run


def steady(plant, settings, regressor, w, saturation=None):
    """The settings with a gradient's steps so short that rounding does not grow from step to step.

    Two recursions on the same data drift apart by I - step_size Phi_f' (R_z + R_u) Phi_f, which
    lengthens nothing where step_size norm(Phi_f' (R_z + R_u) Phi_f) <= 2. Other updates minimise
    a cost, and come nearer to each other in its norm by themselves.
    """
    while isinstance(settings.update, Gradient):
        run = tame(simulate(plant, settings, w, saturation=saturation))
        message = book_loop(plant, [(settings, regressor)], w, saturation=saturation, forced=run)
        size = settings.update.step_size
        if size * max(message["books"][0].curvatures) <= 2:
            break
        settings = with_update(settings, step_size=size / 2)
    return settings


def same(a, b):
    return (
        a.outcome == b.outcome
        and all(
            np.array_equal(getattr(a, name), getattr(b, name))
            for name in ("u", "y", "z", "theta", "theta_final", "u_applied")
        )
        and (a.guard_count, a.reflections) == (b.guard_count, b.reflections)
    )


def identical(a, b):
    """The same, and they would go on the same way."""
    states = [run.state.values.tobytes() if run.state else b"" for run in (a, b)]
    return same(a, b) and states[0] == states[1] and a.guard_first_step == b.guard_first_step
