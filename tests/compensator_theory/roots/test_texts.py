"""What counts, locates and splits roots reads whatever `polynomial` reads."""

import inspect

import pytest
import sympy

import compensator_theory as exact
from tests.support.public import public_objects

FUNCTIONS = (
    "certified_roots", "count_roots", "number_of_real_roots",
    "enclose_split_at_unit_circle", "locate_roots",
    "monic_reciprocal_polynomial", "reciprocal_polynomial", "reflection_coefficients",
    "split_at_unit_circle",
)  # fmt: skip
PUBLIC = public_objects("compensator_theory")
TIMED = ("count_roots", "locate_roots")
TEXT = "(q - 1/2)*(q - 3)*(q**2 + q/3 + 1/9)"


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_text_is_as_good_as_its_polynomial(name):
    function, q = PUBLIC[name], sympy.Symbol("q")
    times = [{}, {"time": "discrete"}] if name in TIMED else [{}]
    for time in times:
        expected = function(exact.polynomial(TEXT), **time)
        for argument in (TEXT, sympy.sympify(TEXT), sympy.Poly(sympy.sympify(TEXT), q)):
            assert function(argument, **time) == expected


def test_no_public_function_of_one_polynomial_wants_a_poly_alone():
    """But for `monic`, which stands below what reads."""
    functions = PUBLIC
    alone = {
        name for name, function in functions.items() if inspect.isfunction(function)
        for one in inspect.signature(function).parameters.values() if one.annotation == "Poly"
    }  # fmt: skip
    assert alone == {"monic"}
