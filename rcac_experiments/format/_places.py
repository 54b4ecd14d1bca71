"""Locations in a file, and their text in errors."""

from __future__ import annotations

import difflib
import reprlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from types import TracebackType

from compensator_theory.errors import Advice, CompensatorError, InputError

DEEPEST = 30
LONGEST_MESSAGE = 1500
LONGEST_OF_SEVERAL = 700


class _ShortRepr(reprlib.Repr):
    """A short repr, with booleans and decimals as in TOML."""

    def repr_Decimal(self, value: Decimal, level: int) -> str:
        """Return the digits."""
        return str(value)

    def repr_bool(self, value: bool, level: int) -> str:
        """Return true or false."""
        return str(value).lower()


_SHORT_REPR = _ShortRepr()
_SHORT_REPR.maxlevel, _SHORT_REPR.maxdict, _SHORT_REPR.maxlist, _SHORT_REPR.maxtuple = 4, 6, 8, 8
_SHORT_REPR.maxstring = _SHORT_REPR.maxother = _SHORT_REPR.maxlong = 100


def quoted(value: object) -> str:
    """Return the repr of a value for an error message, at most a few lines.

    Examples
    --------
    >>> from rcac_experiments.format._places import quoted
    >>> quoted("abc"), quoted(list(range(100)))
    ("'abc'", '[0, 1, 2, 3, 4, 5, 6, 7, ...]')
    """
    return _SHORT_REPR.repr(value)


def shortened(text: str) -> str:
    """Cut a message at a limited length."""
    if len(text) <= LONGEST_MESSAGE:
        return text
    return f"{text[: LONGEST_MESSAGE - 60]} ... ({len(text)} characters)"


class MissingKeyError(InputError):
    """A required key of a table is missing."""

    key: str = ""


class FileError(InputError):
    """All errors of a file, each with its location."""

    def __init__(self, text: str, errors: Sequence[CompensatorError] = ()) -> None:
        super().__init__(text)
        self.errors = tuple(errors)

    def named(self, file: str) -> InputError:
        """Return the list of errors, at limited length."""
        parts: list[str | Advice] = [f"{file}: ", f"{len(self.errors)} errors."]
        length = sum(map(len, map(str, parts)))
        for number, error in enumerate(self.errors, 1):
            line = (f"\n{number}. ", *_of_several(error, file))
            length += sum(map(len, map(str, line)))
            if length > LONGEST_MESSAGE - 60:
                parts.append(f"\n... and {len(self.errors) - number + 1} more.")
                break
            parts += line
        return InputError(*parts).of(file)


def _of_several(error: CompensatorError, file: str) -> tuple[str | Advice, ...]:
    parts = error.args[1:] if error.source == file else error.args
    text = str(InputError(*parts))
    return parts if len(text) <= LONGEST_OF_SEVERAL else (f"{text[: LONGEST_OF_SEVERAL - 4]} ...",)


class Errors:
    """Collect errors, to report all of them together.

    Examples
    --------
    >>> from compensator_theory import InputError
    >>> from rcac_experiments.format._places import Errors
    >>> errors = Errors()
    >>> for word in ("first", "second"):
    ...     with errors:
    ...         raise InputError(word)
    >>> [str(error) for error in errors.errors]
    ['first', 'second']
    """

    def __init__(self) -> None:
        self.errors: list[CompensatorError] = []

    def __enter__(self) -> Errors:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None,
        traceback: TracebackType | None,
    ) -> bool:  # fmt: skip
        if not isinstance(error, CompensatorError):
            return False
        self.add(error)
        return True

    def add(self, error: CompensatorError) -> None:
        """Add an error, or its parts; repeated errors are dropped."""
        known = {one.args for one in self.errors}
        parts = error.errors if isinstance(error, FileError) else (error,)
        self.errors += [one for one in parts if one.args not in known]

    def raise_any(self) -> None:
        """Raise the collected errors, if any."""
        if len(self.errors) == 1:
            raise self.errors[0] from None
        if self.errors:
            raise FileError("\n".join(map(str, self.errors)), self.errors) from None


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """Return a hint at the closest known word, or an empty text."""
    close = difflib.get_close_matches(str(word)[:80], list(known), n=1)
    return f" Did you mean {close[0]!r}?" if close else ""


@dataclass(frozen=True)
class Location:
    """A table of a file, or one of its keys.

    Attributes
    ----------
    file : str
    table : str
        Its name with dots, such as controller.reset; empty for the top level.
    key : str
        A key of that table; empty for the table itself.
    notes : tuple of str
        Further identification of the table: its number in an array, its run.
    depth : int
        Number of enclosing tables and lists.
    """

    file: str
    table: str = ""
    key: str = ""
    notes: tuple[str, ...] = ()
    depth: int = 0

    @property
    def where(self) -> str:
        """The name of the table as in the file."""
        text = f"[{self.table}]" if self.table else "the top level"
        for i, note in enumerate(self.notes):
            text += f" {note}" if not i and note.startswith("no.") else f" of {note}"
        return text

    def __str__(self) -> str:
        return f"{self.where} {self.key}" if self.key and self.table else self.key or self.where

    def at(self, key: str) -> Location:
        """Return the location of a key of this table."""
        return replace(self, key=key)

    def inside(self) -> Location:
        """Return the location of the table under this key."""
        name = f"{self.table}.{self.key}" if self.table and self.key else self.table or self.key
        return replace(self._deeper(), table=name, key="")

    def entry(self, note: str = "") -> Location:
        """Return the location of an entry of the list under this key, identified by `note`."""
        return replace(self._deeper(), notes=(note, *self.notes) if note else self.notes)

    def error(self, *parts: str | Advice) -> InputError:
        """Return an error that names the file."""
        return InputError(f"{self.file}: ", *parts).of(self.file)

    def missing(self, key: str) -> MissingKeyError:
        """Return the error for a missing key."""
        error = MissingKeyError(f"{self.file}: ", f"{self.where} needs the key {key!r}.")
        error.key = key
        return error.of(self.file)

    def refuse(self, value: object, needed: str) -> InputError:
        """Return the error for an invalid value."""
        return self.error(f"{self} = {quoted(value)} must be {needed}.")

    def _deeper(self) -> Location:
        if self.depth >= DEEPEST:
            raise self.error(f"{self.where} is nested more than {DEEPEST} levels deep.")
        return replace(self, depth=self.depth + 1)
