"""An advice names settings that the controller has."""

import re

import numpy as np
import pytest

from rcac_numeric import (
    UD,
    Compensator,
    ControllerSettings,
    ControlLimits,
    GainSchedule,
    PredictiveCost,
    Step,
    WhiteNoise,
    check_controller,
    exogenous,
    fir_target,
    iir,
    loop_health,
    pid,
    simulate,
    standard_plant,
)
from rcac_numeric.checks._warnings import RULES, order_of, warning_of

NOT_OF_PCAC = re.compile(r"n_c|k_w|k_c|G_f|\bH\b|d_zu|target|R_u|dither|structure")
OF_ADAPTATION = re.compile(r"R_theta|k_w|n_c|lambda|theta|G_f|\bH\b|d_zu|target|R_u|dither")
PLANTS = ("1/(q - 2)", "0.1/(q - 0.999)", "(q - 1.5)/(q*(q - 0.5))", "1/(q**3*(q - 0.9))")


def warnings_of(run):
    yield from loop_health(run).warnings
    yield from loop_health(check_controller(run)).warnings


def runs_of(settings, steps):
    w = exogenous([Step(1.0) + WhiteNoise(0.01)], steps)
    for G in PLANTS:
        run = simulate(standard_plant(G), settings, w)
        if run.steps > 5:
            yield run


@pytest.mark.costly
def test_predictive_cost_is_advised_by_its_own_settings():
    names = set()
    for order, R in ((1, 1e-4), (1, 10.0), (3, 1e-3)):
        for limits in (None, ControlLimits(low=-0.5, high=0.5)):
            settings = PredictiveCost(order, 3, R=R, limits=limits)
            for run in runs_of(settings, 60):
                for warning in warnings_of(run):
                    names.add(warning.code)
                    assert not NOT_OF_PCAC.search(warning.next_step), warning
    assert {"unstable", "small margins"} & names


def test_a_gain_schedule_is_advised_as_a_controller_that_does_not_adapt():
    gains = [Compensator([[[0.0]]], [[[0.0]], [[gain]]]) for gain in (-1.5, 0.4)]
    for run in runs_of(GainSchedule([-1.0, 1.0], gains), 40):
        for warning in warnings_of(run):
            assert not OF_ADAPTATION.search(warning.next_step), warning


@pytest.mark.parametrize("key", sorted(key for key, rule in RULES.items() if rule.predictive))
def test_every_remedy_of_the_table_is_for_predictive_cost(key):
    assert not NOT_OF_PCAC.search(RULES[key].predictive)


def test_a_pid_controller_is_not_advised_to_grow_its_order():
    plant = standard_plant("(q - 1.5)/(q*(q - 0.5))")
    settings = ControllerSettings(
        structure=pid(), target=fir_target(standard_plant("-1/q")), update=UD(R_theta=1e-8)
    )
    run = simulate(plant, settings, exogenous([Step(1.0)], 200))
    steps = [warning.next_step for warning in loop_health(run).warnings]
    assert steps and not any("larger n_c" in step for step in steps)
    assert order_of(iir(2)) == "a larger n_c"
    for key, rule in RULES.items():
        if any("{order}" in step for step in rule.steps):
            numbers = dict.fromkeys(re.findall(r"{(\w+)", rule.sentence), np.float64(0.5))
            assert order_of(pid()) in warning_of((key, numbers), order=order_of(pid())).next_step
