"""Identification of u -> z during a run, and updates of the target model."""

from __future__ import annotations

from contextlib import suppress
from typing import Protocol

import numpy as np

from compensator_theory.errors import DivergedError, InputError
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.engine._changes import ControllerChange
from rcac_numeric.identification._recursive_arx import RecursiveARX
from rcac_numeric.identification._zeros_of_arx import PHASES, OnlineZeros
from rcac_numeric.targets._data_driven import DataDriven
from rcac_numeric.targets._model import TargetModel

# A zero beyond the largest is a small leading coefficient more than a zero. One between the circle
# and the smallest is as often what a command or disturbance that persists, 1 or exp(+-j omega),
# leaves in numerator and denominator alike.
SMALLEST_ZERO, LARGEST_ZERO = 1.02, 10.0


class DataDrivenLearner:
    """Recursive ARX model of u -> z that requests changes of G_f."""

    def __init__(self, settings: DataDriven, structure: Structure) -> None:
        self.settings = settings
        self.model = RecursiveARX(
            settings.order, R_theta=settings.R_theta, lambda_=settings.lambda_
        )
        self._window = FrozenPerturbation(structure, settings) if settings.is_frozen else None
        self._current = np.zeros(0)  # the numerator of the last request
        self._outside: ComplexArray = np.zeros(0, dtype=np.complex128)  # zeros of this numerator

    @property
    def has_target(self) -> bool:
        """Whether a target model has been requested."""
        return bool(self._current.size)

    def take(self, u: Array, z: Array, *read: Array) -> None:
        """Take in the next steps of u, z, y and r; a model that overflows is ignored."""
        if self._window is not None:
            self._window.take(u, z, *read)
            return
        with suppress(DivergedError):
            self.model.update(u, z)

    def next_look(self, k: int) -> int:
        """Return the first step after k with a target update."""
        start, every = self.settings.start, self.settings.every
        return start if k < start else k + every - (k - start) % every

    def is_due(self, k: int) -> bool:
        """Whether a target update is due before step k."""
        return k >= self.settings.start and (k - self.settings.start) % self.settings.every == 0

    def look(self, theta: Array) -> tuple[ControllerChange, str] | None:
        """Return the change of G_f and its evidence; None if the target stays."""
        if self._window is not None:
            try:
                self.model = self._window.model(theta)
            except DivergedError:
                return None
        if not np.isfinite(self.model.b).all() or not np.isfinite(self.model.variance):
            return None
        try:
            estimate = self.model.estimate(self.settings.level, self.settings.d_zu)
        except InputError:
            return None  # no significant response of z to u: the target stays
        outside = self._chosen(estimate)
        H = estimate.H if self.settings.H is None else self.settings.H
        if H == 0:
            return None
        numerator = np.r_[np.zeros(estimate.d_zu), H * np.poly(outside).real]
        if not np.isfinite(numerator).all() or not self._differs(numerator):
            return None
        option = self.settings.covariance if self._current.size else "reset"
        self._current, self._outside = numerator, outside
        return ControllerChange(TargetModel(numerator), covariance=option), str(estimate)

    def _chosen(self, zeros: OnlineZeros) -> ComplexArray:
        """Return the zeros of the new G_f, in conjugate pairs."""
        first = not self._current.size
        chosen = []
        for zero, phase in zip(zeros.zeros, zeros.phases, strict=True):
            size = abs(zero)
            if not SMALLEST_ZERO < size < LARGEST_ZERO or phase == PHASES[1]:
                continue
            was_outside = self._outside.size and (np.abs(self._outside - zero) < 0.2 * size).any()
            if phase == PHASES[0] or first or was_outside:
                chosen.append(zero)
        # A conjugate pair has one modulus and one error, up to rounding.
        paired = [z for z in chosen if z.imag == 0 or z.conjugate() in chosen]
        return np.array(paired, dtype=np.complex128)

    def _differs(self, numerator: Array) -> bool:
        if not self._current.size:
            return True
        length = max(len(numerator), len(self._current))
        new, old = (np.pad(n, (0, length - len(n))) for n in (numerator, self._current))
        gap = float(np.linalg.norm(new - old))
        return gap > self.settings.changed * float(np.linalg.norm(old))

    def save(self) -> Array:
        """Return the state."""
        parts = [self._outside.real, self._outside.imag]
        sizes = np.array([float(self._current.size), float(self._outside.size)])
        model = self.model.state if self._window is None else self._window.save()
        return np.concatenate([sizes, self._current, *parts, model])

    def restore(self, values: Array) -> None:
        """Restore the state that `save` returned."""
        sizes = values[:2]
        if len(sizes) < 2 or not (sizes >= 0).all() or not (sizes <= len(values)).all():
            raise ValueError("it holds no state of a learner")
        n, m = (int(size) for size in sizes)
        ends = np.cumsum([2, n, m, m])
        _, current, real, imaginary, model = np.split(values, ends)
        keeper = self.model if self._window is None else self._window
        keeper.restore(np.ascontiguousarray(model))
        self._current, self._outside = current.copy(), real + 1j * imaginary


class Restorable(Protocol):
    """Protocol of objects with a state that can be saved and restored."""

    def save(self) -> Array:
        """Return the state as an array."""

    def restore(self, state: Array, /) -> None:
        """Restore a state; raise ValueError for other values."""


class LearningLoop:
    """State of a compiled loop or controller together with its learner."""

    def __init__(self, compiled: Restorable, learner: Restorable) -> None:
        self._compiled, self._learner = compiled, learner

    def save(self) -> Array:
        """Return the values of the loop, those of the learner, and their number."""
        learnt = self._learner.save()
        values = self._compiled.save()
        return np.concatenate([values, learnt, [float(learnt.size)]])

    def restore(self, values: Array) -> None:
        """Raise ValueError where the values do not fit."""
        count = int(values[-1]) if values.size and 0 < values[-1] < values.size else 0
        if not count:
            raise ValueError("it holds no state of a learner")
        whole = values[: -1 - count], values[-1 - count : -1]
        self._compiled.restore(np.ascontiguousarray(whole[0]))
        self._learner.restore(np.ascontiguousarray(whole[1]))


# The virtual perturbation over a window, with one theta for all steps.


class FrozenPerturbation:
    """u~(k) = u(k) - Phi(k) theta over a window with the current theta.

    The loop that theta would close, driven by u~, is what (4.14) speaks of: u~ -> z has d_zu, H and
    the zeros of G_zu, and the order n + n_c.
    """

    def __init__(self, structure: Structure, settings: DataDriven) -> None:
        self._settings = settings
        at = {"u": 0, "y": 2, "r": 2 + structure.l_y}
        self._taps = [(at[tap.signal] + tap.component, tap.delay) for tap in structure.taps]
        self._longest = max(delay for _, delay in self._taps)
        self._rows = np.zeros((self._longest, 2 + structure.l_y + structure.l_r))  # before step 0

    def take(self, *signals: Array) -> None:
        """Take in the next steps of u, z, y and optionally r; shapes (steps, width)."""
        new = np.vstack([self._rows, np.hstack(signals)])
        self._rows = new[-(self._settings.window + self._longest) :]

    def signals(self, theta: Array) -> tuple[Array, Array]:
        """Return u~ with this theta, and z, over the available window."""
        steps = len(self._rows) - self._longest
        known = self._rows[self._longest :]
        perturbation = known[:, 0].copy()
        for coefficient, (column, delay) in zip(theta, self._taps, strict=True):
            first = self._longest - delay
            perturbation -= coefficient * self._rows[first : first + steps, column]
        return perturbation, known[:, 1]

    def model(self, theta: Array) -> RecursiveARX:
        """Return the ARX model of u~ -> z; raise DivergedError on overflow."""
        chosen = self._settings
        model = RecursiveARX(chosen.order, R_theta=chosen.R_theta, lambda_=chosen.lambda_)
        model.update(*self.signals(theta))
        return model

    def save(self) -> Array:
        """Return the state."""
        return np.asarray(self._rows.reshape(-1))

    def restore(self, values: Array) -> None:
        """Restore the state that `save` returned."""
        width = self._rows.shape[1]
        rows, rest = divmod(len(values), width)
        if rest or not self._longest <= rows <= self._settings.window + self._longest:
            raise ValueError("it holds no window of signals")
        self._rows = values.reshape(rows, width).copy()
