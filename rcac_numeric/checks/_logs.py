"""The log of a controller: its signals and its coefficients."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import (
    gaps_as_nan,
    has_mask,
    interval,
    number,
    optional_array_like,
    real_array,
)
from rcac_numeric.arrays._values import Value, replaced
from rcac_numeric.checks._conventions import Convention, convention_of
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.signals._log_signals import SIGNALS, read_signals


@attrs.frozen(eq=False, slots=False)
class ControllerLog(Value):
    """The recorded signals of a controller in its loop; one row for each step k = 0, 1, ....

    Parameters
    ----------
    u, y : arrays, shape (steps, l_u), (steps, l_y)
        A 1-D array is a scalar signal.
    z, w, r : arrays, shape (steps, width), optional
        Performance, exogenous input, and the command where the controller reads it.
    theta : array, optional
        Shape (steps, l_theta), row k the coefficients of step k; or (l_theta,), those that it
        ended with.
    D_c, N_c : arrays, optional
        In place of theta, for scalar signals: the polynomials of u = N_c / D_c y in descending
        powers of q.
    source : str
        Named in errors.
    sample_time : float, optional
        In seconds.
    time_skew : (float, float)
        The least and the largest time in seconds by which u of a row is older than its y: a dead
        time from u to y is longer than in the rows. `read_log` computes it from the times.
    has_gaps : bool
        Whether entries of the signals and of theta may be missing (NaN), as `read_log` marks the
        rows that the clock lacks.
    clock, notes : str, tuple of str
        What `read_log` found about the times, and did to the signals.

    Raises
    ------
    InputError
        Where a signal has a gap (NaN) without `has_gaps`, another number of steps than u, or is
        transposed.

    Examples
    --------
    >>> from rcac_numeric import ControllerLog
    >>> ControllerLog(u=[0.0, 1.0, 1.5], y=[1.0, 0.5, 0.2], theta=[0.5, 1.0]).steps
    3
    """

    u: Array = attrs.field(converter=optional_array_like)
    y: Array = attrs.field(converter=optional_array_like)
    z: Array | None = attrs.field(default=None, kw_only=True, converter=optional_array_like)
    w: Array | None = attrs.field(default=None, kw_only=True, converter=optional_array_like)
    r: Array | None = attrs.field(default=None, kw_only=True, converter=optional_array_like)
    theta: Array | None = attrs.field(default=None, kw_only=True, converter=optional_array_like)
    D_c: Array | None = attrs.field(default=None, kw_only=True, converter=optional_array_like)
    N_c: Array | None = attrs.field(default=None, kw_only=True, converter=optional_array_like)
    source: str = attrs.field(default="the log", kw_only=True)
    sample_time: float | None = attrs.field(default=None, kw_only=True)
    time_skew: tuple[float, float] = attrs.field(default=(0.0, 0.0), kw_only=True)
    has_gaps: bool = attrs.field(default=False, kw_only=True)
    clock: str = attrs.field(default="", kw_only=True)
    notes: tuple[str, ...] = attrs.field(default=(), kw_only=True)

    def __attrs_post_init__(self) -> None:
        keep = partial(object.__setattr__, self)
        if self.sample_time is not None:
            keep("sample_time", number(self.sample_time, "sample_time"))
            if not self.sample_time > 0:
                raise InputError(
                    f"sample_time = {self.sample_time:g} must be positive, in seconds."
                )
        keep("time_skew", interval(self.time_skew, "time_skew"))
        steps = 0
        signals = self.u, self.y, self.z, self.w, self.r
        for name, value in zip(SIGNALS, signals, strict=True):
            if value is None and name in ("u", "y"):
                raise InputError(f"{self.source}: the signal {name} is needed.")
            signal = None if value is None else self._signal(name, value)
            if signal is not None and steps not in (0, len(signal)):
                raise InputError(
                    f"{self.source}: {name} has {len(signal)} steps where u has {steps}."
                    + self._transposed(name, signal, steps)
                )
            steps = steps or (0 if signal is None else len(signal))
            keep(name, signal)
        if self.theta is not None:
            keep("theta", self._coefficients(self.theta, steps))
        for name, value in (("D_c", self.D_c), ("N_c", self.N_c)):
            if value is not None:
                keep(name, self._polynomial(name, value))

    @property
    def steps(self) -> int:
        """Number of recorded steps."""
        return len(self.u)

    @property
    def missing(self) -> Array:
        """Whether an entry of the signals or of theta is missing at each step; shape (steps,)."""
        gaps = np.zeros(self.steps, dtype=bool)
        if self.has_gaps:
            for values in (self.u, self.y, self.z, self.w, self.r, self.theta):
                if values is not None and values.ndim == 2 and len(values) == self.steps:
                    gaps |= np.isnan(values).any(axis=1)
        return gaps

    def longest_part(self) -> ControllerLog:
        """Return the longest part without missing rows; the log itself if it has none.

        Raises
        ------
        InputError
            If every row is missing an entry.

        Examples
        --------
        >>> import numpy as np
        >>> from rcac_numeric import ControllerLog
        >>> log = ControllerLog(u=[1, np.nan, 3, 4], y=[1, 2, 3, 4], has_gaps=True)
        >>> log.longest_part().u.ravel()
        array([3., 4.])
        """
        missing = self.missing
        if not missing.any():
            return self
        edges = np.flatnonzero(np.diff(np.concatenate([[True], missing, [True]]).astype(int)))
        if not len(edges):
            raise InputError(f"{self.source}: each of the {self.steps} rows lacks an entry.")
        begins, ends = edges[::2], edges[1::2]
        longest = int(np.argmax(ends - begins))
        part = slice(int(begins[longest]), int(ends[longest]))
        values = {"u": self.u, "y": self.y, "z": self.z, "w": self.w, "r": self.r}
        values |= {"theta": self.theta} if self.has_history else {}
        cut = {name: value[part] for name, value in values.items() if value is not None}
        note = (
            f"steps {part.start} to {part.stop - 1} of {self.steps}, the longest part without gaps"
        )
        return replaced(self, **cut, has_gaps=False, notes=(*self.notes, note))

    @property
    def has_history(self) -> bool:
        """Whether theta was recorded at every step."""
        return self.theta is not None and self.theta.ndim == 2

    @property
    def theta_final(self) -> Array | None:
        """The last coefficients in the log that are not missing."""
        if self.theta is None:
            return None
        if self.theta.ndim != 2:
            return self.theta
        rows = np.flatnonzero(~np.isnan(self.theta).any(axis=1))
        last: Array = self.theta[rows[-1] if len(rows) else -1]
        return last

    def converted(self, convention: str | Convention, structure: Structure) -> ControllerLog:
        """Return the log in our convention, u = Phi theta of the `structure`.

        Parameters
        ----------
        convention : str
            Differences of the program that wrote the log, joined by commas: "-u", "-y", "z for y",
            "r - y for y", "r + y for y", "y first", "interleaved", "oldest first", "by component",
            "by rows", "lags by rows". `check_controller` names the one that replays.
        structure : Structure

        Raises
        ------
        InputError
            Where a word is not known, or the log does not hold the signal that the controller
            reads.

        Examples
        --------
        >>> from rcac_numeric import ControllerLog, iir
        >>> log = ControllerLog(u=[0.0, -1.0], y=[2.0, 0.0], theta=[0.5, 0.1])
        >>> log.converted("-y, y first", iir(n_c=1)).theta      # [y, u] on -y to [u, y] on y
        array([ 0.1, -0.5])
        """
        known = convention_of(convention)
        log = self.reading(known)
        if log.theta is None:
            return log
        return replaced(log, theta=known.theta(log.theta, structure))

    def reading(self, convention: Convention) -> ControllerLog:
        """Return the log with y the signal that the controller reads by a convention."""
        return self if convention.signal == "y" else replaced(self, y=self.read_signal(convention))

    def read_signal(self, convention: Convention) -> Array:
        """The signal that the controller reads by a convention."""
        name = convention.signal
        if name == "y":
            return self.y
        other = self.z if name == "z" else self.r
        if other is None or other.shape != self.y.shape:
            size = "no" if other is None else f"{other.shape[1]} components of"
            raise InputError(
                f"{self.source}: convention = {str(convention)!r}, and the log has {size} "
                f"{name[0]} where y has {self.y.shape[1]} components."
            )
        return {"z": other, "r - y": other - self.y, "r + y": other + self.y}[name]

    def _finite(self, name: str, value: ArrayLike) -> Array:
        value = gaps_as_nan(value)
        try:
            array = np.asarray(value)
        except ValueError:  # rows of several lengths
            return real_array(value, f"{self.source}: {name}")
        if has_mask(value) or array.dtype.kind == "O":
            return real_array(value, f"{self.source}: {name}")
        if array.dtype.kind == "c":
            raise InputError(
                f"{self.source}: {name} must be an array of real numbers, and its entries are "
                "complex."
            )
        if self.has_gaps and array.dtype.kind == "f" and not np.isinf(array).any():
            array = np.array(array, dtype=np.float64)
            array.setflags(write=False)
            return array
        if array.dtype.kind == "f" and not np.all(np.isfinite(array)):
            first = np.argwhere(~np.isfinite(array))[0]
            raise InputError(
                f"{self.source}: {name} has {np.count_nonzero(~np.isfinite(array))} gaps (NaN or "
                f"infinite), the first at step {first[0]}"
                + (f", component {first[1]}" if array.ndim == 2 else "")
                + "; a log without gaps is needed. Cut it, or fill the gaps by what was applied."
            )
        return real_array(array, f"{self.source}: {name}")

    def _signal(self, name: str, value: ArrayLike) -> Array:
        array = self._finite(name, value)
        if array.ndim == 1:
            array = array.reshape(-1, 1)
        if array.ndim != 2 or not array.size:
            raise InputError(
                f"{self.source}: {name} has shape {array.shape}; (steps, width) is needed, one row "
                "for each step."
            )
        if name == "u" and array.shape[0] < array.shape[1]:
            raise InputError(
                f"{self.source}: u has shape {array.shape}; (steps, l_u) is needed, one row for "
                "each step. It seems to be transposed."
            )
        return array

    @staticmethod
    def _transposed(name: str, signal: Array, steps: int) -> str:
        if signal.shape[1] != steps:
            return " Every signal needs one row for each step."
        return (
            f" Its shape is {signal.shape}; ({steps}, {len(signal)}) is needed, so it seems to be "
            "transposed."
        )

    def _polynomial(self, name: str, value: ArrayLike) -> Array:
        values = self._finite(name, value)
        if values.size != max(values.shape, default=1):
            raise InputError(
                f"{self.source}: {name} has shape {values.shape}; one polynomial in q is needed, a "
                "list of coefficients in descending powers."
            )
        return values.reshape(-1)

    def _coefficients(self, value: ArrayLike, steps: int) -> Array:
        theta = self._finite("theta", value)
        if theta.ndim <= 1 or 1 in theta.shape:
            return theta.reshape(-1) if theta.shape != (steps, 1) else theta
        if theta.ndim == 2 and theta.shape[0] == steps:
            return theta
        hint = " It seems to be transposed." if theta.shape[-1] == steps else ""
        raise InputError(
            f"{self.source}: theta has shape {theta.shape}; ({steps}, l_theta), a row for each "
            f"step, or (l_theta,), the last coefficients, is needed.{hint}"
        )


def read_log(
    source: Any,
    names: Mapping[str, str | Sequence[str]] | None = None,
    *,
    transpose: bool = False,
    columns: Sequence[str] = (),
    time: str | None = None,
    sample_time: float | None = None,
    resample: float | None = None,
) -> ControllerLog:
    """Read the log of a controller from a file, a DataFrame or a mapping of arrays.

    Text (.csv, .txt, .tsv, .dat, also .gz), .mat, .npz, .npy, .h5, .parquet, .ulg and .xlsx;
    `inspect_log` says what a file holds. Only the columns in use must be numbers. A column of times
    gives the sample time; rows that it lacks are NaN.

    Parameters
    ----------
    source : path, DataFrame or mapping
    names : mapping, optional
        From u, y, z, w, r, theta, D_c, N_c to the names that the file uses; several names, a
        sequence or joined by +, are components.
    transpose : bool
        Whether every signal has one column, and not one row, for each step.
    columns : sequence of str, optional
        Names for the columns of a table without a head.
    time : str, optional
        The column of the times, or "none" for rows of equal distance whatever the stamps say. By
        default stamps, then t, time or timestamp, then a counter of steps.
    sample_time : float, optional
        In seconds; refused if the times contradict it.
    resample : float, optional
        Sample time in seconds, for irregular times: u, r and theta keep the last value,
        other signals are interpolated; `notes` states the error, `time_skew` that of the times.

    Raises
    ------
    InputError
        If the file cannot be read, or u or y is not in it, or no shape fits; if stamps turn back,
        are repeated, irregular or no times; if two sample times differ.

    Examples
    --------
    >>> from rcac_numeric import read_log
    >>> log = read_log("examples/octave/rcac_loop.mat")
    >>> log.steps, log.theta.shape
    (300, (300, 8))
    >>> times = {"t": [0.0, 0.1, 0.3, 0.4], "u": [1, 2, 3, 4], "y": [0, 1, 2, 3]}
    >>> log = read_log(times)
    >>> log.sample_time, log.missing.tolist()
    (0.1, [False, False, True, False, False])
    """
    signals, name = read_signals(
        source, names or {}, transpose=transpose, columns=columns, time=time,
        sample_time=sample_time, resample=resample,
    )  # fmt: skip
    clock = signals.clock
    return ControllerLog(
        **signals.arrays, source=name, has_gaps=clock is not None or _has_nan(signals.arrays),
        sample_time=sample_time if clock is None else clock.sample_time or sample_time,
        time_skew=signals.time_skew,
        clock="" if clock is None else str(clock), notes=tuple(signals.notes),
    )  # fmt: skip


def _has_nan(arrays: Mapping[str, Array]) -> bool:
    """Whether entries of the signals are missing."""
    return any(
        bool(np.isnan(values).any()) for values in arrays.values() if values.dtype.kind == "f"
    )
