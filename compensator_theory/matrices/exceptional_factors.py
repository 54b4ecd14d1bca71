"""Where a symbolic answer does not hold: the factors of what was divided by on the way to it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import sympy
from sympy import Expr, ImmutableMatrix, Matrix

from compensator_theory.matrices.flint_matrices import symbols_in
from compensator_theory.matrices.fraction_free import RationalFunctions


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
    given = [divisor for divisor in dict.fromkeys(divisors) if divisor.free_symbols]
    if not given:
        return ()
    found = {factor: None for factor in _factors(given) if not factor.is_nonzero}
    return tuple(
        sorted(found, key=lambda f: (sympy.Poly(f).total_degree(), sympy.count_ops(f), str(f)))
    )


def _factors(divisors: list[Expr]) -> Iterator[Expr]:
    """Numerators and denominators in factors, by python-flint where it can read them."""
    row = ImmutableMatrix(1, len(divisors), divisors)
    if (work := RationalFunctions.of(row)) is None:
        for divisor in divisors:
            for side in sympy.fraction(sympy.cancel(divisor)):
                yield from (factor for factor, _ in sympy.factor_list(side)[1])
        return
    for divisor in divisors:
        for side in work.lowest(*work.read(divisor)):
            for factor, _ in side.factor()[1]:
                yield work.expression(-factor if factor.leading_coefficient() < 0 else factor)


def denominators_of(matrices: Iterable[Matrix]) -> list[Expr]:
    """Return the denominators of all entries that have symbols in them.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.matrices.exceptional_factors import denominators_of
    >>> denominators_of([Matrix([["1/a", "2*b"]])])
    [a]
    """
    bottoms: dict[Expr, None] = {}
    for matrix in filter(symbols_in, matrices):
        work = RationalFunctions.of(matrix)
        for entry in matrix:
            if work is None:
                bottoms[sympy.fraction(sympy.cancel(entry))[1]] = None
            elif entry.free_symbols:
                below = work.lowest(*work.read(entry))[1]
                if not below.is_constant():
                    bottoms[work.expression(below)] = None
    return [bottom for bottom in bottoms if bottom.free_symbols]
