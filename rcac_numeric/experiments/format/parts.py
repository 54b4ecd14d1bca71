"""What a table asks to be made, before it is made."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from rcac_numeric.arrays.values import Value

T = TypeVar("T")


@dataclass(frozen=True)
class Later:
    """What `Part.build` is given, found only if some part asks for it."""

    find: Callable[[], Any]


@dataclass(frozen=True, eq=False)
class Part(Value, Generic[T]):
    """What a table asks to be made: a function, and its arguments read and typed.

    Attributes
    ----------
    make : callable
    arguments : dict from parameters to values
        Other parts among them.
    given : tuple of str
        Parameters that do not stand in the file.

    Examples
    --------
    >>> from rcac_numeric import Piecewise, Step
    >>> from rcac_numeric.experiments.format.parts import Part
    >>> step = Part(Step, {"height": 2.0})
    >>> Part(Piecewise, {"pieces": [(3, step)]}).build().description
    'step(2) from 3'
    """

    make: Callable[..., T]
    arguments: dict[str, Any]
    given: tuple[str, ...] = ()

    def build(self, **context: Any) -> T:
        """Make it; `context` holds what does not stand in the file, for inner parts too."""
        built = {name: _built(value, context) for name, value in self.arguments.items()}
        for name in self.given:
            value = context[name]
            built[name] = value.find() if isinstance(value, Later) else value
        return self.make(**built)


def _built(value: Any, context: Mapping[str, Any]) -> Any:
    if isinstance(value, Part):
        return value.build(**context)
    if isinstance(value, list | tuple):
        return type(value)(_built(entry, context) for entry in value)
    if isinstance(value, dict):
        return {key: _built(entry, context) for key, entry in value.items()}
    return value
