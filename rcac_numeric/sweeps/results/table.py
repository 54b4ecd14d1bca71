"""The results of a study as a table: one row for each run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compensator_theory.errors import InputError
from rcac_numeric.arrays import frames
from rcac_numeric.arrays.values import Value
from rcac_numeric.experiments.format.places import did_you_mean
from rcac_numeric.sweeps.store.reading import cell_columns, column, stored_runs
from rcac_numeric.sweeps.store.store import Store

Columns = dict[str, NDArray[Any]]


@dataclass(frozen=True, eq=False, init=False)
class SweepTable(Value):
    """The results of a study.

    Attributes
    ----------
    columns : dict from names to arrays
        run, cell, repetition, then the coordinates, outcome, failure, and the measures (NaN where
        there is none).
    axes, measures : tuple of str
        Which columns are coordinates, and which measures.
    """

    columns: Columns
    axes: tuple[str, ...]
    measures: tuple[str, ...]

    def __init__(
        self,
        columns: Mapping[str, NDArray[Any]],
        axes: tuple[str, ...],
        measures: tuple[str, ...],
    ) -> None:
        object.__setattr__(self, "columns", dict(columns))
        object.__setattr__(self, "axes", tuple(axes))
        object.__setattr__(self, "measures", tuple(measures))

    def __len__(self) -> int:
        return len(self.columns["run"])

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name not in self.columns:
            raise InputError(
                f"the table has no column {name!r}; it has {', '.join(self.columns)}."
                f"{did_you_mean(name, self.columns)}"
            )
        return self.columns[name]

    def where(self, **coordinates: Any) -> SweepTable:
        """The rows at these coordinates.

        Examples
        --------
        >>> import numpy as np
        >>> from rcac_numeric import SweepTable
        >>> table = SweepTable(
        ...     {"run": np.arange(4), "n_c": np.array([1, 1, 2, 2])}, ("n_c",), ())
        >>> table.where(n_c=2)["run"]
        array([2, 3])
        """
        chosen = np.ones(len(self), dtype=bool)
        for name, value in coordinates.items():
            chosen &= np.asarray(self[name] == value)
        columns = {name: values[chosen] for name, values in self.columns.items()}
        return SweepTable(columns, self.axes, self.measures)

    def to_pandas(self) -> frames.DataFrame:
        """The table as a `pandas.DataFrame`, indexed by the run."""
        return frames.imported("pandas").DataFrame(self.columns).set_index("run")

    def to_xarray(self) -> frames.Dataset:
        """The measures and the outcome over the axes and the repetition, an `xarray.Dataset`."""
        xarray = frames.imported("xarray")
        frame = self.to_pandas().drop(columns="cell")
        return xarray.Dataset.from_dataframe(frame.set_index([*self.axes, "repetition"]))

    def __repr__(self) -> str:
        return f"SweepTable({len(self)} runs; {', '.join([*self.axes, *self.measures])})"


def read_table(store: str | Path) -> SweepTable:
    """The runs of a store that have ended, by increasing number; see `run_study`.

    Raises
    ------
    StoreError
        Where the file is no store, or any number in it is not what was written.

    Examples
    --------
    >>> import tempfile
    >>> from rcac_numeric import read_table
    >>> read_table(tempfile.mkdtemp() + "/nothing.sqlite")
    Traceback (most recent call last):
        ...
    rcac_numeric.sweeps.store.problems.StoreError: /... cannot be read: there is no such file.
    """
    with Store(store, read_only=True) as opened:
        return table_in(opened)


def table_in(store: Store) -> SweepTable:
    """The table of an open store."""
    resolved = store.study.resolved
    axes = tuple(axis["name"] for axis in resolved["axes"])
    measures = tuple(kept["name"] for kept in resolved["keep"])
    pieces = list(_pieces(stored_runs(store), measures))
    columns: Columns = {
        name: np.concatenate([piece[name] for piece in pieces])
        if pieces
        else np.zeros(0, dtype=object if name in ("outcome", "failure") else np.float64)
        for name in ("run", "cell", "repetition", "outcome", "failure", *measures)
    }
    cells = columns["cell"].astype(np.int64)
    coordinates = {name: values[cells] for name, values in cell_columns(store).items()}
    ordered = {name: columns[name] for name in ("run", "cell", "repetition")}
    ordered |= coordinates
    ordered |= {name: columns[name] for name in ("outcome", "failure", *measures)}
    return SweepTable(ordered, axes, measures)


def _pieces(
    chunks: Iterator[list[tuple[Any, ...]]], measures: tuple[str, ...]
) -> Iterator[Columns]:
    """Chunk by chunk as arrays, so that a large table is never held as Python's objects."""
    for rows in chunks:
        by_column = list(zip(*rows, strict=True))
        piece: Columns = {
            name: column(list(values))
            for name, values in zip(("run", "cell", "repetition"), by_column[:3], strict=True)
        }
        for name, values in zip(("outcome", "failure"), by_column[3:5], strict=True):
            piece[name] = np.array(values, dtype=object)
        for name, values in zip(measures, by_column[5:], strict=True):
            piece[name] = np.array(values, dtype=np.float64)
        yield piece
