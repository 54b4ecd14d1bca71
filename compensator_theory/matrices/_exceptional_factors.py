"""Exceptional polynomials of a symbolic answer: the factors of all its divisors."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import sympy
from sympy import Expr, Matrix

from compensator_theory.matrices._flint_matrices import symbols_in
from compensator_theory.matrices._rational_functions import (
    NotRationalError,
    factored,
    in_symbols,
)
from compensator_theory.matrices._symbolic_matrices import SymbolicMatrix, symbolic_matrix


def exceptional_factors(divisors: Iterable[Expr]) -> tuple[Expr, ...]:
    """The irreducible polynomials in the symbols where one of the divisors is 0 or infinite."""
    proper = [divisor for divisor in dict.fromkeys(divisors) if divisor.free_symbols]
    degrees = {factor: degree for factor, degree in _factors(proper) if not factor.is_nonzero}
    return tuple(sorted(degrees, key=lambda f: (degrees[f], sympy.count_ops(f), str(f))))


def _factors(divisors: list[Expr]) -> Iterator[tuple[Expr, int]]:
    """Factors of both sides with their degrees, by python-flint where it can read them."""
    symbols = frozenset().union(*(divisor.free_symbols for divisor in divisors))
    work = in_symbols(symbols) if symbols and all(x.is_Symbol for x in symbols) else None
    for divisor in divisors:
        try:
            if work is None:
                raise NotRationalError
            sides = work.lowest(*work.read(divisor))
        except NotRationalError:
            for side in sympy.fraction(sympy.cancel(divisor)):
                for factor, _ in sympy.factor_list(side)[1]:
                    yield factor, int(sympy.Poly(factor).total_degree())
            continue
        for side in sides:
            for factor, _ in factored(side)[1]:
                sign = -1 if factor.leading_coefficient() < 0 else 1
                yield work.expression(factor * sign), int(factor.total_degree())


def denominators_of(matrices: Iterable[Matrix]) -> list[Expr]:
    """Return the denominators that have symbols in them, of each matrix one, or of its entries."""
    bottoms: dict[Expr, None] = {}
    for matrix in filter(symbols_in, matrices):
        symbolic = symbolic_matrix(matrix)
        if isinstance(symbolic, SymbolicMatrix):
            bottoms[symbolic.work.expression(symbolic.flint_form.below)] = None
        elif symbolic is None:
            bottoms |= dict.fromkeys(sympy.fraction(sympy.cancel(e))[1] for e in matrix)
    return [bottom for bottom in bottoms if bottom.free_symbols]
