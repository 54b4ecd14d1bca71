"""Riccati, Lyapunov and Sylvester equations, exact and in float64."""

import mpmath
import numpy as np
import pytest
import scipy.linalg
import sympy as sp

import rcac_numeric as rcac
from compensator_theory import (
    CompensatorError,
    riccati_formula,
    solve_lyapunov,
    solve_riccati,
    solve_stein,
    solve_sylvester,
)
from compensator_theory.errors import NoSolutionError, NotControllableError, UnitCircleError
from tests.support.dare_cases import DAREX
from tests.support.world import case

R = sp.Rational
GOLDEN = (1 + np.sqrt(5)) / 2
b = np.sqrt(0.9)

HAND = [
    # P by hand: nilpotent A, so that the cost ends after two steps; scalar equations.
    case("drake-8034", [[0, 1], [0, 0]], [[0], [1]], np.eye(2), 1, np.diag([1.0, 2.0])),
    case("drake-8034b", np.eye(2), np.eye(2), np.eye(2), np.eye(2), GOLDEN * np.eye(2)),
    case(
        "QuantEcon-tjm3",
        [[2.25, 0], [0, 0]],
        np.eye(2),
        [[1, 0], [0, 0]],
        np.eye(2),
        np.diag([(5.0625 + np.sqrt(5.0625**2 + 4)) / 2, 0]),
    ),
    case("SciPy-14518", [[0, 1e6], [0, 0]], [[0], [1]], np.eye(2), 1, np.diag([1, 1 + 1e12])),
    case("SciPy-14518b", [[0, 1e10], [0, 0]], [[0], [1]], np.eye(2), 1, np.diag([1, 1 + 1e20])),
    case("scalar-unstable", 2, 1, 0, 1, 3),
    case("scalar-stable", 0.5, 1, 0, 1, 0),
]


@pytest.mark.parametrize(("A", "B", "Q", "W", "right"), HAND)
def test_dare_by_hand(A, B, Q, W, right):
    solution = rcac.solve_riccati(A, B, Q, W, time="discrete")
    assert np.atleast_2d(solution.P) == pytest.approx(np.atleast_2d(right), rel=1e-13, abs=1e-14)


def kleinman(A, B, Q, W, S, K):
    """P in 60 digits from a gain that is stabilising; fails where it is not."""
    with mpmath.workdps(60):
        A, B, Q, W, S, K = (mpmath.matrix(np.atleast_2d(M).tolist()) for M in (A, B, Q, W, S, K))
        for _ in range(60):
            F, P = A + B * K, Q + S * K + (S * K).T + K.T * W * K
            for _ in range(60):
                added = F.T * P * F
                P, F = P + added, F * F
                if mpmath.mnorm(added, 1) <= mpmath.mpf(10) ** -55 * (1 + mpmath.mnorm(P, 1)):
                    break
            else:
                raise ValueError("not stable")
            new = -mpmath.inverse(W + B.T * P * B) * (S.T + B.T * P * A)
            change, K = mpmath.mnorm(new - K, 1), new
            if change <= mpmath.mpf(10) ** -40 * (1 + mpmath.mnorm(K, 1)):
                return np.array(P.tolist(), float)
    raise ValueError("sixty digits do not settle it")


# The published collections are in support/dare_cases.py, and wholly in tests/rcac_numeric.
SMALL = [
    case(one.name, one.A, one.B, one.R_1, one.R_2, one.R_12)
    for one in DAREX
    if np.atleast_2d(one.A).shape[0] <= 3
][:4]
DIGITS = [
    case(
        "QuantEcon-356",
        np.array([[1, 0], [0.225, 0]]) * b,
        np.array([[0], [1.11111]]) * b,
        [[2.89634, -4.0404], [-4.0404, 8.16243]],
        [[8.16243]],
        [[4.0404], [-8.16243]],
    ),
    case(
        "JuliaControl-297",
        [[0.3, -1.1], [0.7, 0.4]],
        [[1], [0.5]],
        [[1e4, -100], [-100, 1]],
        [[1]],
        None,
    ),
    case(
        "JuliaControl-297b",
        [[1.3, 0.2], [-0.5, 0.9]],
        [[0.2], [1]],
        [[1e4, -100], [-100, 1]],
        [[1]],
        None,
    ),
    case(
        "SciPy-2251",
        [[0.55, 0.97, 0.2], [0.71, 0.03, 0.4], [0.6, 0.44, 0.5]],
        [[0.95, 0.1], [0.43, 0.7], [0.39, 0.2]],
        np.eye(3),
        np.eye(2),
        None,
    ),
    *SMALL,
]


@pytest.mark.parametrize(("A", "B", "Q", "W", "S"), DIGITS)
def test_dare_in_sixty_digits(A, B, Q, W, S):
    """Kleinman's iteration in mpmath, which ends at the stabilising solution alone."""
    solution = rcac.solve_riccati(A, B, Q, W, S, time="discrete")
    cross = np.zeros((np.atleast_2d(A).shape[0], np.atleast_2d(W).shape[0])) if S is None else S
    right = kleinman(A, B, Q, W, cross, solution.K)
    assert np.abs(solution.P - right).max() <= 1e-8 * np.abs(right).max()
    assert np.abs(solution.poles).max() < 1


def test_a_zero_on_the_circle_is_named():
    """QuantEcon #360: singular weight and a zero at 1; no solution is stabilising."""
    with pytest.raises(UnitCircleError, match="at 1"):
        rcac.solve_riccati(
            [[0, -1], [0, 2]], [[1, 0], [1, 1]], [[1, 0], [0, 0]], [[4, 2], [2, 1]], time="discrete"
        )


CARE = [
    case("double-integrator", [[0, 1], [0, 0]], [[0], [1]], [[np.sqrt(3), 1], [1, np.sqrt(3)]]),
    case(
        "cocp-3",
        [[0, 0, 1, 0], [0, -0.71707317, 0, 0], [0, 0, 0, 1], [0, 15.77560976, 0, 0]],
        [[0], [0], [0.97560976], [-1.46341463]],
        None,
    ),
    case(
        "slow-and-fast",
        np.diag([-1.0, -1e6]),
        [[0], [1]],
        np.diag([0.5, 1 / (1e6 + np.sqrt(1e12 + 1))]),
    ),
    case(
        "slow-and-very-fast",
        np.diag([-1.0, -1e15]),
        [[0], [1]],
        np.diag([0.5, 5e-16]),
    ),
    case(
        "very-slow",
        np.diag([-1e-9, -1e6]),
        [[0], [1]],
        np.diag([5e8, 5e-7]),
    ),
    case(
        "no-input",
        np.diag([-1.0, -1e-13]),
        [[0], [0]],
        np.diag([0.5, 5e12]),
    ),
]


@pytest.mark.parametrize(("A", "B", "right"), CARE)
def test_care(A, B, right):
    """By hand where A is diagonal; else SciPy."""
    n, m = np.shape(B)
    solution = rcac.solve_riccati(A, B, np.eye(n), np.eye(m), time="continuous")
    want = (
        scipy.linalg.solve_continuous_are(
            np.array(A, float), np.array(B, float), np.eye(n), np.eye(m)
        )
        if right is None
        else right
    )
    assert pytest.approx(np.array(want), rel=1e-8, abs=1e-8 * np.abs(want).max()) == solution.P


def test_the_mode_that_is_named_is_one_of_the_plant():
    """diag(1, -1) with b = (0, 1)': the mode 1 cannot be moved; no other number is said."""
    with pytest.raises(NotControllableError, match=r"mode 1(?:\.0+)?(?![.\d])") as refused:
        rcac.solve_riccati(np.diag([1.0, -1.0]), [[0], [1]], np.eye(2), [[1]], time="continuous")
    assert "unit circle" not in str(refused.value)


EXACT = [
    case(
        "JL-440",
        [[1]],
        [[1, 1]],
        [[1]],
        [[1, 0], [0, -4]],
        None,
        "discrete",
        R(1, 2) + sp.sqrt(R(4, 3) + R(1, 4)),
    ),
    case(
        "JL-297-exact",
        [[1, 1], [0, 1]],
        [[0], [1]],
        [[1, 0], [0, 0]],
        [[1]],
        None,
        "discrete",
        None,
    ),
    case(
        "pc-252",
        [[0, 1], [0, 0]],
        [[0], [1]],
        [[1, 0], [0, 1]],
        [[1]],
        [[0], [R(1, 2)]],
        "continuous",
        None,
    ),
    case("pc-8", [[0, 1], [0, 0]], [[0], [1]], [[1, 0], [0, 1]], [[0]], None, "discrete", None),
    case(
        "Mathematica-CARE",
        [[0, 1], [0, 0]],
        [[0], [1]],
        [[1, 0], [0, 1]],
        [[1]],
        None,
        "continuous",
        sp.sqrt(3),
    ),
]


@pytest.mark.parametrize(("A", "B", "Q", "W", "N", "time", "right"), EXACT)
def test_exact_riccati(A, B, Q, W, N, time, right):
    """P[0, 0] by hand where it is known, else SciPy to 1e-12; R may be indefinite or 0."""
    solution = solve_riccati(A, B, Q, W, N, time=time)
    P = np.array(sp.Matrix(solution.P).evalf(30).tolist(), float)
    if right is not None:
        assert sp.simplify(sp.Matrix(solution.P)[0, 0] - right) == 0
    else:
        solver = {
            "discrete": scipy.linalg.solve_discrete_are,
            "continuous": scipy.linalg.solve_continuous_are,
        }[time]
        cross = None if N is None else np.array(N, float)
        want = solver(*(np.array(M, float) for M in (A, B, Q, W)), s=cross)
        assert pytest.approx(want, rel=1e-10, abs=1e-10) == P


def test_a_formula_for_the_double_integrator():
    """Mathematica's manual: with weights q1, q2, r; numbers put in agree with SciPy."""
    formula = riccati_formula(
        [[0, 1], [0, 0]], [[0], [1]], [["q1", 0], [0, "q2"]], [["r"]], time="continuous"
    )
    P = np.array(sp.Matrix(formula.P).subs({"q1": 2, "q2": 3, "r": 5}).evalf().tolist(), float)
    want = scipy.linalg.solve_continuous_are([[0, 1], [0, 0]], [[0], [1]], np.diag([2, 3]), [[5]])
    assert pytest.approx(want, rel=1e-12) == P


EQUATIONS = [
    case("SciPy-23066", lambda: solve_sylvester([[1]], [[-1]], [[0]]).is_unique, False),
    case(
        "pc-342",
        lambda: solve_sylvester([[1, 0], [0, 2]], [[3]], [[4], [5]]).X,
        sp.Matrix([-1, -1]),
    ),
    case("stein-scalar", lambda: solve_stein([["1/2"]], [[3]]).X[0], 4),
    case("lyapunov-scalar", lambda: solve_lyapunov([[-1]], [[3]]).X[0], R(3, 2)),
    case(
        "lyapunov-symbol",
        lambda: sp.simplify(solve_lyapunov([["-a"]], [[1]]).X[0] - 1 / (2 * sp.Symbol("a"))),
        0,
    ),
    case(
        "SciPy-12145",
        lambda: solve_stein([["1e-27", 0], [0, "0.5"]], [["1e4", 0], [0, "1e-27"]]).X[1, 1],
        R(4, 3) * R(1, 10**27),
    ),
]


@pytest.mark.parametrize(("ask", "right"), EQUATIONS)
def test_linear_matrix_equations(ask, right):
    """By hand."""
    assert ask() == right


def test_a_singular_sylvester_equation_says_why():
    """SciPy #23066: x - x + 1 = 0."""
    with pytest.raises(NoSolutionError, match="share an eigenvalue"):
        solve_sylvester([[1]], [[-1]], [[1]])


def test_the_same_with_sin_and_cos():
    """SymPy #24347: the same equation, 1 written as sin^2 + cos^2."""
    theta = sp.Symbol("theta")
    with pytest.raises(CompensatorError):
        solve_sylvester([[sp.sin(theta) ** 2 + sp.cos(theta) ** 2]], [[-1]], [[1]])


REFUSED = [
    case(
        "Mathematica.SE-221330",
        lambda: riccati_formula(
            [[0, 1], [0, 0]],
            [[1, 0], [0, "a"]],
            [[1, 0], [0, 1]],
            [[1, 0], [0, 1]],
            time="continuous",
        ),
    ),
    case(
        "SciPy-complex-0", lambda: rcac.solve_riccati([[1j]], [[1]], [[1]], [[1]], time="discrete")
    ),
    case(
        "unobservable-integrator",
        lambda: rcac.solve_riccati([[1.0]], [[1]], [[0]], [[1]], time="discrete"),
    ),
    case(
        "disturbance-integrator",
        lambda: rcac.solve_riccati([[0.9, 0.1], [0, 1]], [[1], [0]], np.eye(2), 1, time="discrete"),
    ),
]


@pytest.mark.parametrize("ask", REFUSED)
def test_equations_without_an_answer_are_refused(ask):
    with pytest.raises(CompensatorError):
        ask()
