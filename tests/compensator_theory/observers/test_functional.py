"""Observers of a part of the state: their equations, their loops, and when there is none."""

import control
import numpy as np
import pytest
import scipy.linalg
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.errors import NoSolutionError
from compensator_theory.strategies import hurwitz_spectra, matrices, minimal_plants, spectra

s = sympy.Symbol("s")


@st.composite
def systems(draw, n=(2, 4), p=(1, 2), m=(1, 2), direct=True):
    n, p, m = (draw(st.integers(*bounds)) for bounds in (n, p, m))
    A, B, C = draw(matrices(n, n)), draw(matrices(n, m)), draw(matrices(p, n))
    return ct.Realisation(A, B, C, draw(matrices(p, m)) if direct else None, "s")


def placed(data, number, build):
    """Build with as many poles as it wants: it says how many can be moved."""
    for degree in range(number, -1, -1):
        try:
            return build(data.draw(spectra(degree)))
        except ct.InputError as error:
            assert f"has degree {degree}" in str(error)
    raise AssertionError


@given(plant=systems(), data=st.data())
def test_the_estimate_follows_whatever_the_input_is(plant, data):
    """x, u free: the estimate that is right stays right, which is an identity in x and u."""
    assume(sympy.Matrix(plant.C).rank() < plant.n)
    left = plant.n - sympy.Matrix(plant.C).rank()
    result = placed(data, left, lambda poles: ct.reduced_order_observer(plant, poles))
    x = sympy.Matrix(sympy.symbols(f"x:{plant.n}"))
    u = sympy.Matrix(sympy.symbols(f"u:{plant.B.cols}"))
    of_output = plant.C * x  # y - D u
    zeta = result.L * x - result.E * of_output
    moves = result.N * zeta + result.J * of_output + result.H * u
    expected = (result.L - result.E * plant.C) * (plant.A * x + plant.B * u)
    assert (moves - expected).expand().is_zero_matrix
    assert result.order == left and result.error_polynomial.degree() == left


@given(plant=systems(p=(1, 1), m=(1, 1), n=(2, 4), direct=False), data=st.data())
def test_what_cannot_be_moved_is_unobservable(plant, data):
    """Of an observer of reduced order as of one of full order."""
    assume(not plant.C.is_zero_matrix)
    result = placed(data, plant.n - 1, lambda poles: ct.reduced_order_observer(plant, poles))
    assert result.fixed == plant.unobservable_modes


@given(minimal_plants(4), st.data())
def test_a_compensator_of_order_n_less_one_separates(plant, data):
    A, B, n = plant.A, plant.B, plant.n
    assume(n > 1)
    regulator, observer = data.draw(hurwitz_spectra(n)), data.draw(hurwitz_spectra(n - 1))
    K = ct.state_feedback_family(A, B, regulator).gain()
    compensator = ct.reduced_order_observer(plant, observer).compensator(K)
    assert compensator.n == n - 1 and compensator.certificate.holds
    loop = sympy.Matrix(plant.feedback_with(compensator, feedback=1).A)
    poly = ct.polynomial_from_roots((*regulator, *observer), "s")
    assert sympy.Poly(loop.charpoly(s).as_expr(), s, domain="QQ") == poly


@given(systems(m=(1, 1), p=(1, 1), n=(2, 3)), st.data())
def test_a_direct_term_is_taken_off_the_output(plant, data):
    assume(plant.is_minimal)
    n = plant.n
    K = ct.state_feedback_family(plant.A, plant.B, data.draw(spectra(n))).gain()
    observer = ct.reduced_order_observer(plant, data.draw(spectra(n - 1)))
    try:
        compensator = observer.compensator(K)
    except NoSolutionError as error:
        assert "not well posed" in str(error)
        return
    assert compensator.certificate.holds


def test_against_gopinath_and_python_control():
    """The double integrator of Luenberger's paper by Gopinath's construction, written out."""
    A, B, C = [[0, 1], [0, 0]], [[0], [1]], [[1, 0]]
    observer = ct.reduced_order_observer((A, B, C), [-3], variable="s")
    # w = x_2 - l y: w' = -l w - l^2 y + u
    assert (observer.N[0], observer.J[0], observer.H[0], observer.E[0]) == (-3, -9, 1, 3)
    K = -control.acker(np.array(A), np.array(B), [-1, -2])
    F = observer.compensator([K.round().astype(int).ravel().tolist()]).transfer_function()
    loop = control.feedback(control.tf([1], [1, 0, 0]), -F.to_control())
    assert np.allclose(sorted(loop.poles().real), [-3, -2, -1], atol=1e-6)


@given(st.data())
def test_unknown_inputs_leave_the_invariant_zeros(data):
    """Of the whole state: what cannot be moved are the zeros of (A, G, C)."""
    n = data.draw(st.integers(2, 4))
    A, G, C = data.draw(matrices(n, n)), data.draw(matrices(n, 1)), data.draw(matrices(2, n))
    B = sympy.zeros(n, 1)
    build = lambda poles: ct.functional_observer(  # noqa: E731
        (A, B, C), sympy.eye(n), poles, variable="s", unknown_inputs=G
    )
    observed, felt = sympy.Matrix(C * G).rank(), sympy.Matrix(G).rank()
    if observed < felt:
        with pytest.raises(NoSolutionError, match="rank C G = 0"):
            build([-1] * n)
        return
    result = placed(data, n, build)
    assert sympy.zeros(n, 1) == (result.L - result.E * C) * G
    if felt:
        assert result.fixed == ct.invariant_zeros((A, G, C), "s").polynomial


def test_an_unknown_input_is_not_felt_in_a_simulation():
    A = [[0, 1, 0], [0, 0, 1], [-6, -11, -6]]
    B, C, G = [[0], [0], [1]], [[1, 0, 0], [0, 1, 0]], [[0], [1], [1]]
    observer = ct.functional_observer(
        (A, B, C), np.eye(3, dtype=int).tolist(), [-5, -7], variable="s", unknown_inputs=G
    )
    N, J, H, E = (np.array(m, float) for m in (observer.N, observer.J, observer.H, observer.E))
    a, b, c, g = (np.array(m, float) for m in (A, B, C, G))
    h, rng = 0.05, np.random.default_rng(1)
    joint = np.block([[a, np.zeros((3, 3))], [J @ c, N]])
    stored = np.block([[b, g], [H, np.zeros((3, 1))]])
    step = scipy.linalg.expm(np.block([[joint, stored], [np.zeros((2, 8))]]) * h)
    state = np.array([1.0, -1, 2, 0, 0, 0])
    for _ in range(400):
        state = step[:6, :6] @ state + step[:6, 6:] @ rng.normal(size=2)
    x, zeta = state[:3], state[3:]
    # fixed is a zero of (A, G, C): here it is stable, and 20 time constants have passed
    assert all(
        root.real < -0.9 for root in np.roots([float(k) for k in observer.fixed.all_coeffs()])
    )
    assert np.abs(zeta + E @ (c @ x) - x).max() < 1e-6 * max(1.0, np.abs(x).max())


def test_a_functional_of_order_one_of_a_plant_of_order_four():
    """K x of a chain, where one state follows from y: Luenberger's one observer for one gain."""
    A = [[-1, 1, 0, 0], [0, -2, 1, 0], [0, 0, -3, 1], [0, 0, 0, -4]]
    B, C = [[0], [0], [0], [1]], [[1, 0, 0, 0], [0, 1, 0, 0]]
    L = [[1, 1, 1, 0]]
    with pytest.raises(NoSolutionError, match="no observer of order 1"):
        ct.functional_observer((A, B, C), L, [-5], variable="s")
    observer = ct.functional_observer(
        (A, B, C), [[0, 0, 1, 0], [0, 0, 0, 1]], [-5, -6], variable="s"
    )
    assert observer.error_polynomial == ct.polynomial_from_roots([-5, -6], "s")
    whole = observer.realisation
    assert ct.transfer_matrix(whole).shape == (2, 3) and whole.n == 2
    with pytest.raises(ct.InputError, match="no function of L x and y"):
        ct.functional_observer((A, B, C), [[1, 0, 0, 0]], [-5], variable="s").compensator(
            [[0, 0, 1, 0]]
        )


def test_it_is_that_of_full_order_where_nothing_is_known():
    A, B, C = [[-1, 4], [0, -3]], [[0], [1]], [[1, 0]]
    observer = ct.functional_observer((A, B, C), [[1, 0], [0, 1]], [-2, -6], variable="s")
    assert observer.error_polynomial == ct.polynomial_from_roots([-2, -6], "s")
    F = ct.observer_gain_family(A, C, [-2, -6]).gain()
    classical = sympy.Matrix(A) - F * sympy.Matrix(C)
    assert sympy.Matrix(observer.N).charpoly(s) == classical.charpoly(s)


def test_bad_input():
    plant = ([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])
    for arguments, options, words in (
        (([[1, 0, 0]], [-1]), {"variable": "s"}, "L is 1 x 3; for 2 states it needs 2 columns"),
        (([[1, 0], [2, 0]], [-1]), {"variable": "s"}, "rank 1; leave out the rows that follow"),
        (([["a", 1]], [-1]), {"variable": "s"}, "give values to a"),
        (([[0, 1]], [-1, -2]), {"variable": "s"}, "but 1 poles are to be placed"),
        (([[0, 1]], [-1]), {}, "depends on the time domain"),
        (
            ([[0, 1]], [-1]),
            {"variable": "s", "unknown_inputs": [[1]]},
            "for 2 states it needs 2 rows",
        ),
    ):
        with pytest.raises(ct.InputError, match=words):
            ct.functional_observer(plant, *arguments, **options)
    with pytest.raises(ct.InputError, match="no observer is needed"):
        ct.reduced_order_observer(
            ([[0, 1], [0, 0]], [[0], [1]], [[1, 0], [0, 1]]), [], variable="s"
        )
    with pytest.raises(ct.InputError, match="K is 1 x 3; it must be 1 x 2"):
        ct.reduced_order_observer(plant, [-1], variable="s").compensator([[1, 2, 3]])
