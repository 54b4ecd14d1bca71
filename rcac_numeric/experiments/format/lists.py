"""Forms of lists and tables, made of the forms of what is in them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rcac_numeric.experiments.format.places import Errors, Place, brief
from rcac_numeric.experiments.format.values import Form, Integer, Schema


@dataclass(frozen=True)
class ListOf(Form):
    """A list of values of one form."""

    entry: Form
    at_least: int = 0  # 0 or 1
    needed: str = "a list"
    named: str = ""  # what entries with a name are, such as run; otherwise they have numbers

    @property
    def words(self) -> str:
        """A list, and of what."""
        return f"{self.needed}; each entry is {self.entry.words}"

    def read(self, value: object, place: Place) -> list[Any]:
        """As a list of what the entries are read as."""
        if not isinstance(value, list):
            raise place.refuse(value, self.needed)
        if self.at_least and not value:
            raise place.refuse(value, f"{self.needed}, not an empty one")
        many, errors, read = len(value) > 1, Errors(), []
        for i, entry in enumerate(value, 1):
            with errors:
                read.append(
                    self.entry.read(entry, place.entry(self._note(entry, i if many else 0)))
                )
        errors.raise_any()
        return read

    def _note(self, entry: object, number: int) -> str:
        """What tells an entry from the others: its name, or its number, where it is a table."""
        if not isinstance(entry, Mapping):
            return ""
        name = entry.get("name") if self.named else None
        if isinstance(name, str):
            return f"{self.named} {brief(name)}"
        return f"no. {number}" if number else ""

    def schema(self) -> Schema:
        """An array."""
        return {"type": "array", "items": self.entry.schema(), "minItems": self.at_least}


@dataclass(frozen=True)
class Row(Form):
    """A short list whose entries differ in meaning, such as [step, value]."""

    entries: tuple[Form, ...]
    shown: str
    at_least: int | None = None  # how many must be there; all of them by default

    @property
    def words(self) -> str:
        """As it is written."""
        return self.shown

    def read(self, value: object, place: Place) -> tuple[Any, ...]:
        """As a tuple."""
        least = len(self.entries) if self.at_least is None else self.at_least
        if not isinstance(value, list) or not least <= len(value) <= len(self.entries):
            raise place.error(f"{place} has the entry {brief(value)}; {self.shown} is needed.")
        inside = place.entry()
        errors, read = Errors(), []
        for form, entry in zip(self.entries, value, strict=False):
            with errors:
                read.append(form.read(entry, inside))
        errors.raise_any()
        return tuple(read)

    def schema(self) -> Schema:
        """An array with a form for each place."""
        least = len(self.entries) if self.at_least is None else self.at_least
        return {
            "type": "array",
            "prefixItems": [form.schema() for form in self.entries],
            "minItems": least,
            "maxItems": len(self.entries),
        }


@dataclass(frozen=True)
class MapOf(Form):
    """A table from names of the writer's own to values of one form."""

    entry: Form

    @property
    def words(self) -> str:
        """A table, and of what."""
        return f"a table of names; each value is {self.entry.words}"

    def read(self, value: object, place: Place) -> dict[str, Any]:
        """As a dict."""
        if not isinstance(value, Mapping):
            raise place.refuse(value, "a table")
        inside, errors, read = place.inside(), Errors(), {}
        for key, entry in value.items():
            with errors:
                read[key] = self.entry.read(entry, inside.at(key))
        errors.raise_any()
        return read

    def schema(self) -> Schema:
        """An object."""
        return {"type": "object", "additionalProperties": self.entry.schema()}


@dataclass(frozen=True)
class Either(Form):
    """A table of one form, or else a value of another."""

    table: Form
    other: Form

    @property
    def words(self) -> str:
        """Both."""
        return f"{self.other.words}; or {self.table.words}"

    def read(self, value: object, place: Place) -> Any:
        """By whether it is a table."""
        return (self.table if isinstance(value, Mapping) else self.other).read(value, place)

    def schema(self) -> Schema:
        """Either."""
        return {"anyOf": [self.other.schema(), self.table.schema()]}


@dataclass(frozen=True)
class OneOrMore(Form):
    """A value, or a list of such values."""

    entry: Form

    @property
    def words(self) -> str:
        """Both."""
        return f"{self.entry.words}, or a list of such"

    def read(self, value: object, place: Place) -> Any:
        """As the entry reads it, or a list."""
        form = ListOf(self.entry, 1) if isinstance(value, list) else self.entry
        return form.read(value, place)

    def schema(self) -> Schema:
        """Either."""
        return {"anyOf": [self.entry.schema(), ListOf(self.entry, 1).schema()]}


@dataclass(frozen=True)
class ByStep(Form):
    """[[step, value], ...]: what holds from each step on."""

    entry: Form

    @property
    def words(self) -> str:
        """As it is written."""
        return "a list of pairs [step, value]"

    def read(self, value: object, place: Place) -> dict[int, Any]:
        """As a mapping from steps."""
        rows = ListOf(Row((Integer(), self.entry), "a pair [step, value]"))
        changes: dict[int, Any] = {}
        for step, entry in rows.read(value, place):
            if step in changes:
                raise place.error(f"{place} names the step {step} twice.")
            changes[step] = entry
        return changes

    def schema(self) -> Schema:
        """An array of pairs."""
        return ListOf(Row((Integer(), self.entry), "")).schema()
