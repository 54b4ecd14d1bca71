"""Ellipsoids of gains that keep a bound on the unit circle: largest by volume or in a metric."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from rcac_numeric.analysis._peaks import responses_of
from rcac_numeric.arrays._array_types import Array, ComplexArray

AROUND_POLES = np.array([-10, -3, -1, -0.5, -0.2, 0, 0.2, 0.5, 1, 3, 10])
"""Angles beside that of a pole, in multiples of its distance from the circle."""

FLOOR = 1e-14  # of the largest eigenvalue, below which one is raised
STEPS = 1500  # most updates of the weights
THINNED = 25  # updates after which points of no weight are left out
DIRECTIONS = 8  # most times that worst directions of several inputs are added


def frequencies(A: Array, points: int = 300) -> Array:
    """Return angles in [0, pi], among them those of the poles and beside them."""
    poles = np.linalg.eigvals(A)
    angles, depths = np.abs(np.angle(poles)), np.maximum(1 - np.abs(poles), 1e-9)
    beside = (angles[:, None] + depths[:, None] * AROUND_POLES).ravel()
    even = np.linspace(0, np.pi, points // 2)
    ratios = np.geomspace(1e-4, np.pi, points)
    every = np.concatenate([[0.0], ratios, even, beside])
    return np.unique(every[(every >= 0) & (every <= np.pi)])


def responses_on_grid(A: Array, B: Array, C: Array) -> ComplexArray:
    """Return C (zI - A)^-1 B on the grid of A; shape (points, outputs, inputs)."""
    none = np.zeros((len(C), B.shape[1]))
    return responses_of((A, B, C, none), frequencies(A))


@dataclass
class WeightedPoints:
    """Points t with t* M t <= 1 for the unknown M, in coordinates scaled to comparable size.

    Attributes
    ----------
    real, imaginary : arrays, shape (points, l)
        In whitened coordinates.
    weights : array, shape (points,)
        Multipliers; their sum is 1.
    basis, inverse : arrays, shape (l, l)
        M = basis N basis' for the matrix N in whitened coordinates.
    """

    real: Array
    imaginary: Array
    weights: Array
    basis: Array
    inverse: Array

    @property
    def moment(self) -> Array:
        """The weighted sum of Re(t t*)."""
        real = (self.real * self.weights[:, None]).T @ self.real
        return np.asarray(
            real + (self.imaginary * self.weights[:, None]).T @ self.imaginary, dtype=np.float64
        )

    def sizes(self, N: Array) -> Array:
        """Return t* N t of every point."""
        real = ((self.real @ N) * self.real).sum(axis=1)
        return np.asarray(real + ((self.imaginary @ N) * self.imaginary).sum(axis=1))

    def reweighted(self, sizes: Array) -> float:
        """Multiply the weights by the sizes and return the mean size before."""
        mean = float(self.weights @ sizes)
        self.weights = self.weights * sizes / mean
        self.weights /= self.weights.sum()
        return mean

    def thinned(self, sizes: Array) -> WeightedPoints:
        """Leave out the points that have no weight and are far from the bound."""
        near = (sizes > 0.5 * sizes.max()) | (self.weights > 1e-7 * self.weights.max())
        weights = self.weights[near] / self.weights[near].sum()
        return WeightedPoints(
            self.real[near], self.imaginary[near], weights, self.basis, self.inverse
        )


def weighted_points(points: ComplexArray, caps: Array) -> WeightedPoints:
    """Return points, shape (count, l), with the bounds M_ii <= caps_i^2 among them."""
    count, taps = points.shape
    mean = (points.conj().T @ points).real / count + np.diag(caps**-2.0) / count
    scale = 1 / np.sqrt(np.diag(mean))
    values, vectors = np.linalg.eigh(mean * np.outer(scale, scale))
    values = values.clip(1e-15 * values[-1])
    basis = scale[:, None] * vectors * values**-0.5
    inverse = (vectors * values**0.5).T / scale
    real = np.concatenate([points.real @ basis, np.diag(1 / caps) @ basis])
    imaginary = np.concatenate([points.imag @ basis, np.zeros((taps, taps))])
    return WeightedPoints(real, imaginary, np.full(len(real), 1 / len(real)), basis, inverse)


def largest_ellipsoid(
    points: ComplexArray, caps: Array, metric: Array | None = None, rtol: float = 1e-2
) -> Array:
    """Return K, lower triangular: M = KK' with t* M t <= 1 for all points and M_ii <= caps_i^2.

    Without a metric M has the largest determinant; with a metric Sigma it minimises
    tr(M^-1 Sigma), the mean square radius of changes with covariance Sigma. Both are stationary at
    a matrix of the moment S of the points weighted by multipliers, M = S^-1, or M S M = Sigma;
    the multipliers follow by multiplication, as in D-optimal design (Titterington, 1976).
    """
    every = weighted_points(points, caps)
    sigma = None if metric is None else every.inverse @ metric @ every.inverse.T
    active, N = every, np.eye(points.shape[1])
    for step in range(STEPS):
        S = active.moment
        N = _power(S, -1.0) if sigma is None else geometric_mean(S, sigma)
        sizes = active.sizes(N)
        mean = active.reweighted(sizes)
        if sizes.max() < mean * (1 + rtol):
            break
        if step % THINNED == THINNED - 1:
            active = active.thinned(sizes)
    return lower_factor(every.basis @ _power(N / every.sizes(N).max(), 0.5))


def largest_for_matrices(responses: ComplexArray, caps: Array, metric: Array | None) -> Array:
    """Return K for responses of several inputs, K'T of norm at most about 1.

    The points are T v for directions v of the input: the axes at first, then the worst direction
    at each frequency where the norm exceeds 1.
    """
    inputs = responses.shape[2]
    points = np.concatenate([responses[:, :, j] for j in range(inputs)])
    K = largest_ellipsoid(points, caps, metric)
    for _ in range(DIRECTIONS if inputs > 1 else 0):
        _, sizes, adjoints = np.linalg.svd(K.T @ responses)
        if sizes[:, 0].max() < 1.02:
            break
        worst = np.einsum("wlm,wm->wl", responses, adjoints[:, 0].conj())[sizes[:, 0] > 1]
        points = np.concatenate([points, worst])
        K = largest_ellipsoid(points, caps, metric)
    return K


def geometric_mean(S: Array, sigma: Array) -> Array:
    """Return the positive definite M = L^-T (L' sigma L)^(1/2) L^-1, S = L L': M S M = sigma."""
    L = np.linalg.cholesky(S + FLOOR * np.trace(S) * np.eye(len(S)))
    left = solve_triangular(L, _power(L.T @ sigma @ L, 0.5), lower=True, trans="T")
    return np.asarray(solve_triangular(L, left.T, lower=True, trans="T"))


def lower_factor(X: Array) -> Array:
    """Return the lower triangular K with a positive diagonal and KK' = XX'."""
    upper = np.linalg.qr(X.T)[1]
    return np.tril((upper * np.sign(np.diag(upper))[:, None]).T)


def _power(S: Array, exponent: float) -> Array:
    values, vectors = np.linalg.eigh((S + S.T) / 2)
    values = values.clip(FLOOR * values[-1])
    return np.asarray((vectors * values**exponent) @ vectors.T)
