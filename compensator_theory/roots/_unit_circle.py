"""Inside, on or outside the unit circle: decided exactly."""

from __future__ import annotations

import flint
from sympy import QQ, Poly, Symbol

from compensator_theory.errors import InputError, NoSolutionError, UnitCircleError
from compensator_theory.matrices._flint_polynomials import to_flint_polynomial
from compensator_theory.polynomials._budget import quoted
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._poly import (
    canonical,
    is_rational,
    monic,
    require_poly,
    way_to_rational,
)
from compensator_theory.polynomials._reading import PolynomialLike, polynomial
from compensator_theory.roots._certified import decided_balls
from compensator_theory.roots._descartes import distinct_positive_roots


@refusing
def split_at_unit_circle(
    poly: PolynomialLike, variable: str | Symbol | None = None
) -> tuple[Poly, Poly]:
    r"""Split a rational polynomial at the unit circle into two monic rational factors.

    .. math:: N = N_k\, N_s\, N_u, \qquad N_s(\lambda)=0 \Rightarrow |\lambda|<1, \qquad
              N_u(\lambda)=0 \Rightarrow |\lambda|>1

    Parameters
    ----------
    poly : polynomial
        Rational coefficients, not zero.
    variable : str or Symbol, optional
        Default: evident; a list of coefficients shows none.

    Returns
    -------
    tuple of sympy.Poly
        :math:`(N_s, N_u)`; the leading coefficient of `poly` is left out.

    Raises
    ------
    UnitCircleError
        If a root has modulus exactly 1; the message names the irreducible factor.
    NoSolutionError
        If an irreducible factor has roots on both sides, so that the split is not rational.
    InputError
        If the polynomial is zero or has symbolic coefficients.

    Notes
    -----
    No tolerance is involved. An irreducible factor with a root on the circle is its own reciprocal
    up to sign; for such a factor :math:`\lambda + 1/\lambda` satisfies a polynomial of half the
    degree, whose roots in :math:`[-2, 2]` are counted by Descartes' rule of signs. Roots of every
    other factor are off the circle, so that balls of growing precision decide.

    Source: the factors N_zu,s and N_zu,u of Section 2.3 and (4.39).

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.roots import split_at_unit_circle
    >>> stable, unstable = split_at_unit_circle(polynomial("3*q*(q - 1/2)*(q - 2)"))
    >>> stable.as_expr(), unstable.as_expr()
    (q**2 - q/2, q - 2)
    """
    poly = polynomial(poly, variable)
    if not is_rational(poly):
        raise InputError(
            f"{quoted(poly)} has coefficients that are not rational numbers, so its roots cannot "
            f"be located; {way_to_rational(poly)}"
        )
    if poly.is_zero:
        raise InputError("the zero polynomial cannot be split at the unit circle")
    inside = outside = poly.one
    for factor, multiplicity in poly.factor_list()[1]:
        if lies_inside(factor):
            inside *= monic(factor) ** multiplicity
        else:
            outside *= monic(factor) ** multiplicity
    return inside, outside


def lies_inside(factor: Poly) -> bool:
    """Tell whether an irreducible rational polynomial has all its roots inside the unit circle.

    Returns False if all are outside.
    """
    name = monic(factor).as_expr()
    mixed = NoSolutionError(
        f"the irreducible factor {name} has roots on both sides of the unit circle, so no rational "
        "factor contains exactly those inside; use enclose_split_at_unit_circle for certified balls"
    )
    require_none_on_circle(factor)
    if _is_self_reciprocal(factor):
        raise mixed
    inside = [within for _, _, within in decided_balls(factor, is_inside)]
    if any(inside) and not all(inside):
        raise mixed
    return all(inside)


def is_inside(ball: flint.acb) -> bool | None:
    """Tell whether a complex ball lies inside the unit circle; None if it meets the circle."""
    modulus = abs(ball)
    return True if modulus < 1 else False if modulus > 1 else None


def fold_palindrome(poly: Poly) -> Poly:
    r"""Return the polynomial in :math:`t = q + 1/q` that a palindromic polynomial is.

    .. math:: q^{-h} a(q) = b(q + 1/q), \qquad \deg a = 2h
    """
    poly = require_poly(poly)
    half = int(poly.degree()) // 2
    descending = poly.all_coeffs()[: half + 1]  # c_half, ..., c_0 of sum c_j (q^j + q^-j)
    t = poly.gen
    # q^j + q^-j as polynomials in t = q + 1/q
    chebyshev = [Poly(2, t, domain=QQ), Poly(t, t, domain=QQ)]
    while len(chebyshev) <= half:
        chebyshev.append(chebyshev[1] * chebyshev[-1] - chebyshev[-2])
    folded = Poly(descending[half], t, domain=QQ)
    for j in range(1, half + 1):
        folded += chebyshev[j].mul_ground(descending[half - j])
    return canonical(folded)


def require_none_on_circle(poly: Poly) -> None:
    """Refuse a rational polynomial with a root of modulus exactly 1."""
    for factor, _ in require_poly(poly).factor_list()[1]:
        if _is_self_reciprocal(factor) and _has_root_on_circle(factor):
            raise UnitCircleError(
                f"the factor {quoted(monic(factor))} has a root exactly on the unit circle; it "
                "belongs neither to the inside nor to the outside: move that root or treat it "
                "separately"
            )


def _is_self_reciprocal(factor: Poly) -> bool:
    coefficients = factor.all_coeffs()
    return coefficients in (coefficients[::-1], [-c for c in reversed(coefficients)])


def _has_root_on_circle(factor: Poly) -> bool:
    """Decide it for a factor that equals its reciprocal up to sign and is irreducible."""
    if factor.degree() == 1:
        return True  # q - 1 or q + 1
    folded = fold_palindrome(factor)
    # t = 2 (x - 1)/(x + 1) takes the positive x to those t between -2 and 2
    image, power, step = (flint.fmpz_poly(c) for c in ([], [1], [1, 1]))
    for coefficient in reversed(to_flint_polynomial(folded).numer().coeffs()):
        image, power = image * flint.fmpz_poly([-2, 2]) + coefficient * power, power * step
    if (roots := distinct_positive_roots(image)) is None:
        roots = int(folded.count_roots(-2, 2))
    return roots > 0
