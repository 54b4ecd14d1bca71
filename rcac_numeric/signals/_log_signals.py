"""The signals of a log by their roles, one row for each step of one clock."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import attrs
import numpy as np

from compensator_theory.errors import Advice, CompensatorError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._untrusted import MOST_NUMBERS
from rcac_numeric.arrays._validation import number
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.signals._clock import TIMES, Clock, clock_of
from rcac_numeric.signals._data_files import read_contents
from rcac_numeric.signals._log_contents import LogColumn, LogContents, with_clocks
from rcac_numeric.signals._text_tables import without_head

SIGNALS = ("u", "y", "z", "w", "r")
# What a log may hold, under these names or those that the caller gives.
ROLES = (*SIGNALS, "theta", "D_c", "N_c")
PIECEWISE_CONSTANT = ("u", "r", "theta")  # constant between two samples of the controller
# So many names of a file are compared with one that it lacks: a hundred thousand take seconds.
COMPARED = 1000
SAME_TIME = 0.01  # relative difference of two sample times that are the same
OLDEST = 1.02  # of its sample times: an older value of another topic is a lost one
MIDDLE = (0.025, 0.975)  # quantiles of the ages of values
Names = Mapping[str, str | Sequence[str]]


@dataclass
class LogSignals:
    """Arrays by role, with the clock of their rows and notes on their resampling.

    `ages` are the least and largest ages in seconds at which the rows show u and y.
    """

    arrays: dict[str, Array] = field(default_factory=dict)
    topics: dict[str, str] = field(default_factory=dict)
    columns: dict[str, tuple[str, ...]] = field(default_factory=dict)
    clock: Clock | None = None
    notes: list[str] = field(default_factory=list)
    ages: dict[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def time_skew(self) -> tuple[float, float]:
        """The least and largest time in seconds by which u of a row is older than its y.

        Where rows at irregular times are taken as steps of equal distance, both lie as far apart
        as their distances differ.
        """
        of_u, of_y = (self.ages.get(role, (0.0, 0.0)) for role in ("u", "y"))
        early, late = (0.0, 0.0) if self.clock is None else _unevenness(self.clock)
        return of_u[0] - of_y[1] + early, of_u[1] - of_y[0] + late


@np.errstate(all="ignore")  # an overflow is an infinite statement, without a warning
def inspect_log(
    source: Any,
    names: Names | None = None,
    *,
    columns: Sequence[str] = (),
    time: str | None = None,
) -> LogContents:
    """Return the contents of a log file or a DataFrame, and the signals that `read_log` would use.

    Columns with units, types, missing entries and roundings; sample time, jitter, gaps, repeated
    and turning stamps; the columns for u, y, z, w, r and theta.

    Parameters
    ----------
    source : path, DataFrame or mapping of arrays
    names, columns, time
        As for `read_log`.

    Raises
    ------
    InputError
        If the file cannot be read. A log without u or y is described, and `unread` says why
        `read_log` refuses it.

    Examples
    --------
    >>> from rcac_numeric import inspect_log
    >>> log = inspect_log("examples/octave/rcac_loop.mat")
    >>> [(column.name, column.values.shape) for column in log.columns][:2]
    [('u', (300, 1)), ('y', (300, 1))]
    >>> log.roles["theta"]
    ('theta',)
    """
    contents = _contents(source, names or {}, columns, time, None)
    try:
        signals = signals_of(contents, names or {})
    except CompensatorError as error:
        return attrs.evolve(contents, unread=str(error), roles=_roles(contents, names or {}))
    return attrs.evolve(contents, roles=signals.columns, notes=(*contents.notes, *signals.notes))


@np.errstate(all="ignore")
def read_signals(
    source: Any,
    names: Names,
    *,
    transpose: bool,
    columns: Sequence[str],
    time: str | None,
    sample_time: float | None,
    resample: float | None,
) -> tuple[LogSignals, str]:
    """Return the signals of a log, and the name of their source."""
    contents = _contents(source, names, columns, time, sample_time)
    signals = signals_of(
        contents, names, transpose=transpose, sample_time=sample_time, resample=resample
    )
    signals.notes[:0] = contents.notes
    return signals, contents.source


def _contents(
    source: Any, names: Names, columns: Sequence[str], time: str | None, sample_time: float | None
) -> LogContents:
    contents = read_contents(source, columns)
    chosen = [part for name in names.values() for part in _parts(name)]
    return with_clocks(contents, time, sample_time, chosen)


def _parts(name: str | Sequence[str]) -> list[str]:
    return [name] if isinstance(name, str) else [*name]


def signals_of(
    contents: LogContents,
    names: Names,
    *,
    transpose: bool = False,
    sample_time: float | None = None,
    resample: float | None = None,
) -> LogSignals:
    """Choose the signals of a log and bring them to one clock.

    The rows are the steps of the clock of u and y, the slower one if they differ; a step without a
    row is NaN. Signals of other topics have the last value before each step.
    """
    if any(column.name == "" for column in contents.columns):
        raise without_head(contents.source)
    signals = _chosen(contents, names)
    _orient(signals, transpose)
    clocks = {topic: _clock(contents, topic) for topic in set(signals.topics.values())}
    if resample is not None:
        period = number(resample, "resample")
        require_sample_time(contents.source, period, sample_time, " by resample")
        return _resampled(contents, signals, clocks, period)
    base = _base(signals, clocks)
    clock = signals.clock = clocks[base]
    rows = len(next(v for role, v in signals.arrays.items() if signals.topics[role] == base))
    if clock is not None and clock.rows and clock.rows != rows:
        signals.notes.append(
            f"{clock.column} has {clock.rows} stamps and the signals {rows} rows: not used"
        )
        clock = signals.clock = None
    if clock is not None:
        _require_regular(contents.source, clock)
        by = f" by its column {clock.column} [{clock.unit}]"
        ignored = Advice("read_log", (("time", "none"),), 'ignore the stamps with time="none"')
        require_sample_time(
            contents.source, clock.sample_time, sample_time, by, ("; or ", ignored)
        )  # fmt: skip
    others = {role for role, topic in signals.topics.items() if topic != base}
    for role in others:
        _hold(contents.source, signals, role, clock, clocks[signals.topics[role]], rows)
    if clock is not None and clock.missing:
        _insert_missing(contents.source, signals, clock, rows)
    return signals


# Roles


def _chosen(contents: LogContents, names: Names) -> LogSignals:
    """The arrays of all roles."""
    for role in names:
        if role not in ROLES:
            raise InputError(f"names: {role!r} is not known; rename {', '.join(ROLES)}.")
    signals = LogSignals()
    topic = ""
    for role in sorted(ROLES, key=lambda role: role not in names):  # a full name chooses its topic
        name = names.get(role, role)
        parts = []
        for part in _split(contents, name):
            columns = contents.named(part, topic)
            if not columns:
                if role in names or role in ("u", "y"):
                    raise InputError(_missing(contents, role, part, names))
                break
            if role not in names and _is_of_another_log(contents, columns, signals):
                break
            parts.append((*contents.numbers_of(columns), columns))
        if not parts:
            continue
        topic = topic or parts[0][1]
        topics = {topic for _, topic, _ in parts}
        if len(topics) > 1:
            raise InputError(
                f"{contents.source}: the components of {role} are of the topics "
                f"{', '.join(sorted(topics))}, which have different clocks; name one of them."
            )
        arrays = [np.atleast_1d(values) for values, _, _ in parts]
        arrays = [values.reshape(-1, 1) if values.ndim == 1 else values for values in arrays]
        if len({len(values) for values in arrays}) > 1:
            raise InputError(f"{contents.source}: the components of {role} differ in length.")
        is_alone = len(parts) == 1
        signals.arrays[role] = np.asarray(parts[0][0]) if is_alone else np.hstack(arrays)
        signals.topics[role] = parts[0][1]
        signals.columns[role] = tuple(c.full_name for _, _, columns in parts for c in columns)
    return signals


def _is_of_another_log(
    contents: LogContents, columns: Sequence[LogColumn], signals: LogSignals
) -> bool:
    """Whether the topic of some columns has a u and a y, and those in use are of other topics."""
    if not {"u", "y"} <= signals.topics.keys() or columns[0].topic in signals.topics.values():
        return False
    full_names = {*signals.columns["u"], *signals.columns["y"]}
    used = {c.name for c in contents.columns if c.full_name in full_names}
    return used <= {c.name for c in contents.columns if c.topic == columns[0].topic}


def _split(contents: LogContents, name: str | Sequence[str]) -> list[str]:
    """The names of the components: a sequence, or "T1+T2"."""
    if not isinstance(name, str):
        return [*name]
    return [name] if "+" not in name or contents.named(name) else name.split("+")


def _roles(contents: LogContents, names: Names) -> dict[str, tuple[str, ...]]:
    """The columns of the roles that can be found, of a log that is refused."""
    roles = {}
    for role in ROLES:
        try:
            columns = [c for part in _split(contents, names.get(role, role))
                       for c in contents.named(part)]  # fmt: skip
        except CompensatorError:
            continue
        if columns:
            roles[role] = tuple(column.full_name for column in columns)
    return roles


def _missing(contents: LogContents, role: str, name: str, names: Names) -> str:
    """The error for a missing signal: the names in the file, and likely candidates."""
    for column in contents.columns:
        if column.name.startswith(f"{name} (column ") and column.problem:
            return column.problem
    numbers = [c.full_name for c in contents.columns if not c.problem]
    has = shortened(", ".join(c.full_name for c in contents.columns)) or "nothing"
    used = {part for chosen in names.values() for part in _parts(chosen)}
    free = [v for v in numbers[:COMPARED] if v not in used]
    close = difflib.get_close_matches(name, free, n=1, cutoff=0.5)
    likely = close or [
        v for v in free if v not in ROLES and v.rpartition(".")[2].lower() not in TIMES
    ]
    hint = f" Did you mean {close[0]!r}?" if close else ""
    words = f"{contents.source} has no {name!r}, needed as {role}; it has {has}"
    if not likely:
        return f"{words}, none of which can be it."
    proposal = shortened(likely[0])  # whole, to be copied
    option = f'"{role}={proposal}"' if " " in proposal else f"{role}={proposal}"
    return (
        f"{words}.{hint} Say which column is {role}, for instance "
        f"names={{{role!r}: {proposal!r}}}, at a shell --names {option}."
    )


def _orient(signals: LogSignals, transpose: bool) -> None:
    """Turn arrays whose columns are steps, where only one direction gives each signal a row a step.

    MATLAB makes a row of u(k) = ... in a script, and SciPy's savemat of a 1-D array.
    """
    if transpose:
        signals.arrays = {role: values.T for role, values in signals.arrays.items()}
        return
    shapes = [v.shape for role, v in signals.arrays.items() if role in SIGNALS]
    if any(len(shape) != 2 for shape in shapes):
        return
    same_topic = len({signals.topics[role] for role in signals.arrays if role in SIGNALS}) == 1
    if same_topic:
        fits = [n for n in shapes[0] if n > 1 and all(n in shape for shape in shapes)]
        if not fits:
            return
        steps = dict.fromkeys(signals.arrays, fits[0])
    else:
        steps = {role: max(v.shape, default=0) for role, v in signals.arrays.items()}
    for role, values in signals.arrays.items():
        is_signal = role in (*SIGNALS, "theta") and values.ndim == 2
        if is_signal and values.shape[0] != steps[role] == values.shape[1]:
            signals.arrays[role] = values.T


# Clocks


def _clock(contents: LogContents, topic: str) -> Clock | None:
    """The clock of a topic; of the whole log where the topic has none."""
    clock = contents.clocks.get(topic)
    return contents.clocks.get("") if clock is None else clock


def _base(signals: LogSignals, clocks: Mapping[str, Clock | None]) -> str:
    """The topic whose rows are the steps: the slower one of u and y."""

    def rate(role: str) -> float:
        clock = clocks[signals.topics[role]]
        if clock is None or len(clock.times) < 2:
            return np.inf
        return float((len(clock.times) - 1) / max(clock.times[-1] - clock.times[0], 1e-300))

    return signals.topics[min(("u", "y"), key=rate)]


def _require_regular(source: str, clock: Clock) -> None:
    """Raise for stamps that turn, are repeated, irregular, or no times."""
    if clock.is_regular:
        return
    d = np.diff(clock.times)
    usual = float(np.median(d[d > 0])) if (d > 0).any() else 1.0
    resampled = Advice("read_log", (("resample", f"{usual:.3g}"),),
                       "Resample it with resample={resample}, in seconds")  # fmt: skip
    counted = Advice(
        "read_log",
        (("time", "none"),),
        'take the rows as steps of equal distance with time="none" and sample_time',
    )
    remedies: tuple[str | Advice, ...] = ("Cut the log there; or ", counted)
    if not np.isfinite(clock.times).all() or not (d > 0).any():
        remedies = ("Mend it; or ", counted)
    elif clock.repeated:
        remedies = (resampled, "; or cut the log there")
    elif not clock.turning and len(clock.times) > 2:
        remedies = (resampled, "; or ", counted)
    raise InputError(f"{source}: {clock.problem}. ", *remedies, ".")


def require_sample_time(
    source: str, period: float | None, sample_time: float | None, by: str = "",
    remedy: Sequence[str | Advice] = (),
) -> None:  # fmt: skip
    """Raise if a requested sample time contradicts the one of a log."""
    if sample_time is None or period is None or not period > 0:
        return
    if abs(number(sample_time, "sample_time") / period - 1) > SAME_TIME:
        raise InputError(
            f"{source} is sampled every {period:.6g} s{by}, and sample_time = {sample_time:g}. "
            "Leave sample_time out", *remedy, ".",
        )  # fmt: skip


def _insert_missing(source: str, signals: LogSignals, clock: Clock, rows: int) -> None:
    """Give every step of the clock a row, NaN where there was none."""
    for role, values in signals.arrays.items():
        if role not in (*SIGNALS, "theta") or len(values) != rows:
            continue
        width = values.size // rows
        if clock.steps * width > MOST_NUMBERS:
            raise InputError(f"{source} holds more than {MOST_NUMBERS} numbers; cut it.")
        every = np.full((clock.steps, width), np.nan)
        every[clock.step_of_row] = values.reshape(rows, width)
        signals.arrays[role] = every


def _hold(
    source: str, signals: LogSignals, role: str, clock: Clock | None, other: Clock | None, rows: int
) -> None:
    """Bring a signal of another topic to the steps: the last value before each."""
    values = signals.arrays[role]
    values = values.reshape(len(values), -1)
    topic = signals.topics[role]
    times = None if clock is None or not clock.rows else clock.times
    theirs = None if other is None or len(other.times) != len(values) else other.times
    if theirs is not None and times is not None:
        if len(theirs) == len(times) and np.array_equal(theirs, times):
            return
    elif len(values) == rows:
        return
    if times is None or theirs is None:
        raise InputError(
            f"{source}: {role} of {topic or 'the file'} has {len(values)} rows where u and y have "
            f"{rows}, and there are no times that relate them."
        )
    if (np.diff(theirs) < 0).any():
        order = np.argsort(theirs, kind="stable")
        theirs, values = theirs[order], values[order]
    place = np.searchsorted(theirs, times + 1e-9 * (times[-1] - times[0]), side="right") - 1
    age = times - theirs[np.maximum(place, 0)]
    if role == "u":
        signals.ages[role] = _late_moves(theirs, values, times)
    elif role == "y" and (place >= 0).any():
        signals.ages[role] = _middle(age[place >= 0])
    usual = float(np.median(np.diff(theirs))) if len(theirs) > 1 else 0.0
    used = values[np.maximum(place, 0)].copy()
    used[(place < 0) | (age > (OLDEST + _jitter(other)) * usual)] = np.nan
    signals.arrays[role] = used
    moved = float(np.abs(np.diff(values, axis=0)).mean(axis=0).max()) if len(values) > 1 else 0.0
    size = _spread(values) or 1.0
    late = float(age[place >= 0].mean()) if (place >= 0).any() else 0.0
    signals.notes.append(
        f"{role} of {topic or 'the file'} (every {usual:.3g} s): the last value before each step, "
        f"{late:.3g} s old on average; it moves by {moved / size:.1%} of its standard deviation "
        "from sample to sample"
    )


def _jitter(clock: Clock | None) -> float:
    """The jitter of a clock in sample times; half a sample time of one without regular stamps."""
    return clock.jitter if clock is not None and clock.is_regular else 0.5


def _resampled(
    contents: LogContents, signals: LogSignals, clocks: Mapping[str, Clock | None], period: float
) -> LogSignals:
    """Bring all signals to steps of a given distance: u, r and theta held, the others linear."""
    source = contents.source
    if not period > 0:
        raise InputError(f"resample = {period:g} must be positive, in seconds.")
    times: dict[str, Array] = {}
    for role, topic in signals.topics.items():
        clock = clocks[topic]
        if clock is None or len(clock.times) != len(signals.arrays[role]):
            if role in ("D_c", "N_c") or (role == "theta" and 1 in signals.arrays[role].shape):
                continue
            raise InputError(f"{source}: {role} has no times; resample needs a column of them.")
        if clock.turning or not np.isfinite(clock.times).all():
            _require_regular(source, clock)
        times[role] = clock.times
    begin, end = max(t[0] for t in times.values()), min(t[-1] for t in times.values())
    count = int(np.floor((end - begin) / period * (1 + 1e-12))) + 1
    if count < 2 or count > MOST_NUMBERS // 8:
        raise InputError(
            f"{source} lasts {max(end - begin, 0):.3g} s; resample = {period:g} makes {count} "
            "steps of it. Choose another one, in seconds."
        )
    grid = begin + period * np.arange(count)
    for role, t in times.items():
        values = signals.arrays[role]
        values = values.reshape(len(values), -1)
        if role in PIECEWISE_CONSTANT:
            place = np.searchsorted(t, grid + 1e-9 * (end - begin), side="right") - 1
            signals.arrays[role] = values[np.maximum(place, 0)]
            signals.ages[role] = least, most = _late_moves(t, values, grid)
            signals.notes.append(
                f"{role}: the last value before each step; its moves are {least:.3g} to "
                f"{most:.3g} s late"
            )
        else:
            stamps, first = np.unique(t, return_index=True)
            values = values[first]
            columns = [np.interp(grid, stamps, column) for column in values.T]
            signals.arrays[role] = np.column_stack(columns)
            error = _interpolation_error(stamps, values)
            signals.notes.append(
                f"{role}: interpolated; a sample is predicted from its neighbours with an error of "
                f"{error:.2%} of the standard deviation, which bounds that of interpolation"
            )
    clock = clock_of(grid - begin, "resample")
    signals.clock = attrs.evolve(clock, sample_time=period, times=grid)
    return signals


def _late_moves(stamps: Array, values: Array, grid: Array) -> tuple[float, float]:
    """The least and largest time from a move of a held signal to the first step that shows it."""
    moves = stamps[1:][(np.diff(values, axis=0) != 0).any(axis=1)]
    place = np.searchsorted(grid + 1e-9 * (grid[-1] - grid[0]), moves)
    moves, place = moves[place < len(grid)], place[place < len(grid)]
    return _middle(np.maximum(grid[place] - moves, 0.0)) if len(moves) else (0.0, 0.0)


def _unevenness(clock: Clock) -> tuple[float, float]:
    """How much shorter and longer than whole sample times the rows of a clock are apart.

    0 where the resolution of the stamps hides it.
    """
    rows = len(clock.times)
    if clock.sample_time is None or clock.resolution or rows < 2 or rows != len(clock.step_of_row):
        return 0.0, 0.0
    grid = clock.sample_time * clock.step_of_row
    low, high = _middle(np.diff(clock.times) - np.diff(grid))
    return min(low, 0.0), max(high, 0.0)


def _middle(ages: Array) -> tuple[float, float]:
    """The interval of 95 % of some times."""
    low, high = np.quantile(ages, MIDDLE)
    return float(low), float(high)


def _interpolation_error(t: Array, values: Array) -> float:
    """The rms error with which each sample follows from its neighbours, in standard deviations."""
    if len(t) < 3:
        return float("nan")
    part = ((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]
    errors = values[1:-1] - (1 - part) * values[:-2] - part * values[2:]
    ratios = []
    for error, column in zip(errors.T, values.T, strict=True):
        known = error[np.isfinite(error)]
        rms = float(np.sqrt(np.mean(known**2))) if known.size else float("nan")
        ratios.append(rms / (_spread(column) or 1.0))
    return max(ratios)


def _spread(values: Array) -> float:
    """The standard deviation of the finite entries; 0 without any."""
    finite = values[np.isfinite(values)]
    return float(finite.std()) if finite.size else 0.0
