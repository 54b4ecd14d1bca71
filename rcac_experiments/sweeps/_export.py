"""The results of a study as files for other programs, written in pieces of a bounded size."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from compensator_theory.errors import InputError
from rcac_experiments.sweeps._chunk import FAILED
from rcac_experiments.sweeps._folder import Folder
from rcac_experiments.sweeps._table import Columns
from rcac_numeric.arrays._files import replacing
from rcac_numeric.arrays._frames import imported
from rcac_numeric.arrays._wording import spreadsheet_text

AT_ONCE = 50_000  # rows of a piece of Parquet


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
    >>> from rcac_experiments.sweeps import Kept, Study, export_table, run_study
    >>> base = {
    ...     "plant": {"problem": "standard", "G": "1/(q - 0.9)"}, "signals": {"w": {"step": 1}},
    ...     "target": {"model": "fir"}, "controller": {"n_c": 2, "R_theta": 1},
    ...     "run": {"steps": 50}}
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> _ = run_study(Study(base, [], [Kept("steps")]), folder / "study", workers=0)
    >>> export_table(folder / "study", folder / "study.csv")
    >>> print((folder / "study.csv").read_text().strip())
    "run","cell","repetition","outcome","failure","steps"
    0,0,0,"completed","",50.0
    """
    suffix = Path(path).suffix.lower()
    if suffix not in WRITERS:
        raise InputError(f"{path}: the name must end in one of {', '.join(WRITERS)}.")
    with Folder(store) as opened, replacing(path) as new:
        WRITERS[suffix](opened, new)


def _write_csv(store: Folder, path: Path) -> None:
    names, rows = _rows(store)
    with path.open("w", newline="", encoding="utf-8") as file:
        for some in itertools.chain([[tuple(names)]], rows):
            file.writelines(f"{','.join(map(_cell, row))}\n" for row in some)


def _write_parquet(store: Folder, path: Path) -> None:
    arrow, parquet = imported("pyarrow"), imported("pyarrow.parquet")
    names, rows = _rows(store)
    axes = store.cell_columns([])
    kinds = [_arrow_type(arrow, axes, name) for name in names]
    schema = arrow.schema(list(zip(names, kinds, strict=True)))
    with parquet.ParquetWriter(str(path), schema) as writer:
        for piece in _pieces(rows):
            arrays = [
                arrow.array(
                    [_plain(value, kind, arrow) for value in values], type=kind,
                    from_pandas=kind == arrow.float64(),
                )
                for values, kind in zip(zip(*piece, strict=True), kinds, strict=True)
            ]  # fmt: skip
            writer.write_batch(arrow.record_batch(arrays, schema=schema))


def _rows(store: Folder) -> tuple[list[str], Iterator[list[tuple[Any, ...]]]]:
    """The names of the columns, and their rows chunk by chunk, coordinates put in."""
    about = store.study
    names = ["run", "cell", "repetition", *about.axes, "outcome", "failure", *about.measures]
    outcome = names.index("outcome")

    def rows() -> Iterator[list[tuple[Any, ...]]]:
        for chunk in store.results():
            known = chunk.columns | store.cell_columns(chunk.columns["cell"])
            rows = zip(*(_listed(known[name]) for name in names), strict=True)
            yield [row for row in rows if row[outcome] not in FAILED]

    return names, rows()


def _listed(values: Any) -> list[Any]:
    return list(values.tolist() if hasattr(values, "tolist") else values)


def _pieces(rows: Iterator[list[tuple[Any, ...]]]) -> Iterator[list[tuple[Any, ...]]]:
    piece: list[tuple[Any, ...]] = []
    for some in rows:
        piece += some
        if len(piece) >= AT_ONCE:
            yield piece
            piece = []
    if piece:
        yield piece


def _cell(value: Any) -> str:
    """A number, or a text in quotes; None and NaN are nothing."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, list | dict):
        value = json.dumps(value)
    if isinstance(value, str):
        return '"' + spreadsheet_text(value).replace('"', '""') + '"'
    return str(value)


def _arrow_type(arrow: Any, axes: Columns, name: str) -> Any:
    if name in axes:
        kinds = {"i": arrow.int64(), "f": arrow.float64(), "b": arrow.bool_()}
        return kinds.get(axes[name].dtype.kind, arrow.string())
    if name in ("run", "cell", "repetition"):
        return arrow.int64()
    return arrow.string() if name in ("outcome", "failure") else arrow.float64()


def _plain(value: Any, kind: Any, arrow: Any) -> Any:
    plain = value.item() if hasattr(value, "item") else value
    return json.dumps(plain) if kind == arrow.string() and not isinstance(plain, str) else plain


WRITERS: dict[str, Callable[[Folder, Path], None]] = {
    ".csv": _write_csv,
    ".parquet": _write_parquet,
}
