"""Studies: CPU and wall time of a run, what executor and store add, memory, answer to Ctrl-C.

The bars: 1e5 runs of 2000 steps at l_theta = 20 in 180 s on two cores, executor and store under
10 % of that, memory under 500 MB however many runs there are, Ctrl-C answered within 0.5 s. On a
busy machine read the CPU times.

    python benchmarks/sweeps.py [--runs 20000] [--repetitions 3] [--workers 2]
"""

import argparse
import os
import resource
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

from rcac_experiments.sweeps import (
    Axis,
    Metric,
    Study,
    check_store,
    read_table,
    run_study,
)
from rcac_experiments.sweeps import _coordinator as coordinator
from rcac_experiments.sweeps._folder import Folder
from rcac_experiments.sweeps._table import table_in
from rcac_experiments.sweeps._worker import run_chunk
from rcac_numeric import UD, ControllerSettings, FunctionPlant, SimulationCase, TargetModel, iir

BASE = {
    "plant": {"problem": "standard", "G": "(q - 0.5)/(q*(q - 0.9))"},
    "signals": {"w": {"white_noise": 1.0}},
    "target": {"model": "fir"},
    "controller": {"structure": "iir", "n_c": 10, "R_theta": 1.0},
    "run": {"steps": 2000},
}
KEEP = [Metric("rms"), Metric("peak", "late", {"start": 1900}), Metric("settling_step")]
R_THETA = [10.0**e for e in range(-4, 4)]


def study(runs, keep=tuple(KEEP), steps=2000, n_c=10):
    base = {
        **BASE,
        "run": {"steps": steps},
        "controller": {**BASE["controller"], "n_c": n_c},
    }
    axis = Axis("R_theta", R_THETA, sets="controller.R_theta")
    return Study(base, [axis], keep, repetitions=-(-runs // len(R_THETA)), seed=1)


def cpu(who=resource.RUSAGE_SELF):
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


def in_one_process(runs, repetitions):
    """CPU of a whole study, and of its chunks alone; the rest is the trial, executor and store.

    What is done once is left out by the difference of two sizes.
    """
    added, inside = [], []
    spent = 0.0

    def timed(task, **options):
        nonlocal spent
        start = time.process_time()
        result = run_chunk(task, **options)
        spent += time.process_time() - start
        return result

    def cost(count):
        nonlocal spent
        spent, start = 0.0, time.process_time()
        with tempfile.TemporaryDirectory() as folder:
            run_study(study(count), Path(folder) / "store", workers=0)
        return time.process_time() - start, spent

    coordinator.run_chunk = timed
    for _ in range(repetitions):
        (few, few_inside), (many, many_inside) = cost(runs // 5), cost(runs)
        chunks = (many_inside - few_inside) / (runs - runs // 5)
        inside.append(1e6 * chunks)
        added.append(1e6 * (many - few) / (runs - runs // 5) - 1e6 * chunks)
    coordinator.run_chunk = run_chunk
    engine, rest = statistics.median(inside), statistics.median(added)
    print(
        f"one process: {engine:.0f} us of CPU a run in the chunks; executor and store add "
        f"{rest:.1f} us, {100 * rest / engine:.1f} % (bar: 10)"
    )


def over_processes(runs, repetitions, workers):
    walls, cpus = [], []
    for _ in range(repetitions):
        before, start = cpu(resource.RUSAGE_CHILDREN) + cpu(), time.perf_counter()
        with tempfile.TemporaryDirectory() as folder:
            run_study(study(runs), Path(folder) / "store", workers=workers)
            files = (Path(folder) / "store" / "chunks").iterdir()
            size = sum(file.stat().st_size for file in files)
        walls.append(time.perf_counter() - start)
        cpus.append(cpu(resource.RUSAGE_CHILDREN) + cpu() - before)
    wall, used = statistics.median(walls), statistics.median(cpus)
    print(
        f"{runs} runs over {workers} processes: {wall:.1f} s of wall, {used:.1f} s of CPU "
        f"({1e6 * used / runs:.0f} us a run), load {os.getloadavg()[0]:.1f}; so 1e5 runs take "
        f"{used / runs * 1e5 / workers:.0f} s on {workers} idle cores (bar: 180); "
        f"{size / runs:.0f} bytes a run"
    )


def reading(runs):
    """A table held against digests and plan; the same by pyarrow alone; a check in a child."""
    from pyarrow import parquet

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "store"
        run_study(study(runs, steps=20, n_c=2), path, workers=0)
        seconds = {"held": [], "pyarrow": []}
        for _ in range(5):
            start = time.process_time()
            with Folder(path) as opened:
                table_in(opened, guarded=False)
            between = time.process_time()
            for file in (path / "chunks").iterdir():
                parquet.ParquetFile(file).read(use_threads=False)
            seconds["held"].append(between - start)
            seconds["pyarrow"].append(time.process_time() - between)
        start = time.perf_counter()
        check_store(path)
        whole = time.perf_counter() - start
    guarded, alone = (statistics.median(seconds[key]) for key in ("held", "pyarrow"))
    print(
        f"reading {runs} rows: {1e6 * guarded / runs:.1f} us a row, {guarded / alone:.2f} times "
        "what "
        f"pyarrow takes without a look; a check, in a child, {whole:.1f} s of wall"
    )


MEMORY = """
import resource, sys, tempfile
sys.path.insert(0, "benchmarks")
import sweeps
if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        sweeps.run_study(sweeps.study(int(sys.argv[1]), steps=200), folder + "/s", workers=1)
    own, worker = (resource.getrusage(w).ru_maxrss / 1e3
                   for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    print(f"{own:.0f} MB, worker {worker:.0f} MB")
"""


def memory(runs):
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / "memory.py"
        script.write_text(MEMORY)
        for count in (runs // 10, runs):
            out = subprocess.run(
                [sys.executable, str(script), str(count)],
                capture_output=True, text=True, check=True,
            )  # fmt: skip
            print(f"peak memory of {count} runs: {out.stdout.strip()} (bar: 500)")


def slow_case(rng, steps):
    """A plant in Python, which takes its time."""
    plant = FunctionPlant(
        advance=lambda k, x, u, w: 0.9 * x + u + w, output=lambda k, x, w: (x, x),
        n=1, l_u=1, l_w=1, l_y=1, l_z=1,
    )  # fmt: skip
    settings = ControllerSettings(
        structure=iir(2), target=TargetModel([0, 1.0]), update=UD(R_theta=1.0)
    )
    return SimulationCase(plant, settings, rng.standard_normal((steps, 1)), {"stride": steps})


KINDS = {
    "l_theta = 20": lambda: study(10**6, steps=20_000),
    "l_theta = 400": lambda: study(10**5, steps=20_000, n_c=200),
    "Python plant": lambda: Study(slow_case, [Axis("steps", [20_000])], [], repetitions=10**5),
}
PRESSED = """
import gc, sys
sys.path.insert(0, "benchmarks")
import sweeps
if __name__ == "__main__":
    def tell(progress):
        if progress.done:
            print("going", flush=True)
    try:
        sweeps.run_study(sweeps.KINDS[sys.argv[1]](), sys.argv[2], workers=int(sys.argv[3]),
                         progress=tell, many=True)
    finally:
        gc.freeze()  # as rcac does it
"""


def ctrl_c(repetitions):
    """From the key to the end of the process; the chunk size is chosen by the study itself."""
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / "pressed.py"
        script.write_text(PRESSED)
        for kind in KINDS:
            for workers in (0, 2):
                times = []
                for i in range(repetitions):
                    file = Path(folder) / f"{kind}{workers}{i}"
                    process = subprocess.Popen(
                        [sys.executable, str(script), kind, str(file), str(workers)],
                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                    )  # fmt: skip
                    assert process.stdout is not None
                    process.stdout.readline()
                    time.sleep(0.3 * i)
                    start = time.perf_counter()
                    process.send_signal(signal.SIGINT)
                    process.wait()
                    times.append(time.perf_counter() - start)
                    process.stdout.close()
                    read_table(file)
                print(
                    f"Ctrl-C, {kind}, workers = {workers}: median "
                    f"{statistics.median(times):.2f} s, worst {max(times):.2f} s (bar: 0.5)"
                )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=20_000)
    parser.add_argument("--repetitions", type=int, default=3)
    parser.add_argument("--workers", type=int, default=2)
    chosen = parser.parse_args()
    in_one_process(chosen.runs // 4, chosen.repetitions)
    reading(chosen.runs * 5)
    over_processes(chosen.runs, chosen.repetitions, chosen.workers)
    memory(chosen.runs * 5)
    ctrl_c(chosen.repetitions)


if __name__ == "__main__":
    main()
