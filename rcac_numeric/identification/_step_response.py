"""Gain, time constants and dead time of a step test, in seconds, with intervals."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory import figures
from compensator_theory.errors import Advice, InputError, UndecidedError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._blas_threads import one_blas_thread
from rcac_numeric.arrays._showing import notebook_of, report_of
from rcac_numeric.arrays._validation import number
from rcac_numeric.arrays._values import Result
from rcac_numeric.identification._joint_stability import open_loop_gate
from rcac_numeric.identification._prediction_error import ODDS
from rcac_numeric.identification._process_evidence import (
    KNOWN,
    Gate,
    bic_of_jumps,
    bic_without_u,
    feedthrough_gate,
    gate_of_jumps,
    require_delay,
    sign_gate_of,
)
from rcac_numeric.identification._process_records import ROBUST, process_record
from rcac_numeric.identification._process_search import FEW, ProcessSearch
from rcac_numeric.identification._scalar_record import scalar_signal
from rcac_numeric.identification._step_intervals import TAIL, StepSamples, step_samples
from rcac_numeric.identification._step_models import (
    REPEATED,
    SHARE,
    StepFit,
    StepSearch,
    errors_of,
    lag_poles,
)
from rcac_numeric.signals._log_signals import require_sample_time

Kind = Literal[
    "first order", "second order", "oscillating", "integrating", "integrating with a lag"
]
Interval = tuple[float, float]
# Of an interval of the likelihood. Structure, noise model and jumps are chosen by the same data: on
# the 134 results of the seeds 5300 to 5449 of the benchmark it held 83 % of the gains.
WIDENED = 1.5
NORMAL = 1.959964  # standard deviations of a 95 % interval
LOWEST = 4.0  # over the steps of a record: its lowest frequency, in rad/step
RIPPLE = 8.0  # robust standard deviations of the noise of u: a move
MOST_MOVES = 20  # of a noisy u
QUIET = 0.05  # of the standard deviation of u: its noise at most
RUN, RESOLVED, SLOPE = 0.05, 5, 0.05  # of a limit: share of rows, rows of the rise, share of range
OVERSHOOT = 0.7  # damping below which the response has one of 5 % and more
PERIODS = 20  # control periods in the residence time


@runtime_checkable
class LogOfSignals(Protocol):
    """A log: u, y and their sample time, as `ControllerLog` has them."""

    @property
    def u(self) -> Any: ...
    @property
    def y(self) -> Any: ...
    @property
    def sample_time(self) -> float | None: ...


@dataclass(frozen=True, eq=False)
class StepResponse(Result):
    """K e^(-L s)/((T_1 s + 1)(T_2 s + 1)) or its kin, from a step test; times in seconds.

    Intervals are of 95 %, over all structures and noise models that the record supports. Without a
    sample time, times are in steps.

    Attributes
    ----------
    kind : str
        "first order", "second order", "oscillating" (damping below 0.7), "integrating" or
        "integrating with a lag".
    gain : float
        K; of an integrating plant the slope of y, in units of y per second and unit of u.
    gain_interval : (float, float)
        Infinite at one end where the record does not show that y settles.
    dead_time : float
        L, from the row at which u moves.
    dead_time_interval : (float, float)
    time_constants : tuple of (value, low, high)
        T_1 >= T_2; of complex poles none.
    damping, natural_frequency : (value, low, high) or None
        zeta and omega_n in rad/s, of complex poles.
    residence_time : (value, low, high)
        L + T_1 + T_2, or L + 2 zeta/omega_n, which hardly depends on the structure.
    operating_point : (float, float)
        u and y before the first move.
    slope : float
        Of y without u, per second; 0 if the record does not show one.
    is_moving : bool
        Whether y moves before u does, from an earlier move; that part is fitted beside.
    moves : int
        The number of moves of u.
    first_move : float
        The time of the first.
    residual : float
        Standard deviation of the one-step prediction errors, in units of y.
    noise : str
        "white", "coloured" or "drifting": of what the model leaves of y.
    explained : float
        1 - var(y - response)/var(y).
    credible_kinds : tuple of (str, float)
        The kinds and how much worse their BIC is; odds are exp(-half of it).
    gain_deviation : float
        Standard deviation of log abs(G) at 1/residence time, or the lowest frequency that the
        record shows.
    gates : tuple of Gate
        Passed, each with its number and limit.
    jumps : tuple of (float, float)
        Time and size of level jumps of y that are not the plant's.
    u_noise : float
        Standard deviation of the noise of u that was averaged.
    spikes : int
    sample_time : float or None
    u, y, response : arrays, shape (steps,)
        The record, and the model's y.
    """

    kind: Kind
    gain: float
    gain_interval: Interval
    dead_time: float
    dead_time_interval: Interval
    time_constants: tuple[tuple[float, float, float], ...]
    damping: tuple[float, float, float] | None
    natural_frequency: tuple[float, float, float] | None
    residence_time: tuple[float, float, float]
    operating_point: Interval
    slope: float
    is_moving: bool
    moves: int
    first_move: float
    residual: float
    noise: str
    explained: float
    credible_kinds: tuple[tuple[str, float], ...]
    gain_deviation: float
    gates: tuple[Gate, ...]
    jumps: tuple[tuple[float, float], ...]
    u_noise: float
    spikes: int
    sample_time: float | None
    u: Array
    y: Array
    response: Array

    @property
    def plant(self) -> str:
        """The transfer function in s without its dead time, as `design` reads it."""
        denominator = " * ".join(f"({T:.6g}*s + 1)" for T, _, _ in self.time_constants if T > 0)
        if self.damping is not None and self.natural_frequency is not None:
            zeta, omega = self.damping[0], self.natural_frequency[0]
            denominator = f"({1 / omega**2:.6g}*s**2 + {2 * zeta / omega:.6g}*s + 1)"
        if self.kind.startswith("integrating"):
            denominator = f"s * {denominator}" if denominator else "s"
        if " * " in denominator:
            denominator = f"({denominator})".replace(" * ", "*")
        return f"{self.gain:.6g}/{denominator}"

    @property
    def unit(self) -> str:
        """The unit of times."""
        return "s" if self.sample_time else "steps"

    @property
    def control_period(self) -> float:
        """A sample time for a controller: a multiple of the record's, 20 in the residence time."""
        h = self.sample_time or 1.0
        return h * max(1, int(self.residence_time[0] / PERIODS / h))

    @property
    def gain_factors(self) -> Interval:
        """95 % limits of abs(G) around 1/residence time, over that of the model."""
        factor = float(np.exp(NORMAL * self.gain_deviation))
        return 1 / factor, factor

    def delay_error(self, period: float) -> int:
        """The largest error of the dead time by its interval, in steps of a sample time."""
        low, high = self.dead_time_interval
        return max(1, int(np.ceil(max(high - self.dead_time, self.dead_time - low) / period)))

    def _sheet(self) -> Any:
        from rcac_numeric.reports._step_response import step_response_sheet

        return step_response_sheet(self)

    def report(self) -> str:
        """The report: plant, operating point, residual, evidence, next step."""
        return report_of(self._sheet())

    def plot(self) -> figures.Figure:
        """The record with the response of the model; the dead time is marked."""
        from rcac_numeric.plots._step_response import plot_step_response

        return plot_step_response(self)

    def _repr_html_(self) -> str:
        """The report and the picture as HTML for a notebook."""
        return notebook_of(self._sheet(), self.plot)

    def __str__(self) -> str:
        return f"{self.kind}: {self.words}"

    @property
    def words(self) -> str:
        """Gain, time constants and dead time with their intervals."""
        one = "s" if self.sample_time else "step"
        per = f" per {one}" if self.kind.startswith("integrating") else ""
        parts = [f"gain {_words(self.gain, self.gain_interval)}{per}"]
        for i, (T, low, high) in enumerate(self.time_constants):
            name = f"T{i + 1}" if len(self.time_constants) > 1 else "time constant"
            parts.append(f"{name} {_words(T, (low, high))} {self.unit}")
        if self.damping is not None and self.natural_frequency is not None:
            parts.append(f"damping {_words(self.damping[0], self.damping[1:])}")
            omega, low, high = self.natural_frequency
            parts.append(f"natural frequency {_words(omega, (low, high))} rad/{one}")
        parts.append(f"dead time {_words(self.dead_time, self.dead_time_interval)} {self.unit}")
        return ", ".join(parts)


def _words(value: float, interval: Interval) -> str:
    return f"{value:.4g} ({interval[0]:.4g} to {interval[1]:.4g})"


@one_blas_thread()
def identify_step_response(
    u: ArrayLike | LogOfSignals, y: ArrayLike | None = None, *, sample_time: float | None = None
) -> StepResponse:
    """Identify gain, time constants and dead time from a step test, with 95 % intervals.

    K e^(-L s) over T s + 1, (T_1 s + 1)(T_2 s + 1), (s/omega_n)^2 + 2 zeta s/omega_n + 1, s or
    s (T s + 1), with u held between the rows. Each is fitted by prediction errors with white,
    coloured and drifting noise, a slope of y, and an initial response; BIC chooses. An interval is
    1.5 times that of the likelihood over all credible structures (since the data choose them, too):
    that of the dead time counts that a short lag may stand in for it.

    Parameters
    ----------
    u : array, shape (steps,), or ControllerLog
        One step or several, or a log of `read_log`, with y and sample time. The record must begin
        before the first step.
    y : array, shape (steps,), optional
    sample_time : float, optional
        In seconds, of equal steps.

    Raises
    ------
    InputError
        If u or y is constant (a record that begins after its step), rows are missing, u follows y,
        or the record is shorter than 30 steps.
    UndecidedError
        If a gate fails: y is explained as well without u, or by level jumps; the dead time is the
        longest one tried; gain or sign is open; no plant of these orders fits; y stands at a limit.

    Notes
    -----
    Sources: L. Ljung, System Identification (2nd ed. 1999), sections 4.3 and 16.4; K. P. Burnham
    and D. R. Anderson, Model Selection and Multimodel Inference (2002), chapter 4, for intervals
    over several models; K. J. Astrom and T. Hagglund, Advanced PID Control (2006), chapter 2.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.identification import identify_step_response
    >>> t = 2.0 * np.arange(300)
    >>> u = np.where(t < 60, 40.0, 50.0)  # heater, %
    >>> y = 21 + 8 * (1 - np.exp(-np.maximum(t - 60 - 15, 0) / 70))
    >>> y += 0.1 * np.random.default_rng(1).standard_normal(300)
    >>> step = identify_step_response(u, y, sample_time=2.0)
    >>> low, high = step.dead_time_interval
    >>> step.kind, bool(low < 15 < high), round(step.gain, 2)
    ('first order', True, 0.8)
    """
    control, output, period = _signals(u, y, sample_time)
    levels, ripple = _without_ripple(control)
    record = process_record(levels, output)
    record = replace(record, u=record.u - record.u[0])  # at rest before the first move
    _require_range(output)
    with np.errstate(all="ignore"):
        box_jenkins = ProcessSearch(record)
        _require_step(box_jenkins, period)
        noises = tuple(one.noise for one in box_jenkins.fits[:2])
        search = StepSearch(record, noises)
        if not search.fits:
            raise InputError("no model could be fitted: record longer, or step u more.")
        samples = step_samples(record, search.fits)
        gates = _gates(search, box_jenkins, samples)
    failed = [gate for gate in gates if not gate.passed]
    if failed:
        words = "; ".join(f"{gate.name}: {gate.words}" for gate in failed)
        raise UndecidedError(
            f"the record does not determine the plant. Failed: {words}. {failed[0].advice}"
        )
    return _response(control, output, ripple, search, samples, gates, period)


def _signals(
    u: ArrayLike | LogOfSignals, y: ArrayLike | None, sample_time: float | None
) -> tuple[Array, Array, float | None]:
    """U, y and the sample time of arrays or of a log."""
    source, values = "the record", (u, y)
    if y is None:
        if not isinstance(u, LogOfSignals) or hasattr(u, "columns"):
            raise InputError(
                "y is missing: give u and y, or a log, as read_log(FILE) or read_log(DataFrame) "
                "returns it."
            )
        source, values = getattr(u, "source", source), (u.u, u.y)
        missing = int(np.count_nonzero(getattr(u, "missing", ())))
        if missing:
            raise InputError(
                f"{source}: {missing} of {len(u.u)} rows are missing. ",
                Advice("read_log", (("resample", f"{u.sample_time or 1.0:g}"),),
                       "Fill them by interpolation with resample={resample}"),
                "; or cut the log to a part without gaps (log.longest_part()).",
            )  # fmt: skip
        require_sample_time(source, u.sample_time, sample_time)
        if sample_time is None:
            sample_time = u.sample_time
    period = None if sample_time is None else number(sample_time, "sample_time")
    if period is not None and not period > 0:
        raise InputError(f"sample_time = {period:g} must be positive; give it in seconds.")
    return scalar_signal(values[0], "u"), scalar_signal(values[1], "y"), period  # type: ignore[arg-type]


def _without_ripple(u: Array) -> tuple[Array, float]:
    """U with the noise between few large moves averaged, and its standard deviation."""
    moved = np.diff(u)
    spread = ROBUST * float(np.median(np.abs(moved)))
    at = np.nonzero(np.abs(moved) > RIPPLE * spread)[0] + 1
    if not spread > 0 or not 0 < len(at) <= min(MOST_MOVES, len(u) // 10):
        return u, 0.0
    parts = np.split(u, at)
    levels = np.concatenate([np.full(len(part), part.mean()) for part in parts])
    ripple = float(np.std(u - levels))
    return (levels, ripple) if ripple < QUIET * np.std(u) else (u, 0.0)


def _require_range(y: Array) -> None:
    """Refuse a y that rises and then stands at its extreme: a limit of the sensor."""
    steps, size = len(y), float(np.ptp(y))
    for extreme in (y.max(), y.min()):
        is_there = np.concatenate([[False], y == extreme, [False]])
        begins = np.nonzero(is_there[1:] & ~is_there[:-1])[0]
        ends = np.nonzero(is_there[:-1] & ~is_there[1:])[0]
        run = int((ends - begins).argmax())
        length = int(ends[run] - begins[run])
        first = int(begins[run])
        before = y[max(0, first - max(length // 10, 3)) : first]
        rise = np.nonzero(np.abs(y[:first] - extreme) > 0.9 * size)[0]
        is_resolved = len(rise) > 0 and first - rise[-1] >= RESOLVED
        is_steep = len(before) > 2 and abs(before[0] - extreme) > SLOPE * size
        is_steep = is_steep and len(np.unique(before)) >= 3
        is_steep = is_steep and abs(y[first - 1] - extreme) < 0.5 * size
        if length > max(RUN * steps, 4) and is_resolved and is_steep:
            raise UndecidedError(
                f"y stands at {extreme:g} from row {first} on for {length} rows, after a steep "
                "change: a limit of the sensor or of the converter. Repeat with a smaller step, or "
                "cut the record before this row."
            )


def _require_step(search: ProcessSearch, period: float | None) -> None:
    """Refuse a closed loop, and a y that responds in the row of u."""
    if search.is_closed:
        raise InputError(
            "u follows y: the record is of a closed loop, not of a step test. identify_process and "
            "design take it."
        )
    if not search.fits:
        return
    gate = feedthrough_gate(search, search.fits[0])
    if gate is not None:
        require_delay(gate)


def _gates(
    search: StepSearch, box_jenkins: ProcessSearch, samples: StepSamples
) -> tuple[Gate, ...]:
    """The tests of the best fit."""
    record, fit = search.record, search.fits[0]
    bic = fit.bic
    of_jumps = bic_of_jumps(record) if fit.jumps or record.moves <= FEW else np.inf
    difference = min(bic_without_u(record, fit), of_jumps if fit.jumps else np.inf) - bic
    gates = [Gate(
        "effect of u", difference > ODDS, difference, ODDS,
        f"without u the BIC is larger by {difference:.3g}, at least {ODDS:.3g} is required",
        "Make the step larger, or record longer.",
    )]  # fmt: skip
    if record.moves <= FEW:
        gates.append(gate_of_jumps(record.moves, of_jumps - bic))
    last = record.steps / SHARE
    gates.append(Gate(
        "dead time", bool(fit.theta[-1] < last - 1), float(fit.theta[-1]), last,
        f"{fit.theta[-1]:.4g} steps, where 0 to {last:.4g} were tried",
        "The dead time is half of the record: record longer.",
    ))  # fmt: skip
    edge = gate_frequency(fit)
    deviation = gain_deviation(samples, fit.integrates, edge)
    gates.append(Gate(
        "gain", deviation < KNOWN, deviation, KNOWN,
        f"relative standard deviation {deviation:.2g} of abs(G) at {edge:.2g} rad/step, at most "
        f"{KNOWN:.2g} is allowed",
        "Make the step larger, repeat it, or record longer.",
    ))  # fmt: skip
    omega = np.array([edge])
    G = fit.gain * response_at(fit, omega)
    rivals = [one for one in box_jenkins.distinct if one.bic < bic + ODDS]
    others = [one for one in rivals if not np.real(one.response(omega) / G).item() > 0]
    gates.append(sign_gate_of(len(others), edge))
    gates.append(_misfit(fit, bic, box_jenkins, edge))
    gates.append(open_loop_gate(
        record.u, record.y, round(float(fit.theta[-1])), fit.e, fit.parameters
    ))  # fmt: skip
    return tuple(gates)


def _misfit(fit: StepFit, bic: float, box_jenkins: ProcessSearch, edge: float) -> Gate:
    """Whether a model of free coefficients is better, and differs from this one.

    Of a plant of higher order a first or second order is an approximation, which is allowed.
    """
    better = [one for one in box_jenkins.fits[:1] if one.bic < bic - ODDS]
    omega = np.geomspace(edge / 3, edge, 9)
    G = fit.gain * response_at(fit, omega)
    size = max(
        (float(np.max(np.abs(one.response(omega) - G) / np.abs(G))) for one in better), default=0.0
    )
    order = better[0].order if better else 0
    return Gate(
        "misfit", size < KNOWN, size, KNOWN,
        f"a model of order {order} with free zeros fits better and differs by {size:.2g} of "
        f"abs(G), at most {KNOWN:.2g} is allowed" if better else "no model of free order fits "
        "better",
        "The plant is none of first or second order: identify_process and design take the record.",
    )  # fmt: skip


def gate_frequency(fit: StepFit) -> float:
    """1/residence time, in rad/step; at least 4/steps, below which a record shows little.

    Of an integrating plant at most 20/steps: its control is slower than its dead time alone, which
    may be less than a step.
    """
    residence, steps = float(fit.theta[-1]) + fit.structure.lag(fit.theta)[0], len(fit.e)
    least = steps / PERIODS if fit.integrates else 1.0
    return 1 / float(np.clip(residence, least, max(steps / LOWEST, least)))


def response_at(fit: StepFit, omega: Array) -> Array:
    """G(j omega)/K, in steps."""
    S, rho = fit.structure.lag(fit.theta)
    s = 1j * omega
    G = np.exp(-s * fit.theta[-1]) / (rho * (S * s) ** 2 + S * s + 1)
    return np.asarray(G / s if fit.integrates else G)


def gain_deviation(samples: StepSamples, integrates: bool, omega: float) -> float:
    """The standard deviation of log abs(G(j omega)) over the samples."""
    chosen = samples.among(samples.integrates == integrates)
    s = 1j * omega * chosen.sums
    size = np.abs(chosen.gains / (chosen.rhos * s**2 + s + 1))
    relative = chosen.deviations / np.maximum(np.abs(chosen.gains), 1e-300)
    if not (size > 0).all():
        return np.inf
    log = np.log(size)
    mean = chosen.weights @ log
    return float(np.sqrt(chosen.weights @ ((log - mean) ** 2 + relative**2)))


def _kind(fit: StepFit) -> Kind:
    """The kind of plant."""
    if fit.structure.lag(fit.theta)[1] > 1 / (2 * OVERSHOOT) ** 2:
        return "oscillating"
    return fit.structure.name  # type: ignore[return-value]


def _response(
    u: Array, y: Array, ripple: float, search: StepSearch, samples: StepSamples,
    gates: tuple[Gate, ...], period: float | None,
) -> StepResponse:  # fmt: skip
    """The public result, in seconds and units of the record."""
    record, fit, h = search.record, search.fits[0], period or 1.0
    unit_u, unit_y = record.units
    scale = unit_y / unit_u / (h if fit.integrates else 1.0)
    S, rho = fit.structure.lag(fit.theta)
    alike = samples.among(samples.integrates == fit.integrates)
    low, high = sorted(scale * one for one in alike.gain_interval())
    gain = scale * fit.gain
    if not fit.integrates and samples.weights[samples.integrates].sum() > TAIL:
        low, high = (low, np.inf) if gain > 0 else (-np.inf, high)  # y may go on rising
    L = h * float(fit.theta[-1])
    least, most = _widened(L, samples.interval(h * samples.dead_times))
    lags: list[tuple[float, float, float]] = []
    damping = frequency = None
    if rho > REPEATED:
        complex_ones = alike.among(alike.orders == 2)
        root = np.sqrt(np.maximum(complex_ones.rhos, 1e-12))
        damping = _within(1 / (2 * np.sqrt(rho)), complex_ones.interval(1 / (2 * root)))
        omega = 1 / np.maximum(root * complex_ones.sums * h, 1e-300)
        frequency = _within(1 / (np.sqrt(rho) * S * h), complex_ones.interval(omega))
    else:
        values = [-h / float(pole.real) for pole in lag_poles(S, rho)]
        if fit.structure.is_equal:
            values = [h * S / 2] * 2
        lags = [
            _within(value, alike.interval(h * lag))
            for value, lag in zip(values, alike.lags, strict=False)
        ]
    errors = errors_of(record, fit)
    response = y[0] + unit_y * errors.deterministic(fit.theta, fit.free)
    sizes = unit_y * fit.free[1 + fit.slope :]
    jumps = tuple((h * k, float(size)) for k, size in zip(fit.jumps, sizes, strict=False))
    slope = unit_y * float(fit.free[1]) / (h * (record.steps - 1)) if fit.slope else 0.0
    kinds: dict[str, float] = {}
    for one in search.fits:
        if one.bic - fit.bic < ODDS:
            kinds.setdefault(_kind(one), one.bic - fit.bic)
    at = int(np.nonzero(np.diff(record.u))[0][0]) + 1
    total = samples.dead_times + samples.sums
    residence = _within(h * (fit.theta[-1] + S), samples.interval(h * total))
    colours = "drifting" if fit.noise.differences else "coloured"
    return StepResponse(
        kind=_kind(fit), gain=gain, gain_interval=_widened(gain, (low, high)),
        dead_time=L, dead_time_interval=(max(least, 0.0), most),
        time_constants=tuple(lags), damping=damping, natural_frequency=frequency,
        residence_time=residence, operating_point=(float(u[:at].mean()), float(response[at - 1])),
        slope=slope, is_moving=fit.is_moving, moves=record.moves, first_move=h * at,
        residual=unit_y * float(np.std(fit.e)),
        noise="white" if fit.noise.orders == (0, 0, 0) else colours,
        explained=1 - float(np.var(y - response)) / float(np.var(y)),
        credible_kinds=tuple(kinds.items()),
        gain_deviation=gain_deviation(samples, fit.integrates, gate_frequency(fit)),
        gates=gates, jumps=jumps,
        u_noise=ripple, spikes=record.spikes, sample_time=period, u=u, y=y, response=response,
    )  # fmt: skip


def _widened(value: float, interval: Interval) -> Interval:
    """The calibrated interval of a value, which it holds."""
    low, high = min(interval[0], value), max(interval[1], value)
    return value - WIDENED * (value - low), value + WIDENED * (high - value)


def _within(value: float, interval: Interval) -> tuple[float, float, float]:
    """A positive value and its calibrated interval, whose lower end stays positive."""
    value, low = float(value), min(interval[0], float(value))
    low = value * (low / value) ** WIDENED if value > 0 else low
    return value, low, _widened(value, interval)[1]
