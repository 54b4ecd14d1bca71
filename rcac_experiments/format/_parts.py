"""Calls of a table that wait for arguments which are known later."""

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
    """A table for an object whose fields differ from the keys of the table."""

    @abstractmethod
    def build(self) -> Any:
        """Build the object."""


def resolved(value: Any, plant: Any) -> Any:
    """Resolve all partial calls in a value for a plant."""
    if isinstance(value, PartialCall):
        return value.of(plant)
    if isinstance(value, list | tuple):
        return type(value)(resolved(entry, plant) for entry in value)
    if isinstance(value, dict):
        return {key: resolved(entry, plant) for key, entry in value.items()}
    return value


@lru_cache(maxsize=256)
def signature_of(make: Callable[..., Any]) -> Mapping[str, inspect.Parameter]:
    """Return the parameters of a function or class; cached, since inspection is slow."""
    return inspect.signature(make).parameters


@attrs.frozen(eq=False)
class PartialCall(Value, Generic[T]):
    """A function or class with the arguments of a table; other arguments follow later."""

    make: Callable[..., T]
    arguments: dict[str, Any]

    def argument(self, name: str) -> Any:
        """Return an argument, or its default."""
        if name in self.arguments:
            return self.arguments[name]
        return signature_of(self.make)[name].default

    def of(self, plant: Any, **others: Any) -> T:
        """Call the function for a plant; `others` are arguments that are not in the file."""
        if "plant" in signature_of(self.make):
            others = {"plant": plant, **others}
        return self.make(**resolved(self.arguments, plant), **others)

    def build(self) -> T:
        """Call the function without a plant, for instance to build a plant."""
        return self.of(None)
