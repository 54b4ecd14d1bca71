"""The root locus of a loop, exact: breaks, crossings, angles and asymptotes with their gains."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from itertools import zip_longest
from typing import Any

import flint
import sympy
from sympy import QQ, Expr, Poly, Rational, Symbol

from compensator_theory import figures
from compensator_theory._latex import displayed, latex, words
from compensator_theory._printing import text
from compensator_theory._showing import picture_of
from compensator_theory._terminal import several
from compensator_theory.errors import InputError
from compensator_theory.loops._siso import LoopPart, read_loop
from compensator_theory.matrices._certificates import Certified
from compensator_theory.matrices._flint_polynomials import (
    from_flint_polynomial,
    to_flint_polynomial,
)
from compensator_theory.matrices._quotients_modulo import quotient_modulo
from compensator_theory.polynomials._ball_precision import (
    at_growing_precision,
    ball_precision,
)
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import (
    canonical,
    is_rational,
    way_to_rational,
)
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import Time, time_of
from compensator_theory.roots._certified import (
    EASY,
    Root,
    certified_roots,
    refined_balls,
    root_balls,
)
from compensator_theory.roots._counts import half_plane_image
from compensator_theory.roots._enclosures import Enclosure, enclosure_of_ball
from compensator_theory.stability._critical_values import (
    approximation,
    resultant_in_parameter,
    roots_of_irreducible,
)
from compensator_theory.stability._enclosed_norms import narrow
from compensator_theory.stability._margins import (
    frequency_of,
    positive_roots,
    real_root_balls,
    squared,
    value_at_root,
)
from compensator_theory.stability._stabilising_gains import intervals_of_loop
from compensator_theory.stability._stability_intervals import StabilityIntervals

GAIN = Symbol("k")
BITS = (128, 256, 512, 1024, 2048, 4096)


@dataclass(frozen=True)
class LocusBreak(ExactValue):
    """A point at which branches meet: a multiple root of D + k N for a real gain.

    Attributes
    ----------
    factor : sympy.Poly
        Irreducible; the point is a root of it.
    value : complex
        The point, rounded; of two that are conjugate the one above the axis.
    radius : float
        Bound of its error.
    order : int
        How many branches meet.
    gain : sympy.Expr
        Real, exact: rational, in square roots, or a CRootOf.
    """

    factor: Poly
    value: complex
    radius: float
    order: int
    gain: Expr

    def __str__(self) -> str:
        place = f"{self.value.real:.6g}" if self.value.imag == 0 else f"{self.value:.6g}"
        gain = text(self.gain)
        if self.gain.has(sympy.CRootOf):  # its own value sets mpmath's precision
            gain = f"{float(approximation(self.gain)):.6g}"
        return f"{self.order} branches meet at {place} for k = {gain}"

    def _repr_latex_(self) -> str:
        return displayed(f"{latex(self.factor)} = 0", f"k = {latex(self.gain)}")


@dataclass(frozen=True)
class LocusCrossing(ExactValue):
    r"""A point at which branches are on the boundary of stability.

    Attributes
    ----------
    square : sympy.Expr
        :math:`\omega^2`, exact, in discrete time :math:`\tan^2(\theta/2)`; 0 and oo included.
    frequency : Enclosure or None
        In rad/s, in discrete time rad/sample; None at infinity in continuous time.
    gain : sympy.Expr
        Exact.
    gain_enclosure : Enclosure
    """

    square: Expr
    frequency: Enclosure | None
    gain: Expr
    gain_enclosure: Enclosure

    def __str__(self) -> str:
        place = "infinity" if self.frequency is None else f"{float(self.frequency):.6g}"
        return f"on the boundary at {place} for k = {float(self.gain_enclosure):.6g}"

    def _repr_latex_(self) -> str:
        return displayed(rf"\omega^2 = {latex(self.square)}", f"k = {latex(self.gain)}")


@dataclass(frozen=True)
class LocusAngles(ExactValue):
    """The directions of the branches at a pole or a zero, for small or large positive gains.

    Attributes
    ----------
    at : Root
        The pole that they leave, or the zero that they reach; of a pair the one above the axis.
    angles : tuple of Enclosure
        In rad, as many as the multiplicity.
    """

    at: Root
    angles: tuple[Enclosure, ...]

    def __str__(self) -> str:
        degrees = ", ".join(f"{float(a) * 180 / float(sympy.pi):.6g}" for a in self.angles)
        return f"at {self.at}: {degrees} degrees"

    def _repr_latex_(self) -> str:
        angles = [f"{float(a) * 180 / float(sympy.pi):.6g}^\\circ" for a in self.angles]
        return displayed(latex(self.at), *angles)


@dataclass(frozen=True)
class RootLocus(Certified, ExactValue):
    r"""The closed-loop roots of :math:`D + kN` as k goes through the real numbers.

    Attributes
    ----------
    numerator, denominator : sympy.Poly
        N and D without common factors; N has the sign of the feedback in it.
    hidden : sympy.Poly
        The common factor: roots that no gain moves.
    breaks : tuple of LocusBreak
        By ascending real part.
    crossings : tuple of LocusCrossing, or None
        By ascending frequency; None where D/N is real on the whole boundary of stability, as for
        1/s**2, so that branches run along it and cross nowhere alone.
    centroid : sympy.Expr or None
        Where the asymptotes meet; None where no branch goes to infinity.
    asymptotes, asymptotes_negative : tuple of sympy.Expr
        Their angles in rad, for positive and for negative gains.
    departures, arrivals : tuple of LocusAngles
        At the poles and at the zeros, for positive gains.
    """

    identity = "N D' - N' D = 0 where branches meet, D + k N = 0 there if k is rational"

    numerator: Poly
    denominator: Poly
    hidden: Poly
    breaks: tuple[LocusBreak, ...]
    crossings: tuple[LocusCrossing, ...] | None
    centroid: Expr | None
    asymptotes: tuple[Expr, ...]
    asymptotes_negative: tuple[Expr, ...]
    departures: tuple[LocusAngles, ...]
    arrivals: tuple[LocusAngles, ...]

    def _residuals(self) -> list[Poly]:
        N, D = self.numerator, self.denominator
        slope = N * D.diff() - N.diff() * D
        rational = [point for point in self.breaks if point.gain.is_Rational]
        return [
            *(slope.rem(point.factor) for point in self.breaks),
            *((D + N * point.gain).rem(point.factor) for point in rational),
        ]

    @property
    def time(self) -> Time:
        """The time domain that the variable s, z or q stands for."""
        return time_of(self.denominator.gen, "the boundary of stability")

    def at(self, gain: NumberLike) -> tuple[Root, ...]:
        """Return the certified roots for one rational gain."""
        value = exact_number(gain)
        if not value.is_Rational:
            raise InputError(f"the gain {value} must be a rational number")
        return certified_roots(canonical(self.denominator + self.numerator * value))

    @property
    def stable(self) -> StabilityIntervals:
        """The gains for which every root is stable, hidden ones and those at infinity counted."""
        s = self.denominator.gen
        both = self.denominator.as_expr() + GAIN * self.numerator.as_expr()
        whole = sympy.expand(both * self.hidden.as_expr())
        return intervals_of_loop(Poly(whole, s, domain=QQ[GAIN]), GAIN)

    def plot(self, **options: Any) -> figures.Figure:
        """Draw the branches for k > 0, the breaks and crossings with their gains, the asymptotes.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Where it is drawn instead of in a new figure.
        width : float
            Of the figure in inches, 6 by default; 3.5 fits the column of a journal.

        Returns
        -------
        matplotlib.figure.Figure
            Not attached to a window. The branches are those of python-control.

        Raises
        ------
        InputError
            If the figure is narrower than 3 inches, or `ax` is not one pair of axes.

        Examples
        --------
        >>> from compensator_theory import root_locus
        >>> locus = root_locus("1/(s*(s + 4)*(s**2 + 4*s + 20))", feedback=-1)
        >>> [note.get_text() for note in locus.plot().axes[0].texts]
        ['k = 100', 'k = 64', 'k = 260']
        """
        return picture_of(self, **options)

    def __str__(self) -> str:
        lines = [f"{format_polynomial(self.denominator)} + k*({format_polynomial(self.numerator)})"]
        if self.breaks:
            lines.append(several(self.breaks, "breaks"))
        if self.crossings is None:
            lines.append("branches run along the boundary of stability")
        elif self.crossings:
            lines.append(several(self.crossings, "crossings"))
        if self.centroid is not None:
            angles = ", ".join(map(text, self.asymptotes))
            lines.append(f"asymptotes from {text(self.centroid)} at the angles {angles}")
        ends = [f"departure {angles}" for angles in self.departures if angles.at.value.imag]
        ends += [f"arrival {angles}" for angles in self.arrivals if angles.at.value.imag]
        if ends:
            lines.append(several(ends, "departures and .arrivals"))
        return "\n".join(lines)

    def _repr_latex_(self) -> str:
        gain = "k" if self.numerator.is_one else f"k \\left({latex(self.numerator)}\\right)"
        return displayed(
            f"{latex(self.denominator)} + {gain}",
            *(f"{words('break: ')} {latex(part)}" for part in self.breaks),
            *(f"{words('crossing: ')} {latex(part)}" for part in self.crossings or ()),
        )


@refusing
def root_locus(
    plant: LoopPart,
    compensator: LoopPart = 1,
    *,
    feedback: int,
    variable: str | Symbol | None = None,
) -> RootLocus:
    r"""Find breaks, crossings, asymptotes and angles of a root locus, exactly.

    .. math:: D + kN = 0, \qquad \text{breaks: } N D' - N' D = 0, \; k = -D/N \in \mathbb{R}

    Parameters
    ----------
    plant, compensator : transfer function
        Proper, rational, in s, z or q; the locus is that of their product times a gain k.
    feedback : {+1, -1}
        The sign f: :math:`D D_c - f k N N_c`.
    variable : str or Symbol, optional
        Of the plant; default: evident.

    Returns
    -------
    RootLocus

    Raises
    ------
    InputError
        If a coefficient is symbolic, the loop is improper or constant, or the variable says nothing
        about time.
    BudgetError
        If many branches meet: the gains at the roots of an irreducible polynomial of degree above
        111, which takes order 60 or so, are not begun; raise `degree`.

    Notes
    -----
    The gain of a break is an algebraic number: its minimal polynomial is that of the matrix of
    -D/N on the field of the point. Whether the gain of a complex point is real is decided by
    comparison with the roots of that polynomial, which are isolated, and by no tolerance. Source:
    W. R. Evans, Trans. AIEE 67 (1948) 547-551.

    Examples
    --------
    >>> from compensator_theory import root_locus
    >>> print(root_locus("1/(s*(s + 4)*(s**2 + 4*s + 20))", feedback=-1))
    s**4 + 8*s**3 + 36*s**2 + 80*s + k*(1)
    2 branches meet at -2+2.44949j for k = 100; 2 branches meet at -2 for k = 64
    on the boundary at 0 for k = 0; on the boundary at 3.16228 for k = 260
    asymptotes from -2 at the angles pi/4, 3*pi/4, 5*pi/4, 7*pi/4
    departure at -2+4j: -90 degrees
    """
    G, G_c = read_loop(plant, compensator, feedback, variable=variable)
    N, D = G.numerator * G_c.numerator * -feedback, G.denominator * G_c.denominator
    if not (is_rational(N) and is_rational(D)):
        raise InputError(f"a locus needs rational coefficients; {way_to_rational(N, D)}")
    if N.degree() > D.degree() or D.degree() == 0 or N.is_zero:
        raise InputError(f"the loop {N.as_expr()} over {D.as_expr()} is improper or constant")
    time = time_of(G.variable, "the boundary of stability")
    ask("degree", 8 * int(D.degree()), "the root locus")
    hidden = canonical(N.gcd(D))
    N, D = canonical(N.exquo(hidden)), canonical(D.exquo(hidden))
    if D.degree() == 0:
        raise InputError("every pole of the loop is hidden, so that no root moves")
    s = D.gen
    crossings = _crossings(N, D, time)
    excess = int(D.degree() - N.degree())
    centroid, plus, minus = None, (), ()
    if excess:
        (n_1, n_0), (d_1, d_0) = (
            (p.LC(), p.coeff_monomial(s ** (int(p.degree()) - 1)) if p.degree() else 0)
            for p in (N, D)
        )
        centroid = sympy.cancel((n_0 / n_1 - d_0 / d_1) / excess)
        odd = tuple((2 * i + 1) * sympy.pi / excess for i in range(excess))
        even = tuple(2 * i * sympy.pi / excess for i in range(excess))
        plus, minus = (odd, even) if n_1 / d_1 > 0 else (even, odd)
    return RootLocus(
        N, D, hidden, _breaks(N, D), crossings, centroid, plus, minus, _angles(D, N), _angles(N, D)
    )


def _breaks(N: Poly, D: Poly) -> tuple[LocusBreak, ...]:
    W = N * D.diff() - N.diff() * D
    breaks, factors = [], W.factor_list()[1] if not W.is_zero else []
    for factor, _ in factors:
        ask("degree", 9 * int(factor.degree()), "the gains at which branches meet")
    for factor, power in factors:
        if N.rem(factor).is_zero:
            continue  # a multiple zero, where k is infinite
        minimal = _gain_polynomial(N, D, factor)
        real = roots_of_irreducible({minimal})
        for bits in BITS:
            with ball_precision(bits):
                balls = [b for b, _ in root_balls(factor, bits) if not b.imag < 0]
                values = root_balls(minimal, bits)
                matched = [_matched(N, D, ball, [v for v, _ in values]) for ball in balls]
                if all(len(m) == 1 for m in matched):
                    ascending = sorted((v for v, _ in values if v.imag == 0), key=_middle)
                    for ball, (value,) in zip(balls, matched, strict=True):
                        if value.imag == 0:
                            index = next(
                                i for i, v in enumerate(ascending) if v.real.overlaps(value.real)
                            )
                            breaks.append(_break(factor, ball, int(power) + 1, real[index].value))
                    break
        else:
            raise InputError(f"the gains at the roots of {factor.as_expr()} lie too close together")
    return tuple(sorted(breaks, key=lambda b: (b.value.real, -b.value.imag)))


def _middle(ball: flint.acb) -> flint.arb:
    return ball.real.mid()


def _break(factor: Poly, ball: flint.acb, order: int, gain: Expr) -> LocusBreak:
    imaginary = 0.0 if ball.imag == 0 else float(ball.imag.mid())
    value = complex(float(ball.real.mid()), imaginary)
    error = abs(ball - flint.acb(value.real, value.imag)).abs_upper()
    return LocusBreak(canonical(factor), value, float(error) * (1 + 2**-50), order, gain)


def _matched(N: Poly, D: Poly, ball: flint.acb, values: list[flint.acb]) -> list[flint.acb]:
    above, below = (flint.acb_poly(to_flint_polynomial(p))(ball) for p in (D, N))
    return [] if below.contains(0) else [v for v in values if v.overlaps(-above / below)]


def _gain_polynomial(N: Poly, D: Poly, factor: Poly) -> Poly:
    """Return the minimal polynomial of -D/N at the roots of a factor, irreducible and monic."""
    if factor.degree() == 1:
        root = -factor.TC() / factor.LC()
        return Poly(GAIN + D.eval(root) / N.eval(root), GAIN, domain=QQ)
    if factor.degree() > EASY:
        norm = _norm_in_balls(N, D, factor)
    else:
        modulus, above, below = (to_flint_polynomial(p).coeffs() for p in (factor, D, N))
        constants = [flint.fmpq_poly([c]) for c in modulus]
        moved = [flint.fmpq_poly([*pair]) for pair in zip_longest(above, below, fillvalue=0)]
        norm = resultant_in_parameter(constants, moved)
    # the norm is that of an element of a field, and so a power of the minimal polynomial
    whole = from_flint_polynomial(norm, GAIN)
    return whole.exquo(whole.gcd(whole.diff())).monic()


def _norm_in_balls(N: Poly, D: Poly, factor: Poly) -> flint.fmpq_poly:
    r"""Return :math:`c \prod (D(r_i) + k N(r_i))` over the roots, whose coefficients are integers.

    With integers w, N and D, and c the power of the leading coefficient of w that the degree of D
    asks for, it is Res_s(w, D + k N): where a ball holds one integer, that is the coefficient.
    """
    w, above, below = (to_flint_polynomial(p).numer() for p in (factor, D, N))
    degree = max(int(above.degree()), int(below.degree()))
    leading = w.coeffs()[-1] ** degree

    def attempt(start: int) -> flint.fmpz_poly | None:
        balls = [ball for ball, _ in root_balls(factor, start)]
        top, bottom = flint.acb_poly(above), flint.acb_poly(below)
        sizes = [(abs(top(ball)) + abs(bottom(ball)) + 1).log() for ball in balls]
        size = float(sum(sizes, flint.arb(leading).log()).abs_upper())
        if not math.isfinite(size):
            return None
        bits = int(1.45 * size) + start  # of the longest coefficient, and some more
        if (refined := refined_balls(w, balls, bits)) is None:
            return None
        with ball_precision(bits):
            top, bottom = flint.acb_poly(above), flint.acb_poly(below)
            parts = [flint.acb_poly([top(ball), bottom(ball)]) for ball in refined]
            while len(parts) > 1:
                pairs = [a * b for a, b in zip(parts[::2], parts[1::2], strict=False)]
                parts = pairs + parts[len(parts) & ~1 :]
            return (parts[0] * flint.acb_poly([leading])).unique_fmpz_poly()

    product = at_growing_precision(attempt, 256, "the gains at which branches meet")
    scale = flint.fmpq(to_flint_polynomial(D).denom(), to_flint_polynomial(N).denom())
    return flint.fmpq_poly(product)(flint.fmpq_poly([0, scale]))


def _crossings(N: Poly, D: Poly, time: Time) -> tuple[LocusCrossing, ...] | None:
    size = int(D.degree())
    top, bottom = (half_plane_image(p, size) for p in (N, D)) if time == "discrete" else (N, D)
    real, imaginary = squared(bottom, top)
    below = squared(top, top)[0]
    if imaginary.is_zero:
        return None
    zero = Enclosure(Rational(0), Rational(0))
    crossings = []
    if below.eval(0) != 0:
        gain = -real.eval(0) / below.eval(0)
        crossings.append(LocusCrossing(Rational(0), zero, gain, Enclosure(gain, Rational(0))))
    balls = cache(real_root_balls)  # a factor is isolated once for all its roots
    quotients: dict[Poly, Poly] = {}
    for factor, index, value in positive_roots(imaginary):
        if below.rem(factor).is_zero:
            continue  # a zero of the loop: an infinite gain

        def attempt(
            bits: int, factor: Poly = factor, index: int = index
        ) -> tuple[Enclosure, ...] | None:
            square = balls(factor, bits)[index]
            above, under = (
                flint.arb_poly(to_flint_polynomial(p.rem(factor)))(square) for p in (real, below)
            )
            if under.contains(0):  # it is not zero: the factor does not divide it
                return None
            return narrow(frequency_of(square, time), -above / under)

        frequency, enclosure = at_growing_precision(attempt, 160, "the gain of a crossing")
        if factor not in quotients:
            quotients[factor] = -quotient_modulo(factor, real, below)
        gain = value_at_root(quotients[factor], value)
        crossings.append(LocusCrossing(value, frequency, gain, enclosure))
    last, least = (p.coeff_monomial(p.gen**size) for p in (real, below))
    if least != 0:
        gain, edge = -last / least, None
        if time == "discrete":
            with ball_precision(160):
                edge = enclosure_of_ball(flint.arb.pi())
        crossings.append(LocusCrossing(sympy.oo, edge, gain, Enclosure(gain, Rational(0))))
    return tuple(crossings)


def _angles(polynomial: Poly, other: Poly) -> tuple[LocusAngles, ...]:
    """Return the directions at the roots of one polynomial, for positive gains."""
    angles = []
    for factor, multiplicity in polynomial.factor_list()[1]:
        m = int(multiplicity)
        derivative = polynomial
        for _ in range(m):
            derivative = derivative.diff()
        for root in certified_roots(canonical(factor)):
            if root.value.imag < 0:
                continue
            angles.append(
                LocusAngles(replaced(root, m), _directions(factor, root, derivative, other, m))
            )
    return tuple(sorted(angles, key=lambda a: (a.at.value.real, a.at.value.imag)))


def replaced(root: Root, multiplicity: int) -> Root:
    """Return a root with another multiplicity."""
    return Root(root.value, root.radius, multiplicity, root.is_real)


def _directions(
    factor: Poly, root: Root, derivative: Poly, other: Poly, m: int
) -> tuple[Enclosure, ...]:
    for bits in BITS:
        with ball_precision(bits):
            near = flint.acb(root.value.real, root.value.imag)
            reach = flint.arb(root.radius) * 2 + flint.arb(2) ** -1000
            (ball,) = (b for b, _ in root_balls(factor, bits) if not abs(b - near) > reach)
            slope, value = (
                flint.acb_poly(to_flint_polynomial(p))(ball) for p in (derivative, other)
            )
            step = -value / slope
            if step.real < 0 and step.imag.contains(0):
                if not (root.is_real or bits >= BITS[-1]):
                    continue
                angle = flint.arb.pi() if root.is_real else flint.arb.pi() + (-step).arg()
            else:
                angle = step.arg()
            turns = [(angle + 2 * flint.arb.pi() * i) / m for i in range(m)]
            balls = [enclosure_of_ball(turn) for turn in turns]
            if all(b.radius <= Rational(1, 10**15) for b in balls):
                return tuple(balls)
    raise InputError(f"the direction at {root} lies too close to the negative axis to tell")
