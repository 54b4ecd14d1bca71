"""Closed-loop maps against state space, the printed formulas, and python-control."""

import control
import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.errors import ImproperError
from compensator_theory.loops import closed_loop_transfer_matrix, closed_loop_zero_polynomial
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.strategies import (
    matrices,
    polynomials,
    standard_problems,
    strictly_proper_plants,
)

q = sympy.Symbol("q")


@st.composite
def loops(draw, max_order=2, has_direct_term=False, k_c=1):
    problem = draw(standard_problems(max_order, has_direct_term=has_direct_term))
    n_c = draw(st.integers(max(k_c, 1), 2))
    P = [draw(matrices(problem.l_u, problem.l_u)) for _ in range(n_c)]
    Q = [draw(matrices(problem.l_u, problem.l_y)) for _ in range(n_c + 1 - k_c)]
    return problem, P, Q, n_c


def observer_form(P, Q, n_c, k_c):
    """State space (A_c, B_c, C_c, Q_0) of the controller, by hand."""
    l_u, l_y = Q[0].shape
    Q = [sympy.zeros(l_u, l_y)] * k_c + list(Q)
    A_c, B_c = sympy.zeros(l_u * n_c, l_u * n_c), sympy.zeros(l_u * n_c, l_y)
    for i in range(n_c):
        rows = slice(l_u * i, l_u * (i + 1))
        A_c[rows, :l_u] = P[i]
        if i + 1 < n_c:
            A_c[rows, l_u * (i + 1) : l_u * (i + 2)] = sympy.eye(l_u)
        B_c[rows, :] = Q[i + 1] + P[i] * Q[0]
    C_c = sympy.eye(l_u).row_join(sympy.zeros(l_u, l_u * (n_c - 1)))
    return A_c, B_c, C_c, Q[0]


@given(st.sampled_from([0, 1]), st.data())
def test_poles_are_those_of_the_state_space_loop(k_c, data):
    problem, P, Q, n_c = data.draw(loops(has_direct_term=k_c == 1, k_c=k_c))
    A_c, B_c, C_c, Q_0 = observer_form(P, Q, n_c, k_c)
    closed = sympy.BlockMatrix(
        [
            [problem.A + problem.B * Q_0 * problem.C, problem.B * C_c],
            [B_c * problem.C, A_c + B_c * problem.D_0 * C_c],
        ]
    ).as_explicit()  # D_0 or Q_0 is zero
    N_c, D_c = ct.compensator_polynomials(P, Q, n_c, k_c)
    assert ct.closed_loop_polynomial(problem, N_c, D_c) == characteristic_polynomial(closed, q)


@pytest.mark.costly
@given(loops(has_direct_term=True))
def test_closed_loop_is_2_9_at_rational_points(case):
    problem, P, Q, n_c = case
    N_c, D_c = ct.compensator_polynomials(P, Q, n_c, 1)
    closed = closed_loop_transfer_matrix(problem, N_c, D_c)
    assert closed.denominator.degree() == problem.n + problem.l_u * n_c
    point = sympy.Rational(177, 13)
    G_zw, G_zu, G_yw, G_yu = (
        problem.transfer_matrix(c).as_matrix().subs(q, point) for c in ("zw", "zu", "yw", "yu")
    )
    G_c = D_c.subs(q, point).inv() * N_c.subs(q, point)
    expected = G_zw + G_zu * G_c * (sympy.eye(problem.l_y) - G_yu * G_c).inv() * G_yw
    assert closed.as_matrix().subs(q, point) == expected


@given(standard_problems(max_signals=1), polynomials("q", 0, 2), polynomials("q", 2, 2))
def test_scalar_zero_polynomial_of_2_11(problem, N_c, D_c):
    D_c = D_c.monic()
    D = problem.denominator
    N = {c: problem.numerator(c) for c in ("zw", "zu", "yw", "yu")}
    loop = D * D_c - N["yu"] * N_c
    assert ct.closed_loop_polynomial(problem, N_c, D_c) == loop
    printed = N["zu"] * N["yw"] * N_c + N["zw"] * loop
    assert closed_loop_zero_polynomial(problem, N_c, D_c) * D == printed


@given(strictly_proper_plants("q", 3), polynomials("q", 0, 1), polynomials("q", 2, 2))
def test_2_13_to_2_15_and_open_loop(G, N_c, D_c):
    D_c = D_c.monic()
    problem = ct.standard_problem(G)
    for channel in ("zw", "zu", "yw", "yu"):
        assert problem.transfer_function(channel) == G
    assert closed_loop_zero_polynomial(problem, N_c, D_c) == G.numerator * D_c
    ours = closed_loop_transfer_matrix(problem, N_c, D_c).scalar()
    theirs = control.feedback(G.to_control(), ct.transfer_function((N_c, D_c)).to_control(), sign=1)
    for point in (3.7 + 0.2j, -2.9 + 4.4j):
        assert theirs(point) == pytest.approx(ours.to_control()(point), rel=1e-6)


def test_open_loop_with_symbols_is_2_6():
    a, b, c, d = sympy.symbols("a:d")
    P = ct.StandardProblem([[a, 1], [0, b]], [[0], [c]], [[1, d]], [[1], [0]], [["1/2"]], None,
                        [[d, 0]], None, [[3]])  # fmt: skip
    resolvent = (q * sympy.eye(2) - P.A).inv()
    for channel, left, right, direct in (
        ("yu", P.C, P.B, P.D_0), ("zw", P.E_1, P.D_1, P.E_0), ("zu", P.E_1, P.B, P.E_2),
    ):  # fmt: skip
        expected = left * resolvent * right + direct
        difference = P.transfer_matrix(channel).as_matrix() - expected
        assert difference.applyfunc(sympy.cancel).is_zero_matrix
    assert P.G_yw.shape == (1, 1)
    assert ct.closed_loop_polynomial(P, "k", "q").degree() == 3


def test_servo_problem_is_2_25_to_2_27():
    servo = ct.servo_problem("(q - 0.5)/(q**2 - 1)")
    G = ct.servo_problem("(q - 0.5)/(q**2 - 1)").numerator("zu")
    assert [servo.numerator("zw", 0, j) for j in range(3)] == [
        servo.denominator, G, -servo.denominator,
    ]  # fmt: skip
    assert servo.G_zw == servo.G_yw and servo.G_zu == servo.G_yu
    true = ct.servo_problem("(q - 0.5)/(q**2 - 1)", performance="true")
    assert true.numerator("zw", 0, 2).is_zero and true.numerator("yw", 0, 2) == -true.denominator
    two = ct.servo_problem(A=np.eye(2), B=np.eye(2), C=[[1, 0.1], [0, 1]], D_1=[[1], [0]],
                        D_0=[[0, 1], [0, 0]])  # fmt: skip
    assert sympy.Matrix([[0, 0, 1, 0, 0], [0, 0, 0, 0, 0]]) == two.D_1
    assert sympy.Matrix([[0, -1], [0, 0]]) == two.D_0 and two.E_0.shape == (2, 5)
    # The same loop by signals: e_n = r - G_u u - G_d d - v, u = G_c e_n.
    sensitivity = closed_loop_transfer_matrix(servo, "q - 0.1", "q**2")
    assert sensitivity[0, 0].numerator == -sensitivity[0, 2].numerator


def test_to_control_is_the_plant():
    problem = ct.StandardProblem([[0.5]], [[2]], [[1]], [[1]], None, [[3]], [[4]], [[5]], None)
    system = problem.to_control(dt=0.1)
    assert system.dt == 0.1
    assert np.array_equal(system.D, [[0, 5], [3, 0]]) and np.array_equal(system.B, [[1, 2]])
    symbolic = ct.StandardProblem([["a"]], [[2]], [[1]], [[1]], None, None, [[4]], None, None)
    with pytest.raises(ct.InputError, match="a"):
        symbolic.to_control()
    assert "E_1" in str(problem) and "E_1" in problem._repr_latex_()


def test_refusals():
    ok = ([[1]], [[1]], [[1]], [[1]], None, None, [[1]], None, None)
    for position, bad in ((1, [[1], [2]]), (2, [[1, 2]]), (4, [[1, 2]]), (0, [[1, 2]]), (0, 3),
                          (0, [[1], [2, 3]]), (0, [1, 2]), (0, [["q"]]), (0, None), (8, "x"),
                          (0, [[float("nan")]])):  # fmt: skip
        with pytest.raises(ct.InputError):
            ct.StandardProblem(*(bad if i == position else x for i, x in enumerate(ok)))
    problem = ct.StandardProblem(*ok)
    with pytest.raises(ct.InputError):
        problem.transfer_matrix("uy")
    with pytest.raises(ct.InputError):
        problem.transfer_function("zw", 1, 0)
    with pytest.raises(ct.InputError, match="monic"):
        ct.closed_loop_polynomial(problem, 1, "2*q")
    with pytest.raises(ct.InputError):
        ct.closed_loop_polynomial(problem, [[1, 2]], "q")
    with pytest.raises(ct.InputError):
        ct.closed_loop_polynomial(problem, 1, 0)
    with pytest.raises(ct.InputError):
        closed_loop_zero_polynomial(problem, 1, "q", w_channel=1)
    with pytest.raises(ImproperError, match="higher degree"):
        ct.closed_loop_polynomial(problem, "q**2", "q")
    exactly_proper = ct.standard_problem("(q + 1)/q")
    with pytest.raises(ImproperError, match="well posed"):
        ct.closed_loop_polynomial(exactly_proper, "q - 1", "q")
    for arguments in ({}, {"A": [[1]]}, {"G": "1/q", "A": [[1]]}, {"G": "1/q", "performance": "y"},
                      {"A": [[1]], "B": [[1]], "C": [[1]], "D_1": [[1], [1]]}):  # fmt: skip
        with pytest.raises(ct.InputError):
            ct.servo_problem(**arguments)
    with pytest.raises(ImproperError):
        ct.servo_problem("q/(q - 1)")
    with pytest.raises(ImproperError):
        ct.standard_problem("q**2/(q - 1)")
