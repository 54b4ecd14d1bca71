"""The exact target models with zero directions: conditions, oracles, refusals."""

import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

from compensator_theory import transfer_matrix, transmission_zeros, zero_direction_target
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.loops import direction_residual

SMALL = st.integers(-3, 3).map(sympy.Integer)
OUTSIDE = st.fractions(min_value=1, max_value=3, max_denominator=5).filter(lambda z: z > 1)
q = sympy.Symbol("q")


@st.composite
def requested_zeros(draw, count):
    size = draw(st.integers(2, 3))
    H = sympy.Matrix(size, size, draw(st.lists(SMALL, min_size=size**2, max_size=size**2)))
    assume(H.det() != 0)
    values = draw(st.lists(OUTSIDE, min_size=count, max_size=count, unique=True))
    etas = [draw(st.lists(SMALL, min_size=size, max_size=size)) for _ in values]
    assume(all(any(eta) for eta in etas))
    return H, list(zip(values, etas, strict=True))


@given(requested_zeros(1), st.integers(1, 3))
def test_one_real_zero_is_the_projection(case, delay):
    """q^-d (I - z0 q^-1 eta eta'/eta'eta) H, by SymPy's own matrices."""
    H, [(z0, eta)] = case
    built = zero_direction_target(H.tolist(), [(z0, eta)], delays=delay)
    column = sympy.Matrix(eta)
    projection = column * column.T / column.dot(column)
    expected = (sympy.eye(H.rows) - sympy.Rational(z0) / q * projection) * H / q**delay
    assert (built.transfer_matrix.as_matrix() - expected).applyfunc(sympy.cancel).is_zero_matrix


@given(requested_zeros(2), st.lists(st.integers(1, 3), min_size=3, max_size=3))
def test_every_condition_holds_and_there_are_no_other_nmp_zeros(case, delays):
    H, zeros = case
    built = zero_direction_target(H.tolist(), zeros, delays=delays[: H.rows])
    assert built.certificate.holds
    for z0, eta in zeros:
        assert direction_residual(built.transfer_matrix, z0, eta).is_zero_matrix
    determinant = sympy.Poly(sympy.cancel(q**30 * built.transfer_matrix.as_matrix().det()), q)
    roots = np.roots([float(c) for c in determinant.all_coeffs()])
    moduli = np.sort(np.abs(roots))[::-1]
    expected = np.sort([float(z0) for z0, _ in zeros])[::-1]
    assert np.allclose(moduli[:2], expected, rtol=1e-6)
    assert not (moduli[2:] > 1 + 1e-6).any()


def test_the_directions_are_those_that_the_smith_form_finds():
    """An oracle of another kind: `transmission_zeros` of the target."""
    built = zero_direction_target([[1, 0], [1, 2]], [("3/2", [1, -2])])
    outside = [d for d in transmission_zeros(built.transfer_matrix).directions if d.factor.nth(0)]
    assert len(outside) == 1 and outside[0].factor.as_expr() == q - sympy.Rational(3, 2)
    assert sympy.Matrix.hstack(outside[0].output, sympy.Matrix([1, -2])).rank() == 1


def test_a_complex_pair_is_real_and_two_zeros_of_one_direction_need_two_taps():
    built = zero_direction_target([[1, 0], [0, 1]], [("1 + 1j", [1, "1j"])])
    assert built.taps == 1 and built.certificate.holds
    assert direction_residual(built.transfer_matrix, "1 - 1j", [1, "-1j"]).is_zero_matrix
    same = zero_direction_target([[1, 0], [0, 1]], [("2", [1, 1]), ("3", [1, 1])])
    assert same.taps == 2 and same.certificate.holds
    real = zero_direction_target([[1, 0], [0, 1]], [("1 + 1j", [1, 0])])
    assert real.transfer_matrix[1, 1].numerator.as_expr() in (q, q**2)


def test_wide_and_tall():
    tall = zero_direction_target([[1], [2]], [("3/2", [1])])
    matrix = sympy.Matrix([1, 2]) * (q - sympy.Rational(3, 2)) / q**2
    difference = (tall.transfer_matrix.as_matrix() - matrix).applyfunc(sympy.cancel)
    assert difference.is_zero_matrix
    assert zero_direction_target([[1, 2, 0], [0, 1, 1]], [("2", [1, 1])]).certificate.holds


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([[1, 2], [2, 4]], [("2", [1, 0])]), "full rank"),
        (([[1, 0], [0, 1]], [("1/2", [1, 0])]), "inside the unit circle"),
        (([[1, 0], [0, 1]], [("2", [0, 0])]), "direction is zero"),
        (([[1, 0], [0, 1]], [("2", [1])]), "2 are needed"),
        (([[1, 0], [0, 1]], [("2", [1, "1j"])]), "must be real"),
        (([[1, 0], [0, 1]], [("sqrt(2)", [1, 0])]), "not rational"),
        (([[1, 0], [0, 1]], [3]), "not a pair"),
        (([[1, 0], [0]], []), "one and the same"),
    ],
)
def test_bad_input(arguments, message):
    with pytest.raises(InputError, match=message):
        zero_direction_target(*arguments)


@pytest.mark.parametrize("zero", [1, -1, sympy.I, "3/5 + 4/5*I", 1 - sympy.Rational(1, 10**12)])
def test_a_zero_on_the_circle_or_rounded_from_there_is_one_of_the_target(zero):
    """It is no stable zero: to cancel it would put a pole of the controller on the circle."""
    target = zero_direction_target([[1, 0], [0, 1]], [(zero, [1, 2])])
    assert target.certificate.holds
    assert direction_residual(target.transfer_matrix, zero, [1, 2]).is_zero_matrix
    with pytest.raises(InputError, match="inside the unit circle"):
        zero_direction_target([[1, 0], [0, 1]], [(1 - sympy.Rational(2, 10**12), [1, 2])])


def test_dependent_directions_and_too_few_taps():
    identity = [[1, 0], [0, 1]]
    with pytest.raises(NoSolutionError, match="dependent"):
        zero_direction_target(identity, [("2", [1, 1]), ("2", [2, 2])])
    with pytest.raises(NoSolutionError, match="leave the argument taps out"):
        zero_direction_target(identity, [("2", [1, 1]), ("3", [1, 1])], taps=1)
    with pytest.raises(InputError, match="is a pole"):
        direction_residual(transfer_matrix([["1/(q - 2)"]]), 2, [1])
