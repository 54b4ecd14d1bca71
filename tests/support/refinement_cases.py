"""Truths and records for the tests of model refinement: the chapter's mass, spring and damper."""

import numpy as np

H, MASS, DAMPING = 0.1, 1.0, 5.0
MODEL = {
    "A": [[1, H], [0, 1 - DAMPING * H / MASS]],  # kappa acts through the subsystem
    "B": [0, -H / MASS],
    "D_1": [0, H / MASS],
    "C": [0, 1],
    "E_1": [1, 0],
    "x_0": [0.1, 0.01],
}


def spring(kappa, w, noise=0.0, seed=0):
    """y of (8.68), (8.69) for a stiffness at each step; `noise` is (mean, deviation) of v."""
    mean, deviation = noise if noise else (0.0, 0.0)
    v = mean + deviation * np.random.default_rng(seed + 10_000).standard_normal(len(w))
    x, y = np.zeros(2), []
    for k in range(len(w)):
        y.append(x[1] + v[k])
        force = w[k] - kappa[k] * x[0] - DAMPING * x[1]
        x = np.array([x[0] + H * x[1], x[1] + H * force / MASS])
    return np.array(y)


def white(seed, steps, amplitude=100.0):
    """The chapter does not say its w; this excites the spring."""
    return amplitude * np.random.default_rng(seed).standard_normal(steps)
