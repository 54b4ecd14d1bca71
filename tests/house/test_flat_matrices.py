"""A flat B is a column and a flat C a row, in every function that takes them beside A."""

import inspect

import numpy as np
import pytest

import rcac_numeric as rcac
from compensator_theory.errors import CompensatorError
from tests.support.bad_inputs import GOOD
from tests.support.example_calls import example_calls
from tests.support.public import public_objects

EXACT = public_objects("compensator_theory")
AXES = {"B": 1, "C": 0}


def exact_doors():
    """Functions with a B or C of one column or row in their call, and its place."""
    for name, (arguments, keywords) in GOOD.items():
        if not inspect.isfunction(EXACT[name]):
            continue
        parameters = inspect.signature(EXACT[name]).parameters
        names = [k for k, one in parameters.items() if str(one.annotation).startswith("MatrixLike")]
        names = [k if k in names else "" for k in parameters]
        for place, argument in enumerate(arguments):
            letter = names[place] if place < len(names) else ""
            is_matrix = (
                letter in AXES and isinstance(argument, list) and isinstance(argument[0], list)
            )
            if is_matrix and np.shape(argument)[AXES[letter]] == 1:
                case = f"{name} {letter}"
                yield pytest.param(name, place, letter, arguments, keywords, id=case)


@pytest.mark.parametrize(("name", "place", "letter", "arguments", "keywords"), [*exact_doors()])
def test_in_the_exact_half(name, place, letter, arguments, keywords):
    expected = EXACT[name](*arguments, **keywords)
    flat = [entry for row in arguments[place] for entry in row]
    for argument in (flat, tuple(flat), np.array(flat, dtype=object)):
        changed = [*arguments[:place], argument, *arguments[place + 1 :]]
        assert EXACT[name](*changed, **keywords) == expected


def numeric_doors():
    for name, (one, call) in example_calls("rcac_numeric").items():
        for letter in AXES.keys() & call.keys():
            value = np.asarray(call[letter]) if call[letter] is not None else np.zeros(0)
            if value.ndim == 2 and value.shape[AXES[letter]] == 1 and value.dtype.kind in "if":
                yield pytest.param(one, call, letter, id=f"{name} {letter}")


@pytest.mark.parametrize(("one", "call", "letter"), [*numeric_doors()])
def test_in_the_numeric_half(one, call, letter):
    expected = one(**call)
    flat = one(**{**call, letter: np.ravel(np.asarray(call[letter]))})
    assert repr(flat) == repr(expected)


def test_what_does_not_fit_is_refused():
    with pytest.raises(CompensatorError):
        EXACT["is_controllable"]([[0, 1], [0, 0]], [0, 1, 2])
    with pytest.raises(CompensatorError):
        rcac.solve_riccati(
            [[0.0, 1.0], [0.0, 0.0]], [0.0, 1.0, 2.0], Q=np.eye(2), R=[[1.0]], time="continuous"
        )
    a, b = [[0.0, 1.0], [0.0, 0.0]], [0.0, 1.0]
    column = rcac.solve_riccati(a, np.reshape(b, (2, 1)), Q=np.eye(2), R=[[1.0]], time="continuous")
    assert np.array_equal(
        rcac.solve_riccati(a, b, Q=np.eye(2), R=[[1.0]], time="continuous").P, column.P
    )
