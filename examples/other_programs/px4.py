"""The update of the RCAC class of the PX4 forks in NumPy, for docs/coming-from/px4.md.

The plant is the roll rate of an airframe, p(k+1) = 0.9 p(k) + 0.2 u(k-1) + disturbance.
"""

import numpy as np

steps, N, P0 = 600, 0.2, 10.0
command = np.where(np.arange(steps) % 300 < 150, 0.5, -0.5)  # rad/s
disturbance = 0.05 + 0.01 * np.random.default_rng(0).standard_normal(steps)


def loop(controller):
    """Theta and z of every step; the controller gets z(k) and gives u(k) and theta."""
    p, last, z, theta = 0.0, 0.0, np.zeros(steps), np.zeros((steps, 3))
    for k in range(steps):
        z[k] = p - command[k]
        u, theta[k] = controller(k, z[k])
        p, last = 0.9 * p + 0.2 * last + disturbance[k], u
    return theta, z


def theirs(R_u=0.0, lam=1.0, f=lambda z: z, clamp=np.inf):
    """Theta and z of a run with the settings of the class."""
    P, now, phis, us, sums = (
        P0 * np.eye(3),
        np.zeros(3),
        np.zeros((3, 3)),
        [0.0, 0.0],
        [0.0, 0.0],
    )

    def controller(k, z):
        nonlocal P, now, phis
        phis = np.vstack([[z, sums[0], z - sums[1]], phis[:2]])  # Phi(k), Phi(k-1), Phi(k-2)
        phi_f, u_f = N * phis[2], N * us[1]
        if k >= 4:
            rows = np.vstack([phi_f, phis[0]]) if R_u else phi_f[None]
            weights = np.diag([lam, 1 / R_u]) if R_u else np.eye(1) * lam
            P = (P - P @ rows.T @ np.linalg.inv(weights + rows @ P @ rows.T) @ rows @ P) / lam
            now = now - P @ phi_f * (f(z) + phi_f @ now - u_f) - P @ phis[0] * R_u * (phis[0] @ now)
        u = phis[0] @ now
        us[:], sums[:] = [u, us[0]], [float(np.clip(sums[0] + z, -clamp, clamp)), z]
        return u, now

    return loop(controller)
