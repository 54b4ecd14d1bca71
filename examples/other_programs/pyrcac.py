"""The update of PyRCAC in NumPy, from (2.42)-(2.45), for docs/coming-from/pyrcac.md.

The plant is x(k+1) = A x(k) + B u(k), the command a step with noise.
"""

import numpy as np

A, B, C = np.array([[0.4, 0.3], [0.1, 0.7]]), np.array([0.0, 1.0]), np.array([1.0, 0.0])
steps, n_c, GfRD, Nu = 500, 4, 2, [0.3]  # C B = 0 and C A B = 0.3: relative degree 2
command = np.where(np.arange(steps) < 250, 1.0, 2.0) + 0.05 * np.random.default_rng(
    0
).standard_normal(steps)


def theirs(R0):
    """Theta, whose row k made u(k), and z of a run: dense, RegZ = 1, Integrator = 1."""
    l_theta = 2 * n_c + 1
    P, now, x = np.eye(l_theta) / R0, np.zeros(l_theta), np.zeros(2)
    u, z, phi, theta = (
        np.zeros(steps),
        np.zeros(steps),
        np.zeros((steps, l_theta)),
        np.zeros((steps, l_theta)),
    )

    def past(s, k, i):
        return s[k - i] if k >= i else 0 * s[0]

    for k in range(steps):
        z[k] = C @ x - command[k]
        phi[k] = (
            [past(u, k, i) for i in range(1, n_c + 1)]
            + [past(z, k, i) for i in range(1, n_c + 1)]
            + [z[:k].sum()]
        )
        theta[k] = now
        if k > max(l_theta, len(Nu)):
            u[k] = phi[k] @ now
        x = A @ x + B * u[k]
        if k >= max(l_theta, len(Nu)):
            phi_f = sum(N * past(phi, k, GfRD + i) for i, N in enumerate(Nu))
            u_f = sum(N * past(u, k, GfRD + i) for i, N in enumerate(Nu))
            P = P - np.outer(P @ phi_f, P @ phi_f) / (1 + phi_f @ P @ phi_f)
            now = now - P @ phi_f * (z[k] + phi_f @ now - u_f)
    return theta, z
