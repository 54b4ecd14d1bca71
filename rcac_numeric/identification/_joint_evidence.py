"""What a record of several inputs says of a model: effects, level jumps, delays, gains, parts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.identification._box_jenkins import NoiseModel, noise_start
from rcac_numeric.identification._joint_fits import (
    Channel,
    JointFit,
    JointStart,
    joint_covariance,
    joint_disturbance,
    joint_fit,
    reweighted,
)
from rcac_numeric.identification._joint_records import JointRecord
from rcac_numeric.identification._joint_search import JointSearch
from rcac_numeric.identification._joint_stability import LIMIT, largest_root
from rcac_numeric.identification._prediction_error import ODDS
from rcac_numeric.identification._process_evidence import (
    KNOWN,
    LAGS,
    MOST_DELAYS,
    MOST_JUMPS,
    NORMAL,
    OMEGA,
    Gate,
    hidden_share,
    inflation,
    without_jumps,
)
from rcac_numeric.identification._process_search import FEW, NOISES, RICHER

SLOW_POLE = 20.0  # abs(1 - pole) times the steps: a pole that the record cannot tell from 1


@dataclass(frozen=True, eq=False)
class Names:
    """The names of the signals in words: u and y alone, u_1, u_2, ... if there are several."""

    inputs: int
    outputs: int

    def u(self, j: int) -> str:
        """The name of an input."""
        return "u" if self.inputs == 1 else f"u_{j + 1}"

    def y(self, i: int) -> str:
        """The name of an output."""
        return "y" if self.outputs == 1 else f"y_{i + 1}"


def _without(search: JointSearch, fit: JointFit, j: int) -> list[JointFit]:
    """Models without an input, of several noises, with the slope and the free response it has.

    A lightly damped channel fits a sinusoid by its initial state, whatever its input is.
    """
    record = search.record
    rest = tuple(one for one in fit.channels if one.input != j)
    v = joint_disturbance(record, rest)
    has_slope = fit.slope or any(one.summed for one in fit.channels)
    starts = [
        JointStart(rest, noise_start(v, orders), has_slope, fit.sinusoid)
        for orders in RICHER.values()
    ]
    starts += [JointStart(rest, fit.noise, slope, fit.sinusoid) for slope in {fit.slope, has_slope}]
    freed = tuple(replace(one, B=np.zeros(0)) if one.input == j else one for one in fit.channels)
    starts.append(replace(fit.start, channels=freed))
    fits = [joint_fit(record, start) for start in starts]
    alone = [one for one in fits if one is not None]
    return [reweighted(record, one) for one in alone] if fit.heavy else alone


def effect_of(search: JointSearch, fit: JointFit, j: int) -> float:
    """By how much the BIC is larger without an input."""
    return min((one.bic for one in _without(search, fit, j)), default=np.inf) - fit.bic


def jumps_of(search: JointSearch, fit: JointFit, j: int) -> float | None:
    """The BIC with level jumps in place of an input less the BIC; None if it moves often."""
    record = search.record
    if record.moves(j) > FEW:
        return None
    penalty = 2 * float(np.log(record.count))
    rest = tuple(one for one in fit.channels if one.input != j)
    v = joint_disturbance(record, rest)
    without = np.inf
    for noise in [noise_start(v, orders) for orders in NOISES]:
        alone = joint_fit(record, JointStart(rest, noise, sinusoid=fit.sinusoid))
        if alone is None:
            continue
        y, jumps = _less_jumps(record, alone)
        again = joint_fit(replace(record, y=y), alone.start) or alone
        without = min(without, again.bic + jumps * penalty)
    y, jumps = _less_jumps(record, fit)
    beside = joint_fit(replace(record, y=y), fit.start, iterations=8)
    best = fit.bic if beside is None else min(fit.bic, beside.bic + jumps * penalty)
    return without - best


def _less_jumps(record: JointRecord, fit: JointFit) -> tuple[Array, int]:
    """Y less the level jumps in the errors of each part, and how many there are."""
    e = np.zeros(record.steps)
    e[record.observed] = fit.e
    y, total = record.y.copy(), 0
    for part in record.parts:
        if part.stop - part.start > 10:
            y[part], jumps = without_jumps(record.y[part], e[part], fit.noise)
            total += jumps
    return y, total


def effect_gates(search: JointSearch, fit: JointFit, i: int, names: Names) -> tuple[Gate, ...]:
    """That each input has an effect, by itself and beside level jumps, and its dead time."""
    gates = []
    for one in fit.channels:
        u, y = names.u(one.input), names.y(i)
        difference = effect_of(search, fit, one.input)
        gates.append(Gate(
            f"effect of {u} on {y}", difference > ODDS, difference, ODDS,
            f"without {u} the BIC is larger by {difference:.3g}, at least {ODDS:.3g} is required",
            f"Excite {u} more, or record longer.",
        ))  # fmt: skip
        jumps = jumps_of(search, fit, one.input)
        if jumps is not None:
            gates.append(Gate(
                f"level jumps of {y} for {u}", jumps > ODDS, jumps, ODDS,
                f"with up to {MOST_JUMPS} level jumps in place of {u} the BIC is larger by "
                f"{jumps:.3g}, at least {ODDS:.3g} is required",
                f"A jump of the disturbance would look the same: step {u} again, several times.",
            ))  # fmt: skip
        last = search.delays - 1
        gates.append(Gate(
            f"dead time from {u} to {y}", one.delay < last - 1, float(one.delay), float(last),
            f"{one.delay} steps, where 0 to {last} were tried",
            "The best dead time is the longest one tried: record longer, or sample more slowly.",
        ))  # fmt: skip
    return tuple(gates)


def channel_delays(search: JointSearch, fit: JointFit, channel: Channel) -> list[Channel]:
    """The channel at each delay within the odds, of a range of them some."""
    scan = search.scan_of(fit, channel.input)
    squares = scan.squares[0]
    base = squares[channel.delay] if channel.delay < len(squares) else squares.min()
    credible = np.nonzero(search.record.count * np.log(squares / base) < ODDS)[0]
    if not len(credible):
        return [channel]
    tried = {*credible[:: max(1, len(credible) // MOST_DELAYS)], credible[0], credible[-1]}
    return [replace(channel, delay=int(d), B=scan.numerators[0, d]) for d in sorted(tried)]


def response_slopes(fit: JointFit, omega: Array) -> list[tuple[Channel, ComplexArray]]:
    """Each channel and the derivatives of its response by all coefficients of the fit.

    Shape (len(omega), coefficients), in units of the record.
    """
    past = np.exp(-1j * omega)
    count = sum(one.order + len(one.B) for one in fit.channels)
    slopes = []
    for one, place in zip(fit.channels, fit.places, strict=True):
        G = one.response(omega)
        A = np.polyval(one.A[::-1], past)
        B = np.polyval(one.B[::-1], past) * past
        by = np.zeros((len(omega), count), dtype=np.complex128)
        columns = [-G * past**k / A for k in range(1, one.order + 1)]
        columns += [G * past**k / B for k in range(1, len(one.B) + 1)]
        by[:, place] = np.stack(columns, axis=1)
        slopes.append((one, by))
    return slopes


def channel_deviations(record: JointRecord, fit: JointFit, omega: Array) -> dict[int, Array]:
    """Of each input the relative standard deviation of its response."""
    covariance = joint_covariance(record, fit)
    if not np.isfinite(covariance).all():
        return {one.input: np.full(len(omega), np.inf) for one in fit.channels}
    grown = inflation(fit.e, omega)
    deviations = {}
    for one, by in response_slopes(fit, omega):
        squares = np.real(np.einsum("wi,ij,wj->w", by, covariance, by.conj())) * grown
        size = np.abs(one.response(omega))
        deviations[one.input] = np.sqrt(np.maximum(squares, 0)) / np.maximum(size, 1e-300)
    return deviations


def channel_gain_bounds(search: JointSearch, fit: JointFit, j: int) -> tuple[float, float]:
    """The 95 % interval of the gain of an input at rest, over all credible models.

    In units of the record; of a channel with a pole at 1 that of its slope, over the models with
    one.
    """
    mine = fit.channel(j)
    assert mine is not None
    bounds = []
    for one in (fit, *search.rivals):
        channel = one.channel(j)
        if channel is None or channel.summed != mine.summed:
            continue
        place = one.places[one.channels.index(channel)]
        A, B = float(channel.A.sum()), float(channel.B.sum())
        by = np.concatenate([np.full(channel.order, -B / A**2), np.full(len(channel.B), 1 / A)])
        covariance = joint_covariance(search.record, one)[place, place]
        variance = float(by @ covariance @ by) * float(inflation(one.e, np.zeros(1))[0])
        width = NORMAL * float(np.sqrt(max(variance, 0.0)))
        bounds.append((B / A - width, B / A + width))
    return min(low for low, _ in bounds), max(high for _, high in bounds)


def channel_delay_bounds(search: JointSearch, fit: JointFit, j: int) -> tuple[float, int]:
    """When the response to an input begins at the earliest, and its longest delay; in steps.

    Over all credible models, and all credible delays of this one.
    """
    mine = fit.channel(j)
    assert mine is not None
    firsts, delays = [], []
    for one in (fit, *search.rivals):
        channel = one.channel(j)
        if channel is None:
            continue
        at = one.places[one.channels.index(channel)].start + channel.order
        variance = float(joint_covariance(search.record, one)[at, at])
        credible = [channel.delay]
        if one is fit:
            credible += [other.delay for other in channel_delays(search, fit, mine)]
        firsts.append(min(credible) - hidden_share(float(channel.B[0]), variance, channel.order))
        delays += credible
    return min(firsts), max(delays)


def channel_bandwidth(channel: Channel) -> float:
    """The frequency at which the phase is 90 degrees behind that at low frequency, in rad/step."""
    phase = np.unwrap(np.angle(channel.response(OMEGA)))
    behind = np.nonzero(phase[0] - phase > np.pi / 2)[0]
    return float(OMEGA[behind[0]] if len(behind) else np.pi)


def gain_gates(search: JointSearch, fit: JointFit, i: int, names: Names) -> tuple[Gate, ...]:
    """That each gain is known below the bandwidth of its entry, with its sign."""
    gates = []
    for one in fit.channels:
        u, y, edge = names.u(one.input), names.y(i), channel_bandwidth(one)
        omega = np.geomspace(edge / 3, edge, 15)
        worst = float(channel_deviations(search.record, fit, omega)[one.input].max())
        gates.append(Gate(
            f"gain from {u} to {y}", worst < KNOWN, worst, KNOWN,
            f"relative standard deviation {worst:.2g} at {edge / 3:.2g} to {edge:.2g} rad/step, "
            f"at most {KNOWN:.2g} is allowed",
            f"Excite {u} more around this frequency, or record longer.",
        ))  # fmt: skip
        gates.append(sign_of(search, one, edge / 3, u, y))
    return tuple(gates)


def stability_gates(search: JointSearch, fit: JointFit, i: int, names: Names) -> tuple[Gate, ...]:
    """That a pole near 1 is not outside the circle, as far as a long regression can tell.

    All models here have their poles inside the circle: that of an unstable plant ends near 1.
    """
    near = SLOW_POLE / search.record.longest
    if all(np.abs(1 - pole) > near for one in fit.channels for pole in np.roots(one.denominator)):
        return ()
    modulus, deviation = largest_root(search.record)
    bound = modulus + LIMIT * deviation
    return (Gate(
        f"stability of {names.y(i)}", bound < 1 + near, bound, 1 + near,
        f"the largest root of a long regression is {modulus:.4g} +- {LIMIT * deviation:.2g}, and "
        f"the model has a pole near 1; below {1 + near:.4g} the plant is taken for an integrating "
        "one",
        "The plant may be unstable: identify_process and design take such a plant from one record "
        "of one input and output, without gaps. Else excite u more, or record longer.",
    ),)  # fmt: skip


def sign_of(search: JointSearch, channel: Channel, omega: float, u: str, y: str) -> Gate:
    """Whether all credible models have the sign of a channel."""
    at = np.array([omega])
    others = 0
    for fit in search.rivals:
        other = fit.channel(channel.input)
        if other is not None and not np.real(other.response(at) / channel.response(at)) > 0:
            others += 1
    return Gate(
        f"sign from {u} to {y}", not others, float(others), 0.0,
        f"credible models with the other sign at {omega:.2g} rad/step: {others}",
        f"The record supports both signs: excite {u} more, several times.",
    )  # fmt: skip


def joint_misfit(record: JointRecord, fit: JointFit, omega: Array) -> tuple[float, ComplexArray]:
    """The probability that e is independent of past u, and the responses that u leaves in e.

    Shape (len(omega), inputs), in units of the record.
    """
    lags = min(max(one.delay for one in fit.channels) + LAGS, record.count // (8 * len(record.u)))
    u = record.filtered(fit.noise.whitener, fit.noise.C, record.u)
    X = np.concatenate([
        np.stack([record.later(row, k) for k in range(1, lags + 1)]) for row in u
    ])[:, record.observed]  # fmt: skip
    X = X - X.mean(axis=1, keepdims=True)
    scale = record.likelihood(fit.e)[2]
    e = np.clip(fit.e, -4 * scale, 4 * scale)
    e = e - e.mean()
    power = float(np.var(e))
    values, vectors = np.linalg.eigh(X @ X.T)
    is_excited = values > 1e-8 * max(float(values[-1]), 1e-300)
    if not power > 0 or not is_excited.any():
        return 1.0, np.zeros((len(omega), len(u)), dtype=np.complex128)
    across = vectors.T @ (X @ e)
    statistic = float(np.sum(across[is_excited] ** 2 / values[is_excited])) / power
    probability = float(chi2.sf(statistic, int(is_excited.sum())))
    impulse = (vectors[:, is_excited] @ (across[is_excited] / values[is_excited])).reshape(
        len(u), -1
    )
    past = np.exp(-1j * np.outer(omega, np.arange(1, lags + 1)))
    return probability, np.asarray(past @ impulse.T)


def joint_parts(search: JointSearch, fit: JointFit) -> Iterator[tuple[int, JointFit]]:
    """Index and model of each experiment, or half of the only one, that knows its gains.

    Of the channels whose input moves there.
    """
    record = search.record
    if len(record.starts) > 1:
        parts = [record.only([i]) for i in range(len(record.starts))]
    else:
        parts = list(record.halves())
    for k, part in enumerate(parts):
        if part.count < 10 * sum(one.order + len(one.B) for one in fit.channels):
            continue
        moving = [
            one for one in fit.channels
            if len(np.unique(part.u[one.input])) >= 3 or part.moves(one.input) >= 3
        ]  # fmt: skip
        if not moving:
            continue
        noise: NoiseModel = fit.noise
        start = JointStart(tuple(moving), noise, fit.slope, fit.sinusoid)
        again = joint_fit(part, start, iterations=15)
        if again is not None and fit.heavy:
            again = reweighted(part, again, 2)
        if again is None:
            continue
        known = [
            channel_deviations(part, again, np.geomspace(edge / 3, edge, 15))[one.input].max()
            for one in again.channels if (edge := channel_bandwidth(one))
        ]  # fmt: skip
        if max(known) < KNOWN:
            yield k, again
