"""The interacting multiple model filter as covariances and densities, in 50 digits."""

import mpmath as mp
import numpy as np


def interacting(modes, transitions, mu, y, u):
    """x(k|k), P(k|k), mu(k) and the log-likelihood (Bar-Shalom, Li, Kirubarajan 2001, 11.6.6).

    Each mode is (A, B, C, D, Q, R, x_0, P_0); an entry of y that is NaN was not measured.
    """
    with mp.workdps(50):
        built = [tuple(mp.matrix(np.atleast_2d(part).tolist()) for part in one) for one in modes]
        beliefs = [(x.T if x.rows == 1 else x, P) for *_, x, P in built]
        mu, total = [mp.mpf(float(value)) for value in mu], mp.mpf(0)
        result = []
        for k in range(len(y)):
            there = np.flatnonzero(~np.isnan(y[k]))
            v = mp.matrix(u[k].tolist())
            if len(there):
                densities = []
                for j, (_, _, C, D, _, R, _, _) in enumerate(built):
                    beliefs[j], density = corrected(*beliefs[j], C, D, R, y[k], v, there)
                    densities.append(density)
                joint = [m * d for m, d in zip(mu, densities, strict=True)]
                mu = [one / sum(joint) for one in joint]
                total += mp.log(sum(joint))
            result.append((*mixture(mu, beliefs), list(mu)))
            ahead = [[mu[i] * mp.mpf(float(transitions[i][j])) for i in range(len(mu))]
                     for j in range(len(mu))]  # fmt: skip
            mixed = [mixture([one / sum(row) for one in row], beliefs) for row in ahead]
            mu = [sum(row) for row in ahead]
            beliefs = [
                (A * x + B * v, A * P * A.T + Q)
                for (A, B, _, _, Q, *_), (x, P) in zip(built, mixed, strict=True)
            ]
        x, P, probabilities = zip(*result, strict=True)
        arrays = [np.array([np.array(one.tolist(), float) for one in part]) for part in (x, P)]
        return arrays[0][..., 0], arrays[1], np.array(probabilities, float), float(total)


def corrected(x, P, C, D, R, y, v, there):
    """The belief after what was measured, and the density of that."""
    C = mp.matrix([[C[int(i), j] for j in range(C.cols)] for i in there])
    direct = mp.matrix([(D * v)[int(i)] for i in there])
    noise = mp.matrix([[R[int(i), int(j)] for j in there] for i in there])
    e = mp.matrix([y[i] for i in there]) - C * x - direct
    S = C * P * C.T + noise
    gain = P * C.T * S**-1
    square = (e.T * S**-1 * e)[0]
    density = mp.exp(-square / 2) / mp.sqrt(mp.det(2 * mp.pi * S))
    return (x + gain * e, P - gain * S * gain.T), density


def mixture(weights, beliefs):
    """Mean and covariance of a mixture of Gaussians."""
    x = sum((w * one for w, (one, _) in zip(weights, beliefs, strict=True)), 0 * beliefs[0][0])
    P = 0 * beliefs[0][1]
    for w, (one, covariance) in zip(weights, beliefs, strict=True):
        P += w * (covariance + (one - x) * (one - x).T)
    return x, P
