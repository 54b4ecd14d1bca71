"""Whether all roots are inside the unit circle, by arithmetic on the coefficients."""

from __future__ import annotations

import flint
from sympy import QQ, Expr, Poly, Symbol

from compensator_theory.polynomials._ball_precision import ball_precision
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._polynomial_objects import in_our_order
from compensator_theory.polynomials._reading import PolynomialLike, is_list, polynomial
from compensator_theory.roots._counts import require_rational
from compensator_theory.roots._regions import locate_roots

PRECISIONS = (128, 512, 2048, 8192)  # bits; a polynomial of degree n needs about n of them at most


@refusing
def reflection_coefficients(
    poly: PolynomialLike, variable: str | Symbol | None = None
) -> tuple[Expr, ...]:
    r"""Return the numbers of Schur and Cohn, as far as they decide.

    .. math:: k_j = \frac{a_j(0)}{\mathrm{lc}(a_j)}, \qquad
              a_{j-1}(z) = \frac{a_j(z) - k_j\, a_j^*(z)}{z}

    Parameters
    ----------
    poly : polynomial
        Rational coefficients, degree n.
    variable : str or Symbol, optional
        Default: evident; a list of coefficients is one in q.

    Returns
    -------
    tuple of sympy.Rational
        :math:`k_n, k_{n-1}, \ldots`; all n of them if every modulus is below 1, which says that
        every root is inside the unit circle. Otherwise the last one has a modulus of 1 or more,
        and some root is not inside.

    Raises
    ------
    InputError
        If the polynomial is zero or has symbolic coefficients.

    Notes
    -----
    This is Jury's table, divided by its leading elements. A polynomial of degree j is Schur if
    and only if :math:`|k_j| < 1` and the next one is Schur, so no case is singular.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.roots import reflection_coefficients
    >>> reflection_coefficients(polynomial("z**2 - z/2 + 1/4"))
    (1/4, -2/5)
    >>> reflection_coefficients(polynomial("z**2 - 3*z + 2"))
    (2,)
    """
    read = in_our_order(poly)
    poly = require_rational(
        polynomial(read, "q" if variable is None and is_list(read) else variable)
    )
    ring = poly.domain
    row = [ring.convert(c) for c in poly.rep.to_list()]
    coefficients = []
    while len(row) > 1:
        k = row[-1] / row[0]
        coefficients.append(ring.to_sympy(k))
        if abs(k) >= 1:
            break
        row = [a - k * b for a, b in zip(row[:-1], row[:0:-1], strict=True)]
    return tuple(coefficients)


def has_root_outside(poly: Poly) -> bool:
    r"""Tell whether a root lies outside the unit circle, also of polynomials of high degree.

    Notes
    -----
    Exact, in about :math:`n^2` operations. Common factors with the reciprocal polynomial
    :math:`a^*` are separated: g, the greatest of them, has all its roots on the circle if and only
    if its derivative has none outside (Cohn). What remains has no root on the circle, so the
    numbers of :func:`reflection_coefficients` decide in ball arithmetic; where one of them has a
    modulus of exactly 1 no ball can, and :func:`locate_roots` does.
    """
    _, cleared = canonical(require_rational(poly)).clear_denoms(convert=True)
    rest = flint.fmpz_poly([int(c) for c in reversed(cleared.all_coeffs())])
    while rest.degree() > 0:
        ascending = [int(c) for c in rest.coeffs()]
        start = next(i for i, c in enumerate(ascending) if c)  # roots at the origin
        rest = flint.fmpz_poly(ascending[start:])
        common = rest.gcd(flint.fmpz_poly(ascending[start:][::-1]))
        other = rest // common
        if abs(other[0]) > abs(other[other.degree()]) or not _is_schur(other):
            return True
        rest = common.derivative()
    return False


def _is_schur(poly: flint.fmpz_poly) -> bool:
    """Whether every root is inside, where none is on the circle."""
    descending = [int(c) for c in reversed(poly.coeffs())]
    for precision in PRECISIONS:
        with ball_precision(precision):
            answer = _schur_in_balls([flint.arb(c) for c in descending])
        if answer is not None:
            return answer
    return locate_roots(Poly(descending, Symbol("z"), domain=QQ)).unstable == 0


def _schur_in_balls(row: list[flint.arb]) -> bool | None:
    """As `reflection_coefficients`, in balls; None if a ball does not decide."""
    while len(row) > 1:
        k = row[-1] / row[0]
        if not abs(k) < 1:
            return False if abs(k) > 1 else None
        row = [a - k * b for a, b in zip(row[:-1], row[:0:-1], strict=True)]
    return True
