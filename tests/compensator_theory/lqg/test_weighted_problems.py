"""Weights and covariances: factors that multiply to them, python-control's gains, refusals."""

import control
import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.strategies import matrices, semidefinite_matrices

INTEGRATORS = [[0, 1], [0, 0]], [[0], [1]], [[1, 0]]
Q, W = [[1, 0], [0, 0]], [[0, 0], [0, 1]]


def as_float(matrix):
    return np.array(sympy.Matrix(matrix).tolist(), dtype=float)


@given(st.data(), st.sampled_from("szq"))
def test_the_factors_multiply_to_the_weights_of_every_rank(data, variable):
    n, inputs, outputs = (data.draw(st.integers(1, 3)) for _ in range(3))
    A, B, C = (data.draw(matrices(*shape)) for shape in ((n, n), (n, inputs), (outputs, n)))
    cost = data.draw(semidefinite_matrices(n + inputs))
    noise = data.draw(semidefinite_matrices(n + outputs))
    problem = ct.lqg_problem(
        (A, B, C), cost[:n, :n], cost[n:, n:], noise[:n, :n], noise[n:, n:], N=cost[:n, n:],
        S=noise[:n, n:], variable=variable,
    )  # fmt: skip
    E, D = problem.E_1.row_join(problem.E_2), problem.D_1.col_join(problem.D_2)
    assert (cost, noise) == (E.T * E, D * D.T)
    assert (problem.A, problem.B, problem.C, problem.variable.name) == (A, B, C, variable)


@pytest.mark.parametrize("discrete", [False, True])
def test_the_gains_are_those_of_python_control(discrete):
    rng = np.random.default_rng(5)
    A, B, C = ([[0, 1, 0], [0, 0, 1], [1, "1/2", "-1/3"]], [[0], [1], [1]], [[1, 0, 2]])
    a, b, c = map(as_float, (A, B, C))
    for _ in range(5):
        x, y = (sympy.Matrix(rng.integers(-3, 4, (3, 3)).tolist()) for _ in range(2))
        Q, W = x.T * x + sympy.eye(3), y.T * y + sympy.eye(3)
        controller = ct.lqg_controller(
            ct.lqg_problem((A, B, C), Q, [["3/7"]], W, [["2/5"]], variable="z" if discrete else "s")
        )
        lqr, lqe = (control.dlqr, control.dlqe) if discrete else (control.lqr, control.lqe)
        K = lqr(a, b, as_float(Q), np.array([[3 / 7]]))[0]
        gain = [[float(k.centre) for k in row] for row in controller.regulator.K_enclosure]
        np.testing.assert_allclose(gain, -K, rtol=1e-8)
        P = lqe(a, np.eye(3), c, as_float(W), np.array([[2 / 5]]))[1]
        covariance = [[float(p.centre) for p in row] for row in controller.estimator.P_enclosure]
        np.testing.assert_allclose(covariance, P, rtol=1e-8)


def test_systems_of_other_libraries_and_feedthrough_go_in():
    system = control.ss([[0.5]], [[1]], [[1]], [[2]], 0.1)
    problem = ct.lqg_problem(system, [[3]], [[0]], [[2]], [[5]])
    assert (problem.variable.name, problem.sample_time, problem.D_0) == (
        "z", sympy.Rational(1, 10), sympy.Matrix([[2]])
    )  # fmt: skip
    of_text = ct.lqg_problem(ct.realisation("1/s**2"), Q, [[1]], W, [[1]])
    assert of_text == ct.lqg_problem(
        ct.Realisation([[0, 1], [0, 0]], [[0], [1]], [[1, 0]]), Q, [[1]], W, [[1]]
    )


@pytest.mark.parametrize(
    ("plant", "weights", "words"),
    [
        ("1/s**2", (Q, [[1]], W, [[1]]), "which they are"),
        (ct.transfer_function("1/s"), ([[1]],) * 4, "which they are"),
        (control.tf([1], [1, 0]), ([[1]],) * 4, "which they are"),
        (INTEGRATORS, ([[1]], [[1]], W, [[1]]), "Q is 1 x 1 but must be 2 x 2"),
        (INTEGRATORS, (Q, [[1]], [[1, 2], [0, 1]], [[1]]), "W = .* is not symmetric"),
        (INTEGRATORS, (Q, [[1]], W, [[-1]]), "W, V and S are not positive semidefinite"),
        (INTEGRATORS, ([[0, 1], [1, 0]], [[1]], W, [[1]]), "Q, R and N are not positive"),
        (INTEGRATORS, (Q, [["r"]], W, [[1]]), "R has entries that are not rational"),
        (INTEGRATORS, (Q, [[1]], W, [[float("nan")]]), "nan"),
    ],
)
def test_refusals_name_the_matrix(plant, weights, words):
    variable = None if not isinstance(plant, tuple) else "s"
    with pytest.raises(ct.InputError, match=words):
        ct.lqg_problem(plant, *weights, variable=variable)


def test_the_time_domain_is_never_guessed():
    with pytest.raises(ct.InputError, match="time domain"):
        ct.lqg_problem(INTEGRATORS, Q, [[1]], W, [[1]])
