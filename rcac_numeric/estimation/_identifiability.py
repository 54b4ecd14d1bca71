"""Identifiability of noise covariances: Fisher's information by Whittle."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from compensator_theory.errors import IllConditionedError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import square_root_columns
from rcac_numeric.arrays._validation import instance_of, integer
from rcac_numeric.arrays._values import Result
from rcac_numeric.estimation._linear import LinearModel
from rcac_numeric.estimation._settings import EKF, learned_noises

FREQUENCIES = 2048  # of the mean over the spectrum
AT_ONCE = 2_000_000  # complex numbers
# Below this share of the other sensitivities a combination is told from none by rounding only.
ROUNDING = 1e-8


@dataclass(frozen=True, eq=False)
class NoiseInformation(Result):
    """The identifiable combinations of Q and R, and their accuracy.

    Attributes
    ----------
    Q_deviation : array, shape (n, n)
        Asymptotic standard deviations of the entries of an efficient estimate of Q; infinite where
        an entry cannot be identified, zero where it is known.
    R_deviation : array, shape (l_y, l_y)
        The same of R.
    unidentified : tuple of pairs of arrays
        Directions (dQ, dR) in which Q and R may change and the spectrum of y does not.
    steps : int
        Of the record that the deviations are for.
    """

    Q_deviation: Array
    R_deviation: Array
    unidentified: tuple[tuple[Array, Array], ...]
    steps: int

    def __str__(self) -> str:
        """Describe the unidentifiable directions."""
        if not self.unidentified:
            return "the measurements identify every learned entry of Q and R."
        words = [
            " and ".join(
                f"{name}[{i},{j}]"
                for name, change in zip("QR", pair, strict=True)
                for i, j in zip(*np.nonzero(np.triu(np.abs(change) > 1e-6)), strict=True)
            )
            for pair in self.unidentified
        ]
        return (
            f"no record identifies a change of {'; nor of '.join(words)}: their shares "
            "remain those of the initial values. Learn a diagonal, fix some of "
            "them, or measure more of x."
        )


def noise_information(
    settings: EKF, steps: int, *, learn: Iterable[str] = ("Q", "R"), diagonal: bool = False
) -> NoiseInformation:
    r"""Compute the information of a long record on the covariances of noises.

    With G = C (z I - A)^-1 and the spectrum Phi = G Q G* + R of y, the information of each step on
    parameters a and b of Q and R is the mean over the unit circle of

        tr(Phi^-1 dPhi/da Phi^-1 dPhi/db) / 2,

    also where A is not stable. Phi is linear in Q and R, so a direction without information is one
    along which the spectrum stays what it is: of Q at most n l_y combinations can be identified.

    Parameters
    ----------
    settings : EKF
        With a `LinearModel`; Q and R are where the information is taken.
    steps : int
        Of the record; the deviations go like 1/sqrt(steps).
    learn : sequence of {"Q", "R"}
        What is not known.
    diagonal : bool
        Whether what is not known is diagonal.

    Returns
    -------
    NoiseInformation

    Raises
    ------
    InputError
        Where the model is not linear, or what is to be learned is zero.
    IllConditionedError
        Where the spectrum of y is singular: some combination of measurements has no noise at all.

    Notes
    -----
    R. K. Mehra, On the identification of variances and adaptive Kalman filtering, IEEE Transactions
    on Automatic Control 15(2), 1970; P. Whittle, The analysis of multiple stationary time series,
    Journal of the Royal Statistical Society B 15(1), 1953.

    Examples
    --------
    >>> from rcac_numeric.estimation import EKF, LinearModel, noise_information
    >>> track = EKF(LinearModel(A=[[1, 1], [0, 1]], C=[[1, 0]]), Q=0.1, R=1)
    >>> len(noise_information(track, 1000).unidentified)  # position and its cross term
    1
    >>> information = noise_information(track, 1000, diagonal=True)
    >>> print(information)
    the measurements identify every learned entry of Q and R.
    """
    instance_of(settings, "settings", EKF)
    if not isinstance(settings.model, LinearModel):
        raise InputError("the spectrum of y is that of a LinearModel; give EKF(LinearModel(...)).")
    integer(steps, "steps", at_least=1)
    named = learned_noises(settings, learn)
    model, Q, R = settings.model, settings.Q, settings.R
    changes = _changes(Q if "Q" in named else 0 * Q, R if "R" in named else 0 * R, diagonal)
    root = _sensitivity(model, Q, R, changes)
    scale = np.linalg.norm(root, axis=0)
    shown = scale > ROUNDING * scale.max(initial=0.0)
    scale[~shown] = 1.0
    _, values, directions = np.linalg.svd(np.where(shown, root / scale, 0.0))
    values = np.append(values, np.zeros(len(scale) - len(values)))
    unseen = values <= ROUNDING * max(values.max(initial=0.0), 1.0)
    inverse = directions[~unseen] / values[~unseen, None] / scale
    null = directions[unseen] / scale
    shapes = [np.array([pair[which] for pair in changes]) for which in (0, 1)]
    deviations = []
    for part in shapes:
        spread = np.einsum("im,mjk->ijk", inverse, part)
        lost = np.abs(np.einsum("im,mjk->ijk", null, part)).max(axis=0, initial=0.0)
        deviations_of = np.sqrt((spread**2).sum(axis=0) / steps)
        deviations_of[lost > ROUNDING * np.abs(part).max(initial=np.finfo(float).tiny)] = np.inf
        deviations.append(deviations_of)
    pairs = []
    for one in null:
        dQ, dR = (np.tensordot(one, part, axes=1) for part in shapes)
        size = max(np.abs(dQ).max(), np.abs(dR).max())
        pairs.append((dQ / size, dR / size))
    return NoiseInformation(deviations[0], deviations[1], tuple(pairs), int(steps))


def _changes(Q: Array, R: Array, diagonal: bool) -> list[tuple[Array, Array]]:
    """A basis of the changes within the ranges of Q and R, each as large as these are."""
    pairs = []
    for which, covariance in enumerate((Q, R)):
        columns = square_root_columns(np.diag(np.diag(covariance)) if diagonal else covariance).T
        for i, a in enumerate(columns):
            for b in columns[i : i + 1] if diagonal else columns[i:]:
                change = np.outer(a, b) + np.outer(b, a)
                zero = np.zeros_like(R if which == 0 else Q)
                pairs.append((zero, change) if which else (change, zero))
    return pairs


def _sensitivity(
    model: LinearModel, Q: Array, R: Array, changes: list[tuple[Array, Array]]
) -> Array:
    """T with T'T the information of one step on the changes."""
    n, p, count = model.n, model.l_y, len(changes)
    dQ, dR = (np.array([pair[which] for pair in changes]) for which in (0, 1))
    circle = np.exp(1j * np.pi * (np.arange(FREQUENCIES) + 0.5) / FREQUENCIES)
    root = np.zeros((0, count))
    size = max(1, AT_ONCE // (count * max(p, n) * max(p, n)))
    for first in range(0, FREQUENCIES, size):
        z = circle[first : first + size]
        resolvent = z[:, None, None] * np.eye(n) - model.A
        G = np.linalg.solve(resolvent.transpose(0, 2, 1), model.C.T[None]).transpose(0, 2, 1)
        adjoint = G.conj().transpose(0, 2, 1)
        spectrum = G @ Q @ adjoint + R
        try:
            whitening = np.linalg.inv(np.linalg.cholesky(spectrum))
        except np.linalg.LinAlgError:
            raise IllConditionedError(
                "the spectrum of y is singular: some combination of the measurements has no noise. "
                "Give every measurement some noise, R > 0, or drop a redundant one."
            ) from None
        moved = G[:, None] @ dQ @ adjoint[:, None] + dR
        white = whitening[:, None] @ moved @ whitening.conj().transpose(0, 2, 1)[:, None]
        rows = white.transpose(0, 2, 3, 1).reshape(-1, count) / np.sqrt(2 * FREQUENCIES)
        stacked = np.vstack([root, rows.real, rows.imag])
        root = np.asarray(np.linalg.qr(stacked, mode="r"))
    return root
