"""The runs of a study: their numbers, which stay when the study grows."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcac_experiments.sweeps._canonical import canonical_json
from rcac_experiments.sweeps._problems import StoreError

Resolved = dict[str, Any]
# What may grow; a study that differs in anything else is another one.
GROWING = ("axes", "repetitions")


@dataclass(frozen=True)
class Stage:
    """The size of a study at one time: the number of values of each axis, and repetitions."""

    lengths: tuple[int, ...]
    repetitions: int

    @property
    def cells(self) -> int:
        """Number of combinations."""
        return math.prod(self.lengths)


@dataclass(frozen=True)
class Block:
    """Consecutive runs in consecutive chunks: repetitions of each of some consecutive cells."""

    stage: int
    first_run: int
    first_chunk: int
    first_cell: int
    first_repetition: int
    repetitions: int
    runs: int


@dataclass(frozen=True)
class Plan:
    """All cells, runs and chunks (from 1 on) of a study that may have grown.

    `values` are those of each axis in the order in which they came, `stages` the sizes that the
    study had; a chunk has `chunk_size` runs, the last one of a block may have fewer.
    """

    values: dict[str, list[Any]]
    stages: tuple[Stage, ...]
    chunk_size: int

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """The runs of each stage: more repetitions of earlier cells, then its new cells."""
        blocks: list[Block] = []
        cells = repetitions = runs = 0
        chunks = 1
        for i, stage in enumerate(self.stages):
            for first, count, before in ((0, cells, repetitions), (cells, stage.cells - cells, 0)):
                size = count * (stage.repetitions - before)
                if size:
                    blocks.append(Block(i, runs, chunks, first, before,
                                        stage.repetitions - before, size))  # fmt: skip
                    runs, chunks = runs + size, chunks - (-size // self.chunk_size)
            cells, repetitions = stage.cells, stage.repetitions
        return tuple(blocks)

    @property
    def runs(self) -> int:
        """Number of runs."""
        return self.blocks[-1].first_run + self.blocks[-1].runs

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return self.chunk_of(self.runs - 1)

    def chunk(self, number: int) -> tuple[int, int]:
        """The first and the last run of a chunk."""
        block = self._block_with(number)
        first = block.first_run + (number - block.first_chunk) * self.chunk_size
        return first, min(first + self.chunk_size, block.first_run + block.runs) - 1

    def chunk_of(self, run: int) -> int:
        """The number of the chunk that a run is in."""
        block = self._block_of(run)
        return block.first_chunk + (run - block.first_run) // self.chunk_size

    def place(self, run: int) -> tuple[int, int]:
        """Cell and repetition of a run."""
        block = self._block_of(run)
        cell, repetition = divmod(run - block.first_run, block.repetitions)
        return block.first_cell + cell, block.first_repetition + repetition

    def places(self, number: int) -> list[tuple[int, int, int]]:
        """Run, cell and repetition of the runs of a chunk."""
        first, last = self.chunk(number)
        return [(run, *self.place(run)) for run in range(first, last + 1)]

    def values_of(self, number: int) -> dict[str, list[Any]]:
        """The values that each axis had when a chunk was planned: a file's columns follow them."""
        lengths = self.stages[self._block_with(number).stage].lengths
        of_axes = zip(self.values.items(), lengths, strict=True)
        return {name: values[:length] for (name, values), length in of_axes}

    def indices(self, cells: Sequence[int] | NDArray[np.int64]) -> NDArray[np.int64]:
        """Indices of the values of each axis in some cells, shape (axes, cells).

        Those of one stage come in lexicographic order, each after those of the stages before.
        """
        numbers = np.asarray(cells, dtype=np.int64)
        ends = [0, *(stage.cells for stage in self.stages)]
        indices = np.zeros((len(self.values), len(numbers)), dtype=np.int64)
        which = np.searchsorted(ends, numbers, side="right") - 1
        for i in np.unique(which).tolist():
            rows = which == i
            offsets = numbers[rows] - ends[i]
            if i:
                fresh = np.ones(self.stages[i].lengths, dtype=bool)
                fresh[tuple(map(slice, self.stages[i - 1].lengths))] = False
                offsets = np.flatnonzero(fresh)[offsets]
            if self.values:
                indices[:, rows] = np.unravel_index(offsets, self.stages[i].lengths)
        return indices

    def coordinates(self, cells: Sequence[int]) -> list[dict[str, Any]]:
        """The coordinates of some cells."""
        names, values = list(self.values), list(self.values.values())
        return [
            dict(zip(names, (v[i] for v, i in zip(values, where, strict=True)), strict=True))
            for where in self.indices(cells).T.tolist()
        ]

    def _block_of(self, run: int) -> Block:
        return self.blocks[bisect_right(self.blocks, run, key=lambda block: block.first_run) - 1]

    def _block_with(self, chunk: int) -> Block:
        blocks = self.blocks
        return blocks[bisect_right(blocks, chunk, key=lambda block: block.first_chunk) - 1]


def stage_of(resolved: Resolved) -> Stage:
    """The size of a study."""
    return Stage(tuple(len(axis["values"]) for axis in resolved["axes"]), resolved["repetitions"])


def united(old: Resolved, new: Resolved) -> Resolved:
    """Return the union of two studies that differ in extendable parts, the old values first."""
    axes = [
        {**axis, "values": [*axis["values"], *_lacking(other["values"], axis["values"])]}
        for axis, other in zip(old["axes"], new["axes"], strict=True)
    ]
    return {**new, "axes": axes, "repetitions": max(old["repetitions"], new["repetitions"])}


def grown(path: object, old: Resolved, new: Resolved) -> Resolved:
    """Return the store's study extended by the new one; refuse any other difference."""
    then, now = (
        {key: value for key, value in of.items() if key not in GROWING}
        | {"axes": {axis["name"]: axis["sets"] for axis in of["axes"]}}
        for of in (old, new)
    )
    words = _differences("", then, now)
    if not words:
        for axis, other in zip(old["axes"], new["axes"], strict=True):
            if lost := _lacking(axis["values"], other["values"]):
                shown = ", ".join(map(str, lost[:3])) + (" ..." if len(lost) > 3 else "")
                words.append(f"axis {axis['name']} had {shown} before, and has not now")
    if new["repetitions"] < old["repetitions"]:
        words += _differences("repetitions", old["repetitions"], new["repetitions"])
    if words:
        raise StoreError(
            f"{path} holds the results of another study; {'; '.join(words)}. Results are never "
            "mixed: use another folder. (More repetitions or more values of an axis would go on in "
            "this one.)"
        )
    return united(old, new)


def _lacking(values: Sequence[Any], others: Sequence[Any]) -> list[Any]:
    """The values that the others do not have."""
    known = set(map(canonical_json, others))
    return [value for value in values if canonical_json(value) not in known]


def _differences(path: str, old: Any, new: Any) -> list[str]:
    """Return the paths of all differences."""
    if path == "axes" and list(old) != list(new):
        return [f"axes: {', '.join(old)} before, {', '.join(new)} now"]
    if isinstance(old, Mapping) and isinstance(new, Mapping) and old.keys() == new.keys():
        return [
            words
            for key in old
            for words in _differences(f"{path}.{key}".lstrip("."), old[key], new[key])
        ]
    texts = [canonical_json(value) for value in (old, new)]
    if texts[0] == texts[1]:
        return []
    short = [text if len(text) <= 60 else f"{text[:57]}..." for text in texts]
    return [f"{path}: {short[0]} before, {short[1]} now"]
