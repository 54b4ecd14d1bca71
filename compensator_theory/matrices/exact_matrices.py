"""Matrices of any kind to exact SymPy matrices."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import chain
from typing import Any, Protocol, TypeAlias

import flint
import sympy
from sympy import QQ, ZZ, Expr, ImmutableMatrix, MatrixBase
from sympy.polys.matrices import DomainMatrix

from compensator_theory.errors import InputError
from compensator_theory.matrices.flint_matrices import kept_rational, rational_in_flint
from compensator_theory.polynomials.budget import ask, ask_for_number, listed, shown
from compensator_theory.polynomials.numbers import NumberLike, exact_number
from compensator_theory.polynomials.variables import require_one_symbol_a_name


class ArrayOfNumbers(Protocol):
    """What a NumPy array shows of itself; only its shape and its entries are used."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of rows and columns."""

    def __iter__(self) -> Iterator[Any]:
        """Return its rows."""


MatrixLike: TypeAlias = MatrixBase | Sequence[Sequence[NumberLike]] | ArrayOfNumbers
"""A SymPy matrix, a NumPy array or nested lists of anything :func:`exact_number` reads."""


def exact_matrix(value: MatrixLike, name: str) -> ImmutableMatrix:
    """Read a matrix exactly, entry by entry.

    Examples
    --------
    >>> from compensator_theory.matrices.exact_matrices import exact_matrix
    >>> exact_matrix([[0.1, "a"]], "A")
    Matrix([[1/10, a]])
    """
    if (read := _read_at_once(value, name)) is not None:
        return read
    rows, shape = _rows_of(value, name)
    ask("entries", shape[0] * shape[1], f"the matrix {name}")
    entries = [[_rational_or_symbolic(entry, name) for entry in row] for row in rows]
    flat = [entry for row in entries for entry in row]
    require_one_symbol_a_name(set().union(*(entry.free_symbols for entry in flat)))
    return ImmutableMatrix(*shape, flat)


def _read_at_once(value: Any, name: str) -> ImmutableMatrix | None:
    """Read integers and fractions without a look at each as an expression; None for the rest."""
    if type(value) is ImmutableMatrix:
        kept = kept_rational(value)
        if kept is None:
            return None
        ask("entries", int(value.rows) * int(value.cols), f"the matrix {name}")
        entries = [c for row in kept.to_dod().values() for c in row.values()]
        ask_for_number(
            max((abs(int(c.numerator)) for c in entries), default=0),
            max((int(c.denominator) for c in entries), default=1),
        )
        return value
    if (kinds := _kinds(value, name)) is None:
        return None
    domain = ZZ if kinds == {int} else QQ
    rows = [
        [domain(e) if domain is ZZ else domain(e.numerator, e.denominator) for e in row]
        for row in value
    ]
    rep = DomainMatrix(rows, (len(rows), len(rows[0])), domain)
    return ImmutableMatrix._fromrep(rep.to_sparse())


def _kinds(value: Any, name: str) -> set[type] | None:
    """Return the types of the entries of plain rows of integers and fractions; None for others."""
    if type(value) not in (list, tuple) or not all(type(row) in (list, tuple) for row in value):
        return None
    if len({len(row) for row in value}) != 1 or not value[0]:
        return None
    kinds = {type(entry) for row in value for entry in row}
    if not kinds <= {int, Fraction}:
        return None
    ask("entries", len(value) * len(value[0]), f"the matrix {name}")
    if kinds == {int}:
        largest = max(map(abs, chain.from_iterable(value)))
    else:
        largest = max(max(abs(e.numerator), e.denominator) for row in value for e in row)
    ask_for_number(largest, 1)
    return kinds


def read_in_flint(value: MatrixLike, name: str) -> flint.fmpq_mat | None:
    """Read a rational matrix without SymPy where it is written in plain numbers, else through it.

    Examples
    --------
    >>> from compensator_theory.matrices.exact_matrices import read_in_flint
    >>> read_in_flint([[1, 2], [3, 4]], "A").det(), read_in_flint([["a"]], "A")
    (-2, None)
    """
    kinds = _kinds(value, name)
    if kinds is None:
        return rational_in_flint(exact_matrix(value, name))
    rows: Any = value
    if kinds == {int}:
        return flint.fmpq_mat(flint.fmpz_mat(rows))
    fractions = [flint.fmpq(e.numerator, e.denominator) for row in rows for e in row]
    return flint.fmpq_mat(len(rows), len(rows[0]), fractions)


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
            f"{name} = {shown(value)} is not a matrix; write rows, as in [[1, 2], [3, 4]]"
        )
    if len({len(row) for row in rows}) > 1:
        raise InputError(f"the rows of {name} have different lengths: {[len(r) for r in rows]}")
    columns = len(rows[0]) if rows else (shape[1] if shape is not None and len(shape) > 1 else 0)
    return [list(row) for row in rows], (len(rows), columns)


def _rational_or_symbolic(value: NumberLike, name: str) -> Expr:
    """Read an entry; an irrational number would leave the rings that the algorithms work in."""
    entry = sympy.sympify(exact_number(value))
    if entry.is_number and not entry.is_rational:
        raise InputError(
            f"{name} contains the irrational number {entry}; write a rational number close to it, "
            "or, where the function takes symbols, a symbol in its place"
        )
    return entry
