"""How many roots are real and how many left of the imaginary axis: Sturm and Routh, exactly."""

from dataclasses import dataclass
from itertools import pairwise

from sympy import QQ, Poly

from compensator_theory.errors import InputError
from compensator_theory.polynomials.formatting import format_polynomial, shown
from compensator_theory.polynomials.poly import canonical, is_rational
from compensator_theory.polynomials.values import ExactValue


@dataclass(frozen=True)
class RootCount(ExactValue):
    """Numbers of roots with multiplicity on the two sides of a boundary and on it.

    Attributes
    ----------
    stable, boundary, unstable : int
        For the imaginary axis: real part below, equal to, above 0. For the unit circle: modulus
        below, equal to, above 1.

    Examples
    --------
    >>> from compensator_theory import count_half_plane_roots, polynomial
    >>> print(count_half_plane_roots(polynomial("(s + 1)*(s**2 + 1)**2")))
    1 stable, 4 on the boundary, 0 unstable
    """

    stable: int
    boundary: int
    unstable: int

    @property
    def total(self) -> int:
        """The degree."""
        return self.stable + self.boundary + self.unstable

    def __str__(self) -> str:
        return f"{self.stable} stable, {self.boundary} on the boundary, {self.unstable} unstable"


def number_of_real_roots(poly: Poly) -> int:
    r"""Count the real roots with multiplicity by Sturm's theorem.

    Parameters
    ----------
    poly : sympy.Poly
        Rational coefficients, not zero.

    Raises
    ------
    InputError
        If the polynomial is zero or has symbolic coefficients.

    Notes
    -----
    Sturm's theorem counts distinct roots; it is applied to each square-free factor. Theorem 1
    needs the count with multiplicity: :math:`(s+1)^2(s^2+1)^2` has two real roots and not one.
    The flags ``is_real`` of :func:`certified_roots` give the same number by another way.

    Examples
    --------
    >>> from compensator_theory import number_of_real_roots, polynomial
    >>> number_of_real_roots(polynomial("(s + 1)**2*(s**2 + 1)**2"))
    2
    """
    poly = require_rational(poly)
    return sum(m * _distinct_real_roots(factor) for factor, m in poly.sqf_list()[1])


def count_half_plane_roots(poly: Poly) -> RootCount:
    r"""Count the roots left of, on and right of the imaginary axis by the Routh-Hurwitz theorem.

    .. math:: I_{-\infty}^{+\infty}
              \frac{a_{n-1}\omega^{n-1} - a_{n-3}\omega^{n-3} + \cdots}
                   {a_n\omega^n - a_{n-2}\omega^{n-2} + \cdots}
              = \#\mathrm{left} - \#\mathrm{right}

    Parameters
    ----------
    poly : sympy.Poly
        Rational coefficients, not zero.

    Raises
    ------
    InputError
        If the polynomial is zero or has symbolic coefficients.

    Notes
    -----
    The Cauchy index I is read off the Sturm chain of the two polynomials. Where Routh's array is
    regular the chain is the array; where a first element vanishes the chain drops a degree, and
    where a row vanishes it ends with the factor whose roots are symmetric about 0. So no case is
    singular: the roots on the axis are the real roots of that last element.

    Examples
    --------
    >>> from compensator_theory import count_half_plane_roots, polynomial
    >>> print(count_half_plane_roots(polynomial("s**4 + s**3 + 2*s**2 + 2*s + 5")))
    2 stable, 0 on the boundary, 2 unstable
    """
    poly = require_rational(poly)
    chain = routh_chain(poly)
    difference = _variations(chain, -1) - _variations(chain, +1)
    boundary = number_of_real_roots(chain[-1])
    degree = int(poly.degree())
    unstable = (degree - boundary - difference) // 2
    return RootCount(degree - boundary - unstable, boundary, unstable)


def routh_chain(poly: Poly) -> tuple[Poly, ...]:
    """Return the rows of the generalised Routh array as polynomials in the frequency.

    Each is scaled by a positive number; the last is the greatest common divisor of the first two.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.roots.counts import routh_chain
    >>> [str(p.as_expr()) for p in routh_chain(polynomial("s**3 + 2*s**2 + 3*s + 4"))]
    ['s**3 - 3*s', 's**2 - 2', 's', '1']
    """
    descending = require_rational(poly).all_coeffs()
    signed = [c * (-1) ** (k // 2) for k, c in enumerate(descending)]
    rows = [
        Poly([c if k % 2 == parity else 0 for k, c in enumerate(signed)], poly.gen, domain=QQ)
        for parity in (0, 1)
    ]
    return _sturm_chain(*rows)


def require_rational(poly: Poly) -> Poly:
    """Return a rational polynomial in canonical form; refuse zero and polynomials with symbols.

    Raises
    ------
    InputError
        With the reason.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.roots.counts import require_rational
    >>> require_rational(polynomial("s + 1/3"))
    Poly(s + 1/3, s, domain='QQ')
    """
    if not isinstance(poly, Poly):
        raise InputError(f"{shown(poly)} is not a sympy.Poly; make one with polynomial()")
    if not is_rational(poly):
        raise InputError(
            f"the roots of {format_polynomial(poly)} cannot be counted: its coefficients are not "
            "all rational numbers; substitute numbers for the symbols"
        )
    if poly.is_zero:
        raise InputError("every number is a root of the zero polynomial")
    return canonical(poly)


def _distinct_real_roots(poly: Poly) -> int:
    chain = _sturm_chain(poly, poly.diff())
    return _variations(chain, -1) - _variations(chain, +1)


def _sturm_chain(first: Poly, second: Poly) -> tuple[Poly, ...]:
    chain = [_positive_multiple(first)]
    following = _positive_multiple(second)
    while not following.is_zero:
        chain.append(following)
        following = _positive_multiple(-chain[-2].rem(chain[-1]))
    return tuple(chain)


def _positive_multiple(poly: Poly) -> Poly:
    """Keep the coefficients short; the primitive part keeps the sign."""
    if poly.is_zero:
        return poly
    return poly.mul_ground(1 / abs(poly.LC()))


def _variations(chain: tuple[Poly, ...], side: int) -> int:
    """Count the changes of sign along the chain at plus or minus infinity."""
    signs = [(1 if p.LC() > 0 else -1) * side ** int(p.degree()) for p in chain]
    return sum(a != b for a, b in pairwise(signs))
