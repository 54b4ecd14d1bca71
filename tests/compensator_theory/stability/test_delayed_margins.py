"""Margins of loops with one dead time: collocation, grids, python-control, and identities."""

import control
import mpmath
import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

import compensator_theory as exact
from compensator_theory import InputError, stability_margins, transfer_function
from compensator_theory.errors import NoSolutionError
from compensator_theory.strategies import (
    hurwitz_spectra,
    polynomials,
    strictly_proper_plants,
)
from tests.support.delay_roots import delay_roots

DELAYS = st.sampled_from(["1/10", "1/3", "1", "7/2"])


def floats(poly):
    return [float(c) for c in poly.all_coeffs()]


def margins_of(G, delay):
    """Margins of G exp(-delay s) in negative feedback; a loop with the root 0 is set aside."""
    assume(not G.numerator.is_zero)
    try:
        return stability_margins(exact.DelayedTransferFunction(G, delay), feedback=-1)
    except NoSolutionError:
        assume(False)


@st.composite
def stable_loops(draw):
    """A Hurwitz plant and a delay with a stable loop: the gain is lowered until it is."""
    roots = draw(st.integers(1, 3).flatmap(hurwitz_spectra))
    D = exact.polynomial_from_roots(roots, "s")
    N = draw(polynomials(max_degree=int(D.degree()) - 1))
    G, delay = exact.TransferFunction(N if not N.is_zero else N + 1, D), draw(DELAYS)
    while True:
        try:
            if stability_margins(exact.DelayedTransferFunction(G, delay), feedback=-1).is_stable:
                return G, delay
        except NoSolutionError:  # the root 0, with another gain not
            pass
        G = G / 3


def curve(margins, omega, factor=1.0, more=0.0):
    N, D = floats(margins.numerator), floats(margins.denominator)
    s = 1j * omega
    return factor * np.polyval(N, s) / np.polyval(D, s) * np.exp(
        -s * (float(margins.dead_time) + more)
    )  # fmt: skip


@pytest.mark.parametrize("delay", [0.5, 1.0, 2.0])
def test_an_integrator_by_hand(delay):
    """L = exp(-theta s)/s: the crossover 1, gain margin pi/(2 theta), delay margin pi/2 - theta."""
    margins = stability_margins(f"exp(-{delay}*s)/s", feedback=-1)
    assert [c.square for c in margins.gain_crossovers] == [1]
    if delay > np.pi / 2:
        assert not margins.is_stable and margins.gain_up is None and margins.unstable_roots == 2
        return
    assert float(margins.gain_up.value) == pytest.approx(np.pi / 2 / delay, rel=1e-14)
    assert float(margins.delay.value) == pytest.approx(np.pi / 2 - delay, rel=1e-14)
    assert float(margins.phase.value) == pytest.approx(90 - np.degrees(delay), rel=1e-14)


def test_a_first_order_process_in_fifty_digits():
    """tan(3 w) = -10 w for 2 exp(-3 s)/(10 s + 1), solved by mpmath."""
    margins = stability_margins("2*exp(-3*s)/(10*s + 1)", feedback=-1)
    with mpmath.workdps(50):
        w = mpmath.findroot(lambda w: mpmath.atan(10 * w) + 3 * w - mpmath.pi, 0.58)
        factor = mpmath.sqrt(1 + 100 * w**2) / 2
        for value, enclosure in [(w, margins.gain_up.frequency), (factor, margins.gain_up.value)]:
            centre = mpmath.mpf(int(enclosure.centre.p)) / int(enclosure.centre.q)
            assert abs(centre - value) < 1e-29


@pytest.mark.costly
@given(strictly_proper_plants(max_order=4), DELAYS)
@example(transfer_function("20*(s**2 + s/100 + 4)/(s + 2)**4"), "1")
@example(transfer_function("(s**2 + 4)/((s**2 + 1)*(s + 1)**2)"), "1")
@example(transfer_function("(s + 1)/(s - 1)**2"), "1/10")
def test_unstable_roots_are_those_of_collocation(G, delay):
    margins = margins_of(G, delay)
    roots = delay_roots(floats(G.numerator), floats(G.denominator), float(margins.dead_time))
    near = roots[np.abs(roots) < 40 / float(margins.dead_time)]  # those that it resolves
    assume(np.abs(near.real).min() > 1e-6)
    for crossover in margins.gain_crossovers:
        assume(float(crossover.frequency) < 20 / float(margins.dead_time))
    assert (near.real > 0).sum() == margins.unstable_roots
    assert margins.encirclements == margins.unstable_roots - margins.open_loop.unstable


@given(strictly_proper_plants(max_order=4), DELAYS)
@example(transfer_function("20*(s**2 + s/100 + 4)/(s + 2)**4"), "1")
@example(transfer_function("1/(s**2 + 1)"), "1")
@example(transfer_function("(s - 1)/(s + 1)**2"), "1")
def test_phase_crossovers_are_those_of_a_grid(G, delay):
    """Sign changes of Im L on a grid; -1/L at each of ours is its gain."""
    margins = margins_of(G, delay)
    high = float(margins.highest_frequency)
    ours = [c for c in margins.phase_crossovers if c.square != 0]
    for crossover in ours:
        w = float(crossover.frequency)
        assert curve(margins, w) * float(crossover.gain) == pytest.approx(-1, rel=1e-6)
    step = 2 * np.pi / float(margins.dead_time) / 40
    omega = np.linspace(1e-4 * step, high, max(20_000, int(high / step) * 4))
    with np.errstate(all="ignore"):
        L = curve(margins, omega)
        turn = np.angle(-L[1:] / -L[:-1])
    phase = np.angle(-L)  # a crossing of -L through the positive axis
    crossing = (phase[:-1] * phase[1:] < 0) & (np.abs(turn) < 1) & (np.abs(phase[1:]) < 1)
    for w in omega[1:][crossing]:
        assert min(abs(w - float(c.frequency)) for c in ours) <= 2 * (omega[1] - omega[0])
    assert [float(c.frequency) for c in ours] == sorted(float(c.frequency) for c in ours)


@pytest.mark.costly
@given(stable_loops())
@example((transfer_function("1/(s + 1)"), "1"))
@example((transfer_function("3/(2*s - 2)"), "1/10"))
def test_at_its_margins_a_loop_has_a_root_on_the_axis(loop):
    margins = margins_of(*loop)
    assert margins.is_stable
    for margin in (margins.gain_up, margins.gain_down):
        if margin.is_reached:
            L = curve(margins, float(margin.frequency), float(margin.value))
            assert pytest.approx(-1, rel=1e-6) == L
    if margins.delay.is_reached:
        L = curve(margins, float(margins.delay.frequency), more=float(margins.delay.value))
        assert pytest.approx(-1, rel=1e-6) == L


@pytest.mark.costly
@given(stable_loops())
@example((transfer_function("1/(s**2 + s + 4)"), "1/10"))
def test_the_delay_margin_ends_the_window_of_stability_delays(loop):
    margins = margins_of(*loop)
    assert margins.is_stable
    windows = margins.delays.windows
    (upper,) = [
        b for a, b in windows
        if a.upper < margins.dead_time and (b is None or margins.dead_time < b.lower)
    ]  # fmt: skip
    if upper is None:
        touching = [c for c in margins.delays.crossings if c.tendency == 0]
        assert touching or not margins.delay.is_reached
    else:
        total = margins.dead_time + margins.delay.value.centre
        assert abs(float(total - upper.centre)) < 1e-25


@given(strictly_proper_plants(max_order=4), DELAYS)
@example(transfer_function("1/s"), "7/2")  # a phase margin of -110 degrees
def test_each_gain_crossover_says_the_least_delay_that_makes_it_a_root(G, delay):
    margins = margins_of(G, delay)
    for crossover in margins.gain_crossovers:
        w, more = float(crossover.frequency), float(crossover.delay)
        assert 0 < more < 2 * np.pi / w
        assert curve(margins, w, more=more) == pytest.approx(-1, rel=1e-6)


@pytest.mark.parametrize(
    ("hidden", "is_stable", "unstable"),
    [("s + 3", True, 0), ("s**2 + 4", False, 0), ("s", False, 0), ("s - 3", False, 1)],
)
def test_hidden_roots_count_and_move_with_no_gain(hidden, is_stable, unstable):
    margins = stability_margins(f"({hidden})*exp(-s/2)/(({hidden})*(s + 1))", feedback=-1)
    assert margins.hidden.as_expr() == exact.polynomial(hidden, "s").as_expr()
    assert (margins.is_stable, margins.unstable_roots) == (is_stable, unstable)
    shown = stability_margins("exp(-s/2)/(s + 1)", feedback=-1)
    assert margins.phase_crossovers == shown.phase_crossovers and shown.is_stable


@given(strictly_proper_plants(max_order=3), DELAYS, st.sampled_from(["1/7", "3", "100"]))
def test_scaled_time_scales_frequencies_and_no_factor(G, delay, scale):
    margins = margins_of(G, delay)
    faster = G.compose(f"s/({scale})")
    again = margins_of(faster, exact.exact_number(delay) / exact.exact_number(scale))
    assert margins.unstable_roots == again.unstable_roots
    for name in ("gain_crossovers", "phase_crossovers"):
        pairs = zip(getattr(margins, name), getattr(again, name), strict=False)
        for first, second in pairs:
            k = float(exact.exact_number(scale))
            assert float(second.frequency) == pytest.approx(k * float(first.frequency), rel=1e-12)
    if margins.is_stable:
        assert float(again.gain_up.value) == pytest.approx(float(margins.gain_up.value), rel=1e-12)


@pytest.mark.parametrize("loop", ["10/(s*(s + 1)*(s + 5))", "2/(s - 1)", "(s + 3)/(s**2 + s + 1)"])
def test_a_short_dead_time_changes_little(loop):
    without = stability_margins(loop, feedback=-1)
    late = stability_margins(f"{loop}*exp(-s/1000000)", feedback=-1)
    assert late.is_stable == without.is_stable and late.encirclements == without.encirclements
    assert float(late.phase.value) == pytest.approx(float(without.phase.value), abs=1e-3)
    assert float(late.delay.value) == pytest.approx(float(without.delay.value), abs=2e-6)
    if without.gain_up.is_reached:
        assert float(late.gain_up.value) == pytest.approx(float(without.gain_up.value), rel=1e-4)
    else:
        assert float(late.gain_up.value) > 1e4
    assert float(late.gain_down.value) == pytest.approx(float(without.gain_down.value), abs=1e-5)


@pytest.mark.parametrize("loop", ["2*exp(-3*s)/(10*s + 1)", "exp(-s/2)/(s*(s + 1))"])
def test_pade_of_order_8_in_python_control(loop):
    margins = stability_margins(loop, feedback=-1)
    approximated = transfer_function(loop).to_control(8)
    gm, pm, wp, wg = control.margin(approximated)
    assert float(margins.gain_up.value) == pytest.approx(gm, rel=1e-6)
    assert float(margins.phase.value) == pytest.approx(pm, rel=1e-6)
    assert [float(margins.gain_up.frequency), float(margins.phase.frequency)] == pytest.approx(
        [wp, wg], rel=1e-6
    )


def test_dead_times_of_both_parts_add():
    whole = stability_margins("2*exp(-3*s)/(s + 1)", feedback=-1)
    parts = stability_margins("2*exp(-s)/(s + 1)", "exp(-2*s)", feedback=-1)
    assert whole == parts and parts.dead_time == 3
    assert stability_margins("2*exp(-3*s)/(s + 1)", -1, feedback=1) == whole


def test_hidden_modes_are_counted():
    margins = stability_margins("(s - 1)*exp(-s)/((s - 1)*(s + 2))", feedback=-1)
    assert margins.unstable_roots == 1 and not margins.is_stable
    assert margins.hidden == exact.polynomial("s - 1")
    on_axis = stability_margins("s*exp(-s)/(s*(s + 2))", feedback=-1)
    assert on_axis.unstable_roots == 0 and not on_axis.is_stable


@pytest.mark.parametrize(
    ("loop", "error"),
    [
        ("exp(-s)*(s + 1)/(s + 2)", InputError),
        ("exp(-theta*s)/(s + 2)", InputError),
        ("exp(-s)/(s + a)", InputError),
        ("(s - 1)*exp(-s)/(s + 1)**2", NoSolutionError),
        ("1/(s + exp(-s))", InputError),
    ],
)
def test_refused_loops(loop, error):
    with pytest.raises(error):
        stability_margins(loop, feedback=-1)
