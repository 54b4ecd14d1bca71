"""One RCAC controller for any simulator or device."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import DivergedError, FunctionFailedError, InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import vector
from rcac_numeric.arrays.values import fingerprint
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.engine.compiled.callbacks import Failures
from rcac_numeric.engine.compiled.controllers import compiled_controller
from rcac_numeric.engine.live.changes import AppliedChange, ControllerChange
from rcac_numeric.engine.live.control import apply_change
from rcac_numeric.engine.live.methods import LiveMethods
from rcac_numeric.engine.states import SavedState, saved_state
from rcac_numeric.targets.model import TargetModel


def _rebuilt(settings: ControllerSettings, state: SavedState) -> Controller:
    controller = Controller(settings)
    controller.restore(state)
    return controller


class Controller(LiveMethods):
    """An adaptive controller for any simulator or device.

    One call of `step` is one step of RCAC in the order measure, control, filter, update. It takes
    y(k) and z(k) before u(k) is known, so neither may depend on u(k): D_0 = 0 and E_2 = 0, as for
    every sampled plant without feedthrough. (`simulate` knows the plant and allows both.)

    Parameters
    ----------
    settings : ControllerSettings

    Examples
    --------
    >>> from rcac_numeric import UD, Controller, ControllerSettings, TargetModel, iir
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=2), target=TargetModel([0, 1]), update=UD(R_theta=1e-6))
    >>> controller, x = Controller(settings), 0.0
    >>> for k in range(100):  # x(k+1) = 0.9 x(k) + u(k) + 1
    ...     (u,) = controller.step(y=x, z=x)
    ...     x = 0.9 * x + u + 1
    >>> bool(abs(x) < 1e-6)
    True
    """

    def __init__(self, settings: ControllerSettings) -> None:
        if not isinstance(settings, ControllerSettings):
            raise InputError(f"settings = {settings!r}: ControllerSettings are needed.")
        self.settings = settings
        self._failures = Failures()
        self._kernel = compiled_controller(settings, settings.target.l_z, self._failures)
        self._see_targets()
        self._broken = ""
        self._at_work = Lock()

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies and pickles are controllers of their own in the same state."""
        return _rebuilt, (self.settings, self.state)

    def step(
        self,
        y: ArrayLike,
        z: ArrayLike,
        r: ArrayLike | None = None,
        u_applied: ArrayLike | None = None,
    ) -> Array:
        """One step of the controller.

        Parameters
        ----------
        y : array, shape (l_y,), or a number
            The measurement y(k).
        z : array, shape (l_z,), or a number
            The performance variable z(k).
        r : array, shape (l_r,), or a number
            The command r(k), where the structure reads one.
        u_applied : array, shape (l_u,), or a number
            What the actuator made of the last u, u(k-1), where it was not applied as it was
            returned; the target model must then be strictly proper.

        Returns
        -------
        array, shape (l_u,)
            The control u(k).

        Raises
        ------
        InputError
            Where an argument has the wrong size or is not finite; the controller has not moved.
        DivergedError
            Where the controller's own numbers have left float64.
        FunctionFailedError
            Where a weight that is a function failed.
        """
        if not self._at_work.acquire(blocking=False):
            raise _busy()
        try:
            if self._broken:
                raise DivergedError(self._broken)
            if u_applied is not None and (self.k == 0 or not self._is_strict):
                self._refuse_u_applied(u_applied)
            answer = self._moved(y, z, r, u_applied) or self._moved(*self._read(y, z, r, u_applied))
            if answer is None or not answer[1] or self._failures.error is not None:
                self._fail()
            return answer[0]
        finally:
            self._at_work.release()

    def _moved(self, *arguments: object) -> tuple[Array, bool] | None:
        """One step of the kernel; None where it could not read an argument and has not moved."""
        k = self.k
        try:
            return self._kernel.step(*arguments)
        except BaseException:  # a key was pressed while a weight that is a function ran
            self._broken = (
                f"step {k} was interrupted half-way; restore a saved state, or start anew."
            )
            raise

    def _read(self, y: Any, z: Any, r: Any, u_applied: Any) -> tuple[Array | None, ...]:
        """The arguments as arrays; raises where one is not what it should be."""
        structure = self.settings.structure
        if (r is None) != (structure.l_r == 0):
            raise InputError(f"the structure reads l_r = {structure.l_r} commands; r = {r!r}.")
        widths = {"y": structure.l_y, "z": self.settings.target.l_z, "r": structure.l_r}
        return (
            vector(y, "y", widths["y"]),
            vector(z, "z", widths["z"]),
            None if r is None else vector(r, "r", widths["r"]),
            None if u_applied is None else vector(u_applied, "u_applied", structure.l_u),
        )

    def _refuse_u_applied(self, u_applied: ArrayLike) -> NoReturn:
        vector(u_applied, "u_applied", self.settings.structure.l_u)
        if self.k == 0:
            raise InputError("u_applied belongs to the step before; at step 0 there is none.")
        raise InputError("u_applied needs a strictly proper target model.")

    def _fail(self) -> NoReturn:
        """The last step did not succeed: say why."""
        if self._failures.error is not None:
            self._broken = "a weight of this controller has failed; start a new one."
            raise FunctionFailedError(
                f"a weight that is a function failed at step {self.k - 1}: {self._failures.error}"
            ) from self._failures.error
        self._broken = (
            f"the controller left the range of float64 at step {self.k - 1}; its coefficients "
            "are no longer usable. Start a new one, with a larger R_theta or another target."
        )
        raise DivergedError(self._broken)

    def freeze(self) -> None:
        """Stop the adaptation: theta and P stay, signals are still recorded."""
        with self._alone():
            self._kernel.freeze(True)

    def resume(self) -> None:
        """Go on adapting after `freeze`."""
        with self._alone():
            self._kernel.freeze(False)

    def reset_covariance(self) -> None:
        """Set P back to P(0); theta stays.

        Raises
        ------
        InputError
            Where the update keeps no covariance.
        """
        update = self.settings.update
        if not update.keeps_covariance:
            raise InputError(f"{update!r} has no covariance that could be reset.")
        with self._alone():
            self._kernel.reset_covariance()

    def change(self, change: ControllerChange, evidence: str = "") -> AppliedChange:
        """Make several changes at once, or none of them; see `set_target` for what a target does.

        Parameters
        ----------
        change : ControllerChange
        evidence : str
            Kept with what is returned.

        Raises
        ------
        InputError, ImproperError, DivergedError
            Where a part does not fit; the controller is as it was.
        """
        with self._alone():
            if self._broken:
                raise DivergedError(self._broken)
            applied = apply_change(self._kernel, self.settings, change, evidence)
            self._see_targets()
        return applied

    def _see_targets(self) -> None:
        leading = [model.numerator[0] for model in self.settings.targets]
        self._is_strict = not any(one.any() for one in (*leading, self._kernel.target[0][0]))

    @property
    def target(self) -> TargetModel:
        """The target model that the filter runs."""
        return TargetModel(*self._kernel.target)

    @property
    def state(self) -> SavedState:
        """Everything that later steps depend on, beside the settings.

        Raises
        ------
        DivergedError
            Where a step failed half-way, so that there is no state to go on from.
        """
        if self._broken:
            raise DivergedError(self._broken)
        with self._alone():
            values = self._kernel.save()
        return SavedState.taken("controller", self.k, values, fingerprint(self.settings))

    def restore(self, state: SavedState) -> None:
        """Go back, or forward, to a saved state of a controller with the same settings.

        Raises
        ------
        InputError
            Where the state belongs to other settings; the controller has not moved.
        """
        with self._alone():
            saved_state(state, "state").restore_into(
                self._kernel, "controller", fingerprint(self.settings), lambda: self._kernel.k
            )
            self._broken, self._failures.error = "", None
            self._see_targets()

    @property
    def k(self) -> int:
        """Number of steps taken."""
        return int(self._kernel.k)

    @property
    def theta(self) -> Array:
        """The controller coefficients theta(k); shape (l_theta,)."""
        return np.asarray(self._kernel.theta)

    @property
    def P(self) -> Array:
        """The covariance P(k); shape (l_theta, l_theta).

        For the gradient update, which has none, its step size times I.
        """
        return np.asarray(self._kernel.P)

    @property
    def guard_count(self) -> int:
        """Updates so far that rounding decided; see `Run`."""
        return int(self._kernel.guard_count)

    @property
    def compensator(self) -> Compensator:
        """The present controller as a fixed compensator from [y; r] to u."""
        return self.settings.compensator_of(self.theta)

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Refuse what a weight's function or another thread does in the middle of a step."""
        if not self._at_work.acquire(blocking=False):
            raise _busy()
        try:
            yield
        finally:
            self._at_work.release()


def _busy() -> InputError:
    return InputError(
        "the controller is in the middle of a step: neither a weight that is a function "
        "nor another thread may drive it meanwhile. Use one controller for each loop."
    )
