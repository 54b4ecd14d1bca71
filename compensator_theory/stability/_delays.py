"""The exact intervals of a delay in which a loop is stable."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import flint
import sympy
from sympy import QQ, Expr, Poly, Rational, Symbol

from compensator_theory._latex import displayed, latex, words
from compensator_theory.errors import BudgetError, InputError, NoSolutionError
from compensator_theory.matrices._flint_polynomials import to_flint_polynomial
from compensator_theory.polynomials._ball_precision import ball_precision
from compensator_theory.polynomials._budget import ask, listed
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._reading import PolynomialLike, in_one_variable
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import time_of
from compensator_theory.roots._certified import root_balls
from compensator_theory.roots._counts import count_roots, require_rational
from compensator_theory.roots._enclosures import Enclosure, enclosure_of_ball
from compensator_theory.stability._critical_values import (
    even_and_odd,
    real_roots,
    signs_at_real_roots,
)
from compensator_theory.stability._margins import vanishes_at

SQUARE = Symbol("x")
BITS = (160, 320, 640, 1280, 2560, 5120)


@dataclass(frozen=True)
class DelayCrossing(ExactValue):
    r"""A frequency at which roots cross the imaginary axis, again and again as the delay grows.

    Attributes
    ----------
    square : sympy.Expr
        :math:`\omega^2`, exact.
    frequency : Enclosure
        In rad/s.
    tendency : {+1, -1, 0}
        At every one of its delays a pair of roots becomes unstable, stable, or touches the axis.
    first, period : Enclosure
        The least delay, 0 included, and :math:`2\pi/\omega`, by which the others follow, in s.
    """

    square: Expr
    frequency: Enclosure
    tendency: int
    first: Enclosure
    period: Enclosure

    def __str__(self) -> str:
        way = {1: "become unstable", -1: "become stable", 0: "touch the axis"}[self.tendency]
        return (
            f"at {float(self.frequency):.6g} rad/s a pair of roots {way} for delays "
            f"{float(self.first):.6g} + {float(self.period):.6g} l"
        )

    def _repr_latex_(self) -> str:
        first, period = f"{float(self.first):.6g}", f"{float(self.period):.6g}"
        return displayed(
            rf"\omega^2 = {latex(self.square)}", rf"\tau \approx {first} + {period}\,l",
            f"{self.tendency:+d}" if self.tendency else "0",
        )  # fmt: skip


@dataclass(frozen=True)
class StabilityDelays(ExactValue):
    r"""The delays for which all roots of a quasi-polynomial are stable.

    .. math:: P(s) = \sum_k a_k(s)\, e^{-k\tau s}

    Attributes
    ----------
    coefficients : tuple of sympy.Poly
        :math:`a_0, a_1, \ldots`
    unstable_without : int
        How many roots are unstable for small positive delays.
    crossings : tuple of DelayCrossing
        By descending frequency.
    windows : tuple of pairs of Enclosure and Enclosure or None
        The open intervals of positive delays in which every root is stable, but for the delays at
        which roots touch the axis; None: there is no end.
    """

    _REST: ClassVar[str] = ".crossings lists them"
    coefficients: tuple[Poly, ...]
    unstable_without: int
    crossings: tuple[DelayCrossing, ...]
    windows: tuple[tuple[Enclosure, Enclosure | None], ...]

    def unstable_roots(self, delay: NumberLike) -> int:
        """Return how many roots are unstable for a positive rational delay, exactly.

        A rational delay is never one at which roots cross: these are angles of algebraic numbers
        over algebraic numbers, and transcendental (Lindemann).

        Raises
        ------
        InputError
            If the delay is not a positive rational number.
        """
        value = exact_number(delay)
        if not (value.is_Rational and value > 0):
            raise InputError(f"the delay {value} must be a positive rational number")
        total = self.unstable_without
        for crossing in self.crossings:
            if crossing.tendency:
                total += 2 * crossing.tendency * _number_before(crossing, value)
        return total

    def __contains__(self, delay: NumberLike) -> bool:
        return self.unstable_roots(delay) == 0

    def __str__(self) -> str:
        terms = [f"({format_polynomial(self.coefficients[0])})"]
        for k, a in enumerate(self.coefficients[1:], 1):
            terms.append(f"({format_polynomial(a)})*exp(-{'' if k == 1 else f'{k}*'}tau*s)")
        parts = []
        for lower, upper in self.windows:
            end = "oo" if upper is None else f"{float(upper):.6g}"
            parts.append(f"({float(lower):.6g}, {end})")
        where = " or ".join(parts)
        verdict = f"is stable for tau in {where}" if where else "is stable for no positive tau"
        touching = [c for c in self.crossings if c.tendency == 0]
        lines = [f"{' + '.join(terms)} {verdict}", *(f"but {c}" for c in touching if where)]
        return "\n".join(lines)

    def _repr_latex_(self) -> str:
        parts = []
        for lower, upper in self.windows:
            end = r"\infty" if upper is None else f"{float(upper):.6g}"
            parts.append(rf"\left({float(lower):.6g}, {end}\right)")
        where = r" \cup ".join(parts) or r"\emptyset"
        return displayed(rf"{words('stable ')} \iff \tau \in {where}")


@refusing
def stability_delays(
    coefficients: Sequence[PolynomialLike], variable: str | Symbol | None = None
) -> StabilityDelays:
    r"""Find every delay for which a loop with delays is stable.

    .. math:: P(s, z) = \sum_k a_k(s) z^k, \qquad
              H(s) = \mathrm{Res}_z\!\left(P(s, z),\, z^n P(-s, 1/z)\right)

    At the imaginary roots of H, and nowhere else, roots can cross the axis: there
    :math:`z = e^{-\mathrm{j}\omega\tau}` gives the delays, and the way they cross is the same for
    all of them.

    Parameters
    ----------
    coefficients : list of polynomials
        :math:`a_0, a_1, \ldots, a_n`, rational, in s, :math:`\deg a_0 > \deg a_k`: of a loop with
        one delay and the sign f they are :math:`D D_c` and :math:`-f N N_c`.
    variable : str or Symbol, optional
        Default: evident from all of them, or s.

    Returns
    -------
    StabilityDelays
        Windows with certified ends of 30 digits, and the number of unstable roots for any rational
        delay.

    Raises
    ------
    NoSolutionError
        If a root is on the axis for every delay, or the direction of a crossing is not decided
        by the signs that are computed here: several roots cross at one frequency with several
        multiples of the delay, or a root on the axis without delay only touches it.
    InputError, BudgetError
        If the equation is of neutral or advanced type, a coefficient is symbolic, or two ends lie
        closer than 5000 bits tell.

    Notes
    -----
    Source: K. L. Cooke, P. van den Driessche, Funkcialaj Ekvacioj 29 (1986) 77-90; K. Walton, J. E.
    Marshall, IEE Proc. D 134 (1987) 101-107; N. Olgac, R. Sipahi, IEEE Trans. Automatic Control 47
    (2002) 793-797. That no delay of theirs is rational, and hence the number at a rational delay
    exact, is Lindemann's theorem.

    Examples
    --------
    >>> from compensator_theory import stability_delays
    >>> print(stability_delays(["s", "1"]))  # to pi/2
    (s) + (1)*exp(-tau*s) is stable for tau in (0, 1.5708)
    >>> delays = stability_delays(["s**2 + 4", "-1"])
    >>> print(delays)
    (s**2 + 4) + (-1)*exp(-tau*s) is stable for tau in (0, 1.40496) or (3.6276, 4.21489)
    >>> "4" in delays, delays.unstable_roots(5)
    (True, 2)
    """
    if isinstance(coefficients, str):
        raise InputError(
            "give a list, a_0, a_1, ... of a_0(s) + a_1(s) exp(-tau s) + ...: for N/D in negative "
            "feedback with a delay give [D, N]"
        )
    coefficient_list = listed(coefficients, "degree", "the list of coefficients")
    if len(coefficient_list) < 2:
        raise InputError("give a_0, a_1, ...: without a delay use decide_stability")
    polys = in_one_variable(*coefficient_list, variable=variable, default="s")
    polys = tuple(p if p.is_zero else require_rational(p) for p in polys)
    if time_of(polys[0].gen, "a delay in s") == "discrete":
        raise InputError("in discrete time a delay is a power of the variable; write it out")
    while len(polys) > 2 and polys[-1].is_zero:
        polys = polys[:-1]
    if polys[0].is_zero or any(
        not p.is_zero and p.degree() >= polys[0].degree() for p in polys[1:]
    ):
        raise InputError(
            "the degree of a_0 must exceed that of every other coefficient; equations of neutral "
            "or advanced type are not treated"
        )
    whole = sum(polys[1:], polys[0])
    ask("degree", int(polys[0].degree()) * 2 * (len(polys) - 1), "the resultant")
    if whole.eval(0) == 0:
        raise NoSolutionError("s = 0 is a root for every delay, so no delay makes the loop stable")
    if polys[-1].is_zero:  # of two: no coefficient is delayed
        counted = count_roots(polys[0], time="continuous")
        if counted.boundary:
            raise NoSolutionError("a root is on the imaginary axis for every delay: a_1 is zero")
        return StabilityDelays(polys, counted.unstable, (), _windows(counted.unstable, ()))
    crossings, at_once = [], 0
    H = _resultant(polys)
    if H.is_zero:
        raise NoSolutionError(
            "for every delay a root is on the imaginary axis, or a pair symmetric about it: the "
            "coefficients share such a factor; divide it out first"
        )
    for factor, multiplicity in H.factor_list()[1]:
        signs = signs_at_real_roots(Poly(SQUARE, SQUARE, domain=QQ), factor)
        for index, root in enumerate(real_roots([factor])):
            if signs[index] > 0:
                crossing = _crossing(polys, H, factor, int(multiplicity), index, root.value, whole)
                crossings.append(crossing)
                at_once += crossing.tendency > 0 and crossing.first.centre == 0
    crossings.sort(key=lambda crossing: crossing.frequency.centre, reverse=True)
    # Roots on the axis without delay have left it, to where the crossing says; the later delays
    # of the same crossing follow.
    unstable = count_roots(whole, time="continuous").unstable
    windows = _windows(unstable, crossings)
    moved = tuple(c for c in crossings if not (c.first.centre == c.first.radius == 0))
    later = tuple(_later(c) for c in crossings if c not in moved)
    every = tuple(sorted((*moved, *later), key=lambda c: c.frequency.centre, reverse=True))
    return StabilityDelays(polys, unstable + 2 * at_once, every, windows)


def _later(crossing: DelayCrossing) -> DelayCrossing:
    """Return the crossing without its delay 0, which `unstable_without` counts."""
    return DelayCrossing(
        crossing.square, crossing.frequency, crossing.tendency, crossing.period, crossing.period
    )


def _resultant(polys: Sequence[Poly]) -> Poly:
    """Return H as a polynomial in x = w**2."""
    s = polys[0].gen
    context = flint.fmpq_mpoly_ctx.get(["z", "s"], flint.Ordering.lex)
    n = len(polys) - 1
    sides: list[dict[tuple[int, int], flint.fmpq]] = [{}, {}]
    for k, poly in enumerate(polys):
        for power, c in enumerate(to_flint_polynomial(poly).coeffs()):
            if c:
                sides[0][k, power] = c
                sides[1][n - k, power] = -c if power % 2 else c
    first, second = (context.from_dict(side) for side in sides)
    eliminated = first.resultant(second, "z").to_dict()
    terms = {int(powers[1]): QQ(int(c.p), int(c.q)) for powers, c in eliminated.items()}
    even, odd = even_and_odd(Poly({(k,): c for k, c in terms.items()} or 0, s, domain=QQ))
    assert odd.is_zero
    halved = {k: c * (-1) ** int(k[0]) for k, c in even.terms()}
    return Poly(halved, SQUARE, domain=QQ)


def _crossing(
    polys: Sequence[Poly],
    H: Poly,
    factor: Poly,
    multiplicity: int,
    index: int,
    value: Expr,
    whole: Poly,
) -> DelayCrossing:
    """Find z on the circle, and the tendency."""
    one = len(polys) == 2
    if not one and multiplicity > 1:
        raise NoSolutionError(
            f"several roots meet at the frequency sqrt({value}); with several multiples of the "
            "delay this case is not decided"
        )
    if one and vanishes_at(polys[1], factor):
        raise NoSolutionError("a_0 and a_1 share roots on the imaginary axis; divide them out")
    tendency = 0
    if one and multiplicity % 2:  # H is |a_0|^2 - |a_1|^2, up to a sign, and a_0 is the larger
        derivative = H if H.LC() > 0 else -H
        for _ in range(multiplicity):
            derivative = derivative.diff()
        tendency = signs_at_real_roots(derivative, factor)[index]
    at_zero = vanishes_at(whole, factor)
    for bits in BITS:
        with ball_precision(bits):
            real = [ball.real for ball, _ in root_balls(factor, bits) if ball.imag == 0]
            square = sorted(real, key=lambda ball: ball.mid())[index]
            omega = square.sqrt()
            s = flint.acb(0, omega)
            z = _on_circle(polys, s)
            if z is None:
                continue
            if not one:
                flow = _flow(polys, s, z)
                if flow is None or flow.contains(0):
                    continue
                tendency = 1 if flow > 0 else -1
            angle = -(z.arg())
            if at_zero and angle.contains(0):
                first = flint.arb(0)
            elif z.real < 0 and z.imag.contains(0):  # near the branch cut
                first = (flint.arb.pi() - (-z).arg()) / omega
            elif angle.contains(0):
                continue
            else:
                first = (angle if angle > 0 else angle + 2 * flint.arb.pi()) / omega
            enclosures = [enclosure_of_ball(x) for x in (omega, first, 2 * flint.arb.pi() / omega)]
            if all(x.radius <= Rational(1, 10**30) for x in enclosures):
                if at_zero and first == 0 and tendency == 0:
                    raise NoSolutionError(
                        "a root on the imaginary axis without delay only touches it; its "
                        "direction is not decided"
                    )
                return DelayCrossing(value, enclosures[0], tendency, enclosures[1], enclosures[2])
    raise BudgetError(
        f"the tendency at the frequency sqrt({value}) needs more than {BITS[-1]} bits"
    )


def _values(polys: Sequence[Poly], s: flint.acb) -> list[flint.acb]:
    return [flint.acb_poly(to_flint_polynomial(p))(s) for p in polys]


def _on_circle(polys: Sequence[Poly], s: flint.acb) -> flint.acb | None:
    """Return the root z of P(s, z) that is on the unit circle; None if undecided.

    A simple root of the resultant has one common root of P and its mirror image, and as 1/conj(z)
    is one with z, it is its own image.
    """
    values = _values(polys, s)
    if len(values) == 2:
        return -values[0] / values[1]
    if values[-1].contains(0):
        return None
    try:
        roots = flint.acb_poly(values).roots(tol=flint.arb(2) ** -(flint.ctx.prec // 2))
    except ValueError:  # the coefficients are balls that are too large
        return None
    near = [z for z in roots if (abs(z) - 1).contains(0)]
    return near[0] if len(near) == 1 else None


def _flow(polys: Sequence[Poly], s: flint.acb, z: flint.acb) -> flint.arb | None:
    """Return Re(P_s/(s z P_z)), whose sign is the tendency."""
    slopes = _values([p.diff() for p in polys], s)
    values = _values(polys, s)
    P_s = sum((a * z**k for k, a in enumerate(slopes)), flint.acb(0))
    zP_z = sum((a * k * z**k for k, a in enumerate(values)), flint.acb(0))
    return None if zP_z.contains(0) else (P_s / (s * zP_z)).real


def _number_before(crossing: DelayCrossing, delay: Rational) -> int:
    """Return how many of its delays are below a rational one."""
    lower = [(delay - crossing.first.upper) / (crossing.period.upper),
             (delay - crossing.first.lower) / (crossing.period.lower)]  # fmt: skip
    counts = {max(0, int(sympy.floor(x)) + 1) for x in lower}
    if len(counts) > 1:
        raise BudgetError(f"the delay {delay} is within 30 digits of a delay at which roots cross")
    return counts.pop()


def _windows(
    unstable: int, crossings: Sequence[DelayCrossing]
) -> tuple[tuple[Enclosure, Enclosure | None], ...]:
    moving = [c for c in crossings if c.tendency]
    start = Enclosure(Rational(0), Rational(0))
    if not moving:
        return () if unstable else ((start, None),)
    drift = sum(c.tendency / c.period.centre for c in moving)
    if drift <= 0:
        raise NoSolutionError("the crossings do not leave the axis on the whole; please report it")
    last = (len(moving) + 1) / drift
    events: list[tuple[Enclosure, int]] = []
    for c in moving:
        k = 0
        while (c.first.centre + k * c.period.centre) <= last:
            radius = c.first.radius + k * c.period.radius
            events.append((Enclosure(c.first.centre + k * c.period.centre, radius), c.tendency))
            k += 1
            ask("terms", len(events), "the list of delays at which roots cross")
    events.sort(key=lambda event: event[0].centre)
    for (a, _), (b, _) in pairwise(events):
        if a.upper >= b.lower and not a.centre == b.centre == 0:
            raise BudgetError(
                f"roots cross at two frequencies for the delay {float(a):.6g}, or at two delays "
                "that agree to 30 digits"
            )
    windows: list[tuple[Enclosure, Enclosure | None]] = []
    total, since = unstable, start
    at_zero = [way for place, way in events if place.centre == place.radius == 0]
    total += 2 * sum(way > 0 for way in at_zero)  # those that leave to the left were not counted
    for place, way in events:
        if place.centre == place.radius == 0:
            continue
        if total == 0:
            windows.append((since, place))
        total += 2 * way
        since = place
    return tuple(windows)
