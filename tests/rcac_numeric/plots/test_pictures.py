"""Pictures: what is equal is drawn as equal, and words of users are drawn as they are."""

import io

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from rcac_numeric import LoopAnalysis, check_controller, iir, read_log
from rcac_numeric.analysis._match import IntercalatedMatch
from rcac_numeric.plots._style import LEAST_FACTOR, draw_magnitude, draw_phase, draw_title, phases
from tests.support.examples import EXAMPLE_2_3, EXAMPLE_4_7

OMEGA = np.linspace(0.01, 3.13, 200)


@given(st.integers(0, 2**32), st.floats(1e-9, 1e-3))
def test_phases_of_nearly_equal_responses_are_nearly_equal(seed, off):
    """Whatever the phase begins at, also next to the cut at pi, and however far it turns."""
    rng = np.random.default_rng(seed)
    turn = rng.uniform(-20, 20) * OMEGA + rng.choice([0, np.pi, -np.pi, rng.uniform(-4, 4)])
    exponential = np.exp(1j * turn)
    noise = rng.standard_normal(len(OMEGA)) + 1j * rng.standard_normal(len(OMEGA))
    first, second = phases(exponential, exponential * (1 + off * noise))
    assert np.abs(first - second).max() < 10 * off
    assert np.allclose(np.exp(1j * first), exponential)
    assert np.abs(np.diff(first - turn)).max() < 1e-6, "continuous"


@given(st.integers(0, 2**32))
def test_a_notch_does_not_part_equal_phases(seed):
    """At a zero on the unit circle rounding decides the way round; not 2 pi beyond it."""
    rng = np.random.default_rng(seed)
    q = np.exp(1j * OMEGA)
    expected = (q**2 - 2 * np.cos(OMEGA[100]) * q + 1) / q**2
    noise = rng.standard_normal(len(q)) + 1j * rng.standard_normal(len(q))
    first, second = phases(expected, expected + 1e-4 * noise)
    clear = np.abs(expected) > 0.05
    assert np.abs(first - second)[clear].max() < 0.02


def test_a_phase_that_turns_is_followed():
    """Two responses that part for good: the second one is continuous, as unwrapping has it."""
    q = np.exp(1j * OMEGA)
    first, second = phases(1 / q, (q - 0.5) / (q - 1.5) / q**4)
    assert np.abs(np.diff(second)).max() < 0.2 and abs(second - first).max() > np.pi


@pytest.mark.costly
def test_the_phases_of_example_2_3_lie_on_each_other():
    match = LoopAnalysis(EXAMPLE_2_3.run()).match
    first, second = phases(match.target[:, 0, 0], match.reached[:, 0, 0])
    assert np.abs(first - second).max() < 1


def test_a_good_match_looks_like_one():
    """Two all-pass responses that differ by 6e-6: the axis is not cut down to that."""
    exponential = np.exp(-1j * OMEGA)[:, None, None]
    match = IntercalatedMatch(
        OMEGA, exponential * (1 + 6e-6 * np.cos(9 * OMEGA)[:, None, None]), exponential
    )
    gain, phase = Figure().subplots(1, 2)
    draw_magnitude(gain, match)
    low, high = gain.get_ylim()
    assert np.isclose(high / low, LEAST_FACTOR) and low < 1 < high
    constant = IntercalatedMatch(OMEGA, np.abs(match.reached) + 0j, np.abs(exponential) + 0j)
    draw_phase(phase, constant)
    assert np.ptp(phase.get_ylim()) >= 0.49


@pytest.mark.parametrize("title", ["$x^2", r"\frac{1}{", "a$b$c_^", "\x1b[31mred", "x" * 10**5])
def test_any_title_is_drawn(title):
    figure = Figure()
    draw_title(figure, title)
    figure.savefig(io.BytesIO())
    assert "\x1b" not in figure.get_suptitle() and len(figure.get_suptitle()) <= 120


def test_results_draw_themselves():
    """`plot` of each result is the function of the folder above."""
    analysis = LoopAnalysis(EXAMPLE_4_7.run())
    assert len(analysis.plot("4.7").axes) == 6
    log, target = read_log("examples/octave/rcac_loop.mat"), analysis.compared_with
    check = check_controller(log, structure=iir(n_c=4), plant=analysis.plant, target=target, k_w=50)
    assert len(check.plot().axes) == 7
    alone = check_controller(log.u, log.y, theta=log.theta[-1], structure=iir(n_c=4))
    for axis in (*check.plot().axes, *alone.plot().axes):
        assert axis.get_xlabel() and axis.get_ylabel()
    assert len(check.margins["u"].plot().axes) == 3
