"""The learner of a controller that is driven step by step, and learns late what was applied."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.engine import _kernel
from rcac_numeric.engine.live.changes import AppliedChange, ControllerChange
from rcac_numeric.engine.live.learner import DataDrivenLearner, LearningLoop

# Steps that wait to be learnt where no look is due for long.
LONGEST_WAIT = 4096


class DeviceLearner:
    """What `simulate` does between two steps of a controller with `DataDriven`, bit for bit.

    The last pair of u and z waits for what the actuator made of u; before the first target model
    there is no update.

    Parameters
    ----------
    settings : ControllerSettings
        With `learning`.
    kernel : compiled controller
    """

    def __init__(self, settings: ControllerSettings, kernel: _kernel.Controller) -> None:
        assert settings.learning is not None
        self._learner = DataDrivenLearner(settings.learning)
        self._kernel = kernel
        self.whole = LearningLoop(kernel, self)
        self._waiting: list[tuple[float, float]] = []
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
            self._waiting[-1] = (float(u_applied[0]), self._waiting[-1][1])
        if self._learner.is_due(k):
            self._learn(len(self._waiting))
            if (asked := self._learner.look()) is not None:
                change(*asked)
                self.freeze(self._is_held)
        elif len(self._waiting) >= LONGEST_WAIT:
            self._learn(len(self._waiting))

    def after(self, u: Array, z: Array) -> None:
        """Step k is done; what was applied may still be said with the next."""
        self._waiting.append((float(u[0]), float(z[0])))

    def _learn(self, count: int) -> None:
        if count > 0:
            u, z = np.array(self._waiting[:count]).T.copy()
            self._learner.take(u, z)
            del self._waiting[:count]

    def save(self) -> Array:
        """What later steps depend on, the pair that waits among it."""
        self._learn(len(self._waiting) - 1)
        waits = bool(self._waiting)
        pair = self._waiting[-1] if waits else (0.0, 0.0)
        return np.array([*self._learner.save(), *pair, float(waits), float(self._is_held)])

    def restore(self, values: Array) -> None:
        """Go back, or forward, to what `save` gave."""
        if len(values) < 4 or not np.isin(values[-2:], (0.0, 1.0)).all():
            raise ValueError("it holds no state of a learner")
        self._learner.restore(np.ascontiguousarray(values[:-4]))
        u, z, waits, held = values[-4:].tolist()
        self._waiting = [(u, z)] if waits else []
        self.freeze(bool(held))


def require_not_learnt(settings: ControllerSettings, change: ControllerChange) -> None:
    """Refuse a target model from outside where the controller learns its own.

    Parameters
    ----------
    settings : ControllerSettings
    change : ControllerChange

    Raises
    ------
    InputError
        Where both would set it.
    """
    if settings.learning is not None and change.target is not None:
        raise InputError(
            "the target model of this controller is learnt, by DataDriven; the next look would "
            "replace another one. Start a controller with a TargetModel, or leave the target."
        )
