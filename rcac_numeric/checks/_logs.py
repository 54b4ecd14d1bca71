"""The log of a controller: its signals and its coefficients."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from functools import partial
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import (
    gaps_as_nan,
    has_mask,
    optional_array_like,
    real_array,
)
from rcac_numeric.arrays._values import Value
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.signals._data_files import read_variables

SIGNALS = ("u", "y", "z", "w", "r")
# What a log may hold, under these names or those that the caller gives.
ROLES = (*SIGNALS, "theta", "D_c", "N_c")
# A column of this name counts steps or seconds, and is no signal.
TIMES = ("k", "n", "i", "t", "step", "steps", "time", "index", "sample", "seconds", "timestamp")
# So many names of a file are compared with one that it lacks: a hundred thousand take seconds.
COMPARED = 1000


@attrs.frozen(eq=False, slots=False)
class ControllerLog(Value):
    """What was recorded of a controller in its loop; one row for each step k = 0, 1, ....

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

    Raises
    ------
    InputError
        Where a signal has a gap (NaN), another number of steps than u, or is transposed.

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

    def __attrs_post_init__(self) -> None:
        keep = partial(object.__setattr__, self)
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
    def has_history(self) -> bool:
        """Whether theta was recorded at every step."""
        return self.theta is not None and self.theta.ndim == 2

    @property
    def theta_final(self) -> Array | None:
        """The last coefficients in the log."""
        if self.theta is None:
            return None
        last: Array = self.theta[-1] if self.theta.ndim == 2 else self.theta
        return last

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
    path: str | Path, names: Mapping[str, str] | None = None, *, transpose: bool = False
) -> ControllerLog:
    """Read a log from a .csv, .mat or .npz file.

    Parameters
    ----------
    path : path
    names : mapping, optional
        From u, y, z, w, r, theta, D_c, N_c to the names that the file uses.
    transpose : bool
        Whether every signal has one column, and not one row, for each step.

    Raises
    ------
    InputError
        If the file cannot be read, or u or y is not in it, or no shape fits.

    Examples
    --------
    >>> from rcac_numeric import read_log
    >>> log = read_log("examples/octave/rcac_loop.mat")
    >>> log.steps, log.theta.shape
    (300, (300, 8))
    """
    variables = read_variables(path)
    roles = dict(names or {})
    for role in roles:
        if role not in ROLES:
            raise InputError(f"names: {role!r} is not known; rename {', '.join(ROLES)}.")
    signals = {}
    for role in ROLES:
        name = roles.get(role, role)
        if name in variables:
            signals[role] = variables[name].T if transpose else variables[name]
        elif role in roles or role in ("u", "y"):
            raise InputError(_missing(str(path), role, name, variables, roles))
    return ControllerLog(**signals, source=str(path))


def _missing(
    path: str, role: str, name: str, variables: Mapping[str, Array], roles: Mapping[str, str]
) -> str:
    """The error for a missing signal: the names in the file, and likely candidates."""
    has = shortened(", ".join(variables)) or "nothing"
    free = [v for v in [*variables][:COMPARED] if v not in roles.values()]
    close = difflib.get_close_matches(name, free, n=1, cutoff=0.5)
    signals = close or [v for v in free if v not in ROLES and v.lower() not in TIMES]
    hint = f" Did you mean {close[0]!r}?" if close else ""
    if not signals:
        return f"{path} has no {name!r}, needed as {role}; it has {has}, none of which can be it."
    proposal = f"--names {role}={shortened(signals[0], 40)}"
    return (
        f"{path} has no {name!r}, needed as {role}; it has {has}.{hint} Say which column is "
        f"{role}, for instance {proposal}."
    )
