"""Linear plants in ball arithmetic."""

from __future__ import annotations

from flint import arb, arb_mat
from numpy.typing import ArrayLike

from rcac_numeric.engine.compiled.plants import initial_state
from rcac_numeric.engine.reference.balls import balls
from rcac_numeric.plants.linear import MATRICES, Plant
from rcac_numeric.plants.schedules import PlantChange, PlantSchedule


class BallPlant:
    """A linear plant or a schedule of them; x holds the state."""

    def __init__(self, plant: Plant | PlantSchedule, x_0: ArrayLike | None) -> None:
        changes = [PlantChange(start=0, plant=plant)] if isinstance(plant, Plant) else plant.changes
        self._changes = list(changes)
        self.x = balls(initial_state(x_0, plant.n).reshape(-1, 1))
        self._sent: list[arb_mat] = []

    def begin(self, k: int) -> None:
        """Step k: its matrices, its state, its delay."""
        number = max(i for i, change in enumerate(self._changes) if change.start <= k)
        now = self._changes[number]
        if now.start == k and now.state_map is not None:
            self.x = balls(now.state_map) * self.x
        if k > 0 and now.start != k and not now.ramp:
            return
        self._delay = now.delay
        self._m = {name: balls(getattr(now.plant, name)) for name in MATRICES}
        if now.ramp:
            after = self._changes[number + 1]
            part = arb(k - now.start) / (after.start - now.start)
            for name, value in self._m.items():
                self._m[name] = value * (1 - part) + balls(getattr(after.plant, name)) * part

    def y(self, u: arb_mat, w: arb_mat) -> arb_mat:
        """The measurement y(k), (2.2)."""
        return self._row(("C", "D_0", "D_2"), u, w)

    def z(self, u: arb_mat, w: arb_mat) -> arb_mat:
        """The performance variable z(k), (2.3)."""
        return self._row(("E_1", "E_2", "E_0"), u, w)

    def advance(self, u: arb_mat, w: arb_mat) -> None:
        """x(k+1), (2.1)."""
        self.x = self._row(("A", "B", "D_1"), u, w)
        self._sent.append(u)

    def _row(self, names: tuple[str, str, str], u: arb_mat, w: arb_mat) -> arb_mat:
        k, (S, T, V) = len(self._sent), (self._m[name] for name in names)
        acting = u if self._delay == 0 else u * 0
        if 0 < self._delay <= k:
            acting = self._sent[k - self._delay]
        return S * self.x + T * acting + V * w
