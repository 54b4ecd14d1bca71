"""Exact transfer matrices from any description."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import Any, TypeAlias

import sympy
from sympy import MatrixBase, Poly, Symbol

from compensator_theory.errors import InputError
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import common_divisor, exact_quotient, monic, product
from compensator_theory.polynomials._quotients import Quotient
from compensator_theory.polynomials._reading import is_list, read_once
from compensator_theory.polynomials._variables import (
    as_symbol,
    evident_variable,
    require_one_symbol_a_name,
)
from compensator_theory.systems._conversions import TransferFunctionLike, scalar_of
from compensator_theory.systems._descriptions import described, opened, read_system, realised
from compensator_theory.systems._descriptor_systems import DescriptorSystem
from compensator_theory.systems._foreign import is_foreign, several_of
from compensator_theory.systems._kinds import Pair, Roots, Rows, States
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._sample_times import sampled_every, shared_sample_time
from compensator_theory.systems._transfer_functions import TransferFunction
from compensator_theory.systems._transfer_matrices import TransferMatrix

TransferMatrixLike: TypeAlias = (
    TransferMatrix | MatrixBase | Sequence[Sequence[TransferFunctionLike]] | TransferFunctionLike
)
"""Input types of :func:`transfer_matrix`."""


@holds_where_defined
@carrying()
def transfer_matrix(
    rows: TransferMatrixLike,
    variable: str | Symbol | None = None,
    *,
    sample_time: NumberLike | None = None,
) -> TransferMatrix:
    r"""Make an exact transfer matrix out of rows of transfer functions, or a foreign system.

    .. math:: G = \frac 1D \begin{bmatrix} N_{11} & \cdots \\ \vdots & \ddots \end{bmatrix}

    Parameters
    ----------
    rows : nested sequences, sympy.Matrix, TransferMatrix, Realisation, DescriptorSystem, ...
        Each entry is anything :func:`transfer_function` reads, a fraction as a tuple; p rows of m
        entries. A transfer function alone, or a tuple of two polynomials, makes a 1 x 1 matrix; a
        pair of nested lists of three levels holds the numerators and denominators of a matrix, as
        the arguments of python-control's `tf` do. Transfer functions and state spaces with several
        signals are read from python-control and SymPy, and matrices (A, B, C) or (A, B, C, D),
        which need the variable.
    variable : str or Symbol, optional
        Default: the only one of ``s``, ``z``, ``q`` in all entries together, else the only symbol.
    sample_time : number, optional
        As for :func:`transfer_function`.

    Returns
    -------
    TransferMatrix
        p x m, over the least common multiple D of the denominators; factors that an entry has in
        common stay in it.

    Raises
    ------
    InputError
        If the rows are not of one length, an entry cannot be read, or the variable is not evident.

    Examples
    --------
    >>> from compensator_theory import transfer_matrix
    >>> print(transfer_matrix([["1/(s + 1)", 0], [2, "1/(s + a)"]]))
    [[s + a, 0], [2*s**2 + (2*a + 2)*s + 2*a, s + 1]]/(s**2 + (a + 1)*s + a)
    """
    contents = _read(rows, variable)
    return contents if sample_time is None else sampled_every(contents, sample_time)


def _read(rows: TransferMatrixLike, variable: str | Symbol | None) -> TransferMatrix:
    description = described(rows, variable)
    if is_foreign(description):
        description = several_of(description, variable)
    if isinstance(description, States):
        description = realised(description, variable)
    if isinstance(description, TransferMatrix | Realisation | DescriptorSystem):
        if variable is not None and as_symbol(variable) != description.variable:
            raise InputError(f"the system is in {description.variable}, not in {variable}")
        return (
            description
            if isinstance(description, TransferMatrix)
            else description.transfer_matrix()
        )
    rows_of_entries = description.entries if isinstance(description, Rows) else [[description]]
    entries = [[opened(entry, variable) for entry in row] for row in rows_of_entries]
    symbol = _variable(entries) if variable is None else as_symbol(variable)
    read = [[scalar_of(read_system(entry, symbol), symbol) for entry in row] for row in entries]
    if any(G.variable != symbol for row in read for G in row):
        raise InputError(f"the entries are not all in the variable {symbol}")
    require_one_symbol_a_name(
        set().union(
            *(p.free_symbols for r in read for G in r for p in (G.numerator, G.denominator))
        )
    )
    return over_one_denominator(read)


def over_one_denominator(rows: Sequence[Sequence[TransferFunction]]) -> TransferMatrix:
    """Write transfer functions in one variable over their least common denominator."""
    different: dict[Poly, None] = dict.fromkeys(G.denominator for row in rows for G in row)
    common = reduce(_least_common_multiple, different)
    numerators = tuple(tuple(G.numerator for G in row) for row in rows)
    if len(different) > 1:
        cofactors = {bottom: exact_quotient(common, monic(bottom)) for bottom in different}
        numerators = tuple(
            tuple(product(G.numerator, cofactors[G.denominator]) for G in row) for row in rows
        )
    return TransferMatrix(
        numerators,
        common,
        sample_time=shared_sample_time(*(G for row in rows for G in row)),
    )


def _least_common_multiple(a: Poly, b: Poly) -> Poly:
    return product(a, exact_quotient(b, common_divisor(a, b)))


def _variable(entries: list[list[Any]]) -> Symbol:
    """The variable that entries show, of which texts and foreign systems are opened already."""
    fixed: set[Symbol] = set()
    occurring: set[Symbol] = set()
    for entry in (described(entry) for row in entries for entry in row):
        match entry:
            case TransferFunction() | TransferMatrix() | Realisation() | DescriptorSystem():
                fixed.add(entry.variable)
            case Poly():
                fixed |= set(entry.gens)
            case Quotient():
                occurring |= entry.free_symbols
            case Pair(variable=Symbol()) | Roots(variable=Symbol()) | States(variable=Symbol()):
                fixed.add(entry.variable)
            case Pair(numerator, denominator):
                for part in map(read_once, (numerator, denominator)):
                    if isinstance(part, Poly):
                        fixed |= set(part.gens)
                    elif isinstance(part, Quotient):
                        occurring |= part.reduced().free_symbols
                    elif not is_list(part):
                        occurring |= sympy.sympify(exact_number(part)).free_symbols
            case Roots():
                continue
            case States() | Rows():
                fixed.add(scalar_of(entry, None).variable)
            case _:
                occurring |= sympy.sympify(exact_number(entry)).free_symbols
    return evident_variable(occurring | fixed, "the transfer matrix", fixed)
