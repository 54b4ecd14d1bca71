"""A Kalman filter for any simulator or device, one step at a time."""

from __future__ import annotations

from threading import Lock
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import float_array, vector
from rcac_numeric.compiled._estimators import (
    EstimationModel,
    Filter,
    estimation_failure,
    make_adaptive_filter,
    make_filter,
    make_interacting_filters,
)
from rcac_numeric.estimation._compiled import compiled_model
from rcac_numeric.estimation._resumable import Resumable
from rcac_numeric.estimation._settings import (
    EKF,
    IMM,
    UKF,
    AdaptiveNoises,
    AnyFilter,
    covariance_of,
    noise_roots,
    square_root,
)


def compiled_filter(settings: AnyFilter) -> tuple[Filter, EstimationModel]:
    """The filter at step 0 for the kernel, and its model; of several modes that of the first."""
    if isinstance(settings, IMM):
        each = [_arguments(one) for one in settings.filters]
        filters = make_interacting_filters(each, settings.transitions, settings.probabilities)
        return filters, each[0][1]
    if isinstance(settings, AdaptiveNoises):
        _, model, x_0, P_0, Q, R, *_ = _arguments(settings.filter)
        learned = ("Q" in settings.learn, "R" in settings.learn, settings.diagonal)
        begins = (model, x_0, P_0, Q, R, settings.window, settings.iterations)
        return make_adaptive_filter(*begins, *learned), model
    if not isinstance(settings, EKF | UKF):
        raise InputError(f"settings = {settings!r}: an EKF or a UKF is needed.")
    arguments = _arguments(settings)
    return make_filter(*arguments), arguments[1]


def _arguments(
    settings: EKF | UKF,
) -> tuple[str, EstimationModel, Array, Array, Array, Array, float, float]:
    """The arguments of the kernel's filter."""
    kind, alpha, beta = "unscented", 1.0, 0.0
    if isinstance(settings, UKF):
        alpha, beta = settings.alpha, settings.beta
    else:
        kind = "extended" if settings.form == "square root" else "joseph"
    P_0, Q, R = map(square_root, (settings.P_0, settings.Q, settings.R))
    return kind, compiled_model(settings.model), settings.x_0, P_0, Q, R, alpha, beta


class Estimator(Resumable[AnyFilter]):
    """A Kalman filter for a simulator or a device, one step at a time.

    `step(y, u)` is one step: y(k) corrects the belief about x(k), then u(k) moves it to step k+1.
    Where u(k) is computed from the estimate, call `correct`, read `x`, and call `predict`.

    Parameters
    ----------
    settings : EKF, UKF, IMM or AdaptiveNoises

    Examples
    --------
    >>> from rcac_numeric.estimation import UKF, Estimator, LinearModel
    >>> estimator = Estimator(UKF(LinearModel(A=0.9, B=1, C=1), Q=0.01, R=0.1))
    >>> for y in (1.0, 0.8, 1.1):
    ...     estimate = estimator.step(y=y, u=0.1)
    >>> other = Estimator(estimator.settings)
    >>> other.restore(estimator.state)
    >>> bool(other.step(y=1, u=0) == estimator.step(y=1, u=0))
    True
    """

    kind = "filter"

    def __init__(self, settings: AnyFilter) -> None:
        self._kernel, _ = compiled_filter(settings)
        super().__init__(settings)
        self._at_work = Lock()

    def step(
        self,
        y: ArrayLike | None,
        u: ArrayLike | None = None,
        *,
        Q: ArrayLike | None = None,
        R: ArrayLike | None = None,
    ) -> Array:
        """Correct with y(k), then predict with u(k); the estimate x(k|k).

        Parameters
        ----------
        y : array, shape (l_y,), a number, or None
            The measurement; None where it is missing, NaN where an entry of it is.
        u : array, shape (l_u,), or a number
            The known input, where the model has one.
        Q, R : arrays or numbers, optional
            Q(k) and R(k) where they are others than those of the settings, in this step alone; of
            an EKF or a UKF.

        Returns
        -------
        array, shape (n,)
            x(k|k).

        Raises
        ------
        InputError
            Where an argument has the wrong size or is infinite, or a covariance is not
            semidefinite.
        FunctionFailedError
            Where a function of the model raised, or gave what is not finite.
        IllConditionedError
            Where the covariance of the innovation is singular, or lost its definiteness.
        DivergedError
            Where the estimate left the range of float64.
            Whatever is raised, the estimator has not moved.
        """
        before = self.x if y is None else None
        if Q is None and R is None:
            self._move(y, u, corrects=y is not None, predicts=True)
        else:
            self._move_with(noises_of_steps(self.settings, Q, R), y, u)
        return np.asarray(self._kernel.corrected) if before is None else before

    def correct(self, y: ArrayLike, u: ArrayLike | None = None) -> Array:
        """Correct the estimate of x(k) with y(k); u(k) matters if h depends on it.

        Parameters
        ----------
        y : array, shape (l_y,), or a number
            An entry that is NaN was not measured.
        u : array, shape (l_u,), or a number
            Zero where it is left out.

        Returns
        -------
        array, shape (n,)
            x(k|k).
        """
        if u is None:
            u = np.zeros(self.settings.model.l_u)
        self._move(y, u, corrects=True, predicts=False)
        return self.x

    def predict(self, u: ArrayLike | None = None) -> Array:
        """Predict the estimate of step k + 1 with u(k).

        Parameters
        ----------
        u : array, shape (l_u,), or a number

        Returns
        -------
        array, shape (n,)
            x(k+1|k).
        """
        self._move(None, u, corrects=False, predicts=True)
        return self.x

    def _move_with(self, noises: tuple[Array, Array], y: Any, u: Any) -> None:
        """Take a step with separate noises."""
        self._kernel.set_noises(*noises)
        try:
            self._move(y, u, corrects=y is not None, predicts=True)
        finally:
            self._kernel.set_noises(*noises_of_steps(self.settings))

    def _move(self, y: Any, u: Any, *, corrects: bool, predicts: bool) -> None:
        if not self._at_work.acquire(blocking=False):
            raise InputError("the estimator is in the middle of a step; use one for each loop.")
        try:
            if not self._kernel.move(y, u, corrects, predicts):
                model = self.settings.model
                wide = vector(np.zeros(0) if u is None else u, "u", model.l_u)
                read = _measured(y, model.l_y) if corrects else None
                self._kernel.move(read, wide, corrects, predicts)
        except InputError:
            raise
        except Exception as error:
            self._fail(error)
        finally:
            self._at_work.release()

    def _fail(self, error: Exception) -> NoReturn:
        raise estimation_failure(error, self.k) from error

    @property
    def k(self) -> int:
        """Number of predictions: the step that x and P are of."""
        return self._kernel.k

    @property
    def x(self) -> Array:
        """The estimate; x(k|k-1), or x(k|k) after `correct`. Shape (n,)."""
        return np.asarray(self._kernel.x)

    @property
    def P(self) -> Array:
        """The covariance of the estimate, shape (n, n)."""
        return np.asarray(self._kernel.P)

    @property
    def probabilities(self) -> Array:
        """Mode probabilities of an IMM at the step of `x`, shape (M,); empty without modes."""
        return np.asarray(self._kernel.probabilities)

    @property
    def Q(self) -> Array:
        """The covariance of the noise of x in use, shape (n, n): learned where noises are.

        Raises
        ------
        InputError
            For an IMM, where each mode has its own.
        """
        return self._noise(0)

    @property
    def R(self) -> Array:
        """The covariance of the noise of y in use, shape (l_y, l_y), as Q."""
        return self._noise(1)

    def _noise(self, which: int) -> Array:
        if isinstance(self.settings, IMM):
            raise InputError("each mode of an IMM has its own noises: see settings.filters.")
        return noises_in_use(self._kernel, self.settings)[which]

    @property
    def innovation(self) -> Array:
        """Y - h(x(k|k-1)) of the last correction, shape (l_y,)."""
        return np.asarray(self._kernel.innovation)

    @property
    def nis(self) -> float:
        """The last innovation squared and normalised; l_y on average where the noises are right.

        NaN where that correction had no measurement.
        """
        return self._kernel.nis

    def save(self) -> Array:
        """Return the state of the estimator as one array of numbers."""
        return np.asarray(self._kernel.save())

    def take_up(self, values: Array) -> None:
        """Continue from a saved state."""
        self._kernel.restore(values)


def noises_of_steps(
    settings: AnyFilter, Q: ArrayLike | None = None, R: ArrayLike | None = None
) -> tuple[Array, Array]:
    """Square roots of Q and R of one step, if it has separate ones."""
    if not isinstance(settings, EKF | UKF):
        raise InputError(
            f"Q and R of single steps are for an EKF or a UKF: a {type(settings).__name__} has its "
            "own."
        )
    return noise_roots(settings, Q, R)


def noises_in_use(filter: Filter, settings: EKF | UKF | AdaptiveNoises) -> tuple[Array, Array]:
    """Q and R."""
    roots = zip(filter.noises, (settings.model.n, settings.model.l_y), strict=True)
    Q, R = (covariance_of(np.asarray(root).reshape(size, size)) for root, size in roots)
    return Q, R


def _measured(y: Any, l_y: int) -> Array:
    """A measurement whose missing entries are NaN."""
    outputs = float_array(y, "y")
    there = vector(np.where(np.isnan(outputs), 0.0, outputs), "y", l_y)
    return np.where(np.isnan(outputs.reshape(-1)), np.nan, there)
