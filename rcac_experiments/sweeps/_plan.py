"""Which runs a study has: their numbers, and what becomes of them when the study grows."""

from __future__ import annotations

import itertools
import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
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
class Block:
    """Consecutive runs: so many repetitions of each of some consecutive cells.

    Examples
    --------
    >>> from rcac_experiments.sweeps._plan import Block
    >>> Block(first_run=10, first_cell=2, cells=3, first_repetition=0, repetitions=4).place(15)
    (3, 1)
    """

    first_run: int
    first_cell: int
    cells: int
    first_repetition: int
    repetitions: int
    stage: int = 0

    @property
    def runs(self) -> int:
        """How many there are."""
        return self.cells * self.repetitions

    def place(self, run: int) -> tuple[int, int]:
        """Cell and repetition of a run."""
        cell, repetition = divmod(run - self.first_run, self.repetitions)
        return self.first_cell + cell, self.first_repetition + repetition


@dataclass(frozen=True)
class Stage:
    """How large a study was at one time: the number of values of each axis, and repetitions."""

    lengths: tuple[int, ...]
    repetitions: int

    @property
    def cells(self) -> int:
        """Number of combinations."""
        return math.prod(self.lengths)


@dataclass(frozen=True)
class Plan:
    """All cells, runs and chunks of a study that may have grown, from what is in it alone.

    Attributes
    ----------
    values : dict from axes to their values
        In the order in which they came.
    stages : tuple of Stage
        From the first run on to what `values` are now.
    chunk_size : int
        Runs of a chunk; the last one of a block may have fewer.

    Examples
    --------
    >>> from rcac_experiments.sweeps._plan import Plan, Stage
    >>> plan = Plan({"a": [1, 2, 3]}, (Stage((2,), 1), Stage((3,), 2)), 64)
    >>> plan.runs, [plan.place(run) for run in range(plan.runs)]
    (6, [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (2, 1)])
    >>> plan.chunks, plan.coordinates([2])
    (3, [{'a': 3}])
    """

    values: dict[str, list[Any]]
    stages: tuple[Stage, ...]
    chunk_size: int

    @property
    def cells(self) -> int:
        """Number of cells."""
        return self.stages[-1].cells

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """Which runs there are, by increasing number."""
        blocks: list[Block] = []
        cells = repetitions = runs = 0
        for i, stage in enumerate(self.stages):
            more = (
                Block(0, 0, cells, repetitions, stage.repetitions - repetitions, i),
                Block(0, cells, stage.cells - cells, 0, stage.repetitions, i),
            )
            for block in more:
                if block.runs:
                    blocks.append(replace(block, first_run=runs))
                    runs += block.runs
            cells, repetitions = stage.cells, stage.repetitions
        return tuple(blocks)

    @property
    def runs(self) -> int:
        """Number of runs."""
        return sum(block.runs for block in self.blocks)

    @cached_property
    def _first_chunks(self) -> list[int]:
        """The number of the first chunk of each block, from 1 on; and one more than the last."""
        sizes = [-(-block.runs // self.chunk_size) for block in self.blocks]
        return [1, *itertools.accumulate(sizes, initial=1)][1:]

    @property
    def chunks(self) -> int:
        """Number of chunks, which are numbered from 1 on."""
        return self._first_chunks[-1] - 1

    def chunk(self, number: int) -> tuple[int, int]:
        """The first and the last run of a chunk."""
        i = bisect_right(self._first_chunks, number) - 1
        block = self.blocks[i]
        first = block.first_run + (number - self._first_chunks[i]) * self.chunk_size
        return first, min(first + self.chunk_size, block.first_run + block.runs) - 1

    def stage_of(self, number: int) -> int:
        """The stage in which a chunk was planned."""
        return self.blocks[bisect_right(self._first_chunks, number) - 1].stage

    def values_of(self, number: int) -> dict[str, list[Any]]:
        """The values that each axis had when a chunk was planned: a file's columns follow them."""
        lengths = self.stages[self.stage_of(number)].lengths
        return {
            name: values[:length]
            for (name, values), length in zip(self.values.items(), lengths, strict=True)
        }

    def chunk_of(self, run: int) -> int:
        """The number of the chunk that a run is in."""
        i = bisect_right([block.first_run for block in self.blocks], run) - 1
        return self._first_chunks[i] + (run - self.blocks[i].first_run) // self.chunk_size

    def place(self, run: int) -> tuple[int, int]:
        """Cell and repetition of a run."""
        i = bisect_right([block.first_run for block in self.blocks], run) - 1
        return self.blocks[i].place(run)

    def places(self, first: int, last: int) -> list[tuple[int, int, int]]:
        """Run, cell and repetition of the runs of one chunk."""
        i = bisect_right([block.first_run for block in self.blocks], first) - 1
        block = self.blocks[i]
        return [(run, *block.place(run)) for run in range(first, last + 1)]

    def indices(self, cells: Sequence[int] | NDArray[np.int64]) -> NDArray[np.int64]:
        """Which value of each axis some cells have, shape (axes, cells).

        Those of one stage come in lexicographic order, each after those of the stages before.
        """
        numbers = np.asarray(cells, dtype=np.int64)
        ends = [0, *(stage.cells for stage in self.stages)]
        lengths = [(0,) * len(self.values), *(stage.lengths for stage in self.stages)]
        found = np.zeros((len(self.values), len(numbers)), dtype=np.int64)
        stages = np.searchsorted(ends, numbers, side="right")
        for i in np.unique(stages).tolist():
            rows = stages == i
            left = numbers[rows] - ends[i - 1]
            found[:, rows] = _new_combination(left, lengths[i - 1], lengths[i])
        return found

    def coordinates(self, cells: Sequence[int]) -> list[dict[str, Any]]:
        """The coordinates of some cells."""
        by_cell = self.indices(cells).T.tolist()
        return [
            {name: values[i] for (name, values), i in zip(self.values.items(), where, strict=True)}
            for where in by_cell
        ]


def _new_combination(
    left: NDArray[np.int64], old: tuple[int, ...], new: tuple[int, ...]
) -> NDArray[np.int64]:
    """The `left`-th combination of `new` values, in their order, that `old` values do not make."""
    fresh = np.full(len(left), not all(old) or not old)  # whether a new value was met already
    found = np.empty((len(new), len(left)), dtype=np.int64)
    for axis, known in enumerate(old):
        of_all = math.prod(new[axis + 1 :])
        of_new = of_all - math.prod(old[axis + 1 :])
        within = ~fresh & (left < known * of_new)
        beyond = ~fresh & ~within
        left = left - np.where(beyond, known * of_new, 0)
        i, left = np.divmod(left, np.where(within, max(of_new, 1), of_all))
        found[axis] = i + np.where(beyond, known, 0)
        fresh = ~within
    return found


def stage_of(resolved: Resolved) -> Stage:
    """How large a study is."""
    return Stage(tuple(len(axis["values"]) for axis in resolved["axes"]), resolved["repetitions"])


def grown(path: object, old: Resolved, new: Resolved) -> Resolved:
    """What the store holds and the study asks for together, the old values of each axis first."""
    differences = [
        key
        for key in sorted({*old, *new} - set(GROWING))
        if canonical_json(old.get(key)) != canonical_json(new.get(key))
    ]
    words = [_difference(key, old.get(key), new.get(key)) for key in differences]
    named_old, named_new = ({a["name"]: a for a in r["axes"]} for r in (old, new))
    if [a["name"] for a in old["axes"]] != [a["name"] for a in new["axes"]]:
        words.append(f"axes: {', '.join(named_old)} before, {', '.join(named_new)} now")
    for name in named_old.keys() & named_new.keys():
        words += _axis_difference(name, named_old[name], named_new[name])
    if new["repetitions"] < old["repetitions"]:
        words.append(f"repetitions: {old['repetitions']} before, {new['repetitions']} now")
    if words:
        raise StoreError(
            f"{path} holds the results of another study; {'; '.join(words)}. Results are never "
            "mixed: use another folder. (More repetitions or more values of an axis would go on in "
            "this one.)"
        )
    return united(old, new)


def united(old: Resolved, new: Resolved) -> Resolved:
    """All that two studies ask for that differ in what may grow, the old values first."""
    axes = []
    for axis, other in zip(old["axes"], new["axes"], strict=True):
        known = {canonical_json(value) for value in axis["values"]}
        more = [value for value in other["values"] if canonical_json(value) not in known]
        axes.append({**axis, "values": [*axis["values"], *more]})
    return {**new, "axes": axes, "repetitions": max(old["repetitions"], new["repetitions"])}


def _axis_difference(name: str, old: Resolved, new: Resolved) -> list[str]:
    if old["sets"] != new["sets"]:
        return [f"axis {name} sets {old['sets']} before, {new['sets']} now"]
    now = {canonical_json(value) for value in new["values"]}
    lost = [value for value in old["values"] if canonical_json(value) not in now]
    if lost:
        shown = ", ".join(map(str, lost[:3])) + (" ..." if len(lost) > 3 else "")
        return [f"axis {name} had {shown} before, and has not now"]
    return []


def _difference(key: str, old: Any, new: Any) -> str:
    """What differs, down to the innermost key."""
    while isinstance(old, dict) and isinstance(new, dict):
        inner = [k for k in sorted({*old, *new}) if canonical_json(old.get(k, "")) !=
                 canonical_json(new.get(k, ""))]  # fmt: skip
        if len(inner) != 1:
            return f"{key}: {', '.join(inner)} differ"
        key, old, new = f"{key}.{inner[0]}", old.get(inner[0]), new.get(inner[0])
    return f"{key}: {_short(old)} before, {_short(new)} now"


def _short(value: Any) -> str:
    text = canonical_json(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
