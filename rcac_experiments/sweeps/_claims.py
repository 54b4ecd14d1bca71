"""Chunks of a store that a process has taken, with a lease, so that nobody else runs them."""

from __future__ import annotations

import contextlib
import math
import os
import secrets
import socket
import sqlite3
import threading
import time
from dataclasses import dataclass, replace
from pathlib import Path

from rcac_experiments.sweeps._chunk import RunRecord
from rcac_experiments.sweeps._problems import StoreError, explained
from rcac_experiments.sweeps._store import (
    DONE,
    FREE,
    LEASED,
    LONGEST_LEASE,
    PATIENCE,
    ChunkRow,
    Row,
    Store,
    chunk_digest,
    signals_digest,
)

LEASE = 60.0  # seconds; renewed every third of them
STALL = 600.0  # seconds without any progress after which nothing is renewed any more


@dataclass(frozen=True)
class Claim:
    """A chunk that this process may run: its runs first, ..., last."""

    chunk: int
    first: int
    last: int
    tries: int


class Claims:
    """What this process has taken from a store; to be closed, so that the rest is free again."""

    def __init__(self, store: Store) -> None:
        self.store, self.owner = store, this_owner()
        self._last = 0  # the chunk that was taken last: free ones before it are few
        self._progress = time.monotonic()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        if store.journal == "wal":  # with the other nobody else has the file anyway
            self._thread = threading.Thread(target=self._renew, daemon=True)
            self._thread.start()

    def progressed(self) -> None:
        """Note that something was done: leases are renewed for nothing else."""
        self._progress = time.monotonic()

    def take(self) -> Claim | None:
        """A free chunk; None where there is none."""
        with self.store.writing() as connection:
            for after in dict.fromkeys((self._last, 0)):
                row = connection.execute(
                    "SELECT chunk, first, last, tries FROM chunk WHERE chunk > ? AND state = ? "
                    "ORDER BY chunk LIMIT 1", (after, FREE),
                ).fetchone()  # fmt: skip
                if row is not None:
                    break
            else:
                return None
            claim = Claim(*row)
            connection.execute(
                "UPDATE chunk SET state = ?, owner = ?, until = ? WHERE chunk = ?",
                (LEASED, self.owner, time.time() + LEASE, claim.chunk),
            )
        self._last = claim.chunk
        if claim.last >= self.store.study.plan.runs:
            self.store.refreshed()  # another process has made the study grow
        return claim

    def take_over(self) -> int:
        """Free what processes that are gone, or whose lease has run out, had taken; how many.

        A lease that lasts longer than any that is asked for is none: its host's clock is wrong.
        """
        now = time.time()
        with explained(self.store.path):
            owners = self.store.connection.execute(
                "SELECT DISTINCT owner FROM chunk WHERE state = ?", (LEASED,)
            ).fetchall()
        alone = self.store.journal != "wal"
        gone = [o for (o,) in owners if o != self.owner and (alone or is_gone(str(o)))]
        freed = 0
        with self.store.writing() as connection:
            for owner in gone:
                freed += connection.execute(
                    "UPDATE chunk SET state = ?, owner = NULL, until = NULL "
                    "WHERE state = ? AND owner IS ?",
                    (FREE, LEASED, owner),
                ).rowcount
            freed += connection.execute(
                "UPDATE chunk SET state = ?, owner = NULL, until = NULL "
                "WHERE state = ? AND owner IS NOT ? AND NOT (typeof(until) = 'real' AND "
                "until BETWEEN ? AND ?)",
                (FREE, LEASED, self.owner, now, now + LONGEST_LEASE),
            ).rowcount
        return freed

    @property
    def others(self) -> bool:
        """Whether another process is at work on the rest."""
        with explained(self.store.path):
            return bool(
                self.store.connection.execute(
                    "SELECT count(*) FROM chunk WHERE state = ? AND owner IS NOT ?",
                    (LEASED, self.owner),
                ).fetchone()[0]
            )

    def failed(self, claim: Claim) -> Claim:
        """Note that a chunk took its worker with it, or was lost with one; it is still ours."""
        with self.store.writing() as connection:
            connection.execute(
                "UPDATE chunk SET tries = tries + 1 WHERE chunk = ? AND state != ?",
                (claim.chunk, DONE),
            )
        return replace(claim, tries=claim.tries + 1)

    def finish(self, claim: Claim, records: list[RunRecord], seconds: float) -> bool:
        """Store the records of a chunk; False where somebody else has done so.

        Whoever is first does: a run's numbers do not depend on who ran it.
        """
        records = sorted(records, key=lambda record: record.run)
        about = self.store.study
        signals = [
            [
                (name, ",".join(map(str, a.shape)), a.astype("<f8").tobytes())
                for name, a in sorted(record.signals.items())
            ]
            for record in records
        ]
        width = len(about.measures)
        rows: list[Row] = [
            (
                *place, record.outcome, record.error, signals_digest(of_run),
                *map(_stored, record.values or [math.nan] * width),
            )
            for place, record, of_run in zip(
                about.plan.places(claim.first, claim.last), records, signals, strict=True
            )
        ]  # fmt: skip
        failed = sum(record.failed for record in records)
        with self.store.writing() as connection:
            tries = connection.execute(
                "SELECT tries FROM chunk WHERE chunk = ? AND state != ?", (claim.chunk, DONE)
            ).fetchone()
            if tries is None:
                return False
            chunk = ChunkRow(claim.chunk, claim.first, claim.last, DONE, None, None, tries[0],
                             failed, seconds, None)  # fmt: skip
            connection.execute(
                "UPDATE chunk SET state = ?, owner = NULL, until = NULL, failed = ?, seconds = ?, "
                "digest = ? WHERE chunk = ?",
                (DONE, failed, seconds, chunk_digest(about, chunk, rows), claim.chunk),
            )
            places = ", ".join("?" * (6 + width))
            connection.executemany(f"INSERT INTO run VALUES ({places})", rows)
            connection.executemany(
                "INSERT INTO trajectory VALUES (?, ?, ?, ?)",
                (
                    (row[0], *signal)
                    for row, of_run in zip(rows, signals, strict=True)
                    for signal in of_run
                ),
            )
        self.progressed()
        return True

    def close(self) -> None:
        """Give back what was taken and not finished."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()
        with self.store.writing() as connection:
            connection.execute(
                "UPDATE chunk SET state = ?, owner = NULL, until = NULL "
                "WHERE state = ? AND owner = ?",
                (FREE, LEASED, self.owner),
            )

    def close_quietly(self) -> None:
        """The same where something else is wrong already, the disk full for instance."""
        with contextlib.suppress(StoreError):
            self.close()

    def _renew(self) -> None:
        """In a thread of its own, with a connection of its own."""
        while not self._stop.wait(LEASE / 3):
            if time.monotonic() - self._progress > STALL:
                continue
            try:
                with (
                    contextlib.closing(
                        sqlite3.connect(self.store.path, timeout=PATIENCE)
                    ) as connection,
                    connection,
                ):
                    connection.execute(
                        "UPDATE chunk SET until = ? WHERE state = ? AND owner = ?",
                        (time.time() + LEASE, LEASED, self.owner),
                    )
            except sqlite3.Error:
                continue  # who writes results next says what is wrong


def _stored(value: float) -> float | None:
    """SQLite knows no NaN and no negative zero."""
    return None if math.isnan(value) else float(value) + 0.0


def this_owner() -> str:
    """A name for the work that begins now in this process."""
    pid = os.getpid()
    return f"{_machine()}/{pid}/{_start_of(pid)}/{secrets.token_hex(4)}"


def is_gone(owner: str) -> bool:
    """Whether a process of this machine has ended; of another machine only its lease can tell."""
    try:
        machine, pid, start, _ = owner.rsplit("/", 3)
        number = int(pid)
    except ValueError:
        return False
    if machine != _machine():
        return False
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return True
    except OSError:  # of another user
        return False
    return _start_of(number) != start  # its number has been given to another process


def _machine() -> str:
    """The machine since it was started, as processes that can see each other know it."""
    boot = _text("/proc/sys/kernel/random/boot_id")[:8]
    try:
        seen = os.readlink("/proc/self/ns/pid")
    except OSError:
        seen = ""
    return f"{socket.gethostname()}:{boot}:{seen}".replace("/", "_")


def _start_of(pid: int) -> str:
    """When a process was started, in the system's own units; empty where it does not say."""
    after_name = _text(f"/proc/{pid}/stat").rpartition(")")[2].split()
    return after_name[19] if len(after_name) > 19 else ""


def _text(path: str) -> str:
    try:
        return Path(path).read_text()
    except OSError:
        return ""
