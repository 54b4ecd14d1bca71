"""What a table asks to be made, before everything that it needs is known."""

from __future__ import annotations

import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any, Generic, TypeVar

import attrs

from rcac_numeric.arrays._values import Value

T = TypeVar("T")


class Alias(ABC):
    """A table that stands for an object with other fields than the table has keys."""

    @abstractmethod
    def build(self) -> Any:
        """The object."""


def resolved(value: Any, plant: Any) -> Any:
    """A value with every specification in it resolved for a plant."""
    if isinstance(value, PartialCall):
        return value.of(plant)
    if isinstance(value, list | tuple):
        return type(value)(resolved(entry, plant) for entry in value)
    if isinstance(value, dict):
        return {key: resolved(entry, plant) for key, entry in value.items()}
    return value


@lru_cache(maxsize=256)
def signature_of(make: Callable[..., Any]) -> Mapping[str, inspect.Parameter]:
    """The parameters of a function or class, which takes long to find and never changes."""
    return inspect.signature(make).parameters


@attrs.frozen(eq=False)
class PartialCall(Value, Generic[T]):
    """A function or class, and the arguments that a table has for it, read and typed."""

    make: Callable[..., T]
    arguments: dict[str, Any]

    def argument(self, name: str) -> Any:
        """An argument, or what it is where the table does not say it."""
        if name in self.arguments:
            return self.arguments[name]
        return signature_of(self.make)[name].default

    def of(self, plant: Any, **others: Any) -> T:
        """Make it, for this plant; `others` are arguments that do not stand in the file."""
        if "plant" in signature_of(self.make):
            others = {"plant": plant, **others}
        return self.make(**resolved(self.arguments, plant), **others)

    def build(self) -> T:
        """Make what hangs on no plant, such as a plant itself."""
        return self.of(None)
