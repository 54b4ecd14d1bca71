"""Noise models for standard errors from a residual."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import integer


@dataclass(frozen=True)
class NeweyWest:
    """The residual is coloured, or its variance changes: the sandwich of Newey and West.

    cov theta = (Phi' Phi)^-1 S (Phi' Phi)^-1,
    S = sum_{-lags <= l <= lags} (1 - abs(l)/(lags + 1)) sum_k s(k) s(k - l)',  s(k) = phi(k) e(k)

    scaled by rows/(rows - coefficients) and by 1/(1 - b + b^2/3), b = lags/rows, which is what the
    sum over k of s(k), zero by the normal equations, takes away from S.

    Parameters
    ----------
    lags : int, optional
        Beyond which s(k) is uncorrelated; 0 gives White's sandwich, for a variance that changes.
        By default 1.3 sqrt(rows).

    Notes
    -----
    The weights are Bartlett's, so that the covariance is positive semidefinite. It is itself
    uncertain, like one of 3/(2b) degrees of freedom, which regions of confidence count. Source: W.
    K. Newey and K. D. West, A simple, positive semi-definite, heteroskedasticity and
    autocorrelation consistent covariance matrix, Econometrica 55 (1987); E. Lazarus, D. J. Lewis,
    J. H. Stock, M. W. Watson, HAR inference: recommendations for practice, Journal of Business and
    Economic Statistics 36 (2018).

    Examples
    --------
    >>> from rcac_numeric.identification import NeweyWest
    >>> NeweyWest(lags=12)
    NeweyWest(lags=12)
    """

    lags: int | None = None

    def __post_init__(self) -> None:
        if self.lags is not None:
            integer(self.lags, "lags")

    def chosen_lags(self, rows: int) -> int:
        """The lags as set, or by default for the number of equations."""
        chosen = math.ceil(1.3 * math.sqrt(rows)) if self.lags is None else self.lags
        return min(chosen, rows - 1)


def coefficient_covariance(
    regressors: Array, inverse: Array, residual: Array, freedom: int, noise: NeweyWest | None
) -> Array:
    """Covariance of theta in Y = Phi theta + E, shape (p, l_y, p, l_y)."""
    rows, p = regressors.shape
    l_y = residual.shape[1]
    if noise is None:
        return np.asarray(np.einsum("ab,ij->aibj", inverse, residual.T @ residual / freedom))
    projected = regressors @ inverse
    scores = np.einsum("ka,ki->kai", projected, residual).reshape(rows, p * l_y)
    total = scores.T @ scores
    lags = noise.chosen_lags(rows)
    for lag in range(1, lags + 1):
        part = scores[lag:].T @ scores[: rows - lag]
        total += (1 - lag / (lags + 1)) * (part + part.T)
    b = lags / rows
    return np.asarray((rows / freedom) / (1 - b + b**2 / 3) * total).reshape(p, l_y, p, l_y)


def degrees_of_freedom(rows: int, freedom: int, noise: NeweyWest | None) -> float:
    """The degrees of freedom of the covariance."""
    if noise is None:
        return float(freedom)
    return max(2.0, min(float(freedom), 1.5 * rows / max(noise.chosen_lags(rows), 1)))
