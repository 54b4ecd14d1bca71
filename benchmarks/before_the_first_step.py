"""What a run costs beside its steps: before the first one, for its results, and for its cell.

The bars: 20 us before the first step at l_theta <= 20 and 30 us at 50, with lanes and without, and
100 us for a cell of a study that differs from another in a number. CPU time of one core, the least
of some repetitions for parts and the median for whole studies: the clock of a busy machine says
nothing.

    python benchmarks/before_the_first_step.py [--runs 10000] [--repetitions 3]
"""

import argparse
import os
import pickle
import statistics
import time

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np

from rcac_experiments.sweeps import Axis, Metric, Study
from rcac_experiments.sweeps._cells import Cells
from rcac_experiments.sweeps._chunk import ChunkTask
from rcac_experiments.sweeps._worker import run_chunk
from rcac_numeric import (
    UD,
    ControllerSettings,
    SimulationCase,
    WhiteNoise,
    exogenous,
    fir_target,
    iir,
    simulate_batch,
    simulate_many,
    simulate_stream,
    standard_plant,
)
from rcac_numeric.engine._jobs import PreparedRun
from rcac_numeric.engine._loops import PreparedLoops

G = "(q - 0.5)/(q*(q - 0.9))"
BASE = {
    "plant": {"problem": "standard", "G": G},
    "signals": {"w": {"white_noise": 1.0}},
    "target": {"model": "fir"},
    "controller": {"structure": "iir", "n_c": 4, "R_theta": 1.0},
    "run": {"steps": 2000},
}
ORDERS = (4, 10, 25)  # l_theta is twice that
BATCH = 512
# An axis, and its i-th value.
AXES = {
    "controller.R_theta": lambda i: 1 + i * 1e-3,
    "controller.lambda": lambda i: 1 - (i + 1) * 1e-5,
    "controller.k_w": lambda i: 5 + i,
    "signals.w.white_noise": lambda i: 1 + i * 1e-3,
    "run.steps": lambda i: 1000 + i,
    "plant.G": lambda i: f"(q - 0.5)/(q*(q - 0.9{i + 100001}))",
}


def least(work, count, repetitions=7):
    """The least CPU time of some repetitions, us for each of so many."""
    spent = []
    for _ in range(repetitions):
        start = time.process_time()
        work()
        spent.append(time.process_time() - start)
    return 1e6 * min(spent) / count


def before_the_first_step():
    """Runs of two steps: by what is asked of them, and what comes before the first step alone."""
    plant = standard_plant(G)
    print(
        "us a run beside its steps     before the first | simulate_many | simulate_stream, reduced"
    )
    for n_c in ORDERS:
        settings = ControllerSettings(
            structure=iir(n_c=n_c), target=fir_target(plant), update=UD(R_theta=1.0)
        )
        noise = [exogenous([WhiteNoise()], 2, seed) for seed in range(BATCH)]
        cases = [SimulationCase(plant, settings, w) for w in noise]

        def made(cases=cases):
            loops = PreparedLoops()
            for case in cases:
                run = PreparedRun(loops.of(case.plant, case.settings), case.w)
                run.make_ready()

        for lanes in (True, False):
            whole = least(lambda c=cases, n=lanes: simulate_many(c, threads=1, lanes=n), BATCH)
            stream = least(
                lambda c=cases, n=lanes: list(
                    simulate_stream(c, reduce=lambda number, run: 0.0, threads=1, lanes=n)
                ),
                BATCH,
            )
            words = "in lanes" if lanes else "alone"
            print(
                f"  l_theta = {2 * n_c:2d}, {words:8}       {least(made, BATCH):12.1f}    |"
                f" {whole:10.1f}    | {stream:10.1f}",
                flush=True,
            )


def batches():
    """Runs of equal length in arrays, with their first step and all others."""
    print("ns a step of simulate_batch, 256 runs of 2000 steps on one thread")
    plant, w = standard_plant(G), np.random.default_rng(0).standard_normal((256, 2000, 1))
    for n_c in ORDERS:
        settings = ControllerSettings(
            structure=iir(n_c=n_c), target=fir_target(plant), update=UD(R_theta=1.0)
        )
        spent = [
            1e3
            * least(
                lambda s=settings, n=lanes: simulate_batch(plant, s, w, threads=1, lanes=n), w.size
            )
            for lanes in (True, False)
        ]
        print(
            f"  l_theta = {2 * n_c:2d}: {spent[0]:.0f} in lanes, {spent[1]:.0f} alone", flush=True
        )


def cells():
    """Cells of a study, each made beside the one before it."""
    print("us a cell, by what its axis sets")
    for path, value in AXES.items():
        count = 10 if path == "plant.G" else 100
        study = Study(BASE, [Axis("x", [value(0), value(1)], sets=path)], [Metric("rms")])
        cells_of_study = Cells(study)
        cells_of_study.cell({"x": value(0)})
        numbers = iter(range(2, 10**9))

        def some(builder=cells_of_study, value=value, numbers=numbers, count=count):
            for _ in range(count):
                builder.cell({"x": value(next(numbers))})

        print(f"  {path:24} {least(some, count, 5):8.0f}", flush=True)


def chunks(runs, repetitions):
    """Chunks of a study with rms kept: many runs of two cells, and cells of one run."""
    print(f"us a run of 2000 steps, of {runs} in chunks of 256, rms kept; median of {repetitions}")
    for n_c in ORDERS:
        base = {**BASE, "controller": {**BASE["controller"], "n_c": n_c}}
        gains = [10.0 ** (8 * i / runs - 4) for i in range(runs)]
        many = Study(base, [Axis("x", [1.0, 10.0], sets="controller.R_theta")], [Metric("rms")])
        map_ = Study(base, [Axis("x", gains[:2], sets="controller.R_theta")], [Metric("rms")])
        times = {}
        for name, study, where in (
            ("two cells", many, lambda i: {"x": 1.0 + 9.0 * (i % 2)}),
            ("a map", map_, lambda i, gains=gains: {"x": gains[i]}),
        ):
            times[name] = statistics.median(chunked(study, where, runs) for _ in range(repetitions))
        print(
            f"  l_theta = {2 * n_c:2d}: "
            + ", ".join(f"{name} {1e6 * spent / runs:.0f}" for name, spent in times.items()),
            flush=True,
        )


def chunked(study, where, runs):
    """The CPU time of a worker that runs so many, each cell's runs side by side."""
    start = time.process_time()
    stored = pickle.dumps(study)
    for first in range(0, runs, 256):
        numbers = sorted(range(first, min(first + 256, runs)), key=lambda i: str(where(i)))
        by_cell = {}
        for i in numbers:
            by_cell.setdefault(str(where(i)), (where(i), []))[1].append((i, i))
        run_chunk(ChunkTask(stored, study.fingerprint, "", list(by_cell.values())))
    return time.process_time() - start


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=10_000)
    parser.add_argument("--repetitions", type=int, default=3)
    options = parser.parse_args()
    before_the_first_step()
    batches()
    cells()
    chunks(options.runs, options.repetitions)


if __name__ == "__main__":
    main()
