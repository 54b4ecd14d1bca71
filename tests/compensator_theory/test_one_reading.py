"""What is given is read once, and means the same at every door that takes systems."""

from collections import Counter

import pytest

import compensator_theory as exact
from compensator_theory.polynomials import _expressions
from tests.support.disguises import DOORS, PUBLIC
from tests.support.natural_inputs import polynomial_inputs, system_inputs

AGAIN = {
    "canonical": "reads back what it wrote, which may be the text that was given",
    "exceptional_cases": "calls a function for the generic case, and again in each case",
}
STATES = [[0, 1], [1, 0]], [[0], [1]], [[2, 1]], [[0]]


def texts_in(argument):
    if isinstance(argument, str):
        yield argument
    elif isinstance(argument, list | tuple | set | dict):
        for part in argument.values() if isinstance(argument, dict) else argument:
            yield from texts_in(part)


@pytest.fixture
def readings(monkeypatch):
    """How often each text is taken apart."""
    tokens, read = _expressions._tokens, Counter()

    def counted(text):
        read[text] += 1
        return tokens(text)

    monkeypatch.setattr(_expressions, "_tokens", counted)
    return read


def test_readings_are_counted(readings):
    exact.transfer_matrix([["1/s", "1/s"]])
    assert readings == {"1/s": 2}


@pytest.mark.parametrize("name", sorted(DOORS.keys() - AGAIN))
def test_a_text_is_read_once(name, readings):
    """Neither to find the variable first, nor for the shape, nor by a function inside."""
    arguments, keywords = DOORS[name]
    PUBLIC[name](*arguments, **keywords)
    texts = Counter(texts_in([arguments, keywords]))
    assert {text: readings[text] for text in texts if readings[text] > texts[text]} == {}


def outcome(door, row):
    try:
        return door(row.make(), row.variable)
    except exact.CompensatorError as refusal:
        assert str(refusal)
        return None


@pytest.mark.parametrize("x", "sz")
def test_the_three_doors_of_systems_read_the_same(x):
    """Each takes what the others take: a matrix of one entry, states of a proper one."""
    scalar = 0
    for row in [*polynomial_inputs(x), *system_inputs(x)]:
        G = outcome(exact.transfer_function, row)
        matrix, states = outcome(exact.transfer_matrix, row), outcome(exact.realisation, row)
        if G is None:
            assert matrix is None or matrix.shape != (1, 1), row.name
            continue
        if isinstance(G, exact.DelayedTransferFunction):
            assert matrix is None and states is None and x == "s"
            continue
        scalar += 1
        assert matrix == exact.transfer_matrix(G), row.name
        assert states is None or states.transfer_function() == G, row.name
        if G.is_proper and G.numerator.domain.is_QQ:
            assert states is not None, row.name
    assert scalar > 40


def test_a_sample_time_beside_matrices_is_that_of_the_loop():
    """The shape of the plant was once asked as if it were in s, which has no sample time."""
    closed = exact.feedback_connection((*STATES, 0.1), "k", feedback=-1)
    assert str(closed) == "(z + 2)/(z**2 + k*z + (2*k - 1))"
    assert closed.sample_time == exact.exact_number("1/10")


@pytest.mark.parametrize("door", [exact.transfer_function, exact.transfer_matrix])
def test_keys_of_a_mapping_are_checked_at_every_door(door):
    with pytest.raises(exact.InputError, match="unknown keys \\['polse'\\]"):
        door({"zeros": [], "polse": [1]})
    with pytest.raises(exact.InputError, match="not both"):
        exact.transfer_function({"poles": [-1]}, "s", zeros=[-2])
