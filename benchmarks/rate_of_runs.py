"""A worker's processor time for a run of a study, of two installations side by side.

Runs of 2000 steps with the rms of z kept, in chunks of 256: two cells of many runs, and a map, each
of whose cells has one run. Both installations compute the same runs, one after the other, so often
as is said; the medians are printed, their ratio, and whether all that was kept has the same bits.

    python benchmarks/rate_of_runs.py [--before OTHER/bin/python] [--runs 10000] [--cells 2000]
"""

import argparse
import hashlib
import json
import os
import pickle
import statistics
import subprocess
import sys
import time

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

BASE = {
    "plant": {"problem": "standard", "G": "(q - 0.5)/(q*(q - 0.9))"},
    "signals": {"w": {"white_noise": 1.0}},
    "target": {"model": "fir"},
    "controller": {"structure": "iir", "n_c": 4, "R_theta": 1.0},
    "run": {"steps": 2000},
}
CHUNK = 256
# An axis of each map, and its i-th value.
MAPS = {
    "controller.R_theta": lambda i: 1 + i * 1e-3,
    "controller.k_w": lambda i: 4 + i % 1900,
    "signals.w.white_noise": lambda i: 1 + i * 1e-3,
    "plant.G": lambda i: f"(q - 0.5)/(q*(q - 0.{i + 100001}))",
}


def tried(name, runs):
    """The processor time of a run in microseconds, and the digest of all that is kept."""
    try:
        from rcac_experiments.sweeps import Axis, Metric, Study
        from rcac_experiments.sweeps._chunk import ChunkTask
        from rcac_experiments.sweeps._worker import run_chunk
    except ImportError:  # as it was before the experiments had a package of their own
        from rcac_numeric.sweeps import Axis, Study
        from rcac_numeric.sweeps import Kept as Metric
        from rcac_numeric.sweeps.chunks.chunk import ChunkTask
        from rcac_numeric.sweeps.chunks.worker import run_chunk
    if name in MAPS:
        axis = Axis("x", [MAPS[name](i) for i in range(2)], sets=name)
        base, value = BASE, MAPS[name]
    else:
        axis = Axis("x", [1.0, 10.0], sets="controller.R_theta")
        base = {**BASE, "controller": {**BASE["controller"], "n_c": int(name)}}
        value = None
    study = Study(base, [axis], [Metric("rms")], seed=1)
    stored, print_, digest_of_records = pickle.dumps(study), study.fingerprint, hashlib.sha256()

    def chunk(first, count):
        if value is None:
            half = count // 2
            cells = [
                ({"x": R}, [(first + i, first + i) for i in some])
                for R, some in ((1.0, range(half)), (10.0, range(half, count)))
            ]
        else:
            cells = [({"x": value(first + i)}, [(first + i, 0)]) for i in range(count)]
        return run_chunk(ChunkTask(stored, print_, "", cells))

    chunk(0, 16)  # what is done once
    start = time.process_time()
    for first in range(16, 16 + runs, CHUNK):
        for record in chunk(first, min(CHUNK, 16 + runs - first)).records:
            digest_of_records.update(f"{record.run} {record.outcome} {record.values}".encode())
    return 1e6 * (time.process_time() - start) / runs, digest_of_records.hexdigest()


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--before", default="", help="the Python of the other installation")
    parser.add_argument("--runs", type=int, default=10_000)
    parser.add_argument("--cells", type=int, default=2000)
    parser.add_argument("--repetitions", type=int, default=3)
    parser.add_argument("--one", nargs=2, metavar=("NAME", "RUNS"), help="in this process")
    options = parser.parse_args()
    if options.one:
        print(json.dumps(tried(options.one[0], int(options.one[1]))))
        return
    pythons = [python for python in (options.before, sys.executable) if python]
    print(
        f"us a run, medians of {options.repetitions}; {options.runs} runs, maps of {options.cells}"
    )
    for name in ("4", "10", "25", *MAPS):
        spent, digests = {python: [] for python in pythons}, set()
        runs = options.cells if name in MAPS else options.runs
        for _ in range(options.repetitions):
            for python in pythons:
                command = [python, __file__, "--one", name, str(runs)]
                times = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
                spent[python].append(times[0])
                digests.add(times[1])
        medians = [statistics.median(spent[python]) for python in pythons]
        words = f"map of {name}" if name in MAPS else f"l_theta = {2 * int(name)}"
        ratio = f"   {medians[0] / medians[-1]:5.1f} times" if options.before else ""
        same = "the same bits" if len(digests) == 1 else "OTHER BITS"
        print(
            f"  {words:30}" + "".join(f"{m:9.0f}" for m in medians) + f"{ratio}   {same}",
            flush=True,
        )


if __name__ == "__main__":
    main()
