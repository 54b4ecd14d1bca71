"""Transition matrices with symbols: short discriminants are answered, long ones are refused."""

import pytest
import sympy

from compensator_theory import transition_matrix
from compensator_theory.errors import BudgetError
from tests.support.work import at_most


def test_discriminants_with_too_many_terms_are_refused():
    A = sympy.Matrix(4, 4, lambda i, j: (3 * i + 5 * j + i * j) % 7)
    A += sympy.diag(*sympy.symbols("a b c"), 1)
    with (
        at_most(300_000),  # the answer takes 100 times as many
        pytest.raises(BudgetError, match="transition matrix with symbols"),
    ):
        transition_matrix(A)


def test_eigenvalues_that_are_symbols_have_no_discriminant():
    triangular = sympy.diag(*sympy.symbols("a b c d"))
    triangular[0, 1] = triangular[2, 3] = 1
    assert transition_matrix(triangular).is_verified
