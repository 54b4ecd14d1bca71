"""The Diophantine equation between polynomials: its least solution and all others."""

from __future__ import annotations

from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix, Matrix, Poly, Symbol
from sympy.polys.domains.domain import Domain

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.bezout._resultants import resultant
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.forms._polynomial_matrices import (
    PolynomialMatrix,
    denominators,
)
from compensator_theory.matrices._certificates import Certified, Residuals, proven
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._linear_algebra import solve
from compensator_theory.polynomials._budget import ask, repr_of
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._letters import fresh, names_in_all
from compensator_theory.polynomials._poly import (
    canonical,
    from_coefficients,
    monic,
    over_one_field,
    product,
    scaled,
    total,
)
from compensator_theory.polynomials._reading import (
    PolynomialLike,
    in_one_variable,
    is_one_of,
    polynomial,
)
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import require_no_other_operator


@dataclass(frozen=True)
class DiophantineSolution(Certified, ExactValue):
    r"""Every solution of a x + b y = c.

    .. math:: x + t\,\delta x, \quad y + t\,\delta y, \qquad
              \delta x = b/g, \quad \delta y = -a/g, \quad g = \gcd(a, b)

    Attributes
    ----------
    a, b, c : sympy.Poly
        As given.
    x, y : sympy.Poly
        The unique solution of least degree in the requested unknown.
    dx, dy : sympy.Poly
        The solution of the homogeneous equation, whose polynomial multiples are all of them.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; where none of them is zero the identities hold and
        there are no other solutions. :func:`exceptional_cases` gives the other cases.
    """

    _CARRIES = True

    identity = "a x + b y = c, a dx + b dy = 0"

    a: Poly
    b: Poly
    c: Poly
    x: Poly
    y: Poly
    dx: Poly
    dy: Poly
    exceptional: tuple[Expr, ...]

    def _residuals(self) -> Residuals:
        a, b = self.a, self.b
        return [
            total(product(a, self.x), product(b, self.y), -self.c),
            total(product(a, self.dx), product(b, self.dy)),
        ]

    def member(self, t: PolynomialLike) -> tuple[Poly, Poly]:
        """Return the solution (x + t dx, y + t dy) for any polynomial t."""
        factor = polynomial(t, self.a.gen)
        require_no_other_operator(factor)
        return canonical(self.x + factor * self.dx), canonical(self.y + factor * self.dy)

    def _letters(self) -> list[Symbol]:
        """The unknowns x, y and the free polynomial t, distinct from the input's symbols."""
        names = names_in_all(self)
        return [fresh(names, name) for name in "xyt"]

    def __str__(self) -> str:
        x, dx, y, dy = (format_polynomial(p) for p in (self.x, self.dx, self.y, self.dy))
        first, second, t = self._letters()
        return f"{first} = {x} + {t}*({dx}), {second} = {y} + {t}*({dy})"

    def _repr_latex_(self) -> str:
        first, second, t = map(latex, self._letters())
        x = rf"{first} = {latex(self.x)} + {t} \left({latex(self.dx)}\right)"
        y = rf"{second} = {latex(self.y)} + {t} \left({latex(self.dy)}\right)"
        return displayed(x, y, unless(self.exceptional))


@carrying()
def solve_diophantine(
    a: PolynomialLike,
    b: PolynomialLike,
    c: PolynomialLike,
    *,
    least: str = "y",
    variable: str | Symbol | None = None,
) -> DiophantineSolution:
    r"""Solve a x + b y = c for polynomials x and y.

    .. math:: a x + b y = c, \qquad \deg y < \deg(a/g) \quad\text{or}\quad \deg x < \deg(b/g)

    Parameters
    ----------
    a, b, c : polynomial
        Anything :func:`polynomial` reads, in one variable; a and b are not zero. With symbols, for
        generic values of them.
    variable : str or Symbol, optional
        Default: evident from the three together.
    least : {"y", "x"}
        Which unknown gets the least degree. With the plant's denominator as a and its numerator
        as b, "y" is the numerator of the compensator.

    Raises
    ------
    NoSolutionError
        If the greatest common divisor of a and b does not divide c; the message names it.
    InputError
        If a or b is zero, or the variable is not evident.

    Notes
    -----
    Solved as linear equations for the coefficients: Euclid's algorithm is slower with symbols, and
    its numbers grow where both have many small integer roots. Source: V. Kucera, Discrete Linear
    Control: The Polynomial Equation Approach (1979).

    Examples
    --------
    >>> from compensator_theory import solve_diophantine
    >>> solution = solve_diophantine("s**2 - 1", "s - 2", "(s + 1)**3")
    >>> print(solution)
    x = s + 7 + t*(s - 2), y = -4*s - 4 + t*(-s**2 + 1)
    >>> solution.member("s")[0]
    Poly(s**2 - s + 7, s, domain='QQ')
    """
    if not is_one_of(least, ("x", "y")):
        raise InputError(f"least = {repr_of(least)} must be 'x' or 'y'")
    first, second, right = in_one_variable(a, b, c, variable=variable)
    for name, side in (("a", first), ("b", second)):
        if side.is_zero:
            raise InputError(f"{name} is zero; the equation is a division, and has one unknown")
    ask("degree", int(first.degree() + second.degree() + max(right.degree(), 0)), "the equation")
    first, second, right = over_one_field(first, second, right)
    one, two = (first, second) if least == "y" else (second, first)
    over = [p.set_domain(_field(one, two, right)) for p in (one, two, right)]
    g = monic(canonical(over[0].gcd(over[1])))
    divisor = g.set_domain(over[0].domain)
    rest = canonical(over[2].rem(divisor))
    if not rest.is_zero:
        raise NoSolutionError(
            f"a and b share the factor {format_polynomial(g)}, which does not divide "
            f"{format_polynomial(right)}; no polynomials x and y solve the equation"
        ).holding(rest.all_coeffs(), denominators(PolynomialMatrix(((g, rest),))))
    p, q, r = (canonical(side.quo(divisor)) for side in over)
    u, v = _least(p, q, r)
    x, y, dx, dy = (u, v, q, -p) if least == "y" else (v, u, p, -q)
    divisors = denominators(PolynomialMatrix(((g, x, y, dx, dy),)))
    if any(side.free_symbols_in_domain for side in (p, q)):
        divisors.append(resultant(p, q, variable=first.gen))
    exceptional = exceptional_factors(divisors)
    result = DiophantineSolution(first, second, right, x, y, dx, dy, exceptional)
    proven(result.certificate, "solution")
    return result


def _field(*polys: Poly) -> Domain:
    domain = polys[0].domain
    for poly in polys[1:]:
        domain = domain.unify(poly.domain)
    return domain.get_field()


def _least(p: Poly, q: Poly, r: Poly) -> tuple[Poly, Poly]:
    """Return u and v with p u + q v = r and deg v < deg p, for coprime p and q."""
    s, k = p.gen, int(p.degree())
    degree = max(int(r.degree()) if not r.is_zero else 0, int(q.degree()) + k - 1, k)
    above = degree - k + 1  # coefficients of u
    if k == 0:
        return (r if r.is_zero else scaled(r, 1 / p.LC())), polynomial(0, s)
    system = Matrix.zeros(degree + 1, above + k)
    for offset, count, poly in ((0, above, p), (above, k, q)):
        ascending = list(reversed(poly.all_coeffs()))
        for j in range(count):
            for i, coefficient in enumerate(ascending):
                system[i + j, offset + j] = coefficient
    target = [] if r.is_zero else list(reversed(r.all_coeffs()))
    target += [sympy.Integer(0)] * (degree + 1 - len(target))
    coefficients = list(solve(ImmutableMatrix(system), ImmutableMatrix(target)))
    u, v = coefficients[:above], coefficients[above:]
    return from_coefficients(u[::-1], s), from_coefficients(v[::-1], s)
