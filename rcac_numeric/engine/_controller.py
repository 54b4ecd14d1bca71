"""The RCAC controller for step-by-step use with a simulator or device."""

from __future__ import annotations

import warnings
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from threading import Lock
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import (
    CompensatorError,
    DivergedError,
    FunctionFailedError,
    InputError,
)
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import (
    PLAIN,
    gaps_as_nan,
    has_mask,
    instance_of,
    number,
    vector,
)
from rcac_numeric.arrays._values import fingerprint, html_table, shown_array
from rcac_numeric.compiled._callbacks import Failures
from rcac_numeric.compiled._controllers import compiled_controller, fitted_denominator
from rcac_numeric.controllers._bounds import CertifiedBounds
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._limits import ControlLimits
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._supervision import (
    Supervision,
    SupervisionRecord,
    SupervisionWarning,
)
from rcac_numeric.controllers._weights import SignalWeight
from rcac_numeric.engine._changes import AppliedChange, ControllerChange
from rcac_numeric.engine._device_learner import DeviceLearner, require_not_learnt
from rcac_numeric.engine._live_control import apply_change
from rcac_numeric.engine._states import SavedState, saved_state
from rcac_numeric.targets._model import TargetModel


def _rebuilt(
    settings: ControllerSettings, state: SavedState, supervision: Supervision | None = None,
    limits: ControlLimits | None = None,
) -> Controller:  # fmt: skip
    controller = Controller(settings, supervision, limits)
    controller.restore(state)
    return controller


# Text of a warning, issued once: the meaning and the next step.
WORDS = {
    "windup": "P grows where the data do not excite theta, and the next disturbance causes a "
    "large step of theta; use CappedForgetting, or SubspaceForgetting, or lambda = 1",
    "overflow": "an update overflowed float64; theta is restored to its last valid value, P to "
    "P(0)",
}


class Controller:
    """An adaptive controller for any simulator or device.

    One call of `step` is one step of RCAC in the order measure, control, filter, update. It takes
    y(k) and z(k) before u(k) is known, so neither may depend on u(k): D_0 = 0 and E_2 = 0, as for
    every sampled plant without feedthrough. (`simulate` knows the plant and allows both.)

    Parameters
    ----------
    settings : ControllerSettings
        With `DataDriven` as `target` the controller learns the target model as in `simulate`, bit
        for bit.
    supervision : Supervision, optional
        Supervision of the controller. By default the controller notes faults in `record`, warns of
        windup and overflow (`SupervisionWarning`), and returns a finite u at every step.

    limits : ControlLimits, optional
        Of u and of its change, kept by the controller itself.

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

    def __init__(
        self, settings: ControllerSettings, supervision: Supervision | None = None,
        limits: ControlLimits | None = None,
    ) -> None:  # fmt: skip
        if not isinstance(settings, ControllerSettings):
            raise InputError(f"settings = {settings!r}: ControllerSettings are needed.")
        self.settings = settings
        self._failures = Failures()
        self.supervision = Supervision() if supervision is None else supervision
        instance_of(self.supervision, "supervision", Supervision)
        self.limits = None if limits is None else instance_of(limits, "limits", ControlLimits)
        self._kernel = compiled_controller(
            settings,
            settings.target.l_z,
            self._failures,
            supervision=self.supervision,
            limits=limits,
        )
        self._reported_kinds: set[str] = set()
        self._learner = None if settings.learning is None else DeviceLearner(settings, self._kernel)
        self._whole = self._learner.whole if self._learner else self._kernel
        self._changes: deque[AppliedChange] = deque(maxlen=1000)
        self._see_targets()
        self._broken = ""
        self._at_work = Lock()

    def __reduce__(self) -> tuple[Any, ...]:
        """Support copies and pickles: separate controllers in the same state."""
        return _rebuilt, (self.settings, self.state, self.supervision, self.limits)

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
            Where an argument has the wrong size or is no number, or without supervision not
            finite; the controller has not moved.
        DivergedError
            Without supervision, where the controller's own numbers have left float64.
        FunctionFailedError
            Where a weight that is a function failed.
        """
        if not self._at_work.acquire(blocking=False):
            raise busy()
        try:
            if self._broken:
                raise DivergedError(self._broken)
            if u_applied is not None and (self.k == 0 or not self._is_strict):
                refuse_u_applied(self.settings, self.k, u_applied)
            answer = None
            if not self._learner and type(y) in PLAIN and type(z) in PLAIN and type(r) in PLAIN:
                answer = self._moved(y, z, r, u_applied) if type(u_applied) in PLAIN else None
            if answer is None:
                gaps = self.supervision.is_on
                arguments = step_arguments(self.settings, y, z, r, u_applied, gaps=gaps)
                answer = self._moved(*arguments, learner=self._learner)
            if answer is None or not answer[1] or self._failures.error is not None:
                self._fail()
            if answer[1] > 1:
                self._warn()
            return answer[0]
        finally:
            self._at_work.release()

    def _moved(
        self, *arguments: Any, learner: DeviceLearner | None = None
    ) -> tuple[Array, int] | None:
        """Return u(k) of the kernel; None if an argument was not readable and no step was made."""
        k = self.k
        try:
            if learner is not None:
                learner.before(k, arguments[3], self._change)
            answer = self._kernel.step(*arguments)
            if learner is not None and answer is not None:
                learner.after(answer[0], *arguments[:3])
            return answer
        except DivergedError:  # discard the recorded change
            raise
        except BaseException:  # Ctrl-C during a weight function
            self._broken = (
                f"step {k} was interrupted; restore a saved state, or create a new controller."
            )
            raise

    def _fail(self) -> NoReturn:
        """Raise the error of the failed step."""
        self._broken, error = failed_step(self.k - 1, self._failures.error)
        raise error from self._failures.error

    def _warn(self) -> None:
        """Warn once about every trouble."""
        record = self.record
        for event in record.events:
            if event.kind in WORDS and event.kind not in self._reported_kinds:
                self._reported_kinds.add(event.kind)
                words = f"{event}: {WORDS[event.kind]}"
                warnings.warn(words, SupervisionWarning, stacklevel=3)

    def freeze(self) -> None:
        """Stop the adaptation: theta and P stay constant, the regressor is still updated."""
        self._hold(True)

    def resume(self) -> None:
        """Resume the adaptation after `freeze` or after a policy of the supervision.

        After a policy, P restarts from P(0), and the transfer of u is bumpless.
        """
        self._hold(False)
        with self._alone():
            self._kernel.resume_from_trouble()

    def take_over(self, u: ArrayLike, fade: float = 0.9) -> None:
        """Take over the plant from another controller with a bumpless transfer.

        With ``b = u(k-1) - u~(k)``, where u~ is the request of this controller, the output is
        ``u~(k + i) + fade^i b`` from the next step on.

        Parameters
        ----------
        u : array, shape (l_u,), or a number
            What the other one applied last.
        fade : float
            In [0, 1).

        Raises
        ------
        InputError
            Where u has another width, or fade is out of range.

        Examples
        --------
        >>> from rcac_numeric import UD, Controller, ControllerSettings, TargetModel, iir
        >>> controller = Controller(ControllerSettings(
        ...     structure=iir(n_c=2), target=TargetModel([0, 1]), update=UD(R_theta=1)))
        >>> controller.take_over(5.0, fade=0.5)
        >>> [float(controller.step(y=0, z=0)[0]) for k in range(3)]
        [5.0, 2.5, 1.25]
        """
        last = vector(u, "u", self.settings.structure.l_u)
        if not 0 <= number(fade, "fade") < 1:
            raise InputError(f"fade = {fade} is not in [0, 1).")
        with self._alone():
            self._kernel.take_over(last, float(fade))

    def _hold(self, frozen: bool) -> None:
        with self._alone():
            (self._learner or self._kernel).freeze(frozen)

    def reset_covariance(self) -> None:
        """Set P back to P(0); theta stays.

        Raises
        ------
        InputError
            Where the update keeps no covariance.
        """
        update = self.settings.update
        if not update.keeps_covariance:
            raise InputError(f"{update!r} has no covariance to reset.")
        with self._alone():
            self._kernel.reset_covariance()

    def change(self, change: ControllerChange, evidence: str = "") -> AppliedChange:
        """Apply several changes together or none; see `set_target` for target models.

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
            if isinstance(change, ControllerChange):
                require_not_learnt(self.settings, change)
            return self._change(change, evidence)

    def _change(self, change: ControllerChange, evidence: str) -> AppliedChange:
        self._changes.append(apply_change(self._kernel, self.settings, change, evidence))
        self._see_targets()
        return self._changes[-1]

    def set_target(self, target: TargetModel, covariance: str = "blend") -> AppliedChange:
        """Set another G_f from the next step on; theta is kept.

        The past of the filter is what the new G_f makes of the stored signals, as if it had been
        there from the beginning: exactly for an FIR model, and for one with D_f as far as its poles
        have settled within 200 steps. With rho = ``sum |new - old|^2 / sum |new|^2`` of the
        filtered signals over the last 64 steps P becomes

        - "keep": what it is. The fastest to forgive where the zero hardly moved.
        - "reset": P(0). Where the old model was wrong rather than moved.
        - "blend": with P = U D U', d_j <- max(d_j, min(d_j / (1 - rho), d_j(0))), and P(0) where
          rho >= 0.999 or the number of NMP zeros changes, the default.
        - "replay": P(0), and the last 200 steps once more with the new filter; costs as much as
          they do.

        `Instantaneous` and `Gradient` keep nothing, so that nothing becomes of it; the window of a
        `SlidingWindow` is filled again from the stored signals, but for "keep".

        Parameters
        ----------
        target : TargetModel
            Of the same shape; an order up to 200 above the greatest in the settings.
        covariance : {"blend", "keep", "reset", "replay"}

        Raises
        ------
        InputError, ImproperError, DivergedError
            Where the target does not fit; the controller is as it was.

        Examples
        --------
        >>> from rcac_numeric import UD, Controller, ControllerSettings, TargetModel, iir
        >>> controller = Controller(ControllerSettings(
        ...     structure=iir(n_c=2), target=TargetModel([0, 1]), update=UD(R_theta=1e-3)))
        >>> for k in range(20):
        ...     _ = controller.step(y=k % 3, z=k % 2)
        >>> controller.set_target(TargetModel([0, 1, -1.5])).covariance  # an NMP zero came
        'reset'
        """
        return self.change(ControllerChange(target, covariance=covariance))

    def set_lambda(self, lambda_: float) -> AppliedChange:
        """Set another forgetting factor from the next step on, until a scheduled one.

        Parameters
        ----------
        lambda_ : float
            In (0, 1].

        Raises
        ------
        InputError
            Where the update forgets nothing, or by a rule of its own.
        """
        return self.change(ControllerChange(lambda_=lambda_))

    def set_weights(
        self,
        R_z: ArrayLike | SignalWeight | None = None,
        R_u: ArrayLike | SignalWeight | None = None,
        R_u_unfiltered: ArrayLike | None = None,
    ) -> AppliedChange:
        """Set other weights of (2.41) from the next step on; None keeps a weight.

        Parameters
        ----------
        R_z, R_u : float, array of shape (l_z, l_z), or SignalWeight
            A function is refused, because a saved state could not hold it.
        R_u_unfiltered : float or array of shape (l_u, l_u)

        Raises
        ------
        InputError
            Where a weight has another shape, or is not definite as it should be.
        """
        return self.change(ControllerChange(R_z=R_z, R_u=R_u, R_u_unfiltered=R_u_unfiltered))

    @property
    def changes(self) -> tuple[AppliedChange, ...]:
        """The last 1000 changes since the start or a restore, those of `DataDriven` included."""
        return tuple(self._changes)

    def _see_targets(self) -> None:
        leading = [model.numerator[0] for model in self.settings.targets]
        self._is_strict = not any(one.any() for one in (*leading, self._kernel.target[0][0]))

    @property
    def target(self) -> TargetModel:
        """The current target model."""
        return TargetModel(*self._kernel.target)

    @property
    def state(self) -> SavedState:
        """The state of the controller: everything but the settings that later steps depend on.

        Raises
        ------
        DivergedError
            Where a step failed, so that the state is undefined.
        """
        if self._broken:
            raise DivergedError(self._broken)
        with self._alone():
            values = self._whole.save()
        return SavedState.of_values("controller", self.k, values, self._name)

    def restore(self, state: SavedState) -> None:
        """Restore a saved state of a controller with the same settings.

        Raises
        ------
        InputError
            Where the state belongs to other settings; the controller has not moved.
        """
        with self._alone():
            saved_state(state, "state").restored(
                "controller", self._name,
                save=self._whole.save, restore=self._whole.restore, steps=lambda: self._kernel.k,
            )  # fmt: skip
            self._broken, self._failures.error = "", None
            self._changes.clear()
            self._see_targets()

    @property
    def _name(self) -> str:
        """Return the fingerprint of the settings, the identity of a state."""
        if self.supervision == Supervision() and self.limits is None:
            return fingerprint(self.settings)
        parts = (self.settings, self.supervision)
        return fingerprint(parts if self.limits is None else (*parts, self.limits))

    @property
    def record(self) -> SupervisionRecord:
        """The record of the supervision since step 0."""
        return SupervisionRecord.of(self._kernel.troubles)

    @property
    def k(self) -> int:
        """Number of steps taken."""
        return int(self._kernel.k)

    @property
    def theta(self) -> Array:
        """The controller coefficients theta(k); shape (l_theta,)."""
        return np.asarray(self._kernel.theta)

    @property
    def D_f(self) -> Array | None:
        """1, d_1, ..., d_n of the denominator fitted by `JointUD`; else None."""
        return fitted_denominator(self.settings, self._kernel)

    @property
    def P(self) -> Array:
        """The covariance P(k); shape (l_theta, l_theta).

        For the gradient update: its step size times I.
        """
        return np.asarray(self._kernel.P)

    @property
    def guard_count(self) -> int:
        """Number of updates decided by rounding; see `Run`."""
        return int(self._kernel.guard_count)

    @property
    def bounded(self) -> int:
        """Number of updates after which theta was moved to its bounds."""
        return int(self._kernel.bounded)

    @property
    def radius(self) -> float | None:
        """The share of the radius of `CertifiedBounds` that theta(k) uses; None without them."""
        bounds = self.settings.bounds
        return float(bounds.radius_of(self.theta)) if isinstance(bounds, CertifiedBounds) else None

    @property
    def compensator(self) -> Compensator:
        """The current controller as a fixed compensator from [y; r] to u."""
        return self.settings.compensator_of(self.theta)

    def __repr__(self) -> str:
        return f"Controller(k={self.k}, theta={shown_array(self.theta)})"

    def _repr_html_(self) -> str:
        """Return the notebook view: settings, state, and the record of the supervision."""
        rows = [
            ("k", str(self.k)),
            ("theta", shown_array(self.theta)),
            ("settings", str(self.settings)),
            ("record", str(self.record)),
        ]
        return html_table("Controller", rows)

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Raise for calls from a weight function or another thread during a step."""
        if not self._at_work.acquire(blocking=False):
            raise busy()
        try:
            yield
        finally:
            self._at_work.release()


# Arguments of a step, and errors of a failed step.

StepArguments = tuple[Array, Array, Array | None, Array | None]


def step_arguments(
    settings: ControllerSettings, y: Any, z: Any, r: Any, u_applied: Any, *, gaps: bool = False
) -> StepArguments:
    """Return the arguments of a step as arrays."""
    structure = settings.structure
    if (r is None) != (structure.l_r == 0):
        raise InputError(f"the structure reads l_r = {structure.l_r} commands; r = {r!r}.")
    return (
        _sample(y, "y", structure.l_y, gaps),
        _sample(z, "z", settings.target.l_z, gaps),
        None if r is None else _sample(r, "r", structure.l_r, gaps),
        None if u_applied is None else vector(u_applied, "u_applied", structure.l_u),
    )


def _sample(value: Any, name: str, size: int, gaps: bool) -> Array:
    """Return a signal at one step; with `gaps` an entry may be infinite or NaN."""
    value = gaps_as_nan(value) if gaps else value
    if gaps and not has_mask(value):
        with suppress(TypeError, ValueError, OverflowError):
            array = np.asarray(value)
            if array.dtype.kind == "f" and array.size == size:
                known = np.isfinite(array)
                whole = vector(np.where(known, array, 0.0), name, size)
                return np.where(known.reshape(whole.shape), whole, np.nan)
    return vector(value, name, size)


def refuse_u_applied(settings: ControllerSettings, k: int, u_applied: ArrayLike) -> NoReturn:
    """Raise the reason why u_applied is invalid at step k."""
    vector(u_applied, "u_applied", settings.structure.l_u)
    if k == 0:
        raise InputError("u_applied is the applied u of the previous step; leave it out at step 0.")
    raise InputError("u_applied needs a strictly proper target model.")


def failed_step(k: int, cause: BaseException | None) -> tuple[str, CompensatorError]:
    """Return the message of later calls after step k failed, and the error of step k."""
    if cause is not None:
        words = f"a weight that is a function failed at step {k}: {cause}"
        return (
            "a weight function of this controller has failed; create a new controller.",
            FunctionFailedError(words),
        )
    words = (
        f"the controller overflowed float64 at step {k}; its coefficients are invalid. Create a "
        f"new controller with a larger R_theta or another target."
    )
    return words, DivergedError(words)


def busy() -> InputError:
    """Return the error of a call during a step."""
    return InputError(
        "the controller is executing a step: a weight function or another thread cannot call it "
        "now. Use one controller for each loop."
    )
