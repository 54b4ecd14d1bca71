"""Tables in text files: head, units, comments, separators, decimal signs and encodings."""

from __future__ import annotations

import csv
import gzip
import io
import re
import zlib
from array import array
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import IO, TextIO

import numpy as np

from compensator_theory.errors import Advice, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._files import MOST_BYTES
from rcac_numeric.arrays._untrusted import ReadingLimit
from rcac_numeric.arrays._wording import shortened

BLANKS = " "  # any number of blanks and tabs between two entries
SEPARATORS = (";", "\t", ",", "|", BLANKS)
COMMENTS = ("#", "%")
HEAD_LINES = 200  # searched for names, units and the first row of numbers
LONGEST_HEAD = 2**22  # characters of these lines
ROWS_AT_ONCE = 50_000
MISSING = frozenset({"", "nan", "na", "n/a", "#n/a", "null", "none", "-", "--", "?", "<na>", "nat"})
GROUPED = {
    ",": re.compile(r"[+-]?\d{1,3}(\.\d{3})+,\d+"), ".": re.compile(r"[+-]?\d{1,3}(,\d{3})+\.\d+")
}  # fmt: skip
TRUTHS = {"true": 1.0, "false": 0.0}
# A row of units below the names: brackets, or one of these in most of its fields.
UNITS = frozenset((
    "s", "ms", "us", "µs", "μs", "ns", "min", "h", "hz", "khz", "mhz", "v", "mv", "kv", "uv", "a",
    "ma", "ka", "w", "mw", "kw", "n", "nm", "kn", "m", "mm", "cm", "km", "m/s", "m/s2", "m/s^2",
    "rad", "deg", "°", "rad/s", "deg/s", "°/s", "rpm", "1/min", "c", "degc", "°c", "k", "f", "degf",
    "°f", "pa", "kpa", "mpa", "bar", "mbar", "psi", "l/min", "l/s", "m3/h", "kg", "g", "kg/s", "%",
    "-", "1", "[-]", "counts", "lsb", "t", "g/l",
))  # fmt: skip
MOST_TRIED = 10  # rows from which separator and decimal sign are read


@dataclass
class TextColumn:
    """One column of a text: its numbers, or its texts and the first entry that is no number."""

    name: str
    unit: str = ""
    numbers: Array = field(default_factory=lambda: np.zeros(0))
    texts: list[str] = field(default_factory=list)
    problem: str = ""
    lines: Sequence[int] = ()  # of the rows, where they are known


@dataclass(frozen=True)
class Dialect:
    """The format of a text; `start` lines stand before the first row of numbers."""

    encoding: str
    separator: str
    decimal: str
    start: int
    names: tuple[str, ...]
    units: tuple[str, ...]
    width: int
    has_comments: bool = False

    def fields(self, line: str) -> list[str]:
        """Return the entries of a line."""
        return _fields(line, self.separator)


def read_text_columns(
    file: TextSource, columns: Sequence[str] = (), notes: list[str] | None = None
) -> tuple[list[TextColumn], Dialect]:
    """Read the columns of a table; without a head and `columns` their names are empty."""
    problem: Exception | None = None
    for encoding in _encodings(file):
        try:
            dialect = _dialect(file, encoding)
            _require_room(file, dialect)
            return _labelled(file, dialect, _columns(file, dialect, notes), columns), dialect
        except UnicodeDecodeError as error:
            problem = problem or error
        except csv.Error as error:
            problem = error
            break
    raise InputError(f"{file} is not a text file of numbers: {shortened(str(problem), 200)}.")


def as_number(text: str, decimal: str = ".") -> float | None:
    """Return the number of a text, or None; Python's 1_000 is refused."""
    if decimal == ",":
        if "." in text:
            return None
        text = text.replace(",", ".")
    try:
        return None if "_" in text else float(text)
    except ValueError:
        pass
    try:  # Fortran's double precision
        return float(re.sub(r"(?<=[\d.])[dD](?=[+-]?\d+$)", "e", text)) if "_" not in text else None
    except ValueError:
        return None


def table_number(text: str, decimal: str) -> float | None:
    """Return the number of an entry; 1.234,5 and 1,234.5 have groups of thousands."""
    value = as_number(text, decimal)
    if value is None and GROUPED[decimal].fullmatch(text):
        value = float(text.replace("." if decimal == "," else ",", "").replace(",", "."))
    return value


def split_unit(name: str) -> tuple[str, str]:
    """Return a name without the unit behind it, and the unit.

    Examples
    --------
    >>> from rcac_numeric.signals._text_tables import split_unit
    >>> split_unit("T (degC)"), split_unit("u [V]"), split_unit("t/ms"), split_unit("theta(1)")
    (('T', 'degC'), ('u', 'V'), ('t', 'ms'), ('theta(1)', ''))
    """
    match = re.fullmatch(r"(.*\S)\s*(?:\[([^\]\d][^\]]*)\]|\(([^)\d][^)]*)\))", name, re.DOTALL)
    if match:
        return match[1].strip(), (match[2] or match[3] or "").strip()
    slash = re.fullmatch(r"([^/,]*[^/,\s])\s*[/,]\s*(\S+)", name)
    if slash and slash[2].lower() in UNITS:
        return slash[1], slash[2]
    return name, ""


# Encoding and lines.


@dataclass(frozen=True)
class Unpacked:
    """Bytes that stand for a file: of a .gz file, or of a sheet that was written as text."""

    name: str
    data: bytes = field(repr=False)
    separator: str = ""  # where the writer knows it

    def __str__(self) -> str:
        return self.name


TextSource = Path | Unpacked


def unpacked(file: Path) -> Unpacked:
    """Unpack a .gz file; at most MOST_BYTES."""
    try:
        with gzip.open(file, "rb") as stream:
            data = stream.read(MOST_BYTES + 1)
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise InputError(f"{file} is a damaged .gz file: {error}.") from None
    if len(data) > MOST_BYTES:
        raise InputError(f"{file} unpacks to more than {MOST_BYTES} bytes. Cut it.")
    if not data:
        raise InputError(f"{file} is empty.")
    return Unpacked(str(file), data)


def opened_bytes(file: TextSource) -> IO[bytes]:
    """Open a file, or the bytes that stand for one."""
    return io.BytesIO(file.data) if isinstance(file, Unpacked) else file.open("rb")


def _encodings(file: TextSource) -> list[str]:
    """Return the encodings to try, from the first bytes."""
    with opened_bytes(file) as stream:
        first = stream.read(4096)
    if first.startswith((b"\xff\xfe", b"\xfe\xff")):
        return ["utf-16"]
    if b"\0" in first:
        # Text of a program that writes UTF-16 without its mark: every second byte is null.
        odd, even = first[1::2].count(b"\0"), first[::2].count(b"\0")
        if max(odd, even) > 0.4 * len(first) > 2 * min(odd, even):
            return ["utf-16-le" if odd > even else "utf-16-be"]
        raise InputError(f"{file} is not a text file of numbers: it holds null characters.")
    return ["utf-8-sig", "latin-1"]


def _opened(file: TextSource, encoding: str) -> TextIO:
    return io.TextIOWrapper(opened_bytes(file), newline="", encoding=encoding)


def _lines(file: TextSource, encoding: str) -> Iterator[str]:
    """The lines of a text, whatever ends them."""
    with io.TextIOWrapper(opened_bytes(file), encoding=encoding) as stream:
        yield from stream


def _fields(line: str, separator: str) -> list[str]:
    """Return the entries of a line, stripped, without quotes."""
    if separator == BLANKS:
        if '"' not in line:
            return line.split()
        parts = csv.reader([line.replace("\t", " ").strip()], delimiter=" ", skipinitialspace=True)
    else:
        parts = csv.reader([line.rstrip("\r\n")], delimiter=separator, skipinitialspace=True)
    return [entry.strip() for entry in next(parts, [])]


def is_comment(line: str) -> bool:
    """Whether a line is a comment of Python, Octave, gnuplot or MATLAB."""
    return line.lstrip(" \t").startswith(COMMENTS)


# The dialect: separator, decimal sign, head.


def _dialect(file: TextSource, encoding: str) -> Dialect:
    """Return how a text is written, from its first lines."""
    lines, size = [], 0
    for line in islice(_lines(file, encoding), HEAD_LINES):
        lines.append(line)
        size += len(line)
        if size > LONGEST_HEAD:
            break
    forced, skipped = file.separator if isinstance(file, Unpacked) else "", 0
    if lines and (match := re.fullmatch(r'"?sep=(.)"?\s*', lines[0], re.IGNORECASE)):
        forced, skipped = match[1], 1
    rows = {
        i: line for i, line in enumerate(lines)
        if i >= skipped and line.strip() and not is_comment(line)
    }  # fmt: skip
    comments = [i for i, line in enumerate(lines) if i >= skipped and is_comment(line)]
    if sum(lines[i].startswith(("# name:", "# type:")) for i in comments) > 1:
        raise InputError(
            f"{file} is in Octave's own text format, which is not read here. Save it with "
            "save('-v7', 'log.mat', ...) in Octave."
        )
    if not rows and not comments:
        raise InputError(f"{file} is empty.")
    separator, decimal = _separator([*rows.values()] or [""], forced)
    split = {i: _fields(line, separator) for i, line in rows.items()}
    tail = [*split.values()][-MOST_TRIED:]
    width = Counter(len(row) for row in tail).most_common(1)[0][0] if tail else 0
    numeric = {
        j for j in range(width)
        if 2 * sum(_is_number(row[j], decimal) for row in tail if j < len(row)) >= len(tail)
    }  # fmt: skip
    start = next(
        (i for i, row in split.items()
         if numeric and 2 * sum(_is_number(row[j], decimal) for j in numeric if j < len(row))
         >= len(numeric)),
        len(lines),
    )  # fmt: skip
    if start == len(lines) and len(lines) == HEAD_LINES:
        start = next(iter(split), 0)  # no row of numbers at all: the columns say why
    heads = [row for i, row in split.items() if i < start]
    if start == len(lines) and heads:
        width = len(heads[-1])
    names, units = _head(heads, width)
    if not names:
        before = [lines[i] for i in comments if i < start]
        names = _commented_head(before, separator, width)
    return Dialect(encoding, separator, decimal, start, names, units, width, bool(comments))


def _separator(lines: list[str], forced: str) -> tuple[str, str]:
    """Return the separator and the decimal sign that make numbers of most entries."""
    tail = lines[1:][-MOST_TRIED:] or lines
    best: tuple[float, int, str, str] | None = None
    for separator in (forced,) if forced else SEPARATORS:
        head = _fields(lines[0], separator)
        rows = [_fields(line, separator) for line in tail]
        for decimal in (".",) if separator == "," else (".", ","):
            share = count = 0.0
            for row in rows:
                numbers = sum(_is_number(entry, decimal) for entry in row)
                share += numbers / max(len(row), 1) / len(rows)
                count += numbers / len(rows)
            are_numbers = len(head) > 1 and all(_is_number(entry, decimal) for entry in head)
            others = (set(",;|\t") - {separator}) & set(lines[0])
            is_torn = not are_numbers and bool(others) and (separator == BLANKS or len(head) == 1)
            fits = len(head) == len(rows[-1]) and share > 0 and not is_torn
            mark = (share + 0.5 * fits - 0.75 * is_torn, int(count), separator, decimal)
            if count and (best is None or mark[:2] > best[:2]):
                best = mark
    if best is not None:
        return best[2], best[3]
    return forced or next((one for one in ",;\t|" if one in lines[0]), BLANKS), "."


def _is_number(entry: str, decimal: str) -> bool:
    return table_number(entry, decimal) is not None


def _head(heads: list[list[str]], width: int) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names and the units of the rows before the numbers."""
    block: list[list[str]] = []
    for row in reversed(heads):
        if len(row) not in (width - 1, width, width + 1):
            break
        block.insert(0, row)
    if not block:
        return (), ()
    if len(block) > 1 and _is_units(block[-1]):
        return tuple(block[-2]), tuple(entry.strip("[]() ") for entry in block[-1])
    return tuple(block[-1]), ()


def _is_units(row: list[str]) -> bool:
    """Whether the entries of a row are units."""
    entries = [entry for entry in row if entry]
    units = sum(
        bool(re.fullmatch(r"\[.*\]|\(.*\)", entry)) or entry.lower() in UNITS for entry in entries
    )
    return 2 * units >= max(len(entries), 1)


def _commented_head(comments: list[str], separator: str, width: int) -> tuple[str, ...]:
    """Return the names in the last comment with a name for each column, as NumPy writes them."""
    for line in reversed(comments):
        text = line.strip().lstrip("#% ")
        for one in dict.fromkeys((separator, ",", ";", "\t", BLANKS)):
            row = _fields(text, one)
            are_names = len(row) == width and all(row) and len(set(row)) == width
            if are_names and not any(_is_number(entry, ".") for entry in row):
                return tuple(row)
    return ()


# The numbers.


def _require_room(file: TextSource, dialect: Dialect) -> None:
    """Raise if separators and line ends count more entries than the limit."""
    separator, count = dialect.separator.encode(), 0
    with opened_bytes(file) as stream:
        while piece := stream.read(2**20):
            count += piece.count(separator) + piece.count(b"\n") + piece.count(b"\r")
            if dialect.separator == BLANKS:
                count += piece.count(b"\t")
    # Several blanks may stand between two numbers, and two bytes end a line.
    ReadingLimit(Path(str(file))).take([count // 2 if dialect.separator == BLANKS else count])


def _columns(file: TextSource, dialect: Dialect, notes: list[str] | None) -> list[TextColumn]:
    """Return the columns, without names."""
    table = _table(file, dialect)
    if table is not None and table.shape[1] == dialect.width:
        rows, first = len(table), dialect.start + 1
        is_whole = sum(1 for _ in _lines(file, dialect.encoding)) == dialect.start + rows
        lines = range(first, first + rows) if is_whole else ()
        return [TextColumn("", numbers=column, lines=lines) for column in table.T]
    return _checked_columns(file, dialect, notes)


def _table(file: TextSource, dialect: Dialect) -> Array | None:
    """Return the rows by NumPy's reader; None if an entry or a row needs a closer look."""
    if dialect.decimal == ",":
        return None
    with _opened(file, dialect.encoding) as stream:
        lines = io.TextIOWrapper(stream.buffer, encoding=dialect.encoding)
        for _ in range(dialect.start):
            lines.readline()
        first = next((line for line in lines if line.strip()), "")
        if not first:
            return None  # NumPy would warn
        delimiter = None if dialect.separator == BLANKS else dialect.separator
        comments = list(COMMENTS) if dialect.has_comments else None

        def rows() -> Iterator[str]:
            yield first
            yield from lines

        try:
            table = np.loadtxt(
                rows(), delimiter=delimiter, comments=comments, ndmin=2, quotechar='"'
            )
        except UnicodeDecodeError:
            raise
        except ValueError:
            return None
    return np.asarray(table, dtype=np.float64)


def _checked_columns(
    file: TextSource, dialect: Dialect, notes: list[str] | None
) -> list[TextColumn]:
    """Return the columns entry by entry, with the line of an entry that is no number."""
    columns = [TextColumn("") for _ in range(dialect.width)]
    pieces: list[list[Array]] = [[] for _ in columns]
    lines: list[int] = []
    every_line = array("q")
    rows: list[list[str]] = []
    for line, row in _rows(file, dialect, [] if notes is None else notes):
        lines.append(line)
        rows.append(row)
        if len(rows) == ROWS_AT_ONCE:
            _convert(file, dialect, columns, pieces, lines, rows)
            every_line.extend(lines)
            lines, rows = [], []
    _convert(file, dialect, columns, pieces, lines, rows)
    every_line.extend(lines)
    for column, parts in zip(columns, pieces, strict=True):
        column.lines = every_line
        if not column.problem:
            column.numbers, column.texts = np.concatenate([np.zeros(0), *parts]), []
    return columns


def _rows(file: TextSource, dialect: Dialect, notes: list[str]) -> Iterator[tuple[int, list[str]]]:
    """The rows of entries, each with its line; an unfinished last line is left out."""
    width = dialect.width
    before = None
    for line, text in enumerate(_lines(file, dialect.encoding), 1):
        if line <= dialect.start or not text.strip():
            continue
        if dialect.has_comments and is_comment(text):
            continue
        row = dialect.fields(text)
        if not any(row):
            continue
        if before is not None:
            yield before
        before = None
        if len(row) > width and not any(row[width:]):
            row = row[:width]  # separators at the end
        if len(row) == width - 1 and dialect.separator != BLANKS and 0 < len(dialect.names) < width:
            row = [*row, ""]
        if len(row) < width and not text.endswith(("\n", "\r")):
            notes.append(f"line {line}, the last one, is unfinished and left out")
            continue
        if len(row) != width:
            raise InputError(
                f"{file}, line {line}: {len(row)} entries where {width} are needed, one for each "
                "column."
            )
        before = line, row
    if before is not None:
        yield before


def _convert(
    file: TextSource, dialect: Dialect, columns: list[TextColumn], pieces: list[list[Array]],
    lines: list[int], rows: list[list[str]],
) -> None:  # fmt: skip
    """Convert some rows, column by column."""
    for column, parts, entries in zip(columns, pieces, zip(*rows, strict=True), strict=False):
        column.texts.extend(entries)
        if column.problem:
            continue
        try:
            if dialect.decimal == "," or any("_" in entry for entry in entries):
                raise ValueError
            parts.append(np.array([float(entry) for entry in entries]))
            continue
        except ValueError:
            pass
        numbers = np.empty(len(entries))
        for i, entry in enumerate(entries):
            value = table_number(entry, dialect.decimal)
            if value is None and (lower := entry.lower()) in MISSING:
                value = np.nan
            elif value is None:
                value = TRUTHS.get(lower)
            if value is None:
                column.problem = f"{file}, line {lines[i]}, column {{}}: {refused_entry(entry)}"
                break
            numbers[i] = value
        parts.append(numbers)


def refused_entry(entry: str) -> str:
    """The words for an entry that is no number."""
    hint = " Write decimals with a point." if as_number(entry, ",") is not None else ""
    return f"{shortened(entry, 60)!r} is not a number.{hint}"


def _labelled(
    file: TextSource, dialect: Dialect, columns: list[TextColumn], names: Sequence[str]
) -> list[TextColumn]:
    """Name the columns; a column without a name and without numbers is left out."""
    rows = max((max(len(c.numbers), len(c.texts)) for c in columns), default=0)
    head = list(dialect.names)
    if not rows:
        shown = f"the names {shortened(', '.join(head or names), 200)} and " if head else ""
        raise InputError(f"{file} has {shown}no row of numbers.")
    if names:
        require_names(file, names, len(columns))
        head = list(names)
    units = list(dialect.units)
    if head and len(head) == len(columns) - 1 and not names:
        last_is_empty = _is_empty(columns[-1])
        head = [*head, ""] if last_is_empty else ["", *head]  # R writes no name for the row names
        units = [*units, ""] if last_is_empty else ["", *units]
    head += [""] * (len(columns) - len(head))
    units += [""] * (len(columns) - len(units))
    for column, name, unit in zip(columns, head, units, strict=False):
        column.name, unit_of_name = split_unit(name) if dialect.names or names else ("", "")
        column.unit = unit or unit_of_name
    nonempty = [c for c in columns if c.name or not _is_empty(c)]
    if (dialect.names or names) and nonempty and not nonempty[0].name:
        nonempty[0].name = "index" if all(c.name != "index" for c in nonempty) else "column 1"
    counts = Counter(c.name for c in nonempty if c.name)
    for i, column in enumerate(nonempty, 1):
        if dialect.names or names:
            if counts[column.name] > 1:
                column.problem = column.problem or (
                    f"{file}: {counts[column.name]} columns are named {column.name}; each needs a "
                    "distinct name."
                )
                column.name = f"{column.name} (column {i})"
            column.name = column.name or f"column {i}"
        label = shortened(column.name, 60) or str(i)
        column.problem = column.problem.replace("column {}:", f"column {label}:")
    return nonempty


def require_names(file: TextSource, names: Sequence[str], width: int) -> None:
    """Raise if the names that were given do not fit the columns."""
    if len(names) != width:
        raise InputError(
            f"{file} has {width} columns, and {len(names)} names are given: "
            f"{shortened(', '.join(names), 200)}."
        )
    if len(set(names)) < len(names) or not all(names):
        raise InputError(
            f"columns = {shortened(', '.join(names), 200)}: each column needs a distinct name."
        )


def _is_empty(column: TextColumn) -> bool:
    return not column.problem and not len(column.texts) and bool(np.isnan(column.numbers).all())


def without_head(file: TextSource | str) -> InputError:
    """The error for columns without names."""
    return InputError(
        f"{file} begins with numbers; its first row must name the columns, for instance u,y,z. ",
        Advice("read_log", (("columns", '"t", "u", "y"'),), "Name them with columns=[...]"), ".",
    )  # fmt: skip
