"""The signals of an experiment file: one for each channel of the exogenous input."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from compensator_theory.errors import InputError
from rcac_experiments.format._places import Location, quoted
from rcac_experiments.format._tables import ByKey, Table
from rcac_experiments.format._values import Form, Integer, ListOf, Numbers, Row, Schema, String
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import PlantSchedule
from rcac_numeric.signals._commands import FilteredCommand
from rcac_numeric.signals._recordings import Recorded, read_recording
from rcac_numeric.signals._sequences import Levels, Piecewise
from rcac_numeric.signals._signal import Signal, Sum
from rcac_numeric.signals._waveforms import Harmonic, Pulse, Ramp, Step, WhiteNoise


class _Record(Form):
    """A list of numbers or the name of a file."""

    words = "a list of numbers, or the path of a .csv or .npy file"

    def read(self, value: object, place: Location) -> Any:
        """By what it is; a path begins in the folder of the file that names it."""
        if not isinstance(value, str):
            return Numbers().read(value, place)
        return _within(Path(place.file).parent, value), value

    def schema(self) -> Schema:
        """Either."""
        return {"anyOf": [String().schema(), Numbers().schema()]}


class _Column(Form):
    """The index or the name of a column."""

    words = "the index of a column from 0, or its name"

    def read(self, value: object, place: Location) -> int | str:
        """By what it is."""
        return (String() if isinstance(value, str) else Integer()).read(value, place)

    def schema(self) -> Schema:
        """Either."""
        return {"anyOf": [String().schema(), Integer().schema()]}


class _OneOrSeveral(Form):
    """A signal, or a list of them for a block with several components."""

    words = "a signal, or a list of one for each component"

    def read(self, value: object, place: Location) -> list[Signal]:
        """Read the value as a list."""
        entries = value if isinstance(value, list) else [value]
        return ListOf(SIGNAL).read(entries, place)

    def schema(self) -> Schema:
        """Either."""
        return {"anyOf": [SIGNAL.schema(), ListOf(SIGNAL).schema()]}


def recorded(
    record: Annotated[
        Array | tuple[Path, str],
        _Record(),
        "The values, or a .csv or .npy file in the folder of the TOML file or below it.",
    ],
    column: Annotated[
        int | str | None,
        _Column(),
        "Index from 0, or name, of a column of that file; the first where it is left out.",
    ] = None,
) -> Signal:
    """One value for each step; a longer run is refused."""
    if isinstance(record, tuple):
        path, name = record
        return Recorded(read_recording(path, 0 if column is None else column), name)
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
            f"[signals]: recorded = {quoted(record)} is outside the folder of the file. An "
            "experiment file opens records only in its folder; put a copy there."
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
SIGNAL.register("sum", Sum, forms={"parts": ListOf(SIGNAL, 1, "a list of signals")})
SIGNAL.register("recorded", recorded)
Components = list[Signal] | None
OfServo = Annotated[
    Components, _OneOrSeveral(), "Of the servo problem: command, disturbance, sensor noise."
]


def channels(
    plant: Plant | PlantSchedule,
    w: Annotated[Components, _OneOrSeveral(), "Of the standard problem."] = None,
    r: OfServo = None,
    d: OfServo = None,
    v: OfServo = None,
) -> tuple[Signal, ...]:
    """The signals of each block of the exogenous input, zero where the file does not name one."""
    blocks = {"w": w, "r": r, "d": d, "v": v}
    for name, parts in blocks.items():
        if parts is not None and name not in plant.blocks:
            raise InputError(
                f"[signals] sets {name!r}; this plant's exogenous input has "
                f"{', '.join(plant.blocks)}."
            )
    signals: list[Signal] = []
    for name, width in plant.blocks.items():
        parts = blocks.get(name)
        parts = [Step(0.0)] * width if parts is None else parts
        if len(parts) != width:
            raise InputError(f"[signals] {name} has {len(parts)} components; it needs {width}.")
        signals += parts
    return tuple(signals)


SIGNALS = Table(channels, supplied=["plant"])
