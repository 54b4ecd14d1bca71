"""Common roots of two polynomials: how many, and whether there are any."""

from __future__ import annotations

from typing import TypeAlias

import flint
import sympy
from sympy import Expr, Poly, Symbol
from sympy.polys.polyutils import expr_from_dict

from compensator_theory.bezout._subresultant_chains import subresultants
from compensator_theory.bezout._sylvester import (
    formal_coefficients,
    matrix_of_coefficients,
    with_formal_degrees,
)
from compensator_theory.errors import InputError
from compensator_theory.matrices._flint_matrices import rational
from compensator_theory.matrices._flint_polynomials import (
    flint_polynomial_pair,
    to_flint_polynomial,
)
from compensator_theory.matrices._linear_algebra import determinant
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._generic_answers import generic_answer_of
from compensator_theory.polynomials._multivariate import flint_domain, to_flint
from compensator_theory.polynomials._poly import is_rational
from compensator_theory.polynomials._reading import PolynomialLike

Formal: TypeAlias = tuple[Poly, int]
"""A polynomial with its formal degree."""


@carrying()
def number_of_common_roots(
    a: PolynomialLike, b: PolynomialLike, *, variable: str | Symbol | None = None
) -> int | None:
    r"""Count the common roots of two polynomials, with multiplicity.

    .. math:: \deg\gcd(a, b) = k + l - \mathrm{rank}\,\mathcal M_1(a, b)

    Parameters
    ----------
    a, b : polynomial
        One of them may be zero: then all roots of the other count.
    variable : str or Symbol, optional
        Default: evident from the two together; lists show none.

    Returns
    -------
    int or None
        None if it depends on the values of symbols; :func:`exceptional_cases` tells on which.

    Raises
    ------
    InputError
        If the coefficient a_k of the formal degree is zero: if also b_l = 0, the rank would count
        a common root at infinity, as for 0 s**2 + s + 1 and 0 s + 5.

    Notes
    -----
    For rational coefficients the degree of the greatest common divisor is computed, which is faster
    than the rank of the matrix, and with symbols the determinant, then subresultants. Source:
    Theorem A1, whose hypothesis :math:`l \le k` is not needed (and is not met by Example B.2);
    "number" is to be read with multiplicity.

    Examples
    --------
    >>> from compensator_theory.bezout import number_of_common_roots
    >>> number_of_common_roots("(s + 1)**2*(s + 2)", "(s + 1)**3*(s - 7)*s")
    2
    >>> number_of_common_roots("(s + a)*(s + 2)", "(s + a)*(s + 3)", variable="s")
    1
    """
    if (pair := _flint_pair_of(a, b, variable)) is not None:
        return int(pair[0].gcd(pair[1]).degree())
    first, second = _with_leading(*with_formal_degrees(a, b, variable))
    if is_rational(first[0]) and is_rational(second[0]):
        return int(to_flint_polynomial(first[0]).gcd(to_flint_polynomial(second[0])).degree())
    whole = _determinant(first, second)
    if whole != 0:
        return 0 if whole.is_nonzero else None
    return _number_for_all_values(first[0], second[0])


@carrying()
def resultant(
    a: PolynomialLike, b: PolynomialLike, *, variable: str | Symbol | None = None
) -> Expr:
    r"""Return the resultant :math:`\det\mathcal M_1(a, b)`, 0 iff a and b share a root.

    Parameters
    ----------
    a, b : polynomial
        As for :func:`number_of_common_roots`, same condition on a_k.
    variable : str or Symbol, optional
        Default: evident from the two together; lists show none.

    Raises
    ------
    InputError
        If the leading coefficient of a is zero.

    Notes
    -----
    Source: Theorem A1. For true degrees it is SymPy's ``resultant(a, b)``, except that SymPy
    (1.14, issue 10666) loses the sign if k < l are both odd.

    Examples
    --------
    >>> from compensator_theory import resultant
    >>> resultant("s + 1", "s + 2"), resultant("s + a", "s + b")
    (1, -a + b)
    """
    if (pair := _flint_pair_of(a, b, variable)) is not None:
        return rational(pair[0].resultant(pair[1]))
    first, second = _with_leading(*with_formal_degrees(a, b, variable))
    if first[1] == 0:  # a constant has no root, that of 0 either
        return first[0].LC() ** second[1]
    if not (is_rational(first[0]) and is_rational(second[0])):
        return _determinant(first, second)
    lacking = second[1] - (0 if second[0].is_zero else int(second[0].degree()))
    p, q = to_flint_polynomial(first[0]), to_flint_polynomial(second[0])
    return rational(p.coeffs()[-1] ** lacking * p.resultant(q))


@generic_answer_of(resultant)
def _generic_resultant(
    a: PolynomialLike, b: PolynomialLike, *, variable: str | Symbol | None = None
) -> tuple[Expr, list[Expr]]:
    """Return the resultant and its condition: the degrees must not drop."""
    (p, _), _ = _with_leading(*with_formal_degrees(a, b, variable))
    return resultant(a, b, variable=variable), [p.LC()]


@generic_answer_of(number_of_common_roots)
def _generic_number(
    a: PolynomialLike, b: PolynomialLike, *, variable: str | Symbol | None = None
) -> tuple[int, list[Expr]]:
    """Count by the first principal subresultant coefficient that is not zero."""
    (first, _), (second, _) = _with_leading(*with_formal_degrees(a, b, variable))
    if second.is_zero:
        return int(first.degree()), [first.LC()]
    upper, lower = (first, second) if first.degree() >= second.degree() else (second, first)
    principal = subresultants(upper, lower).principal_coefficients
    count = next(k for k, coefficient in enumerate(principal) if coefficient != 0)
    return count, [principal[count], first.LC()]


def _flint_pair_of(
    a: PolynomialLike, b: PolynomialLike, variable: str | Symbol | None
) -> tuple[flint.fmpq_poly, flint.fmpq_poly] | None:
    """Return python-flint polynomials at their true degrees; None if they are not read yet."""
    pair = flint_polynomial_pair(a, b) if variable is None else None
    if pair is None or not pair[0] or not pair[1]:
        return None
    ask("degree", max(pair[0].degree(), pair[1].degree()), "the polynomial")
    return pair


def _determinant(first: tuple[Poly, int], second: tuple[Poly, int]) -> Expr:
    if first[1] == second[1] == 0:
        return sympy.Integer(1)
    if all(int(p.degree()) == degree for p, degree in (first, second) if not p.is_zero):
        value = _by_flint(first[0], second[0])
        if value is not None:
            return value
    both = (formal_coefficients(*pair) for pair in (first, second))
    return determinant(matrix_of_coefficients(*both))


def _by_flint(a: Poly, b: Poly) -> Expr | None:
    """Return the resultant of polynomials whose coefficients are polynomials in symbols over QQ."""
    if a.is_zero or b.is_zero:
        return None
    domain = flint_domain(a, b)
    if domain is None:
        return None
    first, second = to_flint(domain, a, b)
    terms = {
        tuple(map(int, powers)): rational(c)
        for (_, *powers), c in first.resultant(second, "x0").to_dict().items()
    }
    return expr_from_dict(terms, *domain.symbols)


def _with_leading(first: Formal, second: Formal) -> tuple[Formal, Formal]:
    """Refuse a polynomial a whose formal leading coefficient is 0, unless b has it."""
    if first[0].is_zero and first[1] == 0:
        first, second = second, first
    poly, degree = first
    if poly.is_zero:
        raise InputError("a and b are both zero, so that every number is a common root")
    if poly.degree() < degree:
        raise InputError(
            "the leading coefficient of a (of b, where a = 0) is zero; drop its leading zeros"
        )
    return first, second


def _number_for_all_values(a: Poly, b: Poly) -> int | None:
    """Count by subresultants: the number of principal coefficients that vanish identically."""
    if not a.LC().is_nonzero:  # its degree depends on the values
        return None
    if b.is_zero:
        return int(a.degree())
    upper, lower = (a, b) if a.degree() >= b.degree() else (b, a)
    principal = subresultants(upper, lower).principal_coefficients
    count = next(k for k, coefficient in enumerate(principal) if coefficient != 0)
    return count if principal[count].is_nonzero else None
