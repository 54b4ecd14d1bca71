"""The runs of a specification, the reduced experiment, and what a verification says at its end."""

from types import SimpleNamespace

import numpy as np
import pytest

from compensator_theory.errors import InputError
from rcac_experiments import verify
from rcac_experiments.dissertation import load_example
from rcac_experiments.experiments._experiment import (
    Experiment,
    RunResult,
    Verification,
    _known,
)
from rcac_experiments.files._builder import build
from rcac_experiments.judging._claim import Check, Claim
from rcac_numeric import Covariance
from rcac_numeric.arrays._values import replaced
from rcac_numeric.signals._signal import exogenous

RUN = build(
    {
        "plant": {"problem": "servo", "G": "(q - 0.5)/((q - 0.9)*(q - 0.3))"},
        "signals": {"r": 1, "v": {"white_noise": 0.1}},
        "target": {"model": "fir"},
        "controller": {"n_c": 3, "R_theta": 0.1},
        "run": {"steps": 20},
    },
    "case",
).main_run
STUDY = replaced(next(iter(load_example("8.1").studies.values())), seeds=5)


def experiment(runs, claims=(), **more):
    return Experiment("", "x", "x", runs, claims, **more)


def share(run, **more):
    return Check(measure="rms", at_most=1.0, run=run, share=0.5, **more)


# The cases of a specification.


def test_seeds_follow_each_other_and_are_not_perturbed():
    many = replaced(RUN, seed=3, seeds=2, perturbation=0.1, x_0=[1.0, 2.0], x_0_deviation=0.5)
    first, second = many.cases()
    for seed, one in ((3, first), (4, second)):
        assert np.array_equal(one.w, exogenous(RUN.signals, 20, seed))
        (alone,) = replaced(many, seed=seed, seeds=1).cases()
        assert np.array_equal(one.options["x_0"], alone.options["x_0"])
    assert not np.array_equal(first.options["x_0"], second.options["x_0"])


def test_repetitions_are_perturbed_by_what_the_seed_draws():
    """The oracle draws from the stream [seed, 1], w before x_0."""
    size = 1e-3
    twice = replaced(RUN, seed=3, repetitions=2, perturbation=size, x_0=[1.0, 2.0])
    w = exogenous(RUN.signals, 20, 3)
    rng = np.random.default_rng([3, 1])
    first, second = twice.cases()
    assert np.array_equal(first.w, w) and first.options["x_0"].tolist() == [1.0, 2.0]
    of_w, of_x = rng.standard_normal(w.shape), rng.standard_normal(2)
    assert np.allclose(second.w, w * (1 + size * of_w), rtol=1e-14, atol=0)
    assert np.allclose(second.options["x_0"], [1, 2] * (1 + size * of_x), rtol=1e-14, atol=0)


# The end of a run, and of a verification.


def result(outcome, expected):
    run = SimpleNamespace(run=SimpleNamespace(outcome=outcome))
    return RunResult(replaced(RUN, expected=expected), (run,))


@pytest.mark.parametrize(
    ("outcome", "expected", "as_expected"),
    [
        ("completed", "completed", True),
        ("diverged", "completed", False),
        ("completed", "diverged", False),
        ("diverged", "diverged", True),
        ("completed", "mixed", True),
        ("diverged", "mixed", True),
    ],
)
def test_a_run_ends_as_expected(outcome, expected, as_expected):
    assert result(outcome, expected).as_expected == as_expected


CALM, LOST = ("completed", "completed"), ("diverged", "completed")
MEANT, MISSED = ("diverged", "diverged"), ("completed", "diverged")


@pytest.mark.parametrize(
    ("ends", "has_changed", "status"),
    [
        ([], False, 0),
        ([CALM, MEANT], False, 0),
        ([CALM], True, 1),
        ([MISSED], False, 1),
        ([MISSED, MEANT], False, 1),
        ([LOST], False, 3),
        ([CALM, LOST], True, 3),
        ([MISSED, LOST], False, 3),
    ],
)
def test_the_exit_status(ends, has_changed, status):
    results = {str(i): result(*one) for i, one in enumerate(ends)}
    verdicts = (SimpleNamespace(has_changed=False), SimpleNamespace(has_changed=has_changed))
    assert Verification(experiment({}), results, verdicts).exit_status == status


# Fewer seeds.


def seeds_of(reduced):
    return {name: one.seeds for name, one in (reduced.runs | reduced.studies).items()}


FIVE = {name: replaced(RUN, seeds=5) for name in "abcd"}


def test_a_reduced_experiment_has_fewer_seeds_and_names_those_runs():
    runs = {"a": replaced(RUN, seeds=5), "b": RUN, "c": replaced(RUN, seeds=4)}
    case = experiment(runs, [Claim(text="x", checks=[Check(measure="rms", at_most=1.0, run="a")])])
    assert seeds_of(case.reduced()) == {"a": 3, "b": 1, "c": 3}
    assert case.reduced().reduced_runs == {"a", "c"} and not case.reduced(5).reduced_runs
    again = case.reduced(4).reduced(3)
    assert seeds_of(again) == {"a": 3, "b": 1, "c": 3} and again.reduced_runs == {"a", "c"}


def test_a_share_keeps_the_seeds_of_its_run_and_of_those_beside_it():
    of_a = experiment(FIVE, [Claim(text="x", checks=[share("a")])])
    assert seeds_of(of_a.reduced()) == {"a": 5, "b": 3, "c": 3, "d": 3}
    assert seeds_of(of_a.reduced(keep_shares=False)) == dict.fromkeys("abcd", 3)
    ratio = Check(measure="rms", at_most=1.0, run="b", relative_to="c")
    chain = [share("a", relative_to="b"), ratio]
    assert seeds_of(experiment(FIVE, [Claim(text="x", checks=chain)]).reduced()) == {
        "a": 5, "b": 5, "c": 5, "d": 3
    }  # fmt: skip
    alone = [Claim(text="x", checks=[ratio])]
    assert seeds_of(experiment(FIVE, alone).reduced()) == dict.fromkeys("abcd", 3)


class Exact:
    """A check of something exact: it has no share."""

    runs = ()


def test_a_share_keeps_the_seeds_over_which_its_claim_is_judged():
    claims = [
        Claim(text="x", checks=[Exact(), share("a")], over={"b": "holds"}, control="c"),
        Claim(text="y", checks=[Exact(), Check(measure="rms", at_most=1.0)], control="d"),
    ]  # fmt: skip
    names = {name for name, n in seeds_of(experiment(FIVE, claims).reduced()).items() if n == 5}
    assert names == {"a", "b", "c"}


def test_plain_arithmetic_keeps_its_seeds():
    plain = replaced(RUN.settings, update=Covariance(R_theta=0.1))
    runs = {**FIVE, "a": replaced(FIVE["a"], settings=plain)}
    assert seeds_of(experiment(runs).reduced()) == {"a": 5, "b": 3, "c": 3, "d": 3}


def test_studies_are_reduced_too():
    case = experiment({}, studies={"a": STUDY, "b": replaced(STUDY, seeds=2)})
    assert seeds_of(case.reduced()) == {"a": 3, "b": 2} and case.reduced().reduced_runs == {"a"}


# Checks that are refused before anything runs.


def refusal(check, runs, **more):
    with pytest.raises(InputError) as refused:
        verify(
            experiment(runs, [Claim(text="x", checks=[check])], **more),
            progress=lambda name: pytest.fail("a run began"),
        )
    return str(refused.value)


def test_what_a_check_names_is_known_before_anything_runs():
    one = {"a": RUN}
    assert "measure 'rsm'" in refusal(Check(measure="rsm", at_most=1.0), one)
    spoilt = Check(measure="rms", at_most=1.0, arguments={"bnd": 1})
    assert "the check 'rms'" in refusal(spoilt, one)
    for names in ({"run": "b"}, {"run": "a", "relative_to": "b"}):
        assert "the run 'b'" in refusal(Check(measure="rms", at_most=1.0, **names), one)
    for names in ({}, {"run": "a"}, {"run": "a", "relative_to": "a"}):
        _known(Check(measure="rms", at_most=1.0, **names), experiment(one))


def test_a_study_has_the_measures_of_estimation():
    _known(Check(measure="mean_error", at_most=1.0), experiment({}, studies={"a": STUDY}))
    check = Check(measure="rms", at_most=1.0)
    assert "measure 'rms'" in refusal(check, {}, studies={"a": STUDY})
    ratio = Check(measure="mean_error", at_most=1.0, run="a", relative_to="b")
    other = {"a": STUDY, "b": replaced(STUDY, seeds=4)}
    assert "pair by pair" in refusal(ratio, {}, studies=other)


def test_a_ratio_is_of_runs_of_one_number():
    check = Check(measure="rms", at_most=1.0, run="a", relative_to="b")
    four = {"a": replaced(RUN, seeds=4), "b": replaced(RUN, repetitions=4)}
    _known(check, experiment(four))
    for more in ({"seeds": 3}, {"repetitions": 3}, {}):
        assert "pair by pair" in refusal(check, {**four, "b": replaced(RUN, **more)})
