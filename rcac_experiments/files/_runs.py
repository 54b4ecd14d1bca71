"""The runs of an experiment file: its tables joined with the overrides of each run, then read."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Annotated, Any

import attrs

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.experiments._budgets import ExperimentBudget
from rcac_experiments.experiments._experiment import RunSpecification
from rcac_experiments.files._controllers import (
    CONTROLLER,
    ONE_OF_SEVERAL,
    ControllerSpecification,
    read_controllers,
)
from rcac_experiments.files._plants import PLANT, read_plant
from rcac_experiments.files._signals import SIGNALS
from rcac_experiments.files._targets import TARGET
from rcac_experiments.files._updates import UPDATES
from rcac_experiments.format._parts import PartialCall
from rcac_experiments.format._places import Errors, Location
from rcac_experiments.format._tables import PartialTable, Raw, Table
from rcac_experiments.format._values import ListOf
from rcac_numeric.arrays._values import Value
from rcac_numeric.controllers._decentralized import Decentralized
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._stepwise import StepwiseController
from rcac_numeric.engine._compatibility import AnyController, controllers_of, require_fit
from rcac_numeric.engine._reference import require_supported
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._saturation import Saturation
from rcac_numeric.plants._schedules import PlantSchedule
from rcac_numeric.signals._signal import Signal
from rcac_numeric.targets._model import TargetModel

RUN_OPTIONS = PartialTable(
    Table(
        RunSpecification,
        supplied=["name", "plant", "settings", "signals", "saturation", "target", "correction"],
        is_later=True,
    )
)
SATURATION = PartialTable(Table(Saturation))
# What a run may override, and how.
TABLES: dict[str, PartialTable] = {
    "plant": PLANT,
    "signals": PartialTable(SIGNALS),
    "target": TARGET,
    "controller": CONTROLLER,
    "saturation": SATURATION,
    "run": RUN_OPTIONS,
}
CONTROLLERS = ListOf(ONE_OF_SEVERAL, needed="an array of tables, [[controllers]]")


DIFFERS = "What differs from the table of that name."


@attrs.frozen(eq=False)
class OpenValue(Value):
    """One of the values that a reader would try: its name, and what it changes."""

    name: Annotated[str, "What it is called; claims refer to it."]
    plant: Annotated[Raw | None, PLANT, DIFFERS] = None
    signals: Annotated[Raw | None, TABLES["signals"], DIFFERS] = None
    target: Annotated[Raw | None, TARGET, DIFFERS] = None
    controller: Annotated[Raw | None, CONTROLLER, DIFFERS] = None
    controllers: Annotated[list[Raw] | None, CONTROLLERS, "In place of [[controllers]]."] = None
    saturation: Annotated[Raw | None, SATURATION, DIFFERS] = None
    run: Annotated[Raw | None, RUN_OPTIONS, DIFFERS] = None


@attrs.frozen(eq=False)
class Override(OpenValue):
    """One of several runs: its name, and what it changes."""

    correction: Annotated[
        str,
        "The differences of this variant from the source.",
    ] = ""


OPEN_VALUE, OVERRIDE = Table(OpenValue), Table(Override)


@attrs.frozen(eq=False)
class RunTables(Value):
    """One run as its file describes it: values are read, objects are not built."""

    name: str
    plant: PartialCall[Plant | PlantSchedule]
    signals: PartialCall[tuple[Signal, ...]]
    controller: ControllerSpecification
    saturation: Saturation | None
    run_options: PartialCall[RunSpecification]
    correction: str = ""

    def cost(self, plant: Plant | PlantSchedule, budget: ExperimentBudget) -> float:
        """About how many multiplications it takes; raises where it takes too much memory."""
        of_run = self.run_options.argument
        repetitions = of_run("repetitions") * of_run("seeds")
        arguments = [part.arguments for part in self.controller.parts]
        sizes = [one["structure"].of(plant).l_theta for one in arguments if "structure" in one]
        predictive = [one for one in arguments if "horizon" in one]
        sizes += [one["order"] * (plant.l_u + plant.l_y) * plant.l_y for one in predictive]
        budget.require_memory(
            self.name,
            plant,
            sizes,
            steps=of_run("steps"),
            stride=of_run("stride"),
            repetitions=repetitions,
            window=max(
                (int(getattr(one.get("update"), "window", 0)) for one in arguments), default=0
            ),
        )
        return budget.operations_of(
            sizes,
            steps=of_run("steps"),
            repetitions=repetitions,
            reference=of_run("arithmetic") == "reference",
            horizon=sum(one["horizon"] for one in predictive),
        )

    def build(
        self,
        plant: Plant | PlantSchedule,
        built: tuple[AnyController, TargetModel | None] | None = None,
    ) -> RunSpecification:
        """The run, with its plant, and with the objects that its controller needs."""
        controller, target = built or self.controller.build(plant)
        run = self.run_options.of(
            plant,
            name=self.name,
            settings=controller,
            signals=self.signals.of(plant),
            saturation=self.saturation,
            target=target,
            correction=self.correction,
        )
        require_sense(run)
        return run


def wrong_tables(table: Raw, file: str) -> frozenset[str]:
    """The names of the tables of a file, or of an override in it, that cannot be read as they are.

    "runs" is among them where the overrides are no tables with names.
    """
    overrides = table.get("runs") or []
    if not isinstance(overrides, list) or not all(
        isinstance(one, Mapping) and isinstance(one.get("name"), str) for one in overrides
    ):
        return frozenset({"runs"})
    wrong = set()
    for key, form in {**TABLES, "controllers": CONTROLLERS}.items():
        for where in (table, *overrides):
            try:
                if key in where:
                    form.read(where[key], Location(file, key=key))
            except CompensatorError:
                wrong.add(key)
    return frozenset(wrong)


def read_again(tables: RunTables, before: Raw, now: Raw, file: str) -> RunTables:
    """The run of a file of which some tables are others; those that are the same are not read."""
    name = {"name": tables.name}
    is_same = {
        key: before.get(key) is now.get(key) and (key in before) == (key in now)
        for key in (*TABLES, "controllers")
    }
    of_controller = ("controller", "target", "controllers")
    ways = [one.get("run", {}).get("arithmetic") for one in (before, now)]
    known: dict[str, Any] = {
        key: getattr(tables, "run_options" if key == "run" else key)
        for key in ("plant", "signals", "saturation", "run")
        if is_same[key]
    }
    if all(is_same[key] for key in of_controller) and ways[0] == ways[1]:
        known["controller"] = tables.controller
    read = read_run(now, name, file, known=known)
    assert read is not None, "no table is left out"
    return read


def read_run(
    base: Raw,
    override: Raw,
    file: str,
    wrong: Collection[str] = (),
    known: Mapping[str, Any] | None = None,
) -> RunTables | None:
    """The tables of a file joined with what a run overrides, each read once.

    Tables that are known to be `wrong` are omitted, and the function returns None; other errors are
    reported. A table in `known` is not read again.
    """
    name = str(override["name"])
    errors = Errors()
    read: dict[str, Any] = {"saturation": None}
    known = known or {}
    read |= {"run_options" if key == "run" else key: part for key, part in known.items()}
    joined = {
        key: form.joined(base.get(key, {}), override.get(key, {}))
        for key, form in TABLES.items()
        if key not in wrong and not (key in known and key != "controller")
    }

    def place(table: str) -> Location:
        return Location(file, table, notes=(f"run {name!r}",) if table in override else ())

    with errors:
        if "plant" in joined:
            read["plant"] = read_plant(joined["plant"], place("plant"))
    with errors:
        if "signals" in joined:
            read["signals"] = SIGNALS.read(joined["signals"], place("signals"))
    with errors:
        if "saturation" in joined and ("saturation" in base or "saturation" in override):
            read["saturation"] = SATURATION.table.read(joined["saturation"], place("saturation"))
    with errors:
        if "run" in joined:
            read["run_options"] = RUN_OPTIONS.table.read(joined["run"], place("run"))
    run_options: PartialCall[RunSpecification] | None = read.get("run_options")
    arithmetic = None if run_options is None else run_options.argument("arithmetic")
    with errors:
        if "controller" not in known and not {"controller", "target", "controllers"} & set(wrong):
            common = joined["controller"]
            if arithmetic in UPDATES.kinds:  # it says the update too
                common = {"update": arithmetic, **common}
            several = override.get("controllers", base.get("controllers", []))
            controller = read_controllers(common, joined["target"], several, place)
            for part in controller.parts:
                _require_agreement(part, arithmetic, place("controller"))
            read["controller"] = controller
    errors.raise_any()
    if wrong:
        return None
    return RunTables(name=name, correction=str(override.get("correction", "")), **read)


def _require_agreement(part: PartialCall[Any], arithmetic: str | None, place: Location) -> None:
    """[run] and the controller must agree on how the update is computed."""
    update = part.arguments.get("update")
    expected = {"reference": "ud"}.get(arithmetic or "", arithmetic)
    if update is not None and arithmetic is not None and update.name != expected:
        raise InputError(
            f"[run] arithmetic = {arithmetic!r} and {place.where} update = {update.name!r} "
            "contradict each other; arithmetic selects the form of the recursive update. Remove "
            "one."
        )


def words_of(table: Mapping[str, Any]) -> str:
    """A table in the words of its file."""
    return ", ".join(f"{key} = {value}" for key, value in table.items())


# Conditions of a run before it starts: consistent tables, and a controller that adapts.


def require_sense(run: RunSpecification) -> None:
    """Refuse a run that does not fit together or could not adapt."""
    require_fit(run.plant, run.settings)
    if run.saturation is not None:
        run.saturation.bounds(run.plant.l_u)
        if isinstance(run.settings, Decentralized) and not run.settings.shared_u:
            raise InputError(
                "with saturation, separate controllers do not know the applied part of u. Set "
                "shared_u = true in [controller]."
            )
    if run.seeds > 1 and run.repetitions > 1:
        raise InputError(
            f"seeds = {run.seeds} and repetitions = {run.repetitions} exclude each other; give "
            "one. Seeds change the noise, repetitions only the last digits of the data."
        )
    if run.x_0 is not None and run.x_0.shape != (run.plant.n,):
        raise InputError(f"x_0 has {run.x_0.size} entries; the plant has {run.plant.n} states.")
    if run.reference and (run.x_0 is not None or run.x_0_deviation):
        raise InputError('arithmetic = "reference" starts from rest; leave x_0 out.')
    if run.reference:
        require_supported(run.plant, run.settings, run.saturation)
    if isinstance(run.settings, StepwiseController):
        if run.saturation is not None:
            raise InputError(
                f"a {type(run.settings).__name__} does not receive the applied u. Remove "
                "[saturation], and give its own limits = { low = -1, high = 1 } in [controller]."
            )
        return _require_lengths(run)
    for controller in controllers_of(run.settings):
        if isinstance(controller, FixedController):
            continue
        for name in ("k_w", "k_update"):
            if (start := getattr(controller, name)) >= run.steps:
                raise InputError(
                    f"{name} = {start} must be before the end of the run of {run.steps} steps; "
                    "otherwise no coefficient adapts. Use more steps."
                )
    _require_lengths(run)


def _require_lengths(run: RunSpecification) -> None:
    for signal in run.signals:
        signal.require_length(run.steps)
