"""Tuning: what is tried, what is chosen, what is judged on what."""

import itertools
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory.errors import InputError
from rcac_experiments import load_experiment, tune
from rcac_experiments.sweeps import read_table
from rcac_experiments.sweeps._problems import StoreError
from rcac_experiments.tuning._tuning import LEARNING, RULE, Candidate, _judged, drawn
from rcac_numeric import Uncertainty, design
from rcac_numeric.arrays._values import equal, replaced
from rcac_numeric.designing._closed_loop_design import TuningParameters, settings_of
from rcac_numeric.designing._design import compared
from rcac_numeric.designing._plants import read_plant
from rcac_numeric.designing._trials import BOXED, FIXED, RCAC, Trials

PLANT = "1/(q - 0.9)"


@pytest.fixture(scope="module")
def rule_design():
    return design(PLANT, disturbance=1.0, noise=0.05, seeds=1, steps=300)


@pytest.fixture(scope="module")
def tuned(rule_design):
    return tune(rule_design, 8, held_out=2, seeds=3)


@pytest.mark.costly
def test_the_best_goes_on_and_rule_and_fixed_are_always_there(tuned):
    by_name = {one.name: one for one in tuned.candidates}
    assert set(by_name) == {FIXED, RULE, *map(str, range(1, 9))}
    rounds = [one.rounds for one in tuned.candidates]
    assert sorted(rounds) == [1] * 4 + [2] * 2 + [3] + [4] * 3
    last = [one for one in tuned.candidates if one.rounds == 4 and one.name != FIXED]
    assert tuned.chosen in last
    better = [one for one in last if one.order < tuned.chosen.order]
    assert not better or tuned.chosen.name == RULE
    assert by_name[FIXED].beside.ratio == 1 and by_name[FIXED].beside.stable[1] == 24 * 7
    assert by_name[RULE].parameters == TuningParameters()


@pytest.mark.costly
def test_a_candidate_is_what_its_parameters_make_on_the_draws_of_learning(rule_design, tuned):
    one = next(c for c in tuned.candidates if c.rounds == 1)
    settings = settings_of(
        rule_design.model, rule_design.reference, rule_design.expected, one.parameters
    )
    plants = [t.variation for t in rule_design.evidence if t.controller == RCAC]
    trials = Trials({"it": settings, FIXED: rule_design.fixed}, rule_design.model,
                    rule_design.expected, tuple(plants), 300, 3, LEARNING)  # fmt: skip
    assert compared(trials.in_threads(), "it") == one.beside


def test_the_judgement_is_on_other_plants_and_draws(rule_design, tuned):
    trained = {t.variation for t in rule_design.evidence}
    judged = {t.variation for t in tuned.design.evidence}
    assert {one.name for one in judged & trained} == {"nominal"} and len(judged) == 3
    assert tuned.verdict.rcac == compared(tuned.design.evidence, RCAC)
    candidate = settings_of(
        rule_design.model, rule_design.reference, rule_design.expected, tuned.chosen.parameters
    )
    assert equal(tuned.settings, candidate)
    rule = {RCAC: tuned.settings, RULE: rule_design.settings}
    plants = [t.variation for t in tuned.design.evidence if t.controller == RCAC]
    trials = Trials(rule, rule_design.model, rule_design.expected, tuple(plants), 300, 3)
    assert compared(trials.in_threads(), RCAC, RULE) == tuned.beside_rule


@pytest.mark.costly
def test_the_seed_repeats_it(rule_design):
    one, again, other = (tune(rule_design, 1, held_out=1, seeds=1, seed=seed) for seed in (0, 0, 1))
    assert again.candidates == one.candidates and equal(again.settings, one.settings)
    assert {c.parameters for c in other.candidates} & {c.parameters for c in one.candidates} == {
        None, TuningParameters()
    }  # fmt: skip


def test_the_file_and_the_report_are_of_the_tuned_design(tuned, tmp_path):
    tuned.save(tmp_path / "tuned.toml")
    assert equal(load_experiment(tmp_path / "tuned.toml").runs[RCAC].settings, tuned.settings)
    lines = tuned.report().splitlines()
    assert lines[0].startswith("A tuned controller") and lines[1].startswith("  Use ")
    assert len(tuned.plot().axes) == 1


@given(
    gain=st.tuples(st.floats(0.1, 1), st.floats(1, 10)), late=st.integers(0, 3),
    more=st.integers(0, 3), time=st.floats(1, 3), noise=st.floats(1, 10), seed=st.integers(0, 99),
)  # fmt: skip
def test_drawn_plants_are_inside_the_uncertainty(gain, late, more, time, noise, seed):
    plant = read_plant(PLANT, None, late)
    within = Uncertainty(gain=gain, delay=more, time=time, noise=noise)
    plants = drawn(plant, within, 5, seed)
    for one in plants:
        assert gain[0] * (1 - 1e-12) <= one.gain <= gain[1] * (1 + 1e-12)
        assert -min(more, late) <= one.delay <= more
        assert abs(np.log(one.time)) <= np.log(time) + 1e-12
        assert 1 <= one.noise <= noise * (1 + 1e-12)
    assert plants == drawn(plant, within, 5, seed)


def test_a_plant_is_no_design():
    with pytest.raises(InputError, match="Design"):
        tune(PLANT)


class Stopped(Exception):
    """What kills a run of `tune` in the middle."""


def stops_after(runs):
    """A `progress` that raises when so many runs of all rounds have ended."""
    ended = []

    def progress(now):
        ended.append(now.done)
        if sum(b > a for a, b in itertools.pairwise(ended)) >= runs:
            raise Stopped

    return progress


@pytest.mark.slow
def test_killed_in_the_middle_it_goes_on_to_the_same_table(rule_design, tuned, tmp_path):
    arguments = {"budget": 8, "held_out": 2, "seeds": 3, "store": tmp_path / "runs", "workers": 0}
    rows = []
    for runs in (2, 4):
        with pytest.raises(Stopped):
            tune(rule_design, **arguments, progress=stops_after(runs))
        rows.append([len(read_table(one)) for one in sorted((tmp_path / "runs").iterdir())])
    assert 0 < sum(rows[0]) < sum(rows[1])
    calls = []
    resumed = tune(rule_design, **arguments, progress=calls.append)
    assert resumed.candidates == tuned.candidates and resumed.chosen == tuned.chosen
    assert resumed.beside_rule == tuned.beside_rule
    assert equal(resumed.design.evidence, tuned.design.evidence)
    assert calls[0].done >= rows[1][0] and calls[-1].done == calls[-1].total
    again = []
    tune(rule_design, **arguments, progress=again.append)
    assert all(now.done == now.total for now in again)  # nothing is run twice


@pytest.mark.costly
def test_processes_leave_the_same_runs(rule_design, tmp_path):
    arguments = {"budget": 1, "held_out": 1, "seeds": 1}
    with ThreadPoolExecutor(1) as pool:  # of others, as dask's is
        one, *others = (
            tune(rule_design, **arguments, **more)
            for more in (
                {},
                {"store": tmp_path / "runs", "workers": 1},
                {"store": tmp_path / "theirs", "executor": pool},
            )
        )
        assert pool.submit(int).result() == 0  # not shut down
    for other in others:
        assert one.candidates == other.candidates and one.beside_rule == other.beside_rule


@pytest.mark.costly
def test_a_store_of_another_design_is_refused(rule_design, tmp_path):
    arguments = {"budget": 1, "held_out": 1, "seeds": 1, "store": tmp_path / "runs", "workers": 0}
    tune(rule_design, **arguments)
    with pytest.raises(StoreError, match="another study"):
        tune(replaced(rule_design, uncertainty=Uncertainty(noise=2.0)), **arguments)
    with pytest.raises(InputError, match="is a file"):
        (tmp_path / "file").write_text("")
        tune(rule_design, **{**arguments, "store": tmp_path / "file"})
    with pytest.raises(InputError, match="needs a store"):
        tune(rule_design, 1, workers=2)
    with ThreadPoolExecutor(1) as pool, pytest.raises(InputError, match="exclude each other"):
        tune(rule_design, **arguments, executor=pool)


@pytest.mark.parametrize(
    "run", [(np.inf, np.inf, np.inf, np.nan), (1.1, 1.0, 1.5, np.nan)]
)  # lost, or worse
def test_what_does_not_carry_over_to_other_plants_gives_way_to_the_rule(rule_design, tuned, run):
    parameters = {RULE: TuningParameters(), "1": TuningParameters(samples=10.0)}
    settings_by_name = {FIXED: rule_design.fixed} | {
        name: settings_of(rule_design.model, rule_design.reference, rule_design.expected, one)
        for name, one in parameters.items()
    }
    beside = tuned.chosen.beside
    candidates = tuple(Candidate(name, one, beside, 1.5, 4) for name, one in parameters.items())

    def runner(name, trials):  # one run of the point is this one, all others are alike
        runs = [
            run if (n, i, j) == (RCAC, 1, 0) else (1.0, 1.0, 1.5, np.nan)
            for n in trials.controllers for i in range(len(trials.variations))
            for j in range(trials.seeds)
        ]  # fmt: skip
        return trials.of(runs)

    choice = _judged(
        rule_design, settings_by_name, candidates[1], candidates, 300, (2, 1, 0), runner
    )
    assert choice.chosen.name == RULE and equal(choice.settings, settings_by_name[RULE])
    assert choice.verdict.rcac.stable == (3, 3) and choice.beside_rule.losses == 0


@pytest.mark.costly
def test_in_a_certified_set_weaker_priors_are_tried_and_the_set_stays():
    start = design(
        "2/(10*s + 1)", sample_time=1.0, disturbance=0.5, noise=0.02, kept="certified", seeds=1,
        steps=400,
    )  # fmt: skip
    tuned = tune(start, 8, held_out=2, seeds=1)
    points = [one.parameters for one in tuned.candidates if one.name not in (RULE, FIXED)]
    least = TuningParameters().worth(start.expected) / 1000
    assert least <= min(one.samples for one in points) < 10
    assert all(one.spare == 0 and one.width == TuningParameters().width for one in points)
    assert equal(tuned.settings.bounds, start.certified.bounds)
    used = [r for t in tuned.design.evidence if t.controller == RCAC for r in t.radius]
    assert tuned.verdict.guarantee.radius == max(used) <= 1
    box = next(t for t in tuned.design.evidence if t.controller == BOXED)
    settings = settings_of(start.model, start.reference, start.expected, tuned.chosen.parameters)
    trials = Trials({BOXED: settings}, start.model, start.expected, (box.variation,), 400, 1)
    assert trials.in_threads()[0].rms == box.rms  # the chosen prior in the box
