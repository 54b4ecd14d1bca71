"""The H-infinity norm of plants whose coefficients are exponentials, as sampled ones are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import flint
from sympy import Expr, Poly, Rational, Symbol

from compensator_theory.errors import ImproperError, NoSolutionError
from compensator_theory.polynomials._ball_precision import at_growing_precision
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._poly import (
    canonical,
    common_divisor,
    exact_quotient,
    from_coefficients,
)
from compensator_theory.polynomials._variables import time_of
from compensator_theory.roots._enclosures import Enclosure, enclosure_of_ball
from compensator_theory.roots._half_plane import half_plane_polynomial
from compensator_theory.roots._independent_numbers import (
    IndependentNumbers,
    Meaning,
    independent_numbers,
    may_have_exponentials,
    meaning_of,
    mirrored,
    square_free,
)
from compensator_theory.systems._dead_times import transfer_function
from compensator_theory.systems._transfer_functions import TransferFunction

BITS = 320
GOAL = Rational(1, 10**30)


def narrow(*balls: flint.arb) -> tuple[Enclosure, ...] | None:
    """Return balls of 30 digits as enclosures; None where one of them is larger."""
    if not all(ball.is_finite() for ball in balls):
        return None
    enclosures = tuple(map(enclosure_of_ball, balls))
    return enclosures if all(x.radius <= GOAL for x in enclosures) else None


def norm_with_exponentials(
    G: Any, variable: str | Symbol | None
) -> tuple[Enclosure, Meaning] | None:
    r"""Return the norm of a plant with exponentials of numbers; None of another one.

    The gain has its supremum at 0, at infinity or where the derivative of
    :math:`|N|^2/|D|^2` by the square of the frequency vanishes; of all these balls the largest is
    taken, so that no tie matters.
    """
    if not may_have_exponentials(G):
        return None
    source = transfer_function(without_meaning(G), variable)
    if not isinstance(source, TransferFunction):
        return None
    rewritten = over_numbers([source], (meaning_of(G),))
    if rewritten is None:
        return None
    ((system,), numbers) = rewritten
    time = time_of(system.variable, "the H-infinity norm")
    ask_for_numbers(int(system.order), numbers, "the norm of a plant with exponentials")
    common = common_divisor(system.numerator, system.denominator)
    N, D = (exact_quotient(p, common) for p in (system.numerator, system.denominator))
    if N.degree() > D.degree():
        raise ImproperError(f"{system} is improper, and the H-infinity norm infinite")
    poles = numbers.count(D, time)
    if poles.stable < poles.total:
        raise NoSolutionError(
            f"the transfer function is not stable: {poles} poles; it has no H-infinity norm. "
            "Close a stabilising loop first"
        )
    size = int(D.degree())
    top, bottom = (half_plane_polynomial(p, size) if time == "discrete" else p for p in (N, D))
    above, below = squared_over(top, top)[0], squared_over(bottom, bottom)[0]
    slope = canonical(above.diff() * below - above * below.diff())
    factors = [] if slope.is_zero else [factor for factor, _ in square_free(slope)]
    ends = [(above.eval(0), below.eval(0))]
    ends += [tuple(p.coeff_monomial(p.gen**size) for p in (above, below))]

    def attempt(bits: int) -> tuple[Enclosure, ...] | None:
        squares = [numbers.ball(a) / numbers.ball(b) for a, b in ends]
        tops, bottoms = numbers.polynomial_ball(above), numbers.polynomial_ball(below)
        for factor in factors:
            for place in numbers.real_roots(factor, bits):
                if not place < 0:
                    squares.append(tops(place) / bottoms(place))
        largest = squares[0]
        for square in squares[1:]:
            largest = largest.max(square)
        # an end whose ball reaches below 0 is 0 itself
        return narrow(largest.max(flint.arb(0)).sqrt())

    (enclosure,) = at_growing_precision(attempt, BITS, "the H-infinity norm")
    return enclosure, numbers.meaning


def ask_for_numbers(degree: int, numbers: IndependentNumbers, subject: str) -> None:
    """Ask for the work on polynomials of a degree: each number more makes it some four times."""
    ask("entries", 250 * degree**3 * 4 ** (len(numbers.meaning) - 1), subject)


def without_meaning(obj: Any) -> Any:
    """Return the realisation of a sampled plant; other objects unchanged."""
    return obj.realisation if meaning_of(obj) else obj


def over_numbers(
    systems: Sequence[TransferFunction], meanings: Sequence[Meaning]
) -> tuple[list[TransferFunction], IndependentNumbers] | None:
    """Write the coefficients of systems by the symbols of independent numbers."""
    parts = [
        ([*G.numerator.all_coeffs(), *G.denominator.all_coeffs()], meaning)
        for G, meaning in zip(systems, meanings, strict=True)
    ]
    rewritten = independent_numbers(parts, ())
    if rewritten is None:
        return None
    rows, numbers = rewritten
    written = []
    for G, row in zip(systems, rows, strict=True):
        length = len(G.numerator.all_coeffs())
        N, D = (from_coefficients(part, G.variable) for part in (row[:length], row[length:]))
        written.append(TransferFunction(N, D, feedback=G.feedback, sample_time=G.sample_time))
    return written, numbers


def squared_over(first: Poly, second: Poly) -> tuple[Poly, Poly]:
    """Return real and imaginary part of N(jw) D(-jw), the latter over w, in x = w**2."""
    return on_the_axis(canonical(first * mirrored(second)))


def on_the_axis(poly: Poly) -> tuple[Poly, Poly]:
    """Return E and O of p(jw) = E(w**2) + jw O(w**2)."""
    sides: list[dict[tuple[int], Expr]] = [{}, {}]
    for (k,), c in poly.terms():
        sides[int(k) % 2][(int(k) // 2,)] = c * (-1) ** (int(k) // 2)
    even, odd = (Poly(side or {(0,): 0}, poly.gen, domain=poly.domain) for side in sides)
    return canonical(even), canonical(odd)
