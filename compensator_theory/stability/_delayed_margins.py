"""Margins of loops with a dead time; and the public function for loops with one or without."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import flint
import sympy
from sympy import Expr, Poly, Rational, Symbol

from compensator_theory._latex import displayed, latex, words
from compensator_theory._printing import text
from compensator_theory.errors import InputError
from compensator_theory.loops._siso import LoopPart, read_loop
from compensator_theory.matrices._flint_polynomials import to_flint_polynomial
from compensator_theory.polynomials._ball_precision import at_growing_precision
from compensator_theory.polynomials._budget import quoted
from compensator_theory.polynomials._carrying import carried_by
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import (
    common_divisor,
    exact_quotient,
    is_rational,
    way_to_rational,
)
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import Time, time_of
from compensator_theory.roots._counts import count_roots
from compensator_theory.roots._enclosures import Enclosure, ball_of_number
from compensator_theory.roots._root_counts import RootCount
from compensator_theory.stability import _margins
from compensator_theory.stability._delays import StabilityDelays, stability_delays
from compensator_theory.stability._enclosed_margins import (
    EnclosedStabilityMargins,
    margins_with_exponentials,
)
from compensator_theory.stability._enclosed_norms import narrow
from compensator_theory.stability._margins import (
    ZERO,
    Balls,
    GainCrossover,
    PhaseCrossover,
    StabilityMargins,
    positive_roots,
    real_root_balls,
    squared,
)
from compensator_theory.stability._nearest_margins import (
    Crossing,
    CrossingGains,
    Margin,
    PhaseMargins,
    nearest,
    nearest_phase,
)
from compensator_theory.stability._phase_crossovers import DelayedCurve, crossings_to_best
from compensator_theory.systems._dead_times import with_dead_time
from compensator_theory.systems._delayed_transfer_functions import (
    DelayedTransferFunction,
    way_of_pade,
)


@dataclass(frozen=True)
class DelayedStabilityMargins(CrossingGains, PhaseMargins, ExactValue):
    r"""The crossovers of a loop with one dead time, whether it is stable, and its margins.

    .. math:: 1 + L, \qquad L = -f\,G G_c = \frac{N(s)}{D(s)}\,e^{-\theta s}, \qquad
              \deg N < \deg D

    The margins `gain_up`, `gain_down` (factors), `phase_lag`, `phase_lead`, `phase` (degrees) and
    `delay` (s, in addition to the dead time) are named as in :class:`StabilityMargins`.

    Attributes
    ----------
    numerator, denominator : sympy.Poly
        N and D, without common factors.
    hidden : sympy.Poly
        The common factor: roots that L does not show and no gain moves.
    dead_time : sympy.Rational
        :math:`\theta` in s.
    open_loop : RootCount
        Roots of D, the hidden ones counted.
    unstable_roots : int
        Closed-loop roots in the open right half plane, the hidden ones counted, exactly.
    gain_crossovers : tuple of GainCrossover
        By ascending frequency, all of them.
    phase_crossovers : tuple of PhaseCrossover
        By ascending frequency, up to `highest_frequency`. There are infinitely many.
    highest_frequency : sympy.Rational
        In rad/s; beyond it each gain factor exceeds the least one above 1 in the list.
    """

    _REST: ClassVar[str] = ".gain_crossovers and .phase_crossovers list them"
    numerator: Poly
    denominator: Poly
    hidden: Poly
    dead_time: Rational
    open_loop: RootCount
    unstable_roots: int
    gain_crossovers: tuple[GainCrossover, ...]
    phase_crossovers: tuple[PhaseCrossover, ...]
    highest_frequency: Rational

    @property
    def time(self) -> Time:
        """Continuous."""
        return "continuous"

    @property
    def is_well_posed(self) -> bool:
        """True: L is strictly proper."""
        return True

    @property
    def is_stable(self) -> bool:
        """Whether every closed-loop root, hidden or not, is in the open left half plane."""
        if self.hidden.degree() > 0 and count_roots(self.hidden, time="continuous").boundary:
            return False
        return self.unstable_roots == 0

    @property
    def encirclements(self) -> int:
        """Clockwise turns of L about -1, with poles on the boundary passed on the outer side."""
        return self.unstable_roots - self.open_loop.unstable

    @property
    def delays(self) -> StabilityDelays | None:
        """Every dead time with which the loop is stable; None if L is 0."""
        return _delays_of(self.numerator, self.denominator)

    def _factors(self) -> list[Crossing]:
        return [(c.gain_enclosure, c.frequency) for c in self.phase_crossovers]

    def _phase(self, *, lead: bool) -> Margin | None:
        if not self.is_stable:
            return None
        at_one = [ZERO] if self.numerator.eval(0) == self.denominator.eval(0) else []
        crossings = [(c.phase_margin, c.frequency) for c in self.gain_crossovers]
        return nearest_phase(crossings, at_one, lead=lead)

    @property
    def delay(self) -> Margin | None:
        """The least additional delay in s that ends stability; None for an unstable loop."""
        if not self.is_stable:
            return None
        return nearest([(c.delay, c.frequency) for c in self.gain_crossovers])

    def __str__(self) -> str:
        verdict = "stable"
        if not self.is_stable:
            verdict = f"not stable (roots in the right half plane: {self.unstable_roots})"
        lines = [f"the loop is {verdict} with the dead time {text(self.dead_time)} s"]
        if self.hidden.degree() > 0:
            lines.append(f"hidden in L, moved by no gain: {format_polynomial(self.hidden)}")
        return "\n".join(
            [*lines, *map(str, self.gain_crossovers), *map(str, self.phase_crossovers)]
        )

    def _repr_latex_(self) -> str:
        rows = [latex(c) for c in (*self.gain_crossovers, *self.phase_crossovers)]
        return displayed(words("stable" if self.is_stable else "not stable"), *rows)


@carried_by("none")
def stability_margins(
    plant: LoopPart | DelayedTransferFunction,
    compensator: LoopPart | DelayedTransferFunction = 1,
    *,
    feedback: int,
    variable: str | Symbol | None = None,
) -> StabilityMargins | DelayedStabilityMargins | EnclosedStabilityMargins:
    r"""Find every gain and phase crossover of a loop exactly, and its margins.

    .. math:: |N|^2 = |D|^2, \qquad \mathrm{Im}\, N(\mathrm{j}\omega) D(-\mathrm{j}\omega) = 0, \;
              \mathrm{Re} < 0, \qquad L = -f\, G G_c = N/D

    Parameters
    ----------
    plant, compensator : transfer function
        Proper, rational, in s, or in z or q, where :math:`z = (1 + w)/(1 - w)` makes an axis of the
        circle; by default the compensator is 1. In s each may have a dead time, if L is strictly
        proper: :math:`L = e^{-\theta s} N/D`.
    feedback : {+1, -1}
        The sign f; for the usual loop :math:`1 + G G_c` it is -1.
    variable : str or Symbol, optional
        Of the plant; default: evident.

    Returns
    -------
    StabilityMargins, DelayedStabilityMargins or EnclosedStabilityMargins
        Squares of frequencies and gain factors are exact, angles are certified balls of 30 digits.
        With a dead time the phase crossovers and gain factors are such balls, too; with
        exponentials of rational numbers, as sampled plants have them, all of these.

    Raises
    ------
    InputError, ImproperError
        If a coefficient is symbolic, the variable does not show the time domain, L is improper, or
        :math:`1 + L` is zero identically; or, with a dead time, L is not strictly proper, so that
        the loop is of neutral type.
    NoSolutionError
        If, with a dead time, s = 0 is a closed-loop root.

    Notes
    -----
    ``rcac_numeric.stability_margins`` answers the same in float64 for loops in z or q, those of a
    run and of a plant with several channels too.

    A margin is the distance of a *stable* loop from the boundary; the crossovers of an unstable one
    are listed all the same. Every boundary of the gain interval is a phase crossover, not the other
    way round. Where L is real at all frequencies, as :math:`1/s^2` is, none is a crossover by
    itself: `phase_crossovers` is empty and `is_real` true, and a root s that is not hidden comes
    with -s, in discrete time with 1/s, so that no gain makes a loop stable whose L has poles. Where
    :math:`1 + L` is zero at infinity the loop is not well posed, and so not stable. Where
    :math:`|L|` is 1 at all frequencies `gain_crossovers` is empty and `is_all_pass` true; no such
    loop is stable but that of L = 1.

    With a dead time the closed-loop roots in the right half plane are counted by
    :func:`stability_delays`, exactly. Phase crossovers are listed up to `highest_frequency`, beyond
    which each of the infinitely many others has a larger gain factor than `gain_up`.

    Examples
    --------
    >>> from compensator_theory import stability_margins
    >>> print(stability_margins("10/(s*(s + 1)*(s + 5))", feedback=-1))
    the loop is stable
    stable for gain factors in (0, 3)
    |L| = 1 at 1.22706: phase margin 25.39 degrees
    L < 0 at 2.23607: gain factor 3
    >>> margins = stability_margins("1/(s*(s + 1))", feedback=-1)
    >>> margins.gain_crossovers[0].square, margins.delay.value
    (-1/2 + sqrt(5)/2, 1.15061414365604986842 ± 5.0e-21)
    >>> print(margins.phase)  # degrees, at rad/s
    51.8273 at 0.786151
    >>> late = stability_margins("2*exp(-3*s)/(10*s + 1)", feedback=-1)
    >>> print(late)
    the loop is stable with the dead time 3 s
    |L| = 1 at 0.173205: phase margin 90.23 degrees
    L < 0 at 0.580466: gain factor 2.94508
    >>> print(late.gain_up, late.delay, sep="; ")  # and s, at rad/s
    2.94508 at 0.580466; 9.092 at 0.173205
    >>> from compensator_theory.sampling import zero_order_hold
    >>> print(stability_margins(zero_order_hold("1/(s*(s + 1))", "1/2"), feedback=-1))
    the loop is stable with x = exp(-1/2)
    |L| = 1 at 0.39125: phase margin 40.76 degrees
    L < 0 at 0.963168: gain factor 4.36199
    L < 0 at 3.14159: gain factor 196.799
    """
    parts: list[Any] = [plant, compensator]
    dead_time: Expr = sympy.Integer(0)
    for k, named in enumerate((variable, None)):
        part = with_dead_time(parts[k], named)
        if part is not None:
            parts[k] = part
        if isinstance(part, DelayedTransferFunction):
            parts[k], dead_time = part.rational, dead_time + part.delay
    if dead_time == 0:
        sampled = margins_with_exponentials(parts, feedback, variable)
        if sampled is not None:
            return sampled
        return _margins.stability_margins(*parts, feedback=feedback, variable=variable)
    return _delayed_margins(parts, dead_time, feedback, variable)


def _delayed_margins(
    parts: list[Any], dead_time: Expr, feedback: int, variable: str | Symbol | None
) -> DelayedStabilityMargins:
    plant, compensator = parts
    G, G_c = read_loop(plant, compensator, feedback, variable=variable)
    N, D = G.numerator * G_c.numerator * -feedback, G.denominator * G_c.denominator
    if not (is_rational(N) and is_rational(D)):
        way = way_to_rational(N, D, sources=(plant, compensator))
        raise InputError(f"margins need rational coefficients; {way}")
    if not dead_time.is_Rational:
        names = ", ".join(sorted(symbol.name for symbol in dead_time.free_symbols))
        raise InputError(f"margins need a number for the dead time; substitute numbers for {names}")
    time_of(G.variable, "a margin")
    if N.degree() >= D.degree():
        raise InputError(
            f"L = {quoted(N)} over {quoted(D)} with a dead time is not strictly proper, so that "
            "the loop is of neutral type, whose roots are not counted; include the roll-off, as in "
            f"G/(1 + {G.variable}/100), ",
            way_of_pade("or approximate the dead time, G.pade({order})"),
        )
    hidden = common_divisor(N, D)
    opened = count_roots(D, time="continuous")
    N, D = exact_quotient(N, hidden), exact_quotient(D, hidden)
    delays = _delays_of(N, D)
    if delays is None:
        return DelayedStabilityMargins(
            N, D, hidden, dead_time, opened, opened.unstable, (), (), Rational(0)
        )
    unstable = delays.unstable_roots(dead_time)
    if hidden.degree() > 0:
        unstable += count_roots(hidden, time="continuous").unstable
    balls = cache(real_root_balls)
    gain_crossovers = [
        _gain_crossover(factor, index, value, N, D, dead_time, balls)
        for factor, index, value in positive_roots(squared(N, N)[0] - squared(D, D)[0])
    ]
    last = gain_crossovers[-1].frequency if gain_crossovers else None
    crossings, highest = crossings_to_best(DelayedCurve(N, D, dead_time), last)
    phase_crossovers = [
        PhaseCrossover(_square(frequency), frequency, factor, factor)
        for frequency, factor in crossings
    ]
    if N.eval(0) * D.eval(0) < 0:
        factor = -D.eval(0) / N.eval(0)
        at_zero = PhaseCrossover(Rational(0), ZERO, factor, Enclosure(factor, Rational(0)))
        phase_crossovers.insert(0, at_zero)
    return DelayedStabilityMargins(
        N, D, hidden, dead_time, opened, unstable, tuple(gain_crossovers),
        tuple(phase_crossovers), highest,
    )  # fmt: skip


def _delays_of(N: Poly, D: Poly) -> StabilityDelays | None:
    """Return the stable delays of D + N exp(-tau s), coprime."""
    return None if N.is_zero else stability_delays([D, N])


def _gain_crossover(
    factor: Poly, index: int, value: Expr, N: Poly, D: Poly, dead_time: Rational, balls: Balls
) -> GainCrossover:
    """Return a gain crossover: L is real at none, as its angle is transcendental (Lindemann)."""

    def attempt(bits: int) -> tuple[Enclosure, ...] | None:
        top, bottom = (flint.acb_poly(to_flint_polynomial(p)) for p in (N, D))  # at this precision
        omega = balls(factor, bits)[index].sqrt()
        s = flint.acb(0, omega)
        below = bottom(s)
        if below.contains(0):
            return None
        turned = -top(s) / below * (-s * ball_of_number(dead_time)).exp()
        if turned.imag.contains(0):
            return None
        margin = turned.arg()
        lag = margin if margin > 0 else margin + 2 * flint.arb.pi()
        return narrow(omega, margin, lag / omega)

    return GainCrossover(value, *at_growing_precision(attempt, 160, "a phase margin"))


def _square(frequency: Enclosure) -> Enclosure:
    """Return an enclosure of the square of a positive number."""
    centre, radius = frequency.centre, frequency.radius
    return Enclosure(centre**2 + radius**2, 2 * centre * radius)
