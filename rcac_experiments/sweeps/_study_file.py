"""study.json: the complete request of a study, and the versions that computed its runs."""

from __future__ import annotations

import itertools
import json
import time
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.sweeps._axes import Axis
from rcac_experiments.sweeps._canonical import canonical_json, digest
from rcac_experiments.sweeps._directory import ZEROS
from rcac_experiments.sweeps._measures import require_column
from rcac_experiments.sweeps._plan import GROWING, Plan, Resolved, Stage, grown, stage_of, united
from rcac_experiments.sweeps._study import LARGEST_GRID, SIGNALS, Study
from rcac_experiments.sweeps._versions import versions

FORMAT = 3  # 2 was an SQLite file
LARGEST_CHUNK = 512  # runs
LARGEST_FILE, MOST_ENTRIES = 2**26, 2**22  # bytes; commas and brackets, also those in texts
# All that reading a study that is none may raise.
NO_STUDY = (
    CompensatorError, LookupError, TypeError, ValueError, AttributeError, ArithmeticError,
    RecursionError,
)  # fmt: skip
# What is in a study, see `Study.resolved`.
KEYS = {
    "base", "files", "axes", "keep", "repetitions", "seed", "common_noise", "lanes",
    "keep_signals",
}  # fmt: skip


@dataclass(frozen=True)
class StoredStudy:
    """The study of a folder.

    `versions` and `instruction_set` are those that it was begun with, `mixed` what differed when
    others went on with it.
    """

    resolved: Resolved
    file: str
    title: str
    versions: dict[str, str]
    instruction_set: str
    created: str
    plan: Plan
    mixed: tuple[str, ...] = ()

    @cached_property
    def fingerprint(self) -> str:
        """That of the study as it is now."""
        return digest(canonical_json(self.resolved))

    @cached_property
    def name(self) -> str:
        """The digest that binds each chunk to the study without its extendable parts."""
        axes = [{"name": axis["name"], "sets": axis["sets"]} for axis in self.resolved["axes"]]
        fixed = {key: value for key, value in self.resolved.items() if key not in GROWING}
        return digest(canonical_json({**fixed, "axes": axes}))

    @property
    def axes(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(axis["name"] for axis in self.resolved["axes"])

    @property
    def measures(self) -> tuple[str, ...]:
        """The names of the columns of measures."""
        return tuple(metric["name"] for metric in self.resolved["keep"])

    def grown(self, path: object, study: Study, *, among_others: bool = False) -> StoredStudy:
        """Return the stored study with the additions of a larger one; another study is refused.

        A smaller one is refused too, unless another process may have extended the store.
        """
        new = json.loads(json.dumps(study.resolved))
        if among_others:
            new = united(self.resolved, new)
        new = grown(path, self.resolved, new)
        if canonical_json(new) == canonical_json(self.resolved):
            return self
        stages = (*self.plan.stages, stage_of(new))
        return replace(self, resolved=new, plan=plan_of(new, stages, self.plan.chunk_size))


def begun(study: Study, instruction_set: str, chunk_size: int) -> StoredStudy:
    """Return the record of a new study with the current versions."""
    resolved = json.loads(json.dumps(study.resolved))
    return StoredStudy(
        resolved, str(Path(study.file).resolve()), study.title, versions(), instruction_set,
        time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        plan_of(resolved, (stage_of(resolved),), chunk_size),
    )  # fmt: skip


def plan_of(resolved: Resolved, stages: tuple[Stage, ...], chunk_size: int) -> Plan:
    """The plan of a study; raises one of `NO_STUDY` where it cannot be one."""
    if resolved.keys() != KEYS or type(resolved["seed"]) is not int:
        raise ValueError("its keys are not those of a study, or its seed is no integer")
    if type(chunk_size) is not int or not 1 <= chunk_size <= LARGEST_CHUNK:
        raise ValueError(f"a chunk of {chunk_size} runs; there are 1 to {LARGEST_CHUNK}")
    axes = [Axis(axis["name"], axis["values"], axis["sets"]) for axis in resolved["axes"]]
    for metric in resolved["keep"]:
        require_column(metric["name"])
        if not isinstance(metric["arguments"], dict):
            raise TypeError("the arguments of a measure are no table")
    names = [*(axis.name for axis in axes), *(metric["name"] for metric in resolved["keep"])]
    if len({name.lower() for name in names}) != len(names):
        raise ValueError("two columns have one name")
    if not set(resolved["keep_signals"]) <= set(SIGNALS):
        raise ValueError("keep_signals names unknown signals")
    sizes = [(*stage.lengths, stage.repetitions) for stage in stages]
    if not all(type(n) is int and 0 < n < 2**62 for size in sizes for n in size):
        raise ValueError("a stage has a size that is no positive integer")
    # Each stage has all that the one before had, and the last is the study as it is.
    for before, after in itertools.pairwise(sizes):
        if not all(a <= b for a, b in zip(before, after, strict=True)):
            raise ValueError("a stage is smaller than the one before")
    if stages[-1] != stage_of(resolved) or stages[-1].cells > LARGEST_GRID:
        raise ValueError("the size of its last stage differs from its axes")
    return Plan({axis.name: list(axis.values) for axis in axes}, stages, chunk_size)


def text_of(about: StoredStudy) -> bytes:
    """The bytes of study.json, not sealed yet."""
    document = {
        "format": FORMAT, "title": about.title, "file": about.file, "created": about.created,
        "instruction_set": about.instruction_set, "mixed": about.mixed, "versions": about.versions,
        "chunk_size": about.plan.chunk_size,
        "stages": [[list(stage.lengths), stage.repetitions] for stage in about.plan.stages],
        "study": about.resolved, "digest": ZEROS.decode(),
    }  # fmt: skip
    text = json.dumps(document, indent=1).encode()
    if len(text) > LARGEST_FILE or _entries(text) > MOST_ENTRIES:
        raise InputError("the study cannot be written down: it has too many values.")
    return text


def read_text(data: bytes) -> StoredStudy:
    """Read study.json; raise one of `NO_STUDY` for any other file."""
    if _entries(data) > MOST_ENTRIES:
        raise ValueError(f"it has more than {MOST_ENTRIES} values")
    document = json.loads(data)
    if document.pop("format", None) != FORMAT:
        raise ValueError(f"it is of no format that this version reads, which is {FORMAT}")
    study, used_versions, mixed = document["study"], document["versions"], document["mixed"]
    texts_by_name = {
        name: document[name] for name in ("file", "title", "instruction_set", "created")
    }
    texts = [*texts_by_name.values(), *used_versions, *used_versions.values(), *mixed]
    if not all(type(text) is str for text in texts) or type(mixed) is not list:
        raise TypeError("an entry has the wrong type")
    canonical_json(study)
    stages = tuple(Stage(tuple(lengths), count) for lengths, count in document["stages"])
    plan = plan_of(study, stages, document["chunk_size"])
    return StoredStudy(
        study, plan=plan, versions=used_versions, mixed=tuple(mixed), **texts_by_name
    )


def _entries(text: bytes) -> int:
    return sum(map(text.count, (b",", b"[", b"{")))
