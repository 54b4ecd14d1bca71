"""The search for models of one output and several inputs: starts, orders, delays, noise."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.identification._box_jenkins import (
    ONE,
    NoiseModel,
    noise_start,
    sinusoids,
    without_sinusoid,
)
from rcac_numeric.identification._delay_scan import (
    LONG,
    LONGEST,
    SHORTEST,
    TIME_CONSTANTS,
    WHITENERS,
    DelayScan,
    delay_scan,
    regression_roots,
)
from rcac_numeric.identification._disturbance_parts import (
    MOST_JUMPS,
    peak_frequency,
    student_regression,
)
from rcac_numeric.identification._hidden_pairs import (
    CANCELLED,
    RESOLVED,
    cancelling_pairs,
    hides_a_pair,
    roots_of,
)
from rcac_numeric.identification._joint_fits import (
    Channel,
    JointFit,
    JointStart,
    joint_disturbance,
    joint_fit,
    reweighted,
    student_weights,
    tuned,
)
from rcac_numeric.identification._joint_records import JointRecord
from rcac_numeric.identification._prediction_error import ODDS
from rcac_numeric.identification._process_records import DEGREES, JUMP, ROBUST
from rcac_numeric.identification._process_search import (
    DRIFTING,
    MOST_STEPS,
    NOISES,
    NOTCH,
    RICHER,
    RING,
    SAME,
    SHORT,
    SLOW,
    USUAL,
    WORSE,
)
from rcac_numeric.identification._scalar_record import SHARE, integrated_share

SWEEPS = 3  # over the inputs, in a start
MOST_ORDER = 3  # of a channel
EXTENSIONS = 8  # of the best model
POLES = (0.2, 0.5, 0.7, 0.85, 0.93, 0.97)  # one of which extends a channel
SLOWEST = 0.99  # pole of a channel of first order in place of one that oscillates
KEPT = 6  # models that are refined
RINGING = 3.0  # (1 - abs(pole)) times the steps: an oscillation that hardly decays


def joint_costs(record: JointRecord) -> Array:
    """What each delay adds to the criterion."""
    most = max(min(MOST_STEPS, record.longest // 6), 2)
    return np.where(np.arange(most) < USUAL, 0.0, ODDS)


def channel_scan(
    record: JointRecord, j: int, candidates: Sequence[Array], others: Sequence[Channel],
    noise: NoiseModel, *, count: int, delays: int, slope: bool = False, summed: bool = False,
    sinusoid: float = 0.0, weights: Array | None = None,
) -> DelayScan:  # fmt: skip
    """All delays of one input for some poles, the numerators of the other inputs free beside.

    Missing steps of y are interpolated and do not count; `weights` are of the other steps.
    """
    top, below = noise.whitener, noise.C
    impulse = np.zeros(record.steps)
    impulse[list(record.starts)] = 1.0
    has_slope = slope or summed or any(one.summed for one in others)
    u = record.summed(record.u[j]) if summed else record.u[j]
    levels = [np.ones(record.steps)]
    if has_slope:
        levels.append(np.concatenate([np.linspace(0, 1, p.stop - p.start) for p in record.parts]))
    if sinusoid:
        waves = [sinusoids(sinusoid, p.stop - p.start) for p in record.parts]
        levels += [np.concatenate(rows) for rows in zip(*waves, strict=True)]
    plain = record.filtered(top, below, np.stack([record.y, *levels]))
    columns = []
    for one in others:
        driven = record.filtered(top, np.convolve(below, one.A), one.driver(record))
        columns += [record.later(driven, k) for k in range(1, len(one.B) + 1)]
    free_of_all = [_by_part(record, row) for row in plain[1:]]
    driven_u, free = [], []
    for A in candidates:
        both = record.filtered(top, np.convolve(below, A), np.stack([u, impulse]))
        driven_u.append(both[0])
        states = [_by_part(record, record.later(both[1], k)) for k in range(len(A) - 1)]
        free.append(np.concatenate([*free_of_all, *states, *(one[None] for one in columns)]))
    widest = max(len(one) for one in free)
    rows = np.stack([np.pad(one, ((0, widest - len(one)), (0, 0))) for one in free])
    gap = delays + count
    if weights is None and (len(record.starts) > 1 or not record.observed.all()):
        weights = record.observed.astype(np.float64)
    weights = None if weights is None else record.separated(weights, gap)
    y = record.separated(plain[0], gap)
    rows, driven = record.separated(rows, gap), record.separated(np.stack(driven_u), gap)
    if weights is not None:
        y, rows = y * weights, rows * weights
    return delay_scan(y, driven, rows, count, delays, weights)


def _by_part(record: JointRecord, row: Array) -> Array:
    """A row for each part, 0 in the others."""
    if len(record.starts) == 1:
        return row[None]
    rows = np.zeros((len(record.starts), record.steps))
    for i, part in enumerate(record.parts):
        rows[i, part] = row[part]
    return rows


class JointSearch:
    """The models of one output, in the order of their BIC.

    Parameters
    ----------
    record : JointRecord
    inputs : sequence of int
        Those that may have an effect.

    Attributes
    ----------
    fits : list of JointFit
    larger : list of JointFit
        Credible models with further inputs, whose effect does not pay the odds.
    """

    def __init__(self, record: JointRecord, inputs: Sequence[int]) -> None:
        self.record, self.inputs = record, tuple(inputs)
        self.costs = joint_costs(record)
        self.fits: list[JointFit] = []
        self.larger: list[JointFit] = []
        self._searched()
        y = _without_jumps(record)
        y = record.clipped() if y is None else y
        if y is not None:
            self._without_accidents(replace(record, y=y), record)
        self._robust()
        self._rank()
        for _ in range(EXTENSIONS):
            if not self._varied():
                break
        self._without_cancelled()

    def _searched(self) -> None:
        """Fits from the global start, then of further orders and noises."""
        record = self.record
        self._begin()
        if self.fits and any(record.after_gaps):
            best = self.fits[0]
            lost = max(one.delay + len(one.B) for one in best.channels)
            self._fit_again(record.without_past(lost))
        self._noise()
        self._sinusoids()
        self._grow()
        self._noise()
        if self._reduce():
            self._grow()  # fewer poles elsewhere: another pole may be credible
        self._cancelled()
        if self.fits and self.fits[0].sinusoid:
            self.fits.append(self._priced(tuned(self.record, self.fits[0])))
            self._reduce()

    def _fit_again(self, record: JointRecord) -> None:
        """The best models fitted to a record of other steps: a BIC is of the steps it counts."""
        starts = [one.start for one in self.fits[: 2 * KEPT]]
        self.fits, self.record = [], record
        for start in starts:
            self.fit(start)
        self._rank()

    def fitted_to(self, record: JointRecord) -> JointFit:
        """The best model fitted to a record of other steps; as it is where that fails."""
        best = self.fits[0]
        fit = joint_fit(record, best.start)
        if fit is None:
            return best
        return self._priced(reweighted(record, fit) if best.heavy else fit)

    def _without_accidents(self, clipped: JointRecord, record: JointRecord) -> None:
        """Search on y without jumps and spikes, then fit to y from there by Student's likelihood.

        Jumps and spikes draw least squares away from the plant: of a noise that drifts a jump is
        one error; of one that returns, all that follow.
        """
        plain, target, self.fits, self.record = self.fits, self.record, [], clipped
        self._searched()
        best, searched = self.fits[:KEPT], self.record
        self.fits, self.record = plain, target
        observed = target.observed & searched.observed
        if np.count_nonzero(observed) < target.count:
            self._fit_again(replace(target, observed=observed))
        for start in (one.start for one in best):
            starts, noise = [start], start.noise
            if not noise.differences:
                drifting = NoiseModel(np.convolve(noise.C, [1, -DRIFTING]), noise.D, 1)
                starts.append(replace(start, noise=drifting))
            for one in starts:
                at_start = joint_fit(self.record, one, iterations=0)
                if at_start is not None and at_start.heavy:
                    self.fits.append(self._priced(reweighted(self.record, at_start)))

    def _varied(self) -> bool:
        """The best heavy model with one thing changed, by its weights; whether that pays."""
        if not self.fits or not self.fits[0].heavy:
            return False
        best, changed = self.fits[0], list[JointStart]()
        for i, one in enumerate(best.channels):
            for other in [*_longer(one), *_shorter(one), *_shifted(one), *_unsummed(one)]:
                channels = (*best.channels[:i], other, *best.channels[i + 1 :])
                changed.append(replace(best.start, channels=channels))
        changed += self._without_pairs(best)
        v = joint_disturbance(self.record, best.channels)
        for orders in (*NOISES, *RICHER.values()):
            changed.append(replace(best.start, noise=noise_start(v, orders)))
        weights = student_weights(self.record, best)
        for starts, count in ((changed, 2), ([*self._of_real_poles(best)], 1)):
            fits = [joint_fit(self.record, one, iterations=8, weights=weights) for one in starts]
            priced = sorted((self._priced(fit) for fit in fits if fit is not None), key=_bic)
            for fit in priced[:count]:
                if fit.bic < best.bic + WORSE:
                    self.fits.append(self._priced(reweighted(self.record, fit)))
        self._rank()
        return self.fits[0].bic < best.bic - 1.0

    @property
    def delays(self) -> int:
        """The number of delays that are tried."""
        return len(self.costs)

    @property
    def distinct(self) -> list[JointFit]:
        """The credible models, of each kind the best."""
        kinds: dict[tuple[object, ...], JointFit] = {}
        for fit in self.fits:
            if self.credible(fit):
                kinds.setdefault(fit.key, fit)
        return list(kinds.values())

    @property
    def rivals(self) -> list[JointFit]:
        """The credible models, those with further inputs among them."""
        return [*self.distinct, *self.larger]

    def with_larger(self, other: JointSearch) -> None:
        """Keep the credible models of a search over more inputs."""
        best = self.fits[0].bic + min(bic_difference(other, self), 0.0)
        shift = self.fits[0].bic + bic_difference(other, self) - other.fits[0].bic
        self.larger = [
            one for one in other.rivals if one.bic + shift <= best + ODDS
        ]  # fmt: skip

    def credible(self, fit: JointFit) -> bool:
        """Whether the odds against a model are below one to ten thousand."""
        return fit.bic <= self.fits[0].bic + ODDS

    def fit(self, start: JointStart, iterations: int = 25) -> JointFit | None:
        """A fit, which is kept."""
        fit = joint_fit(self.record, start, iterations=iterations)
        if fit is None:
            return None
        fit = self._priced(fit)
        self.fits.append(fit)
        return fit

    def _priced(self, fit: JointFit) -> JointFit:
        cost = sum(
            float(self.costs[one.delay]) if one.delay < self.delays else ODDS
            for one in fit.channels
        )
        return replace(fit, bic=fit.bic + cost) if cost else fit

    def _rank(self) -> None:
        self.fits = [
            one for one in self.fits
            if all(not c.summed or integrated_share(c.A, c.B) > SHARE for c in one.channels)
        ]  # fmt: skip
        longest = self.record.longest
        ending = [
            one for one in self.fits if not any(_is_endless(c, longest) for c in one.channels)
        ]  # fmt: skip
        self.fits = sorted(ending or self.fits, key=_bic)

    def _begin(self) -> None:
        """From each whitener the poles and delays of all inputs in turn, then short fits."""
        record, short = self.record, list[JointFit]()
        for D, differences in WHITENERS:
            channels = self._swept(NoiseModel(ONE, D, differences))
            v = joint_disturbance(record, channels)
            for orders in NOISES:
                start = JointStart(channels, noise_start(v, orders))
                fit = joint_fit(record, start, iterations=SHORT)
                if fit is not None:
                    short.append(self._priced(fit))
        short.sort(key=_bic)
        for one in _of_each_noise(short):
            fit = self.fit(one.start)
            if fit is not None:
                self._moved(fit)
        self._rank()

    def _swept(self, noise: NoiseModel, sinusoid: float = 0.0) -> tuple[Channel, ...]:
        """Poles and delay of each input in turn, until none moves; beside a sinusoid or none."""
        record, channels = self.record, dict[int, Channel]()
        grid = np.exp(-1 / np.geomspace(
            SHORTEST, max(10.0, min(record.longest / 4, LONGEST)), TIME_CONSTANTS
        ))  # fmt: skip
        candidates: list[Array] = [
            np.poly(poles).astype(np.float64) for a in grid for poles in ([a], [a, a**2])
        ]
        for sweep in range(SWEEPS if len(self.inputs) > 1 else 1):
            before = {j: one.key for j, one in channels.items()}
            for j in self.inputs:
                others = [one for i, one in channels.items() if i != j]
                scan = channel_scan(
                    record, j, candidates, others, noise, count=2, delays=self.delays,
                    sinusoid=sinusoid,
                )  # fmt: skip
                value = record.count * np.log(scan.squares) + self.costs
                i, delay = np.unravel_index(int(value.argmin()), value.shape)
                channels[j] = Channel(j, candidates[int(i)], scan.numerators[i, delay], int(delay))
            if sweep and before == {j: one.key for j, one in channels.items()}:
                break
        return tuple(channels[j] for j in self.inputs)

    def scan_of(self, fit: JointFit, j: int) -> DelayScan:
        """All delays of one channel of a fit."""
        channel = fit.channel(j)
        assert channel is not None
        others = [one for one in fit.channels if one.input != j]
        return channel_scan(
            self.record, j, [channel.A], others, fit.noise, count=len(channel.B),
            delays=self.delays, slope=fit.slope, summed=channel.summed, sinusoid=fit.sinusoid,
            weights=student_weights(self.record, fit) if fit.heavy else None,
        )  # fmt: skip

    def _moved(self, fit: JointFit) -> JointFit:
        """The fit with each channel at its best delay, until none moves."""
        for _ in range(SWEEPS):
            channels = []
            for one in fit.channels:
                scan = self.scan_of(fit, one.input)
                value = self.record.count * np.log(scan.squares[0]) + self.costs
                delay = int(value.argmin())
                is_other = delay != one.delay and one.delay < self.delays
                if is_other and value[delay] < value[one.delay] - 1e-6:
                    channels.append(replace(one, delay=delay, B=scan.numerators[0, delay]))
                else:
                    channels.append(one)
            if all(a is b for a, b in zip(channels, fit.channels, strict=True)):
                break
            again = self.fit(replace(fit.start, channels=tuple(channels)))
            if again is None or again.bic >= fit.bic:
                break
            fit = again
        return fit

    def _try(self, fit: JointFit, changes: Iterable[Sequence[Channel]]) -> None:
        """Fits in which one channel is changed, each to several."""
        for i, others in enumerate(changes):
            for other in others:
                channels = (*fit.channels[:i], other, *fit.channels[i + 1 :])
                self.fit(replace(fit.start, channels=channels))

    def _extended(self, fit: JointFit, channel: Channel) -> list[Channel]:
        """The channel with a further pole of a grid, its numerator and delay by a scan of all."""
        if channel.order >= MOST_ORDER:
            return []
        return [self._scanned(fit, channel, [np.convolve(channel.A, [1.0, -p]) for p in POLES])]

    def _scanned(
        self, fit: JointFit, channel: Channel, candidates: Sequence[Array], *, moves: bool = True
    ) -> Channel:
        """The channel with the best of some denominators, its numerator and, if it moves, delay."""
        others = [one for one in fit.channels if one is not channel]
        scan = channel_scan(
            self.record, channel.input, candidates, others, fit.noise,
            count=len(candidates[0]) - 1, delays=self.delays, slope=fit.slope,
            summed=channel.summed, sinusoid=fit.sinusoid,
            weights=student_weights(self.record, fit) if fit.heavy else None,
        )  # fmt: skip
        value = self.record.count * np.log(scan.squares) + self.costs
        if not moves and channel.delay < self.delays:
            value[:, np.arange(self.delays) != channel.delay] = np.inf
        i, delay = np.unravel_index(int(value.argmin()), value.shape)
        B = np.concatenate([scan.numerators[i, delay], np.zeros(int(channel.summed))])
        return replace(channel, A=candidates[int(i)], B=B, delay=int(delay))

    def _of_real_poles(self, fit: JointFit) -> Iterator[JointStart]:
        """Starts of first order in place of channels that oscillate: a slow noise looks so.

        In place of one of them, and in place of every channel of higher order.
        """
        oscillates = [np.iscomplexobj(np.roots(one.A)) for one in fit.channels]
        if not any(oscillates):
            return
        candidates = [np.array([1.0, -p]) for p in (*POLES, SLOWEST)]
        first = [
            one if one.order < 2 else self._scanned(fit, one, candidates, moves=False)
            for one in fit.channels
        ]
        kinds = [tuple(first)]
        for i, is_one in enumerate(oscillates):
            if is_one:
                kinds.append((*fit.channels[:i], first[i], *fit.channels[i + 1 :]))
        for channels in kinds:
            v = joint_disturbance(self.record, channels)
            for noise in [fit.noise, *(noise_start(v, orders) for orders in RICHER.values())]:
                for slope in {fit.slope, False}:
                    yield replace(fit.start, channels=channels, noise=noise, slope=slope)

    def _grow(self) -> None:
        """A further pole, or a pole at 1, of each channel as long as it pays."""
        for _ in range(EXTENSIONS):
            if not self.fits:
                return
            best = self.fits[0]
            self._try(best, [
                [*_longer(one), *self._extended(best, one), *_summed(one, self.record.longest)]
                for one in best.channels
            ])  # fmt: skip
            self.fit(replace(best.start, slope=True), 12)
            self._rank()
            if self.fits[0] is best or self.fits[0].bic > best.bic - 1.0:
                break
            self._moved(self.fits[0])
            self._rank()

    def _reduce(self) -> bool:
        """Fewer poles of each channel, all of which may be credible; whether that pays."""
        for count in range(3):
            if not self.fits:
                return False
            best = self.fits[0]
            self._try(best, ([*_shorter(one), *_unsummed(one)] for one in best.channels))
            self._rank()
            if self.fits[0] is best:
                return count > 0
            self._moved(self.fits[0])
            self._rank()
        return True

    def _noise(self) -> None:
        """Noise of order 2, drifting or not, and a sinusoid, for the best."""
        for fit in self.fits[:2]:
            v = joint_disturbance(self.record, fit.channels)
            self.fit(replace(fit.start, slope=True), 12)
            for differences in (0, 1):
                for orders in (RICHER[differences], NOISES[differences]):
                    self.fit(replace(fit.start, noise=noise_start(v, orders)))
            omega = peak_frequency(v)
            if omega:
                z = np.exp(1j * omega)
                C, D = (np.real(np.poly([r * z, r / z])) for r in (NOTCH, RING))
                self.fit(replace(fit.start, noise=NoiseModel(C, D, 0)))
                D, C = np.convolve(D, [1, -0.2]), np.convolve(C, [1, -0.3])
                self.fit(replace(fit.start, noise=NoiseModel(C, D, 0)))
        self._rank()

    def _sinusoids(self) -> None:
        """A sinusoid beside the level, of frequencies that the best models show.

        At the peak of the disturbance, and at poles that the record cannot tell from the circle: a
        channel fits a sinusoid by its initial state, and a long regression has it as a root.
        """
        record = self.record
        resolved, frequencies = RESOLVED / record.longest, list[float]()
        counts = record.observed.copy()
        for part in record.parts[1:]:
            counts[part.start : part.start + LONG] = False
        long = regression_roots(record.y, record.u[list(self.inputs)], counts)
        on_circle = (np.abs(long) > 1 - resolved / 2) & (long.imag > resolved)
        frequencies += np.angle(long[on_circle]).tolist()[:1]
        for fit in self.fits[:2]:
            roots = [np.roots(fit.noise.D), *(np.roots(one.A) for one in fit.channels)]
            poles = np.concatenate(roots) + 0j
            poles = poles[(np.abs(poles) > 1 - resolved / 2) & (poles.imag > resolved)]
            peak = peak_frequency(joint_disturbance(self.record, fit.channels))
            for omega in [*np.angle(poles), *([peak] if peak else [])]:
                if all(abs(omega - other) > 10 * resolved / SAME for other in frequencies):
                    frequencies.append(float(omega))
        for omega in frequencies[:3]:
            self._beside_sinusoid(omega)
        self._rank()

    def _beside_sinusoid(self, omega: float) -> None:
        """Models with a sinusoid beside the level, from the global start beside one."""
        record, short = self.record, list[JointFit]()
        starts = [self._swept_beside(NoiseModel(ONE, *one), omega) for one in WHITENERS]
        starts += [one.channels for one in self.fits[:1]]
        for channels in starts:
            if any(_is_endless(one, record.longest) for one in channels):
                continue
            near, rest = self._less_sinusoid(channels, omega)
            for orders in NOISES:
                start = JointStart(channels, noise_start(rest, orders), sinusoid=near)
                fit = joint_fit(record, start, iterations=SHORT)
                if fit is not None:
                    short.append(self._priced(fit))
        for one in sorted(short, key=_bic)[:2]:
            fit = self.fit(one.start)
            if fit is not None:
                fit = self._priced(tuned(record, fit))
                self.fits.append(fit)
                self._moved(fit)

    def _swept_beside(self, noise: NoiseModel, omega: float) -> tuple[Channel, ...]:
        """Poles and delays beside a sinusoid, whose frequency is corrected once."""
        channels = self._swept(noise, omega)
        near = self._less_sinusoid(channels, omega)[0]
        is_same = abs(near - omega) < RESOLVED / self.record.longest / SAME
        return channels if is_same else self._swept(noise, near)

    def _less_sinusoid(self, channels: tuple[Channel, ...], omega: float) -> tuple[float, Array]:
        """The frequency of the sinusoid that channels leave near one, and what is left then."""
        v = joint_disturbance(self.record, channels)
        return without_sinusoid(v, omega, self.record.parts, self.record.observed)

    def _cancelled(self) -> None:
        """Pairs of a pole and a zero near the circle, which fit the noise, moved into D."""
        for fit in self.fits[:3]:
            for start in [*self._without_pairs(fit), *self._of_real_poles(fit)]:
                self.fit(start)
        self._rank()

    def _without_pairs(self, fit: JointFit) -> Iterator[JointStart]:
        """Starts without one of the pairs of a pole and a zero, which is in the noise or not."""
        for i, one in enumerate(fit.channels):
            for poles, zeros in _pairs(one):
                A = np.atleast_1d(np.real(np.poly(np.delete(np.roots(one.A), poles))))
                if len(A) == 1:
                    continue
                rest = np.delete(np.roots(one.B), zeros)
                B = one.B[0] * np.atleast_1d(np.real(np.poly(rest)))
                channels = list(fit.channels)
                channels[i] = replace(one, A=A, B=B)
                pair = np.roots(one.A)[poles]
                C = np.convolve(fit.noise.C, np.real(np.poly(NOTCH * pair)))
                D = np.convolve(fit.noise.D, np.real(np.poly(pair)))
                start = replace(fit.start, channels=tuple(channels))
                yield replace(start, noise=replace(fit.noise, C=C, D=D))
                yield start
                yield replace(start, slope=True)

    def _without_cancelled(self) -> None:
        """Leave out models with a pair that all but cancels, where one without it is credible.

        Such a pair is a disturbance of the level or a sinusoid; in a loop it is a hidden mode on
        the circle.
        """
        plain = [one for one in self.fits if not has_hidden_pair(one, self.record.longest)]
        if plain and plain[0].bic <= self.fits[0].bic + ODDS:
            self.fits = plain

    def _robust(self) -> None:
        """The best by Student's likelihood, where its tails are heavy."""
        if not self.fits or not self.fits[0].heavy:
            return
        limit = self.fits[0].bic + 2 * WORSE
        for one in self.fits[:KEPT]:
            if one.bic <= limit:
                fit = reweighted(self.record, one)
                if fit is not one:
                    self.fits.append(self._priced(fit))


def bic_difference(first: JointSearch, second: JointSearch) -> float:
    """The BIC of the best of one search less that of another, over the steps that both count.

    After a gap of u the steps that depend on it are left out: how many, each search decides.
    """
    best = [first.fits[0], second.fits[0]]
    observed = first.record.observed & second.record.observed
    for i, search in enumerate((first, second)):
        if np.count_nonzero(observed) < search.record.count:
            best[i] = search.fitted_to(replace(search.record, observed=observed))
    return best[0].bic - best[1].bic


def _without_jumps(record: JointRecord) -> Array | None:
    """Y less the jumps in the innovations of its differences; None if there are none, or many.

    Of a long regression on past y and u, with Student's weights: what u does is no jump.
    """
    p = min(20, record.longest // 20)
    y, u = (one - record.later(one, 1) for one in (record.y, record.u))  # parts begin at 0
    X = np.concatenate(
        [np.stack([record.later(rows, k) for k in range(1, p + 1)]) for rows in (y, *u)]
    )
    counts = record.observed & (record.later(record.observed.astype(np.float64), 1) > 0)

    def weights_of(e: Array) -> Array:
        scale = record.likelihood(e[counts])[2]
        return np.asarray(counts * np.sqrt((DEGREES + 1) / (DEGREES + (e / scale) ** 2)))

    a, e = student_regression(X, y, weights_of, counts.astype(np.float64))
    size = JUMP * (ROBUST * float(np.median(np.abs(e[counts]))) + 1e-12)
    response = np.concatenate([ONE, -a[:p]])  # of e to a jump
    jumps = np.zeros(record.steps)
    e = np.where(counts, e, 0.0)
    for part in record.parts:
        e[part.start : part.start + p] = 0.0  # there the past is not known
    for _ in range(int(MOST_JUMPS * record.steps)):
        late = np.flatnonzero(np.abs(e) > size)
        if not len(late):
            return record.y - record.summed(jumps) if jumps.any() else None
        k = int(late[0])
        stop = min(k + p + 1, next(one.stop for one in record.parts if one.stop > k))
        jumps[k] += e[k]
        e[k:stop] -= e[k] * response[: stop - k]
    return None


def _of_each_noise(fits: list[JointFit]) -> list[JointFit]:
    """The two best of each kind of noise."""
    return [one for i in (0, 1) for one in [f for f in fits if f.noise.differences == i][:2]]


def _longer(one: Channel) -> list[Channel]:
    if one.order >= MOST_ORDER:
        return []
    n = one.order + 1
    A, both = np.convolve(one.A, [1, -0.5]), []
    for earlier in (0, 1, 2):
        if one.delay < earlier:
            continue
        B = np.convolve(one.B, [1, -0.5]) if not earlier else one.B
        B = np.concatenate([np.zeros(earlier), B])[: n + one.summed]
        B = np.concatenate([B, np.zeros(n + one.summed - len(B))])
        if np.abs(B).any():
            both.append(replace(one, A=A, B=B, delay=one.delay - earlier))
    return both


def _shifted(one: Channel) -> list[Channel]:
    """A step earlier and later."""
    both = []
    for shift in (-1, 1):
        B = np.concatenate([[0.0], one.B[:-1]])
        if shift > 0:
            B = np.concatenate([one.B[1:], [0.0]])
        if one.delay + shift >= 0 and np.abs(B).any():
            both.append(replace(one, delay=one.delay + shift, B=B))
    return both


def _shorter(one: Channel) -> list[Channel]:
    """Without the fastest real pole, its lag as delay or not."""
    poles = np.roots(one.A)
    real = poles[np.abs(poles.imag) < 1e-9].real
    if one.order < 2 or not len(real):
        return []
    rest = np.delete(poles, int(np.argmin(np.abs(poles - real[np.argmin(np.abs(real))]))))
    A = np.concatenate([ONE, np.real(np.poly(rest))[1:]])
    n = one.order - 1 + one.summed
    gain = one.B.sum() / one.A.sum() * A.sum()
    B = np.zeros(max(n, 1))
    B[0] = gain
    return [replace(one, A=A, B=B, delay=one.delay + late) for late in (0, 1)]


def _summed(one: Channel, steps: int) -> list[Channel]:
    """With a pole at 1 in place of one that the record cannot tell from it."""
    poles = np.roots(one.A)
    real = np.where(np.abs(poles.imag) < 1e-9, poles.real, -1.0)
    if one.summed or not len(poles) or real.max() < 1 - SLOW / steps:
        return []
    rest = np.delete(poles, int(real.argmax()))
    A = np.concatenate([ONE, np.real(np.poly(rest))[1:]]) if len(rest) else np.array([1.0, -0.3])
    B = np.concatenate([one.B, np.zeros(len(A))])[: len(A)]
    return [replace(one, A=A, B=B, summed=True)]


def _unsummed(one: Channel) -> list[Channel]:
    """Without the pole at 1: with the zero beside it left out, which fits a level, or it alone."""
    if not one.summed:
        return []
    A, zeros = np.convolve(one.A, [1, -POLES[-1]]), np.roots(one.B)
    others = [replace(one, A=A, summed=False)]
    near = int(np.argmin(np.abs(zeros - 1))) if len(zeros) else 0
    if one.order and len(zeros) and abs(zeros[near] - 1) < CANCELLED and not zeros[near].imag:
        B = one.B[np.flatnonzero(one.B)[0]] * np.atleast_1d(
            np.real(np.poly(np.delete(zeros, near)))
        )
        others.append(replace(one, B=B, summed=False))
    return others


def has_hidden_pair(fit: JointFit, steps: int) -> bool:
    """Whether a pole near the circle and a zero all but cancel in a channel."""
    return any(
        hides_a_pair(roots_of(one.denominator), roots_of(one.B), steps) for one in fit.channels
    )


def _is_endless(one: Channel, steps: int) -> bool:
    """Whether a channel rings throughout a record: its initial state is a free sinusoid."""
    poles = np.roots(one.A)
    rings = (np.abs(poles.imag) > 1e-9) & ((1 - np.abs(poles)) * steps < RINGING)
    return bool(rings.any())


def _pairs(one: Channel) -> list[tuple[list[int], list[int]]]:
    """Indices of poles near the circle, and of the zeros beside them."""
    return cancelling_pairs(roots_of(one.A), roots_of(one.B))


def _bic(fit: JointFit) -> float:
    return fit.bic
