"""A symbol of ours is never one of the user's: renaming a symbol of the input renames the answer.

Every public function is asked about the good inputs of tests/support/bad_inputs.py with a symbol
put in. The answer is compared with that for a letter that nothing here introduces, for each letter
that the function's signature, its answer or the source of the package does introduce.
"""

import ast
import inspect
import itertools
import pathlib
import re
from collections import Counter
from dataclasses import fields

import pytest
import sympy
from sympy import Basic, MatrixBase, Poly, Symbol

import compensator_theory as exact
from compensator_theory.polynomials._values import ExactValue
from docs.reference_pages import nodes
from tests.support.bad_inputs import GOOD, NOT_DOORS
from tests.support.symbolic_inputs import PUBLIC, calls, symbols_in

OTHER = "mu_user"  # a letter that nothing introduces
NAME = re.compile(r"[^\W\d]\w*")
LABEL = re.compile(r"\b\w+ ?= ?")
WORDS = {
    "is_lqg_suboptimal": "u", "kalman_decomposition": "c o", "observer_based_compensator": "u y",
    "place_matrix_poles": "a", "transfer_function_is_observer_based": "a n",
    "state_feedback_family": "x", "observer_gain_family": "x",
    "exceptional_cases": "x y", "step_response": "y", "impulse_response": "y",
    "time_response": "y",
}  # fmt: skip
"""Letters in the sentences of answers that are words, or signals of the loop."""


def letters_of_the_source():
    """Names of symbols that are made by literals, and names that the choice of letters is given."""
    names = set()
    for path in pathlib.Path(exact.__file__).parent.rglob("_*.py"):
        for node in nodes(path):
            if isinstance(node, ast.Call):
                value = getattr(node.func, "attr", getattr(node.func, "id", ""))
                if value in ("Symbol", "symbols", "fresh", "introduced", "numbered", "_taken"):
                    texts = [a.value for a in node.args if isinstance(a, ast.Constant)]
                    names |= {t for t in texts if isinstance(t, str) and t.isidentifier()}
    return names


SOURCE = letters_of_the_source()


def defaults_of(function):
    parameters = inspect.signature(function).parameters.values()
    return {p.default for p in parameters if isinstance(p.default, str) and len(p.default) == 1}


def answers(name, call, symbol):
    """The answer for a symbol; None where there is no place for one, or a refusal."""
    answer = call(symbol)
    try:
        return None if answer is None else PUBLIC[name](*answer[0], **answer[1])
    except exact.CompensatorError:
        return None


# ---- answers that are the same but for names
def same(one, other, names):
    """Whether two answers are the same where the names of the first are changed."""
    if isinstance(one, Poly):
        return isinstance(other, Poly) and same(
            (one.gen, tuple(one.all_coeffs())), (other.gen, tuple(other.all_coeffs())), names
        )
    if isinstance(one, MatrixBase):  # its entries, since blocks are sorted by names
        return (
            isinstance(other, MatrixBase)
            and one.shape == other.shape
            and same(tuple(one), tuple(other), names)
        )
    if isinstance(one, Basic) and isinstance(other, Basic):
        renamed = one.xreplace({s: Symbol(names.get(s.name, s.name)) for s in one.free_symbols})
        return renamed == other or sympy.cancel(renamed - other) == 0
    if isinstance(one, tuple | list):
        if not isinstance(other, tuple | list) or len(one) != len(other):
            return False
        left = list(other)
        for part in one:  # what is sorted by its text comes in another order
            match = next((x for x in left if same(part, x, names)), None)
            if match is None:
                return False
            left.remove(match)
        return True
    if isinstance(one, ExactValue) and type(one) is type(other):
        pairs = {f.name: (getattr(one, f.name), getattr(other, f.name)) for f in fields(one)}
        for name in ("sample", "certificate"):  # chosen freely; the identity in words
            pairs.pop(name, None)
        where = pairs.pop("exceptional", ((), ()))  # where they vanish is the same
        squares = [tuple(factor**2 for factor in factors) for factors in where]
        return all(same(*pair, names) for pair in (squares, *pairs.values()))
    return one == other or isinstance(one, str)


def is_renamed(answer, other, letter):
    """Whether an answer for a letter is that for another one, names of ours changed as well."""
    if isinstance(answer, str) or answer == other:
        return isinstance(other, str) or OTHER not in symbols_in(other)
    mine, theirs = symbols_in(answer) - {letter}, symbols_in(other) - {OTHER}
    if len(mine) != len(theirs):
        return False
    ordered = sorted(mine & theirs)
    mine, theirs = sorted(mine - set(ordered)), sorted(theirs - set(ordered))
    return any(
        same(answer, other, {letter: OTHER, **dict(zip(mine, order, strict=True))})
        for order in itertools.permutations(theirs)
    )


ABBREVIATED = "matrix, see ."


def counts(text):
    """How often each name occurs, without the names: what is shown is the same up to renaming."""
    return sorted(Counter(NAME.findall(LABEL.sub("", text))).values())


def letters_for(function, answer):
    shown = {name for name in NAME.findall(str(answer)) if len(name) == 1 and name.islower()}
    return symbols_in(answer) | shown | defaults_of(function)


@pytest.mark.costly
@pytest.mark.parametrize("name", sorted(set(GOOD) - NOT_DOORS))
def test_a_symbol_of_the_input_is_kept_apart_from_ours(name):
    requested, left = SOURCE, 2
    for call, argument in calls(name):
        other = answers(name, call, OTHER) if left else None
        if other is None:
            continue
        left -= 1
        letters = letters_for(PUBLIC[name], other) | requested
        letters -= {OTHER, *argument, *WORDS.get(name, "").split()}
        requested = set()
        for letter in sorted(letters):
            result = answers(name, call, letter)
            if result is not None:
                assert is_renamed(result, other, letter), (letter, result, other)
                texts = str(result), str(other)
                if not any(ABBREVIATED in text for text in texts):  # by the length of its letters
                    assert counts(texts[0]) == counts(texts[1]), (letter, *texts)


# ---- the instances that were found first
def test_the_gain_of_a_loop_is_not_the_gain_of_the_plant():
    """By Routh: s**3 + 3 s**2 + 2 s + k g is stable for 0 < k g < 6."""
    for arguments in (["k/(s*(s + 1)*(s + 2))"], ["1/(s*(s + 1)*(s + 2))", "k"]):
        gains = exact.stabilising_gains(*arguments, feedback=-1)
        assert [p.name for p in gains.parameters] == ["k", "gain"]
        with pytest.raises(exact.InputError, match=r"symbol of the plant.*gain of the loop"):
            exact.stabilising_gains(*arguments, feedback=-1, gain="k")


@pytest.mark.parametrize("name", ["zero_order_hold", "first_order_hold", "tustin", "matched"])
@pytest.mark.parametrize("plant", ["h/(s + 1)", "(s + h)/(s + 1)", "1/(s + h)"])
def test_the_step_is_no_symbol_of_the_plant(name, plant):
    function = PUBLIC[name]
    assert function(plant, variable="s").step == Symbol("step")
    with pytest.raises(exact.InputError, match=r"symbol of the plant.*the step"):
        function(plant, "h", variable="s")


def test_a_letter_means_one_thing_in_all_cases():
    """Where k = 0 the plant has no k any more, and the gain is called no k for that."""
    cases = exact.exceptional_cases(exact.stabilising_gains, "k/(s*(s + 1)*(s + 2))", feedback=-1)
    assert [case.conditions for case in cases.cases] == ["k != 0", "k = 0"]
    assert "no real gain" in str(cases.cases[1])
    cases = exact.exceptional_cases(exact.solve_diophantine, "s - t", "s", "1", variable="s")
    assert all("t_*(" in str(case) for case in cases.cases if case.status == "answered")
