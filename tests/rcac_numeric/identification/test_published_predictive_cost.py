"""The four plants of the public PCAC code with printed coefficients, with claims that are judged.

Source: github.com/rorsolle/PCAC at 33d83c2, Examples/Example_1.m, Example_2.m, Example_S_5.m and
Example_S_6.m: plant, order, horizon, weights, limits, P(0), theta(0), commands, noise and length.
There the model holds G_0 = 0, the first n controls are drawn, and u(k+1) is that of theta(k).
"""

import numpy as np
import pytest

import compensator_theory as ct
from rcac_numeric import (
    ControlLimits,
    PredictiveCost,
    predictive_cost_limit,
    servo_plant,
    simulate,
)

PLANTS = {
    "1": "(q - 2/5)/(q**2 + q/2 - 1/10)",
    "2": "(q - 13/10)/(q**2 - 7/5*q + 3/10)",
    "S5": "4*(q - 6/5)/(q**2 - q + 4/5)",
    "S6": "4*(q - 6/5)/(q**2 - q + 6/5)",
}
LATE = {"Q": 50, "P": 50, "R": 10, "R_theta": 1e-3}
SETTINGS = {  # settings, bound of u and of its moves, steps, standard deviation of the noise
    "1": ({"horizon": 5, "Q": 2, "P": 5, "R": 1e-4, "R_theta": 1.0}, 10, 100, 0.0),
    "2": ({"horizon": 20, "Q": 2, "P": 5, "R_theta": 1e-3, "theta_0": [0, 1, 0, 0]}, 5, 60, 0.0),
    "S5": ({"horizon": 50, **LATE}, 1, 1000, 0.1),
    "S6": ({"horizon": 50, **LATE}, 1, 100, 0.0),
}


def run_of(name, limited_by="least squares"):
    settings, bound, steps, noise = SETTINGS[name]
    k = np.arange(steps)
    command = np.ones(steps) if name in "12" else np.where(k < 20, 1.0, np.where(k < 40, -1, 3))
    w = noise * np.random.default_rng(0).standard_normal((steps, 3))
    w[:, 0] = command
    limits = ControlLimits(low=-bound, high=bound, rise=bound, fall=bound)
    controller = PredictiveCost(
        2, problem="servo", limits=limits, limited_by=limited_by, **settings
    )
    run = simulate(servo_plant(PLANTS[name]), controller, w)
    assert run.outcome == "completed" and abs(run.u).max() <= bound
    return run, command - run.z[:, 0]


@pytest.mark.parametrize(
    ("name", "is_stable", "zero"),
    [("1", True, "2/5"), ("2", False, "13/10"), ("S5", True, "6/5"), ("S6", False, "6/5")],
)
def test_what_the_plants_are(name, is_stable, zero):
    G = ct.transfer_function(PLANTS[name])
    assert ct.decide_stability(G).is_stable is is_stable
    assert G.numerator.eval(ct.exact_number(zero)) == 0


@pytest.mark.parametrize("name", PLANTS)
def test_the_limit_of_each_is_stable(name):
    """Exactly, for the printed horizon and weights; without limits of u."""
    settings = SETTINGS[name][0]
    weights = {key: ct.exact_number(str(settings.get(key, 1))) for key in "QPR"}
    limit = ct.predictive_cost_compensator(PLANTS[name], horizon=settings["horizon"], **weights)
    assert limit.certificate.holds
    assert ct.decide_stability(limit.regulator, time="discrete").is_stable


@pytest.mark.parametrize("limited_by", ["saturation", "least squares"])
@pytest.mark.parametrize("name", ["1", "2"])
def test_the_command_is_followed(name, limited_by):
    _, y_0 = run_of(name, limited_by)
    assert abs(y_0[-10:] - 1).max() < 0.02


def test_the_final_loop_of_example_2_is_its_limit():
    comparison = predictive_cost_limit(run_of("2")[0])
    assert comparison.worst_distance < 0.01 and comparison.backward_error < 0.05


def test_example_1_is_never_persistently_exciting():
    """The command is followed, and a coefficient is off by more than 0.005: exigency."""
    run, _ = run_of("1")
    assert abs(run.theta_final - [1, -0.4, -0.5, 0.1]).max() > 0.005


@pytest.mark.costly
@pytest.mark.parametrize(("name", "gain"), [("S5", "-1"), ("S6", "-2/3")])
def test_the_commands_of_s5_and_s6_are_beyond_the_limit_of_u(name, gain):
    """y_0 = G(1) u at rest: with abs(u) <= 1 the command 3 has no equilibrium."""
    G_1 = ct.transfer_function(PLANTS[name])(1)
    assert ct.exact_number(gain) == G_1
    _, y_0 = run_of(name)
    assert abs(y_0[60:].mean()) < abs(float(G_1)) + 0.1


def test_the_bounded_cost_holds_the_unstable_plant_of_s6_at_the_nearest_output():
    _, y_0 = run_of("S6")
    assert abs(y_0[90:] - 2 / 3).max() < 0.02
