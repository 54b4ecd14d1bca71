"""Reproducing a list of experiments: each once, the page of all of them at the end."""

from __future__ import annotations

import hashlib
import io
import json
import multiprocessing as mp
import os
import pickle
import re
import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import compensator_theory as exact
from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.dissertation._pages import gallery_page
from rcac_experiments.experiments._experiment import Experiment, verify
from rcac_experiments.reports._cases import Case, case_of
from rcac_numeric.arrays._files import member, replacing, require_readable
from rcac_numeric.arrays._untrusted import parsed_json
from rcac_numeric.arrays._values import Result, Value, replaced
from rcac_numeric.reports._rendering import rendered, write_page

PAGE, CASES = "index.html", "cases"
FAILED = 2  # the status of a case that could not be made
FEW = 5  # repetitions of a run in a quick look


@dataclass(frozen=True, eq=False)
class Reproduction(Result):
    """The result of a reproduction.

    Attributes
    ----------
    cases : tuple of Case
        In the order of the experiments.
    page : Path
        The page that tells of them.
    """

    cases: tuple[Case, ...]
    page: Path

    @property
    def exit_status(self) -> int:
        """3 where a loop diverged unexpectedly, else 2 where a case failed, else 1 or 0."""
        return max((case.status for case in self.cases), default=0)


def reproduce(
    experiments: Iterable[Experiment],
    folder: str | Path,
    *,
    executor: Executor | None = None,
    progress: Callable[[str, int, int], None] = lambda name, done, of: None,
) -> Reproduction:
    """Verify experiments and write one page of them.

    Parameters
    ----------
    experiments : iterable of Experiment
    folder : path
        Gets ``index.html``, and ``cases`` with a file for each experiment that is done. An
        experiment whose file is there, with the same data and version, is not run again: a kill
        loses only what was running.
    executor : Executor, optional
        Where they are run; one after the other in this process by default.
    progress : callable
        Called with the experiment that is done, how many are, and of how many.

    Raises
    ------
    InputError
        If the folder cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from rcac_experiments.dissertation import load_example, reproduce
    >>> result = reproduce(map(load_example, ["7.1", "B.2"]), tempfile.mkdtemp())
    >>> result.exit_status, result.page.name, [case.id for case in result.cases]
    (0, 'index.html', ['7.1', 'B.2'])
    """
    requests = list(experiments)
    store = CompletedCases(Path(folder) / CASES)
    cases_done = {
        i: case for i, wish in enumerate(requests) if (case := store.find(wish)) is not None
    }
    for count, i in enumerate(cases_done, 1):
        progress(requests[i].id, count, len(requests))
    remaining = [i for i in range(len(requests)) if i not in cases_done]

    def done(i: int, case: Case) -> None:
        if case.status != FAILED:
            store.keep(requests[i], case)
        cases_done[i] = case
        progress(requests[i].id, len(cases_done), len(requests))

    if executor is None:
        for i in remaining:
            done(i, verified_case(requests[i]))
    else:
        futures = {executor.submit(verified_case, requests[i]): i for i in remaining}
        for future in as_completed(futures):
            done(futures[future], future.result())
    is_quick = any(wish.reduced_runs for wish in requests)
    return _written([cases_done[i] for i in range(len(requests))], Path(folder), is_quick)


def verified_case(experiment: Experiment) -> Case:
    """Verify one experiment; an error becomes a case with its reason."""
    try:
        with np.errstate(all="ignore"):  # an overflow is reported, without a warning of NumPy
            return case_of(verify(experiment))
    except CompensatorError as error:
        message = f"Verification failed: {error}"
        body = str(rendered("sentence.html", level="bad", words=message))
        return Case(
            experiment.id, experiment.title, experiment.source, FAILED, (), body, "", (), ""
        )


def reduced(experiment: Experiment) -> Experiment:
    """Return the experiment with fewer seeds and repetitions."""
    few = experiment.reduced()
    runs = {
        name: replaced(run, repetitions=min(run.repetitions, FEW)) for name, run in few.runs.items()
    }
    fewer = {name for name, run in few.runs.items() if run.repetitions > FEW}
    return replace(few, runs=runs, reduced_runs=few.reduced_runs | fewer)


def _written(cases: Sequence[Case], folder: Path, is_quick: bool) -> Reproduction:
    page = member(folder, PAGE)
    write_page(gallery_page(cases, is_quick=is_quick), page)
    return Reproduction(tuple(cases), page)


# Completed cases are stored in a folder, so that a restart skips them.


def digest_of(experiment: Experiment) -> str:
    """Return the digest of the data of an experiment and the version of this package."""
    data = io.BytesIO()
    pickler = pickle.Pickler(data, protocol=5)
    pickler.fast = True  # no references: whether two equal texts are one object is chance
    pickler.dump(experiment)
    return hashlib.sha256(exact.__version__.encode() + b"\0" + data.getvalue()).hexdigest()


@dataclass(frozen=True, eq=False)
class CompletedCases(Value):
    """A folder with one file for each completed case."""

    folder: Path | str

    def find(self, experiment: Experiment) -> Case | None:
        """Return the stored case of an experiment; None if missing or of other data."""
        try:
            require_readable(self._file(experiment))
            record = parsed_json(self._file(experiment).read_text("utf-8"))
            if record["digest"] != digest_of(experiment):
                return None
            return Case.from_record(record["case"])
        except (OSError, ValueError, KeyError, TypeError, InputError):
            return None  # an invalid file: the case is computed again

    def keep(self, experiment: Experiment, case: Case) -> None:
        """Write the case of an experiment."""
        file = member(self.folder, self._file(experiment).name)
        record = {"digest": digest_of(experiment), "case": case.to_record()}
        with replacing(file) as new:
            new.write_text(json.dumps(record), encoding="utf-8")

    def _file(self, experiment: Experiment) -> Path:
        name = re.sub(r"[^A-Za-z0-9.-]+", "-", experiment.id)[:60] or "case"
        return Path(self.folder) / f"{name}.json"


INTERRUPTED = 130
PATIENCE = 0.2  # seconds between two checks that the parent still runs


@contextmanager
def case_workers(count: int) -> Iterator[Executor | None]:
    """An executor with so many processes; None for one, which is this process itself.

    Whatever ends the block ends the processes with what they are at, and so does the death of
    this process.
    """
    if count <= 1:
        yield None
        return
    context = mp.get_context("spawn")
    stop = context.Event()
    executor = ProcessPoolExecutor(count, mp_context=context, initializer=_watch, initargs=(stop,))
    try:
        yield executor
    finally:
        stop.set()
        executor.shutdown(wait=True, cancel_futures=True)


def _watch(stop: Any) -> None:
    """Leave Ctrl-C to the parent, and end when it is done or gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = mp.parent_process()

    def look() -> None:
        while not stop.wait(PATIENCE):
            if parent is not None and not parent.is_alive():
                break
        os._exit(INTERRUPTED)

    threading.Thread(target=look, daemon=True).start()
