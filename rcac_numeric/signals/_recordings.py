"""Recorded signals: arrays, and files with text columns or NumPy arrays."""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import array_like, instance_of, integer, real_array
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.signals._data_files import read_contents
from rcac_numeric.signals._log_contents import LogColumn, LogContents
from rcac_numeric.signals._signal import Signal


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
    r"""One column of a file of numbers; shape (steps,).

    Parameters
    ----------
    path : path
        A text (.csv, .txt, .tsv, .dat) has one row for each step and may begin with names, units
        and comments; a .npy file holds an array of shape (steps,) or (steps, columns). Other files
        that `inspect_log` reads have names.
    column : int or str
        Index from 0, or name where the file has names.

    Raises
    ------
    InputError
        If the file cannot be read, an entry of the column is missing or no number, or there is no
        such column.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from rcac_numeric import read_recording
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "flight.csv"
    >>> _ = file.write_text("r, d\n0.15, 0\n0.15, 0.5\n")
    >>> read_recording(file, column="d")
    array([0. , 0.5])
    """
    contents = read_contents(path)
    columns = _column(contents, column)
    if len(columns) == 1 and columns[0].problem:
        raise InputError(columns[0].problem)
    signal = columns[0].values if len(columns) == 1 else None
    if signal is None or max(signal.shape, default=0) != signal.size:
        shape = "several columns" if signal is None else f"shape {signal.shape}"
        raise InputError(f"{path}: {column!r} has {shape}; one column is needed.")
    return real_array(signal.ravel(), str(path))


def _column(contents: LogContents, column: int | str) -> list[LogColumn]:
    """The columns of a name, or the one of an index."""
    file = contents.source
    if isinstance(column, str):
        columns = contents.named(column)
        if not columns:
            names = [c.full_name for c in contents.columns if c.name]
            known = (
                f"it has {shortened(', '.join(names))}" if names else "its columns have no names"
            )
            raise InputError(f"{file} has no column {column!r}; {known}.")
        return columns
    index, width = integer(column, "column"), len(contents.columns)
    if index >= width:
        raise InputError(f"{file} has no column {index}; it has {width}, counted from 0.")
    return [contents.columns[index]]
