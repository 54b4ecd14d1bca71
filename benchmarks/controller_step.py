"""What one step of `Controller` costs, beside its kernel alone and NumPy loops that do the same.

Run with: python benchmarks/controller_step.py [STEPS]

Four contestants take the same measurements in turn, in one process, and the medians over rounds are
compared: `Controller.step`; the kernel's own step, called as `Controller` calls it, so that the
difference is what the checks cost; a tidy NumPy loop of (2.28)-(2.46); and the matrix form that
users of PyRCAC write, with Kronecker products and an explicit inverse. theta of all is compared at
the end. Processor time is counted, so that what else runs on the machine is not.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections import deque

import numpy as np

from rcac_numeric import Controller, ControllerSettings, Covariance, TargetModel, iir

ORDERS = (5, 10, 20, 40)  # n_c; l_theta is twice that
ROUNDS = 15
R_THETA = 1e6  # theta stays small: what is fed back here is no loop


class Tidy:
    """RCAC for scalar signals with G_f = 1/q: arrays allocated once, no Kronecker product."""

    def __init__(self, n_c: int) -> None:
        self.n_c, self.k = n_c, 0
        self.theta, self.P = np.zeros(2 * n_c), np.eye(2 * n_c) / R_THETA
        self.phi, self.phi_f, self.u_f = np.zeros(2 * n_c), np.zeros(2 * n_c), 0.0

    def step(self, y: float, z: float) -> float:
        """One step: u(k) from theta(k), then theta(k+1)."""
        phi, n_c = self.phi, self.n_c
        u = float(phi @ self.theta) if self.k >= n_c else 0.0
        if self.k >= n_c:
            v = self.P @ self.phi_f
            error = z - self.u_f + float(self.phi_f @ self.theta)
            gain = v / (1.0 + float(self.phi_f @ v))
            self.theta = self.theta - gain * error
            self.P -= np.outer(gain, v)
        self.phi_f, self.u_f = phi.copy(), u
        phi[1:n_c], phi[n_c + 1 :] = phi[: n_c - 1].copy(), phi[n_c:-1].copy()
        phi[0], phi[n_c] = u, y
        self.k += 1
        return u


class MatrixForm:
    """The same as the text writes it, for any number of signals: Phi, (2.42)-(2.45), an inverse."""

    def __init__(self, n_c: int) -> None:
        self.n_c, self.k = n_c, 0
        self.theta, self.P = np.zeros((2 * n_c, 1)), np.eye(2 * n_c) / R_THETA
        self.u = deque([np.zeros((1, 1))] * n_c, maxlen=n_c)
        self.y = deque([np.zeros((1, 1))] * n_c, maxlen=n_c)
        self.Phi_f, self.u_f = np.zeros((1, 2 * n_c)), np.zeros((1, 1))
        self.N = np.ones((1, 1))

    def step(self, y: float, z: float) -> float:
        """One step: u(k) from theta(k), then theta(k+1)."""
        phi = np.vstack([*self.u, *self.y])
        Phi = np.kron(phi.T, np.eye(1))
        u = Phi @ self.theta if self.k >= self.n_c else np.zeros((1, 1))
        if self.k >= self.n_c:
            Gamma = np.linalg.inv(np.eye(1) + self.Phi_f @ self.P @ self.Phi_f.T)
            self.P = self.P - self.P @ self.Phi_f.T @ Gamma @ self.Phi_f @ self.P
            z_hat = np.array([[z]]) - self.u_f + self.Phi_f @ self.theta
            self.theta = self.theta - self.P @ self.Phi_f.T @ z_hat
        self.Phi_f, self.u_f = self.N @ Phi, self.N @ u
        self.u.appendleft(u)
        self.y.appendleft(np.array([[y]]))
        self.k += 1
        return float(u[0, 0])


def contestants(n_c: int) -> dict[str, object]:
    """The four, each ready to start."""
    settings = ControllerSettings(
        structure=iir(n_c=n_c), target=TargetModel([0.0, 1.0]), update=Covariance(R_theta=R_THETA)
    )
    return {
        "Controller.step": Controller(settings),
        "kernel alone": Controller(settings)._kernel,
        "tidy NumPy": Tidy(n_c),
        "matrix form": MatrixForm(n_c),
    }


def microseconds(one: object, data: np.ndarray, kernel: bool) -> float:
    """The time of a step over these measurements."""
    step = one.step
    pairs = [(float(y), float(z)) for y, z in data]
    start = time.thread_time()
    if kernel:
        for y, z in pairs:
            step(y, z, None, None)
    else:
        for y, z in pairs:
            step(y, z)
    return (time.thread_time() - start) / len(pairs) * 1e6


def main() -> None:
    """Print the table."""
    steps = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    print(f"us per step, median of {ROUNDS} rounds of {steps} steps in turn")
    names = list(contestants(1))
    print("l_theta  " + "  ".join(f"{name:>15}" for name in names) + "   checks  worst theta")
    for n_c in ORDERS:
        rng = np.random.default_rng(n_c)
        contestants_by_name = contestants(n_c)
        times: dict[str, list[float]] = {name: [] for name in names}
        for _ in range(ROUNDS):
            data = rng.standard_normal((steps, 2))
            for name in names:
                times[name].append(
                    microseconds(contestants_by_name[name], data, name == "kernel alone")
                )
        medians = {name: statistics.median(values) for name, values in times.items()}
        checks = statistics.median(
            a - b for a, b in zip(times[names[0]], times[names[1]], strict=True)
        )
        thetas = [np.ravel(one.theta) for one in contestants_by_name.values()]
        worst = max(np.abs(theta - thetas[0]).max() for theta in thetas) / np.abs(thetas[0]).max()
        print(f"{2 * n_c:7d}  " + "  ".join(f"{medians[name]:15.2f}" for name in names)
              + f"  {checks:7.2f}  {worst:.1e}")  # fmt: skip


if __name__ == "__main__":
    main()
