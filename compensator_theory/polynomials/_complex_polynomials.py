"""Polynomials with complex coefficients, as rotating frames have them: read by few functions."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import sympy
from sympy import QQ_I, Dummy, Expr, Poly, PolynomialError, Symbol

from compensator_theory.errors import InputError
from compensator_theory.polynomials._budget import ask, is_array, limit_of, quoted
from compensator_theory.polynomials._expressions import parse_expression
from compensator_theory.polynomials._numbers import exact_number
from compensator_theory.polynomials._poly import canonical, from_coefficients, product, total
from compensator_theory.polynomials._sympy_trees import require_readable
from compensator_theory.polynomials._variables import shared_variable, variable_in

_UNIT = re.compile(r"(?<![A-Za-z_])(?:\d+(?:\.\d*)?)?[Ij](?![A-Za-z_0-9(])|\d[ij](?![A-Za-z_0-9(])")


def complex_parts(
    obj: Any, variable: str | Symbol | None = None, time: object = None
) -> tuple[Poly, Poly] | None:
    """Return the polynomials a and b of a + jb; None where b is 0, or there is no polynomial.

    Symbols stand for real numbers; `time` gives a list of coefficients its variable.
    """
    if variable is None and time is not None and isinstance(obj, list | tuple):
        variable = variable_in(time, None, "the polynomial")
    if isinstance(obj, Poly):
        if obj.domain.is_QQ or obj.domain.is_ZZ or len(obj.gens) != 1:
            return None
        coefficients, gen = obj.all_coeffs(), obj.gen
    elif (read := _coefficients(obj, variable)) is not None:
        coefficients, gen = read
    else:
        return None
    if not any(c.has(sympy.I) for c in coefficients):
        return None
    sides = [_real_and_imaginary(c) for c in coefficients]
    real, imaginary = (
        canonical(from_coefficients([side[k] for side in sides], gen)) for k in (0, 1)
    )
    return None if imaginary.is_zero else (real, imaginary)


def norm_of(parts: tuple[Poly, Poly]) -> Poly:
    """Return p times its conjugate: the roots of p and their conjugates, stable as those are."""
    real, imaginary = parts
    return total(product(real, real), product(imaginary, imaginary))


def joined(parts: tuple[Poly, Poly]) -> Poly:
    """Return a + jb as one polynomial."""
    real, imaginary = parts
    domain = QQ_I if real.domain.is_QQ and imaginary.domain.is_QQ else None
    expression = sympy.expand(real.as_expr() + sympy.I * imaginary.as_expr())
    return Poly(expression, real.gen, domain=domain) if domain else Poly(expression, real.gen)


def over_gaussian_rationals(obj: Any, variable: str | Symbol | None) -> tuple[Poly, Poly] | None:
    """Return numerator and denominator over Q(j) of a rational function; None of a real one."""
    if isinstance(obj, tuple) and len(obj) == 2:
        if not _shows_unit(obj):
            return None
        top, bottom = (exact_number(side) for side in obj)
        expression = top / bottom
    else:
        parsed = _expression(obj)
        if parsed is None:
            return None
        expression = parsed
    if not expression.has(sympy.I):
        return None
    s = shared_variable([expression], variable)
    top, bottom = sympy.fraction(sympy.together(expression))
    try:
        N, D = (Poly(side, s, domain=QQ_I) for side in (top, bottom))
    except (PolynomialError, sympy.CoercionFailed):
        raise InputError(
            f"{quoted(expression)} has complex coefficients, and they are no rational numbers "
            "alone; give values for its symbols"
        ) from None
    if D.is_zero:
        raise InputError(f"the denominator of {quoted(expression)} is zero")
    N, D = N.mul_ground(1 / D.LC()), D.monic()
    if not any(c.has(sympy.I) for c in (*N.all_coeffs(), *D.all_coeffs())):
        return None
    return N, D


def _coefficients(obj: Any, variable: str | Symbol | None) -> tuple[list[Expr], Symbol] | None:
    """Return the coefficients of a text, an expression or a list, where the unit shows."""
    if isinstance(obj, list | tuple) or is_array(obj, dimensions=1):
        if variable is None or len(obj) > limit_of("degree") + 1 or not _shows_unit(obj):
            return None
        return [exact_number(value) for value in obj], Symbol(str(variable))
    if (expression := _expression(obj)) is None or not expression.has(sympy.I):
        return None
    gen = shared_variable([expression], variable)
    try:
        poly = Poly(expression, gen)
    except PolynomialError:
        return None
    ask("degree", int(poly.degree()), "the polynomial")
    return poly.all_coeffs(), gen


def _shows_unit(values: Sequence[Any]) -> bool:
    """Whether a number of a list is complex."""
    return any(
        (isinstance(value, complex) and value.imag != 0)
        or (isinstance(value, str) and _UNIT.search(value) is not None)
        or (isinstance(value, Expr) and value.has(sympy.I))
        for value in values
    )


def _expression(obj: Any) -> Expr | None:
    """Return the expression of a text that may have the imaginary unit, or of an expression."""
    if isinstance(obj, str):
        return parse_expression(obj) if _UNIT.search(obj) else None
    if isinstance(obj, Expr):
        require_readable(obj)
        return obj
    if isinstance(obj, Poly) and len(obj.gens) == 1:
        return obj.as_expr()
    return None


def _real_and_imaginary(value: Expr) -> tuple[Expr, Expr]:
    """Return a and b of a rational function a + jb of real symbols."""
    unit = Dummy()
    top, bottom = (
        Poly(side.xreplace({sympy.I: unit}), unit).rem(Poly(unit**2 + 1, unit))
        for side in sympy.fraction(sympy.together(value))
    )
    a, b = (top.coeff_monomial(unit**k) for k in (0, 1))
    c, d = (bottom.coeff_monomial(unit**k) for k in (0, 1))
    norm = c**2 + d**2
    return sympy.cancel((a * c + b * d) / norm), sympy.cancel((b * c - a * d) / norm)
