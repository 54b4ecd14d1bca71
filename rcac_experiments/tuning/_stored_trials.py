"""Trials in the store of a study: run by processes, and gone on with where they were stopped."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path

from rcac_experiments.sweeps._axes import Axis
from rcac_experiments.sweeps._folder import Folder
from rcac_experiments.sweeps._measures import Metric
from rcac_experiments.sweeps._problems import StoreError
from rcac_experiments.sweeps._progress import Progress
from rcac_experiments.sweeps._study import Study
from rcac_experiments.sweeps._sweep import run_study
from rcac_experiments.sweeps._table import table_in
from rcac_numeric.analysis._loop_analysis import LoopAnalysis
from rcac_numeric.designing._trials import (
    Trial,
    Trials,
    largest_error,
    sensitivity,
    used_radius,
    whole_rms,
)


def stored(
    trials: Trials, store: Path, executor: Executor, progress: Callable[[Progress], None] | None
) -> tuple[Trial, ...]:
    """The outcome of trials, of which those in the store are not run again.

    The same as `Trials.in_threads`, bit for bit on one instruction set.

    Parameters
    ----------
    trials : Trials
    store : path
        Of a study's folder, made where there is none; one of other trials is refused.
    executor, progress
        As of `run_study`.
    """
    study = Study(
        trials,
        [
            Axis("controller", list(trials.controllers)),
            Axis("plant", list(range(len(trials.variations)))),
            Axis("seed", list(range(trials.first, trials.first + trials.seeds))),
        ],
        [Metric(rms), Metric(peak), Metric(Ms), Metric(radius)],
        lanes=False,
        title="Trials of a design",
    )
    run_study(study, store, executor=executor, progress=progress, retry_failed=True)
    with Folder(store) as opened:
        table = table_in(opened, guarded=False)  # it was read and completed just now
    if table.failures:
        raise StoreError(
            f"{table.failures} of {trials.runs} runs in {store} failed, the first because "
            f"{table.failed['failure'][0]!s}. The same call runs them again."
        )
    columns = (table[name].tolist() for name in ("rms", "peak", "Ms", "radius"))
    return trials.of(zip(*columns, strict=True))


def rms(r: LoopAnalysis) -> float:
    """Return `whole_rms` of the run."""
    return whole_rms(r.run)


def peak(r: LoopAnalysis) -> float:
    """Return `largest_error` of the run."""
    return largest_error(r.run)


def Ms(r: LoopAnalysis) -> float:
    """Return `sensitivity` of the run."""
    return sensitivity(r.run)


def radius(r: LoopAnalysis) -> float:
    """Return `used_radius` of the run."""
    return used_radius(r.run)
