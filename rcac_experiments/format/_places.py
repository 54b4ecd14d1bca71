"""Where in a file something stands, and how that is said in errors."""

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
    """Short, and as TOML writes what Python writes otherwise."""

    def repr_Decimal(self, value: Decimal, level: int) -> str:
        """The digits alone."""
        return str(value)

    def repr_bool(self, value: bool, level: int) -> str:
        """In small letters."""
        return str(value).lower()


_SHORT_REPR = _ShortRepr()
_SHORT_REPR.maxlevel, _SHORT_REPR.maxdict, _SHORT_REPR.maxlist, _SHORT_REPR.maxtuple = 4, 6, 8, 8
_SHORT_REPR.maxstring = _SHORT_REPR.maxother = _SHORT_REPR.maxlong = 100


def quoted(value: object) -> str:
    """A value for an error message, never longer than a few lines.

    Examples
    --------
    >>> from rcac_experiments.format._places import quoted
    >>> quoted("abc"), quoted(list(range(100)))
    ("'abc'", '[0, 1, 2, 3, 4, 5, 6, 7, ...]')
    """
    return _SHORT_REPR.repr(value)


def shortened(text: str) -> str:
    """A message cut to a length that a reader can bear."""
    if len(text) <= LONGEST_MESSAGE:
        return text
    return f"{text[: LONGEST_MESSAGE - 60]} ... ({len(text)} characters in all)"


class MissingKeyError(InputError):
    """A table needs a key that it has not."""

    key: str = ""


class FileError(InputError):
    """Everything that is wrong with a file, each error with its place."""

    def __init__(self, text: str, errors: Sequence[CompensatorError] = ()) -> None:
        super().__init__(text)
        self.errors = tuple(errors)

    def named(self, file: str) -> InputError:
        """What is wrong, one after another, as far as a reader can bear."""
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
    """Collects errors, so that all of them can be said at once.

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
        """One more, or those that it consists of; what was said already is not said again."""
        known = {one.args for one in self.errors}
        parts = error.errors if isinstance(error, FileError) else (error,)
        self.errors += [one for one in parts if one.args not in known]

    def raise_any(self) -> None:
        """Raise what was collected, if anything was."""
        if len(self.errors) == 1:
            raise self.errors[0] from None
        if self.errors:
            raise FileError("\n".join(map(str, self.errors)), self.errors) from None


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """A hint at the known word that comes closest, or nothing."""
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
        What else tells the table from others of its name: its number in an array, its run.
    depth : int
        How many tables and lists lie around it.
    """

    file: str
    table: str = ""
    key: str = ""
    notes: tuple[str, ...] = ()
    depth: int = 0

    @property
    def where(self) -> str:
        """The table's name as the file writes it."""
        text = f"[{self.table}]" if self.table else "the top level"
        for i, note in enumerate(self.notes):
            text += f" {note}" if not i and note.startswith("no.") else f" of {note}"
        return text

    def __str__(self) -> str:
        return f"{self.where} {self.key}" if self.key and self.table else self.key or self.where

    def at(self, key: str) -> Location:
        """One key of this table."""
        return replace(self, key=key)

    def inside(self) -> Location:
        """The table that stands under this key."""
        name = f"{self.table}.{self.key}" if self.table and self.key else self.table or self.key
        return replace(self._deeper(), table=name, key="")

    def entry(self, note: str = "") -> Location:
        """An entry of the list under this key; `note` tells it from the others."""
        return replace(self._deeper(), notes=(note, *self.notes) if note else self.notes)

    def error(self, *parts: str | Advice) -> InputError:
        """An error that names the file."""
        return InputError(f"{self.file}: ", *parts).of(self.file)

    def missing(self, key: str) -> MissingKeyError:
        """That the table needs a key."""
        error = MissingKeyError(f"{self.file}: ", f"{self.where} needs the key {key!r}.")
        error.key = key
        return error.of(self.file)

    def refuse(self, value: object, needed: str) -> InputError:
        """That a value is not what is needed."""
        return self.error(f"{self} = {quoted(value)} must be {needed}.")

    def _deeper(self) -> Location:
        if self.depth >= DEEPEST:
            raise self.error(f"{self.where} is nested more than {DEEPEST} deep.")
        return replace(self, depth=self.depth + 1)
