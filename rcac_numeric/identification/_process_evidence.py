"""What a record says of a model: whether u is needed, how well the gain is known, what is left."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.signal import fftconvolve, lfilter
from scipy.stats import chi2

from compensator_theory._truth import Truth
from compensator_theory.errors import InputError, UndecidedError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.identification._box_jenkins import (
    ONE,
    NoiseModel,
    ProcessFit,
    Start,
    fitted,
    inverse_information,
    later,
    noise_start,
    start_of,
    value_before,
    weighted_fit,
)
from rcac_numeric.identification._delay_scan import scanned_again
from rcac_numeric.identification._prediction_error import ODDS, leads
from rcac_numeric.identification._process_records import DEGREES, ProcessRecord
from rcac_numeric.identification._process_search import (
    FEW,
    NOISES,
    RICHER,
    SIMPLE,
    ProcessSearch,
    has_many_values,
)

SURE = float(np.sqrt(np.log(1e4)))  # P(abs(x) > SURE) = 1e-4, complex Gaussian x of E abs(x)^2 = 1
KNOWN = 1 / SURE  # largest relative standard deviation of the gain around the crossover
MOST_JUMPS = 3
NORMAL = 1.959964  # standard deviations of a 95 % interval
FASTER = 2.0  # standard deviations
MISFIT = 1e-4  # level of the test of e against past u
COLOUR = 8  # order of the autoregression of e
LAGS = 25  # of u beyond the delay, in that test
MOST_DELAYS = 8  # of a range of credible delays those that are tried
OMEGA = np.geomspace(1e-4, np.pi, 100)


class AnyFit(Protocol):
    """What the evidence reads of a fit, in discrete or in continuous time."""

    @property
    def noise(self) -> NoiseModel: ...
    @property
    def slope(self) -> bool: ...
    @property
    def integrates(self) -> bool: ...
    @property
    def heavy(self) -> bool: ...


@dataclass(frozen=True)
class Gate(Truth):
    """A test that a model of a record must pass before a controller is designed on it.

    Attributes
    ----------
    name : str
        "effect of u", "level jumps", "dead time", "gain", "sign", "rivals", "misfit", "halves" or
        "robustness".
    passed : bool
    value, limit : float
        The statistic, and what it must exceed or stay below.
    words : str
        What was tested, with the numbers.
    advice : str
        What to do where it failed.
    """

    name: str
    passed: bool
    value: float
    limit: float
    words: str
    advice: str

    def __str__(self) -> str:
        return f"{self.name}: {'passed' if self.passed else 'FAILED'} ({self.words})"


def relative_deviation(record: ProcessRecord, fit: ProcessFit, omega: Array) -> Array:
    """sqrt(E abs(dG)^2)/abs(G) from the covariance of A and B, the noise model fitted beside.

    Where e is not white its spectrum, where it is larger than that of white noise, inflates it.
    """
    covariance = parameter_covariance(record, fit)
    if not np.isfinite(covariance).all():
        return np.full(len(omega), np.inf)
    n, m = fit.order, len(fit.B)
    past = np.exp(-1j * omega)
    A, B = np.polyval(fit.A[::-1], past), np.polyval(fit.B[::-1], past) * past
    slopes = [-(past**k) / A for k in range(1, n + 1)] + [past**k / B for k in range(1, m + 1)]
    by = np.stack(slopes, axis=1)  # d log G
    squares = np.real(np.einsum("wi,ij,wj->w", by, covariance, by.conj()))
    return np.asarray(np.sqrt(np.maximum(squares, 0) * inflation(fit.e, omega)))


def parameter_covariance(record: ProcessRecord, fit: ProcessFit) -> Array:
    """The covariance of a_1, ..., a_n, b_1, ..., b_m in record units; infinite if unknown."""
    count = fit.order + len(fit.B)
    return inverse_information(fit.jacobian)[:count, :count] * variance_of(record, fit)


def with_faster_pole(record: ProcessRecord, fit: ProcessFit) -> ProcessFit:
    """The model with its largest pole `FASTER` standard deviations farther out, A and B beside it.

    They are the likeliest ones with that pole, to the first order of the covariance.
    """
    covariance = parameter_covariance(record, fit)
    poles, n = np.roots(fit.A), fit.order
    pole = poles[int(np.abs(poles).argmax())]
    by = -(pole ** np.arange(n - 1, -1, -1)) / np.polyval(np.polyder(fit.A), pole)
    slope = np.real(by * np.conj(pole)) / abs(pole)  # of the modulus
    onto = covariance[:, :n] @ slope
    deviation = float(np.sqrt(max(float(slope @ onto[:n]), 0.0)))
    if not (np.isfinite(covariance).all() and deviation > 0):
        return fit
    moved = np.concatenate([fit.A[1:], fit.B]) + FASTER / deviation * onto
    return replace(fit, A=np.concatenate([ONE, moved[:n]]), B=moved[n:])


def variance_of(record: ProcessRecord, fit: ProcessFit) -> float:
    """The variance of e by which a covariance is scaled; of Student's, that of its estimate."""
    if not fit.heavy:
        return float(np.mean(fit.e**2))
    return record.likelihood(fit.e)[2] ** 2 * (DEGREES + 3) / (DEGREES + 1)


def inflation(e: Array, omega: Array) -> Array:
    """The spectrum of e over its variance, at least 1."""
    X = np.stack([later(e, k) for k in range(1, COLOUR + 1)])
    a = np.linalg.lstsq(X.T, e, rcond=None)[0]
    white = e - a @ X
    total = float(np.var(e))
    if not total > 0:
        return np.ones(len(omega))
    filter_of = np.polyval(np.concatenate([-a[::-1], ONE]), np.exp(-1j * omega))
    return np.asarray(np.maximum(1.0, np.var(white) / np.abs(filter_of) ** 2 / total))


def effect_gate(search: ProcessSearch, fit: ProcessFit) -> Gate:
    """Whether y is explained worse without u, by BIC."""
    difference = bic_without_u(search.record, fit, fit.sinusoid) - fit.bic
    shift = (
        " y(k) predicts u(k): if u was not computed from y, y of a row was logged after its u; "
        "pair y[:-1] with u[1:]." * search.is_closed
    )
    return Gate(
        "effect of u", difference > ODDS, difference, ODDS,
        f"without u the BIC is larger by {difference:.3g}, at least {ODDS:.3g} is required",
        f"Excite u more, or record longer.{shift}",
    )  # fmt: skip


def bic_without_u(record: ProcessRecord, fit: AnyFit, sinusoid: float = 0.0) -> float:
    """The least BIC of models of y alone: noise of order 2 or less, and that of the fit.

    The latter with its slope, and a sinusoid of the frequency given.
    """
    y, values = record.y, []
    starts = [_alone(noise_start(y, orders)) for orders in (*SIMPLE, *NOISES, *RICHER.values())]
    starts.append(_alone(noise_start(y - np.linspace(y[0], y[-1], len(y)), RICHER[0]), True))
    starts.append(_alone(fit.noise, fit.slope or fit.integrates, sinusoid))
    for start in starts:
        alone = fitted(record, start, is_plant_fixed=True)
        if alone is None:
            continue
        if fit.heavy:
            alone = _reweighted(record, alone)
        values.append(alone.bic - float(np.log(record.steps)))  # no coefficient of B
    return min(values, default=np.inf)


def _reweighted(record: ProcessRecord, alone: ProcessFit) -> ProcessFit:
    for _ in range(3):
        again = fitted(
            record, start_of(alone), weights=record.weights(alone.e), is_plant_fixed=True,
            iterations=8,
        )  # fmt: skip
        if again is None or again.bic >= alone.bic:
            break
        alone = again
    return alone


def _alone(noise: NoiseModel, slope: bool = False, sinusoid: float = 0.0) -> Start:
    return Start(ONE, np.zeros(1), 0, noise, slope=slope, sinusoid=sinusoid)


def jump_gate(search: ProcessSearch, fit: ProcessFit) -> Gate | None:
    """Whether the effect of u is more than that of jumps of the level; of few moves of u only."""
    record = search.record
    if record.moves > FEW:
        return None
    y, jumps = without_jumps(record.y, fit.e, fit.noise)
    beside = fitted(replace(record, y=y), start_of(fit), iterations=8)
    best = fit.bic if beside is None else min(fit.bic, beside.bic + jumps * jump_penalty(record))
    return gate_of_jumps(record.moves, bic_of_jumps(record, fit.sinusoid) - best)


def gate_of_jumps(moves: int, difference: float) -> Gate:
    """The gate of a BIC with jumps in place of u, less that with u."""
    return Gate(
        "level jumps", difference > ODDS, difference, ODDS,
        f"moves of u: {moves}; with up to {MOST_JUMPS} level jumps in place of u the BIC "
        f"is larger by {difference:.3g}, at least {ODDS:.3g} is required",
        "A jump of the disturbance would look the same: step u again, several times.",
    )  # fmt: skip


def jump_penalty(record: ProcessRecord) -> float:
    """What each jump adds to BIC: its time and its size."""
    return 2 * float(np.log(record.steps))


def bic_of_jumps(record: ProcessRecord, sinusoid: float = 0.0) -> float:
    """The least BIC of y with up to three level jumps and without u."""
    without = np.inf
    for orders in (*SIMPLE, *NOISES):
        start = _alone(noise_start(record.y, orders), sinusoid=sinusoid)
        alone = fitted(record, start, is_plant_fixed=True)
        if alone is None:
            continue
        y, jumps = without_jumps(record.y, alone.e, alone.noise)
        again = fitted(replace(record, y=y), start_of(alone), is_plant_fixed=True) or alone
        bic = again.bic - float(np.log(record.steps)) + jumps * jump_penalty(record)
        without = min(without, bic)
    return without


def without_jumps(y: Array, e: Array, noise: NoiseModel) -> tuple[Array, int]:
    """Y less the level jumps in e, one after another as long as each pays 3 log N, and how many."""
    steps = len(y)
    response = lfilter(noise.whitener, noise.C, np.ones(steps))
    energy = np.maximum(np.cumsum(response**2)[::-1], 1e-300)
    e, y, jumps = e.copy(), y.copy(), 0
    for _ in range(MOST_JUMPS):
        match = fftconvolve(e, response[::-1])[steps - 1 :]
        gain = match**2 / energy
        gain[-3:] = 0.0
        k, total = int(gain.argmax()), float(e @ e)
        if steps * np.log(max(1e-12, 1 - gain[k] / total)) + 3 * np.log(steps) > 0:
            break
        size = match[k] / energy[k]
        e[k:] -= size * response[: steps - k]
        y[k:] -= size
        jumps += 1
    return y, jumps


def delay_gate(search: ProcessSearch, fit: ProcessFit) -> Gate:
    """Whether the delay is inside the range that was tried."""
    last = search.delays - 1
    inside = search.is_known or fit.delay < last - 1
    return Gate(
        "dead time", inside, float(fit.delay), float(last),
        f"{fit.delay} steps, where 0 to {last} were tried",
        "The best dead time is the longest one tried: record longer, since at most a sixth of the "
        "record is tried, or sample more slowly.",
    )  # fmt: skip


def feedthrough_gate(
    search: ProcessSearch, fit: ProcessFit, *, is_commanded: bool = False
) -> Gate | None:
    """Whether y(k) responds to u(k); None where u(k) responds to y(k).

    A u of few values is no response: then y(k) predicts u(k) because it contains it. Raise an error
    where the record shows neither direction, and no command (`is_commanded`) says that u responds.
    """
    record = search.record
    plain = fit if not fit.armax else next((one for one in search.fits if not one.armax), None)
    if plain is None or (fit.armax and not search.is_closed):
        return None
    fit = plain
    earlier = replace(record, u=np.append(record.u[1:], record.u[-1]))
    weights = record.weights(fit.e) if fit.heavy else None
    squares = [
        scanned_again(
            one, fit.A, fit.noise.C, fit.noise.whitener, slope=fit.slope, summed=fit.summed,
            count=count, delays=1, weights=weights, sinusoid=fit.sinusoid,
        ).squares[0, 0]
        for one, count in ((earlier, fit.order + fit.summed + 1), (record, fit.order + fit.summed))
    ]  # fmt: skip
    e = fit.e if weights is None else fit.e * weights
    least = min(float(squares[1]), float(e @ e))
    difference = record.steps * float(np.log(least / squares[0])) - float(np.log(record.steps))
    if difference > ODDS and not search.is_direct and has_many_values(record):
        direction = leads(record.u, record.y)
        if direction is False or (direction is None and is_commanded):
            return None
        if direction is None and search.is_closed:
            raise undecided_direction("u", "y", difference)
    return Gate(
        "direct feedthrough", difference < ODDS, difference, ODDS,
        f"with u(k) in the model of y(k) the BIC is smaller by {difference:.3g}",
        "Pair y[:-1] with u[1:].",
    )  # fmt: skip


def undecided_direction(u: str, y: str, difference: float) -> UndecidedError:
    """The error for a u and a y of one step that predict each other, in either direction."""
    return UndecidedError(
        f"{y}(k) and {u}(k) predict each other: with {u}(k) in the model of {y}(k) the BIC is "
        f"smaller by {difference:.3g}, and the record does not show whether {u} was computed from "
        f"{y} or {y} was logged after its {u}. Of a closed loop give design the command, or the "
        f"dither, as r; else pair y[:-1] with u[1:]."
    )


def require_delay(feedthrough: Gate) -> None:
    """Raise an error where y answers to u at once."""
    if not feedthrough.passed:
        raise InputError(
            f"y(k) responds to u(k): {feedthrough.words}. u and y of a row are one step apart: "
            "log y before u is applied, or pair y[:-1] with u[1:]."
        )


def credible_delays(search: ProcessSearch, fit: ProcessFit) -> list[tuple[Array, int]]:
    """Numerator and delay of each delay within the odds, of a range of them some."""
    if search.is_known or fit.armax:
        return [(fit.B, fit.delay)]
    record = search.record
    scan = scanned_again(
        record, fit.A, fit.noise.C, fit.noise.whitener, slope=fit.slope, summed=fit.summed,
        count=len(fit.B), delays=search.delays,
        weights=record.weights(fit.e) if fit.heavy else None, sinusoid=fit.sinusoid,
    )  # fmt: skip
    squares = scan.squares[0]
    base = squares[fit.delay] if fit.delay < len(squares) else squares.min()
    credible = np.nonzero(record.steps * np.log(squares / base) < ODDS)[0]
    if not len(credible):
        return [(fit.B, fit.delay)]
    tried = {*credible[:: max(1, len(credible) // MOST_DELAYS)], credible[0], credible[-1]}
    return [(scan.numerators[0, d], int(d)) for d in sorted(tried)]


def hidden_share(first: float, variance: float, order: int) -> float:
    """The steps before the first coefficient of B in which a response may begin unseen.

    The response of n lags grows as the n-th power of time, and one that is smaller than the
    deviation of that coefficient, of a variance, does not show.
    """
    unseen = NORMAL * float(np.sqrt(max(variance, 0.0)))
    return (unseen / abs(first)) ** (1 / max(order, 1)) if unseen < abs(first) else 1.0


def dead_time_interval(
    first: float, last: int, period: float | None, skew: tuple[float, float], *, is_direct: bool
) -> tuple[float, float]:
    """The interval of a dead time: a response begins at `first` at the earliest, delays to `last`.

    In steps of the record; the result in seconds with a sample time. u(k - 1 - d) is the last one
    with an effect on y(k), and held for a step: the dead time is from d to d + 1 steps. `skew`: by
    which u of a row is older than its y. `is_direct`: y was paired with the u of the row after.
    """
    h, earlier = period or 1.0, int(is_direct)
    most = max(last - earlier, 0) + 1 + skew[1] / h  # a feedthrough is within a step
    return max(first - earlier + skew[0] / h, 0.0) * h, max(most, 0.0) * h


def misfit(search: ProcessSearch, fit: ProcessFit, omega: Array) -> tuple[float, Array]:
    """Probability that e is independent of past u, and the response that u leaves in e over G."""
    record, noise = search.record, fit.noise
    u = lfilter(noise.whitener, noise.C, record.u)
    count = min(fit.delay + LAGS, record.steps // 8)
    X = sliding_window_view(u, count)[:-1, ::-1]  # row k: u(k + count - 1), ..., u(k)
    X = X - X.mean(axis=0)
    scale = record.likelihood(fit.e)[2]
    e = np.clip(fit.e, -4 * scale, 4 * scale)[count:]
    e = e - e.mean()
    power = float(np.var(e))
    H = X.T @ X
    values, vectors = np.linalg.eigh(H)
    is_excited = values > 1e-8 * max(values[-1], 1e-300)
    if not power > 0 or not is_excited.any():
        return 1.0, np.zeros(len(omega))
    across = vectors.T @ (X.T @ e)
    statistic = float(np.sum(across[is_excited] ** 2 / values[is_excited])) / power
    probability = float(chi2.sf(statistic, int(is_excited.sum())))
    impulse = vectors[:, is_excited] @ (across[is_excited] / values[is_excited])
    left = np.exp(-1j * np.outer(omega, np.arange(1, count + 1))) @ impulse
    if fit.armax:
        left = left / np.polyval(fit.A[::-1], np.exp(-1j * omega))
    return probability, np.abs(left) / np.abs(fit.response(omega))


def part_fits(
    search: ProcessSearch, fit: ProcessFit, count: int
) -> Iterator[tuple[ProcessRecord, ProcessFit] | None]:
    """The model fitted again to parts of the record; None where u hardly moves, or it fails."""
    record = search.record
    bounds = np.linspace(0, record.steps, count + 1).astype(int)
    for low, high in pairwise(bounds):
        u = record.u[low:high]
        if len(np.unique(u)) < 3 and np.count_nonzero(np.diff(u)) < 3:
            yield None
            continue
        part = record.part(slice(low, high))
        again = fitted(part, start_of(fit), iterations=15)
        pays, before = (0.0, 0.0) if again is None else value_before(part, again)
        if again is not None and pays > ODDS:
            part = part.counted_from(before)
            again = fitted(part, start_of(again), iterations=15)
        if again is not None and fit.heavy:
            again = weighted_fit(part, again, 2)
        yield None if again is None else (part, again)


def bandwidth(fit: ProcessFit) -> float:
    """The frequency at which the phase of G is 90 degrees behind that at low frequency.

    In rad/step; without controller the gain is tested below it.
    """
    G = fit.response(OMEGA)
    phase = np.unwrap(np.angle(G))
    behind = np.nonzero(phase[0] - phase > np.pi / 2)[0]
    return float(OMEGA[behind[0]] if len(behind) else np.pi)


def gain_gate(search: ProcessSearch, fit: ProcessFit) -> Gate:
    """Whether the gain is known around the bandwidth of the plant."""
    edge = bandwidth(fit)
    omega = np.geomspace(edge / 3, edge, 15)
    worst = float(relative_deviation(search.record, fit, omega).max())
    return Gate(
        "gain", worst < KNOWN, worst, KNOWN,
        f"relative standard deviation {worst:.2g} at {edge / 3:.2g} to {edge:.2g} rad/step, "
        f"at most {KNOWN:.2g} is allowed",
        "Excite u more around this frequency, or record longer.",
    )  # fmt: skip


def sign_gate(search: ProcessSearch, fit: ProcessFit, omega: float) -> Gate:
    """Whether all credible models of the same stability have the sign of this one."""
    at = np.array([omega])
    others = [
        one for one in search.rivals
        if one.is_unstable == fit.is_unstable
        and not np.real(one.response(at) / fit.response(at)).item() > 0
    ]  # fmt: skip
    return sign_gate_of(len(others), omega)


def sign_gate_of(others: int, omega: float) -> Gate:
    """The gate of a number of credible models with the other sign."""
    return Gate(
        "sign", not others, float(others), 0.0,
        f"credible models with the other sign at {omega:.2g} rad/step: {others}",
        "The record supports both signs: excite u more, several times.",
    )  # fmt: skip
