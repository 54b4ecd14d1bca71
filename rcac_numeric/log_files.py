"""Variables of a log file, whatever wrote it: .csv, .mat up to version 7, .npz."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Any

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.validation import Array

FORMATS = (".csv", ".mat", ".npz")
# u1, u_1, u(1) and u[1] are all the first component of u.
NUMBERED = re.compile(r"(.*?[^\W\d_])[_(\[]?(\d+)[)\]]?$")


def read_variables(path: str | Path) -> dict[str, Array]:
    r"""Every numeric variable of a file, by name.

    Parameters
    ----------
    path : path
        A .csv file has a row of names and then one row for each step; the columns u1, u2, ... are
        also found together as u. A .mat file is of version 4, 5, 6 or 7. A .npz file holds arrays.

    Raises
    ------
    InputError
        If the file cannot be read, is empty, or an entry is no number.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from rcac_numeric.log_files import read_variables
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
            rows = [(i, row) for i, row in enumerate(csv.reader(stream), 1) if any(row)]
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{file} is not a text file of numbers: {error}.") from None
    if not rows:
        raise InputError(f"{file} is empty.")
    names = [entry.strip() for entry in rows[0][1]]
    if all(_number(name) is not None for name in names):
        raise InputError(
            f"{file} begins with numbers; its first row must name the columns, for instance u,y,z."
        )
    if len(set(names)) < len(names) or not all(names):
        raise InputError(
            f"{file}, line {rows[0][0]}: the columns are named {', '.join(names)}; each needs a "
            "name of its own."
        )
    if len(rows) == 1:
        raise InputError(f"{file} has the names {', '.join(names)} and no row of numbers.")
    table = np.empty((len(rows) - 1, len(names)))
    for i, (line, row) in enumerate(rows[1:]):
        if len(row) != len(names):
            raise InputError(
                f"{file}, line {line}: {len(row)} entries where {len(names)} are needed, one for "
                "each named column."
            )
        for j, entry in enumerate(row):
            value = _number(entry)
            if value is None:
                raise InputError(
                    f"{file}, line {line}, column {names[j]}: {entry.strip()!r} is not a number."
                )
            table[i, j] = value
    return _grouped({name: table[:, [j]] for j, name in enumerate(names)})


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
    return _numeric({k: v for k, v in contents.items() if not k.startswith("__")}, file)


def _from_npz(file: Path) -> dict[str, Array]:
    try:
        with file.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
            contents = {name: archive[name] for name in archive.files}
    except OSError:
        raise
    except Exception as error:  # zipfile, NumPy and pickle each have their own
        raise InputError(f"{file} is not an .npz file of numbers: {error}.") from None
    return _numeric(contents, file)


def _numeric(contents: dict[str, Any], file: Path) -> dict[str, Array]:
    found = {}
    for name, value in contents.items():
        if not isinstance(value, np.ndarray):
            value = getattr(value, "toarray", lambda: None)()  # a sparse matrix  # noqa: PLW2901
        if isinstance(value, np.ndarray) and value.dtype.kind in "iufb" and value.size:
            found[name] = np.asarray(value, dtype=np.float64)
        elif isinstance(value, np.ndarray) and value.dtype.kind == "c":
            raise InputError(f"{file}: {name} is complex; signals and coefficients are real.")
    return found


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
