"""RCAC in ball arithmetic.

An independent transcription of section 2.3, without the kernel's taps and filters: Phi(k) is
built from (2.30), filtered as a matrix by (2.40), and theta updated by (2.42)-(2.48) as printed.
"""

from __future__ import annotations

import numpy as np
from flint import arb, arb_mat

from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.controllers.settings_checks import Weight
from rcac_numeric.controllers.weights import SignalWeight
from rcac_numeric.engine.reference.ball_updates import BallData, ball_update
from rcac_numeric.engine.reference.balls import balls, held, latest, normalized


class BallController:
    """One controller. A step is `measure`, `control`, `adapt` and `finish`, in the loop's order."""

    def __init__(self, settings: ControllerSettings) -> None:
        self.settings, self.k = settings, 0
        self.theta = balls(settings.theta_0.reshape(-1, 1))
        self._update = ball_update(settings.update, settings.l_theta)
        names = ("u", "y", "r", "derived", "Phi", "Phi_f", "u_f", "v")
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
            value[i, 0] = held(value[i, 0], -signal.limit, signal.limit, self.k)
        past["derived"].append(value)

    def control(self) -> arb_mat:
        """u(k) = Phi(k) theta(k), (2.29)."""
        u = arb_mat(self.settings.structure.l_u, 1)
        if self.k >= self.settings.k_w:
            u = self._regressor() * self.theta
        self._past["u"].append(u)
        return u if self.settings.fixed is None else u + self._beside(self.settings.fixed)

    def _beside(self, fixed: Compensator) -> arb_mat:
        """What the fixed compensator in parallel adds to u(k), (2.28)."""
        past, v = self._past, arb_mat(fixed.l_u, 1)
        for lag, P in enumerate(fixed.past_u[: self.k], start=1):
            v = v + balls(P) * past["v"][self.k - lag]
        for lag, Q in enumerate(fixed.past_y[: self.k + 1]):
            if Q.any():  # where Q_0 is zero y(k) need not be there yet
                e = past["y"][self.k - lag].entries() + past["r"][self.k - lag].entries()
                v = v + balls(Q) * arb_mat(len(e), 1, e)
        past["v"].append(v)
        return v

    def adapt(self, z: arb_mat) -> None:
        """theta(k+1), or theta(k) in the filter form, and the covariance that goes with it."""
        s, k = self.settings, self.k
        self._past["Phi"].append(self._regressor())
        self._filter("Phi", s.structure.l_theta)
        self._filter("u", 1)
        self._update.begin(k)
        frozen = any(start <= k and (stop is None or k < stop) for start, stop in s.freeze)
        if k < s.k_update or frozen:
            return
        R_z = self._weight(s.R_z, z)
        W = R_z + self._weight(s.R_u, z)
        if s.z_normalization is not None:
            f = s.z_normalization
            z = arb_mat(z.nrows(), 1, [normalized(value, f) for value in z.entries()])
        residual, Phi_f = z - self._past["u_f"][k], self._past["Phi_f"][k]
        if s.R_u_unfiltered.any():  # Phi(k) theta + 0 = 0 as further rows
            R, zero = balls(s.R_u_unfiltered), arb_mat(s.structure.l_u, 1)
            Phi_f, residual = _stacked(Phi_f, self._past["Phi"][k]), _stacked(residual, zero)
            R_z, W = _diagonal(R_z, R), _diagonal(W, R)
        data = BallData(k, k - s.k_update, Phi_f, R_z, W, residual)
        self.theta = self._update.step(data, self.theta)
        if s.bounds is not None:  # entry by entry: `require_supported` has asked
            rows = zip(self.theta.entries(), *s.bounds.box(s.structure), strict=True)
            theta = [held(value, float(low), float(high), k) for value, low, high in rows]
            self.theta = arb_mat(len(theta), 1, theta)

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
        target = latest(self.settings.target, self.settings.target_changes, self.k)
        output = arb_mat(target.l_z, columns)
        for i in range(min(self.k, target.n_f) + 1):
            # In the filter form u(k) is not there yet, and N_0 is zero.
            if self.k - i >= self.settings.k_filter and target.numerator[i].any():
                output = output + balls(target.numerator[i]) * self._past[name][self.k - i]
            if i > 0:
                earlier = self._past[f"{name}_f"][self.k - i]
                output = output - balls(target.denominator[i]) * earlier
        self._past[f"{name}_f"].append(output)

    def _weight(self, R: Weight, z: arb_mat) -> arb_mat:
        if isinstance(R, np.ndarray):
            return balls(R)
        assert isinstance(R, SignalWeight)  # no function: `require_supported` has asked
        square = (z.transpose() * z)[0, 0]
        power = square * arb(R.z_squared) + arb(R.constant)
        if R.nu:
            power = power / (1 + arb(R.nu) * square.sqrt()) ** 2
        return balls(np.eye(z.nrows())) * power


def _stacked(above: arb_mat, below: arb_mat) -> arb_mat:
    rows = above.nrows() + below.nrows()
    return arb_mat(rows, above.ncols(), above.entries() + below.entries())


def _diagonal(first: arb_mat, second: arb_mat) -> arb_mat:
    m, n = first.nrows(), second.nrows()
    whole = arb_mat(m + n, m + n)
    for block, size, start in ((first, m, 0), (second, n, m)):
        for i in range(size):
            for j in range(size):
                whole[start + i, start + j] = block[i, j]
    return whole
