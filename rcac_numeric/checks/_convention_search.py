"""Find the convention by which the logged u is the output of the logged coefficients."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._values import Result, replaced
from rcac_numeric.checks._conventions import (
    NO_YES,
    OURS,
    SIGNALS,
    Convention,
    Signal,
    differences,
    orders,
)
from rcac_numeric.checks._logs import ControllerLog
from rcac_numeric.checks._regressor import regressor
from rcac_numeric.checks._replays import (
    SHIFTS,
    ControlReplay,
    Replayer,
    ThetaRows,
    at_limits,
    replay_compensator,
    row_by_row,
    shifted,
)
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.plants._saturation import Saturation

Limits = tuple[float, float]
ROWS = 200  # steps that screen the conventions
REPLAYED = 8  # conventions with the least residual, which are replayed
# A step tells conventions apart where abs(Phi) abs(theta) is so large beside its median.
MOVING = 1e-3
# An actuator's limit is an extreme value of u that so many steps have.
STAYS = 2
LONG = 20  # moving steps for which our convention must hold before a first difference is named
FREE = 3  # steps without a limit for each coefficient, before limits are believed
SURE = 4.0  # standard errors within which a fitted limit is replaced by a number of fewer digits
SAME = 1e-5  # relative difference of two signals that are one, but for its rounding
# Of the steps, those with the least residual: where limits act or samples are lost, some steps
# follow no convention.
QUANTILES = (0.5, 0.2)


@dataclass(frozen=True, eq=False)
class ConventionMatch(Result):
    """A convention by which the log replays, or the one that comes closest.

    Attributes
    ----------
    convention : Convention
    replay : ControlReplay
    u_limits : (low, high) or None
        Limits of u with which it replays; infinite where one side has none.
    """

    convention: Convention
    replay: ControlReplay
    u_limits: Limits | None = None

    @property
    def options(self) -> str:
        """The options of `rcac check`."""
        words = [f'--convention "{self.convention}"'] if self.convention != OURS else []
        if self.u_limits is not None:
            words.append(f"--u-limits {self.u_limits[0]!r},{self.u_limits[1]!r}")
        return " ".join(words)

    @property
    def arguments(self) -> str:
        """The arguments of `check_controller`."""
        words = [f'convention="{self.convention}"'] if self.convention != OURS else []
        if self.u_limits is not None:
            low, high = (
                repr(v) if np.isfinite(v) else f"{'-' * bool(v < 0)}np.inf" for v in self.u_limits
            )
            words.append(f"u_limits=({low}, {high})")
        return ", ".join(words)

    def __str__(self) -> str:
        words = [self.convention.description] if self.convention != OURS else []
        if self.u_limits is not None:
            words.append(f"u is limited to [{self.u_limits[0]:.6g}, {self.u_limits[1]:.6g}]")
        if self.replay.shift:
            row = "k - 1" if self.replay.shift > 0 else "k + 1"
            words.append(f"row {row} of theta made u(k)")
        return "; ".join(words) or OURS.description


@dataclass(frozen=True, eq=False)
class ConventionSearch(Result):
    """The conventions by which the logged u is the output of the logged coefficients.

    Attributes
    ----------
    matches : tuple of ConventionMatch
        Those that replay within the roundings of the log, the one with the fewest differences from
        ours first. This log does not distinguish two that replay.
    tried : int
        The number of conventions.
    closest : ConventionMatch or None
        The one with the least misfit, if none replays.
    ours : ControlReplay
        The replay by our convention.
    of : {"theta", "the compensator"}
    """

    matches: tuple[ConventionMatch, ...]
    tried: int
    closest: ConventionMatch | None
    ours: ControlReplay
    of: str = "theta"

    @property
    def is_unique(self) -> bool:
        """Whether exactly one convention replays."""
        return len(self.matches) == 1

    def _moving(self, step: int) -> int:
        """The number of compared steps before a step at which u is not nearly zero."""
        u = np.abs(self.ours.u).max(axis=1)
        return int(np.sum(u[self.ours.start : step] > MOVING * u.max()))

    def __str__(self) -> str:
        if not self.matches:
            controller = "Phi theta" if self.of == "theta" else "the output of the controller"
            misfit = (
                f"largest relative difference {self.ours.worst:.2g} at step {self.ours.worst_step}"
            )
            close = ""
            if self.closest is not None and self.closest.replay.worst < self.ours.worst:
                close = (
                    f"; closest, with relative difference {self.closest.replay.worst:.2g}: "
                    f"{self.closest}"
                )
            if (step := self.ours.first_difference) is not None and self._moving(step) >= LONG:
                row = {0: "", 1: ", with row k - 1 of theta", -1: ", with row k + 1 of theta"}
                return (
                    f"u = {controller} holds up to step {step - 1}{row[self.ours.shift]}, and "
                    f"differs first at step {step}; {misfit}. No other of {self.tried} "
                    f"conventions holds{close}. Look at u, y and theta from step {step} on."
                )
            return (
                f"The log does not contain u = {controller} under any of {self.tried} conventions: "
                f"{misfit}{close}. Is u the computed one, without dither?"
            )
        first = self.matches[0]
        size = f"worst relative difference {first.replay.worst:.2g}"
        if self.is_unique:
            return (
                f"The log has another convention: {first} ({size}). Repeat the check with "
                f"{first.options}; in Python check_controller(..., {first.arguments})."
            )
        each = " or ".join(f"{one} [{one.options}]" for one in self.matches)
        return (
            f"The log replays by {len(self.matches)} conventions, and does not decide which: "
            f"{each}. Choose one; in Python check_controller(..., {first.arguments})."
        )


def search_conventions(
    replayer: Replayer, ours: ControlReplay, limits: tuple[Array, Array] | None = None
) -> ConventionSearch:
    """Try the conventions that differ between programs on a log.

    Every combination of signs, of the signal that is read, of the order of theta and of the row of
    theta is screened by the residual u - Phi theta at some hundred steps; those with the least are
    replayed. Limits of u are tried where u stays at its largest or smallest value, and, where u
    was logged before them, found by least squares.

    Parameters
    ----------
    replayer : Replayer
        The log with its structure.
    ours : ControlReplay
        The replay by our convention.
    limits : (low, high), optional
        Known limits of each component of u.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric import ControllerLog, iir
    >>> from rcac_numeric.checks._convention_search import search_conventions
    >>> from rcac_numeric.checks._conventions import OURS
    >>> from rcac_numeric.checks._replays import Replayer
    >>> rng = np.random.default_rng(0)
    >>> y, u, theta = rng.standard_normal(40), np.zeros(40), rng.uniform(-0.5, 0.5, (40, 2))
    >>> for k in range(1, 40):
    ...     u[k] = theta[k] @ [-y[k - 1], u[k - 1]]
    >>> replayer = Replayer(ControllerLog(u, y, theta=theta), iir(1))
    >>> search = search_conventions(replayer, replayer.replay(OURS))
    >>> str(search.matches[0].convention)
    '-y, y first'
    """
    screen = _Screen(replayer.log, replayer.structure, replayer.first)
    candidates = screen.candidates()
    likely = sorted(
        {
            int(index)
            for scores in screen.scores()
            for index in np.argsort(scores, kind="stable")[:REPLAYED]
        }
    )
    replays = [_match(replayer, candidates[index], limits) for index in likely]
    if limits is None and not any(one.replay.agrees for one in replays):
        replays += [one for index in likely for one in _limited(replayer, candidates[index])]
    matches = _distinct(replayer, [one for one in replays if one.replay.agrees])
    closest = None if matches else min(replays, key=lambda one: one.replay.worst)
    tried = len(candidates) * len(screen.theta)
    return ConventionSearch(matches, tried, closest, ours)


def search_signs(
    log: ControllerLog,
    compensator: Compensator,
    ours: ControlReplay,
    *,
    k_w: int | None = None,
    tolerance: float | None = None,
    u_limits: Saturation | Limits | None = None,
) -> ConventionSearch:
    """Try the signs, the signal that is read, and limits of u on a log of a fixed compensator."""
    reads_r = log.r is not None and compensator.l_y != log.y.shape[1]
    limits = [u_limits]
    if u_limits is None and (bounds := stays_at(log.u)) is not None:
        limits.append((float(bounds[0][0]), float(bounds[1][0])))
    replays = []
    for pair, signal, negative in itertools.product(
        limits, SIGNALS[:1] if reads_r else read_signals(log), (False, True)
    ):
        convention = Convention(negative_y=negative, signal=signal)
        replayed = replay_compensator(
            log, convention.compensator(compensator),
            k_w=k_w, tolerance=tolerance, u_limits=pair, convention=convention,
        )  # fmt: skip
        fitted = pair if u_limits is None and not isinstance(pair, Saturation) else None
        replays.append(ConventionMatch(convention, replayed, fitted))
    matches = [one for one in replays if one.replay.agrees]
    without_limits = [one for one in matches if one.u_limits is None]
    closest = None if matches else min(replays, key=lambda one: one.replay.worst)
    return ConventionSearch(
        tuple(without_limits or matches), len(replays), closest, ours, "the compensator"
    )


def read_signals(log: ControllerLog) -> Iterator[Signal]:
    """The signals that the controller may read, those that repeat another one apart."""
    known = [log.y]
    yield "y"
    for name in SIGNALS[1:]:
        other = log.z if name == "z" else log.r
        if other is None or other.shape != log.y.shape:
            continue
        values = log.read_signal(Convention(signal=name))
        if any(is_same(values, sign * one) for one in known for sign in (1, -1)):
            continue
        known.append(values)
        yield name


def is_same(one: Array, other: Array) -> bool:
    """Whether two signals are one, but for their rounding."""
    if one.shape != other.shape:
        return False
    return float(np.abs(one - other).max()) <= SAME * float(np.abs(one).max())


def _match(
    replayer: Replayer,
    convention: Convention,
    limits: tuple[Array, Array] | None,
    pair: Limits | None = None,
) -> ConventionMatch:
    return ConventionMatch(convention, replayer.replay(convention, limits), pair)


def _distinct(
    replayer: Replayer, matches: Sequence[ConventionMatch]
) -> tuple[ConventionMatch, ...]:
    """Matches with another controller each, the one with the fewest differences first."""
    distinct: dict[bytes, ConventionMatch] = {}
    for one in sorted(matches, key=lambda one: differences(one.convention)):
        log = replayer.log.converted(one.convention, replayer.structure)
        assert log.theta is not None
        own_u = one.convention.own_u and one.replay.limited > 0
        key = (log.theta + 0.0).tobytes() + log.y.tobytes() + bytes([own_u])
        distinct.setdefault(key, one)
    return tuple(distinct.values())


class _Screen:
    """The residual u - Phi theta of many conventions at some steps of a log."""

    def __init__(self, log: ControllerLog, structure: Structure, first: int) -> None:
        assert log.theta is not None
        self.log, self.structure = log, structure
        first = max(first, 1)
        if not log.has_history:
            first = max(first, log.steps - max(log.steps // 10, 1))
        steps = self._usual(np.arange(first, log.steps - log.has_history))
        self.rows = steps[np.linspace(0, len(steps) - 1, min(len(steps), ROWS)).astype(int)]
        self.past = np.array([tap.signal == "u" for tap in structure.taps])
        wide = np.broadcast_to(log.theta, (log.steps, log.theta.shape[-1]))
        shifts = SHIFTS if log.has_history else (0,)
        self.theta = [shifted(wide, shift)[self.rows] for shift in shifts]
        self.u = log.u[self.rows]
        self.orders = list(orders(structure))
        self.phi: dict[Signal, Array] = {}
        for signal in read_signals(log):
            read = log.read_signal(Convention(signal=signal))
            self.phi[signal] = regressor(structure, replaced(log, y=read))[self.rows]

    def _usual(self, steps: NDArray[Any]) -> NDArray[Any]:
        """The steps before which no limit of u seems to act, if they are many."""
        limits = stays_at(self.log.u)
        if limits is None or not len(steps):
            return steps
        is_limited = np.any(at_limits(self.log.u, np.zeros_like(self.log.u), limits), axis=1)
        recent = np.convolve(is_limited, np.ones(self.structure.n_c + 1))[: self.log.steps] > 0.5
        for near in (recent, is_limited):
            away = steps[~np.asarray(near)[steps]]
            if len(away) >= max(20, self.structure.l_theta):
                return np.asarray(away)
        return steps

    @property
    def signs(self) -> list[tuple[bool, bool]]:
        """Whether theta acts on -u and on -y; a structure without past u has no sign of it."""
        return list(itertools.product(NO_YES[: 1 + bool(self.past.any())], NO_YES))

    def candidates(self) -> list[Convention]:
        """Every convention, without the limits of u."""
        return [
            replace(order, signal=signal, negative_u=u, negative_y=y)
            for signal in self.phi
            for order in self.orders
            for u, y in self.signs
        ]

    def scores(self) -> Array:
        """Quantiles of the residual of each candidate, for its best row of theta; a row each."""
        best: list[Array] = []
        signs = np.where(self.signs, -1.0, 1.0)[:, :, None, None]
        for phi in self.phi.values():
            for order in self.orders:
                score = np.full((len(QUANTILES), len(signs)), np.inf)
                for past, read, size in self._parts(phi, order.positions(self.structure)):
                    moving = size > MOVING * np.median(size)
                    computed = signs[:, 0] * past + signs[:, 1] * read
                    with np.errstate(over="ignore"):  # an infinite residual is the worst one
                        residual = np.sort((np.abs(self.u - computed) / size)[:, moving], axis=1)
                    places = [int(q * residual.shape[1]) for q in QUANTILES]
                    score = np.minimum(score, residual[:, places].T)
                best.append(score)
        return np.concatenate(best, axis=1)

    def _parts(self, phi: Array, positions: Array) -> Iterator[tuple[Array, Array, Array]]:
        """The parts of Phi theta by u and by the read signal, and their size, for each shift."""
        shape = (-1, len(self.structure.taps), self.structure.l_u)
        for theta in self.theta:
            Theta = theta[:, positions].reshape(shape)
            past = row_by_row(phi * self.past, Theta)
            read = row_by_row(phi * ~self.past, Theta)
            size = row_by_row(np.abs(phi), np.abs(Theta))
            yield past, read, np.maximum(size, np.finfo(float).tiny)


# Limits of u.


def stays_at(u: Array) -> tuple[Array, Array] | None:
    """The smallest and the largest u, where it has one of them at several steps; else None.

    The other one is a limit, too, or it is u at that step and as good as none.
    """
    low, high = float(u.min()), float(u.max())
    often = max(np.sum(u == limit, axis=0).max() for limit in (low, high))
    if not low < high or often < STAYS:
        return None
    width = u.shape[1]
    return np.full(width, low), np.full(width, high)


def _limited(replayer: Replayer, convention: Convention) -> Iterator[ConventionMatch]:
    """The replays of a convention with the limits of u that the log suggests."""
    log, structure = replayer.log, replayer.structure
    if (limits := stays_at(log.u)) is not None:
        low, high = float(limits[0][0]), float(limits[1][0])
        for own_u in NO_YES[: 1 + any(tap.signal == "u" for tap in structure.taps)]:
            one = replace(convention, own_u=own_u)
            match = _between(replayer, one, low, high)
            if log.steps - match.replay.limited < FREE * structure.l_theta:
                continue
            if match.replay.agrees:  # a limit that never acts is none
                sides = [(-np.inf, high), (low, np.inf)]
                one_sided = [_between(replayer, one, *side) for side in sides]
                match = next((side for side in one_sided if side.replay.agrees), match)
            yield match
    lags = [j for j, tap in enumerate(structure.taps) if tap.signal == "u" and tap.delay == 1]
    if structure.l_u > 1 or not lags:
        return
    for rows in replayer.rows(convention):
        for before in _limits_before(replayer, rows, lags[0]):
            match = _between(replayer, convention, *before)
            yield match
            if match.replay.agrees:
                break


def _between(
    replayer: Replayer, convention: Convention, low: float, high: float
) -> ConventionMatch:
    width = replayer.log.u.shape[1]
    limits = np.full(width, low), np.full(width, high)
    return _match(replayer, convention, limits, (low, high))


def _limits_before(replayer: Replayer, rows: ThetaRows, last: int) -> tuple[Limits, ...]:
    """The limits that Phi obeys where u was logged before them, of one input; none, or two pairs.

    At the first step at which u differs from Phi theta, u(k-1) is the only past value beyond a
    limit, which follows; then all steps determine both by least squares, weighted by the roundings
    of the rows. The first pair has the fewest digits within the standard errors of the second.
    """
    structure, u = replayer.structure, replayer.log.u
    limits, open_ = np.array([-np.inf, np.inf]), np.zeros(2)
    compared = np.zeros(len(u), dtype=bool)
    compared[rows.start : len(u) - (rows.shift < 0)] = True
    for _ in range(2):
        gaps, allowed = _gaps(replayer, rows, limits, open_)
        broken = np.flatnonzero((np.abs(gaps) > allowed) & compared)
        if not len(broken):
            break
        k = int(broken[0])
        weight, value = float(rows.Theta[k, last, 0]), float(u[k - 1, 0])
        if k == 0 or weight == 0:
            return ()
        limit = float(np.clip(value, *limits)) + float(gaps[k]) / weight
        side = int(value > 0)
        if limit * value <= 0 or abs(limit) >= abs(value) or np.isfinite(limits[side]):
            return ()
        open_[side] = float(allowed[k]) / abs(weight)
        limits[side] = _shortest(limit, float(open_[side]))
    if np.isinf(limits).all():
        return ()
    # u - Phi theta is linear in the limits where they act.
    past = np.array([tap.signal == "u" for tap in structure.taps])
    phi, Theta = regressor(structure, rows.log), rows.Theta[:, :, 0]
    is_low, is_high = (phi < limits[0]) & past, (phi > limits[1]) & past
    columns = np.column_stack([(Theta * acts).sum(axis=1) for acts in (is_low, is_high)])
    rest = u[:, 0] - (Theta * np.where(is_low | is_high, 0.0, phi)).sum(axis=1)
    acting = columns.any(axis=1) & compared
    weights = 1 / np.maximum(_gaps(replayer, rows, limits, open_)[1], np.finfo(float).tiny)[acting]
    X, values = columns[acting] * weights[:, None], rest[acting] * weights
    fit = np.linalg.lstsq(X, values, rcond=None)[0]
    spread = float(np.sqrt(np.mean((values - X @ fit) ** 2))) if len(values) else 0.0
    errors = SURE * spread * np.sqrt(np.diag(np.linalg.pinv(X.T @ X)))
    fit = np.where(np.isfinite(limits), fit, limits)
    short = [_shortest(float(v), float(e)) for v, e in zip(fit, errors, strict=True)]
    return (short[0], short[1]), (float(fit[0]), float(fit[1]))


def _gaps(replayer: Replayer, rows: ThetaRows, limits: Array, open_: Array) -> tuple[Array, Array]:
    """U - Phi theta with u within limits of some error, and the size that is rounding."""
    u, error = replayer.log.u, replayer.errors.signals["u"]
    assert error is not None
    moved = error + np.where(u < limits[0], open_[0], 0) + np.where(u > limits[1], open_[1], 0)
    inside = replace(
        rows, log=replaced(rows.log, u=np.clip(u, *limits)), errors={**rows.errors, "u": moved}
    )
    errors = replayer.errors
    computed, terms, bound = inside.computed(replayer.structure, errors.sum_unit)
    allowed = errors.floor + errors.digits(terms, bound, len(replayer.structure.taps))
    return (u - computed)[:, 0], allowed[:, 0]


def _shortest(value: float, error: float) -> float:
    """The number with the fewest digits within an error."""
    texts = (float(f"{value:.{digits}g}") for digits in range(1, 17))
    return next((v for v in texts if abs(v - value) <= max(error, 1e-12 * abs(value))), value)
