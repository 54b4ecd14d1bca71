"""RCMR for a simulator or a device, one step at a time, and over a whole record."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import CompensatorError, DivergedError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import PLAIN, instance_of, signal_array, vector
from rcac_numeric.arrays._values import Result
from rcac_numeric.compiled._estimators import (
    EstimationError,
    Refinement,
    make_refinement,
)
from rcac_numeric.estimation._local_observability import UnidentifiableWarning
from rcac_numeric.estimation._markov import reconstruction
from rcac_numeric.estimation._refinement_settings import RCMR
from rcac_numeric.estimation._resumable import Resumable
from rcac_numeric.estimation._subsystems import FIRSubsystem, RepeatedParameters

# At this share the data weigh as much as the initial estimate.
DETERMINED = 0.5


@dataclass(frozen=True, eq=False)
class Evidence(Result):
    """The share of the initial estimate in theta, per direction.

    Attributes
    ----------
    kept : array, shape (l_theta,)
        Eigenvalues of lambda^updates P(0)^-1/2 P P(0)^-1/2, the share of the initial estimate in
        P^-1, largest first: 1 where the data say nothing.
    directions : array, shape (l_theta, l_theta)
        Their directions of theta, one in each row.
    """

    kept: Array
    directions: Array

    @property
    def undetermined(self) -> Array:
        """The directions that are still mainly the initial estimate, one in each row."""
        return self.directions[self.kept > DETERMINED]

    def __str__(self) -> str:
        """Describe the undetermined directions."""
        unknown = self.undetermined
        if not len(unknown):
            return "the data determine every coefficient."
        if len(self.kept) == 1:
            subject = "theta"
        else:
            subject = f"{len(unknown)} of {len(self.kept)} directions of theta"
        return (
            f"the data do not determine {subject}: the regressor is too small there, and the "
            "estimate "
            "is mainly theta_0. Excite the model by a richer w, or raise beta if the signals are "
            "small and clean."
        )


def evidence(settings: RCMR, P: Array, k: int) -> Evidence:
    """The evidence in P after k steps with these settings."""
    share = settings.lambda_ ** max(k - settings.k_update, 0)
    root = np.linalg.cholesky(settings.beta)
    whitened = share * np.linalg.solve(root, np.linalg.solve(root, P).T)
    values, vectors = np.linalg.eigh((whitened + whitened.T) / 2)
    return Evidence(values[::-1], np.ascontiguousarray((root @ vectors[:, ::-1]).T))


class ModelRefinement(Resumable[RCMR]):
    """RCMR for a simulator or a device, one step at a time.

    One step: z(k) = C x^(k) - y(k), the update to theta(k), u^(k) = Phi(k) theta(k), and the
    model's step to k + 1.

    Parameters
    ----------
    settings : RCMR

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.estimation import RCMR, ModelRefinement
    >>> model = RCMR(A=0.5, B=1, D_1=1, C=1, E_1=1, beta=1, delays=(1,))
    >>> refinement, x = ModelRefinement(model), 0.0
    >>> for w in np.random.default_rng(1).standard_normal(300):
    ...     theta = refinement.step(w=w, y=x)
    ...     x = (0.5 + 0.3) * x + w  # the unknown parameter is 0.3
    >>> theta.round(3)
    array([0.3])
    """

    kind = "refinement"

    def __init__(self, settings: RCMR) -> None:
        self._kernel = compiled_refinement(settings)
        super().__init__(settings)
        self._broken = ""
        self._measured = False
        self._at_work = Lock()

    def step(self, w: ArrayLike, y: ArrayLike, x: ArrayLike | None = None) -> Array:
        """One step of RCMR.

        Parameters
        ----------
        w : array, shape (l_w,), or a number
            The known input w(k).
        y : array, shape (l_y,), or a number
            The measurement y(k).
        x : array, shape (n,), optional
            A measured or observed state x(k), from which the model takes this step, so that it is
            a one-step predictor. Left out, the model runs freely.

        Returns
        -------
        array, shape (l_theta,)
            theta(k).

        Raises
        ------
        InputError
            Where an argument has the wrong size or is not finite; nothing has moved.
        DivergedError
            Where the model or its coefficients left the range of float64.
        """
        self._require_half(measured=False)

        def moved() -> None:
            plain = type(w) in PLAIN and type(y) in PLAIN and type(x) in PLAIN
            if not (plain and self._kernel.step(w, y, x)):
                inputs, outputs, state = self._read(w, y, x)
                self._kernel.step(inputs, outputs, state)

        self._alone(moved)
        return self.theta

    def measure(self, y: ArrayLike, x: ArrayLike | None = None) -> Array:
        """The first half of a step, for a w(k) that depends on theta(k); then call `advance`.

        Parameters
        ----------
        y : array, shape (l_y,), or a number
        x : array, shape (n,), optional
            As in `step`.

        Returns
        -------
        array, shape (l_theta,)
            theta(k).
        """
        self._require_half(measured=False)

        def moved() -> None:
            if not self._kernel.half(y, x, True):
                _, outputs, state = self._read(None, y, x)
                self._kernel.half(outputs, state, True)

        self._alone(moved)
        self._measured = True
        return self.theta

    def advance(self, w: ArrayLike) -> None:
        """The second half: u^(k), and the model's step to k + 1 with w(k).

        Parameters
        ----------
        w : array, shape (l_w,), or a number
        """
        self._require_half(measured=True)

        def moved() -> None:
            if not self._kernel.half(w, None, False):
                self._kernel.half(vector(w, "w", self.settings.l_w), None, False)

        self._alone(moved)
        self._measured = False

    def _read(self, w: Any, y: Any, x: Any) -> tuple[Array | None, ...]:
        """Return the arguments as arrays, or raise an error."""
        settings = self.settings
        return (
            None if w is None else vector(w, "w", settings.l_w),
            vector(y, "y", settings.l_y),
            None if x is None else vector(x, "x", settings.n),
        )

    def _require_half(self, *, measured: bool) -> None:
        if self._broken:
            raise DivergedError(self._broken)
        if measured != self._measured:
            raise InputError(
                "y(k) was measured already: call advance(w) next."
                if self._measured
                else "advance(w) comes after measure(y)."
            )

    def _alone(self, moved: Callable[[], None]) -> None:
        if not self._at_work.acquire(blocking=False):
            raise InputError("the refinement is in the middle of a step; use one for each loop.")
        try:
            moved()
        except EstimationError as error:
            failure = self._failed(error)
            raise failure from None
        finally:
            self._at_work.release()

    def _failed(self, error: Exception) -> CompensatorError:
        _, words = error.args
        self._broken = (
            f"step {self.k}: {words}: the free-running model diverged. Give step a measured x, use "
            "a smaller beta or more delays; this object is no longer usable."
        )
        return DivergedError(self._broken)

    def freeze(self) -> None:
        """Stop the updates; the model goes on."""
        self._kernel.freeze(True)

    def resume(self) -> None:
        """Go on with the updates after `freeze`."""
        self._kernel.freeze(False)

    @property
    def k(self) -> int:
        """Number of steps taken."""
        return self._kernel.k

    @property
    def theta(self) -> Array:
        """theta, shape (l_theta,): [N_1 ... N_nc] row by row, or the parameters."""
        return np.asarray(self._kernel.theta)

    @property
    def P(self) -> Array:
        """The matrix P of the recursion, shape (l_theta, l_theta); no covariance of errors."""
        return np.asarray(self._kernel.P)

    @property
    def x(self) -> Array:
        """The state x^(k) that the model has reached."""
        return np.asarray(self._kernel.x)

    @property
    def z(self) -> Array:
        """The performance C x^ - y of the last step, shape (l_y,)."""
        return np.asarray(self._kernel.z)

    @property
    def u(self) -> Array:
        """The subsystem's output u^ of the last step, shape (l_u,)."""
        return np.asarray(self._kernel.u)

    @property
    def evidence(self) -> Evidence:
        """The directions of theta that the data determine so far."""
        return evidence(self.settings, self.P, self.k)

    def save(self) -> Array:
        """Every number that later steps depend on."""
        self._require_half(measured=False)
        return np.asarray(self._kernel.save())

    def take_up(self, values: Array) -> None:
        """Continue from a saved state."""
        self._kernel.restore(values)
        self._broken, self._measured = "", False


def compiled_refinement(settings: RCMR) -> Refinement:
    """The refinement at step 0 for the kernel."""
    instance_of(settings, "settings", RCMR)
    chosen, l_u = settings.delays.index(settings.d), settings.l_u
    rows = slice(chosen * l_u, (chosen + 1) * l_u)
    eigenvalues, V_d, W = reconstruction(settings.H, settings.R, rows)
    part = settings.subsystem
    A_j = D_j = np.zeros(0)
    n_c, strictly_proper = 0, False
    if isinstance(part, RepeatedParameters):
        A_j = part.A
        D_j = part.D if part.D.shape[2] else np.zeros((part.l_theta, settings.n, settings.l_w))
    elif isinstance(part, FIRSubsystem):
        n_c, strictly_proper = part.n_c, part.strictly_proper
    return make_refinement(
        sizes=[settings.n, settings.l_w, l_u, settings.l_y, int(settings.E_1.shape[0])],
        A=settings.A,
        D_1=settings.D_1,
        B=settings.B,
        C=settings.C,
        delays=settings.delays,
        stack=settings.stack,
        H=settings.H,
        R=settings.R,
        eigenvalues=eigenvalues,
        V_d=V_d,
        W=W,
        chosen=chosen,
        eta_bar=settings.eta_bar,
        forgetting=settings.lambda_,
        direct=settings.method == "direct",
        change=settings.method == "nearest",
        k_update=settings.k_update,
        E_1=settings.E_1,
        n_c=n_c,
        strictly_proper=strictly_proper,
        A_j=A_j,
        D_j=D_j,
        P_0=settings.beta,
        theta_0=settings.theta_0,
        x_0=settings.x_0,
    )


@dataclass(frozen=True, eq=False)
class RefinementRun(Result):
    """The results of RCMR over a record.

    Attributes
    ----------
    settings : RCMR
    theta : array, shape (steps, l_theta)
        theta(k).
    z : array, shape (steps, l_y)
        C x^(k) - y(k).
    u : array, shape (steps, l_u)
        The subsystem's output u^(k).
    P : array, shape (l_theta, l_theta)
        At the end.
    evidence : Evidence
        Which directions of theta the record determines.
    guard_count : int
        Updates that rounding decided.
    """

    settings: RCMR
    theta: Array
    z: Array
    u: Array
    P: Array
    evidence: Evidence
    guard_count: int


def refine(settings: RCMR, w: ArrayLike, y: ArrayLike, x: ArrayLike | None = None) -> RefinementRun:
    """Refine a model with a record of inputs and measurements.

    Parameters
    ----------
    settings : RCMR
    w : array, shape (steps, l_w)
        The known input; a 1-D array is one signal.
    y : array, shape (steps, l_y)
        The measurements.
    x : array, shape (steps, n), optional
        Measured states, for a one-step predictor.

    Returns
    -------
    RefinementRun

    Raises
    ------
    InputError
        Where shapes do not fit or an entry is not finite.
    DivergedError
        Where the free-running model left the range of float64.

    Warns
    -----
    UnidentifiableWarning
        Where the record does not determine every coefficient.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.estimation import RCMR, refine
    >>> w, x = np.random.default_rng(1).standard_normal(300), [0.0]
    >>> for input in w[:-1]:
    ...     x.append((0.5 + 0.3) * x[-1] + input)
    >>> run = refine(RCMR(A=0.5, B=1, D_1=1, C=1, E_1=1, delays=(1,)), w, x)
    >>> run.theta[-1].round(3)
    array([0.3])
    """
    run = refined_record(settings, w, y, x)
    if len(run.evidence.undetermined):
        warnings.warn(str(run.evidence), UnidentifiableWarning, stacklevel=2)
    return run


def refined_record(
    settings: RCMR, w: ArrayLike, y: ArrayLike, x: ArrayLike | None = None
) -> RefinementRun:
    """As `refine`, without the warning, for callers that read `evidence`."""
    kernel = compiled_refinement(settings)
    outputs = signal_array(y, "y", settings.l_y)
    steps = len(outputs)
    inputs = signal_array(w, "w", settings.l_w, steps)
    states = np.zeros(0) if x is None else signal_array(x, "x", settings.n, steps)
    theta = np.zeros((steps, settings.l_theta))
    z, u = np.zeros((steps, settings.l_y)), np.zeros((steps, settings.l_u))
    try:
        kernel.run(inputs, outputs, states, theta, z, u)
    except EstimationError:
        raise DivergedError(
            f"the refined model left the range of float64 at step {kernel.k}: in free run it "
            "became "
            "unstable. Give the states x that were measured, use a smaller beta, or other delays."
        ) from None
    P = np.asarray(kernel.P)
    evidence_of_run = evidence(settings, P, kernel.k)
    return RefinementRun(settings, theta, z, u, P, evidence_of_run, kernel.guard_count)
