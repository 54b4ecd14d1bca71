"""The Rauch-Tung-Striebel smoother in square roots, with measurements missing entry by entry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import IllConditionedError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import float_array, integer, real_array, signal_array
from rcac_numeric.arrays._values import Result
from rcac_numeric.estimation._linear import LinearModel
from rcac_numeric.estimation._settings import EKF, square_root


@dataclass(frozen=True, eq=False)
class SmoothedStates(Result):
    """The estimates of every state from a whole record, or from its next steps.

    Attributes
    ----------
    settings : EKF
    lag : int or None
        x(k) is that of the measurements up to y(k + lag); of all of them where it is None.
    x : array, shape (steps, n)
    P : array, shape (steps, n, n)
    filtered : array, shape (steps, n)
        x(k|k), for comparison.
    log_likelihood : float
        Of the entries that were measured, under the model.
    """

    settings: EKF
    lag: int | None
    x: Array
    P: Array
    filtered: Array
    log_likelihood: float

    @property
    def deviation(self) -> Array:
        """Square roots of the diagonals of P, shape (steps, n)."""
        return np.sqrt(np.diagonal(self.P, axis1=1, axis2=2))


def smooth(
    settings: EKF, y: ArrayLike, u: ArrayLike | None = None, *, lag: int | None = None
) -> SmoothedStates:
    """Estimate every state from measurements before and after it.

    The Kalman filter runs forward in square roots. Backward, with P(k|k) = S S' and one orthogonal
    transformation of ``[[A S, Q^1/2], [S, 0]]`` to ``[[L, 0], [G, M]]``,

        J = G L^-1,  x(k|N) = x(k|k) + J (x(k+1|N) - x(k+1|k)),  P(k|N) = M M' + J P(k+1|N) J',

    so that no covariance is inverted and none is subtracted.

    Parameters
    ----------
    settings : EKF
        With a `LinearModel`.
    y : array, shape (steps, l_y)
        A NaN is an entry that was not measured; the others of its row count.
    u : array, shape (steps, l_u), optional
        The known input, where the model has one.
    lag : int, optional
        So many steps after k are used for x(k), as where an estimate may come that late; all of
        them by default.

    Returns
    -------
    SmoothedStates

    Raises
    ------
    InputError
        Where shapes do not fit, the model is not linear, or an entry is infinite.
    IllConditionedError
        Where the covariance of an innovation is singular.

    Examples
    --------
    >>> from rcac_numeric.estimation import EKF, LinearModel, smooth
    >>> level = EKF(LinearModel(A=1, C=1), Q=1.0, R=1.0, P_0=100.0)
    >>> smoothed = smooth(level, [0.0, float("nan"), 2.0])
    >>> smoothed.x[1].round(2)  # half-way between its neighbours, nearly
    array([1.])
    """
    if not isinstance(settings, EKF) or not isinstance(settings.model, LinearModel):
        raise InputError("a smoother needs an EKF with a LinearModel; give EKF(LinearModel(...)).")
    model = settings.model
    if model.angles:
        raise InputError("a smoother takes no angles: unwrap their record first (numpy.unwrap).")
    outputs = float_array(y, "y")
    measured = ~np.isnan(outputs)
    outputs = signal_array(real_array(np.where(measured, outputs, 0.0), "y"), "y", model.l_y)
    measured = measured.reshape(outputs.shape)
    steps = len(outputs)
    if u is None and model.l_u:
        raise InputError(f"the model has {model.l_u} known inputs; give their record u.")
    inputs = signal_array(np.zeros((steps, model.l_u)) if u is None else u, "u", model.l_u, steps)
    if lag is not None:
        integer(lag, "lag")
    with np.errstate(over="ignore", invalid="ignore"):  # what leaves float64 is looked for
        forward = _forward(settings, outputs, measured, inputs)
    x, S, predicted, likelihood = forward
    if not (np.isfinite(x).all() and np.isfinite(predicted).all() and np.isfinite(likelihood)):
        raise IllConditionedError(
            "the filter or its likelihood leaves float64: write y and u in units in which they are "
            "of the size of their noises."
        )
    filtered = x.copy()
    n = model.n
    gains = np.zeros((max(steps - 1, 0), n, n))
    roots = np.zeros_like(gains)
    Q = square_root(settings.Q)
    for k in range(steps - 1):
        gains[k], roots[k] = _backward_step(model.A, S[k], Q)
    if lag is None:
        x, S = _backward(filtered, S, predicted, gains, roots, steps - 1, steps)
    else:
        late = [
            _backward(filtered, S, predicted, gains, roots, min(k + lag, steps - 1), 1 + lag, k)
            for k in range(steps)
        ]
        x = np.array([one[0][k] for k, one in enumerate(late)]).reshape(steps, n)
        S = np.array([one[1][k] for k, one in enumerate(late)]).reshape(steps, n, n)
    P = S @ S.transpose(0, 2, 1)
    return SmoothedStates(settings, lag, x, P, filtered, likelihood)


def _lower(M: Array) -> Array:
    """The lower triangle L with L L' = M M'."""
    return np.asarray(np.linalg.qr(M.T, mode="r")).T


def _forward(
    settings: EKF, y: Array, measured: Array, u: Array
) -> tuple[Array, Array, Array, float]:
    """x(k|k), S(k|k), x(k+1|k) and the logarithm of the likelihood."""
    model = settings.model
    assert isinstance(model, LinearModel)
    n, steps = model.n, len(y)
    Q, R = square_root(settings.Q), square_root(settings.R)
    x, S = settings.x_0.copy(), square_root(settings.P_0)
    states, roots, predicted = np.zeros((steps, n)), np.zeros((steps, n, n)), np.zeros((steps, n))
    likelihood = 0.0
    for k in range(steps):
        there = np.flatnonzero(measured[k])
        p = len(there)
        if p:
            C = model.C[there]
            innovation = y[k, there] - C @ x - model.D[there] @ u[k]
            L = _lower(np.block([[R[there], C @ S], [np.zeros((n, R.shape[1])), S]]))
            L_y = L[:p, :p]
            scale = np.abs(np.diag(L_y))
            if not scale.min() > 1e-14 * scale.max():
                raise IllConditionedError(
                    f"the covariance of the innovation is singular at step {k}: give every "
                    "measurement some noise, R > 0, or drop a redundant one."
                )
            white = np.linalg.solve(L_y, innovation)
            x = x + L[p:, :p] @ white
            S = np.zeros((n, n))
            rest = L[p:, p:]
            S[:, : rest.shape[1]] = rest[:, :n]
            likelihood -= 0.5 * float(white @ white) + float(np.log(scale).sum())
            likelihood -= 0.5 * p * float(np.log(2 * np.pi))
        states[k], roots[k] = x, S
        x = model.A @ x + model.B @ u[k]
        predicted[k] = x
        S = _lower(np.hstack([model.A @ S, Q]))
    return states, roots, predicted, likelihood


def _backward_step(A: Array, S: Array, Q: Array) -> tuple[Array, Array]:
    """J and M of one step."""
    n = len(A)
    L = _lower(np.block([[A @ S, Q], [S, np.zeros((n, Q.shape[1]))]]))
    # Where a state is known exactly L is singular, and what J makes of it does not matter.
    J = np.linalg.lstsq(L[:n, :n].T, L[n:, :n].T, rcond=1e-15)[0].T
    M = np.zeros((n, n))
    rest = L[n:, n:]
    M[:, : rest.shape[1]] = rest
    return np.asarray(J), M


def _backward(
    filtered: Array, S: Array, predicted: Array, gains: Array, roots: Array, last: int,
    count: int, first: int = 0,
) -> tuple[Array, Array]:  # fmt: skip
    """Smooth from step `last` back to `first`; other steps keep the filter's estimates."""
    x, root = filtered.copy(), S.copy()
    for k in range(last - 1, max(first, last - count) - 1, -1):
        x[k] = filtered[k] + gains[k] @ (x[k + 1] - predicted[k])
        root[k] = _lower(np.hstack([roots[k], gains[k] @ root[k + 1]]))
    return x, root
