"""Batches of equal-length runs as arrays of shape (runs, steps, width)."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import instance_of, integer, items, real_array
from rcac_numeric.arrays._values import Result
from rcac_numeric.engine._batches import GROUP
from rcac_numeric.engine._compatibility import AnyController, controllers_of
from rcac_numeric.engine._jobs import PreparedRun, run_to_end
from rcac_numeric.engine._loops import PreparedLoops
from rcac_numeric.plants._any_plant import AnyPlant
from rcac_numeric.plants._foreign import as_plant
from rcac_numeric.plants._saturation import Saturation


@dataclass(frozen=True, eq=False)
class BatchRun(Result):
    """Many runs of one plant, as arrays; row i of each belongs to run i.

    Attributes
    ----------
    plant : the arguments of the run.
    settings : tuple of controllers, one for each run.
    w, u, y, z : arrays, shape (runs, steps, width)
        NaN in u, y and z from the step on that was not completed.
    theta_final : array, shape (runs, l_theta)
        The coefficients after the last completed step.
    steps : array of integers, shape (runs,)
        Number of completed steps.
    outcomes : tuple of str
        As `Run.outcome`.
    guard_counts : array of integers, shape (runs,)
        As `Run.guard_count`.
    failures : tuple of str
        What a function of the plant or of a weight raised; empty where none did.
    """

    plant: AnyPlant
    settings: tuple[AnyController, ...]
    w: Array
    u: Array
    y: Array
    z: Array
    theta_final: Array
    steps: NDArray[np.int64]
    outcomes: tuple[str, ...]
    guard_counts: NDArray[np.int64]
    failures: tuple[str, ...]

    def __repr__(self) -> str:
        runs, steps, _ = self.w.shape
        completed = self.outcomes.count("completed")
        return f"BatchRun({completed} of {runs} completed, steps={steps}, {self.plant!r})"


def simulate_batch(
    plant: AnyPlant,
    settings: AnyController | Sequence[AnyController],
    w: ArrayLike,
    *,
    x_0: ArrayLike | None = None,
    divergence_limit: float | None = None,
    saturation: Saturation | None = None,
    threads: int | None = None,
    lanes: bool = False,
) -> BatchRun:
    """Run a plant under many inputs, and perhaps as many controllers, into arrays.

    Run i is that of `simulate_many` with w[i], bit for bit, without what a `Run` holds beside its
    signals: no theta over time, and no state to go on from. Settings that differ in R_theta,
    lambda, theta_0, R_z, R_u or the coefficients of G_f alone are compiled once.

    Parameters
    ----------
    plant : Plant, PlantSchedule or FunctionPlant
        Or what `plant_of` reads.
    settings : controller, or sequence of one for each run
        As for `simulate_many`; all with the same l_theta.
    w : array, shape (runs, steps, l_w)
    x_0 : array, shape (n,) or (runs, n), optional
        Initial state; zero by default.
    divergence_limit, saturation
        As for `simulate`, of each run.
    threads, lanes
        As for `simulate_many`: a step takes 3.3, 2.7 and 2.1 times as long without lanes for
        l_theta = 8, 20 and 50 (benchmarks/before_the_first_step.py).

    Raises
    ------
    InputError
        Where sizes do not fit, or a run is not valid; its number is named, and nothing has run.
    RunInterrupted
        On Ctrl-C; its attribute `runs` holds the runs that were under way.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, fir_target, iir, simulate_batch, standard_plant)
    >>> plant = standard_plant("1/(q - 0.9)")
    >>> settings = [
    ...     ControllerSettings(structure=iir(n_c=2), target=fir_target(plant), update=UD(R_theta=R))
    ...     for R in (0.1, 1, 10)]
    >>> w = np.random.default_rng(0).standard_normal((3, 500, 1))
    >>> batch = simulate_batch(plant, settings, w, lanes=True)
    >>> batch
    BatchRun(3 of 3 completed, steps=500, Plant(n=1, l_u=1, l_w=1, l_y=1, l_z=1))
    >>> batch.z.shape, batch.theta_final.shape
    ((3, 500, 1), (3, 4))
    """
    workers = integer(os.cpu_count() or 1 if threads is None else threads, "threads", at_least=1)
    instance_of(lanes, "lanes", bool)
    plant = as_plant(plant)
    inputs = real_array(w, "w")
    if inputs.ndim != 3:
        raise InputError(f"w has shape {inputs.shape}; (runs, steps, l_w) is needed.")
    count, steps, _ = inputs.shape
    if isinstance(settings, AnyController):
        each: tuple[AnyController, ...] = (settings,) * count
    else:
        each = items(settings, "settings", AnyController)  # type: ignore[arg-type]
    if len(each) != count:
        raise InputError(f"there are {len(each)} settings for {count} runs; give one for each.")
    starts = None if x_0 is None else real_array(x_0, "x_0")
    if starts is not None and starts.ndim == 2 and len(starts) != count:
        raise InputError(f"x_0 has {len(starts)} rows for {count} runs; give one for each.")
    loops, prepared = PreparedLoops(), []
    signals = None
    for i in range(count):
        try:
            controllers_of(each[i])
            loop = loops.of(plant, each[i], saturation)
            if signals is None:
                widths = plant.l_u, plant.l_y, plant.l_z
                signals = [np.full((count, steps, width), np.nan) for width in widths]
            prepared.append(
                PreparedRun(
                    loop,
                    inputs[i],
                    x_0=starts if starts is None or starts.ndim < 2 else starts[i],
                    stride=max(steps, 1),
                    divergence_limit=divergence_limit,
                    into=(signals[0][i], signals[1][i], signals[2][i]),
                )
            )
        except InputError as error:
            raise InputError(f"run {i}: {error}") from None
    return _ended(plant, each, inputs, signals, prepared, workers, lanes)


def _ended(
    plant: AnyPlant,
    settings: tuple[AnyController, ...],
    w: Array,
    signals: list[Array] | None,
    prepared: list[PreparedRun],
    threads: int,
    lanes: bool,
) -> BatchRun:
    if signals is None:
        raise InputError("w holds no run; its first axis counts the runs.")
    widths = {one.l_theta for one in settings}
    if len(widths) > 1:
        raise InputError(f"the settings have l_theta = {sorted(widths)}; one is needed for all.")
    theta = np.empty((len(prepared), widths.pop()))
    done, guards = (np.zeros(len(prepared), dtype=np.int64) for _ in range(2))
    outcomes: list[str] = []
    failures: list[str] = []
    prepared.reverse()  # pop() from the end frees completed runs
    while prepared:
        group = [prepared.pop() for _ in range(min(max(GROUP, 64 * threads), len(prepared)))]
        run_to_end(group, threads, lanes)
        for one in group:
            i = len(outcomes)
            done[i], outcome, guards[i], theta[i], failure = one.ending
            for signal in signals:
                signal[i, done[i] :] = np.nan
            outcomes.append(outcome)
            failures.append(failure)
    u, y, z = signals
    return BatchRun(
        plant, settings, w, u, y, z, theta, done, tuple(outcomes), guards, tuple(failures)
    )
