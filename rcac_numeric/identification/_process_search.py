"""The search for models of a scalar record: global starts, orders, noise, integrator, sinusoid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.compiled._box_jenkins import confined
from rcac_numeric.identification._box_jenkins import (
    CIRCLE,
    ONE,
    NoiseModel,
    ProcessFit,
    Start,
    disturbance,
    fitted,
    later,
    noise_start,
    residual_of,
    sinusoids,
    start_of,
    weighted_fit,
    with_noise,
    without_sinusoid,
)
from rcac_numeric.identification._delay_scan import (
    pole_starts,
    regression_roots,
    regression_start,
    robust_starts,
    scanned_again,
    unstable_starts,
)
from rcac_numeric.identification._disturbance_parts import (
    differenced,
    joint_innovations,
    peak_frequency,
    without_level_jumps,
    without_outliers,
)
from rcac_numeric.identification._hidden_pairs import (
    RESOLVED,
    cancelling_pairs,
    has_hidden_pair,
    has_unstable_part,
    roots_of,
)
from rcac_numeric.identification._prediction_error import ODDS, answers
from rcac_numeric.identification._process_records import ProcessRecord
from rcac_numeric.identification._scalar_record import SHARE, integrated_share
from rcac_numeric.identification._simpler_models import simpler_starts

USUAL = 80  # steps: a longer dead time must pay ODDS
MOST_STEPS = 1000  # of a dead time
NOISES = ((1, 1, 0), (1, 0, 1))  # orders of C and D, and differences
SIMPLE = ((0, 0, 0), (0, 1, 0), (0, 0, 1))  # which the former contain
RICHER = {0: (2, 2, 0), 1: (2, 1, 1)}
SHORT = 5  # iterations of a fit that is compared only
MOST_ORDER = 4
FEW = 3  # moves of u: what the disturbance does beside them may be all that is to be seen
SLOW = 30.0  # abs(1 - pole) times the steps: a pole that may be 1
SLOWEST = 3.5  # periods in a record, beside a slope: no peak of a sinusoid
RING, NOTCH = 0.9995, 0.9  # moduli of the roots of D and C of a sinusoid
SAME = 50.0  # of that frequency: sinusoids within it have the same response beside them
SLOW_WAVE = 0.3  # of that frequency: the slowest sinusoid that is tried in place of a pole
SIMPLIFIED = 8  # kinds of models that are made simpler
REFITTED = 8  # models that are fitted again by Student's likelihood
MANY = 8  # values of u: fewer are no answer to y
DRIFTING = 0.95  # root of C beside the difference of a noise that hardly drifts
WORSE = 60.0  # of BIC: what is not continued


def delay_costs(record: ProcessRecord, known: int | None = None) -> Array:
    """What each delay adds to the criterion."""
    most = max(min(MOST_STEPS, record.steps // 6), 2)
    if known is not None:
        costs = np.full(max(most, known + 1), np.inf)
        costs[known] = 0.0
        return costs
    return np.where(np.arange(most) < USUAL, 0.0, ODDS)


def is_answer(record: ProcessRecord) -> bool:
    """Whether y predicts u."""
    return record.moves >= MANY and record.steps >= 100 and answers(record.u, record.y)


def has_many_values(record: ProcessRecord) -> bool:
    """Whether u takes so many values that it may be the answer of a controller."""
    return len(np.unique(record.u)) > max(MANY, record.steps // 20)


class ProcessSearch:
    """The models of a record, in the order of their BIC.

    Parameters
    ----------
    record : ProcessRecord
    delay : int, optional
        Known dead time.
    is_direct : bool
        Whether y of the record was logged a step before its u, so that delay 0 is a direct
        feedthrough.
    """

    def __init__(
        self, record: ProcessRecord, delay: int | None = None, *, is_direct: bool = False
    ) -> None:
        self.record, self.is_direct = record, is_direct
        self.costs = delay_costs(record, delay)
        self.is_known = delay is not None
        self.is_closed = not is_direct and is_answer(record)
        self.fits: list[ProcessFit] = []
        self.jumped: list[ProcessFit] = []
        self.short: list[ProcessFit] = []
        self._box_jenkins(record)
        clipped = record.clipped()
        if clipped is not None:
            self._clipped(replace(record, y=clipped))
        self._robust_starts()
        self._sloped()
        self._extended()
        self._integrating()
        self._richer()
        self._sinusoids()
        may_respond = self.is_closed or (has_many_values(record) and record.steps >= 100)
        if may_respond:
            self._armax(record)
            y = without_level_jumps(record)
            if y is not None:
                self._armax_of_clipped(replace(record, y=y))
        self._cancelled()
        omegas = self._undamped()
        omega = self._beside_unstable(omegas) if may_respond else 0.0
        if omega:
            self._armax(record, omega=omega)
        self._robust()
        self._simplified()
        self._rank()
        self._without_cancelled()
        self._jumped()

    @property
    def delays(self) -> int:
        """The number of delays that are tried."""
        return len(self.costs)

    def credible(self, fit: ProcessFit) -> bool:
        """Whether the odds against a model are below one to ten thousand.

        An unstable one, of more parameters by its kind, is compared by AIC; with a stable one by
        the errors of the output.
        """
        best = self.fits[0]
        if fit.bic <= best.bic + ODDS:
            return True
        if not fit.armax:
            return False
        by = float(np.log(self.record.steps)) - 2
        least = fit.bic - by * fit.parameters - (0.0 if best.armax else _reflection(fit))
        return least < best.bic - by * best.parameters + ODDS

    @property
    def distinct(self) -> list[ProcessFit]:
        """The credible models, of each kind and order the best."""
        kinds: dict[tuple[object, ...], ProcessFit] = {}
        for fit in self.fits:
            if self.credible(fit):
                key = fit.order, fit.delay, fit.noise.differences, fit.armax, fit.summed
                kinds.setdefault(key, fit)
        return list(kinds.values())

    def kinds(self, count: int) -> list[ProcessFit]:
        """The best model of each order and noise, credible or not, the best ones first."""
        kinds: dict[tuple[object, ...], ProcessFit] = {}
        for fit in self.fits:
            kinds.setdefault((fit.order, fit.noise.orders, fit.armax, fit.summed), fit)
        return list(kinds.values())[:count]

    @property
    def rivals(self) -> list[ProcessFit]:
        """The credible models, and those with a level jump beside the response to u."""
        return self.distinct + [one for one in self.jumped if self.credible(one)]

    def of_order(self, order: int) -> ProcessFit | None:
        """The best model of an order, credible or not; None if there is none."""
        best = [one for one in self.fits if one.order == order][:1]
        if not best:
            starts = sorted((one for one in self.short if one.order == order), key=_bic)
            best = [fit for one in starts[:1] if (fit := self.fit(start_of(one))) is not None]
            self._rank()
        return best[0] if best else None

    def fit(self, start: Start, iterations: int = 25) -> ProcessFit | None:
        """A fit, which is kept."""
        fit = fitted(self.record, start, iterations=iterations)
        return None if fit is None else self._keep(fit)

    def _keep(self, fit: ProcessFit) -> ProcessFit | None:
        cost = float(self.costs[fit.delay]) if fit.delay < self.delays else ODDS
        if not np.isfinite(cost):
            return None
        fit = replace(fit, bic=fit.bic + cost) if cost else fit
        self.fits.append(fit)
        return fit

    def _rank(self) -> None:
        self.fits = [
            one for one in self.fits
            if (not one.armax or has_unstable_part(one))
            and (not one.summed or integrated_share(one.A, one.B) > SHARE)
        ]  # fmt: skip
        self.fits.sort(key=_bic)

    def _starts(self, record: ProcessRecord) -> list[Start]:
        starts: list[Start] = []
        none = NoiseModel(ONE, ONE, 0)
        for pair in pole_starts(record, record.y, record.u, self.costs):
            starts += [Start(one.A, one.B, one.delay, none) for one in pair]
        for differences in (0, 1):
            y, u = differenced(record, differences)
            regressions = [
                (*regression_start(y, u, (), n, self.costs), n) for n in (1, 2, 3)
            ]  # fmt: skip
            past, B, delay, _, _ = min(regressions, key=lambda one: one[3])
            A = confined(np.concatenate([ONE, past]), 0.9999)
            starts.append(Start(A, B, delay, none))
        unique: dict[tuple[object, ...], Start] = {}
        for one in starts:
            unique.setdefault((one.delay, tuple(one.A.round(6))), one)
        return list(unique.values())

    def _box_jenkins(self, record: ProcessRecord) -> None:
        """Short fits from every start; then the best of each order and noise, with its delay."""
        target = self.record
        self.record = record
        first = len(self.fits)
        for start in self._starts(record):
            v = disturbance(record, start)
            for orders in NOISES:
                self.fit(with_noise(start, noise_start(v, orders)), SHORT)
        short = sorted(self.fits[first:], key=_bic)
        del self.fits[first:]
        self.short += short if record is target else []
        if not short:
            self.record = target
            return
        for n in (1, 2, 3):
            for _, _, differences in NOISES:
                alike = [
                    one for one in short
                    if one.order == n and one.noise.differences == differences
                    and one.bic < short[0].bic + 10 * WORSE
                ]  # fmt: skip
                for one in alike[: 2 if n == 2 else 1]:
                    fit = self.fit(start_of(one))
                    if fit is not None:
                        self._moved(fit)
        self.record = target

    def _clipped(self, record: ProcessRecord) -> None:
        """Fit Box-Jenkins models to y without its jumps, then to y from there."""
        first = len(self.fits)
        self._box_jenkins(record)
        best = sorted(self.fits[first:], key=_bic)[:4]
        del self.fits[first:]
        for one in best:
            self.fit(start_of(one), 10)
        for one in best[:2]:
            self._weighted(start_of(one))

    def _weighted(self, start: Start) -> None:
        """A fit by Student's likelihood from the start: jumps draw least squares away from it.

        Of a noise that drifts a jump is one error; of one that returns, all that follow.
        """
        starts, noise = [start], start.noise
        if not noise.differences:
            drifting = NoiseModel(np.convolve(noise.C, [1, -DRIFTING]), noise.D, 1)
            starts.append(with_noise(start, drifting))
        for one in starts:
            at_start = fitted(self.record, one, iterations=0)
            if at_start is not None and at_start.heavy:
                self._keep(weighted_fit(self.record, at_start))

    def _robust_starts(self) -> None:
        """Fits by Student's likelihood from the global start with its weights.

        A best model by least squares may hide that tails are heavy: it spreads them.
        """
        first = len(self.fits)
        for scan, weights, differences in robust_starts(self.record, self.costs):
            start = Start(scan.A, scan.B, scan.delay, NoiseModel(ONE, ONE, differences))
            self._student_fit(start, weights, 8)
        for one in sorted(self.fits[first:], key=_bic)[:1]:
            v = without_outliers(disturbance(self.record, one), one.noise.differences)
            start = with_noise(start_of(one), noise_start(v, NOISES[one.noise.differences]))
            self._student_fit(start, self.record.weights(one.e), 8)

    def _student_fit(self, start: Start, weights: Array, iterations: int) -> ProcessFit | None:
        """A fit by Student's likelihood that begins with some weights; it is kept."""
        fit = fitted(self.record, start, weights=weights, iterations=iterations)
        return None if fit is None else self._keep(weighted_fit(self.record, fit))

    def _moved(self, fit: ProcessFit) -> ProcessFit:
        """The fit at the best delay for its poles and noise, if that is another one."""
        if self.is_known:
            return fit
        scan = scanned_again(
            self.record, fit.A, fit.noise.C, fit.noise.whitener, slope=fit.slope,
            summed=fit.summed, count=len(fit.B), delays=self.delays, sinusoid=fit.sinusoid,
        )  # fmt: skip
        value = self.record.steps * np.log(scan.squares[0]) + self.costs
        delay = int(value.argmin())
        if delay == fit.delay:
            return fit
        start = replace(start_of(fit), delay=delay, B=scan.numerators[0, delay])
        again = self.fit(start)
        return again if again is not None and again.bic < fit.bic else fit

    def _best(
        self, count: int, order: int | None = None, *, summed: bool | None = None,
        slope: bool | None = None,
    ) -> list[ProcessFit]:  # fmt: skip
        """The best models so far, of an order, with or without a pole at 1 or a slope."""
        alike = [
            one for one in self.fits
            if order in (None, one.order) and summed in (None, one.summed)
            and slope in (None, one.slope)
        ]  # fmt: skip
        return sorted(alike, key=_bic)[:count]

    def _extended(self) -> None:
        """Orders 2 to 4 from the best of the order below, as long as they pay."""
        for n in range(2, MOST_ORDER + 1):
            below = self._best(1, n - 1, summed=False)
            if not below or below[0].bic > self._best(1)[0].bic + WORSE:
                continue
            before = self._best(1, n, summed=False)
            for fit in below:
                A = np.convolve(fit.A, [1, -0.5])
                for earlier in (0, 1, 2):
                    if fit.delay < earlier or (earlier and self.is_known):
                        continue
                    B = np.convolve(fit.B, [1, -0.5]) if not earlier else fit.B
                    B = np.concatenate([np.zeros(earlier), B])[:n]
                    B = np.concatenate([B, np.zeros(n - len(B))])
                    if np.abs(B).any():
                        longer = replace(start_of(fit), A=A, B=B, delay=fit.delay - earlier)
                        self._alike(longer, fit, 25)
            now = self._best(1, n, summed=False)
            if now and now[0].bic > below[0].bic and (not before or now[0] is before[0]) and n > 2:
                break

    def _integrating(self) -> None:
        """A pole at 1, u summed, where one is so near that the record cannot tell.

        And where the level has a slope: the response of an integrating plant to a step is one.
        """
        slow = self._may_integrate()
        if not slow and not any(one.slope for one in self._best(2)):
            return
        none = NoiseModel(ONE, ONE, 0)
        starts = []
        for one in slow[:2]:
            rest = np.delete(one.poles, int(np.argmin(np.abs(one.poles - 1))))
            A = np.atleast_1d(np.real(np.poly(rest)))
            starts.append(Start(A, one.B, one.delay, none, summed=True))
        summed = np.cumsum(self.record.u)
        pairs = pole_starts(self.record, self.record.y, summed, self.costs)
        scans = [pairs[0][0], pairs[1][0]]
        if self.record.moves <= FEW:  # every dead time has a local minimum
            scans = [one for pair in pairs for one in pair]
        starts += [Start(one.A, one.B, one.delay, none, summed=True) for one in scans]
        short: list[ProcessFit] = []
        first = len(self.fits)
        for start in starts:
            n = max(len(start.A) - 1, 1)
            A = confined(start.A, 0.999) if len(start.A) > 1 else np.array([1.0, -0.3])
            B = np.concatenate([start.B, np.zeros(n + 1)])[: n + 1]
            padded = replace(start, A=A, B=B)
            v = disturbance(self.record, padded)
            for orders in NOISES:
                self.fit(with_noise(padded, noise_start(v, orders)), SHORT)
        short = sorted(self.fits[first:], key=_bic)[:3]
        del self.fits[first:]
        for one in short:
            fit = self.fit(start_of(one))
            if fit is not None:
                self._moved(fit)

    def _sloped(self) -> None:
        """A slope of y beside the best of each order, before a further pole stands for it."""
        for n in range(1, MOST_ORDER):
            for one in self._best(1, n, slope=False):
                self.fit(replace(start_of(one), slope=True), 12)
        if self.record.moves <= FEW or self._may_integrate():
            for one in self._beside(np.linspace(0, 1, self.record.steps), slope=True)[:2]:
                fit = self.fit(start_of(one))
                if fit is not None:
                    self._moved(fit)

    def _may_integrate(self) -> list[ProcessFit]:
        """The best models that have a pole which the record cannot distinguish from 1."""
        limit = 1 - SLOW / self.record.steps
        return [one for one in self._best(6) if not one.armax and _slowest(one) > limit]

    def _beside(self, column: Array, *, slope: bool = False, jump: int = 0) -> list[ProcessFit]:
        """Short fits from the global start with a further part of the level, the best first."""
        record, first, none = self.record, len(self.fits), NoiseModel(ONE, ONE, 0)
        level = np.stack([np.ones(record.steps), column])
        for pair in pole_starts(record, record.y, record.u, self.costs, [column]):
            for one in pair:
                start = Start(one.A, one.B, one.delay, none, slope=slope, jump=jump)
                v = disturbance(record, start)
                v = v - np.linalg.lstsq(level.T, v, rcond=None)[0] @ level
                for orders in NOISES:
                    self.fit(with_noise(start, noise_start(v, orders)), SHORT)
        short = sorted(self.fits[first:], key=_bic)
        del self.fits[first:]
        return short

    def _jumped(self) -> None:
        """Rivals of a record of few moves of u: the level jumps beside the response to u.

        In the row in which a response begins, or where y jumps. With more moves no jump can stand
        for a response.
        """
        record = self.record
        if record.moves > FEW or not self.fits:
            return
        moves, k = np.nonzero(np.diff(record.u))[0] + 1, np.arange(record.steps)
        rows = {int(row) + one.delay + 1 for row in moves for one in self.distinct[:2]}
        first = len(self.fits)
        for row in sorted(rows | set(record.large_jumps(FEW))):
            if not 0 < row < record.steps:
                continue
            for one in self._beside(np.asarray(k >= row, dtype=np.float64), jump=row)[:2]:
                self.fit(start_of(one))
        self._simplified(first)
        self.jumped = sorted(self.fits[first:], key=_bic)
        del self.fits[first:]

    def _richer(self) -> None:
        """Noise of order 2 for the best."""
        for one in self._best(2):
            n_C, n_D, differences = RICHER[one.noise.differences]
            C = np.concatenate([one.noise.C, np.zeros(n_C)])[: n_C + 1]
            D = np.concatenate([one.noise.D, np.zeros(n_D)])[: n_D + 1]
            if len(one.noise.C) < n_C + 1 or len(one.noise.D) < n_D + 1:
                self._alike(with_noise(start_of(one), NoiseModel(C, D, differences)), one)

    def _sinusoids(self) -> None:
        """A narrow D at the peak of the periodogram of what the best models leave."""
        best = self._best(2)
        best += [one for one in self._best(8) if one.order != best[0].order][:1]
        for one in best:
            if one.armax:
                continue
            A = np.convolve(one.A, [1, -CIRCLE]) if one.summed else one.A
            v = disturbance(self.record, Start(A, one.B, one.delay, one.noise))
            omega = peak_frequency(v)
            if not omega:
                continue
            z = np.exp(1j * omega)
            D = np.real(np.poly([RING * z, RING / z]))
            C = np.real(np.poly([NOTCH * z, NOTCH / z]))
            fit = self.fit(with_noise(start_of(one), NoiseModel(C, D, 0)))
            if fit is not None:
                self._moved(fit)
            self._with_sinusoid(start_of(one), omega)

    def _with_sinusoid(self, start: Start, omega: float) -> None:
        """Fits with a sinusoid near a frequency beside the level."""
        first = len(self.fits)
        v = disturbance(self.record, start)
        omega, v = without_sinusoid(v, omega)
        start = replace(start, sinusoid=omega)
        for orders in NOISES:
            self.fit(with_noise(start, noise_start(v, orders)), SHORT)
        short = sorted(self.fits[first:], key=_bic)
        del self.fits[first:]
        for one in short[:1]:
            fit = self.fit(start_of(one))
            if fit is not None:
                self._moved(fit)

    def _armax_of_clipped(self, record: ProcessRecord) -> None:
        """The same on y without its jumps; the results begin a fit by Student's likelihood."""
        target, first = self.record, len(self.fits)
        self.record = record
        self._armax(record, np.inf)
        self.record = target
        best = sorted(self.fits[first:], key=_bic)[:3]
        del self.fits[first:]
        for one in best:
            self._weighted(start_of(one))

    def _armax(self, record: ProcessRecord, worse: float = WORSE, omega: float = 0.0) -> None:
        """Models whose poles may be anywhere; only those with one outside the circle are kept.

        With a sinusoid of a frequency beside the level where `omega` is positive.
        """
        bj = self._best(1)
        first = len(self.fits)
        waves = sinusoids(omega, record.steps) if omega else ()
        starts: list[tuple[float, Start]] = []
        for differences in (0, 1):
            y, u = differenced(record, differences)
            both = joint_innovations(y, u)
            for n in range(1, MOST_ORDER + 1):
                past = [later(both, k) for k in range(1, n + 1)]
                for columns in ((), past):
                    of_y, B, delay, value = regression_start(y, u, columns, n, self.costs)
                    C = confined(np.concatenate([ONE, of_y[n:], np.zeros(n)])[: n + 1], 0.98)
                    A = np.concatenate([ONE, of_y[:n]])
                    noise = NoiseModel(C, ONE, differences)
                    starts.append((value, Start(A, B, delay, noise, armax=True)))
        starts.sort(key=lambda one: one[0])
        regressions = [start for _, start in starts[:4]]
        scanned = [
            Start(one.A, one.B, one.delay, NoiseModel(C, ONE, i), armax=True)
            for one, C, i in unstable_starts(record, self.costs, waves)
        ]
        for start in [replace(one, sinusoid=omega) for one in scanned + regressions]:
            n, differences = len(start.A) - 1, start.noise.differences
            self.fit(start, SHORT)
            v = disturbance(record, start)
            if omega:
                v = without_sinusoid(v, omega)[1]
            for orders in ((n, 1, 0), (n + 1, 0, 1)):
                if orders[2] == differences:
                    self.fit(with_noise(start, noise_start(v, orders)), SHORT)
        short = sorted(self.fits[first:], key=_bic)
        del self.fits[first:]
        limit = bj[0].bic + worse if bj else np.inf
        for one in [one for one in short if np.abs(one.poles).max(initial=0) > 0.995][:4]:
            if one.bic - _reflection(one) < limit:
                self.fit(start_of(one))
        for one in sorted(self.fits[first:], key=_bic)[:1]:
            start = start_of(one)
            noises = [NoiseModel(np.convolve(one.noise.C, [1, 0]), np.array([1.0, -0.5]), 0)]
            if one.noise.differences == 0 and len(one.noise.D) == 1:
                self.fit(with_noise(start, noises[0]))
            for shift in () if self.is_known else (-1, 1, 2):
                B = np.concatenate([[0.0], one.B[:-1]])
                if shift > 0:
                    B = np.concatenate([one.B[shift:], np.zeros(min(shift, len(one.B)))])
                if one.delay + shift >= 0 and np.abs(B).any():
                    self.fit(replace(start, delay=one.delay + shift, B=B))
            if one.order < MOST_ORDER:
                C = np.convolve(one.noise.C, [1, -0.3])
                self.fit(replace(
                    start, A=np.convolve(one.A, [1, -0.3]), B=np.convolve(one.B, [1, -0.3]),
                    noise=replace(one.noise, C=C),
                ))  # fmt: skip
        if not any(has_unstable_part(one) for one in self.fits[first:]):
            del self.fits[first:]

    def _cancelled(self) -> None:
        """Pairs of a pole and a zero near the circle, which fit the noise, moved into D."""
        self._rank()
        for one in list(self.fits[:4]):
            for poles, zeros in cancelling_pairs(roots_of(one.A), roots_of(one.B)):
                rest = np.delete(np.roots(one.A), poles)
                moved = np.roots(one.A)[poles]
                A = np.atleast_1d(np.real(np.poly(rest)))
                others = np.delete(np.roots(one.B), zeros)
                B = one.B[0] * np.atleast_1d(np.real(np.poly(others)))
                if len(A) == 1:
                    continue
                D = np.convolve(one.noise.D, np.real(np.poly(moved)))
                C = np.convolve(one.noise.C, np.real(np.poly(NOTCH * moved)))
                start = replace(start_of(one), A=A, B=B, noise=replace(one.noise, C=C, D=D))
                fit = self.fit(start)
                if fit is not None:
                    self._moved(fit)

    def _undamped(self) -> list[float]:
        """A sinusoid of the disturbance in place of a pair of poles of A or D on the circle.

        And at such roots of a long regression on past y and u: a wrong plant hides the sinusoid in
        what it leaves. The record is searched anew, also where a model has that sinusoid already.
        Returns the frequencies that were tried.
        """
        self._rank()
        of_fits = [
            one for fit in self.fits[:3]
            for one in (fit.poles[: 0 if fit.armax else None], roots_of(fit.noise.D))
        ]  # fmt: skip
        tried: list[float] = []
        near = 10 * RESOLVED / self.record.steps / SAME
        record = self.record
        regression = regression_roots(record.y, record.u[None], np.ones(record.steps, dtype=bool))
        for ringing in (regression, np.concatenate(of_fits)):
            for omega in np.angle(self._on_circle(ringing)).tolist()[:2]:
                if all(abs(omega - other) > near for other in tried):
                    tried.append(omega)
                    self._beside_sinusoid(omega)
        return tried

    def _beside_unstable(self, omegas: list[float]) -> float:
        """The frequency of a sinusoid beside the best model; 0 where there is none.

        An unstable model hides it in further poles: that of the frequencies, or of the peaks of
        periodograms, beside which the starts of unstable models have the least errors.
        """
        record, best = self.record, self._best(1)
        if not best or best[0].sinusoid or not best[0].armax:
            return best[0].sinusoid if best else 0.0
        peaks = {peak_frequency(v) for v in (record.y, residual_of(record, best[0]))}
        slowest = SLOWEST * RESOLVED / record.steps
        omegas = [*omegas[:1], *(one for one in peaks if one > slowest)]
        least, chosen = self._least_of_unstable(()) - ODDS, 0.0
        for omega in omegas:
            value = self._least_of_unstable(sinusoids(omega, record.steps))
            if value < least:
                least, chosen = value, omega
        return chosen

    def _least_of_unstable(self, waves: Sequence[Array]) -> float:
        starts = unstable_starts(self.record, self.costs, waves)
        return min((one.square for one, _, _ in starts), default=np.inf)

    def _on_circle(self, roots: ComplexArray) -> ComplexArray:
        """The roots with positive imaginary part that the record cannot tell from the circle."""
        resolved = RESOLVED / self.record.steps
        return roots[(np.abs(roots) > 1 - resolved / 2) & (roots.imag > SLOW_WAVE * resolved)]

    def _beside_sinusoid(self, omega: float) -> None:
        """Models with a sinusoid of the level, from the global start beside one.

        Twice, since poles and delay follow the sinusoid closely: the second time with the frequency
        that the first has.
        """
        first, short = len(self.fits), list[ProcessFit]()
        for _ in range(2):
            short += self._short_beside(omega)
            if not short:
                return
            short.sort(key=_bic)
            near = RESOLVED / self.record.steps / SAME
            if abs(short[0].sinusoid - omega) < near:
                break
            omega = short[0].sinusoid
        del self.fits[first:]
        best = [[one for one in short if one.summed is integrates] for integrates in (False, True)]
        for one in best[0][:2] + best[1][:2]:
            fit = self.fit(start_of(one))
            if fit is not None:
                self._moved(fit)

    def _short_beside(self, omega: float) -> list[ProcessFit]:
        """Short fits with a sinusoid from the global start beside it."""
        record, first = self.record, len(self.fits)
        waves = sinusoids(omega, record.steps)
        for u, summed in ((record.u, False), (np.cumsum(record.u), True)):
            for pair in pole_starts(record, record.y, u, self.costs, waves):
                for scan in pair:
                    B = np.concatenate([scan.B, np.zeros(len(scan.A))])[: len(scan.A) - 1 + summed]
                    none = NoiseModel(ONE, ONE, 0)
                    start = Start(scan.A, B, scan.delay, none, summed, sinusoid=omega)
                    v = without_sinusoid(disturbance(record, start), omega)[1]
                    for orders in NOISES:
                        self.fit(with_noise(start, noise_start(v, orders)), SHORT)
        return self.fits[first:]

    def _simplified(self, first: int = 0) -> None:
        """The credible models, and those that may be, with fewer coefficients, if that pays.

        All begin with full orders of B and noise: one coefficient too many is a delay that is a
        step too short, or a zero far away, and a rival with fewer is compared with a best model
        that has none too many.
        """
        margin = ODDS + 2 * float(np.log(self.record.steps))
        kinds: dict[tuple[object, ...], ProcessFit] = {}
        fits = sorted(self.fits[first:], key=_bic)
        for one in fits:
            key = (
                one.order, one.delay, one.noise.differences, one.armax, one.summed, one.slope,
                one.jump,
            )  # fmt: skip
            if one.bic < fits[0].bic + margin:
                kinds.setdefault(key, one)
        for one in list(kinds.values())[:SIMPLIFIED]:
            best: ProcessFit | None = one
            while best is not None:
                starts = [*simpler_starts(best, is_known=self.is_known)]
                simpler = [self._alike(start, best) for start in starts]
                better = [fit for fit in simpler if fit is not None and fit.bic < best.bic]
                best = min(better, key=_bic, default=None)

    def _alike(self, start: Start, fit: ProcessFit, iterations: int = SHORT) -> ProcessFit | None:
        """A fit from a start near another fit, by the same likelihood."""
        if not fit.heavy:
            return self.fit(start, iterations)
        return self._student_fit(start, self.record.weights(fit.e), SHORT)

    def _without_cancelled(self) -> None:
        """Leave out models with a pair that all but cancels, where one without it is credible.

        Such a pair is a disturbance of the level or a sinusoid; in a loop it is a hidden mode on
        the circle.
        """
        if not self.fits:
            return
        credible = [one for one in self.fits if one.bic <= self.fits[0].bic + ODDS]
        hidden = {id(one) for one in credible if has_hidden_pair(one)}
        least = min((len(one.poles) for one in credible if id(one) not in hidden), default=None)
        if hidden and least is not None:
            self.fits = [
                one for one in self.fits if id(one) not in hidden or len(one.poles) < least
            ]  # fmt: skip

    def _robust(self) -> None:
        """The best by Student's likelihood, where its tails are heavy."""
        self._rank()
        if not self.fits or not self.fits[0].heavy:
            return
        # Of a noise that drifts a spike is two errors, of white noise one.
        for one in [one for one in self.fits if not one.armax][:2]:
            white = fitted(
                self.record, with_noise(start_of(one), NoiseModel(ONE, ONE, 0)),
                weights=self.record.weights(one.e), iterations=8,
            )  # fmt: skip
            if white is not None:
                self._keep(weighted_fit(self.record, white))
        self.fits.sort(key=_bic)
        kinds: dict[tuple[object, ...], ProcessFit] = {}
        for one in self.fits:
            key = one.order, one.delay, one.noise.differences, one.armax, one.noise.orders
            kinds.setdefault(key, one)
        for one in list(kinds.values())[:REFITTED]:
            if one.bic > self.fits[0].bic + 2 * WORSE:
                break
            cost = float(self.costs[one.delay]) if one.delay < self.delays else ODDS
            fit = weighted_fit(self.record, one)
            if fit is not one:
                self.fits.append(replace(fit, bic=fit.bic + cost))


def _bic(fit: ProcessFit) -> float:
    return fit.bic


def _reflection(fit: ProcessFit) -> float:
    """2 N log of the product of the moduli of the poles outside the circle.

    Where the noise is of the output, predictors of an unstable plant have errors larger than it by
    that product: A v = A* e with A* the reflected A (Forssell and Ljung).
    """
    size = np.abs(fit.poles)
    return 2 * len(fit.e) * float(np.log(size[size > 1]).sum())


def _slowest(fit: ProcessFit) -> float:
    """The largest real pole."""
    poles = fit.poles
    real = poles.real[np.abs(poles.imag) < 1e-9]
    return float(real.max(initial=-1.0))
