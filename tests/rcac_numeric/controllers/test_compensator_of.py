"""A fixed compensator from a transfer function: the same one by every way in."""

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import transfer_function
from compensator_theory.errors import CompensatorError
from rcac_numeric import ClosedLoop, FixedController, h2_cost
from rcac_numeric.controllers._compensator import compensator_of

coefficients = st.lists(st.integers(-9, 9), min_size=1, max_size=4)


@given(coefficients, coefficients.filter(lambda d: d[0] != 0))
def test_text_exact_and_python_control_agree(numerator, denominator):
    numerator = numerator[: len(denominator)]
    q = " + ".join(f"({c})*q**{i}" for i, c in enumerate(reversed(numerator)))
    D = " + ".join(f"({c})*q**{i}" for i, c in enumerate(reversed(denominator)))
    text = f"({q})/({D})"
    compensator = compensator_of(transfer_function(text, "q"))
    points = np.exp(1j * np.array([0.3, 1.1, 2.9]))
    expected = np.polyval(numerator, points) / np.polyval(denominator, points)
    reached = np.polyval(compensator.numerator, points) / np.polyval(
        compensator.denominator, points
    )
    near = np.abs(np.polyval(denominator, points)) > 1e-3
    np.testing.assert_allclose(reached[near], expected[near], rtol=1e-9, atol=1e-12)
    if any(numerator) and len(denominator) > 1:
        same = compensator_of(text)
        assert np.array_equal(compensator.denominator, same.denominator)
        foreign = compensator_of(control.tf(numerator, denominator, True))
        values = np.polyval(foreign.numerator, points) / np.polyval(foreign.denominator, points)
        np.testing.assert_allclose(values[near], expected[near], rtol=1e-9, atol=1e-12)


def test_it_closes_loops_as_a_compensator_does():
    plant, text = "0.2*(q + 0.8)/((q - 0.9)*(q - 0.7))", "-(0.5*q - 0.4)/(q - 1)"
    compensator = compensator_of(text)
    assert compensator_of(compensator) is compensator
    assert np.array_equal(ClosedLoop(plant, text).poles(), ClosedLoop(plant, compensator).poles())
    assert h2_cost(plant, text).value == h2_cost(plant, compensator).value
    assert FixedController(text).compensator.l_y == 1
    assert ClosedLoop("1/q", "0.25").poles() == pytest.approx([0.25])


@pytest.mark.parametrize(
    ("obj", "words"),
    [
        ("1/(s + 1)", "in continuous time"),
        ("q", "future values of y"),
        ("k/q", "not a number"),
        ("sqrt(2)/q", "irrational"),
        (3, "is not a Compensator"),
        (None, "is not a Compensator"),
        ("1/(q -", "cannot read"),
    ],
)
def test_what_is_no_compensator_is_refused(obj, words):
    with pytest.raises(CompensatorError, match=words):
        FixedController(obj)
