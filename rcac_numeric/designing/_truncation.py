"""Balanced truncation of a stable system to a requested accuracy."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import schur, solve_triangular

from compensator_theory.errors import IllConditionedError
from rcac_numeric.analysis._gramians import stein_solution
from rcac_numeric.analysis._peaks import responses_of
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._values import Value
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.designing._plants import LONGEST_DELAY, MOST_STATES, DesignPlant

OF_PEAK, AT_REST = 0.01, 0.05  # the error that is allowed, over the largest and the low gain
GRID = 600  # frequencies at which responses are compared, and those of the slow modes
RINGS = 0.9  # modulus of a pole that may show between two of them


class Balanced:
    """A stable system in balanced coordinates: equal controllability and observability Gramians.

    Source: B. C. Moore, IEEE Transactions on Automatic Control 26 (1981) 17-32; by square roots:
    M. S. Tombs and I. Postlethwaite, International Journal of Control 46 (1987) 1319-1330.
    """

    def __init__(self, A: Array, B: Array, C: Array) -> None:
        self.A, self.B, self.C = A, B, C
        self._reachability = _root(stein_solution(A, B @ B.T))
        self._observability = _root(stein_solution(A.T, C.T @ C))
        self._left, self.hankel, self._right = np.linalg.svd(
            self._observability.T @ self._reachability
        )

    def truncated(self, order: int) -> tuple[Array, Array, Array]:
        """A, B, C of the states of the largest Hankel singular values."""
        scale = np.sqrt(self.hankel[:order])
        into = self._reachability @ self._right[:order].T / scale
        onto = (self._observability @ self._left[:, :order] / scale).T
        return onto @ self.A @ into, onto @ self.B, self.C @ into


@dataclass(frozen=True, eq=False)
class Truncation(Value):
    """A plant of many states and its truncation.

    Attributes
    ----------
    whole, plant : DesignPlant
    omega : array, shape (N,)
        Frequencies in rad/sample at which the two were compared.
    left_out : array, shape (N,)
        The largest singular value of the difference of their responses.
    error : float
        Its largest value, over the peak of the response.
    """

    whole: DesignPlant
    plant: DesignPlant
    omega: Array
    left_out: Array
    error: float

    def small_gain(self, controller: Compensator) -> float:
        """The peak over frequency of the truncation error times K S.

        Below 1 the controller, of e or of [e; r], stabilises the whole plant if it stabilises the
        one of few states, since what is left out is stable; the peak Ms of the sensitivity is then
        at most that of the loop with few states over 1 minus this.
        """
        m, omega = self.plant.m, self.omega
        K = responses_of(controller.state_space(), omega)[:, :, :m]
        S = np.linalg.inv(np.eye(m) + self.plant.response(omega) @ K)
        return float((np.linalg.norm(K @ S, 2, axis=(1, 2)) * self.left_out).max())


def truncated(plant: DesignPlant) -> Truncation | None:
    """The truncation of least order within the allowed error; None if the plant is kept.

    What is late in all of it, as in a measured impulse response, becomes dead time first. The
    error is measured: the bound by the Hankel singular values that are left out grows with their
    number, which of an impulse response that was cut off is nearly its length.

    Notes
    -----
    Source: U. M. Al-Saggaf and G. F. Franklin, IEEE Transactions on Automatic Control 32 (1987)
    815-819; the small-gain theorem: G. Zames, IEEE Transactions on Automatic Control 11 (1966)
    228-238.
    """
    if len(plant.A) <= MOST_STATES or plant.later is not None or not plant.is_stable:
        return None
    A, B, C = plant.A, plant.B, plant.C
    late, size = 0, np.linalg.norm(C) * np.linalg.norm(B)
    longest = LONGEST_DELAY // plant.m - plant.delay
    while late < longest and np.abs(C @ B).max() <= 1e-14 * size:
        late, C = late + 1, C @ A
    try:
        balanced = Balanced(A, B, C)
    except IllConditionedError:  # no truncation can be had: the plant stays whole
        return None
    omega, response = _response(plant)
    peak = float(np.linalg.norm(response, 2, axis=(1, 2)).max())
    allowed = min(OF_PEAK * peak, AT_REST * plant.low_gain)
    for order in range(1, len(A)):
        if balanced.hankel[order] > allowed:  # the error is no less
            continue
        a, b, c = balanced.truncated(order)
        reduced = replace(
            plant, A=a, B=b, C=c, delay=plant.delay + late, continuous=None, fraction=0.0
        )
        left_out = np.linalg.norm(response - reduced.response(omega), 2, axis=(1, 2))
        if reduced.is_stable and left_out.max() <= allowed:
            return Truncation(plant, reduced, omega, left_out, float(left_out.max()) / peak)
    return None


def _response(plant: DesignPlant) -> tuple[Array, ComplexArray]:
    """Frequencies and the response there, by one Schur form and triangular systems."""
    T, Z = schur(plant.A, output="complex")
    B, C, poles = Z.conj().T @ plant.B, plant.C @ Z, np.diag(T)
    angles = np.abs(np.angle(poles[np.abs(poles) > RINGS]))
    omega = np.unique(np.concatenate([np.linspace(0, np.pi, GRID), angles]))
    eye = np.eye(len(T))
    responses = [C @ solve_triangular(z * eye - T, B) * z**-plant.delay for z in np.exp(1j * omega)]
    return omega, np.array(responses)


def _root(gramian: Array) -> Array:
    """L with L L' = the positive semidefinite matrix, which Cholesky's method may refuse."""
    values, vectors = np.linalg.eigh((gramian + gramian.T) / 2)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
