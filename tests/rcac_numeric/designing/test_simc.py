"""SIMC: the settings that Skogestad printed, in the limit of fast sampling."""

import numpy as np
import pytest

from compensator_theory.errors import NoSolutionError
from rcac_numeric import Step, simulate
from rcac_numeric.designing._expected import read_expected
from rcac_numeric.designing._plants import read_plant
from rcac_numeric.designing._reference import MOST, reference_loop
from rcac_numeric.designing._simc import simc
from rcac_numeric.designing._trials import whole_rms

FAST = 1e-4  # s; the settings differ by a few samples over theta


def gains(G, h=FAST, dead_time=0.0):
    """K_P and K_P/K_I in seconds."""
    numerator = simc(read_plant(G, h, dead_time), derivative=False).compensator.numerator
    K_I = numerator.sum() / h  # N_c(1)
    return numerator[1], numerator[1] / K_I


# Table 3 of Skogestad, J. Process Control 13 (2003) 291-309: E1, E3 and E4 (SIMC-PI).
@pytest.mark.parametrize(
    ("G", "K_c", "tau_I"),
    [
        ("1/((s + 1)*(s/5 + 1))", 5.5, 0.8),
        ("2*(15*s + 1)/((20*s + 1)*(s + 1)*(s/10 + 1)**2)", 2.33, 1.05),
        ("1/((s + 1)*(s/5 + 1)*(s/25 + 1)*(s/125 + 1))", 3.72, 1.1),
    ],
)
def test_printed_pi_settings(G, K_c, tau_I):
    result = gains(G)
    assert result == pytest.approx((K_c, tau_I), rel=0.01)


def test_an_integrator_with_dead_time():  # K_c = 1/(2 k' theta), tau_I = 8 theta, table 1
    theta = 1.0 + 1.5 * 0.02  # the hold and the strictly proper controller are late too
    result = gains("2/(50*s)", 0.02, 1.0)
    assert result == pytest.approx((1 / (2 * 0.04 * theta), 8 * theta), rel=1e-6)


def test_the_second_lag_is_the_derivative_time():
    result = simc(read_plant("1/((50*s + 1)*(10*s + 1))", 0.02, 1.0)).compensator
    # Series form with tau_1 = 50, tau_I = 8 theta, tau_D = 10, parallel K_P = K_c (1 + 10/8).
    theta = 1.03
    K_c = 50 / (2 * theta)
    K_D = result.numerator[-1]
    assert abs(K_D * 0.02 - K_c * 10) < 1e-6 * K_c
    assert result.numerator.sum() / 0.02 == pytest.approx(K_c / (8 * theta), rel=1e-6)


@pytest.mark.parametrize(
    ("G", "words"),
    [
        ("1/(10*s - 1)", "unstable"),
        ("1/(s**2 + s/50 + 1)", "damping of 0.01"),
        ("1/s**2", "two integrators"),
        ("s/(s**2 + 5*s + 10)", "zero at rest"),
        ("(3*s + 1)/s**2", "two integrators|no lag"),
    ],
)
def test_where_the_rules_are_silent_they_say_so(G, words):
    with pytest.raises(NoSolutionError, match=words):
        simc(read_plant(G, 0.1, 0.0))


def test_the_sign_is_that_of_the_plant():
    plus, minus = (
        simc(read_plant(G, 1.0, 2.0)).compensator for G in ("1/(9*s + 1)", "-1/(9*s + 1)")
    )
    assert np.allclose(plus.numerator, -minus.numerator) and plus.numerator[1] > 0


@pytest.mark.parametrize("late", [0.0, 3.0])
def test_the_reference_does_not_lose_to_it_on_a_first_order_plant(late):
    plant = read_plant("2/(10*s + 1)", 1.0, late)
    expected, _ = read_expected(Step(1.0), 0.02, None, np.inf, plant.low_gain)
    ours, theirs = reference_loop(plant, expected), simc(plant)
    w = expected.w(2000, 1)
    rms = [whole_rms(simulate(plant.servo(), one, w)) for one in (ours.fixed, theirs)]
    assert rms[0] < rms[1] and ours.peak <= MOST
