"""Recorded signals: arrays, and files with text columns or NumPy arrays."""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._files import require_readable
from rcac_numeric.arrays._untrusted import read_npy
from rcac_numeric.arrays._validation import array_like, instance_of, integer, real_array
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.signals._signal import Signal
from rcac_numeric.signals._text_tables import read_table


@attrs.frozen(eq=False, slots=False)
class Recorded(Signal):
    """A record, one value for each step from step 0 on, without values beyond its end.

    More steps than were recorded are refused, also of a sum.

    Parameters
    ----------
    record : array, shape (steps,)
        For a record of several channels see `recorded_channels`.
    name : str
        What errors call it.

    Examples
    --------
    >>> from rcac_numeric import Recorded
    >>> Recorded([0.5, -0.5, 1.0]).samples(2)
    array([ 0.5, -0.5])
    """

    record: Array = attrs.field(converter=array_like)
    name: str = "record"

    def __attrs_post_init__(self) -> None:
        array = real_array(self.record, instance_of(self.name, "name", str))
        if array.ndim != 1 or array.size == 0:
            raise InputError(f"{self.name} has shape {array.shape}; a record needs shape (steps,).")
        object.__setattr__(self, "record", array)

    @property
    def description(self) -> str:
        """For instance record of 3 steps."""
        return f"{self.name} of {self.record.size} steps"

    @property
    def steps_known(self) -> int:
        """Number of recorded steps."""
        return int(self.record.size)

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """Return the first values of the record."""
        return self.record[:steps].copy()


def recorded_channels(values: ArrayLike, name: str = "record") -> tuple[Signal, ...]:
    """A record of several channels as one signal for each; values of shape (steps, channels).

    Examples
    --------
    >>> from rcac_numeric import exogenous, recorded_channels
    >>> exogenous(recorded_channels([[1.0, 2.0], [3.0, 4.0]]), steps=2)
    array([[1., 2.],
           [3., 4.]])
    """
    record = real_array(values, name)
    if record.ndim != 2 or record.size == 0:
        raise InputError(f"{name} has shape {record.shape}; shape (steps, channels) is needed.")
    return tuple(Recorded(column, f"{name}[:, {i}]") for i, column in enumerate(record.T))


def read_recording(path: str | Path, column: int | str = 0) -> Array:
    r"""One column of a .csv or .npy file; shape (steps,).

    Parameters
    ----------
    path : path
        A .csv file has one row for each step, numbers separated by commas, and may begin with a
        row of names; empty lines are skipped. A .npy file holds an array of shape (steps,) or
        (steps, columns).
    column : int or str
        Index from 0, or name where the file has names.

    Raises
    ------
    InputError
        If the file cannot be read, an entry is no number, or there is no such column.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from rcac_numeric import read_recording
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "flight.csv"
    >>> _ = file.write_text("r, d\n0.15, 0\n0.15, 0.5\n")
    >>> read_recording(file, column="d")
    array([0. , 0.5])
    """
    file = Path(path)
    if file.suffix.lower() not in (".csv", ".npy"):
        raise InputError(f"{file} is not a recording that can be read; use .csv or .npy.")
    try:
        require_readable(file)
        if file.suffix.lower() == ".csv":
            names, table = read_table(file, named=False)
        else:
            names, table = [], _columns(file)
    except OSError as error:
        raise InputError(f"{file} cannot be read: {error.strerror or error}.") from None
    return real_array(table[:, _index(column, names, table.shape[1], file)], str(file))


def _columns(file: Path) -> np.ndarray:
    table = read_npy(file)
    if table.ndim not in (1, 2) or table.size == 0:
        raise InputError(
            f"{file} holds an array of shape {table.shape}; (steps,) or (steps, columns) is needed."
        )
    return table.reshape(len(table), -1)


def _index(column: int | str, names: list[str], width: int, file: Path) -> int:
    if isinstance(column, str):
        if column not in names:
            known = (
                f"it has {shortened(', '.join(names))}" if names else "its columns have no names"
            )
            raise InputError(f"{file} has no column {column!r}; {known}.")
        return names.index(column)
    index = integer(column, "column")
    if index >= width:
        raise InputError(f"{file} has no column {index}; it has {width}, counted from 0.")
    return index
