"""The forms of values and lists in a file: reading, description and schema."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

import compensator_theory as exact
from compensator_theory.errors import CompensatorError
from rcac_experiments.format._places import Errors, Location, did_you_mean, quoted
from rcac_numeric.arrays._validation import number, real_array

Schema = dict[str, Any]
LARGEST = 2**62
DEEPEST_ARRAY = 3


def is_number(value: object) -> bool:
    """Return whether a value is a real number; true and false are none."""
    return isinstance(value, int | float | Decimal) and not isinstance(value, bool)


def as_float(value: Any) -> Any:
    """Round decimals, also in lists, to float64; return other values unchanged."""
    if isinstance(value, Decimal):
        return float(value)
    return [as_float(entry) for entry in value] if isinstance(value, list) else value


class Form(ABC):
    """The form of a value."""

    @property
    @abstractmethod
    def words(self) -> str:
        """The required form, such as an integer; it ends the sentence of an error."""

    @abstractmethod
    def read(self, value: object, place: Location) -> Any:
        """The value as Python's, or an error that names the place."""

    @abstractmethod
    def schema(self) -> Schema:
        """The JSON Schema; it accepts whatever `read` does."""


@dataclass(frozen=True)
class Integer(Form):
    """A whole number in a range."""

    at_least: int = 0
    at_most: int = LARGEST

    @property
    def words(self) -> str:
        """The words with the least value."""
        return f"an integer of at least {self.at_least}"

    def read(self, value: object, place: Location) -> int:
        """Read the value as an int."""
        if isinstance(value, bool) or not isinstance(value, int):
            raise place.error(f"{place} must be an integer, not {quoted(value)}.")
        if value < self.at_least:
            raise place.refuse(value, f"at least {self.at_least}")
        if value > self.at_most:
            raise place.refuse(value, f"at most {self.at_most}")
        return value

    def schema(self) -> Schema:
        """An integer in the range."""
        return {"type": "integer", "minimum": self.at_least, "maximum": self.at_most}


@dataclass(frozen=True)
class Real(Form):
    """A real number, or a string such as "pi/8", which is evaluated exactly and rounded once."""

    check: Callable[[float, str], float] | None = None  # given the place as the number's name

    words = 'a number, or a string such as "pi/8"'

    def read(self, value: object, place: Location) -> float:
        """Read the value as a finite float."""
        if isinstance(value, str):
            try:
                expression = exact.parse_expression(value)
            except CompensatorError as error:
                raise place.error(f"{place} = {quoted(value)}: ", *error.args) from None
            if not (expression.is_number and expression.is_real):
                raise place.error(f"{place} = {quoted(value)} must be a real number.")
            value = float(expression)
        if not is_number(value):
            raise place.error(f"{place} must be a real number, not {quoted(value)}.")
        read = number(as_float(value), str(place))
        return read if self.check is None else self.check(read, str(place))

    def schema(self) -> Schema:
        """A number or a string."""
        return {"type": ["number", "string"]}


@dataclass(frozen=True)
class String(Form):
    """A string."""

    words = "a string"

    def read(self, value: object, place: Location) -> str:
        """Read the value as a str."""
        if not isinstance(value, str):
            raise place.refuse(value, self.words)
        return value

    def schema(self) -> Schema:
        """A string."""
        return {"type": "string"}


@dataclass(frozen=True)
class Choice(Form):
    """One of a few words."""

    choices: tuple[str, ...]

    @property
    def words(self) -> str:
        """The words."""
        return f"one of {', '.join(self.choices)}"

    def read(self, value: object, place: Location) -> str:
        """Read the value as a str among the choices."""
        if not isinstance(value, str):
            raise place.refuse(value, "a string")
        if value not in self.choices:
            hint = did_you_mean(value, self.choices)
            raise place.error(f"{place} = {quoted(value)} must be {self.words}.{hint}")
        return value

    def schema(self) -> Schema:
        """An enumeration."""
        return {"enum": list(self.choices)}


@dataclass(frozen=True)
class Flag(Form):
    """True or false."""

    words = "true or false"

    def read(self, value: object, place: Location) -> bool:
        """Read the value as a bool."""
        if not isinstance(value, bool):
            raise place.refuse(value, self.words)
        return value

    def schema(self) -> Schema:
        """A truth value."""
        return {"type": "boolean"}


@dataclass(frozen=True)
class Numbers(Form):
    """A number, or lists of numbers nested up to three deep: a vector, a matrix, several."""

    longest: int | None = None  # of the outermost list
    check: Callable[[Any, str], Any] | None = None  # given the place as the array's name

    words = "a number or an array of real numbers"

    def read(self, value: object, place: Location) -> Any:
        """A number as a float, anything else as an array of float64."""
        if isinstance(value, list):
            _require_depth(value, place, self.words)
            if self.longest is not None and len(value) > self.longest:
                raise place.error(f"{place} has {len(value)} entries; at most {self.longest} are "
                                  "allowed.")  # fmt: skip
            for leaf in _leaves(value):
                if not is_number(leaf):
                    raise place.error(f"{place} = {quoted(value)} must be {self.words}; the entry "
                                      f"{quoted(leaf)} is not.")  # fmt: skip
            if _shape(value) is None:
                raise place.error(f"{place} = {quoted(value)} must be {self.words}; its rows "
                                  "differ "
                                  "in length.")  # fmt: skip
            read: Any = real_array(as_float(value), str(place))
        elif is_number(value):
            read = number(as_float(value), str(place))
        else:
            raise place.refuse(value, self.words)
        return read if self.check is None else self.check(read, str(place))

    def schema(self) -> Schema:
        """A number or lists of them."""
        return _nested({"type": "number"})


class Sign(Form):
    """+1 or -1."""

    words = "1 or -1"

    def read(self, value: object, place: Location) -> int:
        """Read the value as an int."""
        if isinstance(value, bool) or value not in (1, -1) or not isinstance(value, int):
            raise place.refuse(value, self.words)
        return value

    def schema(self) -> Schema:
        """One of the two."""
        return {"enum": [1, -1]}


@dataclass(frozen=True)
class Exact(Form):
    """What the exact half reads: numbers, strings such as "1/3" or "q - 0.85", lists of those.

    A number means its shortest decimal, 0.1 being 1/10.
    """

    words = 'a number, a string such as "1/3", or lists of those'

    def read(self, value: object, place: Location) -> Any:
        """As it stands, its text included: the exact half parses it where it is used."""
        if isinstance(value, list):
            _require_depth(value, place, self.words)
            flat = _leaves(value)
        else:
            flat = [value]
        for leaf in flat:
            if not (is_number(leaf) or isinstance(leaf, str)):
                raise place.refuse(value, self.words)
        return value

    def schema(self) -> Schema:
        """A number, a string or lists of them."""
        return _nested({"type": ["number", "string"]})


def _require_depth(value: list[Any], place: Location, needed: str) -> None:
    if _depth(value) > DEEPEST_ARRAY:
        raise place.refuse(value, f"{needed}, nested at most {DEEPEST_ARRAY} deep")


def _depth(value: object) -> int:
    return 1 + max(map(_depth, value), default=0) if isinstance(value, list) else 0


def _shape(value: Any) -> tuple[int, ...] | None:
    """The shape of nested lists; None where rows differ in length."""
    if not isinstance(value, list):
        return ()
    shapes = {_shape(entry) for entry in value}
    if len(shapes) > 1 or None in shapes:
        return None
    return (len(value), *(shapes.pop() or () if shapes else ()))


def _leaves(value: list[Any]) -> list[Any]:
    leaves: list[Any] = []
    for entry in value:
        leaves += _leaves(entry) if isinstance(entry, list) else [entry]
    return leaves


def _nested(leaf: Schema) -> Schema:
    schema = leaf
    for _ in range(DEEPEST_ARRAY):
        schema = {"anyOf": [leaf, {"type": "array", "items": schema}]}
    return schema


@dataclass(frozen=True)
class ListOf(Form):
    """A list of values of one form."""

    entry: Form
    at_least: int = 0  # 0 or 1
    needed: str = "a list"
    named: str = ""  # what entries with a name are, such as run; otherwise they have numbers

    @property
    def words(self) -> str:
        """A list, with the form of its entries."""
        return f"{self.needed}; each entry is {self.entry.words}"

    def read(self, value: object, place: Location) -> list[Any]:
        """Read a list; each entry is read by the form of the entries."""
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
            return f"{self.named} {quoted(name)}"
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

    def read(self, value: object, place: Location) -> tuple[Any, ...]:
        """Read the value as a tuple."""
        least = len(self.entries) if self.at_least is None else self.at_least
        if not isinstance(value, list) or not least <= len(value) <= len(self.entries):
            raise place.error(f"{place}: the entry {quoted(value)} must be {self.shown}.")
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
        """A table, with the form of its entries."""
        return f"a table of names; each value is {self.entry.words}"

    def read(self, value: object, place: Location) -> dict[str, Any]:
        """Read the value as a dict."""
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

    def read(self, value: object, place: Location) -> Any:
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

    def read(self, value: object, place: Location) -> Any:
        """Read one entry, or a list of entries."""
        form = ListOf(self.entry, 1) if isinstance(value, list) else self.entry
        return form.read(value, place)

    def schema(self) -> Schema:
        """Either."""
        return {"anyOf": [self.entry.schema(), ListOf(self.entry, 1).schema()]}


@dataclass(frozen=True)
class ByStep(Form):
    """[[step, value], ...]: values from each step on."""

    entry: Form

    @property
    def words(self) -> str:
        """As it is written."""
        return "a list of pairs [step, value]"

    def read(self, value: object, place: Location) -> dict[int, Any]:
        """Read the value as a mapping from steps."""
        rows = ListOf(Row((Integer(), self.entry), "a pair [step, value]"))
        changes: dict[int, Any] = {}
        for step, entry in rows.read(value, place):
            if step in changes:
                raise place.error(f"{place} has step {step} twice.")
            changes[step] = entry
        return changes

    def schema(self) -> Schema:
        """An array of pairs."""
        return ListOf(Row((Integer(), self.entry), "")).schema()
