"""Compiled controllers from controllers as data.

A new kind of controller is registered here: `@kernel_arguments.register(YourController)`. What
is derived from a kind that is, or made of parts that are derived from ours, is refused: the kernel
would run it without what it adds.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import singledispatch
from typing import Any, cast

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight, square_root_columns
from rcac_numeric.compiled import _kernel
from rcac_numeric.compiled._callbacks import Failures
from rcac_numeric.compiled._updates import (
    Event,
    initial_variances,
    kernel_arguments_of,
    kernel_update,
    require_kind,
)
from rcac_numeric.controllers._bounds import (
    CertifiedBounds,
    CoefficientBounds,
    ellipsoid_radii,
    inverse_factor,
)
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._joint import JointUD
from rcac_numeric.controllers._limits import ControlLimits
from rcac_numeric.controllers._memoryless import Gradient
from rcac_numeric.controllers._normalization import FUNCTIONS, Normalization
from rcac_numeric.controllers._recursive import UD
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._structure import DerivedSignal, Structure, Tap
from rcac_numeric.controllers._supervision import POLICIES, Supervision
from rcac_numeric.controllers._weights import SignalWeight, Weight
from rcac_numeric.targets._data_driven import DataDriven
from rcac_numeric.targets._model import TargetModel

VARIABLE = "RCAC_INSTRUCTION_SET"


def require_instruction_set() -> None:
    """Raise if RCAC_INSTRUCTION_SET requests instructions that this processor does not have.

    The environment variable RCAC_INSTRUCTION_SET forces one of `_kernel.instruction_sets()` on
    everything that is made from then on; without it the kernel takes the first. They round in
    different orders: theta differs by about 1e-15 from one to the next.
    """
    name, known = os.environ.get(VARIABLE, ""), _kernel.instruction_sets()
    if name and name not in known:
        raise InputError(
            f"{VARIABLE} = {name!r} is no instruction set of this processor; it runs "
            f"{', '.join(known)}."
        )


def instruction_set() -> str:
    """Return the instruction set in use; raise if the processor does not have it."""
    require_instruction_set()
    return os.environ.get(VARIABLE, "") or _kernel.instruction_sets()[0]


CONSTANT = (np.ndarray, SignalWeight)  # weights as data, without functions
NEVER = 2**62  # beyond the last step of any run
ORDER_OF_EVENTS = ("freeze", "resume", "reset", "forgetting", "target")


def compiled_controller(
    controller: object,
    l_z: int,
    failures: Failures,
    instructions: str = "",
    supervision: Supervision | None = None,
    limits: ControlLimits | None = None,
) -> _kernel.Controller:
    """Return the compiled controller at step 0."""
    require_instruction_set()
    arguments = kernel_arguments(controller, l_z, failures)
    if isinstance(controller, ControllerSettings):
        l_e = controller.structure.l_y + controller.structure.l_r
        arguments["supervision"] = _supervision(supervision, controller.structure.l_u, l_e)
        if limits is not None:
            arguments["limits"] = limits.bounds(controller.structure.l_u)
    return _kernel.controller(**arguments, instruction_set=instructions)


@singledispatch
def kernel_arguments(controller: object, l_z: int, failures: Failures) -> dict[str, Any]:
    """Return the arguments of `_kernel.controller`; the export writes them as tables."""
    raise InputError(f"settings = {controller!r}: ControllerSettings are needed.")


@kernel_arguments.register(ControllerSettings)
def _(settings: ControllerSettings, l_z: int, failures: Failures) -> dict[str, Any]:
    require_kind(settings, "settings", kernel_arguments.registry)
    require_parts(settings)
    structure, target = settings.structure, settings.target
    update = kernel_update(settings.update, structure.l_theta)
    regressor = [(structure.index(tap), tap.delay) for tap in structure.taps]
    models = settings.targets
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
    return dict(
        update,
        l_u=structure.l_u,
        l_y=structure.l_y,
        l_r=structure.l_r,
        l_z=target.l_z,
        derived=[(np.array(s.now), np.array(s.before), s.pole, s.limit) for s in structure.derived],
        regressor=regressor,
        channels=channels,
        filtered=filtered,
        targets=[_padded(model, longest) for model in models],
        R_z=_weight(settings.R_z, "R_z", target.l_z, failures, definite=True),
        R_u=_weight(settings.R_u, "R_u", target.l_z, failures, definite=False),
        k_w=settings.k_w,
        k_update=settings.k_update,
        k_filter=settings.k_filter,
        filter_form=settings.form == "filter",
        reflect_poles=settings.reflect_poles,
        events=_events(settings, update["events"]),
        theta_0=settings.theta_0,
        dither=_dither(settings.learning),
        **_additions(settings),
    )


@kernel_arguments.register(FixedController)
def _(controller: FixedController, l_z: int, failures: Failures) -> dict[str, Any]:
    """Return a fixed compensator as a regressor with coefficients and no update."""
    require_kind(controller, "settings", kernel_arguments.registry)
    c = controller.compensator
    require_kind(c, "compensator", (Compensator,))
    first = 0 if c.past_y[0].any() else 1  # u(k) needs y(k) only for a proper controller
    of_u = [(i, lag) for lag in range(1, c.n_c + 1) for i in range(c.l_u)]
    of_y = [(c.l_u + i, lag) for lag in range(first, c.n_c + 1) for i in range(c.l_y)]
    columns = [c.past_u[lag - 1][:, i] for i, lag in of_u]
    columns += [c.past_y[lag][:, i - c.l_u] for i, lag in of_y]
    if not columns:  # u = 0; the kernel needs one tap
        of_u, columns = [(0, 1)], [np.zeros(c.l_u)]
    theta = np.concatenate(columns)
    size = len(theta)
    return dict(
        kernel_arguments_of(Gradient.name, P_0=np.zeros((size, size))),
        l_u=c.l_u,
        l_y=c.l_y - controller.l_r,
        l_r=controller.l_r,
        l_z=l_z,
        derived=[],
        regressor=of_u + of_y,
        channels=[(i, 0) for i in range(c.l_u)],
        filtered=[(0, 0)] * len(of_u + of_y),
        targets=[(np.zeros((1, l_z, c.l_u)), np.eye(l_z)[None])],
        R_z=np.eye(l_z),
        R_u=np.zeros((l_z, l_z)),
        k_w=controller.k_w,
        k_update=NEVER,
        k_filter=NEVER,
        filter_form=False,
        reflect_poles=False,
        theta_0=theta,
    )


Numbers = tuple[Array, Array, float, Any, Any, list[tuple[Array, Array]]]
# Numeric settings of a controller that reuses the compiled form of another one.
ALIKE = ("k_w", "k_update", "k_filter", "form", "reflect_poles")
SHARED = ("structure", "z_normalization", "bounds", "fixed")


def numbers_beside(base: ControllerSettings, settings: ControllerSettings) -> Numbers | None:
    """Return the numbers for `_kernel.Loop.copy`; None if more than numbers differs.

    Numbers are R_theta, lambda and theta(0), R_z and R_u, and G_f of the same order.
    """
    one, other, target = _plain_update(base), _plain_update(settings), settings.target
    if one is None or other is None or type(target) is not TargetModel:
        return None
    if not (
        (target.n_f, target.l_z) == (base.target.n_f, base.target.l_z)
        and all(getattr(base, name) is getattr(settings, name) for name in SHARED)
        and all(getattr(base, name) == getattr(settings, name) for name in ALIKE)
        and base.R_u_unfiltered.tobytes() == settings.R_u_unfiltered.tobytes()
        and one.stop_where_unsupported == other.stop_where_unsupported
    ):
        return None
    failures = Failures()  # only for weights that are functions; these are excluded above
    return (
        initial_variances(other.R_theta, settings.structure.l_theta),
        settings.theta_0,
        cast(float, other.lambda_),
        _weight(settings.R_z, "R_z", target.l_z, failures, definite=True),
        _weight(settings.R_u, "R_u", target.l_z, failures, definite=False),
        [(target.numerator, target.denominator)],
    )


def _plain_update(settings: ControllerSettings) -> UD | None:
    """Return the update if a run changes only theta and P, else None."""
    update = settings.update
    if type(settings) is not ControllerSettings or type(update) is not UD:
        return None
    is_plain = (
        type(update.lambda_) is float
        and update.process_noise is None
        and update.reset is None
        and settings.learning is None
        and not (settings.target_changes or settings.freeze)
        and type(settings.R_z) in CONSTANT
        and type(settings.R_u) in CONSTANT
    )
    return update if is_plain else None


def fitted_denominator(settings: ControllerSettings, kernel: _kernel.Controller) -> Array | None:
    """Return 1, d_1, ..., d_n of the D_f that `JointUD` fits; None for other updates."""
    if not isinstance(settings.update, JointUD):
        return None
    return np.concatenate([[1.0], kernel.also_fitted])


def require_parts(settings: ControllerSettings, who: str = "engine") -> None:
    """Raise for subclasses of structures, target models and weights."""
    require_kind(settings.structure, "structure", (Structure,), who)
    for tap in settings.structure.taps:
        require_kind(tap, "a tap", (Tap,), who)
    for signal in settings.structure.derived:
        require_kind(signal, "a derived signal", (DerivedSignal,), who)
    for model in settings.targets:
        require_kind(model, "target", (TargetModel,), who)
    if settings.learning is not None:
        require_kind(settings.learning, "learning", (DataDriven,), who)
    parts = {
        "z_normalization": (Normalization,),
        "bounds": (CoefficientBounds, CertifiedBounds),
        "fixed": (Compensator,),
    }
    for name, kinds in parts.items():
        if (part := getattr(settings, name)) is not None:
            require_kind(part, name, kinds, who)
    for name in ("R_z", "R_u"):
        if isinstance(weight := getattr(settings, name), SignalWeight):
            require_kind(weight, name, (SignalWeight,), who)


def _events(settings: ControllerSettings, of_update: Sequence[Event]) -> list[Event]:
    """Return the scheduled events by step: (step, kind, lambda or index of the target model)."""
    events = [*of_update]
    for start, stop in _merged(settings.freeze):
        events.append((start, "freeze", 0.0))
        if stop is not None:
            events.append((stop, "resume", 0.0))
    events += [(k, "target", float(i)) for i, k in enumerate(settings.target_changes, start=1)]
    return sorted(events, key=lambda event: (event[0], ORDER_OF_EVENTS.index(event[1])))


def _merged(intervals: Sequence[tuple[int, int | None]]) -> list[tuple[int, int | None]]:
    """Return the union of intervals [start, stop) as disjoint intervals."""
    merged: list[tuple[int, float]] = []
    for start, stop in sorted((a, np.inf if b is None else b) for a, b in intervals):
        if merged and start <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(stop, merged[-1][1]))
        else:
            merged.append((start, stop))
    return [(start, None if stop == np.inf else int(stop)) for start, stop in merged]


def penalty_rows(R: Array) -> Array:
    """Return S with S'S = R, with as many rows as R."""
    S = np.zeros_like(R)
    roots = square_root_columns(R).T
    S[: len(roots)] = roots
    return S


def _additions(settings: ControllerSettings) -> dict[str, Any]:
    """Return the arguments for settings of published RCAC that are not in the text."""
    additions: dict[str, Any] = {}
    if settings.R_u_unfiltered.any():
        additions["penalty"] = penalty_rows(settings.R_u_unfiltered)
    if (f := settings.z_normalization) is not None:
        additions["normalization"] = (1 + FUNCTIONS.index(f.function), f.limit, f.slope)
    if (bounds := settings.bounds) is not None:
        if isinstance(bounds, CertifiedBounds):
            in_metric = not isinstance(settings.update, JointUD)
            inverse = inverse_factor(bounds)
            additions["ellipsoid"] = (bounds.center, inverse, in_metric, *ellipsoid_radii(bounds))
        else:
            low, high = bounds.box(settings.structure)
            additions["bounds"] = (low, high, bounds.method == "metric", bounds.sweeps)
    if (fixed := settings.fixed) is not None:
        additions["fixed"] = (fixed.past_u, fixed.past_y)
    return additions


def _supervision(supervision: Supervision | None, l_u: int, l_e: int) -> tuple[Any, ...] | None:
    if supervision is None:
        return None
    require_kind(supervision, "supervision", (Supervision,))
    supervision.require_widths(l_u, l_e)
    fallback = supervision.fallback
    past_u, past_y = (np.zeros(0),) * 2 if fallback is None else (fallback.past_u, fallback.past_y)
    return (
        POLICIES.index(supervision.policy), supervision.growth, supervision.limit,
        supervision.jump or 0.0, supervision.patience, supervision.fade,
        past_u, past_y, supervision.missed == "fallback",
    )  # fmt: skip


def _dither(learning: DataDriven | None) -> tuple[int, float, float, int]:
    if learning is None:
        return (0, 0.0, 0.0, 0)
    return (learning.seed, learning.dither, learning.running_dither, learning.start)


def _padded(model: TargetModel, order: int) -> tuple[Array, Array]:
    if model.n_f == order:
        return model.numerator, model.denominator
    padding = [(0, order - model.n_f), (0, 0), (0, 0)]
    return np.pad(model.numerator, padding), np.pad(model.denominator, padding)


def _weight(value: Weight, name: str, l_z: int, failures: Failures, *, definite: bool) -> Any:
    if isinstance(value, SignalWeight):
        return value.constant * np.eye(l_z), value.z_squared, value.nu
    if isinstance(value, np.ndarray):
        return value
    function = value

    def checked(k: int, y: Array, z: Array, u: Array) -> Array:
        try:
            return constant_weight(function(k, y, z, u), f"{name}({k})", l_z, definite=definite)
        except TypeError as error:
            raise InputError(
                f"{name} = {function!r} could not be called as {name}(k, y, z, u): {error}."
            ) from error

    return failures.guard(checked)
