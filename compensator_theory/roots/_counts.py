"""How many roots are real and how many stable: Sturm and Routh, exactly."""

from __future__ import annotations

from itertools import pairwise

import flint
import sympy
from sympy import Expr, Poly, Symbol

from compensator_theory.errors import InputError
from compensator_theory.matrices._flint_polynomials import (
    from_flint_polynomial,
    to_flint_polynomial,
)
from compensator_theory.polynomials._ball_precision import ball_precision
from compensator_theory.polynomials._carrying import carried_by, refusing
from compensator_theory.polynomials._complex_polynomials import complex_parts, norm_of
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import is_rational, way_to_rational
from compensator_theory.polynomials._reading import (
    PolynomialLike,
    PolynomialOrSystem,
    polynomial,
    polynomial_in_time,
)
from compensator_theory.polynomials._variables import Time
from compensator_theory.roots._descartes import distinct_real_roots
from compensator_theory.roots._independent_numbers import polynomial_with_exponentials
from compensator_theory.roots._root_counts import RootCount

PRECISIONS = (256, 1024, 4096, 16384)
"""Precisions in bits for Routh's array; if none suffices, a row is nearly singular."""

ONE_PLUS, ONE_MINUS = flint.fmpq_poly([1, 1]), flint.fmpq_poly([1, -1])


@refusing
def number_of_real_roots(poly: PolynomialLike, variable: str | Symbol | None = None) -> int:
    r"""Count the real roots with multiplicity by Descartes' rule of signs, or Sturm's theorem.

    Parameters
    ----------
    poly : polynomial
        Rational coefficients, not zero.
    variable : str or Symbol, optional
        Default: evident; a list of coefficients shows none.

    Raises
    ------
    InputError
        If the polynomial is zero or has symbolic coefficients.

    Notes
    -----
    Both count distinct roots; they are applied to each square-free factor. Bisection by Descartes'
    rule takes about as many Taylor shifts as there are real roots; only where two roots almost
    coincide does Sturm's chain take less. Theorem 1 needs the count with multiplicity:
    :math:`(s+1)^2(s^2+1)^2` has two real roots and not one. The flags ``is_real`` of
    :func:`certified_roots` give the same number by another way.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.roots import number_of_real_roots
    >>> number_of_real_roots(polynomial("(s + 1)**2*(s**2 + 1)**2"))
    2
    """
    return _real_roots(to_flint_polynomial(require_rational(polynomial(poly, variable))).numer())


def has_real_root(poly: Poly) -> bool | None:
    """Tell whether a monic real polynomial has a real root; None if symbols decide.

    Symbols stand for real numbers. A factor of odd degree has a real root whatever they are.
    """
    if is_rational(poly):
        return number_of_real_roots(poly) > 0
    factors = [factor for factor, _ in poly.factor_list()[1]]
    if any(factor.degree() % 2 for factor in factors):
        return True
    real = {
        symbol: sympy.Dummy(symbol.name, real=True)
        for symbol in poly.free_symbols_in_domain
        if symbol.is_real is None  # otherwise it keeps assumptions such as its sign
    }
    signs = [
        _is_nonnegative(sympy.sympify(f.discriminant()).xreplace(real)) if f.degree() == 2 else None
        for f in factors
    ]
    return True if True in signs else False if set(signs) == {False} else None


def _is_nonnegative(value: Expr) -> bool | None:
    """Tell the sign of a value, False for negative; a quadratic without real roots keeps one."""
    if (known := sympy.factor(value).is_nonnegative) is not None:
        return bool(known)
    for symbol in value.free_symbols:
        if not (value.is_polynomial(symbol) and sympy.degree(value, symbol) == 2):
            continue
        quadratic = Poly(value, symbol)
        discriminant = sympy.expand(quadratic.discriminant())
        if quadratic.LC().is_positive and _is_nonnegative(-discriminant):
            return True
        if quadratic.LC().is_negative and _is_nonnegative(discriminant) is False:
            return False
    return None


@carried_by("none")
def count_roots(
    poly: PolynomialOrSystem, variable: str | Symbol | None = None, *, time: Time | None = None
) -> RootCount:
    r"""Count the stable roots, those on the boundary of stability and the unstable ones, exactly.

    .. math:: I_{-\infty}^{+\infty}
              \frac{a_{n-1}\omega^{n-1} - a_{n-3}\omega^{n-3} + \cdots}
                   {a_n\omega^n - a_{n-2}\omega^{n-2} + \cdots}
              = \#\mathrm{left} - \#\mathrm{right}, \qquad z = \frac{1 + s}{1 - s}

    Parameters
    ----------
    poly : polynomial, or a Realisation or TransferFunction
        Rational coefficients, not zero.
    time : {"continuous", "discrete"}, optional
        Whether stable means left of the imaginary axis, or inside the unit circle; default as for
        :func:`decide_stability`.
    variable : str or Symbol, optional
        Default: evident; of a list of coefficients s, in discrete time q.

    Raises
    ------
    InputError
        If the polynomial is zero or has symbolic coefficients, or `time` is missing or not that
        of the variable.

    Notes
    -----
    The Cauchy index I is read off the Sturm chain of the two polynomials. Where Routh's array is
    regular the chain is the array; where a first element vanishes the chain drops a degree, and
    where a row vanishes it ends with the factor whose roots are symmetric about 0. So no case is
    singular: the roots on the axis are the real roots of that last element. The exact numbers of
    the chain are long, so that the factor with the symmetric roots is taken out first, and the
    array of the remaining polynomial computed in balls, which decide where it is regular.
    In discrete time the roots of :math:`(1-s)^k a((1+s)/(1-s))` are counted; the degree that it
    lacks is the multiplicity of the root -1.

    Examples
    --------
    >>> from compensator_theory import count_roots
    >>> print(count_roots("s**4 + s**3 + 2*s**2 + 2*s + 5"))
    2 stable, 0 on the boundary, 2 unstable
    >>> print(count_roots("q*(q + 1)**2*(q - 3)"))
    1 stable, 2 on the boundary, 1 unstable
    """
    if (rewritten := polynomial_with_exponentials(poly, variable, time)) is not None:
        written, domain, numbers = rewritten
        return numbers.count(written, domain)
    if (parts := complex_parts(poly, variable, time)) is not None:
        both = _count_rational(norm_of(parts), None, time)
        return RootCount(both.stable // 2, both.boundary // 2, both.unstable // 2)
    return _count_rational(poly, variable, time)


@refusing
def _count_rational(
    poly: PolynomialOrSystem, variable: str | Symbol | None, time: Time | None
) -> RootCount:
    """Count the roots of a rational polynomial."""
    poly, time = polynomial_in_time(poly, time, variable)
    poly = require_rational(poly)
    degree = int(poly.degree())
    if time == "discrete":
        poly = half_plane_image(poly, degree)
    whole = to_flint_polynomial(poly).numer()
    counts = _count_in_balls(whole)
    if counts is None:
        counts = _count_by_chain(whole)
    return RootCount(counts.stable, counts.boundary + degree - counts.total, counts.unstable)


def half_plane_image(poly: Poly, size: int) -> Poly:
    """Return (1 - s)^k p((1 + s)/(1 - s)) of a rational polynomial of at most degree k = `size`."""
    ascending = to_flint_polynomial(poly).coeffs()
    image, power = flint.fmpq_poly([]), flint.fmpq_poly([1])
    for coefficient in [0] * (size + 1 - len(ascending)) + ascending[::-1]:
        image = image * ONE_PLUS + power * coefficient  # Horner's scheme, made homogeneous
        power = power * ONE_MINUS
    return from_flint_polynomial(image, poly.gen)


def routh_chain(poly: flint.fmpz_poly) -> list[flint.fmpz_poly]:
    """Return the rows of the generalised Routh array as polynomials in the frequency.

    Each is scaled by a positive number; the last is the greatest common divisor of the first two.
    """
    signed = [c * (-1) ** (k // 2) for k, c in enumerate(poly.coeffs()[::-1])]
    first, second = (
        flint.fmpz_poly([c if k % 2 == parity else 0 for k, c in enumerate(signed)][::-1])
        for parity in (0, 1)
    )
    return _sturm_chain(first, second)


def require_rational(poly: PolynomialLike) -> Poly:
    """Return a rational polynomial in canonical form; refuse zero and polynomials with symbols."""
    poly = polynomial(poly)
    if not is_rational(poly):
        raise InputError(
            f"the roots of {format_polynomial(poly)} cannot be counted: its coefficients are not "
            f"all rational numbers; {way_to_rational(poly)}"
        )
    if poly.is_zero:
        raise InputError("every number is a root of the zero polynomial")
    return poly


def _count_by_chain(poly: flint.fmpz_poly) -> RootCount:
    chain = routh_chain(poly)
    difference = _variations(chain, -1) - _variations(chain, +1)
    boundary, degree = _real_roots(chain[-1]), int(poly.degree())
    unstable = (degree - boundary - difference) // 2
    return RootCount(degree - boundary - unstable, boundary, unstable)


def _count_in_balls(poly: flint.fmpz_poly) -> RootCount | None:
    mirrored = flint.fmpz_poly([-c if k % 2 else c for k, c in enumerate(poly.coeffs())])
    symmetric = poly.gcd(mirrored)
    unstable = _unstable_in_balls(poly // symmetric)
    if unstable is None:
        return None
    boundary = 0
    if symmetric.degree() > 0:
        boundary = _real_roots(routh_chain(symmetric)[-1])
        unstable += (int(symmetric.degree()) - boundary) // 2
    return RootCount(int(poly.degree()) - boundary - unstable, boundary, unstable)


def _unstable_in_balls(poly: flint.fmpz_poly) -> int | None:
    """Count sign changes in the first column of Routh's array; None if balls do not decide."""
    descending = poly.coeffs()[::-1]
    for precision in PRECISIONS:
        with ball_precision(precision):
            signs = _first_column(descending)
        if signs is not None:
            return sum(a != b for a, b in pairwise(signs))
    return None


def _first_column(descending: list[flint.fmpz]) -> list[bool] | None:
    row, following = (flint.arb_poly(descending[parity::2]) for parity in (0, 1))
    signs = []
    for _ in descending:
        head = row[0]
        if not (head > 0 or head < 0):
            return None
        signs.append(bool(head > 0))
        rest = row - following * (head / following[0]) if following.length() else row
        row, following = following, flint.arb_poly(rest.coeffs()[1:])
    return signs


def _real_roots(poly: flint.fmpz_poly) -> int:
    """Count the real roots with multiplicity."""
    _, factors = poly.factor_squarefree()
    return sum(int(m) * _distinct_real_roots(factor) for factor, m in factors)


def _distinct_real_roots(factor: flint.fmpz_poly) -> int:
    if (roots := distinct_real_roots(factor)) is not None:
        return roots
    chain = _sturm_chain(factor, factor.derivative())
    return _variations(chain, -1) - _variations(chain, +1)


def _sturm_chain(first: flint.fmpz_poly, second: flint.fmpz_poly) -> list[flint.fmpz_poly]:
    chain, following = [first], second
    while following:
        chain.append(following // following.content())  # short, and of the same sign
        rest = flint.fmpq_poly(chain[-2]) % flint.fmpq_poly(chain[-1])
        following = -rest.numer()
    return chain


def _variations(chain: list[flint.fmpz_poly], side: int) -> int:
    """Count the changes of sign along the chain at plus or minus infinity."""
    signs = [p.leading_coefficient() * side ** int(p.degree()) > 0 for p in chain]
    return sum(a != b for a, b in pairwise(signs))
