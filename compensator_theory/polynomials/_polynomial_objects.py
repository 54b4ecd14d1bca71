"""Polynomials of NumPy, python-flint and SymPy's rings, as a list from the highest power down."""

from __future__ import annotations

from typing import Any

import flint
from sympy import Expr, Poly, Symbol
from sympy.polys.fields import FracElement
from sympy.polys.rings import PolyElement

from compensator_theory.errors import InputError
from compensator_theory.polynomials._budget import listed
from compensator_theory.polynomials._numbers import read_coefficients
from compensator_theory.polynomials._poly import from_coefficients

_IN_FLINT = (flint.fmpz_poly, flint.fmpq_poly, flint.fmpz_series, flint.fmpq_series)
_UNNAMED = "x"
"""How NumPy calls a variable that was given no name."""


def in_our_order(obj: Any) -> Any:
    """Return a polynomial of another package as a list in descending powers, or as one of SymPy.

    NumPy's `Polynomial` and python-flint list their coefficients from the constant on, `poly1d`
    from the highest power down, and each is read in its own order. What is none is handed back.
    """
    if isinstance(obj, str | list | tuple | Poly | Expr):
        return obj
    if isinstance(obj, PolyElement | FracElement):
        expression = obj.as_expr()
        symbols = (obj.ring if isinstance(obj, PolyElement) else obj.field).symbols
        alone = len(symbols) == 1 and isinstance(obj, PolyElement)
        return Poly(expression, symbols[0]) if alone else expression
    if isinstance(obj, _IN_FLINT):
        return _descending(listed(obj.coeffs(), "degree", "the polynomial", more=1))
    classes = {((one.__module__ or "").split(".")[0], one.__name__) for one in type(obj).__mro__}
    if ("numpy", "poly1d") in classes:
        return _named([*obj.coeffs], obj.variable)
    if ("numpy", "ABCPolyBase") in classes:
        if ("numpy", "Polynomial") not in classes or (obj.domain != obj.window).any():
            raise InputError(
                f"the coefficients of this {type(obj).__name__} are not those of the powers of its "
                "variable; give p.convert(kind=numpy.polynomial.Polynomial)"
            )
        return _named(_descending([*obj.coef]), obj.symbol)
    return obj


def _descending(ascending: list[Any]) -> list[Any]:
    """Return the coefficients from the highest power down, without padding zeros."""
    coefficients = ascending[::-1] or [0]
    while len(coefficients) > 1 and coefficients[0] == 0:
        del coefficients[0]
    return coefficients


def _named(descending: list[Any], name: str) -> Any:
    """The list; the polynomial itself where its variable was named."""
    if name == _UNNAMED:
        return descending
    return from_coefficients(read_coefficients(descending), Symbol(name))
