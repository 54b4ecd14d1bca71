"""Requests to the placement, its reasons for refusal, sensitivity, and Propositions 3 and 4."""

import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.bezout import (
    check_proposition_3,
    check_proposition_4,
    number_of_common_roots,
)
from compensator_theory.bezout._sylvester import sylvester_m
from compensator_theory.errors import ImproperError, NoSolutionError
from compensator_theory.loops import compensator_from_sensitivity
from compensator_theory.matrices._linear_algebra import determinant
from compensator_theory.placement._rounding_effects import rounded_polynomial, rounding_effect
from compensator_theory.strategies import polynomials, spectra, strictly_proper_plants

SIGNS = st.sampled_from([1, -1])


@pytest.mark.costly
@given(strictly_proper_plants(max_order=3), SIGNS, st.integers(0, 2), st.data())
def test_properness(plant, feedback, excess, data):
    n_c = plant.order + excess
    target = ct.polynomial_from_roots(data.draw(spectra(plant.order + n_c)), "s")
    strict = ct.place_poles(plant, target, feedback=feedback, properness="strictly proper")
    assert strict.compensator.is_strictly_proper and strict.residual.is_zero
    exact = ct.place_poles(plant, target, feedback=feedback, properness="exactly proper")
    assert exact.numerator.degree() == n_c == exact.denominator.degree()
    assert exact.residual.is_zero and exact.numerator.LC() == 1
    assert len(exact.homogeneous) == excess + 1
    back = [0] * excess + [-1]
    assert exact.residual_of(exact.member(back)).is_zero


@given(strictly_proper_plants(max_order=3), SIGNS, st.data())
def test_strictly_proper_below_order_n_needs_luck(plant, feedback, data):
    n = plant.order
    target = ct.polynomial_from_roots(data.draw(spectra(2 * n - 1)), "s")
    unique = ct.place_poles(plant, target, feedback=feedback)
    if n > 1 and unique.numerator.degree() < n - 1:
        placement = ct.place_poles(plant, target, feedback=feedback, properness="strictly proper")
        assert placement.compensator == unique.compensator
        with pytest.raises(NoSolutionError, match="not exactly proper"):
            ct.place_poles(plant, target, feedback=feedback, properness="exactly proper")
    elif unique.numerator.is_zero:
        pass
    else:
        with pytest.raises(NoSolutionError, match="every reachable target"):
            ct.place_poles(plant, target, feedback=feedback, properness="strictly proper")


@given(strictly_proper_plants(max_order=4), SIGNS, st.data())
def test_reasons_are_relations_that_reachable_targets_satisfy(plant, feedback, data):
    n = plant.order
    n_c = data.draw(st.integers(0, max(n - 2, 0)))
    target = ct.polynomial_from_roots(data.draw(spectra(n + n_c)), "s")
    try:
        ct.place_poles(plant, target, feedback=feedback)
        return
    except NoSolutionError as error:
        text = str(error)
    relation = text.split("every reachable target has ")[1].split(" = 0", maxsplit=1)[0]
    claimed = sympy.sympify(text.split("this one gives ")[1].split(". From", maxsplit=1)[0])

    def value(poly):
        names = {f"t_{i}": poly.coeff_monomial(poly.gen**i) for i in range(n + n_c + 1)}
        return sympy.sympify(relation).subs(names)

    assert value(target) == claimed != 0
    D_c = data.draw(polynomials("s", n_c, n_c, is_monic=True))
    N_c = data.draw(polynomials("s", 0, n_c))
    reachable = plant.denominator * D_c - feedback * plant.numerator * N_c
    assume(reachable.degree() == n + n_c)
    assert value(reachable) == 0


@given(strictly_proper_plants(max_order=3), SIGNS, st.data())
def test_least_order(plant, feedback, data):
    n = plant.order
    poles = data.draw(spectra(2 * n))
    placement = ct.place_poles(plant, list(poles), "least", feedback=feedback)
    order = placement.denominator.degree()
    assert placement.residual.is_zero
    assert placement.target == ct.polynomial_from_roots(poles[: n + order], "s")
    for lower in range(order):
        try:
            target = ct.polynomial_from_roots(poles[: n + lower], "s")
        except ct.InputError:
            continue
        with pytest.raises(NoSolutionError):
            ct.place_poles(plant, target, feedback=feedback)


def test_a_static_gain_is_found_where_one_does():
    plant = ct.transfer_function("1/(s*(s + 3))")
    placement = ct.place_poles(plant, [-1, -2, -5, -6], "least", feedback=-1)
    assert placement.denominator.degree() == 0 and placement.numerator.as_expr() == 2
    strict = ct.place_poles(
        plant, [-1, -2, -5, -6], "least", feedback=-1, properness="strictly proper"
    )
    assert strict.denominator.degree() == 2


@given(strictly_proper_plants(max_order=3), SIGNS, st.data())
def test_sensitivity_determines_the_compensator(plant, feedback, data):
    n_c = data.draw(st.integers(0, 2))
    D_c = data.draw(polynomials("s", n_c, n_c, is_monic=True))
    N_c = data.draw(polynomials("s", 0, n_c))
    compensator = ct.transfer_function((N_c, D_c))
    S = ct.sensitivity_function(plant, compensator, feedback=feedback)
    assert S.numerator == plant.denominator * D_c
    assert S.denominator == plant.denominator * D_c - feedback * plant.numerator * N_c
    point = sympy.Rational(355, 113)
    loop = plant.as_expr() * compensator.as_expr()
    s = plant.variable
    assert S.as_expr().subs(s, point) == 1 / (1 - feedback * loop.subs(s, point))
    again = compensator_from_sensitivity(plant, S, feedback=feedback)
    assert again == compensator.reduced()
    assert compensator_from_sensitivity(plant, S.reduced(), feedback=feedback) == again


def test_equal_polynomials_do_not_mean_equal_sensitivities():
    """(7.24): S determines G_c; the polynomial does not, without a bound on deg N_c."""
    family = ct.place_poles("1/(s - 1)", [-1, -2], feedback=-1, numerator_degree=1)
    members = [family.member([k]) for k in (0, 1)]
    assert all(family.residual_of(member).is_zero for member in members)
    first, second = (ct.sensitivity_function("1/(s - 1)", m, feedback=-1) for m in members)
    assert first.denominator == second.denominator and first != second
    assert family.sensitivity == first


def test_symbolic_sensitivity():
    S = ct.sensitivity_function("b/(s + a)", "k", feedback=-1)
    a, k = sympy.symbols("a k")
    assert S.denominator == ct.polynomial("s + a + b*k", "s")
    assert S.numerator.as_expr() == S.variable + a
    assert compensator_from_sensitivity("b/(s + a)", S, feedback=-1).as_expr() == k


@given(polynomials("s", 1, 4, is_monic=True), st.data())
def test_propositions_3_and_4(D, data):
    n = D.degree()
    N = data.draw(polynomials("s", 0, n - 1))
    n_c = data.draw(st.integers(max(N.degree(), 0), n + 2))
    m_hat = data.draw(st.integers(-1, n + 1))
    third = check_proposition_3(D, N, n_c, m_hat)
    fourth = check_proposition_4(D, N, n_c, m_hat)
    assert third.holds and fourth.holds
    assert third.right == (m_hat == n - 1)
    assert fourth.right == (m_hat == n - 1 and n_c == n)
    if m_hat == n - 1 and n_c > n:
        assert not third.printed_holds and "as printed" in str(third)
    if m_hat == n - 1 and n_c >= n - 1 and number_of_common_roots(D, N) == 0:
        assert determinant(sylvester_m(D, N, n_c, m_hat)) != 0  # Proposition 5, for every n_c


def test_bad_input():
    plant = "1/(s**2 + 3*s + 2)"
    four = [-1, -2, -3, -4]
    for bad in ("proper", "", 1):
        with pytest.raises(ct.InputError, match="properness"):
            ct.place_poles(plant, four, feedback=-1, properness=bad)
    with pytest.raises(ct.InputError):
        ct.place_poles(plant, four, feedback=-1, properness="strictly proper", numerator_degree=2)
    with pytest.raises(ct.InputError):
        ct.place_poles(plant, four, feedback=-1, properness="exactly proper", numerator_degree=1)
    for degree in (1.5, True, "1"):
        with pytest.raises(ct.InputError):
            ct.place_poles(plant, four, feedback=-1, numerator_degree=degree)
    for poles in ([-1], "s**2", 3, ["-1+j", -2, -3]):
        with pytest.raises(ct.InputError):
            ct.place_poles(plant, poles, "least", feedback=-1)
    with pytest.raises(NoSolutionError, match="n_c from 0 to 0"):
        ct.place_poles(plant, [-5, -6], "least", feedback=-1)
    with pytest.raises(ImproperError):
        ct.place_poles("s**3/(s + 1)", four, "least", feedback=-1)
    for function in (ct.sensitivity_function, compensator_from_sensitivity):
        for feedback in (0, 2, True, None):
            with pytest.raises(ct.InputError, match="feedback"):
                function(plant, "1", feedback=feedback)
        with pytest.raises(ct.InputError, match="variable"):
            function(plant, "1/(q + 1)", feedback=-1)
    with pytest.raises(ImproperError, match="well posed"):
        ct.sensitivity_function("s/(s + 1)", "1", feedback=1)
    for G, S in (("0/(s + 1)", "1"), (plant, "0/(s + 1)")):
        with pytest.raises(ct.InputError, match="zero"):
            compensator_from_sensitivity(G, S, feedback=-1)
    with pytest.raises(ImproperError, match="relative degree"):
        compensator_from_sensitivity(plant, "s/(s + 1)", feedback=-1)
    for function in (check_proposition_3, check_proposition_4):
        for arguments in (("s", "s", 1, 0), ("s**2", "s", 0, 1), ("s**2", "s", True, 1),
                          ("1/s", "s", 1, 1)):  # fmt: skip
            with pytest.raises(ct.InputError):
                function(*arguments)
    with pytest.raises(ct.InputError):
        rounded_polynomial(ct.polynomial("s + a"))
    with pytest.raises(ct.InputError):
        rounding_effect(
            ct.transfer_function("1/(s + a)", "s"), ct.transfer_function("1", "s"), feedback=1
        )
    with pytest.raises(ct.InputError):
        ct.place_poles("b/s", ["-1", "-2"], feedback=-1).to_control()
