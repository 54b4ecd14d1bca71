"""Data classes with arrays: equality by value, fingerprints, reprs."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields, is_dataclass
from dataclasses import replace as dataclass_replace
from html import escape
from typing import Any, ClassVar, TypeVar

import attrs
import numpy as np

from compensator_theory._few_lines import MOST_LINES
from compensator_theory._truth import Truth
from compensator_theory._wording import in_a_line
from rcac_numeric.arrays._wording import shortened

T = TypeVar("T")

MOST = 9  # longest array that a repr writes out, in entries
LINES, LINE = MOST_LINES, 120  # largest repr, in lines and in characters a line
WIDTH = 90  # longest field in a repr, in characters


class Value:
    """Base class of data classes with arrays: equality by value.

    Arrays are equal if shape, type and every entry are; NaN equals NaN, as it
    must for a result to equal its own copy. A repr has at most five lines of 120 characters.
    """

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        # Before attrs or dataclasses decorate the class: both keep a `__repr__` of its namespace.
        if cls.__repr__ is Value.__repr__:
            cls.__repr__ = Value.__repr__  # type: ignore[method-assign]

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return self is other or equal(_contents(self), _contents(other))

    def __hash__(self) -> int:
        return hash((type(self).__qualname__, fingerprint(self)))

    def __repr__(self) -> str:
        if not is_record(self):
            return object.__repr__(self)
        pairs = ((name, getattr(self, name)) for name in _repr_fields(type(self)))
        text = f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in pairs)})"
        return text if _is_short(text) else _packed(self, _abbreviated)

    def __str__(self) -> str:
        text = repr(self)
        if len(text) <= WIDTH and "\n" not in text:
            return text
        rows = self.overview()
        return rows if _is_short(rows) else _packed(self, lambda value: _shown(value, 0))

    def overview(self) -> str:
        """Return all fields as text, one a line, large arrays by size and range."""
        return overview(self)

    def _latex(self, printer: object = None) -> str:
        """Return the notebook formula for SymPy's `latex`."""
        from compensator_theory._latex import latex

        return latex(self)

    def _repr_html_(self) -> str | None:
        if hasattr(self, "_repr_latex_"):  # a notebook prefers HTML to LaTeX
            return None
        return html_table(type(self).__name__, _rows(self, depth=1))


class Result(Value, Truth):
    """Base class of results; only a yes or no result has a truth value."""


class ShowsState:
    """Base class of objects with a state; the repr shows the attributes in `SHOWN`."""

    SHOWN: ClassVar[tuple[str, ...]] = ()

    def __repr__(self) -> str:
        fields = (f"{name}={_shown(getattr(self, name), 0)}" for name in self.SHOWN)
        return f"{type(self).__name__}({', '.join(fields)})"

    def _repr_html_(self) -> str:
        rows = ((name, _shown(getattr(self, name), 0)) for name in self.SHOWN)
        return html_table(type(self).__name__, rows)


def equal(a: Any, b: Any) -> bool:
    """Whether two values are equal, arrays entry by entry."""
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
    """Return the first 16 hexadecimal digits of the SHA-256 of a value.

    The digits are the same on every machine. Functions enter by name, not by code.
    """
    digest = hashlib.sha256()
    for piece in _pieces(value):
        digest.update(len(piece).to_bytes(8, "little") + piece)
    return digest.hexdigest()[:16]


def is_record(value: object) -> bool:
    """Whether a value is an instance of an attrs class or a dataclass."""
    return not isinstance(value, type) and (attrs.has(type(value)) or is_dataclass(value))


def field_names(cls: type[Any], *, compared: bool = False, constructor: bool = False) -> list[str]:
    """Return the field names of a class: the compared ones, or those of the constructor."""
    if attrs.has(cls):
        every = [(f.name, bool(f.eq), f.init) for f in attrs.fields(cls)]
    else:
        every = [(f.name, f.compare, f.init) for f in fields(cls)]
    return [name for name, eq, init in every if (eq or not compared) and (init or not constructor)]


def replaced(value: T, **changes: Any) -> T:
    """Return a copy with some fields replaced and checked."""
    if attrs.has(type(value)):
        copy: T = attrs.evolve(value, **changes)  # type: ignore[misc]
        return copy
    return dataclass_replace(value, **changes)  # type: ignore[type-var]


def overview(value: Any, depth: int = 1) -> str:
    """Return the class and its fields, one a line; large arrays by size and range, without None."""
    rows = _rows(value, depth)
    width = max((len(name) for name, _ in rows), default=0)
    lines = [
        f"  {name:<{width}}  " + text.replace("\n", "\n  " + " " * (width + 2))
        for name, text in rows
    ]
    return "\n".join([type(value).__name__, *lines])


def _repr_fields(cls: type) -> list[str]:
    if attrs.has(cls):
        return [field.name for field in attrs.fields(cls) if field.repr]
    return [field.name for field in fields(cls) if field.repr]


def _is_short(text: str) -> bool:
    return sum(1 + max(len(line) - 1, 0) // LINE for line in text.split("\n")) <= LINES


def _packed(value: Any, text_of: Callable[[Any], str]) -> str:
    """Return the fields of a record, filled into at most five lines."""
    names = _repr_fields(type(value)) if is_record(value) else []
    parts = ((name, text_of(getattr(value, name))) for name in names)
    texts = [f"{name}={_words(text)}" for name, text in parts if text]
    lines, rest = [f"{type(value).__name__}("], len(texts)
    for text in texts:
        mark = f"... {rest} more: overview())"
        if len(lines[-1]) + len(text) + 2 <= LINE - len(mark) * (len(lines) == LINES):
            lines[-1] += f"{text}, "
        elif len(lines) < LINES:
            lines.append(f"    {text}, ")
        else:
            return "\n".join(line.rstrip() for line in [*lines[:-1], lines[-1] + mark])
        rest -= 1
    return "\n".join(line.rstrip() for line in [*lines[:-1], lines[-1].rstrip(", ") + ")"])


def _abbreviated(part: Any) -> str:
    """Return a repr on one line, without the entries of large arrays and of nested records."""
    if isinstance(part, np.ndarray):
        return shown_array(part)
    text = repr(part)
    if len(text) <= WIDTH and "\n" not in text:
        return text
    return f"{type(part).__name__}(...)" if is_record(part) else " ".join(text.split())


def html_table(caption: str, rows: Iterable[tuple[str, str]]) -> str:
    """Return names and texts as an escaped HTML table."""
    cells = "".join(
        f"<tr><th style='text-align:left'>{escape(name)}</th>"
        f"<td style='text-align:left'><pre style='margin:0'>{escape(text)}</pre></td></tr>"
        for name, text in rows
    )
    return f"<table><caption>{escape(caption)}</caption>{cells}</table>"


def _rows(value: Any, depth: int) -> list[tuple[str, str]]:
    fields = ((name, getattr(value, name)) for name in field_names(type(value)))
    rows = [(name, _shown(part, depth)) for name, part in fields if not name.startswith("_")]
    return [(name, text) for name, text in rows if text]


def _shown(part: Any, depth: int) -> str:
    """Return a short text for a field; empty for None."""
    if part is None:
        return ""
    if isinstance(part, np.ndarray):
        return shown_array(part)
    if is_record(part):
        if next(cls for cls in type(part).__mro__ if "__str__" in vars(cls)) not in (Value, object):
            return _words(str(part))
        if "\n" not in (text := repr(part)) and len(text) <= WIDTH:
            return text
        return overview(part, depth - 1) if depth else type(part).__name__
    if isinstance(part, str):
        return _words(part)
    if isinstance(part, float | complex):
        return f"{part:.6g}"
    if isinstance(part, Mapping):
        return _words(", ".join(map(str, part)))
    if isinstance(part, list | tuple):
        return shortened(", ".join(filter(None, (_shown(item, 0) for item in part))), WIDTH)
    if callable(part) and hasattr(part, "__name__"):
        return str(part.__name__)
    return _words(str(part))


def _words(text: str) -> str:
    """Return an untrusted text on one line with its control characters escaped."""
    return shortened(in_a_line(" ".join(text.split())), WIDTH)


def shown_array(part: np.ndarray) -> str:
    """Return an array as text: its entries, or shape and range if there are many."""
    if not part.size:
        return ""
    if part.size <= MOST:
        return np.array2string(
            part, precision=6, suppress_small=False, separator=", ", max_line_width=WIDTH
        ).replace("\n ", " ")
    shape = " x ".join(map(str, part.shape))
    if part.dtype.kind not in "iuf" or not (finite := part[np.isfinite(part)]).size:
        return shape
    unknown = f", {part.size - finite.size} not finite" if finite.size < part.size else ""
    return f"{shape}, from {finite.min():.6g} to {finite.max():.6g}{unknown}"


def _contents(value: Any) -> dict[str, Any]:
    return {name: getattr(value, name) for name in field_names(type(value), compared=True)}


def _pieces(value: Any) -> list[bytes]:
    if isinstance(value, np.ndarray):
        if value.dtype.kind not in "biufc":  # texts and objects
            return [str(value.shape).encode(), *_pieces(value.tolist())]
        kind = "<c16" if value.dtype.kind == "c" else "<f8"
        return [str(value.shape).encode(), np.ascontiguousarray(value, dtype=kind).tobytes()]
    if is_record(value):
        if not isinstance(value, Value):  # without an array, so that the repr identifies the value
            return [repr(value).encode()]
        return [
            type(value).__name__.encode(),
            # The exact form of a float64 object does not change its behaviour.
            *(p for k, v in _contents(value).items() if k != "exact" for p in _pieces(v)),
        ]
    if isinstance(value, Mapping):
        return [b"map", *(p for item in value.items() for part in item for p in _pieces(part))]
    if type(value).__name__ == "LowLevelCallable":  # a tuple that contains a memory address
        name = getattr(value.function, "__name__", type(value.function).__name__)
        return [b"compiled", name.encode(), value.signature.encode()]
    if isinstance(value, list | tuple):
        return [b"list", *(piece for item in value for piece in _pieces(item))]
    if callable(value):
        return [getattr(value, "__qualname__", type(value).__name__).encode()]
    return [repr(value).encode()]
