"""Where a symbolic answer does not hold: the factors of what was divided by on the way to it."""

from __future__ import annotations

from collections.abc import Iterable

import sympy
from sympy import Expr, Matrix

from compensator_theory.matrices.flint_matrices import symbols_in


def exceptional_factors(divisors: Iterable[Expr]) -> tuple[Expr, ...]:
    """Return the irreducible polynomials in the symbols where one of the divisors is 0 or infinite.

    Parameters
    ----------
    divisors : iterable of sympy.Expr
        Rational functions of symbols; numbers, and factors that are known to be nonzero, drop out.

    Examples
    --------
    >>> from sympy import Integer
    >>> from sympy.abc import a, b
    >>> from compensator_theory.matrices.exceptional_factors import exceptional_factors
    >>> exceptional_factors([Integer(2), a**2 - a, a / (b + 1)])
    (a, a - 1, b + 1)
    """
    found: dict[Expr, None] = {}
    for divisor in dict.fromkeys(divisors):
        if not divisor.free_symbols:
            continue
        for side in sympy.fraction(sympy.cancel(divisor)):
            for factor, _ in sympy.factor_list(side)[1]:
                if not factor.is_nonzero:
                    found[factor] = None
    return tuple(
        sorted(found, key=lambda f: (sympy.Poly(f).total_degree(), sympy.count_ops(f), str(f)))
    )


def denominators_of(matrices: Iterable[Matrix]) -> list[Expr]:
    """Return the denominators of all entries that have symbols in them.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.matrices.exceptional_factors import denominators_of
    >>> denominators_of([Matrix([["1/a", "2*b"]])])
    [a]
    """
    bottoms = (
        sympy.fraction(sympy.cancel(entry))[1]
        for matrix in matrices
        if symbols_in(matrix)
        for entry in matrix
        if entry.free_symbols
    )
    return [bottom for bottom in dict.fromkeys(bottoms) if bottom.free_symbols]
