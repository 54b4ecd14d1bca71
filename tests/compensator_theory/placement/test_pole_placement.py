"""Pole placement: the examples of chapter 7 and identities for random plants."""

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.bezout import number_of_common_roots
from compensator_theory.errors import ImproperError, NoSolutionError, NotCoprimeError
from compensator_theory.strategies import polynomials, rationals, spectra, strictly_proper_plants

SIGNS = st.sampled_from([1, -1])


def plant_of(A, B, C):
    problem = ct.StandardProblem(A, B, C, B, None, None, C, None, None, "s")
    return problem.transfer_function("yu")


def test_example_7_5():
    plant = plant_of([[-1, 4], [0, -3]], [[0], [1]], [[1, 0]])
    placement = ct.place_poles(plant, [-6, -5, -4, -2], feedback=-1)
    assert placement.numerator == ct.polynomial("33/4*s + 93/4")
    assert placement.denominator == ct.polynomial("s**2 + 13*s + 49")
    assert placement.is_unique and placement.residual.is_zero
    # The observer-based compensator (7.11), (7.12) of Examples 7.1 and 7.2, with u = G_c y: minus.
    A, B, C = sympy.Matrix([[-1, 4], [0, -3]]), sympy.Matrix([0, 1]), sympy.Matrix([[1, 0]])
    quarter = sympy.Rational(1, 4)
    for K, F in (([-3, -5], [4, -3 * quarter]), ([-5, -7], [2, -quarter])):
        row, column = sympy.Matrix([K]), sympy.Matrix(F)
        observer_based = plant_of(A + B * row - column * C, column, row)
        assert observer_based.numerator == -placement.numerator
        assert observer_based.denominator == placement.denominator


def test_example_7_6():
    plant = plant_of([[0, 1, 0], [0, -2, 0.85], [0, -3, -1]], [[0], [0], [1]], [[1, 0, 0]])
    assert str(plant) == "(17/20)/(s**3 + 3*s**2 + 91*s/20)"
    poles = ["-0.5+0.1j", "-0.5-0.1j", "-1+0.5j", "-1-0.5j", "-2+1j", "-2-1j"]
    placement = ct.place_poles(plant, poles, feedback=-1)
    assert placement.numerator == ct.polynomial("4747/850*s**2 + 13657/1700*s + 65/34")
    assert placement.denominator == ct.polynomial("s**3 + 4*s**2 + 99/25*s + 73/100")
    positive = ct.place_poles(plant, poles, feedback=+1)
    assert (positive.numerator, positive.denominator) == (
        -placement.numerator,
        placement.denominator,
    )


@given(strictly_proper_plants(max_order=5), SIGNS, st.integers(-1, 2), st.integers(0, 2), st.data())
def test_residual_uniqueness_and_families(plant, feedback, excess, extra, data):
    n = plant.order
    n_c = n + excess
    target = ct.polynomial_from_roots(data.draw(spectra(n + n_c)), "s")
    numerator_degree = min(n - 1 + extra, n_c)
    placement = ct.place_poles(plant, target, feedback=feedback, numerator_degree=numerator_degree)
    assert placement.residual.is_zero
    assert (placement.denominator.degree(), placement.denominator.is_monic) == (n_c, True)
    assert placement.numerator.is_zero or placement.numerator.degree() <= n - 1
    assert len(placement.homogeneous) == numerator_degree - (n - 1)
    parameters = data.draw(st.lists(rationals(), min_size=extra, max_size=extra))
    parameters = parameters[: len(placement.homogeneous)]
    member = placement.member(parameters)
    assert placement.residual_of(member).is_zero
    assert (member.order, bool(member.is_proper)) == (n_c, True)
    for i, parameter in enumerate(parameters):
        assert member.numerator.coeff_monomial(member.variable ** (n + i)) == parameter
    default = ct.place_poles(plant, target, feedback=feedback)
    assert default.is_unique
    assert default.compensator == placement.member([0] * len(placement.homogeneous))


@given(strictly_proper_plants(max_order=3), SIGNS, st.data())
def test_a_designed_compensator_is_found_again(plant, feedback, data):
    n_c = data.draw(st.integers(plant.order - 1, plant.order + 2))
    D_c = data.draw(polynomials("s", n_c, n_c, is_monic=True))
    N_c = data.draw(polynomials("s", 0, plant.order - 1))
    target = plant.denominator * D_c - feedback * plant.numerator * N_c
    placement = ct.place_poles(plant, target, feedback=feedback)
    assert (placement.numerator, placement.denominator) == (N_c, D_c)


@given(strictly_proper_plants(variable="q", max_order=3), st.data())
def test_poles_of_the_loop_that_results(plant, data):
    target = ct.polynomial_from_roots(data.draw(spectra(2 * plant.order)), "q")
    placement = ct.place_poles(plant, target, feedback=+1)
    loop = ct.standard_problem(plant)
    assert ct.closed_loop_polynomial(loop, placement.numerator, placement.denominator) == target


@given(strictly_proper_plants(max_order=3), rationals().filter(bool), SIGNS, st.data())
def test_exactly_proper_plants(plant, direct, feedback, data):
    exact = ct.TransferFunction(plant.numerator + direct * plant.denominator, plant.denominator)
    n = exact.order
    for n_c in (n - 1, n, n + 1):
        target = ct.polynomial_from_roots(data.draw(spectra(n + n_c)), "s")
        try:
            placement = ct.place_poles(exact, target, feedback=feedback)
        except ImproperError as error:
            assert n_c == n - 1 and "well posed" in str(error)
            continue
        assert placement.is_unique and placement.residual.is_zero
        assert placement.leading_coefficient == 1 or n_c == n - 1
        assert placement.denominator.degree() == n_c
    with pytest.raises(ct.InputError, match="exactly proper"):
        ct.place_poles(exact, target, feedback=1, numerator_degree=n_c)


@given(strictly_proper_plants(max_order=3), polynomials("s", 1, 2, is_monic=True), st.data())
def test_a_common_factor_is_fixed(plant, factor, data):
    hidden = ct.TransferFunction(plant.numerator * factor, plant.denominator * factor)
    n = hidden.order
    rest = ct.polynomial_from_roots(data.draw(spectra(2 * n - factor.degree())), "s")
    placement = ct.place_poles(hidden, rest * factor, feedback=-1)
    assert placement.residual.is_zero
    assert len(placement.homogeneous) == factor.degree()
    if number_of_common_roots(rest, factor) == 0:
        other = factor + ct.polynomial(1, "s")
        if factor.gcd(rest * other).degree() < factor.degree():
            with pytest.raises(NotCoprimeError):
                ct.place_poles(hidden, rest * other, feedback=-1)


def test_symbolic_placement():
    placement = ct.place_poles("b/(s**2 + a*s)", "(s + p)**3", feedback=-1)
    a, b, p = sympy.symbols("a b p")
    s = placement.plant.variable
    assert placement.residual.is_zero and placement.is_unique
    assert sympy.cancel(placement.denominator.as_expr() - (s + 3 * p - a)) == 0
    slope = (3 * p**2 - a * (3 * p - a)) / b
    assert sympy.cancel(placement.numerator.as_expr() - slope * s - p**3 / b) == 0
    family = ct.place_poles("b/(s + a)", ["-p", "-r"], feedback=1, numerator_degree=1)
    assert family.residual_of(family.member(["alpha"])).is_zero


def test_low_order():
    assert ct.place_poles("1/(s**2 + 3*s + 2)", "s**2 + 3*s + 7", feedback=-1).numerator.LC() == 5
    with pytest.raises(NoSolutionError, match="n_c = 1"):
        ct.place_poles("1/(s**2 + 3*s + 2)", "s**2 + 4*s + 7", feedback=-1)
    with pytest.raises(NoSolutionError):
        ct.place_poles("1/s**2", "(s + 1)**4", feedback=-1, numerator_degree=0)


def test_refusals():
    with pytest.raises(TypeError):
        ct.place_poles("1/s", [-1])
    for feedback in (0, 2, True, "negative"):
        with pytest.raises(ct.InputError, match="feedback"):
            ct.place_poles("1/s", [-1], feedback=feedback)
    with pytest.raises(ImproperError):
        ct.place_poles("s**2/(s + 1)", [-1], feedback=1)
    with pytest.raises(ImproperError):
        ct.place_poles("1/s", [-1, -2], feedback=1, numerator_degree=2)
    for target, n_c in (([-1], None), ([-1, -2, -3], 2), ([-1, -2], 1), ([], None)):
        with pytest.raises(ct.InputError):
            ct.place_poles("1/s**2", target, n_c, feedback=1)
    # D D_c + N N_c = (s**2 + s + 1)*1 + (s**2 + 1)*s: D_c = 1 is no denominator of order 1.
    with pytest.raises(ImproperError, match="the only pair"):
        ct.place_poles("(s**2 + 1)/(s**2 + s + 1)", polynomial=[1, 1, 2, 1], feedback=-1)
    # n_c = n: the leading coefficient would hang on the free parameter.
    with pytest.raises(ct.InputError, match="exactly proper"):
        ct.place_poles("(s + 2)/(s + 1)", [-1, -2], feedback=-1, numerator_degree=1)
    with pytest.raises(NotCoprimeError, match=r"s \+ 1"):
        ct.place_poles("(s + 1)/((s + 1)*(s + 2))", ["-3", "-4", "-5"], feedback=-1)
    with pytest.raises(ct.InputError):
        ct.place_poles("1/s", ["-1+1j", -2], feedback=1)
    with pytest.raises(ct.InputError):
        ct.place_poles("1/(s + 1)", [-1, -2], feedback=1, numerator_degree=1).member([])


def test_it_prints_and_scales():
    family = ct.place_poles("1/(s - 1)", [-1, -2], feedback=1, numerator_degree=1)
    assert "1-parameter family" in str(family) and "D D_c - N N_c" in str(family)
    assert "G_c" in family._repr_latex_()
    rng = np.random.default_rng(3)
    n = 15
    plant = ct.transfer_function(
        zeros=[float(x) for x in rng.uniform(-9, 0, n - 1)],
        poles=[float(x) for x in rng.uniform(-9, 9, n)], gain=1, variable="s",
    )  # fmt: skip
    assert ct.place_poles(plant, list(range(-2 * n, 0)), feedback=-1).residual.is_zero
