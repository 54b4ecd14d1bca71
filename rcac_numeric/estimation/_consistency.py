"""Consistency of a filter: NEES and NIS with their intervals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._validation import integer, number, real_array
from rcac_numeric.arrays._values import Result


@dataclass(frozen=True, eq=False)
class Consistency(Result):
    """The mean of a normalised squared error, and its interval.

    Attributes
    ----------
    mean : float
        Its expected value is `degrees` where model and noises are right.
    degrees : int or float
        l_y for the NIS, on average where entries are missing; n for the NEES.
    samples : int
        How many steps.
    interval : tuple of two floats
        Where the mean lies with the confidence, if the samples are independent: innovations of a
        right filter are; errors of x, for NEES over one run, are not, and the interval is then
        too narrow.
    confidence : float
    """

    mean: float
    degrees: float
    samples: int
    interval: tuple[float, float]
    confidence: float

    @property
    def verdict(self) -> str:
        """Whether the mean lies in the interval: "consistent", else "optimistic" or "pessimistic".

        Optimistic: the errors are larger than the filter says.
        """
        low, high = self.interval
        if self.mean > high:
            return "optimistic"
        return "pessimistic" if self.mean < low else "consistent"


def chi_square_interval(degrees: float, samples: int, confidence: float) -> tuple[float, float]:
    """The interval of the mean of independent chi-square variables."""
    samples = integer(samples, "samples", 1)
    if not number(degrees, "degrees") > 0:
        raise InputError(f"degrees = {degrees} must be positive.")
    if not 0 < number(confidence, "confidence") < 1:
        raise InputError(f"confidence = {confidence} must lie between 0 and 1.")
    tail = (1 - confidence) / 2
    from scipy.special import gammaincinv  # a sixth of a second

    ends = 2 * gammaincinv(degrees * samples / 2, np.array([tail, 1 - tail])) / samples
    return float(ends[0]), float(ends[1])


def nis_consistency(nis: ArrayLike, l_y: float, confidence: float = 0.95) -> Consistency:
    """The mean NIS of a run, or of many, against its chi-square interval.

    Parameters
    ----------
    nis : array
        Normalised squared innovations.
    l_y : int or float
        Number of measurements in each step, on average.
    confidence : float

    Raises
    ------
    InputError
        Where there are none, or one is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.estimation import nis_consistency
    >>> e = np.random.default_rng(1).standard_normal((500, 2))
    >>> nis_consistency((e**2).sum(axis=1), l_y=2).verdict
    'consistent'
    >>> nis_consistency(1.5 * (e**2).sum(axis=1), l_y=2).verdict
    'optimistic'
    """
    values = real_array(nis, "nis").reshape(-1)
    if not values.size:
        raise InputError("nis is empty: no step has a measurement.")
    interval = chi_square_interval(l_y, values.size, confidence)
    return Consistency(float(values.mean()), l_y, values.size, interval, confidence)


def nees_consistency(error: ArrayLike, P: ArrayLike, confidence: float = 0.95) -> Consistency:
    """The mean NEES e' P^-1 e against its chi-square interval.

    Parameters
    ----------
    error : array, shape (samples, n)
        x - x(k|k); of independent runs, one row each, where the interval is to be taken at its
        word.
    P : array, shape (samples, n, n)
    confidence : float

    Raises
    ------
    InputError
        Where the shapes do not fit, or P is singular.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.estimation import nees_consistency
    >>> e = np.random.default_rng(1).standard_normal((200, 3))
    >>> nees_consistency(e, np.broadcast_to(np.eye(3), (200, 3, 3))).verdict
    'consistent'
    """
    errors, covariances = real_array(error, "error"), real_array(P, "P")
    if errors.ndim != 2 or covariances.shape != (*errors.shape, errors.shape[1]):
        raise InputError(
            f"error has shape {errors.shape} and P {covariances.shape}; (samples, n) and "
            "(samples, n, n) are needed."
        )
    try:
        roots = np.linalg.cholesky(covariances)
    except np.linalg.LinAlgError:
        raise InputError(
            "a covariance in P is not positive definite; leave such a step out."
        ) from None
    whitened = np.linalg.solve(roots, errors[..., None])[..., 0]
    with np.errstate(over="ignore"):
        values = (whitened**2).sum(axis=1)
    if not np.isfinite(values).all():
        raise InputError("error over the root of P has a square beyond float64; check their units.")
    n = errors.shape[1]
    interval = chi_square_interval(n, values.size, confidence)
    return Consistency(float(values.mean()), n, values.size, interval, confidence)
