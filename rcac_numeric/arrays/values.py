"""Data that compare by what they hold: equality, and a short name that equal data share."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np


class Value:
    """A base for dataclasses with arrays in them: equal where all that they hold is equal.

    Two arrays are equal where shape, type and every entry are; not a number equals itself, as it
    must for a result to equal its own copy.
    """

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return self is other or equal(_contents(self), _contents(other))

    def __hash__(self) -> int:
        return hash((type(self).__qualname__, fingerprint(self)))


def equal(a: Any, b: Any) -> bool:
    """Whether two pieces of data hold the same, arrays entry by entry."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return (
            isinstance(a, np.ndarray)
            and isinstance(b, np.ndarray)
            and a.dtype == b.dtype
            and np.array_equal(a, b, equal_nan=a.dtype.kind in "fc")
        )
    if type(a) is not type(b):
        return False
    if isinstance(a, Mapping):
        return list(a) == list(b) and all(equal(a[key], b[key]) for key in a)
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(equal, a, b))
    return bool(a == b or (a != a and b != b))  # noqa: PLR0124


def fingerprint(value: Any) -> str:
    """The first 16 hexadecimal digits of the SHA-256 of everything that `value` holds.

    The same on every machine. Functions count by their name: their code cannot be compared.
    """
    digest = hashlib.sha256()
    for piece in _pieces(value):
        digest.update(len(piece).to_bytes(8, "little") + piece)
    return digest.hexdigest()[:16]


def _contents(value: Any) -> dict[str, Any]:
    return {f.name: getattr(value, f.name) for f in fields(value) if f.compare}


def _pieces(value: Any) -> list[bytes]:
    if isinstance(value, np.ndarray):
        if value.dtype.kind not in "biufc":  # texts and objects
            return [str(value.shape).encode(), *_pieces(value.tolist())]
        kind = "<c16" if value.dtype.kind == "c" else "<f8"
        return [str(value.shape).encode(), np.ascontiguousarray(value, dtype=kind).tobytes()]
    if is_dataclass(value) and not isinstance(value, type):
        if not isinstance(value, Value):  # without an array in it, so that its repr says it all
            return [repr(value).encode()]
        return [
            type(value).__name__.encode(),
            # The exact form of a float64 object changes nothing of what it does.
            *(p for k, v in _contents(value).items() if k != "exact" for p in _pieces(v)),
        ]
    if isinstance(value, Mapping):
        return [b"map", *(p for item in value.items() for part in item for p in _pieces(part))]
    if type(value).__name__ == "LowLevelCallable":  # a tuple with an address in it
        name = getattr(value.function, "__name__", type(value.function).__name__)
        return [b"compiled", name.encode(), value.signature.encode()]
    if isinstance(value, list | tuple):
        return [b"list", *(piece for item in value for piece in _pieces(item))]
    if callable(value):
        return [getattr(value, "__qualname__", type(value).__name__).encode()]
    return [repr(value).encode()]
