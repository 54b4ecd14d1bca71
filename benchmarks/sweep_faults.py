"""Studies under faults: each ends with the table of the undisturbed run, or names what is missing.

Workers and coordinators are killed at random and around the rename of a chunk, two at a time; the
disk is full, or slow; the folder may only be read; a worker hangs; memory is limited; a run ends
its worker under each executor; dask loses a worker, and its scheduler; the studies among the
examples on every executor, and made of old stores; folders that are damaged or made to harm. As a
table of Markdown.

    python -m benchmarks.sweep_faults [--kills 24] [--folders 4000] [--old STORES] [--only kills]
"""

import argparse
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import warnings
from collections import Counter
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np

from rcac_experiments.sweeps import (
    Axis,
    Metric,
    StoreError,
    Study,
    check_store,
    convert_store,
    load_study,
    read_table,
    run_study,
)
from rcac_experiments.sweeps import _directory as directory
from rcac_experiments.sweeps import _folder as folders
from rcac_experiments.sweeps import _reader as reader
from rcac_experiments.sweeps import _sweep as sweep
from tests.support import hostile_folders, studies

EXAMPLES = Path(__file__).parents[1] / "examples" / "studies"
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


def slow(r):
    """Takes a moment, so that there is time to be killed in."""
    time.sleep(0.01)
    return 1.0


MEASURES = {"rms": slow, "greedy": greedy, "hanging": hanging}


def study(kind="rms", values=(0.01, 1.0, 100.0), repetitions=100):
    axis = Axis("R_theta", list(values), sets="controller.R_theta")
    metrics = [Metric("rms", "of_z"), Metric(MEASURES[kind])]
    return Study(BASE, [axis], metrics, repetitions=repetitions, seed=5, keep_signals=["z"])


def small_chunks():
    """So that there are many to lose."""
    sweep._chunk_size = lambda study, first, pool: 10


def killed_around_a_rename():
    """The process ends at one of its renames: before it, or when it was done."""
    real, rng = os.rename, random.SystemRandom()

    def rename(*names, **where):
        fate = rng.random()
        if fate < 0.1:
            os.kill(os.getpid(), signal.SIGKILL)
        real(*names, **where)
        if fate > 0.9:
            os.kill(os.getpid(), signal.SIGKILL)

    directory.os.rename = rename


def slow_disk():
    """Whatever is written, renamed or brought to the disk takes a quarter of a second, or two."""
    rng = random.SystemRandom()

    def slowed(real):
        def call(*arguments, **where):
            time.sleep(rng.choice([0.05, 0.1, 0.25, 0.25, 2.0]))
            return real(*arguments, **where)

        return call

    for name in ("rename", "fsync", "open"):
        setattr(directory.os, name, slowed(getattr(os, name)))


def coordinate(store, workers, kind="rms", *words, **limits):
    """A coordinator as a process of its own."""
    command = [sys.executable, "-m", "benchmarks.sweep_faults", "--coordinate", str(store)]
    command += [str(workers), kind, *words, *(f"{which}={most}" for which, most in limits.items())]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        cwd=Path(__file__).parents[1],
    )  # fmt: skip


def coordinated(store, workers, kind, *words):
    """What such a process does."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    written = Counter()
    put = folders.Folder.put
    folders.Folder.put = lambda folder, *what: (written.update(["chunks"]), put(folder, *what))
    for word in words:
        which, _, most = word.partition("=")
        if which == "renames":
            killed_around_a_rename()
        elif which == "slow":
            slow_disk()
        else:
            resource.setrlimit(getattr(resource, which), (int(most), int(most)))
    try:
        repetitions = 100 if kind == "rms" else 10
        run_study(study(kind, repetitions=repetitions), store, workers=int(workers))
    except StoreError as error:
        sys.exit(str(error))
    print(written["chunks"])


def children(pid):
    """The processes that any thread of a process has started."""
    processes = []
    for listed in Path(f"/proc/{pid}/task").glob("*/children"):
        try:
            processes += map(int, listed.read_text().split())
        except OSError:
            continue
    return processes


def say(subject, result):
    print(f"| {subject} | {result} |", flush=True)


def verdict(subject, store, reference, missing=()):
    """One line; raises where the table is another one."""
    table = read_table(store)
    rows = np.isin(reference["run"], table["run"])
    assert not set(reference["run"][~rows].tolist()) - set(missing), "rows are missing"
    for name in table.columns:
        a, b = table[name], reference[name][rows]
        assert np.array_equal(a, b, equal_nan=a.dtype.kind == "f"), (subject, name)
    assert check_store(store).is_whole
    left = f", {len(missing)} named as failed" if missing else ""
    say(subject, f"{len(table)} rows as undisturbed{left}; whole")


def kills(folder, reference, count):
    """At a rename of its own, and from outside when something has been stored, two at a time."""
    stores = done = 0
    while done < count // 3:
        store = folder / f"renames{stores}"
        stores += 1
        while (process := coordinate(store, 0, "rms", "renames")).wait() != 0:
            assert process.returncode == -signal.SIGKILL, process.communicate()[1]
            done += 1
        process.communicate()
        parts = len(list(store.rglob("*.part")))
        verdict(f"killed {done} times at a rename; {parts} hidden files left", store, reference)
    rng, ended, stores = random.Random(3), Counter(), 0
    while sum(ended.values()) < count - done:
        store = folder / f"kills{stores}"
        stores += 1
        started = [coordinate(store, 1) for _ in range(2)]
        before = 0
        while any(process.poll() is None for process in started):
            time.sleep(rng.uniform(0.0, 0.2))
            now = len(list((store / "chunks").glob("*.parquet")))
            i = rng.randrange(2)
            workers = children(started[i].pid)
            if now <= before or sum(ended.values()) >= count - done or not workers:
                continue
            before = now
            victim = rng.choice(["a worker", "a coordinator", "both"])
            if victim != "a coordinator":
                with suppress(ProcessLookupError):
                    os.kill(max(workers), signal.SIGKILL)
            if victim != "a worker":
                started[i].kill()
                started[i].communicate()
                started[i] = coordinate(store, 1)
            ended[victim] += 1
        for process in started:
            messages = (
                process.communicate()[1] if process.stderr and not process.stderr.closed else ""
            )
            assert process.returncode == 0 and "Traceback" not in messages, messages
        words = ", ".join(f"{kind} {number}" for kind, number in sorted(ended.items()))
        verdict(f"of two coordinators killed so far: {words}", store, reference)


def slow_disks(folder, reference):
    """Two coordinators over a disk that hardly answers, of which one is killed."""
    store, rng, killed = folder / "slow", random.Random(4), 0
    started = [coordinate(store, 1, "rms", "slow") for _ in range(2)]
    start = time.perf_counter()
    while any(process.poll() is None for process in started):
        time.sleep(rng.uniform(2.0, 8.0))
        if killed < 4 and started[0].poll() is None and (store / "chunks").exists():
            started[0].kill()
            started[0].communicate()
            started[0] = coordinate(store, 1, "rms", "slow")
            killed += 1
    messages = [process.communicate()[1] for process in started]
    assert all(process.returncode == 0 for process in started), messages
    words = f"two coordinators on a slow disk, one killed {killed} times, {since(start)}"
    verdict(words, store, reference)


def two(folder, reference):
    for i in range(3):
        store = folder / f"two{i}"
        started = [coordinate(store, 1) for _ in range(2)]
        counts = [int(process.communicate()[0]) for process in started]
        total = len(list((store / "chunks").glob("*.parquet")))
        words = f"two coordinators at a time computed {counts[0]} + {counts[1]} chunks for {total}"
        verdict(words, store, reference)


def disk(folder, reference):
    store = folder / "disk"
    messages = coordinate(store, 1, RLIMIT_FSIZE=20_000).communicate()[1]
    assert "the disk is full" in messages and "Traceback" not in messages, messages
    run_study(study(), store, workers=0)
    verdict("no file may be larger than 20 kB, then it may", store, reference)
    mount = folder / "mount"
    mount.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=1500k", "tmpfs", str(mount)]
    if subprocess.run(command, capture_output=True, check=False).returncode:
        say("a disk of 1.5 MB", "cannot be mounted here")
        return
    try:
        messages = coordinate(mount / "store", 1).communicate()[1]
        assert "the disk is full" in messages and "Traceback" not in messages, messages
        report = check_store(mount / "store")
        assert report.is_whole and report.done, report
        hidden = list((mount / "store" / "chunks").glob(".*"))
        shutil.copytree(mount / "store", folder / "larger")
    finally:
        subprocess.run(["umount", str(mount)], check=True)
    run_study(study(), folder / "larger", workers=0)
    words = f"a disk of 1.5 MB full after {report.done} runs ({len(hidden)} hidden files left)"
    verdict(words + ", then a larger one", folder / "larger", reference)


def readonly(folder, reference):
    """A mount that nobody can write to, root neither."""
    store = folder / "readonly"
    store.mkdir()
    bind = ["mount", "--bind", str(folder / "reference"), str(store)]
    if subprocess.run(bind, capture_output=True, check=False).returncode:
        say("a folder that may only be read", "cannot be mounted here")
        return
    try:
        subprocess.run(["mount", "-o", "remount,bind,ro", str(store)], check=True)
        out, messages = coordinate(store, 0).communicate()
        assert out.strip() == "0", messages
        verdict("a file system that may only be read, the command given again", store, reference)
        try:
            run_study(study(repetitions=101), store, workers=0)
        except StoreError as error:
            say("the same, a larger study", f"refused: ...{str(error)[-60:]}")
    finally:
        subprocess.run(["umount", str(store)], check=True)


def deadly(folder):
    values = [1.0, 2.0, studies.DEADLY, 4.0, 5.0]
    whole = studies.over_R_theta(values, studies.deadly, 2)
    others = studies.over_R_theta([v for v in values if v != studies.DEADLY], studies.deadly, 2)
    run_study(others, folder / "others", workers=0)
    expected = read_table(folder / "others")["rms"]
    small = sweep._chunk_size
    sweep._chunk_size = lambda study, first, pool: 5
    pools = {
        "processes of ours": {"workers": 2},
        "a function that makes a ProcessPoolExecutor": {
            "executor": partial(ProcessPoolExecutor, 2)
        },
    }
    for name, how in pools.items():
        store, start = folder / f"deadly{len(name)}", time.perf_counter()
        progress = run_study(whole, store, **how)
        table = read_table(store)
        assert set(table.failed["R_theta"]) == {studies.DEADLY} and progress.failed == 2
        assert np.array_equal(np.sort(table["rms"]), np.sort(expected))
        say(f"2 of 10 runs end their worker; {name}", f"those 2 named, {since(start)}")
    with ProcessPoolExecutor(2) as pool:
        try:
            run_study(whole, folder / "broken", executor=pool)
        except StoreError as error:
            assert f"R_theta = {studies.DEADLY}" in str(error), error
            say("the same; one ProcessPoolExecutor", "refused, and the run named")
    with cluster(2, 0) as client:
        start, how = time.perf_counter(), client.get_executor(pure=False)
        try:
            run_study(whole, folder / "dask", executor=how)
            message = "those 2 named"
        except StoreError as error:  # its nannies gave up
            assert f"R_theta = {studies.DEADLY}" in str(error), error
            message = "refused, and the run named; then on processes of ours: those 2 named"
            run_study(whole, folder / "dask", workers=2)
        table = read_table(folder / "dask")
        assert set(table.failed["R_theta"]) == {studies.DEADLY} and table.failures == 2
        assert np.array_equal(np.sort(table["rms"]), np.sort(expected))
        say("the same; dask, allowed-failures 0", f"{message}, {since(start)}")
    sweep._chunk_size = small


def since(start):
    return f"{time.perf_counter() - start:.0f} s"


def hang(folder):
    store, other = folder / "hang", folder / "hangs not"
    progress = run_study(
        study("hanging", (0.01, HANGING, 100.0), 2), store, workers=2, time_limit=8.0
    )
    run_study(study("hanging", (0.01, 100.0), 2), other, workers=0)
    table = read_table(store)
    assert set(table.failed["R_theta"]) == {HANGING} and progress.failed == 2, table.failed
    assert np.array_equal(np.sort(table["of_z"]), np.sort(read_table(other)["of_z"]))
    say("a worker that hangs, time_limit 8 s", f"{progress}; the others as undisturbed")


def memory(folder):
    store, other = folder / "memory", folder / "enough"
    whole = study("greedy", repetitions=10)
    process = coordinate(store, 1, "greedy", RLIMIT_AS=2**31 + 2**28)
    messages = process.communicate()[1]
    assert process.returncode == 0, messages
    table = read_table(store)
    words = f"memory limit: {table.failures} of 30 failed ({set(table.failed['outcome'])})"
    assert table.failures == 30
    run_study(whole, store, workers=0, retry_failed=True)
    run_study(whole, other, workers=0)
    verdict(f"{words}, retried", store, read_table(other))


@contextmanager
def cluster(workers, failures=3):
    warnings.simplefilter("ignore")
    import dask
    import distributed

    with (
        dask.config.set({"distributed.scheduler.allowed-failures": failures}),
        distributed.LocalCluster(
            n_workers=workers, threads_per_worker=1, dashboard_address=None, silence_logs=60
        ) as local,
        distributed.Client(local) as client,
    ):
        yield client


def losing(client, subject, lost):
    """A progress that ends a worker or the scheduler, once, when something has ended."""
    local = client.cluster

    def lose(progress):
        if lost or not progress.done:
            return
        if subject == "worker":
            lost.append(next(iter(local.workers.values())).pid)
            os.kill(lost[0], signal.SIGKILL)
        else:
            lost.append(0)
            threading.Thread(target=lambda: local.sync(local.scheduler.close), daemon=True).start()

    return lose


def dask(folder, reference):
    for name in ("scheduler", "worker"):
        store, lost = folder / name, []
        with cluster(2 if name == "worker" else 1) as client:
            try:
                run_study(study(), store, executor=client.get_executor(pure=False), window=4,
                          progress=losing(client, name, lost))  # fmt: skip
                ended = "went on by itself"
            except StoreError as error:
                ended = f"refused ({str(error)[:60]}...), then gone on with"
        assert lost
        run_study(study(), store, workers=0)
        verdict(f"dask lost its {name}: {ended}", store, reference)


def reduced(path):
    """A study among the examples with three values of each axis or fewer, and two repetitions."""
    whole = load_study(path)
    axes = [Axis(a.name, a.values[:: max(1, -(-len(a) // 3))], sets=a.sets) for a in whole.axes]
    return Study(
        whole.base, axes, whole.keep, repetitions=min(whole.repetitions, 2), seed=whole.seed,
        common_noise=whole.common_noise, lanes=whole.lanes, file=whole.file, title=whole.title,
        keep_signals=whole.keep_signals,
    )  # fmt: skip


def executors(folder, old):
    """The studies among the examples: an old store converted, and the same computed anew."""
    sweep._chunk_size = lambda study, first, pool: 4
    for path in sorted(EXAMPLES.glob("*.toml")):
        one, messages = reduced(path), []
        base = folder / path.stem
        base.mkdir()
        run_study(one, base / "in process", workers=0)
        expected = read_table(base / "in process")
        ways = {"2 processes": {"workers": 2}, "3 threads": {"executor": ThreadPoolExecutor(3)}}
        for name, how in ways.items():
            run_study(one, base / name, **how)
            assert read_table(base / name) == expected, (path, name)
            messages.append(name)
        lost = []
        with cluster(2) as client:
            run_study(one, base / "dask", executor=client.get_executor(pure=False), window=4,
                      progress=losing(client, "worker", lost))  # fmt: skip
        assert read_table(base / "dask") == expected and lost, path
        messages.append("dask, one of two workers killed")
        if old is not None:
            converted = convert_store(old / f"{path.stem}.sqlite", base / "converted")
            assert converted.is_whole and converted.done == one.runs
            assert same_bits(read_table(base / "converted"), expected), path
            messages.append("old store converted")
        say(f"{path.stem}, {one.runs} runs in process", "the same bits: " + ", ".join(messages))


def same_bits(a, b):
    """Every number of two tables, also where their rows were planned in other chunks."""
    return a == b and all(
        a[name].tobytes() == b[name].tobytes() for name in a.columns if a[name].dtype != object
    )


MEASURED = """
import resource, sys, time
from rcac_experiments.sweeps import StoreError, check_store, read_table
start = time.process_time()
said = []
for use in (check_store, read_table):
    try:
        found = use(sys.argv[1])
        said.append("named" if use is check_store and not found.is_whole else "read")
    except StoreError:
        said.append("refused")
print(*said, sep=", ")
child = resource.getrusage(resource.RUSAGE_CHILDREN)
with open("/proc/self/status") as status:  # what a process had before exec counts for ru_maxrss
    most = next(int(line.split()[1]) for line in status if line.startswith("VmHWM"))
print(max(most, child.ru_maxrss) // 1024, time.process_time() - start, child.ru_utime)
"""


def whole_study(folder):
    """A finished store, its study and table, and a file of ours that nothing may touch."""
    one = studies.study(
        20, base={**studies.BASE, "run": {"steps": 30}}, keep_signals=["y"], title="a study"
    )
    sweep._chunk_size = lambda study, first, pool: 20
    (folder / "ours").mkdir()
    victim = folder / "ours" / "notes.txt"
    victim.write_text("mine")
    run_study(one, folder / "whole", workers=0)
    return one, read_table(folder / "whole"), victim


def hostile(folder):
    """Each kind of hostile folder, as the commands read it: in a child, and measured."""
    one, before, victim = whole_study(folder)
    rng, seconds, megabytes = random.Random(6), 0.0, 0.0
    for kind, harm in hostile_folders.HOSTILE.items():
        received = folder / "got"
        shutil.rmtree(received, ignore_errors=True)
        shutil.copytree(folder / "whole", received)
        harm(received, rng, victim)
        mine = sorted(victim.parent.iterdir())
        command = [sys.executable, "-c", MEASURED, str(received)]
        out = subprocess.run(command, capture_output=True, text=True, check=False)
        assert not out.stderr, (kind, out.stderr)
        most, local, child = map(float, out.stdout.splitlines()[-1].split())
        seconds, megabytes = max(seconds, local, child), max(megabytes, most)
        again = computed_again(one, received, before)
        assert victim.read_text() == "mine" and sorted(victim.parent.iterdir()) == mine, kind
        for moved in victim.parent.glob("chunks*"):
            shutil.rmtree(moved)
        words = f"{out.stdout.splitlines()[0]}; {again}; {max(local, child):.1f} s, {most:.0f} MB"
        say(kind, words)
    say(f"{len(hostile_folders.HOSTILE)} kinds", "0 wrong tables, nothing outside touched; at most "
        f"{seconds:.1f} s of processor, {megabytes:.0f} MB")  # fmt: skip


def damaged(folder, count):
    """Bytes that were changed, in this process: what a check, a reader and the study make of it."""
    one, before, victim = whole_study(folder)
    rng, counts, slowest = random.Random(7), Counter(), 0.0
    folders.read_guarded = reader.read_in_process
    for i in range(count):
        received = folder / "got"
        shutil.rmtree(received, ignore_errors=True)
        shutil.copytree(folder / "whole", received)
        harm = hostile_folders.DAMAGE[i % len(hostile_folders.DAMAGE)]
        harm(received, rng, victim)
        start = time.process_time()
        try:
            is_named = not check_store(received).is_whole
        except StoreError:
            is_named = True
        try:
            assert read_table(received) == before, f"a wrong table: {harm.__name__}"
            read = "read as it was"
        except StoreError:
            read = "refused"
        slowest = max(slowest, time.process_time() - start)
        again = computed_again(one, received, before) if i % 10 == 0 else "not run"
        counts[f"{read}{', named by the check' if is_named else ''}", again] += 1
    for (read, again), number in sorted(counts.items()):
        say(f"{number} folders with changed bytes", f"{read}; {again}")
    say(f"{count} folders", f"0 wrong tables; at most {slowest:.1f} s of processor")


def computed_again(one, store, before):
    """What the study makes of a folder."""
    guarded = folders.read_guarded
    try:
        run_study(one, store, workers=0)
    except StoreError:
        return "the study refused"
    folders.read_guarded = reader.read_in_process
    assert read_table(store) == before, "a wrong table was computed"
    folders.read_guarded = guarded
    return "the study gives the table"


def main():
    small_chunks()
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=24)
    parser.add_argument("--folders", type=int, default=4000)
    parser.add_argument("--old", type=Path, help="SQLite stores of the reduced studies, by name.")
    parser.add_argument(
        "--only",
        default="kills,slow,two,disk,readonly,deadly,hang,memory,dask,executors,hostile,damaged",
    )
    parser.add_argument("--coordinate", nargs="+")
    chosen = parser.parse_args()
    if chosen.coordinate:
        coordinated(*chosen.coordinate)
        return
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scenarios = {
            "kills": lambda: kills(folder, reference, chosen.kills),
            "slow": lambda: slow_disks(folder, reference),
            "two": lambda: two(folder, reference),
            "disk": lambda: disk(folder, reference),
            "readonly": lambda: readonly(folder, reference),
            "deadly": lambda: deadly(folder),
            "hang": lambda: hang(folder),
            "memory": lambda: memory(folder),
            "dask": lambda: dask(folder, reference),
            "executors": lambda: executors(folder, chosen.old),
            "hostile": lambda: hostile(folder),
            "damaged": lambda: damaged(folder, chosen.folders),
        }
        chosen_parts = chosen.only.split(",")
        if not set(chosen_parts) <= {"executors", "hostile", "damaged", "deadly", "hang", "memory"}:
            run_study(study(), folder / "reference", workers=0)
            reference = read_table(folder / "reference")
        for scenario in chosen_parts:
            scenarios[scenario]()


if __name__ == "__main__":
    main()
