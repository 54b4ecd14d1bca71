"""The store of a study: a folder with study.json and a file for each completed chunk of runs.

Results are deterministic, so a store needs no locks, leases or repair: a chunk that is computed
twice is the same chunk, and a missing or damaged chunk is computed again.
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

from rcac_experiments.sweeps._chunk import FAILED, LONGEST_TEXT, RunRecord
from rcac_experiments.sweeps._chunk_files import (
    INTEGER,
    INTEGERS,
    NUMBER,
    NUMBERS,
    TEXT,
    TRUTH,
    Columns,
    Layout,
    encode,
)
from rcac_experiments.sweeps._directory import Directory, is_part
from rcac_experiments.sweeps._problems import Damaged, StoreError
from rcac_experiments.sweeps._reader import file_of, read_guarded, read_in_process
from rcac_experiments.sweeps._study import Study
from rcac_experiments.sweeps._study_file import (
    LARGEST_FILE,
    NO_STUDY,
    StoredStudy,
    read_text,
    text_of,
)

STUDY, CHUNKS = "study.json", "chunks"
SQLITE = b"SQLite format 3\0"
EXACT = 2**53  # integers up to it are float64


@dataclass(frozen=True)
class Chunk:
    """A stored chunk: its runs first, ..., last, and its columns, or a fault."""

    number: int
    first: int
    last: int
    columns: Columns
    fault: str = ""

    @property
    def failed(self) -> int:
        """The number of failed runs."""
        return sum(outcome in FAILED for outcome in self.columns.get("outcome", ()))

    @property
    def fault_words(self) -> str:
        """The damaged runs and the fault."""
        return f"the runs {self.first} to {self.last} ({file_of(self.number)}): {self.fault}"


class Folder:
    """An open store."""

    def __init__(self, path: str | Path, make: bool = False) -> None:
        self.path = Path(path)
        self._about: StoredStudy | None = None
        self._chunks: Directory | None = None
        self._layouts: dict[tuple[int, ...], Layout] = {}
        try:
            if make and not os.path.lexists(self.path):
                self.path.mkdir(exist_ok=True)
            elif not self.path.is_dir():
                raise _no_folder(self.path)
            self.directory = Directory(self.path)
        except StoreError:
            raise
        except (OSError, ValueError) as error:  # a null character in the path is the latter
            raise StoreError(
                f"{str(path)!r} cannot be made or read ({getattr(error, 'strerror', error)}): "
                "check "
                "that the folder exists and that you may write to it."
            ) from None

    def __enter__(self) -> Folder:
        return self

    def __exit__(self, *error: object) -> None:
        if self._chunks is not None:
            self._chunks.close()
        self.directory.close()

    # The study.

    @property
    def is_new(self) -> bool:
        """Whether the folder is empty; a folder with other files is refused."""
        return self._read() is None

    def _read(self) -> StoredStudy | None:
        try:
            return read_text(self.directory.read(STUDY, LARGEST_FILE))
        except (Damaged, *NO_STUDY) as fault:
            raise StoreError(
                f"{self.path} is damaged or no store of a study: its {STUDY} is invalid ({fault}). "
                f"Nothing was changed. No run can be checked without {STUDY}; restore the file "
                "from a copy, or run the study into another folder."
            ) from None
        except FileNotFoundError:
            others = [n for n in self.directory.names() if n != CHUNKS and not is_part(n)]
            if others or self.numbers():
                raise StoreError(
                    f"{self.path} is no store of a study: it has no {STUDY}, and contains other "
                    "files. "
                    "Nothing was changed. Give a separate folder, which `rcac sweep` makes; "
                    "restore "
                    f"a store without {STUDY} from a copy."
                ) from None
            return None

    @property
    def study(self) -> StoredStudy:
        """The description of the study, as it was last read."""
        return self._about or self.refreshed()

    def refreshed(self) -> StoredStudy:
        """Read the description of the study again, which another process may have extended."""
        about = self._read()
        if about is None:
            raise StoreError(
                f"{self.path} is empty: it contains no study. If `rcac sweep` was interrupted "
                "at its start, run the same command again."
            )
        if about != self._about:
            self._about, self._layouts = about, {}
        return about

    def begin(self, about: StoredStudy) -> None:
        """Write the study, unless another process has just done so."""
        data = text_of(about)
        if self.is_new:
            self.directory.make(CHUNKS)
            self.directory.put(STUDY, data)

    def grow(self, study: Study, mixed: Sequence[str] = (), *, among_others: bool = False) -> None:
        """Extend the stored study, and record differing versions."""
        about = self.refreshed()
        words = (*about.mixed, *(w for w in mixed if w not in about.mixed))
        new = about.grown(self.path, study, among_others=among_others)
        self.write(replace(new, mixed=words))
        self.refreshed()

    def write(self, about: StoredStudy) -> None:
        """Replace the description of the study."""
        if about != self.study:
            self.directory.put(STUDY, text_of(about))

    # The chunks.

    @property
    def chunks(self) -> Directory | None:
        """The folder of the chunks, or None."""
        if self._chunks is None:
            self._chunks = self.directory.inside(CHUNKS)
        return self._chunks

    def numbers(self) -> list[int]:
        """The numbers of the stored chunks."""
        return sorted(filter(None, map(_number, self.chunks.names() if self.chunks else ())))

    def strangers(self) -> list[str]:
        """Return foreign files among the chunks, which other readers would read too."""
        names, most = self.chunks.names() if self.chunks else [], self.study.plan.chunks
        return sorted(n for n in names if not is_part(n) and not 0 < (_number(n) or 0) <= most)

    def layout(self, number: int) -> Layout:
        """The columns of a chunk."""
        about, values = self.study, self.study.plan.values_of(number)
        lengths = tuple(map(len, values.values()))
        if lengths not in self._layouts:
            signals = about.resolved["keep_signals"]
            self._layouts[lengths] = Layout(about.name, (
                ("run", INTEGER), ("cell", INTEGER), ("repetition", INTEGER),
                *((name, _kind(known)) for name, known in values.items()),
                ("outcome", TEXT), ("failure", TEXT), *((name, NUMBER) for name in about.measures),
                *((f"{name}.values", NUMBERS) for name in signals),
                *((f"{name}.shape", INTEGERS) for name in signals),
            ))  # fmt: skip
        return self._layouts[lengths]

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
        for i, name in enumerate(about.measures):  # a result without a number is a null
            columns[name] = [
                r.values[i] + 0.0 if r.values and not math.isnan(r.values[i]) else None
                for r in records
            ]
        for name in about.resolved["keep_signals"]:
            samples = [record.signals.get(name) for record in records]
            columns[f"{name}.values"] = [None if a is None else np.ravel(a) for a in samples]
            columns[f"{name}.shape"] = [None if a is None else a.shape for a in samples]
        try:
            data = encode(layout, number, columns)
        except Damaged as fault:
            first, last = about.plan.chunk(number)
            raise StoreError(
                f"{self.path}: the runs {first} to {last} cannot be stored: {fault}. Keep fewer "
                "signals, or run fewer steps."
            ) from None
        assert self.chunks is not None
        self.chunks.put(file_of(number), data)

    def read(self, numbers: Iterable[int] | None = None, guarded: bool = True) -> Iterator[Chunk]:
        """The chunks that have a file, by increasing number, compared with the plan.

        With `guarded` in a child with limits: who made the folder is not known.
        """
        about = self.study
        selected = self.numbers() if numbers is None else numbers
        chunks = {n: about.plan.chunk(n) for n in selected if 0 < n <= about.plan.chunks}
        if self.chunks is None or not chunks:
            return
        jobs = [(n, last - first + 1, self.layout(n)) for n, (first, last) in chunks.items()]
        for number, content in (read_guarded if guarded else read_in_process)(self.chunks, jobs):
            columns, fault = ({}, content) if isinstance(content, str) else (content, "")
            if columns:
                fault = _fault(about, number, self.layout(number), columns)
            yield Chunk(number, *chunks[number], columns, fault)

    def results(
        self, numbers: Iterable[int] | None = None, guarded: bool = True
    ) -> Iterator[Chunk]:
        """Yield the chunks; raise an error for a damaged one."""
        for chunk in self.read(numbers, guarded):
            if chunk.fault:
                raise StoreError(
                    f"{self.path} is damaged: {chunk.fault_words}. Nothing was changed. Repeat "
                    "the damaged "
                    "runs with the same `rcac sweep` (run_study); list all of them with `rcac "
                    "store "
                    "check` (check_store)."
                )
            yield chunk

    def cell_columns(self, cells: Sequence[int] | NDArray[np.int64]) -> dict[str, NDArray[Any]]:
        """Return the coordinates of some cells, an array for each axis."""
        plan = self.study.plan
        by_axis = zip(plan.values.items(), plan.indices(cells), strict=True)
        return {name: column(values)[places] for (name, values), places in by_axis}


def _fault(about: StoredStudy, number: int, layout: Layout, columns: Columns) -> str:
    """Return the fault of rows with a correct digest, which only an edited store has."""
    for name, values in _planned(about, number, layout).items():
        if list(columns[name]) != list(values):
            return f"its column {name} is not that of the study"
    if None in columns["outcome"] or None in columns["failure"]:
        return "a run has no outcome"
    if max(map(len, (*columns["outcome"], *columns["failure"]))) > LONGEST_TEXT:
        return "a text is longer than any that is stored"
    failed = np.array([outcome in FAILED for outcome in columns["outcome"]])
    if any(not np.isnan(columns[name][failed]).all() for name in about.measures):
        return "a run that failed has a number"
    return ""


def _planned(about: StoredStudy, number: int, layout: Layout) -> dict[str, list[Any]]:
    """Return the columns of a chunk that the plan determines."""
    plan, kinds = about.plan, dict(layout.columns)
    run, cell, repetition = map(list, zip(*plan.places(number), strict=True))
    columns = {"run": run, "cell": cell, "repetition": repetition}
    coordinates = plan.coordinates(cell)
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


def _number(name: str) -> int | None:
    """The number of a chunk's file; None for another name."""
    number = int(name[:-8]) if re.fullmatch(r"[0-9]{8,18}\.parquet", name) else 0
    return number if number and file_of(number) == name else None


def _no_folder(path: Path) -> StoreError:
    """Return the error for a path that is no folder."""
    if not os.path.lexists(path):
        return StoreError(f"{path} cannot be read: there is no such folder.")
    if path.is_file():
        with path.open("rb") as file:
            if file.read(len(SQLITE)) == SQLITE:
                return StoreError(
                    f"{path} is a store of an earlier version, an SQLite file: convert it with "
                    f"`rcac store convert {path} -o FOLDER` (convert_store)."
                )
    return StoreError(
        f"{path} is no store of a study: it is a file, and a store is a folder with {STUDY}. "
        "Nothing was changed. Make a store with `rcac sweep`; run an experiment's .toml with "
        "`rcac verify`."
    )
