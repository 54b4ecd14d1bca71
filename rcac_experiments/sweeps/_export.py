"""The results of a study as files for other programs."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from compensator_theory.errors import InputError
from rcac_experiments.sweeps._table import SweepTable, read_table
from rcac_numeric.arrays._files import replacing
from rcac_numeric.arrays._frames import imported
from rcac_numeric.arrays._wording import spreadsheet_text

AT_ONCE = 50_000  # rows that are made Python's objects at a time


def export_table(store: str | Path, path: str | Path) -> None:
    """Write the results in a store to a .csv or a .parquet file, a row for each run.

    Runs that failed are no results, and are not in the file.

    Floats are written in full, and where there is no value, nothing; coordinates that are lists
    or tables as JSON. A text in a .csv file stands in quotes and is never a formula of a
    spreadsheet: one that begins as a formula does gets an apostrophe in front, and control
    characters are written out. Parquet keeps texts as they are; it needs pyarrow, which
    `compensator-theory[studies]` brings.

    Raises
    ------
    StoreError
        Where the store is damaged.
    InputError
        Where the file cannot be written, or pyarrow is missing; an older file stays whole.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from rcac_experiments.sweeps import Metric, Study, export_table, run_study
    >>> base = {
    ...     "plant": {"problem": "standard", "G": "1/(q - 0.9)"}, "signals": {"w": {"step": 1}},
    ...     "target": {"model": "fir"}, "controller": {"n_c": 2, "R_theta": 1},
    ...     "run": {"steps": 50}}
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> _ = run_study(Study(base, [], [Metric("steps")]), folder / "study", workers=0)
    >>> export_table(folder / "study", folder / "study.csv")
    >>> print((folder / "study.csv").read_text().strip())
    "run","cell","repetition","outcome","failure","steps"
    0,0,0,"completed","",50.0
    """
    suffix = Path(path).suffix.lower()
    if suffix not in WRITERS:
        raise InputError(f"{path}: the name must end in one of {', '.join(WRITERS)}.")
    table = read_table(store)
    with replacing(path) as new:
        WRITERS[suffix](table, new)


def _write_csv(table: SweepTable, path: Path) -> None:
    columns = table.columns.values()
    with path.open("w", newline="", encoding="utf-8") as file:
        file.write(f"{','.join(map(_cell, table.columns))}\n")
        for start in range(0, len(table), AT_ONCE):
            rows = zip(*(v[start : start + AT_ONCE].tolist() for v in columns), strict=True)
            file.writelines(f"{','.join(map(_cell, row))}\n" for row in rows)


def _write_parquet(table: SweepTable, path: Path) -> None:
    arrow, parquet = imported("pyarrow"), imported("pyarrow.parquet")
    columns = {
        name: arrow.array(list(map(_text, values)) if values.dtype == object else values,
                          from_pandas=name in table.measures)
        for name, values in table.columns.items()
    }  # fmt: skip
    parquet.write_table(arrow.table(columns), str(path))


def _cell(value: Any) -> str:
    """A number, or a text in quotes; None and NaN are nothing."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, list | dict):
        value = json.dumps(value)
    if isinstance(value, str):
        return '"' + spreadsheet_text(value).replace('"', '""') + '"'
    return str(value)


def _text(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)


WRITERS: dict[str, Callable[[SweepTable, Path], None]] = {
    ".csv": _write_csv,
    ".parquet": _write_parquet,
}
