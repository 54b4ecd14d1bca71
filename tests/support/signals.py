"""White noise that a test can name by its seed."""

import numpy as np


def noise(seed, steps, width):
    return np.random.default_rng(seed).standard_normal((steps, width))


def white(steps, seed=0, width=1):
    """The same for tests in which only the number of steps matters."""
    return noise(seed, steps, width)
