"""Experiments and verifications are data: they pickle to equal objects, in another process too."""

import copy
import pickle
import subprocess
import sys

import pytest

from rcac_experiments import verify
from rcac_experiments.dissertation import load_example
from rcac_experiments.dissertation._examples import example_ids
from rcac_numeric.arrays._values import replaced as replace

FRESH = """
import pickle, sys
from rcac_experiments import verify
from rcac_experiments.dissertation import load_example
first, second = pickle.load(sys.stdin.buffer)
experiment = load_example("2.6")
assert first == experiment and first.runs["mixed"] == experiment.runs["mixed"]
assert second == verify(load_example("4.7")), "a verification is a function of its data"
sys.stdout.buffer.write(pickle.dumps((first, second)))
"""


@pytest.mark.costly
@pytest.mark.cases(20)
@pytest.mark.parametrize("number", example_ids())
def test_every_example_pickles_and_compares(number):
    experiment = load_example(number)
    assert pickle.loads(pickle.dumps(experiment)) == experiment == copy.deepcopy(experiment)
    assert load_example(number) == experiment and hash(load_example(number)) == hash(experiment)
    if not experiment.runs:  # an exact example
        assert replace(experiment, claims=experiment.claims[:0]) != experiment
        return
    run = experiment.main_run
    changed = replace(experiment, runs={**experiment.runs, run.name: replace(run, seed=9)})
    assert changed != experiment, "equality looks inside"


def test_a_verification_pickles_and_compares():
    verification = verify(load_example("A.2"))
    verification.main.first.loop  # noqa: B018 what was analysed already is no part of the data
    again = pickle.loads(pickle.dumps(verification))
    assert again == verification
    assert [v.verdict for v in again.verdicts] == [v.verdict for v in verification.verdicts]


@pytest.mark.costly
def test_in_a_fresh_process():
    data = (load_example("2.6"), verify(load_example("4.7")))
    result = subprocess.run(
        [sys.executable, "-c", FRESH], input=pickle.dumps(data), capture_output=True, check=False
    )
    assert result.returncode == 0, result.stderr.decode()
    assert pickle.loads(result.stdout) == data
