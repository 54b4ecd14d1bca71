"""RCAC and its plants in ball arithmetic: every number is a ball that holds the exact result.

An independent transcription of section 2.3, without the kernel's taps and filters: Phi(k) is
built from (2.30), filtered as a matrix by (2.40), and theta updated by (2.42)-(2.48) as printed.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from flint import arb, arb_mat

from compensator_theory.errors import DivergedError
from rcac_numeric.controllers.rules import SignalWeight
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.plants.linear import MATRICES, Plant, initial_state
from rcac_numeric.plants.schedules import PlantChange, PlantSchedule


class BallController:
    """One controller. A step is `measure`, `control`, `adapt` and `finish`, in the loop's order."""

    def __init__(self, settings: ControllerSettings) -> None:
        self.settings, self.k = settings, 0
        self.theta = balls(settings.theta_0.reshape(-1, 1))
        self.P = balls(settings.R_theta).inv()
        self._P_0 = self.P
        self._noise = None if settings.process_noise is None else balls(settings.process_noise)
        names = ("u", "y", "r", "derived", "Phi", "Phi_f", "u_f")
        self._past: dict[str, list[arb_mat]] = {name: [] for name in names}

    def measure(self, y: arb_mat, r: arb_mat) -> None:
        """Take y(k) and r(k), and run the derived signals."""
        past, derived = self._past, self.settings.structure.derived
        past["y"].append(y)
        past["r"].append(r)
        value = arb_mat(len(derived), 1)
        for i, signal in enumerate(derived):
            for lag, row in enumerate((signal.now, signal.before)[: self.k + 1]):
                inputs = past["y"][-1 - lag].entries() + past["r"][-1 - lag].entries()
                for weight, v in zip(row, inputs, strict=True):
                    value[i, 0] += arb(weight) * v
            if self.k > 0:
                value[i, 0] += arb(signal.pole) * past["derived"][-1][i, 0]
        past["derived"].append(value)

    def control(self) -> arb_mat:
        """u(k) = Phi(k) theta(k), (2.29)."""
        u = arb_mat(self.settings.structure.l_u, 1)
        if self.k >= self.settings.k_w:
            u = self._regressor() * self.theta
        self._past["u"].append(u)
        return u

    def adapt(self, z: arb_mat) -> None:
        """theta(k+1), or theta(k) in the filter form, and the covariance that goes with it."""
        s, k = self.settings, self.k
        self._past["Phi"].append(self._regressor())
        self._filter("Phi", s.structure.l_theta)
        self._filter("u", 1)
        if s.reset and k in s.reset.at:
            self.P = self._P_0
        frozen = any(start <= k and (stop is None or k < stop) for start, stop in s.freeze)
        if k < s.k_update or frozen:
            return
        age = k - s.k_update
        if s.reset and s.reset.every and age > 0 and age % s.reset.every == 0:
            self.P = self._P_0
        R_z, W = self._weight(s.R_z, z), self._weight(s.R_z, z) + self._weight(s.R_u, z)
        lam = arb(_latest(s.lambda_, s.later_lambdas, k))
        F, residual = self._past["Phi_f"][k], z - self._past["u_f"][k]
        if s.update == "gradient":
            slope = F.transpose() * (W * F * self.theta + R_z * residual)
            self.theta = self.theta - slope * arb(s.step_size)
            return
        PF = self.P * F.transpose()
        try:
            W_inverse = W.inv()
            gain = PF * (W_inverse * lam + F * PF).inv()
        except ZeroDivisionError:
            raise DivergedError(
                f"the balls have lost every digit at step {k}: Upsilon cannot be told from a "
                "singular matrix. Use more digits or fewer steps, and look whether the loop "
                "diverges in float64."
            ) from None
        self.theta = self.theta - gain * (F * self.theta + W_inverse * R_z * residual)
        if s.update != "instantaneous":
            self.P = (self.P - gain * (F * self.P)) * (1 / lam)
        if self._noise is not None:
            self.P = self.P + self._noise

    def finish(self) -> None:
        """Go to the next step."""
        self.k += 1

    def _regressor(self) -> arb_mat:
        """Phi(k) = phi(k)' (x) I of (2.30), with zeros before step 0."""
        structure = self.settings.structure
        Phi = arb_mat(structure.l_u, structure.l_theta)
        for j, tap in enumerate(structure.taps):
            if self.k >= tap.delay:
                value = self._past[tap.signal][self.k - tap.delay][tap.component, 0]
                for i in range(structure.l_u):
                    Phi[i, j * structure.l_u + i] = value
        return Phi

    def _filter(self, name: str, columns: int) -> None:
        """G_f of Phi or u, (2.40); zero inputs before k_filter."""
        target = _latest(self.settings.target, self.settings.later_targets, self.k)
        output = arb_mat(target.l_z, columns)
        for i in range(min(self.k, target.n_f) + 1):
            # In the filter form u(k) is not there yet, and N_0 is zero.
            if self.k - i >= self.settings.k_filter and target.numerator[i].any():
                output = output + balls(target.numerator[i]) * self._past[name][self.k - i]
            if i > 0:
                earlier = self._past[f"{name}_f"][self.k - i]
                output = output - balls(target.denominator[i]) * earlier
        self._past[f"{name}_f"].append(output)

    def _weight(self, R: Any, z: arb_mat) -> arb_mat:
        if not isinstance(R, SignalWeight):
            return balls(R)
        power = (z.transpose() * z)[0, 0] * arb(R.z_squared) + arb(R.constant)
        return balls(np.eye(z.nrows())) * power


class BallPlant:
    """A linear plant or a schedule of them; x holds the state."""

    def __init__(self, plant: Plant | PlantSchedule, x_0: Any) -> None:
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


def balls(values: Any) -> arb_mat:
    """float64 numbers, taken as exact."""
    array = np.asarray(values, dtype=np.float64)
    return arb_mat(*array.shape, [arb(float(v)) for v in array.ravel()])


def _latest(first: Any, changes: Any, k: int) -> Any:
    return [first, *(value for step, value in sorted(changes.items()) if step <= k)][-1]
