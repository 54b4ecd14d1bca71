"""Results of both halves in a terminal: the answer on at most five lines; imports no SymPy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from functools import wraps
from typing import Any

MOST_LINES = 5


def in_few_lines(write: Callable[[Any], str]) -> Callable[[Any], str]:
    """Decorate a ``__str__``: at most five lines, the last of which counts the omitted ones.

    `_REST` of the class names the attributes with the omitted lines.
    """

    @wraps(write)
    def written(self: Any) -> str:
        lines = write(self).split("\n")
        if len(lines) <= MOST_LINES:
            return "\n".join(lines)
        rest = type(self)._REST or f"the fields are {field_names(self)}"
        omitted = len(lines) - MOST_LINES + 1
        return "\n".join([*lines[: MOST_LINES - 1], f"... {omitted} more; {rest}"])

    return written


def field_names(value: Any) -> str:
    """Write the attributes of a result that its repr shows, tuples with their lengths."""
    names = []
    for field in fields(value):
        if field.repr:
            part = getattr(value, field.name)
            count = f" ({len(part)})" if isinstance(part, tuple) else ""
            names.append(f".{field.name}{count}")
    return ", ".join(names)
