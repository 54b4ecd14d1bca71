"""Statistics of runs: shares with their confidence intervals, quantiles of metrics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from compensator_theory import figures
from compensator_theory.errors import InputError
from rcac_experiments.sweeps._table import Columns, SweepTable
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import instance_of, items, number
from rcac_numeric.arrays._values import Result


def wilson_interval(
    successes: ArrayLike, trials: ArrayLike, confidence: float = 0.95
) -> tuple[Array, Array]:
    """Wilson's score interval of a share, entry by entry.

    Its ends are the shares p at which the normal approximation of the count just includes what was
    observed: abs(p_hat - p) = z sqrt(p (1 - p) / n). For 0 of n it is not empty: 0 of 25 leaves
    13 % possible.

    Parameters
    ----------
    successes, trials : arrays of integers
    confidence : float
        Between 0 and 1.

    Raises
    ------
    InputError
        Where a count is negative or exceeds its trials.

    References
    ----------
    E. B. Wilson, "Probable inference, the law of succession, and statistical inference", Journal
    of the American Statistical Association 22, 1927.

    Examples
    --------
    >>> from rcac_experiments.sweeps import wilson_interval
    >>> low, high = wilson_interval(0, 25)
    >>> float(low), round(float(high), 3)
    (0.0, 0.133)
    """
    from scipy.special import ndtri

    k, n = np.asarray(successes, dtype=np.float64), np.asarray(trials, dtype=np.float64)
    if not 0 < number(confidence, "confidence") < 1:
        raise InputError(f"confidence = {confidence} must be between 0 and 1.")
    if np.any(k < 0) or np.any(k > n):
        raise InputError("successes must lie between 0 and trials.")
    z2 = float(ndtri(0.5 + confidence / 2)) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        middle = (k + z2 / 2) / (n + z2)
        half = np.sqrt(z2 * (k * (n - k) / n + z2 / 4)) / (n + z2)
    low, high = np.where(k == 0, 0.0, middle - half), np.where(k == n, 1.0, middle + half)
    return np.where(n > 0, low, 0.0), np.where(n > 0, high, 1.0)


@dataclass(frozen=True, eq=False)
class SweepSummary(Result):
    """A study group by group: the number of completed runs, and their metrics.

    Attributes
    ----------
    axes : tuple of str
        What the groups differ in.
    measure : str
        What the quantiles are of; empty for none.
    quantiles : tuple of float
        Which ones.
    columns : dict from names to arrays
        The axes; runs, the number of results; not_completed of them, with its share, share_low
        and share_high (Wilson, 95 %); failed, the number of runs that are no results;
        measured, the number of completed runs with a finite value; then median and q0.05, ... of
        those, NaN where there is none.
    """

    axes: tuple[str, ...]
    measure: str
    quantiles: tuple[float, ...]
    columns: Columns

    def __len__(self) -> int:
        return len(self.columns["runs"])

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.columns[name]

    def grid(self, value: str, x: str, y: str) -> tuple[Array, Array, Array]:
        """A column over two axes: x, y, and values of shape (len(y), len(x)), NaN where none is."""
        if set(self.axes) != {x, y}:
            raise InputError(
                f"the groups differ in {', '.join(self.axes) or 'nothing'}; a map over {x} and "
                f"{y} needs summarise(..., by=[{x!r}, {y!r}])."
            )
        xs, column = np.unique(self[x], return_inverse=True)
        ys, row = np.unique(self[y], return_inverse=True)
        values = np.full((len(ys), len(xs)), np.nan)
        values[row, column] = self[value]
        return xs, ys, values

    def plot(self) -> figures.Figure:
        """The share of runs that did not complete, and the median, over one axis or two."""
        from rcac_experiments.plots._sweep import plot_summary

        return plot_summary(self)


def summarise(
    table: SweepTable,
    measure: str = "",
    by: Sequence[str] | None = None,
    quantiles: Sequence[float] = (0.05, 0.95),
) -> SweepSummary:
    """Group the runs of a study by some of its axes.

    Parameters
    ----------
    table : SweepTable
    measure : str, optional
        What medians and quantiles are taken of, over completed runs with a finite value.
    by : sequence of str, optional
        Axes; all of them by default.
    quantiles : sequence of float

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_experiments.sweeps import SweepTable, summarise
    >>> table = SweepTable(
    ...     {"run": np.arange(4), "n_c": np.array([1, 1, 2, 2]), "rms": np.array([1., 3., 2., 9.]),
    ...      "outcome": np.array(["completed", "completed", "completed", "diverged"])},
    ...     axes=("n_c",), measures=("rms",))
    >>> summary = summarise(table, "rms")
    >>> summary["median"].tolist(), summary["not_completed"].tolist()
    ([2.0, 2.0], [0, 1])
    """
    instance_of(table, "table", SweepTable)
    axes = table.axes if by is None else items(by, "by", str)
    for name in axes:
        if name not in table.axes:
            raise InputError(f"{name!r} is no axis; the axes are {', '.join(table.axes)}.")
    probabilities = tuple(number(q, "a quantile") for q in items(quantiles, "quantiles"))
    if any(not 0 <= q <= 1 for q in probabilities):
        raise InputError(f"the quantiles {probabilities} must lie between 0 and 1.")
    everything = {
        name: np.concatenate([table[name], table.failed.get(name, np.zeros(0, table[name].dtype))])
        for name in axes
    }
    firsts, groups, count = _groups(everything, len(table) + table.failures)
    group, of_failed = groups[: len(table)], groups[len(table) :]
    failed = np.asarray(table["outcome"] != "completed", dtype=bool)
    runs = np.bincount(group, minlength=count)
    not_completed = np.bincount(group, weights=failed, minlength=count).astype(np.int64)
    low, high = wilson_interval(not_completed, runs)
    columns: Columns = {name: values[firsts] for name, values in everything.items()}
    columns |= {"runs": runs, "not_completed": not_completed}
    columns |= {"share": not_completed / np.maximum(runs, 1), "share_low": low, "share_high": high}
    columns["failed"] = np.bincount(of_failed, minlength=count)
    if measure:
        columns |= _quantiles(table[measure], group, count, failed, probabilities)
    return SweepSummary(tuple(axes), measure, probabilities, columns)


def _groups(axes: Columns, length: int) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
    """The first row of each group, the group of each row, and how many there are."""
    group = np.zeros(length, dtype=np.int64)
    for values in axes.values():
        comparable = np.array([repr(v) for v in values]) if values.dtype == object else values
        distinct, place = np.unique(comparable, return_inverse=True)
        group = group * len(distinct) + place
    _, firsts, group = np.unique(group, return_index=True, return_inverse=True)
    return firsts, group, len(firsts)


def _quantiles(
    values: Array,
    group: NDArray[np.int64],
    count: int,
    failed: NDArray[np.bool_],
    quantiles: Sequence[float],
) -> Columns:
    known = np.isfinite(values) & ~failed
    order = np.lexsort((values[known], group[known]))
    grouped, ordered = group[known][order], values[known][order]
    starts = np.searchsorted(grouped, np.arange(count + 1))
    columns: Columns = {"measured": np.diff(starts)}
    named = {"median": 0.5, **{f"q{q:g}": q for q in quantiles}}
    for name, q in named.items():
        columns[name] = np.array([
            np.quantile(ordered[a:b], q) if b > a else np.nan
            for a, b in pairwise(starts)
        ])  # fmt: skip
    return columns
