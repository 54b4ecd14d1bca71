"""The plant of an experiment file, and how it changes while it runs."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import one_of
from rcac_numeric.experiments.files.sections import Section, Table
from rcac_numeric.plants.linear import MATRICES, Plant
from rcac_numeric.plants.problems import from_problem, servo_plant, standard_plant
from rcac_numeric.plants.schedules import PlantChange, PlantSchedule


def plant_of(section: Section) -> Plant | PlantSchedule:
    """The plant; with [[plant.changes]] a schedule, each of them going on from the one before."""
    own = {key: value for key, value in section.table.items() if key != "changes"}
    changes = [PlantChange(start=0, plant=_plant(own, section.file))]
    gain, delay = 1, 0
    for index, table in enumerate(section.tables("changes")):
        entry = Section(table, "plant.changes", section.file)
        given = entry.given("G", *MATRICES)
        if "G" in given or ("G" in own and given):
            own = {key: value for key, value in own.items() if key not in ("G", *MATRICES)}
        own = {**own, **given}
        gain, delay = entry.get("gain", gain), entry.get("delay", delay)
        change = PlantChange(
            start=entry.require("start"),
            plant=_amplified(_plant(own, section.file), gain),
            ramp=entry.flag("ramp"),
            state_map=entry.get("state_map", None),
            delay=delay,
        )
        if index == 0 and change.start == 0:
            changes = []  # what the file says of step 0 itself
        changes.append(change)
    return PlantSchedule(changes) if "changes" in section.table else changes[0].plant


def _plant(table: Table, file: str) -> Plant:
    section = Section(table, "plant", file)
    problem = one_of(section.text("problem"), "problem", ("standard", "servo"))
    if problem == "servo":
        one_of(section.text("performance", "measured"), "performance", ("measured", "true"))
    performance = ("performance",) if problem == "servo" else ()
    if "G" in section.table:
        section.only(f'problem = "{problem}" with G', "problem", "G", *performance)
        _require_coprime(section.table["G"])
        make = servo_plant if problem == "servo" else standard_plant
        return make(**section.given("G", *performance))
    allowed = ("A", "B", "D_1", "C", "D_0") if problem == "servo" else MATRICES
    section.only(f'problem = "{problem}"', "problem", *allowed, *performance)
    for key in ("A", "B", "C") if problem == "servo" else ("A", "B", "D_1", "C"):
        section.require(key)
    matrices = section.given(*allowed)
    if problem == "servo":
        return servo_plant(**matrices, **section.given(*performance))
    from compensator_theory import StandardProblem

    left_out = {"D_0": None, "D_2": None, "E_1": matrices["C"], "E_2": None, "E_0": None}
    return from_problem(StandardProblem(**{**left_out, **matrices}))


def _amplified(plant: Plant, gain: Any) -> Plant:
    """The plant whose control input acts `gain` times as strongly."""
    if gain == 1:
        return plant
    from compensator_theory import exact_number

    factor = exact_number(gain)
    if not (factor.is_number and factor.is_real):
        raise InputError(f"gain = {gain!r} is not a real number.")
    problem = plant.problem
    scaled = {name: factor * getattr(problem, name) for name in ("B", "D_0", "E_2")}
    return from_problem(replace(problem, **scaled), plant.blocks)


def _require_coprime(G: Any) -> None:
    from compensator_theory import NotCoprimeError, transfer_function

    plant = transfer_function(G)
    if plant.is_coprime is False:
        factor = plant.common_factor().as_expr()
        raise NotCoprimeError(
            f"numerator and denominator of the plant G share the factor {factor}: no controller "
            "moves that pole. Cancel the factor, or give the matrices A, B, D_1 and C if the "
            "hidden mode is meant."
        )
