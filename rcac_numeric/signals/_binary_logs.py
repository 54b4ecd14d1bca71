"""Logs that a library reads: HDF5 (.mat of version 7.3), Parquet, ULog, spreadsheets.

What a file asks for is counted before it is read, by the shapes that it states.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, redirect_stdout
from datetime import date, datetime, time, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.arrays._files import MOST_BYTES
from rcac_numeric.arrays._frames import imported
from rcac_numeric.arrays._untrusted import ReadingLimit
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.signals._log_contents import LogColumn
from rcac_numeric.signals._mat_files import DEEPEST, MOST_PARTS
from rcac_numeric.signals._text_tables import Unpacked

PARTS_OF_A_VARIABLE = ("type", "value")  # of Octave's HDF5 files


@contextmanager
def reading(file: Path, subject: str) -> Iterator[None]:
    """Turn any error of a library about a file into one of ours."""
    try:
        yield
    except (CompensatorError, MemoryError):
        raise
    except Exception as error:  # each library raises its own, and that of its libraries
        words = shortened(str(error) or type(error).__name__, 200)
        raise InputError(f"{file} is not {subject} that can be read: {words}.") from None


# HDF5


def read_hdf5(file: Path, *, is_matlab: bool) -> dict[str, Any]:
    """Read the data sets of an HDF5 file by name, groups as dict; MATLAB's columns come first."""
    h5py = imported("h5py")
    with reading(file, "an HDF5 file"), h5py.File(file, "r") as opened:
        reader = _Hdf5(h5py, opened, ReadingLimit(file), is_matlab)
        return {
            name: reader.value(opened[name], 0)
            for name in opened
            if not name.startswith("#") and name in opened
        }


class _Hdf5:
    """Values of data sets and groups; the sizes are counted before they are read."""

    def __init__(self, h5py: Any, file: Any, limit: ReadingLimit, is_matlab: bool) -> None:
        self.h5py, self.file, self.limit, self.is_matlab = h5py, file, limit, is_matlab
        self.parts = 0

    def value(self, item: Any, depth: int) -> Any:
        self.parts += 1
        if depth > DEEPEST or self.parts > MOST_PARTS:
            raise ValueError(f"it is nested more than {DEEPEST} deep, or has too many parts")
        if isinstance(item, self.h5py.Group):
            names = list(item)
            if sorted(names) == sorted(PARTS_OF_A_VARIABLE) and "OCTAVE_NEW_FORMAT" in item.attrs:
                value = self.value(item["value"], depth + 1)
                is_turned = isinstance(value, np.ndarray) and not self.is_matlab
                return value.T if is_turned else value
            return {name: self.value(item[name], depth + 1) for name in names}
        if not isinstance(item, self.h5py.Dataset) or item.shape is None:
            return None
        kind = item.attrs.get("MATLAB_class", b"")
        if kind == b"char":
            self.limit.take(item.shape)
            return "".join(map(chr, np.asarray(item[()]).T.ravel(order="F")))
        if item.dtype.kind == "O":
            if not self.h5py.check_ref_dtype(item.dtype):
                return None
            self.limit.take(item.shape)
            return [self.value(self.file[ref], depth + 1) for ref in item[()].ravel()]
        if item.dtype.names is not None:
            if set(item.dtype.names) != {"real", "imag"}:
                return None
            self.limit.take((*item.shape, 2))
            pair = item[()]
            return (pair["real"] + 1j * pair["imag"]).T
        if item.dtype.kind not in "iufb" or "MATLAB_empty" in item.attrs:
            return None
        self.limit.take(item.shape)
        values = np.asarray(item[()])
        return values.T if self.is_matlab else values


# Parquet


def read_parquet(file: Path) -> list[LogColumn]:
    """Read the columns of numbers and time stamps of a Parquet file."""
    parquet, types = (imported(f"pyarrow.{part}", "logs") for part in ("parquet", "types"))
    with reading(file, "a Parquet file"):
        opened = parquet.ParquetFile(file)
        schema, rows = opened.schema_arrow, opened.metadata.num_rows
        limit = ReadingLimit(file)
        columns = []
        for field in schema:
            name = "index" if field.name.startswith("__index_level_") else field.name
            kind = field.type
            is_list = types.is_list(kind) or types.is_fixed_size_list(kind)
            is_number = types.is_integer(kind) or types.is_floating(kind) or types.is_boolean(kind)
            is_number |= types.is_decimal(kind)
            is_stamp = types.is_timestamp(kind) or types.is_duration(kind)
            if not (is_number or is_stamp or is_list):
                problem = f"{file}, column {shortened(name, 60)}: {kind} is not a number."
                columns.append(LogColumn(name, None, stored=str(kind), problem=problem))
                continue
            limit.take([rows])
            chunks = opened.read(columns=[field.name]).column(0).combine_chunks()
            columns.append(_of_arrow(name, chunks, str(kind), is_list, is_stamp, limit))
        return columns


def _of_arrow(
    name: str, chunk: Any, kind: str, is_list: bool, is_stamp: bool, limit: ReadingLimit
) -> LogColumn:
    """A column of a chunk of Arrow; lists of one length become components."""
    if is_list:
        values = chunk.flatten()
        limit.take([len(values)])
        width, rest = divmod(len(values), max(len(chunk), 1))
        if rest or chunk.null_count:
            return LogColumn(
                name, None, stored=kind, problem=f"column {name}: lists of several lengths"
            )
        numbers = values.to_numpy(zero_copy_only=False).astype(np.float64)
        return LogColumn(name, numbers.reshape(len(chunk), width), stored=kind)
    if is_stamp:
        counts = chunk.cast("int64").to_numpy(zero_copy_only=False)
        unit = next((u for u in ("ns", "us", "ms", "s") if f"[{u}" in kind), "s")
        return LogColumn(name, seconds_of_counts(counts, unit), stored="time stamps")
    numbers = chunk.to_numpy(zero_copy_only=False)
    values = (
        np.array([np.nan if v is None else float(v) for v in numbers])
        if (numbers.dtype.kind == "O")
        else numbers.astype(np.float64)
    )
    return LogColumn(name, values, stored={"double": "float64", "float": "float32"}.get(kind, kind))


def seconds_of_counts(counts: np.ndarray, unit: str) -> np.ndarray:
    """Return counts of a unit of time in seconds from the first one, without loss."""
    first = counts[np.isfinite(counts)][:1]
    scale = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}[unit]
    return np.asarray((counts - first if len(first) else counts) / scale, dtype=np.float64)


# ULog


def read_ulog(file: Path) -> tuple[list[LogColumn], list[str]]:
    """Read the topics of a ULog file, a clock for each; and notes about dropouts."""
    pyulog = imported("pyulog")
    with reading(file, "a ULog file"), file.open("rb") as stream:
        with redirect_stdout(io.StringIO()):  # pyulog prints what it finds damaged
            log = pyulog.ULog(stream)
        limit, columns = ReadingLimit(file), []
        several = {data.name for data in log.data_list if data.multi_id}
        for data in log.data_list:
            topic = f"{data.name}_{data.multi_id}" if data.name in several else data.name
            for name, values in data.data.items():
                limit.take(values.shape)
                is_clock = name == "timestamp"
                numbers = values / 1e6 if is_clock else values.astype(np.float64)
                columns.append(
                    LogColumn(
                        name, numbers, topic=topic, stored=str(values.dtype),
                        unit="s" if is_clock else "",
                    )
                )  # fmt: skip
        lost = [dropout.duration / 1e3 for dropout in log.dropouts]
    notes = []
    if lost:
        notes.append(
            f"the logger reports {len(lost)} dropouts of {sum(lost):.3g} s together, the longest "
            f"of {max(lost):.3g} s"
        )
    return columns, notes


# Spreadsheets


def read_spreadsheet(file: Path) -> dict[str, Unpacked]:
    """Return the sheets that have rows, by their titles, as text with tabs."""
    openpyxl = imported("openpyxl")
    sheets = {}
    with reading(file, "a spreadsheet"):
        with zipfile.ZipFile(file) as archive:
            if sum(member.file_size for member in archive.infolist()) > MOST_BYTES:
                raise InputError(f"{file} unpacks to more than {MOST_BYTES} bytes. Cut it.")
        book = openpyxl.load_workbook(file, read_only=True, data_only=True)
        limit = ReadingLimit(file)
        for sheet in book.worksheets:
            rows = []
            for row in sheet.iter_rows(values_only=True):
                limit.take([max(len(row), 1)])
                rows.append([*map(_entry, row)])
            if sum(any(row) for row in rows) > 1:
                # A sheet may end each row at its last cell.
                width = max(i for row in rows for i, entry in enumerate(row, 1) if entry)
                lines = ["\t".join([*row[:width], *[""] * (width - len(row))]) for row in rows]
                data = "\n".join([*lines, ""]).encode()
                # Lines of a .csv pasted into one column have a separator in their cells.
                separator = "\t" if width > 1 else ""
                sheets[sheet.title] = Unpacked(f"{file}, sheet {sheet.title!r}", data, separator)
    if not sheets:
        raise InputError(f"{file} has no sheet with rows of numbers.")
    return sheets


def _entry(value: Any) -> str:
    """The text of a cell."""
    if value is None:
        return ""
    if isinstance(value, datetime | date | time):
        return value.isoformat(" ") if isinstance(value, datetime) else value.isoformat()
    if isinstance(value, timedelta):
        return f"0 days {value}" if value.days == 0 else str(value)
    if isinstance(value, bool | float | int):
        return repr(value)
    return " ".join(str(value).split())


def tree_columns(tree: Mapping[str, Any]) -> Iterator[LogColumn]:
    """The arrays in nested structures as columns, each structure a topic.

    Simulink's structure with time is `time` beside `signals`; a time series as structure is `Time`
    beside `Data`.
    """
    for name, value in tree.items():
        yield from _walk(name, value, "")


def _walk(name: str, value: Any, topic: str) -> Iterator[LogColumn]:
    if isinstance(value, np.ndarray):
        if value.size and value.dtype.kind in "iufbcmM":
            yield _array_column(name, value, topic)
        return
    path = f"{topic}.{name}" if topic else name
    if isinstance(value, list):
        for i, part in enumerate(value, 1):
            if isinstance(part, dict | list):
                label = _label(part, "") if isinstance(part, dict) else ""
                yield from _walk(label or f"{name}({i})", part, topic)
        return
    if not isinstance(value, dict):
        return
    fields = {key.lower(): part for key, part in value.items()}
    if "signals" in fields and "time" in fields:
        yield from _with_time(name, path, fields)
    elif "time" in fields and "data" in fields:
        label = _label(value, name)
        for key, part in (("time", fields["time"]), (label, fields["data"])):
            yield from _walk(key, _steps_first(part), path)
    elif "values" in fields and isinstance(fields["values"], dict):  # an element of a logsout
        yield from _walk(
            _label(value, name), {"Name": _label(value, name), **fields["values"]}, topic
        )
    else:
        for key, part in value.items():
            yield from _walk(key, part, path)


def _with_time(name: str, path: str, fields: Mapping[str, Any]) -> Iterator[LogColumn]:
    """The signals of a structure with time."""
    signals = fields["signals"]
    parts = [signals] if isinstance(signals, dict) else signals
    if not isinstance(parts, list):
        return
    yield from _walk("time", fields["time"], path)
    for i, part in enumerate(parts, 1):
        if not isinstance(part, dict):
            continue
        label = part.get("label") or str(part.get("blockName") or "").rpartition("/")[2]
        label = str(label or (name if len(parts) == 1 else f"{name}{i}"))
        yield from _walk(label, _steps_first(part.get("values")), path)


def _label(value: Mapping[str, Any], default: str) -> str:
    """The name that a time series or a logged signal has, or the default."""
    name = value.get("Name") or value.get("name") or default
    return name if isinstance(name, str) and name.strip() else default


def _steps_first(values: Any) -> Any:
    """Simulink stores vectors as width x 1 x steps."""
    if isinstance(values, np.ndarray) and values.ndim == 3 and 1 in values.shape[:2]:
        return np.moveaxis(values, -1, 0).reshape(values.shape[-1], -1)
    return values


def _array_column(name: str, value: np.ndarray, topic: str) -> LogColumn:
    if value.dtype.kind in "mM":
        counts, unit = value.astype(f"{value.dtype.kind}8[ns]").astype(np.int64), "ns"
        return LogColumn(name, seconds_of_counts(counts, unit), topic=topic, stored="time stamps")
    numbers = value
    if value.dtype.kind != "c":
        with np.errstate(invalid="ignore"):  # a NaN of single precision may be signalling
            numbers = np.asarray(value, dtype=np.float64)
    return LogColumn(name, numbers, topic=topic, stored=str(value.dtype))
