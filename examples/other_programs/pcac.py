"""The first control of the PCAC MATLAB code in NumPy, for docs/coming-from/pcac.md.

The plant is G = (z - 1.3)/(z^2 - 1.4 z + 0.3), and X = [x, err, ref, U] as in pcac_paper.m.
"""

import numpy as np

F, G = np.array([-1.4, 0.3]), np.array([1.0, -1.3])
A, B, C = np.array([[-F[0], 1.0], [-F[1], 0.0]]), G[:, None], np.array([[1.0, 0.0]])
horizon, Q, P, R = 20, 2.0, 5.0, 1.0
x, u_past, r = np.array([0.4, -0.2]), 0.3, 1.0


def theirs():
    """U of MPC.m for one model without active limits, as least squares in the moves."""
    A_tilde = np.block(
        [
            [A, np.zeros((2, 2)), B],
            [C @ A, 0, -1, C @ B],
            [np.zeros((1, 3)), 1, 0],
            [np.zeros((1, 4)), 1],
        ]
    )
    B_tilde = np.vstack([B, C @ B, [[0.0]], [[1.0]]])
    X, reach = np.concatenate([x, C @ x - r, [r, u_past]]), np.zeros((5, horizon))
    rows, targets = [np.sqrt(R) * np.eye(horizon)], [np.zeros(horizon)]
    for j in range(1, horizon + 1):
        reach = A_tilde @ reach
        reach[:, j - 1] += B_tilde[:, 0]
        X = A_tilde @ X
        weight = np.sqrt(P if j == horizon else Q)
        rows.append(weight * reach[2:3])
        targets.append(-weight * X[2:3])
    return u_past + np.linalg.lstsq(np.vstack(rows), np.concatenate(targets), rcond=None)[0][0]
