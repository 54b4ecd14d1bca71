"""Matrices of any kind to exact SymPy matrices."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any, Protocol, TypeAlias

import flint
import sympy
from sympy import Expr, ImmutableMatrix, Matrix, MatrixBase

from compensator_theory.errors import InputError
from compensator_theory.matrices._flint_backed import FlintBackedMatrix
from compensator_theory.matrices._flint_matrices import (
    RationalMatrix,
    from_flint,
    rational_representation,
    to_flint,
)
from compensator_theory.matrices._symbolic_matrices import SymbolicMatrix, symbolic_matrix
from compensator_theory.polynomials._budget import ask, decimal_digits, listed, repr_of
from compensator_theory.polynomials._decidable import require_rational_functions
from compensator_theory.polynomials._numbers import NumberLike, exact_number, plain_rationals
from compensator_theory.polynomials._variables import require_one_symbol_a_name


class ArrayOfNumbers(Protocol):
    """Protocol of NumPy arrays: their shape and their entries."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of rows and columns."""

    def __iter__(self) -> Iterator[Any]:
        """Return its rows."""


MatrixLike: TypeAlias = MatrixBase | Sequence[Sequence[NumberLike]] | ArrayOfNumbers
"""A SymPy matrix, a NumPy array or nested lists of anything :func:`exact_number` reads."""


def exact_matrix(value: MatrixLike, name: str) -> ImmutableMatrix:
    """Read a matrix exactly, entry by entry."""
    value = _in_rows(value, name)
    if (read := _read_at_once(value, name)) is not None:
        return read
    rows, shape = _rows_of(value, name)
    ask("entries", shape[0] * shape[1], f"the matrix {name}")
    entries = [[_rational_or_symbolic(entry, name) for entry in row] for row in rows]
    flat = [entry for row in entries for entry in row]
    require_one_symbol_a_name(set().union(*(entry.free_symbols for entry in flat)))
    matrix = ImmutableMatrix(*shape, flat)
    symbolic = symbolic_matrix(matrix)
    return matrix if symbolic is None else symbolic


def _in_rows(value: Any, name: str) -> Any:
    """A flat B as a column and a flat C as a row, as in a system (A, B, C)."""
    is_flat = isinstance(value, list | tuple) or getattr(value, "ndim", 0) == 1
    if name not in ("B", "C") or not is_flat:
        return value
    ask("entries", len(value), f"the matrix {name}")  # before each entry is looked at
    entries = [*value]
    if not entries or any(hasattr(e, "__len__") and not isinstance(e, str) for e in entries):
        return value
    return [[entry] for entry in entries] if name == "B" else [entries]


def _read_at_once(value: Any, name: str) -> FlintBackedMatrix | None:
    """Read a rational matrix at once, without an expression for each entry; None for others."""
    if isinstance(value, SymbolicMatrix):
        ask("entries", value.rows * value.cols, f"the matrix {name}")
        return value
    if isinstance(value, RationalMatrix):
        return _within_budget(value, name)
    if type(value) in (ImmutableMatrix, Matrix):
        return (
            None
            if rational_representation(value) is None
            else _within_budget(from_flint(to_flint(value)), name)
        )
    is_array = type(value).__module__ == "numpy" and getattr(value, "ndim", 0) == 2
    if is_array and value.dtype.name in ("float64", "int64"):
        ask("entries", value.size, f"the matrix {name}")
        value = value.tolist()
    if type(value) not in (list, tuple) or not {list, tuple}.issuperset(map(type, value)):
        return None
    if len(set(map(len, value))) != 1 or not value[0]:
        return None
    shape = len(value), len(value[0])
    ask("entries", shape[0] * shape[1], f"the matrix {name}")
    flat = [*chain.from_iterable(value)]
    if set(map(type, flat)) == {int}:
        ask("digits", decimal_digits(max(*flat, -min(flat)).bit_length()), "a number")
        return from_flint(flint.fmpq_mat(flint.fmpz_mat(*shape, flat)))
    entries = plain_rationals(flat)
    return None if entries is None else from_flint(flint.fmpq_mat(*shape, entries))


def _within_budget(matrix: RationalMatrix, name: str) -> RationalMatrix:
    """Check the budget for the number of entries and for the longest one."""
    entries = matrix.flint_form.entries()
    ask("entries", len(entries), f"the matrix {name}")
    bits = max(map(flint.fmpq.height_bits, entries), default=0)
    ask("digits", decimal_digits(bits), "a number")
    return matrix


def _rows_of(value: Any, name: str) -> tuple[list[list[Any]], tuple[int, int]]:
    if isinstance(value, MatrixBase):
        return value.tolist(), (int(value.rows), int(value.cols))
    if hasattr(value, "toarray") or hasattr(value, "todense"):
        raise InputError(f"{name} is a sparse matrix; write it out with .toarray()")
    shape = getattr(value, "shape", None)
    iterable = hasattr(value, "__iter__") and not isinstance(value, str | bytes | set | dict)
    rows = listed(value, "entries", f"the matrix {name}") if iterable and shape != () else None
    if rows is None or any(isinstance(r, str | bytes) or not hasattr(r, "__len__") for r in rows):
        raise InputError(
            f"{name} = {repr_of(value)} is not a matrix; write rows, as in [[1, 2], [3, 4]]"
        )
    if len({len(row) for row in rows}) > 1:
        raise InputError(f"the rows of {name} have different lengths: {[len(r) for r in rows]}")
    columns = len(rows[0]) if rows else (shape[1] if shape is not None and len(shape) > 1 else 0)
    return [list(row) for row in rows], (len(rows), columns)


def _rational_or_symbolic(value: NumberLike, name: str) -> Expr:
    """Read an entry, which must be in the rings that the algorithms work in."""
    entry = sympy.sympify(exact_number(value))
    require_rational_functions([entry], name)
    return entry
