"""Systems of python-control for tests, and the response that it says they have."""

import control
import numpy as np

POINTS = np.exp(1j * np.array([0.2, 1.1, 2.6]))


def of_control(system):
    return np.array([np.atleast_2d(system(point)) for point in POINTS])


def random_system(seed, n, inputs, outputs, dt=0.01):
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    A /= 1.2 * max(np.abs(np.linalg.eigvals(A)).max(), 1e-3)
    parts = A, rng.standard_normal((n, inputs)), rng.standard_normal((outputs, n))
    return control.ss(*parts, rng.standard_normal((outputs, inputs)) * (seed % 2), dt)
