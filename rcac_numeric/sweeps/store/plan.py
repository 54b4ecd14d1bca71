"""Which runs a study has: their numbers, and what becomes of them when the study grows."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from rcac_numeric.sweeps.store.problems import StoreError
from rcac_numeric.sweeps.study.canonical import canonical_json

Resolved = dict[str, Any]
# What may grow; a study that differs in anything else is another one.
GROWING = ("axes", "repetitions")


@dataclass(frozen=True)
class Block:
    """Consecutive runs: so many repetitions of each of some consecutive cells.

    Examples
    --------
    >>> from rcac_numeric.sweeps.store.plan import Block
    >>> Block(first_run=10, first_cell=2, cells=3, first_repetition=0, repetitions=4).place(15)
    (3, 1)
    """

    first_run: int
    first_cell: int
    cells: int
    first_repetition: int
    repetitions: int

    @property
    def runs(self) -> int:
        """How many there are."""
        return self.cells * self.repetitions

    def place(self, run: int) -> tuple[int, int]:
        """Cell and repetition of a run."""
        cell, repetition = divmod(run - self.first_run, self.repetitions)
        return self.first_cell + cell, self.first_repetition + repetition


def first_block(resolved: Resolved) -> Block:
    """All runs of a new study."""
    return Block(0, 0, number_of_cells(resolved), 0, resolved["repetitions"])


def number_of_cells(resolved: Resolved) -> int:
    """Number of combinations of the axes' values."""
    count = 1
    for axis in resolved["axes"]:
        count *= len(axis["values"])
    return count


def cells_of(resolved: Resolved, old: Resolved | None = None) -> Iterator[tuple[Any, ...]]:
    """The coordinates of all cells in the order of their numbers, or of those that are new."""
    axes = [axis["values"] for axis in resolved["axes"]]
    known = [len(axis["values"]) for axis in old["axes"]] if old else [0] * len(axes)
    for places in itertools.product(*(range(len(values)) for values in axes)):
        if old is None or any(i >= n for i, n in zip(places, known, strict=True)):
            yield tuple(values[i] for values, i in zip(axes, places, strict=True))


def grown(path: object, old: Resolved, new: Resolved) -> Resolved:
    """What the store holds and the study asks for together, the old values of each axis first.

    Raises
    ------
    StoreError
        Where the study is another one: what differs is named.
    """
    differences = [
        key
        for key in sorted({*old, *new} - set(GROWING))
        if canonical_json(old.get(key)) != canonical_json(new.get(key))
    ]
    words = [_difference(key, old.get(key), new.get(key)) for key in differences]
    named_old, named_new = ({a["name"]: a for a in r["axes"]} for r in (old, new))
    if [a["name"] for a in old["axes"]] != [a["name"] for a in new["axes"]]:
        words.append(f"axes: {', '.join(named_old)} before, {', '.join(named_new)} now")
    axes = []
    for name in named_old.keys() & named_new.keys():
        words += _axis_difference(name, named_old[name], named_new[name])
    if new["repetitions"] < old["repetitions"]:
        words.append(f"repetitions: {old['repetitions']} before, {new['repetitions']} now")
    if words:
        raise StoreError(
            f"{path} holds the results of another study; {'; '.join(words)}. Results are never "
            "mixed: use another file. (More repetitions or more values of an axis would go on in "
            "this one.)"
        )
    for axis in old["axes"]:
        known = {canonical_json(value) for value in axis["values"]}
        more = [v for v in named_new[axis["name"]]["values"] if canonical_json(v) not in known]
        axes.append({**axis, "values": [*axis["values"], *more]})
    return {**new, "axes": axes}


def new_blocks(old: Resolved, new: Resolved, runs: int) -> list[Block]:
    """The runs that a grown study adds to its `runs` runs."""
    blocks = []
    cells, before, now = number_of_cells(old), old["repetitions"], new["repetitions"]
    if now > before:
        blocks.append(Block(runs, 0, cells, before, now - before))
        runs += blocks[-1].runs
    if more := number_of_cells(new) - cells:
        blocks.append(Block(runs, cells, more, 0, now))
    return blocks


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
