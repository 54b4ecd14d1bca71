"""Margins and H-infinity norm of plants whose coefficients are exponentials, as sampled ones are.

Every tie is decided as a polynomial identity in the exponentials, which are algebraically
independent; what remains has signs and places that certified balls show.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any, ClassVar

import flint
import sympy
from sympy import Expr, Poly, Rational, Symbol

from compensator_theory._latex import displayed, latex, words
from compensator_theory._printing import text
from compensator_theory.errors import ImproperError
from compensator_theory.loops._siso import closed_loop_of_pair, read_loop
from compensator_theory.polynomials._ball_precision import at_growing_precision
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import (
    canonical,
    common_divisor,
    exact_quotient,
)
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import Time, time_of
from compensator_theory.roots._enclosures import Enclosure
from compensator_theory.roots._half_plane import half_plane_polynomial
from compensator_theory.roots._independent_numbers import (
    IndependentNumbers,
    Meaning,
    may_have_exponentials,
    meaning_of,
    square_free,
)
from compensator_theory.roots._root_counts import RootCount
from compensator_theory.stability._enclosed_norms import (
    BITS,
    ask_for_numbers,
    narrow,
    on_the_axis,
    over_numbers,
    squared_over,
    without_meaning,
)
from compensator_theory.stability._margins import (
    OTHER_SIGN,
    ZERO,
    CountedLoop,
    GainCrossover,
    PhaseCrossover,
    frequency_of,
)
from compensator_theory.stability._nearest_margins import (
    Crossing,
    CrossingGains,
    Margin,
    PhaseMargins,
    half_circle,
    nearest,
    nearest_phase,
)


@dataclass(frozen=True)
class EnclosedStabilityMargins(CountedLoop, CrossingGains, PhaseMargins, ExactValue):
    r"""The crossovers of a loop with exponentials as coefficients, and its margins, certified.

    The margins `gain_up`, `gain_down` (factors), `phase_lag`, `phase_lead`, `phase` (degrees) and
    `delay` (s, in discrete time steps) are named as in :class:`StabilityMargins`. Root counts and
    ties are exact: powers of exp(-1/10) are related by no polynomial.

    Attributes
    ----------
    numerator, denominator : sympy.Poly
        N and D of :math:`L = -f\,G G_c`, without common factors, in symbols of `exponentials`.
    hidden : sympy.Poly
        The common factor: roots that L does not show and no gain moves.
    exponentials : tuple of (Symbol, Expr)
        The numbers that the symbols stand for, such as (x, exp(-1/10)).
    time : {"continuous", "discrete"}
    open_loop, closed_loop : RootCount
        Roots of D, and of D + N, the hidden ones counted in both.
    gain_crossovers : tuple of GainCrossover
        By ascending frequency, with an enclosure as `square`.
    phase_crossovers : tuple of PhaseCrossover
        By ascending frequency, with enclosures.
    """

    _REST: ClassVar[str] = ".gain_crossovers and .phase_crossovers list them"
    numerator: Poly
    denominator: Poly
    hidden: Poly
    exponentials: Meaning
    time: Time
    open_loop: RootCount
    closed_loop: RootCount
    gain_crossovers: tuple[GainCrossover, ...]
    phase_crossovers: tuple[PhaseCrossover, ...]

    def _factors(self) -> list[Crossing]:
        """The gain factors that put a root on the boundary, or at infinity."""
        factors: list[Crossing] = [
            (c.gain_enclosure, sympy.oo if c.frequency is None else c.frequency)
            for c in self.phase_crossovers
        ]
        N, D = self.numerator, self.denominator
        if self.time == "discrete" and not N.is_zero and N.degree() == D.degree():
            at_infinity = -D.LC() / N.LC()
            if self._numbers.sign(at_infinity) > 0:
                factors.append((_enclosure(self._numbers, at_infinity), sympy.oo))
        return factors

    @property
    def _numbers(self) -> IndependentNumbers:
        return IndependentNumbers(self.exponentials)

    def _phase(self, *, lead: bool) -> Margin | None:
        if not self.is_stable:
            return None
        N, D = self.numerator, self.denominator
        ends: list[tuple[Expr, Any]]
        if self.time == "discrete":
            ends = [(N.eval(1) - D.eval(1), ZERO), (N.eval(-1) - D.eval(-1), half_circle())]
        else:
            last = N.coeff_monomial(D.gen ** int(D.degree())) - D.LC()
            ends = [(N.eval(0) - D.eval(0), ZERO), (last, sympy.oo)]
        at_one = [place for difference, place in ends if sympy.cancel(difference) == 0]
        crossings = [(c.phase_margin, c.frequency) for c in self.gain_crossovers]
        return nearest_phase(crossings, at_one, lead=lead)

    @property
    def delay(self) -> Margin | None:
        r"""The least delay that makes the loop unstable, in s, in discrete time in steps.

        None for an unstable loop. In continuous time every delay does where :math:`|L| \ge 1` at
        infinity. In discrete time, where :math:`|L(-1)| > 1`, it is a whole number of steps.
        """
        if not self.is_stable:
            return None
        N, D, numbers = self.numerator, self.denominator, self._numbers
        crossings = [(c.delay, c.frequency) for c in self.gain_crossovers]
        if self.time == "continuous":
            above = N.coeff_monomial(D.gen ** int(D.degree()))
            if numbers.sign(above**2 - D.LC() ** 2) >= 0:
                return Margin(ZERO, sympy.oo)
            return nearest(crossings)
        top, bottom = N.eval(-1), D.eval(-1)
        if sympy.cancel(bottom) != 0 and numbers.sign(top**2 - bottom**2) <= 0:
            if sympy.cancel(top - bottom) == 0:
                crossings.append((Enclosure(Rational(1), Rational(0)), half_circle()))
            return nearest(crossings)
        z = D.gen
        for steps in count(1):
            ask("degree", int(D.degree()) + steps, "the loop with that delay")
            roots = numbers.count(canonical(D * Poly(z**steps, z) + N), "discrete")
            if roots.stable < roots.total:
                return Margin(Enclosure(Rational(steps), Rational(0)), None)
        raise AssertionError("unreachable")

    @property
    def _has_stable_opposite(self) -> bool:
        """Whether the unstable loop is stable with the other sign of feedback: 1 - L."""
        if self.is_stable:
            return False
        roots = canonical(self.denominator - self.numerator)
        if roots.degree() < self.denominator.degree():
            return False
        counts = self._numbers.count(canonical(roots * self.hidden), self.time)
        return bool(counts.stable == counts.total)

    def __str__(self) -> str:
        verdict = "stable" if self.is_stable else f"not stable ({self.closed_loop})"
        if not self.is_well_posed:
            verdict = f"not well posed: 1 + L = 0 at infinity ({self.closed_loop})"
        meaning = ", ".join(f"{x} = {text(value)}" for x, value in self.exponentials)
        lines = [f"the loop is {verdict} with {meaning}"]
        if self._has_stable_opposite:
            lines.append(OTHER_SIGN)
        if self.hidden.degree() > 0:
            lines.append(f"hidden in L, moved by no gain: {format_polynomial(self.hidden)}")
        return "\n".join(
            [*lines, *map(str, self.gain_crossovers), *map(str, self.phase_crossovers)]
        )

    def _repr_latex_(self) -> str:
        rows = [latex(c) for c in (*self.gain_crossovers, *self.phase_crossovers)]
        return displayed(words("stable" if self.is_stable else "not stable"), *rows)


def margins_with_exponentials(
    parts: Sequence[Any], feedback: int, variable: str | Symbol | None
) -> EnclosedStabilityMargins | None:
    """Return the margins of a loop with exponentials of numbers; None of another loop."""
    if not may_have_exponentials(*parts):
        return None
    plant, compensator = map(without_meaning, parts)
    G, G_c = read_loop(plant, compensator, feedback, variable=variable)
    rewritten = over_numbers([G, G_c], [*map(meaning_of, parts)])
    if rewritten is None:
        return None
    (G, G_c), numbers = rewritten
    N, D = canonical(G.numerator * G_c.numerator * -feedback), G.denominator * G_c.denominator
    D = canonical(D)
    time = time_of(G.variable, "a margin")
    if N.degree() > D.degree():
        raise ImproperError(f"the loop {N.as_expr()} over {D.as_expr()} is improper")
    ask_for_numbers(int(D.degree()), numbers, "the margins of a loop with exponentials")
    whole = closed_loop_of_pair(G, G_c, feedback)
    if whole.is_zero:
        raise ImproperError(
            "L = -1 at all frequencies, so that 1 + L is zero: the loop is not well posed"
        )
    closed, opened = numbers.count(whole, time), numbers.count(D, time)
    hidden = common_divisor(N, D) if not N.is_zero else D
    N, D = exact_quotient(N, hidden), exact_quotient(D, hidden)
    size = int(D.degree())
    top, bottom = (half_plane_polynomial(p, size) if time == "discrete" else p for p in (N, D))
    return EnclosedStabilityMargins(
        N, D, hidden, numbers.meaning, time, opened, closed,
        tuple(_gain_crossovers(top, bottom, time, numbers)),
        tuple(_phase_crossovers(top, bottom, size, time, numbers)),
    )  # fmt: skip


def _vanishing(poly: Poly, factor: Poly) -> Poly:
    """Return the part of a factor in w**2 at whose roots a polynomial vanishes on the axis."""
    divisor = factor
    for part in on_the_axis(poly):
        if not part.is_zero:
            divisor = common_divisor(divisor, part)
    return divisor


def _gain_crossovers(
    top: Poly, bottom: Poly, time: Time, numbers: IndependentNumbers
) -> list[GainCrossover]:
    difference = canonical(squared_over(top, top)[0] - squared_over(bottom, bottom)[0])
    crossovers = []
    for whole, _ in () if difference.is_zero else square_free(difference):
        minus_one = _vanishing(canonical(top + bottom), whole)
        one = _vanishing(canonical(top - bottom), whole)
        others = exact_quotient(exact_quotient(whole, minus_one), one)
        for factor, angle in ((minus_one, 0), (one, 1), (others, None)):
            for index in _positive(factor, numbers):
                crossovers.append(_gain_crossover(factor, index, angle, top, bottom, time, numbers))
    return sorted(crossovers, key=lambda c: c.frequency.centre)


def _positive(factor: Poly, numbers: IndependentNumbers) -> list[int]:
    """Return the indices of the positive roots among the real ones; 0 is none of them."""
    least = min((int(k) for (k,), _ in factor.terms()), default=0)
    negative_or_zero = 0
    if least:  # square-free: 0 is a simple root
        factor = exact_quotient(factor, Poly(factor.gen, factor.gen, domain="QQ"))
        negative_or_zero = 1

    def attempt(bits: int) -> list[bool] | None:
        signs = [True if r > 0 else False if r < 0 else None for r in
                 numbers.real_roots(factor, bits)]  # fmt: skip
        return None if None in signs else signs  # type: ignore[return-value]

    signs = at_growing_precision(attempt, BITS, "the sign of a root")
    first = signs.index(True) if True in signs else len(signs)
    return [k + negative_or_zero for k in range(first, len(signs))]


def _gain_crossover(
    factor: Poly, index: int, angle: int | None, top: Poly, bottom: Poly, time: Time,
    numbers: IndependentNumbers,
) -> GainCrossover:  # fmt: skip
    """`angle` is that of -L over pi where L is -1 or 1; else L is not real on the circle."""

    def attempt(bits: int) -> tuple[Enclosure, ...] | None:
        square = numbers.real_roots(factor, bits)[index]
        omega = frequency_of(square, time)
        if angle == 0:
            return narrow(square, omega, flint.arb(0), flint.arb(0))
        margin = flint.arb.pi()
        if angle is None:
            s = flint.acb(0, square.sqrt())
            above, below = (flint.acb_poly(numbers.polynomial_ball(p))(s) for p in (top, bottom))
            if below.contains(0):
                return None
            turned = -above / below
            if turned.imag.contains(0):
                return None
            margin = turned.arg()
        lag = margin if margin > 0 else margin + 2 * flint.arb.pi()
        return narrow(square, omega, margin, lag / omega)

    return GainCrossover(*at_growing_precision(attempt, BITS, "a phase margin"))


def _phase_crossovers(
    top: Poly, bottom: Poly, size: int, time: Time, numbers: IndependentNumbers
) -> list[PhaseCrossover]:
    real, imaginary = squared_over(top, bottom)
    below = squared_over(bottom, bottom)[0]
    if imaginary.is_zero:
        return []
    crossovers = []
    at_zero, under = real.eval(0), below.eval(0)
    if sympy.cancel(under) != 0 and numbers.sign(at_zero) < 0:
        factor = _enclosure(numbers, -under / at_zero)
        crossovers.append(PhaseCrossover(ZERO, ZERO, factor, factor))
    inner = []
    for whole, _ in square_free(imaginary):
        part = whole
        for other in (below, real):  # poles on the boundary, and zeros of L
            if not other.is_zero:
                part = exact_quotient(part, common_divisor(part, other))
        inner += [
            crossover
            for index in _positive(part, numbers)
            if (crossover := _phase_crossover(part, index, real, below, time, numbers)) is not None
        ]
    crossovers += sorted(inner, key=lambda c: c.square.centre)
    last, least = (p.coeff_monomial(p.gen**size) for p in (real, below))
    if sympy.cancel(least) != 0 and numbers.sign(last) < 0:
        factor = _enclosure(numbers, -least / last)
        edge = half_circle() if time == "discrete" else None
        crossovers.append(PhaseCrossover(sympy.oo, edge, factor, factor))
    return crossovers


def _phase_crossover(
    factor: Poly, index: int, real: Poly, below: Poly, time: Time, numbers: IndependentNumbers
) -> PhaseCrossover | None:
    """Return the crossover where L is negative; None where it is positive."""

    def attempt(bits: int) -> tuple[Enclosure, ...] | None:
        square = numbers.real_roots(factor, bits)[index]
        above, under = (numbers.polynomial_ball(p)(square) for p in (real, below))
        if above > 0:
            return ()
        return narrow(square, frequency_of(square, time), -under / above) if above < 0 else None

    enclosures = at_growing_precision(attempt, BITS, "a gain margin")
    if not enclosures:
        return None
    square, frequency, gain = enclosures
    return PhaseCrossover(square, frequency, gain, gain)


def _enclosure(numbers: IndependentNumbers, value: Expr) -> Enclosure:
    """Return the enclosure of a rational function of the numbers."""
    reduced = sympy.cancel(value)
    if reduced.is_Rational:
        return Enclosure(reduced, Rational(0))
    (enclosure,) = at_growing_precision(lambda _: narrow(numbers.ball(reduced)), BITS, "a gain")
    return enclosure
