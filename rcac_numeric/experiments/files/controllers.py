"""The controller of an experiment file: one, or several with an update each."""

from __future__ import annotations

from typing import Any

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import one_of
from rcac_numeric.controllers.decentralized import Decentralized
from rcac_numeric.controllers.fixed import FixedController
from rcac_numeric.controllers.rules import (
    CovarianceReset,
    ScheduledForgetting,
    SignalWeight,
    VariableRateForgetting,
)
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.controllers.updates import (
    UD,
    Covariance,
    Gradient,
    Instantaneous,
    SlidingWindow,
    Update,
)
from rcac_numeric.engine.compatibility import AnyController
from rcac_numeric.experiments.files.lqg import lqg_settings
from rcac_numeric.experiments.files.sections import Section, Table, merged
from rcac_numeric.experiments.files.structures import structure_of
from rcac_numeric.experiments.files.targets import target_of
from rcac_numeric.plants.frozen import plant_at
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.schedules import PlantSchedule
from rcac_numeric.targets.model import TargetModel

# How the recursive update (2.42)-(2.45) may be computed.
ARITHMETICS = ("ud", "covariance", "reference")


def controller_of(
    table: Table, plant: Plant | PlantSchedule, file: str, arithmetic: str | None
) -> AnyController:
    """What [controller], [[controllers]] and [target] describe together.

    `arithmetic` is that of [run], or None where the file leaves it open.
    """
    common = Section(table.get("controller", {}), "controller", file)
    parts = table.get("controllers", [])
    if not isinstance(parts, list):
        raise InputError("controllers must be an array of tables, [[controllers]].")
    shared_u = common.flag("shared_u")
    if not parts:
        if "shared_u" in common.table:
            raise InputError("[controller] sets 'shared_u', which only [[controllers]] read.")
        target = _target(table.get("target", {}), plant, file)
        return _settings(common, target, plant, arithmetic)
    own = {key: value for key, value in common.table.items() if key != "shared_u"}
    settings = []
    for part in parts:
        given = dict(Section(part, "controllers", file).table)
        own_target = {"target": given.pop("target", {})}
        joined = merged({"target": table.get("target", {})}, own_target)
        target = _target(joined["target"], plant, file)
        section = Section(merged(own, given), "controllers", file)
        settings.append(_settings(section, target, plant, arithmetic))
    return Decentralized(settings, shared_u=shared_u)


def _settings(
    section: Section,
    target: TargetModel,
    plant: Plant | PlantSchedule,
    arithmetic: str | None,
) -> ControllerSettings | FixedController:
    if section.get("structure", "iir") == "lqg":
        return lqg_settings(section, plant)
    structure = structure_of(section, plant)
    options = section.given(
        "R_z", "R_u", "k_w", "k_update", "k_filter", "theta_0", "form",
    )  # fmt: skip
    for key in ("R_z", "R_u"):
        if isinstance(options.get(key), dict):
            options[key] = _signal_weight(options[key], key)
    options["reflect_poles"] = section.flag("reflect_poles")
    options["freeze"] = [_interval(entry) for entry in section.items("freeze")]
    options["target_changes"] = {
        step: _target(model, plant, section.file)
        for step, model in _changes(section, "target_changes").items()
    }
    return ControllerSettings(
        structure=structure,
        target=target,
        update=_update(section, arithmetic),
        **options,
    )


def _target(table: Any, plant: Plant | PlantSchedule, file: str) -> TargetModel:
    """The target model; what it takes from the plant is taken from the plant at step 0."""
    return target_of(Section(table, "target", file), plant_at(plant, 0))


UPDATES: dict[str, type[Update]] = {
    kind.name: kind for kind in (UD, Covariance, SlidingWindow, Instantaneous, Gradient)
}


def _update(section: Section, arithmetic: str | None) -> Update:
    """The update, on whose name [run] and the controller must agree."""
    name = section.text("update", arithmetic if arithmetic in UPDATES else "ud")
    one_of(name, "update", tuple(UPDATES))
    if arithmetic is not None and arithmetic != name and (arithmetic, name) != (
        "reference", "ud",
    ):  # fmt: skip
        raise InputError(
            f"[run] arithmetic = {arithmetic!r} and {section.where} update = {name!r} contradict "
            "each other; arithmetic is how the recursive update is computed."
        )
    options = section.given("R_theta", "process_noise", "window", "step_size")
    if "lambda" in section.table:
        options["lambda_"] = section.table["lambda"]
    if "lambda_changes" in section.table:
        changes = _changes(section, "lambda_changes")
        options["lambda_"] = ScheduledForgetting(changes, options.get("lambda_", 1.0))
    if "forgetting" in section.table:
        options["lambda_"] = VariableRateForgetting(
            **_rule(section, "forgetting", "short", "long", "gain").table
        )
    if "reset" in section.table:
        rule = _rule(section, "reset")
        rule.items("at")
        options["reset"] = CovarianceReset(**rule.table)
    if "stop_where_unsupported" in section.table:
        options["stop_where_unsupported"] = section.flag("stop_where_unsupported")
    if name != "gradient":
        section.require("R_theta")
    else:
        options.pop("R_theta", None)
    try:
        update: Update = UPDATES[name](**options)
    except TypeError as error:
        raise InputError(f'update = "{name}": {error}.') from None
    return update


def _signal_weight(table: Table, name: str) -> SignalWeight:
    """{ z_squared = c, constant = b } for (b + c z(k)'z(k)) I."""
    if "z_squared" not in table or set(table) - {"z_squared", "constant"}:
        raise InputError(
            f"{name} = {table} is not known; use a number, a matrix, or z_squared = c with an "
            "optional constant."
        )
    return SignalWeight(**table)


def _rule(section: Section, key: str, *needed: str) -> Section:
    rule = Section(section.table[key], f"controller.{key}", section.file)
    for name in needed:
        rule.require(name)
    return rule


def _changes(section: Section, key: str) -> dict[int, Any]:
    """[[step, value], ...] as a mapping."""
    changes: dict[int, Any] = {}
    for entry in section.items(key):
        if not (isinstance(entry, list) and len(entry) == 2):
            raise InputError(f"{key} has the entry {entry!r}; pairs [step, value] are needed.")
        step, value = entry
        if not isinstance(step, int) or step in changes:
            raise InputError(f"{key} names the step {step!r}; each must be an integer, once.")
        changes[step] = value
    return changes


def _interval(entry: Any) -> tuple[Any, Any]:
    """[start, stop], or [start] for an interval without an end."""
    if not (isinstance(entry, list) and len(entry) in (1, 2)):
        raise InputError(f"freeze has the entry {entry!r}; [start, stop] or [start] is needed.")
    return entry[0], entry[1] if len(entry) == 2 else None
