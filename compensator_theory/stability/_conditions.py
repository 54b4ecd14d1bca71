"""Stability of a polynomial with symbols as a short list of inequalities."""

from __future__ import annotations

import sympy
from sympy import Expr, Poly, Symbol

from compensator_theory.errors import InputError
from compensator_theory.matrices._linear_algebra import determinant
from compensator_theory.polynomials._generic_answers import generic_answer_of
from compensator_theory.polynomials._reading import PolynomialLike, polynomial
from compensator_theory.polynomials._variables import is_discrete
from compensator_theory.stability._half_plane import half_plane_polynomial
from compensator_theory.systems._transfer_functions import TransferFunction


class _Conditions(tuple[Expr, ...]):
    """Expressions that are to be positive; an empty one is no "no", so it has no truth value."""

    __slots__ = ()

    def __bool__(self) -> bool:
        raise InputError(
            "the conditions are expressions that have to be positive, and answer no yes-or-no "
            "question: ask decide_stability(p), or len(...) for how many are left"
        )


def stability_conditions(
    poly: PolynomialLike, variable: str | Symbol | None = None
) -> tuple[Expr, ...]:
    r"""Return expressions that are all positive if and only if every root is stable.

    .. math:: a_0, a_1, a_3, a_5, \ldots > 0, \qquad \Delta_{n-1}, \Delta_{n-3}, \ldots > 0

    for even n, and :math:`a_0, a_2, a_4, \ldots` in place of the odd ones for odd n: half of
    Hurwitz's determinants :math:`\Delta_k`, as Lienard and Chipart have shown. A polynomial in z or
    q is mapped to the half plane by z = (1 + w)/(1 - w) first.

    Parameters
    ----------
    poly : polynomial
        In s for the open left half plane, in z or q for the open unit disk; symbols stand for real
        numbers. Where the leading coefficient is symbolic, it is taken to be positive, and is the
        first condition; for a negative one ask for the negative polynomial, and where it is zero
        for what is left of the polynomial.
    variable : str or Symbol, optional
        Default: evident; a list of coefficients shows none.

    Returns
    -------
    tuple of sympy.Expr
        Without the conditions that are true whatever the symbols are; empty where all are. It has
        no truth value, as `decide_stability` has.

    Raises
    ------
    InputError
        If the polynomial is zero, or its variable is none of s, z and q.

    Notes
    -----
    Source: A. Lienard and H. Chipart, J. Math. Pures Appl. 10 (1914) 291-346; F. R. Gantmacher, The
    Theory of Matrices, vol. 2, XV.13. A condition that is false whatever the symbols are stands in
    the list as a negative number or 0.

    Examples
    --------
    >>> from compensator_theory import stability_conditions
    >>> stability_conditions("s**3 + a*s**2 + b*s + c")
    (c, a, a*b - c)
    >>> stability_conditions("z**2 + a*z + b")
    (-a + b + 1, a + b + 1, 1 - b)
    """
    if isinstance(poly, TransferFunction):
        raise InputError(
            f"{poly} is a transfer function; its poles are the roots of G.denominator, and those "
            "of a loop the roots of closed_loop_polynomial(standard_problem(G), N_c, D_c)"
        )
    p = polynomial(poly, variable)
    if p.is_zero:
        raise InputError("every number is a root of the zero polynomial")
    if sympy.sympify(p.LC()).is_negative:
        p = -p
    leading = [] if sympy.sympify(p.LC()).is_positive else [p.LC()]
    if is_discrete(p.gen, "stability"):
        size = int(p.degree())
        p = half_plane_polynomial(p)
        a = [p.coeff_monomial(p.gen**k) for k in range(size + 1)]
        leading.append(a[-1])
    else:
        a = list(reversed(p.all_coeffs()))
    n = len(a) - 1
    if not n:
        return _Conditions(_shortened(leading))
    first = range(1, n, 2) if n % 2 == 0 else range(2, n, 2)
    coefficients = [a[0], *(a[k] for k in first)]
    minors = [_hurwitz_minor(a, k) for k in range(n - 1, 1, -2)]
    return _Conditions(_shortened([*leading, *coefficients, *reversed(minors)]))


@generic_answer_of(stability_conditions)
def _generic_conditions(
    poly: PolynomialLike, variable: str | Symbol | None = None
) -> tuple[tuple[Expr, ...], list[Expr]]:
    """They speak of one degree, and of a positive leading coefficient where it is symbolic."""
    leading = sympy.sympify(polynomial(poly, variable).LC())
    return stability_conditions(poly, variable), [leading]


def _hurwitz_minor(ascending: list[Expr], size: int) -> Expr:
    n = len(ascending) - 1

    def entry(i: int, j: int) -> Expr:
        k = n - 2 * (j + 1) + (i + 1)
        return ascending[k] if 0 <= k <= n else sympy.Integer(0)

    return determinant(sympy.Matrix(size, size, entry))


def _shortened(conditions: list[Expr]) -> list[Expr]:
    """Leave out denominators, positive numbers and factors, and what stands there twice."""
    kept: list[Expr] = []
    for condition in conditions:
        top, bottom = sympy.fraction(sympy.cancel(condition))
        shorter = sympy.expand(top * bottom)
        symbols = sorted(shorter.free_symbols, key=str)
        if symbols:
            shorter = Poly(shorter, *symbols).primitive()[1].as_expr()
        if not shorter.is_positive and shorter not in kept:
            kept.append(shorter)
    return kept
