"""Readers of untrusted files: sizes, shapes, types, depth and digits are checked first.

Every reader of arrays and of JSON that somebody else may have written goes through here, with one
limit. A checksum finds damage; it says nothing about who wrote a file.
"""

from __future__ import annotations

import json
import math
import re
import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy

from compensator_theory.errors import InputError
from rcac_numeric.arrays._files import require_readable
from rcac_numeric.arrays._wording import shortened

# A million steps of thirty signals; 268 MB as float64.
MOST_NUMBERS = 2**25
MOST_LISTED = 2**20  # bytes of an archive's table of contents
MOST_CHARACTERS = 2**22  # of a text in an array
MOST_PARTS = 2**16  # entries of lists and tables in JSON
DEEPEST = 60  # of JSON
LONGEST_NUMBER = 30  # digits of an integer in JSON

# Other compression methods allow a file to request any amount of memory.
_PACKED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_JSON = re.compile(r'"[^"\\]*+(?:\\.[^"\\]*+)*+"?|[\[{]|[\]}]|,|[0-9]+', re.DOTALL)


class ReadingLimit:
    """Remaining budget of numbers for one file."""

    def __init__(self, file: Path) -> None:
        self.file, self.left = file, MOST_NUMBERS

    def take(self, shape: Iterable[int]) -> int:
        """Return the number of entries of a shape and subtract it from the budget."""
        sizes = list(shape)
        # The rows of an empty array cost time too, so they count.
        if math.prod(max(size, 1) for size in sizes) > self.left:
            raise InputError(f"{self.file} holds more than {MOST_NUMBERS} numbers; cut it.")
        count = math.prod(sizes)
        self.left -= count
        return count


def read_npz(file: Path) -> dict[str, np.ndarray]:
    """Read the arrays of numbers and texts of an archive, by name."""
    require_readable(file)
    limit, arrays = ReadingLimit(file), {}
    with file.open("rb") as opened:
        try:
            listing = _Listing(opened)
            with zipfile.ZipFile(listing) as archive:
                listing.is_listed = True
                for member in archive.infolist():
                    name = member.filename.removesuffix(".npy")
                    if name == member.filename:
                        continue
                    if name in arrays:
                        raise ValueError(f"it holds {shortened(name, 60)!r} twice")
                    if member.compress_type not in _PACKED:
                        raise ValueError(f"{shortened(name, 60)!r} is packed by no usual method")
                    with archive.open(member) as stream:
                        _require_room(stream, limit)
                    with archive.open(member) as stream:
                        arrays[name] = _array(stream)
        except InputError:
            raise
        except Exception as error:  # zipfile, its decompressors and NumPy raise different errors
            raise _unreadable(file, "an .npz file of numbers", error) from None
    return arrays


def names_in(file: Path) -> list[str]:
    """Return the names of the arrays in an archive without reading the arrays."""
    with file.open("rb") as opened:
        try:
            with zipfile.ZipFile(_Listing(opened)) as archive:
                return [name.removesuffix(".npy") for name in archive.namelist()]
        except Exception as error:
            raise _unreadable(file, "an .npz file", error) from None


def read_npy(file: Path) -> np.ndarray:
    """Read the array of a .npy file."""
    require_readable(file)
    with file.open("rb") as stream:
        try:
            _require_room(stream, ReadingLimit(file))
            stream.seek(0)
            return _array(stream)
        except InputError:
            raise
        except Exception as error:
            raise _unreadable(file, "an array of numbers", error) from None


def parsed_json(text: str) -> Any:
    """Parse JSON text with at most `MOST_PARTS` parts and `DEEPEST` levels."""
    depth = parts = 0
    for token in _JSON.finditer(text):
        first = text[token.start()]
        if first in "[{":
            depth += 1
            parts += 1
            if depth > DEEPEST:
                raise ValueError(f"it is nested more than {DEEPEST} deep")
        elif first in "]}":
            depth -= 1
        elif first == ",":
            parts += 1
        elif first != '"' and token.end() - token.start() > LONGEST_NUMBER:
            raise ValueError(f"it has a number of more than {LONGEST_NUMBER} digits")
        if parts > MOST_PARTS:
            raise ValueError(f"it has more than {MOST_PARTS} parts")
    return json.loads(text)


class _Listing:
    """File wrapper that limits the size of the ZIP table of contents."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file, self.is_listed = file, False

    def read(self, size: int = -1) -> bytes:
        if not self.is_listed and size > MOST_LISTED:
            raise ValueError("its table of contents is too long")
        return self._file.read(size)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)


def _unreadable(file: Path, subject: str, error: Exception) -> InputError:
    words = str(error) or type(error).__name__
    return InputError(f"{file} is not {subject}: {shortened(words, 200)}.")


def _require_room(stream: IO[bytes], limit: ReadingLimit) -> None:
    if npy.read_magic(stream) != (1, 0):  # later versions are for headers of up to 4 GB
        raise ValueError("its header is not one of plain numbers")
    shape, _, dtype = npy.read_array_header_1_0(stream)
    if min(shape, default=0) < 0:
        raise ValueError(f"an array has the shape {shape}")
    if dtype.kind not in "biufcUmM" or dtype.fields is not None:
        raise ValueError(f"an array has entries of type {str(dtype)[:60]}")
    if dtype.kind == "U" and dtype.itemsize > 4 * MOST_CHARACTERS:
        raise ValueError(f"a text has more than {MOST_CHARACTERS} characters")
    limit.take((*shape, max(dtype.itemsize // 8, 1)))


def _array(stream: Any) -> np.ndarray:
    values: np.ndarray = np.asarray(npy.read_array(stream, allow_pickle=False))
    if values.dtype.kind != "f" or values.dtype == np.float64:
        return values
    with np.errstate(invalid="ignore"):  # a NaN of single precision may be a signalling one
        return values.astype(np.float64)
