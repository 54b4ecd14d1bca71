"""Reproducing a list of experiments: each once, the page of all of them at the end."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.arrays.values import Value
from rcac_numeric.experiments.experiment import Experiment
from rcac_numeric.experiments.verdicts import verify
from rcac_numeric.reports.page.cases import Case, case_of
from rcac_numeric.reports.page.html import words
from rcac_numeric.reports.page.pages import gallery_page, write_page
from rcac_numeric.reproduction.kept import KeptCases

PAGE, CASES = "index.html", "cases"
FAILED = 2  # the status of a case that could not be made
FEW = 5  # repetitions of a run in a quick look


@dataclass(frozen=True, eq=False)
class Reproduction(Value):
    """What was reproduced.

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
    >>> from rcac_numeric import load_example, reproduce
    >>> found = reproduce(map(load_example, ["7.1", "B.2"]), tempfile.mkdtemp())
    >>> found.exit_status, found.page.name, [case.id for case in found.cases]
    (0, 'index.html', ['7.1', 'B.2'])
    """
    wanted = list(experiments)
    kept = KeptCases(Path(folder) / CASES)
    found = {i: case for i, wish in enumerate(wanted) if (case := kept.find(wish)) is not None}
    for count, i in enumerate(found, 1):
        progress(wanted[i].id, count, len(wanted))
    left = [i for i in range(len(wanted)) if i not in found]

    def done(i: int, case: Case) -> None:
        if case.status != FAILED:
            kept.keep(wanted[i], case)
        found[i] = case
        progress(wanted[i].id, len(found), len(wanted))

    if executor is None:
        for i in left:
            done(i, made(wanted[i]))
    else:
        futures = {executor.submit(made, wanted[i]): i for i in left}
        for future in as_completed(futures):
            done(futures[future], future.result())
    return _written([found[i] for i in range(len(wanted))], Path(folder))


def made(experiment: Experiment) -> Case:
    """The case of one experiment; one that cannot be verified says why, and costs no other."""
    try:
        with np.errstate(all="ignore"):  # a loop that leaves float64 is reported, not warned of
            return case_of(verify(experiment))
    except CompensatorError as error:
        body = f'<p class="bad">This could not be verified: {words(str(error))}</p>'
        return Case(
            experiment.id, experiment.title, experiment.source, FAILED, (), body, "", (), ""
        )


def reduced(experiment: Experiment) -> Experiment:
    """The same experiment for a quick look: fewer seeds, and fewer repetitions."""
    few = experiment.reduced()
    runs = {
        name: replace(run, repetitions=min(run.repetitions, FEW)) for name, run in few.runs.items()
    }
    return replace(few, runs=runs)


def _written(cases: Sequence[Case], folder: Path) -> Reproduction:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder} cannot be made: {error.strerror}.") from None
    page = folder / PAGE
    write_page(gallery_page(cases), page)
    return Reproduction(tuple(cases), page)
