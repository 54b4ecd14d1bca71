"""Everything that describes a system with several signals, to an exact transfer matrix."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import reduce
from typing import Any, TypeAlias

import sympy
from sympy import MatrixBase, Poly, Symbol

from compensator_theory.errors import InputError
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._expressions import read_text
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import common_divisor, exact_quotient, monic, product
from compensator_theory.polynomials._polynomial_objects import in_our_order
from compensator_theory.polynomials._reading import is_list
from compensator_theory.polynomials._variables import (
    as_symbol,
    evident_variable,
    require_one_symbol_a_name,
)
from compensator_theory.systems._conversions import TransferFunctionLike, transfer_function
from compensator_theory.systems._descriptions import Pair, Rows, States, described
from compensator_theory.systems._descriptor_systems import DescriptorSystem
from compensator_theory.systems._foreign import Matrices, contents_of, is_foreign, joined_of
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._sample_times import sampled_every, shared_sample_time
from compensator_theory.systems._transfer_functions import TransferFunction
from compensator_theory.systems._transfer_matrices import TransferMatrix

TransferMatrixLike: TypeAlias = (
    TransferMatrix | MatrixBase | Sequence[Sequence[TransferFunctionLike]] | TransferFunctionLike
)
"""What :func:`transfer_matrix` reads."""


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
    found = _read(rows, variable)
    return found if sample_time is None else sampled_every(found, sample_time)


def _read(rows: TransferMatrixLike, variable: str | Symbol | None) -> TransferMatrix:
    rows = described(rows, variable)
    if isinstance(rows, States):
        rows = rows.realisation(variable)
    if isinstance(rows, TransferMatrix | Realisation | DescriptorSystem):
        if variable is not None and as_symbol(variable) != rows.variable:
            raise InputError(f"the system is in {rows.variable}, not in {variable}")
        return rows if isinstance(rows, TransferMatrix) else rows.transfer_matrix()
    entries = _entries(rows, variable)
    if isinstance(entries, TransferMatrix):
        return entries
    symbol = _variable(entries, variable)
    read = [[transfer_function(entry, symbol) for entry in row] for row in entries]
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


def _entries(rows: Any, variable: str | Symbol | None) -> list[list[Any]] | TransferMatrix:
    if isinstance(rows, Rows):
        return rows.entries
    if is_foreign(rows):
        return _foreign(rows, variable)
    return [[rows]]


def _foreign(system: Any, variable: str | Symbol | None) -> list[list[Any]] | TransferMatrix:
    if type(system).__module__.startswith("sympy") and type(system).__name__.startswith("MIMO"):
        system = joined_of(system)
    outputs = getattr(system, "noutputs", getattr(system, "num_outputs", 1))
    inputs = getattr(system, "ninputs", getattr(system, "num_inputs", 1))
    if (outputs, inputs) == (1, 1) or not hasattr(system, "num"):
        if all(hasattr(system, name) for name in "ABCD"):
            found = contents_of(system, variable)
            assert isinstance(found, Matrices)
            plant = Realisation(
                found.A, found.B, found.C, found.D, found.variable, sample_time=found.sample_time
            )
            return plant.transfer_matrix()
        if (outputs, inputs) == (1, 1):
            return [[transfer_function(system, variable)]]
    return [
        [transfer_function(system[i, j], variable) for j in range(inputs)] for i in range(outputs)
    ]


def _variable(entries: list[list[Any]], variable: str | Symbol | None) -> Symbol:
    if variable is not None:
        return as_symbol(variable)
    fixed: set[Symbol] = set()
    occurring: set[Symbol] = set()
    for entry in (described(entry) for row in entries for entry in row):
        if isinstance(entry, TransferFunction | TransferMatrix | Realisation | DescriptorSystem):
            fixed.add(entry.variable)
        elif isinstance(entry, Poly):
            fixed |= set(entry.gens)
        elif is_foreign(entry):
            fixed.add(transfer_function(entry).variable)
        elif isinstance(entry, str):
            top, bottom = read_text(entry).sides()
            occurring |= top.free_symbols | bottom.free_symbols
        elif isinstance(entry, Pair):
            for part in map(in_our_order, (entry.numerator, entry.denominator)):
                if isinstance(part, Poly):
                    fixed |= set(part.gens)
                elif not is_list(part):
                    occurring |= sympy.sympify(exact_number(part)).free_symbols
        elif isinstance(entry, Mapping):
            continue
        elif isinstance(entry, States | Rows):
            fixed.add(transfer_function(entry).variable)
        else:
            occurring |= sympy.sympify(exact_number(entry)).free_symbols
    return evident_variable(occurring | fixed, "the transfer matrix", fixed)
