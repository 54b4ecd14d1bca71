"""When two runs are the same run, and which runs may be compared digit by digit."""

import numpy as np
from hypothesis import assume


def tame(run):
    """Runs that do not grow beyond what a comparison to nine digits means."""
    assume(run.outcome == "completed" and np.abs(run.u).max() < 1e2)
    return run


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
