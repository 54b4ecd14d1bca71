"""Covariances of noises from a record, by maximum likelihood."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import DivergedError, IllConditionedError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import instance_of, integer
from rcac_numeric.arrays._values import Result, replaced
from rcac_numeric.compiled._estimators import estimation_failure, learn_noises
from rcac_numeric.estimation._compiled import compiled_model
from rcac_numeric.estimation._estimates import record_of
from rcac_numeric.estimation._identifiability import NoiseInformation, noise_information
from rcac_numeric.estimation._linear import LinearModel
from rcac_numeric.estimation._local_observability import UnidentifiableWarning
from rcac_numeric.estimation._settings import (
    EKF,
    covariance_of,
    learned_noises,
    square_root,
)

SETTLED = 1e-9  # relative change of both roots in one iteration
GAIN = 1e-10  # of the log-likelihood in a cycle, where a variance goes to zero for ever

Iteration = Callable[[Array, Array], tuple[Array, Array, float]]


@dataclass(frozen=True, eq=False)
class FittedNoises(Result):
    """Q and R that make a record likely.

    Attributes
    ----------
    settings : EKF
        The filter that was given, with the Q and R found.
    log_likelihood : float
        Of the record under them.
    improvement : float
        How much larger it is than under what was given.
    iterations : int
        Passes over the record.
    converged : bool
        Whether Q and R had settled by then.
    information : NoiseInformation or None
        What such a record can say of Q and R; None where the model is not linear.
    """

    settings: EKF
    log_likelihood: float
    improvement: float
    iterations: int
    converged: bool
    information: NoiseInformation | None

    @property
    def Q(self) -> Array:
        """The covariance of the noise of x, shape (n, n)."""
        return self.settings.Q

    @property
    def R(self) -> Array:
        """The covariance of the noise of y, shape (l_y, l_y)."""
        return self.settings.R


def fit_noises(
    settings: EKF,
    y: ArrayLike,
    u: ArrayLike | None = None,
    *,
    learn: Iterable[str] = ("Q", "R"),
    diagonal: bool = False,
    most_iterations: int = 5000,
) -> FittedNoises:
    """Find the covariances of noises under which a record is most likely.

    Expectation maximisation as in `AdaptiveNoises`, with the whole record as one block, in square
    roots and accelerated by squared extrapolation; a step that would make the record less likely is
    not taken. The likelihood may have several maxima, and that nearest to what is given is found.

    Parameters
    ----------
    settings : EKF
        With Q and R to begin with; x_0 and P_0 are taken as known.
    y : array, shape (steps, l_y)
        A NaN is an entry that was not measured.
    u : array, shape (steps, l_u), optional
        The known input, where the model has one.
    learn : sequence of {"Q", "R"}
        What is learned; the other is taken as known.
    diagonal : bool
        Whether what is learned is diagonal.
    most_iterations : int
        Passes over the record.

    Returns
    -------
    FittedNoises

    Raises
    ------
    InputError
        Where shapes do not fit, there are fewer than two steps, or what is to be learned is zero.
    FunctionFailedError, IllConditionedError, DivergedError
        As in `Estimator.step`.

    Warns
    -----
    UnidentifiableWarning
        Where no record can tell some combination of what is learned.

    Notes
    -----
    R. H. Shumway and D. S. Stoffer, An approach to time series smoothing and forecasting using the
    EM algorithm, Journal of Time Series Analysis 3(4), 1982; R. Varadhan and C. Roland, Simple and
    globally convergent methods for accelerating the convergence of any EM algorithm, Scandinavian
    Journal of Statistics 35(2), 2008.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.estimation import EKF, LinearModel, fit_noises
    >>> rng = np.random.default_rng(1)
    >>> y = np.cumsum(0.5 * rng.standard_normal(2000)) + 2 * rng.standard_normal(2000)
    >>> fit = fit_noises(EKF(LinearModel(A=1, C=1), Q=1.0, R=1.0), y)
    >>> bool(abs(fit.R[0, 0] - 4) < 3 * fit.information.R_deviation[0, 0] < 0.6)
    True
    """
    instance_of(settings, "settings", EKF)
    named = learned_noises(settings, learn)
    instance_of(diagonal, "diagonal", bool)
    integer(most_iterations, "most_iterations", at_least=1)
    outputs, inputs = record_of(settings.model, y, u)
    if len(outputs) < 2:
        raise InputError(f"y has {len(outputs)} steps; noises need at least two.")
    if np.isfinite(outputs).any(axis=1).sum() < 2:
        raise InputError("y is NaN in all steps but one at most; noises need two measurements.")
    model = compiled_model(settings.model)
    begins = settings.x_0, square_root(settings.P_0)

    def iterate(Q: Array, R: Array) -> tuple[Array, Array, float]:
        learned = ("Q" in named, "R" in named, diagonal)
        try:
            return learn_noises(model, *begins, Q, R, inputs, outputs, *learned)
        except Exception as error:
            raise estimation_failure(error, 0) from error

    Q, R, passes, converged = _extrapolated(
        iterate, square_root(settings.Q), square_root(settings.R), most_iterations
    )
    first = iterate(square_root(settings.Q), square_root(settings.R))[2]
    last = iterate(Q, R)[2]
    fitted = replaced(
        settings,
        Q=covariance_of(Q) if "Q" in named else settings.Q,
        R=covariance_of(R) if "R" in named else settings.R,
    )
    information: NoiseInformation | None = None
    if isinstance(settings.model, LinearModel):
        # Where a variance was found to be zero the directions are those of what was given.
        information = noise_information(settings, len(outputs), learn=named, diagonal=diagonal)
        if not information.unidentified and fitted.Q.any() and fitted.R.any():
            information = noise_information(fitted, len(outputs), learn=named, diagonal=diagonal)
        if information.unidentified:
            warnings.warn(str(information), UnidentifiableWarning, stacklevel=2)
    return FittedNoises(fitted, last, last - first, passes, converged, information)


def _extrapolated(
    iterate: Iteration, Q: Array, R: Array, most: int
) -> tuple[Array, Array, int, bool]:
    """The fixed point of the iteration, by squared extrapolation of both roots (SQUAREM)."""
    shape, passes, best = Q.size, 0, -np.inf

    def apply(point: Array) -> tuple[Array, float]:
        new_Q, new_R, likelihood = iterate(
            point[:shape].reshape(Q.shape), point[shape:].reshape(R.shape)
        )
        return np.concatenate([new_Q.ravel(), new_R.ravel()]), likelihood

    point = np.concatenate([Q.ravel(), R.ravel()])
    converged = False
    while passes < most and not converged:
        one, _ = apply(point)
        two, reached = apply(one)
        passes += 2
        step, bend = one - point, two - 2 * one + point
        changed, sizes = (np.split(np.abs(each), [shape]) for each in (step, point))
        settled = all(
            change.max() <= SETTLED * size.max()
            for change, size in zip(changed, sizes, strict=True)
        )
        converged = settled or reached - best < GAIN
        best, start, point = reached, point, two
        if not converged and passes < most and bend.any():
            length = max(1.0, float(np.linalg.norm(step) / np.linalg.norm(bend)))
            try:
                further, likelihood = apply(start + 2 * length * step + length**2 * bend)
            except (IllConditionedError, DivergedError):  # too far
                continue
            passes += 1
            if likelihood >= reached:
                point = further
    return point[:shape].reshape(Q.shape), point[shape:].reshape(R.shape), passes, converged
