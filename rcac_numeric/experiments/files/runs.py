"""The runs of an experiment file: its tables joined with what each run overrides, then read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.values import Value
from rcac_numeric.controllers.decentralized import Decentralized
from rcac_numeric.controllers.fixed import FixedController
from rcac_numeric.controllers.structure import Structure
from rcac_numeric.engine.compatibility import controllers_of, require_fit
from rcac_numeric.engine.reference.run import require_supported
from rcac_numeric.experiments.budgets import Budget
from rcac_numeric.experiments.experiment import RunSpecification
from rcac_numeric.experiments.files.controllers import (
    CONTROLLER,
    ONE_OF_SEVERAL,
    ControllerSpecification,
    read_controllers,
)
from rcac_numeric.experiments.files.plants import PLANT, PlantSpecification, read_plant
from rcac_numeric.experiments.files.signals import SIGNALS, signals_of
from rcac_numeric.experiments.files.structures import sizes_of
from rcac_numeric.experiments.files.targets import TARGET
from rcac_numeric.experiments.files.updates import UPDATES
from rcac_numeric.experiments.format.deferred import Deferred
from rcac_numeric.experiments.format.lists import ListOf
from rcac_numeric.experiments.format.parts import Part
from rcac_numeric.experiments.format.places import Place
from rcac_numeric.experiments.format.tables import Raw, Table
from rcac_numeric.experiments.format.values import Choice, Form, Integer, Numbers
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.saturation import Saturation
from rcac_numeric.plants.schedules import PlantSchedule

ARITHMETICS = ("ud", "covariance", "reference")


@dataclass(frozen=True)
class Course:
    """How a run is run.

    Parameters
    ----------
    steps : int
        Length of the run.
    seed : int
        Of the noise.
    stride : int
        theta is kept at every stride-th step.
    arithmetic : str
        Of the recursive update: "ud", "covariance" or "reference", which is certified with 250
        digits, see [arithmetic](arithmetic.md). As `update` says where it is left out.
    repetitions : int
        How often it is run; for other than the first time w is changed by `perturbation`.
    perturbation : number
        The relative change of w, to see whether the outcome hangs on the last bits.
    expected : {"completed", "diverged", "mixed"}
        "diverged" for a run that is there to show a divergence; "mixed" where only some of its
        seeds or repetitions diverge.
    seeds : int
        With how many seeds it is run, `seed` and those after it; in place of repetitions.
    x_0 : list of numbers
        The initial state, zero where it is left out; `perturbation` changes it too.
    x_0_deviation : number
        The standard deviation of what each seed adds to the initial state.
    """

    steps: int
    seed: int = 0
    stride: int = 1
    arithmetic: str | None = None
    repetitions: int = 1
    perturbation: float = 0.0
    expected: str = "completed"
    seeds: int = 1
    x_0: Any = None
    x_0_deviation: float = 0.0


COURSE = Deferred(
    Table(
        Course,
        forms={
            "steps": Integer(1),
            "stride": Integer(1),
            "repetitions": Integer(1),
            "seeds": Integer(1),
            "x_0": Numbers(),
            "arithmetic": Choice(ARITHMETICS),
        },
    )
)
SATURATION = Deferred(
    Table(Saturation, forms={"low": Numbers(), "high": Numbers(), "rate": Numbers()})
)
# What a run may override, and how.
TABLES: dict[str, Deferred] = {
    "plant": PLANT,
    "signals": Deferred(SIGNALS),
    "target": TARGET,
    "controller": CONTROLLER,
    "saturation": SATURATION,
    "run": COURSE,
}
FORMS: dict[str, Form] = {
    **TABLES,
    "controllers": ListOf(ONE_OF_SEVERAL, needed="an array of tables, [[controllers]]"),
}


def _override(
    name: str, plant: Any = None, signals: Any = None, target: Any = None, controller: Any = None,
    controllers: Any = None, saturation: Any = None, run: Any = None, correction: str = "",
) -> str:  # fmt: skip
    """One of several runs: its name, and what it changes.

    Parameters
    ----------
    name : str
        What it is called; claims refer to it.
    plant, signals, target, controller, saturation, run : tables
        What differs from the table of that name.
    controllers : tables
        In place of [[controllers]].
    correction : str
        What this variant reads differently from the source, or adds to it.
    """
    return name


OVERRIDE = Table(_override, forms=FORMS)


@dataclass(frozen=True, eq=False)
class RunTables(Value):
    """One run as its file describes it, every value read and nothing made."""

    name: str
    plant: PlantSpecification
    signals: Part[Any]
    controller: ControllerSpecification
    saturation: Part[Saturation] | None
    course: Course
    folder: Path
    correction: str = ""

    def cost(self, plant: Plant | PlantSchedule, budget: Budget) -> float:
        """About how many multiplications it takes; raises where it takes too much memory."""
        course, parts = self.course, self.controller.parts
        structures = [s for part in parts if (s := _structure(part, plant))]
        budget.require_memory(
            self.name,
            plant,
            structures,
            steps=course.steps,
            stride=course.stride,
            repetitions=course.repetitions * course.seeds,
            window=max(map(_window, parts), default=0),
        )
        return budget.operations_of(
            structures,
            steps=course.steps,
            repetitions=course.repetitions * course.seeds,
            reference=course.arithmetic == "reference",
        )

    def build(self, plant: Plant | PlantSchedule) -> RunSpecification:
        """The run, its plant being made already."""
        course = self.course
        controller, target = self.controller.build(plant)
        made = RunSpecification(
            name=self.name,
            plant=plant,
            settings=controller,
            signals=signals_of(self.signals, plant, self.folder),
            steps=course.steps,
            seed=course.seed,
            stride=course.stride,
            reference=course.arithmetic == "reference",
            repetitions=course.repetitions,
            perturbation=course.perturbation,
            saturation=None if self.saturation is None else self.saturation.build(),
            expected=course.expected,
            target=target,
            seeds=course.seeds,
            x_0=None if course.x_0 is None else np.atleast_1d(course.x_0),
            x_0_deviation=course.x_0_deviation,
            correction=self.correction,
        )
        require_sense(made)
        return made


def read_run(base: Raw, override: Raw, file: str) -> RunTables:
    """The tables of a file joined with what a run overrides, each read once."""
    name = str(override["name"])
    joined = {
        key: form.joined(base.get(key, {}), override.get(key, {})) for key, form in TABLES.items()
    }
    several = override.get("controllers", base.get("controllers", []))

    def place(table: str) -> Place:
        return Place(file, table, notes=(f"run {name!r}",) if table in override else ())

    plant = read_plant(joined["plant"], place("plant"))
    course = COURSE.table.read(joined["run"], place("run")).build()
    common = joined["controller"]
    if course.arithmetic in UPDATES.kinds:  # what [run] says of the update
        common = {"update": course.arithmetic, **common}
    note = place("controller").notes or place("target").notes or place("controllers").notes
    controller = read_controllers(common, joined["target"], several, note, file)
    for part in controller.parts:
        _require_agreement(part, course.arithmetic, place("controller"))
    return RunTables(
        name=name,
        plant=plant,
        signals=SIGNALS.read(joined["signals"], place("signals")),
        controller=controller,
        saturation=SATURATION.table.read(joined["saturation"], place("saturation"))
        if "saturation" in base or "saturation" in override
        else None,
        course=course,
        folder=Path(file).parent,
        correction=str(override.get("correction", "")),
    )


def _require_agreement(part: Part[Any], arithmetic: str | None, place: Place) -> None:
    """[run] and the controller must agree on how the update is computed."""
    update = _name_of_update(part)
    wanted = {"reference": "ud"}.get(arithmetic or "", arithmetic)
    if update is not None and arithmetic is not None and update != wanted:
        raise InputError(
            f"[run] arithmetic = {arithmetic!r} and {place.where} update = {update!r} contradict "
            "each other; arithmetic is how the recursive update is computed."
        )


def _name_of_update(part: Part[Any]) -> str | None:
    chosen = part.arguments.get("update")
    if chosen is None:
        return None
    return next(n for n, k in UPDATES.kinds.items() if k.variants[0].table.make is chosen.make)


def _structure(part: Part[Any], plant: Plant | PlantSchedule) -> Structure | None:
    """The structure of a controller that adapts."""
    chosen = part.arguments.get("structure")
    return None if chosen is None else chosen.build(**sizes_of(plant))


def _window(part: Part[Any]) -> int:
    chosen = part.arguments.get("update")
    return 0 if chosen is None else int(chosen.arguments.get("window", 0))


def words_of(table: Mapping[str, Any]) -> str:
    """A table in the words of its file."""
    return ", ".join(f"{key} = {value}" for key, value in table.items())


# What is asked of a run before it starts: that it fits together and could adapt.


def require_sense(run: RunSpecification) -> None:
    """Refuse a run that does not fit together or could not adapt."""
    require_fit(run.plant, run.settings)
    if run.saturation is not None:
        run.saturation.bounds(run.plant.l_u)
        if isinstance(run.settings, Decentralized) and not run.settings.shared_u:
            raise InputError(
                "with saturation, controllers that hold their own u cannot know which part of it "
                "was applied. Set shared_u = true in [controller]."
            )
    if run.seeds > 1 and run.repetitions > 1:
        raise InputError(
            f"seeds = {run.seeds} and repetitions = {run.repetitions}: give one of them. Seeds "
            "change the noise, repetitions only the last digits of the data."
        )
    if run.x_0 is not None and run.x_0.shape != (run.plant.n,):
        raise InputError(f"x_0 has {run.x_0.size} entries; the plant has {run.plant.n} states.")
    if run.reference and (run.x_0 is not None or run.x_0_deviation):
        raise InputError('arithmetic = "reference" starts from rest; leave x_0 out.')
    if run.reference:
        require_supported(run.plant, run.settings, run.saturation)
    for controller in controllers_of(run.settings):
        if isinstance(controller, FixedController):
            continue
        for name in ("k_w", "k_update"):
            if (start := getattr(controller, name)) >= run.steps:
                raise InputError(
                    f"{name} = {start} is not before the end of the run of {run.steps} steps, so "
                    "nothing would be adapted. Use more steps."
                )
    for signal in run.signals:
        signal.require_length(run.steps)
