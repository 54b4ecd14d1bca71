"""Where in a file something stands, and how that is said in errors."""

from __future__ import annotations

import difflib
import reprlib
from collections.abc import Iterable
from dataclasses import dataclass, replace

from compensator_theory.errors import InputError

DEEPEST = 30
LONGEST_MESSAGE = 1500
_BRIEF = reprlib.Repr()
_BRIEF.maxlevel, _BRIEF.maxdict, _BRIEF.maxlist, _BRIEF.maxtuple = 4, 6, 8, 8
_BRIEF.maxstring = _BRIEF.maxother = _BRIEF.maxlong = 100


def brief(value: object) -> str:
    """A value for an error message, never longer than a few lines.

    Examples
    --------
    >>> from rcac_numeric.experiments.format.places import brief
    >>> brief("abc"), brief(list(range(100)))
    ("'abc'", '[0, 1, 2, 3, 4, 5, 6, 7, ...]')
    """
    return _BRIEF.repr(value)


def shortened(text: str) -> str:
    """A message cut to a length that a reader can bear."""
    if len(text) <= LONGEST_MESSAGE:
        return text
    return f"{text[: LONGEST_MESSAGE - 60]} ... ({len(text)} characters in all)"


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """A hint at the known word that comes closest, or nothing."""
    close = difflib.get_close_matches(str(word)[:80], list(known), n=1)
    return f" Did you mean {close[0]!r}?" if close else ""


@dataclass(frozen=True)
class Place:
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

    def at(self, key: str) -> Place:
        """One key of this table."""
        return replace(self, key=key)

    def inside(self) -> Place:
        """The table that stands under this key."""
        name = f"{self.table}.{self.key}" if self.table and self.key else self.table or self.key
        return replace(self._deeper(), table=name, key="")

    def entry(self, number: int = 0) -> Place:
        """An entry of the list under this key; `number` counts tables from 1."""
        numbered = (f"no. {number}", *self.notes) if number else self.notes
        return replace(self._deeper(), notes=numbered)

    def error(self, message: str) -> InputError:
        """An error that names the file."""
        return InputError(f"{self.file}: {message}")

    def refuse(self, value: object, needed: str) -> InputError:
        """That a value is not what is needed."""
        return self.error(f"{self} = {brief(value)} must be {needed}.")

    def _deeper(self) -> Place:
        if self.depth >= DEEPEST:
            raise self.error(f"{self.where} is nested more than {DEEPEST} deep.")
        return replace(self, depth=self.depth + 1)
