"""The signals of an experiment file: one for each channel of the exogenous input."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import attrs

from compensator_theory.errors import InputError
from rcac_experiments.format._parts import Shorthand
from rcac_experiments.format._places import Place, brief
from rcac_experiments.format._tables import ByKey, Table
from rcac_experiments.format._values import Form, Integer, ListOf, Numbers, Row, Schema, Text
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import PlantSchedule
from rcac_numeric.signals._commands import FilteredCommand
from rcac_numeric.signals._recordings import Recorded, read_recording
from rcac_numeric.signals._sequences import Levels, Piecewise
from rcac_numeric.signals._signal import Signal, SignalSum
from rcac_numeric.signals._waveforms import Harmonic, Pulse, Ramp, Step, WhiteNoise


class _Record(Form):
    """A list of numbers or the name of a file."""

    words = "a list of numbers, or the path of a .csv or .npy file"

    def read(self, value: object, place: Place) -> Any:
        """By what it is; a path begins in the folder of the file that names it."""
        if not isinstance(value, str):
            return Numbers().read(value, place)
        return _within(Path(place.file).parent, value), value

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

    def read(self, value: object, place: Place) -> list[Signal]:
        """As a list."""
        entries = value if isinstance(value, list) else [value]
        return ListOf(SIGNAL).read(entries, place)

    def schema(self) -> Schema:
        """Either."""
        return {"anyOf": [SIGNAL.schema(), ListOf(SIGNAL).schema()]}


@attrs.frozen(eq=False)
class RecordedHere(Shorthand):
    """One value for each step; a longer run is refused."""

    record: Annotated[
        Array | tuple[Path, str],
        _Record(),
        "The values, or a .csv or .npy file in the folder of the TOML file or below it.",
    ]
    column: Annotated[
        int | str | None,
        _Column(),
        "Index from 0, or name, of a column of that file; the first where it is left out.",
    ] = None

    def made(self) -> Signal:
        """The record."""
        if isinstance(self.record, tuple):
            path, name = self.record
            return Recorded(read_recording(path, 0 if self.column is None else self.column), name)
        if self.column is not None:
            raise InputError("[signals]: column is for a file; recorded is a list here.")
        return Recorded(self.record)


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
SIGNAL.register("filtered", FilteredCommand, forms={"signal": SIGNAL})
SIGNAL.register("sum", SignalSum, forms={"parts": ListOf(SIGNAL, 1, "a list of signals")})
SIGNAL.register("recorded", RecordedHere)
OF_SERVO = "Of the servo problem: command, disturbance, sensor noise."


@attrs.frozen(eq=False)
class Signals:
    """The signals of each block of the exogenous input."""

    w: Annotated[list[Signal] | None, _OneOrSeveral(), "Of the standard problem."] = None
    r: Annotated[list[Signal] | None, _OneOrSeveral(), OF_SERVO] = None
    d: Annotated[list[Signal] | None, _OneOrSeveral(), OF_SERVO] = None
    v: Annotated[list[Signal] | None, _OneOrSeveral(), OF_SERVO] = None

    def of(self, plant: Plant | PlantSchedule) -> tuple[Signal, ...]:
        """One signal for each channel of w; a block that the file does not name is zero."""
        given = {name: parts for name in "wrdv" if (parts := getattr(self, name)) is not None}
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
                raise InputError(
                    f"[signals] {name} has {len(parts)} components; {width} are needed."
                )
            channels += parts
        return tuple(channels)


SIGNALS = Table(Signals)
