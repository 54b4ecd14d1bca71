"""What `tune` tries, what it keeps, and what gives way to the rule, on runs that are a script."""

import contextlib

import numpy as np
import pytest
from scipy.stats import qmc

from compensator_theory.errors import InputError
from rcac_experiments.tuning import _tuning as tuning
from rcac_experiments.tuning._tuning import (
    NU,
    RULE,
    SAMPLES,
    WEAKEST,
    Candidate,
    _judged,
    _points,
    _settings,
    tune,
)
from rcac_numeric import Step, design, pid
from rcac_numeric.arrays._values import equal
from rcac_numeric.designing._closed_loop_design import TuningParameters
from rcac_numeric.designing._design import Comparison
from rcac_numeric.designing._trials import BOXED, FIXED, RCAC

SMALL = {"disturbance": Step(0.5), "noise": 0.1, "seeds": 1, "steps": 100}
LOST, EQUAL = (np.inf, np.inf, np.inf, np.nan), (1.0, 1.0, 1.5, np.nan)


@pytest.fixture(scope="module")
def plain():
    return design("1/(q - 0.9)", **SMALL)


@pytest.fixture(scope="module")
def certified():
    return design("1/(q - 0.9)", kept="certified", **SMALL)


class Script:
    """A runner of trials whose numbers are those of the script, by name, plant and draw."""

    def __init__(self, numbers=lambda controller, plant, draw: EQUAL):
        self.numbers, self.rounds = numbers, {}

    def __call__(self, name, trials):
        self.rounds[name] = trials
        return trials.of([
            self.numbers(one, plant, draw) for one in trials.controllers
            for plant in range(len(trials.variations)) for draw in range(trials.seeds)
        ])  # fmt: skip


@pytest.fixture
def script(monkeypatch):
    """All runs of `tune` by a script."""
    runs = Script()
    monkeypatch.setattr(tuning, "_runner", lambda *options: contextlib.nullcontext(runs))
    return runs


# The points.


@pytest.mark.parametrize(("budget", "weakest"), [(1, None), (5, None), (8, 0.5)])
def test_the_points_are_those_of_the_sequence_of_the_seed(budget, weakest):
    """Sobol points of five letters, scrambled by the stream [seed, 5]; N_0 from the weakest on."""
    sequence = qmc.Sobol(5, rng=np.random.default_rng([7, 5]))
    expected = sequence.random_base2(3)[:budget]
    least = SAMPLES[0] if weakest is None else np.log10(weakest)
    points = _points(budget, 7, weakest)
    assert len(points) == budget
    samples = np.log10([one.samples for one in points])
    np.testing.assert_allclose(samples, least + expected[:, 0] * (SAMPLES[1] - least), rtol=1e-9)
    nu = np.log10([one.nu for one in points])
    np.testing.assert_allclose(nu, NU[0] + expected[:, 1] * (NU[1] - NU[0]), rtol=1e-9)


# What is tried.


def test_a_tuning_has_its_points_beside_rule_and_fixed(plain, script):
    tuned = tune(plain, 3, held_out=1, seeds=1)
    assert [one.name for one in tuned.candidates] == [FIXED, RULE, "1", "2", "3"]
    points = _points(3, 0)
    assert [one.parameters for one in tuned.candidates] == [None, TuningParameters(), *points]
    assert any(one.spare for one in points)
    first = script.rounds["round-1"]
    assert first.steps == script.rounds["held-out"].steps == 100 and first.seeds == 1
    assert list(first.controllers) == [FIXED, RULE, "1", "2", "3"]
    held_out = script.rounds["held-out"]
    assert (len(held_out.variations), held_out.seeds) == (2, 1)
    assert "held-out-box" not in script.rounds
    # All are alike: the rule stays.
    assert tuned.chosen.name == RULE and equal(tuned.settings, plain.settings)


def test_steps_and_draws_are_those_that_are_given(plain, script):
    tune(plain, 1, held_out=3, seeds=2, steps=150)
    assert script.rounds["round-1"].steps == 150
    held_out = script.rounds["held-out"]
    assert (len(held_out.variations), held_out.seeds, held_out.steps) == (4, 2, 150)
    tune(plain, 1, held_out=1, seeds=1, steps=100)  # the least


def test_the_order_of_a_structure_stays(script):
    pi = design("1/(q - 0.9)", structure=pid("PI"), **SMALL)
    tuned = tune(pi, 3, held_out=1, seeds=1)
    parameters = [one.parameters for one in tuned.candidates if one.name not in (FIXED, RULE)]
    assert [one.spare for one in parameters] == [0, 0, 0]
    assert len({one.width for one in parameters}) == 3  # and nothing else
    assert tuned.settings.structure == pid("PI")


def test_in_a_certified_set_order_and_width_stay_and_the_prior_may_be_weaker(certified, script):
    tuned = tune(certified, 3, held_out=1, seeds=1)
    parameters = [one.parameters for one in tuned.candidates if one.name not in (FIXED, RULE)]
    rule = TuningParameters()
    points = _points(3, 0, WEAKEST * rule.worth(certified.expected))
    assert [one.samples for one in parameters] == [one.samples for one in points]
    assert {(one.spare, one.width) for one in parameters} == {(0, rule.width)}
    assert equal(tuned.settings.bounds, certified.certified.bounds)
    assert list(script.rounds["held-out-box"].controllers) == [BOXED]
    assert {one.controller for one in tuned.design.evidence} >= {RCAC, BOXED, FIXED}


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"budget": 0}, "budget"),
        ({"budget": 4097}, "budget"),
        ({"held_out": 0}, "held_out"),
        ({"seeds": 0}, "seeds"),
        ({"steps": 99}, "steps"),
    ],
)
def test_numbers_beyond_their_bounds_are_refused(plain, script, options, words):
    with pytest.raises(InputError, match=words):
        tune(plain, **{"budget": 1, "held_out": 1, "seeds": 1, **options})


# What carries over to the plants that judge.


@pytest.mark.parametrize(
    ("of_point", "of_rule", "is_kept"),
    [
        ([EQUAL, EQUAL], [EQUAL, EQUAL], True),  # no more error
        ([(0.9, 1, 1.5, np.nan), EQUAL], [EQUAL, EQUAL], True),
        ([(1.1, 1, 1.5, np.nan), EQUAL], [EQUAL, EQUAL], False),
        ([LOST, EQUAL], [EQUAL, EQUAL], False),
        ([LOST, (0.5, 1, 1.5, np.nan)], [EQUAL, EQUAL], False),  # one run is more than the error
        ([(3.0, 1, 1.5, np.nan), EQUAL], [LOST, (2.0, 1, 1.5, np.nan)], True),
        ([EQUAL, (2.0, 1, 1.5, np.nan)], [LOST, EQUAL], True),  # saves one at more error
        ([EQUAL, LOST], [LOST, EQUAL], False),  # nothing to compare the error by
    ],
)
def test_what_saves_no_run_and_has_more_error_gives_way_to_the_rule(
    plain, of_point, of_rule, is_kept
):
    parameters = {RULE: TuningParameters(), "1": TuningParameters(samples=10.0)}
    settings = {
        FIXED: plain.fixed,
        **{name: _settings(plain, one) for name, one in parameters.items()},
    }
    alike = Comparison(1.0, (1.0, 1.0), (1, 1), (1, 1), (0.2, 1.0), "none", 1.0, 0, 0)
    candidates = tuple(Candidate(name, one, alike, 1.5, 4) for name, one in parameters.items())
    by_name = {RCAC: of_point, RULE: of_rule}

    def numbers(controller, plant, draw):
        return by_name[controller][plant] if controller in by_name else EQUAL

    tuned = _judged(plain, settings, candidates[1], candidates, 100, (1, 1, 0), Script(numbers))
    assert tuned.chosen.name == ("1" if is_kept else RULE)
    assert equal(tuned.settings, settings[tuned.chosen.name])
    assert RULE not in {one.controller for one in tuned.design.evidence}
    (first, second) = (one for one in tuned.design.evidence if one.controller == RCAC)
    expected = of_point if is_kept else of_rule
    assert (first.rms[0], second.rms[0]) == (expected[0][0], expected[1][0])
    assert not is_kept or tuned.beside_rule.wins == sum(one is LOST for one in of_rule)
    assert is_kept or tuned.beside_rule.ratio == 1
