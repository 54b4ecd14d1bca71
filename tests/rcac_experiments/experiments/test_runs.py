"""Runs over seeds and initial states, and runs that are cut off, against single runs."""

import copy

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from compensator_theory import InputError
from rcac_experiments.files._builder import build
from rcac_experiments.judging._measures import MEASURES
from rcac_numeric import simulate
from rcac_numeric.analysis._closed_loop import frozen_loop
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.signals._signal import exogenous

CASE = {
    "plant": {"problem": "servo", "G": "(q - 0.5)/((q - 0.9)*(q - 0.3))"},
    "signals": {"r": 1, "v": {"white_noise": 0.1}},
    "target": {"model": "fir"},
    "controller": {"n_c": 3, "R_theta": 0.1},
    "run": {"steps": 60},
}


def case(changes=(), **run):
    table = copy.deepcopy(CASE)
    table["run"].update(run)
    if changes:
        table["plant"]["changes"] = list(changes)
    return build(table, "case")


def same(a, b):
    names = ("u", "y", "z", "theta", "theta_final")
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in names)


@pytest.mark.costly
@settings(max_examples=10)
@given(seed=st.integers(0, 1000), seeds=st.integers(2, 5))
def test_seeds_are_the_single_runs_bit_for_bit(seed, seeds):
    runs = case(seed=seed, seeds=seeds).main_run.execute().repetitions
    assert len(runs) == seeds
    for number, repetition in enumerate(runs):
        assert same(case(seed=seed + number).main_run.execute().first.run, repetition.run)


def test_the_initial_state_is_drawn_for_each_seed():
    specification = case(seeds=4, x_0=[1.0, 2.0], x_0_deviation=0.5).main_run
    runs = [r.run for r in specification.execute().repetitions]
    states = np.array([run.x_0 for run in runs])
    assert len({tuple(state) for state in states}) == 4
    assert np.abs(states - [1, 2]).max() < 0.5 * 5
    for number, run in enumerate(runs):
        w = exogenous(specification.signals, 60, number)
        assert same(run, simulate(specification.plant, specification.settings, w, x_0=run.x_0))
    again = replace(specification, seeds=1, seed=2).execute().first.run
    assert same(again, runs[2]), "it belongs to the seed, not to its place"


def test_repetitions_change_the_initial_state_too():
    table = case(repetitions=3, perturbation=1e-6, x_0=[1.0, 2.0]).main_run.execute()
    states = np.array([r.run.x_0 for r in table.repetitions])
    assert states[0].tolist() == [1, 2]
    assert (states[1:] != [1, 2]).all() and np.abs(states - [1, 2]).max() < 2e-5


@pytest.mark.parametrize(
    ("run", "message"),
    [
        ({"seeds": 2, "repetitions": 2}, "give one"),
        ({"x_0": [1.0]}, "x_0 has 1 entries; the plant has 2 states"),
        ({"x_0": [1.0, 2.0], "arithmetic": "reference"}, "starts from rest"),
        ({"x_0_deviation": 1, "arithmetic": "reference"}, "starts from rest"),
        ({"seeds": 0}, "seeds = 0 must be at least 1"),
    ],
)
def test_what_is_refused(run, message):
    with pytest.raises(InputError, match=message):
        case(**run)


@pytest.mark.costly
@settings(max_examples=10)
@given(k=st.integers(4, 59), stride=st.sampled_from([1, 4, 7]))
def test_a_run_cut_off_is_the_shorter_run(k, stride):
    """Steps do not know how many follow: what is left is the run of k steps and its controller."""
    whole = case(stride=stride).main_run.execute().first
    if k % stride:
        with pytest.raises(InputError, match="was not stored"):
            whole.until(k)
        return
    cut, short = whole.until(k), case(stride=stride, steps=k).main_run.execute().first
    assert same(cut.run, short.run) and np.array_equal(cut.run.w, short.run.w)
    assert cut.split.power() == short.split.power()
    assert whole.until(k) is cut and whole.until(60) is whole
    whole_match = MEASURES["median_match"](whole)
    assert MEASURES["match_change"](whole, since=k) == whole_match / cut.match.median


def test_a_run_cut_off_has_the_plant_of_its_last_step():
    whole = case([{"start": 40, "gain": 3}]).main_run.execute().first
    assert np.array_equal(whole.plant.B, 3 * whole.until(40).plant.B)
    assert np.array_equal(whole.plant.B, whole.until(41).plant.B)
    assert whole.until(40).split.identity_error < 1e-12
    with pytest.raises(InputError, match="changes during the run"):
        whole.until(41).split  # noqa: B018
    frozen = frozen_loop(whole.run.plant, whole.run.compensator_at(40), 40)
    assert MEASURES["frozen_spectral_radius"](whole, at=40) == frozen.spectral_radius
    assert not np.isclose(whole.until(40).loop.spectral_radius, frozen.spectral_radius)
