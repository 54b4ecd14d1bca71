"""The measures of a run's plant, against the plant itself."""

import numpy as np
import pytest

from compensator_theory import InputError
from rcac_experiments.files._builder import build
from rcac_experiments.judging._measures import MEASURES
from rcac_numeric.engine._target_learner import acting_input


def run(**plant):
    table = {
        "plant": plant,
        "signals": {"d": {"white_noise": 1}} if plant["problem"] != "standard" else {},
        "target": {"model": "output subspace"},
        "controller": {"n_c": 4, "R_theta": 1, "k_w": 205},
        "run": {"steps": 210},
    }
    return build(table, "case").main_run.execute().first


def test_zeros_and_poles_of_a_known_plant():
    outcome = run(problem="standard", G="(q - 0.5)*(q**2 - 2*q + 2)/((q - 0.25)*(q + 0.75)*q**3)")
    assert MEASURES["largest_plant_zero"](outcome) == pytest.approx(2**0.5)
    assert MEASURES["plant_zero_distance"](outcome, value=1, imaginary=1.5) == pytest.approx(0.5)
    assert MEASURES["plant_zero_distance"](outcome, value=0.25) == pytest.approx(0.25)
    assert MEASURES["plant_spectral_radius"](outcome) == pytest.approx(0.75)


def test_the_plant_is_that_of_the_step():
    outcome = run(problem="aircraft transition", start=7, duration=0.1)
    radii = [MEASURES["plant_spectral_radius"](outcome, at=k) for k in (69, 71)]
    zeros = [MEASURES["plant_zero_distance"](outcome, value=1.1359, at=k) for k in (69, 71)]
    assert radii[0] < radii[1] and zeros[0] > 0.15 and zeros[1] < 5e-5


def test_identified_zeros_without_noise_and_over_the_transition():
    """Each window of 70 by itself; the one that holds the transition shows no plant."""
    outcome = run(problem="aircraft transition", start=10, duration=1)
    assert MEASURES["identified_zero_error"](outcome, stop=70) < 1e-5
    assert MEASURES["identified_zero_error"](outcome, start=140) < 1e-5
    assert MEASURES["identified_zero_error"](outcome) > 1e-2
    with pytest.raises(InputError, match="no window of 70 samples lies in"):
        MEASURES["identified_zero_error"](outcome, start=150)


def test_a_disturbance_that_enters_with_the_control_acts_as_it_does():
    outcome = run(problem="aircraft")
    assert np.array_equal(acting_input(outcome.run), outcome.run.u_applied + outcome.run.w[:, 1:2])
    dummies = run(problem="aircraft", measured="dummy commands")
    assert np.array_equal(acting_input(dummies.run), dummies.run.u_applied + dummies.run.w[:, 1:])
