"""One run of a study again, with everything that the store did not keep."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from compensator_theory import figures
from compensator_theory.errors import FunctionFailedError, InputError
from rcac_experiments.sweeps._axes import Axis
from rcac_experiments.sweeps._canonical import data_files, file_digests, source_of
from rcac_experiments.sweeps._cells import Cells
from rcac_experiments.sweeps._chunk import error_text
from rcac_experiments.sweeps._folder import Folder
from rcac_experiments.sweeps._measures import Metric
from rcac_experiments.sweeps._problems import StoreError
from rcac_experiments.sweeps._study import Study
from rcac_experiments.sweeps._study_file import StoredStudy
from rcac_experiments.sweeps._versions import versions
from rcac_experiments.sweeps._worker import MeasureFailed, measured, run_in_full
from rcac_numeric.analysis._loop_analysis import LoopAnalysis
from rcac_numeric.arrays._showing import report_of
from rcac_numeric.arrays._validation import integer
from rcac_numeric.arrays._values import Result, fingerprint
from rcac_numeric.arrays._wording import printable, shortened
from rcac_numeric.compiled._controllers import VARIABLE, instruction_set


@dataclass(frozen=True, eq=False)
class ReplayedRun(Result):
    """A repeated run of a study.

    Attributes
    ----------
    number, repetition : int
    coordinates : dict from axes to values
    analysed : LoopAnalysis
        The run with its analyses.
    stored, repeated : dict from measures to floats
        Stored and repeated values; NaN for a missing value.
    stored_outcome, stored_error : str
    differing_versions : dict from names to (then, now)
    """

    number: int
    repetition: int
    coordinates: dict[str, Any]
    analysed: LoopAnalysis
    stored: dict[str, float]
    repeated: dict[str, float]
    stored_outcome: str
    stored_error: str
    differing_versions: dict[str, tuple[str, str]]

    @property
    def differences(self) -> list[str]:
        """The measures whose bits differ, and the outcome if it does."""
        pairs = ((name, self.stored[name], self.repeated[name]) for name in self.stored)
        differ = [n for n, a, b in pairs if not np.array_equal([a], [b], equal_nan=True)]
        if self.stored_outcome != self.analysed.run.outcome:
            differ.append("outcome")
        return differ

    @property
    def is_identical(self) -> bool:
        """Whether all stored values are bit-identical."""
        return not self.differences

    def plot(self, title: str = "") -> figures.Figure:
        """One sheet: response, coefficients, poles and zeros, and the intercalated match."""
        return self.analysed.plot(title or f"run {self.number}")

    def _sheet(self) -> Any:
        from rcac_experiments.reports._studies import replay_sheet

        return replay_sheet(self)

    def report(self) -> str:
        """Return the report: the run, and the comparison with the stored values."""
        return report_of(self._sheet())

    def __str__(self) -> str:
        return self.report()


def replay_run(
    store: str | Path,
    run: int,
    measures: Mapping[str, Callable[..., Any]] | None = None,
    data: str | Path | None = None,
) -> ReplayedRun:
    """Repeat one run of a store, bit for bit, with its signals and coefficients.

    A store chooses no code and no files. Functions that its study has come from the caller, and
    must have the source that they had then; so do the data files that it names.

    Parameters
    ----------
    store : path
    run : int
    measures : mapping from names to functions, optional
        The functions of the study, measures and the one that makes its cases, by what they are
        called; a measure of rcac needs none.
    data : path, optional
        The folder of the data files that the study names, which must be what they were.

    Raises
    ------
    StoreError
        Where there is no such run, it was not run yet, or it used other instructions; where the
        study has a function or a data file that was not given, or is not what it was.
    CompensatorError
        Where the run was recorded as one that cannot be made, for the reason that it gave then.
    FunctionFailedError
        Where a measure raises again what it raised then.

    Examples
    --------
    >>> import tempfile
    >>> from rcac_experiments.sweeps import Metric, Study, replay_run, run_study
    >>> base = {
    ...     "plant": {"problem": "standard", "G": "1/(q - 0.9)"},
    ...     "signals": {"w": {"white_noise": 1}},
    ...     "target": {"model": "fir"}, "controller": {"n_c": 2}, "run": {"steps": 200}}
    >>> study = Study({**base, "controller": {"n_c": 2, "R_theta": 1}}, [], [Metric("rms")],
    ...     repetitions=8)
    >>> store = tempfile.mkdtemp() + "/study"
    >>> _ = run_study(study, store, workers=0)
    >>> again = replay_run(store, 5)
    >>> again.is_identical, again.analysed.run.steps
    (True, 200)
    """
    integer(run, "run")
    functions = dict(measures or {})
    for name, function in functions.items():
        if not callable(function):
            raise InputError(f"measures[{name!r}] = {function!r} must be a function.")
    with Folder(store) as opened:
        about = opened.study
        plan = about.plan
        if run >= plan.runs:
            raise StoreError(f"{store} has no run {run}; its runs are 0 to {plan.runs - 1}.")
        results = list(opened.results([plan.chunk_of(run)]))
    if not results:
        raise StoreError(f"run {run} of {store} is not stored yet; run `run_study` first.")
    row = {name: values[run - results[0].first] for name, values in results[0].columns.items()}
    cell, repetition = plan.place(run)
    (coordinates,) = plan.coordinates([cell])
    study = _study(about, str(store), functions, data)
    if instruction_set() != about.instruction_set:
        raise StoreError(
            f"{store} used the instruction set {about.instruction_set}, this process uses "
            f"{instruction_set()}: set the environment variable {VARIABLE}="
            f"{about.instruction_set} to replay it bit for bit."
        )
    cells = Cells(study)
    with np.errstate(all="ignore"):
        analysed = run_in_full(cells, coordinates, repetition)
        try:
            values, _ = measured(cells.cell(coordinates), analysed)
        except MeasureFailed as failed:
            raise FunctionFailedError(
                f"run {run} of {store}: the measure {failed.name} raised "
                f"{error_text(failed.cause)}."
            ) from failed.cause
    now = versions()
    return ReplayedRun(
        number=run,
        repetition=repetition,
        coordinates=coordinates,
        analysed=analysed,
        stored={name: float(row[name]) for name in about.measures},
        repeated=dict(zip(about.measures, (value + 0.0 for value in values), strict=True)),
        stored_outcome=row["outcome"],
        stored_error=row["failure"],
        differing_versions={
            name: (then, now.get(name, "absent"))
            for name, then in about.versions.items()
            if now.get(name) != then
        },
    )


def _study(
    about: StoredStudy,
    store: str,
    functions: dict[str, Callable[..., Any]],
    data: str | Path | None,
) -> Study:
    """The study of a store as an object again, with the functions and files of the caller."""
    resolved = about.resolved

    def restored(value: Any) -> Any:
        if not (isinstance(value, dict) and value.keys() >= {"function", "source"}):
            return value
        whole = str(value["function"])
        name = whole.rpartition(":")[2]
        if (function := functions.get(whole, functions.get(name))) is None:
            raise StoreError(
                f"{store} was made with the function {printable(whole)}, and a store runs no code "
                "of its own: if you know where the function comes from, give it by its name, "
                "replay_run(..., measures={name: function}) or --measures FILE.py."
            )
        if source_of(function) != value["source"]:
            raise StoreError(
                f"the function {printable(name)} is not the one that {store} was made with: its "
                "source differs, so the numbers cannot be compared. Use the original version."
            )
        if "holds" in value and fingerprint(function) != value["holds"]:
            raise StoreError(
                f"{printable(name)} holds other data than the one that {store} was made with; give "
                "the original one."
            )
        return function

    try:
        base = restored(resolved["base"])
        file = _file_in(data, about, store)
        return Study(
            base,
            [Axis(axis["name"], axis["values"], axis["sets"]) for axis in resolved["axes"]],
            [
                Metric(restored(metric["measure"]), metric["name"], metric["arguments"])
                for metric in resolved["keep"]
            ],
            repetitions=resolved["repetitions"],
            seed=resolved["seed"],
            common_noise=resolved["common_noise"],
            lanes=resolved["lanes"],
            keep_signals=resolved["keep_signals"],
            file=file,
            title=about.title,
        )
    except (KeyError, TypeError, AttributeError) as error:
        raise StoreError(f"{store} holds no study ({type(error).__name__}: {error}).") from None


def _file_in(data: str | Path | None, about: StoredStudy, store: str) -> str:
    """Return a path beside the data files of the study, after their digests were checked."""
    resolved = about.resolved
    named = sorted(data_files([resolved["base"], *(a["values"] for a in resolved["axes"])]))
    stored: dict[str, str] = resolved["files"]
    if not named:
        return "study"
    shown = ", ".join(printable(shortened(name, 80)) for name in named[:3])
    if data is None:
        raise StoreError(
            f"{store} was made with data files ({shown}), and a store opens no file of your disk: "
            "say in which folder they are, replay_run(..., data=FOLDER) or --data FOLDER."
        )
    folder = Path(data).resolve()
    for name in named:
        path = (folder / name).resolve()
        if not path.is_relative_to(folder):
            raise StoreError(
                f"{store} names the data file {printable(shortened(name, 80))}, which is not in "
                f"{folder}: give the folder that holds all of them."
            )
        if file_digests(name, str(folder)) != {name: stored.get(name)}:
            raise StoreError(
                f"the data file {path} is not there, or is not what {store} was made with."
            )
    return str(folder / "study")
