"""Crash-safe log of a controller."""

from __future__ import annotations

import os
import warnings
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import gaps_as_nan, instance_of
from rcac_numeric.arrays._values import ShowsState
from rcac_numeric.controllers._supervision import SupervisionWarning
from rcac_numeric.engine._controller import Controller


class Recorder(ShowsState):
    """Controller with a log: writes every step to a .csv file for `rcac check`.

    A row is one write to the file, so that a process that is killed leaves no half row, and lacks
    the last step at most: u_applied is given with the next step, so that a row waits for that, or
    for `close`. Where the file takes no more, the log ends with its last whole row, a
    `SupervisionWarning` says so once, `failure` keeps it, and the controller goes on. The row of
    step k holds u(k), or what was applied of it, y(k), z(k), r(k) as the controller held them,
    theta(k) that made u(k), and whether the sample was missed.

    Parameters
    ----------
    controller : Controller
    path : path
        A new file; one that is there is refused.

    Raises
    ------
    InputError
        Where the file is there, or cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from rcac_numeric import (
    ...     UD, Controller, ControllerSettings, Recorder, TargetModel, iir, read_log)
    >>> controller = Controller(ControllerSettings(
    ...     structure=iir(n_c=1), target=TargetModel([0, 1]), update=UD(R_theta=1)))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path, x = Path(folder) / "log.csv", 1.0
    ...     with Recorder(controller, path) as recorder:
    ...         for k in range(20):
    ...             (u,) = recorder.step(x, x)
    ...             x = 0.9 * x + u
    ...     log = read_log(path)
    >>> log.steps, log.theta.shape
    (20, (20, 2))
    """

    SHOWN = ("path", "controller", "failure")

    def __init__(self, controller: Controller, path: str | Path) -> None:
        self.controller = instance_of(controller, "controller", Controller)
        self.path = Path(path)
        structure = controller.settings.structure
        widths = {
            "u": structure.l_u, "y": structure.l_y, "z": controller.settings.target.l_z,
            "r": structure.l_r, "theta": structure.l_theta, "missed": 1,
        }  # fmt: skip
        names = [
            name if width == 1 and name != "theta" else f"{name}[{i}]"
            for name, width in widths.items()
            for i in range(width)
        ]
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND
        try:
            self._file: int | None = os.open(self.path, flags, 0o666)
        except OSError as error:
            raise InputError(f"{path} cannot be written: {error.strerror or error}.") from None
        self._known = {"y": np.zeros(widths["y"]), "z": np.zeros(widths["z"])}
        self._known["r"] = np.zeros(widths["r"])
        self._row: list[Array] = []
        self._size = 0
        self.failure = ""
        self._write(",".join(names))
        if self.failure:
            raise InputError(f"{self.path} cannot be written: {self.failure}.")

    def step(
        self,
        y: ArrayLike,
        z: ArrayLike,
        r: ArrayLike | None = None,
        u_applied: ArrayLike | None = None,
    ) -> Array:
        """Run `Controller.step` and write its row.

        Parameters
        ----------
        y, z : arrays, shape (l_y,), (l_z,), or numbers
        r : array, shape (l_r,), or a number, optional
        u_applied : array, shape (l_u,), or a number, optional

        Raises
        ------
        InputError, DivergedError, FunctionFailedError
            As `Controller.step`; also where the log was closed.
        """
        if self._file is None and not self.failure:
            raise InputError(f"the log {self.path} is closed.")
        theta = self.controller.theta
        before = self.controller.record.troubles.get("missed sample")
        u: Array = self.controller.step(y, z, r, u_applied)
        if self.failure:
            return u
        after = self.controller.record.troubles.get("missed sample")
        missed = after is not None and (before is None or after.steps > before.steps)
        for name, value in zip("yzr", map(gaps_as_nan, (y, z, r)), strict=True):
            values = np.zeros(0) if value is None else np.asarray(value, dtype=float).reshape(-1)
            known = np.isfinite(values)
            self._known[name] = np.where(known, values, self._known[name])
        if self._row:
            if u_applied is not None:
                self._row[0] = np.asarray(u_applied, dtype=float).reshape(-1)
            self._flush()
        if self.controller.settings.form == "filter":
            theta = self.controller.theta  # filter form: the update precedes the control
        signals = [self._known[name].copy() for name in ("y", "z", "r")]
        self._row = [u.copy(), *signals, theta, np.array([float(missed)])]
        return u

    def _flush(self) -> None:
        numbers = np.concatenate(self._row)
        self._row = []
        self._write(",".join(f"{value:.17g}" for value in numbers))

    def _write(self, line: str) -> None:
        assert self._file is not None
        data = f"{line}\n".encode()
        try:
            is_whole = os.write(self._file, data) == len(data)
            reason = "the disk is full"
        except OSError as error:
            is_whole, reason = False, error.strerror or str(error)
        if is_whole:
            self._size += len(data)
            return
        self.failure, file, self._file = reason, self._file, None
        os.ftruncate(file, self._size)  # remove an incomplete row
        os.close(file)
        warnings.warn(
            SupervisionWarning(f"the log {self.path} ends here: {reason}. The controller goes on."),
            stacklevel=4,
        )

    def close(self) -> None:
        """Write the last row and close the file."""
        if self._file is None:
            return
        if self._row:
            self._flush()
        if self._file is not None:
            os.close(self._file)
            self._file = None

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:  # fmt: skip
        self.close()
