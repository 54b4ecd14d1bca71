"""The store of a study: a folder with study.toml, and a file for each chunk of runs that has ended.

Results are deterministic. So nothing is locked, leased or repaired: a chunk that is computed twice
is the same chunk, and one that is missing or damaged is computed again.
"""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcac_experiments.sweeps._chunk import FAILED, RunRecord
from rcac_experiments.sweeps._chunk_files import (
    INTEGER,
    INTEGERS,
    NUMBER,
    NUMBERS,
    TEXT,
    TRUTH,
    Columns,
    Damaged,
    Layout,
    encode,
)
from rcac_experiments.sweeps._directory import PART, Directory, NotOurs
from rcac_experiments.sweeps._problems import StoreError
from rcac_experiments.sweeps._reader import file_of, read_guarded, read_here
from rcac_experiments.sweeps._study import Study
from rcac_experiments.sweeps._study_file import (
    LARGEST_FILE,
    NO_STUDY,
    StoredStudy,
    begun,
    read_text,
    text_of,
)

STUDY, CHUNKS = "study.toml", "chunks"
SQLITE = b"SQLite format 3\0"
EXACT = 2**53  # integers up to it are float64


@dataclass(frozen=True)
class Chunk:
    """A chunk whose file is there: its runs first, ..., last, and its columns, or a fault."""

    number: int
    first: int
    last: int
    columns: Columns
    fault: str = ""

    @property
    def failed(self) -> int:
        """How many of its runs failed."""
        return sum(outcome in FAILED for outcome in self.columns.get("outcome", ()))


class Folder:
    """An open store."""

    def __init__(self, path: str | Path, make: bool = False) -> None:
        self.path = Path(path)
        self._about: StoredStudy | None = None
        self._text = b""
        _require_folder(self.path, make)
        try:
            self.directory = Directory(self.path)
        except (OSError, ValueError) as error:
            words = getattr(error, "strerror", None) or error
            raise StoreError(f"{str(path)!r} cannot be read: {words}.") from None
        self._chunks: Directory | None = None
        self._layouts: dict[int, Layout] = {}

    def close(self) -> None:
        """Let go of it."""
        if self._chunks is not None:
            self._chunks.close()
        self.directory.close()

    def __enter__(self) -> Folder:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    # The study.

    @property
    def is_new(self) -> bool:
        """Whether no study is in it yet; a folder with other things in it is refused."""
        try:
            self._text = self.directory.read(STUDY, LARGEST_FILE)
        except NotOurs as fault:
            raise StoreError(self._without_study(str(fault))) from None
        except FileNotFoundError:
            others = [n for n in self.directory.names() if n != CHUNKS and not _is_part(n)]
            if others or self.numbers():
                raise StoreError(
                    f"{self.path} is no store of a study: it has no {STUDY}, and other things are "
                    "in it. Nothing was changed. Give a folder of its own, which `rcac sweep` "
                    "makes; a store whose study was lost is taken from a copy."
                ) from None
            return True
        return False

    @property
    def study(self) -> StoredStudy:
        """What is said of the study, as it was when it was last read."""
        return self._about or self.refreshed()

    def refreshed(self) -> StoredStudy:
        """What is said of the study now: another process may have made it grow."""
        before = self._text
        if self.is_new:
            raise StoreError(
                f"{self.path} is empty: no study was stored in it. If a sweep into it was killed "
                "at its beginning, give the same `rcac sweep` again."
            )
        if self._about is None or self._text != before:
            try:
                self._about, self._layouts = read_text(self._text), {}
            except NO_STUDY as error:
                raise StoreError(self._without_study(str(error))) from None
        return self._about

    @property
    def text(self) -> bytes:
        """study.toml as it was last read."""
        return self._text

    def create(self, study: Study, instruction_set: str, chunk_size: int) -> None:
        """Write down the study, unless another process just did."""
        self.begin(begun(study, instruction_set, chunk_size))

    def begin(self, about: StoredStudy) -> None:
        """The same of a study that was begun elsewhere."""
        text = text_of(about)
        self.directory.make(CHUNKS)
        self.directory.put(STUDY, text.encode(), new=True)

    def write(self, about: StoredStudy) -> None:
        """Put what is said of the study in the place of what was said."""
        if about != self.study:
            self.directory.make(CHUNKS)
            self.directory.put(STUDY, text_of(about).encode())

    def grow(self, study: Study, mixed: Sequence[str] = (), *, among_others: bool = False) -> None:
        """Add what the study asks for and the store has not, and what was mixed into it."""
        about = self.refreshed()
        words = (*about.mixed, *(w for w in mixed if w not in about.mixed))
        new = about.grown(self.path, study, among_others=among_others)
        self.write(replace(new, mixed=words))
        self.refreshed()

    # The chunks.

    @property
    def chunks(self) -> Directory | None:
        """The folder with the files of chunks; None where there is none."""
        if self._chunks is None:
            self._chunks = self.directory.inside(CHUNKS)
        return self._chunks

    def numbers(self) -> list[int]:
        """The chunks of which there is a file."""
        found = (_number(name) for name in (self.chunks.names() if self.chunks else ()))
        return sorted(number for number in found if number is not None)

    def strangers(self) -> list[str]:
        """What is beside the files of chunks, and would be read with them by others."""
        names = self.chunks.names() if self.chunks else []
        most = self.study.plan.chunks
        return sorted(
            name for name in names if not _is_part(name) and not 0 < (_number(name) or 0) <= most
        )

    def layout(self, number: int) -> Layout:
        """The columns of a chunk."""
        stage = self.study.plan.stage_of(number)
        if stage not in self._layouts:
            self._layouts[stage] = self._layout(number)
        return self._layouts[stage]

    def _layout(self, number: int) -> Layout:
        about = self.study
        values = about.plan.values_of(number)
        signals = about.resolved["keep_signals"]
        return Layout(about.name, (
            ("run", INTEGER), ("cell", INTEGER), ("repetition", INTEGER),
            *((name, _kind(known)) for name, known in values.items()),
            ("outcome", TEXT), ("failure", TEXT), *((name, NUMBER) for name in about.measures),
            *((f"{name}.values", NUMBERS) for name in signals),
            *((f"{name}.shape", INTEGERS) for name in signals),
        ))  # fmt: skip

    def put(self, number: int, records: Iterable[RunRecord]) -> None:
        """Write the file of a chunk."""
        if self.chunks is None:
            self.directory.make(CHUNKS)
        about, layout = self.study, self.layout(number)
        records = sorted(records, key=lambda record: record.run)
        columns: dict[str, Sequence[Any]] = {
            **_planned(about, number, layout),
            "outcome": [record.outcome for record in records],
            "failure": [record.error for record in records],
        }
        for i, name in enumerate(about.measures):
            columns[name] = [_stored(r.values[i]) if r.values else None for r in records]
        for name in about.resolved["keep_signals"]:
            kept = [record.signals.get(name) for record in records]
            columns[f"{name}.values"] = [None if a is None else np.ravel(a) for a in kept]
            columns[f"{name}.shape"] = [None if a is None else a.shape for a in kept]
        first, last = about.plan.chunk(number)
        try:
            data = encode(layout, number, columns)
        except Damaged as fault:
            raise StoreError(
                f"{self.path}: the runs {first} to {last} cannot be stored: {fault}. Keep fewer "
                "signals, or run fewer steps."
            ) from None
        assert self.chunks is not None
        self.chunks.put(file_of(number), data)

    def read(self, numbers: Iterable[int] | None = None, guarded: bool = True) -> Iterator[Chunk]:
        """The chunks of which there is a file, by increasing number, held against the plan.

        With `guarded` in a child with limits: who made the folder is not known.
        """
        about = self.study
        plan = about.plan
        wanted = self.numbers() if numbers is None else list(numbers)
        wanted = [n for n in wanted if 0 < n <= plan.chunks]
        if self.chunks is None or not wanted:
            return
        jobs = []
        for number in wanted:
            first, last = plan.chunk(number)
            jobs.append((number, last - first + 1, self.layout(number)))
        found = (read_guarded if guarded else read_here)(self.chunks, jobs)
        for number, columns in found:
            first, last = plan.chunk(number)
            fault = columns if isinstance(columns, str) else ""
            if not isinstance(columns, str):
                fault = _fault(about, number, self.layout(number), columns)
            known = {} if isinstance(columns, str) else columns
            yield Chunk(number, first, last, known, fault)

    def results(
        self, numbers: Iterable[int] | None = None, guarded: bool = True
    ) -> Iterator[Chunk]:
        """The same; a damaged chunk is refused."""
        for chunk in self.read(numbers, guarded):
            if chunk.fault:
                raise StoreError(
                    f"{self.path} is damaged: {fault_words(chunk)}. Nothing was changed. The same "
                    "`rcac sweep` (run_study) computes again what is damaged; `rcac store check` "
                    "(check_store) names all of it."
                )
            yield chunk

    def cell_columns(self, cells: Sequence[int] | NDArray[np.int64]) -> dict[str, NDArray[Any]]:
        """The coordinates of some cells, an array for each axis."""
        plan = self.study.plan
        by_axis = zip(plan.values.items(), plan.indices(cells), strict=True)
        return {name: column(values)[places] for (name, values), places in by_axis}

    def _without_study(self, what: str) -> str:
        return (
            f"{self.path} is damaged or no store of a study: its {STUDY} is none ({what}). Nothing "
            "was changed. Without its study nothing in it can be checked; take it from a copy, or "
            "run the study into another folder."
        )


def fault_words(chunk: Chunk) -> str:
    """Which runs are damaged, and how."""
    return f"the runs {chunk.first} to {chunk.last} ({file_of(chunk.number)}): {chunk.fault}"


def _fault(about: StoredStudy, number: int, layout: Layout, columns: Columns) -> str:
    """What is wrong with rows whose digest is right: only who can compute digests comes here."""
    for name, values in _planned(about, number, layout).items():
        if list(columns[name]) != list(values):
            return f"its column {name} is not that of the study"
    for outcome, words in zip(columns["outcome"], columns["failure"], strict=True):
        if outcome is None or words is None:
            return "a run has no outcome"
    failed = np.array([outcome in FAILED for outcome in columns["outcome"]])
    if any(not np.isnan(columns[name][failed]).all() for name in about.measures):
        return "a run that failed has a number"
    return ""


def _planned(about: StoredStudy, number: int, layout: Layout) -> dict[str, list[Any]]:
    """The columns of a chunk that follow from the plan."""
    plan, kinds = about.plan, dict(layout.columns)
    places = plan.places(*plan.chunk(number))
    by_name = zip(("run", "cell", "repetition"), zip(*places, strict=True), strict=True)
    columns = {name: list(values) for name, values in by_name}
    coordinates = plan.coordinates(columns["cell"])
    return columns | {
        name: [_coordinate(where[name], kinds[name]) for where in coordinates]
        for name in plan.values
    }


def _kind(values: Sequence[Any]) -> str:
    """The kind of the column of an axis: one for all numbers, since an axis may grow."""
    if all(type(value) is bool for value in values):
        return TRUTH
    if all(type(v) is float or (type(v) is int and abs(v) <= EXACT) for v in values):
        return NUMBER
    return TEXT


def _coordinate(value: Any, kind: str) -> Any:
    if kind == TEXT:
        return value if isinstance(value, str) else json.dumps(value)
    return float(value) if kind == NUMBER else value


def _stored(value: float) -> float | None:
    """No NaN and no negative zero: a result without a number is a null."""
    return None if math.isnan(value) else float(value) + 0.0


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


def _is_part(name: str) -> bool:
    return name.startswith(".") and name.endswith(PART)


def _number(name: str) -> int | None:
    """The number of a chunk's file; None for another name."""
    if not re.fullmatch(r"[0-9]{8,18}\.parquet", name):
        return None
    number = int(name.partition(".")[0])
    return number if file_of(number) == name else None


def _require_folder(path: Path, make: bool) -> None:
    """Refuse what is no folder; make one where there is none."""
    head, is_there = b"", True
    try:
        if path.is_dir():
            return
        is_there = os.path.lexists(path)
        if not is_there and make:
            path.mkdir(exist_ok=True)
            return
        if path.is_file():
            with path.open("rb") as file:
                head = file.read(len(SQLITE))
    except ValueError as error:  # a null character in the path
        raise StoreError(f"{str(path)!r} cannot be read: {error}.") from None
    except OSError as error:
        raise StoreError(
            f"{path} cannot be made or read ({error.strerror}): is there such a folder, and may "
            "you write to it?"
        ) from None
    if not is_there:
        raise StoreError(f"{path} cannot be read: there is no such folder.")
    if head == SQLITE:
        raise StoreError(
            f"{path} is a store of an earlier version, an SQLite file: `rcac store convert {path} "
            "-o FOLDER` (convert_store) makes a folder of it."
        )
    raise StoreError(
        f"{path} is no store of a study: it is a file, and a store a folder with a {STUDY}. "
        "Nothing was changed. `rcac sweep` makes stores; `rcac verify` runs an experiment's .toml."
    )
