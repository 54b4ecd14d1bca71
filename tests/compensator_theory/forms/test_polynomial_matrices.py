"""Arithmetic of polynomial matrices against SymPy's at a point."""

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import InputError, polynomial_matrix
from compensator_theory.errors import CompensatorError
from compensator_theory.strategies import polynomials, rationals

s = sympy.Symbol("s")
squares = st.integers(1, 3).flatmap(
    lambda n: st.lists(
        st.lists(polynomials(max_degree=2), min_size=n, max_size=n), min_size=n, max_size=n
    ).map(lambda rows: polynomial_matrix(rows, "s"))
)


@given(squares, rationals(), st.integers(0, 3))
def test_products_and_powers(P, point, exponent):
    assert (P * P)(point) == P(point) * P(point) == (P @ P)(point)
    assert (P**exponent)(point) == P(point) ** exponent
    assert (2 * P)(point) == 2 * P(point) == (P * 2)(point)
    assert (P * (s + 1))(point) == (point + 1) * P(point)


def test_what_has_no_product():
    P = polynomial_matrix([["s", "1"]], "s")
    for call in (lambda: P**2, lambda: P**-1, lambda: P * P):
        with pytest.raises(InputError):
            call()
    with pytest.raises(TypeError):
        P * None
    assert (
        P * "s" == "s" * P == s * P and polynomial_matrix([["a*s"]], "s").subs({"a": 0})[0, 0] == 0
    )
    with pytest.raises(CompensatorError):
        polynomial_matrix([["s**300"]], "s") ** 100_000
