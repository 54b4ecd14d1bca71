"""The direction of a zero of a plant whose fractions are prescribed, as an oracle."""

import numpy as np


def directions(poles, X, zero):
    """The left null vector of G(z0), by the eigenvectors of X; no zero direction of our own."""
    values, vectors = np.linalg.eig(X.T)
    eta = vectors[:, np.argmin(np.abs(values - zero))]
    turned = eta * [(zero - a) * (zero - b) for a, b in poles]
    return turned / np.linalg.norm(turned)
