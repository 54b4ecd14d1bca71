"""Arrays in .npy and .npz files: sizes are asked before anything is read, nothing is unpickled."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy

from compensator_theory.errors import InputError
from rcac_numeric.arrays.wording import shortened
from rcac_numeric.signals.budget import Budget


def read_npz(file: Path) -> dict[str, np.ndarray]:
    """The arrays of an archive by name.

    Raises
    ------
    InputError
        Where it is none, is damaged, holds objects, or more than may be read.
    """
    budget, found = Budget(file), {}
    try:
        with zipfile.ZipFile(file) as archive:
            for member in (name for name in archive.namelist() if name.endswith(".npy")):
                with archive.open(member) as stream:
                    _require_room(stream, budget)
                with archive.open(member) as stream:
                    found[member.removesuffix(".npy")] = _array(stream)
    except InputError:
        raise
    except Exception as error:  # zipfile, its decompressors and NumPy each have their own
        raise InputError(
            f"{file} is not an .npz file of numbers: {shortened(str(error), 200)}."
        ) from None
    return found


def read_npy(file: Path) -> np.ndarray:
    """The array of a file.

    Raises
    ------
    InputError
        As for `read_npz`.
    """
    try:
        with file.open("rb") as stream:
            _require_room(stream, Budget(file))
        with file.open("rb") as stream:
            return _array(stream)
    except InputError:
        raise
    except Exception as error:
        raise InputError(
            f"{file} is not an array of numbers: {shortened(str(error), 200)}."
        ) from None


def _require_room(stream: IO[bytes], budget: Budget) -> None:
    if npy.read_magic(stream) != (1, 0):  # later versions are for headers of up to 4 GB
        raise ValueError("its header is not one of plain numbers")
    shape, _, dtype = npy.read_array_header_1_0(stream)
    if min(shape, default=0) < 0:
        raise ValueError(f"an array has the shape {shape}")
    budget.take((*shape, max(dtype.itemsize // 8, 1)))


def _array(stream: Any) -> np.ndarray:
    values: np.ndarray = np.asarray(npy.read_array(stream, allow_pickle=False))
    if values.dtype.kind != "f":
        return values
    with np.errstate(invalid="ignore"):  # a NaN of single precision may be a signalling one
        return values.astype(np.float64)
