"""Margins: textbooks, python-control's in floats, and the loops themselves at the margins."""

import itertools
import warnings

import control
import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

import compensator_theory as exact
from compensator_theory import InputError, stability_margins
from compensator_theory.errors import ImproperError
from compensator_theory.strategies import strictly_proper_plants


@pytest.mark.parametrize(
    ("loop", "phases", "gains"),
    [
        ("10/(s*(s + 1)*(s + 5))", [(25.39, 1.2271)], [3]),
        ("100/(s*(s + 1)*(s + 5))", [(-23.65, 3.9073)], [sympy.Rational(3, 10)]),
        ("1/(s*(s + 1)**2)", [(21.386, 0.68233)], [2]),
        ("1/(s*(s + 1))", [(51.827, 0.78615)], []),
        ("7*(s + 10)**2/s**3", [(10.03, 11.9236)], [sympy.Rational(5, 7)]),
        ("-2/(s + 1)", [(-60, np.sqrt(3))], [sympy.Rational(1, 2)]),
    ],
)
def test_textbook_margins(loop, phases, gains):
    """Of Ogata's and of Franklin, Powell and Emami-Naeini's examples; the last by hand."""
    margins = stability_margins(loop, feedback=-1)
    mine = [(c.degrees, float(c.frequency)) for c in margins.gain_crossovers]
    assert np.allclose(mine, phases, rtol=2e-4)
    assert [c.gain for c in margins.phase_crossovers] == gains


def test_answers_in_closed_form():
    margins = stability_margins("1/(s*(s + 1))", feedback=-1)
    (crossover,) = margins.gain_crossovers
    assert crossover.square == (sympy.sqrt(5) - 1) / 2
    assert abs(float(margins.delay.value) - 1.15061) < 1e-5 and margins.gains.upper == sympy.oo
    assert margins.encirclements == 0 and margins.open_loop.boundary == 1
    irrational = stability_margins("1/((s + 1)*(s**2 + s + 3))", feedback=-1).phase_crossovers
    assert [(c.square, c.gain) for c in irrational] == [(4, 5)]


@given(strictly_proper_plants(max_order=4), st.sampled_from([-1, 1]))
def test_against_python_control(G, sign):
    """All of its crossovers are among ours; on a grid it finds no others."""
    N, D = ([float(c) for c in p.all_coeffs()] for p in (G.numerator, G.denominator))
    try:
        margins = stability_margins(G, feedback=sign)
    except InputError:
        return
    loop = control.tf([-sign * c for c in N], D)
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a pole on the axis, where it divides by 0
        gm, pm, _, wg, wp, _ = control.stability_margins(loop, returnall=True)
    mine = [float(c.frequency) for c in margins.gain_crossovers]
    for w, degrees in zip(wp, pm, strict=True):
        assume(w > 1e-3)
        nearest = min(
            margins.gain_crossovers, key=lambda c: abs(float(c.frequency) - w), default=None
        )
        if nearest is None or abs(float(nearest.frequency) - w) > 1e-5 * w:
            assume(False)  # a touching point, which floats see or not
        turn = (nearest.degrees - degrees) % 360
        assert min(turn, 360 - turn) < 1e-3
    assert len(mine) >= len(wp)
    for w, factor in zip(wg, gm, strict=True):
        if np.isfinite(factor) and w > 1e-3:
            gaps = [abs(float(c.gain_enclosure) / factor - 1) for c in margins.phase_crossovers]
            assume(gaps)
            assert min(gaps) < 1e-3


@given(strictly_proper_plants(max_order=4), st.sampled_from([-1, 1]))
def test_the_ends_of_the_gain_interval_are_crossovers(G, sign):
    """With -1/L as factor a root is on the axis; the ends of the interval are among these."""
    try:
        margins = stability_margins(G, feedback=sign)
    except InputError:
        return
    gains = {c.gain for c in margins.phase_crossovers}
    if margins.gains is not None:
        for end in (margins.gains.lower, margins.gains.upper):
            if end.is_finite and end > 0:
                assert min(abs(float(end - g)) for g in gains) < 1e-9 * float(end)
    for crossover in margins.phase_crossovers:
        closed = np.polyadd(
            [float(c) for c in margins.denominator.all_coeffs()],
            [float(crossover.gain_enclosure) * float(c) for c in margins.numerator.all_coeffs()],
        )
        roots = np.roots(closed)
        near = 1j * float(crossover.frequency)
        slope = np.polyval(np.polyder(closed), near)
        assert abs(np.polyval(closed, near)) < 1e-6 * (1 + abs(slope)) * (1 + abs(roots).max())


def test_discrete_loops():
    margins = stability_margins("0.5/(z - 0.5)", feedback=-1)
    assert [c.gain for c in margins.phase_crossovers] == [3] and margins.gains.upper == 3
    assert margins.delay.value == sympy.oo and margins.is_stable
    double = stability_margins("0.2*(z + 0.8)/((z - 1)*(z - 0.5))", feedback=-1)

    def at(theta):
        z = np.exp(1j * theta)
        return 0.2 * (z + 0.8) / ((z - 1) * (z - 0.5))

    assert double.gain_crossovers and double.phase_crossovers
    for gain in double.gain_crossovers:
        there = at(float(gain.frequency))
        assert np.isclose(abs(there), 1) and np.isclose(np.angle(-there), float(gain.phase_margin))
    for phase in double.phase_crossovers:
        assert np.isclose(-1 / at(float(phase.frequency)), float(phase.gain_enclosure))


@pytest.mark.parametrize("variable", ["s", "z"])
@given(data=st.data())
def test_a_loop_that_is_real_at_all_frequencies_has_no_single_crossover(variable, data):
    """Even in s, reciprocal in z: |L| = 1 at 0 or 180 degrees, and no gain helps."""
    s = sympy.Symbol(variable)
    square = s**2 if variable == "s" else (s - 1) ** 2 / s
    top, bottom = (
        sympy.Poly(data.draw(st.lists(st.integers(-4, 4), min_size=n, max_size=n)), s)
        for n in (2, 3)
    )
    assume(bottom.LC() and not top.is_zero and (top + bottom).degree() == bottom.degree())
    L = sympy.cancel((top.as_expr() / bottom.as_expr()).subs(s, square))
    assume(L.has(s))
    margins = stability_margins(L, feedback=-1, variable=s)
    assert margins.is_real and not margins.phase_crossovers and "is real" in str(margins)
    assert margins.gains is None and not margins.is_stable and margins.delay is None
    for crossover in margins.gain_crossovers:
        omega = complex(0, crossover.frequency.centre)
        value = complex(L.subs(s, omega if variable == "s" else sympy.exp(omega)).evalf(20))
        assert abs(abs(value) - 1) < 1e-9
        assert abs(crossover.degrees - (180 if value.real > 0 else 0)) < 1e-6


def test_what_is_refused():
    for loop in ("a/(s + 1)", "1/(x + 1)"):
        with pytest.raises(InputError):
            stability_margins(loop, feedback=-1, variable="x" if "x" in loop else "s")
    with pytest.raises(ImproperError):
        stability_margins("s**2/(s + 1)", feedback=-1)
    assert str(stability_margins("2/(s - 1)", feedback=-1)).startswith("the loop is stable")
    assert stability_margins("(s + 3)/(s + 1)", feedback=-1).delay.value.centre == 0


ALL_PASS = {
    "s": [("s - 1", "s + 1"), ("s**2 - s + 3", "s**2 + s + 3"), ("s + 2", "s - 2"), ("1", "1")],
    "z": [("1", "z"), ("1 - z/2", "z - 1/2"), ("1 + 3*z", "z + 3"), ("z", "1"), ("1", "1")],
}


@pytest.mark.parametrize("feedback", [-1, 1])
@pytest.mark.parametrize("sign", ["", "-"])
@pytest.mark.parametrize(
    ("x", "places"),
    [(x, p) for x, rows in ALL_PASS.items()
     for p in itertools.combinations_with_replacement(range(len(rows)), 2)],
)  # fmt: skip
def test_a_loop_of_gain_1_everywhere_is_answered(x, places, sign, feedback):
    """The closed loop, its gains and the angles of L on a grid are the oracle."""
    tops, bottoms = zip(*(ALL_PASS[x][p] for p in places), strict=True)
    N, D = (exact.polynomial("*".join(f"({f})" for f in parts), x) for parts in (tops, bottoms))
    N = -N if sign else N
    if N.degree() > D.degree():
        return
    G = exact.transfer_function((N, D), x)
    L = (-feedback * N, D)
    if (L[0] + L[1]).is_zero:
        with pytest.raises(ImproperError, match="1 \\+ L is zero"):
            stability_margins(G, feedback=feedback)
        return
    margins = stability_margins(G, feedback=feedback)
    assert margins.is_all_pass and not margins.gain_crossovers
    cells = exact.stabilising_gains(G, feedback=feedback)
    around = next((cell for cell in cells.intervals if 1 in cell), None)
    assert margins.gains == around and margins.is_stable == (around is not None)
    omega = np.tan(np.linspace(0.01, 1.56, 200)) if x == "s" else np.linspace(0.01, 3.13, 200)
    point = 1j * omega if x == "s" else np.exp(1j * omega)
    values = [np.polyval([float(c) for c in p.all_coeffs()], point) for p in L]
    np.testing.assert_allclose(np.abs(values[0] / values[1]), 1)
    if margins.is_stable:
        np.testing.assert_allclose(values[0] / values[1], 1)
        assert "phase margin of 180 degrees" in str(margins)
        assert float(margins.delay.value) == (0 if x == "s" else 1)  # L(-1) = 1
    else:
        assert "no phase margin" in str(margins)
    assert not stability_margins((2 * N, D), feedback=feedback, variable=x).is_all_pass


@given(strictly_proper_plants())
def test_the_other_sign_is_advised_where_its_loop_is_stable(G):
    margins, opposite = (stability_margins(G, feedback=sign) for sign in (-1, 1))
    for one, other in ((margins, opposite), (opposite, margins)):
        is_advised = "stable with the other sign of feedback" in str(one)
        assert is_advised == (other.is_stable and not one.is_stable)
