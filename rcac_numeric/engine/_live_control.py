"""Changing a compiled controller between two steps: checked first, then applied as a whole."""

from __future__ import annotations

import numpy as np

from compensator_theory.errors import DivergedError, ImproperError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight
from rcac_numeric.compiled import _kernel
from rcac_numeric.compiled._controllers import penalty_rows
from rcac_numeric.compiled._updates import require_kind
from rcac_numeric.controllers._forgetting import VariableRateForgetting
from rcac_numeric.controllers._joint import JointUD
from rcac_numeric.controllers._memoryless import Gradient, Instantaneous
from rcac_numeric.controllers._recursive import RecursiveLeastSquares
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._sliding_window import SlidingWindow
from rcac_numeric.controllers._weights import SignalWeight
from rcac_numeric.engine._changes import (
    AppliedChange,
    ControllerChange,
    LiveWeight,
    nmp_zero_count,
)
from rcac_numeric.targets._model import TargetModel

KernelWeight = Array | tuple[Array, float, float] | None


def apply_change(
    kernel: _kernel.Controller,
    settings: ControllerSettings,
    change: ControllerChange,
    evidence: str = "",
) -> AppliedChange:
    """Make a change in a compiled controller between two steps."""
    require_kind(change, "the change", (ControllerChange,))
    if isinstance(settings.update, JointUD):
        raise InputError(
            f"{settings.update!r} fits D_f for one target model and one set of weights; neither "
            "can change during a run. Start a new controller."
        )
    l_z = settings.target.l_z
    weights = [
        _kernel_weight(getattr(change, name), name, l_z, definite=name == "R_z")
        for name in ("R_z", "R_u")
    ]
    penalty = _penalty(change.R_u_unfiltered, settings)
    if change.lambda_ is not None:
        _require_forgets(settings, change.lambda_)
    covariance, distance = "", 0.0
    if change.target is not None:
        covariance, distance = _apply_target(kernel, settings, change.target, change.covariance)
    if change.lambda_ is not None:
        kernel.set_lambda(change.lambda_)
    kernel.set_weights(weights[0], weights[1], penalty)
    return AppliedChange(int(kernel.k), change, covariance, distance, evidence)


def _apply_target(
    kernel: _kernel.Controller, settings: ControllerSettings, target: TargetModel, covariance: str
) -> tuple[str, float]:
    require_fits(target, settings, int(kernel.longest_order))
    option = _option(covariance, settings, target.numerator, kernel.target[0])
    try:
        distance = kernel.set_target(target.numerator, target.denominator, option)
    except OverflowError:
        raise DivergedError(
            f"the replay of the last steps with the new target overflows float64 at step "
            f'{kernel.k}; the controller is unchanged. Use covariance="reset".'
        ) from None
    lost = option == "blend" and distance >= 0.999
    return "reset" if lost else option, float(distance)


def require_fits(target: TargetModel, settings: ControllerSettings, longest_order: int) -> None:
    """Refuse a target model that a running controller cannot go on with."""
    require_kind(target, "target", (TargetModel,))
    was = settings.target
    if (target.l_z, target.l_u) != (was.l_z, was.l_u):
        raise InputError(
            f"the new target model is {target.l_z} x {target.l_u} and the controller's "
            f"{was.l_z} x {was.l_u}: the number of signals cannot change while it runs. The "
            "controller is unchanged; give a target of that shape, or start another controller."
        )
    if target.n_f > longest_order:
        raise InputError(
            f"the new target model has order n_f = {target.n_f}; the stored signals suffice for "
            f"{longest_order}. Start a new controller with it."
        )
    if settings.form == "filter" and target.relative_degree == 0:
        raise ImproperError(
            'form = "filter" updates before u(k) is known, so the target model must be strictly '
            "proper; the controller is unchanged."
        )


def _option(covariance: str, settings: ControllerSettings, target: Array, was: Array) -> str:
    """Return the kernel's option for P at a change of the target."""
    update = settings.update
    if isinstance(update, Gradient | Instantaneous):
        if covariance == "replay":
            raise InputError(f'{update!r} stores no samples that covariance="replay" could replay.')
        return "keep"
    if isinstance(update, SlidingWindow):  # its rows are those of one target or of the other
        return "keep" if covariance == "keep" else "replay"
    if covariance == "blend" and nmp_zero_count(target) != nmp_zero_count(was):
        return "reset"
    return covariance


def _require_forgets(settings: ControllerSettings, lambda_: float) -> None:
    update = settings.update
    if not isinstance(update, RecursiveLeastSquares | SlidingWindow):
        raise InputError(f"{update!r} has no forgetting factor that could be set.")
    if isinstance(update.lambda_, VariableRateForgetting):
        raise InputError(
            f"lambda is set at every step by {update.lambda_!r}; so set_lambda is refused."
        )
    noise = update.process_noise if isinstance(update, RecursiveLeastSquares) else None
    if noise is not None and lambda_ != 1:
        raise InputError("process_noise belongs to (2.46), that is to lambda_ = 1.")


def _penalty(value: float | Array | None, settings: ControllerSettings) -> Array | None:
    """The rows that the kernel makes of R_u_unfiltered."""
    if value is None:
        return None
    R = constant_weight(value, "R_u_unfiltered", settings.structure.l_u, definite=False)
    if isinstance(settings.update, SlidingWindow) and not settings.R_u_unfiltered.any():
        raise InputError(
            "the window of this controller holds no rows for R_u_unfiltered; start it with one "
            "that is not zero."
        )
    return penalty_rows(R)


def _kernel_weight(
    value: LiveWeight | None, name: str, l_z: int, *, definite: bool
) -> KernelWeight:
    if value is None:
        return None
    if isinstance(value, SignalWeight):
        require_kind(value, name, (SignalWeight,))
        if definite and value.constant == 0:
            raise InputError(
                f"{name} = z_squared z'z is not positive definite at z = 0; give constant."
            )
        return value.constant * np.eye(l_z), value.z_squared, value.nu
    return constant_weight(value, name, l_z, definite=definite)
