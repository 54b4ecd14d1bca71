"""One run of a study again, with everything that the store did not keep."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rcac_numeric.arrays import figures
from rcac_numeric.arrays.showing import report_of
from rcac_numeric.arrays.validation import integer
from rcac_numeric.arrays.values import Value
from rcac_numeric.engine.compiled.instruction_sets import VARIABLE, instruction_set
from rcac_numeric.experiments.measures.analysed_run import AnalysedRun
from rcac_numeric.sweeps.chunks.measuring import measured
from rcac_numeric.sweeps.chunks.worker import run_in_full
from rcac_numeric.sweeps.store.problems import StoreError
from rcac_numeric.sweeps.store.reading import coordinates_in, stored_run
from rcac_numeric.sweeps.store.store import Store
from rcac_numeric.sweeps.store.stored_study import study_in
from rcac_numeric.sweeps.store.versions import versions
from rcac_numeric.sweeps.study.cells import Cells


@dataclass(frozen=True, eq=False)
class ReplayedRun(Value):
    """A run of a study that was run again.

    Attributes
    ----------
    number, repetition : int
    coordinates : dict from axes to values
    analysed : AnalysedRun
        The run with its analyses.
    stored, found : dict from measures to floats
        What is in the store, and what came out now; NaN where there is none.
    stored_outcome, stored_error : str
    differing_versions : dict from names to (then, now)
    """

    number: int
    repetition: int
    coordinates: dict[str, Any]
    analysed: AnalysedRun
    stored: dict[str, float]
    found: dict[str, float]
    stored_outcome: str
    stored_error: str
    differing_versions: dict[str, tuple[str, str]]

    @property
    def differences(self) -> list[str]:
        """The measures whose bits differ, and the outcome if it does."""
        pairs = ((name, self.stored[name], self.found[name]) for name in self.stored)
        differ = [n for n, a, b in pairs if not np.array_equal([a], [b], equal_nan=True)]
        if self.stored_outcome != self.analysed.run.outcome:
            differ.append("outcome")
        return differ

    @property
    def is_identical(self) -> bool:
        """Whether every bit that the store holds came out again."""
        return not self.differences

    def plot(self, title: str = "") -> figures.Figure:
        """One sheet: response, coefficients, poles and zeros, and the intercalated match."""
        return self.analysed.plot(title or f"run {self.number}")

    def report(self) -> str:
        """What was run, and whether it is what the store holds."""
        return report_of(self)

    def __str__(self) -> str:
        return self.report()


def replay_run(store: str | Path, run: int) -> ReplayedRun:
    """Run one run of a store again, bit for bit, with its signals and coefficients.

    Raises
    ------
    StoreError
        Where there is no such run, it was not run yet, or it used other instructions.
    CompensatorError
        Where the run was recorded as one that cannot be made, for the reason that it gave then.

    Examples
    --------
    >>> import tempfile
    >>> from rcac_numeric import Kept, Study, replay_run, run_study
    >>> base = {
    ...     "plant": {"problem": "standard", "G": "1/(q - 0.9)"},
    ...     "signals": {"w": {"white_noise": 1}},
    ...     "target": {"model": "fir"}, "controller": {"n_c": 2}, "run": {"steps": 200}}
    >>> study = Study({**base, "controller": {"n_c": 2, "R_theta": 1}}, [], [Kept("rms")],
    ...     repetitions=8)
    >>> store = tempfile.mkdtemp() + "/study.sqlite"
    >>> _ = run_study(study, store, workers=0)
    >>> again = replay_run(store, 5)
    >>> again.is_identical, again.analysed.run.steps
    (True, 200)
    """
    integer(run, "run")
    with Store(store, read_only=True) as opened:
        row = stored_run(opened, run)
        about = opened.study
        coordinates = coordinates_in(opened, range(row[1], row[1] + 1))[row[1]]
    if instruction_set() != about.instruction_set:
        raise StoreError(
            f"{store} was run with the instructions {about.instruction_set}, this is "
            f"{instruction_set()}: set the environment variable {VARIABLE}="
            f"{about.instruction_set} to replay it bit for bit."
        )
    study = study_in(about)
    cells = Cells(study)
    with np.errstate(all="ignore"):
        analysed = run_in_full(cells, coordinates, row[2])
        values, _ = measured(cells.cell(coordinates), analysed)
    names = [kept.name for kept in study.keep]
    now = versions()
    return ReplayedRun(
        number=run,
        repetition=row[2],
        coordinates=coordinates,
        analysed=analysed,
        stored=dict(zip(names, (math.nan if v is None else v for v in row[5:]), strict=True)),
        found=dict(zip(names, (value + 0.0 for value in values), strict=True)),
        stored_outcome=row[3],
        stored_error=row[4],
        differing_versions={
            name: (then, now.get(name, "absent"))
            for name, then in about.versions.items()
            if now.get(name) != then
        },
    )
