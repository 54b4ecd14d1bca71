"""Exact results in a terminal: short calls, matrices by their shapes, names of the fields."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from typing import Any

from sympy import MatrixBase, Poly

from compensator_theory._few_lines import MOST_LINES, field_names
from compensator_theory._printing import representation, text

WHOLE_CALL = 200
"""Characters of a constructor call that is printed with all its arguments."""
WHOLE_MATRIX = 400
"""Characters of a matrix that is printed with all its entries."""
_LONGEST_LINE = 240
_LONGEST_FIELD = 60


def matrix_repr(name: str, written: str, shape: tuple[int, int]) -> str:
    """Write a matrix of polynomials as a call; a large one by its shape."""
    if len(written) <= WHOLE_MATRIX:
        return f"{name}({written})"
    return f"<{name}, {shape[0]} x {shape[1]}; print it for the entries>"


def matrix_line(name: str, matrix: MatrixBase, attribute: str = "") -> str:
    """Write a matrix with its name; a large one by its shape and its attribute."""
    written = text(matrix.tolist())
    if len(written) <= WHOLE_MATRIX:
        return f"{name} = {written}"
    return f"{name}: {_shape(matrix)}, see .{attribute or name}"


def several(parts: Sequence[object], attribute: str, most: int = 4) -> str:
    """Write the first parts on one line, with a count of the others and their attribute."""
    more = [f"... {len(parts) - most} more; .{attribute} has all"] if len(parts) > most else []
    return "; ".join([*map(str, parts[:most]), *more])


def result_repr(value: Any) -> str:
    """Write a short result as a constructor call, a longer one as its answer and its fields."""
    name = type(value).__qualname__
    arguments = [(f.name, getattr(value, f.name)) for f in fields(value) if f.repr]
    call = f"{name}({', '.join(f'{key}={representation(part)}' for key, part in arguments)})"
    if "\n" not in call and len(call) <= WHOLE_CALL:
        return call
    if not _has_answer(type(value)):
        return f"{name}({', '.join(f'{key}={_in_short(part)}' for key, part in arguments)})"
    lines = [_cut(line) for line in str(value).split("\n")]
    last = f"fields: {field_names(value)}"
    if len(lines) == MOST_LINES:
        lines, last = lines[: MOST_LINES - 1], f"... print it for the rest; {last}"
    return "\n  ".join([f"{name}: {lines[0]}", *lines[1:], last])


def _has_answer(kind: type) -> bool:
    return any("__str__" in vars(base) for base in kind.__mro__[:-1])


def _in_short(part: Any) -> str:
    if isinstance(part, MatrixBase):
        return f"<{_shape(part)}>"
    if is_dataclass(part):
        return f"<{type(part).__qualname__}>"
    written = text(part.as_expr()) if isinstance(part, Poly) else representation(part)
    if len(written) <= _LONGEST_FIELD:
        return written
    return f"<{len(part)} items>" if isinstance(part, tuple) else _cut(written, _LONGEST_FIELD)


def _shape(matrix: MatrixBase) -> str:
    return f"{matrix.rows} x {matrix.cols} matrix"


def _cut(line: str, most: int = _LONGEST_LINE) -> str:
    return line if len(line) <= most else f"{line[: most - 3]}..."
