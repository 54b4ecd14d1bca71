"""The lateral aircraft (3.1), (3.2) in continuous time, discretised by Euler's rule."""

import numpy as np

A_0 = np.array(
    [
        [-0.0771, 0.269, -0.9631, 0.0397],
        [-25.60, 0.0218, 0.0995, 0],
        [0.6160, 0.0376, -0.2687, 0],
        [0, 1, -0.4202, 0.0058],
    ]
)
B_0 = np.array([[-0.0002], [2.519], [-0.0222], [0]])
A_1, B_1 = A_0.copy(), B_0.copy()
A_1[1, 0], A_1[2, 0] = -108.8, 0.4107
B_1[2, 0] = -0.0665


def euler(A, B, h):
    """(I + h A, h B)."""
    return np.eye(4) + h * A, h * B


def without_A21(A):
    """The model in which entry (2, 1) is the unknown subsystem from beta to P."""
    rest = A.copy()
    rest[1, 0] = 0.0
    return rest


E_1, B_HAT, FOLLOWED = [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]
