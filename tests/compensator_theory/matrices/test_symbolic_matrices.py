"""A matrix with symbols that python-flint keeps is the same matrix to SymPy, in lowest terms."""

import pickle

import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st
from sympy import ImmutableMatrix, Rational
from sympy.abc import a, b, c, x

from compensator_theory.errors import InputError
from compensator_theory.matrices._exact_matrices import exact_matrix
from compensator_theory.matrices._exceptional_factors import denominators_of, exceptional_factors
from compensator_theory.matrices._flint_backed import FlintBackedMatrix
from compensator_theory.matrices._flint_matrices import RationalMatrix, is_rational_matrix
from compensator_theory.matrices._linear_algebra import multiplied
from compensator_theory.matrices._symbolic_matrices import SymbolicMatrix, symbolic_matrix

ENTRIES = st.sampled_from(
    [sympy.Integer(k) for k in (-2, 0, 1)]
    + [a, a - b, a * b + 1, b / 2, 1 / (a + b), (a - 1) / b, Rational(1, 3)]
)


@st.composite
def squares(draw, entries=ENTRIES):
    n = draw(st.integers(1, 2))
    flat = draw(st.lists(entries, min_size=n * n, max_size=n * n))
    flat[draw(st.integers(0, n * n - 1))] = draw(st.sampled_from([a, 1 / b, a + c]))
    return ImmutableMatrix(n, n, flat)


def lowest(matrix):
    return ImmutableMatrix(matrix.applyfunc(sympy.cancel))


def at_numbers(matrix):
    return matrix.subs({a: Rational(7, 3), b: Rational(-5, 11), c: Rational(13, 2)})


SAME = {
    "tolist": lambda M: M.tolist(),
    "entries": list,
    "flat": lambda M: M.flat(),
    "todok": lambda M: M.todok(),
    "parts": lambda M: (M[0, 0], M[0, :], M[-1], M[-1:, [0, -1]], M[::-1, 0], M[:2], M[:, :0]),
    "texts": lambda M: (str(M), repr(M), sympy.latex(M), sympy.pretty(M), sympy.srepr(M)),
    "codes": lambda M: (sympy.pycode(M), sympy.ccode(M, assign_to="A"), sympy.octave_code(M)),
    "hash": hash,
    "args": lambda M: M.args,
    "symbols": lambda M: M.free_symbols,
    "transpose": lambda M: M.T,
    "polynomial": lambda M: M.charpoly(x).as_expr().expand(),
    "zero": lambda M: M.is_zero_matrix,
    "subs": lambda M: M.subs(a, 7),
    "exchanged": lambda M: M.xreplace({a: x}),
    "mutable": lambda M: M.as_mutable(),
    "rebuilt": lambda M: M.func(*M.args),
    "domain": lambda M: M.to_DM(),
    "pickle": lambda M: pickle.loads(pickle.dumps(M)),
}


@settings(max_examples=5)
@given(squares())
def test_whatever_is_asked_the_answer_is_that_of_sympys_own_matrix(matrix):
    remaining, plain = exact_matrix(matrix, "A"), lowest(matrix)
    assert isinstance(remaining, SymbolicMatrix) and not is_rational_matrix(remaining)
    assert remaining == plain and plain == remaining and {remaining: 1}[plain] == 1
    assert remaining != plain + sympy.eye(plain.rows) and remaining != 0
    for name, ask in SAME.items():
        assert ask(remaining) == ask(plain), name


@settings(max_examples=5)
@given(squares(), squares())
def test_operations_stay_in_flint_and_are_those_of_sympy(first, second):
    n = min(first.rows, second.rows)
    P, Q = first[:n, :n], second[:n, :n]
    R = ImmutableMatrix(n, n, lambda i, j: Rational(i - 2 * j, 3))
    p, q, r = (exact_matrix(M, "M") for M in (P, Q, R))
    mixed = Q if isinstance(p, SymbolicMatrix) else q
    for left, right, remaining, other in (
        (P, Q, p, q),
        (P, R, p, r),
        (R, P, r, p),
        (P, Q, p, mixed),
    ):
        for built, expected in (
            (remaining + other, left + right),
            (remaining - other, left - right),
            (remaining * other, left * right),
            (multiplied(remaining, other, remaining), left * right * left),
            (remaining.row_join(other), left.row_join(right)),
            (remaining.col_join(other), left.col_join(right)),
        ):
            assert isinstance(built, FlintBackedMatrix) and at_numbers(built) == at_numbers(
                expected
            )
    assert a * p == p * a and at_numbers(a * p / 2) == at_numbers(a * P / 2)
    assert sympy.sqrt(2) * p == p * sympy.sqrt(2)
    assert isinstance(p - p, RationalMatrix) and (p - p).is_zero_matrix
    assert (p + c * q - c * q) == p and (p + q) - q == p
    assert hash(p + c * q - c * q) == hash(p)


def test_what_is_no_rational_function_is_refused_at_the_door():
    for entry in (sympy.sqrt(a), sympy.exp(a), sympy.sqrt(2) * a, a**b):
        with pytest.raises(InputError, match="A"):
            exact_matrix([[entry]], "A")
        assert symbolic_matrix(ImmutableMatrix([[entry]])) is None


@settings(max_examples=5)
@given(squares())
def test_the_denominator_has_the_factors_of_all_entries(matrix):
    remaining = exact_matrix(matrix, "A")
    entries = [sympy.fraction(sympy.cancel(entry))[1] for entry in matrix]
    assert exceptional_factors(denominators_of([remaining])) == exceptional_factors(entries)


@pytest.mark.parametrize("place", [(5, 0), (0, -9), 99, (0, [3])])
def test_places_outside_are_refused(place):
    with pytest.raises(IndexError):
        exact_matrix([["a", 1]], "A")[place]


def test_what_would_have_millions_of_terms_is_not_written_out():
    whole = sympy.Add(*sympy.symbols("a:f"))
    for entry in (whole**199, 1 / whole**160, whole**20 * (whole + 1) ** 20):
        assert not isinstance(exact_matrix(sympy.Matrix([[entry, 1]]), "A"), SymbolicMatrix)
    assert isinstance(exact_matrix(sympy.Matrix([[whole**9, 1]]), "A"), SymbolicMatrix)
