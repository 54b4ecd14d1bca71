"""The uncertainty of identified zeros by resampling blocks of the record."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import integer, number
from rcac_numeric.arrays._values import Result
from rcac_numeric.identification._mu_markov import identify_markov_parameters
from rcac_numeric.identification._regressors import regression
from rcac_numeric.identification._zero_gradients import realised_zeros
from rcac_numeric.identification._zeros import IdentifiedZeros, identified_zeros


@dataclass(frozen=True, eq=False)
class BootstrapZeros(Result):
    """Zeros of models that were identified from resampled data.

    Attributes
    ----------
    delta : IdentifiedZeros
        Zeros of the whole record, with their uncertainty by the delta method.
    draws : complex array, shape (replicates, n)
        Zeros of each resampled record, matched to those of the whole one.
    block : int
        Length of the blocks, in equations.
    """

    delta: IdentifiedZeros
    draws: ComplexArray
    block: int

    @property
    def covariance(self) -> Array:
        """The covariance of real and imaginary part of each zero, shape (n, 2, 2)."""
        gaps = self.draws - self.draws.mean(axis=0)
        parts = np.stack([gaps.real, gaps.imag], axis=2)
        return np.asarray(np.einsum("rni,rnj->nij", parts, parts) / (len(parts) - 1))

    def modulus_interval(self, index: int, level: float = 0.95) -> tuple[float, float]:
        """The percentiles of the modulus of a zero between which a share `level` of draws lies."""
        value = number(level, "level")
        if not 0 < value < 1:
            raise InputError(f"level = {value:g}; a level of confidence is between 0 and 1.")
        low, high = np.quantile(np.abs(self.draws[:, index]), [(1 - value) / 2, (1 + value) / 2])
        return float(low), float(high)

    @property
    def error_ratio(self) -> Array:
        """Standard error by resampling over that by the delta method, for each zero.

        Far from 1 where the error is too large for the delta method's first order.
        """
        ours, theirs = (
            np.sqrt(np.trace(c, axis1=1, axis2=2)) for c in (self.covariance, self.delta.covariance)
        )
        return np.asarray(ours / theirs)


def bootstrap_zeros(
    u: ArrayLike,
    y: ArrayLike,
    mu: int,
    n_mod: int,
    *,
    order: int,
    seed: int,
    replicates: int = 200,
    block: int | None = None,
) -> BootstrapZeros:
    """The uncertainty of identified zeros by the moving-block bootstrap.

    Blocks of consecutive equations of (3.8) are drawn with replacement until there are as many as
    in the record, the model is fitted to them, and its zeros are matched to those of the record.

    Parameters
    ----------
    u, y, mu, n_mod
        As for `identify_markov_parameters`.
    order : int
        Number of states of the realisation.
    seed : int
        Of the draws.
    replicates : int
        Number of resampled records.
    block : int, optional
        Length of a block; at least as long as the noise remembers. By default the cube root of the
        number of equations, and mu + n_mod at least.

    Raises
    ------
    InputError
        As `identify_markov_parameters` and `identified_zeros`; or if the record has fewer than
        four blocks.

    Notes
    -----
    Equations are resampled with their regressors, so that noise may be coloured and its variance
    may change. Source: H. R. Kunsch, The jackknife and the bootstrap for general stationary
    observations, Annals of Statistics 17 (1989).

    Examples
    --------
    >>> import numpy as np, scipy.signal
    >>> from rcac_numeric.identification import bootstrap_zeros
    >>> rng = np.random.default_rng(0)
    >>> u = rng.standard_normal(1000)
    >>> y = scipy.signal.lfilter([0, 1, -1.2], [1, -0.5, 0], u) + 0.1 * rng.standard_normal(1000)
    >>> found = bootstrap_zeros(u, y, mu=8, n_mod=2, order=2, seed=1, replicates=50)
    >>> bool(0.6 < found.error_ratio[0] < 1.6)
    True
    """
    markov = identify_markov_parameters(u, y, mu, n_mod)
    delta = identified_zeros(markov, order=order)
    regressors, present = regression(u, y, mu, n_mod)
    rows = len(present)
    length = (
        max(round(rows ** (1 / 3)), mu + n_mod) if block is None else integer(block, "block", 1)
    )
    count = integer(replicates, "replicates", at_least=2)
    if rows < 4 * length:
        raise InputError(
            f"{rows} equations make fewer than four blocks of {length}; record more data, or give "
            "a shorter block."
        )
    rng = np.random.default_rng(integer(seed, "seed"))
    whole = np.hstack([regressors, present])
    draws = []
    for _ in range(count):
        starts = rng.integers(0, rows - length + 1, size=-(-rows // length))
        chosen = whole[(starts[:, None] + np.arange(length)).ravel()[:rows]]
        theta = np.linalg.lstsq(
            chosen[:, : regressors.shape[1]], chosen[:, regressors.shape[1] :], rcond=None
        )[0]
        H = theta[: mu * markov.H.shape[2]].reshape(mu, markov.H.shape[2], -1).transpose(0, 2, 1)
        zeros = realised_zeros(np.ascontiguousarray(H[delta.d_zu :]), order)
        from scipy.optimize import linear_sum_assignment  # a sixth of a second

        _, matched = linear_sum_assignment(np.abs(delta.zeros[:, None] - zeros[None, :]))
        draws.append(zeros[matched])
    return BootstrapZeros(delta, np.array(draws), length)
