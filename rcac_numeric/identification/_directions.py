"""NMP zeros and their directions from a record of data."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import integer, number
from rcac_numeric.arrays._values import Result
from rcac_numeric.identification._regressors import as_signal, lagged
from rcac_numeric.targets._zero_directions import DirectionInformation

# Beyond it a zero of an overfitted numerator is one at infinity.
FARTHEST = 10.0


@dataclass(frozen=True, eq=False)
class DirectionsFromData(Result):
    """The identified G_zu of a record, with its evidence.

    Attributes
    ----------
    information : DirectionInformation
        H, and the NMP zeros with their directions; what `zero_direction_target` takes.
    zeros : array
        All zeros of the fitted numerator.
    errors : array
        Their standard errors, to first order.
    order, steps : int
        Of the fit: lags, and rows.
    residual : float
        Root mean square of the one-step error.
    """

    information: DirectionInformation
    zeros: ComplexArray
    errors: Array
    order: int
    steps: int
    residual: float


def directions_from_data(
    u: ArrayLike, z: ArrayLike, *, order: int, level: float = 1.96, largest_error: float = 0.2
) -> DirectionsFromData:
    """Relative degree 1, H, NMP zeros and directions of a square G_zu, by least squares.

    z(k) + A_1 z(k-1) + ... + A_p z(k-p) = B_1 u(k-1) + ... + B_p u(k-p) + e(k):
    det B(z0) = 0,  eta' A(z0)^-1 B(z0) = 0,  H = B_1

    Parameters
    ----------
    u, z : arrays, shape (steps, l) and (steps, l)
        Control and performance, as many of each.
    order : int
        p. Noise that enters the plant is no white e, so that p must exceed the order of the plant.
    level : float
        A zero counts as NMP where its modulus exceeds 1 by as many standard errors, and as
        minimum phase where it falls short of 1 by as many; beyond 10 it is one at infinity.
    largest_error : float
        The largest standard error of an NMP zero.

    Raises
    ------
    InputError
        If sizes differ, there are too few data, the input does not excite the fit, B_1 is
        singular, or a zero is not decided or an NMP zero known too badly: keep the target that
        you have, then.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.identification import directions_from_data
    >>> u = np.random.default_rng(0).standard_normal((500, 2))
    >>> z = np.zeros((500, 2))
    >>> X = np.array([[1.5, 0.0], [0.0, 0.2]])
    >>> z[2:] = u[1:-1] - u[:-2] @ X.T
    >>> [(z0, eta)] = directions_from_data(u, z, order=2).information.zeros
    >>> complex(np.round(z0, 9)), np.abs(np.round(eta, 9)).tolist()
    ((1.5+0j), [1.0, 0.0])
    """
    U, Z = as_signal(u, "u"), as_signal(z, "z")
    p, size = integer(order, "order", at_least=1, at_most=100), U.shape[1]
    if U.shape != Z.shape:
        raise InputError(f"u has shape {U.shape} and z {Z.shape}; a square G_zu is identified.")
    if len(U) < p + 4 * size * p:
        raise InputError(
            f"{len(U)} steps are too few for order = {p}: {p + 4 * size * p} at least."
        )
    rows = np.hstack([lagged(U, p + 1)[:, size:], -lagged(Z, p + 1)[:, size:]])
    solution, _, rank, singular = np.linalg.lstsq(rows, Z[p:], rcond=None)
    theta: Array = np.asarray(solution, dtype=np.float64)
    if rank < rows.shape[1]:
        raise InputError(
            f"the data do not determine the fit of order {p}: rank {rank} of {rows.shape[1]}, "
            f"smallest singular value {singular[-1]:.2g}. Perturb u more, or use a lower order."
        )
    error = Z[p:] - rows @ theta
    noise: Array = error.T @ error / (len(rows) - rows.shape[1])
    inverse: Array = np.asarray(np.linalg.inv(rows.T @ rows), dtype=np.float64)
    spread = inverse[: p * size, : p * size]
    B = _blocks(theta[: p * size], p, size)
    A = np.concatenate([np.eye(size)[None], _blocks(theta[p * size :], p, size)])
    least = float(np.linalg.svd(B[0], compute_uv=False)[-1])
    deviation = float(np.sqrt(np.linalg.norm(noise, 2) * np.linalg.norm(spread[:size, :size], 2)))
    if least <= max(3 * deviation, 1e-9 * float(np.abs(B).max())):
        raise InputError(
            f"B_1 has the singular value {least:.2g} with the standard error {deviation:.2g}: the "
            "relative degree is not 1 in every channel, or there are too few data to show it."
        )
    zeros, errors = _zeros(B, noise, spread)
    width = number(level, "level")
    known = []
    for z0, spread_of in zip(zeros, errors, strict=True):
        if z0.imag < 0 or abs(z0) > FARTHEST or abs(z0) + width * spread_of < 1:
            continue
        if abs(z0) - width * spread_of <= 1 or spread_of > number(largest_error, "largest_error"):
            raise InputError(
                f"the zero {z0:.4g} has the standard error {spread_of:.2g}: the data do not decide "
                "where it is, inside or outside the unit circle. Record more, or perturb u more."
            )
        value = scipy.linalg.solve(_at(A, z0), _at(B, z0) / z0)
        eta = np.linalg.svd(value)[0][:, -1].conj()
        turned = eta * abs(eta[(k := np.argmax(np.abs(eta)))]) / eta[k]
        real = z0.imag == 0
        known.append((complex(z0), [complex(e.real if real else e) for e in turned]))
    residual = float(np.sqrt((error**2).mean()))
    return DirectionsFromData(
        DirectionInformation(B[0], known), zeros, errors, p, len(rows), residual
    )


def _blocks(theta: Array, p: int, size: int) -> Array:
    return np.asarray(theta.T.reshape(size, p, size).transpose(1, 0, 2), dtype=np.float64)


def _at(blocks: Array, z0: complex) -> ComplexArray:
    """Evaluate a polynomial in 1/q at z0."""
    powers = z0 ** -np.arange(len(blocks), dtype=float)
    return np.asarray(np.tensordot(powers, blocks, 1))


def _zeros(B: Array, noise: Array, spread: Array) -> tuple[ComplexArray, Array]:
    """The roots of det B and their standard errors, to first order.

    With eta' B(z0) = 0 and B(z0) v = 0: dz0 = -eta' dB(z0) v / eta' B'(z0) v.
    """
    p, size, _ = B.shape
    companion = np.eye(size * (p - 1), k=-size)
    if p > 1:
        companion[:size] = -np.linalg.solve(B[0], np.hstack(list(B[1:])))
    values = np.asarray(scipy.linalg.eigvals(companion)) if p > 1 else np.zeros(0)
    zeros = np.where(np.abs(values.imag) <= 1e-9 * np.abs(values), values.real, values)
    zeros = zeros.astype(np.complex128)
    errors = []
    for z0 in zeros:
        if z0 == 0:
            errors.append(0.0)
            continue
        U, _, V = np.linalg.svd(_at(B, z0))
        eta, v = U[:, -1].conj(), V[-1].conj()
        powers = z0 ** -np.arange(p, dtype=float)
        moved = np.tensordot(-np.arange(p) * powers / z0, B, 1)
        x = np.concatenate([power * v for power in powers])
        variance = (eta @ noise @ eta.conj()).real * (x.conj() @ spread @ x).real
        slope = abs(eta @ moved @ v)
        errors.append(float(np.sqrt(variance) / slope) if slope > 0 else np.inf)
    return zeros, np.array(errors)
