"""The contribution of one irreducible factor of the denominator to a response in time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import factorial

import sympy
from sympy import Expr, Poly, Symbol

from compensator_theory._latex import displayed, latex
from compensator_theory.matrices._quotients_modulo import quotient_modulo
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import over_coefficient_field
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.roots._closed_forms import completed_square, root_of_square


@dataclass(frozen=True)
class Mode(ExactValue):
    r"""The part of a response that belongs to the roots of one irreducible factor.

    .. math:: \sum_{r:\,p(r) = 0} \sum_{j=1}^m c_j(r)\,\varphi_j(r), \qquad
              \varphi_j = \frac{t^{j-1}}{(j-1)!}\,e^{rt} \quad\text{or}\quad
              \varphi_j = \binom{k}{j-1} r^{k-j+1}

    Attributes
    ----------
    factor : sympy.Poly
        p, monic and irreducible over the field of the coefficients.
    coefficients : tuple of sympy.Poly
        c_1, ..., c_m, of lower degree than p, in the variable of p; m is the multiplicity.

    Examples
    --------
    >>> from compensator_theory import step_response
    >>> step_response("1/(s + 2)").terms[1].coefficients
    (Poly(-1/2, s, domain='QQ'),)
    """

    factor: Poly
    coefficients: tuple[Poly, ...]

    @property
    def transform(self) -> tuple[Poly, Poly]:
        r"""Numerator and denominator of the sum of all c_j(r)/(s - r)^j.

        From :math:`\sum_r c(r)/(s - r) = (c p' \bmod p)/p`, differentiated j - 1 times.
        """
        p, slope = self.factor, self.factor.diff()
        size = len(self.coefficients)
        numerator = Poly(0, p.gen, domain=p.domain)
        for j, c in enumerate(self.coefficients, start=1):
            top = (c * slope).rem(p)
            for k in range(1, j):  # -d/ds of top/p**k, over k
                top = (top * slope * k - top.diff() * p).quo_ground(k)
            numerator += top * p ** (size - j)
        return numerator, p**size

    def __str__(self) -> str:
        written = ", ".join(map(format_polynomial, self.coefficients))
        return f"roots of {format_polynomial(self.factor)}: {written}"

    def _repr_latex_(self) -> str:
        return displayed(rf"{latex(self.factor)} = 0", latex(self.coefficients))

    def expression(self, time: Symbol, *, is_discrete: bool) -> Expr:
        """Return the closed form in t or k, real where the coefficients are."""
        write = _discrete_terms if is_discrete else _continuous_terms
        return write(self.factor, self.coefficients, time)


def _continuous_terms(p: Poly, coefficients: Sequence[Poly], t: Symbol) -> Expr:
    """Return the sum of c_j(r) t^(j-1)/(j-1)! e^(rt) over the roots r."""
    return sympy.Add(
        *(
            _exponentials(p, c, t) * t**j / factorial(j)
            for j, c in enumerate(coefficients)
            if not c.is_zero
        )
    )


def _discrete_terms(p: Poly, coefficients: Sequence[Poly], k: Symbol) -> Expr:
    """Return the sum of c_j(r) binomial(k, j - 1) r^(k-j+1) over the roots r."""
    parts = []
    inverse = Poly(1, p.gen, domain="QQ")
    for j, c in enumerate(coefficients):
        if p.degree() == 1 and p.TC() == 0:  # r = 0: one sample
            parts.append(c.as_expr() * sympy.KroneckerDelta(k, j))
            continue
        if j:  # r^(k-j+1) = r^k r^(1-j)
            x = Poly(p.gen, p.gen, domain="QQ")
            factor, top, bottom = over_coefficient_field(p, inverse, x)
            inverse = quotient_modulo(factor, top, bottom)
        value = (c * inverse).rem(p)
        if not value.is_zero:
            binomial = sympy.Mul(*(k - i for i in range(j))) / factorial(j)
            parts.append(_powers(p, value, k) * binomial)
    return sympy.Add(*parts)


def _exponentials(p: Poly, c: Poly, t: Symbol) -> Expr:
    """Return the sum of c(r) e^(rt) over the roots of p."""
    if p.degree() == 1:
        return _in_short(c.as_expr()) * sympy.exp(-p.TC() * t)
    if p.degree() > 2:
        return _root_sum(p, c, lambda r: sympy.exp(r * t))
    centre, square = completed_square(p)
    if square.is_positive:
        return sympy.Add(*(a * sympy.exp(r * t) for a, r in _pair(c, centre, square)))
    even, odd = _even_and_odd(c, centre, square)
    w = root_of_square(-square)
    decay = sympy.exp(centre * t)
    return 2 * even * decay * sympy.cos(w * t) + 2 * odd / w * decay * sympy.sin(w * t)


def _powers(p: Poly, c: Poly, k: Symbol) -> Expr:
    """Return the sum of c(r) r^k over the roots of p."""
    if p.degree() == 1:
        return _in_short(c.as_expr()) * (-p.TC()) ** k
    if p.degree() > 2:
        return _root_sum(p, c, lambda r: r**k)
    centre, square = completed_square(p)
    if not square.is_negative:
        return sympy.Add(*(a * r**k for a, r in _pair(c, centre, square)))
    even, odd = _even_and_odd(c, centre, square)
    w, modulus = sympy.sqrt(-square), sympy.sqrt(p.TC())
    angle = sympy.acos(centre / modulus) * k
    return 2 * even * modulus**k * sympy.cos(angle) + (2 * odd / w * modulus**k * sympy.sin(angle))


def _pair(c: Poly, centre: Expr, square: Expr) -> list[tuple[Expr, Expr]]:
    """Return c(r) and r for the two roots of (s - centre)**2 - square."""
    even, odd = _even_and_odd(c, centre, square)
    root = root_of_square(square)
    return [(even + sign * odd / root, centre + sign * root) for sign in (1, -1)]


def _even_and_odd(c: Poly, centre: Expr, square: Expr) -> tuple[Expr, Expr]:
    """Return e and o of c(r) = e + o/d, for r = centre + d and d**2 = square."""
    u, v = c.coeff_monomial(1), c.coeff_monomial(c.gen)
    return _in_short(u + v * centre), _in_short(v * square)


def _root_sum(p: Poly, c: Poly, function: Callable[[Expr], Expr]) -> Expr:
    """Return a sum over the roots of a factor of degree three or more, as SymPy's RootSum."""
    x = p.gen
    return sympy.RootSum(p, sympy.Lambda(x, c.as_expr() * function(x)), auto=False)


def _in_short(coefficient: Expr) -> Expr:
    return sympy.factor(coefficient) if coefficient.free_symbols else coefficient
