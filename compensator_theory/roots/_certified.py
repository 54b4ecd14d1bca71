"""Roots with a certificate: balls that provably contain them, with exact multiplicities."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TypeVar

import flint
from sympy import QQ, QQ_I, Expr, Poly, Symbol

from compensator_theory._latex import displayed, words
from compensator_theory.errors import InputError
from compensator_theory.polynomials._ball_precision import (
    at_growing_precision,
    ball_precision,
)
from compensator_theory.polynomials._budget import quoted
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._complex_polynomials import complex_parts, joined
from compensator_theory.polynomials._poly import canonical, is_rational, way_to_rational
from compensator_theory.polynomials._reading import PolynomialLike, polynomial
from compensator_theory.polynomials._values import ExactValue

Decision = TypeVar("Decision")

EASY = 20
"""Degree from which rational roots are split off first: close roots take python-flint seconds."""
START = 400
"""Bits up to which the first step of Newton's method goes, from balls of at least half of them."""


@dataclass(frozen=True)
class Root(ExactValue):
    """A root of a rational polynomial, known to lie in a disk that contains no other root.

    Attributes
    ----------
    value : complex
        Centre of the disk.
    radius : float
        Upper bound of the distance between `value` and the root.
    multiplicity : int
        Exact.
    is_real : bool
        Exact: decided by the certificate and not by the size of the imaginary part.

    Examples
    --------
    >>> from compensator_theory import certified_roots, polynomial
    >>> print(certified_roots(polynomial("q**2 - q/2"))[1])
    0.5
    """

    value: complex
    radius: float
    multiplicity: int
    is_real: bool

    def __str__(self) -> str:
        text = f"{self.value.real:.6g}" if self.is_real else f"{self.value:.6g}"
        return text if self.multiplicity == 1 else f"{text} (multiplicity {self.multiplicity})"

    def _repr_latex_(self) -> str:
        text = words("" if self.multiplicity == 1 else f" (multiplicity {self.multiplicity})")
        value = f"{self.value.real:.6g}" if self.is_real else f"{self.value:.6g}".replace("j", "i")
        return displayed(rf"\lambda \approx {value} {text if self.multiplicity > 1 else ''}")


@refusing
def certified_roots(poly: PolynomialLike, variable: str | Symbol | None = None) -> tuple[Root, ...]:
    r"""Isolate the roots of a polynomial with rational coefficients in certified disks.

    .. math:: |\lambda_i - \mathrm{value}_i| \le \mathrm{radius}_i

    Parameters
    ----------
    poly : polynomial
        Rational coefficients, or complex ones with rational parts, not zero.
    variable : str or Symbol, optional
        Default: evident; a list of coefficients shows none.

    Returns
    -------
    tuple of Root
        Distinct roots; real ones first in ascending order, then conjugate pairs by real part,
        the root in the upper half plane first. Empty for a constant.

    Raises
    ------
    InputError
        If the polynomial is zero or has symbolic coefficients.

    Examples
    --------
    >>> from compensator_theory import certified_roots, polynomial
    >>> [(r.value, r.multiplicity) for r in certified_roots(polynomial("s**2*(s**2 + 1)"))]
    [(0j, 2), (1j, 1), (-1j, 1)]
    >>> print(*certified_roots("s**2 + (2 - 3*I)*s - 6*I"))
    -2 0+3j
    """
    if (parts := complex_parts(poly, variable)) is not None:
        return _complex_roots(parts)
    source = polynomial(poly, variable)
    with ball_precision(64):
        rounded = [_rounded(ball, multiplicity) for ball, multiplicity in root_balls(source)]
    return tuple(sorted(rounded, key=_order))


def _complex_roots(parts: tuple[Poly, Poly]) -> tuple[Root, ...]:
    """Isolate the roots of a + jb; real ones are those of the common factor of a and b."""
    if not all(map(is_rational, parts)):
        raise InputError(
            "the roots of a polynomial with complex coefficients are certified for rational "
            "parts; substitute numbers for its symbols"
        )
    factors = []
    for factor, multiplicity in joined(parts).sqf_list()[1]:
        sides = complex_parts(factor.monic()) or (factor.monic().set_domain(QQ), None)
        common = sides[0] if sides[1] is None else sides[0].gcd(sides[1])
        rest = factor.monic().exquo(common.set_domain(QQ_I))
        factors.append((canonical(common), rest, int(multiplicity)))

    def attempt(bits: int) -> list[tuple[flint.acb, int]] | None:
        balls = [
            (ball, multiplicity)
            for common, _, multiplicity in factors if common.degree() > 0
            for ball, _ in root_balls(common, bits)
        ]  # fmt: skip
        for _, rest, multiplicity in factors:
            if rest.degree() < 1:
                continue
            coefficients = [c.as_real_imag() for c in reversed(rest.all_coeffs())]
            poly = flint.acb_poly([flint.acb(*map(_fraction, c)) for c in coefficients])
            try:
                isolated = poly.roots(tol=flint.arb(2) ** (-bits // 2))
            except ValueError:  # too few bits
                return None
            if any(ball.imag.contains(0) for ball in isolated):
                return None  # none of them is real
            balls += [(ball, multiplicity) for ball in isolated]
        apart = not any(a[0].overlaps(b[0]) for a, b in combinations(balls, 2))
        return balls if apart else None

    isolated_roots = at_growing_precision(attempt, 128, "the roots")
    with ball_precision(128):
        return tuple(sorted((_rounded(*root) for root in isolated_roots), key=_order))


def _fraction(number: Expr) -> flint.fmpq:
    return flint.fmpq(int(number.p), int(number.q))


def real_multiplicities(poly: Poly) -> list[tuple[int, int]]:
    """Return (degree, multiplicity) of each distinct irreducible real factor, 1 or 2 in degree."""
    roots = certified_roots(poly)
    upper_half = [root for root in roots if root.is_real or root.value.imag > 0]
    return [(1 if root.is_real else 2, root.multiplicity) for root in upper_half]


def root_balls(poly: Poly, precision: int = 64) -> list[tuple[flint.acb, int]]:
    """Return the certified complex balls of python-flint with their multiplicities."""
    rest = _integer_polynomial(poly)
    rational = []
    if rest.degree() > EASY:
        for root, multiplicity in flint.fmpq_poly(rest).roots():
            rational.append((root, int(multiplicity)))
            rest //= flint.fmpz_poly([-root.p, root.q]) ** int(multiplicity)
    with ball_precision(precision):
        balls = [(flint.acb(flint.arb(root)), multiplicity) for root, multiplicity in rational]
        return balls + [(ball, int(multiplicity)) for ball, multiplicity in rest.complex_roots()]


def refined_balls(
    poly: flint.fmpz_poly, balls: Sequence[flint.acb], precision: int
) -> list[flint.acb] | None:
    """Return smaller balls around the simple roots that balls isolate, by Newton's interval method.

    The root lies in m - p(m)/p'(X) for the midpoint m of its ball X, whose p'(X) is convex and
    holds the mean slope from m to the root. Much faster than isolating them at that precision. None
    where p'(X) holds 0: then the balls are too large.
    """
    steps, slope = [precision], poly.derivative()
    while steps[-1] > START:
        steps.append(steps[-1] // 2 + 8)
    terms = flint.arb_poly([abs(c) for c in poly.coeffs()])
    smaller = []
    for ball in balls:
        is_real, place = bool(ball.imag == 0), ball
        lost = int(float((terms(abs(ball)) + 2).log().abs_upper()) * 1.5)  # bits, by cancellation
        for bits in reversed(steps):
            with ball_precision(bits + lost):
                p, dp = flint.acb_poly(poly), flint.acb_poly(slope)
                middle, mean = place.mid(), dp(place)
                if mean.contains(0):
                    return None
                place = middle - p(middle) / mean
        smaller.append(flint.acb(place.real) if is_real else place)
    return smaller


def decided_balls(
    poly: Poly, decide: Callable[[flint.acb], Decision | None], precision: int = 64
) -> list[tuple[flint.acb, int, Decision]]:
    """Isolate the roots with growing precision until each ball answers a question.

    The decision uses the precision of the balls: at a lower one, python-flint would round
    what it computes from them and lose the answer.
    """

    def attempt(bits: int) -> list[tuple[flint.acb, int, Decision]] | None:
        decided = []
        for ball, multiplicity in root_balls(poly, bits):
            if (answer := decide(ball)) is None:
                return None
            decided.append((ball, multiplicity, answer))
        return decided

    return at_growing_precision(attempt, precision, "a question about each root")


def _integer_polynomial(poly: Poly) -> flint.fmpz_poly:
    if not is_rational(poly):
        raise InputError(
            f"the roots of {quoted(poly)} cannot be certified: its coefficients are not all "
            f"rational numbers; {way_to_rational(poly)}"
        )
    if poly.is_zero:
        raise InputError("every number is a root of the zero polynomial")
    _, cleared = canonical(poly).clear_denoms(convert=True)
    return flint.fmpz_poly([int(c) for c in reversed(cleared.all_coeffs())])


def _rounded(ball: flint.acb, multiplicity: int) -> Root:
    is_real = bool(ball.imag == 0)
    real = 0.0 if ball.real.contains(0) else float(ball.real.mid())  # +-j prints as +-j
    value = complex(real, 0.0 if is_real else float(ball.imag.mid()))
    error = abs(ball - flint.acb(value.real, value.imag)).abs_upper()
    radius = float(error)
    if flint.arb(radius) < error:
        radius = math.nextafter(radius, math.inf)
    return Root(value, radius, multiplicity, is_real)


def _order(root: Root) -> tuple[bool, float, float, float]:
    value = root.value
    return (not root.is_real, value.real, abs(value.imag), -value.imag)
