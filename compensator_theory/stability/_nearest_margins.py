"""The margins of a stable loop: the nearest change of gain, phase and delay, and the disk."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import count
from typing import Any, TypeAlias

import flint
import sympy
from sympy import Expr, Poly, Rational

from compensator_theory import figures
from compensator_theory._latex import displayed, latex
from compensator_theory._showing import picture_of
from compensator_theory.polynomials._ball_precision import ball_precision
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.roots._certified import root_balls
from compensator_theory.roots._counts import count_roots
from compensator_theory.roots._enclosures import Enclosure, ball_of_enclosure, enclosure_of_ball
from compensator_theory.stability._critical_values import approximation, is_less
from compensator_theory.stability._norms import HInfinityNorm, rational_norm
from compensator_theory.systems._transfer_functions import TransferFunction

BITS = 160
NOTHING = Enclosure(Rational(0), Rational(0))
Frequency: TypeAlias = Enclosure | Expr | None
Crossing: TypeAlias = tuple[Enclosure, Frequency]
"""The value of a change that puts a root on the boundary, and the frequency of that root."""


@dataclass(frozen=True)
class Margin(ExactValue):
    r"""How far a stable loop can be changed in one way before it is stable no more.

    Attributes
    ----------
    value : sympy.Expr or Enclosure
        A factor of the gain, exact; a turn of the phase in degrees, or a delay in s, in discrete
        time in steps, as certified balls. If no change ends stability it is oo, or 0 for a gain
        that falls. `float` reads each of them.
    frequency : Enclosure, sympy.oo or None
        Of the root that comes to the boundary: in rad/s, in discrete time in rad/sample; oo in
        continuous time where it comes from infinity, None where there is none.

    Examples
    --------
    >>> from compensator_theory import stability_margins
    >>> margins = stability_margins("10/(s*(s + 1)*(s + 5))", feedback=-1)
    >>> print(margins.gain_up)
    3 at 2.23607
    """

    value: Expr | Enclosure
    frequency: Frequency

    @property
    def is_reached(self) -> bool:
        """Whether there is such a change at all."""
        return self.frequency is not None

    def __str__(self) -> str:
        place = "" if self.frequency is None else f" at {float(self.frequency):.6g}"
        value = self.value if isinstance(self.value, Enclosure) else approximation(self.value)
        return f"{float(value):.6g}{place}"

    def _repr_latex_(self) -> str:
        return displayed(latex(self.value))


@dataclass(frozen=True)
class SymmetricDiskMargin(ExactValue):
    r"""The symmetric disk margin of a stable loop, and the peaks of S and T.

    .. math:: \alpha = \frac{2}{\|S - T\|_\infty}, \qquad S = \frac{1}{1 + L}, \quad
              T = \frac{L}{1 + L}, \quad L = N/D

    Every factor :math:`(1 + d/2)/(1 - d/2)` with complex :math:`|d| < \alpha` leaves the loop
    stable. Source: P. Seiler, A. Packard and P. Gahinet, IEEE Control Systems 40(5) (2020) 78-95.

    Attributes
    ----------
    numerator, denominator : sympy.Poly
        N and D, without common factors.

    Examples
    --------
    >>> from compensator_theory import stability_margins
    >>> disk = stability_margins("1/(s + 1)", feedback=-1).disk
    >>> disk.alpha, disk.gain, disk.S_peak
    (2, (0, oo), 1)
    """

    numerator: Poly
    denominator: Poly

    @property
    def alpha(self) -> Expr:
        """Exact; oo where L is 1."""
        return sympy.oo if self._norm is None else 2 / self._norm.value

    @property
    def gain(self) -> tuple[Expr, Expr]:
        """The range of gains in the disk: (2 - alpha) / (2 + alpha) and its inverse."""
        norm = self._norm
        if norm is None or not _exceeds_one(norm):
            return sympy.Integer(0), sympy.oo
        low = (norm.value - 1) / (norm.value + 1)
        return low, 1 / low

    @property
    def phase(self) -> Enclosure:
        """The turn in degrees, in both directions: 2 arctan(alpha / 2)."""
        if self._norm is None:
            return Enclosure(Rational(180), Rational(0))
        with ball_precision(BITS):
            turn = 2 * (1 / ball_of_enclosure(self._norm.enclosure)).atan()
            return enclosure_of_ball(turn * 180 / flint.arb.pi())

    @cached_property
    def S_peak(self) -> Expr:
        """The largest abs(S) over all frequencies, exact."""
        return self._of(self.denominator).value

    @cached_property
    def T_peak(self) -> Expr:
        """The largest abs(T) over all frequencies, exact."""
        if self.numerator.is_zero:
            return sympy.Integer(0)
        return self._of(self.numerator).value

    @cached_property
    def _norm(self) -> HInfinityNorm | None:
        difference = self.denominator - self.numerator
        return None if difference.is_zero else self._of(difference)

    def _of(self, numerator: Poly) -> HInfinityNorm:
        return rational_norm(TransferFunction(numerator, self.denominator + self.numerator))

    def __str__(self) -> str:
        low, high = (f"{float(end):.4g}" for end in self.gain)
        return f"alpha {float(self.alpha):.6g}: gain {low} to {high}, phase {float(self.phase):.4g}"

    def _repr_latex_(self) -> str:
        return displayed(rf"\alpha = {latex(self.alpha)}")


def _exceeds_one(norm: HInfinityNorm) -> bool:
    if 1 not in norm.enclosure:
        return bool(norm.enclosure.lower > 1)
    return norm.square_polynomial.eval(1) != 0 and bool(norm.value > 1)


def half_circle() -> Enclosure:
    """The angle pi of z = -1."""
    with ball_precision(BITS):
        return enclosure_of_ball(flint.arb.pi())


def nearest_gain(end: Expr, crossings: Iterable[Crossing], *, up: bool) -> Margin:
    """An end of the interval of gains around 1, with the crossover that it is."""
    if (end == sympy.oo) if up else not is_less(sympy.Integer(0), end):
        return Margin(sympy.oo if up else sympy.Integer(0), None)
    near = float(approximation(end))
    distances = [(abs(float(gain) - near), frequency) for gain, frequency in crossings]
    # A constant L has no crossover.
    changes = min(distances, key=lambda pair: pair[0], default=(0.0, NOTHING))[1]
    return Margin(end, changes)


class PhaseMargins:
    """The phase margins and the pictures that all loops have in common."""

    def _phase(self, *, lead: bool) -> Margin | None:
        """The least lag or lead that ends stability; None for an unstable loop."""
        raise NotImplementedError

    @property
    def phase_lag(self) -> Margin | None:
        """The least lag in degrees, in (0, 360), that ends stability; None for an unstable loop."""
        return self._phase(lead=False)

    @property
    def phase_lead(self) -> Margin | None:
        """The least lead in degrees, in (0, 360), that does so; None for an unstable loop."""
        return self._phase(lead=True)

    @property
    def phase(self) -> Margin | None:
        """The lesser of lag and lead, at most 180 degrees; None for an unstable loop."""
        lag, lead = self.phase_lag, self.phase_lead
        if lag is None or lead is None:
            return None
        return lead if bool(float(lead.value) < float(lag.value)) else lag

    def plot(self, view: str = "all", **options: Any) -> figures.Figure:
        """Draw Nyquist's curve and Bode's plot of L, the margins marked.

        Parameters
        ----------
        view : {"all", "nyquist", "bode"}
            One of them, or both.
        ax : matplotlib Axes or sequence of Axes, optional
            Where it is drawn instead of in a new figure: one pair of axes for Nyquist's curve, two
            for Bode's plot, three for both.
        width : float
            Of the figure in inches; 3.5 fits the column of a journal.

        Returns
        -------
        matplotlib.figure.Figure
            Not attached to a window.

        Raises
        ------
        InputError
            If the view is none of these, `ax` has not as many axes, or the figure is narrower than
            3 inches.

        Examples
        --------
        >>> from compensator_theory import stability_margins
        >>> figure = stability_margins("10/(s*(s + 1)*(s + 5))", feedback=-1).plot("bode")
        >>> [axis.get_title() for axis in figure.axes]
        ['gain margin 3 at 2.24', 'phase margin 25.4 degrees at 1.23']
        """
        return picture_of(self, view=view, **options)


class CrossingGains:
    """The gain margins of a loop by the factors that put a root on the boundary."""

    @property
    def is_stable(self) -> bool:
        """Whether the loop is stable as it is."""
        raise NotImplementedError

    def _factors(self) -> list[Crossing]:
        """The positive factors, none of which is 1 for a stable loop, with their frequencies."""
        raise NotImplementedError

    @property
    def gain_up(self) -> Margin | None:
        """The least factor above 1 of the gain that ends stability; None for an unstable loop."""
        if not self.is_stable:
            return None
        return nearest([crossing for crossing in self._factors() if crossing[0].lower > 1])

    @property
    def gain_down(self) -> Margin | None:
        """The largest factor in (0, 1) that does so, or 0; None for an unstable loop."""
        if not self.is_stable:
            return None
        below = [crossing for crossing in self._factors() if crossing[0].upper < 1]
        if not below:
            return Margin(sympy.Integer(0), None)
        return Margin(*max(below, key=lambda pair: pair[0].centre))


def nearest_phase(
    crossings: Sequence[Crossing], ends: Sequence[Frequency], *, lead: bool
) -> Margin:
    """The least turn, in degrees, of crossovers with their arg(-L), and of ends where L is 1."""
    changes: list[Crossing] = [(Enclosure(Rational(180), Rational(0)), end) for end in ends]
    with ball_precision(BITS):
        for margin, frequency in crossings:
            degrees = ball_of_enclosure(margin) * 180 / flint.arb.pi()
            lag = degrees if margin.centre > 0 else degrees + 360
            changes.append((enclosure_of_ball(360 - lag if lead else lag), frequency))
    return nearest(changes)


def nearest(crossings: Sequence[Crossing]) -> Margin:
    """The least of the changes; oo where there is none."""
    if not crossings:
        return Margin(sympy.oo, None)
    return Margin(*min(crossings, key=lambda pair: pair[0].centre))


def nearest_delay_in_steps(
    N: Poly, D: Poly, crossings: Sequence[Crossing], outward: Sequence[bool]
) -> Margin:
    """The least delay of a discrete loop: of the crossovers where abs(L(-1)) <= 1.

    Else a delay between two whole numbers of steps has no meaning, whole steps decide,
    and a crossover counts only where it lies in the step in which stability is lost.
    """
    top, bottom = N.eval(-1), D.eval(-1)
    if bottom != 0 and abs(top) <= abs(bottom):
        at_half = [(Enclosure(Rational(1), Rational(0)), half_circle())] if top == bottom else []
        return nearest([*crossings, *at_half])
    z = D.gen
    for steps in count(1):
        ask("degree", int(D.degree()) + steps, "the loop with that delay")
        delayed = D * Poly(z**steps, z, domain=D.domain) + N
        roots = count_roots(delayed, time="discrete")
        if roots.stable < roots.total:
            break
    changes = []
    with ball_precision(BITS):
        for (delay, frequency), leaves in zip(crossings, outward, strict=True):
            if not leaves or not isinstance(frequency, Enclosure):
                continue
            turn = 2 * flint.arb.pi() / ball_of_enclosure(frequency)
            for turns in range(steps + 1):
                total = enclosure_of_ball(ball_of_enclosure(delay) + turn * turns)
                if steps - 1 < total.upper and total.lower <= steps:
                    changes.append((total, frequency))
        if not changes:
            largest = max(
                (ball for ball, _ in root_balls(delayed, BITS) if ball.imag.mid() >= 0),
                key=lambda ball: abs(ball).mid(),
            )
            changes = [(Enclosure(Rational(steps), Rational(0)), enclosure_of_ball(largest.arg()))]
    return nearest(changes)
