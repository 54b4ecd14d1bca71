"""What a case may take is asked before anything is made, and can be allowed in so many words."""

import copy

import pytest

from compensator_theory import InputError
from rcac_experiments import ExperimentBudget
from rcac_experiments.files._builder import build
from tests.support.work import at_most, at_most_bytes

CASE = {
    "plant": {"problem": "servo", "G": "(q - 0.5)/((q - 0.9)*(q - 0.3))"},
    "signals": {"r": 1},
    "target": {"model": "fir"},
    "controller": {"n_c": 3, "R_theta": 0.1},
    "run": {"steps": 100},
}


CALLS, BYTES = 5_000_000, 100_000_000


def case(controller=(), **run):
    table = copy.deepcopy(CASE)
    table["controller"].update(controller)
    table["run"].update(run)
    return table


@pytest.mark.costly
@pytest.mark.parametrize(
    ("table", "message"),
    [
        (case({"n_c": 20_000}, steps=50_000), "bytes"),
        (case({"n_c": 20_000, "structure": "fir"}, steps=50_000), "bytes"),
        (case({"n_c": 50, "update": "sliding window", "window": 10**6}, steps=10**4), "bytes"),
        (case(steps=10**10), "bytes"),
        (case(repetitions=10**9), "bytes"),
        (case(repetitions=2**62), "bytes"),
        (case({"n_c": 1500}, steps=10**6, stride=10**6), "operations"),
        (case(steps=200, arithmetic="reference", repetitions=10_000), "operations"),
    ],
)
def test_what_would_take_too_much(table, message):
    refused = pytest.raises(InputError, match=f"{message}.*ExperimentBudget")
    with at_most(CALLS), at_most_bytes(BYTES), refused:
        build(table, "case")


def test_more_can_be_allowed():
    table = case(steps=2_000_000)
    small = ExperimentBudget(memory=1e7, operations=1e6)
    with pytest.raises(InputError, match=r"ExperimentBudget\(memory="):
        build(table, "case", small)
    with pytest.raises(InputError, match=r"ExperimentBudget\(operations="):
        build(table, "case", ExperimentBudget(operations=1e6))
    assert (
        build(table, "case", ExperimentBudget(memory=1e9, operations=1e9)).main_run.steps
        == 2_000_000
    )


def test_the_budget_is_of_all_runs_together():
    table = case()
    one = ExperimentBudget(operations=2e4)
    build(table, "case", one)
    table["runs"] = [{"name": str(i)} for i in range(5)]
    with pytest.raises(InputError, match="operations"):
        build(table, "case", one)
