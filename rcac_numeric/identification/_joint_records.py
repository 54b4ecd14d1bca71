"""Records of several inputs, with missing steps and of several experiments, for one output each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solve
from scipy.signal import lfilter

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import gaps_as_nan, integer, items
from rcac_numeric.identification._process_records import (
    JUMP,
    LEAST,
    ROBUST,
    at_rest,
    likelihood_of,
    quantum_of,
    without_spikes,
)

SMALLEST = 1e-120  # size of a signal, whose squares are in float64
LONGEST_GAP = 20  # missing steps of u in a row: after more of them the state is free
PAST = 10  # of u, by which its missing steps are expected
MOST_MISSING = 0.5  # of the steps
COLLINEAR = 1e-4  # share of an input that does not follow from the others
LAGS = 20  # of the others, on both sides


@dataclass(frozen=True, eq=False)
class JointRecord:
    """Inputs and one output in units of a standard deviation, in one or several experiments.

    Attributes
    ----------
    u : array, shape (inputs, steps)
        Less its value at rest in each experiment, or that which y shows; 0 before it.
    y : array, shape (steps,)
        Less its first value in each experiment; interpolated where it is missing.
    observed : array of bool, shape (steps,)
        Where y counts.
    starts : tuple of int
        The first step of each experiment, and of each part after a long gap of u.
    after_gaps : tuple of bool
        Whether the part begins after a gap, with an unknown past of u.
    units_u, unit_y : array, float
    quantum : float
        The step by which y is rounded, in units of y; 0 where it is not visible.
    spikes : int
        Single values of y that were replaced by the mean of their neighbours.
    """

    u: Array
    y: Array
    observed: NDArray[np.bool_]
    starts: tuple[int, ...]
    after_gaps: tuple[bool, ...]
    units_u: Array
    unit_y: float
    quantum: float
    spikes: int

    @property
    def steps(self) -> int:
        """The number of steps, missing ones counted."""
        return len(self.y)

    @property
    def count(self) -> int:
        """The number of steps at which y counts."""
        return int(np.count_nonzero(self.observed))

    @property
    def parts(self) -> list[slice]:
        """The steps of each part."""
        return [slice(a, b) for a, b in pairwise([*self.starts, self.steps])]

    @property
    def longest(self) -> int:
        """The steps of the longest part."""
        return max(int(part.stop - part.start) for part in self.parts)

    def moves(self, j: int) -> int:
        """The number of steps at which an input changes within a part."""
        return sum(int(np.count_nonzero(np.diff(self.u[j, part]))) for part in self.parts)

    def filtered(self, b: ArrayLike, a: ArrayLike, rows: Array) -> Array:
        """Filter rows, from rest in each part."""
        if len(self.starts) == 1:
            return np.asarray(lfilter(b, a, rows))
        return np.concatenate([lfilter(b, a, rows[..., one]) for one in self.parts], axis=-1)

    def later(self, rows: Array, steps: int) -> Array:
        """Delay rows within each part, 0 before."""
        if not steps:
            return rows
        moved = np.zeros_like(rows)
        for part in self.parts:
            if part.stop - part.start > steps:
                moved[..., part.start + steps : part.stop] = rows[
                    ..., part.start : part.stop - steps
                ]
        return moved

    def earlier(self, rows: Array) -> Array:
        """Advance rows by a step within each part, their last value kept."""
        return np.concatenate([
            np.concatenate([rows[..., one][..., 1:], rows[..., one][..., -1:]], axis=-1)
            for one in self.parts
        ], axis=-1)  # fmt: skip

    def summed(self, rows: Array) -> Array:
        """Sum rows within each part."""
        return np.concatenate([np.cumsum(rows[..., one], axis=-1) for one in self.parts], axis=-1)

    def separated(self, rows: Array, steps: int) -> Array:
        """The parts of rows with so many zeros between them."""
        if len(self.starts) == 1:
            return rows
        zeros = np.zeros((*rows.shape[:-1], steps))
        pieces = [one for part in self.parts for one in (rows[..., part], zeros)]
        return np.concatenate(pieces[:-1], axis=-1)

    def clipped(self) -> Array | None:
        """Y with its jumps clipped at six robust standard deviations; None where it has none."""
        dy = self.y - self.later(self.y, 1)  # each part begins at 0
        middle = float(np.median(dy))
        size = JUMP * (ROBUST * float(np.median(np.abs(dy - middle))) + 1e-12)
        if size < JUMP * 1e-6 or not (np.abs(dy - middle) > size).any():
            return None
        return self.summed(np.clip(dy, middle - size, middle + size))

    def likelihood(self, e: Array) -> tuple[float, float, float]:
        """-2 log likelihood a step, Gaussian and of Student's t, and the scale of the latter."""
        return likelihood_of(e, self.quantum)

    def only(self, parts: Sequence[int]) -> JointRecord:
        """Some of the parts as a record."""
        chosen = [self.parts[i] for i in parts]
        rows = np.concatenate([np.arange(one.start, one.stop) for one in chosen])
        sizes = [one.stop - one.start for one in chosen]
        starts = tuple(int(k) for k in np.cumsum([0, *sizes[:-1]]))
        return replace(
            self, u=self.u[:, rows], y=self.y[rows], observed=self.observed[rows], starts=starts,
            after_gaps=tuple(self.after_gaps[i] for i in parts),
        )  # fmt: skip

    def halves(self) -> tuple[JointRecord, JointRecord]:
        """The first and the second half of the longest part."""
        part = max(self.parts, key=lambda one: one.stop - one.start)
        middle = (part.start + part.stop) // 2
        both = []
        for rows in (slice(part.start, middle), slice(middle, part.stop)):
            u = self.u[:, rows]
            rest = np.array([at_rest(one) for one in u])[:, None]
            both.append(replace(
                self, u=u - rest, y=self.y[rows], observed=self.observed[rows], starts=(0,),
                after_gaps=(False,),
            ))  # fmt: skip
        return both[0], both[1]

    def without_past(self, steps: int) -> JointRecord:
        """The record without the steps of y that depend on an unknown past of u."""
        if not any(self.after_gaps):
            return self
        observed = self.observed.copy()
        for part, is_after in zip(self.parts, self.after_gaps, strict=True):
            if is_after:
                observed[part.start : min(part.start + steps, part.stop)] = False
        return replace(self, observed=observed)


@dataclass(frozen=True, eq=False)
class Inputs:
    """The inputs of a record with what was assumed of their missing steps."""

    u: Array
    units: Array
    starts: tuple[int, ...]
    after_gaps: tuple[bool, ...]
    words: tuple[str, ...]


def experiment_starts(experiments: Sequence[int] | None, steps: int) -> tuple[int, ...]:
    """The first step of each experiment."""
    if experiments is None:
        return (0,)
    sizes = [
        integer(one, "experiments", at_least=LEAST) for one in items(experiments, "experiments")
    ]
    if sum(sizes) != steps:
        raise InputError(
            f"experiments = {sizes} are {sum(sizes)} steps, and u has {steps}: give the number of "
            "steps of each experiment, in the order of the rows."
        )
    return tuple(int(k) for k in np.cumsum([0, *sizes[:-1]]))


def matrix_signal(values: ArrayLike, name: str) -> Array:
    """A signal of several components, shape (steps, width), NaN where it is missing."""
    try:
        array = np.array(gaps_as_nan(values), dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name} must be an array of numbers, a row for each step.") from None
    array = array[:, None] if array.ndim == 1 else array
    if array.ndim != 2 or not array.size or array.shape[0] < array.shape[1]:
        raise InputError(
            f"{name} has shape {array.shape}; (steps, width) is needed, one row for each step."
        )
    if np.isinf(array).any():
        raise InputError(f"{name} is infinite at some steps; NaN marks what is missing.")
    largest = float(np.abs(array[~np.isnan(array)]).max(initial=0.0))
    if largest and not SMALLEST < largest < 1 / SMALLEST:  # its squares leave float64
        raise InputError(f"{name} reaches {largest:.3g}; scale its unit so that it is near 1.")
    return array


def inputs_of(u: Array, starts: tuple[int, ...]) -> Inputs:
    """Fill the missing steps of u, and count each input from its value at rest."""
    steps, width = u.shape
    missing = np.isnan(u)
    words, all_starts, after = [], list(starts), dict.fromkeys(starts, False)
    for j in range(width):
        share = float(missing[:, j].mean())
        if share > MOST_MISSING:
            raise InputError(
                f"u_{j + 1} is missing at {100 * share:.0f} % of the steps; at most "
                f"{100 * MOST_MISSING:.0f} % may be."
            )
    rows = np.flatnonzero(missing.any(axis=1))
    for run in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1) if len(rows) else []:
        if len(run) > LONGEST_GAP and run[-1] + 1 < steps:
            after.setdefault(int(run[-1]) + 1, True)
    all_starts = sorted(after)
    filled = np.empty_like(u)
    bounds = [*all_starts, steps]
    for j in range(width):
        for a, b in pairwise(bounds):
            filled[a:b, j] = _expected(u[a:b, j], missing[a:b, j])
    count = int(missing.any(axis=1).sum())
    if count:
        words.append(
            f"u is missing at {count} of {steps} steps: there it is its expectation from its "
            f"neighbours by an autoregression of order {PAST} at most"
        )
    gaps = len(all_starts) - len(starts)
    if gaps:
        words.append(
            f"{gaps} gaps of u are longer than {LONGEST_GAP} steps: nothing is assumed of u there, "
            "and the state after each is free"
        )
    moved = filled.T.copy()
    for a, b in pairwise(bounds):
        for j in range(width):
            moved[j, a:b] -= at_rest(filled[a:b, j])
    units = moved.std(axis=1)
    for j in range(width):
        if not units[j] > 1e-9 * max(np.abs(filled[:, j]).max(), 1e-300):
            name = "u" if width == 1 else f"u_{j + 1}"
            raise InputError(
                f"{name} is constant: the record does not show its effect. Move it, or leave it "
                "out. If it was stepped, the record must begin before the step."
            )
    scaled = moved / units[:, None]
    _require_independent(scaled)
    return Inputs(scaled, units, tuple(all_starts), tuple(after[k] for k in all_starts),
                  tuple(words))  # fmt: skip


def _expected(u: Array, missing: NDArray[np.bool_]) -> Array:
    """U with its missing steps replaced by their expectation, by an autoregression of u."""
    if not missing.any():
        return u
    there = np.flatnonzero(~missing)
    if not len(there):
        return np.zeros_like(u)
    level = float(u[there].mean())
    filled = np.interp(np.arange(len(u)), there, u[there]) - level
    order = min(PAST, len(there) // 20)
    if not order or not np.ptp(u[there]) > 0:
        return filled + level
    for _ in range(3):  # of expectation and regression
        X = np.stack([np.r_[np.zeros(k), filled[:-k]] for k in range(1, order + 1)])
        whole = np.convolve(missing, np.ones(order + 1))[: len(u)] < 0.5
        rows = X[:, whole]
        if rows.shape[1] < 5 * order:
            rows, target = X, filled
        else:
            target = filled[whole]
        H = rows @ rows.T
        a = solve(H + 1e-8 * np.trace(H) / order * np.eye(order) + 1e-300 * np.eye(order),
                  rows @ target, assume_a="pos")  # fmt: skip
        filled = _smoothed(filled, missing, np.concatenate([[1.0], -a]))
    return filled + level


def _smoothed(u: Array, missing: NDArray[np.bool_], A: Array) -> Array:
    """The missing steps for which the sum of squares of A u is least, run by run."""
    n, steps, u = len(A) - 1, len(u), u.copy()
    unknown = np.flatnonzero(missing)
    if not len(unknown):
        return u
    # Runs that are at least n steps apart do not depend on each other.
    for run in np.split(unknown, np.flatnonzero(np.diff(unknown) > n) + 1):
        a, b = int(run[0]), min(int(run[-1]) + n + 1, steps)
        rows = np.arange(a, b)
        columns = np.zeros((len(rows), len(run)))
        for i, k in enumerate(run):
            reach = slice(k - a, min(k - a + n + 1, len(rows)))
            columns[reach, i] = A[: len(rows) - (k - a)][: n + 1]
        known = u.copy()
        known[run] = 0.0
        before = known[max(a - n, 0) : b]
        rest = np.convolve(np.r_[np.zeros(max(n - a, 0)), before], A)[n : n + len(rows)]
        u[run] = np.linalg.lstsq(columns, -rest, rcond=None)[0]
    return u


def _require_independent(u: Array) -> None:
    """Raise an error where an input follows from the others."""
    if len(u) < 2:
        return
    k = np.arange(u.shape[1])
    at = [np.clip(k + lag, 0, k[-1]) for lag in range(-LAGS, LAGS + 1)]
    for j, target in enumerate(u - u.mean(axis=1, keepdims=True)):
        X = np.concatenate([np.delete(u, j, axis=0)[:, rows] for rows in at])
        X = X - X.mean(axis=1, keepdims=True)
        rest = target - np.linalg.lstsq(X.T, target, rcond=1e-10)[0] @ X
        share = float(rest @ rest) / max(float(target @ target), 1e-300)
        if share < COLLINEAR:
            names = ", ".join(f"u_{i + 1}" for i in range(len(u)) if i != j)
            raise InputError(
                f"u_{j + 1} follows from {names} (a share of {share:.1g} of it does not): the "
                "record cannot tell their effects apart. Move the inputs independently, or leave "
                f"u_{j + 1} out."
            )


def joint_record(inputs: Inputs, y: Array, name: str) -> JointRecord:
    """The record of one output, NaN where it is missing."""
    observed = ~np.isnan(y)
    if np.count_nonzero(observed) < max(LEAST, (1 - MOST_MISSING) * len(y)):
        raise InputError(
            f"{name} is there at {np.count_nonzero(observed)} of {len(y)} steps; at least "
            f"{LEAST}, and half of them, are needed."
        )
    filled, spikes, differences = np.empty_like(y), 0, []
    for a, b in pairwise([*inputs.starts, len(y)]):
        there = np.flatnonzero(observed[a:b])
        if not len(there):
            filled[a:b] = 0.0
            continue
        cleaned, count = without_spikes(y[a:b][there])
        spikes += count
        filled[a:b] = np.interp(np.arange(b - a), there, cleaned) - cleaned[0]
        differences.append(np.diff(cleaned))
    changes = np.concatenate(differences)
    if not np.ptp(changes) > 0:
        raise InputError(f"{name} is constant: the record does not show the plant.")
    unit = float(np.std(changes)) or float(np.std(filled))
    scaled = filled / unit
    return JointRecord(
        inputs.u, scaled, observed, inputs.starts, inputs.after_gaps, inputs.units, unit,
        quantum_of(scaled[observed]), spikes,
    )  # fmt: skip
