"""The plant, the controller structure and the target model of a check, as a shell can give them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.arrays.wording import shortened
from rcac_numeric.controllers.structure import Structure
from rcac_numeric.experiments.files.builder import FILE
from rcac_numeric.experiments.files.controllers import CONTROLLER
from rcac_numeric.experiments.files.documents import Raw, named, read_file
from rcac_numeric.experiments.files.plants import read_plant
from rcac_numeric.experiments.files.structures import STRUCTURE, sizes_of
from rcac_numeric.experiments.files.targets import TARGET
from rcac_numeric.experiments.format.places import Place
from rcac_numeric.experiments.format.tables import require_table
from rcac_numeric.plants.linear import MATRICES, Plant
from rcac_numeric.plants.problems import servo_plant, standard_plant
from rcac_numeric.plants.schedules import PlantSchedule
from rcac_numeric.signals.data_files import FORMATS, read_variables
from rcac_numeric.signals.text_tables import as_number
from rcac_numeric.targets.filters import target_model
from rcac_numeric.targets.model import TargetModel

Names = dict[str, str]


def parse_names(text: str, option: str = "names", example: str = "u=input,y=output") -> Names:
    """The option --names u=input,y=output as a mapping.

    Examples
    --------
    >>> from rcac_numeric.cli.check_inputs import parse_names
    >>> parse_names("u=input, y=output")
    {'u': 'input', 'y': 'output'}
    """
    names: dict[str, str] = {}
    for part in filter(None, (p.strip() for p in text.split(","))):
        role, equals, name = (piece.strip() for piece in part.partition("="))
        if not (role and equals and name):
            raise InputError(f"--{option} has the entry {part!r}; write for instance {example}.")
        if role in names:
            raise InputError(f"--{option} gives {role} twice: {names[role]!r} and {name!r}.")
        names[role] = name
    return names


def parse_noise(text: str) -> dict[str, float] | None:
    """The option --noise d=1,v=0.25 as intensities of blocks or channels of w.

    Examples
    --------
    >>> from rcac_numeric.cli.check_inputs import parse_noise
    >>> parse_noise("d=1, v=0.25")
    {'d': 1.0, 'v': 0.25}
    """
    noise: dict[str, float] = {}
    for name, intensity in parse_names(text, "noise", "d=1,v=0.25").items():
        value = as_number(intensity)
        if value is None:
            raise InputError(
                f"--noise {name}={intensity}: {intensity!r} is no number; write for instance "
                "d=1,v=0.25."
            )
        noise[name] = value
    return noise or None


def read_case(plant: str | None, problem: str) -> tuple[Plant | None, Raw]:
    """The plant that --plant means, and the tables of its file where it is an experiment file.

    Parameters
    ----------
    plant : str or None
        The path of a .toml file with [plant]; of a .mat or .npz file with the matrices A, B, D_1,
        C, ...; or a transfer function in q.
    problem : {"standard", "servo"}
        What a transfer function is the plant of.
    """
    if plant is None:
        return None, {}
    suffix = Path(plant).suffix.lower()
    if suffix == ".toml":
        table, file = read_file(plant)
        try:
            FILE.require_known(table, Place(file))
            found = read_plant(table.get("plant", {}), Place(file, "plant")).build()
        except CompensatorError as error:
            raise named(error, file) from None
        if isinstance(found, PlantSchedule):
            raise InputError(
                f"{file}: the plant changes while it runs; give the one plant that the controller "
                "is to be checked with, without [[plant.changes]]."
            )
        return found, table
    if suffix in FORMATS:
        variables = read_variables(plant)
        found_plant = plant_in(variables, plant)
        if found_plant is None:
            raise InputError(
                f"{plant} has no plant: A, B and C are needed, and it has "
                f"{shortened(', '.join(variables))}."
            )
        return found_plant, {}
    return (servo_plant(plant) if problem == "servo" else standard_plant(plant)), {}


def plant_in(variables: Mapping[str, Any], file: str) -> Plant | None:
    """The plant whose matrices are among a file's variables; D_1 = B where it is left out."""
    if not {"A", "B", "C"} <= variables.keys():
        return None
    matrices = {name: variables[name] for name in MATRICES if name in variables}
    try:
        return Plant(**{"D_1": variables["B"], **matrices})
    except CompensatorError as error:
        raise named(error, file) from None


def read_structure(
    table: Raw, plant: Plant | None, *, kind: str | None, n_c: int | None, k_c: int | None,
    widths: tuple[int, int],
) -> Structure | None:  # fmt: skip
    """The structure of the options, or else of [controller]; None where neither says any."""
    given: Raw = {}
    place = Place("--plant", "controller")
    own = require_table(table.get("controller", {}), place)
    CONTROLLER.table.require_known(own, place)
    if kind is None and n_c is None:
        given = {key: value for key, value in own.items() if key in STRUCTURE.all_keys()}
        if not given:
            return None
    else:
        given["structure"] = kind or "iir"
        if n_c is not None:
            given["n_c"] = n_c
    if k_c is not None:
        given["k_c"] = k_c
    sizes: Any = plant if plant is not None else _Sizes(*widths)
    try:
        part = STRUCTURE.read(given, Place("the options", "controller"))
        return part.build(**sizes_of(sizes))
    except InputError as error:
        hint = " Give --n-c." if "needs the key 'n_c'" in str(error) else ""
        raise InputError(f"{error}{hint}") from None


class _Sizes:
    """Widths of a log whose plant is not known, as far as a structure asks for them."""

    def __init__(self, l_u: int, l_y: int) -> None:
        self.l_u, self.l_y = l_u, l_y
        self.blocks: dict[str, int] = {}


def read_target(table: Raw, plant: Plant | None, G_f: str | None) -> TargetModel | None:
    """The target model of --target, or else of [target]."""
    if G_f is not None:
        return target_model(G_f)
    if plant is None or "target" not in table:
        return None
    part = TARGET.table.read(table["target"], Place("the experiment file", "target"))
    made: TargetModel = part.build(plant=plant)
    return made
