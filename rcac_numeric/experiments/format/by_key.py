"""Things whose kind is named by a key of their table, such as { step = 1, start = 10 }."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Generic, TypeVar

from rcac_numeric.experiments.format.parts import Part
from rcac_numeric.experiments.format.places import Place, brief, did_you_mean
from rcac_numeric.experiments.format.tables import Table
from rcac_numeric.experiments.format.values import Form, Schema

T = TypeVar("T")


class ByKey(Form, Generic[T]):
    """A table in which one key names the kind, its value being the first argument.

    Parameters
    ----------
    what : str
        What it is, with its article.
    number : callable
        What a number alone stands for.

    Examples
    --------
    >>> from rcac_numeric import Pulse, Step
    >>> from rcac_numeric.experiments.format.by_key import ByKey
    >>> from rcac_numeric.experiments.format.places import Place
    >>> signal = ByKey("a signal", number=Step)
    >>> signal.register("pulse", Pulse)
    >>> signal.read({"pulse": 2, "length": 5}, Place("case.toml", "signals", "r")).build()
    Pulse(height=2.0, start=0, length=5)
    """

    def __init__(self, what: str, *, number: Callable[[float], T]) -> None:
        self.what, self.number = what, number
        self.kinds: dict[str, Table[T]] = {}

    def register(self, name: str, make: Callable[..., T], **options: Any) -> None:
        """Let a key name this kind; its value is the first argument of `make`."""
        first = next(iter(Table(make, **options).keys)).parameter
        self.kinds[name] = Table(make, **{**options, "names": {first: name}})

    @property
    def words(self) -> str:
        """A number, or the keys that name a kind."""
        return f"{self.what}; use a number, or a table with one of {', '.join(self.kinds)}"

    def read(self, value: object, place: Place) -> Part[T]:
        """What is to be made."""
        if isinstance(value, int | float) and not isinstance(value, bool):
            number = Table(self.number).keys[0]
            return Part(self.number, {number.parameter: number.form.read(value, place)})
        if not isinstance(value, Mapping):
            raise place.error(f"{place} = {brief(value)} is not {self.words}.")
        for name, table in self.kinds.items():
            if name in value:
                return table.read(value, place)
        hint = next((h for key in value if (h := did_you_mean(key, self.kinds))), "")
        raise place.error(f"{place} = {brief(dict(value))} is not {self.words}.{hint}")

    def schema(self) -> Schema:
        """A reference: a kind may hold others."""
        return {"$ref": f"#/$defs/{self.what.split()[-1]}"}

    def definition(self) -> Schema:
        """What the reference stands for."""
        tables = [
            {**table.schema(), "required": [key.name for key in table.keys if key.is_required]}
            for table in self.kinds.values()
        ]
        return {"anyOf": [{"type": "number"}, *tables]}
