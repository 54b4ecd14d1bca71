"""The file of a study: opened, made, compared with what is asked for, grown, read.

Every chunk of runs has a digest of its rows, each row one of its signals, and the study one of
itself; which cells, runs and chunks there are follows from the study, and what the tables say of
them is held against that. So no bit of a result can change, and no row come or go, unseen.
"""

from __future__ import annotations

import itertools
import json
import math
import os
import secrets
import sqlite3
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compensator_theory.errors import CompensatorError
from rcac_experiments.sweeps._axes import Axis
from rcac_experiments.sweeps._beside import header_of, require_ours
from rcac_experiments.sweeps._canonical import canonical_json, digest
from rcac_experiments.sweeps._chunk import FAILED
from rcac_experiments.sweeps._measures import require_column
from rcac_experiments.sweeps._plan import Plan, Resolved, Stage, grown, stage_of
from rcac_experiments.sweeps._problems import StoreError, damaged, explained, without_study
from rcac_experiments.sweeps._study import LARGEST_GRID, SIGNALS, Study
from rcac_experiments.sweeps._versions import versions
from rcac_numeric.arrays._array_types import Array

FORMAT = 2
APPLICATION = 0x52434143  # "RCAC": what `file` and SQLite know the file by
FREE, LEASED, DONE = 0, 1, 2  # states of a chunk
PATIENCE = 60.0  # seconds that SQLite waits for another process
LARGEST_CHUNK = 512  # runs
LONGEST_LEASE = 600.0  # seconds from now; one that lasts longer was not asked for by this package
JOURNALS = {"wal": "WAL", "rollback": "DELETE"}
Row = tuple[Any, ...]

# All that reading a study that is none may raise.
NO_STUDY = (
    CompensatorError,
    LookupError,
    TypeError,
    ValueError,
    AttributeError,
    ArithmeticError,
    RecursionError,
)
# What is in a study, see `Study.resolved`.
KEYS = {
    "base", "files", "axes", "keep", "repetitions", "seed", "common_noise", "lanes",
    "keep_signals",
}  # fmt: skip

# What SQLite keeps of these statements is compared letter by letter: a store holds these tables
# and nothing else, no view and no trigger above all.
FIXED = {
    "study": "CREATE TABLE study (resolved TEXT, fingerprint TEXT, file TEXT, title TEXT, "
    "versions TEXT, instruction_set TEXT, created TEXT, chunk_size INTEGER, stages TEXT, "
    "mixed TEXT, origin TEXT, digest TEXT)",
    "chunk": "CREATE TABLE chunk (chunk INTEGER PRIMARY KEY, first INTEGER, last INTEGER, "
    "state INTEGER, owner TEXT, until REAL, tries INTEGER, failed INTEGER, seconds REAL, "
    "digest TEXT)",
    "trajectory": "CREATE TABLE trajectory (run INTEGER, name TEXT, shape TEXT, float64 BLOB, "
    "PRIMARY KEY (run, name)) WITHOUT ROWID",
}
# Of a row of `chunk`.
_TEXT, _REAL = (str, type(None)), (float, type(None))
KINDS = ((int,), (int,), (int,), (int,), _TEXT, _REAL, (int,), (int,), _REAL, _TEXT)
# The columns of a row of `run` before those of the measures.
OF_EVERY_RUN = ("run", "cell", "repetition", "outcome", "failure", "signals_digest")


@dataclass(frozen=True)
class StudyRow:
    """What a store says of its study.

    `versions` and `instruction_set` are those that it was begun with, `mixed` what differed when
    others went on with it; `origin` is drawn once for each store, and every chunk is bound to it.
    """

    resolved: Resolved
    fingerprint: str
    file: str
    title: str
    versions: dict[str, str]
    instruction_set: str
    created: str
    chunk_size: int
    plan: Plan
    mixed: tuple[str, ...]
    origin: str

    @property
    def axes(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(axis["name"] for axis in self.resolved["axes"])

    @property
    def measures(self) -> tuple[str, ...]:
        """The names of the columns of measures."""
        return tuple(kept["name"] for kept in self.resolved["keep"])


@dataclass(frozen=True)
class ChunkRow:
    """What a store says of a chunk."""

    chunk: int
    first: int
    last: int
    state: int
    owner: str | None
    until: float | None
    tries: int
    failed: int
    seconds: float | None
    digest: str | None


class Store:
    """An open store."""

    def __init__(self, path: str | Path, journal: str = "wal", read_only: bool = False) -> None:
        self.path, self.journal = Path(path), journal
        self._study: StudyRow | None = None
        header = header_of(self.path)
        # SQLite acts on what lies beside a file before it reads the file.
        pages = require_ours(self.path)
        if read_only and header is None:
            raise StoreError(f"{path} cannot be read: there is no such file.")
        if header and (
            header.application not in (None, 0, APPLICATION) or (header.application == 0 and pages)
        ):
            raise StoreError(_foreign(self.path, "it is a database of another program"))
        if header and not read_only and pages is None:
            self._open("ro", read_only=True)
            self.close()
        self._open("ro" if read_only else "rwc", read_only)

    def _open(self, mode: str, read_only: bool) -> None:
        mode += "&immutable=1" if mode == "ro" and _is_at_rest(self.path) else ""
        with explained(self.path):
            self.connection = sqlite3.connect(
                f"{self.path.absolute().as_uri()}?mode={mode}",
                uri=True, timeout=PATIENCE, isolation_level=None, check_same_thread=False,
            )  # fmt: skip
        try:
            with explained(self.path):
                self._settle(read_only)
        except BaseException:
            self.connection.close()
            raise

    @property
    def is_new(self) -> bool:
        """Whether nothing was stored in it yet."""
        with explained(self.path):
            return not self.connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]

    @property
    def bytes_held(self) -> int:
        """Of the file and of what stands beside it until it is put in."""
        with explained(self.path):
            pages, size = (self.connection.execute(f"PRAGMA {name}").fetchone()[0]
                           for name in ("page_count", "page_size"))  # fmt: skip
        return int(pages * size)

    @contextmanager
    def writing(self) -> Iterator[sqlite3.Connection]:
        """One transaction: all of it is stored, or nothing."""
        with explained(self.path):
            self.connection.execute("BEGIN IMMEDIATE")
            try:
                yield self.connection
                self.connection.execute("COMMIT")
            except BaseException:
                if self.connection.in_transaction:  # where the disk is full it is over already
                    self.connection.execute("ROLLBACK")
                raise

    # What is made.

    def create(self, study: Study, instruction_set: str, chunk_size: int) -> bool:
        """Write down the study, its cells and its chunks; False where another process just did."""
        with self.writing():
            if not self.is_new:
                return False
            resolved = json.loads(json.dumps(study.resolved))
            about = StudyRow(
                resolved, digest(canonical_json(resolved)), str(Path(study.file).resolve()),
                study.title, versions(), instruction_set,
                time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()), chunk_size,
                _plan(resolved, (stage_of(resolved),), chunk_size), (), secrets.token_hex(8),
            )  # fmt: skip
            self.create_as(about)
            self.add_chunks(1, about.plan)
        return True

    def create_as(self, about: StudyRow) -> None:
        """Make the tables, and write down a study and its cells, in a transaction of the caller."""
        execute = self.connection.execute
        for statement in tables_of(about).values():
            execute(statement)
        execute(f"PRAGMA user_version = {FORMAT}")
        execute(f"PRAGMA application_id = {APPLICATION}")
        self.write_study(about)
        self._add_cells(0, about.plan)

    def grow(self, study: Study) -> None:
        """Add what the study asks for and the store has not; refuse another study."""
        with self.writing():
            about = self.refreshed()
            new = grown(self.path, about.resolved, json.loads(json.dumps(study.resolved)))
            if canonical_json(new) == canonical_json(about.resolved):
                return
            stages = (*about.plan.stages, stage_of(new))
            plan = _plan(new, stages, about.chunk_size)
            self.write_study(
                replace(about, resolved=new, fingerprint=digest(canonical_json(new)), plan=plan)
            )
            self._add_cells(about.plan.cells, plan)
            self.add_chunks(about.plan.chunks + 1, plan)

    def note_mixed(self, words: Sequence[str]) -> None:
        """Write down what differs from what the store was begun with, for good."""
        with self.writing():
            about = self.refreshed()
            if new := [w for w in words if w not in about.mixed]:
                self.write_study(replace(about, mixed=(*about.mixed, *new)))

    def write_study(self, about: StudyRow) -> None:
        """Put a study in the place of what is said of one."""
        row: list[Any] = [
            json.dumps(about.resolved), about.fingerprint, _encodable(about.file),
            _encodable(about.title), json.dumps(about.versions), about.instruction_set,
            about.created, about.chunk_size,
            json.dumps([[list(s.lengths), s.repetitions] for s in about.plan.stages]),
            json.dumps(about.mixed), about.origin,
        ]  # fmt: skip
        places = ", ".join("?" * (len(row) + 1))
        self.connection.execute("DELETE FROM study")
        self.connection.execute(f"INSERT INTO study VALUES ({places})", (*row, digest_of(row)))
        self._study = None

    def set_free(self, chunks: Sequence[tuple[int, int, int]]) -> None:
        """Forget the runs of some chunks (number, first, last), so that they are run again."""
        with self.writing() as connection:
            for chunk, first, last in chunks:
                for table in ("run", "trajectory"):
                    connection.execute(
                        f"DELETE FROM {table} WHERE run BETWEEN ? AND ?", (first, last)
                    )
                connection.execute(
                    "UPDATE chunk SET state = ?, owner = NULL, until = NULL, tries = 0, "
                    "failed = 0, seconds = NULL, digest = NULL WHERE chunk = ?", (FREE, chunk),
                )  # fmt: skip

    # What is read.

    @property
    def study(self) -> StudyRow:
        """What is said of the study, as it was when it was last read."""
        return self._study or self.refreshed()

    def refreshed(self) -> StudyRow:
        """What is said of the study now: another process may have made it grow."""
        if self.is_new:
            raise StoreError(
                f"{self.path} is empty: no study was stored in it. If a sweep into it was killed "
                "at its beginning, give the same `rcac sweep` again."
            )
        with explained(self.path):
            rows = self.connection.execute("SELECT * FROM study").fetchall()
        if len(rows) != 1 or not _is_digest(rows[0][-1], list(rows[0][:-1])):
            raise StoreError(without_study(self.path, "its study is not what was written"))
        try:
            self._study = _study_row(rows[0][:-1])
        except NO_STUDY as error:
            # Somebody wrote it so: its digest is right.
            raise StoreError(without_study(self.path, f"its study is none ({error})")) from None
        return self._study

    def chunks(self) -> list[ChunkRow]:
        """All chunks, held against the plan, and the number of rows against them."""
        plan = self.study.plan
        with explained(self.path):
            found = [ChunkRow(*row) for row in
                     self.connection.execute("SELECT * FROM chunk ORDER BY chunk")]  # fmt: skip
            rows = self.connection.execute("SELECT count(*) FROM run").fetchone()[0]
        if len(found) != plan.chunks:
            raise StoreError(
                damaged(self.path, f"it has {len(found)} chunks of runs and not {plan.chunks}")
            )
        for number, chunk in enumerate(found, 1):
            if fault := chunk_fault(plan, number, chunk):
                raise StoreError(damaged(self.path, fault))
        ended = sum(chunk.last - chunk.first + 1 for chunk in found if chunk.state == DONE)
        if rows != ended:
            raise StoreError(
                damaged(self.path, f"it has {rows} rows of runs, where {ended} runs have ended")
            )
        return found

    def rows(self, chunk: ChunkRow) -> list[Row]:
        """The rows of a chunk that has ended, by increasing run."""
        with explained(self.path):
            rows = self.connection.execute(
                "SELECT * FROM run WHERE run BETWEEN ? AND ? ORDER BY run",
                (chunk.first, chunk.last),
            ).fetchall()
        if fault := rows_fault(self.study, chunk, rows):
            raise StoreError(damaged(self.path, fault))
        return rows

    def all_rows(self) -> Iterator[list[Row]]:
        """The rows of each chunk that has ended, by increasing run."""
        for chunk in self.chunks():
            if chunk.state == DONE:
                yield self.rows(chunk)

    def row(self, run: int) -> Row:
        """One row."""
        plan = self.study.plan
        if not 0 <= run < plan.runs:
            raise StoreError(f"{self.path} has no run {run}; its runs are 0 to {plan.runs - 1}.")
        chunk = self.chunks()[plan.chunk_of(run) - 1]
        if chunk.state != DONE:
            raise StoreError(f"run {run} of {self.path} has not been run yet.")
        return self.rows(chunk)[run - chunk.first]

    def signals(self, row: Row) -> dict[str, Array]:
        """The signals that were kept of a run, by its row."""
        found = self.stored_signals(row[0])
        if fault := signals_fault(self.study, row, found):
            raise StoreError(damaged(self.path, fault))
        return {
            name: np.frombuffer(data, "<f8").reshape([int(n) for n in shape.split(",")])
            for name, shape, data in found
        }

    def stored_signals(self, run: int) -> list[Row]:
        """The rows of the signals of a run (name, shape, bytes), as they stand there."""
        with explained(self.path):
            return self.connection.execute(
                "SELECT name, shape, float64 FROM trajectory WHERE run = ? ORDER BY name", (run,)
            ).fetchall()

    def cell_columns(self, cells: Sequence[int] | NDArray[np.int64]) -> dict[str, NDArray[Any]]:
        """The coordinates of some cells, an array for each axis."""
        plan = self.study.plan
        by_axis = zip(plan.values.items(), plan.indices(cells), strict=True)
        return {name: column(values)[places] for (name, values), places in by_axis}

    def counts(self) -> tuple[int, int, int]:
        """Runs that have ended, runs in all, and how many of those that ended failed."""
        with explained(self.path):
            done, whole, failed = self.connection.execute(
                "SELECT total((last - first + 1) * (state = ?)), total(last - first + 1), "
                "total(failed) FROM chunk", (DONE,),
            ).fetchone()  # fmt: skip
        return int(done), int(whole), int(failed)

    def close(self) -> None:
        """Let go of the file."""
        self.connection.close()

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _settle(self, read_only: bool) -> None:
        execute = self.connection.execute
        execute("PRAGMA trusted_schema = OFF")
        execute("PRAGMA cell_size_check = ON")
        if read_only:
            execute("BEGIN")
        is_new = self.is_new
        application, form = (execute(f"PRAGMA {n}").fetchone()[0] for n in
                             ("application_id", "user_version"))  # fmt: skip
        if not is_new and application != APPLICATION:
            raise StoreError(_foreign(self.path, "it is a database of another program"))
        if not is_new and form != FORMAT:
            raise StoreError(
                f"{self.path} is written in format {form}; this version reads {FORMAT}, in which "
                "every result is held against a digest. Export it with the version that wrote it "
                "(`rcac show --export`), or run the study into a new file."
            )
        if not is_new:
            self._require_tables()
        if read_only:
            return
        if self.journal == "rollback":
            execute("PRAGMA locking_mode = EXCLUSIVE")
        _patiently(lambda: execute(f"PRAGMA journal_mode = {JOURNALS[self.journal]}"))
        # With WAL a loss of power can take the last chunks, and never damages the file.
        execute("PRAGMA synchronous = NORMAL" if self.journal == "wal" else
                "PRAGMA synchronous = FULL")  # fmt: skip

    def _require_tables(self) -> None:
        """Refuse other tables than ours, before any of them is read."""
        found = {
            name: (kind, sql)
            for kind, name, sql in self.connection.execute(
                "SELECT type, name, sql FROM sqlite_master"
            )
        }
        fixed = {name: ("table", sql) for name, sql in FIXED.items()}
        if found.keys() == {*fixed, "cell", "run"} and fixed.items() <= found.items():
            expected = {name: ("table", sql) for name, sql in tables_of(self.refreshed()).items()}
            if found == expected:
                return
        raise StoreError(without_study(self.path, "its tables are not those of a store"))

    def _add_cells(self, first: int, plan: Plan) -> None:
        """For whoever joins tables in SQL; what is read here follows from the plan."""
        places = ", ".join("?" * (1 + len(plan.values)))
        self.connection.executemany(f"INSERT INTO cell VALUES ({places})", cell_rows(plan, first))

    def add_chunks(self, first: int, plan: Plan) -> None:
        """Make the chunks of a plan from one on, all of them free."""
        self.connection.executemany(
            "INSERT INTO chunk VALUES (?, ?, ?, ?, NULL, NULL, 0, 0, NULL, NULL)",
            ((n, *plan.chunk(n), FREE) for n in range(first, plan.chunks + 1)),
        )


def tables_of(about: StudyRow) -> dict[str, str]:
    """The statements that make the tables; a column for every axis and for every measure."""
    coordinates = "".join(f', "{name}"' for name in about.axes)
    measures = "".join(f', "{name}" REAL' for name in about.measures)
    return {
        **FIXED,
        "cell": f"CREATE TABLE cell (cell INTEGER PRIMARY KEY{coordinates})",
        "run": "CREATE TABLE run (run INTEGER PRIMARY KEY, cell INTEGER, repetition INTEGER, "
        f"outcome TEXT, failure TEXT, signals_digest TEXT{measures})",
    }


def cell_rows(plan: Plan, first: int = 0) -> Iterator[Row]:
    """The rows of the table `cell`; what is no number or text stands there as JSON."""
    for number, values in enumerate(plan.all_cells(first), first):
        yield (number, *(_coordinate(value) for value in values))


def digest_of(value: Any) -> str:
    """A digest of texts, numbers and lists of them, the same in every version of Python."""
    text = json.dumps(value, separators=(",", ":"))
    return blake2b(text.encode(), digest_size=16).hexdigest()


def chunk_digest(about: StudyRow, chunk: ChunkRow, rows: list[Row]) -> str:
    """What binds the rows of a chunk to their values, their place, and their store."""
    of_chunk = (chunk.chunk, chunk.first, chunk.last, chunk.tries, chunk.failed, chunk.seconds)
    return digest_of([about.origin, of_chunk, rows])


def signals_digest(signals: Sequence[Row]) -> str | None:
    """What the row of a run says of its signals (name, shape, bytes), by increasing name."""
    if not signals:
        return None
    found = blake2b(digest_size=16)
    for name, shape, data in signals:
        head = json.dumps([name, shape, len(data)]).encode()
        found.update(len(head).to_bytes(8, "little") + head)
        found.update(data)
    return found.hexdigest()


def chunk_fault(plan: Plan, number: int, chunk: ChunkRow) -> str:
    """What is wrong with what is said of a chunk; nothing where it fits the plan."""
    if (chunk.chunk, chunk.first, chunk.last) != (number, *plan.chunk(number)):
        return f"the chunk {number} of its runs is not where it belongs"
    if chunk.state not in (FREE, LEASED, DONE):
        return f"the chunk {number} of its runs is in a state that there is not"
    if (chunk.state == DONE) != (chunk.digest is not None):
        return f"the chunk {number} of its runs has ended and has not"
    kinds = tuple(map(type, vars(chunk).values()))
    if not all(kind in of for kind, of in zip(kinds, KINDS, strict=True)):
        return f"what is said of the chunk {number} of its runs is of another kind"
    if (
        chunk.tries < 0
        or not 0 <= chunk.failed <= chunk.last - chunk.first + 1
        or not (chunk.seconds is None or 0 <= chunk.seconds < math.inf)
    ):
        return f"what is said of the chunk {number} of its runs is out of range"
    no_owner = chunk.state == LEASED or (chunk.owner, chunk.until) == (None, None)
    no_result = chunk.state == DONE or (chunk.failed, chunk.seconds) == (0, None)
    if not (no_owner and no_result):
        return f"the chunk {number} of its runs says what only another state of it can"
    return ""


def rows_fault(about: StudyRow, chunk: ChunkRow, rows: list[Row]) -> str:
    """What is wrong with the rows of a chunk that has ended; nothing where nothing is."""
    where = f"the runs {chunk.first} to {chunk.last}"
    if len(rows) != chunk.last - chunk.first + 1:
        return f"{where} are not what was stored: there are {len(rows)} rows"
    try:
        if chunk_digest(about, chunk, rows) != chunk.digest:
            return f"{where} are not what was stored"
    except TypeError:  # bytes
        return f"{where} are not what was stored"
    # From here on only who can compute digests comes: the numbers are what he wrote.
    if [row[:3] for row in rows] != about.plan.places(chunk.first, chunk.last):
        return f"{where} are not those of the study"
    kinds = {type(value) for row in rows for value in row[6:]}
    if not kinds <= {float, type(None)} or not all(
        type(row[3]) is str and type(row[4]) is str and type(row[5]) in (str, type(None))
        for row in rows
    ):
        return f"{where} hold what is no number"
    failed = [row for row in rows if row[3] in FAILED]
    if len(failed) != chunk.failed or any(value is not None for r in failed for value in r[5:]):
        return f"{where} failed and did not"
    return ""


def signals_fault(about: StudyRow, row: Row, found: list[Row]) -> str:
    """What is wrong with the signals of a run; nothing where nothing is."""
    where = f"the signals of run {row[0]}"
    try:
        if signals_digest(found) != row[5]:
            return f"{where} are not what was stored"
        expected = about.resolved["keep_signals"] if found else []
        if sorted(expected) != [name for name, _, _ in found]:
            return f"{where} are not those of the study"
        for _, shape, data in found:
            sizes = [int(n) for n in shape.split(",")]
            if min(sizes) < 0 or 8 * math.prod(sizes) != len(data):
                return f"{where} have no such shape"
    except (TypeError, ValueError, AttributeError):
        return f"{where} are not what was stored"
    return ""


def column(values: list[Any]) -> NDArray[Any]:
    """An array of one kind: integers, floats, texts, truth values; else of objects."""
    kinds = {type(value) for value in values}
    if kinds <= {int} or kinds <= {bool} or kinds <= {str}:
        return np.array(values)
    if kinds <= {int, float}:
        return np.array(values, dtype=np.float64)
    array = np.empty(len(values), dtype=object)
    array[:] = values
    return array


def _study_row(row: Row) -> StudyRow:
    """Raises what a study that is none makes it raise."""
    resolved, versions_, stages, mixed = (json.loads(row[i]) for i in (0, 4, 8, 9))
    texts = (row[1], row[2], row[3], row[5], row[6], row[10])
    if not all(type(text) is str for text in texts) or type(row[7]) is not int:
        raise ValueError("something in it is of another kind")
    if not 1 <= row[7] <= LARGEST_CHUNK:
        raise ValueError(f"a chunk of {row[7]} runs; there are 1 to {LARGEST_CHUNK}")
    if type(mixed) is not list or not all(type(words) is str for words in mixed):
        raise TypeError("what was mixed is no list of texts")
    if row[1] != digest(canonical_json(resolved)):
        raise ValueError("its fingerprint is that of another one")
    if not all(type(k) is str and type(v) is str for k, v in versions_.items()):
        raise TypeError("a version is no text")
    return StudyRow(
        resolved=resolved,
        fingerprint=row[1],
        file=row[2],
        title=row[3],
        versions=versions_,
        instruction_set=row[5],
        created=row[6],
        chunk_size=row[7],
        plan=_plan(resolved, tuple(Stage(tuple(n), r) for n, r in stages), row[7]),
        mixed=tuple(mixed),
        origin=row[10],
    )


def _plan(resolved: Resolved, stages: tuple[Stage, ...], chunk_size: int) -> Plan:
    """The plan of a study; raises where it cannot be one."""
    if resolved.keys() != KEYS or type(resolved["seed"]) is not int:
        raise ValueError("it has not what a study has")
    axes = [Axis(axis["name"], axis["values"], axis["sets"]) for axis in resolved["axes"]]
    for kept in resolved["keep"]:
        require_column(kept["name"])
        if not isinstance(kept["arguments"], dict):
            raise TypeError("the arguments of a measure are no table")
    names = [*(axis.name for axis in axes), *(kept["name"] for kept in resolved["keep"])]
    if len({name.lower() for name in names}) != len(names):
        raise ValueError("two columns have one name")
    if not set(resolved["keep_signals"]) <= set(SIGNALS):
        raise ValueError("no such signals are kept")
    sizes = [(*stage.lengths, stage.repetitions) for stage in stages]
    if not all(type(n) is int and n > 0 for size in sizes for n in size):
        raise ValueError("a size is no number")
    # Each stage has all that the one before had, and the last is the study as it is.
    for before, after in itertools.pairwise(sizes):
        if not all(a <= b for a, b in zip(before, after, strict=True)):
            raise ValueError("it has shrunk")
    if stages[-1] != stage_of(resolved) or stages[-1].cells > LARGEST_GRID:
        raise ValueError("its size is that of another one")
    return Plan({axis.name: list(axis.values) for axis in axes}, stages, chunk_size)


def _coordinate(value: Any) -> Any:
    plain = isinstance(value, str | float) or (type(value) is int and abs(value) < 2**63)
    return value if plain else json.dumps(value)


def _is_digest(found: Any, of: Any) -> bool:
    try:
        return bool(found == digest_of(of))
    except (TypeError, ValueError):
        return False


def _encodable(text: str) -> str:
    """The path of a file may hold bytes that are no text."""
    return text.encode("utf-8", "backslashreplace").decode()


def _foreign(path: Path, what: str) -> str:
    return (
        f"{path} is damaged or no store of a study: {what}. Nothing was changed. Run the study "
        "into a new file."
    )


def _is_at_rest(path: Path) -> bool:
    """Whether nobody may write here, and no results wait beside the file to be put into it.

    SQLite makes files beside a database that it only reads; where it may not, it reads none.
    """
    real = Path(os.path.realpath(path))
    if os.access(real.parent, os.W_OK):
        return False
    beside = (real.with_name(real.name + end) for end in ("-wal", "-journal"))
    return not any(file.exists() and file.stat().st_size for file in beside)


def _patiently(change: Callable[[], object]) -> None:
    """What SQLite refuses at once while another process does the same."""
    for pause in (0.05, 0.2, 0.5, 1.0, 2.0):
        try:
            change()
        except sqlite3.OperationalError as error:
            if "locked" not in str(error):
                raise
            time.sleep(pause)
        else:
            return
    change()
