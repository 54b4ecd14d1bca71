"""The learner of a controller that is driven step by step, and learns late what was applied."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.compiled import _kernel
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.engine._changes import AppliedChange, ControllerChange
from rcac_numeric.engine._learner import DataDrivenLearner, LearningLoop

# Steps that wait to be learnt where no look is due for long.
LONGEST_WAIT = 4096


class DeviceLearner:
    """What `simulate` does between two steps of a controller with `DataDriven`, bit for bit.

    The last step's signals wait for what the actuator made of u; before the first target model
    there is no update.
    """

    def __init__(self, settings: ControllerSettings, kernel: _kernel.Controller) -> None:
        assert settings.learning is not None
        self._learner = DataDrivenLearner(settings.learning, settings.structure)
        self._kernel = kernel
        self.whole = LearningLoop(kernel, self)
        structure = settings.structure
        self._waiting: list[Array] = []  # rows of u, z, y and r
        self._ends = np.cumsum([1, 1, structure.l_y])
        self._width = 2 + structure.l_y + structure.l_r
        self._last = np.zeros(self._width)
        self._is_held = False  # by its user
        self.freeze(False)

    def freeze(self, frozen: bool) -> None:
        """Hold theta, or let it adapt once there is a target model; what is learnt goes on."""
        self._is_held = frozen
        self._kernel.freeze(frozen or not self._learner.has_target)

    def before(
        self,
        k: int,
        u_applied: Array | None,
        change: Callable[[ControllerChange, str], AppliedChange],
    ) -> None:
        """What is to be done before step k: learn what came before it, look, change the target."""
        if u_applied is not None and self._waiting:
            self._waiting[-1][0] = u_applied[0]
        if self._learner.is_due(k):
            self._learn(len(self._waiting))
            if (asked := self._learner.look(self._kernel.theta)) is not None:
                change(*asked)
                self.freeze(self._is_held)
        elif len(self._waiting) >= LONGEST_WAIT:
            self._learn(len(self._waiting))

    def after(self, u: Array, y: Array, z: Array, r: Array | None) -> None:
        """Step k is done; what was applied may still be said with the next."""
        row = np.concatenate([u, z, y, *([] if r is None else [r])])
        missed = ~np.isfinite(row)  # what the kernel held, the model of the plant learns too
        row[missed] = self._last[missed]
        self._waiting.append(row)
        self._last = row.copy()

    def _learn(self, count: int) -> None:
        if count > 0:
            rows = np.array(self._waiting[:count])
            self._learner.take(*np.hsplit(rows, self._ends))
            del self._waiting[:count]

    def save(self) -> Array:
        """What later steps depend on, the step that waits among it."""
        self._learn(len(self._waiting) - 1)
        waits = bool(self._waiting)
        row = self._waiting[-1] if waits else np.zeros(self._width)
        flags = [float(waits), float(self._is_held)]
        return np.concatenate([self._learner.save(), self._last, row, flags])

    def restore(self, values: Array) -> None:
        """Go back, or forward, to what `save` gave."""
        size = 2 * self._width + 2
        if len(values) < size or not np.isin(values[-2:], (0.0, 1.0)).all():
            raise ValueError("it holds no state of a learner")
        self._learner.restore(np.ascontiguousarray(values[:-size]))
        waits, value = values[-2:].tolist()
        self._last, row = values[-size:-2].reshape(2, -1).copy()
        self._waiting = [row] if waits else []
        self.freeze(bool(value))


def require_not_learnt(settings: ControllerSettings, change: ControllerChange) -> None:
    """Refuse a target model from outside where the controller learns its own."""
    if settings.learning is not None and change.target is not None:
        raise InputError(
            "the target model of this controller is learnt, by DataDriven; the next look would "
            "replace another one. Start a controller with a TargetModel, or leave the target."
        )
