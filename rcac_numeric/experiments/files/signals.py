"""The signals of an experiment file: one for each channel of the exogenous input."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import number
from rcac_numeric.experiments.files.sections import Section
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.schedules import PlantSchedule
from rcac_numeric.signals.recordings import Recorded, read_recording
from rcac_numeric.signals.signal import Signal
from rcac_numeric.signals.waveforms import (
    Harmonic,
    Levels,
    Piecewise,
    Pulse,
    Ramp,
    Step,
    WhiteNoise,
)

# For each kind of signal the function that makes it and the argument that its key stands for.
KINDS: dict[str, tuple[Any, str]] = {
    "step": (Step, "height"),
    "ramp": (Ramp, "slope"),
    "pulse": (Pulse, "height"),
    "harmonic": (Harmonic, "omega"),
    "white_noise": (WhiteNoise, "std"),
    "sequence": (Levels, "levels"),
}


def signals(section: Section, plant: Plant | PlantSchedule) -> tuple[Signal, ...]:
    """One signal for each channel of w; a block that the file does not name is zero."""
    for key in section.table:
        if key not in plant.blocks:
            raise InputError(
                f"[signals] sets {key!r}; this plant's exogenous input has "
                f"{', '.join(plant.blocks)}."
            )
    channels: list[Signal] = []
    for name, width in plant.blocks.items():
        value = section.get(name, [0.0] * width)
        parts = value if isinstance(value, list) else [value]
        if len(parts) != width:
            raise InputError(f"[signals] {name} has {len(parts)} components; {width} are needed.")
        folder = Path(section.file).parent
        channels += [_signal(part, name, folder) for part in parts]
    return tuple(channels)


def real(value: Any, name: str) -> float:
    """A number; a string such as "pi/8" is evaluated exactly and rounded once."""
    if not isinstance(value, str):
        return number(value, name)
    from compensator_theory import parse_expression

    expression = parse_expression(value)
    if not (expression.is_number and expression.is_real):
        raise InputError(f"{name} = {value!r} is not a real number.")
    return float(expression)


def _signal(value: Any, name: str, folder: Path) -> Signal:
    if isinstance(value, int | float) and not isinstance(value, bool):
        return Step(value)
    if isinstance(value, dict) and set(value) == {"sum"}:
        if not isinstance(value["sum"], list) or not value["sum"]:
            raise InputError(f"[signals] {name}: sum = {value['sum']!r} must be a list of signals.")
        parts = [_signal(part, name, folder) for part in value["sum"]]
        return sum(parts[1:], parts[0])
    if isinstance(value, dict) and "recorded" in value:
        return _recorded(value, name, folder)
    if isinstance(value, dict) and set(value) == {"piecewise"}:
        pieces = _pieces(value, name)
        return Piecewise([(start, _signal(part, name, folder)) for start, part in pieces])
    for kind in KINDS.keys() & (value.keys() if isinstance(value, dict) else ()):
        make, first = KINDS[kind]
        arguments = {first if key == kind else key: entry for key, entry in value.items()}
        if isinstance(arguments[first], str):
            arguments[first] = real(arguments[first], f"[signals] {name}.{kind}")
        try:
            signal: Signal = make(**arguments)
        except TypeError as error:
            raise InputError(f"[signals] {name}: {error}.") from None
        return signal
    raise InputError(
        f"[signals] {name} = {value!r} is not a signal; use a number, or a table with one of "
        f"{', '.join(KINDS)}, recorded, piecewise or sum."
    )


def _recorded(value: dict[str, Any], name: str, folder: Path) -> Signal:
    """A list of numbers, or a column of a file whose path is relative to the experiment's."""
    if unknown := value.keys() - {"recorded", "column"}:
        raise InputError(
            f"[signals] {name}: recorded does not read {', '.join(sorted(unknown))}; it reads "
            "column, where it names a file."
        )
    source = value["recorded"]
    if isinstance(source, str):
        return Recorded(read_recording(folder / source, value.get("column", 0)), source)
    if "column" in value:
        raise InputError(f"[signals] {name}: column is for a file; recorded is a list here.")
    return Recorded(source, f"[signals] {name}.recorded")


def _pieces(value: dict[str, Any], name: str) -> list[Any]:
    pieces = value["piecewise"]
    if not (isinstance(pieces, list) and all(isinstance(p, list) and len(p) == 2 for p in pieces)):
        raise InputError(
            f"[signals] {name}: piecewise = {pieces!r} must be a list of pairs [start, signal]."
        )
    return pieces
