"""The H-infinity norm, exact: an algebraic number with a certified ball."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from itertools import count, pairwise
from typing import TypeAlias

import flint
import sympy
from sympy import QQ, Expr, Poly, Rational, Symbol

from compensator_theory._latex import displayed, latex
from compensator_theory._printing import text
from compensator_theory.errors import NoSolutionError
from compensator_theory.matrices._flint_polynomials import (
    from_flint_polynomial,
    to_flint_polynomial,
)
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.matrices._rational_functions import factored
from compensator_theory.polynomials._ball_precision import at_growing_precision, ball_precision
from compensator_theory.polynomials._budget import ask, decimal_digits
from compensator_theory.polynomials._carrying import carried_by, refusing
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.roots._counts import number_of_real_roots
from compensator_theory.roots._enclosures import Enclosure, ball_of_enclosure, enclosure_of_ball
from compensator_theory.roots._independent_numbers import Meaning
from compensator_theory.stability._critical_values import (
    CriticalValue,
    number_between,
    real_root,
)
from compensator_theory.stability._enclosed_norms import norm_with_exponentials
from compensator_theory.stability._half_plane_matrices import (
    HalfPlaneMatrix,
    gram_of,
    half_plane_matrix,
)
from compensator_theory.systems._matrix_conversions import TransferMatrixLike

LEVEL = Symbol("g")
Bivariate: TypeAlias = list[flint.fmpz_poly]
"""A polynomial in w and g as its coefficients, polynomials in g, of ascending powers of w."""


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


@dataclass(frozen=True)
class EnclosedHInfinityNorm(ExactValue):
    """The largest gain over all frequencies of a plant with exponentials as coefficients.

    Attributes
    ----------
    enclosure : Enclosure
        Certified, with 30 digits: such a norm is in general no algebraic number.
    exponentials : tuple of (Symbol, Expr)
        The numbers that occur in the coefficients, such as (x, exp(-1/10)).
    """

    enclosure: Enclosure
    exponentials: Meaning

    def __float__(self) -> float:
        return float(self.enclosure)

    def __str__(self) -> str:
        return repr(self.enclosure)

    def _repr_latex_(self) -> str:
        return displayed(rf"\|G\|_\infty = {self.enclosure.latex()}")


@carried_by("none")
def h_infinity_norm(
    G: TransferMatrixLike, variable: str | Symbol | None = None
) -> HInfinityNorm | EnclosedHInfinityNorm:
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

    Returns
    -------
    HInfinityNorm or EnclosedHInfinityNorm
        The latter, a ball of 30 digits, for a scalar G whose coefficients are exponentials of
        rational numbers, such as a sampled plant.

    Raises
    ------
    NoSolutionError
        If G is not stable.
    InputError, ImproperError, BudgetError
        If it cannot be read, has symbols, does not show the time domain, is improper or too large.

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
    >>> norm = h_infinity_norm("(s + 1)/(s**2 + s + 2)")
    >>> norm.value, norm.square_polynomial.as_expr()
    (sqrt(5/7 + 4*sqrt(2)/7), 7*g**2 - 10*g - 1)
    >>> print(h_infinity_norm("1/(z - exp(-1/10))"))  # 1/(1 - exp(-1/10))
    10.5083319447750496240 ± 5.0e-20
    """
    sampled = norm_with_exponentials(G, variable)
    if sampled is not None:
        return EnclosedHInfinityNorm(*sampled)
    return rational_norm(G, variable)


@refusing
def rational_norm(G: TransferMatrixLike, variable: str | Symbol | None = None) -> HInfinityNorm:
    """Return the norm of a rational transfer matrix."""
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
    return HInfinityNorm(_square_root(best.value), ball, polynomial)


def _square_root(square: Expr) -> Expr:
    """Take the root of a number that is not negative; SymPy would isolate all roots to see it."""
    number, root = square.as_coeff_Mul()
    if not isinstance(root, sympy.CRootOf):
        return sympy.sqrt(square)
    return sympy.sqrt(number) * sympy.Pow(root, sympy.S.Half, evaluate=False)


def _factors(G: HalfPlaneMatrix) -> list[Bivariate]:
    """Return the irreducible factors that contain g, of P in (w, g)."""
    s = G.variable
    gram = sympy.Matrix([[e.as_expr() for e in row] for row in gram_of(G)])
    bottom = to_flint_polynomial(G.denominator)
    bottom *= flint.fmpq_poly([c * (-1) ** k for k, c in enumerate(bottom.coeffs())])
    x = sympy.Symbol("x_level")
    # det(x I - gram) with x = g D(s) D(-s): one charpoly of a polynomial matrix
    spread = characteristic_polynomial(gram, x)
    by_level = [
        to_flint_polynomial(Poly(c, s, domain=QQ)) * bottom**k
        for k, c in enumerate(reversed(spread.all_coeffs()))
    ]
    below = reduce(lambda a, b: a.lcm(b), (p.denom() for p in by_level))
    terms = {
        (i, k): (c * below).numer() * (-1) ** i  # s^2 = -w
        for k, p in enumerate(by_level)
        for i, c in enumerate(p.coeffs()[::2])
        if c
    }
    both = flint.fmpz_mpoly_ctx.get(["w", "g"], flint.Ordering.lex).from_dict(terms)
    factors = [_by_powers_of_w(factor) for factor, _ in factored(both)[1]]
    return [factor for factor in factors if any(c.degree() > 0 for c in factor)]


def _by_powers_of_w(poly: flint.fmpz_mpoly) -> Bivariate:
    size, levels = (int(degree) + 1 for degree in poly.degrees())
    by_level = [[flint.fmpz(0)] * levels for _ in range(size)]
    for (i, k), c in poly.to_dict().items():
        by_level[int(i)][int(k)] = c
    return [flint.fmpz_poly(row) for row in by_level]


def _supremum(factors: list[Bivariate]) -> tuple[CriticalValue, Poly]:
    """Return the supremum of g with P(w, g) = 0 for a w >= 0, and its irreducible polynomial."""
    candidates: list[flint.fmpz_poly] = []
    constant: list[flint.fmpz_poly] = []
    for factor in factors:
        if len(factor) == 1:
            constant += _irreducible(factor[0])
        else:
            _ask(factor)
            for part in (factor[-1], factor[0], _discriminant(factor)):
                candidates += _irreducible(part)
    distinct = [*constant, *(f for f in candidates if f not in constant)]
    levels = _levels([f for k, f in enumerate(distinct) if f not in distinct[:k]])
    for k in range(len(levels) - 1, -1, -1):
        place, polynomial, index = levels[k]
        below = (
            number_between(levels[k - 1][0].upper, place.lower)
            if k
            else sympy.floor(place.lower) - 1
        )
        if polynomial in constant or any(_has_frequency(factor, below) for factor in factors):
            level_polynomial = from_flint_polynomial(flint.fmpq_poly(polynomial), LEVEL)
            return CriticalValue(
                real_root(level_polynomial.monic(), index), place
            ), level_polynomial
    raise AssertionError("the eigenvalues of a Gram matrix are real")


def _levels(polys: list[flint.fmpz_poly]) -> list[tuple[Enclosure, flint.fmpz_poly, int]]:
    """Return the real roots of distinct irreducible polynomials, which and whose each is."""

    def attempt(_: int) -> list[tuple[Enclosure, flint.fmpz_poly, int]] | None:
        levels = []
        for poly in polys:
            real = sorted(
                (r.real for r, _ in poly.complex_roots() if r.imag == 0), key=lambda r: r.mid()
            )
            levels += [(enclosure_of_ball(r), poly, i) for i, r in enumerate(real)]
        levels.sort(key=lambda level: level[0].lower)
        apart = all(a[0].upper < b[0].lower for a, b in pairwise(levels))
        return levels if apart else None

    return at_growing_precision(attempt, 64, "the order of levels")


def _irreducible(poly: flint.fmpz_poly) -> list[flint.fmpz_poly]:
    if not poly:
        return []
    return [f if f.leading_coefficient() > 0 else -f for f, _ in poly.factor()[1]]


MEASURE = "the polynomial of the norm, ten digits as an entry,"


def _ask(factor: Bivariate) -> None:
    """Ask for the digits of a discriminant: of so many levels, each a number with as many."""
    size = 2 * len(factor) - 2
    bits = max(int(c).bit_length() for poly in factor for c in poly.coeffs())
    levels = size * max(int(c.degree()) for c in factor)
    ask("entries", levels * (decimal_digits(size * bits) // 10), MEASURE)


def _discriminant(factor: Bivariate) -> flint.fmpz_poly:
    """Return a multiple by a number of the discriminant in w, interpolated between whole levels."""
    size = (2 * len(factor) - 4) * max(int(c.degree()) for c in factor) + 1
    places: list[int] = []
    values: list[flint.fmpq] = []
    for k in count():
        level = (k + 1) // 2 * (-1) ** k
        if factor[-1](level):  # elsewhere it is that of a lower degree
            places.append(level)
            values.append(flint.fmpq(flint.fmpz_poly([c(level) for c in factor]).discriminant()))
        if len(places) == size:
            break
    for step in range(1, size):  # Newton's divided differences
        for i in range(size - 1, step - 1, -1):
            values[i] = (values[i] - values[i - 1]) / (places[i] - places[i - step])
    discriminant = flint.fmpq_poly()
    for place, value in zip(reversed(places), reversed(values), strict=True):
        discriminant = discriminant * flint.fmpq_poly([-place, 1]) + value
    return discriminant.numer()


def _has_frequency(factor: Bivariate, level: Rational) -> bool:
    """Whether a factor vanishes at this level for some w > 0, by Sturm's theorem."""
    at = flint.fmpq(int(level.p), int(level.q))
    values = [flint.fmpq_poly(c)(at) for c in factor]
    squared = flint.fmpq_poly([values[k // 2] if k % 2 == 0 else 0 for k in range(2 * len(values))])
    if squared.degree() < 1:
        return False
    return number_of_real_roots(from_flint_polynomial(squared, LEVEL)) > 0
