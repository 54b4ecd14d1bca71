"""Variables of a log file, whatever wrote it: .csv, .mat up to version 7, .npz."""

from __future__ import annotations

import csv
import re
import warnings
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array

FORMATS = (".csv", ".mat", ".npz")
# u1, u_1, u(1) and u[1] are all the first component of u.
NUMBERED = re.compile(r"(.*?[^\W\d_])[_(\[]?(\d+)[)\]]?$")


def read_variables(path: str | Path) -> dict[str, Array]:
    r"""Every numeric variable of a file, by name.

    Parameters
    ----------
    path : path
        A .csv file has a row of names and then one row for each step, separated by commas,
        semicolons or tabs; the columns u1, u2, ... are also found together as u. A .mat file is of
        version 4, 5, 6 or 7. A .npz file holds arrays.

    Raises
    ------
    InputError
        If the file cannot be read, is empty, or an entry is no number.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from rcac_numeric.signals.data_files import read_variables
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "log.csv"
    >>> _ = file.write_text("u, y1, y2\n0, 1, 2\n0.5, 3, 4\n")
    >>> variables = read_variables(file)
    >>> variables["u"].shape, variables["y"].tolist()
    ((2, 1), [[1.0, 2.0], [3.0, 4.0]])
    """
    file = Path(path)
    readers = {".csv": _from_csv, ".mat": _from_mat, ".npz": _from_npz}
    suffix = file.suffix.lower()
    if suffix not in readers:
        raise InputError(f"{file} is not a log that can be read; use {', '.join(FORMATS)}.")
    try:
        if file.stat().st_size == 0:
            raise InputError(f"{file} is empty.")
        found = readers[suffix](file)
    except OSError as error:
        raise InputError(f"{file} cannot be read: {error.strerror or error}.") from None
    if not found:
        raise InputError(f"{file} holds no numeric variable.")
    return found


def _from_csv(file: Path) -> dict[str, Array]:
    try:
        with file.open(newline="", encoding="utf-8-sig") as stream:
            line, names, delimiter = _head(file, stream)
            table = _table(stream, delimiter)
        if table is None or table.shape[1] != len(names):  # slower, but it knows what is wrong
            with file.open(newline="", encoding="utf-8-sig") as stream:
                table = _checked_table(file, stream, line, names, delimiter)
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{file} is not a text file of numbers: {error}.") from None
    if not len(table):
        raise InputError(f"{file} has the names {', '.join(names)} and no row of numbers.")
    return _grouped({name: table[:, [j]] for j, name in enumerate(names)})


def _head(file: Path, stream: TextIO) -> tuple[int, list[str], str]:
    """The line of the names, the names, and what separates them: a comma, semicolon or tab."""
    names: list[str] = []
    line = 0
    for text in stream:
        line += 1
        delimiter = next((d for d in ",;\t" if d in text), ",")
        row = next(csv.reader([text], delimiter=delimiter), [])
        names = [entry.strip() for entry in row]
        if any(names):
            break
    if not any(names):
        raise InputError(f"{file} is empty.")
    if all(as_number(name) is not None for name in names):
        raise InputError(
            f"{file} begins with numbers; its first row must name the columns, for instance u,y,z."
        )
    if len(set(names)) < len(names) or not all(names):
        raise InputError(
            f"{file}, line {line}: the columns are named {', '.join(names)}; each needs a "
            "name of its own."
        )
    return line, names, delimiter


def _table(stream: TextIO, delimiter: str) -> Array | None:
    """The rest of the file by NumPy's own reader; None where an entry or a row is not right."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # no row at all is said by the caller
            table = np.loadtxt(stream, delimiter=delimiter, comments=None, ndmin=2, quotechar='"')
    except ValueError:
        return None
    return np.asarray(table, dtype=np.float64)


def _checked_table(
    file: Path, stream: TextIO, head: int, names: list[str], delimiter: str
) -> Array:
    rows = []
    for line, row in enumerate(csv.reader(stream, delimiter=delimiter), 1):
        if line <= head or not any(row):
            continue
        if len(row) != len(names):
            raise InputError(
                f"{file}, line {line}: {len(row)} entries where {len(names)} are needed, one for "
                "each named column."
            )
        rows.append(
            [_entry(file, line, name, entry) for name, entry in zip(names, row, strict=True)]
        )
    return np.array(rows, dtype=np.float64).reshape(len(rows), len(names))


def _entry(file: Path, line: int, name: str, entry: str) -> float:
    value = as_number(entry)
    if value is not None:
        return value
    hint = " Write decimals with a point." if as_number(entry.replace(",", ".")) is not None else ""
    raise InputError(
        f"{file}, line {line}, column {name}: {entry.strip()!r} is not a number.{hint}"
    )


def _grouped(columns: dict[str, Array]) -> dict[str, Array]:
    """The columns, and under the common name those that are numbered without a gap."""
    members: dict[str, dict[int, Array]] = {}
    for name, values in columns.items():
        if match := NUMBERED.match(name):
            members.setdefault(match[1], {})[int(match[2])] = values
    together = {}
    for name, parts in members.items():
        first, last = min(parts), max(parts)
        if first in (0, 1) and last - first + 1 == len(parts) and name not in columns:
            together[name] = np.hstack([parts[i] for i in sorted(parts)])
    return {**columns, **together}


def _from_mat(file: Path) -> dict[str, Array]:
    from scipy.io import loadmat

    try:
        contents = loadmat(str(file))
    except NotImplementedError:
        raise InputError(
            f"{file} is a .mat file of version 7.3 (HDF5), which is not read here. Save it with "
            "save('-v7', ...) in MATLAB or Octave."
        ) from None
    except (ValueError, TypeError, EOFError, IndexError, KeyError) as error:
        raise InputError(f"{file} is not a .mat file that can be read: {error}.") from None
    except Exception as error:  # SciPy has errors of its own for damaged files
        raise InputError(f"{file} is a damaged .mat file: {error}.") from None
    return _numeric({k: v for k, v in contents.items() if not k.startswith("__")})


def _from_npz(file: Path) -> dict[str, Array]:
    try:
        with file.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
            contents = {name: archive[name] for name in archive.files}
    except OSError:
        raise
    except Exception as error:  # zipfile, NumPy and pickle each have their own
        raise InputError(f"{file} is not an .npz file of numbers: {error}.") from None
    return _numeric(contents)


def _numeric(contents: dict[str, Any]) -> dict[str, Array]:
    """The arrays of numbers. Complex ones stay so: who needs them as real numbers refuses them."""
    found: dict[str, Any] = {}
    for name, value in contents.items():
        if not isinstance(value, np.ndarray):
            value = getattr(value, "toarray", lambda: None)()  # a sparse matrix  # noqa: PLW2901
        if isinstance(value, np.ndarray) and value.dtype.kind in "iufb" and value.size:
            found[name] = np.asarray(value, dtype=np.float64)
        elif isinstance(value, np.ndarray) and value.dtype.kind == "c":
            found[name] = value
    return found


def as_number(text: str) -> float | None:
    """The number that a text is, or None; 1_000 is Python, and no number in a file."""
    try:
        return None if "_" in text else float(text)
    except ValueError:
        return None
