"""Variables of log files: .csv, .mat up to version 7, .npz."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._files import require_readable
from rcac_numeric.arrays._untrusted import read_npz
from rcac_numeric.signals._mat_files import read_mat
from rcac_numeric.signals._text_tables import read_table

FORMATS = (".csv", ".mat", ".npz")
# u1, u_1, u(1) and u[1] are all the first component of u.
NUMBERED = re.compile(r"(.*?[^\W\d_])[_(\[]?(\d{1,6})[)\]]?$")


def read_variables(path: str | Path) -> dict[str, Array]:
    r"""Read every numeric variable of a file, by name."""
    file = Path(path)
    readers: dict[str, Callable[[Path], Mapping[str, np.ndarray]]] = {
        ".csv": _columns, ".mat": read_mat, ".npz": read_npz,
    }  # fmt: skip
    suffix = file.suffix.lower()
    if suffix not in readers:
        raise InputError(f"{file} is not a log that can be read; use {', '.join(FORMATS)}.")
    try:
        require_readable(file)
        variables = _numeric(readers[suffix](file))
    except OSError as error:
        raise InputError(f"{file} cannot be read: {error.strerror or error}.") from None
    if not variables:
        raise InputError(f"{file} holds no numeric variable.")
    return variables


def _columns(file: Path) -> dict[str, Array]:
    """Return the columns; consecutively numbered columns also as one array."""
    names, table = read_table(file, named=True)
    columns = {name: table[:, [j]] for j, name in enumerate(names)}
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


def _numeric(contents: Mapping[str, np.ndarray]) -> dict[str, Array]:
    """Return the numeric arrays; the caller refuses complex ones if needed."""
    variables: dict[str, Array] = {}
    for name, value in contents.items():
        if value.dtype.kind in "iufb" and value.size:
            with np.errstate(invalid="ignore"):  # a NaN of single precision may be signalling
                variables[name] = np.asarray(value, dtype=np.float64)
        elif value.dtype.kind == "c":
            variables[name] = value
    return variables
