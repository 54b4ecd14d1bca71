"""The H-infinity norm, exact: an algebraic number with a certified ball."""

from __future__ import annotations

from dataclasses import dataclass

import sympy
from sympy import QQ, Expr, Poly, Symbol

from compensator_theory._latex import displayed, latex
from compensator_theory._printing import text
from compensator_theory.errors import NoSolutionError
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.polynomials._ball_precision import ball_precision
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.roots._counts import number_of_real_roots
from compensator_theory.roots._enclosures import Enclosure, ball_of_enclosure, enclosure_of_ball
from compensator_theory.stability._critical_values import (
    CriticalValue,
    number_between,
    real_roots,
)
from compensator_theory.stability._half_plane_matrices import HalfPlaneMatrix, half_plane_matrix
from compensator_theory.systems._matrix_conversions import TransferMatrixLike

LEVEL = Symbol("g")


@dataclass(frozen=True)
class HInfinityNorm(ExactValue):
    r"""The largest singular value over all frequencies.

    Attributes
    ----------
    value : sympy.Expr
        Exact: rational, in square roots, or the square root of SymPy's CRootOf.
    enclosure : Enclosure
        Certified: lies within `radius` of `centre`.
    square_polynomial : sympy.Poly
        Irreducible, in g; :math:`\|G\|_\infty^2` is a root.
    """

    value: Expr
    enclosure: Enclosure
    square_polynomial: Poly

    def __str__(self) -> str:
        exact, near = text(self.value), f"{float(self.enclosure):.6g}"
        return exact if exact == near else f"{exact} = {near}"

    def _repr_latex_(self) -> str:
        exact, near = latex(self.value), f"{float(self.enclosure):.6g}"
        return displayed(
            rf"\|G\|_\infty = {exact}" + (rf" \approx {near}" if exact != near else "")
        )


def h_infinity_norm(G: TransferMatrixLike, variable: str | Symbol | None = None) -> HInfinityNorm:
    r"""Compute the H-infinity norm of a stable proper transfer matrix.

    .. math:: \|G\|_\infty = \sup_\omega \bar\sigma(G(\mathrm{j}\omega)), \qquad
              P(\omega^2, g) = |D|^{2m} \det(g I - G(-\mathrm{j}\omega)' G(\mathrm{j}\omega))

    The square is the largest g with P(w, g) = 0 at some w >= 0. It is a root of the discriminant of
    a factor of P in w, of its value at w = 0 or of its leading coefficient; from the largest of
    these downwards Sturm's theorem tells at one value between two of them whether P has a root.

    Parameters
    ----------
    G : transfer matrix
        p x m, rational, stable, proper; in s, or in z or q, where the unit circle is mapped to the
        axis by z = (1 + s)/(1 - s). Anything :func:`transfer_matrix` reads.
    variable : str or Symbol, optional
        As for :func:`transfer_matrix`.

    Raises
    ------
    NoSolutionError
        If G is not stable.
    InputError, ImproperError, BudgetError
        If it cannot be read, has symbols, says nothing about time, is improper or too large.

    Notes
    -----
    Factors common to all entries are cancelled first. Bisection (S. Boyd, V. Balakrishnan, P.
    Kabamba, Math. Control Signals Systems 2 (1989) 207-219) finds the same in floats; exactly, N.
    Kanno, M. C. Smith, J. Symbolic Computation 41 (2006) 1342-1367.

    Examples
    --------
    >>> from compensator_theory import h_infinity_norm
    >>> print(h_infinity_norm("1/(s**2 + s + 1)"))
    2*sqrt(3)/3 = 1.1547
    >>> found = h_infinity_norm("(s + 1)/(s**2 + s + 2)")
    >>> found.value, found.square_polynomial.as_expr()
    (sqrt(5/7 + 4*sqrt(2)/7), 7*g**2 - 10*g - 1)
    """
    source = half_plane_matrix(G, "the H-infinity norm", variable)
    if not source.is_stable:
        raise NoSolutionError(
            f"the transfer matrix is not stable: {source.poles} poles; it has no H-infinity norm. "
            "Close a stabilising loop first"
        )
    factors = _factors(source)
    best, polynomial = _supremum(factors)
    with ball_precision(80):
        ball = enclosure_of_ball(ball_of_enclosure(best.enclosure).sqrt())
    return HInfinityNorm(sympy.sqrt(best.value), ball, polynomial)


def _factors(G: HalfPlaneMatrix) -> list[Poly]:
    """Return the irreducible factors that contain g, of P in (w, g)."""
    s = G.variable
    rows, columns = len(G.numerators), len(G.numerators[0])
    N = sympy.Matrix([[e.as_expr() for e in row] for row in G.numerators])
    mirrored = N.subs(s, -s).T
    gram = mirrored * N if columns <= rows else N * mirrored
    bottom = sympy.expand(G.denominator.as_expr() * G.denominator.as_expr().subs(s, -s))
    x = sympy.Symbol("x_level")
    # det(x I - gram) with x = g D(s) D(-s): one charpoly of a polynomial matrix
    spread = characteristic_polynomial(gram.applyfunc(sympy.expand), x)
    total = sum(c * (LEVEL * bottom) ** k for k, c in enumerate(reversed(spread.all_coeffs())))
    even = Poly(sympy.expand(total), s)
    halved = {(int(k) // 2,): c * (-1) ** (int(k) // 2) for (k,), c in even.terms()}  # s^2 = -w
    both = Poly(Poly(halved, s).as_expr(), s, LEVEL, domain=QQ)
    return [factor for factor, _ in both.factor_list()[1] if factor.degree(LEVEL) > 0]


def _supremum(factors: list[Poly]) -> tuple[CriticalValue, Poly]:
    """Return the supremum of g with P(w, g) = 0 for a w >= 0, and its irreducible polynomial."""
    candidates: dict[Poly, None] = {}
    constant: set[Poly] = set()
    for factor in factors:
        in_w = Poly(factor.as_expr(), factor.gens[0])
        if in_w.degree() == 0:
            constant.update(_irreducible(in_w.LC()))
        else:
            for part in (in_w.LC(), in_w.TC(), in_w.discriminant()):
                candidates.update(dict.fromkeys(_irreducible(part)))
    candidates.update(dict.fromkeys(constant))
    roots = real_roots(list(candidates))
    for k in range(len(roots) - 1, -1, -1):
        (polynomial,) = (c for c in candidates if roots[k].value in _values(c))
        below = (
            number_between(roots[k - 1].enclosure.upper, roots[k].enclosure.lower)
            if k
            else sympy.floor(roots[0].enclosure.lower) - 1
        )
        if polynomial in constant or any(_has_frequency(factor, below) for factor in factors):
            return roots[k], polynomial
    raise AssertionError("the eigenvalues of a Gram matrix are real")


def _irreducible(expression: Expr) -> list[Poly]:
    poly = Poly(expression, LEVEL, domain=QQ)
    return [] if poly.is_zero else [f.primitive()[1] for f, _ in poly.factor_list()[1]]


def _values(poly: Poly) -> list[Expr]:
    return [root.value for root in real_roots([poly])]


def _has_frequency(factor: Poly, level: Expr) -> bool:
    """Whether a factor vanishes at this level for some w > 0, by Sturm's theorem."""
    w = factor.gens[0]
    squared = Poly(factor.as_expr().subs({LEVEL: level, w: w**2}, simultaneous=True), w, domain=QQ)
    return squared.degree() > 0 and number_of_real_roots(squared) > 0
