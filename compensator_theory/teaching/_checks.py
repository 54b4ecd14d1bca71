"""Judge an answer by drawn cases or a certificate; a wrong one has its least counterexample."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random
from typing import TYPE_CHECKING, Any

from compensator_theory._latex import displayed, words
from compensator_theory.errors import CompensatorError, InputError, WrongAnswerError
from compensator_theory.libraries import require_library
from compensator_theory.polynomials._budget import repr_of
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.teaching._answers import written
from compensator_theory.teaching._course import course_exercises
from compensator_theory.teaching._exercises import Exercise, _Claim

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy

Case = tuple[Any, ...]


@dataclass(frozen=True)
class Judgement(ExactValue):
    """Whether an answer is right, and the least case in which it is wrong.

    Attributes
    ----------
    is_right : bool
    reason : str
        What is wrong with the answer, or what was checked.
    case : tuple
        The arguments of the case that decides, of least size; empty where none does.
    parameters : tuple of str
        The names of these arguments.
    draws : int
        Different cases in which the answer was compared; 0 for a certificate.
    """

    _ANSWER = "is_right"

    is_right: bool
    reason: str
    case: Case = ()
    parameters: tuple[str, ...] = ()
    draws: int = 0

    def __str__(self) -> str:
        place = location(self.parameters, self.case)
        if self.is_right:
            verdict = f"Right, by the counterexample {place}" if place else "Right"
        else:
            verdict = f"Wrong at {place}" if place else "Wrong"
        return f"{verdict}: {self.reason}."

    def _repr_markdown_(self) -> str:
        verdict = "Right" if self.is_right else "Wrong"
        return f"**{verdict}**{_escaped(str(self).removeprefix(verdict))}"

    def _repr_latex_(self) -> str:
        return displayed(words(str(self)))


def judge(exercise: Exercise | str, answer: Any, *, draws: int = 50, seed: int = 0) -> Judgement:
    """Judge an answer, and shrink the case in which it is wrong.

    Parameters
    ----------
    exercise : Exercise or str
        A teacher's exercise, or the number of one of the course: "3.1".
    answer : object
        A function, a claim's truth value or counterexample, or the object that the exercise asks
        for. An exception of a function is a fault of it, like a wrong value.
    draws : int
        The most cases that are drawn; fewer where fewer exist.
    seed : int
        One seed draws the same cases for everybody, so that equal answers have equal marks.

    Returns
    -------
    Judgement
        True or false in an ``if``.

    Raises
    ------
    InputError
        If the exercise does not exist, Hypothesis is not installed, or draws or seed is no such
        number.

    Examples
    --------
    >>> from compensator_theory.teaching import judge
    >>> judge("6.1", lambda k: 0 < k < 6).is_right
    True
    >>> print(judge("6.1", lambda k: k < 6))
    Wrong at k = 0: your function returns True; the stability of the loop is False.
    """
    exercise = _exercise(exercise)
    if type(draws) is not int or not 0 < draws <= 100_000:
        raise InputError(f"draws = {draws!r} must be an integer from 1 to 100000")
    if type(seed) is not int:
        raise InputError(f"seed = {seed!r} must be an integer")
    if isinstance(exercise, _Claim):
        return _judge_claim(exercise, answer, draws, seed)
    if not exercise.cases:
        fault = _fault(exercise, answer, ())
        return Judgement(fault is None, fault or "the certificate was recomputed")
    case, number = _least_case(exercise, answer, draws, seed)
    if case is None:
        return Judgement(True, f"{number} drawn cases agree", draws=number)
    fault = _fault(exercise, answer, case) or _UNSTEADY
    if fault == _UNANSWERED:
        return Judgement(False, fault)
    return Judgement(False, fault, case, exercise.parameters, number)


def check(exercise: Exercise | str, answer: Any, *, draws: int = 50, seed: int = 0) -> Judgement:
    """Judge an answer; a wrong one is an error, which fails the cell that grades it.

    Parameters
    ----------
    exercise, answer, draws, seed
        See :func:`judge`.

    Raises
    ------
    WrongAnswerError
        Its message is the counterexample, and a notebook shows the message alone; `judgement` is
        the :class:`Judgement`.
    InputError
        As for :func:`judge`.

    Examples
    --------
    >>> from compensator_theory.teaching import check
    >>> print(check("6.1", lambda k: 0 < k < 6))
    Right: 17 drawn cases agree.
    >>> check("6.1", lambda k: 0 < k <= 6)
    Traceback (most recent call last):
        ...
    compensator_theory.errors.WrongAnswerError: Wrong at k = 6: your function returns True; the
    stability of the loop is False.
    """
    judgement = judge(exercise, answer, draws=draws, seed=seed)
    if not judgement.is_right:
        raise WrongAnswerError(str(judgement), judgement=judgement)
    return judgement


def location(parameters: tuple[str, ...], case: Case) -> str:
    """Write a case: names and values."""
    return ", ".join(
        f"{name} = {written(value)}" for name, value in zip(parameters, case, strict=True)
    )


_UNANSWERED = "the exercise is not answered yet"
_UNSTEADY = "your function returns different values for the same arguments"


def _exercise(exercise: Exercise | str) -> Exercise:
    if isinstance(exercise, Exercise):
        return exercise
    exercises = course_exercises()
    if not isinstance(exercise, str) or exercise not in exercises:
        raise InputError(
            f"{exercise!r} is no exercise of the course, which has {', '.join(exercises)}; an "
            "Exercise of yours is made by teaching.function_exercise, for instance"
        )
    return exercises[exercise]


def _judge_claim(claim: _Claim, answer: Any, draws: int, seed: int) -> Judgement:
    if isinstance(answer, list | tuple):
        return _judge_counterexample(claim, tuple(answer))
    if str(answer) not in ("True", "False"):
        return Judgement(
            False,
            "the answer to a claim is True, False, or a counterexample: a tuple of "
            f"{', '.join(claim.parameters)}; not {repr_of(answer)}",
        )
    is_right = (str(answer) == "True") is claim.is_true
    most = draws if claim.is_true else 10 * draws  # a counterexample ends the search
    case, number = _least_case(claim, answer, most, seed)
    if case is None:
        truth = "holds" if claim.is_true else "does not hold in general"
        reason = f"the statement {truth}; {number} drawn cases have no counterexample"
        return Judgement(is_right, reason, draws=number)
    reason = _fault(claim, answer, case) or _UNSTEADY
    return Judgement(is_right, reason, case, claim.parameters, number)


def _judge_counterexample(claim: _Claim, case: Case) -> Judgement:
    if len(case) != len(claim.parameters):
        return Judgement(
            False,
            f"a counterexample is a tuple of {len(claim.parameters)} parts, "
            f"{', '.join(claim.parameters)}; this one has {len(case)}",
        )
    try:
        fault = claim.fault(None, *case)
    except Exception as error:  # what a student writes may raise anything
        refusal = str(error).rstrip(".")
        return Judgement(False, f"the counterexample cannot be read or is none: {refusal}")
    if fault is None:
        place = location(claim.parameters, case)
        return Judgement(False, f"{place} is no counterexample; the statement holds there")
    return Judgement(True, fault, case, claim.parameters)


def _least_case(exercise: Exercise, answer: Any, draws: int, seed: int) -> tuple[Case | None, int]:
    """Draw cases until one refutes the answer, and shrink it; and how many were compared."""
    require_library("hypothesis")
    from hypothesis import HealthCheck, Phase, find, settings
    from hypothesis.errors import Flaky, NoSuchExample

    compared: set[str] = set()
    refuting: list[Case] = []

    def refutes(case: Case) -> bool:
        compared.add(location(exercise.parameters, case))
        is_wrong = _fault(exercise, answer, case) is not None
        if is_wrong:
            refuting.append(case)
        return is_wrong

    quiet = settings(
        max_examples=draws,
        database=None,
        deadline=None,
        phases=(Phase.generate, Phase.shrink),
        suppress_health_check=list(HealthCheck),
    )
    try:
        case: Case = find(_joined(exercise), refutes, settings=quiet, random=Random(seed))
    except NoSuchExample:
        return None, len(compared)
    except Flaky:
        return refuting[-1], len(compared)
    return case, len(compared)


def _joined(exercise: Exercise) -> SearchStrategy[Case]:
    """All arguments of a case by one strategy."""
    from hypothesis import strategies as st

    def flat(parts: tuple[Any, ...]) -> Case:
        arguments: list[Any] = []
        for names, part in zip(exercise.cases, parts, strict=True):
            arguments += part if "," in names else (part,)
        if len(arguments) != len(exercise.parameters):
            raise InputError(
                f"the strategies draw {len(arguments)} arguments, and cases names "
                f"{len(exercise.parameters)}: {', '.join(exercise.parameters)}"
            )
        return tuple(arguments)

    return st.tuples(*exercise.cases.values()).map(flat)


def _fault(exercise: Exercise, answer: Any, case: Case) -> str | None:
    """Return the fault of an answer in a case; an exception of the answer is a fault, too."""
    try:
        return exercise.fault(answer, *case)
    except NotImplementedError:
        return _UNANSWERED
    except CompensatorError as error:
        return f"the answer is refused: {str(error).rstrip('.')}"
    except Exception as error:  # a student's function may raise anything
        return f"your answer raises {type(error).__name__}: {str(error).rstrip('.')}"


def _escaped(sentence: str) -> str:
    """Markdown without emphasis and formulas."""
    return "".join(f"\\{c}" if c in r"\`*_{}[]<>#|$~" else c for c in sentence)
