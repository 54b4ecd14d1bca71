"""Markov parameters from recorded data: least squares with the mu-Markov model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import integer, number, real_array
from rcac_numeric.arrays._values import Result
from rcac_numeric.identification._noise_models import (
    NeweyWest,
    coefficient_covariance,
    degrees_of_freedom,
)
from rcac_numeric.identification._regressors import as_signal, lagged


@dataclass(frozen=True, eq=False)
class IdentifiedMarkovParameters(Result):
    """A fitted mu-Markov model (3.8), with the evidence for its Markov parameters.

    Attributes
    ----------
    H : array, shape (mu, l_y, l_u)
        The Markov parameters H_0, ..., H_(mu-1).
    standard_error : array, shape (mu, l_y, l_u)
        Of each entry of H; at least the bound of rounding
        eps * (number of equations) * condition_number * max(abs(H)).
    covariance : array, shape (mu l_y l_u, mu l_y l_u)
        Of H.ravel(), with the squares of standard_error on its diagonal.
    a, b : arrays, shapes (n_mod, l_y, l_y) and (n_mod, l_y, l_u)
        The other coefficients of (3.8), those of smallest norm where several fit equally well.
    residual : array, shape (rows, l_y)
        What (3.8) leaves unexplained, one row for each equation.
    freedom : float
        Degrees of freedom of the covariance.
    condition_number : float
        Of the regressors of H, after the other regressors have been projected out of them and
        each has been scaled to length 1.
    """

    H: Array
    standard_error: Array
    covariance: Array
    a: Array
    b: Array
    residual: Array
    freedom: float
    condition_number: float

    @property
    def mu(self) -> int:
        """Number of Markov parameters."""
        return len(self.H)

    def __str__(self) -> str:
        rms = np.sqrt(np.mean(self.residual**2))
        largest = [
            f"H_{i}: {np.abs(H).max():.6g} +- {error.max():.2g}"
            for i, (H, error) in enumerate(zip(self.H, self.standard_error, strict=True))
        ]
        head = f"{self.mu} Markov parameters, largest entry and standard error of each"
        tail = f"rms residual {rms:.3g}, condition number {self.condition_number:.3g}"
        return "\n".join([head, *largest, tail])

    def cleared(self, significance: float = 5.0) -> Array:
        """H with its leading insignificant parameters set to zero; shape (mu, l_y, l_u).

        A parameter is significant if one of its entries exceeds `significance` standard errors.
        """
        factor = number(significance, "significance")
        significant = (np.abs(self.H) > factor * self.standard_error).any(axis=(1, 2))
        cleared = self.H.copy()
        cleared[: int(np.argmax(significant)) if significant.any() else self.mu] = 0.0
        return cleared


def identify_markov_parameters(
    u: ArrayLike,
    y: ArrayLike,
    mu: int,
    n_mod: int,
    noise: NeweyWest | None = NeweyWest(),  # noqa: B008 (frozen)
) -> IdentifiedMarkovParameters:
    """The Markov parameters from u to y by least squares, (3.8)-(3.10).

    y(k) = sum_{j<mu} H_j u(k-j) + sum_{j=mu}^{mu+n_mod-1} (b_j u(k-j) - a_j y(k-j))

    Parameters
    ----------
    u, y : arrays, shapes (steps, l_u) and (steps, l_y)
        1-D arrays stand for scalar signals.
    mu : int
        Number of Markov parameters, at least 1.
    n_mod : int
        Order of the model; at least that of the plant for the model to be exact.
    noise : NeweyWest, optional
        How the standard errors come about; None takes the residual as white, the textbook's
        (Phi' Phi)^-1 x Sigma, which misses how coloured noise correlates the parameters.

    Raises
    ------
    InputError
        If there are fewer equations than coefficients, the input is not persistently exciting of
        order mu + n_mod (the message gives the order that it reaches), or a feedback from y to u
        leaves H undetermined. Ranks are those of float64: singular values below
        eps * (largest side) * (largest singular value) count as zero.

    Notes
    -----
    Without noise and with n_mod above the plant's order a and b are not unique, but H is. With a
    white input in open loop H is estimated consistently whatever the output noise, the error
    shrinking like 1/sqrt(steps), while a and b stay biased; then the present and recent inputs
    are independent of all other regressors. In closed loop they are not. Errata: the text calls
    the first mu outputs of the impulse response H_1, ..., H_mu; they are H_0, ..., H_(mu-1).

    Examples
    --------
    >>> import numpy as np, scipy.signal
    >>> from rcac_numeric.identification import identify_markov_parameters
    >>> u = np.random.default_rng(0).standard_normal(100)
    >>> y = scipy.signal.lfilter([0, 2, 1], [1, -0.5, 0], u)
    >>> identify_markov_parameters(u, y, mu=4, n_mod=2).H.ravel().round(6) + 0.0
    array([0., 2., 2., 1.])
    """
    U, Y = as_signal(u, "u"), as_signal(y, "y")
    if len(U) != len(Y):
        raise InputError(f"u has {len(U)} steps and y has {len(Y)}; they must be equally long.")
    mu, n_mod = integer(mu, "mu", at_least=1), integer(n_mod, "n_mod")
    window, l_u, l_y = mu + n_mod, U.shape[1], Y.shape[1]
    rows, unknowns = len(U) - window + 1, window * l_u + n_mod * l_y
    if rows < unknowns:
        raise InputError(
            f"{len(U)} samples give {max(rows, 0)} equations for {unknowns} coefficients of each "
            f"output; record at least {unknowns + window - 1} samples, or lower mu or n_mod."
        )
    past_u = lagged(U, window)
    recent, older = past_u[:, : mu * l_u], past_u[:, mu * l_u :]
    rest = np.hstack([older, -lagged(Y, window)[:, mu * l_y :]])
    present = Y[window - 1 :]
    _require_excitation(U, window)

    # Least squares in two steps: what `rest` explains is removed from `recent` first.
    directions = _column_space(rest)
    pure = recent - directions @ (directions.T @ recent)
    lengths = np.linalg.norm(recent, axis=0)
    size = np.linalg.svd(pure / lengths, compute_uv=False)
    if size[-1] <= np.finfo(float).eps * rows * size[0]:
        raise InputError(
            f"the {mu} Markov parameters are not determined: a linear relation between the "
            "recorded u and y, such as a feedback from y to u, explains the input. Add an "
            "independent perturbation to u."
        )
    theta_H = np.linalg.lstsq(pure / lengths, present, rcond=None)[0] / lengths[:, None]
    explained = present - recent @ theta_H
    theta_rest = _least_norm(rest, explained)
    residual = explained - rest @ theta_rest
    freedom = max(rows - mu * l_u - directions.shape[1], 1)
    inverse = np.linalg.inv((pure / lengths).T @ (pure / lengths)) / np.outer(lengths, lengths)
    condition_number = float(size[0] / size[-1])
    rounding = np.finfo(float).eps * rows * condition_number * np.abs(theta_H).max()
    spread = coefficient_covariance(pure, inverse, residual, freedom, noise)
    covariance = _of_parameters(spread, mu, l_u, rounding)
    shape = (mu, Y.shape[1], l_u)
    cut = n_mod * l_u
    return IdentifiedMarkovParameters(
        H=_as_matrices(theta_H, mu, l_u),
        standard_error=real_array(np.sqrt(np.diag(covariance)).reshape(shape), "standard errors"),
        covariance=real_array(covariance, "covariance"),
        b=_as_matrices(theta_rest[:cut], n_mod, l_u),
        a=_as_matrices(theta_rest[cut:], n_mod, l_y),
        residual=real_array(residual, "residual"),
        freedom=degrees_of_freedom(rows, freedom, noise),
        condition_number=condition_number,
    )


def _require_excitation(u: Array, order: int) -> None:
    def excites(length: int) -> bool:
        rows = lagged(u, length)
        return int(np.linalg.matrix_rank(rows)) >= int(rows.shape[1])

    if excites(order):
        return
    reached = next((length for length in range(order - 1, 0, -1) if excites(length)), 0)
    raise InputError(
        f"the input is persistently exciting of order {reached} only; mu + n_mod = {order} is "
        "needed. Record a richer input, such as white noise, or lower mu or n_mod."
    )


def _scaled_svd(columns: Array) -> tuple[Array, Array, Array, Array]:
    lengths = np.linalg.norm(columns, axis=0)
    lengths[lengths == 0] = 1.0
    left, size, right = np.linalg.svd(columns / lengths, full_matrices=False)
    keep = size > np.finfo(float).eps * max(columns.shape) * size.max(initial=0.0)
    return left[:, keep], size[keep], right[keep], lengths


def _column_space(columns: Array) -> Array:
    """An orthonormal basis."""
    return _scaled_svd(columns)[0]


def _least_norm(columns: Array, target: Array) -> Array:
    left, size, right, lengths = _scaled_svd(columns)
    return np.asarray((right.T @ ((left.T @ target) / size[:, None])) / lengths[:, None])


def _of_parameters(spread: Array, mu: int, l_u: int, rounding: float) -> Array:
    """Reorder theta with rows (lag, input) to H.ravel(), in the order (lag, output, input)."""
    l_y = spread.shape[1]
    sixfold = spread.reshape(mu, l_u, l_y, mu, l_u, l_y).transpose(0, 2, 1, 3, 5, 4)
    covariance = sixfold.reshape(mu * l_y * l_u, mu * l_y * l_u)
    missing = np.maximum(rounding**2 - np.diag(covariance), 0.0)
    return np.asarray(covariance + np.diag(missing))


def _as_matrices(stacked: Array, count: int, width: int) -> Array:
    """[H_0'; H_1'; ...] as an array of matrices."""
    return real_array(
        stacked.reshape(count, width, stacked.shape[1]).transpose(0, 2, 1), "coefficients"
    )
