"""A plant from one record of a process: model, noise, rivals, intervals and gates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory._truth import Truth
from compensator_theory.errors import InputError, UndecidedError
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._blas_threads import one_blas_thread
from rcac_numeric.arrays._validation import integer, interval, number
from rcac_numeric.identification._box_jenkins import (
    DIFFERENCE,
    ProcessFit,
    residual_of,
    value_before,
)
from rcac_numeric.identification._joint_records import inputs_of, joint_record
from rcac_numeric.identification._joint_stability import (
    OPEN_LIMIT,
    open_loop_gate,
    unstable_root,
)
from rcac_numeric.identification._prediction_error import ODDS
from rcac_numeric.identification._process_evidence import (
    NORMAL,
    Gate,
    bandwidth,
    credible_delays,
    dead_time_interval,
    delay_gate,
    effect_gate,
    feedthrough_gate,
    gain_gate,
    hidden_share,
    jump_gate,
    parameter_covariance,
    sign_gate,
)
from rcac_numeric.identification._process_records import ProcessRecord, process_record
from rcac_numeric.identification._process_search import FEW, ProcessSearch
from rcac_numeric.identification._scalar_record import ScalarModel

FASTEST_POLE = 1e-6  # modulus of a pole below which there is no time constant
ROUNDS, TRIED = 3, 12  # searches for the u before a record, and models that are tried for it


@dataclass(frozen=True, eq=False)
class ProcessModel(ScalarModel, Truth):
    """y = q^-delay B/A u + level (+ slope, sinusoid) + C/(D (1 - q^-1)^i) e, with its evidence.

    Attributes
    ----------
    numerator : array, shape (m,)
        b_1, ..., b_m of B = b_1 q^-1 + ... + b_m q^-m; with direct feedthrough b_0, ..., b_(m-1).
    denominator : array, shape (n + 1,)
        1, a_1, ..., a_n of A.
    delay : int
        Steps beside the one that every strictly proper model has.
    noise : pair of arrays
        C and D. Where `is_armax`, A stands below the noise too.
    differences : int
        i, 0 or 1: 1 for noise that drifts as a random walk.
    integrators : int
        Poles of A that are 1 exactly.
    is_armax : bool
        Whether A is in the noise model too, as it is for an unstable plant.
    innovation, residual : array, shape (steps,)
        e, and what plant, level and slope leave of y: noise, and a sinusoid; without the last step
        if there is direct feedthrough.
    criterion : float
        BIC: -2 log likelihood, the better of Gauss's and Student's (4 degrees), + parameters log N.
    explained : float
        1 - var(e)/var(y).
    covariance : array
        Of the coefficients of A without poles at 1, and of B.
    gain_interval : (float, float)
        95 %, of `gain`, over all credible models with as many integrators.
    delay_interval : (int, int)
        Of all credible models (odds above one to ten thousand), widened by `time_skew`; in steps.
    dead_time_interval : (float, float)
        The same of the dead time: a delay of d steps is a dead time of about d to d + 1 steps,
        where u moves at the rows. In seconds; in steps without a sample time.
    rivals : tuple of ScalarModel
        The other credible models of these odds, and the credible delays of this one.
    gates : tuple of Gate
        The tests, each with its number and limit.
    spikes : int
        Single values of y that were replaced by the mean of their neighbours.
    sample_time : float or None
        In seconds.
    u_before : float
        The u before the record: that at rest, or the one that the first rows of y show.
    """

    noise: tuple[Array, Array]
    differences: int
    integrators: int
    is_armax: bool
    innovation: Array
    residual: Array
    criterion: float
    explained: float
    covariance: Array
    gain_interval: tuple[float, float]
    delay_interval: tuple[int, int]
    dead_time_interval: tuple[float, float]
    rivals: tuple[ScalarModel, ...]
    gates: tuple[Gate, ...]
    spikes: int = 0
    sample_time: float | None = None
    u_before: float = 0.0

    @property
    def order(self) -> int:
        """The number of poles."""
        return len(self.denominator) - 1

    @property
    def failed(self) -> tuple[Gate, ...]:
        """The gates that the model did not pass."""
        return tuple(gate for gate in self.gates if not gate.passed)

    @property
    def gain(self) -> float:
        """G(1); of an integrating plant the slope of y, per second with a sample time."""
        gain = _gain(self.numerator, self.denominator, self.integrators)
        return gain / (self.sample_time or 1.0) ** self.integrators

    @property
    def poles(self) -> ComplexArray:
        """The poles in z, those at 1 last."""
        free = np.roots(_without_integrators(self.denominator, self.integrators))
        return np.concatenate([free, np.ones(self.integrators)])

    @property
    def pole_deviations(self) -> Array:
        """The standard deviation of each of `poles`; 0 for those at 1."""
        A = _without_integrators(self.denominator, self.integrators)
        poles, n = np.roots(A), len(A) - 1
        slope = np.polyval(np.polyder(A), poles) if n else np.ones(0)
        by = -(poles[:, None] ** np.arange(n - 1, -1, -1)) / slope[:, None]
        squares = np.einsum("pi,ij,pj->p", by, self.covariance[:n, :n], by.conj())
        return np.concatenate([np.sqrt(np.maximum(squares.real, 0)), np.zeros(self.integrators)])

    @property
    def dead_time(self) -> float:
        """`delay` in seconds; in steps without a sample time."""
        return self.delay * (self.sample_time or 1.0)

    @property
    def time_constants(self) -> tuple[tuple[float, float, float], ...]:
        """Of each positive real pole in the circle -h/log(p) and its 95 % interval; in seconds.

        In steps without a sample time.
        """
        h = self.sample_time or 1.0
        rows: list[tuple[float, float, float]] = []
        for pole, deviation in zip(self.poles, self.pole_deviations, strict=True):
            if abs(pole.imag) > 1e-9 or not FASTEST_POLE < pole.real < 1 - 1e-12:
                continue
            low, high = pole.real - NORMAL * deviation, pole.real + NORMAL * deviation
            least = -h / np.log(low) if low > FASTEST_POLE else 0.0
            most = -h / np.log(high) if high < 1 else np.inf
            rows.append((float(-h / np.log(pole.real)), float(least), float(most)))
        return tuple(sorted(rows, reverse=True))

    def __str__(self) -> str:
        pole = " with a pole at 1" if self.integrators else ""
        pole += " and direct feedthrough" if self.is_direct else ""
        low, high = self.gain_interval
        unit = " s" if self.sample_time else " steps"
        of_delay = " to ".join(f"{one:.4g}" for one in self.dead_time_interval) + unit
        return (
            f"order {self.order}{pole}, delay {self.delay}, gain {self.gain:.4g} "
            f"({low:.4g} to {high:.4g}), dead time {self.dead_time:.4g}{unit} ({of_delay})"
        )


@one_blas_thread()
def identify_process(
    u: ArrayLike, y: ArrayLike, *, sample_time: float | None = None, delay: int | None = None,
    time_skew: Sequence[float] = (0.0, 0.0),
) -> ProcessModel:  # fmt: skip
    """Identify a plant from the record of a process with drifts, jumps, walks and spikes.

    Box-Jenkins models of order 1 to 4 by prediction errors, with noise of order 2 at most that
    drifts or not, one sinusoid and a slope; of an unstable plant ARMAX. No step of the record is
    dropped: the initial state is fitted, and u before the record is constant, as at rest or, where
    u moves more than three times and the first rows of y show it, another value. Direct
    feedthrough, y(k) responding to u(k), is part of the model where it pays odds of ten thousand
    and u does not respond to y(k).
    The search begins at every delay up
    to a sixth of the record (1000 at most), a grid of poles and three noise filters, by least
    squares and, where errors have heavy tails, with Student's weights. BIC ranks the models, by
    the better of Gauss's and Student's likelihood, the latter no sharper than the rounding of y;
    the best ones lose coefficients and poles that the record does not show. What is within odds of
    one to ten thousand of the best is credible, and gates say what the record leaves open.

    Parameters
    ----------
    u, y : arrays of shape (steps,) or (steps, 1)
        Of an open or of a closed loop. A step test must begin before its step.
    sample_time : float, optional
        In seconds, for dead time and time constants.
    delay : int, optional
        Known dead time in steps; a record with direct feedthrough is refused then.
    time_skew : (float, float)
        The least and the largest time by which u of a row is older than its y, in seconds, or in
        steps without a sample time: that of a `ControllerLog`. (0, sample_time) where u moves
        between two rows. It widens the intervals of delay and dead time.

    Returns
    -------
    ProcessModel
        Of the best BIC. Read `failed` before you use it: `design` refuses a log of which a gate
        failed.

    Raises
    ------
    InputError
        Where u or y is constant, the record is shorter than 30 steps, or y is explained as well
        without u.

    Notes
    -----
    Sources: G. E. P. Box and G. M. Jenkins, Time Series Analysis (1970), chapter 11; L. Ljung,
    System Identification (2nd ed. 1999), sections 4.3 and 10.2; E. J. Hannan and J. Rissanen,
    Biometrika 69 (1982) 81-94; G. H. Golub and V. Pereyra, SIAM Journal on Numerical Analysis 10
    (1973) 413-432, for what is projected out.

    Examples
    --------
    >>> import numpy as np
    >>> from scipy.signal import lfilter
    >>> from rcac_numeric.identification import identify_process
    >>> rng = np.random.default_rng(1)
    >>> u = np.repeat(rng.choice([-1.0, 1.0], 80), 10)
    >>> y = lfilter([0] * 6 + [0.5], [1, -0.8], u) + np.cumsum(0.05 * rng.standard_normal(800))
    >>> y[400:] += 8.0
    >>> model = identify_process(u, y, sample_time=2.0)
    >>> low, high = model.gain_interval
    >>> model.dead_time, bool(low < 2.5 < high), model.differences, model.failed
    (10.0, True, 1, ())
    """
    period = None if sample_time is None else number(sample_time, "sample_time")
    if period is not None and not period > 0:
        raise InputError(f"sample_time = {period:g} must be positive; give it in seconds.")
    known = None if delay is None else integer(delay, "delay")
    skew = interval(time_skew, "time_skew")
    search = search_of(u, y, known)
    fit = search.fits[0]
    effect = effect_gate(search, fit)
    require_effect(effect, search)
    gates = (effect, *gates_without_controller(search, fit), gain_gate(search, fit))
    gates = (*gates, sign_gate(search, fit, bandwidth(fit) / 3))
    return process_model(search, fit, gates, period, skew)


def search_of(
    u: ArrayLike, y: ArrayLike, delay: int | None, *, is_commanded: bool = False
) -> ProcessSearch:
    """The models of a record; raise an error where there are none.

    Where y(k) responds to u(k), those of y(k) and u(k + 1). `is_commanded`: of a closed loop, by
    its command.
    """
    record = process_record(u, y)
    if delay is not None and delay > record.steps // 2:
        raise InputError(
            f"delay = {delay} is more than half of the {record.steps} steps of the record."
        )
    search = _searched(record, delay)
    if not search.fits:
        raise InputError("no model could be fitted to the record: record longer, or excite u more.")
    feedthrough = feedthrough_gate(search, search.fits[0], is_commanded=is_commanded)
    if feedthrough is None or feedthrough.passed:
        return search
    if delay is not None:
        raise InputError(
            f"delay = {delay}, and y(k) responds to u(k): {feedthrough.words}. Leave the delay "
            "out, or log y before u is applied."
        )
    earlier = process_record(np.ravel(u)[1:], np.ravel(y)[:-1])
    direct = _searched(earlier, None, is_direct=True)
    if not direct.fits:
        return search
    again = feedthrough_gate(direct, direct.fits[0])
    if again is not None and not again.passed:
        raise InputError(
            "y of a row responds to u of a later row: y was logged two steps or more after its u. "
            "Pair y[:-2] with u[2:], or log y before u is applied."
        )
    return direct


def _searched(
    record: ProcessRecord, delay: int | None, *, is_direct: bool = False
) -> ProcessSearch:
    """The models of a record, and of the u before it that they show.

    With dead time or slow poles the first rows answer to it. One number is all that they show, and
    a record of few moves not even that: there any disturbance of its first rows would be one.
    """
    with np.errstate(all="ignore"):
        search = ProcessSearch(record, delay, is_direct=is_direct)
        for _ in range(ROUNDS if record.moves > FEW else 0):
            before = _u_before(search)
            if not before:
                break
            moved = search.record.counted_from(before)
            again = ProcessSearch(moved, delay, is_direct=is_direct)
            if not again.fits or again.fits[0].bic > search.fits[0].bic - ODDS:
                break
            search = again
    return search


def _u_before(search: ProcessSearch) -> float:
    """The u before the record by which a model becomes the most credible; 0 where none pays.

    A wrong best model hides it, so that the best of each kind are tried, credible or not.
    """
    least, before = search.fits[0].bic + ODDS if search.fits else 0.0, 0.0
    for fit in search.kinds(TRIED):
        pays, value = value_before(search.record, fit)
        if pays >= ODDS and fit.bic - pays < least:
            least, before = fit.bic - pays, value
    return before


def require_effect(effect: Gate, search: ProcessSearch) -> None:
    """Raise an error where y does not respond to u, or grows by itself."""
    if effect.passed:
        return
    record = search.record
    inputs = inputs_of(record.u[:, None], (0,))
    with np.errstate(all="ignore"):
        root = unstable_root(joint_record(inputs, record.y, "y"), OPEN_LIMIT)
    if root is not None and not search.is_closed:
        raise UndecidedError(
            "the plant seems unstable, in an open loop: a long regression of y on its past and "
            f"that of u has a root of modulus {abs(root):.4g}, outside the unit circle, and y "
            "grows whatever u does. Stabilise it by any controller, move the command or add a "
            "dither to u, and record that loop."
        )
    raise UndecidedError(f"the record shows no effect of u on y: {effect.words}. {effect.advice}")


def gates_without_controller(search: ProcessSearch, fit: ProcessFit) -> tuple[Gate, ...]:
    """The gates that need no controller, after the effect of u."""
    jumps, late = jump_gate(search, fit), delay_gate(search, fit)
    gates = (late,) if jumps is None else (jumps, late)
    if fit.is_unstable or search.is_closed:
        return gates
    record = search.record
    return (*gates, open_loop_gate(record.u, record.y, fit.delay, fit.e, fit.parameters))


def process_model(
    search: ProcessSearch, fit: ProcessFit, gates: tuple[Gate, ...], period: float | None,
    time_skew: tuple[float, float] = (0.0, 0.0),
) -> ProcessModel:  # fmt: skip
    """The public model of a fit."""
    record = search.record
    unit_u, unit_y = record.units
    gain_unit = unit_y / unit_u
    late = credible_delays(search, fit)
    rivals = [
        scalar_model(gain_unit * one.B, one.denominator, one.delay, search.is_direct)
        for one in search.distinct if one is not fit
    ]  # fmt: skip
    rivals += [
        scalar_model(gain_unit * B, fit.denominator, steps, search.is_direct)
        for B, steps in late if steps != fit.delay
    ]  # fmt: skip
    plain = scalar_model(gain_unit * fit.B, fit.denominator, fit.delay, search.is_direct)
    alike = [fit, *(one for one in search.distinct if one.summed == fit.summed)]
    scale = gain_unit / (period or 1.0) ** fit.summed
    bounds = [_gain_bounds(search, one) for one in alike if one.is_unstable == fit.is_unstable]
    interval = sorted((scale * min(low for low, _ in bounds),
                       scale * max(high for _, high in bounds)))  # fmt: skip
    units = np.concatenate([np.ones(fit.order), np.full(len(fit.B), gain_unit)])
    covariance = parameter_covariance(record, fit) * units * units[:, None]
    y = record.y
    return ProcessModel(
        plain.numerator, plain.denominator, plain.delay, (fit.noise.C, fit.noise.D),
        fit.noise.differences, int(fit.summed), fit.armax, fit.e * unit_y,
        residual_of(record, fit) * unit_y, fit.bic,
        1 - float(np.mean(fit.e**2)) / float(np.var(y)), covariance,
        (interval[0], interval[1]),
        *_delay_intervals(search, fit, [steps for _, steps in late], period, time_skew),
        tuple(rivals), gates,
        record.spikes, period, record.rest, is_direct=plain.is_direct,
    )  # fmt: skip


def _delay_intervals(
    search: ProcessSearch, fit: ProcessFit, delays: Sequence[int], period: float | None,
    skew: tuple[float, float],
) -> tuple[tuple[int, int], tuple[float, float]]:  # fmt: skip
    """The intervals of the delay in steps and of the dead time, in seconds with a sample time.

    A dead time shorter than the delays is possible where the first coefficient of a model is too
    small to show.
    """
    h, record = period or 1.0, search.record
    models = [*((one, one.delay) for one in search.distinct), *((fit, steps) for steps in delays)]
    hidden = {id(one): _hidden_share(record, one) for one, _ in models}
    last = max(steps for _, steps in models)
    first = min(steps - hidden[id(one)] for one, steps in models)
    interval = dead_time_interval(first, last, period, skew, is_direct=search.is_direct)
    earlier = min(steps for _, steps in models) - int(search.is_direct) + skew[0] / h
    in_steps = max(int(np.floor(earlier)), 0), max(int(np.ceil(interval[1] / h - 1e-9)) - 1, 0)
    return in_steps, interval


def _hidden_share(record: ProcessRecord, fit: ProcessFit) -> float:
    """The steps before the first coefficient of B in which a response may begin unseen."""
    variance = float(parameter_covariance(record, fit)[fit.order, fit.order])
    return hidden_share(float(fit.B[0]), variance, fit.order)


def scalar_model(B: Array, A: Array, delay: int, is_earlier: bool) -> ScalarModel:
    """A model; where y was paired with the u of the row after, delay 0 is a feedthrough."""
    if not is_earlier:
        return ScalarModel(B, A, delay)
    return ScalarModel(B, A, max(delay - 1, 0), is_direct=delay == 0)


def _without_integrators(A: Array, count: int) -> Array:
    for _ in range(count):
        A = np.polydiv(A, DIFFERENCE)[0]
    return A


def _gain(B: Array, A: Array, integrators: int) -> float:
    rest = float(_without_integrators(A, integrators).sum())
    with np.errstate(divide="ignore"):
        return float(np.divide(float(B.sum()), rest))


def _gain_bounds(search: ProcessSearch, fit: ProcessFit) -> tuple[float, float]:
    """The 95 % interval of the gain at rest, or of the slope, in units of the record."""
    A, B = float(fit.A.sum()), float(fit.B.sum())
    by = np.concatenate([np.full(fit.order, -B / A**2), np.full(len(fit.B), 1 / A)])
    variance = by @ parameter_covariance(search.record, fit) @ by
    width = NORMAL * float(np.sqrt(max(variance, 0.0)))
    return B / A - width, B / A + width
