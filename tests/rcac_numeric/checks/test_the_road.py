"""Settings that went wrong name the road."""

import pytest

from rcac_numeric import (
    UD,
    ControllerSettings,
    Step,
    WhiteNoise,
    exogenous,
    fir_target,
    iir,
    loop_health,
    pole_placement_target,
    servo_plant,
    simulate,
)
from rcac_numeric.checks._rules import what_to_expect

DAMPED = servo_plant("0.01/((q**2 - 1.9*q + 0.98)*q**5)")
W = exogenous([Step(1.0), WhiteNoise(0.1), WhiteNoise(0.01)], 400)


def warnings_of(**change):
    known = {"structure": iir(8), "target": fir_target(DAMPED), "update": UD(1e-6), **change}
    return loop_health(simulate(DAMPED, ControllerSettings(**known), W)).warnings


def test_a_run_from_zero_names_design_once_and_what_to_expect():
    found = warnings_of()
    named = [one for one in found if "design(plant)" in one.next_step]
    assert len(named) == 1
    assert "a damping of 0.035" in named[0].sentence and "a dead time of 7" in named[0].sentence


def test_a_run_that_began_at_a_controller_does_not():
    theta_0 = [1e-3] * 16
    assert not any("design(plant)" in one.next_step for one in warnings_of(theta_0=theta_0))


@pytest.mark.parametrize(
    ("G", "poles"), [("1/((q - 0.9)*(q - 0.5))", ()), ("0.01/((q**2 - 1.9*q + 0.98)*q**5)", (0.9,))]
)
def test_nothing_is_said_of_what_fir_suits_or_of_slower_poles(G, poles):
    plant = servo_plant(G)
    assert what_to_expect(plant, pole_placement_target(plant, poles)) == ""
