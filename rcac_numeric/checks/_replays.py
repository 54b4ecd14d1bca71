"""Compare the logged u with the output of the logged coefficients."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import number
from rcac_numeric.arrays._values import Result
from rcac_numeric.checks._logs import ControllerLog
from rcac_numeric.checks._regressor import regressor, require_fit
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._regressor import regressor_of
from rcac_numeric.controllers._structure import Structure

# Rounding of the same sum in float64, added in another order.
ROUNDING = 1e-9
# Coefficients that were logged only once may have moved by as much in the last tenth.
STILL = 1e-5


@dataclass(frozen=True, eq=False)
class ControlReplay(Result):
    """u(k) beside Phi(k) theta of the log.

    Attributes
    ----------
    u : array, shape (steps, l_u)
        Phi(k) theta(k) from the logged u, y and r; for coefficients that were logged only once,
        Phi(k) theta.
    start : int
        The first step that is compared: k_w, or where the regressor is filled; for coefficients
        that were logged only once, the last tenth.
    shift : int
        0 if row k of theta made u(k); 1 if row k is the result of the update of step k, so that
        row k - 1 made u(k). The better fit decides.
    worst : float
        Largest abs(u - Phi theta) from `start` on, relative to the largest abs(Phi) abs(theta)
        there: the terms that u is the sum of, which may be much larger than u.
    worst_step : int
    of : {"theta", "the compensator"}
        What u was computed from.
    tolerance : float
        The largest `worst` that counts as the same u: what the digits of the log leave open,
        carried through Phi theta; 1e-9 for a log in float64, 1e-5 where theta was logged once.
    resolution : str
        The digits of the log in words; empty where they do not matter.
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

    @property
    def agrees(self) -> bool:
        """Whether u is the output of the coefficients, within the tolerance."""
        return self.worst <= self.tolerance

    def __str__(self) -> str:
        rows = ""
        if self.shift and self.agrees:
            rows = "; row k of theta is updated at step k and used at step k + 1"
        elif self.shift:
            rows = ", with row k - 1 of theta for step k; with row k the difference is larger"
        verdict = "is" if self.agrees else "is NOT"
        why = f" from the digits of the log: {self.resolution}" if self.resolution else ""
        allowed = f" (tolerance {self.tolerance:.1g}{why})" if why or not self.agrees else ""
        return (
            f"u {verdict} the output of {self.of}: worst relative difference {self.worst:.2g} at "
            f"step {self.worst_step}{allowed}, from step {self.start} on{rows}"
        )


def replay(
    log: ControllerLog,
    structure: Structure,
    *,
    k_w: int | None = None,
    tolerance: float | None = None,
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

    Raises
    ------
    InputError
        Where sizes do not fit the structure.

    Examples
    --------
    >>> from rcac_numeric import ControllerLog, iir
    >>> from rcac_numeric.checks._replays import replay
    >>> log = ControllerLog(u=[0, 1.0, 0.5], y=[2.0, 0, 0], theta=[0.5, 0.5])
    >>> replay(log, iir(n_c=1)).agrees     # u(k) = u(k-1)/2 + y(k-1)/2
    True
    """
    require_fit(log, structure)
    assert log.theta is not None
    taps, first = len(structure.taps), structure.n_c if k_w is None else max(k_w, 0)
    errors = LogErrors(log, tolerance)
    phi = regressor(structure, log)
    off = regressor_of(structure, errors.signals, np.abs)
    if not log.has_history:
        start = max(first, log.steps - max(log.steps // 10, 1))
        shape: tuple[int, ...] = (taps, structure.l_u)
        Theta, moved = log.theta.reshape(shape), errors.theta.reshape(shape)
        terms = np.abs(phi) @ np.abs(Theta)
        bound = np.abs(phi) @ moved + off @ (np.abs(Theta) + moved)
        return errors.compared(phi @ Theta, terms, bound, start, floor=STILL)
    shape = (log.steps, taps, structure.l_u)
    Theta, moved = log.theta.reshape(shape), errors.theta.reshape(shape)
    candidates = []
    for shift in (0, 1):
        rows, rows_off = (v[: log.steps - shift] for v in (Theta, moved))
        u, terms, bound = (np.zeros_like(log.u) for _ in range(3))
        past, past_off = phi[shift:], off[shift:]
        u[shift:] = _row_by_row(past, rows)
        terms[shift:] = _row_by_row(np.abs(past), np.abs(rows))
        bound[shift:] = _row_by_row(np.abs(past), rows_off)
        bound[shift:] += _row_by_row(past_off, np.abs(rows) + rows_off)
        candidates.append(errors.compared(u, terms, bound, max(first, shift), shift=shift))
    return min(candidates, key=lambda each: (each.worst, each.shift))


def replay_compensator(
    log: ControllerLog,
    compensator: Compensator,
    *,
    k_w: int | None = None,
    tolerance: float | None = None,
) -> ControlReplay:
    """Replay a compensator that is constant since k_w, by default over the last tenth."""
    errors = LogErrors(log, tolerance)
    reads_r = log.r is not None and compensator.l_y != log.y.shape[1]
    outputs, terms, bound = (np.zeros_like(log.u) for _ in range(3))
    for name, coefficients, first in (("u", compensator.past_u, 1), ("y", compensator.past_y, 0)):
        names = ("y", "r") if name == "y" and reads_r else (name,)
        signal = np.hstack([getattr(log, each) for each in names])
        off = np.hstack([error for each in names if (error := errors.signals[each]) is not None])
        for lag, matrix in enumerate(coefficients, first):
            past = slice(0, max(log.steps - lag, 0))
            outputs[lag:] += signal[past] @ matrix.T
            terms[lag:] += np.abs(signal[past]) @ np.abs(matrix).T
            bound[lag:] += off[past] @ np.abs(matrix).T
    since = log.steps - max(log.steps // 10, 1) if k_w is None else k_w
    start = max(len(compensator.past_u), since)
    return errors.compared(outputs, terms, bound, start, of="the compensator", floor=STILL)


class LogErrors:
    """Bounds of the rounding errors of a log's signals and of theta, from its digits."""

    def __init__(self, log: ControllerLog, tolerance: float | None) -> None:
        if tolerance is not None and not number(tolerance, "tolerance") > 0:
            raise InputError(f"tolerance = {tolerance} must be positive.")
        self.log, self.tolerance = log, tolerance
        self.digits: dict[str, Resolution] = {}
        self.signals: dict[str, Array | None] = {}
        for name in ("u", "y", "r", "theta"):
            values = getattr(log, name)
            if values is not None:
                self.digits[name] = resolution_of(values)
            self.signals[name] = None if values is None else self.digits[name].error(values)

    @property
    def theta(self) -> Array:
        """The bound for theta."""
        error = self.signals["theta"]
        assert error is not None
        return error

    def compared(
        self,
        u_computed: Array,
        terms: Array,
        bound: Array,
        start: int,
        *,
        shift: int = 0,
        of: str = "theta",
        floor: float = ROUNDING,
    ) -> ControlReplay:
        """Compare the logged u with the computed one, within the rounding of the log."""
        u, steps = self.log.u, self.log.steps
        if start >= steps:
            raise InputError(
                f"the log of {steps} steps ends before step {start}, from which u could be "
                "compared with Phi theta; a longer log is needed."
            )
        size = max(float(np.abs(u[start:]).max()), float(terms[start:].max())) or 1.0
        gaps = np.abs(u - u_computed)[start:].max(axis=1)
        tolerance, words = self.tolerance, ""
        if tolerance is None:
            used = {n: d for n, d in self.digits.items() if n != "theta" or of == "theta"}
            if any(digits.kind == "single" for digits in used.values()):
                floor = max(floor, 64 * HALF_SINGLE)  # the controller summed in single precision
            left_open = float((bound + self.digits["u"].error(u))[start:].max()) / size
            tolerance = floor + left_open
            if left_open > floor:
                words = ", ".join(f"{n} {d}" for n, d in used.items() if d.kind != "exact")
        return ControlReplay(
            u=u_computed, start=start, shift=shift, worst=float(gaps.max()) / size,
            worst_step=start + int(np.argmax(gaps)), of=of, tolerance=tolerance, resolution=words,
        )  # fmt: skip


def _row_by_row(phi: Array, Theta: Array) -> Array:
    """phi(k) Theta(k) at every step."""
    return np.asarray(np.einsum("kj,kji->ki", phi, Theta))


# A log with more digits than these is as good as float64.
MOST_DIGITS = 11
# Fewer values than these may have few digits by themselves, as those of a step have.
EVIDENCE = 10
# At most so many numbers of a signal are looked at.
SAMPLE = 20_000
HALF_SINGLE = 2.0**-24


@dataclass(frozen=True)
class Resolution:
    """The rounding of logged numbers.

    Attributes
    ----------
    kind : {"exact", "single", "decimals", "digits"}
        float64, single precision, a fixed number of decimals, or of significant digits.
    digits : int
        How many.
    """

    kind: str = "exact"
    digits: int = 0

    def error(self, values: Array) -> Array:
        """A bound of the error of each value."""
        size = np.abs(values)
        if self.kind == "decimals":
            return np.full_like(size, 0.5 * 10.0**-self.digits)
        if self.kind == "digits":
            place = np.floor(np.log10(np.where(size > 0, size, 1.0)))
            return np.where(size > 0, 0.5 * 10.0 ** (place + 1 - self.digits), 0.0)
        return size * (HALF_SINGLE if self.kind == "single" else 0.0)

    def __str__(self) -> str:
        if self.kind in ("exact", "single"):
            return {"exact": "in float64", "single": "in single precision"}[self.kind]
        return f"to {self.digits} {self.kind}"


def resolution_of(values: Array) -> Resolution:
    """The coarsest rounding that all of these numbers are consistent with.

    The chance that numbers which were not rounded look as if they were is nil from ten different
    ones on. With fewer, those of a step for example, nothing is concluded.
    """
    flat = np.abs(values).ravel()
    flat = np.unique(flat[:: max(flat.size // SAMPLE, 1)])
    flat = flat[(flat > 1e-280) & (flat < 1e280)]
    if flat.size < EVIDENCE:
        return Resolution()
    exponents = np.floor(np.log10(flat)).astype(int)
    whole = max(int(exponents.max()) + 1, 0)
    digits = next((d for d in range(1, MOST_DIGITS + 1) if _fit(flat, d - 1 - exponents)), None)
    decimals = next((d for d in range(MOST_DIGITS + 1) if _fit(flat, d)), None)
    if decimals == 0:
        return Resolution()  # counts, of an analog-to-digital converter for example
    if decimals is not None and (digits is None or decimals + whole <= max(digits, whole)):
        return Resolution("decimals", decimals)
    if digits is not None:
        return Resolution("digits", digits)
    with np.errstate(over="ignore", under="ignore"):
        is_single = np.array_equal(flat.astype(np.float32).astype(np.float64), flat)
    return Resolution("single") if is_single else Resolution()


def _fit(values: Array, places: int | Array) -> bool:
    """Whether every value has no more than these decimal places."""
    scaled = values * 10.0 ** np.asarray(places, dtype=np.float64)
    off = np.abs(scaled - np.rint(scaled))
    return bool(np.all((off <= 4e-15 * scaled) & (scaled < 1e12)))
