"""Real polynomials from their exact roots."""

from collections import Counter
from collections.abc import Iterable
from typing import TypeAlias, cast

import sympy
from sympy import QQ, Poly, Symbol

from compensator_theory.errors import InputError
from compensator_theory.polynomials.numbers import NumberLike, exact_number
from compensator_theory.polynomials.poly import (
    PolynomialLike,
    canonical,
    from_expression,
    polynomial,
)
from compensator_theory.polynomials.variables import as_symbol

SpectrumLike: TypeAlias = PolynomialLike | Iterable[NumberLike]
"""A polynomial in any form but a list, or a collection of roots."""


def polynomial_from_roots(roots: Iterable[NumberLike], variable: str | Symbol) -> Poly:
    r"""Multiply out the monic real polynomial with the given exact roots.

    .. math:: p(s) = \prod_i (s - \lambda_i)

    Parameters
    ----------
    roots : iterable
        Anything :func:`exact_number` reads; a root is repeated as often as its multiplicity, and
        complex roots come in conjugate pairs. Symbols stand for real numbers.
    variable : str or Symbol
        The variable of the polynomial.

    Returns
    -------
    sympy.Poly
        Monic; 1 if there are no roots.

    Raises
    ------
    InputError
        If a complex root lacks its conjugate; the message names it.

    Examples
    --------
    >>> from compensator_theory import polynomial_from_roots
    >>> polynomial_from_roots([-1, "-0.5+0.1j", "-0.5-0.1j"], "s")
    Poly(s**3 + 2*s**2 + 63/50*s + 13/50, s, domain='QQ')
    """
    symbol = as_symbol(variable)
    if isinstance(roots, str) or not isinstance(roots, Iterable):
        raise InputError(f"the roots {roots!r} must be a list, for instance ['-1', '-2+1j']")
    exact = [sympy.expand(exact_number(root)) for root in roots]
    for root in exact:
        if symbol in root.free_symbols:
            raise InputError(f"the root {root} contains the variable {symbol} itself")
    product = Poly(1, symbol, domain=QQ)
    waiting = Counter(exact)
    for root in exact:
        if not waiting[root]:
            continue
        partner = sympy.expand(root.xreplace({sympy.I: -sympy.I}))
        waiting[root] -= 1
        if partner == root:
            product *= from_expression(symbol - root, symbol)
        elif waiting[partner]:
            waiting[partner] -= 1
            quadratic = symbol**2 - sympy.expand(root + partner) * symbol
            product *= from_expression(quadratic + sympy.expand(root * partner), symbol)
        else:
            raise InputError(
                f"the root {root} lacks its conjugate {partner}; list both, equally often"
            )
    return canonical(product)


def polynomial_or_roots(value: SpectrumLike, variable: str | Symbol) -> Poly:
    """Read what is to be placed: a polynomial, or its roots in any collection.

    A list, tuple, array, set or generator holds *roots*; coefficients are written as a polynomial.

    Raises
    ------
    InputError
        As :func:`polynomial_from_roots` and :func:`polynomial`.

    Examples
    --------
    >>> from compensator_theory.polynomials.from_roots import polynomial_or_roots
    >>> polynomial_or_roots((-1, -2), "s") == polynomial_or_roots("s**2 + 3*s + 2", "s")
    True
    """
    is_collection = isinstance(value, Iterable) and not isinstance(value, str | Poly | sympy.Expr)
    if is_collection:
        return polynomial_from_roots(cast(Iterable[NumberLike], value), variable)
    return polynomial(cast(PolynomialLike, value), variable)
