"""Plants with dead time, and the variations within their uncertainty."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, expm, logm

import compensator_theory as exact
from compensator_theory.errors import (
    BudgetError,
    IllConditionedError,
    ImproperError,
    InputError,
    NoSolutionError,
)
from compensator_theory.systems._descriptions import has_states, shape_of
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._balancing import balancing_scales, scaled_states
from rcac_numeric.arrays._validation import (
    instance_of,
    integer,
    items,
    number,
    reads,
    real_array,
    with_checks,
)
from rcac_numeric.arrays._values import Value
from rcac_numeric.plants._foreign import is_nonlinear, plant_of, rounded_once
from rcac_numeric.plants._functions import FunctionPlant
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._problems import exact_realisation
from rcac_numeric.plants._schedules import PlantSchedule
from rcac_numeric.plants._zero_order_hold import zero_order_hold
from rcac_numeric.plants.gallery._continuous import ContinuousPlant
from rcac_numeric.targets._modelling import ModellingInformation
from rcac_numeric.targets._zero_directions import DirectionInformation

MOST_SIGNALS = 4  # inputs and outputs
GAINS = (1e-100, 1e100)  # beyond them squares of signals leave float64
ALIKE = 100.0  # the gain of an output, or of an input, over that of another
MOST_STATES = 40  # beyond it each Riccati equation of the weight grid and peaks takes seconds
LONGEST_DELAY = 60  # steps: theta has two coefficients for each
LOW = 0.02  # rad/sample, where the gain of a plant is read: an integrator has none at 0
FAR = 2000  # steps, after which what grows has outgrown the rest
LOGARITHM = 1e-6  # what a plant in continuous time may miss of the sampled one when it is held
ROUNDING = 1e-9  # of a period of dead time
IMPROPER = (
    "the plant is not strictly proper: y follows u at once. Add the lag of the actuator or of the "
    "sensor."
)


def _range(value: object, name: str) -> tuple[float, float]:
    low, high = (number(one, name) for one in items(value, name))
    if not 0 < low <= 1 <= high:
        raise InputError(f"{name} = ({low:g}, {high:g}) must be factors around 1, (low, high).")
    return low, high


def _factor(value: object, name: str) -> float:
    factor = number(value, name)
    if factor < 1:
        raise InputError(f"{name} = {factor:g} is a factor, and at least 1.")
    return factor


@attrs.frozen(slots=False, kw_only=True, field_transformer=with_checks)
class Uncertainty:
    """Ranges of gain, dead time and time constants of the true plant about the nominal one.

    Parameters
    ----------
    gain : (float, float)
        The least and the largest factor of the gain.
    delay : int
        Steps that the dead time may be longer, or shorter where there are as many.
    time : float
        Factor by which all time constants may be longer or shorter.
    noise : float
        Factor by which the sensor noise may be larger.

    Raises
    ------
    InputError
        Where a factor is out of order.

    Examples
    --------
    >>> from rcac_numeric import Uncertainty
    >>> Uncertainty(gain=(0.5, 2.0)).delay
    1
    """

    gain: tuple[float, float] = attrs.field(default=(0.8, 1.25), metadata=reads(_range))
    delay: int = attrs.field(default=1, metadata=reads(integer))
    time: float = attrs.field(default=1.2, metadata=reads(_factor))
    noise: float = attrs.field(default=3.0, metadata=reads(_factor))


@dataclass(frozen=True)
class Variation:
    """One plant within an uncertainty: its gain, dead time, time constants and noise."""

    name: str = "nominal"
    gain: float | tuple[float, ...] = 1.0  # several: of each input
    delay: int = 0
    time: float = 1.0
    noise: float = 1.0


@dataclass(frozen=True, eq=False)
class DesignPlant(Value):
    """x(k+1) = A x(k) + B (u + d)(k - delay), y_0 = C x; as many outputs as inputs, m.

    Attributes
    ----------
    A, B, C : arrays of shape (n, n), (n, m), (m, n)
    delay : int
        Whole steps of dead time.
    continuous : pair of arrays, or None
        A_c and B_c, per step, with which A and B are sampled; C is the same.
    fraction : float
        What is left of the dead time, in periods; its states are the last m of A.
    sample_time : float or None
        In seconds.
    later : array of int, shape (n, m), or None
        Further steps by which each state is late to each input, where entries differ.
    """

    A: Array
    B: Array
    C: Array
    delay: int = 0
    continuous: tuple[Array, Array] | None = None
    fraction: float = 0.0
    sample_time: float | None = None
    later: NDArray[np.int64] | None = None

    @property
    def longest(self) -> int:
        """Whole steps of the longest dead time."""
        return self.delay + (0 if self.later is None else int(self.later.max()))

    def _parts_of(self, B: Array) -> Iterator[tuple[int, Array]]:
        """The dead times in whole steps, and the part of B for each."""
        if self.later is None:
            yield self.delay, B
        else:
            for more in np.unique(self.later):
                yield self.delay + int(more), np.where(self.later == more, B, 0.0)

    def servo(self, changed: Variation | None = None) -> Plant:
        """The servo problem (2.16)-(2.20) with y = z = e = r - y_0 - v, past u as states.

        The disturbance d enters with u, before the dead time.
        """
        change = Variation() if changed is None else changed
        A, B = self._sampled(change.time)
        n, m = B.shape
        late = m * (self.longest + change.delay)
        chain = np.eye(n + late, k=m)
        chain[:n] = 0.0
        chain[:n, :n] = A
        enters = np.zeros((n + late, m))
        if late:
            enters[-m:] = np.eye(m)
        for steps, part in self._parts_of(B * np.asarray(change.gain)):
            past = m * (steps + change.delay)
            if past:
                chain[:n, n + late - past : n + late - past + m] += part
            else:
                enters[:n] += part
        none = np.zeros((n + late, m))
        C = np.hstack([self.C, np.zeros((m, late))])
        direct = np.hstack([np.eye(m), np.zeros((m, m)), -np.eye(m)])
        return Plant(
            A=chain, B=enters, D_1=np.hstack([none, enters, none]), C=-C, D_2=direct, E_0=direct,
            blocks={"r": m, "d": m, "v": m}, sample_time=self.sample_time,
        )  # fmt: skip

    def response(self, omega: Any) -> ComplexArray:
        """G(exp(j omega)) from u to y_0; shape (len(omega), m, m)."""
        z = np.exp(1j * np.atleast_1d(omega))[:, None, None]
        late = sum(part * z**-steps for steps, part in self._parts_of(self.B))
        return np.asarray(self.C @ np.linalg.solve(z * np.eye(len(self.A)) - self.A, late))

    @property
    def m(self) -> int:
        """The number of inputs, and of outputs."""
        return int(self.B.shape[1])

    @property
    def low_gain(self) -> float:
        """norm(G) at 0.02 rad/sample: the gain at rest, but finite with integrators."""
        return float(np.linalg.norm(self.response(LOW)[0], 2))

    @property
    def gain_at_rest(self) -> float:
        """G(1) of one input and output; infinite where that is not finite in float64."""
        from_rest = np.eye(len(self.A)) - self.A
        if not np.linalg.cond(from_rest) * np.finfo(float).eps < 1:
            return np.inf
        return float((self.C @ np.linalg.solve(from_rest, self.B)).item())

    @property
    def condition(self) -> float:
        """The largest singular value of G at 0.02 rad/sample over the least."""
        return float(np.linalg.cond(self.response(LOW)[0]))

    @property
    def sign(self) -> str:
        """The sign of the final response of y_0 to a step of u, both scalar."""
        # Several poles that are 1 to rounding may be computed inside the circle.
        if self.is_stable and np.isfinite(at_rest := self.gain_at_rest):
            return "+" if at_rest > 0 else "-"
        x, drive = np.zeros_like(self.B), 1.0
        for _ in range(FAR):
            x = self.A @ x + drive * self.B
            if (size := np.abs(x).max()) > 1e100:  # state and drive together, to stay in float64
                x, drive = x / size, drive / size
        return "+" if (self.C @ x).item() > 0 else "-"

    @property
    def is_stable(self) -> bool:
        """Whether every pole is inside the unit circle by more than 1e-9."""
        return bool(np.abs(np.linalg.eigvals(self.A)).max(initial=0.0) < 1 - 1e-9)

    def _sampled(self, time: float) -> tuple[Array, Array]:
        """A and B with all time constants so many times as long."""
        if time == 1:
            return self.A, self.B
        continuous = continuous_of(self)
        if continuous is None:
            raise NoSolutionError(
                "the sampled plant has a pole at 0 or on the negative axis, which no continuous "
                "plant gives: its time constants cannot be varied. Give the plant in s with "
                "sample_time, or its dead time separately."
            )
        return _hold_sampled(continuous[0] / time, continuous[1] / time, self.fraction)


def slower_plant(plant: DesignPlant, every: int) -> DesignPlant:
    """The plant with a controller that runs in one of `every` steps, u held between them: exact.

    x(K+1) = A^n x(K) + sum over i of A^(n-1-i) B u(n K + i - d), where u changes once in a row of
    n steps at most if d is no multiple of n: then past u is a state.
    """
    if every == 1:
        return plant
    if plant.later is not None or plant.fraction:
        raise InputError(
            "a slower plant is not available for dead times by entry or fractions of a step."
        )
    late = -(-plant.delay // every)
    first = every - (late * every - plant.delay)  # steps with the earlier of both controls
    power, sums = np.eye(len(plant.A)), [np.zeros_like(plant.B), np.zeros_like(plant.B)]
    for i in range(every - 1, -1, -1):
        sums[int(i >= first)] += power @ plant.B
        power = plant.A @ power
    period = None if plant.sample_time is None else every * plant.sample_time
    if first == every:
        return DesignPlant(*balanced(power, sums[0], plant.C), late, sample_time=period)
    n, m = plant.B.shape
    A = np.block([[power, sums[0]], [np.zeros((m, n + m))]])
    B, C = np.vstack([sums[1], np.eye(m)]), np.hstack([plant.C, np.zeros((len(plant.C), m))])
    return DesignPlant(*balanced(A, B, C), late - 1, sample_time=period)


def continuous_of(plant: DesignPlant) -> tuple[Array, Array] | None:
    """A_c and B_c per step, as given or from the sampled plant; None if there are none."""
    if plant.continuous is not None:
        return plant.continuous
    n = len(plant.A)
    poles = np.linalg.eigvals(plant.A)
    if ((np.abs(poles.imag) < 1e-9) & (poles.real < 1e-6)).any():
        return None
    augmented = np.block([[plant.A, plant.B], [np.zeros((plant.m, n)), np.eye(plant.m)]])
    try:
        logarithm = np.asarray(logm(augmented))
    except ValueError:  # it leaves float64
        return None
    if not np.linalg.norm(expm(logarithm) - augmented) <= LOGARITHM * np.linalg.norm(augmented):
        return None
    if np.abs(logarithm.imag).max(initial=0.0) > 1e-9 * np.abs(logarithm).max(initial=1.0):
        return None
    return logarithm.real[:n, :n], logarithm.real[:n, n:]


def _hold_sampled(A: Array, B: Array, fraction: float) -> tuple[Array, Array]:
    """Sample with a zero-order hold whose input is late by a fraction of a period."""
    if not fraction:
        return zero_order_hold(A, B, 1.0)
    late_A, late_B = zero_order_hold(A, B, fraction)
    rest_A, rest_B = zero_order_hold(A, B, 1 - fraction)
    n, m = B.shape
    whole = np.zeros((n + m, n + m))
    whole[:n, :n], whole[:n, n:] = rest_A @ late_A, rest_A @ late_B
    return whole, np.vstack([rest_B, np.eye(m)])


@np.errstate(all="ignore")  # what leaves float64 is refused
def balanced(A: Array, B: Array, C: Array) -> tuple[Array, Array, Array]:
    """Scale the states by powers of two to similar size.

    Raises
    ------
    IllConditionedError
        If the gain, or an entry of the result, leaves float64.
    """
    # Any point that is no pole of a plant with neat numbers: only the size of y over u matters.
    point = (1 + 1j) * (1 + 2.0**-20) * np.eye(len(A))
    n, m = B.shape
    matrices = A, B, C
    if all(np.isfinite(matrix).all() for matrix in matrices):
        gain = float(np.linalg.norm(C @ np.linalg.solve(point - A, B), 2)) or 1.0
        whole = np.block([[A, B], [C / gain, np.zeros((m, m))]])
        if np.isfinite(whole).all() and np.isfinite(gain):
            scale = balancing_scales(whole)
            # What is common to u and y is left out, so that only the states move.
            scale[n:] = np.exp2(np.round(np.mean(np.log2(scale[n:]))))
            whole = scaled_states(np.block([[A, B], [C, np.zeros((m, m))]]), scale)
            matrices = whole[:n, :n], whole[:n, n:], whole[n:, :n]
            if np.isfinite(whole).all():
                return matrices
    sizes = [size for matrix in matrices for size in (np.abs(matrix[matrix != 0]),) if size.size]
    raise IllConditionedError(
        f"the plant leaves float64: its entries are {min(s.min() for s in sizes):.3g} to "
        f"{max(s.max() for s in sizes):.3g}. Give u and y in units of their ranges, and time in "
        "units of the time constants."
    )


def read_plant(plant: Any, sample_time: float | None, dead_time: Any) -> DesignPlant:
    """Read a plant in any form that `plant_of` reads, with a separate dead time."""
    plant, dead_time = _with_written_dead_time(plant, dead_time)
    if np.ndim(dead_time):
        return _late_by_entry(plant, sample_time, real_array(dead_time, "dead_time"))
    late = number(dead_time, "dead_time")
    if late < 0:
        raise InputError(f"dead_time = {late:g} must not be negative.")
    steps = 0
    if isinstance(plant, PlantSchedule):
        if len(plant.changes) > 1:
            raise InputError(
                "the plant changes while it runs; design for one of its plants, and say how far "
                "the others are by uncertainty=Uncertainty(...)."
            )
        steps, plant = plant.changes[0].delay, plant.changes[0].plant
    if isinstance(plant, Plant):
        plant = plant_of(plant, sample_time=sample_time)
        return _with_dead_time(_of_plant(plant), late, steps)
    if isinstance(plant, ModellingInformation | DirectionInformation):
        raise InputError(
            "modelling information does not suffice to test controllers: cold_start(information, "
            "order=..., stable=...) returns settings; design(ControllerLog(u, y)) identifies a "
            "model."
        )
    if plant is None or isinstance(plant, int | float):
        raise InputError(
            f"plant = {plant!r} is no plant: give a transfer function such as '1/(10*s + 1)', a "
            "Plant, a system of python-control, or a ControllerLog(u, y)."
        )
    if isinstance(plant, FunctionPlant):
        raise InputError(
            "the plant is nonlinear; linearise it where the loop is to work, for instance with "
            "control.linearize(system, x, u), and design for that."
        )
    continuous = _continuous(plant)
    if continuous is None:
        read = plant_of(plant, sample_time=sample_time)
        return _with_dead_time(_of_plant(instance_of(read, "plant", Plant)), late, steps)
    h = _period(sample_time)
    A, B, C = balanced(continuous[0] * h, continuous[1] * h, continuous[2])
    whole = int(np.floor(late / h + ROUNDING))
    fraction = max(late / h - whole, 0.0)
    fraction = fraction if fraction > 2 * ROUNDING else 0.0
    hold_A, hold_B = _hold_sampled(A, B, fraction)
    hold_C = np.hstack([C, np.zeros((len(C), len(hold_A) - len(A)))])
    design_plant = DesignPlant(hold_A, hold_B, hold_C, whole + steps, (A, B), fraction, h)
    return checked_plant(design_plant)


def _with_written_dead_time(plant: Any, dead_time: Any) -> tuple[Any, Any]:
    """Return the rational part of a plant that is written with exp(-theta s), and theta."""
    from compensator_theory.systems._dead_times import with_dead_time
    from compensator_theory.systems._delayed_transfer_functions import DelayedTransferFunction

    G = with_dead_time(plant)
    if not isinstance(G, DelayedTransferFunction):
        return plant, dead_time
    if not G.delay.is_Rational:
        raise InputError(f"the dead time {G.delay} must be a number; substitute one for it.")
    written = float(G.delay)
    if np.ndim(dead_time) or number(dead_time, "dead_time") not in (0.0, written):
        raise InputError(
            f"the plant has the dead time {written:g} s in exp(-{G.delay}*s), and dead_time = "
            f"{dead_time}; give one of them."
        )
    return G.rational, written


def _late_by_entry(plant: Any, sample_time: float | None, late: Array) -> DesignPlant:
    """Realise every output separately, with the dead time of each entry.

    What outputs share, an integrator for instance, each has for its own then.
    """
    G = exact.transfer_matrix(plant) if isinstance(plant, list) else None
    if G is None or str(G.variable) != "s":
        raise InputError(
            "dead_time by entry is for rows of transfer functions in s; in q it stands in the "
            "entries, as in 0.1/(q**3*(q - 0.9))."
        )
    _require_square(*reversed(G.shape))
    if late.shape != G.shape or (late < 0).any():
        raise InputError(
            f"dead_time = {late.tolist()}: give one for each of the {G.shape[0]} x {G.shape[1]} "
            "entries, in seconds, none of them negative."
        )
    h, m = _period(sample_time), len(late)
    steps = np.rint(late / h).astype(np.int64)
    if np.abs(late / h - steps).max() > 1e-6:
        raise InputError(
            f"dead_time = {late.tolist()} is {(late / h).round(4).tolist()} steps, and by entry it "
            "must be whole steps: round it, or choose another sample_time."
        )
    rows = [rounded_once(exact.minimal_realisation([[G[i, j] for j in range(m)]]).realisation)
            for i in range(m)]  # fmt: skip
    if any(D.any() for *_, D in rows):
        raise ImproperError(IMPROPER)
    states = [len(A) for A, *_ in rows]
    A, C = (block_diag(*(row[k] for row in rows)) for k in (0, 2))
    A, B, C = balanced(A * h, np.vstack([B for _, B, *_ in rows]) * h, C)
    least = int(steps.min())
    later = np.repeat(steps - least, states, axis=0)
    design_plant = DesignPlant(
        *_hold_sampled(A, B, 0.0), C, least, (A, B), sample_time=h, later=later
    )
    for pole in np.linalg.eigvals(design_plant.A):
        if abs(pole) < 1 - ROUNDING:
            continue
        moved = sum(part * pole**-steps for steps, part in design_plant._parts_of(design_plant.B))
        modes = np.hstack([design_plant.A - pole * np.eye(len(A)), moved])
        if np.linalg.norm(modes, -2) < ROUNDING * np.linalg.norm(modes, 2):
            raise NoSolutionError(
                f"several outputs share the pole {pole:.4g} of the sampled plant, which does not "
                "decay: with dead times by entry each output is realised separately, and u cannot "
                "move the copies independently. Give the plant in q, with the dead times in its "
                "entries."
            )
    return checked_plant(design_plant)


def _period(sample_time: float | None) -> float:
    if sample_time is None:
        raise InputError(
            "the plant is in continuous time, and RCAC runs in discrete time: say how often it is "
            "sampled, in seconds, by sample_time (at a shell --sample-time). About 10 to 30 "
            "samples in the rise time that the loop is to have are usual."
        )
    h = number(sample_time, "sample_time")
    if not h > 0:
        raise InputError(f"sample_time = {h:g} must be positive, in seconds.")
    return h


def _continuous(plant: Any) -> tuple[Array, Array, Array] | None:
    """A, B and C of a plant in continuous time; None if its time is discrete."""
    if isinstance(plant, ContinuousPlant):
        matrices = plant.A, plant.B, plant.C
        return tuple(np.atleast_2d(np.asarray(m, dtype=np.float64)) for m in matrices)  # type: ignore[return-value]
    plant_in_q = _realised(plant)
    if plant_in_q is None or str(plant_in_q.variable) != "s":
        return None
    if any(entry != 0 for entry in plant_in_q.D):
        raise ImproperError(IMPROPER)
    A, B, C, _ = rounded_once(plant_in_q)
    _require_square(B.shape[1], len(C))
    return A, B, C


def _realised(plant: Any) -> exact.Realisation | None:
    if is_nonlinear(plant):
        return None  # plant_of says what to do
    if not has_states(plant):
        _require_square(*reversed(shape_of(plant)))
    return exact_realisation(plant)


def _of_plant(plant: Plant) -> DesignPlant:
    """The map from u to y of a plant, or from u to -e of a servo problem."""
    _require_square(plant.l_u, plant.l_y)
    if plant.D_0.any() or plant.E_2.any():
        raise ImproperError(
            "the plant is not strictly proper: y or z follows u at once. Put one step of delay at "
            "its input."
        )
    if not np.array_equal(plant.E_1, plant.C):
        raise InputError(
            "z of this plant is not the measured y, but design controls y: give a Plant with "
            "E_1 = C, or use lqg_controller and ControllerSettings."
        )
    m = plant.l_u
    sign = -1.0 if dict(plant.blocks) == {"r": m, "d": m, "v": m} else 1.0
    design_plant = DesignPlant(plant.A, plant.B, sign * plant.C, sample_time=plant.sample_time)
    return checked_plant(design_plant)


def _with_dead_time(plant: DesignPlant, late: float, steps: int) -> DesignPlant:
    """A sampled plant whose dead time is a whole number of steps."""
    h = plant.sample_time or 1.0
    whole = round(late / h)
    if abs(late / h - whole) > 1e-6:
        raise InputError(
            f"dead_time = {late:g} is {late / h:.4g} steps, and of a sampled plant it must be a "
            "whole number; give the plant in s with sample_time."
        )
    return checked_plant(replace(plant, delay=plant.delay + whole + steps))


def refuse_states(plant: DesignPlant) -> None:
    """Raise an error for a plant of too many states."""
    if len(plant.A) > MOST_STATES:
        raise BudgetError(
            f"the plant has {len(plant.A)} states, its float64 matrices have no truncation that is "
            f"near enough, and the Riccati equations of a design take at most {MOST_STATES}. "
            "Reduce its order, for instance by control.balred, and give a dead time "
            "among its states as dead_time."
        )


def checked_plant(plant: DesignPlant) -> DesignPlant:
    """The plant; raise an error where design cannot take it."""
    if len(plant.A) > MOST_STATES and (plant.later is not None or not plant.is_stable):
        refuse_states(plant)  # before anything is solved for a plant that is not truncated
    if plant.longest * plant.m > LONGEST_DELAY:
        raise InputError(
            f"the dead time is {plant.longest} steps, and each of them has two coefficients of the "
            f"controller; at most {LONGEST_DELAY // plant.m} are taken. Sample more slowly."
        )
    if not len(plant.A) or not plant.low_gain > 0:
        raise InputError("u has no effect on y: the plant has gain 0.")
    if not GAINS[0] <= plant.low_gain <= GAINS[1]:
        raise InputError(
            f"the plant has a gain of {plant.low_gain:.3g} at {LOW} rad/step, outside "
            f"{GAINS[0]:g} to {GAINS[1]:g}. Give u and y in units of their ranges, and a "
            "sample_time of the size of the time constants."
        )
    size = np.abs(plant.response(LOW)[0])
    for name, axis in (("output", 1), ("input", 0)):
        gains = np.linalg.norm(size, axis=axis)
        if not gains.max() <= ALIKE * gains.min():
            raise InputError(
                f"{name} {int(gains.argmin()) + 1} of the plant has a gain of {gains.min():.3g}, "
                f"{name} {int(gains.argmax()) + 1} of {gains.max():.3g}: design weighs all "
                "errors alike and all controls alike. Give every signal in units of its own range."
            )
    return plant


def _require_square(l_u: int, l_y: int) -> None:
    if l_u == l_y <= MOST_SIGNALS:
        return
    if l_u > l_y:
        advice = (
            f"of its inputs make {l_y}, u = W v with the shares W of the actuators, and give "
            f"transfer_matrix(G) @ W, or W at the input of a Plant: B @ W. W has shape "
            f"({l_u}, {l_y})."
        )
    elif l_u < l_y:
        advice = (
            "at rest no more outputs can be held than there are inputs: leave rows out, or weigh "
            f"them together, S @ transfer_matrix(G), or S @ C of a Plant. S has shape "
            f"({l_u}, {l_y})."
        )
    else:
        advice = "make a design for each group of signals that hardly act on each other."
    raise InputError(
        f"the plant has {l_u} inputs and {l_y} outputs; design takes as many inputs as outputs, at "
        f"most {MOST_SIGNALS}: {advice}"
    )


def variations(plant: DesignPlant, uncertainty: Uncertainty) -> tuple[Variation, ...]:
    """The nominal plant and its variations, each with one change."""
    low, high = uncertainty.gain
    changes = [Variation()]
    changes += [Variation(f"gain x {f:g}", gain=f) for f in (low, high) if f != 1]
    for i in range(plant.m if plant.m > 1 and low < high else 0):
        gains = tuple(low if i == j else high for j in range(plant.m))
        changes.append(Variation(f"input {i + 1} x {low:g}, others x {high:g}", gain=gains))
    if uncertainty.delay:
        more = uncertainty.delay
        changes.append(Variation(f"delay + {more}", delay=more))
        if less := min(more, plant.delay):
            changes.append(Variation(f"delay - {less}", delay=-less))
    if uncertainty.time != 1 and continuous_of(plant) is not None:
        slow = uncertainty.time
        changes.append(Variation(f"time constants x {slow:.3g}", time=slow))
        changes.append(Variation(f"time constants / {slow:.3g}", time=1 / slow))
    if uncertainty.noise != 1:
        changes.append(Variation(f"noise x {uncertainty.noise:g}", noise=uncertainty.noise))
    return tuple(changes)
