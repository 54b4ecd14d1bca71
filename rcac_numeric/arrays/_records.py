"""Data as JSON trees and arrays: exact serialisation without pickle."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cache
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import attrs
import numpy as np

import compensator_theory as exact
from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._values import equal, field_names, is_record

PLAIN = (str, bool, int, type(None))
LEFT_OUT = ("certificate",)  # certificate of a conversion: not part of comparisons
FORMS = frozenset(
    frozenset(form.split())
    for form in (
        "float", "array", "fraction", "tuple", "list", "dict", "class fields", "poly variable",
        "matrix shape", "symbol", "number",
    )
)  # fmt: skip
LARGEST = 10_000  # rows or columns of an exact matrix
_HEX = re.compile(r"-?(?:inf|nan|0x[01]\.[0-9a-f]{1,13}p[+-][0-9]{1,4})")
_RATIO = re.compile(r"-?[0-9]{1,4000}(?:/[1-9][0-9]{0,3999})?")
_NAME = re.compile(r"[^\W\d]\w{0,30}")


class Records:
    """Serialiser of listed classes to a JSON tree and named arrays."""

    def __init__(self, *classes: type) -> None:
        self._classes = {one.__name__: one for one in classes}

    def include(self, *classes: type) -> None:
        """List further classes, of packages that stand above."""
        self._classes |= {one.__name__: one for one in classes}

    def tree(self, value: Any, arrays: dict[str, Array]) -> Any:
        """Return the data as a tree; arrays are added to `arrays`."""
        tree = self._tree(value, arrays)
        if not equal(self.value(tree, arrays), value):
            raise InputError(f"{type(value).__name__} cannot be written exactly.")
        return tree

    def _tree(self, value: Any, arrays: dict[str, Array]) -> Any:
        if type(value) in PLAIN:
            return value
        if type(value) is float:
            return {"float": value.hex()}
        if isinstance(value, np.ndarray) and value.dtype.kind in "fciub":
            name = f"part_{len(arrays)}"
            arrays[name] = value
            return {"array": name}
        if type(value) is Fraction:
            return {"fraction": str(value)}
        if type(value) in (tuple, list):
            return {type(value).__name__: [self._tree(part, arrays) for part in value]}
        if isinstance(value, Mapping):
            pairs = [[self._tree(k, arrays), self._tree(v, arrays)] for k, v in value.items()]
            return {"dict": pairs}
        name = type(value).__name__
        if is_record(value) and type(value) in (*self._classes.values(), *_exact().values()):
            parts = {
                field: self._tree(getattr(value, field), arrays)
                for field in field_names(type(value), constructor=True)
                if field not in LEFT_OUT
            }
            return {"class": name, "fields": parts}
        if name in ("Poly", "ImmutableDenseMatrix", "RationalMatrix", "Symbol"):
            return _symbolic(value)
        if getattr(value, "is_Rational", False):  # a sample time of the exact package
            return {"number": str(value)}
        raise InputError(f"{name} {value!r:.80} cannot be written into a file without pickle.")

    def value(self, tree: Any, arrays: Mapping[str, Array]) -> Any:
        """Rebuild the data from `tree`; fields must have the types that their class declares."""
        if type(tree) in PLAIN:
            return tree
        if not isinstance(tree, dict) or frozenset(tree) not in FORMS:
            raise ValueError(f"{str(tree)[:80]!r} is not an entry of a record")
        match tree:
            case {"float": str() as digits}:
                return _float(digits)
            case {"array": str() as name}:
                return arrays[name]
            case {"fraction": str() as ratio}:
                return _fraction(ratio)
            case {"tuple": list() as parts}:
                return tuple(self.value(part, arrays) for part in parts)
            case {"list": list() as parts}:
                return [self.value(part, arrays) for part in parts]
            case {"dict": list() as pairs}:
                return {self.value(k, arrays): self.value(v, arrays) for k, v in pairs}
            case {"class": str() as name, "fields": dict() as parts}:
                return self._instance(name, {k: self.value(v, arrays) for k, v in parts.items()})
            case {"poly": list() as coefficients, "variable": str() as variable}:
                return exact.polynomial([*map(_fraction, coefficients)], _name(variable))
            case {"matrix": list() as rows, "shape": [int() as height, int() as width]}:
                return _matrix(rows, height, width)
            case {"symbol": str() as name}:
                return _name(name)
            case {"number": str() as digits}:
                return exact.exact_number(_fraction(digits))
        raise ValueError(f"{str(tree)[:80]!r} is not an entry of a record")

    def _instance(self, name: str, parts: dict[str, Any]) -> Any:
        if name in _exact():
            return _exact()[name](**parts)
        if name not in self._classes:
            raise ValueError(
                f"a {name[:60]!r} is not an allowed class of the packages that are imported; one "
                "of rcac_numeric.estimation is read after an import of that"
            )
        record = self._classes[name](**_by_argument(self._classes[name], parts))
        require_declared(record)
        return record


def require_declared(record: Any) -> None:
    """Raise TypeError if a field of a dataclass does not have its declared type."""
    for name, hint in _declared(record.__class__).items():
        if not _is_of(getattr(record, name), hint):
            kind = type(getattr(record, name)).__name__
            raise TypeError(f"{name} of a {type(record).__name__} is of type {kind}")


@cache
def _declared(cls: type[Any]) -> dict[str, Any]:
    hints = get_type_hints(cls)
    return {name: hints[name] for name in field_names(cls)}


def _is_of(value: Any, hint: Any) -> bool:
    """Whether a value matches an annotation of our classes; protocols are not checked."""
    origin, inner = get_origin(hint), get_args(hint)
    if hint is Any or getattr(hint, "_is_protocol", False):
        return True
    if origin is Literal:
        return isinstance(value, str) and value in inner
    if origin in (Union, UnionType):
        return any(_is_of(value, one) for one in inner)
    if origin is np.ndarray:
        return isinstance(value, np.ndarray) and value.dtype == np.float64
    if origin is tuple and inner[-1] is not Ellipsis:
        fits = isinstance(value, tuple) and len(value) == len(inner)
        return fits and all(map(_is_of, value, inner))
    if origin in (tuple, Sequence):
        return isinstance(value, tuple | list) and all(_is_of(one, inner[0]) for one in value)
    if origin is Mapping:
        fits = isinstance(value, Mapping)
        return fits and all(_is_of(k, inner[0]) and _is_of(v, inner[1]) for k, v in value.items())
    if hint in (int, float):
        return type(value) is int or (hint is float and type(value) is float)
    return isinstance(hint, type) and isinstance(value, hint)


def _float(digits: str) -> float:
    if not _HEX.fullmatch(digits):
        raise ValueError(f"{digits[:60]!r} is no float")
    try:
        return float.fromhex(digits)
    except OverflowError:
        raise ValueError(f"{digits} is beyond float64") from None


def _fraction(ratio: Any) -> Fraction:
    if not isinstance(ratio, str) or not _RATIO.fullmatch(ratio):
        raise ValueError(f"{str(ratio)[:60]!r} is no rational number")
    return Fraction(ratio)


def _name(text: str) -> str:
    if not _NAME.fullmatch(text):
        raise ValueError(f"{text[:60]!r} is no name of a variable")
    return text


@cache
def _exact() -> dict[str, type]:
    """Return the exact classes by name, imported on first use."""
    classes = (exact.StandardProblem, exact.TransferFunction, exact.TransferMatrix)
    return {one.__name__: one for one in classes}


def _symbolic(value: Any) -> Any:
    """Rebuild a polynomial, matrix or symbol of the exact package from its numbers as text."""
    name = type(value).__name__
    if name == "Symbol":
        return {"symbol": str(value)}
    if name == "Poly":
        coefficients = [str(c) for c in value.all_coeffs()]
        return {"poly": coefficients, "variable": str(value.gen)}
    rows = [[str(entry) for entry in row] for row in value.tolist()]
    return {"matrix": rows, "shape": list(value.shape)}


def _matrix(rows: list[Any], height: int, width: int) -> Any:
    from sympy import ImmutableMatrix

    if not (0 <= height <= LARGEST and 0 <= width <= LARGEST):
        raise ValueError(f"a matrix of {height} x {width} is too large")
    if not height or not width:
        return ImmutableMatrix.zeros(height, width)
    if len(rows) != height or any(len(row) != width for row in rows):
        raise ValueError(f"a matrix is not of its size {height} x {width}")
    return [[_fraction(entry) for entry in row] for row in rows]


def _by_argument(cls: type[Any], parts: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of a class under the names of the constructor's arguments."""
    if not attrs.has(cls):
        return parts
    names = {field.name: field.alias or field.name for field in attrs.fields(cls)}
    return {names.get(name, name): value for name, value in parts.items()}
