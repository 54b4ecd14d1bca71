"""A Kalman filter over a whole record."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from compensator_theory import figures
from compensator_theory.errors import FunctionFailedError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import float_array, real_array, signal_array
from rcac_numeric.arrays._values import Result
from rcac_numeric.compiled._estimators import estimation_failure
from rcac_numeric.estimation._any_model import AnyModel
from rcac_numeric.estimation._consistency import Consistency, nees_consistency, nis_consistency
from rcac_numeric.estimation._estimator import (
    compiled_filter,
    noises_in_use,
    noises_of_steps,
)
from rcac_numeric.estimation._identifiability import NoiseInformation, noise_information
from rcac_numeric.estimation._linear import LinearModel
from rcac_numeric.estimation._local_observability import (
    Observability,
    UnidentifiableWarning,
    UnobservableWarning,
    observability_along,
)
from rcac_numeric.estimation._settings import EKF, IMM, UKF, AdaptiveNoises, AnyFilter


@dataclass(frozen=True, eq=False)
class StateEstimates(Result):
    """The estimates of a Kalman filter over a record.

    Attributes
    ----------
    settings : EKF, UKF or AdaptiveNoises
    x : array, shape (steps, n)
        x(k|k), of measurements up to y(k): nothing here is smoothed.
    deviation : array, shape (steps, n)
        Square roots of the diagonal of P(k|k).
    P : array, shape (steps, n, n) or (0, n, n)
        P(k|k), if requested.
    innovation : array, shape (steps, l_y)
        y(k) - h(x(k|k-1)); NaN where an entry is missing.
    nis : array, shape (steps,)
        Innovations squared and normalised, of what was measured; NaN where nothing was.
    log_likelihood : float
        Of the measurements, under the model.
    observability : Observability
        Which directions of x the record could tell apart.
    """

    settings: EKF | UKF | AdaptiveNoises
    x: Array
    deviation: Array
    P: Array
    innovation: Array
    nis: Array
    log_likelihood: float
    observability: Observability

    def nis_consistency(self, confidence: float = 0.95) -> Consistency:
        """Test whether the innovations agree with the filter's covariance.

        Parameters
        ----------
        confidence : float
            Of the interval for the mean of the NIS.
        """
        present = ~np.isnan(self.nis)
        if not present.any():
            raise InputError("no step has a measurement: there is no innovation to evaluate.")
        measured = int((~np.isnan(self.innovation[present])).sum())
        return nis_consistency(self.nis[present], measured / int(present.sum()), confidence)

    def nees_consistency(self, truth: ArrayLike, confidence: float = 0.95) -> Consistency:
        """Test whether the errors agree with the filter's covariance; needs covariances.

        Parameters
        ----------
        truth : array, shape (steps, n)
            The true x.
        confidence : float
            Of the interval for the mean of the NEES.

        Raises
        ------
        InputError
            Where the covariances were not kept.
        """
        if not len(self.P):
            raise InputError(
                "the covariances were not stored: call estimate(..., keep_covariances=True)."
            )
        error = signal_array(truth, "truth", self.x.shape[1], len(self.x)) - self.x
        return nees_consistency(error, self.P, confidence)


@dataclass(frozen=True, eq=False)
class AdaptedEstimates(StateEstimates):
    """The estimates of a Kalman filter that learns its noises, over a record.

    Attributes
    ----------
    Q : array, shape (windows + 1, n, n)
        Q of the settings, and after each whole window what was learned from it.
    R : array, shape (windows + 1, l_y, l_y)
        The same of R.
    information : NoiseInformation or None
        What a window can say of Q and R at their last values; None where the model is not linear.
    """

    Q: Array
    R: Array
    information: NoiseInformation | None


@dataclass(frozen=True, eq=False)
class ModeEstimates(Result):
    """The estimates of an interacting multiple model filter over a record.

    Attributes
    ----------
    settings : IMM
    x : array, shape (steps, n)
        The mean of x(k) over the modes, of measurements up to y(k).
    deviation : array, shape (steps, n)
        Square roots of the diagonal of P(k|k).
    P : array, shape (steps, n, n) or (0, n, n)
        The covariance over the modes, their differences included, if requested.
    innovation : array, shape (steps, l_y)
        The mean over the modes of y(k) - h(x(k|k-1)); NaN where an entry is missing.
    nis : array, shape (steps,)
        Innovations squared and normalised by the covariance of the mixture; NaN where nothing was
        measured. Its mean is the number of measurements; it is not chi-square.
    log_likelihood : float
        Of the measurements, under the mixture.
    probabilities : array, shape (steps, M)
        Of the modes at k, given measurements up to y(k).
    """

    settings: IMM
    x: Array
    deviation: Array
    P: Array
    innovation: Array
    nis: Array
    log_likelihood: float
    probabilities: Array

    @property
    def most_probable(self) -> NDArray[np.intp]:
        """The mode of the largest probability in each step, shape (steps,)."""
        return np.asarray(self.probabilities.argmax(axis=1))

    def plot(self) -> figures.Figure:
        """The estimate with two deviations on either side, and the probabilities of the modes."""
        from rcac_numeric.plots._modes import plot_modes

        return plot_modes(self)


@overload
def estimate(
    settings: EKF | UKF,
    y: ArrayLike,
    u: ArrayLike | None = None,
    measured: ArrayLike | None = None,
    *,
    Q: ArrayLike | None = None,
    R: ArrayLike | None = None,
    keep_covariances: bool = False,
) -> StateEstimates: ...


@overload
def estimate(
    settings: AdaptiveNoises,
    y: ArrayLike,
    u: ArrayLike | None = None,
    measured: ArrayLike | None = None,
    *,
    keep_covariances: bool = False,
) -> AdaptedEstimates: ...


@overload
def estimate(
    settings: IMM,
    y: ArrayLike,
    u: ArrayLike | None = None,
    measured: ArrayLike | None = None,
    *,
    keep_covariances: bool = False,
) -> ModeEstimates: ...


def estimate(
    settings: AnyFilter,
    y: ArrayLike,
    u: ArrayLike | None = None,
    measured: ArrayLike | None = None,
    *,
    Q: ArrayLike | None = None,
    R: ArrayLike | None = None,
    keep_covariances: bool = False,
) -> StateEstimates | ModeEstimates:
    """Run a Kalman filter over a record of measurements.

    Parameters
    ----------
    settings : EKF, UKF, IMM or AdaptiveNoises
    y : array, shape (steps, l_y)
        A 1-D array is one signal. A NaN is an entry that was not measured; the others of its row
        count.
    u : array, shape (steps, l_u), optional
        The known input, where the model has one.
    measured : array of bool, shape (steps,) or (steps, l_y), optional
        False where y(k), or an entry of it, is missing; what stands there is not looked at.
    Q, R : arrays, shapes (steps, n, n) and (steps, l_y, l_y), or (steps,), optional
        Q(k) and R(k) of each step, where they change; those of the settings by default, which also
        judge what is observable. A number stands for that multiple of I. Of an EKF or a UKF.
    keep_covariances : bool
        Keep P(k|k) of every step.

    Returns
    -------
    StateEstimates, AdaptedEstimates where noises are learned, ModeEstimates of an IMM

    Raises
    ------
    InputError
        Where shapes do not fit or an entry is infinite.
    FunctionFailedError
        Where a function of the model failed; `run` holds the estimates until then.
    IllConditionedError, DivergedError
        As in `Estimator.step`.

    Warns
    -----
    UnobservableWarning
        Where the record cannot tell some direction of x from nothing: what is estimated there is
        what was believed at first.
    UnidentifiableWarning
        Where noises are learned of which no record can tell some combination.

    Examples
    --------
    >>> from rcac_numeric.estimation import EKF, LinearModel, estimate
    >>> model = LinearModel(A=[[1, 0.1], [0, 1]], C=[[1, 0]])
    >>> estimates = estimate(EKF(model, Q=1e-9, R=1e-4, P_0=10), y=[0.2 * k for k in range(50)])
    >>> estimates.x[-1].round(2)
    array([9.8, 2. ])
    """
    estimates = estimated_record(
        settings, y, u, measured, Q=Q, R=R, keep_covariances=keep_covariances
    )
    if isinstance(estimates, StateEstimates) and estimates.observability.unseen:
        warnings.warn(str(estimates.observability), UnobservableWarning, stacklevel=2)
    if (
        isinstance(estimates, AdaptedEstimates)
        and estimates.information is not None
        and estimates.information.unidentified
    ):
        warnings.warn(str(estimates.information), UnidentifiableWarning, stacklevel=2)
    return estimates


@overload
def estimated_record(
    settings: EKF | UKF, y: ArrayLike, u: ArrayLike | None = None, *args: Any, **options: Any
) -> StateEstimates: ...


@overload
def estimated_record(
    settings: AnyFilter, y: ArrayLike, u: ArrayLike | None = None, *args: Any, **options: Any
) -> StateEstimates | ModeEstimates: ...


def estimated_record(
    settings: AnyFilter,
    y: ArrayLike,
    u: ArrayLike | None = None,
    measured: ArrayLike | None = None,
    *,
    Q: ArrayLike | None = None,
    R: ArrayLike | None = None,
    keep_covariances: bool = False,
) -> StateEstimates | ModeEstimates:
    """As `estimate`, without the warnings, for callers that read `observability`."""
    kernel, compiled = compiled_filter(settings)
    model = settings.model
    outputs, inputs = record_of(model, y, u, measured)
    steps, n = len(outputs), model.n
    there = ~np.isnan(outputs)
    x, deviation = np.zeros((steps, n)), np.zeros((steps, n))
    P = np.zeros((steps if keep_covariances else 0, n, n))
    innovation = np.full((steps, model.l_y), np.nan)
    nis, likelihood = np.full(steps, np.nan), np.zeros(steps)
    probabilities = np.zeros((steps, len(kernel.probabilities)))
    learned: list[tuple[Array, Array]] = []

    def result(count: int) -> StateEstimates | ModeEstimates:
        first = (x[:count], deviation[:count], P[:count], innovation[:count], nis[:count])
        total = float(likelihood[:count].sum())
        if isinstance(settings, IMM):
            return ModeEstimates(settings, *first, total, probabilities[:count])
        known = settings.filter if isinstance(settings, AdaptiveNoises) else settings
        observability = observability_along(
            model, compiled, x[:count], inputs[:count], known.P_0, known.R, there[:count]
        )
        if isinstance(settings, AdaptiveNoises):
            return AdaptedEstimates(
                settings, *first, total, observability, *_learned(settings, learned)
            )
        return StateEstimates(settings, *first, total, observability)

    record = (inputs, outputs, x, deviation, P, innovation, nis, likelihood, probabilities)
    noises = None if Q is None and R is None else _roots(settings, Q, R, steps)
    try:
        if noises is not None:
            for k, roots in enumerate(noises):
                kernel.set_noises(*roots)
                kernel.run(*(part[k : k + 1] for part in record))
        elif isinstance(settings, AdaptiveNoises):
            learned.append(noises_in_use(kernel, settings))
            for k in range(0, steps, settings.window):
                kernel.run(*(part[k : k + settings.window] for part in record))
                if k + settings.window <= steps:
                    learned.append(noises_in_use(kernel, settings))
        else:
            kernel.run(*record)
    except Exception as error:
        failure = estimation_failure(error, kernel.k)
        if isinstance(failure, FunctionFailedError):
            failure.run = result(kernel.k) if kernel.k else None
        raise failure from error
    return result(steps)


def record_of(
    model: AnyModel, y: ArrayLike, u: ArrayLike | None, measured: ArrayLike | None = None
) -> tuple[Array, Array]:
    """Y with NaN where an entry is missing, and u, one row for each step."""
    outputs = _with_gaps(y, model.l_y, measured)
    if u is None and model.l_u:
        raise InputError(f"the model has {model.l_u} known inputs; give their record u.")
    inputs = np.zeros((len(outputs), model.l_u)) if u is None else u
    return outputs, signal_array(inputs, "u", model.l_u, len(outputs))


def _learned(
    settings: AdaptiveNoises, learned: list[tuple[Array, Array]]
) -> tuple[Array, Array, NoiseInformation | None]:
    """Every Q and R, and the information in a window on the last ones."""
    Q, R = (np.array(each) for each in zip(*learned, strict=True))
    if not isinstance(settings.model, LinearModel):
        return Q, R, None
    information = noise_information(
        settings.filter, settings.window, learn=settings.learn, diagonal=settings.diagonal
    )
    return Q, R, information


def _roots(
    settings: AnyFilter, Q: ArrayLike | None, R: ArrayLike | None, steps: int
) -> list[tuple[Array, Array]]:
    """The square roots of the noises of each step."""
    each = []
    for name, noise in (("Q", Q), ("R", R)):
        rows = [None] * steps if noise is None else list(real_array(noise, name))
        if len(rows) != steps:
            raise InputError(f"{name} has {len(rows)} entries for {steps} steps.")
        each.append(rows)
    roots = []
    for k, (q, r) in enumerate(zip(*each, strict=True)):
        try:
            roots.append(noises_of_steps(settings, q, r))
        except InputError as error:
            raise InputError(f"at step {k}: {error}") from None
    return roots


def _with_gaps(y: ArrayLike, l_y: int, measured: ArrayLike | None) -> Array:
    """y, shape (steps, l_y), with NaN where an entry is missing."""
    outputs = float_array(y, "y")
    if measured is not None:
        there = np.asarray(measured)
        if there.dtype != bool or there.shape not in {outputs.shape[:1], outputs.shape}:
            raise InputError(
                f"measured has type {there.dtype} and shape {there.shape}; one True or False for "
                f"each of the {len(outputs)} rows of y, or for each of its entries, is needed."
            )
        outputs[~there] = np.nan
    missing = np.isnan(outputs)
    read = signal_array(np.where(missing, 0.0, outputs), "y", l_y)
    return np.where(missing.reshape(read.shape), np.nan, read)
