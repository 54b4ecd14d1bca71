"""Recursive estimation of Markov parameters."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import integer, number, vector
from rcac_numeric.arrays._values import ShowsState


class RecursiveMarkov(ShowsState):
    """The least squares of (3.8), one sample at a time, with exponential forgetting.

    minimise sum_k lambda^(K-k) norm(y(k) - theta phi(k))^2

    Parameters
    ----------
    l_u, l_y : int
        Numbers of inputs and outputs.
    mu, n_mod : int
        As for `identify_markov_parameters`.
    lambda_ : float
        Forgetting factor, above 0 and at most 1.
    lags : int
        Of the Newey-West covariance; how long the noise remembers, in steps.

    Raises
    ------
    InputError
        If a setting is out of range, or `H` is read before the data determine it.

    Notes
    -----
    Square-root information form: one triangular factor, updated by a QR decomposition, so that
    nothing is squared and there is no initial covariance; with `lambda_` = 1 the estimate is
    that of the batch. The covariance is summed from the errors of prediction, which know only the
    past, so that it is on the safe side at first.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.identification import RecursiveMarkov
    >>> fit = RecursiveMarkov(l_u=1, l_y=1, mu=3, n_mod=1)
    >>> u = np.random.default_rng(0).standard_normal(30)
    >>> for now, before in zip(u[1:], u[:-1]):
    ...     fit.update([now], [2 * before])
    >>> (fit.H.ravel()[1:].round(9) + 0.0).tolist()
    [2.0, 0.0]
    """

    SHOWN = ("mu", "n_mod", "lambda_", "samples")

    def __init__(
        self, l_u: int, l_y: int, mu: int, n_mod: int, lambda_: float = 1.0, lags: int = 10
    ) -> None:
        self.l_u, self.l_y = integer(l_u, "l_u", at_least=1), integer(l_y, "l_y", at_least=1)
        self.mu, self.n_mod = integer(mu, "mu", at_least=1), integer(n_mod, "n_mod")
        self.lambda_, self.lags = number(lambda_, "lambda_"), integer(lags, "lags")
        if not 0 < self.lambda_ <= 1:
            raise InputError(f"lambda_ = {self.lambda_:g}; it must be above 0 and at most 1.")
        self._p = (mu + n_mod) * l_u + n_mod * l_y
        self._R = np.zeros((0, self._p + self.l_y))
        self._theta = np.zeros((self._p, self.l_y))
        self._past_u: list[Array] = []
        self._past_y: list[Array] = []
        self._scores: list[Array] = []
        self._S = np.zeros((self._p * self.l_y, self._p * self.l_y))
        self._weight, self._determined = 0.0, False

    @property
    def samples(self) -> float:
        """The number of equations so far, old ones by their weight."""
        return self._weight

    def update(self, u: ArrayLike, y: ArrayLike) -> None:
        """Update with u(k) and y(k)."""
        window = self.mu + self.n_mod
        now = vector(u, "u", self.l_u), vector(y, "y", self.l_y)
        self._past_u = [now[0], *self._past_u][:window]
        self._past_y = [now[1], *self._past_y][:window]
        if len(self._past_u) < window:
            return
        older = [-value for value in self._past_y[self.mu :]]
        phi = np.concatenate([*self._past_u, *older])
        if self._determined:
            self._add_score(phi, now[1] - phi @ self._theta)
        stacked = np.vstack([np.sqrt(self.lambda_) * self._R, np.concatenate([phi, now[1]])])
        self._R = np.asarray(np.linalg.qr(stacked, mode="r"))
        self._weight = self.lambda_ * self._weight + 1
        self._solve()

    @property
    def H(self) -> Array:
        """The Markov parameters H_0, ..., H_(mu-1), shape (mu, l_y, l_u)."""
        self._require_determined()
        return self._as_parameters(self._theta)

    @property
    def standard_error(self) -> Array:
        """The standard error of each entry of H, by Newey-West with these lags."""
        self._require_determined()
        R = self._R[: self._p, : self._p]
        inverse = np.linalg.inv(R.T @ R)
        whole = self._S.reshape(self._p, self.l_y, self._p, self.l_y)
        variance = np.einsum("ab,bici,ca->ai", inverse, whole, inverse)
        freedom = max(self._weight - self._p, 1.0)
        return self._as_parameters(np.sqrt(np.maximum(variance, 0) * self._weight / freedom))

    def _add_score(self, phi: Array, error: Array) -> None:
        score = np.outer(phi, error).ravel()
        total = np.zeros_like(score)
        for lag, past in enumerate(self._scores, 1):
            total += (1 - lag / (self.lags + 1)) * self.lambda_**lag * past
        cross = np.outer(score, total)
        self._S = self.lambda_**2 * self._S + np.outer(score, score) + cross + cross.T
        self._scores = [score, *self._scores][: self.lags]

    def _solve(self) -> None:
        if len(self._R) < self._p:
            return
        size = np.linalg.svd(self._R[: self._p, : self._p], compute_uv=False)
        self._determined = bool(size[-1] > np.finfo(float).eps * self._p * size[0])
        if self._determined:
            solution = np.linalg.solve(self._R[: self._p, : self._p], self._R[: self._p, self._p :])
            self._theta = np.asarray(solution, dtype=np.float64)

    def _as_parameters(self, theta: Array) -> Array:
        recent = theta[: self.mu * self.l_u].reshape(self.mu, self.l_u, self.l_y)
        return np.ascontiguousarray(recent.transpose(0, 2, 1))

    def _require_determined(self) -> None:
        if not self._determined:
            raise InputError(
                f"{self._weight:g} equations do not determine the {self._p} coefficients of each "
                "output yet: record more data, a richer input, or lower mu or n_mod (without noise "
                "n_mod above the plant's order leaves them undetermined for good)."
            )
