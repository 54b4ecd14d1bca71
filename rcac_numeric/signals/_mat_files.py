"""Safe reader of numeric variables of .mat files, versions 4 to 7.

SciPy's reader is C code that trusts the types and sizes in the file, and has a segmentation fault
where they are wrong; here every size is checked against what is there before it is used.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._files import MOST_BYTES
from rcac_numeric.arrays._untrusted import ReadingLimit
from rcac_numeric.signals._mat_version_4 import read_version_4

COMPRESSED, MATRIX = 15, 14
TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
# The class of a variable, and the type of its entries however they are stored.
CLASSES = {6: "f8", 7: "f4", 8: "i1", 9: "u1", 10: "i2", 11: "u2", 12: "i4", 13: "u4", 14: "i8",
           15: "u8"}  # fmt: skip
CELL, STRUCT, OBJECT, TEXT, SPARSE, OPAQUE = 1, 2, 3, 4, 5, 17
TEXTS = {1: "u1", 2: "u1", 4: "u2", 16: "u1", 17: "u2"}  # how characters are stored
DEEPEST = 12  # of structures
MOST_PARTS = 2**16  # of structures and cells
COMPLEX_FLAG = 0x0800


class DamagedError(ValueError):
    """A defect of a .mat file; the reader adds the file name."""


class MatObject(str):
    """The class of a MATLAB object, whose contents only MATLAB reads."""

    __slots__ = ()


def read_mat(file: Path) -> dict[str, Any]:
    """Read the variables of a file by name.

    Numbers are arrays, texts str, structures dict, arrays of structures and cells lists; an object
    of MATLAB (timeseries, table) is a `MatObject`, and functions are left out.
    """
    contents, limit = file.read_bytes(), ReadingLimit(file)
    try:
        if b"\0" in contents[:4]:
            return read_version_4(contents, limit)
        if contents.startswith(b"\x89HDF") or _version(contents) == 2:
            raise InputError(
                f"{file} says that it is a .mat file of version 7.3, and is no HDF5 file. Save it "
                "with save('-v7', ...) in MATLAB or Octave."
            )
        if contents.startswith((b"# Created by Octave", b"# name:", b"Octave-1-")):
            raise InputError(
                f"{file} is in Octave's own text or binary format, which is not read here. Save it "
                f"with save('-v7', '{file.name}', ...) in Octave."
            )
        if _version(contents) != 1 or contents[126:128] not in (b"IM", b"MI"):
            raise InputError(f"{file} is not a .mat file that can be read.")
        return _Version5(contents, "<" if contents[126:128] == b"IM" else ">", limit).variables()
    except (DamagedError, zlib.error, struct.error) as error:
        raise InputError(f"{file} is a damaged .mat file: {error}.") from None


def _version(contents: bytes) -> int:
    """Return the major version in the header: 1 for 5 to 7, 2 for 7.3."""
    tail = contents[124:128]
    return tail[1 if tail[2:] == b"IM" else 0] if len(tail) == 4 else 0


class _Version5:
    """Parser of the elements of a version 5 file: a type, a number of bytes, the data."""

    def __init__(self, contents: bytes, order: str, limit: ReadingLimit) -> None:
        self.contents, self.order, self.limit = contents, order, limit
        self.unpacked = self.parts = 0

    def variables(self) -> dict[str, Any]:
        variables: dict[str, Any] = {}
        view = memoryview(self.contents)[128:]
        while len(view) >= 8:
            kind, size = struct.unpack(self.order + "II", view[:8])
            if size > len(view) - 8:
                raise DamagedError(f"an element of {size} bytes has {len(view) - 8}")
            body = view[8 : 8 + size]
            view = view[8 + size :]
            if kind == COMPRESSED:
                body = self._unpacked(body)
                kind, size = struct.unpack(self.order + "II", body[:8])
                if size > len(body) - 8:
                    raise DamagedError(f"an element of {size} bytes has {len(body) - 8}")
                body = body[8 : 8 + size]
            if kind == MATRIX:
                name, values = self._matrix(body)
                if values is not None and name and not name.startswith("__"):
                    variables[name] = values
        return variables

    def _unpacked(self, body: memoryview) -> memoryview:
        stream = zlib.decompressobj()
        room = MOST_BYTES - self.unpacked
        data = stream.decompress(body, room)
        if stream.unconsumed_tail:
            self.limit.take([self.limit.left + 1])  # raises with the name of the limit
        if not stream.eof:
            raise DamagedError("a compressed variable ends too soon")
        self.unpacked += len(data)
        return memoryview(data)

    def _matrix(self, body: memoryview, depth: int = 0) -> tuple[str, Any]:
        if not body:
            return "", None
        flags, body = self._element(body)
        if flags.dtype.itemsize != 4 or len(flags) != 2:
            raise DamagedError("a variable has no class")
        code = int(flags[0])
        if code & 0xFF == OPAQUE:
            return self._opaque(body)
        if code & 0xFF not in (*CLASSES, CELL, STRUCT, OBJECT, TEXT, SPARSE):
            return "", None
        dims, body = self._element(body)
        label, body = self._element(body)
        shape = [int(size) for size in dims] if dims.dtype.kind in "iu" else []
        if len(shape) < 2 or min(shape) < 0:
            raise DamagedError(f"a variable has the dimensions {shape[:8]}")
        name = label.tobytes().decode("latin-1")
        if code & 0xFF == SPARSE:
            return name, self._sparse(body, shape, is_complex=bool(code & COMPLEX_FLAG))
        if code & 0xFF == TEXT:
            return name, self._text(body)
        if code & 0xFF == CELL:
            return name, self._nested(body, math.prod(shape), depth)[0]
        if code & 0xFF in (STRUCT, OBJECT):
            return name, self._structures(body, math.prod(shape), depth, code & 0xFF == OBJECT)
        count = self.limit.take(shape)
        real, body = self._element(body)
        parts = [real]
        if code & COMPLEX_FLAG:
            parts.append(self._element(body)[0])
        if any(len(part) != count for part in parts):
            raise DamagedError(f"{name} of shape {tuple(shape)} has {len(parts[-1])} entries")
        kind = CLASSES[code & 0xFF]
        with np.errstate(invalid="ignore", over="ignore"):  # damaged values cannot be detected
            values = parts[0].astype(kind) if len(parts) == 1 else _complex(*parts)
        return name, values.reshape(shape, order="F")

    def _sparse(self, body: memoryview, shape: list[int], *, is_complex: bool) -> np.ndarray:
        """Return a sparse matrix as a full array."""
        self.limit.take(shape)
        rows, body = self._element(body)
        starts, body = self._element(body)
        values, body = self._element(body)
        if is_complex:
            values = _complex(values, self._element(body)[0])
        kinds = rows.dtype.kind + starts.dtype.kind
        if len(shape) != 2 or len(starts) != shape[1] + 1 or "f" in kinds:
            raise DamagedError("a sparse matrix has no columns")
        ends = starts.astype(np.int64)
        count = int(ends[-1])
        fits = ends[0] == 0 and (np.diff(ends) >= 0).all() and count <= min(len(rows), len(values))
        where = rows[: max(count, 0)].astype(np.int64)
        if not fits or (where.size and not (where.min() >= 0 and where.max() < shape[0])):
            raise DamagedError("a sparse matrix has entries outside of it")
        full = np.zeros(shape, dtype=values.dtype if is_complex else np.float64)
        np.add.at(full, (where, np.repeat(np.arange(shape[1]), np.diff(ends))), values[:count])
        return full

    def _nested(self, body: memoryview, count: int, depth: int) -> tuple[list[Any], memoryview]:
        """Return the variables in a cell, and the remaining bytes."""
        self.parts += count
        if depth >= DEEPEST or self.parts > MOST_PARTS:
            raise DamagedError(f"structures are nested more than {DEEPEST} deep, or too many")
        values = []
        for _ in range(count):
            if len(body) < 8:
                raise DamagedError("a structure ends too soon")
            kind, size = struct.unpack(self.order + "II", body[:8])
            if kind != MATRIX or size > len(body) - 8:
                raise DamagedError(f"an element of {size} bytes has {len(body) - 8}")
            values.append(self._matrix(body[8 : 8 + size], depth + 1)[1])
            body = body[8 + size :]
        return values, body

    def _structures(self, body: memoryview, count: int, depth: int, is_object: bool) -> Any:
        """Return a structure as a dict, or several as a list of them."""
        if is_object:
            _, body = self._element(body)  # the name of its class
        length, body = self._element(body)
        labels, body = self._element(body)
        size = int(length[0]) if length.size and length.dtype.kind in "iu" else 0
        text = labels.tobytes()
        if size < 1 or len(text) % size or len(text) // size > MOST_PARTS:
            raise DamagedError(f"a structure has fields of {size} characters")
        names = [
            text[i : i + size].split(b"\0")[0].decode("latin-1") for i in range(0, len(text), size)
        ]
        result = []
        for _ in range(min(count, MOST_PARTS)):
            values, body = self._nested(body, len(names), depth)
            result.append(dict(zip(names, values, strict=True)))
        return result[0] if len(result) == 1 else result

    def _text(self, body: memoryview) -> str:
        """Return the characters of a text, column by column."""
        if len(body) < 8:
            return ""
        (first,) = struct.unpack(self.order + "I", body[:4])
        kind = first & 0xFFFF if first >> 16 else first
        if kind not in TEXTS:
            return ""
        values, _ = self._element(body, TEXTS)
        if values.dtype.itemsize == 1:
            return values.tobytes().decode("utf-8", "replace")
        return values.astype("<u2").tobytes().decode("utf-16-le", "replace")

    def _opaque(self, body: memoryview) -> tuple[str, Any]:
        """Return the name of an object and its class."""
        label, body = self._element(body)
        _, body = self._element(body)  # MCOS or java
        kind, body = self._element(body)
        return label.tobytes().decode("latin-1"), MatObject(kind.tobytes().decode("latin-1"))

    def _element(
        self, view: memoryview, types: Mapping[int, str] = TYPES
    ) -> tuple[np.ndarray, memoryview]:
        """Return the numbers of the next element and the remaining bytes."""
        if len(view) < 8:
            raise DamagedError("a variable ends too soon")
        (first,) = struct.unpack(self.order + "I", view[:4])
        if first >> 16:  # up to four bytes, in the tag itself
            kind, size, start, step = first & 0xFFFF, first >> 16, 4, 8
            if size > 4:
                raise DamagedError(f"a small element has {size} bytes; at most four are possible")
        else:
            (size,) = struct.unpack(self.order + "I", view[4:8])
            kind, start, step = first, 8, 8 + size + -size % 8
        if kind not in types:
            raise DamagedError(f"an element has the type {kind}")
        dtype = np.dtype(types[kind]).newbyteorder(self.order)  # type: ignore[arg-type]
        if size > len(view) - start or size % dtype.itemsize:
            raise DamagedError(f"an element of {size} bytes has {max(len(view) - start, 0)}")
        return np.frombuffer(view[start : start + size], dtype), view[step:]


def _complex(real: np.ndarray, imaginary: np.ndarray) -> np.ndarray:
    if len(real) != len(imaginary):
        raise DamagedError(f"{len(real)} real parts have {len(imaginary)} imaginary ones")
    values = real.astype(np.complex128)
    values.imag = imaginary
    return values
