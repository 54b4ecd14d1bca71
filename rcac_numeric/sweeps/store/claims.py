"""Chunks of a store that a process has taken, with a lease, so that nobody else runs them."""

from __future__ import annotations

import contextlib
import math
import sqlite3
import threading
import time
import zlib
from dataclasses import dataclass
from typing import Any

from rcac_numeric.sweeps.chunks.chunk import RunRecord
from rcac_numeric.sweeps.store.owners import is_gone, this_owner
from rcac_numeric.sweeps.store.problems import StoreError, explained
from rcac_numeric.sweeps.store.schema import DONE, FREE, LEASED
from rcac_numeric.sweeps.store.store import PATIENCE, Store

LEASE = 60.0  # seconds; renewed every third of them


@dataclass(frozen=True)
class Claim:
    """A chunk that this process may run: its runs first, ..., last."""

    chunk: int
    first: int
    last: int
    tries: int


class Claims:
    """What this process has taken from a store; to be closed, so that the rest is free again.

    Parameters
    ----------
    store : Store
    """

    def __init__(self, store: Store) -> None:
        self.store, self.owner, self._blocks = store, this_owner(), store.blocks
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        if store.journal == "wal":  # with the other nobody else has the file anyway
            self._thread = threading.Thread(target=self._renew, daemon=True)
            self._thread.start()

    def take(self) -> Claim | None:
        """A free chunk, or one whose owner let its lease run out; None where there is none."""
        now = time.time()
        with self.store.writing() as connection:
            row = connection.execute(
                "UPDATE chunk SET state = ?, owner = ?, until = ? WHERE chunk = (SELECT chunk "
                "FROM chunk WHERE state = ? ORDER BY chunk LIMIT 1) "
                "RETURNING chunk, first, last, tries",
                (LEASED, self.owner, now + LEASE, FREE),
            ).fetchall()
        return Claim(*row[0]) if row else None

    def take_over(self) -> int:
        """Free what processes that are gone, or whose lease has run out, had taken; how many."""
        with explained(self.store.path):
            owners = self.store.connection.execute(
                "SELECT DISTINCT owner FROM chunk WHERE state = ?", (LEASED,)
            ).fetchall()
        alone = self.store.journal != "wal"
        gone = [o for (o,) in owners if o != self.owner and (alone or is_gone(o))]
        freed = 0
        with self.store.writing() as connection:
            for owner in gone:
                freed += connection.execute(
                    "UPDATE chunk SET state = ? WHERE state = ? AND owner = ?",
                    (FREE, LEASED, owner),
                ).rowcount
            freed += connection.execute(
                "UPDATE chunk SET state = ? WHERE state = ? AND owner != ? AND until < ?",
                (FREE, LEASED, self.owner, time.time()),
            ).rowcount
        return freed

    @property
    def others(self) -> bool:
        """Whether another process is at work on the rest."""
        with explained(self.store.path):
            return bool(
                self.store.connection.execute(
                    "SELECT count(*) FROM chunk WHERE state = ? AND owner != ?",
                    (LEASED, self.owner),
                ).fetchone()[0]
            )

    def failed(self, claim: Claim) -> Claim:
        """Note that a chunk took its worker with it, or was lost with one; it is still ours."""
        with self.store.writing() as connection:
            connection.execute(
                "UPDATE chunk SET tries = tries + 1 WHERE chunk = ? AND owner = ?",
                (claim.chunk, self.owner),
            )
        return Claim(claim.chunk, claim.first, claim.last, claim.tries + 1)

    def finish(self, claim: Claim, records: list[RunRecord], seconds: float) -> bool:
        """Store the records of a chunk; False where the chunk has meanwhile been given away."""
        rows = [self._row(record) for record in records]
        with self.store.writing() as connection:
            mine = connection.execute(
                "UPDATE chunk SET state = ?, owner = NULL, until = NULL, crc = ?, seconds = ? "
                "WHERE chunk = ? AND state = ? AND owner = ?",
                (DONE, checksum(rows), seconds, claim.chunk, LEASED, self.owner),
            ).rowcount
            if not mine:
                return False
            places = ", ".join("?" * len(rows[0]))
            connection.executemany(f"INSERT INTO run VALUES ({places})", rows)
            connection.executemany(
                "INSERT INTO trajectory VALUES (?, ?, ?, ?)",
                (
                    (record.run, name, ",".join(map(str, a.shape)), a.astype("<f8").tobytes())
                    for record in records
                    for name, a in record.signals.items()
                ),
            )
        return True

    def close(self) -> None:
        """Give back what was taken and not finished."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()
        with self.store.writing() as connection:
            connection.execute(
                "UPDATE chunk SET state = ?, owner = NULL WHERE state = ? AND owner = ?",
                (FREE, LEASED, self.owner),
            )

    def close_quietly(self) -> None:
        """The same where something else is wrong already, the disk full for instance."""
        with contextlib.suppress(StoreError):
            self.close()

    def _row(self, record: RunRecord) -> tuple[Any, ...]:
        block = next(b for b in reversed(self._blocks) if b.first_run <= record.run)
        # SQLite knows no NaN and no negative zero.
        values = (None if math.isnan(v) else float(v) + 0.0 for v in record.values)
        return (record.run, *block.place(record.run), record.outcome, record.error, *values)

    def _renew(self) -> None:
        """In a thread of its own, with a connection of its own."""
        while not self._stop.wait(LEASE / 3):
            try:
                connection = sqlite3.connect(self.store.path, timeout=PATIENCE)
                with connection:
                    connection.execute(
                        "UPDATE chunk SET until = ? WHERE state = ? AND owner = ?",
                        (time.time() + LEASE, LEASED, self.owner),
                    )
                connection.close()
            except sqlite3.Error:
                continue  # who writes results next says what is wrong


def checksum(rows: list[tuple[Any, ...]]) -> int:
    """A number that changes with any bit of the rows of a chunk."""
    return zlib.crc32(repr(rows).encode())
