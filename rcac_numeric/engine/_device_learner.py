"""DataDriven learning of a `Controller`, which receives the applied u one step later."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.compiled import _kernel
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.engine._changes import AppliedChange, ControllerChange
from rcac_numeric.engine._learner import DataDrivenLearner, LearningLoop

# Largest number of buffered steps between two target updates.
LONGEST_WAIT = 4096


class DeviceLearner:
    """Learning between two steps of a `Controller` with `DataDriven`, equal to `simulate`.

    The last step's signals wait for what the actuator made of u; before the first target model
    there is no update.
    """

    def __init__(self, settings: ControllerSettings, kernel: _kernel.Controller) -> None:
        assert settings.learning is not None
        self._learner = DataDrivenLearner(settings.learning, settings.structure)
        self._kernel = kernel
        self.whole = LearningLoop(kernel, self)
        structure = settings.structure
        self._waiting: list[Array] = []  # buffered rows of u, z, y and r
        self._ends = np.cumsum([1, 1, structure.l_y])
        self._width = 2 + structure.l_y + structure.l_r
        self._last = np.zeros(self._width)
        self._is_frozen = False  # frozen by the user
        self.freeze(False)

    def freeze(self, frozen: bool) -> None:
        """Freeze theta, or adapt from the first target model on; the identification continues."""
        self._is_frozen = frozen
        self._kernel.freeze(frozen or not self._learner.has_target)

    def before(
        self,
        k: int,
        u_applied: Array | None,
        change: Callable[[ControllerChange, str], AppliedChange],
    ) -> None:
        """Before step k: take in the buffered steps and update the target model if due."""
        if u_applied is not None and self._waiting:
            self._waiting[-1][0] = u_applied[0]
        if self._learner.is_due(k):
            self._learn(len(self._waiting))
            if (update := self._learner.look(self._kernel.theta)) is not None:
                change(*update)
                self.freeze(self._is_frozen)
        elif len(self._waiting) >= LONGEST_WAIT:
            self._learn(len(self._waiting))

    def after(self, u: Array, y: Array, z: Array, r: Array | None) -> None:
        """Buffer step k; u_applied of this step may follow with the next."""
        row = np.concatenate([u, z, y, *([] if r is None else [r])])
        # A missed sample: the model takes the value that the kernel used.
        missed = ~np.isfinite(row)
        row[missed] = self._last[missed]
        self._waiting.append(row)
        self._last = row.copy()

    def _learn(self, count: int) -> None:
        if count > 0:
            rows = np.array(self._waiting[:count])
            self._learner.take(*np.hsplit(rows, self._ends))
            del self._waiting[:count]

    def save(self) -> Array:
        """Return the state, the buffered steps included."""
        self._learn(len(self._waiting) - 1)
        waits = bool(self._waiting)
        row = self._waiting[-1] if waits else np.zeros(self._width)
        flags = [float(waits), float(self._is_frozen)]
        return np.concatenate([self._learner.save(), self._last, row, flags])

    def restore(self, values: Array) -> None:
        """Restore the state that `save` returned."""
        size = 2 * self._width + 2
        if len(values) < size or not np.isin(values[-2:], (0.0, 1.0)).all():
            raise ValueError("it holds no state of a learner")
        self._learner.restore(np.ascontiguousarray(values[:-size]))
        waits, value = values[-2:].tolist()
        self._last, row = values[-size:-2].reshape(2, -1).copy()
        self._waiting = [row] if waits else []
        self.freeze(bool(value))


def require_not_learnt(settings: ControllerSettings, change: ControllerChange) -> None:
    """Raise for an external target model if the controller learns its target."""
    if settings.learning is not None and change.target is not None:
        raise InputError(
            "DataDriven learns the target model of this controller and would replace another one. "
            "Start a controller with a TargetModel, or leave the target."
        )
