"""A matrix of plants from records of several inputs and outputs, experiments and gaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory._truth import Truth
from compensator_theory.errors import InputError, UndecidedError
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._blas_threads import one_blas_thread
from rcac_numeric.arrays._validation import interval, number
from rcac_numeric.arrays._values import Value
from rcac_numeric.identification._joint_evidence import (
    Names,
    channel_delay_bounds,
    channel_gain_bounds,
    effect_gates,
    effect_of,
    gain_gates,
    stability_gates,
)
from rcac_numeric.identification._joint_fits import (
    Channel,
    JointFit,
    joint_fit,
    joint_residual,
    with_values_before,
)
from rcac_numeric.identification._joint_records import (
    Inputs,
    JointRecord,
    experiment_starts,
    inputs_of,
    joint_record,
    matrix_signal,
)
from rcac_numeric.identification._joint_search import JointSearch, bic_difference
from rcac_numeric.identification._joint_stability import LIMIT, OPEN_LIMIT, unstable_root
from rcac_numeric.identification._prediction_error import ODDS, answers, leads
from rcac_numeric.identification._process import ROUNDS, scalar_model
from rcac_numeric.identification._process_evidence import (
    Gate,
    dead_time_interval,
    undecided_direction,
)
from rcac_numeric.identification._process_search import MANY, WORSE
from rcac_numeric.identification._scalar_record import ScalarModel

SHORTEST_TEST = 100  # steps of a test of feedback


@dataclass(frozen=True, eq=False)
class ProcessMatrix(Value, Truth):
    """y_i = sum over j of q^-delay_ij B_ij/A_ij u_j + level + noise_i, with its evidence.

    Attributes
    ----------
    entries : tuple of rows of ScalarModel or None
        `entries[i][j]` from u_j to y_i; None where the records show no effect.
    noise : tuple of pairs of arrays
        C and D of each output.
    differences : tuple of int
        1 where the noise of an output drifts as a random walk.
    innovations, residuals : tuple of arrays
        Of each output, at the steps where it is there.
    gain_intervals : tuple of rows of (float, float) or None
        Nominal 95 %, of the gain of each entry, over all credible models. With a pole at 1 of the
        slope of y, per second with a sample time, over those with one.
    dead_time_intervals : tuple of rows of (float, float) or None
        Of each entry, over all credible models, widened by `time_skew`: a delay of d steps is a
        dead time of about d to d + 1 steps, where u moves at the rows. In seconds; in steps
        without a sample time.
    criteria : tuple of float
        BIC of each output.
    gates : tuple of Gate
        The tests of all entries, each with its number and limit.
    assumptions : tuple of str
        What was assumed: of missing steps of u, and of entries without effect.
    is_direct : bool
        Whether y(k) may respond to u(k): then an entry of delay 0 begins with b_0.
    sample_time : float or None
        In seconds.
    """

    entries: tuple[tuple[ScalarModel | None, ...], ...]
    noise: tuple[tuple[Array, Array], ...]
    differences: tuple[int, ...]
    innovations: tuple[Array, ...]
    residuals: tuple[Array, ...]
    gain_intervals: tuple[tuple[tuple[float, float] | None, ...], ...]
    dead_time_intervals: tuple[tuple[tuple[float, float] | None, ...], ...]
    criteria: tuple[float, ...]
    gates: tuple[Gate, ...]
    assumptions: tuple[str, ...] = ()
    is_direct: bool = False
    sample_time: float | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """The numbers of outputs and inputs."""
        return len(self.entries), len(self.entries[0])

    @property
    def failed(self) -> tuple[Gate, ...]:
        """The gates that the model did not pass."""
        return tuple(gate for gate in self.gates if not gate.passed)

    @property
    def delays(self) -> tuple[tuple[int | None, ...], ...]:
        """The delays of the entries in steps."""
        return tuple(
            tuple(None if one is None else one.delay for one in row) for row in self.entries
        )

    def response(self, omega: ArrayLike) -> ComplexArray:
        """G(exp(j omega)), shape (len(omega), outputs, inputs); omega in rad/step."""
        z = np.exp(1j * np.atleast_1d(np.asarray(omega, dtype=np.float64)))
        G = np.zeros((len(z), *self.shape), dtype=np.complex128)
        for i, row in enumerate(self.entries):
            for j, one in enumerate(row):
                if one is not None:
                    B, A = one.transfer_function
                    G[:, i, j] = np.polyval(B, z) / np.polyval(A, z) * z**-one.delay
        return G

    @property
    def gain(self) -> Array:
        """G(1): infinite where an entry has a pole at 1."""
        G = np.zeros(self.shape)
        for i, row in enumerate(self.entries):
            for j, one in enumerate(row):
                if one is not None:
                    bottom = float(one.denominator.sum())
                    is_infinite = abs(bottom) < 1e-9 * np.abs(one.denominator).sum()
                    top = float(one.numerator.sum())
                    G[i, j] = np.copysign(np.inf, top) if is_infinite else top / bottom
        return G

    def __str__(self) -> str:
        rows = []
        names = Names(self.shape[1], self.shape[0])
        for i, row in enumerate(self.entries):
            for j, one in enumerate(row):
                pair = f"{names.u(j)} to {names.y(i)}"
                bounds, late = self.gain_intervals[i][j], self.dead_time_intervals[i][j]
                if one is None or bounds is None or late is None:
                    rows.append(f"{pair}: no effect")
                    continue
                gain, interval = self.gain[i, j], f"{bounds[0]:.4g} to {bounds[1]:.4g}"
                words = f"gain {gain:.4g} ({interval})"
                if np.isinf(gain):
                    unit = "second" if self.sample_time else "step"
                    words = f"a pole at 1, slope {interval} per {unit}"
                unit = "s" if self.sample_time else "steps"
                dead_time = f"dead time {late[0]:.4g} to {late[1]:.4g} {unit}"
                rows.append(f"{pair}: order {one.order}, delay {one.delay} ({dead_time}), {words}")
        return "; ".join(rows)


@dataclass(frozen=True, eq=False)
class MatrixSearch:
    """The models of all outputs.

    Attributes
    ----------
    searches : tuple of JointSearch
        Of each output, over the inputs that have an effect on it.
    inputs : Inputs
    assumptions : tuple of str
    is_direct : bool
        Whether y was logged a step before its u, so that delay 0 is a direct feedthrough.
    """

    searches: tuple[JointSearch, ...]
    inputs: Inputs
    assumptions: tuple[str, ...]
    is_direct: bool

    @property
    def names(self) -> Names:
        """The names of the signals."""
        return Names(len(self.inputs.u), len(self.searches))

    @property
    def best(self) -> tuple[JointFit, ...]:
        """The best model of each output."""
        return tuple(one.fits[0] for one in self.searches)

    def gain_unit(self, i: int, j: int) -> float:
        """y_i over u_j in units of the record."""
        return float(self.searches[i].record.unit_y / self.inputs.units[j])


def matrix_search(
    u: ArrayLike, y: ArrayLike, experiments: Sequence[int] | None = None
) -> MatrixSearch:
    """The models of all outputs of a record; raise an error where an output shows no effect."""
    controls, outputs = matrix_signal(u, "u"), matrix_signal(y, "y")
    if len(controls) != len(outputs):
        raise InputError(
            f"u has {len(controls)} steps and y {len(outputs)}; they must be equally long."
        )
    starts = experiment_starts(experiments, len(controls))
    search = _searched(controls, outputs, starts)
    direct = _direct_entries(search)
    if not direct:
        return search
    # u(k + 1) with y(k): the last step of each experiment has no u.
    last = np.array([*starts[1:], len(controls)]) - 1
    earlier = np.delete(controls, list(starts), axis=0)
    starts = tuple(int(k) - i for i, k in enumerate(starts))
    return _searched(earlier, np.delete(outputs, last, axis=0), starts, is_direct=True)


def _searched(
    u: Array, y: Array, starts: tuple[int, ...], *, is_direct: bool = False
) -> MatrixSearch:
    inputs = inputs_of(u, starts)
    names = Names(u.shape[1], y.shape[1])
    searches, words = [], list(inputs.words)
    records = [joint_record(inputs, row, names.y(i)) for i, row in enumerate(y.T)]
    _require_stable(records, names)
    for i, record in enumerate(records):
        search, without = _with_effects(record, i, names)
        searches.append(search)
        words += without
    for j in range(u.shape[1]):
        if not any(j in one.inputs for one in searches):
            raise UndecidedError(
                f"the record shows no effect of {names.u(j)}: excite it more, or leave it out."
            )
    return MatrixSearch(tuple(searches), inputs, tuple(words), is_direct)


def _require_stable(records: Sequence[JointRecord], names: Names) -> None:
    """Raise an error where the plant of an output seems unstable: all models here are stable."""
    is_closed = any(is_controlled(one, j) for one in records for j in range(len(one.u)))
    for i, record in enumerate(records):
        with np.errstate(all="ignore"):
            root = unstable_root(record, LIMIT if is_closed else OPEN_LIMIT)
        if root is not None:
            raise UndecidedError(
                f"the plant of {names.y(i)} seems unstable: a long regression of {names.y(i)} on "
                f"its past and that of u has a root of modulus {abs(root):.4g}, outside the "
                "unit circle. Models of several signals, experiments or gaps are of stable and "
                "integrating plants. identify_process and design take unstable ones from one "
                "record of one input and one output, without gaps, in a stabilised loop."
            )


def _with_past(search: JointSearch) -> JointSearch:
    """The search, or that of its record with the u before each part that the best model shows."""
    for _ in range(ROUNDS if search.fits else 0):
        pays, record = with_values_before(search.record, search.fits[0])
        if pays < ODDS:
            break
        again = JointSearch(record, search.inputs)
        if not again.fits or again.fits[0].bic > search.fits[0].bic - ODDS:
            break
        search = again
    return search


def _with_effects(record: JointRecord, i: int, names: Names) -> tuple[JointSearch, list[str]]:
    """The models of one output over the inputs without which the BIC is larger by the odds.

    Where an effect is small the models without it are searched as those with it.
    """
    inputs, words = list(range(len(record.u))), list[str]()
    search: JointSearch | None = None
    while inputs:
        with np.errstate(all="ignore"):
            search = search or _with_past(JointSearch(record, inputs))
            if not search.fits:
                break
            effects = {j: effect_of(search, search.fits[0], j) for j in inputs}
            weakest = min(inputs, key=lambda j: effects[j])
            others = [j for j in inputs if j != weakest]
            without: JointSearch | None = None
            if others and effects[weakest] < WORSE:
                without = JointSearch(search.record, others)
                if without.fits:
                    effects[weakest] = min(effects[weakest], bic_difference(without, search))
        if effects[weakest] > ODDS:
            return search, words
        words.append(
            f"the entry from {names.u(weakest)} to {names.y(i)} is 0: without it the BIC is larger "
            f"by {effects[weakest]:.3g} only, less than {ODDS:.3g}"
        )
        if without is not None and without.fits:
            without.with_larger(search)
        inputs, search = others, without
    raise UndecidedError(
        f"the record shows no effect of u on {names.y(i)}: "
        + ("; ".join(words) or "no model could be fitted")
        + ". Excite u more, or record longer."
    )


def _direct_entries(search: MatrixSearch) -> list[tuple[int, int]]:
    """The entries in which y(k) responds to u(k): with u(k) the BIC is smaller by the odds.

    Not asked where u may respond to y(k).
    """
    entries = []
    for i, one in enumerate(search.searches):
        record, fit = one.record, one.fits[0]
        earlier = replace(record, u=record.earlier(record.u))
        for channel in fit.channels:
            j = channel.input
            if channel.delay:
                continue
            direction = leads(record.u[j], record.y) if may_respond(record, j) else True
            if direction is False:
                continue
            later = [replace(other, delay=other.delay + 1) for other in fit.channels]
            direct = list(later)
            at = fit.channels.index(channel)
            direct[at] = replace(channel, delay=0, B=np.r_[0.0, channel.B])
            fits = [
                joint_fit(earlier, replace(fit.start, channels=tuple(one)))
                for one in (later, direct)
            ]
            if fits[0] is None or fits[1] is None or fits[0].bic < fits[1].bic + ODDS:
                continue
            if direction is None:
                names = search.names
                raise undecided_direction(names.u(j), names.y(i), fits[0].bic - fits[1].bic)
            entries.append((i, j))
    return entries


def is_controlled(record: JointRecord, j: int) -> bool:
    """Whether an input may respond to y(k)."""
    return may_respond(record, j) and not leads(record.u[j], record.y)


def may_respond(record: JointRecord, j: int) -> bool:
    """Whether y(k) predicts an input."""
    u = record.u[j]
    has_many = len(np.unique(u.round(9))) > max(MANY, record.steps // 20)
    if not has_many or record.steps < SHORTEST_TEST:
        return False
    return answers(u, record.y)


@one_blas_thread()
def identify_process_matrix(
    u: ArrayLike, y: ArrayLike, *, experiments: Sequence[int] | None = None,
    sample_time: float | None = None, time_skew: Sequence[float] = (0.0, 0.0),
) -> ProcessMatrix:  # fmt: skip
    """Identify a plant of several inputs and outputs, over several experiments and gaps.

    Each output has its own Box-Jenkins model: one transfer function of order 3 at most with its
    own delay for each input, and one noise model. Levels, slopes, initial states and, where it
    pays, one sinusoid are fitted for each experiment. Where steps are missing (NaN) the errors are
    those of the Kalman filter of the noise: y is not interpolated. An input without which the BIC
    is not larger by odds of ten
    thousand has no entry. For stable and integrating plants; of one input and output without gaps
    `identify_process` takes unstable ones too.

    Parameters
    ----------
    u, y : arrays of shape (steps, inputs), (steps, outputs)
        NaN where a value is missing, up to half of the steps. A missing u is its expectation from
        its neighbours; after more than 20 missing steps in a row nothing is assumed of u.
    experiments : sequence of int, optional
        The number of steps of each experiment, where the rows are of several one after another.
    sample_time : float, optional
        In seconds.
    time_skew : (float, float)
        The least and the largest time by which u of a row is older than its y, in seconds, or in
        steps without a sample time: that of a `ControllerLog`. It widens the intervals of dead
        times.

    Returns
    -------
    ProcessMatrix
        Of the best BIC. Read `failed` and `assumptions` before you use it.

    Raises
    ------
    InputError
        Where an input is constant or follows from the others, or the record is too short.
    UndecidedError
        Where no input has an effect on an output, or an input has none; or where the plant seems
        unstable: a long regression has a root outside the unit circle, by its 95 % deviation where
        u responds to y.

    Notes
    -----
    Sources: L. Ljung, System Identification (2nd ed. 1999), section 4.2 (several inputs) and 14.3
    (merged data sets); R. H. Jones, Technometrics 22 (1980) 389-395, for the likelihood of a record
    with missing observations.

    Examples
    --------
    >>> import numpy as np
    >>> from scipy.signal import lfilter
    >>> from rcac_numeric.identification import identify_process_matrix
    >>> rng = np.random.default_rng(1)
    >>> u = np.repeat(rng.choice([-1.0, 1.0], (60, 2)), 10, axis=0)
    >>> y = lfilter([0, 0, 0, 0.5], [1, -0.8], u[:, 0]) - lfilter([0, 0.1], [1, -0.9], u[:, 1])
    >>> y += 0.1 * rng.standard_normal(600)
    >>> y[rng.random(600) < 0.1] = np.nan
    >>> model = identify_process_matrix(u, y)
    >>> model.delays, model.gain.round(0), model.failed
    (((2, 0),), array([[ 2., -1.]]), ())
    """
    period = None if sample_time is None else number(sample_time, "sample_time")
    if period is not None and not period > 0:
        raise InputError(f"sample_time = {period:g} must be positive; give it in seconds.")
    skew = interval(time_skew, "time_skew")
    gates: list[Gate] = []
    with np.errstate(all="ignore"):
        search = matrix_search(u, y, experiments)
        for i, (one, fit) in enumerate(zip(search.searches, search.best, strict=True)):
            gates += effect_gates(one, fit, i, search.names)
            gates += gain_gates(one, fit, i, search.names)
            gates += stability_gates(one, fit, i, search.names)
        return process_matrix(search, search.best, tuple(gates), period, skew)


def process_matrix(
    search: MatrixSearch, fits: Sequence[JointFit], gates: tuple[Gate, ...], period: float | None,
    time_skew: tuple[float, float] = (0.0, 0.0),
) -> ProcessMatrix:  # fmt: skip
    """The public model of a fit of each output."""
    entries = tuple(
        tuple(_entry(search, fit, i, j) for j in range(len(search.inputs.u)))
        for i, fit in enumerate(fits)
    )
    units = [one.record.unit_y for one in search.searches]
    return ProcessMatrix(
        entries, tuple((fit.noise.C, fit.noise.D) for fit in fits),
        tuple(fit.noise.differences for fit in fits),
        tuple(fit.e * unit for fit, unit in zip(fits, units, strict=True)),
        tuple(joint_residual(one.record, fit) * unit
              for one, fit, unit in zip(search.searches, fits, units, strict=True)),
        tuple(tuple(_gain_interval(search, fit, i, j, period) for j in range(len(search.inputs.u)))
              for i, fit in enumerate(fits)),
        tuple(tuple(_dead_time(search, fit, i, j, period, time_skew)
                    for j in range(len(search.inputs.u)))
              for i, fit in enumerate(fits)),
        tuple(fit.bic for fit in fits), gates, search.assumptions, search.is_direct, period,
    )  # fmt: skip


def _gain_interval(
    search: MatrixSearch, fit: JointFit, i: int, j: int, period: float | None
) -> tuple[float, float] | None:
    channel = fit.channel(j)
    if channel is None:
        return None
    unit = search.gain_unit(i, j) / (period or 1.0) ** channel.summed
    low, high = channel_gain_bounds(search.searches[i], fit, j)
    return unit * low, unit * high


def _dead_time(
    search: MatrixSearch, fit: JointFit, i: int, j: int, period: float | None,
    skew: tuple[float, float],
) -> tuple[float, float] | None:  # fmt: skip
    if fit.channel(j) is None:
        return None
    first, last = channel_delay_bounds(search.searches[i], fit, j)
    return dead_time_interval(first, last, period, skew, is_direct=search.is_direct)


def _entry(search: MatrixSearch, fit: JointFit, i: int, j: int) -> ScalarModel | None:
    channel: Channel | None = fit.channel(j)
    if channel is None:
        return None
    B = search.gain_unit(i, j) * channel.B
    return scalar_model(B, channel.denominator, channel.delay, search.is_direct)
