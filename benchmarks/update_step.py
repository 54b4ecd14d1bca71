"""Time of one closed-loop RCAC step beside NumPy's and SciPy's, measured in one run.

Prints nanoseconds per step (median of several repetitions) and the ratio to the UD kernel, for
growing numbers of controller coefficients. Machines are noisy: read the ratios.

    python benchmarks/update_step.py [--steps 20000] [--repetitions 5]
"""

import argparse
import statistics
import time

import numpy as np
from scipy.linalg.blas import dsymv, dsyr

from rcac_numeric import ControllerSettings, fir_target, iir, simulate, standard_plant


def kernel(update, l_theta, steps):
    plant = standard_plant("(q - 0.5)/(q*(q - 0.9))")
    settings = ControllerSettings(
        structure=iir(l_theta // 2), target=fir_target(plant), R_theta=1.0, update=update
    )
    w = np.random.default_rng(0).standard_normal((steps, 1))
    start = time.perf_counter()
    simulate(plant, settings, w, stride=steps)
    return (time.perf_counter() - start) / steps


def numpy_text(l_theta, steps):
    """(2.43)-(2.45) as written, on random regressors."""
    phis = np.random.default_rng(0).standard_normal((steps, 1, l_theta))
    P, theta = np.eye(l_theta), np.zeros((l_theta, 1))
    start = time.perf_counter()
    for phi in phis:
        gain = P @ phi.T @ np.linalg.inv(1.0 + phi @ P @ phi.T)
        theta = theta - gain @ (phi @ theta + 0.1)
        P = P - gain @ phi @ P
    return (time.perf_counter() - start) / steps


def scipy_blas(l_theta, steps):
    """The update alone on one triangle with BLAS symv and syr."""
    phis = np.random.default_rng(0).standard_normal((steps, l_theta))
    P, theta = np.asfortranarray(np.eye(l_theta)), np.zeros(l_theta)
    start = time.perf_counter()
    for phi in phis:
        g = dsymv(1.0, P, phi)
        upsilon = 1.0 + phi @ g
        theta -= g * ((phi @ theta + 0.1) / upsilon)
        P = dsyr(-1.0 / upsilon, g, a=P, overwrite_a=True)
    return (time.perf_counter() - start) / steps


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=20_000)
    parser.add_argument("--repetitions", type=int, default=5)
    arguments = parser.parse_args()
    rows = {
        "UD, whole closed-loop step": lambda n, s: kernel("ud", n, s),
        "covariance, whole step": lambda n, s: kernel("covariance", n, s),
        "SciPy symv + syr, update": lambda n, s: scipy_blas(n, s // 10),
        "NumPy text, update": lambda n, s: numpy_text(n, s // 10),
    }
    print(f"{'ns per step (ratio to UD)':<28}" + "".join(f"{n:>16}" for n in SIZES))
    times = {name: {n: [] for n in SIZES} for name in rows}
    for _ in range(arguments.repetitions):
        for n in SIZES:
            for name, run in rows.items():
                times[name][n].append(run(n, arguments.steps))
    base = {n: statistics.median(times["UD, whole closed-loop step"][n]) for n in SIZES}
    for name in rows:
        cells = ((statistics.median(times[name][n]), base[n]) for n in SIZES)
        print(f"{name:<28}" + "".join(f"{t * 1e9:>9.0f} ({t / b:4.1f})" for t, b in cells))


SIZES = (10, 20, 40, 80, 160)

if __name__ == "__main__":
    main()
