"""Two builds of the kernel side by side: an update, a step, a whole loop, eight loops in lock step.

    python benchmarks/two_kernels.py BEFORE.so AFTER.so [--rounds 31] [--plain]

A process for each build, which measure in turn; processor time, medians over the rounds. Where a
build lies after an install says `rcac_numeric.compiled._kernel.__file__`.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import statistics
import subprocess
import sys
import time

import numpy as np

SIZES = (4, 8, 10, 16, 20, 24, 32, 40)
KINDS = ("update", "step", "loop", "lanes")


def measurements(kind: str, l_theta: int):
    """A function that does `count` of them, and how many it does."""
    from rcac_numeric import (
        UD,
        Controller,
        ControllerSettings,
        fir_target,
        iir,
        simulate,
        standard_plant,
    )
    from rcac_numeric.compiled import _kernel as kernel

    rng = np.random.default_rng(0)
    plant = standard_plant("(q - 0.5)/(q*(q - 0.9))")
    settings = ControllerSettings(
        structure=iir(n_c=l_theta // 2),
        target=fir_target(plant),
        update=UD(R_theta=1.0 if kind == "loop" else 1e6),
    )
    if kind == "update":
        steps, repeat = 128, 8
        rows, target = rng.standard_normal((steps, 1, l_theta)), rng.standard_normal((steps, 1))
        start = {"P_0": np.eye(l_theta), "theta_0": np.zeros(l_theta)}
        weights = {"R_z": np.eye(1), "R_u": np.zeros((1, 1)), "forgetting": 0.999}
        return lambda: kernel.replay_updates(
            "ud", rows, target, **weights, **start, repeat=repeat
        ), steps * repeat
    if kind == "lanes":
        steps, repeat, lanes = 64, 4, kernel.lanes
        rows, target = (
            rng.standard_normal((steps, l_theta, lanes)),
            rng.standard_normal((steps, lanes)),
        )
        start = {"P_0": np.array([np.eye(l_theta)] * lanes), "theta_0": np.zeros((l_theta, lanes))}
        return lambda: kernel.replay_ud_lanes(rows, target, **start, repeat=repeat), (
            steps * repeat * lanes
        )
    if kind == "loop":
        w = rng.standard_normal((30_000, 1))
        return lambda: simulate(plant, settings, w, stride=len(w)), len(w)
    controller, data = (
        Controller(settings),
        [(float(x), float(x)) for x in rng.standard_normal(500)],
    )

    def steps_of_a_device() -> None:
        for y, z in data:
            controller.step(y, z)

    return steps_of_a_device, len(data)


def measure(path: str) -> None:
    """What a process does: a line "kind l_theta" in, nanoseconds out."""
    name = "rcac_numeric.compiled._kernel"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    sys.modules[name] = module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    times = {}
    for line in sys.stdin:
        kind, l_theta = line.split()
        if (kind, l_theta) not in times:
            times[kind, l_theta] = measurements(kind, int(l_theta))
            times[kind, l_theta][0]()
        run, count = times[kind, l_theta]
        start = time.process_time()
        run()
        print(1e9 * (time.process_time() - start) / count, flush=True)


def main() -> None:
    """Print nanoseconds of both and their ratio."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kernels", nargs=2, metavar="KERNEL")
    parser.add_argument("--rounds", type=int, default=31)
    parser.add_argument("--plain", action="store_true", help="with the instruction set plain")
    arguments = parser.parse_args()
    environment = {**os.environ, **({"RCAC_INSTRUCTION_SET": "plain"} if arguments.plain else {})}
    code = (
        f"import sys; sys.path[:0] = {sys.path!r}; import two_kernels; two_kernels.measure({{!r}})"
    )
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", code.format(path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
        )
        for path in arguments.kernels
    ]
    print("ns        " + "".join(f"{f'l = {l_theta}':>20}" for l_theta in SIZES))
    for kind in KINDS:
        cells = []
        for l_theta in SIZES:
            medians: list[list[float]] = [[], []]
            for _ in range(arguments.rounds):
                for process, times in zip(processes, medians, strict=True):
                    assert process.stdin is not None
                    assert process.stdout is not None
                    print(kind, l_theta, file=process.stdin, flush=True)
                    times.append(float(process.stdout.readline()))
            before, after = map(statistics.median, medians)
            ratio = statistics.median(a / b for a, b in zip(*medians, strict=True))
            cells.append(f"{before:7.0f}{after:6.0f}{ratio:6.2f}x")
        print(f"{kind:<10}" + "".join(cells), flush=True)
    for process in processes:
        process.communicate()


if __name__ == "__main__":
    main()
