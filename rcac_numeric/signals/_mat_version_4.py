"""Numeric variables of .mat files of version 4: a header of five integers, a name, the numbers."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._untrusted import ReadingLimit

PRECISIONS = ("f8", "f4", "i4", "i2", "u2", "u1")
FULL, SPARSE = 0, 2
LONGEST_NAME = 1000


def read_version_4(contents: bytes, limit: ReadingLimit) -> dict[str, np.ndarray]:
    """Read the numeric arrays by name; texts are skipped."""
    variables: dict[str, np.ndarray] = {}
    view = memoryview(contents)
    try:
        order = "<" if struct.unpack("<i", view[:4])[0] in range(5000) else ">"
        while view:
            name, values, view = _variable(view, order, limit)
            if values is not None:
                variables[name] = values
    except (struct.error, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{limit.file} is not a .mat file that can be read: {error}.") from None
    return variables


def _variable(view: memoryview, order: str, limit: ReadingLimit) -> tuple[str, Any, memoryview]:
    kind, rows, columns, is_complex, length = struct.unpack(order + "5i", view[:20])
    _, precision, shape_of_it = kind // 100, kind // 10 % 10, kind % 10
    if kind not in range(5000) or precision >= len(PRECISIONS):
        raise ValueError(f"a variable has the type {kind}")
    if rows < 0 or columns < 0 or not 0 < length <= LONGEST_NAME:
        raise ValueError(f"a variable has the shape {rows} x {columns}")
    name = bytes(view[20 : 20 + length]).split(b"\0")[0].decode("latin-1")
    view = view[20 + length :]
    dtype = np.dtype(PRECISIONS[precision]).newbyteorder(order)  # type: ignore[arg-type]
    parts = []
    for _ in range(2 if is_complex and shape_of_it != SPARSE else 1):
        size = rows * columns * dtype.itemsize
        if size > len(view):
            raise ValueError(f"{rows} x {columns} numbers do not fit in {len(view)} bytes")
        numbers = np.frombuffer(view[:size], dtype).reshape((rows, columns), order="F")
        parts.append(numbers.astype(PRECISIONS[precision]))
        view = view[size:]
    if shape_of_it == SPARSE:
        return name, _sparse(parts[0], limit), view
    if shape_of_it != FULL:
        return name, None, view
    limit.take((rows, columns))
    return name, parts[0] if len(parts) == 1 else _complex(*parts), view


def _sparse(table: np.ndarray, limit: ReadingLimit) -> np.ndarray:
    """Return a full array from rows (i, j, value) or (i, j, real, imaginary), counted from 1."""
    if len(table) < 1 or table.shape[1] not in (3, 4) or not (abs(table[:, :2]) < 2**31).all():
        raise ValueError("a sparse matrix has no shape")
    where = table[:, :2].astype(np.int64)
    shape = (int(where[-1, 0]), int(where[-1, 1]))
    entries = where[:-1] - 1
    if min(shape) < 0 or (entries < 0).any() or (entries >= np.array(shape)).any():
        raise ValueError("a sparse matrix has entries outside of it")
    limit.take(shape)
    values = table[:-1, 2] if table.shape[1] == 3 else _complex(table[:-1, 2], table[:-1, 3])
    full = np.zeros(shape, dtype=values.dtype)
    np.add.at(full, (entries[:, 0], entries[:, 1]), values)
    return full


def _complex(real: np.ndarray, imaginary: np.ndarray) -> np.ndarray:
    values = real.astype(np.complex128)
    values.imag = imaginary
    return values
