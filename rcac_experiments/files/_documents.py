"""Read TOML files as tables; the heading of all experiment files."""

from __future__ import annotations

import re
import tomllib
import unicodedata
from collections.abc import Mapping
from decimal import Decimal
from pathlib import Path
from typing import Annotated, Any, TypedDict

import attrs

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.format._places import DEEPEST, FileError, quoted, shortened
from rcac_numeric.arrays._files import require_readable

Raw = dict[str, Any]

LARGEST_FILE = 10 * 2**20  # bytes
MOST_KEYS = 100_000
# Strings as TOML has them, to their end or that of the text, and comments. Nothing is tried twice,
# whatever the text is.
_STRINGS = re.compile(
    r'"""[^"\\]*+(?:(?:\\.|"(?!""))[^"\\]*+)*+(?:"{3,5}|\\?\Z)'
    r"|'''[^']*+(?:'(?!'')[^']*+)*+(?:'{3,5}|\Z)"
    r'|"[^"\\\n]*+(?:\\[^\n][^"\\\n]*+)*+"?'
    r"|'[^'\n]*+'?|\#[^\n]*+",
    re.DOTALL,
)
_PIECES = re.compile(r"([^\n=,\[\]{}]*+)([\n=,\[\]{}]|\Z)")
# What changes the direction of the text around it could show a reader another file than is run.
REORDERING = "\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"


def read_file(path: str | Path) -> tuple[Raw, str]:
    """Return the tables of a user's file and its name."""
    try:
        require_readable(Path(path))
        with Path(path).open("rb") as file:
            text = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}.") from None
    if len(text) > LARGEST_FILE:
        raise InputError(
            f"{path} is larger than {LARGEST_FILE // 2**20} MiB. Long records belong in a .csv or "
            '.npy file of their own: recorded = "flight.csv".'
        )
    try:
        decoded = text.decode("utf-8-sig")  # editors of Windows put a byte order mark in front
        require_short_keys(decoded, str(path))
        table = parsed(decoded)
    except InputError:
        raise
    except RecursionError:
        raise InputError(f"{path} is nested more than {DEEPEST} deep.") from None
    except ValueError as error:  # also an integer of thousands of digits
        raise InputError(f"{path} is not valid TOML: {error}.") from None
    require_plain(table, str(path))
    return table, str(path)


def parsed(text: str) -> Raw:
    r"""Return the tables of a TOML text; numbers keep all their digits."""
    return tomllib.loads(text, parse_float=_number)


def _number(digits: str) -> float | Decimal:
    exact, rounded = Decimal(digits), float(digits)
    return exact if exact.is_finite() and exact != Decimal(repr(rounded)) else rounded


def require_short_keys(text: str, file: str) -> None:
    """Refuse keys with more dots than tables may be deep, and more keys than a person writes.

    tomllib pays for a dotted key by the square of its length, and for any key a kilobyte. Asked in
    one pass over the text, in which strings and comments are blanks.
    """
    keys = text.count("=") + text.count("[") + text.count("{")
    if text.count(".") + keys <= MOST_KEYS and text.count(".") <= DEEPEST:
        return
    keys = 0
    for piece in _PIECES.finditer(without_strings(text)):
        dots = piece[1].count(".")
        if dots > DEEPEST:
            raise InputError(f"{file} is nested more than {DEEPEST} deep: a key has {dots} dots.")
        # A number has one dot, and is no key.
        keys += (piece[2] in ("=", "[", "{")) + (dots if dots > 1 or piece[2] == "=" else 0)
        if keys > MOST_KEYS:
            raise InputError(
                f"{file} has more than {MOST_KEYS} keys and lists. Long records belong in a .csv "
                'or .npy file of their own: recorded = "flight.csv".'
            )


def without_strings(text: str) -> str:
    """Replace each string and comment of a TOML text by a blank."""
    return _STRINGS.sub(" ", text)


def require_plain(table: Raw, file: str) -> None:
    """Refuse tables with deep nesting or with control characters."""
    level: list[Any] = [table]
    for _ in range(DEEPEST + 2):
        inner: list[Any] = []
        for value in level:
            if isinstance(value, str):
                _require_printable(value, file)
            elif isinstance(value, Mapping):
                inner += [*value, *value.values()]
            elif isinstance(value, list):
                inner += value
        level = inner
    if level:
        raise InputError(f"{file} is nested more than {DEEPEST} deep.")


def named(error: CompensatorError, file: str) -> CompensatorError:
    """Return the error with the name of the file, at limited length."""
    if isinstance(error, FileError):
        return error.named(file)
    whole = error if error.source == file else type(error)(f"{file}: ", *error.args)
    text = str(whole)
    short = shortened(text)
    return (whole if short == text else type(error)(short)).of(file)


def _require_printable(text: str, file: str) -> None:
    for character in text:
        is_control = unicodedata.category(character) == "Cc" and character not in "\n\t\r"
        if is_control or character in REORDERING:
            raise InputError(
                f"{file}: the text {quoted(text)} contains the control character "
                f"{character!a}, which a terminal would execute. Remove it."
            )


NUMBER_AND_SOURCE = (
    "Its number, the name of the file where it is left out; and where it comes from."
)


class HeadingWords(TypedDict):
    """The heading of an experiment."""

    id: str
    title: str
    source: str
    notes: str


@attrs.frozen(eq=False, kw_only=True)
class Heading:
    """The subject of an experiment."""

    title: Annotated[str, "What it is about, in a line."] = ""
    id: Annotated[str, NUMBER_AND_SOURCE] = ""
    source: Annotated[str, NUMBER_AND_SOURCE] = ""
    notes: Annotated[str, "What a reader of the report should know."] = ""

    def words(self, file: str) -> HeadingWords:
        """The part of it that the experiment uses."""
        return {
            "id": self.id or Path(file).stem,
            "title": self.title,
            "source": self.source,
            "notes": self.notes.strip(),
        }
