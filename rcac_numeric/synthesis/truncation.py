"""A stable plant of many states as one of few: balanced truncation, as near as it is asked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rcac_numeric.analysis.gramians import stein_solution
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.synthesis.plants import LONGEST_DELAY, DesignPlant

MOST_STATES = 40  # beyond it each of the ladder's Riccati equations and peaks takes seconds
OF_PEAK, AT_REST = 0.01, 0.05  # the error that is allowed, over the largest and the low gain
GRID = 600  # frequencies at which responses are compared


def truncated(plant: DesignPlant) -> tuple[DesignPlant, float]:
    """The plant of least order whose response is near enough, and how far it is.

    What is late in all of it, as in a measured impulse response, becomes dead time first. The
    error is measured: the bound by the Hankel singular values that are left out grows with their
    number, which of an impulse response that was cut off is nearly its length.

    Parameters
    ----------
    plant : DesignPlant
        Stable. One of few states, or with other dead times by entry, is returned as it is.

    Returns
    -------
    plant : DesignPlant
    error : float
        The largest singular value of the difference, over that of the plant; 0 where it is as it
        was.

    Notes
    -----
    Source: U. M. Al-Saggaf and G. F. Franklin, IEEE Transactions on Automatic Control 32 (1987)
    815-819.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.synthesis.plants import DesignPlant
    >>> from rcac_numeric.synthesis.truncation import truncated
    >>> h = 0.8 ** np.arange(60)                       # from 3 steps on
    >>> shift, enters = np.eye(62, k=-1), np.eye(62, 1)
    >>> found, error = truncated(DesignPlant(shift, enters, np.append([0, 0], h)[None]))
    >>> len(found.A), found.delay, error < 1e-3
    (1, 2, True)
    """
    if len(plant.A) <= MOST_STATES or plant.later is not None or not plant.is_stable:
        return plant, 0.0
    A, B, C = plant.A, plant.B, plant.C
    late, size = 0, np.linalg.norm(C) * np.linalg.norm(B)
    while plant.delay + late < LONGEST_DELAY and np.abs(C @ B).max() <= 1e-14 * size:
        late, C = late + 1, C @ A
    reach, seen = _root(stein_solution(A, B @ B.T)), _root(stein_solution(A.T, C.T @ C))
    left, hankel, right = np.linalg.svd(seen.T @ reach)
    omega = np.linspace(0, np.pi, GRID)
    response = plant.response(omega)
    peak = float(np.linalg.norm(response, 2, axis=(1, 2)).max())
    allowed = min(OF_PEAK * peak, AT_REST * plant.low_gain)
    for order in range(1, len(A) + 1):
        scale = np.sqrt(hankel[:order])
        into = (reach @ right[:order].T) / scale
        onto = (left[:, :order] / scale).T @ seen.T
        made = replace(
            plant, A=onto @ A @ into, B=onto @ B, C=C @ into, delay=plant.delay + late,
            continuous=None, fraction=0.0,
        )  # fmt: skip
        if hankel[order:].max(initial=0.0) > allowed:  # the error is no less
            continue
        error = float(np.linalg.norm(response - made.response(omega), 2, axis=(1, 2)).max())
        if error <= allowed:
            return made, error / peak
    return plant, 0.0


def _root(gramian: Array) -> Array:
    """L with L L' = the positive semidefinite matrix, which Cholesky's method may refuse."""
    values, vectors = np.linalg.eigh(gramian)
    return np.asarray(vectors * np.sqrt(np.clip(values, 0.0, None)))
