"""A matrix that python-flint keeps is the same matrix to SymPy, and to whoever asks it anything."""

import pickle
from fractions import Fraction

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import ImmutableMatrix, Matrix, Rational
from sympy.abc import a, x

from compensator_theory import Realisation, budget
from compensator_theory.errors import BudgetError, InputError
from compensator_theory.matrices._exact_matrices import exact_matrix
from compensator_theory.matrices._flint_matrices import (
    RationalMatrix,
    from_flint,
    of_rows,
    symbols_in,
    to_flint,
    zero_matrix,
)

numbers = st.fractions(-9, 9, max_denominator=7)


@st.composite
def squares(draw):
    n = draw(st.integers(1, 4))
    rows = [[draw(numbers) for _ in range(n)] for _ in range(n)]
    plain = ImmutableMatrix(n, n, [Rational(e.numerator, e.denominator) for r in rows for e in r])
    return from_flint(to_flint(plain)), plain


SAME = {
    "tolist": lambda M: M.tolist(),
    "entries": list,
    "flat": lambda M: M.flat(),
    "todok": lambda M: M.todok(),
    "first": lambda M: M[0, 0],
    "row": lambda M: M[0, :],
    "last": lambda M: (M[-1], M[-1, -1], M[-1:, [0, -1]], M[::-1, 0], M[:, :0].shape),
    "several": lambda M: M[:2],
    "masked": lambda M: M[sympy.Integer(0), np.int64(0)],
    "str": str,
    "repr": repr,
    "latex": sympy.latex,
    "pretty": sympy.pretty,
    "srepr": sympy.srepr,
    "python": sympy.pycode,
    "code": lambda M: sympy.ccode(M, assign_to="A"),
    "octave": sympy.octave_code,
    "mathml": sympy.mathml,
    "exchanged": lambda M: M.xreplace({sympy.Integer(1): a}),
    "hash": hash,
    "args": lambda M: M.args,
    "shape": lambda M: M.shape,
    "symbols": lambda M: M.free_symbols,
    "transpose": lambda M: M.T,
    "sum": lambda M: M + M.T,
    "difference": lambda M: M - 2 * M.T,
    "negative": lambda M: -M,
    "product": lambda M: M * M.T,
    "power": lambda M: M**3,
    "half": lambda M: M / 2,
    "by a symbol": lambda M: a * M,
    "with symbols": lambda M: M * M.applyfunc(lambda e: e + a),
    "plus symbols": lambda M: M.applyfunc(lambda e: e + a) + M,
    "determinant": lambda M: M.det(),
    "rank": lambda M: M.rank(),
    "polynomial": lambda M: M.charpoly(x),
    "beside": lambda M: M.row_join(M).col_join(M.row_join(M)),
    "below symbols": lambda M: ImmutableMatrix([[a] * M.cols]).col_join(M),
    "zero": lambda M: (M - M).is_zero_matrix,
    "not zero": lambda M: M.is_zero_matrix,
    "subs": lambda M: M.subs(x, 1),
    "evalf": lambda M: M.evalf(5),
    "mutable": lambda M: M.as_mutable(),
    "rebuilt": lambda M: M.func(*M.args),
    "domain": lambda M: M.to_DM(),
    "floats": lambda M: np.array(M.tolist(), dtype=float).tolist(),
    "pickle": lambda M: pickle.loads(pickle.dumps(M)),
}


@given(squares())
def test_whatever_is_asked_the_answer_is_that_of_sympys_own_matrix(both):
    remaining, plain = both
    assert remaining == plain and plain == remaining and {remaining: 1}[plain] == 1
    for outside in (plain.rows**2, (0, plain.rows), (-plain.rows - 1, 0), (0, [plain.rows])):
        with pytest.raises(IndexError):
            remaining[outside]
    assert remaining != plain + sympy.eye(plain.rows) and remaining != 0
    for name, ask in SAME.items():
        assert ask(remaining) == ask(plain), name
    if plain.det():
        assert remaining.inv() == plain.inv()


@given(squares())
def test_what_is_made_of_rational_matrices_stays_in_flint(both):
    remaining, plain = both
    built = (
        remaining.T,
        remaining * remaining,
        remaining + remaining,
        -remaining,
        remaining * plain,
        remaining + plain,
        remaining[:, :1],
    )
    assert all(isinstance(M, RationalMatrix) for M in (*built, exact_matrix(plain, "A")))
    assert not isinstance(remaining * a, RationalMatrix) and symbols_in(remaining) == set()


@pytest.mark.parametrize("shape", [(0, 0), (0, 2), (2, 0), (1, 3)])
def test_matrices_without_rows_or_columns(shape):
    remaining, plain = zero_matrix(*shape), ImmutableMatrix.zeros(*shape)
    assert remaining == plain and hash(remaining) == hash(plain) and str(remaining) == str(plain)
    assert (
        remaining.tolist() == plain.tolist() and remaining.T == plain.T and remaining.is_zero_matrix
    )
    assert (
        of_rows([[]] * shape[0] if not shape[1] else [[0] * shape[1]] * shape[0], shape)
        == remaining
    )


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=4))
def test_floats_are_their_shortest_decimals_in_every_door(row):
    expected = [Rational(Fraction(repr(e))) for e in row]
    doors = [row], (tuple(row),), np.array([row]), [[str(e) for e in row]]
    assert all(list(exact_matrix(door, "A")) == expected for door in doors)


def test_doors_that_are_not_plain_are_read_as_before():
    third = [[np.float32(0.1), Rational(1, 3)], [np.int64(2), "1/7"]]
    assert exact_matrix(third, "A").tolist() == [[Rational(1, 10), Rational(1, 3)],
                                                 [2, Rational(1, 7)]]  # fmt: skip
    for bad in (
        [[float("nan")]],
        [[1, float("inf")]],
        [[True]],
        np.array([[np.nan]]),
        [[1], [1, 2]],
    ):
        with pytest.raises(InputError):
            exact_matrix(bad, "A")
    for long in ([[10**30]], [[Fraction(1, 10**30)]], Matrix([[10**30]]), [[1e30]]):
        with budget(digits=20), pytest.raises(BudgetError):
            exact_matrix(long, "A")
    with budget(entries=3), pytest.raises(BudgetError):
        exact_matrix(np.zeros((2, 2)), "A")


def test_a_pickle_of_a_result_is_one_of_sympys_matrices():
    plant = Realisation([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]])
    again = pickle.loads(pickle.dumps(plant))
    assert again == plant and type(again.A) is ImmutableMatrix and hash(again) == hash(plant)
