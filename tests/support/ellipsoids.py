"""Ellipsoids for theta, and |v|^2 of a theta in rationals."""

import numpy as np
from flint import fmpq, fmpq_mat

import rcac_numeric as rn


def ellipsoid(seed, size, width=0.05, spread=1.0, center=None):
    """A random one whose axes differ by about `spread`."""
    rng = np.random.default_rng(seed)
    L = np.tril(rng.uniform(-0.3, 0.3, (size, size)), -1)
    L += np.diag(rng.uniform(0.7, 1.3, size))
    scale = width * spread ** rng.uniform(-0.5, 0.5, size)
    return rn.CertifiedBounds(
        width * rng.standard_normal(size) if center is None else center, scale[:, None] * L
    )


def rational(values):
    array = np.atleast_2d(np.asarray(values, dtype=float))
    entries = [fmpq(*float(v).as_integer_ratio()) for v in array.ravel()]
    return fmpq_mat(*array.shape, entries)


def exact_square(bounds, theta):
    """|factor^-1 (theta - center)|^2, without rounding."""
    delta = rational(theta).transpose() - rational(bounds.center).transpose()
    v = rational(bounds.factor).solve(delta)
    return sum(x * x for x in v.entries())
