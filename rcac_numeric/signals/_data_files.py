"""Logs and arrays of files and data frames, all as one `LogContents`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._files import require_readable
from rcac_numeric.arrays._untrusted import read_npy, read_npz
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.signals._binary_logs import (
    read_hdf5,
    read_parquet,
    read_spreadsheet,
    read_ulog,
    tree_columns,
)
from rcac_numeric.signals._log_contents import MOST_STAMPS, LogColumn, LogContents
from rcac_numeric.signals._mat_files import MatObject, read_mat
from rcac_numeric.signals._text_tables import (
    BLANKS,
    MISSING,
    Dialect,
    TextColumn,
    TextSource,
    Unpacked,
    read_text_columns,
    refused_entry,
    require_names,
    split_unit,
    table_number,
    unpacked,
    without_head,
)

TEXTS = (".csv", ".txt", ".tsv", ".dat", ".asc", ".log")
ARRAYS = (".mat", ".npz", ".h5", ".hdf5")  # which may hold the matrices of a plant, too
READ = (*TEXTS, ".gz", *ARRAYS, ".npy", ".parquet", ".ulg", ".xlsx")
ELSEWHERE = {
    ".xls": "Save it as .xlsx or .csv", ".ods": "Save it as .xlsx or .csv",
    ".mcap": "Export its topics to .csv or .parquet", ".bag": "Export its topics to .csv",
    ".db3": "Export its topics to .csv", ".bin": "Convert it to .mat or .csv (mavlogdump.py)",
    ".tlog": "Convert it to .csv (mavlogdump.py)", ".json": "Write it as .csv or .npz",
    ".feather": "Write it as .parquet", ".pkl": "A pickle can run code: write .parquet or .npz",
    ".pickle": "A pickle can run code: write .parquet or .npz", ".slx": "Save its signals as .mat",
    ".mf4": "Export it to .csv or .mat (asammdf)", ".mdf": "Export it to .csv or .mat (asammdf)",
    ".tdms": "Export it to .csv",
}  # fmt: skip


LEAST_ROWS, LEAST_COLUMNS = 10, 2  # of a sheet that may be a log


def is_log_file(path: str | Path) -> bool:
    """Whether the name is one of a file of numbers."""
    return Path(path).suffix.lower() in READ


def read_variables(path: str | Path) -> dict[str, Array]:
    r"""Read every numeric variable of a file, by name."""
    contents = read_contents(path)
    if contents.format.startswith("text") and any(c.name == "" for c in contents.columns):
        raise without_head(contents.source)
    return contents.variables()


def read_contents(source: Any, columns: Sequence[str] = ()) -> LogContents:
    """Read the columns of a file, a data frame or a mapping of arrays.

    Parameters
    ----------
    source : path, DataFrame or mapping
    columns : sequence of str
        Names of the columns of a table, in place of its head.
    """
    if not isinstance(source, str | Path):
        return _of_frame(source) if hasattr(source, "columns") else _of_mapping(source)
    file = Path(source)
    suffix = file.suffix.lower()
    inner = file.with_suffix("").suffix.lower() if suffix == ".gz" else suffix
    if suffix not in READ or (suffix == ".gz" and inner not in TEXTS):
        if suffix in ELSEWHERE:
            raise InputError(f"{file} is not a log that is read here. {ELSEWHERE[suffix]}.")
        raise InputError(f"{file} is not a log that can be read; use {', '.join(READ)}.")
    try:
        require_readable(file)
        if inner in TEXTS:
            return _of_text(file, unpacked(file) if suffix == ".gz" else file, columns)
        if suffix == ".xlsx":
            return _of_sheets(file, read_spreadsheet(file), columns)
        return _of_arrays(file, suffix, columns)
    except OSError as error:
        raise InputError(f"{file} cannot be read: {error.strerror or error}.") from None


def _of_text(file: Path, text: TextSource, names: Sequence[str]) -> LogContents:
    notes: list[str] = []
    parts, dialect = read_text_columns(text, names, notes)
    columns = tuple(_of_text_column(part) for part in parts)
    return LogContents(str(file), _dialect_in_words(file, dialect), columns, notes=tuple(notes))


def _of_sheets(file: Path, sheets: Mapping[str, Unpacked], names: Sequence[str]) -> LogContents:
    """The tables of numbers in a workbook: one sheet as a table, several as topics."""
    tables: dict[str, LogContents] = {}
    sizes: dict[str, int] = {}
    problems: dict[str, InputError] = {}
    for title, text in sheets.items():
        try:
            tables[title] = _of_text(file, text, names)
            sizes[title] = _numeric_columns(tables[title])
        except InputError as error:
            problems[title] = error
    most = max(sizes.values(), default=0)
    titles = [title for title, size in sizes.items() if size >= min(most, LEAST_COLUMNS)]
    if not most:
        titles = [max(sheets, key=lambda title: len(sheets[title].data))]
        if titles[0] in problems:
            raise problems[titles[0]]
    notes = [note for title in titles for note in tables[title].notes]
    if rest := [repr(title) for title in sheets if title not in titles]:
        sheets_read = ", ".join(map(repr, titles))
        notes.append(f"read: sheet {sheets_read}; without a table of numbers: {', '.join(rest)}")
    words = f"text of the sheet{'s' * (len(titles) > 1)} {', '.join(map(repr, titles))}"
    if len(titles) == 1:
        source = str(sheets[titles[0]] if len(sheets) > 1 else file)
        table = tables[titles[0]]
        return attrs.evolve(table, source=source, format=words, notes=tuple(notes))
    columns = [attrs.evolve(c, topic=title) for title in titles for c in tables[title].columns]
    return LogContents(str(file), words, tuple(columns), notes=tuple(notes))


def _numeric_columns(table: LogContents) -> int:
    """Number of named columns with numbers in as many rows as a log has; a cover has fewer."""
    return sum(
        bool(c.name) and c.values is not None and c.rows - c.missing >= LEAST_ROWS
        for c in table.columns
    )


def _of_text_column(part: TextColumn) -> LogColumn:
    if not part.problem:
        return LogColumn(
            part.name, part.numbers, unit=part.unit, stored="printed", lines=part.lines
        )  # fmt: skip
    texts = tuple(part.texts[:MOST_STAMPS])
    return LogColumn(
        part.name, None, unit=part.unit, stored="text", problem=part.problem, texts=texts,
        lines=part.lines,
    )  # fmt: skip


def _dialect_in_words(file: Path, dialect: Dialect) -> str:
    names = {"\t": "tabs", BLANKS: "blanks"}
    words = f"text, columns separated by {names.get(dialect.separator, dialect.separator)}"
    words += ", decimal comma" if dialect.decimal == "," else ""
    words += f", {dialect.encoding}" if dialect.encoding not in ("utf-8-sig",) else ""
    return words + (", packed" if file.suffix.lower() == ".gz" else "")


def _of_arrays(file: Path, suffix: str, names: Sequence[str]) -> LogContents:
    notes: list[str] = []
    if suffix == ".parquet":
        columns = read_parquet(file)
    elif suffix == ".ulg":
        columns, notes = read_ulog(file)
    else:
        readers: dict[str, Callable[[Path], Mapping[str, Any]]] = {
            ".npz": read_npz,
            ".npy": lambda path: {"": read_npy(path)},
            ".mat": lambda path: _mat_tree(path, notes),
            ".h5": lambda path: read_hdf5(path, is_matlab=False),
            ".hdf5": lambda path: read_hdf5(path, is_matlab=False),
        }
        columns = list(tree_columns(readers[suffix](file)))
    if names or suffix == ".npy":
        columns = _split_matrix(file, columns, names)
    if not columns:
        raise InputError(f"{file} holds no numeric variable{_objects(notes)}.")
    return LogContents(str(file), suffix.removeprefix("."), tuple(columns), notes=tuple(notes))


def _mat_tree(file: Path, notes: list[str]) -> Mapping[str, Any]:
    """The variables of a .mat file of any version; a note names those that only MATLAB reads."""
    with file.open("rb") as stream:
        head = stream.read(520)
    is_hdf5 = head.startswith(b"\x89HDF") or head[512:].startswith(b"\x89HDF")
    tree = read_hdf5(file, is_matlab=True) if is_hdf5 else read_mat(file)
    for name, value in tree.items():
        if isinstance(value, MatObject):
            notes.append(
                f"{name or 'an object'} is a {value} of MATLAB, which only MATLAB reads: save "
                f"{_conversion(name, value)}"
            )
    return tree


def _conversion(name: str, kind: str) -> str:
    """The line of MATLAB that makes arrays of an object."""
    name = name or "x"
    if "Dataset" in kind:
        return f"u = {name}.get('u').Values.Data; t = {name}.get('u').Values.Time"
    if kind in {"table", "timetable"}:
        return f"u = {name}.u; y = {name}.y"
    if kind == "timeseries":
        return f"u = {name}.Data; t = {name}.Time"
    return "its arrays"


def _objects(notes: Sequence[str]) -> str:
    return f": {'; '.join(notes)}" if notes else ""


def _split_matrix(file: Path, columns: list[LogColumn], names: Sequence[str]) -> list[LogColumn]:
    """Name the columns of the one matrix of a file."""
    matrices = [c for c in columns if c.values is not None and c.values.ndim <= 2]
    if len(matrices) != 1 or matrices[0].values is None or not matrices[0].values.size:
        names = shortened(", ".join(c.full_name for c in columns), 200) or "nothing"
        raise InputError(
            f"{file}: columns = ... names the columns of one matrix; it holds {names}."
        )
    values = matrices[0].values
    values = values.reshape(-1, 1) if values.ndim < 2 else values
    if not names:
        names = [""] * values.shape[1]
    else:
        require_names(file, names, values.shape[1])
    return [
        LogColumn(name, column, stored=matrices[0].stored)
        for name, column in zip(names, values.T, strict=True)
    ]


# Data frames and mappings of arrays, which somebody's own program made.


def _of_mapping(source: Any) -> LogContents:
    if not isinstance(source, Mapping):
        raise InputError(
            f"a log is a file, a DataFrame or a mapping of arrays, not {type(source).__name__}."
        )
    arrays = {str(name): np.asarray(value) for name, value in source.items()}
    return LogContents("the log", "arrays", tuple(tree_columns(arrays)))


def _of_frame(frame: Any) -> LogContents:
    """The index and the columns of a DataFrame of pandas."""
    if not hasattr(frame, "index") or not hasattr(frame, "iloc"):
        raise InputError("the log has columns and no index; give a DataFrame of pandas.")
    if not len(frame):
        raise InputError("the DataFrame has no row.")
    index = frame.index
    columns = []
    name = str(index.name) if index.name is not None else "index"
    if getattr(index, "nlevels", 1) == 1 and name not in map(str, frame.columns):
        columns.append(_of_series(name, index))
    for i, label in enumerate(frame.columns):
        words = "_".join(map(str, label)) if isinstance(label, tuple) else str(label)
        columns.append(_of_series(words, frame.iloc[:, i]))
    return LogContents("the DataFrame", "DataFrame", tuple(columns))


def _numbers_of_texts(texts: Sequence[str]) -> Array:
    """The numbers of the texts before the first that is none, NaN where an entry is missing."""
    numbers = []
    for text in texts:
        value = np.nan if text.lower() in MISSING else table_number(text, ".")
        if value is None:
            break
        numbers.append(value)
    return np.array(numbers)


def _periods(series: Any) -> Any:
    """The begin of every period of a series or an index."""
    return getattr(series, "dt", series).to_timestamp()


def _of_series(name: str, series: Any) -> LogColumn:
    bare, unit = split_unit(name)
    kind = str(series.dtype)
    if kind.startswith("period"):
        series = _periods(series)
        kind = "datetime64"
    if kind.startswith(("datetime64", "timedelta64", "timestamp", "duration")):
        first = series.iloc[0] if hasattr(series, "iloc") else series[0]
        values = np.asarray((series - first) / np.timedelta64(1, "ns"), dtype=np.float64) / 1e9
        return LogColumn(bare, values, unit=unit, stored="time stamps")
    try:
        array = series.to_numpy(dtype=np.float64, na_value=np.nan)
        return LogColumn(bare, array, unit=unit, stored=kind.lower())
    except (TypeError, ValueError):
        pass
    texts = tuple(map(str, series[: min(len(series), MOST_STAMPS)]))
    numbers = _numbers_of_texts(texts)
    if len(numbers) == len(series):
        return LogColumn(bare, numbers, unit=unit, stored=kind)
    row, label = len(numbers), shortened(bare, 60)
    problem = f"the DataFrame, row {row + 1}, column {label}: "
    problem += refused_entry(texts[row]) if row < len(texts) else "its entries are texts."
    return LogColumn(bare, None, unit=unit, stored=kind, problem=problem, texts=texts)
