"""study.toml: what a study asked for, complete, and what its runs were made with."""

from __future__ import annotations

import itertools
import json
import re
import time
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import blake2b
from pathlib import Path
from typing import Any

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.files._documents import require_short_keys, without_strings
from rcac_experiments.sweeps._axes import Axis
from rcac_experiments.sweeps._canonical import canonical_json, digest
from rcac_experiments.sweeps._measures import require_column
from rcac_experiments.sweeps._plan import GROWING, Plan, Resolved, Stage, grown, stage_of, united
from rcac_experiments.sweeps._study import LARGEST_GRID, SIGNALS, Study
from rcac_experiments.sweeps._versions import versions

FORMAT = 3  # 2 was an SQLite file
LARGEST_CHUNK = 512  # runs
# Bytes of the file, and those that are no texts: tomllib needs half a second for a million.
LARGEST_FILE, MOST_OUTSIDE = 2**26, 2**22
LONG = 1000  # values of an axis, from which on they stand there as a text in JSON
NONE = {"": "none"}  # TOML has no null
HEAD = f"""\
# A study of compensator-theory: what was asked for, and what its runs were made with. The runs are
# in chunks/*.parquet. It is held against its digest: ask for other things in a file of your own.
format = {FORMAT}
"""
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
    """What a folder says of its study.

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
        """What every chunk is bound to: the study without what may grow."""
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
        return tuple(kept["name"] for kept in self.resolved["keep"])

    def grown(self, path: object, study: Study, *, among_others: bool = False) -> StoredStudy:
        """The same with what a study asks for beyond it; another study is refused.

        So is a smaller one, unless others may have made this one grow at the same time.
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
    """What is said of a study that begins now and here."""
    resolved = json.loads(json.dumps(study.resolved))
    return StoredStudy(
        resolved, str(Path(study.file).resolve()), study.title, versions(), instruction_set,
        time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        plan_of(resolved, (stage_of(resolved),), chunk_size),
    )  # fmt: skip


def plan_of(resolved: Resolved, stages: tuple[Stage, ...], chunk_size: int) -> Plan:
    """The plan of a study; raises one of `NO_STUDY` where it cannot be one."""
    if resolved.keys() != KEYS or type(resolved["seed"]) is not int:
        raise ValueError("it has not what a study has")
    if type(chunk_size) is not int or not 1 <= chunk_size <= LARGEST_CHUNK:
        raise ValueError(f"a chunk of {chunk_size} runs; there are 1 to {LARGEST_CHUNK}")
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
    if not all(type(n) is int and 0 < n < 2**62 for size in sizes for n in size):
        raise ValueError("a size is no number")
    # Each stage has all that the one before had, and the last is the study as it is.
    for before, after in itertools.pairwise(sizes):
        if not all(a <= b for a, b in zip(before, after, strict=True)):
            raise ValueError("it has shrunk")
    if stages[-1] != stage_of(resolved) or stages[-1].cells > LARGEST_GRID:
        raise ValueError("its size is that of another one")
    return Plan({axis.name: list(axis.values) for axis in axes}, stages, chunk_size)


def text_of(about: StoredStudy) -> str:
    """The text of study.toml."""
    study = dict(about.resolved)
    study["axes"] = [
        {key: value for key, value in axis.items() if key != "values"}
        | {"values_json": json.dumps(axis["values"]).replace("'", r"\u0027")}
        if len(axis["values"]) > LONG
        else axis
        for axis in study["axes"]
    ]
    document = {
        "title": _encodable(about.title), "file": _encodable(about.file),
        "instruction_set": about.instruction_set, "created": about.created,
        "chunk_size": about.plan.chunk_size, "mixed": list(about.mixed),
        "stages": [vars(stage) for stage in about.plan.stages],
        "versions": about.versions, "study": study,
    }  # fmt: skip
    body = "\n".join(_lines(document, ()))
    text = f"{HEAD}digest = {_toml(_digest(tomllib.loads(body)))}\n{body}\n"
    try:
        kept = read_text(text.encode())
    except (UnicodeEncodeError, *NO_STUDY) as error:
        raise InputError(f"the study cannot be written down: {error}.") from None
    if kept != replace(about, title=_encodable(about.title), file=_encodable(about.file)):
        raise InputError(
            "the study cannot be written down: some value of it has no form in TOML, an empty key "
            "of a table for instance."
        )
    return text


def read_text(data: bytes) -> StoredStudy:
    """What study.toml says; raises one of `NO_STUDY` where it is none."""
    text = data.decode()
    if len(without_strings(text)) > MOST_OUTSIDE:
        raise ValueError(f"it has more than {MOST_OUTSIDE} characters beside texts")
    require_short_keys(text, "study.toml")
    document = tomllib.loads(text)
    if document.get("format") != FORMAT:
        raise ValueError(f"it is of no format that this version reads, which is {FORMAT}")
    del document["format"]
    if document.pop("digest", None) != _digest(document):
        raise ValueError("it is not what was written")
    study = _restored(document["study"])
    for axis in study["axes"]:
        if "values_json" in axis:
            axis["values"] = json.loads(axis.pop("values_json"))
    texts = [document[key] for key in ("title", "file", "instruction_set", "created")]
    texts += [*document["versions"], *document["versions"].values(), *document["mixed"]]
    if not all(type(text) is str for text in texts) or type(document["mixed"]) is not list:
        raise TypeError("something in it is of another kind")
    stages = tuple(
        Stage(tuple(stage["lengths"]), stage["repetitions"]) for stage in document["stages"]
    )
    canonical_json(study)
    return StoredStudy(
        study, document["file"], document["title"], document["versions"],
        document["instruction_set"], document["created"],
        plan_of(study, stages, document["chunk_size"]), tuple(document["mixed"]),
    )  # fmt: skip


def _digest(document: Mapping[str, Any]) -> str:
    text = json.dumps(document, sort_keys=True, separators=(",", ":"))
    return blake2b(text.encode(), digest_size=16).hexdigest()


def _lines(table: Mapping[str, Any], path: tuple[str, ...]) -> list[str]:
    """A table of TOML, the tables in it after its values; three deep as headings."""
    inner = {
        key: value for key, value in table.items()
        if isinstance(value, dict) and value and len(path) < 3
    }  # fmt: skip
    lines = [f"{_key(k)} = {_toml(v, wide=True)}" for k, v in table.items() if k not in inner]
    for key, value in inner.items():
        here = (*path, key)
        lines += ["", f"[{'.'.join(map(_key, here))}]", *_lines(value, here)]
    return lines


def _toml(value: Any, wide: bool = False) -> str:
    """One value; with `wide` each table of a list on a line of its own."""
    if value is None:
        value = NONE
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, str):
        if len(value) > 1000 and "'" not in value and value.isprintable():
            return f"'{value}'"
        return json.dumps(value, ensure_ascii=False).replace("\x7f", r"\u007f")
    if isinstance(value, dict):
        pairs = ", ".join(f"{_key(key)} = {_toml(entry)}" for key, entry in value.items())
        return f"{{ {pairs} }}" if pairs else "{}"
    if wide and value and all(isinstance(entry, dict) for entry in value):
        return "[\n" + "".join(f"  {_toml(entry)},\n" for entry in value) + "]"
    return f"[{', '.join(map(_toml, value))}]"


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _toml(key)


def _restored(value: Any) -> Any:
    if isinstance(value, dict):
        return None if value == NONE else {key: _restored(v) for key, v in value.items()}
    return [_restored(entry) for entry in value] if isinstance(value, list) else value


def _encodable(text: str) -> str:
    """The path of a file may hold bytes that are no text."""
    return text.encode("utf-8", "backslashreplace").decode()
