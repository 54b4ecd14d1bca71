"""Studies under faults: each ends with the table of the undisturbed run, or names what is missing.

Workers and coordinators are killed at random while two coordinators share a store; the disk is
full; a worker hangs; memory is limited; dask loses a worker, and its scheduler.

    python benchmarks/sweep_faults.py [--kills 40] [--only kills,disk,hang,memory,dask]
"""

import argparse
import os
import random
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
import warnings
from pathlib import Path

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np

from rcac_experiments.sweeps import (
    Axis,
    Kept,
    StoreError,
    Study,
    check_store,
    read_table,
    run_study,
)
from rcac_experiments.sweeps import (
    _sweep as sweep,
)

BASE = {
    "plant": {"problem": "standard", "G": "(q - 0.5)/((q - 0.9)*(q - 1.1))"},
    "signals": {"w": {"white_noise": 1.0}},
    "target": {"model": "fir"},
    "controller": {"structure": "iir", "n_c": 3, "R_theta": 1.0},
    "run": {"steps": 2000},
}
HANGING = 5.0


def greedy(r):
    """Asks for 4 GB, and touches none of it."""
    return float(np.empty(2**29).size)


def hanging(r):
    """Never ends at one value of R_theta."""
    while r.run.settings.update.R_theta == HANGING:
        time.sleep(0.01)
    return 1.0


MEASURES = {"rms": "rms", "greedy": greedy, "hanging": hanging}


def study(kind="rms", values=(0.01, 1.0, 100.0), repetitions=100):
    axis = Axis("R_theta", list(values), sets="controller.R_theta")
    kept = [Kept("rms", "of_z"), Kept(MEASURES[kind])] if kind != "rms" else [Kept("rms", "of_z")]
    return Study(BASE, [axis], kept, repetitions=repetitions, seed=5, keep_signals=["z"])


def small_chunks():
    """So that there are many to lose."""
    sweep._chunk_size = lambda study, first, executor: 10


def coordinate(store, workers, kind="rms", **limits):
    """A coordinator as a process of its own."""
    command = [sys.executable, __file__, "--coordinate", str(store), str(workers), kind]
    command += [f"{which}={most}" for which, most in limits.items()]
    return subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )  # fmt: skip


def children(pid):
    """The processes that any thread of a process has started."""
    found = []
    for listed in Path(f"/proc/{pid}/task").glob("*/children"):
        try:
            found += map(int, listed.read_text().split())
        except OSError:
            continue
    return found


def verdict(what, store, reference, missing=()):
    """One line; raises where the table is another one."""
    table = read_table(store)
    rows = np.isin(reference["run"], table["run"])
    assert not set(reference["run"][~rows].tolist()) - set(missing), "rows are missing"
    for name in table.columns:
        a, b = table[name], reference[name][rows]
        assert np.array_equal(a, b, equal_nan=a.dtype.kind == "f"), (what, name)
    assert check_store(store).is_whole
    left = f", {len(missing)} named as failed" if missing else ""
    print(f"{what}: {len(table)} rows as undisturbed{left}; the store is whole", flush=True)


def kills(folder, reference, count):
    """Two coordinators of a store at a time."""
    rng, done, stores = random.Random(3), [0, 0], 0
    while sum(done) < count:
        store = folder / f"kills{stores}.sqlite"
        stores += 1
        started = [coordinate(store, 1) for _ in range(2)]
        while any(process.poll() is None for process in started):
            time.sleep(rng.uniform(0.5, 4.0))
            i = rng.randrange(2)
            workers = [max(found)] if (found := children(started[i].pid)) else []
            if sum(done) >= count or started[i].poll() is not None:
                continue
            if workers and rng.random() < 0.5:
                os.kill(workers[0], signal.SIGKILL)
                done[0] += 1
            elif rng.random() < 0.3:
                started[i].kill()
                started[i].wait()
                done[1] += 1
                started[i] = coordinate(store, 1)
        for process in started:
            said = process.communicate()[1]
            assert process.returncode == 0 and "Traceback" not in said, said
        verdict(f"{done[0]} workers and {done[1]} coordinators killed", store, reference)


def disk(folder, reference):
    store = folder / "disk.sqlite"
    process = coordinate(store, 1, RLIMIT_FSIZE=400_000)
    said = process.communicate()[1]
    assert process.returncode == 1 and "the disk is full" in said, said
    before = len(read_table(store))
    run_study(study(), store, workers=0)
    verdict(f"a disk that was full after {before} runs", store, reference)


def hang(folder):
    values = (0.01, HANGING, 100.0)
    store, other = folder / "hang.sqlite", folder / "others.sqlite"
    whole = study("hanging", values, 2)
    progress = run_study(whole, store, workers=2, time_limit=8.0)
    run_study(study("hanging", (0.01, 100.0), 2), other, workers=0)
    table = read_table(store)
    assert set(table.failed["R_theta"]) == {HANGING} and progress.failed == 2, table.failed
    assert np.array_equal(table["of_z"], read_table(other)["of_z"])
    print(f"a worker that hangs: {progress}; the others as undisturbed", flush=True)


def memory(folder):
    whole, store, other = (
        study("greedy", repetitions=10),
        folder / "memory.sqlite",
        folder / "enough.sqlite",
    )
    process = coordinate(store, 1, "greedy", RLIMIT_AS=2**31 + 2**28)
    said = process.communicate()[1]
    assert process.returncode == 0, said
    table = read_table(store)
    words = f"memory limit: {table.failures} of 30 failed ({set(table.failed['outcome'])})"
    assert table.failures == 30
    run_study(whole, store, workers=0, retry_failed=True)
    run_study(whole, other, workers=0)
    verdict(f"{words}, retried", store, read_table(other))


def dask(folder, reference):
    warnings.simplefilter("ignore")
    import distributed

    def cluster(workers):
        return distributed.LocalCluster(
            n_workers=workers, threads_per_worker=1, dashboard_address=None, silence_logs=60
        )

    for what in ("scheduler", "worker"):
        store, lost = folder / f"{what}.sqlite", []
        with cluster(2 if what == "worker" else 1) as local, distributed.Client(local) as client:

            def lose(progress, what=what, local=local, lost=lost):
                if lost or not progress.done:
                    return
                if what == "worker":
                    lost.append(next(iter(local.workers.values())).pid)
                    os.kill(lost[0], signal.SIGKILL)
                else:
                    lost.append(0)
                    threading.Thread(
                        target=lambda: local.sync(local.scheduler.close), daemon=True
                    ).start()

            try:
                run_study(study(), store, executor=client.get_executor(pure=False), window=4,
                          progress=lose)  # fmt: skip
                ended = "went on by itself"
            except StoreError as error:
                ended = f"refused ({str(error)[:60]}...), then gone on with"
        assert lost
        run_study(study(), store, workers=0)
        verdict(f"dask lost its {what}: {ended}", store, reference)


def main():
    small_chunks()
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=40)
    parser.add_argument("--only", default="kills,disk,hang,memory,dask")
    parser.add_argument("--coordinate", nargs="+")
    chosen = parser.parse_args()
    if chosen.coordinate:
        store, workers, kind, *limits = chosen.coordinate
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        for which, most in (limit.split("=") for limit in limits):
            resource.setrlimit(getattr(resource, which), (int(most), int(most)))
        try:
            run_study(
                study(kind, repetitions=100 if kind == "rms" else 10), store, workers=int(workers)
            )
        except StoreError as error:
            sys.exit(str(error))
        return
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        run_study(study(), folder / "reference.sqlite", workers=0)
        reference = read_table(folder / "reference.sqlite")
        scenarios = {
            "kills": lambda: kills(folder, reference, chosen.kills),
            "disk": lambda: disk(folder, reference),
            "hang": lambda: hang(folder),
            "memory": lambda: memory(folder),
            "dask": lambda: dask(folder, reference),
        }
        for scenario in chosen.only.split(","):
            scenarios[scenario]()


if __name__ == "__main__":
    main()
