"""Compare the logged u with the output of the logged coefficients."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._rounding import UNWRITTEN, Rounding, roundings_of
from rcac_numeric.arrays._validation import number
from rcac_numeric.arrays._values import Result, replaced
from rcac_numeric.checks._conventions import OURS, Convention, convention_of
from rcac_numeric.checks._logs import ControllerLog
from rcac_numeric.checks._regressor import regressor, require_fit
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._regressor import regressor_of
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.plants._saturation import Saturation, limits_of

# Of the largest u until then: another program may compute u in another form. The terms that u is
# the sum of have the rounding of float64 alone; where a loop explodes they exceed u by 1e10.
ROUNDING = 1e-9
# Coefficients that were logged only once may have moved by as much in the last tenth.
STILL = 1e-5
FLOAT64_UNIT = 2.0**-53
# ThetaRows of theta that made u(k), from row k on: k - 1 where row k is the result of step k, k + 1
# where theta is logged one step late.
SHIFTS = (0, 1, -1)


@dataclass(frozen=True, eq=False)
class ControlReplay(Result):
    """u(k) beside Phi(k) theta of the log.

    Attributes
    ----------
    u : array, shape (steps, l_u)
        Phi(k) theta(k) from the logged u, y and r, within the limits of u; for coefficients that
        were logged only once, Phi(k) theta.
    start : int
        The first step that is compared: k_w, or where the regressor is filled; for coefficients
        that were logged only once, the last tenth.
    shift : int
        0 if row k of theta made u(k); 1 if row k is the result of the update of step k, so that
        row k - 1 made u(k); -1 if row k + 1 made it. The better fit decides.
    worst : float
        abs(u - Phi theta) at `worst_step`, relative to the largest abs(Phi) abs(theta) from `start`
        on: the terms that u is the sum of, which may be much larger than u.
    worst_step : int
        The step with the largest difference in units of what the digits leave open there.
    of : {"theta", "the compensator", "the controller with its settings", "the logged theta"}
        The origin of the computed u; the last one where u agrees with the settings of a run and
        theta does not, whose differences are then given.
    tolerance : float
        The largest `worst` that counts as the same u at that step: what the roundings of the log
        leave open, carried through Phi theta, and 1e-9 of the largest u until then; 1e-5 where
        theta was logged once.
    resolution : str
        The roundings of the log in words; empty where they do not matter.
    limited : int
        The number of steps at which the limits of u decide.
    first_difference : int or None
        The first compared step with a difference beyond the tolerance there.
    """

    _ANSWER = "agrees"

    u: Array
    start: int
    shift: int
    worst: float
    worst_step: int
    of: str = "theta"
    tolerance: float = STILL
    resolution: str = ""
    limited: int = 0
    first_difference: int | None = None

    @property
    def agrees(self) -> bool:
        """Whether u is the output of the coefficients, within the tolerance."""
        return self.worst <= self.tolerance

    def __str__(self) -> str:
        rows = ""
        if self.shift > 0:
            rows = "; row k of theta is updated at step k and used at step k + 1"
        elif self.shift < 0:
            rows = "; row k of theta is that of step k - 1"
        if self.shift and not self.agrees:
            row = "k - 1" if self.shift > 0 else "k + 1"
            rows = f", with row {row} of theta for step k; with row k the difference is larger"
        verdict = "is" if self.agrees else "is NOT"
        why = f" from the digits of the log: {self.resolution}" if self.resolution else ""
        allowed = f" (tolerance {self.tolerance:.1g}{why})" if why or not self.agrees else ""
        limits = f"; limited at {self.limited} steps" if self.limited else ""
        return (
            f"u {verdict} the output of {self.of}: worst relative difference {self.worst:.2g} at "
            f"step {self.worst_step}{allowed}, from step {self.start} on{rows}{limits}"
        )


def replay(
    log: ControllerLog,
    structure: Structure,
    *,
    k_w: int | None = None,
    tolerance: float | None = None,
    convention: str | Convention | None = None,
    u_limits: Saturation | tuple[float, float] | None = None,
) -> ControlReplay:
    """Compute the controller's output from the log, and compare the logged u with it.

    Parameters
    ----------
    log : ControllerLog
        With theta.
    structure : Structure
    k_w : int, optional
        First step with u = Phi theta; by default where the regressor is filled.
    tolerance : float, optional
        The relative difference that counts as none; by default what the log's digits leave open.
    convention : str, optional
        What differs from u = Phi theta in the program that wrote the log, as for
        `ControllerLog.converted`; "own u" besides, where Phi holds u before its limits.
    u_limits : (low, high) or Saturation, optional
        Limits of the actuator. Phi holds the limited u; the logged u may be the one before or
        after the limits.

    Raises
    ------
    InputError
        Where sizes do not fit the structure, or the limits have a rate.

    Examples
    --------
    >>> from rcac_numeric import ControllerLog, iir
    >>> from rcac_numeric.checks._replays import replay
    >>> log = ControllerLog(u=[0, 1.0, 0.5], y=[2.0, 0, 0], theta=[0.5, 0.5])
    >>> replay(log, iir(n_c=1)).agrees     # u(k) = u(k-1)/2 + y(k-1)/2
    True
    """
    known = convention_of(convention)
    require_fit(log, structure)
    limits = limits_of_u(log, u_limits)
    return Replayer(log, structure, k_w=k_w, tolerance=tolerance).replay(known, limits)


@dataclass(frozen=True)
class ThetaRows:
    """A converted log, and the coefficients that made u(k) if theta is shifted by some rows."""

    log: ControllerLog
    errors: dict[str, Array | None]
    Theta: Array
    moved: Array
    start: int
    shift: int

    def computed(self, structure: Structure, sum_unit: float) -> tuple[Array, Array, Array]:
        """Phi Theta(k), the size of its terms, and the bound of its error."""
        phi = regressor(structure, self.log)
        off = regressor_of(structure, self.errors, np.abs)
        for column, tap in enumerate(structure.taps):
            if tap.signal == "derived" and structure.derived[tap.component].pole:
                # A running sum adds its roundings up.
                off[:, column] += np.cumsum(sum_unit * np.abs(phi[:, column]))
        size = np.abs(self.Theta)
        bound = row_by_row(np.abs(phi), self.moved) + row_by_row(off, size + self.moved)
        return row_by_row(phi, self.Theta), row_by_row(np.abs(phi), size), bound


class Replayer:
    """Replays of one log by several conventions: its roundings are found once."""

    def __init__(
        self,
        log: ControllerLog,
        structure: Structure,
        *,
        k_w: int | None = None,
        tolerance: float | None = None,
    ) -> None:
        self.log, self.structure, self.errors = log, structure, LogErrors(log, tolerance)
        self.first = structure.n_c if k_w is None else max(k_w, 0)

    def with_structure(self, structure: Structure) -> Replayer:
        """The same log with another structure of as many coefficients."""
        other = copy(self)
        other.structure = structure
        return other

    def replay(
        self, convention: Convention, limits: tuple[Array, Array] | None = None
    ) -> ControlReplay:
        """Compare the logged u with Phi theta by a convention and with limits of u."""
        log, is_after = within(self.log, self.errors, limits)
        replays = []
        own_u = convention.own_u and is_after
        for row_set in self.rows(convention, log):
            rows = row_set
            if own_u and limits is not None:
                rows = _with_own_u(row_set, self.structure, limits)
            replays.append(
                self.errors.compared(
                    *rows.computed(self.structure, self.errors.sum_unit),
                    rows.start,
                    shift=rows.shift,
                    is_still=not log.has_history,
                    count=len(self.structure.taps),
                    limits=limits if is_after else None,
                )
            )
        agreeing = [each for each in replays if each.agrees]
        return agreeing[0] if agreeing else min(replays, key=lambda one: one.worst / one.tolerance)

    def rows(self, convention: Convention, log: ControllerLog | None = None) -> list[ThetaRows]:
        """The log in a convention, for each row of theta that u(k) may belong to."""
        log = (self.log if log is None else log).converted(convention, self.structure)
        assert log.theta is not None
        moved = np.abs(convention.theta(self.errors.theta, self.structure))
        errors = self.errors.of(convention)
        shape = (log.steps, len(self.structure.taps), self.structure.l_u)
        Theta, moved = (
            np.broadcast_to(v, (log.steps, v.shape[-1])).reshape(shape) for v in (log.theta, moved)
        )
        if not log.has_history:
            start = max(self.first, log.steps - max(log.steps // 10, 1))
            self.errors.require_steps(start)
            return [ThetaRows(log, errors, Theta, moved, start, 0)]
        self.errors.require_steps(self.first)
        return [
            ThetaRows(
                log, errors, shifted(Theta, shift), shifted(moved, shift),
                max(self.first, shift), shift,
            )
            for shift in SHIFTS
            if log.steps - (shift < 0) > max(self.first, shift)
        ]  # fmt: skip


def shifted(rows: Array, shift: int) -> Array:
    """The row of theta that u(k) belongs to, for each k; the last row is repeated."""
    if shift > 0:
        return np.concatenate([rows[:shift], rows[:-shift]])[: len(rows)]
    return np.concatenate([rows[-shift:], rows[shift:]])[: len(rows)] if shift else rows


def limits_of_u(
    log: ControllerLog, u_limits: Saturation | tuple[float, float] | None
) -> tuple[Array, Array] | None:
    """The limits of each component of u; None without limits."""
    saturation = limits_of(u_limits)
    if saturation is None:
        return None
    low, high, rate = saturation.bounds(log.u.shape[1])
    if np.isfinite(rate).any():
        raise InputError(
            "u_limits has a rate; a log is compared with limits of u alone. Give (low, high)."
        )
    return low, high


def within(
    log: ControllerLog, errors: LogErrors, limits: tuple[Array, Array] | None
) -> tuple[ControllerLog, bool]:
    """The log with u within the limits, and whether it was logged after them."""
    error = errors.signals["u"]
    if limits is None or error is None:
        return log, True
    applied = np.clip(log.u, *limits)
    is_after = bool(np.all(np.abs(applied - log.u) <= error))
    return replaced(log, u=applied), is_after


def _with_own_u(rows: ThetaRows, structure: Structure, limits: tuple[Array, Array]) -> ThetaRows:
    """The rows with u as it was before the limits, where they decide, and a bound of its error."""
    u, error = rows.log.u.copy(), rows.errors["u"]
    assert error is not None
    error = error.copy()
    phi = regressor(structure, rows.log)
    off = regressor_of(structure, rows.errors, np.abs)
    past = [(j, tap) for j, tap in enumerate(structure.taps) if tap.signal == "u"]
    is_limited = at_limits(u, error, limits).any(axis=1)
    for k in np.flatnonzero(is_limited):
        for j, tap in past:
            if tap.delay <= k:
                phi[k, j] = u[k - tap.delay, tap.component]
                off[k, j] = error[k - tap.delay, tap.component]
        computed = phi[k] @ rows.Theta[k]
        is_beyond = np.clip(computed, *limits) != computed
        u[k] = np.where(is_beyond, computed, u[k])
        bound = np.abs(phi[k]) @ rows.moved[k] + off[k] @ (np.abs(rows.Theta[k]) + rows.moved[k])
        error[k] = np.where(is_beyond, bound, error[k])
    return replace(rows, log=replaced(rows.log, u=u), errors={**rows.errors, "u": error})


def at_limits(u: Array, error: Array, limits: tuple[Array, Array]) -> Array:
    """Whether each u is at a limit, within its rounding."""
    low, high = limits
    return np.asarray((u <= low + error) | (u >= high - error))


def replay_compensator(
    log: ControllerLog,
    compensator: Compensator,
    *,
    k_w: int | None = None,
    tolerance: float | None = None,
    u_limits: Saturation | tuple[float, float] | None = None,
    convention: Convention = OURS,
) -> ControlReplay:
    """Replay a compensator that is constant since k_w, by default over the last tenth.

    It reads the signal of the convention.
    """
    errors, limits = LogErrors(log, tolerance), limits_of_u(log, u_limits)
    log = log.reading(convention)
    reads_r = log.r is not None and compensator.l_y != log.y.shape[1]
    log, is_after = within(log, errors, limits)
    bounds = errors.of(convention)
    outputs, terms, bound = (np.zeros_like(log.u) for _ in range(3))
    count = 0
    for name, coefficients, first in (("u", compensator.past_u, 1), ("y", compensator.past_y, 0)):
        names = ("y", "r") if name == "y" and reads_r else (name,)
        signal = np.hstack([getattr(log, each) for each in names])
        off = np.hstack([error for each in names if (error := bounds[each]) is not None])
        for lag, matrix in enumerate(coefficients, first):
            past = slice(0, max(log.steps - lag, 0))
            outputs[lag:] += signal[past] @ matrix.T
            terms[lag:] += np.abs(signal[past]) @ np.abs(matrix).T
            bound[lag:] += off[past] @ np.abs(matrix).T
            count += matrix.shape[1]
    since = log.steps - max(log.steps // 10, 1) if k_w is None else k_w
    start = max(len(compensator.past_u), since)
    return errors.compared(
        outputs, terms, bound, start, of="the compensator", is_still=True, count=count,
        limits=limits if is_after else None,
    )  # fmt: skip


class LogErrors:
    """Bounds of the rounding errors of a log's signals and of theta, from its digits."""

    def __init__(self, log: ControllerLog, tolerance: float | None) -> None:
        if tolerance is not None and not number(tolerance, "tolerance") > 0:
            raise InputError(f"tolerance = {tolerance} must be positive.")
        self.log, self.tolerance = log, tolerance
        names = ("u", "y", "z", "r", "theta")
        values = {name: getattr(log, name) for name in names}
        self.roundings = roundings_of({n: v for n, v in values.items() if v is not None})
        self.signals: dict[str, Array | None] = {
            name: None if value is None else self._error(name, value)
            for name, value in values.items()
        }

    def _error(self, name: str, values: Array) -> Array:
        is_measured = name in ("y", "z", "r")
        parts = [values] if values.ndim == 1 else list(values.T)
        bounds = [
            one.error(part, with_step=not is_measured) + unwritten(one, part)
            for one, part in zip(self.roundings[name], parts, strict=True)
        ]
        return bounds[0] if values.ndim == 1 else np.column_stack(bounds)

    def of(self, convention: Convention) -> dict[str, Array | None]:
        """The bounds of u, of the signal that a convention reads, and of r."""
        errors = self.signals
        y = errors["y"]
        if convention.signal == "z":
            y = errors["z"]
        elif convention.signal != "y":
            assert y is not None and errors["r"] is not None
            y = y + errors["r"]
        return {"u": errors["u"], "y": y, "r": errors["r"]}

    @property
    def theta(self) -> Array:
        """The bound for theta."""
        error = self.signals["theta"]
        assert error is not None
        return error

    @property
    def sum_unit(self) -> float:
        """The relative rounding of an addition in the arithmetic that the numbers show."""
        if self.tolerance is not None:
            return 0.0
        names = ("u", "theta") if "theta" in self.roundings else ("u",)
        units = [one.sum_unit for name in names for one in self.roundings[name]]
        return max(FLOAT64_UNIT, *units)

    @property
    def floor(self) -> Array:
        """1e-9 of the largest u until each step, shape (steps, 1)."""
        return ROUNDING * np.maximum.accumulate(np.abs(self.log.u).max(axis=1))[:, None]

    def digits(self, terms: Array, bound: Array, count: int) -> Array:
        """The difference from Phi theta that the digits of the log leave open at each step."""
        error = self.signals["u"]
        assert error is not None
        return np.asarray(bound + error + (2 * count + 8) * self.sum_unit * terms)

    def require_steps(self, start: int) -> None:
        """Raise an error if no step from `start` on was logged."""
        if start >= self.log.steps:
            raise InputError(
                f"the log of {self.log.steps} steps ends before step {start}, from which u could "
                "be compared with Phi theta; a longer log is needed."
            )

    def compared(
        self,
        u_computed: Array,
        terms: Array,
        bound: Array,
        start: int,
        *,
        shift: int = 0,
        of: str = "theta",
        is_still: bool = False,
        count: int = 1,
        limits: tuple[Array, Array] | None = None,
    ) -> ControlReplay:
        """Compare the logged u with the computed one, step by step, within the roundings."""
        self.require_steps(start)
        u, limited = self.log.u, 0
        compared = slice(start, self.log.steps - (shift < 0))  # the last row has no row after it
        if limits is not None:
            inside = np.clip(u_computed, *limits)
            limited = int(np.any(inside != u_computed, axis=1)[compared].sum())
            u_computed = inside
        size = max(float(np.abs(u[compared]).max()), float(terms[compared].max())) or 1.0
        gaps, words = np.abs(u - u_computed) / size, ""
        if self.tolerance is not None:
            allowed = np.full_like(gaps, self.tolerance)
        else:
            digits = self.digits(terms, bound, count) / size
            floor = np.full_like(gaps, STILL) if is_still else self.floor / size
            allowed = np.maximum(floor + digits, np.finfo(float).tiny)
            if float(digits[compared].max()) > float(floor[compared].max()):
                words = self._words(of)
        excess = (gaps / allowed)[compared].max(axis=1)
        step = start + int(np.argmax(excess))
        component = int(np.argmax(gaps[step] / allowed[step]))
        beyond = np.flatnonzero(excess > 1)
        return ControlReplay(
            u=u_computed, start=start, shift=shift, worst=float(gaps[step, component]),
            worst_step=step, of=of, tolerance=float(allowed[step, component]), resolution=words,
            limited=limited, first_difference=start + int(beyond[0]) if len(beyond) else None,
        )  # fmt: skip

    def _words(self, of: str) -> str:
        names = [n for n in ("u", "y", "r", "theta") if n in self.roundings]
        words = []
        for name in names:
            kinds = list(dict.fromkeys(str(d) for d in self.roundings[name] if not d.is_exact))
            if kinds and (name != "theta" or of == "theta"):
                words.append(f"{name} {' or '.join(kinds)}")
        return ", ".join(words)


def unwritten(rounding: Rounding, values: Array) -> Array:
    """The bound of the error of texts with 12 to 15 digits, which look exact; 0 for float64."""
    sizes = np.abs(values)
    is_text = rounding.is_exact and all(float(f"{one:.15g}") == one for one in sizes[:200])
    return sizes * (0.5 * UNWRITTEN if is_text else 0.0)


def row_by_row(phi: Array, Theta: Array) -> Array:
    """phi(k) Theta(k) at every step."""
    return np.asarray(np.einsum("kj,kji->ki", phi, Theta))
