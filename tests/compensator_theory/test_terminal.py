"""Results in a terminal: five lines, the answer first, and attributes that exist."""

import re

import pytest
import sympy
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import compensator_theory as exact
from compensator_theory._few_lines import MOST_LINES
from compensator_theory._terminal import WHOLE_CALL
from compensator_theory.polynomials._values import ExactValue

from .samples import SAMPLES

RESULTS = [cls for cls in SAMPLES if issubclass(cls, ExactValue)]


@pytest.mark.cases(40)
@pytest.mark.parametrize("cls", SAMPLES, ids=lambda cls: cls.__name__)
@settings(max_examples=8, suppress_health_check=[HealthCheck.too_slow], deadline=None)
@given(data=st.data())
def test_a_result_prints_on_at_most_five_lines(cls, data):
    value = data.draw(SAMPLES[cls])
    for written in (str(value), repr(value)):
        assert len(written.splitlines()) <= MOST_LINES
    for field in re.findall(r"(?<=[ ,(]\.)[A-Za-z_]\w*", repr(value) + cls_rest(cls)):
        assert hasattr(value, field), field


def cls_rest(cls):
    return " " + getattr(cls, "_REST", "")


def test_a_large_matrix_is_printed_by_its_shape():
    plant = exact.Realisation(sympy.eye(30), sympy.ones(30, 1), sympy.ones(1, 30), variable="s")
    assert str(plant).startswith("A: 30 x 30 matrix, see .A\nB = [[1], [1]")
    assert repr(plant).startswith("Realisation: A: 30 x 30 matrix, see .A\n  B = ")
    assert repr(plant).splitlines()[-1].startswith("  fields: .A, .B, .C, .D, .variable")


def test_the_lines_that_are_omitted_are_counted():
    zeros = exact.transmission_zeros("(s + 1)*(s + 2)*(s + 3)*(s + 4)*(s + 5)*(s + 6)/s**6", "s")
    lines = str(zeros).splitlines()
    assert len(lines) == MOST_LINES
    assert lines[-1] == "... 3 more; .directions lists them"
    assert ".directions (6)" in repr(zeros)


def test_a_short_result_is_a_constructor_call():
    count = exact.count_roots("s**2 - 1", time="continuous")
    assert repr(count) == "RootCount(stable=1, boundary=0, unstable=1)"


def test_a_long_result_gives_its_answer_first():
    region = exact.stability_region("s**2 + a*s + b", "a", "b")
    assert len(repr(region)) <= 500 and repr(region).startswith(f"StabilityRegion: {region}\n")
    assert repr(region).splitlines()[-1] == (
        "  fields: .polynomial, .parameters (2), .boundaries (2), .slabs (2), .of_a_loop"
    )
    assert WHOLE_CALL < 500


def test_a_large_matrix_of_polynomials_is_printed_whole_on_demand_only():
    matrix = exact.polynomial_matrix(
        [[f"s**9 + {10**40 + i * j}*s" for i in range(5)] for j in range(5)]
    )
    assert repr(matrix) == "<PolynomialMatrix, 5 x 5; print it for the entries>"
    assert repr(exact.polynomial_matrix([["s"]])) == "PolynomialMatrix([[s]])"
    assert str(10**40) in str(matrix)
