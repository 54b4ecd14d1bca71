"""The discrete-time Riccati equation in sixty digits, for gains that were found in float64."""

import mpmath
import numpy as np


def design_60_digits(A, B, E_1, E_2, K, digits=60):
    """(K, P) by Kleinman's iteration from a stabilising K, as mpmath matrices."""
    with mpmath.workdps(digits):
        A, B, E_1, E_2, K = (mpmath.matrix(np.atleast_2d(M).tolist()) for M in (A, B, E_1, E_2, K))
        for _ in range(200):
            P = _stein(A + B * K, E_1 + E_2 * K, digits)
            left = E_2.T * E_2 + B.T * P * B
            new = -mpmath.inverse(left) * (E_2.T * E_1 + B.T * P * A)
            change = mpmath.mnorm(new - K, 1)
            K = new
            if change <= mpmath.mpf(10) ** (-digits / 2) * mpmath.mnorm(K, 1):
                return K, P
    raise ValueError("sixty digits do not settle it")


def _stein(A, E, digits):
    P, power = E.T * E, A
    for _ in range(100):
        added = power.T * P * power
        P = P + added
        if mpmath.mnorm(added, 1) <= mpmath.mpf(10) ** -digits * mpmath.mnorm(P, 1):
            return P
        power = power * power
        if mpmath.mnorm(power, 1) > mpmath.mpf(10) ** 500:
            break
    raise ValueError("not stable")


def hard_design(seed):
    """A plant for LQG with V_2 from 1 to 1e-14 of V_1: several signals, delays, hidden modes."""
    from rcac_numeric import Plant

    rng = np.random.default_rng(seed)
    n, l_u, l_y = int(rng.integers(1, 6)), int(rng.integers(1, 4)), int(rng.integers(1, 4))
    A = rng.standard_normal((n, n))
    radius = rng.choice([0.3, 0.9, 0.99, 0.9999, 1.05, 1.3])
    A *= radius / max(np.abs(np.linalg.eigvals(A)).max(), 1e-3)
    B, C = rng.standard_normal((n, l_u)), rng.standard_normal((l_y, n))
    if n > 1 and rng.random() < 0.3:  # a mode that is hardly moved, or hardly seen
        A[0, 1:] = 0
        A[0, 0] = rng.choice([0.5, 0.95])
        B[0] *= 10 ** rng.uniform(-8, 0)
        A[1:, 0] *= 10 ** rng.uniform(-6, 0)
        C[:, 0] *= 10 ** rng.uniform(-6, 0)
    delay = int(rng.integers(0, 3))
    if delay:  # of every u
        whole = n + delay * l_u
        late = np.zeros((whole, whole))
        late[:n, :n], late[:n, n : n + l_u] = A, B
        late[n : whole - l_u, n + l_u :] = np.eye((delay - 1) * l_u)
        A, C = late, np.hstack([C, np.zeros((l_y, delay * l_u))])
        B = np.vstack([np.zeros((whole - l_u, l_u)), np.eye(l_u)])
    n = len(A)
    l_w = n + l_y
    size = 10 ** rng.uniform(-7, 0)
    D_1, D_2 = rng.standard_normal((n, l_w)), size * rng.standard_normal((l_y, l_w))
    E_1 = np.vstack([rng.standard_normal((2, n)), np.zeros((l_u, n))])
    E_2 = np.vstack([np.zeros((2, l_u)), 10 ** rng.uniform(-7, 0) * np.eye(l_u)])
    return Plant(A=A, B=B, D_1=D_1, C=C, D_2=D_2, E_1=E_1, E_2=E_2, E_0=np.zeros((len(E_1), l_w)))
