"""Positive definiteness of rational matrices, held against SymPy and against known signs."""

import flint
from hypothesis import given
from hypothesis import strategies as st
from sympy import ImmutableMatrix, eye

from compensator_theory.matrices._definiteness import is_positive_definite
from compensator_theory.matrices._flint_matrices import to_flint
from compensator_theory.strategies import semidefinite_matrices

sizes = st.integers(1, 4)


@given(sizes.flatmap(semidefinite_matrices))
def test_a_gram_matrix_is_definite_where_it_is_regular(gram):
    assert is_positive_definite(to_flint(gram)) == (gram.det() != 0)


@given(sizes.flatmap(semidefinite_matrices), st.integers(1, 3000), st.sampled_from([1, -1]))
def test_the_smallest_change_of_a_singular_matrix_decides(gram, bits, sign):
    """Only rational numbers tell E'E + 2^-3000 I from E'E."""
    tiny = flint.fmpq(sign, flint.fmpz(2) ** bits)
    shift = flint.fmpq_mat(
        [[tiny * int(i == j) for j in range(gram.rows)] for i in range(gram.rows)]
    )
    expected = sign > 0 or (ImmutableMatrix(gram) - eye(gram.rows) / 2**bits).is_positive_definite
    assert is_positive_definite(to_flint(gram) + shift) == expected


def test_an_empty_matrix_is_positive_definite():
    assert is_positive_definite(flint.fmpq_mat(0, 0))
