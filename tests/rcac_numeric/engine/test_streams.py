"""Streams of results: the runs of simulate_many, in any order, with nothing kept."""

import weakref

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory.errors import InputError

PLANT = rn.standard_plant("1/(q - 0.9)")


def case(seed, steps=60, n_c=2):
    settings = rn.ControllerSettings(
        structure=rn.iir(n_c), target=rn.fir_target(PLANT), update=rn.UD(R_theta=1.0 + seed)
    )
    w = np.random.default_rng(seed).standard_normal((steps, 1))
    return rn.SimulationCase(PLANT, settings, w)


@given(
    lengths=st.lists(st.integers(0, 80), max_size=20),
    at_once=st.integers(1, 9),
    lanes=st.booleans(),
)
def test_they_are_those_of_simulate_many(lengths, at_once, lanes):
    cases = [case(i, steps, 1 + i % 3) for i, steps in enumerate(lengths)]
    items = list(rn.simulate_stream(cases, at_once=at_once, lanes=lanes))
    assert sorted(result.number for result in items) == list(range(len(cases)))
    whole = rn.simulate_many(cases, lanes=lanes)
    assert all(result.value == whole[result.number] for result in items)


def test_a_reducer_takes_the_place_of_the_run():
    cases = [case(seed) for seed in range(20)]
    peaks = {
        result.number: result.value
        for result in rn.simulate_stream(cases, reduce=lambda i, run: (i, np.abs(run.z).max()))
    }
    assert peaks == {i: (i, np.abs(r.z).max()) for i, r in enumerate(rn.simulate_many(cases))}


def test_nothing_of_a_run_is_kept():
    observed, alive = [], []

    def reduced(number, run):
        observed.append(weakref.ref(run))
        return 0.0

    for _ in rn.simulate_stream((case(s) for s in range(40)), reduce=reduced, at_once=4):
        alive.append(sum(run() is not None for run in observed))
    assert len(alive) == 40 and max(alive) <= 4


def test_cases_are_taken_when_they_are_needed():
    elapsed = []

    def cases():
        for seed in range(100):
            elapsed.append(seed)
            yield case(seed)

    next(rn.simulate_stream(cases(), at_once=3))
    assert len(elapsed) == 3


def test_what_fails_is_a_result_and_the_rest_goes_on():
    def advance(k, x, u, w):
        raise ZeroDivisionError("a fault")

    broken = rn.FunctionPlant(
        advance=advance, output=lambda k, x, w: (x, x), n=1, l_u=1, l_w=1, l_y=1, l_z=1
    )
    good = case(1)
    cases = [
        good,
        rn.SimulationCase(broken, good.settings, good.w),
        rn.SimulationCase(PLANT, good.settings, [[np.nan]]),
        "no case",
        rn.SimulationCase(PLANT, good.settings, good.w, {"sride": 2}),
        good,
    ]
    counted = []
    result = {r.number: r for r in rn.simulate_stream(cases, progress=counted.append)}
    outcomes = [result[i].outcome for i in range(6)]
    assert outcomes == ["completed", "plant failed", "refused", "refused", "refused", "completed"]
    assert "a fault" in result[1].failure and "sride" in result[4].failure
    assert result[2].value is None and result[0].value == result[5].value
    assert counted == [1, 2, 3, 4, 5, 6]


def test_a_reducer_that_raises_costs_its_own_case():
    def reduced(number, run):
        return 1 / (number - 1)

    result = {r.number: r for r in rn.simulate_stream([case(i) for i in range(3)], reduce=reduced)}
    assert [result[i].outcome for i in range(3)] == ["completed", "reducer failed", "completed"]
    assert result[1].failure.startswith("ZeroDivisionError")


def test_a_key_pressed_keeps_what_was_under_way():
    def advance(k, x, u, w):
        if k == 20:
            raise KeyboardInterrupt
        return 0.5 * x + u + w

    plant = rn.FunctionPlant(
        advance=advance, output=lambda k, x, w: (x, x), n=1, l_u=1, l_w=1, l_y=1, l_z=1
    )
    good = case(1)
    with pytest.raises(rn.RunInterrupted) as caught:
        list(rn.simulate_stream([good, rn.SimulationCase(plant, good.settings, good.w)], threads=1))
    assert caught.value.runs[-1].outcome == "interrupted"


def test_bad_options_are_refused_before_anything_runs():
    with pytest.raises(InputError, match="at_once"):
        rn.simulate_stream([], at_once=0)
