"""Gain and phase crossovers of a loop, exact, with all margins that follow from them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import ClassVar

import flint
import sympy
from sympy import QQ, Expr, Poly, Rational, Symbol

from compensator_theory._latex import displayed, latex, words
from compensator_theory.errors import ImproperError, InputError
from compensator_theory.loops._siso import LoopPart, closed_loop_of_pair, read_loop
from compensator_theory.matrices._flint_polynomials import to_flint_polynomial
from compensator_theory.matrices._quotients_modulo import quotient_modulo
from compensator_theory.polynomials._ball_precision import (
    at_growing_precision,
    ball_precision,
)
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import (
    ask_for_coefficients,
    common_divisor,
    exact_quotient,
    is_rational,
    way_to_rational,
)
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import Time, time_of
from compensator_theory.roots._certified import root_balls
from compensator_theory.roots._counts import count_roots, half_plane_image
from compensator_theory.roots._enclosures import Enclosure, enclosure_of_ball
from compensator_theory.roots._root_counts import RootCount
from compensator_theory.stability._critical_values import (
    even_and_odd,
    real_roots,
    signs_at_real_roots,
)
from compensator_theory.stability._enclosed_norms import narrow
from compensator_theory.stability._nearest_margins import (
    Margin,
    PhaseMargins,
    SymmetricDiskMargin,
    half_circle,
    nearest,
    nearest_delay_in_steps,
    nearest_gain,
    nearest_phase,
)
from compensator_theory.stability._stabilising_gains import intervals_of_gains
from compensator_theory.stability._stability_intervals import StabilityCell

SQUARE = Symbol("x")
ZERO = Enclosure(Rational(0), Rational(0))
Balls = Callable[[Poly, int], list[flint.arb]]
"""`real_root_balls`, remembered as long as one loop is looked at."""


@dataclass(frozen=True)
class GainCrossover(ExactValue):
    r"""A frequency at which the loop has the gain 1.

    Attributes
    ----------
    square : sympy.Expr
        :math:`\omega^2`, exact; in discrete time :math:`\tan^2(\theta/2)` of the angle
        :math:`\theta` in rad/sample.
    frequency : Enclosure
        In rad/s, in discrete time rad/sample.
    phase_margin : Enclosure
        :math:`\arg(-L)` in rad, between :math:`-\pi` and :math:`\pi`: the lag that brings L to -1,
        or, where negative, the lead.
    delay : Enclosure
        The least positive delay that does so, in s, in discrete time in samples.
    """

    square: Expr
    frequency: Enclosure
    phase_margin: Enclosure
    delay: Enclosure

    @property
    def degrees(self) -> float:
        """The phase margin in degrees, rounded."""
        return float(self.phase_margin) * 180 / float(sympy.pi)

    def __str__(self) -> str:
        return f"|L| = 1 at {float(self.frequency):.6g}: phase margin {self.degrees:.4g} degrees"

    def _repr_latex_(self) -> str:
        return displayed(
            rf"|L| = 1, \; \omega^2 = {latex(self.square)}",
            rf"\varphi \approx {self.degrees:.4g}^\circ",
        )


@dataclass(frozen=True)
class PhaseCrossover(ExactValue):
    r"""A frequency at which L is real and negative.

    Attributes
    ----------
    square : sympy.Expr or Enclosure
        :math:`\omega^2`, exact, 0 and oo included; in discrete time :math:`\tan^2(\theta/2)`.
        With a dead time an enclosure.
    frequency : Enclosure or None
        In rad/s, in discrete time rad/sample; None at infinity in continuous time.
    gain : sympy.Expr or Enclosure
        :math:`-1/L`, exact: the factor of the gain at which a root is on the boundary of stability.
        With a dead time an enclosure.
    gain_enclosure : Enclosure
        The same, certified.
    """

    square: Expr | Enclosure
    frequency: Enclosure | None
    gain: Expr | Enclosure
    gain_enclosure: Enclosure

    def __str__(self) -> str:
        place = "infinity" if self.frequency is None else f"{float(self.frequency):.6g}"
        return f"L < 0 at {place}: gain factor {float(self.gain_enclosure):.6g}"

    def _repr_latex_(self) -> str:
        return displayed(
            rf"L < 0, \; \omega^2 = {latex(self.square)}", f"-1/L = {latex(self.gain)}"
        )


OTHER_SIGN = "stable with the other sign of feedback"


class CountedLoop:
    """Stability of a loop by its root counts."""

    open_loop: RootCount
    closed_loop: RootCount

    @property
    def is_well_posed(self) -> bool:
        """Whether :math:`1 + L` is not zero at infinity, so that no closed-loop root is there."""
        return self.closed_loop.total == self.open_loop.total

    @property
    def is_stable(self) -> bool:
        """Whether the loop is well posed and every closed-loop root, hidden or not, is stable."""
        return self.is_well_posed and self.closed_loop.stable == self.closed_loop.total

    @property
    def encirclements(self) -> int:
        """Clockwise turns of L about -1, with poles on the boundary passed on the outer side."""
        return self.closed_loop.unstable - self.open_loop.unstable


@dataclass(frozen=True)
class StabilityMargins(CountedLoop, PhaseMargins, ExactValue):
    r"""All crossovers of a loop :math:`1 + L`, whether it is stable as it is, and its margins.

    The margins `gain_up`, `gain_down` (factors), `phase_lag`, `phase_lead`, `phase` (degrees),
    `delay` (s, in discrete time steps) and `disk` are computed when they are read. The result of
    ``rcac_numeric.stability_margins`` has the same names.

    Attributes
    ----------
    numerator, denominator : sympy.Poly
        N and D of :math:`L = -f\,G G_c`, without common factors.
    hidden : sympy.Poly
        The common factor: roots that L does not show and no gain moves.
    time : {"continuous", "discrete"}
    open_loop, closed_loop : RootCount
        Roots of D, and of D + N, the hidden ones counted in both. Nyquist's count of encirclements
        of -1, clockwise, is the difference of the unstable ones.
    gain_crossovers : tuple of GainCrossover
        By ascending frequency.
    phase_crossovers : tuple of PhaseCrossover
        By ascending frequency.
    gains : StabilityCell or None
        The interval of gain factors around 1 with which the loop is stable; None if it is not.
    """

    _REST: ClassVar[str] = ".gain_crossovers and .phase_crossovers list them"
    numerator: Poly
    denominator: Poly
    hidden: Poly
    time: Time
    open_loop: RootCount
    closed_loop: RootCount
    gain_crossovers: tuple[GainCrossover, ...]
    phase_crossovers: tuple[PhaseCrossover, ...]
    gains: StabilityCell | None

    @property
    def is_real(self) -> bool:
        """Whether L is real at all frequencies, so that none of them is a crossover by itself."""
        return bool(squared(*self._in_half_plane())[1].is_zero)

    @property
    def is_all_pass(self) -> bool:
        """Whether abs(L) is 1 at all frequencies, so that none is a gain crossover by itself.

        Such a loop is stable for L = 1 alone (hidden roots apart), with a phase margin of 180
        degrees at each of them: on the unit circle an L that keeps from -1 does not turn about it,
        and an L with poles turns about 0 as often as it has more stable than unstable ones.
        """
        N, D = self._in_half_plane()
        return bool(squared(N, N)[0] == squared(D, D)[0])

    def _in_half_plane(self) -> tuple[Poly, Poly]:
        """N and D, in discrete time mapped to the half plane."""
        size = int(self.denominator.degree())
        if self.time == "continuous":
            return self.numerator, self.denominator
        return half_plane_image(self.numerator, size), half_plane_image(self.denominator, size)

    @property
    def gain_up(self) -> Margin | None:
        """The least factor above 1 of the gain that ends stability; None for an unstable loop."""
        return self._gain(up=True)

    @property
    def gain_down(self) -> Margin | None:
        """The largest factor in (0, 1) that does so, or 0; None for an unstable loop."""
        return self._gain(up=False)

    def _gain(self, *, up: bool) -> Margin | None:
        if self.gains is None or not self.is_stable:
            return None
        crossings = [
            (c.gain_enclosure, sympy.oo if c.frequency is None else c.frequency)
            for c in self.phase_crossovers
        ]
        return nearest_gain(self.gains.upper if up else self.gains.lower, crossings, up=up)

    def _phase(self, *, lead: bool) -> Margin | None:
        if not self.is_stable:
            return None
        N, D = self.numerator, self.denominator
        if self.time == "discrete":
            ends = [(N.eval(1), D.eval(1), ZERO), (N.eval(-1), D.eval(-1), half_circle())]
        else:
            size = int(D.degree())
            ends = [
                (N.eval(0), D.eval(0), ZERO),
                (N.coeff_monomial(D.gen**size), D.LC(), sympy.oo),
            ]
        at_one = [place for top, bottom, place in ends if top == bottom]
        crossings = [(c.phase_margin, c.frequency) for c in self.gain_crossovers]
        return nearest_phase(crossings, at_one, lead=lead)

    @cached_property
    def delay(self) -> Margin | None:
        r"""The least delay that makes the loop unstable, in s, in discrete time in steps.

        None for an unstable loop. In continuous time every delay does where :math:`|L| \ge 1` at
        infinity. In discrete time, where :math:`|L(-1)| > 1`, whole steps decide.
        """
        if not self.is_stable:
            return None
        N, D = self.numerator, self.denominator
        crossings = [(c.delay, c.frequency) for c in self.gain_crossovers]
        if self.time == "discrete":
            return nearest_delay_in_steps(N, D, crossings, self._outward())
        if N.degree() == D.degree() and abs(N.LC()) >= abs(D.LC()):
            return Margin(ZERO, sympy.oo)
        return nearest(crossings)

    def _outward(self) -> list[bool]:
        """Whether a growing delay moves the root of each gain crossover outward, or it turns."""
        N, D = self._in_half_plane()
        top, bottom = squared(N, N)[0], squared(D, D)[0]
        slope = (bottom - top).diff(SQUARE)
        return [
            signs_at_real_roots(slope, factor)[index] >= 0
            for factor, index, _ in _frequencies_of_gain_1(top, bottom)
        ]

    @property
    def disk(self) -> SymmetricDiskMargin | None:
        """The symmetric disk margin, computed when it is read; None for an unstable loop."""
        if not self.is_stable:
            return None
        return SymmetricDiskMargin(self.numerator, self.denominator)

    @property
    def _has_stable_opposite(self) -> bool:
        """Whether the unstable loop is stable with the other sign of feedback: 1 - L."""
        if self.is_stable:
            return False
        roots = self.denominator - self.numerator
        if roots.degree() < self.denominator.degree():
            return False
        counts = count_roots(roots * self.hidden, time=self.time)
        return bool(counts.stable == counts.total)

    def __str__(self) -> str:
        verdict = "stable" if self.is_stable else f"not stable ({self.closed_loop})"
        if not self.is_well_posed:
            verdict = f"not well posed: 1 + L = 0 at infinity ({self.closed_loop})"
        lines = [f"the loop is {verdict}"]
        if self._has_stable_opposite:
            lines.append(OTHER_SIGN)
        if self.hidden.degree() > 0:
            lines.append(f"hidden in L, moved by no gain: {format_polynomial(self.hidden)}")
        if self.denominator.degree() == 0:
            lines.append(f"L is the constant {self.numerator.LC() / self.denominator.LC()}")
        elif self.is_real:
            pairs = "a pole s comes with -s" if self.time == "continuous" else "a pole z with 1/z"
            visible = " that is not hidden" if self.hidden.degree() > 0 else ""
            pairs = pairs.replace("a pole", f"a pole{visible},", 1) if visible else pairs
            lines.append(f"L is real at all frequencies, and {pairs}")
        if self.gains is not None:
            lines.append(f"stable for gain factors in {self.gains}")
        if self.is_all_pass:
            angle = (
                "a phase margin of 180 degrees at each of them" if self.is_stable else
                "no phase margin; stabilising_gains has the gains, if any, for which it is stable"
            )  # fmt: skip
            lines.append(f"|L| is 1 at all frequencies: {angle}")
        return "\n".join(
            [*lines, *map(str, self.gain_crossovers), *map(str, self.phase_crossovers)]
        )

    def _repr_latex_(self) -> str:
        rows = [latex(c) for c in (*self.gain_crossovers, *self.phase_crossovers)]
        return displayed(words("stable" if self.is_stable else "not stable"), *rows)


@refusing
def stability_margins(
    plant: LoopPart,
    compensator: LoopPart = 1,
    *,
    feedback: int,
    variable: str | Symbol | None = None,
) -> StabilityMargins:
    """Return the crossovers and margins of a loop of rational transfer functions."""
    G, G_c = read_loop(plant, compensator, feedback, variable=variable)
    N, D = G.numerator * G_c.numerator * -feedback, G.denominator * G_c.denominator
    if not (is_rational(N) and is_rational(D)):
        way = way_to_rational(N, D, sources=(plant, compensator))
        raise InputError(f"margins need rational coefficients; {way}")
    time = time_of(G.variable, "a margin")
    if N.degree() > D.degree():
        raise ImproperError(f"the loop {N.as_expr()} over {D.as_expr()} is improper")
    whole = closed_loop_of_pair(G, G_c, feedback)
    if whole.is_zero:
        raise ImproperError(
            "L = -1 at all frequencies, so that 1 + L is zero: the loop is not well posed"
        )
    closed, opened = count_roots(whole, time=time), count_roots(D, time=time)
    hidden = common_divisor(N, D)
    N, D = exact_quotient(N, hidden), exact_quotient(D, hidden)
    size = int(D.degree())
    top, bottom = (half_plane_image(p, size) for p in (N, D)) if time == "discrete" else (N, D)
    through = squared(top, top)[0], squared(bottom, bottom)[0]
    real, imaginary = squared(top, bottom)
    ask_for_coefficients(through[0] - through[1], size, "the frequencies of the margins")
    balls = cache(real_root_balls)  # a factor is isolated once for all its roots
    gain_crossovers = [
        _gain_crossover(factor, index, value, top, bottom, time, balls)
        for factor, index, value in _frequencies_of_gain_1(*through)
    ]
    phase_crossovers = []
    if not imaginary.is_zero:
        phase_crossovers = _phase_crossovers(real, imaginary, through[1], size, time, balls)
    cells = intervals_of_gains(G, G_c, feedback=feedback).intervals
    around = next((cell for cell in cells if 1 in cell), None)
    return StabilityMargins(
        N, D, hidden, time, opened, closed, tuple(gain_crossovers), tuple(phase_crossovers), around
    )


def _frequencies_of_gain_1(top: Poly, bottom: Poly) -> list[tuple[Poly, int, Expr]]:
    """Return the positive roots of |N|^2 - |D|^2; empty if it vanishes identically."""
    return [] if top == bottom else positive_roots(top - bottom)


def squared(first: Poly, second: Poly) -> tuple[Poly, Poly]:
    """Return real and imaginary part of N(jw) D(-jw), the latter over w, in x = w**2."""
    s = first.gen
    even, odd = even_and_odd(first * second.compose(Poly(-s, s, domain=QQ)))

    def at_minus_x(poly: Poly) -> Poly:
        terms = {k: c * (-1) ** int(k[0]) for k, c in poly.terms()}
        return Poly(terms, SQUARE, domain=QQ)

    return at_minus_x(even), at_minus_x(odd)


def positive_roots(poly: Poly) -> list[tuple[Poly, int, Expr]]:
    """Return (irreducible factor, index among its real roots, value) of the positive roots."""
    factors = [factor for factor, _ in poly.factor_list()[1]]
    roots = []
    for factor in factors:
        signs = signs_at_real_roots(Poly(factor.gen, factor.gen, domain=QQ), factor)
        for index, root in enumerate(real_roots([factor])):
            if signs[index] > 0:
                roots.append((root.enclosure.centre, factor, index, root.value))
    return [(factor, index, value) for _, factor, index, value in sorted(roots, key=lambda r: r[0])]


def real_root_balls(factor: Poly, bits: int) -> list[flint.arb]:
    """Return balls around the real roots, ascending; inside of a block of that precision."""
    real = [ball.real for ball, _ in root_balls(factor, bits) if ball.imag == 0]
    return sorted(real, key=lambda ball: ball.mid())


def _value_at(poly: Poly, point: flint.acb) -> flint.acb:
    return flint.acb_poly(to_flint_polynomial(poly))(point)


def frequency_of(square: flint.arb, time: Time) -> flint.arb:
    """Return the frequency whose square, or that of its tangent's half, is given."""
    root = square.sqrt()
    return root if time == "continuous" else 2 * root.atan()


def vanishes_at(poly: Poly, factor: Poly) -> bool:
    """Whether a polynomial in s vanishes at +-j sqrt(x) for the positive roots x of a factor."""
    for part in even_and_odd(poly):
        terms = {k: c * (-1) ** int(k[0]) for k, c in part.terms()}
        if not Poly(terms, factor.gen, domain=QQ).rem(factor).is_zero:
            return False
    return True


def _gain_crossover(
    factor: Poly, index: int, value: Expr, top: Poly, bottom: Poly, time: Time, balls: Balls
) -> GainCrossover:
    """N and D are coprime, so that neither is zero where their moduli are equal."""
    is_minus_one, is_one = vanishes_at(top + bottom, factor), vanishes_at(top - bottom, factor)

    def attempt(bits: int) -> tuple[Enclosure, ...] | None:
        square = balls(factor, bits)[index]
        omega = frequency_of(square, time)
        if is_minus_one:  # a root on the boundary
            return narrow(omega, flint.arb(0), flint.arb(0))
        margin = flint.arb.pi()
        if not is_one:  # so that -L is not real
            s = flint.acb(0, square.sqrt())
            below = _value_at(bottom, s)
            turned = -_value_at(top, s) / below
            if below.contains(0) or turned.imag.contains(0):
                return None
            margin = turned.arg()
        lag = margin if margin > 0 else margin + 2 * flint.arb.pi()
        return narrow(omega, margin, lag / omega)

    return GainCrossover(value, *at_growing_precision(attempt, 160, "a phase margin"))


def _phase_crossovers(
    real: Poly, imaginary: Poly, below: Poly, size: int, time: Time, balls: Balls
) -> list[PhaseCrossover]:
    zero = Enclosure(Rational(0), Rational(0))
    crossovers = []
    at_zero, under = real.eval(0), below.eval(0)
    if under != 0 and at_zero < 0:
        factor = -under / at_zero
        crossovers.append(PhaseCrossover(Rational(0), zero, factor, Enclosure(factor, Rational(0))))
    signs, quotients = {}, {}
    for factor, index, value in positive_roots(imaginary):
        if below.rem(factor).is_zero:
            continue  # a pole of L on the boundary
        if real.rem(factor).is_zero:
            continue  # a zero of L
        if factor not in signs:
            signs[factor] = signs_at_real_roots(real, factor)
            quotients[factor] = -quotient_modulo(factor, below, real)
        if signs[factor][index] < 0:
            quotient = quotients[factor]
            crossovers.append(
                _phase_crossover(factor, index, value, real, below, quotient, time, balls)
            )
    last, least = (p.coeff_monomial(SQUARE**size) for p in (real, below))
    if least != 0 and last < 0:
        factor, edge = -least / last, None
        if time == "discrete":
            with ball_precision(160):
                edge = enclosure_of_ball(flint.arb.pi())
        crossovers.append(PhaseCrossover(sympy.oo, edge, factor, Enclosure(factor, Rational(0))))
    return crossovers


def _phase_crossover(
    factor: Poly, index: int, value: Expr, real: Poly, below: Poly, quotient: Poly, time: Time,
    balls: Balls,
) -> PhaseCrossover:  # fmt: skip
    above, under = (to_flint_polynomial(p.rem(factor)) for p in (real, below))

    def attempt(bits: int) -> tuple[Enclosure, ...] | None:
        square = balls(factor, bits)[index]
        top, bottom = (flint.arb_poly(p)(square) for p in (under, above))
        if bottom.contains(0):  # it is not zero: the factor does not divide it
            return None
        return narrow(frequency_of(square, time), -top / bottom)

    frequency, enclosure = at_growing_precision(attempt, 160, "a gain margin")
    return PhaseCrossover(value, frequency, value_at_root(quotient, value), enclosure)


def value_at_root(poly: Poly, root: Expr) -> Expr:
    """Return the value of a polynomial at a rational number, a square root or an indexed root."""
    if root.is_Rational:
        return poly.eval(root)
    if not root.has(sympy.CRootOf):
        return sympy.expand(poly.as_expr().subs(poly.gen, root))
    # SymPy's expand asks an indexed root for its polynomial again and again.
    return sympy.Add(*(c * root ** int(k) for (k,), c in poly.terms()))
