"""Settings that went wrong name the road."""

import pytest

import rcac_numeric as rn
from rcac_numeric.checks._rules import fir_target_obstacle

DAMPED = rn.servo_plant("0.01/((q**2 - 1.9*q + 0.98)*q**5)")
W = rn.exogenous([rn.Step(1.0), rn.WhiteNoise(0.1), rn.WhiteNoise(0.01)], 400)


def warnings_of(**change):
    known = {
        "structure": rn.iir(8),
        "target": rn.fir_target(DAMPED),
        "update": rn.UD(1e-6),
        **change,
    }
    return rn.loop_health(rn.simulate(DAMPED, rn.ControllerSettings(**known), W)).warnings


def test_a_run_from_zero_names_design_once_and_what_to_expect():
    warnings = warnings_of()
    named = [one for one in warnings if "design(plant)" in one.next_step]
    assert len(named) == 1
    assert "a damping of 0.035" in named[0].sentence and "a dead time of 7" in named[0].sentence


def test_a_run_that_began_at_a_controller_does_not():
    theta_0 = [1e-3] * 16
    assert not any("design(plant)" in one.next_step for one in warnings_of(theta_0=theta_0))


@pytest.mark.parametrize(
    ("G", "poles"), [("1/((q - 0.9)*(q - 0.5))", ()), ("0.01/((q**2 - 1.9*q + 0.98)*q**5)", (0.9,))]
)
def test_nothing_is_said_of_what_fir_suits_or_of_slower_poles(G, poles):
    plant = rn.servo_plant(G)
    assert fir_target_obstacle(plant, rn.pole_placement_target(plant, poles)) == ""
