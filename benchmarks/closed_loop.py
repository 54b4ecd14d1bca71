"""The whole closed loop: its overhead over the update, NumPy, threads, lanes, memory, import.

Every pair is measured side by side in one run, alternating, and the median of the repetitions is
printed. Machines are noisy: read the ratios.

    python benchmarks/closed_loop.py [--repetitions 7]
"""

import argparse
import statistics
import subprocess
import sys
import time
import tracemalloc

from attrs import evolve
from update_step import dgemm  # first: it keeps NumPy to one thread

# isort: split
import numpy as np

from rcac_numeric import (
    UD,
    ControllerSettings,
    SimulationCase,
    fir_target,
    iir,
    simulate,
    simulate_many,
    standard_plant,
)

PLANT = standard_plant("(q - 0.5)/(q*(q - 0.9))")


def settings(l_theta):
    return ControllerSettings(
        structure=iir(l_theta // 2), target=fir_target(PLANT), update=UD(R_theta=1.0)
    )


def noise(steps, seed=0):
    return np.random.default_rng(seed).standard_normal((steps, 1))


def seconds(function):
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def side_by_side(repetitions, summary=statistics.median, **functions):
    """Median seconds of each (or another summary), the calls taking turns."""
    times = {name: [] for name in functions}
    for _ in range(repetitions):
        for name, function in functions.items():
            times[name].append(seconds(function))
    return {name: summary(values) for name, values in times.items()}


def overhead(repetitions):
    """The loop with and without its update: the difference is the update."""
    print("whole step and update alone (the loop without update subtracted)")
    for l_theta in (10, 20, 40, 80):
        with_update = settings(l_theta)
        without = evolve(with_update, k_update=10**9)
        w = noise(100_000)
        t = side_by_side(
            repetitions,
            whole=lambda s=with_update, w=w: simulate(PLANT, s, w, stride=len(w)),
            loop=lambda s=without, w=w: simulate(PLANT, s, w, stride=len(w)),
        )
        whole, update = t["whole"] / len(w), (t["whole"] - t["loop"]) / len(w)
        print(
            f"  l_theta = {l_theta:3d}: {whole * 1e9:7.0f} ns, update {update * 1e9:7.0f} ns, "
            f"whole / update = {whole / update:.2f}"
        )


def numpy_loop(l_theta, w):
    """The same loop in good NumPy: preallocated arrays, one BLAS call for each product."""
    n_c = l_theta // 2
    A, B, C = PLANT.A, PLANT.B[:, 0], PLANT.C[0]
    x, theta, P = np.zeros(PLANT.n), np.zeros(l_theta), np.eye(l_theta)
    phi, phi_before = np.zeros(l_theta), np.zeros(l_theta)
    z = np.empty(len(w))
    u_before = 0.0
    for k in range(len(w)):
        y = C @ x
        z[k] = y
        u = phi @ theta if k >= n_c else 0.0
        if k >= n_c:  # G_f = 1/q
            g = P @ phi_before
            upsilon = 1.0 + phi_before @ g
            theta -= g * ((phi_before @ theta + y - u_before) / upsilon)
            P -= np.multiply.outer(g / upsilon, g)
        x = A @ x + B * (u + w[k, 0])
        phi_before[:] = phi
        phi[1:n_c] = phi[: n_c - 1]
        phi[n_c + 1 :] = phi[n_c:-1]
        phi[0], phi[n_c], u_before = u, y, u
    return z


def beside_numpy(repetitions):
    l_theta, steps = 40, 100_000
    s, w, short = settings(l_theta), noise(steps), noise(steps)[: steps // 10]
    difference = np.abs(numpy_loop(l_theta, short)[:200] - simulate(PLANT, s, short).z[:200, 0])
    assert difference.max() < 1e-8, "the two loops must do the same"
    t = side_by_side(
        repetitions,
        kernel=lambda: simulate(PLANT, s, w, stride=steps),
        numpy=lambda: numpy_loop(l_theta, short),
    )
    ratio = t["numpy"] * 10 / t["kernel"]
    seconds_each = f"{t['kernel']:.3f} s, NumPy {t['numpy'] * 10:.2f} s"
    print(f"1e5 steps, n_c = 20: {seconds_each}: {ratio:.0f} times")


def threads(repetitions):
    for l_theta in (20, 80):
        cases = [
            SimulationCase(PLANT, settings(l_theta), noise(20_000, i), {"stride": 20_000})
            for i in range(32)
        ]
        t = side_by_side(
            repetitions,
            one=lambda c=cases: simulate_many(c, threads=1),
            two=lambda c=cases: simulate_many(c, threads=2),
        )
        rate = 3 * l_theta**2 * 32 * 20_000 / t["one"] / 1e9
        print(
            f"batch of 32 loops, l_theta = {l_theta}: one thread {rate:.1f} GFLOP/s "
            f"(3 l^2 a step), two threads {t['one'] / t['two']:.2f} times faster"
        )


def lanes(repetitions):
    """Batches in lanes beside those of the ordinary loop, preparation and records included.

    The best times: on a busy machine pauses weigh more in the longer of two measurements.
    """
    steps, count, rates = 50_000, 16, []
    for l_theta in (8, 20, 40):
        cases = [
            SimulationCase(PLANT, settings(l_theta), noise(steps, i), {"stride": steps})
            for i in range(count)
        ]
        t = side_by_side(
            repetitions,
            min,
            ordinary=lambda c=cases: simulate_many(c, threads=1),
            lanes=lambda c=cases: simulate_many(c, threads=1, lanes=True),
            two_threads=lambda c=cases: simulate_many(c, threads=2, lanes=True),
            dgemm=lambda: rates.append(dgemm()),
        )
        share = 3 * l_theta**2 * steps * count / t["lanes"] / max(rates)
        print(
            f"lanes, {count} loops, l_theta = {l_theta:2d}: "
            f"{1e9 * t['lanes'] / steps / count:.0f} ns a step and loop, "
            f"{t['ordinary'] / t['lanes']:.1f} times faster than one after another, "
            f"{100 * share:.0f} % of dgemm on one thread (3 l^2 a step; bar at 20: 65), "
            f"two threads {t['lanes'] / t['two_threads']:.2f} times faster"
        )


def memory():
    s, w = settings(20), noise(1_000_000)
    tracemalloc.start()
    run = simulate(PLANT, s, w, stride=1000)
    peak = tracemalloc.get_traced_memory()[1] + w.nbytes
    tracemalloc.stop()
    bytes_of_run = sum(a.nbytes for a in (run.w, run.u, run.y, run.z, run.theta))
    print(
        f"1e6 steps: {bytes_of_run / 1e6:.0f} MB kept, peak {peak / 1e6:.0f} MB: "
        f"{peak / bytes_of_run:.2f} times"
    )


def import_time():
    command = [sys.executable, "-c", "import rcac_numeric; rcac_numeric.simulate"]
    both = [seconds(lambda: subprocess.run(command, check=True)) for _ in range(5)]
    bare = [
        seconds(lambda: subprocess.run([sys.executable, "-c", ""], check=True)) for _ in range(5)
    ]
    spent = statistics.median(both) - statistics.median(bare)
    print(f"import rcac_numeric and its simulate: {spent:.2f} s")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repetitions", type=int, default=7)
    repetitions = parser.parse_args().repetitions
    overhead(repetitions)
    beside_numpy(repetitions)
    threads(repetitions)
    lanes(repetitions)
    memory()
    import_time()


if __name__ == "__main__":
    main()
