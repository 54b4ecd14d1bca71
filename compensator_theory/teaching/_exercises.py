"""Exercises: the cases that are drawn, and the fault of an answer in one case."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from compensator_theory.errors import InputError
from compensator_theory.teaching._answers import agree, written

Cases: TypeAlias = Mapping[str, Any]
"""Names of arguments and Hypothesis strategies, whose type is not imported: it is optional."""


class Exercise:
    """A question, and the function that finds the fault of an answer.

    :func:`function_exercise` and :func:`claim_exercise` make the two usual kinds. The third kind
    asks for one object, such as a compensator: it has no cases, and its fault recomputes a
    certificate.

    Parameters
    ----------
    question : str
        The question in one or two sentences.
    fault : function of the answer and the parts of a case
        None where the answer is right, otherwise what is wrong in this case: a sentence.
    cases : mapping of str to strategy, optional
        Names of the arguments and Hypothesis strategies that draw them. A name "a, b" belongs to a
        strategy that draws pairs. By default the answer is judged once.

    Examples
    --------
    A teacher's exercise: a compensator that gives the loop of 1/(s - 1) the pole -2.

    >>> from compensator_theory import feedback_connection, transfer_function
    >>> from compensator_theory.teaching import Exercise, judge
    >>> def fault(compensator):
    ...     loop = feedback_connection("1/(s - 1)", compensator, feedback=-1)
    ...     pole = "s + 2"
    ...     if loop.denominator.as_expr() != transfer_function(pole).numerator.as_expr():
    ...         return f"the closed-loop polynomial is {loop.denominator.as_expr()}, not {pole}"
    >>> exercise = Exercise("Give the loop of 1/(s - 1) the pole -2, with u = -k y.", fault)
    >>> print(judge(exercise, "3"))
    Right: the certificate was recomputed.
    >>> print(judge(exercise, "-3"))
    Wrong: the closed-loop polynomial is s - 4, not s + 2.
    """

    def __init__(
        self, question: str, fault: Callable[..., str | None], cases: Cases | None = None
    ) -> None:
        cases = {} if cases is None else cases
        if not isinstance(question, str) or not callable(fault):
            raise InputError("an Exercise is made of a question, a text, and a fault, a function")
        if not isinstance(cases, Mapping) or not all(
            isinstance(names, str) and hasattr(strategy, "flatmap")
            for names, strategy in cases.items()
        ):
            raise InputError(
                "cases must be a mapping from names of arguments to strategies, such as "
                '{"k": st.integers(-5, 5)}'
            )
        self.question, self.fault, self.cases = question, fault, dict(cases)

    def __repr__(self) -> str:
        return f"Exercise({self.question!r})"

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the arguments of a case."""
        return tuple(name.strip() for names in self.cases for name in names.split(","))


def function_exercise(
    question: str, cases: Cases, solution: Callable[..., Any], *, subject: str = "right value"
) -> Exercise:
    """Ask for a function, which is compared with the solution in drawn cases.

    Parameters
    ----------
    question : str
    cases : mapping of str to strategy
        As for :class:`Exercise`; the arguments of the function, in this order.
    solution : function
        Its value has the type that an answer is read as: bool, number or expression, polynomial,
        matrix, transfer function, or a tuple of these. Values are equal where their difference
        is zero; a transfer function is compared as a quotient.
    subject : str
        The name of the value, for the sentence that refutes an answer.

    Examples
    --------
    >>> from hypothesis import strategies as st
    >>> from compensator_theory.teaching import function_exercise, judge
    >>> exercise = function_exercise(
    ...     "Is the loop of 1/(s - a) with u = -k y stable?",
    ...     {"a": st.integers(-5, 5), "k": st.integers(-5, 5)},
    ...     lambda a, k: k > a,
    ...     subject="stability of the loop",
    ... )
    >>> print(judge(exercise, lambda a, k: k >= a))
    Wrong at a = 0, k = 0: your function returns True; the stability of the loop is False.
    """

    def fault(answer: Any, *case: Any) -> str | None:
        if not callable(answer):
            return f"the answer must be a function of ({', '.join(exercise.parameters)})"
        value, expected = answer(*case), solution(*case)
        if agree(value, expected):
            return None
        return f"your function returns {written(value)}; the {subject} is {written(expected)}"

    if not callable(solution):
        raise InputError("solution must be a function of the arguments that cases names")
    exercise = Exercise(question, fault, cases)
    if not exercise.cases:
        raise InputError("a function is compared in cases: names of arguments and strategies")
    return exercise


def claim_exercise(
    statement: str, cases: Cases, objection: Callable[..., str | None], *, is_true: bool
) -> Exercise:
    """Ask whether a statement holds in every case.

    The answer is True, False, or a counterexample: the arguments of a case as a tuple.

    Parameters
    ----------
    statement : str
    cases : mapping of str to strategy
        As for :class:`Exercise`.
    objection : function of the case
        None where the statement holds in the case, otherwise why it fails: a sentence.
    is_true : bool
        Whether the statement is a theorem. A test of the exercise draws cases: a theorem has no
        counterexample, a false statement has one.

    Examples
    --------
    >>> from compensator_theory import count_roots, polynomial
    >>> from compensator_theory.strategies import polynomials
    >>> from compensator_theory.teaching import claim_exercise, judge
    >>> def objection(p):
    ...     n = count_roots(p).unstable
    ...     has_positive_coefficients = min(polynomial(p).all_coeffs()) > 0
    ...     return f"it has {n} unstable roots" if n and has_positive_coefficients else None
    >>> exercise = claim_exercise(
    ...     "A polynomial of degree 3 with positive coefficients has no unstable root.",
    ...     {"p": polynomials(min_degree=3, max_degree=3, is_monic=True)},
    ...     objection,
    ...     is_true=False,
    ... )
    >>> judge(exercise, True).is_right, judge(exercise, False).is_right
    (False, True)
    >>> print(judge(exercise, ("s**3 + s**2 + s + 1",)))
    Wrong: p = s**3 + s**2 + s + 1 is no counterexample; the statement holds there.
    >>> print(judge(exercise, ("s**3 + s**2 + s + 2",)))
    Right, by the counterexample p = s**3 + s**2 + s + 2: it has 2 unstable roots.
    """

    def fault(answer: Any, *case: Any) -> str | None:
        return objection(*case)

    return _Claim(statement, fault, cases, is_true=is_true)


class _Claim(Exercise):
    """A statement with its truth value."""

    def __init__(
        self, question: str, fault: Callable[..., str | None], cases: Cases, *, is_true: bool
    ) -> None:
        super().__init__(question, fault, cases)
        if not isinstance(is_true, bool):
            raise InputError(f"is_true = {is_true!r} must be True or False")
        if not self.cases:
            raise InputError("a claim needs cases: names of arguments and strategies")
        self.is_true = is_true
