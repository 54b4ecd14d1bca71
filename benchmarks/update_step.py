"""Time of one update of l_theta coefficients beside the machine's limit and other programs'.

The yardstick is NumPy's product of two 1024 x 1024 matrices on one thread. An update counts
3 l^2 operations, the fewest that any form needs. Machines are noisy: everything is measured in
turn, over and over, and only medians and ratios of one run mean anything.

    python benchmarks/update_step.py [--repetitions 15] [--seconds 0.01]
"""

import os

for library in ("OPENBLAS", "MKL", "OMP", "VECLIB_MAXIMUM"):  # before NumPy reads them
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

import argparse
import statistics
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from scipy.linalg.blas import dsymv, dsyr
from yardsticks import symmetric_covariance

from rcac_numeric.compiled import _kernel

SIZES = (10, 20, 40, 80, 160)
LANE_SIZES = (10, 20, 40)
STEPS = 8  # rows in a record: few, as in a closed loop the row is always in the nearest cache


def clock(run, operations_guess, seconds):
    """Seconds per pass of run(passes), the cost of the call itself taken off."""
    passes = max(2, round(seconds / operations_guess))
    start = time.perf_counter()
    run(1)
    middle = time.perf_counter()
    run(passes + 1)
    return (time.perf_counter() - 2 * middle + start) / passes


def dgemm():
    """Operations per second of NumPy's product of two matrices."""
    a, b = np.random.default_rng(0).standard_normal((2, 1024, 1024))
    start = time.perf_counter()
    a @ b
    return 2 * 1024**3 / (time.perf_counter() - start)


def kernel(update, l_theta, seconds):
    """Seconds per update in the compiled kernel, or in the compiled yardstick."""
    rng = np.random.default_rng(0)
    rows, target = rng.standard_normal((STEPS, 1, l_theta)), rng.standard_normal((STEPS, 1))
    start = {"P_0": np.eye(l_theta), "theta_0": np.zeros(l_theta)}
    weights = {"R_z": np.eye(1), "R_u": np.zeros((1, 1))}

    def run(passes):
        if update == "symmetric covariance":
            symmetric_covariance.replay(rows[:, 0], target[:, 0], **start, repeat=passes)
        else:
            _kernel.replay_updates(update, rows, target, **weights, **start, repeat=passes)

    return clock(run, STEPS * (5e-8 + 1e-10 * l_theta**2), seconds) / STEPS


def lanes(l_theta, seconds, threads=1):
    """Seconds per update and lane; with several threads the time for all of them over all."""
    rng, count = np.random.default_rng(0), _kernel.lanes
    rows = rng.standard_normal((STEPS, l_theta, count))
    target = rng.standard_normal((STEPS, count))
    start = {"P_0": np.array([np.eye(l_theta)] * count), "theta_0": np.zeros((l_theta, count))}

    def one(passes):
        _kernel.replay_ud_lanes(rows, target, **start, repeat=passes)

    with ThreadPoolExecutor(threads) as pool:
        run = one if threads == 1 else lambda passes: list(pool.map(one, [passes] * threads))
        guess = STEPS * count * (1e-8 + 1e-10 * l_theta**2)
        return clock(run, guess, seconds) / (STEPS * count * threads)


def from_python(adapt, l_theta, seconds):
    """Seconds per update of a Python function of (regressor, target)."""
    rng = np.random.default_rng(0)
    rows, target = rng.standard_normal((STEPS, l_theta)), rng.standard_normal(STEPS)

    def run(passes):
        for _ in range(passes):
            for phi, value in zip(rows, target, strict=True):
                adapt(phi, value)

    return clock(run, STEPS * 2e-5, seconds) / STEPS


def scipy_blas(l_theta):
    """One triangle with BLAS symv and syr."""
    P, theta = np.asfortranarray(np.eye(l_theta)), np.zeros(l_theta)

    def adapt(phi, value):
        nonlocal P, theta
        g = dsymv(1.0, P, phi)
        upsilon = 1.0 + phi @ g
        theta -= g * ((phi @ theta + value) / upsilon)
        P = dsyr(-1.0 / upsilon, g, a=P, overwrite_a=True)

    return adapt


def numpy_tidy(l_theta):
    """P phi once, one outer product."""
    P, theta = np.eye(l_theta), np.zeros(l_theta)

    def adapt(phi, value):
        nonlocal P, theta
        g = P @ phi
        upsilon = 1.0 + phi @ g
        theta -= g * ((phi @ theta + value) / upsilon)
        P -= np.outer(g / upsilon, g)

    return adapt


def numpy_text(l_theta):
    """(2.43)-(2.45) as printed."""
    P, theta = np.eye(l_theta), np.zeros((l_theta, 1))

    def adapt(phi, value):
        nonlocal P, theta
        phi = phi[None, :]
        gain = P @ phi.T @ np.linalg.inv(1.0 + phi @ P @ phi.T)
        theta = theta - gain @ (phi @ theta + value)
        P = P - gain @ phi @ P

    return adapt


def padasip_rls(l_theta):
    """FilterRLS of padasip."""
    try:
        from padasip.filters import FilterRLS
    except ImportError as missing:
        raise SystemExit("padasip is one of the yardsticks: pip install padasip") from missing
    rls = FilterRLS(n=l_theta, mu=0.99999, eps=1.0)
    return lambda phi, value: rls.adapt(value, phi)


OTHERS = {
    "SciPy symv + syr": scipy_blas,
    "NumPy, tidy": numpy_tidy,
    "NumPy, as printed": numpy_text,
    "padasip FilterRLS": padasip_rls,
}
KERNELS = ("ud", "symmetric covariance", "covariance")


def measure(repetitions, seconds):
    """Medians of everything, each measured once per repetition."""
    times = {}
    for _ in range(repetitions):
        times.setdefault("dgemm", []).append(dgemm())
        for l_theta in SIZES:
            for update in KERNELS:
                times.setdefault((update, l_theta), []).append(kernel(update, l_theta, seconds))
            for name, make in OTHERS.items():
                time_ = from_python(make(l_theta), l_theta, seconds)
                times.setdefault((name, l_theta), []).append(time_)
        for l_theta in LANE_SIZES:
            for threads in (1, 2):
                time_ = lanes(l_theta, seconds, threads)
                times.setdefault((f"lanes, {threads}", l_theta), []).append(time_)
    return {name: statistics.median(times) for name, times in times.items()}


def table(title, rows, sizes):
    """Print rows of (name, format, value of l_theta)."""
    print(f"\n{title:<44}" + "".join(f"{l_theta:>10}" for l_theta in sizes))
    for name, style, value in rows:
        print(f"{name:<44}" + "".join(f"{value(l_theta):>10{style}}" for l_theta in sizes))


def report(t):
    """The tables, and the project's bars with what was found."""
    rate, ud = t["dgemm"], lambda n: t["ud", n]

    def share(part, n):
        return 300 * n**2 / t[part, n] / rate

    def nanoseconds(phase):
        return lambda n: 1e9 * t[phase, n]

    chosen = _kernel.instruction_sets()[0]
    print(f"dgemm, n = 1024: {rate / 1e9:.1f} GFLOP/s; instruction set: {chosen}")
    rows = [
        ("UD, ns", ".0f", nanoseconds("ud")),
        ("UD, GFLOP/s by 3 l^2", ".1f", lambda n: 3e-9 * n**2 / ud(n)),
        ("UD, % of dgemm", ".1f", lambda n: share("ud", n)),
        ("symmetric covariance, ns", ".0f", nanoseconds("symmetric covariance")),
        ("UD / symmetric covariance", ".2f", lambda n: ud(n) / t["symmetric covariance", n]),
        ("covariance as printed, compiled / UD", ".1f", lambda n: t["covariance", n] / ud(n)),
    ]
    table("one update, one thread", rows, SIZES)
    rows = [(name + " / UD", ".1f", lambda n, name=name: t[name, n] / ud(n)) for name in OTHERS]
    table("called from Python", rows, SIZES)
    rows = [("one thread, ns per lane", ".1f", nanoseconds("lanes, 1"))]
    rows += [("one thread, % of dgemm", ".1f", lambda n: share("lanes, 1", n))]
    rows += [("two threads, % of dgemm", ".1f", lambda n: share("lanes, 2", n))]
    rows += [("two threads over one", ".2f", lambda n: t["lanes, 1", n] / t["lanes, 2", n])]
    rows += [("one run after another / lanes", ".1f", lambda n: ud(n) / t["lanes, 1", n])]
    table(f"{_kernel.lanes} runs in lock step", rows, LANE_SIZES)
    bars = [
        ("UD at l = 80, % of dgemm", share("ud", 80), 65),
        ("UD at l = 160, % of dgemm", share("ud", 160), 65),
        ("UD at l = 20, % of dgemm", share("ud", 20), 20),
        ("lanes at l = 20, % of dgemm", share("lanes, 1", 20), 65),
        ("symmetric covariance / UD at l = 80", t["symmetric covariance", 80] / ud(80), 1 / 1.5),
        ("SciPy symv + syr / UD at l = 80", t["SciPy symv + syr", 80] / ud(80), 12),
        ("padasip / UD at l = 80", t["padasip FilterRLS", 80] / ud(80), 100),
    ]
    print()
    for name, value, bar in bars:
        print(f"{name:<44}{value:>10.2f}, bar {bar:.3g}: {'met' if value >= bar else 'NOT met'}")


def main():
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repetitions", type=int, default=15)
    parser.add_argument("--seconds", type=float, default=0.01, help="of each measurement")
    arguments = parser.parse_args()
    report(measure(arguments.repetitions, arguments.seconds))


if __name__ == "__main__":
    main()
