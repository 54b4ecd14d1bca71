"""Realisations, their hidden modes, the two gains and the compensator that they make."""

import control
import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.errors import (
    BudgetError,
    ImproperError,
    NotControllableError,
    NotObservableError,
)
from compensator_theory.strategies import (
    matrices,
    minimal_mimo_plants,
    spectra,
    strictly_proper_plants,
)
from tests.support.work import at_most

s = sympy.Symbol("s")
MOTOR = ([[-1, 4], [0, -3]], [[0], [1]], [[1, 0]])


def characteristic(matrix):
    """SymPy's own division-free route, not ours."""
    return sympy.Poly(sympy.Matrix(matrix).charpoly(s).as_expr(), s, domain="QQ")


@given(st.integers(1, 4).flatmap(lambda n: st.tuples(matrices(n, n), matrices(n, 1))))
def test_uncontrollable_modes_are_the_common_factors_of_adjugate_and_determinant(pair):
    A, B = pair
    resolvent = s * sympy.eye(A.rows) - A
    common = characteristic(A)
    for entry in resolvent.adjugate() * B:
        common = common.gcd(sympy.Poly(entry, s, domain="QQ"))
    assert ct.uncontrollable_polynomial(A, B, variable=s) == common.monic()
    assert ct.is_controllable(A, B) is (common.degree() == 0)


@given(
    matrices(2, 2),
    matrices(2, 1),
    matrices(1, 2),
    matrices(1, 1),
    matrices(1, 2),
    st.integers(1, 5),
)
def test_hidden_modes_are_what_the_transfer_function_cancels(A, B, C, mode, link, scale):
    zero_column = sympy.zeros(2, 1)
    A_wide = sympy.Matrix.vstack(A.row_join(zero_column), link.row_join(mode))
    hidden = ct.Realisation(
        A_wide, B.col_join(sympy.Matrix([scale])), C.row_join(sympy.zeros(1, 1))
    )
    G = hidden.transfer_function()
    assert hidden.unobservable_modes.rem(sympy.Poly(s - mode[0], s, domain="QQ")).is_zero
    assert G.common_factor().rem(sympy.Poly(s - mode[0], s, domain="QQ")).is_zero
    minimal = G.common_factor().degree() == 0
    assert hidden.is_minimal is minimal and not hidden.is_observable
    moved = hidden.in_basis([[1, 2, 0], [0, 1, -1], [0, 0, 3]])
    assert moved.transfer_function() == G
    assert moved.unobservable_modes == hidden.unobservable_modes


@given(strictly_proper_plants(), st.sampled_from(["controllable", "observable"]))
def test_canonical_forms_realise_the_pair_as_it_is(plant, form):
    doubled = ct.transfer_function((plant.numerator * ct.polynomial("s + 3"),
                                 plant.denominator * ct.polynomial("s + 3")))  # fmt: skip
    assert ct.realisation(plant, form=form).transfer_function() == plant
    assert ct.realisation(plant, form=form).is_minimal
    hidden = ct.realisation(doubled, form=form)
    assert hidden.transfer_function() == doubled
    modes = {"controllable": hidden.unobservable_modes, "observable": hidden.uncontrollable_modes}
    assert modes[form] == ct.polynomial("s + 3")
    assert (hidden.is_controllable, hidden.is_observable) == (
        form == "controllable",
        form == "observable",
    )


@given(strictly_proper_plants(), st.data())
def test_gains_place_the_eigenvalues(plant, data):
    system = ct.realisation(plant)
    n = system.n
    regulator, observer = (ct.polynomial_from_roots(data.draw(spectra(n)), "s") for _ in range(2))
    K = ct.regulator_gain(system.A, system.B, regulator)
    F = ct.observer_gain(system.A, system.C, observer)
    assert characteristic(system.A + system.B * K) == regulator
    assert characteristic(system.A - F * system.C) == observer


@given(st.integers(1, 3).flatmap(minimal_mimo_plants), st.data())
def test_gains_of_several_signals(plant, data):
    A, B, C = plant.A, plant.B, plant.C
    roots = [ct.polynomial_from_roots(data.draw(spectra(A.rows)), "s") for _ in range(2)]
    K, F = ct.regulator_gain(A, B, roots[0]), ct.observer_gain(A, C, roots[1])
    assert characteristic(A + B * K) == roots[0]
    assert characteristic(A - F * C) == roots[1]


def test_gains_agree_with_python_control():
    A, B = np.array([[0.0, 1, 0], [0, -2, 0.85], [0, -3, -1]]), np.array([[0.0], [0], [1]])
    roots = [-1.0, -2.0, -3.0]
    K = np.array(ct.regulator_gain(A, B, roots), float)
    assert np.allclose(K, -control.acker(A, B, roots), rtol=1e-10)


@given(strictly_proper_plants(max_order=3), st.data())
def test_proposition_1_the_allocation_does_not_matter(plant, data):
    n = plant.order
    p, r = (ct.polynomial_from_roots(data.draw(spectra(n)), "s") for _ in range(2))
    one, other = (
        ct.observer_based_compensator(plant, p, r),
        ct.observer_based_compensator(plant, r, p),
    )
    assert one.transfer_function == other.transfer_function
    assert one.certificate.holds and other.certificate.holds
    placed = ct.place_poles(plant, p * r, feedback=+1)  # through the Sylvester matrix instead
    assert one.transfer_function == placed.compensator
    assert characteristic(ct.closed_loop_matrix(one.plant, one.compensator)) == p * r


def test_example_7_1_and_7_2():
    first = ct.observer_based_compensator(MOTOR, [-5, -4], [-2, -6], variable="s")
    second = ct.observer_based_compensator(MOTOR, [-5, -6], [-2, -4], variable="s")
    assert (list(first.K), list(first.F)) == ([-3, -5], [4, sympy.Rational(-3, 4)])
    assert (list(second.K), list(second.F)) == ([-5, -7], [2, sympy.Rational(-1, 4)])
    assert first.transfer_function == second.transfer_function
    printed = ct.transfer_function("(33/4*s + 93/4)/(s**2 + 13*s + 49)")  # (7.31), with 8.25
    assert first.transfer_function.numerator == -printed.numerator
    assert first.transfer_function.denominator == printed.denominator
    assert "K = [[-3, -5]]" in str(first) and "G_c" in first._repr_latex_()


@given(strictly_proper_plants(max_order=3), st.data())
def test_the_transfer_function_of_a_minimal_plant_comes_with_its_identity(plant, data):
    """D D_c - N N_c = p_R p_O has one solution of degrees n - 1 and n."""
    n = plant.order
    p, r = (ct.polynomial_from_roots(data.draw(spectra(n)), "s") for _ in range(2))
    G_c = ct.observer_based_compensator(plant, p, r).transfer_function
    assert "p_R p_O" in G_c.certificate.identity and G_c.certificate.holds
    N, D = plant.numerator, plant.denominator
    assert D * G_c.denominator - N * G_c.numerator == p * r


def test_the_numerator_may_have_a_low_degree():
    """Erratum to the proof of Proposition 1: deg N_c <= n - 1, not = n - 1."""
    A, B, C = sympy.Matrix([[0, 1], [-2, -3]]), sympy.Matrix([0, 1]), sympy.Matrix([[1, 0]])
    K, F = sympy.Matrix([[1, 0]]), sympy.Matrix([0, 1])
    p_R = sympy.Poly((A + B * K).charpoly(s).as_expr(), s)
    p_O = sympy.Poly((A - F * C).charpoly(s).as_expr(), s)
    design = ct.observer_based_compensator((A, B, C), p_R, p_O, variable="s")
    assert (design.K, design.F) == (K, F)
    assert design.transfer_function.numerator == ct.polynomial(1, "s")


@given(strictly_proper_plants(max_order=2), matrices(1, 1), st.data())
def test_plants_with_a_direct_term(plant, direct, data):
    exact = ct.transfer_function(
        (plant.numerator + direct[0] * plant.denominator, plant.denominator)
    )
    p, r = (ct.polynomial_from_roots(data.draw(spectra(plant.order)), "s") for _ in range(2))
    design = ct.observer_based_compensator(exact, p, r)
    assert design.certificate.holds
    assert characteristic(ct.closed_loop_matrix(design.plant, design.compensator)) == p * r


def test_symbolic_design():
    design = ct.observer_based_compensator("b/(s**2 + a*s)", "s**2 + p*s + r", ["-c", "-d"])
    assert design.certificate.holds
    loop = ct.closed_loop_matrix(design.plant, design.compensator)
    a, b, c, d, p, r = sympy.symbols("a b c d p r")
    expected = (s**2 + p * s + r) * (s + c) * (s + d)
    assert sympy.cancel((s * sympy.eye(4) - loop).det() - expected) == 0
    assert design.plant.is_controllable is True
    assert design.plant.is_observable is None  # b may be 0
    assert ct.is_controllable(sympy.Matrix([[a]]), sympy.Matrix([b])) is None
    assert ct.is_controllable(sympy.Matrix([[a, 0], [0, a]]), sympy.Matrix([b, 1])) is False


def test_refusals():
    A, B, C = [[1, 0], [0, 2]], [[1], [0]], [[0, 1]]
    with pytest.raises(NotControllableError, match="s - 2"):
        ct.regulator_gain(A, B, [-1, -2])
    with pytest.raises(NotObservableError, match="s - 1"):
        ct.observer_gain(A, C, [-1, -2])
    with pytest.raises(NotControllableError, match="s - 2"):
        ct.observer_based_compensator((A, B, [[1, 1]]), [-1, -2], [-3, -4], variable="s")
    with pytest.raises(ct.InputError, match="stabilising_compensators"):
        ct.observer_based_compensator(([[0]], [[1, 2]], [[1]]), [-1], [-2], variable="s")
    with pytest.raises(NotControllableError, match="s - 2"):
        ct.regulator_gain(A, [[1, 2], [0, 0]], [-1, -2])
    with pytest.raises(NotObservableError, match="s - 1"):
        ct.observer_gain(A, [[0, 1], [0, 2]], [-1, -2])
    with pytest.raises(ct.InputError, match="degree 1"):
        ct.regulator_gain(*MOTOR[:2], [-1])
    with pytest.raises(ct.InputError, match="conjugate"):
        ct.regulator_gain(*MOTOR[:2], ["-1+1j", -1])
    with pytest.raises(ct.InputError):
        ct.controllability_matrix(sympy.eye(2), sympy.eye(3))
    with pytest.raises(ImproperError):
        ct.realisation("s**2/(s + 1)")
    with pytest.raises(ct.InputError, match="form"):
        ct.realisation("1/s", form="diagonal")
    with pytest.raises(ct.InputError, match="C is 1 x 3"):
        ct.Realisation([[1, 2], [3, 4]], [[1], [1]], [[1, 2, 3]])
    with pytest.raises(ct.InputError, match="variable"):
        ct.Realisation([["s"]], [[1]], [[1]])
    with pytest.raises(ct.InputError, match="variable"):
        ct.closed_loop_matrix(ct.realisation("1/s"), ct.realisation("1/z"))
    with pytest.raises(ct.InputError, match="direct term"):
        ct.closed_loop_matrix(ct.realisation("1/s"), ct.realisation("(s + 2)/(s + 1)"))
    with pytest.raises(ct.InputError, match="outputs"):
        ct.closed_loop_matrix(ct.realisation("1/s"), ct.Realisation([[1]], [[1, 2]], [[1]]))
    for bad in (([[float("nan")]], [[1]], [[1]]), 3, None, ("a", "b", "c"), ([[1]], [[]], [[1]])):
        with pytest.raises(ct.CompensatorError):
            ct.observer_based_compensator(bad, [-1], [-2])


def test_systems_of_python_control_keep_their_basis():
    system = control.ss([[0.1, 1], [0, -3]], [[0], [1]], [[1, 0]], 0, 0.1)
    exact = ct.realisation(system)
    assert exact.variable.name == "z" and exact.A[0, 0] == sympy.Rational(1, 10)
    assert "A = " in str(exact) and exact._repr_latex_().startswith("$")


def test_a_compensator_of_long_numbers_is_refused_by_one_entry():
    A, B, C = [[2, 1, 0], [0, 3, 1], [1, 0, 5]], [[1], [2], [7]], [[1, 3, 2]]
    poles = [[sympy.Rational(k, 10**90 + k) for k in (-7, -3, start)] for start in (-1, -2)]
    long = ct.observer_based_compensator((A, B, C), *poles, variable="s")
    assert long.certificate.holds
    with ct.budget(digits=250):
        for read in (lambda: long.compensator, lambda: long.certificate):
            with at_most(3_000), pytest.raises(BudgetError, match="transfer_function"):
                read()
