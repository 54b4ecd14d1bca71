"""The signals of an experiment file: one for each channel of the exogenous input."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from compensator_theory.errors import InputError
from rcac_numeric.experiments.format.by_key import ByKey
from rcac_numeric.experiments.format.lists import ListOf, Row
from rcac_numeric.experiments.format.parts import Part
from rcac_numeric.experiments.format.places import Place, brief
from rcac_numeric.experiments.format.tables import Table
from rcac_numeric.experiments.format.values import Form, Integer, Numbers, Schema, Text
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.schedules import PlantSchedule
from rcac_numeric.signals.recordings import Recorded, read_recording
from rcac_numeric.signals.sequences import Levels, Piecewise
from rcac_numeric.signals.signal import Signal, Sum
from rcac_numeric.signals.waveforms import Harmonic, Pulse, Ramp, Step, WhiteNoise


class _Record(Form):
    """A list of numbers or the name of a file."""

    words = "a list of numbers, or the path of a .csv or .npy file"

    def read(self, value: object, place: Place) -> Any:
        """By what it is."""
        return (Text() if isinstance(value, str) else Numbers()).read(value, place)

    def schema(self) -> Schema:
        """Either."""
        return {"anyOf": [Text().schema(), Numbers().schema()]}


class _Column(Form):
    """The index or the name of a column."""

    words = "the index of a column from 0, or its name"

    def read(self, value: object, place: Place) -> int | str:
        """By what it is."""
        return (Text() if isinstance(value, str) else Integer()).read(value, place)

    def schema(self) -> Schema:
        """Either."""
        return {"anyOf": [Text().schema(), Integer().schema()]}


class _OneOrSeveral(Form):
    """A signal, or a list of them for a block with several components."""

    words = "a signal, or a list of one for each component"

    def read(self, value: object, place: Place) -> list[Part[Signal]]:
        """As a list."""
        entries = value if isinstance(value, list) else [value]
        return ListOf(SIGNAL).read(entries, place)

    def schema(self) -> Schema:
        """Either."""
        return {"anyOf": [SIGNAL.schema(), ListOf(SIGNAL).schema()]}


def _recorded(record: Any, column: Any = None, *, folder: Path) -> Signal:
    """One value for each step; a longer run is refused.

    Parameters
    ----------
    record : list of numbers, or str
        The values, or a .csv or .npy file in the folder of the TOML file or below it.
    column : int or str
        Index from 0, or name, of a column of that file; the first where it is left out.
    """
    if isinstance(record, str):
        values = read_recording(_within(folder, record), 0 if column is None else column)
        return Recorded(values, record)
    if column is not None:
        raise InputError("[signals]: column is for a file; recorded is a list here.")
    return Recorded(record)


def _within(folder: Path, record: str) -> Path:
    """The path of a record in the folder of the file that names it, or in one below."""
    path = folder / record
    try:
        is_inside = path.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError, ValueError):  # a circle of links, or no path at all
        is_inside = False
    if not is_inside:
        raise InputError(
            f"[signals]: recorded = {brief(record)} leads out of the folder of the file. An "
            "experiment file opens records in its own folder alone; put a copy there."
        )
    return path


def _sum(parts: list[Signal]) -> Signal:
    """A sum of signals, added in their order.

    Parameters
    ----------
    parts : list of signals
        The signals that are added.
    """
    return Sum(tuple(parts))


SIGNAL: ByKey[Signal] = ByKey("a signal", number=Step)
SIGNAL.register("step", Step)
SIGNAL.register("ramp", Ramp)
SIGNAL.register("pulse", Pulse)
SIGNAL.register("harmonic", Harmonic)
SIGNAL.register("white_noise", WhiteNoise)
SIGNAL.register("sequence", Levels)
SIGNAL.register(
    "piecewise",
    Piecewise,
    forms={
        "pieces": ListOf(
            Row((Integer(), SIGNAL), "a pair [start, signal]"),
            needed="a list of pairs [start, signal]",
        )
    },
)
SIGNAL.register("sum", _sum, forms={"parts": ListOf(SIGNAL, 1, "a list of signals")})
SIGNAL.register(
    "recorded", _recorded, given=["folder"], forms={"record": _Record(), "column": _Column()}
)


def _blocks(
    w: list[Signal] | None = None,
    r: list[Signal] | None = None,
    d: list[Signal] | None = None,
    v: list[Signal] | None = None,
) -> Mapping[str, list[Signal]]:
    """The signals of each block of the exogenous input.

    Parameters
    ----------
    w : signals
        Of the standard problem.
    r, d, v : signals
        Of the servo problem: command, disturbance, sensor noise.
    """
    named = {"w": w, "r": r, "d": d, "v": v}
    return {name: parts for name, parts in named.items() if parts is not None}


SIGNALS = Table(_blocks, forms=dict.fromkeys("wrdv", _OneOrSeveral()))


def signals_of(
    part: Part[Mapping[str, list[Signal]]], plant: Plant | PlantSchedule, folder: Path
) -> tuple[Signal, ...]:
    """One signal for each channel of w; a block that the file does not name is zero."""
    given = part.build(folder=folder)
    for name in given:
        if name not in plant.blocks:
            raise InputError(
                f"[signals] sets {name!r}; this plant's exogenous input has "
                f"{', '.join(plant.blocks)}."
            )
    channels: list[Signal] = []
    for name, width in plant.blocks.items():
        parts = given.get(name, [Step(0.0)] * width)
        if len(parts) != width:
            raise InputError(f"[signals] {name} has {len(parts)} components; {width} are needed.")
        channels += parts
    return tuple(channels)
