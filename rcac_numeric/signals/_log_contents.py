"""Contents of a log file or a data frame: columns with units and roundings, and their clocks."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from typing import Any, ClassVar

import attrs
import numpy as np

from compensator_theory._few_lines import in_few_lines
from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._rounding import Rounding, rounding_of
from rcac_numeric.arrays._showing import report_of
from rcac_numeric.arrays._validation import optional_array_like
from rcac_numeric.arrays._values import Result
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.signals._clock import (
    TIMES,
    Clock,
    clock_of,
    in_seconds,
    is_counter,
    is_time,
    over_midnight,
    seconds_of_texts,
    unread_clock,
    unread_stamps,
)
from rcac_numeric.signals._text_tables import split_unit

# u1, u_1, u(1) and u[1] are all the first component of u.
NUMBERED = re.compile(r"(.*?[^\W\d_])[_(\[]?(\d{1,6})[)\]]?$")
CONSTANTS = ("ts", "dt", "t_s", "sample_time", "sampletime", "tsample", "h_s")
ARRAYS = ("mat", "npz", "h5", "hdf5", "arrays")  # formats of arrays that are no tables
MOST_TURNS = 0.3  # of the rows of a column of times
MOST_STAMPS = 2**22  # texts that are kept as possible stamps


@attrs.frozen(eq=False, slots=False)
class LogColumn(Result):
    """One column or variable of a log.

    Attributes
    ----------
    name : str
        Without its unit.
    values : array, shape (rows,) or (rows, width), or None
        NaN where an entry is missing; None for texts.
    unit : str
        From the head; empty if the file does not say it.
    stored : str
        The type in the file: a type of NumPy, "text", "printed" for numbers in a text.
    topic : str
        Its group, for a file with several clocks: a topic of ULog, a structure with time.
    problem : str
        Why it holds no numbers; empty where it does.
    """

    name: str
    values: Array | None = attrs.field(converter=optional_array_like)
    unit: str = attrs.field(default="", kw_only=True)
    stored: str = attrs.field(default="float64", kw_only=True)
    topic: str = attrs.field(default="", kw_only=True)
    problem: str = attrs.field(default="", kw_only=True)
    texts: tuple[str, ...] = attrs.field(default=(), kw_only=True, repr=False)
    lines: Sequence[int] = attrs.field(default=(), kw_only=True, repr=False)

    @property
    def full_name(self) -> str:
        """The name with its topic, such as actuator.u."""
        return f"{self.topic}.{self.name}" if self.topic else self.name

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.texts) if self.values is None else len(np.atleast_1d(self.values))

    @property
    def missing(self) -> int:
        """Number of entries without a number."""
        if self.values is None or self.values.dtype.kind == "c":
            return 0
        return int(np.count_nonzero(~np.isfinite(self.values)))

    @property
    def rounding(self) -> Rounding:
        """The number format and the printed digits of the numbers."""
        known = self.__dict__.get("_rounding")
        if known is None:
            is_real = self.values is not None and self.values.dtype.kind != "c"
            known = rounding_of(self.values) if is_real and self.values is not None else Rounding()
            object.__setattr__(self, "_rounding", known)
        return known


@attrs.frozen(eq=False, slots=False)
class LogContents(Result):
    """The columns of a log, and those that would be u, y, r, theta.

    Attributes
    ----------
    source : str
    format : str
        In words, such as "text, columns separated by ;, decimal comma".
    columns : tuple of LogColumn
    clocks : mapping from topic to Clock or None
        None where no column holds times.
    notes : tuple of str
        What was left out or assumed.
    roles : mapping from signal to tuple of str
        The columns for u, y, z, w, r, theta, D_c and N_c.
    unread : str
        Why `read_log` refuses the log as it is; empty if it reads it.
    """

    _REST: ClassVar[str] = "report() has all of it"

    source: str
    format: str
    columns: tuple[LogColumn, ...]
    clocks: Mapping[str, Clock | None] = attrs.field(factory=dict)
    notes: tuple[str, ...] = ()
    roles: Mapping[str, tuple[str, ...]] = attrs.field(factory=dict)
    unread: str = ""

    @property
    def clock(self) -> Clock | None:
        """The clock of a log with one; of several the first."""
        return next((clock for clock in self.clocks.values() if clock is not None), None)

    @property
    def is_table(self) -> bool:
        """Whether each column has an entry in each row; other files hold arrays of any shape."""
        return self.format not in ARRAYS

    @property
    def topics(self) -> tuple[str, ...]:
        """Groups of columns with a clock each; one empty name for a table."""
        return tuple(dict.fromkeys(column.topic for column in self.columns))

    def _sheet(self) -> Any:
        from rcac_numeric.reports._log import log_sheet

        return log_sheet(self)

    def report(self) -> str:
        """The columns, the clock, and the signals that would be used, as text."""
        return report_of(self._sheet())

    @in_few_lines
    def __str__(self) -> str:
        return self.report()

    def named(self, name: str, topic: str = "") -> list[LogColumn]:
        """The columns of a name: alone, with its topic, with its unit, or numbered from 0 or 1.

        Of several topics with a column of this name it is that of `topic`.
        """
        exact = [c for c in self.columns if name in (c.full_name, c.name)]
        if exact:
            return exact if len(exact) == 1 else _one_topic(self, name, exact, topic)
        bare, unit = split_unit(name)
        if unit:
            exact = [c for c in self.columns if (bare, unit) == (c.name, c.unit)]
            if exact:
                return exact
        members = _numbered(self.columns, name, topic)
        if members:
            return members
        folded = [c for c in self.columns if name.lower() in (c.full_name.lower(), c.name.lower())]
        if folded:
            return folded if len(folded) == 1 else _one_topic(self, name, folded, topic)
        return _numbered(self.columns, name, topic, fold=True)

    def numbers_of(self, columns: Sequence[LogColumn]) -> tuple[Array, str]:
        """The numbers of columns, shape (rows,) or (rows, width), with their topic."""
        for column in columns:
            if column.problem:
                raise InputError(f"{column.problem}")
        parts = [c.values for c in columns if c.values is not None]
        if len(parts) == 1 and not (self.is_table and parts[0].ndim == 1):
            return parts[0], columns[0].topic
        return np.column_stack(parts), columns[0].topic

    def variables(self) -> dict[str, Array]:
        """The numbers by name; consecutively numbered columns also as one array."""
        alone = {c.full_name: c.values for c in self.columns if c.values is not None}
        result: dict[str, Array] = {
            name: values.reshape(-1, 1) if self.is_table and values.ndim == 1 else values
            for name, values in alone.items()
        }
        for column in self.columns:
            match = NUMBERED.match(column.full_name)
            if match and match[1] not in result:
                members = _numbered(self.columns, match[1])
                parts = [m.values for m in members if m.values is not None]
                if parts and len(parts) == len(members):
                    result[match[1]] = np.column_stack(parts)
        return result


def _numbered(
    columns: Sequence[LogColumn], name: str, topic: str = "", *, fold: bool = False
) -> list[LogColumn]:
    """The columns name1, name2, ... in order, if they are consecutive from 0 or 1."""
    target = name.lower() if fold else name
    members: dict[str, dict[int, LogColumn]] = {}
    for column in columns:
        match = NUMBERED.match(column.name)
        if not match:
            continue
        base = match[1].lower() if fold else match[1]
        if target in (base, f"{column.topic}.{base}"):
            members.setdefault(column.topic, {})[int(match[2])] = column
    members = {topic: members[topic]} if topic in members else members
    for parts in members.values():
        first, last = min(parts), max(parts)
        if first in (0, 1) and last - first + 1 == len(parts) and len(members) == 1:
            return [parts[i] for i in sorted(parts)]
    return []


def _one_topic(
    contents: LogContents, name: str, columns: list[LogColumn], topic: str
) -> list[LogColumn]:
    """The column of the topic; refuses those of other topics."""
    inside = [c for c in columns if c.topic == topic]
    if len(inside) == 1:
        return inside
    names = ", ".join(c.full_name for c in columns)
    full = columns[0].full_name
    option = f'"u={full}"' if " " in full else f"u={full}"
    raise InputError(
        f"{contents.source} has {len(columns)} columns {name!r}: {shortened(names, 200)}. Give the "
        f"full name, for instance names={{'u': {full!r}}}, at a shell --names {option}."
    )


def with_clocks(
    contents: LogContents,
    time: str | None = None,
    sample_time: float | None = None,
    signals: Collection[str] = (),
) -> LogContents:
    """Find the column of times of every topic, and the clock of its stamps.

    `time` names the column, or "none" for rows of equal distance whatever the stamps say. Columns
    that are named as signals hold no times.
    """
    clocks: dict[str, Clock | None] = {}
    stamps: list[str] = []
    notes = [*contents.notes]
    for topic in contents.topics:
        columns = [
            c for c in contents.columns
            if c.topic == topic and c.full_name not in signals and c.name not in signals
        ]  # fmt: skip
        clocks[topic] = None
        if time == "none":
            continue
        unread = _not_rising(columns) if time is None else None
        is_named = len(contents.topics) == 1 or any(time in (c.name, c.full_name) for c in columns)
        for chosen in _time_columns(columns, time if is_named else None):
            if unread is not None and is_counter(chosen.name, chosen.unit):
                continue
            times, unit = _times(chosen, columns, sample_time)
            if times is not None:
                break
            unread = _unread(columns, unit) if unread is None else unread
        else:
            constant = _constant(columns)
            clocks[topic] = unread if constant is None else constant
            notes += _passed_over(columns) if clocks[topic] is None else []
            stamps += [] if unread is None else [unread.column]
            continue
        counts = unit != "time stamps" and is_counter(chosen.name, chosen.unit)
        counts &= bool((times % 1 == 0).all())
        clocks[topic] = clock_of(
            times, chosen.full_name, unit=unit, is_counter=counts, lines=chosen.lines
        )  # fmt: skip
        stamps.append(chosen.full_name)
        notes += _passed_over(columns) if counts and time is None else []
    if time not in (None, "none") and not stamps:
        raise InputError(
            f"{contents.source} has no column {time!r} with times; it has "
            f"{shortened(', '.join(c.full_name for c in contents.columns), 300)}."
        )
    return attrs.evolve(contents, clocks=clocks, notes=tuple(notes))


def _time_columns(columns: Sequence[LogColumn], time: str | None) -> list[LogColumn]:
    """The columns that may be the times: the named one, or stamps, then seconds, then counts."""
    if time is not None:
        return [c for c in columns if time in (c.name, c.full_name)][:1]
    long = [c for c in columns if _is_vector(c)]
    tests = (
        lambda c: c.stored == "time stamps",
        lambda c: is_time(c.name, c.unit) and not _is_day(c) and _may_be_time(c),
        lambda c: c.values is None and not _is_day(c) and seconds_of_texts(c.texts[:2]) is not None,
        lambda c: is_counter(c.name, c.unit) and _rises(c),
    )
    return [c for test in tests for c in long if test(c)]


def _unread(columns: Sequence[LogColumn], name: str) -> Clock | None:
    """The refused clock of a column of texts; None if its name and its texts are no clock's."""
    column = next(c for c in columns if c.full_name == name)
    is_clock = is_time(column.name, column.unit) or np.mean(unread_stamps(column.texts)) < 0.5
    return unread_clock(column.full_name, column.texts, column.lines) if is_clock else None


def _not_rising(columns: Sequence[LogColumn]) -> Clock | None:
    """The refused clock of numbers whose name says that they are times, and which do not rise."""
    for column in columns:
        is_clock = is_time(column.name, column.unit) and not _is_quantity(column)
        if not is_clock or not _is_vector(column) or _is_day(column) or _may_be_time(column):
            continue
        if column.values is not None:
            return clock_of(column.values.ravel(), column.full_name, lines=column.lines)
    return None


def _is_quantity(column: LogColumn) -> bool:
    """Whether the name may be that of a temperature or a thickness."""
    return column.name in "tT" and not column.unit


def _is_day(column: LogColumn) -> bool:
    """Whether a column holds the day of all rows."""
    if column.name.lower() != "date":
        return False
    if column.values is None:
        return len({*column.texts}) == 1 and ":" not in column.texts[0]
    return not _may_be_time(column)


def _passed_over(columns: Sequence[LogColumn]) -> list[str]:
    """The notes on columns that have names of times, and are none."""
    notes = []
    for column in columns:
        is_time_name = is_time(column.name, column.unit) and _is_vector(column)
        is_quantity = _is_quantity(column) and not _may_be_time(column)
        if (
            not is_time_name
            or column.missing == column.rows
            or not (is_quantity or _is_day(column))
        ):
            continue
        d = np.zeros(1) if column.values is None else np.diff(column.values.ravel())
        turns = int(np.count_nonzero(d < 0))
        words = f"turns back in {turns} of {column.rows}" if turns else "has the same value in all"
        notes.append(f"{column.full_name} {words} rows, and is not read as times")
    return notes


def _is_vector(column: LogColumn) -> bool:
    """Whether a column holds one number or text for each of several rows."""
    if column.values is None:
        return len(column.texts) > 1
    size = int(column.values.size)
    return column.values.dtype.kind != "c" and size > 1 and size == max(column.values.shape)


def _rises(column: LogColumn) -> bool:
    return column.values is not None and bool((np.diff(column.values.ravel()) > 0).all())


def _may_be_time(column: LogColumn) -> bool:
    """Whether numbers rise but for a few rows; a temperature T or a thickness t does not."""
    if column.values is None:
        return column.name != "T"
    d = np.diff(column.values.ravel())
    return bool(np.mean(d < 0) < MOST_TURNS and (d > 0).any()) and (
        column.name != "T" or _rises(column)
    )


def _constant(columns: Sequence[LogColumn]) -> Clock | None:
    """The clock of a topic with a sample time as a constant."""
    for column in columns:
        value = column.values
        if column.name.lower() in CONSTANTS and value is not None and np.size(value) == 1:
            period = float(np.ravel(value)[0].real)
            if np.isfinite(period) and period > 0:
                return Clock(column.full_name, period, 0, 0)
    return None


def _times(
    chosen: LogColumn, columns: Sequence[LogColumn], sample_time: float | None
) -> tuple[Array | None, str]:
    """The times of a column in seconds and their unit; or None and the name of its texts."""
    if chosen.values is not None:
        values = chosen.values.ravel()
        if chosen.stored == "time stamps":
            return values, "time stamps"
        return in_seconds(values, chosen.name, chosen.unit, sample_time)
    times = seconds_of_texts(chosen.texts)
    if times is None:
        return None, chosen.full_name
    if len(chosen.texts[0]) > len("00:00:00.000000 PM"):
        return times, "time stamps"
    # A date and a time of day may stand in two columns.
    is_date = ":" not in chosen.texts[0]
    for other in columns:
        is_pair = bool(other.texts) and (":" in other.texts[0]) == is_date
        if other is not chosen and is_pair and other.name.lower() in TIMES:
            more = seconds_of_texts(other.texts)
            if more is None:
                return None, other.full_name
            if len(more) == len(times):
                return times + more, "time stamps"
    return times if is_date else over_midnight(times), "time stamps"
