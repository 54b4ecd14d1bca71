"""From the tables of an experiment file to an experiment: plant, target models, runs."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.arrays.validation import integer, number, one_of
from rcac_numeric.controllers.fixed import FixedController
from rcac_numeric.engine.compatibility import AnyController, controllers_of
from rcac_numeric.engine.reference.run import require_supported
from rcac_numeric.engine.simulation import simulate
from rcac_numeric.experiments.experiment import Experiment, RunSpecification
from rcac_numeric.experiments.files.claims import claim
from rcac_numeric.experiments.files.controllers import ARITHMETICS, controller_of
from rcac_numeric.experiments.files.plants import plant_of
from rcac_numeric.experiments.files.sections import (
    Section,
    Table,
    merged,
    named,
    read_example,
    read_file,
)
from rcac_numeric.experiments.files.signals import signals
from rcac_numeric.experiments.files.targets import target_of
from rcac_numeric.plants.frozen import plant_at
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.saturation import Saturation
from rcac_numeric.plants.schedules import PlantSchedule
from rcac_numeric.targets.model import TargetModel

# What a run may keep in memory before it is refused.
MAX_BYTES = 8 * 2**30


def load_example(number: str) -> Experiment:
    """A numbered example of the dissertation.

    Examples
    --------
    >>> from rcac_numeric import load_example
    >>> load_example("4.7").main_run.settings.k_w
    50
    """
    return build(*read_example(number))


def load_experiment(path: str | Path) -> Experiment:
    """A user's own case from its TOML file; docs/experiment-files.md describes the format.

    Raises
    ------
    InputError
        Where the file cannot be read, a key is unknown or missing, or a value is out of range;
        other errors of the tree where the plant or the target model does not allow the case.

    Examples
    --------
    >>> from rcac_numeric import load_experiment, verify
    >>> verify(load_experiment("examples/boost_converter.toml")).exit_status
    0
    """
    return build(*read_file(path))


def build(table: Table, file: str) -> Experiment:
    """The experiment that a parsed file describes; `file` is named in errors."""
    try:
        return _experiment(table, file)
    except CompensatorError as error:
        raise named(error, file) from None


def _experiment(table: Table, file: str) -> Experiment:
    top = Section(table, "", file)
    common = plant_of(Section(top.require("plant"), "plant", file))
    overrides = [Section(t, "runs", file) for t in top.tables("runs") or [{"name": "main"}]]
    runs = {}
    for override in overrides:
        name = override.text("name")
        if name in runs:
            raise InputError(f"two runs are named {name!r}; give each its own name.")
        own = merged(table, override.table)
        plant = common
        if "plant" in override.table:
            plant = plant_of(Section(own["plant"], "plant", file))
        runs[name] = _run(name, own, plant, file)
    return Experiment(
        id=top.text("id", Path(file).stem),
        title=top.text("title", ""),
        source=top.text("source", ""),
        notes=top.text("notes", "").strip(),
        runs=runs,
        claims=[claim(Section(t, "claims", file), next(iter(runs))) for t in top.tables("claims")],
        description=_description(table),
    )


def _run(name: str, table: Table, plant: Plant | PlantSchedule, file: str) -> RunSpecification:
    run = Section(table.get("run", {}), "run", file)
    arithmetic = run.get("arithmetic", None)
    if arithmetic is not None:
        one_of(run.text("arithmetic"), "arithmetic", ARITHMETICS)
    settings = controller_of(table, plant, file, arithmetic)
    bounds = Section(table.get("saturation", {}), "saturation", file)
    specification = RunSpecification(
        name=name,
        plant=plant,
        settings=settings,
        signals=signals(Section(table.get("signals", {}), "signals", file), plant),
        steps=integer(run.require("steps"), "steps", at_least=1),
        seed=integer(run.get("seed", 0), "seed"),
        stride=integer(run.get("stride", 1), "stride", at_least=1),
        reference=arithmetic == "reference",
        target=_lqg_target(table, plant, file, settings),
        repetitions=integer(run.get("repetitions", 1), "repetitions", at_least=1),
        perturbation=number(run.get("perturbation", 0.0), "perturbation"),
        saturation=Saturation(**bounds.table) if "saturation" in table else None,
        expected=one_of(run.text("expected", "completed"), "expected", ("completed", "diverged")),
    )
    _require_sense(specification)
    return specification


def _lqg_target(
    table: Table, plant: Plant | PlantSchedule, file: str, settings: AnyController
) -> TargetModel | None:
    """What a loop with LQG is compared with."""
    if not isinstance(settings, FixedController):
        return None
    return target_of(Section(table.get("target", {}), "target", file), plant_at(plant, 0))


def _require_sense(run: RunSpecification) -> None:
    """Refuse a run that does not fit together, could not adapt or would not fit into memory."""
    nothing = np.zeros((0, run.plant.l_w))
    simulate(run.plant, run.settings, nothing, saturation=run.saturation)
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
    plant = run.plant
    kept = sum(c.l_theta for c in controllers_of(run.settings)) / run.stride
    size = 8 * run.steps * (2 * plant.l_w + plant.l_u + plant.l_y + plant.l_z + kept)
    if size > MAX_BYTES:
        raise InputError(
            f"the run of {run.steps} steps would keep {size / 2**30:.3g} GiB; at most "
            f"{MAX_BYTES / 2**30:.0f} are allowed. Use fewer steps or a larger stride."
        )


def _description(table: Table) -> dict[str, str]:
    """The file's own words for plant, signals, target and controllers, for the report."""
    names = ("plant", "signals", "target", "controller", "controllers", "saturation", "run")
    words = {}
    for name in names:
        parts = table.get(name, {})
        words[name] = "; ".join(
            ", ".join(f"{key} = {value}" for key, value in part.items())
            for part in (parts if isinstance(parts, list) else [parts])
        )
    return words
