"""Read plant, structure and target model of an experiment file, for a log."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypedDict

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.files._builder import FILE
from rcac_experiments.files._controllers import CONTROLLER, WHOLE
from rcac_experiments.files._documents import Raw, named, read_file
from rcac_experiments.files._plants import read_plant
from rcac_experiments.files._structures import STRUCTURE
from rcac_experiments.files._targets import TARGET
from rcac_experiments.format._places import Location, MissingKeyError
from rcac_experiments.format._tables import require_table
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import PlantSchedule
from rcac_numeric.targets._filters import target_model
from rcac_numeric.targets._model import TargetModel


class CheckArguments(TypedDict):
    """The result of `check_arguments`: keyword arguments of `check_controller`."""

    plant: Plant
    structure: Structure | None
    target: TargetModel | None
    k_w: int | None


def check_arguments(path: str | Path) -> CheckArguments:
    """Read the arguments of `check_controller` from an experiment file.

    Parameters
    ----------
    path : path
        Of a TOML file with [plant], and where they are known [controller] and [target]; it needs
        no [run], as `rcac check --plant` needs none.

    Returns
    -------
    dict
        plant, structure, target and k_w; None where the file says nothing of it.

    Raises
    ------
    InputError
        Where the file cannot be read, or its plant changes while it runs; other errors of the tree
        where the plant or the target model does not allow it.

    Examples
    --------
    >>> from rcac_experiments import check_arguments
    >>> from rcac_numeric import check_controller, read_log
    >>> log = read_log("examples/octave/rcac_loop.mat")
    >>> check_controller(log, **check_arguments("examples/octave/example_4_7.toml")).is_consistent
    True
    """
    plant, table = plant_and_tables(path)
    try:
        structure = read_structure(table, plant, kind=None, n_c=None, k_c=None, widths=(0, 0))
        target = read_target(table, plant, None)
    except CompensatorError as error:
        raise named(error, str(path)) from None
    return {"plant": plant, "structure": structure, "target": target, "k_w": k_w_of(table)}


def plant_and_tables(path: str | Path) -> tuple[Plant, Raw]:
    """The plant of an experiment file, and its tables."""
    table, file = read_file(path)
    try:
        FILE.require_known(table, Location(file))
        plant = read_plant(table.get("plant", {}), Location(file, "plant")).build()
    except CompensatorError as error:
        raise named(error, file) from None
    if isinstance(plant, PlantSchedule):
        raise InputError(
            f"{file}: the plant changes during the run; give the plant of the final controller, "
            "without [[plant.changes]]."
        )
    return plant, table


def k_w_of(table: Raw) -> int | None:
    """The first step with control, where [controller] says it.

    Examples
    --------
    >>> from rcac_experiments.files._case_files import k_w_of
    >>> k_w_of({"controller": {"k_w": 50}})
    50
    """
    table_of_controller = table.get("controller")
    return table_of_controller.get("k_w") if isinstance(table_of_controller, dict) else None


def read_structure(
    table: Raw, plant: Plant | None, *, kind: str | None, n_c: int | None, k_c: int | None,
    widths: tuple[int, int],
) -> Structure | None:  # fmt: skip
    """The structure of the options, or else of [controller]; None where neither says any."""
    defaults: Raw = {}
    place = Location("--plant", "controller")
    table_of_controller = require_table(table.get("controller", {}), place)
    CONTROLLER.table.require_known(table_of_controller, place)
    if kind is None and n_c is None:
        if (whole := table_of_controller.get("structure")) in list(WHOLE):
            raise InputError(
                f"[controller] structure = {whole!r} is a complete controller, and u, y and theta "
                "of a log do not replay it. Check the saved run (rcac verify CASE --save RUN.npz), "
                "or remove [controller] and give --controller, the transfer function of u."
            )
        defaults = {
            key: value for key, value in table_of_controller.items() if key in STRUCTURE.all_keys()
        }
        if not defaults:
            return None
    else:
        defaults["structure"] = kind or "iir"
        if n_c is not None:
            defaults["n_c"] = n_c
    if k_c is not None:
        defaults["k_c"] = k_c
    sizes: Any = plant if plant is not None else _Sizes(*widths)
    try:
        part = STRUCTURE.read(defaults, Location("the options", "controller"))
        structure: Structure = part.of(sizes)
        return structure
    except MissingKeyError as error:
        if error.key == "n_c" and kind is not None:
            raise InputError(f"--structure {kind} needs its order n_c: give --n-c.") from None
        raise


class _Sizes:
    """Widths of a log whose plant is not known, as far as the structure fixes them."""

    def __init__(self, l_u: int, l_y: int) -> None:
        self.l_u, self.l_y = l_u, l_y
        self.blocks: dict[str, int] = {}


def read_target(table: Raw, plant: Plant | None, G_f: str | None) -> TargetModel | None:
    """The target model of --target, or else of [target]."""
    if G_f is not None:
        return target_model(G_f)
    if plant is None or "target" not in table:
        return None
    part = TARGET.table.read(table["target"], Location("the experiment file", "target"))
    target: TargetModel = part.of(plant)
    return target
