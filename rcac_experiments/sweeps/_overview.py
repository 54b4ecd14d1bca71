"""A store as a whole: its study, progress and outcomes."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rcac_experiments.sweeps._folder import Folder
from rcac_experiments.sweeps._statistics import SweepSummary, summarise
from rcac_experiments.sweeps._table import SweepTable, table_in
from rcac_numeric.arrays._showing import report_of
from rcac_numeric.arrays._values import Result


@dataclass(frozen=True, eq=False)
class SweepOverview(Result):
    """The contents of a store.

    Of the runs that have ended, those that failed are in `table.failed` and in no number else.

    Attributes
    ----------
    path, title, fingerprint, instruction_set, created : str
    versions : dict from names to str
        What it was begun with.
    mixed : tuple of str
        What differed when it was gone on with by `mixed`.
    seed, repetitions : int
    axes : dict from names to (path, number of values)
    done, total : int
        Runs that have ended, and runs of the study.
    table : SweepTable
    summary : SweepSummary
        Group by group.
    """

    path: str
    title: str
    fingerprint: str
    instruction_set: str
    created: str
    versions: dict[str, str]
    mixed: tuple[str, ...]
    seed: int
    repetitions: int
    axes: dict[str, tuple[str, int]]
    done: int
    total: int
    table: SweepTable
    summary: SweepSummary

    @property
    def failed(self) -> int:
        """How many of the runs that have ended failed."""
        return self.table.failures

    @property
    def failures(self) -> dict[str, int]:
        """Errors of failed runs with their counts, the most frequent first."""
        outcomes, texts = (self.table.failed.get(name, ()) for name in ("outcome", "failure"))
        words = (f"{outcome}: {text}" for outcome, text in zip(outcomes, texts, strict=True))
        return dict(Counter(words).most_common())

    @property
    def outcomes(self) -> dict[str, int]:
        """Number of results of each outcome, the most frequent first."""
        return dict(Counter(self.table["outcome"].tolist()).most_common())

    @property
    def errors(self) -> dict[str, int]:
        """Notes beside the outcomes with their counts, the most frequent first."""
        return dict(Counter(e for e in self.table["failure"].tolist() if e).most_common())

    def _sheet(self) -> Any:
        from rcac_experiments.reports._studies import sweep_sheet

        return sweep_sheet(self)

    def report(self) -> str:
        """The study, its outcomes and statistics in words and numbers."""
        return report_of(self._sheet())

    def __str__(self) -> str:
        return self.report()


def sweep_overview(
    store: str | Path, measure: str = "", by: tuple[str, ...] | None = None
) -> SweepOverview:
    """Summarise the contents of a store over some axes.

    Parameters
    ----------
    store : path
    measure : str, optional
        What medians and quantiles are of; the first that was kept by default.
    by : tuple of str, optional
        Axes; all by default.

    Raises
    ------
    StoreError
        Where the folder is no store or is damaged.

    Examples
    --------
    >>> import tempfile
    >>> from rcac_experiments.sweeps import Axis, Metric, Study, run_study, sweep_overview
    >>> base = {
    ...     "plant": {"problem": "standard", "G": "1/(q - 2)"},
    ...     "signals": {"w": {"white_noise": 1}},
    ...     "target": {"model": "fir"}, "controller": {"n_c": 2}, "run": {"steps": 50}}
    >>> study = Study(base, [Axis("R_theta", [0.1, 10], sets="controller.R_theta")],
    ...     [Metric("rms")])
    >>> store = tempfile.mkdtemp() + "/study"
    >>> _ = run_study(study, store, workers=0)
    >>> overview = sweep_overview(store)
    >>> overview.done, overview.outcomes
    (2, {'completed': 2})
    """
    with Folder(store) as opened:
        row, table = opened.study, table_in(opened)
    first = table.measures[0] if table.measures else ""
    return SweepOverview(
        path=str(store),
        title=row.title,
        fingerprint=row.fingerprint,
        instruction_set=row.instruction_set,
        created=row.created,
        versions=row.versions,
        mixed=row.mixed,
        seed=row.resolved["seed"],
        repetitions=row.resolved["repetitions"],
        axes={a["name"]: (a["sets"], len(a["values"])) for a in row.resolved["axes"]},
        done=len(table) + table.failures,
        total=row.plan.runs,
        table=table,
        summary=summarise(table, measure or first, by),
    )
