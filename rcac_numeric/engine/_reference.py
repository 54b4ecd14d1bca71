"""The closed loop in ball arithmetic: RCAC without rounding errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat
from numpy.typing import ArrayLike

from compensator_theory._truth import Truth
from compensator_theory.errors import InputError
from compensator_theory.polynomials._ball_precision import ball_precision
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import integer, real_array, signal_array
from rcac_numeric.compiled._controllers import require_parts
from rcac_numeric.compiled._plants import initial_state, require_linear
from rcac_numeric.compiled._updates import require_kind
from rcac_numeric.controllers._bounds import CertifiedBounds, CoefficientBounds
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._weights import SignalWeight, Weight
from rcac_numeric.engine._ball_updates import (
    BallData,
    ball_update,
    balls,
    clamped,
    inside,
    latest,
    normalized,
)
from rcac_numeric.engine._compatibility import AnyController, command_position, require_fit
from rcac_numeric.engine._runs import Run
from rcac_numeric.plants._any_plant import AnyPlant
from rcac_numeric.plants._foreign import as_plant
from rcac_numeric.plants._linear import MATRICES, Plant
from rcac_numeric.plants._saturation import Saturation
from rcac_numeric.plants._schedules import PlantChange, PlantSchedule


class BallPlant:
    """A linear plant or schedule in ball arithmetic, with state x."""

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


class BallController:
    """One controller. A step is `measure`, `control`, `adapt`, `finish` in this order.

    An independent transcription of section 2.3, without the kernel's taps and filters: Phi(k) is
    built from (2.30), filtered as a matrix by (2.40), and theta updated by (2.42)-(2.48) as
    printed.
    """

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
            value[i, 0] = clamped(value[i, 0], -signal.limit, signal.limit, self.k)
        past["derived"].append(value)

    def control(self) -> arb_mat:
        """u(k) = Phi(k) theta(k), (2.29)."""
        u = arb_mat(self.settings.structure.l_u, 1)
        if self.k >= self.settings.k_w:
            u = self._regressor() * self.theta
        self._past["u"].append(u)
        return u if self.settings.fixed is None else u + self._beside(self.settings.fixed)

    def _beside(self, fixed: Compensator) -> arb_mat:
        """Return the output of the parallel fixed compensator, (2.28)."""
        past, v = self._past, arb_mat(fixed.l_u, 1)
        for lag, P in enumerate(fixed.past_u[: self.k], start=1):
            v = v + balls(P) * past["v"][self.k - lag]
        for lag, Q in enumerate(fixed.past_y[: self.k + 1]):
            if Q.any():  # for Q_0 = 0 y(k) may be unknown here
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
        if isinstance(s.bounds, CertifiedBounds):
            self.theta = inside(self.theta, s.bounds, self._update.times, k)
        elif s.bounds is not None:  # "clip" only: `require_supported` refuses "metric"
            rows = zip(self.theta.entries(), *s.bounds.box(s.structure), strict=True)
            theta = [clamped(value, float(low), float(high), k) for value, low, high in rows]
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
            # In the filter form u(k) is unknown here, and N_0 is zero.
            if self.k - i >= self.settings.k_filter and target.numerator[i].any():
                output = output + balls(target.numerator[i]) * self._past[name][self.k - i]
            if i > 0:
                earlier = self._past[f"{name}_f"][self.k - i]
                output = output - balls(target.denominator[i]) * earlier
        self._past[f"{name}_f"].append(output)

    def _weight(self, R: Weight, z: arb_mat) -> arb_mat:
        if isinstance(R, np.ndarray):
            return balls(R)
        # Constant or SignalWeight: `require_supported` refuses functions.
        assert isinstance(R, SignalWeight)
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


@dataclass(frozen=True, eq=False)
class ReferenceRun(Run, Truth):
    """A run in ball arithmetic, rounded once to float64 at the end.

    Attributes
    ----------
    digits : float
        Certified correct digits of the least accurate entry of theta_final, relative to the
        largest entry.
    """

    digits: float = float("nan")

    def __repr__(self) -> str:
        return f"ReferenceRun({self.outcome}, steps={self.steps}, digits={self.digits:.3g})"


def simulate_reference(
    plant: Plant | PlantSchedule,
    settings: ControllerSettings,
    w: ArrayLike,
    *,
    x_0: ArrayLike | None = None,
    digits: int = 250,
) -> ReferenceRun:
    """Run the loop of `simulate` in ball arithmetic with `digits` decimal digits.

    Parameters
    ----------
    plant : Plant or PlantSchedule
    settings, w, x_0
        As for `simulate`; the float64 data are taken as exact. The updates `UD` and
        `Covariance` are the same here.
    digits : int
        Working precision. Balls grow by about one digit every few steps, so a few hundred digits
        serve a few hundred steps.

    Raises
    ------
    InputError
        Where sizes do not fit, or for what the reference does not do: functions as plants or
        weights, several controllers, the sliding window, variable-rate forgetting, resets that
        watch the run, pole reflection, `CoefficientBounds` with method = "metric".
    DivergedError
        Where the balls have lost every digit.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, Step, exogenous, fir_target, iir, simulate_reference,
    ...     standard_plant)
    >>> plant = standard_plant("(q - 0.5)/(q*(q - 0.9))")
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=2), target=fir_target(plant), update=UD(R_theta=1e-20))
    >>> w = exogenous([Step()], steps=20)
    >>> reference = simulate_reference(plant, settings, w)
    >>> reference.digits > 100
    True
    """
    plant = as_plant(plant)
    require_supported(plant, settings)
    require_fit(plant, settings)
    w = signal_array(w, "w", plant.l_w, blocks=plant.blocks)
    bits = int(integer(digits, "digits", at_least=16) * 3.33) + 8
    return _run(plant, settings, w, x_0, bits)


def require_supported(
    plant: AnyPlant, controller: AnyController, saturation: Saturation | None = None
) -> tuple[Plant | PlantSchedule, ControllerSettings]:
    """Raise for settings that the reference does not support."""
    if not isinstance(plant, Plant | PlantSchedule):
        raise InputError(f"the reference needs a linear plant, not {plant!r}.")
    if not isinstance(controller, ControllerSettings):
        raise InputError(
            f"the reference runs one adaptive controller, not a {type(controller).__name__}."
        )
    if saturation is not None:
        raise InputError("the reference runs without saturation.")
    for name in ("R_z", "R_u"):
        if not isinstance(getattr(controller, name), np.ndarray | SignalWeight):
            raise InputError(
                f"the reference does not know {name} as a weight that is a function; leave it out."
            )
    if controller.learning is not None:
        raise InputError("the reference learns no target model; give it one.")
    if controller.reflect_poles:
        raise InputError("the reference does not know reflect_poles; leave it out.")
    bounds = controller.bounds
    if isinstance(bounds, CoefficientBounds) and bounds.method == "metric":
        raise InputError(
            'the reference does not know bounds with method = "metric"; use "clip", or leave them '
            "out."
        )
    R = controller.R_u_unfiltered
    if R.any() and np.linalg.matrix_rank(R) < len(R):
        raise InputError("the reference needs R_u_unfiltered to be positive definite, or zero.")
    require_linear(plant, "reference")
    require_kind(controller, "settings", (ControllerSettings,), "reference")
    require_parts(controller, "reference")
    ball_update(controller.update, controller.l_theta)
    return plant, controller


def _run(
    plant: Plant | PlantSchedule,
    settings: ControllerSettings,
    w: Array,
    x_0: ArrayLike | None,
    bits: int,
) -> ReferenceRun:
    with ball_precision(bits):
        controller, body = BallController(settings), BallPlant(plant, x_0)
    position, l_r = command_position(plant, settings.structure.l_r), settings.structure.l_r
    filter_form = settings.form == "filter"
    y_first = settings.measures_first or filter_form
    record: dict[str, list[arb_mat]] = {name: [] for name in ("u", "y", "z", "theta")}
    unknown = arb_mat(plant.l_u, 1)  # placeholder of u(k) if nothing depends on it
    for k, row in enumerate(w):
        with ball_precision(bits):  # local precision, so that other threads keep theirs
            w_k, r_k = (
                balls(row.reshape(-1, 1)),
                balls(row[position : position + l_r].reshape(-1, 1)),
            )
            body.begin(k)
            if y_first:
                y = body.y(unknown, w_k)
                controller.measure(y, r_k)
            if filter_form:
                controller.adapt(body.z(unknown, w_k))
            record["theta"].append(controller.theta)
            u = controller.control()
            if not y_first:
                y = body.y(u, w_k)
                controller.measure(y, r_k)
            z = body.z(u, w_k)
            if not filter_form:
                controller.adapt(z)
            controller.finish()
            body.advance(u, w_k)
            for name, value in (("u", u), ("y", y), ("z", z)):
                record[name].append(value)

    widths = {"u": plant.l_u, "y": plant.l_y, "z": plant.l_z, "theta": settings.structure.l_theta}
    rounded = {
        name: np.array([[float(b.mid()) for b in v.entries()] for v in values]).reshape(
            len(w), widths[name]
        )
        for name, values in record.items()
    }
    final = controller.theta.entries()
    size = max(abs(float(b.mid())) for b in final) or 1.0
    worst = max(b.rad() for b in final)  # as a ball: the value may underflow float64
    with ball_precision(bits):
        correct = float("inf") if worst == 0 else -float((worst / size).log() / arb(10).log())
    return ReferenceRun(
        plant=plant,
        settings=settings,
        w=w,
        u=rounded["u"],
        y=rounded["y"],
        z=rounded["z"],
        theta=rounded["theta"],
        theta_final=np.array([float(b.mid()) for b in final]),
        stride=1,
        outcome="completed",
        guard_count=0,
        guard_first_step=-1,
        u_applied=rounded["u"],
        x_0=None if x_0 is None else real_array(x_0, "x_0").reshape(-1),
        digits=correct,
    )
