"""The update of RCAC_cpp in NumPy, in the order of its calls, for docs/coming-from/rcac-cpp.md."""

import numpy as np

A, B, C = np.array([[0.5, 1.0], [0.0, 0.3]]), np.eye(2), np.array([[1.0, 0.0], [0.0, 2.0]])
N_u = [
    np.zeros((2, 2)),
    C @ B,
    C @ A @ B - 0.2 * C @ B,
]  # H_1 q^-1 + ..., over 1 - 0.2 q^-1
D_u = [-0.2 * np.eye(2)]
R_z, lam, P0, n_c, k_0, steps = np.diag([1.0, 2.0]), 0.995, 100.0, 4, 12, 400
noise = np.random.default_rng(0).standard_normal((steps, 2)) * 0.05
command = np.where(np.arange(steps)[:, None] < 8, 0.0, [[1.0, -0.5]]) + noise * (
    np.arange(steps)[:, None] >= 8
)


def theirs():
    """Theta, whose row k made u(k), and z of a run."""
    l_theta = n_c * 2 * 4
    P, now, x = P0 * np.eye(l_theta), np.zeros(l_theta), np.zeros(2)
    u, z, theta = np.zeros((steps + 1, 2)), np.zeros((steps, 2)), np.zeros((steps, l_theta))
    Phi, Phi_f, u_f = (
        np.zeros((steps + 1, 2, l_theta)),
        np.zeros((steps, 2, l_theta)),
        np.zeros((steps, 2)),
    )
    for k in range(steps):
        z[k] = C @ x - command[k]
        theta[k] = now
        x = A @ x + B @ u[k]
        for i, N in enumerate(N_u):
            if k >= i:
                Phi_f[k] += N @ Phi[k - i]
                u_f[k] += N @ u[k - i]
        if k >= 1:
            Phi_f[k] -= D_u[0] @ Phi_f[k - 1]
            u_f[k] -= D_u[0] @ u_f[k - 1]
        if k + 1 >= k_0:
            F = Phi_f[k]
            gain = np.linalg.inv(lam * np.linalg.inv(R_z) + F @ P @ F.T)
            now = now - P @ F.T @ gain @ (F @ now + z[k] - u_f[k])
            P = (P - P @ F.T @ gain @ F @ P) / lam
        rows = [u[k + 1 - i] if k + 1 >= i else np.zeros(2) for i in range(1, n_c + 1)]
        rows += [z[k + 1 - i] if k + 1 >= i else np.zeros(2) for i in range(1, n_c + 1)]
        if k + 1 > n_c:
            Phi[k + 1] = np.kron(np.concatenate(rows), np.eye(2))
        if k + 1 >= k_0:
            u[k + 1] = Phi[k + 1] @ now
    return theta, z
