"""The clock of a log: sample time, jitter, gaps, repeated and turning stamps."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from datetime import datetime, timedelta
from functools import cache
from typing import Any

import attrs
import numpy as np

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._rounding import rounding_of
from rcac_numeric.arrays._validation import array_like
from rcac_numeric.arrays._values import Result
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.signals._text_tables import MISSING

SECONDS = {
    "s": 1.0, "sec": 1.0, "secs": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "msec": 1e-3,
    "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "usec": 1e-6, "ns": 1e-9, "nsec": 1e-9, "min": 60.0,
    "minutes": 60.0, "h": 3600.0, "hours": 3600.0, "d": 86400.0, "days": 86400.0,
}  # fmt: skip
# A column of this name holds times, or counts steps.
TIMED = ("t", "time", "timestamp", "seconds", "stamp", "datetime", "date", "zeit", "elapsed",
         "tout", "timestamp_sample", "elapsed_time", "time stamp", "date/time",
         "local time")  # fmt: skip
COUNTED = ("k", "n", "i", "step", "steps", "index", "sample", "samples", "row", "no", "nr", "#")
TIMES = (*TIMED, *COUNTED)
# Numbers of this size are counted from 1970; the unit follows from the size.
SINCE_1970 = ((1e17, "ns"), (1e14, "us"), (1e11, "ms"), (1e8, "s"))
# From 1954 to 2119, and from 1954 to 2081.
SERIAL_DAYS = ((20_000.0, 80_000.0, "a spreadsheet"), (714_000.0, 760_000.0, "MATLAB"))
LONGEST_STEP = 0.01  # days, in a column whose name does not say that it holds dates
NO_DATES = ("seconds", "elapsed", "elapsed_time", "tout", "timestamp_sample")
DIGITS = "YYYYMMDDhhmmss"
JITTER = 0.3  # of a sample time: a stamp further away belongs to no step of the grid
STRAY = 0.01  # of the rows may
FEW_GAPS = 5  # may be evenly spread by accident
RARE = 0.2  # of the rows: fewer may repeat a stamp since they stand twice
LONGEST_PAUSE = 10  # times the rows of the log
DATES = (
    "%d.%m.%Y", "%m/%d/%Y", "%d/%m/%Y", "%Y/%m/%d", "%d-%m-%Y", "%d.%m.%y", "%m/%d/%y", "%d/%m/%y",
    "%d-%b-%Y", "%b %d %Y", "%d %b %Y", "%d-%b-%y", "%d %b %y", "%d/%b/%Y",
)  # fmt: skip
HOURS = ("%H:%M:%S", "%H:%M:%S.%f", "%H:%M:%S,%f", "%H:%M:%S:%f", "%H:%M", "%I:%M:%S %p",
         "%I:%M:%S.%f %p", "%I:%M %p")  # fmt: skip
SAMPLED = 5  # texts of a column whose forms are tried
DURATION = re.compile(
    r"(?:(?P<days>-?\d+) days? ?,? ?)?(?:(?P<h>\d+):)?(?P<m>\d+):(?P<s>\d+(?:[.,]\d+)?)"
)


@attrs.frozen(eq=False, slots=False)
class Clock(Result):
    """The steps of a log by its time stamps.

    Attributes
    ----------
    column : str
        The column of the stamps.
    sample_time : float or None
        In seconds; None for a counter of steps.
    rows : int
        Rows with a stamp.
    steps : int
        Steps from the first to the last one, missing ones included.
    jitter : float
        Largest distance of the time between two rows from whole sample times, in sample times.
    gaps : int
        Places where rows are missing.
    longest_gap : float
        In steps from row to row; 1 without a gap.
    repeated, turning : int
        Rows with the stamp of the row before, or an earlier one.
    resolution : float
        Step of the stamps in seconds, where it hides the jitter; 0 otherwise.
    problem : str
        Why these stamps give no sample time; empty where they do.
    unit : str
        Of the stamps; with "assumed" where the file does not say it.
    step_of_row : array of int, shape (rows,)
        The step of every row.
    times : array, shape (rows,)
        The stamps in seconds, or the counts.
    """

    column: str
    sample_time: float | None
    rows: int
    steps: int
    jitter: float = 0.0
    gaps: int = 0
    longest_gap: float = 1.0
    repeated: int = 0
    turning: int = 0
    resolution: float = 0.0
    problem: str = ""
    unit: str = "s"
    step_of_row: Array = attrs.field(
        factory=lambda: np.zeros(0, int), converter=array_like, repr=False
    )
    times: Array = attrs.field(factory=lambda: np.zeros(0), converter=array_like, repr=False)

    @property
    def missing(self) -> int:
        """Number of missing rows."""
        return self.steps - self.rows

    @property
    def is_regular(self) -> bool:
        """Whether no two rows share a step."""
        return not self.problem

    def __str__(self) -> str:
        if self.problem:
            return self.problem
        if self.sample_time is None:
            words = f"{self.column} counts {self.steps} steps"
        else:
            words = f"sample time {self.sample_time:.9g} s, from {self.column} [{self.unit}]"
            words += f"; jitter up to {self.jitter:.2%} of it" if self.jitter > 1e-9 else ""
        words += f"; stamps in steps of {self.resolution:.3g} s" if self.resolution else ""
        if self.missing:
            longest = f"{self.longest_gap - 1:.0f} rows"
            words += f"; {self.missing} of {self.steps} rows are missing in {self.gaps} gaps, the "
            words += f"longest of {longest}"
        return words


def clock_of(
    times: Array, column: str, *, unit: str = "s", is_counter: bool = False,
    lines: Sequence[int] = (),
) -> Clock:  # fmt: skip
    """Find the sample time and the step of every row; times in seconds, or counts.

    `lines` are those of the rows in a file, for the words of a problem.

    The sample time is the slope of the stamps over the steps, which are the rounded multiples of
    the usual time between two rows.

    Examples
    --------
    >>> from rcac_numeric.signals._clock import clock_of
    >>> print(clock_of(np.array([0.0, 0.1, 0.2, 0.4, 0.5]), "t"))
    sample time 0.1 s, from t [s]; 1 of 6 rows are missing in 1 gaps, the longest of 1 rows
    """
    rows = len(times)

    def refused(problem: str, **counts: int) -> Clock:
        return Clock(
            column, None, rows, rows, problem=problem, unit=unit, times=times, **counts
        )  # fmt: skip

    if rows < 2:
        return refused(f"{column} has {rows} stamps, which give no sample time")
    if not np.isfinite(times).all():
        first = int(np.argmin(np.isfinite(times)))
        return refused(f"{column} has no stamp in {place_of(first, lines)}")
    d = np.diff(times)
    if not d.any():
        return refused(f"{column} has the same stamp in every row, which gives no sample time")
    turning = int(np.count_nonzero(d < 0))
    if turning:
        first = int(np.argmax(d < 0))
        return refused(
            f"{column} turns back from {times[first]:.9g} to {times[first + 1]:.9g} in "
            f"{place_of(first + 1, lines)}; rows that turn back: {turning}", turning=turning
        )  # fmt: skip
    rounding = rounding_of(times - times[0])
    places = rounding.places
    # Of stamps below 1 s three digits are three decimals, too, if none has more.
    decimals = np.round(times - times[0], places)
    is_decimal = np.abs(times - times[0] - decimals).max() <= 4 * np.spacing(np.abs(times).max())
    is_decimal &= rounding.printing in ("decimals", "digits")
    fraction = 10.0**-places if is_decimal else rounding.step
    if rounding.is_exact and (d % 1 == 0).all():
        fraction = 1.0
    even = (times[-1] - times[0]) / (rows - 1)
    away = np.abs(times - times[0] - even * np.arange(rows))
    repeated = int(np.count_nonzero(d == 0))
    multiples = None if repeated else _steps(d)
    # Stamps of whole seconds, for instance, of which ten rows have the same one.
    is_coarse = fraction > 0 and even > 0 and away.max() <= 1.001 * fraction
    is_coarse &= multiples is None or _is_evenly_spread(np.diff(multiples))
    is_coarse &= not repeated or (even < 1.5 * fraction and _is_rounded(d))
    if repeated and not is_coarse:
        first = int(np.argmax(d == 0))
        return refused(
            f"{column} has {repeated} rows with the stamp of the row before, the first in "
            f"{place_of(first + 1, lines)}", repeated=repeated
        )  # fmt: skip
    if is_coarse or (multiples is None and np.quantile(away, 1 - STRAY) <= JITTER * even):
        multiples = np.arange(rows)
    if multiples is None:
        low, high = np.quantile(d, [0.05, 0.95])
        return refused(
            f"{column} is irregular: 90 % of the rows are {low:.3g} to {high:.3g} "
            f"{'steps' if is_counter else 's'} apart, and no sample time explains them"
        )
    steps = multiples
    period = float(np.polyfit(steps, times - times[0], 1)[0]) if rows > 2 else float(d[0])
    counts = np.diff(steps)
    jitter = float(np.abs(d / period - counts).max())
    is_coarse = bool(is_coarse and not is_counter and jitter > 1e-6)
    spread = float(np.std(times - times[0] - period * steps))
    if steps[-1] + 1 > LONGEST_PAUSE * rows + 1000:
        at = int(np.argmax(counts))
        return refused(
            f"{column} pauses for {d[at]:.4g} {'steps' if is_counter else 's'} after "
            f"{place_of(at, lines)}, "
            f"{counts[at]} times the sample time: two logs in one"
        )
    # Neat numbers: 0.004 and not 0.00400000000012, where the stamps cannot tell them apart.
    error = 8 * max(spread, np.spacing(np.abs(times).max())) / rows**1.5  # of a slope
    neat = float(f"{period:.9g}")
    for digits in range(1, 9):
        if abs(float(f"{period:.{digits}g}") - period) <= max(error, 1e-9 * period):
            neat = float(f"{period:.{digits}g}")
            break
    return Clock(
        column, None if is_counter else neat, rows, int(steps[-1]) + 1,
        0.0 if is_coarse else jitter, int(np.count_nonzero(counts > 1)),
        float(counts.max()), repeated, unit=unit,
        resolution=fraction if is_coarse else 0.0, step_of_row=steps, times=times,
    )  # fmt: skip


def _is_rounded(d: Array) -> bool:
    """Whether stamps repeat as rounded ones of even rows do, and not since a row stands twice.

    Those repeat often, or evenly spread, or a longer distance follows: 0, 1, 1, 3 s.
    """
    repeated = int(np.count_nonzero(d == 0))
    if repeated >= RARE * len(d):
        return True
    longer = np.rint(d[d > 0] / np.median(d[d > 0])) - 1
    return repeated > FEW_GAPS and (_is_evenly_spread(d == 0) or 2 * longer.sum() >= repeated)


def unread_clock(column: str, texts: Sequence[str], lines: Sequence[int] = ()) -> Clock:
    """The clock of texts that are not all times: it states the first entry that is none."""
    rows, unread = len(texts), unread_stamps(texts)
    unread = unread if unread.any() else np.ones(rows, bool)  # 0,5: a number of another language
    count, first = int(unread.sum()), int(np.argmax(unread))
    words = "stamps is no time:" if count == 1 else "stamps are no times, the first"
    return Clock(
        column, None, rows, rows, unit="time stamps", times=np.full(rows, np.nan),
        problem=f"column {column}: {count} of {rows} {words} {shortened(texts[first], 60)!r} in "
        f"{place_of(first, lines)}",
    )  # fmt: skip


def place_of(row: int, lines: Sequence[int] = ()) -> str:
    """The words for a row from 0, with its line in a file."""
    return f"row {row + 1}" + (f" (line {lines[row]})" if row < len(lines) else "")


def _is_evenly_spread(counts: Array) -> bool:
    """Whether the long distances between rows are those that rounded stamps of even rows have.

    Rows that are lost leave one gap here and one there.
    """
    places = np.flatnonzero(counts > counts.min())
    return not len(places) or (len(places) > FEW_GAPS and int(np.ptp(np.diff(places))) <= 1)


def _steps(d: Array) -> Any:
    """Return the steps of rows whose distances are multiples of one sample time, or None."""
    single = d[d <= 1.5 * np.quantile(d, 0.1)]
    period = float(np.median(single))
    counts = np.maximum(np.rint(d / period), 1)
    for _ in range(3):
        period = float(d.sum() / counts.sum())
        counts = np.maximum(np.rint(d / period), 1)
    stray = np.mean(np.abs(d / period - counts) > JITTER)
    if stray > STRAY:
        return None
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


# Reading times.


def is_time(name: str, unit: str) -> bool:
    """Whether a column of this name and unit holds times."""
    base, _ = _name_and_unit(name)
    return base in TIMED and (not unit or unit.lower() in SECONDS or _is_format(unit))


def is_counter(name: str, unit: str) -> bool:
    """Whether a column of this name counts steps."""
    return name.lower() in COUNTED and unit.lower() in {"", "-", "1"}


def _is_format(unit: str) -> bool:
    """Whether the brackets hold the form of a date, as in Time (hh:mm:ss)."""
    return bool(re.fullmatch(r"[hmsHMSyYdD:./\- ]+", unit)) or unit.upper() in {"UTC", "GMT"}


def _name_and_unit(name: str) -> tuple[str, str]:
    """Return the name in small letters without a unit behind it: time_ms, timeUs."""
    low = name.lower().strip()
    match = re.fullmatch(r"(t|time|timestamp|stamp|elapsed)[_ \-.]?(ms|us|ns|sec|s|min)", low)
    if match and low not in {"times", "stamps"}:
        return match[1], match[2]
    return low, ""


def in_seconds(
    values: Array, name: str, unit: str, sample_time: float | None = None
) -> tuple[Array, str]:
    """Return the times of a column of numbers in seconds, and the words for their unit.

    Where the file does not say the unit it follows from the size of the numbers (since 1970, days
    of a spreadsheet, YYYYMMDDhhmmss), from the sample time, or it is seconds; whole numbers of a
    `timestamp` are microseconds, as PX4 and ROS write them.
    """
    base, suffix = _name_and_unit(name)
    known = unit.lower() if unit.lower() in SECONDS else suffix
    if known:
        return values * SECONDS[known], known
    finite = values[np.isfinite(values)]
    size = float(np.abs(finite).min(initial=np.inf))
    dated = _of_digits(values)
    if dated is not None:
        return dated, DIGITS
    writer = next((word for low, high, word in SERIAL_DAYS if low < size < high), "")
    if writer and base in TIMED and np.any(finite % 1):
        rounding = rounding_of(values)
        since = values - values[0]
        if rounding.printing == "decimals":
            since = np.round(since, rounding.places)
        if base in {"date", "datetime", "timestamp"} and 0 < np.median(np.diff(finite)) < 1:
            return since * 86400.0, f"days of {writer}"
        if base not in NO_DATES and _are_days(since, sample_time):
            return since * 86400.0, f"days of {writer}, assumed"
    for least, word in SINCE_1970:
        if least <= size < 100 * least * (10 if word == "s" else 1):
            return (values - values[0]) * SECONDS[word], f"{word} since 1970"
    d = np.diff(finite)
    typical = float(np.median(d[d > 0])) if (d > 0).any() else 0.0
    whole = bool((finite % 1 == 0).all())
    if sample_time is not None and typical > 0 and whole:
        for word in ("s", "ms", "us", "ns"):
            if abs(typical * SECONDS[word] / sample_time - 1) < 0.05:
                return values * SECONDS[word], f"{word}, by the given sample time"
    if base.startswith("timestamp") and whole and typical >= 1:
        return values * 1e-6, "us, assumed"
    return values, "s" if base == "seconds" else "s, assumed"


def _are_days(since: Array, sample_time: float | None) -> bool:
    """Whether steps below 0.01 are neater, or nearer to the sample time, in days than in seconds.

    45 720 may be a date of a spreadsheet, or the seconds since a device was started.
    """
    d = np.diff(since)
    if not d.size or not 0 < np.median(d) < LONGEST_STEP:
        return False
    clock = clock_of(since, "")
    period = float(clock.sample_time or np.median(d))
    off = [
        abs(float(f"{step:.1e}") / step - 1) if sample_time is None else
        abs(np.log(step / sample_time)) for step in (86400.0 * period, period)
    ]  # fmt: skip
    return off[0] <= off[1]


def _of_digits(values: Array) -> Array | None:
    """Seconds from the first of the numbers 20250304140320; None unless each one is a time."""
    is_known = np.isfinite(values)
    known = values[is_known]
    if not known.size or not ((known >= 19e12) & (known < 22e12) & (known % 1 == 0)).all():
        return None
    parts = []
    rest = known.astype(np.int64)
    for size in (100, 100, 100, 100, 100):
        rest, part = np.divmod(rest, size)
        parts.append(part)
    second, minute, hour, day, month = parts
    months = ((rest - 1970) * 12 + month - 1).astype("datetime64[M]")
    dates = months.astype("datetime64[D]") + (day - 1)
    is_time = (second < 60) & (minute < 60) & (hour < 24) & (month >= 1) & (month <= 12)
    if not (is_time & (day >= 1) & (dates.astype("datetime64[M]") == months)).all():
        return None
    stamps = 86400.0 * dates.astype(np.int64) + 3600.0 * hour + 60.0 * minute + second
    times = np.full(values.shape, np.nan)
    times[is_known] = stamps - stamps[0]
    return times


def seconds_of_texts(texts: Sequence[str]) -> Array | None:
    """Return stamps in seconds from the first one, or None if the texts are none."""
    first = next((text for text in texts if text.lower() not in MISSING), None)
    if first is None:
        return None
    best: Array | None = None
    mark = (True, np.inf)
    for read in _readers(first):
        try:
            values = np.array([np.nan if text.lower() in MISSING else read(text) for text in texts])
        except (ValueError, OverflowError):
            continue
        span = float(np.nanmax(values) - np.nanmin(values))
        turns = bool((np.diff(values[np.isfinite(values)]) < 0).any())
        # A date that can be read in two ways is the one with the smaller span.
        if best is None or (turns, span) < mark:
            best, mark = values, (turns, span)
        if read is _iso or read is _duration:
            break
    if best is None:
        return None
    return np.asarray((best - best[np.isfinite(best)][0]) / 1e6)


def unread_stamps(texts: Sequence[str]) -> Array:
    """Whether each text is no time in the form that reads most of them; a number may be one."""
    every = max(len(texts) // SAMPLED, 1)
    readers = {_number}.union(*(_readers(text) for text in texts[::every]))
    masks = [[not _is_read(read, text) for text in texts] for read in readers]
    return np.asarray(min(masks, key=sum), dtype=bool)


def _is_read(read: Callable[[str], float], text: str) -> bool:
    try:
        return text.lower() in MISSING or bool(np.isfinite(read(text)))
    except (ValueError, OverflowError):
        return False


def _number(text: str) -> float:
    return float(text.replace(",", "."))


def _readers(first: str) -> list[Callable[[str], float]]:
    """The readers of a text that begins as this one does."""
    readers: list[Callable[[str], float]] = []
    for read in (_iso, _duration):
        try:
            read(first)
        except (ValueError, OverflowError):
            continue
        return [read]
    for date in DATES:
        for hours in HOURS:
            for form in (f"{date} {hours}", f"{date}T{hours}", f"{date}, {hours}"):
                try:
                    datetime.strptime(first, form)
                except ValueError:
                    continue
                readers.append(_by_form(form))
    for form in (*HOURS, *DATES):
        try:
            datetime.strptime(first, form)
        except ValueError:
            continue
        readers.append(_by_form(form))
    return readers


EPOCH = datetime(1970, 1, 1)


def _iso(text: str) -> float:
    """Microseconds of ISO 8601; without a zone as if it were UTC."""
    if not re.match(r"\d{4}-?\d\d-?\d\d", text):
        raise ValueError(text)
    stamp = datetime.fromisoformat(text)
    offset = stamp.utcoffset() or timedelta()
    return (stamp.replace(tzinfo=None) - EPOCH - offset) / timedelta(microseconds=1)


@cache
def _by_form(form: str) -> Callable[[str], float]:
    def read(text: str) -> float:
        return (datetime.strptime(text, form) - EPOCH) / timedelta(microseconds=1)

    return read


def _duration(text: str) -> float:
    """Microseconds of 12:00:01.5, 01:02.5 or 0 days 00:00:00.100000."""
    match = DURATION.fullmatch(text)
    if match is None:
        raise ValueError(text)
    parts = match.groupdict(default="0")
    seconds = 60.0 * int(parts["m"]) + float(parts["s"].replace(",", "."))
    return 1e6 * (86400.0 * int(parts["days"]) + 3600.0 * int(parts["h"]) + seconds)


def over_midnight(times: Array) -> Array:
    """Add a day wherever a time of day begins again."""
    turns = np.concatenate([[0], np.cumsum(np.diff(times) < -43200.0)])
    return np.asarray(times + 86400.0 * turns)
