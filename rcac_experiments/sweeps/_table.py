"""The results of a study as a table: one row for each run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from compensator_theory.errors import InputError
from rcac_experiments.format._places import did_you_mean
from rcac_experiments.sweeps._chunk import FAILED
from rcac_experiments.sweeps._folder import Folder
from rcac_numeric.arrays import _frames as frames
from rcac_numeric.arrays._values import Value

Columns = dict[str, NDArray[Any]]


@attrs.frozen(eq=False, slots=False)
class SweepTable(Value):
    """The results of a study.

    Attributes
    ----------
    columns : dict from names to arrays
        run, cell, repetition, then the coordinates, outcome, failure, and the measures (NaN where
        the result has none).
    axes, measures : tuple of str
        Which columns are coordinates, and which measures.
    failed : dict from names to arrays
        Of the runs that failed, of which no number is known and which stand in no other column:
        run, cell, repetition, the coordinates, outcome and failure.
    """

    columns: Columns
    axes: tuple[str, ...]
    measures: tuple[str, ...]
    failed: Columns = attrs.field(factory=dict)

    def __attrs_post_init__(self) -> None:
        for name, kind in (("columns", dict), ("axes", tuple), ("measures", tuple)):
            object.__setattr__(self, name, kind(getattr(self, name)))
        object.__setattr__(self, "failed", dict(self.failed or {}))

    def __len__(self) -> int:
        return len(self.columns["run"])

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name not in self.columns:
            raise InputError(
                f"the table has no column {name!r}; it has {', '.join(self.columns)}."
                f"{did_you_mean(name, self.columns)}"
            )
        return self.columns[name]

    @property
    def failures(self) -> int:
        """How many runs failed."""
        return len(self.failed.get("run", ()))

    def where(self, **coordinates: Any) -> SweepTable:
        """Return the rows at these coordinates, and the failed runs there.

        Examples
        --------
        >>> import numpy as np
        >>> from rcac_experiments.sweeps import SweepTable
        >>> table = SweepTable(
        ...     {"run": np.arange(4), "n_c": np.array([1, 1, 2, 2])}, ("n_c",), ())
        >>> table.where(n_c=2)["run"]
        array([2, 3])
        """
        for name in coordinates:
            self[name]  # a name that is none is refused

        def chosen(columns: Columns) -> Columns:
            rows = np.ones(len(columns.get("run", ())), dtype=bool)
            for name, value in coordinates.items():
                rows &= np.asarray(columns[name] == value) if name in columns else False
            return {name: values[rows] for name, values in columns.items()}

        return SweepTable(chosen(self.columns), self.axes, self.measures, chosen(self.failed))

    def to_pandas(self) -> frames.DataFrame:
        """The table as a `pandas.DataFrame`, indexed by the run."""
        return frames.imported("pandas").DataFrame(self.columns).set_index("run")

    def to_xarray(self) -> frames.Dataset:
        """The measures and the outcome over the axes and the repetition, an `xarray.Dataset`."""
        frame = self.to_pandas().drop(columns="cell")  # before xarray, which imports pandas
        xarray = frames.imported("xarray")
        return xarray.Dataset.from_dataframe(frame.set_index([*self.axes, "repetition"]))

    def __repr__(self) -> str:
        failed = f", {self.failures} more failed" if self.failures else ""
        return f"SweepTable({len(self)} runs{failed}; {', '.join([*self.axes, *self.measures])})"


def read_table(store: str | Path) -> SweepTable:
    """The results in a store, by increasing number of the run, with failed runs separate.

    Raises
    ------
    StoreError
        Where the folder is no store, or anything in the table is not what was written.

    Examples
    --------
    >>> import tempfile
    >>> from rcac_experiments.sweeps import read_table
    >>> read_table(tempfile.mkdtemp() + "/nothing")
    Traceback (most recent call last):
        ...
    rcac_experiments.sweeps._problems.StoreError: /... cannot be read: there is no such folder.
    """
    with Folder(store) as opened:
        return table_in(opened)


def table_in(store: Folder, guarded: bool = True) -> SweepTable:
    """The table of an open store."""
    about = store.study
    results, failures = [_piece({}, about.measures)], [_piece({}, ())]
    for chunk in store.results(guarded=guarded):
        # Chunk by chunk as arrays, so that a large table is never held as Python's objects.
        piece = _piece(chunk.columns, about.measures)
        failed = np.array([outcome in FAILED for outcome in piece["outcome"]])
        results.append({name: values[~failed] for name, values in piece.items()})
        names = failures[0]
        failures.append({name: piece[name][failed] for name in names})
    return SweepTable(
        _joined(results, store, about.measures), about.axes, about.measures,
        _joined(failures, store, ()),
    )  # fmt: skip


def _piece(columns: Columns, measures: tuple[str, ...]) -> Columns:
    kinds: dict[str, Any] = dict.fromkeys(("run", "cell", "repetition"), np.int64)
    kinds |= dict.fromkeys(("outcome", "failure"), object)
    kinds |= dict.fromkeys(measures, np.float64)
    return {name: np.array(columns.get(name, ()), dtype=kind) for name, kind in kinds.items()}


def _joined(pieces: list[Columns], store: Folder, measures: tuple[str, ...]) -> Columns:
    """The columns in their order, the coordinates put in."""
    joined = {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}
    ordered = {name: joined[name] for name in ("run", "cell", "repetition")}
    ordered |= store.cell_columns(joined["cell"])
    return ordered | {name: joined[name] for name in ("outcome", "failure", *measures)}
