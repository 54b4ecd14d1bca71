"""The regressor of logged signals: what a controller of a structure has seen at each step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.checks.logs import ControllerLog
from rcac_numeric.controllers.structure import Structure


def regressor(structure: Structure, log: ControllerLog) -> Array:
    """phi(k) of (2.29), from the logged signals and zero before; shape (steps, taps)."""
    return regressor_of(structure, {"u": log.u, "y": log.y, "r": log.r}, np.asarray)


def regressor_of(structure: Structure, signals: Mapping[str, Array | None], sign: Any) -> Array:
    """The same of any signals; with np.abs as `sign`, a bound of its error from that of theirs."""
    u, y, r = signals["u"], signals["y"], signals["r"]
    assert u is not None and y is not None
    steps = len(u)
    inputs = y if r is None or not structure.l_r else np.hstack([y, r])
    derived = np.zeros((steps, len(structure.derived)))
    for i, signal in enumerate(structure.derived):
        drive = inputs @ sign(np.array(signal.now))
        drive[1:] += inputs[:-1] @ sign(np.array(signal.before))
        pole, before = float(sign(signal.pole)), 0.0
        # A clamp makes no error larger: the bound is that without it.
        limit = np.inf if sign is np.abs else signal.limit
        for k in range(steps):
            free = pole * before + drive[k]
            before = derived[k, i] = min(max(free, -limit), limit)
    known = {"u": u, "y": y, "r": r, "derived": derived}
    phi = np.zeros((steps, len(structure.taps)))
    for j, tap in enumerate(structure.taps):
        past = known[tap.signal]
        assert past is not None
        phi[tap.delay :, j] = past[: max(steps - tap.delay, 0), tap.component]
    return phi


def require_fit(log: ControllerLog, structure: Structure) -> None:
    """Refuse a log whose widths or coefficients are not those of the structure."""
    words = f"this {structure.name} structure with n_c = {structure.n_c}"
    for name, width in (("u", structure.l_u), ("y", structure.l_y), ("r", structure.l_r)):
        signal = getattr(log, name)
        if width and signal is None:
            raise InputError(f"{log.source}: {words} reads {name}, which the log does not hold.")
        if width and signal.shape[1] != width:
            raise InputError(
                f"{log.source}: {name} has {signal.shape[1]} components; {words} has l_{name} = "
                f"{width}."
            )
    assert log.theta is not None
    size = log.theta.shape[-1]
    if size != structure.l_theta:
        hint = "Check n_c, k_c and the kind of structure."
        if size == log.steps and structure.l_theta == 1:
            hint = f"One coefficient over time has the shape ({log.steps}, 1)."
        raise InputError(
            f"{log.source}: theta has {size} coefficients; {words}, l_u = {structure.l_u}, l_y = "
            f"{structure.l_y} has {structure.l_theta}. {hint}"
        )
