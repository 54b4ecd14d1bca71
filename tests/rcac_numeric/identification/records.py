"""Recorded data of known plants."""

import numpy as np
import scipy.signal


def coloured(rng, steps, pole):
    return scipy.signal.lfilter([1.0], [1.0, -pole], rng.standard_normal(steps))


def simulated(plant, u):
    """z of a Plant from rest."""
    x, z = np.zeros(plant.n), []
    for value in np.asarray(u).reshape(len(u), -1):
        z.append(plant.E_1 @ x + plant.E_2 @ value)
        x = plant.A @ x + plant.B @ value
    return np.array(z)


COMPLEX = 1.1 + 0.4j  # a zero of (q - zero)(q - conjugate)/((q - 0.5)(q - 0.2)(q + 0.3))
REAL = 1.5  # the zero of (q - 1.5)/(q^2 - 0.5 q + 0.2)


def noisy(zero, steps, seed, noise=0.1, pole=0.8):
    """u, y of one of the two plants above: white u in open loop, coloured output noise."""
    rng = np.random.default_rng(seed)
    u = rng.standard_normal(steps)
    if isinstance(zero, complex):
        numerator = np.r_[0, np.poly([zero, np.conj(zero)]).real]
        denominator = np.poly([0.5, 0.2, -0.3])
    else:
        numerator, denominator = [0, 1, -zero], [1, -0.5, 0.2]
    y = scipy.signal.lfilter(numerator, denominator, u)
    return u, y + noise * coloured(rng, steps, pole)
