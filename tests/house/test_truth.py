"""A yes/no answer has the truth value that it says; no other result has one."""

import inspect
import re
import typing
from pathlib import Path

import pytest
import sympy

import compensator_theory as exact
import rcac_experiments
import rcac_numeric
from compensator_theory import InputError
from compensator_theory._truth import Truth
from rcac_experiments.dissertation._checking import Finding
from rcac_numeric.arrays._values import replaced
from tests.rcac_experiments.samples import SAMPLES as EXPERIMENTS
from tests.rcac_numeric.samples import SAMPLES as NUMERIC
from tests.support.public import public_objects

PAGE = Path(__file__).parents[2] / "docs/coming-from/exact.md"
PACKAGES = exact, rcac_numeric, rcac_experiments
RESULTS = {
    name: cls
    for package in PACKAGES
    for name in dir(package.results)
    if inspect.isclass(cls := getattr(package.results, name))
}


def plants(first, second):
    return exact.decide_simultaneous_stabilisability(first, second, feedback=-1)


def positions(C):
    return exact.geometry.decouple_disturbance(
        ([[0, 1], [0, 0]], [[0], [1]], [C]), [[1], [0]], variable="s"
    )


def certificate(residual):
    return exact.results.Certificate("x = 0", sympy.ImmutableMatrix([[residual]]))


def twice(name, yes):
    """A sample of the numeric half, which says no, and the same with evidence that says yes."""
    no = (NUMERIC | EXPERIMENTS)[RESULTS[name]](1)
    return [replaced(no, **yes(no)), no]


# The question is answered by hand: yes, then no.
ANSWERS = {
    "StabilityDecision": lambda: map(exact.decide_stability, ("s + 1", "s - 1")),
    "RealnessDecision": lambda: map(exact.decide_bounded_real, ("1/(s + 1)", "5/(s + 1)")),
    "StrongStabilisability": lambda: map(
        exact.decide_strong_stabilisability, ("1/(s - 1)", "(s - 1)/(s*(s - 2))")
    ),
    "SimultaneousStabilisability": lambda: [
        plants("1/(s - 1)", "2/(s - 1)"), plants("1/(s - 1)", "-1/(s - 1)")
    ],
    "IntervalStability": lambda: map(
        exact.decide_interval_stability, ([(1, 1), (1, 2)], [(1, 1), (-2, -1)])
    ),
    "ObserverDecision": lambda: [
        exact.observers.pair_is_observer_based("1/(s - 1)", c, feedback=1)
        for c in ("-6/(s + 4)", "-5/(s + 2)")
    ],
    "Certificate": lambda: map(certificate, (0, 1)),
    "Judgement": lambda: [
        exact.teaching.judge("6.1", answer) for answer in (lambda k: 0 < k < 6, lambda k: k < 6)
    ],
    "PropositionCheck": lambda: [
        exact.results.PropositionCheck("M = N iff n = 1", True, right, right)
        for right in (True, False)
    ],
    "DisturbanceDecoupling": lambda: map(positions, ([0, 1], [1, 0])),
    "PickInterpolation": lambda: [
        exact.interpolation.nevanlinna_pick([1], [1], bound) for bound in (2, "1/2")
    ],
    "ControlReplay": lambda: twice("ControlReplay", lambda no: {"worst": no.tolerance / 2}),
    "DirectionCheck": lambda: twice(
        "DirectionCheck", lambda no: {"forms": ("kept",) * len(no.forms)}
    ),
    "LoopHealth": lambda: twice("LoopHealth", lambda no: {"warnings": ()}),
    "Checked": lambda: twice("Checked", lambda no: {"facts": (Finding("1 = 1", True),)}),
}  # fmt: skip
"""Results whose sentence is a yes or a no. Every other one has no truth value."""


def test_every_result_is_an_answer_or_has_no_truth_value():
    """None of them is a sequence: those with a length count something, and hold more."""
    assert len(RESULTS) > 150 and ANSWERS.keys() <= RESULTS.keys()
    unruled = [name for name, cls in RESULTS.items() if cls.__bool__ is not Truth.__bool__]
    answers = {name for name, cls in RESULTS.items() if cls._ANSWER}
    questions = {name for name, cls in RESULTS.items() if (cls.__doc__ or "").startswith("Whether")}
    assert unruled == [] and answers == set(ANSWERS) >= questions


def test_the_page_lists_the_answers():
    (row,) = (
        line for line in PAGE.read_text("utf-8").splitlines() if "`StabilityDecision`" in line
    )
    assert set(re.findall(r"`(\w+)`", row.split("|")[1])) == set(ANSWERS)


def test_what_decides_returns_an_answer():
    for package in PACKAGES:
        for name, function in public_objects(package.__name__).items():
            if name.startswith(("decide_", "check_proposition")):
                assert typing.get_type_hints(function)["return"].__name__ in ANSWERS


@pytest.mark.parametrize("name", sorted(ANSWERS))
def test_an_answer_has_the_truth_value_that_it_says(name):
    yes, no = ANSWERS[name]()
    assert type(yes) is type(no) is RESULTS[name]
    assert bool(yes) is True and bool(no) is False, (str(yes), str(no))


@pytest.mark.parametrize("name", sorted(RESULTS.keys() - ANSWERS.keys()))
def test_what_answers_no_question_has_no_truth_value(name):
    with pytest.raises(InputError, match="is not None"):
        bool(object.__new__(RESULTS[name]))


def test_what_is_undecided_has_no_truth_value():
    undecided = exact.decide_stability("s + a")
    with pytest.raises(ValueError, match=r"undecided.*depending on its symbols.*\.is_stable"):
        assert undecided


def test_what_to_ask_instead():
    with pytest.raises(InputError, match=r"test .*\.is_stable"):
        bool(exact.stability_margins("9/(s*(s + 1)*(s + 2))", feedback=-1))


def test_what_one_constructs_is_true_as_any_object():
    system = exact.transfer_function("0", "s")
    assert system and exact.Budget() and exact.realisation("1/s") and rcac_numeric.UD(1.0)
