"""The controller structure of an experiment file."""

from __future__ import annotations

from typing import Any

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import one_of
from rcac_numeric.controllers.kinds import feedforward, fir, fir_integrator, iir, pid, quasi_fir
from rcac_numeric.controllers.structure import DerivedSignal, Structure, Tap
from rcac_numeric.experiments.files.sections import KEYS, Section
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.schedules import PlantSchedule

# For each structure the function that makes it, the keys that it needs and those that it may have.
KINDS: dict[str, tuple[Any, tuple[str, ...], tuple[str, ...]]] = {
    "iir": (iir, ("n_c",), ("k_c",)),
    "fir": (fir, ("n_c",), ("k_c",)),
    "quasi-fir": (quasi_fir, ("n_c",), ("free_poles", "k_c")),
    "pid": (pid, (), ("terms",)),
    "fir + integrator": (fir_integrator, ("n_c",), ("F", "k_c")),
    "feedforward": (feedforward, ("n_c",), ("feedback", "first_r", "k_c")),
    "taps": (Structure, ("taps",), ("derived", "n_c")),
}
STRUCTURE_KEYS = {"structure"}.union(*(needed + optional for _, needed, optional in KINDS.values()))


def structure_of(section: Section, plant: Plant | PlantSchedule) -> Structure:
    """The structure, as wide as the plant asks for."""
    kind = one_of(section.text("structure", "iir"), "structure", (*KINDS, "lqg"))
    make, needed, optional = KINDS[kind]
    own = Section(
        section.given(*STRUCTURE_KEYS), section.name, section.file, keys=KEYS["controller"]
    )
    own.only(f'structure = "{kind}"', "structure", *needed, *optional)
    for key in needed:
        own.require(key)
    widths = {"l_u": plant.l_u, "l_y": plant.l_y}
    options = own.given(*needed, *optional)
    if kind == "taps":
        options["derived"] = [_derived(entry, section.file) for entry in own.items("derived")]
        options["taps"] = [_tap(entry) for entry in own.items("taps")]
        reads_r = any(tap.signal == "r" for tap in options["taps"]) or any(
            len(signal.now) > plant.l_y for signal in options["derived"]
        )
        widths["l_r"] = _commands(plant, "taps") if reads_r else 0
    if kind == "feedforward":
        widths["l_r"] = _commands(plant, "feedforward")
    structure: Structure = make(**options, **widths)
    return structure


def _commands(plant: Plant | PlantSchedule, kind: str) -> int:
    if not plant.blocks.get("r", 0):
        raise InputError(
            f'structure = "{kind}" reads the command r, but this plant\'s exogenous input has '
            f"{', '.join(plant.blocks)}."
        )
    return int(plant.blocks["r"])


def _tap(entry: Any) -> Tap:
    if not (isinstance(entry, list) and len(entry) == 3 and isinstance(entry[0], str)):
        raise InputError(
            f'taps has the entry {entry!r}; [signal, component, delay] such as ["y", 0, 1] is '
            "needed."
        )
    return Tap(*entry)


def _derived(entry: Any, file: str) -> DerivedSignal:
    table = Section(entry, "controller.derived", file)
    now = table.items("now")
    before = table.items("before") or [0.0] * len(now)
    return DerivedSignal(tuple(now), tuple(before), table.get("pole", 0.0))
