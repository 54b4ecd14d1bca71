"""LQG poles in continuous time for several signals, against SciPy's Riccati equation."""

import random

import flint
import numpy as np
import pytest
import scipy.linalg
import sympy
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.strategies import matrices
from tests.support.structure_cases import fewer
from tests.support.work import at_most

s = sympy.Symbol("s")


def as_numpy(matrix):
    return np.array(matrix.tolist(), float)


@st.composite
def problems(draw, signals=2):
    n, m, p = draw(st.integers(1, 3)), draw(st.integers(1, signals)), draw(st.integers(1, signals))
    A, B, C = draw(matrices(n, n)), draw(matrices(n, m)), draw(matrices(p, n))
    E_1 = sympy.Matrix(draw(matrices(n, n))).col_join(draw(matrices(m, n)))
    D_1 = sympy.Matrix(draw(matrices(n, n))).row_join(draw(matrices(n, p)))
    return ct.StandardProblem(
        A=A, B=B, C=C, D_1=D_1, D_0=None, D_2=sympy.zeros(p, n).row_join(sympy.eye(p)),
        E_1=E_1, E_2=sympy.zeros(n, m).col_join(sympy.eye(m)), E_0=None, variable="s",
    )  # fmt: skip


def riccati_poles(A, B, E_1, E_2):
    """Closed-loop poles by SciPy's care, with the cross term; None where it fails."""
    a, b, e, f = map(as_numpy, (A, B, E_1, E_2))
    try:
        P = scipy.linalg.solve_continuous_are(a, b, e.T @ e, f.T @ f, s=e.T @ f)
    except (np.linalg.LinAlgError, ValueError):
        return None
    K = np.linalg.solve(f.T @ f, b.T @ P + f.T @ e)
    return np.poly(a - b @ K)


@fewer(3)
@given(problems())
def test_the_poles_are_those_of_the_riccati_equation(plant):
    try:
        poles = ct.lqg_poles(plant)
    except ct.CompensatorError:
        assume(False)
    sides = (
        (poles.regulator, (plant.A, plant.B, plant.E_1, plant.E_2)),
        (poles.estimator, (plant.A.T, plant.C.T, plant.D_1.T, plant.D_2.T)),
    )
    for factor, data in sides:
        mine = [float(c) for c in factor.enclosure.coefficients]
        roots = np.roots(mine)
        assert roots.real.max() < 0
        expected = riccati_poles(*data)
        assume(expected is not None and min(-roots.real) > 1e-3)
        assert np.allclose(mine, expected, rtol=1e-5, atol=1e-6)


@fewer(3)
@given(problems())
def test_the_spectrum_is_that_of_the_transfer_matrix(plant):
    """p(s) = det(G'(-s) G(s)) D(s) D(-s), at a point."""
    p = ct.regulator_spectrum(plant.A, plant.B, E_1=plant.E_1, E_2=plant.E_2, time="continuous")
    point = sympy.Rational(11, 7)
    eye = sympy.eye(plant.n)

    def G(x):
        return plant.E_1 * (x * eye - plant.A).inv() * plant.B + plant.E_2

    D = [(x * eye - plant.A).det() for x in (point, -point)]
    assume(all(D))
    assert p.eval(point) == (G(-point).T * G(point)).det() * D[0] * D[1]


@fewer(3)
@given(problems(signals=1))
def test_scalar_plants_as_by_the_gains(plant):
    try:
        gains = ct.lqg_controller(plant)
    except ct.CompensatorError:
        assume(False)
    poles = ct.lqg_poles(plant)
    assert poles.polynomial == gains.polynomial
    assert poles.enclosure.degree == 2 * plant.n


@given(st.integers(0, 10**6))
@settings(max_examples=2)
def test_the_spectrum_of_many_states_is_that_of_the_hamiltonian_matrix(seed):
    """With R = I it is (-1)^n det(sI - H); counted are the calls that the pencil takes."""
    n, drawn = 32, random.Random(seed)
    A, B = (sympy.Matrix(n, width, lambda i, j: drawn.randint(-3, 3)) for width in (n, 2))
    with at_most(200_000):
        spectrum = ct.regulator_spectrum(A, B, sympy.eye(n), sympy.eye(2), time="continuous")
    H = sympy.Matrix.vstack(
        sympy.Matrix.hstack(A, -B * B.T), sympy.Matrix.hstack(-sympy.eye(n), -A.T)
    )
    expected = flint.fmpz_mat(2 * n, 2 * n, [int(entry) for entry in H]).charpoly()
    assert spectrum.all_coeffs() == [(-1) ** n * int(c) for c in reversed(expected.coeffs())]


def test_what_is_refused():
    two = {"A": [[1]], "B": [[1, 0]], "C": [[1]], "D_1": [[1, 0]], "D_0": None, "D_2": [[0, 1]],
           "E_1": [[1], [0]], "E_0": None, "variable": "s"}  # fmt: skip
    with pytest.raises(ct.CompensatorError, match="zero weight"):
        ct.lqg_poles(ct.StandardProblem(E_2=[[0, 0], [1, 0]], **two))
    with pytest.raises(ct.CompensatorError, match="uncontrollable"):
        ct.lqg_poles(ct.StandardProblem(**{**two, "B": [[0]], "E_2": [[0], [1]]}))
    with pytest.raises(ct.CompensatorError, match="axis"):
        ct.lqg_poles(
            ct.StandardProblem(
                **{**two, "A": [[0]], "B": [[1]], "E_1": [[0], [0]], "E_2": [[0], [1]]}
            )
        )
    for bad in ("1/s", ct.standard_problem("1/(x - 1)")):
        with pytest.raises(ct.CompensatorError):
            ct.lqg_poles(bad)
    with pytest.raises(ct.CompensatorError, match="discrete"):
        ct.regulator_spectrum([[1]], [[1]], [[1]], [[1]], variable="z", time="continuous")


@pytest.mark.parametrize("E_2", [[[0], [1]], [[0], [0]]])
def test_a_control_without_weight_has_no_optimal_gain_in_continuous_time(E_2):
    """For the plant 1/(s + 1) the spectrum is 2 - s^2 with the weight 1, and a number without."""
    plant = ct.StandardProblem(
        A=[[-1]],
        B=[[1]],
        C=[[1]],
        D_1=[[1, 0]],
        D_0=None,
        D_2=[[0, 1]],
        E_1=[[1], [0]],
        E_2=E_2,
        E_0=None,
        variable="s",
    )
    if E_2[1][0]:
        assert ct.lqg_poles(plant).polynomial is None  # the poles -sqrt(2) are irrational
    else:
        with pytest.raises(ct.errors.NoSolutionError, match="zero weight"):
            ct.lqg_poles(plant)
