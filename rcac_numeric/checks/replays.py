"""Whether a logged u really is what the logged coefficients make of the logged past."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.checks.logs import ControllerLog
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.controllers.structure import Structure

# A log in single precision or in seven printed digits still counts as the same u.
SAME = 1e-5


@dataclass(frozen=True, eq=False)
class ControlReplay:
    """u(k) beside Phi(k) theta of the log.

    Attributes
    ----------
    u : array, shape (steps, l_u)
        Phi(k) theta(k) from the logged u, y and r; for coefficients that were logged only once,
        Phi(k) theta.
    start : int
        The first step that is compared: k_w, or where the regressor is filled; for coefficients
        that were logged only once, the last tenth.
    shift : int
        0 where row k of theta made u(k); 1 where row k is what the update of step k left, so
        that row k - 1 made u(k). The one that fits better is taken.
    worst : float
        Largest abs(u - Phi theta) from `start` on, relative to the largest abs(Phi) abs(theta)
        there: the terms that u is the sum of, which may be much larger than u.
    worst_step : int
    of : {"theta", "the compensator"}
        What u was computed from.
    """

    u: Array
    start: int
    shift: int
    worst: float
    worst_step: int
    of: str = "theta"

    @property
    def agrees(self) -> bool:
        """Whether u is the output of the coefficients, to 1e-5."""
        return self.worst <= SAME

    def __str__(self) -> str:
        rows = "" if not self.shift else "; row k of theta is what step k left for step k + 1"
        verdict = "is" if self.agrees else "is NOT"
        return (
            f"u {verdict} the output of {self.of}: worst relative difference {self.worst:.2g} at "
            f"step {self.worst_step}, compared from step {self.start} on{rows}"
        )


def regressor(structure: Structure, log: ControllerLog) -> Array:
    """phi(k) of (2.29), from the logged signals and zero before; shape (steps, taps)."""
    steps = log.steps
    inputs = log.y if log.r is None or not structure.l_r else np.hstack([log.y, log.r])
    derived = np.zeros((steps, len(structure.derived)))
    for i, signal in enumerate(structure.derived):
        drive = inputs @ np.array(signal.now)
        drive[1:] += inputs[:-1] @ np.array(signal.before)
        before = 0.0
        for k in range(steps):
            before = derived[k, i] = signal.pole * before + drive[k]
    signals = {"u": log.u, "y": log.y, "r": log.r, "derived": derived}
    phi = np.zeros((steps, len(structure.taps)))
    for j, tap in enumerate(structure.taps):
        phi[tap.delay :, j] = signals[tap.signal][: max(steps - tap.delay, 0), tap.component]
    return phi


def replay(log: ControllerLog, structure: Structure, *, k_w: int | None = None) -> ControlReplay:
    """Compute what the controller must have answered, and hold the logged u against it.

    Parameters
    ----------
    log : ControllerLog
        With theta.
    structure : Structure
    k_w : int, optional
        First step with u = Phi theta; by default where the regressor is filled.

    Raises
    ------
    InputError
        Where sizes do not fit the structure.

    Examples
    --------
    >>> from rcac_numeric import ControllerLog, iir
    >>> from rcac_numeric.checks.replays import replay
    >>> log = ControllerLog(u=[0, 1.0, 0.5], y=[2.0, 0, 0], theta=[0.5, 0.5])
    >>> replay(log, iir(n_c=1)).agrees     # u(k) = u(k-1)/2 + y(k-1)/2
    True
    """
    require_fit(log, structure)
    phi = regressor(structure, log)
    first = structure.n_c if k_w is None else max(k_w, 0)
    taps = len(structure.taps)
    if not log.has_history:
        start = max(first, log.steps - max(log.steps // 10, 1))
        Theta = log.theta.reshape(taps, structure.l_u)
        return _held(log, phi @ Theta, np.abs(phi) @ np.abs(Theta), start, 0)
    Theta = log.theta.reshape(log.steps, taps, structure.l_u)
    found = []
    for shift in (0, 1):
        rows = Theta[: log.steps - shift]
        u, terms = np.zeros_like(log.u), np.zeros_like(log.u)
        u[shift:] = np.einsum("kj,kji->ki", phi[shift:], rows)
        terms[shift:] = np.einsum("kj,kji->ki", np.abs(phi[shift:]), np.abs(rows))
        found.append(_held(log, u, terms, max(first, shift), shift))
    return min(found, key=lambda each: (each.worst, each.shift))


def replay_compensator(log: ControllerLog, compensator: Compensator) -> ControlReplay:
    """The same for a compensator that did not change, over the last tenth of the log.

    Examples
    --------
    >>> from rcac_numeric import Compensator, ControllerLog
    >>> from rcac_numeric.checks.replays import replay_compensator
    >>> log = ControllerLog(u=[0, 1.0, 0.5], y=[2.0, 0, 0])
    >>> replay_compensator(log, Compensator(past_u=[[[0.5]]], past_y=[[[0.0]], [[0.5]]])).agrees
    True
    """
    inputs = (
        log.y if log.r is None or compensator.l_y == log.y.shape[1] else np.hstack([log.y, log.r])
    )
    made, terms = np.zeros_like(log.u), np.zeros_like(log.u)
    for signal, coefficients, first in (
        (log.u, compensator.past_u, 1),
        (inputs, compensator.past_y, 0),
    ):
        for lag, matrix in enumerate(coefficients, first):
            past = signal[: max(log.steps - lag, 0)]
            made[lag:] += past @ matrix.T
            terms[lag:] += np.abs(past) @ np.abs(matrix).T
    start = max(len(compensator.past_u), log.steps - max(log.steps // 10, 1))
    return replace(_held(log, made, terms, start, 0), of="the compensator")


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
    size = log.theta.shape[-1]
    if size != structure.l_theta:
        hint = "Check n_c, k_c and the kind of structure."
        if size == log.steps and structure.l_theta == 1:
            hint = f"One coefficient over time has the shape ({log.steps}, 1)."
        raise InputError(
            f"{log.source}: theta has {size} coefficients; {words}, l_u = {structure.l_u}, l_y = "
            f"{structure.l_y} has {structure.l_theta}. {hint}"
        )


def _held(log: ControllerLog, made: Array, terms: Array, start: int, shift: int) -> ControlReplay:
    if start >= log.steps:
        raise InputError(
            f"the log of {log.steps} steps ends before step {start}, from which u could be "
            "compared with Phi theta; a longer log is needed."
        )
    size = max(float(np.abs(log.u[start:]).max()), float(terms[start:].max()))
    gaps = np.abs(log.u - made)[start:].max(axis=1)
    worst = float(gaps.max()) / size if size else float(gaps.max())
    return ControlReplay(made, start, shift, worst, start + int(np.argmax(gaps)))
