"""The chunks of a folder that may come from others, tried in one child with limits.

pyarrow is not made for files of strangers: some damaged ones end the process, others unpack to
gigabytes. The child reads each of them first; the one that it was at when it ended is damaged.
"""

from __future__ import annotations

import json
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from rcac_experiments.sweeps._chunk_files import MOST_BYTES, Columns, Layout, decode
from rcac_experiments.sweeps._directory import Directory
from rcac_experiments.sweeps._problems import Damaged, StoreError

MEMORY = 2**30  # bytes of the child, plus four times the size of a file beyond 64 MiB
SECONDS = 1.0  # processor time for a chunk, plus 1 s for each 64 MiB of its file
LARGE = 2**26
TIMEOUT = 60.0  # seconds until a drive or a file counts as unreadable
DEATHS = 2  # lost children, after which the other chunks are not read
ENVIRONMENT = {"ARROW_DEFAULT_MEMORY_POOL": "system", "OPENBLAS_NUM_THREADS": "1",
               "OMP_NUM_THREADS": "1"}  # fmt: skip

ChunkRequest = tuple[int, int, Layout]  # the number of a chunk, its rows, its columns
ChunkResult = tuple[int, Columns | str]  # its columns, or what is wrong with it


def file_of(number: int) -> str:
    """Return the name of a chunk's file."""
    return f"{number:08d}.parquet"


def read_in_process(folder: Directory, requests: Sequence[ChunkRequest]) -> Iterator[ChunkResult]:
    """Read the stored chunks among the requested ones, in this process."""
    for number, rows, layout in requests:
        try:
            data = folder.read(file_of(number), MOST_BYTES)
            yield number, decode(layout, number, rows, data)
        except FileNotFoundError:
            continue
        except Damaged as fault:
            yield number, str(fault)


def read_guarded(folder: Directory, requests: Sequence[ChunkRequest]) -> Iterator[ChunkResult]:
    """Read chunks after a child process has read them within limits of memory and time."""
    faults: dict[int, str] = {}
    remaining = list(requests)
    for _ in range(DEATHS):
        if remaining:
            faults.update(_faults_by_child(folder, remaining))
            remaining = [one for one in remaining if one[0] not in faults]
        if remaining:
            faults[remaining.pop(0)[0]] = "reading it exceeded the limits of memory or time"
    words = f"it was not read: {DEATHS} earlier chunks ended the reading process"
    faults.update({number: words for number, _, _ in remaining})
    for one in requests:
        if faults[one[0]]:
            yield one[0], faults[one[0]]
        else:
            yield from read_in_process(folder, [one])


def _faults_by_child(folder: Directory, requests: Sequence[ChunkRequest]) -> dict[int, str]:
    """Return the fault of each chunk that a child process has read."""
    layouts = list(dict.fromkeys(layout for _, _, layout in requests))
    task = {
        "folder": str(folder.path.absolute()), "handle": folder.handle,
        "layouts": [[layout.study, layout.columns] for layout in layouts],
        "chunks": [[number, rows, layouts.index(layout)] for number, rows, layout in requests],
    }  # fmt: skip
    child = subprocess.Popen(
        # -P: nothing is imported from the folder that this process is in.
        [sys.executable, "-P", "-m", __name__], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL, env={**os.environ, **ENVIRONMENT},
        pass_fds=() if folder.handle is None else (folder.handle,),
    )  # fmt: skip
    lines: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(child, task, lines), daemon=True).start()
    answers = []
    try:
        with suppress(queue.Empty):  # a hanging drive must not block this process
            while line := lines.get(timeout=TIMEOUT):
                answers.append(line)
    finally:
        child.kill()
    if answers[:1] != [b"ready\n"]:
        raise StoreError(
            f"{folder.path} cannot be read: the process that checks the chunks does not "
            f"start ({sys.executable} -m {__name__})."
        )
    return dict(map(json.loads, answers[1:]))


def _listen(child: subprocess.Popen[bytes], task: object, lines: queue.SimpleQueue[bytes]) -> None:
    """Send the task to a child and queue its output lines; an empty line at its end."""
    assert child.stdin is not None and child.stdout is not None
    with suppress(OSError):
        child.stdin.write(json.dumps(task).encode())
        child.stdin.close()
    for line in child.stdout:
        lines.put(line)
    child.wait()
    child.stdout.close()
    lines.put(b"")


def _serve() -> None:
    """Run the child: read the chunks listed on stdin, and print the fault of each."""
    task = json.loads(sys.stdin.buffer.read())
    folder = Directory(Path(task["folder"]), task["handle"])
    layouts = [Layout(study, tuple(map(tuple, columns))) for study, columns in task["layouts"]]
    with suppress(Damaged):
        decode(layouts[0], 0, 0, b"")  # imports the libraries before the limits apply
    print("ready", flush=True)
    for number, rows, index in task["chunks"]:
        size = 0
        with suppress(OSError):
            size = min(folder.about(file_of(number)).st_size, MOST_BYTES)
        _limit(MEMORY + 4 * max(size - LARGE, 0), SECONDS + size / LARGE)
        results = dict(read_in_process(folder, [(number, rows, layouts[index])]))
        fault = results.get(number, "")
        print(json.dumps([number, fault if isinstance(fault, str) else ""]), flush=True)


def _limit(memory: int, seconds: float) -> None:
    """Limit memory and time of this process; the system ends it beyond the limits."""
    if sys.platform == "win32":
        return
    import resource
    import signal

    with suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_AS, (memory, resource.getrlimit(resource.RLIMIT_AS)[1]))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    signal.setitimer(signal.ITIMER_PROF, seconds)


if __name__ == "__main__":
    _serve()
