"""Data as plain trees and arrays: what a file holds without pickle, bit for bit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from fractions import Fraction
from typing import Any

import numpy as np

import compensator_theory as exact
from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.values import equal

PLAIN = (str, bool, int, type(None))
EXACT = ("StandardProblem", "TransferFunction", "TransferMatrix")
LEFT_OUT = ("certificate",)  # of a conversion: evidence, which no comparison reads


class Records:
    """Writes data of the classes that it names as a tree of JSON and named arrays, and reads it.

    Parameters
    ----------
    classes : classes
        Dataclasses whose constructors take their fields. Nothing else is ever constructed.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.arrays.records import Records
    >>> arrays = {}
    >>> tree = Records().tree((1.5, np.arange(2.0)), arrays)
    >>> tree
    {'tuple': [{'float': '0x1.8000000000000p+0'}, {'array': 'part_0'}]}
    >>> Records().value(tree, arrays)
    (1.5, array([0., 1.]))
    """

    def __init__(self, *classes: type) -> None:
        self._classes = {one.__name__: one for one in classes}

    def tree(self, value: Any, arrays: dict[str, Array]) -> Any:
        """The data as a tree; arrays are put into `arrays`.

        Raises
        ------
        InputError
            Where it is of a class that is not named, or does not come back as it was.
        """
        made = self._tree(value, arrays)
        if not equal(self.value(made, arrays), value):
            raise InputError(f"{type(value).__name__} cannot be written exactly.")
        return made

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
        if is_dataclass(value) and self._class(name) is type(value):
            parts = {
                f.name: self._tree(getattr(value, f.name), arrays)
                for f in fields(value)
                if f.init and f.name not in LEFT_OUT
            }
            return {"class": name, "fields": parts}
        if name in ("Poly", "ImmutableDenseMatrix", "Symbol"):
            return _symbolic(value)
        if getattr(value, "is_Rational", False):  # a sample time of the exact half
            return {"number": str(value)}
        raise InputError(f"{name} {value!r:.80} cannot be written into a file without pickle.")

    def value(self, tree: Any, arrays: Mapping[str, Array]) -> Any:
        """What `tree` was made of.

        Raises
        ------
        InputError, LookupError, TypeError, ValueError
            Where it is no such tree.
        """
        if type(tree) in PLAIN:
            return tree
        match tree:
            case {"float": str() as digits}:
                return float.fromhex(digits)
            case {"array": str() as name}:
                return arrays[name]
            case {"fraction": str() as ratio}:
                return Fraction(ratio)
            case {"tuple": list() as parts}:
                return tuple(self.value(part, arrays) for part in parts)
            case {"list": list() as parts}:
                return [self.value(part, arrays) for part in parts]
            case {"dict": list() as pairs}:
                return {self.value(k, arrays): self.value(v, arrays) for k, v in pairs}
            case {"class": str() as name, "fields": dict() as parts}:
                made = self._class(name)
                if made is None:
                    raise ValueError(f"a {name} is nothing that belongs here")
                return made(**{k: self.value(part, arrays) for k, part in parts.items()})
            case {"poly": list() as coefficients, "variable": str() as variable}:
                return exact.polynomial(coefficients, variable)
            case {"matrix": list() as rows, "shape": [int() as height, int() as width]}:
                return _matrix(rows, height, width)
            case {"symbol": str() as name}:
                return name
            case {"number": str() as digits}:
                return exact.exact_number(digits)
        raise ValueError(f"{str(tree)[:80]!r} stands for nothing")

    def _class(self, name: str) -> type | None:
        return getattr(exact, name) if name in EXACT else self._classes.get(name)


def _symbolic(value: Any) -> Any:
    """A polynomial, matrix or symbol of the exact half, by its numbers as text."""
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

    if not height or not width:
        return ImmutableMatrix.zeros(height, width)
    return rows
