"""Judging: the least case, exceptions, functions that change, and what is no answer."""

import itertools
import pickle

import pytest
from hypothesis import strategies as st

import compensator_theory as exact
from compensator_theory.errors import InputError, WrongAnswerError
from compensator_theory.teaching import (
    Exercise,
    check,
    claim_exercise,
    course_exercises,
    function_exercise,
    judge,
)

SQUARE = function_exercise("The square of a.", {"a": st.integers(-9, 9)}, lambda a: a * a)
POSITIVE = claim_exercise(
    "Every a + b is positive.",
    {"a, b": st.tuples(st.integers(-9, 9), st.integers(-9, 9))},
    lambda a, b: f"the sum is {a + b}" if a + b <= 0 else None,
    is_true=False,
)


def test_the_least_case_of_all():
    assert judge(SQUARE, lambda a: a if a > 3 else a * a).case == (4,)
    assert judge(SQUARE, lambda a: a * a if a > -3 else 0).case == (-3,)
    assert judge(POSITIVE, True).case == (0, 0)


def test_a_judgement_is_the_same_again_and_pickles():
    first, second = (judge(SQUARE, lambda a: 2 * a) for _ in range(2))
    assert first == second == pickle.loads(pickle.dumps(first))
    assert not first and first.parameters == ("a",)


def test_every_case_is_compared_where_there_are_few():
    assert judge(SQUARE, lambda a: a**2, draws=200).draws == 19
    assert judge(SQUARE, lambda a: a**2, draws=3).draws <= 3


@pytest.mark.parametrize(
    ("answer", "sentence"),
    [
        (lambda a: 1 // a * 0 + a * a, "raises ZeroDivisionError"),
        (lambda a: None, "returns None"),
        (lambda: 1, "raises TypeError"),
        (7, "must be a function of (a)"),
        (lambda a: "a", "returns a; "),
        (lambda a: "a +", "refused"),
        (lambda a: [a], "refused"),
        (lambda a: float(a * a) + 1e-9, "returns"),
        (lambda a: float("nan"), "refused"),
    ],
)
def test_what_is_no_right_value_is_a_fault_in_a_sentence(answer, sentence):
    judgement = judge(SQUARE, answer)
    assert not judgement and sentence in str(judgement), str(judgement)


def test_an_unanswered_exercise_says_so():
    def answer(a):
        raise NotImplementedError

    with pytest.raises(WrongAnswerError, match="not answered yet"):
        check(SQUARE, answer)


def test_a_function_that_changes_its_mind_is_wrong():
    count = itertools.count()
    assert not judge(SQUARE, lambda a: a * a + next(count) % 2)


@pytest.mark.parametrize("answer", [True, 1, 0.5, "yes", None])
def test_a_truth_value_is_a_truth_value(answer):
    exercise = function_exercise("Is 2 even?", {"a": st.just(2)}, lambda a: True)
    assert bool(judge(exercise, lambda a: answer)) is (answer is True)


@pytest.mark.parametrize("answer", [(-1, 1), [0, 0]])
def test_a_counterexample_is_an_answer(answer):
    assert judge(POSITIVE, answer) and judge(POSITIVE, answer).case == tuple(answer)


@pytest.mark.parametrize("answer", [1, "False", None, (1,), (1, 2, 3), (1, "b"), ({}, 1)])
def test_what_answers_no_claim_is_wrong(answer):
    if answer == "False":
        assert judge(POSITIVE, answer)
        return
    judgement = judge(POSITIVE, answer)
    assert not judgement and "counterexample" in judgement.reason and judgement.case == ()


@pytest.mark.parametrize("number", ["0.1", "6", 6.1, None, ("6.1",), [], "nothing"])
def test_an_exercise_that_is_none_is_refused(number):
    with pytest.raises(InputError, match="no exercise of the course"):
        judge(number, 1)


@pytest.mark.parametrize("draws", [0, -1, 1.5, True, None, 10**9])
def test_draws_are_a_number(draws):
    with pytest.raises(InputError, match="draws"):
        judge(SQUARE, abs, draws=draws)


@pytest.mark.parametrize("seed", [1.5, None, "a", True])
def test_a_seed_is_an_integer(seed):
    with pytest.raises(InputError, match="seed"):
        judge(SQUARE, abs, seed=seed)


@pytest.mark.parametrize(
    "parts", [(1, print), ("q", 1), ("q", print, [1]), ("q", print, {"a": 1}), ("q", print, {1: 2})]
)
def test_an_exercise_of_other_parts_is_refused(parts):
    with pytest.raises(InputError):
        Exercise(*parts)


def test_strategies_and_names_fit_together():
    wrong = function_exercise("?", {"a, b": st.just((1, 2, 3))}, max)
    with pytest.raises(InputError, match="a, b"):
        judge(wrong, max)


@pytest.mark.costly
@pytest.mark.parametrize("number", [n for n, e in course_exercises().items() if e.cases])
def test_a_claim_and_a_case_are_what_they_are_said_to_be(number):
    """The truth values of the course: a theorem has no counterexample in many draws."""
    exercise = course_exercises()[number]
    if hasattr(exercise, "is_true") and exercise.is_true:
        assert judge(number, True, draws=300, seed=1)
    elif hasattr(exercise, "is_true"):
        assert judge(number, False, seed=1).case


def test_a_notebook_shows_a_sentence():
    right, wrong = judge("6.1", lambda k: 0 < k < 6), judge("6.1", lambda k: k < 6)
    assert right._repr_markdown_() == "**Right**: 17 drawn cases agree."
    assert "k = 0" in wrong._repr_markdown_() and exact.teaching.judge("6.1", lambda k: k).case
    try:
        check("6.1", lambda k: k < 6)
    except WrongAnswerError as error:
        assert error._render_traceback_() == [str(wrong)]
