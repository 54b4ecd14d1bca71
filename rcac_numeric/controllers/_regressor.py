"""Regressor and filtered regressor of recorded signals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.targets._model import TargetModel


def regressor_of(structure: Structure, signals: Mapping[str, Array | None], sign: Any) -> Array:
    """Return phi(k) of (2.29) for recorded signals from rest; shape (steps, taps).

    With np.abs as `sign` the result bounds the error of phi for errors of the signals.
    """
    u, y, r = signals["u"], signals["y"], signals["r"]
    assert u is not None and y is not None
    steps = len(u)
    inputs = y if r is None or not structure.l_r else np.hstack([y, r])
    derived = np.zeros((steps, len(structure.derived)))
    for i, signal in enumerate(structure.derived):
        drive = inputs @ sign(np.array(signal.now))
        drive[1:] += inputs[:-1] @ sign(np.array(signal.before))
        pole, before = float(sign(signal.pole)), 0.0
        # A clamp does not increase an error, so the bound ignores it.
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


def has_common_filter(target: TargetModel) -> bool:
    """Whether D_f is a polynomial times the identity, so that signals are filtered separately."""
    first = target.denominator[:, :1, :1] * np.eye(target.l_z)
    return bool(np.array_equal(first, target.denominator))


def filtered_regressor(phi: Array, target: TargetModel) -> Array:
    """Return Phi_f = G_f Phi of (2.40) for Phi = phi' (x) I; shape (steps, l_z, l_theta)."""
    steps, taps = phi.shape
    if target.denominator[1:].any():
        phi = _divided(phi, target.denominator[1:, 0, 0])
    out = np.zeros((steps, target.l_z, taps, target.l_u))
    for lag, N in enumerate(target.numerator):
        if N.any() and lag < steps:
            out[lag:] += np.einsum("kt,zu->kztu", phi[: steps - lag], N)
    return out.reshape(steps, target.l_z, taps * target.l_u)


def _divided(phi: Array, tail: Array) -> Array:
    """Filter the columns of phi by 1/(1 + tail(q^-1)); importing scipy.signal takes 0.5 s."""
    out, order = phi.copy(), len(tail)
    reversed_tail = tail[::-1]
    for k in range(1, len(out)):
        first = max(k - order, 0)
        out[k] -= reversed_tail[order - (k - first) :] @ out[first:k]
    return out
