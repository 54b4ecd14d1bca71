"""Textbook transcriptions of the Kalman, extended and unscented filters, in plain NumPy."""

import numpy as np


def kalman(A, B, C, D, Q, R, x, P, y, u):
    """x(k|k) and P(k|k) by the covariance formulas (Simon 2006, section 5.1)."""
    xs, Ps = [], []
    for k in range(len(y)):
        S = C @ P @ C.T + R
        K = P @ C.T @ np.linalg.inv(S)
        x = x + K @ (y[k] - C @ x - D @ u[k])
        P = (np.eye(len(x)) - K @ C) @ P
        xs.append(x)
        Ps.append(P)
        x, P = A @ x + B @ u[k], A @ P @ A.T + Q
    return np.array(xs), np.array(Ps)


def extended(f, F, h, H, Q, R, x, P, y, u):
    """The same with Jacobians at the estimates."""
    xs, Ps = [], []
    for k in range(len(y)):
        C = H(k, x, u[k])
        S = C @ P @ C.T + R
        K = P @ C.T @ np.linalg.inv(S)
        x = x + K @ (y[k] - h(k, x, u[k]))
        P = (np.eye(len(x)) - K @ C) @ P
        xs.append(x)
        Ps.append(P)
        A = F(k, x, u[k])
        x, P = f(k, x, u[k]), A @ P @ A.T + Q
    return np.array(xs), np.array(Ps)


def unscented(f, h, Q, R, x, P, y, u, alpha, redrawn=True):
    """(8.9)-(8.24) with the weights and signs corrected; `redrawn`: the points after adding Q."""
    n = len(x)
    gamma = np.array([(alpha - n) / alpha] + [1 / (2 * alpha)] * (2 * n))

    def points(x, P):
        S = np.sqrt(alpha) * np.linalg.cholesky(P)
        return np.vstack([x, x + S.T, x - S.T])

    xs, Ps, X = [], [], points(x, P)
    for k in range(len(y)):
        Y = np.array([h(k, point, u[k]) for point in X])
        mean = gamma @ Y
        P_yy = (gamma * (Y - mean).T) @ (Y - mean) + R
        P_xy = (gamma * (X - x).T) @ (Y - mean)
        K = P_xy @ np.linalg.inv(P_yy)
        x, P = x + K @ (y[k] - mean), P - K @ P_yy @ K.T
        xs.append(x)
        Ps.append(P)
        X = np.array([f(k, point, u[k]) for point in points(x, P)])
        x = gamma @ X
        P = (gamma * (X - x).T) @ (X - x) + Q
        if redrawn:
            X = points(x, P)
    return np.array(xs), np.array(Ps)
