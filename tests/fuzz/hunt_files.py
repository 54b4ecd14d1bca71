"""As many hostile runs and states as are asked for: `python -m tests.fuzz.hunt_files 10000`.

Each is read in a process of its own, whose CPU time and largest size are measured. Printed is what
broke, took more than 5 s of CPU or grew by more than 500 MB, and at the end the worst of all.
"""

import argparse
import os
import tempfile
import traceback
from collections import Counter
from pathlib import Path

from tests.fuzz.hostile_files import draw, parts_of, require_harmless_run, restorable, seeds

CPU_SECONDS, MEGABYTES = 5.0, 500.0


def measured(task):
    """The CPU seconds and megabytes that a process for a task takes, and its status."""
    child = os.fork()
    if child == 0:
        status = 2
        try:
            status = 0 if task() is None else 1
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(status)
    _, status, usage = os.wait4(child, 0)
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, status


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", type=int)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    chosen = parser.parse_args()
    runs = seeds()
    with tempfile.TemporaryDirectory() as folder:
        parts = [parts_of(run, Path(folder)) for run in runs]
        states = [pair for run in runs for pair in restorable(run)]
        path = Path(folder) / "hostile.npz"
        runs[0].save(path)
        require_harmless_run(path, drawn=True)  # imports what is used
        _, alone, _ = measured(lambda: None)
        worst, ends = {"seconds": (0.0, -1), "megabytes": (0.0, -1)}, Counter()
        for seed in range(chosen.first, chosen.first + chosen.count):
            task = draw(path, seed, parts, states)
            seconds, megabytes, status = measured(task)
            megabytes -= alone
            ends[{0: "refused", 256: "read"}.get(status, "broken")] += 1
            worst["seconds"] = max(worst["seconds"], (seconds, seed))
            worst["megabytes"] = max(worst["megabytes"], (megabytes, seed))
            if status not in (0, 256) or seconds > CPU_SECONDS or megabytes > MEGABYTES:
                print(f"seed {seed}: status {status}, {seconds:.1f} s, {megabytes:.0f} MB",
                      flush=True)  # fmt: skip
    for name, (value, seed) in worst.items():
        print(f"most {name}: {value:.2f} (seed {seed})")
    print(dict(ends))


if __name__ == "__main__":
    main()
