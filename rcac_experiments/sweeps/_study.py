"""A study: a base problem, its axes, repetitions and metrics."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any, Never

from compensator_theory.errors import InputError
from rcac_experiments.format._places import did_you_mean
from rcac_experiments.sweeps._axes import Axis, RandomAxis
from rcac_experiments.sweeps._canonical import (
    canonical_json,
    digest,
    file_digests,
    name_of,
    plain,
)
from rcac_experiments.sweeps._measures import Metric
from rcac_numeric.arrays._validation import instance_of, integer, items, one_of
from rcac_numeric.arrays._values import Value
from rcac_numeric.engine._batches import SimulationCase

CaseFunction = Callable[..., SimulationCase]
Coordinates = dict[str, Any]
# More runs than these are hardly meant: they have to be requested.
MANY_RUNS = 10**6
# Cells are numbered in one table of the store.
LARGEST_GRID = 10**7
SIGNALS = ("w", "u", "y", "z", "theta")


@dataclass(frozen=True, eq=False, init=False)
class Study(Value):
    """A study as data: each run is a function of its coordinates, its repetition and the seed.

    Parameters
    ----------
    base : mapping or function
        The tables of an experiment file without [[runs]]; or a function at the top of a module,
        `case(rng, **coordinates)`, that returns a `SimulationCase`, all that is random in it drawn
        from the `numpy.random.Generator` that it is given. Data that it needs are the fields of a
        frozen class at the top of a module, whose instance is called.
    axes : sequence of Axis or RandomAxis
        Every combination of their values is a cell.
    keep : sequence of Metric
        What is measured of every run, beside its outcome; nothing where it is left out.
    repetitions : int
        Runs of every cell, which differ in their noise; with `run.perturbation`, all but the first
        in w times 1 + perturbation * (standard normal) too.
    seed : int
        The root of all that is random.
    common_noise : bool
        Let repetition i have the same noise in all cells, to compare them pair by pair.
    lanes : bool
        As in `simulate_many`, decided for all runs of the study.
    keep_signals : sequence of str
        Which of w, u, y, z and theta are kept of every run.
    file : str
        Where the tables come from: errors name it, and relative paths in them start beside it.
    title : str

    Raises
    ------
    InputError
        Where something of it cannot be.

    Examples
    --------
    >>> from rcac_experiments.sweeps import Axis, Metric, Study
    >>> base = {
    ...     "plant": {"problem": "standard", "G": "1/(q - 0.9)"},
    ...     "signals": {"w": {"white_noise": 1}},
    ...     "target": {"model": "fir"}, "controller": {"n_c": 2, "R_theta": 1},
    ...     "run": {"steps": 200}}
    >>> study = Study(
    ...     base, [Axis("R_theta", [0.01, 1, 100], sets="controller.R_theta")],
    ...     [Metric("rms")], repetitions=10)
    >>> study
    Study(30 runs: R_theta 3 x 10 repetitions)
    """

    base: dict[str, Any] | CaseFunction
    axes: tuple[Axis, ...]
    keep: tuple[Metric, ...]
    repetitions: int
    seed: int
    common_noise: bool
    lanes: bool
    keep_signals: tuple[str, ...]
    file: str
    title: str

    def __init__(
        self,
        base: Mapping[str, Any] | CaseFunction,
        axes: Sequence[Axis | RandomAxis],
        keep: Sequence[Metric] = (),
        *,
        repetitions: int = 1,
        seed: int = 0,
        common_noise: bool = False,
        lanes: bool = True,
        keep_signals: Sequence[str] = (),
        file: str = "study",
        title: str = "",
        **others: Never,
    ) -> None:
        if others:
            known = [field.name for field in fields(self)]
            hint = did_you_mean(next(iter(others)), known)
            raise InputError(f"a study takes {', '.join(known)}, not {', '.join(others)}.{hint}")
        set_ = object.__setattr__
        set_(self, "seed", integer(seed, "seed"))
        requested = items(axes, "axes", Axis | RandomAxis)  # type: ignore[arg-type]
        drawn = [axis.drawn(seed) if isinstance(axis, RandomAxis) else axis for axis in requested]
        set_(self, "axes", tuple(drawn))
        set_(self, "keep", items(keep, "keep", Metric))
        for kind, names in (
            ("axes", [axis.name for axis in drawn]),
            ("columns", [*(axis.name for axis in drawn), *(metric.name for metric in self.keep)]),
            ("axes' paths", [axis.sets for axis in drawn]),
        ):
            lower = [name.lower() for name in names]  # SQL does not tell k_W from k_w
            if twice := next((name for name in names if lower.count(name.lower()) > 1), None):
                raise InputError(f"two {kind} are called {twice!r}; give each its own name.")
        set_(self, "repetitions", integer(repetitions, "repetitions", at_least=1))
        set_(self, "common_noise", instance_of(common_noise, "common_noise", bool))
        set_(self, "lanes", instance_of(lanes, "lanes", bool))
        signals = items(keep_signals, "keep_signals")
        set_(self, "keep_signals", tuple(one_of(s, "keep_signals", SIGNALS) for s in signals))
        set_(self, "file", instance_of(file, "file", str))
        set_(self, "title", instance_of(title, "title", str))
        set_(self, "base", _base(base, self.axes))
        if self.cells > LARGEST_GRID:
            raise InputError(
                f"the axes have {self.cells} combinations; at most {LARGEST_GRID} are allowed."
            )

    @property
    def cells(self) -> int:
        """Number of combinations of the axes' values."""
        return math.prod(map(len, self.axes))

    @property
    def runs(self) -> int:
        """Number of runs."""
        return self.cells * self.repetitions

    def document(self, coordinates: Coordinates) -> dict[str, Any]:
        """The experiment of one cell; for a study of tables."""
        assert isinstance(self.base, dict)
        document = self.base
        for axis in self.axes:
            document = with_value(document, axis.sets, coordinates[axis.name])
        return document

    @cached_property
    def resolved(self) -> dict[str, Any]:
        """Everything that decides the results, in JSON types."""
        return {
            "base": plain(self.base),
            "files": file_digests(
                [plain(self.base), *(a.values for a in self.axes)], str(Path(self.file).parent)
            ),
            "axes": [{"name": a.name, "sets": a.sets, "values": list(a.values)} for a in self.axes],
            "keep": [
                {"name": k.name, "measure": plain(k.measure), "arguments": k.arguments}
                for k in self.keep
            ],
            "repetitions": self.repetitions,
            "seed": self.seed,
            "common_noise": self.common_noise,
            "lanes": self.lanes,
            "keep_signals": list(self.keep_signals),
        }

    @property
    def fingerprint(self) -> str:
        """The digest of the study; equal for studies with equal results, on every machine."""
        return digest(canonical_json(self.resolved))

    def __repr__(self) -> str:
        parts = [f"{axis.name} {len(axis)}" for axis in self.axes]
        if self.repetitions > 1 or not parts:
            parts.append(f"{self.repetitions} repetitions")
        return f"Study({self.runs} runs: {' x '.join(parts)})"


def require_meant(study: Study, many: bool) -> None:
    """Refuse so many runs as nobody starts by intention, unless they were requested."""
    if study.runs > MANY_RUNS and not many:
        parts = " x ".join(f"{len(axis)} ({axis.name})" for axis in study.axes) or "1"
        raise InputError(
            f"the study has {study.runs} runs: {parts} cells x {study.repetitions} repetitions; "
            f"more than {MANY_RUNS} must be requested. On the command line --yes does that, in "
            "Python many=True."
        )


def _base(
    base: Mapping[str, Any] | CaseFunction, axes: Sequence[Axis]
) -> dict[str, Any] | CaseFunction:
    if callable(base):
        name_of(base)
        return base
    document = plain(instance_of(base, "base", Mapping))
    for name, instead in (("runs", "a study varies one run: use an axis"),):
        if document.get(name):
            raise InputError(f"[[{name}]] has no place in a study; {instead}.")
    run = document.get("run")
    if isinstance(run, Mapping):
        for name in ("seed", "repetitions"):
            if name in run or any(axis.sets == f"run.{name}" for axis in axes):
                raise InputError(
                    f"{name} of [run] has no place in a study, which sets {name} itself: set "
                    f"{name} of the study instead."
                )
    for axis in axes:
        try:
            with_value(document, axis.sets, axis.values[0])
        except InputError as error:
            raise InputError(f"the axis {axis.name!r}: ", *error.args) from None
    assert isinstance(document, dict)
    return document


def with_value(document: Mapping[str, Any], path: str, value: Any) -> dict[str, Any]:
    """A copy of the document with one value set.

    The table around it must be there; the last key may be new, an entry of a list may not.
    """
    keys = path.split(".")
    changed = _with(document, keys, value, path, "")
    assert isinstance(changed, dict)
    return changed


def _with(around: Any, keys: list[str], value: Any, path: str, walked: str) -> Any:
    key, rest = keys[0], keys[1:]
    location = f"{walked}.{key}" if walked else key
    if isinstance(around, list):
        if not key.isdecimal() or int(key) >= len(around):
            raise InputError(
                f"{path!r} leads nowhere: {walked} is a list of {len(around)}, and {key!r} is not "
                f"the number of one of its entries, from 0 on."
            )
        copy: Any = list(around)
        copy[int(key)] = _with(around[int(key)], rest, value, path, location) if rest else value
        return copy
    if not isinstance(around, Mapping):
        raise InputError(f"{path!r} leads nowhere: {walked} is {around!r}, which has no entries.")
    if not key or (rest and key not in around) or (not rest and not walked):
        raise InputError(
            f"{path!r} leads nowhere: {walked or 'the file'} has {', '.join(around)}."
            f"{did_you_mean(key, around)}"
        )
    return {**around, key: _with(around[key], rest, value, path, location) if rest else value}
