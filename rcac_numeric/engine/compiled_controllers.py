"""From settings to a compiled controller at step 0."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.definite_matrices import constant_weight, square_root_columns
from rcac_numeric.controllers.rules import CovarianceReset, SignalWeight
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.engine import _kernel
from rcac_numeric.targets.model import TargetModel


class Failures:
    """Holds the first exception that a user's function raised while the kernel ran."""

    def __init__(self) -> None:
        self.error: Exception | None = None

    def guard(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """`function`, but an exception is kept here and None returned."""

        def guarded(*arguments: Any) -> Any:
            try:
                return function(*arguments)
            except Exception as error:
                self.error = self.error or error
                return None

        return guarded


def compiled_controller(settings: ControllerSettings, failures: Failures) -> _kernel.Controller:
    """A compiled controller at step 0."""
    structure, target = settings.structure, settings.target
    regressor = [(structure.index(tap), tap.delay) for tap in structure.taps]
    models = [target, *settings.later_targets.values()]
    if settings.k_filter == 0 and len(models) == 1:
        # From zero initial conditions the filter commutes with the delays: one channel for
        # each scalar signal serves all taps on it.
        sources = sorted({source for source, _ in regressor} - set(range(structure.l_u)))
        order = [*range(structure.l_u), *sources]
        channels = [(source, 0) for source in order]
        filtered = [(order.index(source), delay) for source, delay in regressor]
    else:
        # A filter that is switched on or replaced later does not: each tap is its own channel.
        channels = [*((i, 0) for i in range(structure.l_u)), *regressor]
        filtered = [(structure.l_u + j, 0) for j in range(len(regressor))]
    longest = max(model.n_f for model in models)
    rule, reset = settings.forgetting, settings.reset or CovarianceReset()
    Q = settings.process_noise
    return _kernel.controller(
        l_u=structure.l_u,
        l_y=structure.l_y,
        l_r=structure.l_r,
        l_z=target.l_z,
        derived=[(np.array(s.now), np.array(s.before), s.pole) for s in structure.derived],
        regressor=regressor,
        channels=channels,
        filtered=filtered,
        targets=[_padded(model, longest) for model in models],
        R_z=_weight(settings.R_z, "R_z", target.l_z, failures, definite=True),
        R_u=_weight(settings.R_u, "R_u", target.l_z, failures, definite=False),
        forgetting_factor=settings.lambda_,
        k_w=settings.k_w,
        k_update=settings.k_update,
        k_filter=settings.k_filter,
        filter_form=settings.form == "filter",
        reflect_poles=settings.reflect_poles,
        events=_events(settings),
        forgetting=(rule.short, rule.long, rule.gain, rule.smallest) if rule else (0, 0, 0.0, 1.0),
        reset=(reset.every, reset.trace_below, reset.growth, reset.short, reset.long),
        noise=np.zeros(0) if Q is None else np.ascontiguousarray(square_root_columns(Q).T),
        update=settings.update,
        P_0=settings.P_0,
        theta_0=settings.theta_0,
        window=settings.window,
        step_size=settings.step_size,
    )


def _events(settings: ControllerSettings) -> list[tuple[int, str, float]]:
    """What is scheduled, by step: (step, kind, lambda or the number of the target model)."""
    events: list[tuple[int, str, float]] = []
    for start, stop in _merged(settings.freeze):
        events.append((start, "freeze", 0.0))
        if stop is not None:
            events.append((stop, "resume", 0.0))
    events += [(k, "reset", 0.0) for k in (settings.reset.at if settings.reset else ())]
    events += [(k, "forgetting", value) for k, value in settings.later_lambdas.items()]
    events += [(k, "target", float(i)) for i, k in enumerate(settings.later_targets, start=1)]
    order = ("freeze", "resume", "reset", "forgetting", "target")
    return sorted(events, key=lambda event: (event[0], order.index(event[1])))


def _merged(intervals: Sequence[tuple[int, int | None]]) -> list[tuple[int, int | None]]:
    """The union of intervals [start, stop) as disjoint ones with gaps between them."""
    merged: list[tuple[int, float]] = []
    for start, stop in sorted((a, np.inf if b is None else b) for a, b in intervals):
        if merged and start <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(stop, merged[-1][1]))
        else:
            merged.append((start, stop))
    return [(start, None if stop == np.inf else int(stop)) for start, stop in merged]


def _padded(model: TargetModel, order: int) -> tuple[Array, Array]:
    padding = [(0, order - model.n_f), (0, 0), (0, 0)]
    return np.pad(model.numerator, padding), np.pad(model.denominator, padding)


def _weight(value: Any, name: str, l_z: int, failures: Failures, *, definite: bool) -> Any:
    if isinstance(value, SignalWeight):
        return value.constant * np.eye(l_z), value.z_squared
    if not callable(value):
        return value

    def checked(k: int, y: Array, z: Array, u: Array) -> Array:
        try:
            return constant_weight(value(k, y, z, u), f"{name}({k})", l_z, definite=definite)
        except TypeError as error:
            raise InputError(
                f"{name} = {value!r} could not be called as {name}(k, y, z, u): {error}."
            ) from error

    return failures.guard(checked)
