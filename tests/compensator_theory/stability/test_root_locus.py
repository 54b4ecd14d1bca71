"""Root loci: textbooks, discriminants as the oracle of the breaks, closed loops in floats."""

from itertools import zip_longest

import flint
import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st
from sympy import Rational, pi, sqrt

from compensator_theory import CompensatorError, InputError, root_locus, stabilising_gains
from compensator_theory.stability._critical_values import resultant_in_parameter
from compensator_theory.stability._root_locus import _norm_in_balls
from compensator_theory.strategies import strictly_proper_plants
from tests.support.structure_cases import fewer

k = sympy.Symbol("k")


def floats(poly):
    return [float(c) for c in poly.all_coeffs()]


@pytest.mark.parametrize(
    ("loop", "breaks", "crossings"),
    [
        (
            "1/(s*(s + 1)*(s + 2))",
            [(-1 - 1 / 3**0.5, -2 * sqrt(3) / 9), (-1 + 1 / 3**0.5, 2 * sqrt(3) / 9)],
            [(0, 0), (2, 6)],
        ),
        (
            "1/(s*(s + 4)*(s**2 + 4*s + 20))",
            [(-2 + 6**0.5 * 1j, 100), (-2, 64)],
            [(0, 0), (10, 260)],
        ),
        ("1/(s*(s + 4)*(s**2 + 4*s + 8))", [(-2, 16)], [(0, 0), (4, 80)]),
        ("(s + 1)/(s**2*(s + 9))", [(-3, 27), (0, 0)], [(0, 0)]),
        (
            "(s + 2)/(s**2 + 2*s + 3)",
            [(-2 - 3**0.5, 2 + 2 * sqrt(3)), (-2 + 3**0.5, 2 - 2 * sqrt(3))],
            [(0, Rational(-3, 2))],
        ),
        ("(z + 1)/(z - 1)**2", [(-3, 8), (1, 0)], [(0, 0)]),
    ],
)
def test_textbook_loci(loop, breaks, crossings):
    """Of Ogata, and of Franklin, Powell and Emami-Naeini; the last by hand."""
    locus = root_locus(loop, feedback=-1)
    assert [b.gain for b in locus.breaks] == [gain for _, gain in breaks]
    assert np.allclose([b.value for b in locus.breaks], [place for place, _ in breaks])
    assert [(c.square, c.gain) for c in locus.crossings] == crossings


def test_angles_orders_and_asymptotes():
    four = root_locus("1/(s*(s + 4)*(s**2 + 4*s + 8))", feedback=-1)
    assert [b.order for b in four.breaks] == [4] and four.centroid == -2
    assert four.asymptotes == (pi / 4, 3 * pi / 4, 5 * pi / 4, 7 * pi / 4)
    assert root_locus("(s + 1)/(s**2*(s + 9))", feedback=-1).breaks[0].order == 3
    departure = root_locus("(s + 2)/(s**2 + 2*s + 3)", feedback=-1).departures[0].angles[0]
    assert abs(float(sympy.tan(departure.centre)) + 1 / 2**0.5) < 1e-12
    real = root_locus("1/(s*(s + 1)*(s + 2))", feedback=-1).departures
    # An odd number of poles to the right: 0 and -1 meet between them, -2 goes to the left.
    ways = {int(a.at.value.real): [abs(float(angle)) for angle in a.angles] for a in real}
    assert ways == {0: [pytest.approx(np.pi)], -1: [pytest.approx(0)], -2: [pytest.approx(np.pi)]}
    straight = root_locus("1/(s*(s + 4)*(s**2 + 4*s + 20))", feedback=-1)
    down = next(a for a in straight.departures if a.at.value.imag)
    assert abs(float(down.angles[0]) + np.pi / 2) < 1e-14
    conditional = root_locus("(s**2 + 2*s + 4)/(s*(s + 4)*(s + 6)*(s**2 + 1.4*s + 1))", feedback=-1)
    gains = [float(c.gain_enclosure) for c in conditional.crossings[1:]]
    assert np.allclose(gains, [15.6106, 67.5126, 163.557], rtol=1e-5)
    assert len(conditional.stable.intervals) == 2


@pytest.mark.parametrize(
    ("loop", "frequency", "gain"),
    [("1/(z - 1/2)", pi, Rational(3, 2)), ("(s + 1)/(s + 2)", None, -1)],
)
def test_the_last_crossing_is_at_minus_one_or_at_infinity(loop, frequency, gain):
    """z - 1/2 + k = 0 at z = -1; s + 2 + k (s + 1) loses its degree."""
    last = root_locus(loop, feedback=-1).crossings[-1]
    assert (last.square, last.gain) == (sympy.oo, gain)
    assert (last.gain_enclosure.centre, last.gain_enclosure.radius) == (gain, 0)
    if frequency is None:
        assert last.frequency is None
    else:
        assert abs(last.frequency.centre - frequency.evalf(50)) <= last.frequency.radius + 1e-40


def test_large_gains_are_enclosed_as_tightly_as_small_ones():
    """Irrational ones at the three crossings of a conditionally stable loop, times 10^60."""
    loop = "(s**2 + 2*s + 4)/({}*s*(s + 4)*(s + 6)*(s**2 + 1.4*s + 1))"
    small, large = (root_locus(loop.format(10**n), feedback=-1).crossings for n in (0, 60))
    for one, other in zip(small, large, strict=True):
        assert other.gain_enclosure.radius <= Rational(1, 10**30)
        error = other.gain_enclosure.centre - 10**60 * one.gain_enclosure.centre
        assert abs(error) <= 10**60 * one.gain_enclosure.radius + other.gain_enclosure.radius


@fewer(2)
@given(strictly_proper_plants(max_order=4), st.sampled_from([-1, 1]))
def test_breaks_are_the_zeros_of_the_discriminant(G, sign):
    """Exactly as many distinct real gains as the discriminant in s of D + k N has."""
    try:
        locus = root_locus(G, feedback=sign)
    except CompensatorError:
        assume(False)
    s = locus.denominator.gen
    whole = sympy.Poly(locus.denominator.as_expr() + k * locus.numerator.as_expr(), s)
    if whole.degree() < 2:
        assert not locus.breaks
        return
    disc = sympy.Poly(whole.discriminant(), k)
    gains = {b.gain for b in locus.breaks}
    assert len(set(disc.real_roots())) == len(gains)
    for b in locus.breaks:
        near = float(sympy.N(b.gain))
        closed = np.polyadd(floats(locus.denominator), [near * c for c in floats(locus.numerator)])
        assert (
            abs(np.polyval(closed, b.value))
            < 1e-6 * (1 + np.abs(closed).max()) * (1 + abs(b.value)) ** 4
        )
        slope = np.polyval(np.polyder(closed), b.value)
        assert abs(slope) < 1e-6 * (1 + np.abs(closed).max()) * (1 + abs(b.value)) ** 4


@fewer(2)
@given(strictly_proper_plants(max_order=4), st.sampled_from([-1, 1]))
def test_crossings_and_departures_of_the_loop_itself(G, sign):
    try:
        locus = root_locus(G, feedback=sign)
    except CompensatorError:
        assume(False)
    N, D = floats(locus.numerator), floats(locus.denominator)
    crossings = locus.crossings or ()  # None: a branch runs along the boundary
    for crossing in crossings:
        if crossing.frequency is None:
            continue
        point = 1j * float(crossing.frequency)
        closed = np.polyadd(D, [float(crossing.gain_enclosure) * c for c in N])
        assert (
            abs(np.polyval(closed, point))
            < 1e-6 * (1 + np.abs(closed).max()) * (1 + abs(point)) ** 4
        )
    ends = {
        end
        for cell in stabilising_gains(G, feedback=sign).intervals
        for end in (cell.lower, cell.upper)
        if end.is_finite
    }
    gains = [float(c.gain_enclosure) for c in crossings]
    assert locus.crossings is not None or not ends
    for end in ends:
        assert min(abs(float(end) - g) for g in gains) < 1e-9 * (1 + abs(float(end)))
    for angles in locus.departures:
        m = len(angles.angles)
        step = 1e-3 * min([1.0, *(abs(r.value - angles.at.value) for r in locus.at(0)
                                  if r.value != angles.at.value)])  # fmt: skip
        for angle in angles.angles:
            there = angles.at.value + step * np.exp(1j * float(angle))
            gain = -np.polyval(D, there) / np.polyval(N, there)
            assert abs(np.angle(gain)) < 0.1 * m


def test_hidden_modes_and_refusals():
    locus = root_locus("(s - 1)/((s - 1)*(s + 2))", feedback=-1)
    assert locus.hidden.as_expr() == sympy.Symbol("s") - 1 and not locus.stable.intervals
    assert [str(r) for r in locus.at(1)] == ["-3"]
    for loop in ("a/(s + 1)", "2", "s**2/(s + 1)", "(s - 1)/(s - 1)"):
        with pytest.raises(InputError):
            root_locus(loop, feedback=-1, variable="s")
    with pytest.raises(InputError, match="rational"):
        locus.at("sqrt(2)")
    assert "asymptotes" in str(locus) and locus._repr_latex_().startswith("$")


@given(st.lists(st.integers(-9, 9), min_size=14, max_size=14), st.integers(1, 5))
@fewer(10)
def test_gains_of_many_branches_from_balls_and_from_resultants(numbers, below):
    """The polynomial of the gains is rounded from balls from degree 21, interpolated before."""
    s = sympy.Symbol("s")
    N = sympy.Poly([1, *numbers[:4]], s, domain="QQ") * sympy.Rational(1, below)
    D = sympy.Poly([below, *numbers[2:]], s, domain="QQ") * sympy.Rational(1, 7)
    factors = (N * D.diff() - N.diff() * D).factor_list()[1]
    for factor, _ in factors:
        assume(not N.rem(factor).is_zero)
        sides = zip_longest(*(p.all_coeffs()[::-1] for p in (D, N)), fillvalue=0)
        loop = [flint.fmpq_poly([flint.fmpq(int(c.p), int(c.q)) for c in (a, sympy.S(b))])
                for a, b in sides]  # fmt: skip
        constants = [flint.fmpq_poly([flint.fmpq(int(c.p), int(c.q))])
                     for c in factor.all_coeffs()[::-1]]  # fmt: skip
        norm, balls = resultant_in_parameter(constants, loop), _norm_in_balls(N, D, factor)
        assert norm * balls.coeffs()[-1] == balls * norm.coeffs()[-1]
