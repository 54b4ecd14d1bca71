"""Time of one step of the estimators beside filterpy's, and the price of a Python model.

"step" is one call of `Estimator.step` or `ModelRefinement.step`; "record" is a step inside
`estimate` or `refine`, which run the whole record in the kernel. filterpy's filters are given the
same model as NumPy functions, which is how it takes one. Everything is measured in turn, over and
over; only medians and ratios of one run mean anything.

    python benchmarks/estimation.py [--repetitions 9]
"""

import os

for library in ("OPENBLAS", "MKL", "OMP", "VECLIB_MAXIMUM"):  # before NumPy reads them
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

import argparse
import statistics
import time
import warnings

import numpy as np
import sympy

from rcac_numeric.estimation import (
    EKF,
    IMM,
    RCMR,
    UKF,
    AdaptiveNoises,
    Estimator,
    LinearModel,
    ModelRefinement,
    NonlinearModel,
    SymbolicModel,
    estimate,
    refine,
)

H, STEPS, RECORDS = 0.05, 400, 100
NOISE = {"Q": 1e-5, "R": 1e-3, "P_0": 0.1}
RNG = np.random.default_rng(0)
U, Y = RNG.standard_normal((STEPS, 1)), 0.1 * RNG.standard_normal((STEPS, 1))


def pendulum(k, x, u):
    return np.array([x[0] + H * x[1], x[1] + H * (u[0] - 0.4 * x[1] - 9.81 * np.sin(x[0]))])


def angle(k, x, u):
    return x[:1]


def pendulum_jacobian(k, x, u):
    return np.array([[1.0, H], [-9.81 * H * np.cos(x[0]), 1 - 0.4 * H]])


def angle_jacobian(k, x, u):
    return np.array([[1.0, 0.0]])


theta, omega, torque = sympy.symbols("theta omega u")
SYMPY = SymbolicModel(
    [theta + H * omega, omega + H * (torque - 0.4 * omega - 9.81 * sympy.sin(theta))],
    [theta],
    [theta, omega],
    [torque],
)
LINEAR = LinearModel(A=[[1, H], [-9.81 * H, 1 - 0.4 * H]], B=[[0], [H]], C=[[1, 0]])
PYTHON = NonlinearModel(
    pendulum, angle, 2, 1, 1, dynamics_jacobian=pendulum_jacobian, output_jacobian=angle_jacobian
)
DIFFERENCES = NonlinearModel(pendulum, angle, 2, 1, 1)


def linear(k, x, u):
    return LINEAR.A @ x + LINEAR.B @ u


def by_steps(settings):
    estimator = Estimator(settings)

    def run():
        for k in range(STEPS):
            estimator.step(Y[k], U[k])

    return run


def by_record(settings):
    """With what it takes to compile the model, over a record that is long enough for that."""
    y, u = np.tile(Y, (RECORDS, 1)), np.tile(U, (RECORDS, 1))

    def run():
        estimate(settings, y, u)

    return run


def filterpy_linear():
    from filterpy.kalman import KalmanFilter

    other = KalmanFilter(dim_x=2, dim_z=1, dim_u=1)
    other.F, other.B, other.H = LINEAR.A, LINEAR.B, LINEAR.C
    other.x, other.P, other.Q, other.R = np.zeros(2), 0.1 * np.eye(2), 1e-5 * np.eye(2), 1e-3
    for k in range(STEPS):
        other.update(Y[k])
        other.predict(U[k])


def filterpy_extended():
    from filterpy.kalman import ExtendedKalmanFilter

    class Filter(ExtendedKalmanFilter):
        def predict_x(self, u=0):
            self.x = pendulum(0, self.x, u)

    other = Filter(dim_x=2, dim_z=1)
    other.x, other.P, other.Q, other.R = np.zeros(2), 0.1 * np.eye(2), 1e-5 * np.eye(2), 1e-3
    for k in range(STEPS):
        other.update(Y[k], lambda x: angle_jacobian(0, x, None), lambda x: angle(0, x, None))
        other.F = pendulum_jacobian(k, other.x, U[k])
        other.predict(U[k])


def filterpy_unscented(dynamics):
    from filterpy.kalman import JulierSigmaPoints, UnscentedKalmanFilter

    def run():
        points = JulierSigmaPoints(n=2, kappa=1.0)
        other = UnscentedKalmanFilter(
            dim_x=2, dim_z=1, dt=1, points=points, hx=lambda x: x[:1],
            fx=lambda x, dt, u: dynamics(0, x, u),
        )  # fmt: skip
        other.P, other.Q, other.R = 0.1 * np.eye(2), 1e-5 * np.eye(2), 1e-3 * np.eye(1)
        for k in range(STEPS):
            other.predict(u=U[k])
            other.update(Y[k])

    return run


def filterpy_interacting():
    from filterpy.kalman import IMMEstimator, KalmanFilter

    filters = []
    for _ in range(2):
        other = KalmanFilter(dim_x=2, dim_z=1, dim_u=1)
        other.F, other.B, other.H = LINEAR.A, LINEAR.B, LINEAR.C
        other.x, other.P, other.Q, other.R = np.zeros(2), 0.1 * np.eye(2), 1e-5 * np.eye(2), 1e-3
        filters.append(other)
    both = IMMEstimator(filters, [0.5, 0.5], CHAIN)
    for k in range(STEPS):
        both.update(Y[k])
        both.predict(U[k])


CHAIN = np.array([[0.9, 0.1], [0.1, 0.9]])
JUMPS = IMM([EKF(LINEAR, **NOISE)] * 2, CHAIN)
LEARNS = AdaptiveNoises(EKF(LINEAR, **NOISE), iterations=1, diagonal=True)
SPRING = RCMR(A=[[1, 0.1], [0, 0.5]], B=[0, -0.1], D_1=[0, 0.1], C=[0, 1], E_1=[1, 0])


REFINEMENT = ModelRefinement(SPRING)


def refinement_by_steps():
    for k in range(STEPS):
        REFINEMENT.step(U[k], Y[k])


def refinement_by_record():
    refine(SPRING, np.tile(U, (RECORDS, 1)), np.tile(Y, (RECORDS, 1)))


RUNS = {
    ("Kalman, linear", "filterpy"): filterpy_linear,
    ("Kalman, linear", "step"): by_steps(EKF(LINEAR, **NOISE)),
    ("Kalman, linear", "record"): by_record(EKF(LINEAR, **NOISE)),
    ("Kalman, linear", "learning, record"): by_record(LEARNS),
    ("IMM of two, linear", "filterpy"): filterpy_interacting,
    ("IMM of two, linear", "step"): by_steps(JUMPS),
    ("IMM of two, linear", "record"): by_record(JUMPS),
    ("EKF, pendulum", "filterpy"): filterpy_extended,
    ("EKF, pendulum", "SymPy, step"): by_steps(EKF(SYMPY, **NOISE)),
    ("EKF, pendulum", "SymPy, record"): by_record(EKF(SYMPY, **NOISE)),
    ("EKF, pendulum", "Python, step"): by_steps(EKF(PYTHON, **NOISE)),
    ("EKF, pendulum", "Python, no Jacobians, step"): by_steps(EKF(DIFFERENCES, **NOISE)),
    ("UKF, linear", "filterpy"): filterpy_unscented(linear),
    ("UKF, linear", "step"): by_steps(UKF(LINEAR, **NOISE)),
    ("UKF, linear", "record"): by_record(UKF(LINEAR, **NOISE)),
    ("UKF, pendulum", "filterpy"): filterpy_unscented(pendulum),
    ("UKF, pendulum", "SymPy, step"): by_steps(UKF(SYMPY, **NOISE)),
    ("UKF, pendulum", "SymPy, record"): by_record(UKF(SYMPY, **NOISE)),
    ("UKF, pendulum", "Python, step"): by_steps(UKF(PYTHON, **NOISE)),
    ("RCMR, one parameter", "filterpy's EKF"): filterpy_extended,
    ("RCMR, one parameter", "step"): refinement_by_steps,
    ("RCMR, one parameter", "record"): refinement_by_record,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repetitions", type=int, default=9)
    repetitions = parser.parse_args().repetitions
    warnings.simplefilter("ignore")
    times = {name: [] for name in RUNS}
    for _ in range(repetitions):
        for name, run in RUNS.items():
            start = time.perf_counter()
            run()
            steps = STEPS * (RECORDS if name[1].endswith("record") else 1)
            times[name].append((time.perf_counter() - start) / steps)
    yardstick = 0.0
    for (case, name), values in times.items():
        median = statistics.median(values)
        if name.startswith("filterpy"):
            yardstick = median
        print(f"{case:20} {name:28} {1e6 * median:8.2f} us {yardstick / median:7.1f} x")


if __name__ == "__main__":
    main()
