"""Transition matrices with symbols: short discriminants are answered, long ones are refused."""

from dataclasses import replace

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


@pytest.mark.parametrize("variable", ["s", "z"])
@pytest.mark.parametrize(
    "rows",
    [
        [[0, 1, 0], [0, 0, 1], [-2, -3, 1]],
        [[2, 1, 0], [0, 2, 0], [0, 0, "-1/3"]],  # a repeated eigenvalue, entries without modes
        [[0, 1], [0, 0]],
        [[1, 2], [-2, 1]],
    ],
)
def test_a_rational_certificate_is_that_of_the_transform(rows, variable):
    E = transition_matrix(rows, variable)
    x, n = E.variable, E.A.rows
    factor = x if variable == "z" else 1
    residual = (x * sympy.eye(n) - E.A) * E.transform - factor * sympy.eye(n)
    assert residual.applyfunc(sympy.cancel).is_zero_matrix and E.is_verified
    entries = [list(row) for row in E.responses]
    entries[0][-1] = entries[0][0]
    wrong = replace(E, responses=tuple(map(tuple, entries)))
    assert not wrong.is_verified and not wrong.certificate.holds
