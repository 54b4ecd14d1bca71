"""Roots in closed form: of linear and quadratic factors, with symbols and surds."""

from __future__ import annotations

from dataclasses import dataclass

import sympy
from sympy import Expr, Poly, Symbol

from compensator_theory._latex import displayed, latex, words
from compensator_theory._printing import text
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import is_rational, over_coefficient_field
from compensator_theory.polynomials._reading import PolynomialLike, polynomial
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.roots._certified import Root, certified_roots


@dataclass(frozen=True)
class RootFormula(ExactValue):
    """A root as an expression in the coefficients.

    Attributes
    ----------
    value : sympy.Expr
        The symbols stand for generic values: a square root may be imaginary.
    multiplicity : int
        For generic values.

    Examples
    --------
    >>> from compensator_theory.roots import closed_form_roots
    >>> print(closed_form_roots("(s + a)**2", "s")[0])
    -a (multiplicity 2)
    """

    value: Expr
    multiplicity: int

    def __str__(self) -> str:
        more = "" if self.multiplicity == 1 else f" (multiplicity {self.multiplicity})"
        return f"{text(self.value)}{more}"

    def _repr_latex_(self) -> str:
        more = "" if self.multiplicity == 1 else words(f" (multiplicity {self.multiplicity})")
        return displayed(rf"\lambda = {latex(self.value)} {more}")


@carrying()
def closed_form_roots(
    poly: PolynomialLike, variable: str | Symbol | None = None
) -> tuple[RootFormula, ...]:
    r"""Return the roots of a polynomial whose irreducible factors are linear or quadratic.

    .. math:: s^2 + bs + c = 0 \iff s = -\frac b2 \pm \sqrt{\frac{b^2}{4} - c}

    Parameters
    ----------
    poly : polynomial
        Not zero; with symbols, square roots, or both.
    variable : str or Symbol, optional
        Default: evident; a list of coefficients shows none.

    Returns
    -------
    tuple of RootFormula
        Distinct roots, factor by factor; empty for a constant.

    Raises
    ------
    NoSolutionError
        If a factor of degree three or more is irreducible over the field of the coefficients.
    InputError
        If the polynomial is zero.

    Examples
    --------
    >>> from compensator_theory.roots import closed_form_roots
    >>> print(*closed_form_roots("s**3 + 2*z*w*s**2 + w**2*s", "s"), sep="; ")
    0; -w*z - w*sqrt(z**2 - 1); -w*z + w*sqrt(z**2 - 1)
    """
    p = polynomial(poly, variable)
    if p.is_zero:
        raise InputError("every number is a root of the zero polynomial")
    (p,) = over_coefficient_field(p)
    formulas = []
    for factor, multiplicity in sorted(p.factor_list()[1], key=lambda item: item[0].degree()):
        if factor.degree() > 2:
            raise NoSolutionError(
                f"the roots of {format_polynomial(factor)} have no closed form in square "
                "roots; give values by subs(...), or ask stability_conditions"
            )
        formulas += [RootFormula(r, int(multiplicity)) for r in roots_of_factor(factor.monic())]
    return tuple(formulas)


def roots_of_factor(p: Poly) -> list[Expr]:
    """Return the roots of a monic factor of degree one or two."""
    if p.degree() == 1:
        return [-p.TC()]
    centre, square = completed_square(p)
    root = root_of_square(square)
    return [centre - root, centre + root]


def completed_square(p: Poly) -> tuple[Expr, Expr]:
    """Return c and d of (s - c)**2 - d."""
    centre = -p.coeff_monomial(p.gen) / 2
    square = sympy.expand(centre**2 - p.TC())
    return centre, sympy.factor(square) if square.free_symbols else square


def root_of_square(square: Expr) -> Expr:
    """Return a square root; its sign does not matter, so that of w**2 may be w."""
    return sympy.powdenest(sympy.sqrt(sympy.factor(square)), force=True)


def roots_of(p: Poly) -> tuple[Root | RootFormula, ...]:
    """Return certified roots of a rational polynomial, else closed forms."""
    return certified_roots(p) if is_rational(p) else closed_form_roots(p)
