"""The plant, names and intensities of a check, as a shell can give them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.arrays.wording import shortened
from rcac_numeric.checks.case_files import plant_and_tables
from rcac_numeric.experiments.files.documents import Raw, named
from rcac_numeric.plants.linear import MATRICES, Plant
from rcac_numeric.plants.problems import servo_plant, standard_plant
from rcac_numeric.signals.data_files import FORMATS, read_variables
from rcac_numeric.signals.text_tables import as_number

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
        return plant_and_tables(plant)
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


def is_transfer_function(plant: str | None) -> bool:
    """Whether --plant is neither left out nor the name of a file.

    Examples
    --------
    >>> from rcac_numeric.cli.check_inputs import is_transfer_function
    >>> is_transfer_function("1/(q - 0.5)"), is_transfer_function("plant.toml")
    (True, False)
    """
    return plant is not None and Path(plant).suffix.lower() not in (".toml", *FORMATS)


def plant_in(variables: Mapping[str, Any], file: str) -> Plant | None:
    """The plant whose matrices are among a file's variables; D_1 = B where it is left out."""
    if not {"A", "B", "C"} <= variables.keys():
        return None
    matrices = {name: variables[name] for name in MATRICES if name in variables}
    try:
        return Plant(**{"D_1": variables["B"], **matrices})
    except CompensatorError as error:
        raise named(error, file) from None
