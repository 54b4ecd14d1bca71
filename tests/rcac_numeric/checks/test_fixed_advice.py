"""A controller that does not adapt gets no advice about what adapts."""

import re

import numpy as np
import pytest

from rcac_numeric import (
    UD,
    Compensator,
    ControllerSettings,
    FixedController,
    HealthWarning,
    Saturation,
    Step,
    WhiteNoise,
    check_controller,
    exogenous,
    fir_target,
    iir,
    loop_health,
    simulate,
    standard_plant,
)
from rcac_numeric.checks._warnings import RULES

OF_A_FIXED_ONE = {key: rule.fixed for key, rule in RULES.items() if rule.fixed}

OF_ADAPTATION = re.compile(r"R_theta|k_w|n_c|k_c|lambda|theta|G_f|\bH\b|d_zu|target|R_u|dither")
PLANTS = (
    "1/(q - 2)",
    "0.1/(q - 0.999)",
    "(q - 1.5)/(q*(q - 0.5))",
    "1/(q**3*(q - 0.9))",
    "0.01/(q-1)",
)
GAINS = (-1.5, 0.0, 0.4)
CASES = [(G, gain) for G in PLANTS for gain in GAINS]


def loop_of(G, gain, steps=300, saturation=None):
    c = Compensator(past_u=np.zeros((1, 1, 1)), past_y=[[[0.0]], [[gain]]])
    w = exogenous([Step(1.0) + WhiteNoise(0.01)], steps)
    return c, simulate(standard_plant(G), FixedController(c), w, saturation=saturation)


def sentences(run):
    return [(one.code, one.sentence, one.next_step) for one in loop_health(run).warnings]


def every_warning():
    for G, gain in CASES:
        c, run = loop_of(G, gain)
        yield from sentences(run)
        yield from sentences(loop_of(G, gain, 30, Saturation(low=-0.1, high=0.1))[1])
        u, y = run.u[np.abs(run.u[:, 0]) < 1e9], run.y[np.abs(run.u[:, 0]) < 1e9]
        for wrong in (1.0, 1.1):
            log = check_controller(u * wrong, y, compensator=c, plant=standard_plant(G))
            yield from sentences(log)
            assert "about theta" not in log.report()


@pytest.mark.costly
def test_nothing_that_is_said_of_a_fixed_controller_speaks_of_adaptation():
    names = set()
    for code, sentence, step in every_warning():
        names.add(code)
        assert code in OF_A_FIXED_ONE, (code, step)
        assert not OF_ADAPTATION.search(step), (code, step)
        assert not OF_ADAPTATION.search(sentence), (code, sentence)
    assert names >= {"unstable", "slow", "inconsistent log", "saturated"}


@pytest.mark.parametrize(("gain", "is_turned"), [(0.5, True), (-0.5, False), (3.0, False)])
def test_the_other_sign_is_advised_where_it_stabilises(gain, is_turned):
    """u(k) = gain y(k-1) on 1/(q - 0.9): the poles are the roots of q^2 - 0.9 q - gain."""
    steps = [
        step
        for code, _, step in sentences(loop_of("1/(q - 0.9)", gain, 60)[1])
        if code == "unstable"
    ]
    assert len(steps) == (gain > 0)
    assert any("other sign" in step for step in steps) == is_turned


def test_an_adapting_one_still_gets_it():
    plant = standard_plant("(q - 1.5)/(q*(q - 0.5))")
    settings = ControllerSettings(
        structure=iir(2), target=fir_target(standard_plant("-1/q")), update=UD(R_theta=1e-8)
    )
    run = simulate(plant, settings, exogenous([Step(1.0)], 200))
    steps = " ".join(step for _, _, step in sentences(run))
    assert "R_theta" in steps


@pytest.mark.parametrize("code", sorted(OF_A_FIXED_ONE))
def test_every_remedy_of_the_table_is_for_a_fixed_one(code):
    assert not OF_ADAPTATION.search(OF_A_FIXED_ONE[code])


def test_every_rule_is_a_warning_that_is_documented():
    """Its code is a rule by itself, stands in the documentation, and its numbers fill it in."""

    class AnyNumber(dict):
        def __missing__(self, name):
            return 0.5

    for key, rule in RULES.items():
        code = key.partition(":")[0]
        assert code in RULES, key
        assert f'"{code}"' in HealthWarning.__doc__, code
        for words in (rule.sentence, *rule.steps):
            assert "{" not in words.format_map(AnyNumber(count=1, steps=1)), key
        assert rule.sentence.endswith(".") and not rule.fixed.endswith(".")
