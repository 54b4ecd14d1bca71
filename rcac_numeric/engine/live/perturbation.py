"""The virtual perturbation of the last steps, with the theta of one moment in all of them."""

from __future__ import annotations

import numpy as np

from rcac_numeric.arrays.array_types import Array
from rcac_numeric.controllers.structure import Structure
from rcac_numeric.identification.online.arx import RecursiveARX
from rcac_numeric.targets.data_driven import DataDriven


class FrozenPerturbation:
    """u~(k) = u(k) - Phi(k) theta over a window, theta that of the moment at which it is asked.

    The loop that theta would close, driven by u~, is what (4.14) speaks of: u~ -> z has d_zu, H and
    the zeros of G_zu, and the order n + n_c.

    Parameters
    ----------
    structure : Structure
        With one u, and no derived signals.
    settings : DataDriven
        Whose window, order and forgetting the model has.
    """

    def __init__(self, structure: Structure, settings: DataDriven) -> None:
        self._settings = settings
        at = {"u": 0, "y": 2, "r": 2 + structure.l_y}
        self._taps = [(at[tap.signal] + tap.component, tap.delay) for tap in structure.taps]
        self._longest = max(delay for _, delay in self._taps)
        self._rows = np.zeros((self._longest, 2 + structure.l_y + structure.l_r))  # before step 0

    def take(self, *signals: Array) -> None:
        """The next steps of u, z, y and, where there is one, r; each of shape (steps, width)."""
        new = np.vstack([self._rows, np.hstack(signals)])
        self._rows = new[-(self._settings.window + self._longest) :]

    def signals(self, theta: Array) -> tuple[Array, Array]:
        """u~ with this theta, and z, over what there is of the window."""
        steps = len(self._rows) - self._longest
        known = self._rows[self._longest :]
        perturbation = known[:, 0].copy()
        for coefficient, (column, delay) in zip(theta, self._taps, strict=True):
            first = self._longest - delay
            perturbation -= coefficient * self._rows[first : first + steps, column]
        return perturbation, known[:, 1]

    def model(self, theta: Array) -> RecursiveARX:
        """The ARX model of u~ -> z; raises DivergedError where it leaves float64."""
        chosen = self._settings
        found = RecursiveARX(chosen.order, R_theta=chosen.R_theta, lambda_=chosen.lambda_)
        found.update(*self.signals(theta))
        return found

    def save(self) -> Array:
        """What later looks depend on."""
        return np.asarray(self._rows.reshape(-1))

    def restore(self, values: Array) -> None:
        """Go back, or forward, to what `save` gave."""
        width = self._rows.shape[1]
        rows, rest = divmod(len(values), width)
        if rest or not self._longest <= rows <= self._settings.window + self._longest:
            raise ValueError("it holds no window of signals")
        self._rows = values.reshape(rows, width).copy()
