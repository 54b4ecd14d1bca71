"""Root locus, margins, delays."""

import pytest
import sympy
from sympy import Rational, pi, sqrt

from compensator_theory import root_locus, stability_delays, stability_margins
from tests.support.exercises import encloses


def test_breakaway_of_two_poles():
    """Where do the branches of 1/(s (s + 2)) leave the axis?"""
    (result,) = root_locus("1/(s*(s + 2))", feedback=-1).breaks
    assert (result.value, result.gain, result.order) == (-1, 1, 2)  # s^2 + 2 s + k


def test_breakaway_with_an_irrational_place():
    """The break points of 1/(s (s + 4)(s + 6)) and their gains."""
    s = sympy.Symbol("s")
    k = -s * (s + 4) * (s + 6)
    result = {
        sympy.nsimplify(b.gain) for b in root_locus("1/(s*(s + 4)*(s + 6))", feedback=-1).breaks
    }
    # 3 s^2 + 20 s + 24 = 0
    assert result == {sympy.expand(k.subs(s, p)) for p in sympy.solve(sympy.diff(k, s), s)}


def test_circle_of_a_zero():
    """Where do the branches of (s + 2)/(s (s + 1)) leave the axis and come back?"""
    locus = root_locus("(s + 2)/(s*(s + 1))", feedback=-1).breaks
    # the circle about the zero -2 with the radius sqrt(2 * 1)
    assert sorted(b.value.real for b in locus) == pytest.approx([-2 - 2**0.5, -2 + 2**0.5])
    assert {b.gain for b in locus} == {3 - 2 * sqrt(2), 3 + 2 * sqrt(2)}


def test_crossing_of_the_imaginary_axis():
    """With which gain does 1/(s (s + 4)(s + 6)) reach the imaginary axis, and where?"""
    locus = root_locus("1/(s*(s + 4)*(s + 6))", feedback=-1).crossings
    assert [(c.square, c.gain) for c in locus] == [(0, 0), (24, 240)]  # s^3 + 10 s^2 + 24 s + k


def test_asymptotes():
    """The asymptotes of (s + 2)/(s (s + 1)(s + 3)(s + 7))."""
    locus = root_locus("(s + 2)/(s*(s + 1)*(s + 3)*(s + 7))", feedback=-1)
    assert locus.centroid == -3  # (-11 + 2)/3
    assert {sympy.Mod(a, 2 * pi) for a in locus.asymptotes} == {pi / 3, pi, 5 * pi / 3}


def test_angle_of_departure():
    """At which angle does the locus of 1/(s (s^2 + 2 s + 2)) leave -1 + i?"""
    locus = root_locus("1/(s*(s**2 + 2*s + 2))", feedback=-1).departures
    ((angle,),) = [d.angles for d in locus if d.at.value == -1 + 1j]
    assert encloses(angle, -pi / 4)  # 180 - 135 - 90 degrees


def test_angle_of_arrival():
    """At which angle does the locus of (s^2 + 1)/(s (s + 1)^2) arrive at i?"""
    locus = root_locus("(s**2 + 1)/(s*(s + 1)**2)", feedback=-1).arrivals
    ((angle,),) = [d.angles for d in locus if d.at.value == 1j]
    assert encloses(angle, -pi / 2)  # 180 - 90 + 90 + 45 + 45 = 270 degrees


def test_discrete_locus():
    """With which gain does 1/(z (z - 1)) reach the unit circle?"""
    locus = root_locus("1/(z*(z - 1))", feedback=-1)
    crossings = {c.gain: c.frequency for c in locus.crossings}
    assert set(crossings) == {0, 1, -2}  # at 1; z^2 - z + 1 at 60 degrees; z^2 - z - 2 at -1
    assert crossings[1] == pi / 3 or encloses(crossings[1], pi / 3)


def test_phase_margin_of_a_motor():
    """The gain crossover and the phase margin of 1/(s (s + 1))."""
    (result,) = stability_margins("1/(s*(s + 1))", feedback=-1).gain_crossovers
    assert result.square == (sqrt(5) - 1) / 2  # w^4 + w^2 = 1
    assert encloses(result.phase_margin, sympy.atan(1 / sqrt((sqrt(5) - 1) / 2)))


def test_gain_margin_of_three_lags():
    """The phase crossover and the gain margin of 1/(s + 1)^3."""
    result = [
        c for c in stability_margins("1/(s + 1)**3", feedback=-1).phase_crossovers if c.square
    ]
    assert [(c.square, c.gain) for c in result] == [(3, 8)]  # three times 60 degrees, modulus 2^3


def test_margins_of_an_unstable_plant():
    """The gain factors that keep 4/(s - 1)/(s + 3) stable under unity feedback."""
    margins = stability_margins("4/((s - 1)*(s + 3))", feedback=-1)
    assert margins.is_stable
    assert (margins.gains.lower, margins.gains.upper) == (Rational(3, 4), sympy.oo)
    assert abs(margins.encirclements) == 1  # one unstable pole


def test_margins_of_a_real_loop():
    """Has 1/s^2 under unity feedback phase crossovers?"""
    margins = stability_margins("1/s**2", feedback=-1)  # L < 0 at every frequency
    assert margins.is_real and not margins.phase_crossovers and not margins.is_stable
    assert [(c.square, c.degrees) for c in margins.gain_crossovers] == [(1, 0)]


@pytest.mark.parametrize(("plant", "gain"), [("1/s**2", 0), ("1/(s**2 + 1)", -1)])
def test_locus_on_the_axis(plant, gain):
    """Where do the branches of 1/s^2 and of 1/(s^2 + 1) meet, and where do they cross the axis?"""
    locus = root_locus(plant, feedback=-1)
    assert [(b.value, b.gain) for b in locus.breaks] == [(0, gain)]
    assert set(locus.asymptotes) == {pi / 2, 3 * pi / 2}
    assert locus.crossings is None  # they stay on it
    assert not locus.stable.intervals


def test_delay_margin_of_an_integrator():
    """The delay that 2/s with unity feedback endures."""
    margins = stability_margins("2/s", feedback=-1)
    assert encloses(margins.delay.value, pi / 4)  # 90 degrees at w = 2


def test_delays_of_a_lag():
    """For which delays is x' = -x(t) - 2 x(t - tau) stable?"""
    (window,) = stability_delays(["s + 1", "2"]).windows
    assert encloses(
        window[1], sympy.acos(Rational(-1, 2)) / sqrt(3)
    )  # arccos(-a/b)/sqrt(b^2 - a^2)


def test_windows_of_delays():
    """For which delays is x'' = -3 x(t) + x(t - tau) stable?"""
    delays = stability_delays(["s**2 + 3", "-1"])
    # w^2 = 4 at tau = pi/2 + pi k to the right, w^2 = 2 at tau = sqrt(2) pi k to the left
    ends = [(0, pi / 2), (sqrt(2) * pi, 3 * pi / 2)]
    assert len(delays.windows) == len(ends)
    for (lower, upper), (low, high) in zip(delays.windows, ends, strict=True):
        assert lower == low or encloses(lower, low)
        assert encloses(upper, high)


def test_stable_for_every_delay():
    """Is x' = -2 x(t) - x(t - tau) stable for every delay?"""
    delays = stability_delays(["s + 2", "1"])
    assert not delays.crossings  # |i w + 2| > 1
    assert 10**6 in delays
