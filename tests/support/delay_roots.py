"""Rightmost roots of a loop with a dead time, in floats: Chebyshev collocation of its generator.

D. Breda, S. Maset, R. Vermiglio, SIAM J. Sci. Comput. 27 (2005) 482-495.
"""

import numpy as np
from scipy.signal import tf2ss


def chebyshev_derivative(count):
    """Nodes on [-1, 1] from 1 down, and the matrix of the derivative there (Trefethen's cheb)."""
    nodes = np.cos(np.pi * np.arange(count + 1) / count)
    weights = np.r_[2, np.ones(count - 1), 2] * (-1.0) ** np.arange(count + 1)
    differences = nodes[:, None] - nodes
    matrix = np.outer(weights, 1 / weights) / (differences + np.eye(count + 1))
    return nodes, matrix - np.diag(matrix.sum(axis=1))


def delay_roots(numerator, denominator, delay, count=60):
    """Roots of D(s) + N(s) exp(-delay s), the rightmost of which are accurate."""
    A, B, C, _ = tf2ss(numerator, denominator)
    n = len(A)
    matrix = np.kron(chebyshev_derivative(count)[1] * 2 / delay, np.eye(n))
    matrix[:n] = 0
    matrix[:n, :n] = A
    matrix[:n, -n:] = -B @ C
    return np.linalg.eigvals(matrix)
