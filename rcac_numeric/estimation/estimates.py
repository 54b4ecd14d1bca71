"""A Kalman filter over a whole record."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import FunctionFailedError, InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import float_array, real_array, signal_array
from rcac_numeric.arrays.values import Value
from rcac_numeric.engine.compiled.estimators import estimation_failure
from rcac_numeric.estimation.consistency import Consistency, nees_consistency, nis_consistency
from rcac_numeric.estimation.estimator import compiled_filter
from rcac_numeric.estimation.local_observability import (
    Observability,
    UnobservableWarning,
    observability_along,
)
from rcac_numeric.estimation.settings import EKF, UKF, noise_roots


@dataclass(frozen=True, eq=False)
class StateEstimates(Value):
    """What a Kalman filter made of a record.

    Attributes
    ----------
    settings : EKF or UKF
    x : array, shape (steps, n)
        x(k|k), of measurements up to y(k): nothing here is smoothed.
    deviation : array, shape (steps, n)
        Square roots of the diagonal of P(k|k).
    P : array, shape (steps, n, n) or (0, n, n)
        P(k|k), where it was asked for.
    innovation : array, shape (steps, l_y)
        y(k) - h(x(k|k-1)); NaN where an entry is missing.
    nis : array, shape (steps,)
        Innovations squared and normalised, of what was measured; NaN where nothing was.
    log_likelihood : float
        Of the measurements, under the model.
    observability : Observability
        Which directions of x the record could tell apart.
    """

    settings: EKF | UKF
    x: Array
    deviation: Array
    P: Array
    innovation: Array
    nis: Array
    log_likelihood: float
    observability: Observability

    def nis_consistency(self, confidence: float = 0.95) -> Consistency:
        """Whether the innovations are as large as the filter says.

        Parameters
        ----------
        confidence : float
            Of the interval for the mean of the NIS.
        """
        kept = ~np.isnan(self.nis)
        if not kept.any():
            raise InputError("no step has a measurement: there is no innovation to judge.")
        measured = int((~np.isnan(self.innovation[kept])).sum())
        return nis_consistency(self.nis[kept], measured / int(kept.sum()), confidence)

    def nees_consistency(self, truth: ArrayLike, confidence: float = 0.95) -> Consistency:
        """Whether the errors are as large as the filter says; needs covariances.

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
            raise InputError("there are no covariances: estimate(..., keep_covariances=True).")
        error = signal_array(truth, "truth", self.x.shape[1], len(self.x)) - self.x
        return nees_consistency(error, self.P, confidence)


def estimate(
    settings: EKF | UKF,
    y: ArrayLike,
    u: ArrayLike | None = None,
    measured: ArrayLike | None = None,
    *,
    Q: ArrayLike | None = None,
    R: ArrayLike | None = None,
    keep_covariances: bool = False,
) -> StateEstimates:
    """Run a Kalman filter over a record of measurements.

    Parameters
    ----------
    settings : EKF or UKF
    y : array, shape (steps, l_y)
        A 1-D array is one signal. A NaN is an entry that was not measured; the others of its row
        count.
    u : array, shape (steps, l_u), optional
        The known input, where the model has one.
    measured : array of bool, shape (steps,) or (steps, l_y), optional
        False where y(k), or an entry of it, is missing; what stands there is not looked at.
    Q, R : arrays, shapes (steps, n, n) and (steps, l_y, l_y), or (steps,), optional
        Q(k) and R(k) of each step, where they change; those of the settings by default, which also
        judge what is observable. A number stands for that multiple of I.
    keep_covariances : bool
        Keep P(k|k) of every step.

    Returns
    -------
    StateEstimates

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

    Examples
    --------
    >>> from rcac_numeric.estimation import EKF, LinearModel, estimate
    >>> model = LinearModel(A=[[1, 0.1], [0, 1]], C=[[1, 0]])
    >>> found = estimate(EKF(model, Q=1e-9, R=1e-4, P_0=10), y=[0.2 * k for k in range(50)])
    >>> found.x[-1].round(2)
    array([9.8, 2. ])
    """
    made = estimated_record(settings, y, u, measured, Q=Q, R=R, keep_covariances=keep_covariances)
    if made.observability.unseen:
        warnings.warn(str(made.observability), UnobservableWarning, stacklevel=2)
    return made


def estimated_record(
    settings: EKF | UKF,
    y: ArrayLike,
    u: ArrayLike | None = None,
    measured: ArrayLike | None = None,
    *,
    Q: ArrayLike | None = None,
    R: ArrayLike | None = None,
    keep_covariances: bool = False,
) -> StateEstimates:
    """As `estimate`, without the warning: for who reads `observability`."""
    kernel, compiled = compiled_filter(settings)
    model = settings.model
    outputs = _with_gaps(y, model.l_y, measured)
    steps = len(outputs)
    there = ~np.isnan(outputs)
    inputs = signal_array(np.zeros((steps, model.l_u)) if u is None else u, "u", model.l_u, steps)
    if u is None and model.l_u:
        raise InputError(f"the model has {model.l_u} known inputs; give their record u.")
    n = model.n
    x, deviation = np.zeros((steps, n)), np.zeros((steps, n))
    P = np.zeros((steps if keep_covariances else 0, n, n))
    innovation = np.full((steps, model.l_y), np.nan)
    nis, likelihood = np.full(steps, np.nan), np.zeros(steps)

    def result(kept: int) -> StateEstimates:
        return StateEstimates(
            settings,
            x[:kept],
            deviation[:kept],
            P[:kept],
            innovation[:kept],
            nis[:kept],
            float(likelihood[:kept].sum()),
            observability_along(
                model, compiled, x[:kept], inputs[:kept], settings.P_0, settings.R, there[:kept]
            ),
        )

    record = (inputs, outputs, x, deviation, P, innovation, nis, likelihood)
    noises = None if Q is None and R is None else _roots(settings, Q, R, steps)
    try:
        if noises is None:
            kernel.run(*record)
        else:
            for k, roots in enumerate(noises):
                kernel.set_noises(*roots)
                kernel.run(*(part[k : k + 1] for part in record))
    except Exception as error:
        failure = estimation_failure(error, kernel.k)
        if isinstance(failure, FunctionFailedError):
            failure.run = result(kernel.k) if kernel.k else None
        raise failure from error
    return result(steps)


def _roots(
    settings: EKF | UKF, Q: ArrayLike | None, R: ArrayLike | None, steps: int
) -> list[tuple[Array, Array]]:
    """The square roots of the noises of each step."""
    each = []
    for name, given in (("Q", Q), ("R", R)):
        rows = [None] * steps if given is None else list(real_array(given, name))
        if len(rows) != steps:
            raise InputError(f"{name} has {len(rows)} entries where {steps} steps are.")
        each.append(rows)
    roots = []
    for k, (q, r) in enumerate(zip(*each, strict=True)):
        try:
            roots.append(noise_roots(settings, q, r))
        except InputError as error:
            raise InputError(f"at step {k}: {error}") from None
    return roots


def _with_gaps(y: ArrayLike, l_y: int, measured: ArrayLike | None) -> Array:
    """y, shape (steps, l_y), with NaN where an entry is missing."""
    given = float_array(y, "y")
    if measured is not None:
        there = np.asarray(measured)
        if there.dtype != bool or there.shape not in {given.shape[:1], given.shape}:
            raise InputError(
                f"measured has type {there.dtype} and shape {there.shape}; one True or False for "
                f"each of the {len(given)} rows of y, or for each of its entries, is needed."
            )
        given[~there] = np.nan
    missing = np.isnan(given)
    read = signal_array(np.where(missing, 0.0, given), "y", l_y)
    return np.where(missing.reshape(read.shape), np.nan, read)
