"""Phase crossovers of a loop with a dead time: roots of a transcendental equation, in balls."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import flint
import sympy
from sympy import QQ, Poly, Rational

from compensator_theory.errors import BudgetError
from compensator_theory.matrices._flint_polynomials import to_flint_polynomial
from compensator_theory.polynomials._ball_precision import at_growing_precision
from compensator_theory.polynomials._poly import exact_quotient
from compensator_theory.roots._enclosures import Enclosure, ball_of_number
from compensator_theory.stability._critical_values import real_roots
from compensator_theory.stability._enclosed_norms import narrow
from compensator_theory.stability._margins import squared

MOST_BOXES = 50_000
MOST_DOUBLINGS = 60
NEWTON_STEPS = 40
Crossings = list[tuple[Enclosure, Enclosure]]
"""Frequencies with their factors of the gain -1/L."""


@dataclass(frozen=True)
class DelayedCurve:
    r"""The frequency response :math:`L = e^{-\theta s} N/D` of a strictly proper, coprime N/D.

    With :math:`N(s) D(-s) = g(-s^2) P(s)`, g of the largest degree, a phase crossover is a root of
    :math:`F(\omega) = \mathrm{Im}\, P(j\omega) e^{-j\theta\omega}` with negative real part. No root
    but 0 is multiple or one of g: it would be algebraic, and :math:`e^{2j\theta\omega}`, a quotient
    of algebraic numbers there, is transcendental (Lindemann). So small balls decide.
    """

    numerator: Poly
    denominator: Poly
    dead_time: Rational

    @cached_property
    def _factors(self) -> tuple[Poly, Poly]:
        """G in x = omega^2 and P in s."""
        real, imaginary = squared(self.numerator, self.denominator)
        g = real.gcd(imaginary)
        s = self.numerator.gen
        terms: dict[tuple[int, ...], Rational] = {}
        for part, shift in ((exact_quotient(real, g), 0), (exact_quotient(imaginary, g), 1)):
            for (k,), c in part.terms():
                terms[2 * int(k) + shift,] = c * (-1) ** int(k)
        return g, Poly(terms, s, domain=QQ)

    def _derivative(self, order: int) -> Poly:
        """Q with F^(n) = Im(j^n Q(j omega) exp(-j theta omega)): (d/ds - theta)^n P."""
        Q = self._factors[1]
        for _ in range(order):
            Q = Q.diff() - Q * self.dead_time
        return Q

    def crossings(self, high: float) -> Crossings:
        """Return all crossings with a frequency in (0, high], ascending."""
        low = self._free_of_roots()
        P, slope = self._derivative(0), self._derivative(1)

        def attempt(bits: int) -> Crossings | None:
            search = _CrossingSearch(self, _acb(P), _acb(slope), bits)
            isolated = search.isolated(low, high)
            if isolated is None:
                return None
            crossings = [search.crossing(*box) for box in isolated]
            if any(crossing is None for crossing in crossings):
                return None
            return [crossing for crossing in crossings if crossing]  # no empty ones: L > 0

        return at_growing_precision(attempt, 160, "a phase crossover")

    def _free_of_roots(self) -> float:
        """Return an end of (0, end] without a root of F, from the first derivative at 0."""
        order = 1
        while (Q := self._derivative(order)).eval(0) == 0:
            order += 2  # F is odd
        unit = flint.acb(0, 1) ** order

        def attempt(bits: int) -> float | None:
            for exponent in range(MOST_DOUBLINGS):
                end = 2.0 ** (8 - 2 * exponent)
                s = flint.acb(0, flint.arb(0).union(flint.arb(end)))
                slope = (unit * _acb(Q)(s) * (-s * ball_of_number(self.dead_time)).exp()).imag
                if not slope.contains(0):
                    return end
            return None

        return at_growing_precision(attempt, 160, "the phase near the frequency 0")


class _CrossingSearch:
    """Bisection for the roots of F at one precision."""

    def __init__(
        self, curve: DelayedCurve, P: flint.acb_poly, slope: flint.acb_poly, bits: int
    ) -> None:
        """Take P and the polynomial of F'."""
        self.theta = ball_of_number(curve.dead_time)
        self.P, self.Q, self.bits = P, slope, bits
        self.g = flint.arb_poly(to_flint_polynomial(curve._factors[0]))
        self.below = flint.arb_poly(
            to_flint_polynomial(squared(curve.denominator, curve.denominator)[0])
        )

    def _turned(self, poly: flint.acb_poly, omega: flint.arb) -> flint.acb:
        s = flint.acb(0, omega)
        return poly(s) * (-s * self.theta).exp()

    def value(self, omega: flint.arb) -> flint.arb:
        """Return F."""
        return self._turned(self.P, omega).imag

    def slope(self, omega: flint.arb) -> flint.arb:
        """Return F'."""
        return self._turned(self.Q, omega).real

    def isolated(self, low: float, high: float) -> list[tuple[float, float]] | None:
        """Return intervals with one simple root each; None at too low a precision."""
        boxes = [(low, high)] if low < high else []
        roots: list[tuple[float, float]] = []
        smallest = high * 2.0 ** -min(self.bits // 4, 45)
        for _ in range(MOST_BOXES):
            if not boxes:
                return roots
            a, b = boxes.pop()
            box, middle = flint.arb(a).union(flint.arb(b)), flint.arb((a + b) / 2)
            slope = self.slope(box)
            at_middle = self.value(middle)
            if not (at_middle + slope * (box - middle)).contains(0):
                continue
            if not slope.contains(0):
                ends = self.value(flint.arb(a)), self.value(flint.arb(b))
                if any(end.contains(0) for end in ends):
                    return None
                if bool(ends[0] > 0) != bool(ends[1] > 0):
                    roots.append((a, b))
                continue
            if b - a < smallest:
                return None
            boxes += [((a + b) / 2, b), (a, (a + b) / 2)]
        raise BudgetError(
            f"the loop has too many phase crossovers for {MOST_BOXES} intervals; shorten the dead "
            "time, or give pade(order)"
        )

    def crossing(self, a: float, b: float) -> tuple[Enclosure, Enclosure] | tuple[()] | None:
        """Return frequency and gain of a root; () where L is positive, None if undecided."""
        box = flint.arb(a).union(flint.arb(b))
        for _ in range(NEWTON_STEPS):
            middle = flint.arb(box.mid())
            slope = self.slope(box)
            following = middle - self.value(middle) / slope
            if not (following.is_finite() and following.overlaps(box)):
                return None
            following = following.intersection(box)
            if following.rad() >= box.rad() / 2:
                box = following
                break
            box = following
        real = self.g(box * box) * self._turned(self.P, box).real
        if real > 0:
            return ()
        if not real < 0:
            return None
        enclosures = narrow(box, -self.below(box * box) / real)
        return None if enclosures is None else (enclosures[0], enclosures[1])


def crossings_to_best(curve: DelayedCurve, last: Enclosure | None) -> tuple[Crossings, Rational]:
    """Return the phase crossovers up to a frequency beyond which none has a smaller gain above 1.

    `last` is the last gain crossover: beyond it abs(L) < 1.
    """
    start = 0.0 if last is None else _above(float(last.upper))
    turn = 7 / float(curve.dead_time)
    crossings: Crossings = []
    high = start
    for exponent in range(MOST_DOUBLINGS):
        high = start + turn * 2.0**exponent
        crossings = curve.crossings(high)
        factors = [gain.upper for _, gain in crossings if gain.lower > 1]
        if factors:
            break
    else:
        raise BudgetError("no phase crossover was found; the numbers differ too much in size")
    bound = sympy.ceiling(min(factors) * 1024) / 1024
    N, D = curve.numerator, curve.denominator
    difference = squared(N, N)[0] * bound**2 - squared(D, D)[0]
    edge = max((root.enclosure.upper for root in real_roots([difference])), default=0)
    end = _above(math.sqrt(_above(float(edge)))) if edge > 0 else 0.0
    if end > high:
        high = end
        crossings = curve.crossings(high)
    return crossings, Rational(high)


def _above(number: float) -> float:
    """Return the next float."""
    return math.nextafter(number, math.inf)


def _acb(poly: Poly) -> flint.acb_poly:
    return flint.acb_poly(to_flint_polynomial(poly))
