"""Positive real and bounded real, decided exactly: passive systems and contractions."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from typing import Literal

import sympy
from sympy import QQ, Poly, Symbol

from compensator_theory._latex import displayed, words
from compensator_theory._printing import text
from compensator_theory.errors import InputError
from compensator_theory.matrices._flint_matrices import identity_matrix
from compensator_theory.matrices._linear_algebra import characteristic_polynomial, solve
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._poly import is_rational, way_to_rational
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.roots._root_counts import RootCount
from compensator_theory.stability._critical_values import number_between, positive_roots
from compensator_theory.stability._half_plane_matrices import (
    HalfPlaneMatrix,
    gram_of,
    half_plane_matrix,
)
from compensator_theory.systems._matrix_conversions import TransferMatrixLike, transfer_matrix
from compensator_theory.systems._transfer_matrices import TransferMatrix


@dataclass(frozen=True)
class RealnessDecision(ExactValue):
    """Whether a transfer matrix is positive real or bounded real, with the reason.

    Attributes
    ----------
    question : {"positive real", "bounded real"}
    holds : bool
    poles : RootCount or None
        Of the transfer matrix for bounded real; of its Cayley transform (G - I)(G + I)^-1
        for positive real, None where that is undefined, because det(G + I) = 0 for all s. All
        are stable where the answer is yes.
    spectrum : tuple of sympy.Poly
        In w = omega^2, or tan^2(theta/2) at z = exp(j theta): sums of principal minors of I - G*G
        (of the Cayley transform), times positive polynomials. The matrix is positive semidefinite
        where none is negative.
    violated : sympy.Rational or None
        A value of w where one is negative; None if there is none.
    """

    _ANSWER = "holds"

    question: Literal["positive real", "bounded real"]
    holds: bool
    poles: RootCount | None
    spectrum: tuple[Poly, ...]
    violated: sympy.Rational | None

    def __str__(self) -> str:
        if self.holds:
            return f"{self.question}"
        if self.poles is None:
            return f"not {self.question}: det(G + I) = 0 for all s"
        if self.poles.stable < self.poles.total:
            return f"not {self.question}: {self.poles} poles"
        return f"not {self.question}: the matrix is indefinite at omega^2 = {text(self.violated)}"

    def _repr_latex_(self) -> str:
        return displayed(words(str(self)))


@refusing
def decide_bounded_real(
    G: TransferMatrixLike, variable: str | Symbol | None = None
) -> RealnessDecision:
    r"""Decide whether a transfer matrix is stable with an H-infinity norm of at most 1.

    .. math:: I - G(-\mathrm{j}\omega)'\,G(\mathrm{j}\omega) \ge 0 \quad\text{for all } \omega

    Parameters
    ----------
    G : transfer matrix
        p x m, rational, proper; in s, or in z or q. Anything :func:`transfer_matrix` reads.
    variable : str or Symbol, optional
        As for :func:`transfer_matrix`.

    Returns
    -------
    RealnessDecision
        A matrix is positive semidefinite if and only if the coefficients of det(xI - M) alternate;
        each is a polynomial in omega^2, whose sign Sturm's theorem decides.

    Raises
    ------
    InputError, ImproperError, BudgetError
        If it cannot be read, has symbols, does not show the time domain, is improper or too large.

    Notes
    -----
    Source: B. D. O. Anderson, S. Vongpanitlerd, Network Analysis and Synthesis (1973), Section 2.6.

    Examples
    --------
    >>> from compensator_theory import decide_bounded_real
    >>> decide_bounded_real("(s - 1)/(s + 1)").holds
    True
    >>> print(decide_bounded_real("1/(s**2 + s + 1)"))
    not bounded real: the matrix is indefinite at omega^2 = 1/2
    """
    source = half_plane_matrix(G, "bounded realness", variable)
    return _decision("bounded real", source)


@refusing
def decide_positive_real(
    G: TransferMatrixLike, variable: str | Symbol | None = None
) -> RealnessDecision:
    r"""Decide whether a square transfer matrix is positive real, that is passive.

    .. math:: G(s) + G(s)^* \ge 0 \quad\text{wherever } \mathrm{Re}\,s > 0 \;(|z| > 1)
              \quad\Longleftrightarrow\quad (G - I)(G + I)^{-1} \text{ is bounded real}

    Parameters
    ----------
    G : transfer matrix
        m x m, rational; in s, or in z or q. Poles on the axis and a pole at infinity are allowed:
        s is positive real. Anything :func:`transfer_matrix` reads.
    variable : str or Symbol, optional
        As for :func:`transfer_matrix`.

    Raises
    ------
    InputError, BudgetError
        If it cannot be read, is not square, has symbols, does not show the time domain, or is too
        large.

    Notes
    -----
    Cayley's transform leaves no poles on the axis to look at. Source: O. Brune (1931); B. D. O.
    Anderson, S. Vongpanitlerd, Network Analysis and Synthesis (1973), Sections 2.7 and 4.1.

    Examples
    --------
    >>> from compensator_theory import decide_positive_real
    >>> decide_positive_real("(s + 1)/(s*(s + 2))").holds
    True
    >>> print(decide_positive_real("1/(s**2 + s + 1)"))
    not positive real: the matrix is indefinite at omega^2 = 2
    """
    source = transfer_matrix(G, variable)
    m = source.shape[0]
    if source.shape != (m, m):
        raise InputError(f"the transfer matrix is {m} x {source.shape[1]}; it must be square")
    N, d = source.numerator_matrix(), source.denominator.as_expr()
    parts = (source.denominator, *chain(*source.numerators))
    if not all(map(is_rational, parts)):
        raise InputError(
            "positive realness needs rational coefficients; "
            f"{way_to_rational(*parts, sources=(G,))}"
        )
    plus = N + d * identity_matrix(m)
    if sympy.expand(plus.det(method="berkowitz")) == 0:
        return RealnessDecision("positive real", False, None, (), None)
    quotient = solve(plus.T, (N - d * identity_matrix(m)).T).T  # (N - d I)(N + d I)^-1
    transform = transfer_matrix(
        [[_pair(entry, source.variable) for entry in row] for row in quotient.tolist()],
        source.variable,
    )
    if not _is_proper(transform):
        return RealnessDecision("positive real", False, RootCount(0, 1, 0), (), None)
    return _decision("positive real", half_plane_matrix(transform, "positive realness"))


def _pair(entry: sympy.Expr, s: Symbol) -> tuple[Poly, Poly]:
    top, bottom = sympy.fraction(sympy.cancel(entry))
    return Poly(top, s, domain=QQ), Poly(bottom, s, domain=QQ)


def _is_proper(G: TransferMatrix) -> bool:
    size = G.denominator.degree()
    return all(e.is_zero or e.degree() <= size for row in G.numerators for e in row)


def _decision(
    question: Literal["positive real", "bounded real"], G: HalfPlaneMatrix
) -> RealnessDecision:
    s = G.variable
    gram = gram_of(G)
    below = G.denominator * G.denominator.compose(Poly(-s, s, domain=QQ))
    whole = sympy.Matrix(
        [
            [(below - entry if i == j else -entry).as_expr() for j, entry in enumerate(row)]
            for i, row in enumerate(gram)
        ]
    )
    x = sympy.Symbol("x_level")
    spread = characteristic_polynomial(whole, x).all_coeffs()
    spectrum = tuple(_in_square(c * (-1) ** k, s) for k, c in enumerate(spread) if k)
    violated = next((at for p in spectrum if (at := _negative(p)) is not None), None)
    return RealnessDecision(question, G.is_stable and violated is None, G.poles, spectrum, violated)


def _in_square(expression: sympy.Expr, s: Symbol) -> Poly:
    """Return p(w) of an even polynomial p(s) with s^2 = -w."""
    even = Poly(sympy.expand(expression), s, domain=QQ)
    w = sympy.Symbol("w")
    terms = {(int(k) // 2,): c * (-1) ** (int(k) // 2) for (k,), c in even.terms()}
    return Poly(terms, w, domain=QQ)


def _negative(poly: Poly) -> sympy.Rational | None:
    """Return a w >= 0 at which a polynomial is negative, None if there is none.

    Between two neighbouring roots the sign is that at one point.
    """
    if poly.is_zero or poly.degree() == 0:
        return sympy.Integer(0) if poly.LC() < 0 else None
    roots = positive_roots(poly)
    ends = [sympy.Integer(0), *(root.upper for root in roots)]
    after = [*(root.lower for root in roots), ends[-1] + 2]
    for lower, upper in zip(ends, after, strict=True):
        if lower < upper and poly.eval(at := number_between(lower, upper)) < 0:
            return at
    return None
