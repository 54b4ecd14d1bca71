"""Margins: at each of them a pole of the perturbed loop is on the unit circle, and not before."""

import warnings
from itertools import product

import control
import numpy as np
import pytest
import scipy.signal
from hypothesis import assume, example, given, settings

import compensator_theory
from compensator_theory.errors import CompensatorError, ImproperError, InputError
from rcac_numeric import (
    UD,
    ClosedLoop,
    Compensator,
    ControllerSettings,
    LoopAnalysis,
    Plant,
    fir_target,
    iir,
    simulate,
    stability_margins,
    standard_plant,
)
from rcac_numeric.analysis._boundaries import gain_crossovers, lag_at, phase_crossovers
from rcac_numeric.analysis._classical import channel_margins
from rcac_numeric.analysis._opened_loop import broken_loop
from tests.support.loops import random_loop, seeds


def tf(numerator, denominator, dt=True):
    return control.tf(numerator, denominator, dt)


def radius(L, gain=1.0, delay=0):
    """Spectral radius of 1 + gain L q^-delay = 0 from its polynomial, not from our matrices."""
    numerator, denominator = np.atleast_1d(L.num[0][0]), np.atleast_1d(L.den[0][0])
    polynomial = np.polyadd(np.polymul(denominator, [1.0] + [0.0] * delay), gain * numerator)
    return np.abs(np.roots(polynomial)).max(initial=0.0)


def assert_margins_hold(seed):
    """Return whether the loop is stable; if it is, hold every margin against the poles."""
    L = random_loop(seed)
    margins = stability_margins(L, feedback=-1)
    assert margins.is_stable == (radius(L) < 1)
    if not margins.is_stable:
        assert margins.gain_up is margins.phase is margins.delay is margins.disk is None
        return False
    for result in (margins.gain_up, margins.gain_down, margins.phase, margins.delay):
        if result.is_reached and not result.jumps:
            assert abs(result.radius_at - 1) < 1e-6, (seed, result)
            assert result.radius_before < 1 < result.radius_after, (seed, result)
    for result in (margins.phase_lag, margins.phase_lead):  # the farther one of them, too
        assert not result.is_reached or abs(result.radius_at - 1) < 1e-6, (seed, result)
    assert abs(margins.disk.radius_at - 1) < 1e-6, seed
    # Nothing is lost before the margin, and nothing is missed where there is said to be none.
    for up, result in ((True, margins.gain_up), (False, margins.gain_down)):
        end = result.value if result.is_reached else (1e3 if up else 1e-3)
        for share in np.linspace(0, 0.999, 12):
            assert radius(L, 1 + (end - 1) * share) < 1, (seed, share)
    turn = np.radians(margins.phase.value if margins.phase.is_reached else 180.0)
    for share in np.linspace(0, 0.999, 8):
        assert radius(L, np.exp(1j * turn * share)) < 1, (seed, share)
    delay = margins.delay
    last = 12 if not delay.is_reached else int(np.ceil(delay.value)) - 1
    for steps in range(1, min(last, 25) + 1):
        assert radius(L, delay=steps) < 1, (seed, steps)
    if delay.jumps:
        assert radius(L, delay=int(delay.value)) >= 1
    assert margins.disk.alpha <= 2 * np.tan(turn / 2) * (1 + 1e-8) or turn >= np.pi
    return True


@pytest.mark.costly
@settings(max_examples=100)
@given(seeds)
def test_at_a_margin_the_poles_cross(seed):
    assert_margins_hold(seed)


@pytest.mark.costly
@pytest.mark.long
def test_at_a_margin_the_poles_cross_in_10_000_loops(in_full):
    expected = 10_000 if in_full else 60
    seed = stable = 0
    while stable < expected:
        stable += assert_margins_hold(seed)
        seed += 1


@pytest.mark.costly
@settings(max_examples=60)
@given(seeds)
def test_python_control_agrees_where_it_is_right(seed):
    """Its polynomial method leaves out z = 1 and z = -1, and at times makes crossovers up."""
    L = random_loop(seed)
    margins = stability_margins(L, feedback=-1)
    assume(margins.is_stable)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            GM, PM, _, w_pc, w_gc, _ = control.stability_margins(L, returnall=True, method="poly")
        except (UserWarning, RuntimeWarning):  # it says that its answer may be inaccurate
            assume(False)
    true = np.abs(np.abs(margins.loop.response(w_gc)) - 1) < 1e-6
    ours = margins.gain_crossovers
    inner = ours[(ours > 1e-6) & (ours < np.pi - 1e-6)]
    assert len(w_gc[true]) == len(inner) and np.allclose(np.sort(w_gc[true]), inner, rtol=1e-6)
    if true.any():
        assert np.isclose(np.abs(PM[true]).min(), margins.phase.value, rtol=1e-5, atol=1e-6)
    for gain, omega in zip(GM, w_pc, strict=True):
        L_there = margins.loop.response([omega])[0]
        if abs(L_there + 1 / gain) > 1e-6 * abs(L_there):
            continue
        assert np.abs(margins.phase_crossovers - omega).min() < 1e-5
        assert not 1 < gain < margins.gain_up.value * (1 - 1e-6)
        assert not margins.gain_down.value * (1 + 1e-6) < gain < 1


# k, omega_mco (rad/sample), PM (degrees), DM (steps)
TABLE_5_1 = [
    (15000, 1.8872, 19.0799, 0.1765),
    (30000, 1.4003, 86.1123, 1.0733),
    (60000, 0.5742, 181.7065, 5.5233),
]


@pytest.mark.parametrize(("k", "omega", "phase", "delay"), TABLE_5_1)
def test_table_5_1_counts_the_phase_in_0_to_360_and_divides(k, omega, phase, delay):
    """Its last row has a PM beyond 180 degrees, so it is a lag, not the nearer of lag and lead."""
    slack = delay * 0.5e-4 / omega + 0.5e-4 + np.radians(0.5e-4) / omega  # four printed digits
    assert abs(np.radians(phase) / omega - delay) <= slack


@pytest.mark.parametrize(("k", "omega", "phase", "delay"), TABLE_5_1)
def test_a_loop_with_the_margins_of_table_5_1(k, omega, phase, delay):
    """The delay margin, and the whole delays around it, of a loop made to have these numbers."""
    L = loop_with(omega, phase)
    margins = stability_margins(L, feedback=-1)
    assert np.isclose(margins.delay.frequency, omega, rtol=1e-9)
    assert np.isclose(np.degrees(lag_at(margins.loop, margins.delay.frequency)[0]), phase)
    assert abs(margins.delay.value - delay) < 1e-3
    steps = int(np.ceil(delay))
    assert radius(L, delay=steps - 1) < 1 < radius(L, delay=steps)


def loop_with(omega, phase):
    """(g q + h) / (q^d (q^2 - 2 r cos(angle) q + r^2)) with |L| = 1 and this lag at omega.

    Of all such loops one that is stable and whose delay margin is decided at omega.
    """
    exponential = np.exp(1j * (np.radians(phase) - np.pi))
    z = np.exp(1j * omega)
    choices = product(range(4), np.linspace(0.1, 1.0, 10), np.linspace(0.05, 3.1, 62))
    for d, r, angle in choices:
        D = np.array([1, -2 * r * np.cos(angle), r * r])
        value = exponential * np.polyval(D, z) * z**d
        g = value.imag / z.imag
        h = value.real - g * z.real
        L = tf([g, h], np.concatenate([D, np.zeros(d)]))
        if radius(L) < 0.999 and abs((h - g) / np.polyval(D, -1)) < 1:
            margins = stability_margins(L, feedback=-1).delay
            is_decided = np.isclose(margins.frequency, omega, rtol=1e-9)
            if is_decided and radius(L, delay=int(np.ceil(margins.value))) > 1:
                return L
    raise AssertionError("no such loop found")


def test_a_conditionally_stable_loop_has_margins_on_both_sides():
    L = tf([1.5], [1, -2])  # q - 2 + 1.5 k: stable for 2/3 < k < 2
    margins = stability_margins(L, feedback=-1)
    assert np.isclose(margins.gain_down.value, 2 / 3) and np.isclose(margins.gain_up.value, 2)
    assert margins.gain_down.frequency == 0 and np.isclose(margins.gain_up.frequency, np.pi)
    again = stability_margins(L, feedback=-1, sample_time=0.1)
    assert np.isclose(again.delay_time, 0.1 * margins.delay.value)


def test_nearest_boundary_of_a_loop_with_three_phase_crossovers():
    """A triple integrator-like loop: unstable for small gain, stable in between, unstable again."""
    L = tf(0.6 * np.poly([0.8, 0.8]), np.poly([1.0, 1.0, 1.0]))
    margins = stability_margins(L, feedback=-1)
    assert margins.is_stable and len(margins.phase_crossovers) >= 2
    assert 0 < margins.gain_down.value < 1 < margins.gain_up.value < np.inf
    for result in (margins.gain_down, margins.gain_up):
        assert radius(L, result.value * 1.01) != radius(L, result.value * 0.99)
        assert (radius(L, result.value * 1.01) > 1) != (radius(L, result.value * 0.99) > 1)


def test_an_unstable_loop_has_no_margins_and_says_so():
    margins = stability_margins(tf([4.0], [1, -2]), feedback=-1)
    assert not margins.is_stable and margins.gain_up is None and margins.delay_time is None
    assert "unstable" in str(margins) and len(margins.phase_crossovers)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_loop_of_the_other_sign_is_named(sign):
    """q^2 - q - 2 + 2.5 is stable, q^2 - q - 2 - 2.5 is not; a pole at 2 without feedback stays."""
    plant = standard_plant("1/(q - 2)")
    loop = ClosedLoop(plant, Compensator(past_u=[[[-1.0]]], past_y=[[[0.0]], [[2.5 * sign]]]))
    idle = ClosedLoop(plant, Compensator(past_u=[[[0.0]]], past_y=[[[0.0]], [[0.0]]]))
    assert loop.is_stable != loop.has_stable_opposite and not idle.has_stable_opposite
    assert stability_margins(loop).loop.has_stable_opposite == loop.has_stable_opposite
    for words in (str(stability_margins(loop)), LoopAnalysis((plant, loop.compensator)).report()):
        assert ("negate past_y" in words) == (not loop.is_stable)
    assert "negate past_y" not in str(stability_margins(idle))


def test_without_crossovers():
    still = stability_margins(tf([0.0], [1, -0.5]), feedback=-1)
    assert still.is_stable and still.gain_up.value == np.inf == still.phase.value
    assert still.delay.value == np.inf and still.gain_down.value == 0
    assert still.worst_gap == 0 and "inf" in str(still)
    assert not stability_margins(control.ss(2, 0, 1, 0, True), feedback=-1).is_stable
    small = stability_margins(tf([-0.1], [1, -0.5]), feedback=-1)
    assert small.gain_up.frequency == 0 and np.isclose(small.gain_up.value, 5)
    assert len(small.gain_crossovers) == 0 and small.delay.value == np.inf


def test_loops_without_dynamics():
    assert stability_margins(tf([0.5], [1]), feedback=-1).gain_up.value == np.inf
    half = stability_margins(tf([-0.5], [1]), feedback=-1).gain_up
    assert half.value == pytest.approx(2) and half.radius_after == 0  # 1 - 0.5 x 2: ill posed there
    twice = stability_margins(tf([2.0], [1]), feedback=-1).delay
    assert twice.value == 1 and twice.jumps and twice.radius_at > 1  # q + 2


def test_exactly_proper_loops_at_the_ends_of_the_circle():
    L = tf([0.5, 0.1], [1, -0.5])  # L(1) = 1.2, L(-1) = 0.8/3: one crossover, phase never half
    margins = stability_margins(L, feedback=-1)
    assert len(margins.gain_crossovers) == 1 and margins.gain_up.value == np.inf
    at_one = tf([0.25, 0.25], [1, -0.5])  # L(1) = 1 exactly: a crossover at 0 that no delay moves
    result = stability_margins(at_one, feedback=-1)
    assert result.gain_crossovers.tolist() == [0.0] and result.delay.value == np.inf
    assert np.isclose(result.phase.value, 180)
    at_minus_one = tf([0.75, -0.75], [1, -0.5])  # L(-1) = 1: one step of delay puts a pole at -1
    result = stability_margins(at_minus_one, feedback=-1)
    assert np.isclose(result.gain_crossovers[-1], np.pi)
    assert np.isclose(result.delay.value, 1) and np.isclose(radius(at_minus_one, delay=1), 1)


def test_positive_feedback_is_the_negative_loop():
    L = tf([0.3], [1, -1, 0.2])
    negative, positive = stability_margins(L, feedback=-1), stability_margins(-L, feedback=+1)
    assert negative.gain_up == positive.gain_up and negative.delay == positive.delay


@pytest.mark.parametrize("at", ["u", "y"])
def test_a_closed_loop_is_opened_at_one_channel_while_the_others_stay_closed(at):
    rng = np.random.default_rng(3)
    plant = Plant(
        A=[[0.9, 0.2], [0, 0.7]], B=rng.standard_normal((2, 2)), D_1=np.ones((2, 1)),
        C=rng.standard_normal((2, 2)), D_0=0.1 * rng.standard_normal((2, 2)),
    )  # fmt: skip
    P, Q = 0.2 * rng.standard_normal((2, 2, 2)), 0.1 * rng.standard_normal((3, 2, 2))
    loop = ClosedLoop(plant, Compensator(P, Q))
    for channel in (0, 1):
        opened = broken_loop(loop, at=at, channel=channel)
        ours = np.sort_complex(opened.closed_poles())
        assert np.allclose(ours, np.sort_complex(loop.poles()), atol=1e-9)
        gain = np.ones(2)
        gain[channel] = 1.7  # on this channel alone, in the plant's own matrices
        B, D_0 = plant.B * gain, plant.D_0 * gain
        C = plant.C
        if at == "y":
            B, C, D_0 = plant.B, plant.C * gain[:, None], plant.D_0 * gain[:, None]
        other = ClosedLoop(Plant(A=plant.A, B=B, D_1=plant.D_1, C=C, D_0=D_0), loop.compensator)
        assert np.allclose(
            np.sort_complex(opened.closed_poles(1.7)), np.sort_complex(other.poles()), atol=1e-9
        )


def test_opening_a_scalar_loop_at_u_and_at_y_gives_the_same_margins():
    compensator = Compensator(past_u=[[[0.4]], [[-0.1]]], past_y=[[[0.1]], [[-0.3]], [[0.1]]])
    loop = ClosedLoop(standard_plant("(q - 1.2)/((q - 0.9)*(q - 0.3))"), compensator)
    at_u, at_y = (stability_margins(loop, at=at) for at in ("u", "y"))
    assert np.isclose(at_u.gain_up.value, at_y.gain_up.value)
    assert np.isclose(at_u.disk.alpha, at_y.disk.alpha)


@settings(max_examples=60)
@given(seeds)
def test_crossovers_are_all_there_and_all_true(seed):
    """A fine grid, which the code never uses, sees no sign change that the crossovers lack."""
    loop = broken_loop(random_loop(seed), feedback=-1)
    gains, phases = gain_crossovers(loop), phase_crossovers(loop)
    assert np.allclose(np.abs(loop.response(gains)), 1, rtol=1e-7)
    omega = np.linspace(1e-3, np.pi - 1e-3, 3001)
    L = loop.response(omega)
    for i in np.flatnonzero(np.diff(np.sign(np.abs(L) - 1))):
        assert ((gains >= omega[i] - 1e-9) & (gains <= omega[i + 1] + 1e-9)).any()
    crosses = (np.diff(np.sign(L.imag)) != 0) & (L.real[1:] < 0) & (L.real[:-1] < 0)
    for i in np.flatnonzero(crosses):
        assert ((phases >= omega[i] - 1e-9) & (phases <= omega[i + 1] + 1e-9)).any()


def assert_crossovers_match_a_grid(loop, L_at):
    """A grid of values of L that polynomials gave, not the matrices of the loop."""
    gains, phases = gain_crossovers(loop), phase_crossovers(loop)
    omega = np.linspace(1e-3, np.pi - 1e-3, 40001)
    L = L_at(np.exp(1j * omega))
    assert np.allclose(np.abs(L_at(np.exp(1j * gains))), 1, rtol=1e-7)
    for i in np.flatnonzero(np.diff(np.sign(np.abs(L) - 1))):
        assert ((gains >= omega[i] - 1e-9) & (gains <= omega[i + 1] + 1e-9)).any()
    for i in np.flatnonzero((np.diff(np.sign(L.imag)) != 0) & (L.real[1:] < 0) & (L.real[:-1] < 0)):
        assert ((phases >= omega[i] - 1e-9) & (phases <= omega[i + 1] + 1e-9)).any()


@pytest.mark.costly
@pytest.mark.cases(2)
@pytest.mark.parametrize("seed", range(5))
def test_crossovers_of_a_loop_with_50_lags(seed):
    """As many as a quasi-FIR controller of chapter 6 has, with the plant (6.2)'s kind of poles."""
    rng = np.random.default_rng(seed)
    Q = np.concatenate([[0.0], 0.2 * rng.standard_normal(50)])
    plant = standard_plant("(q - 1.1)/((q - 0.9)*(q - 0.95))")
    loop = ClosedLoop(plant, Compensator(np.zeros((50, 1, 1)), Q[:, None, None]))
    opened = broken_loop(loop)
    assert len(gain_crossovers(opened)) > 3
    assert_crossovers_match_a_grid(
        opened,
        lambda z: -np.polyval(Q, z) / z**50 * (z - 1.1) / ((z - 0.9) * (z - 0.95)),
    )


def test_internal_models_on_the_circle_do_not_hide_crossovers():
    """A double integrator and an undamped pair: L has poles on the circle itself."""
    poles = np.concatenate([[1.0, 1.0], np.exp([0.5j, -0.5j])])
    zeros = np.concatenate([[0.95, 0.9], 0.95 * np.exp([0.5j, -0.5j])])
    N, D = 0.5 * np.poly(zeros).real, np.poly(poles).real
    L = tf(N, D)
    assert_crossovers_match_a_grid(
        broken_loop(L, feedback=-1), lambda z: np.polyval(N, z) / np.polyval(D, z)
    )
    margins = stability_margins(L, feedback=-1)
    assert margins.is_stable and margins.gain_up.value == np.inf
    assert [round(float(radius(L, k)), 6) < 1 for k in (1.0, 10.0, 1e3)] == [True, True, True]


@pytest.mark.parametrize("h", [0.1, 1e-2, 1e-3, 1e-4])
@pytest.mark.parametrize("order", [2, 3, 4, 5])
def test_a_loop_that_is_sampled_fast_has_the_margins_of_the_continuous_one(h, order):
    """k / (s + 1)^order, sampled with a hold: to first order a delay of half a period.

    All poles are within h of 1, where cos omega keeps no digit of the crossovers.
    """
    k = 1.5
    omega = np.sqrt(k ** (2 / order) - 1)  # abs(k / (1 + j omega)^order) = 1
    lag = np.pi - order * np.arctan(omega)
    L = control.c2d(control.ss(control.tf([k], np.poly([-1.0] * order))), h, "zoh")
    margins = stability_margins(L, feedback=-1)
    assert np.isclose(margins.phase_lag.frequency, omega * h, rtol=0.02 + h)
    assert np.isclose(np.radians(margins.phase_lag.value), lag - omega * h / 2, rtol=h)
    assert np.isclose(margins.delay_time, lag / omega - h / 2, rtol=h)
    if order > 2:
        assert np.isclose(margins.gain_up.value, 1 / np.cos(np.pi / order) ** order / k, rtol=5 * h)
    assert margins.worst_gap < 1e-6 and abs(margins.disk.radius_at - 1) < 1e-6


@pytest.mark.parametrize("g", [1e-1, 1e-3, 1e-6, 1e-9])
def test_a_slow_integrator_has_a_crossover_and_at_both_ends_of_the_circle(g):
    for pole, sign in ((1, 1.0), (-1, -1.0)):
        margins = stability_margins(tf([sign * g], [1, -pole]), feedback=-1)
        slow = 2 * np.arcsin(g / 2)  # abs(q - pole) = g
        assert np.isclose(margins.phase_lag.frequency, slow if pole == 1 else np.pi - slow)
        assert np.isclose(margins.phase.value, 90 - np.degrees(slow) / 2)
        assert margins.gain_down.value == 0 and margins.gain_down.radius_at != 1


@pytest.mark.costly
@settings(max_examples=100)
@given(seeds)
@example(1524)  # its gain margin is a fifth of a thousandth
def test_no_gain_below_one_is_lost_to_poles_on_the_circle(seed):
    """Integrators, double ones and undamped pairs: rounding puts them inside or outside."""
    rng = np.random.default_rng(seed)
    pair = np.exp([1j, -1j] * rng.uniform(0.1, 3.0, 1))
    on = [[1.0], [1.0, 1.0], [-1.0], pair, [1.0, *pair]][rng.integers(5)]
    poles = np.concatenate([on, rng.uniform(-0.9, 0.9, rng.integers(0, 3))])
    D = np.poly(poles).real
    N = np.poly(rng.uniform(-0.95, 0.95, len(poles))).real - D
    margins = stability_margins(tf(N, D), feedback=-1)
    assume(margins.is_stable)
    down = margins.gain_down
    assert down.value == 0 or down.value > 1e-9
    for gain in np.geomspace(max(down.value**0.999, 1e-4), 1, 30):
        assert radius(tf(N, D), gain) < 1 + 1e-12
    if down.is_reached:
        assert radius(tf(N, D), down.value * 0.999) > 1
    assert abs(margins.disk.radius_at - 1) < 1e-6 and margins.worst_gap < 1e-6


@pytest.mark.parametrize("seed", range(3))
def test_the_gain_margin_of_example_5_1(seed):
    """The text has 1.81 at omega = 0 at step 5000; 1.65 to 1.88 over 20 seeds."""
    plant = standard_plant(
        "(q**2 - 1.7*q + 0.785)*(q**2 - 1.4*q + 0.85)"
        "/((q - 0.5)*(q**2 - 1.8*q + 0.97)*(q**2 - 1.4*q + 0.98))"
    )
    controller = ControllerSettings(
        structure=iir(n_c=10), target=fir_target(plant), update=UD(R_theta=1e-5)
    )
    w = 0.01 * np.random.default_rng(seed).standard_normal((5000, 1))
    loop = ClosedLoop(plant, simulate(plant, controller, w).compensator)
    margins = stability_margins(loop)
    assert 1.6 < margins.gain_up.value < 1.9 and margins.gain_up.frequency == 0
    frozen = broken_loop(loop)
    assert frozen.radius(2.9) > 1 and frozen.radius(1.5) < 1


def test_table_5_2_calls_seconds_steps():
    """129.12 degrees at 0.3708 rad/s are 6.08 s, at h = 0.1 s 60.8 steps; it prints 6.07 steps."""
    for omega, phase, printed in ((0.3708, 129.12, 6.07), (2.1834, 38.83, 0.31)):
        assert abs(np.radians(phase) / omega - printed) < 0.01


@pytest.mark.parametrize(
    ("loop", "options", "error", "words"),
    [
        (tf([1.0], [1, -0.5]), {}, InputError, "needs the sign of feedback"),
        (control.tf([1.0], [1, 1]), {"feedback": -1}, InputError, "is in continuous time"),
        (tf([1.0, 0, 0], [1, -0.5]), {"feedback": -1}, ImproperError, "future"),
        (3.0, {"feedback": -1}, InputError, "not a loop"),
        (tf([1.0], [1, 0.0]), {"feedback": -1}, InputError, "every frequency"),
        (tf([1.0], [1, -0.5]), {"feedback": -1, "sample_time": 0}, InputError, "positive"),
        (control.frd([1.0, 2.0], [0.1, 0.2], True), {"feedback": -1}, InputError, "no poles"),
    ],
)  # fmt: skip
def test_refusals(loop, options, error, words):
    with pytest.raises(error, match=words):
        stability_margins(loop, **options)
    assert issubclass(error, CompensatorError)


def test_a_closed_loop_refuses_a_sign_and_a_missing_channel():
    loop = ClosedLoop(standard_plant("1/(q - 2)"), Compensator([[[-1.0]]], [[[0.0]], [[-2.5]]]))
    with pytest.raises(InputError, match="leave feedback out"):
        stability_margins(loop, feedback=-1)
    with pytest.raises(InputError, match="at most 0"):
        stability_margins(loop, channel=1)
    assert len(stability_margins(loop).plot().axes) == 3


@pytest.mark.parametrize(
    ("system", "words"),
    [
        (control.tf([2.0], [1, 3, 2, 0]), r"compensator_theory\.stability_margins"),
        (control.ss([[-1.0]], [[1.0]], [[1.0]], [[0.0]]), r"compensator_theory\.stability_margins"),
        (scipy.signal.lti([1.0], [1.0, 1.0]), r"compensator_theory\.stability_margins"),
        ("2/(s*(s + 1))", r"compensator_theory\.stability_margins"),
        (control.frd(np.ones(2), np.array([0.1, 1.0])), r"control\.stability_margins"),
        (control.tf([1.0, 0], [1.0, 0.0], 0.1), "Change the gain of the loop a little"),
    ],
)  # fmt: skip
def test_what_has_no_margins_here_names_who_answers(system, words):
    with pytest.raises(InputError, match=words):
        stability_margins(system, feedback=-1)
    if "compensator_theory" in words:
        assert compensator_theory.stability_margins(system, feedback=-1) is not None


def test_channels_of_several_controls_have_their_numbers():
    """Two loops that do not meet: the margins of each are those of it alone, at u1 and at u2."""
    gains, poles = [0.2, 0.4], [0.9, 0.5]
    one = np.eye(2)
    plant = Plant(A=np.diag(poles), B=one, C=one, D_1=one, E_1=one)
    both = ClosedLoop(
        plant, Compensator(past_u=[np.zeros((2, 2))], past_y=[np.zeros((2, 2)), -np.diag(gains)])
    )
    margins_of, reasons = channel_margins(both)
    assert list(margins_of) == ["u1", "u2"] and not reasons
    for margins, gain, pole in zip(margins_of.values(), gains, poles, strict=True):
        plant = Plant(A=[[pole]], B=[[1.0]], C=[[1.0]], D_1=[[1.0]], E_1=[[1.0]])
        alone = ClosedLoop(plant, Compensator(past_u=[[[0.0]]], past_y=[[[0.0]], [[-gain]]]))
        expected, _ = channel_margins(alone)
        assert list(expected) == ["u"]
        assert margins.gain_up == pytest.approx(expected["u"].gain_up)
