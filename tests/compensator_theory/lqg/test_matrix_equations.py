"""Matrix equations against Kronecker's system, SciPy, impulse sums and simulated steady states."""

import re

import numpy as np
import pytest
import scipy.linalg
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import Matrix, Rational

from compensator_theory import (
    CompensatorError,
    InputError,
    budget,
    gramians,
    invariant_zeros,
    polynomial_from_roots,
    realisation,
    solve_lyapunov,
    solve_regulator_equations,
    solve_stein,
    solve_sylvester,
)
from compensator_theory._printing import text
from compensator_theory.errors import BudgetError, NoSolutionError
from compensator_theory.lqg import _sylvester_equations as sylvester_equations
from compensator_theory.strategies import matrices
from tests.support.structure_cases import fewer
from tests.support.structure_cases import realisations as systems

SMALL = st.integers(-2, 2)


def small_matrices(rows, columns):
    """Entries that make common eigenvalues frequent."""
    return st.lists(SMALL, min_size=rows * columns, max_size=rows * columns).map(
        lambda entries: Matrix(rows, columns, entries)
    )


@st.composite
def equations(draw, square=False):
    n = draw(st.integers(1, 3))
    m = n if square else draw(st.integers(1, 3))
    family = draw(st.sampled_from([small_matrices, matrices]))
    return draw(family(n, n)), draw(family(m, m)), draw(family(n, m))


def as_numpy(matrix):
    return np.array(matrix.tolist(), float)


def kronecker(left, right):
    """All solutions of left x = right by SymPy: None, or the number of free unknowns."""
    wide = left.row_join(right)
    return None if wide.rank() > left.rank() else left.cols - left.rank()


def held_against(solve, left, right, residual):
    """The verdict, the size of the family and the residual, for one equation."""
    free = kronecker(left, right)
    if free is None:
        with pytest.raises(NoSolutionError):
            solve()
        return None
    result = solve()
    assert result.certificate.holds and residual(result.X).is_zero_matrix
    assert len(result.homogeneous) == free
    if free:  # independent
        columns = (Matrix(Y.rows * Y.cols, 1, list(Y)) for Y in result.homogeneous)
        assert Matrix.hstack(*columns).rank() == free
    return result


@fewer(2)
@given(equations())
def test_sylvester_against_kronecker_and_scipy(case):
    A, B, C = case
    n, m = C.shape
    eye = sympy.eye
    left = sympy.kronecker_product(A, eye(m)) + sympy.kronecker_product(eye(n), B.T)
    result = held_against(
        lambda: solve_sylvester(A, B, -C), left, Matrix(n * m, 1, list(C)),
        lambda X: A * X + X * B - C,
    )  # fmt: skip
    gap = [
        abs(x + y) for x in np.linalg.eigvals(as_numpy(A)) for y in np.linalg.eigvals(as_numpy(B))
    ]
    if result is not None and result.is_unique and min(gap) > 1e-2:
        expected = scipy.linalg.solve_sylvester(*map(as_numpy, (A, B, C)))
        assert np.allclose(as_numpy(result.X), expected, rtol=1e-6, atol=1e-6)


@fewer(2)
@given(equations())
def test_stein_against_kronecker(case):
    A, B, Q = case
    n, m = Q.shape
    left = sympy.eye(n * m) - sympy.kronecker_product(A, B.T)
    held_against(
        lambda: solve_stein(A, Q, B), left, Matrix(n * m, 1, list(Q)), lambda X: A * X * B + Q - X
    )


@fewer(2)
@given(equations(square=True))
def test_lyapunov_against_kronecker_and_scipy(case):
    A, _, Q = case
    n = A.rows
    eye = sympy.eye(n)
    left = sympy.kronecker_product(A, eye) + sympy.kronecker_product(eye, A)
    result = held_against(
        lambda: solve_lyapunov(A, Q), left, Matrix(n * n, 1, list(-Q)),
        lambda X: A * X + X * A.T + Q,
    )  # fmt: skip
    values = np.linalg.eigvals(as_numpy(A))
    if (
        result is not None
        and result.is_unique
        and min(abs(x + y) for x in values for y in values) > 1e-2
    ):
        expected = scipy.linalg.solve_continuous_lyapunov(as_numpy(A), -as_numpy(Q))
        assert np.allclose(as_numpy(result.X), expected, rtol=1e-6, atol=1e-6)


def test_discrete_against_scipy():
    A, Q = Matrix([[Rational(1, 2), 1], [0, Rational(-1, 3)]]), Matrix([[2, 1], [1, 3]])
    expected = scipy.linalg.solve_discrete_lyapunov(as_numpy(A), as_numpy(Q))
    assert np.allclose(as_numpy(solve_stein(A, Q).X), expected)


def large(rows, columns, seed):
    """Rational entries, too large for the other tests' oracles."""
    rng = np.random.default_rng(seed)
    entries = rng.integers(-9, 10, (2, rows * columns))
    return Matrix(
        rows,
        columns,
        [Rational(int(p), abs(int(q)) // 4 + 1) for p, q in zip(*entries, strict=True)],
    )


@pytest.mark.parametrize(("n", "m"), [(12, 9), (7, 14), (1, 20)])
def test_large_ones_against_their_residual_and_scipy(n, m):
    A, B, C = large(n, n, 1), large(m, m, 2), large(n, m, 3)
    X = solve_sylvester(A, B, -C).X
    assert (A * X + X * B - C).is_zero_matrix
    expected = scipy.linalg.solve_sylvester(*map(as_numpy, (A, B, C)))
    assert np.allclose(as_numpy(X), expected, rtol=1e-6, atol=1e-9)
    Y = solve_stein(A, C, B).X
    assert (A * Y * B + C - Y).is_zero_matrix


def test_poles_that_are_there_often_have_short_solutions():
    plant = realisation(("1", polynomial_from_roots([-1, -2, -3] * 4, "s")))
    gramian_pair = gramians(plant)
    A, B, W = plant.A, plant.B, gramian_pair.controllability
    assert (A * W + W * A.T + B * B.T).is_zero_matrix


def test_combinations_that_hide_a_denominator(monkeypatch):
    A, C = large(8, 8, 4), large(8, 8, 5)
    usual = solve_lyapunov(A, C)
    monkeypatch.setattr(sylvester_equations, "_SMALL_PRIMES", 1)
    monkeypatch.setattr(sylvester_equations, "_SPARE_BITS", -40)  # lifted too little
    assert solve_lyapunov(A, C) == usual


def test_a_solution_with_too_many_digits_is_refused():
    A = Matrix(80, 80, lambda i, j: (7 * i * i + 3 * j + i * j) % 19 - 9 + 30 * (i == j))
    with pytest.raises(BudgetError, match="digits counted as one"):
        solve_stein(A, A, A)
    small = Matrix(12, 12, list(A[:12, :12]))
    with budget(entries=300), pytest.raises(BudgetError, match="digits counted as one"):
        solve_lyapunov(small, small)
    assert solve_lyapunov(small, small).certificate.holds


def test_symbols_say_where_they_hold():
    solution = solve_lyapunov([[0, 1], ["-b", "-a"]], [[0, 0], [0, 1]])
    a, b = sympy.symbols("a b")
    assert solution.exceptional == (a, b)
    assert solution.X.subs({a: 3, b: 2}) == solve_lyapunov([[0, 1], [-2, -3]], [[0, 0], [0, 1]]).X
    with pytest.raises(NoSolutionError, match="sum 0"):
        solve_lyapunov([[0, 1], [-2, 0]], [[0, 0], [0, 1]])  # a = 0
    family = solve_sylvester([["a"]], [["-a"]], [[0]])
    assert not family.is_unique and family.homogeneous[0] == Matrix([[1]])


@fewer(3)
@given(st.integers(1, 4), st.integers(1, 4), st.integers(-3, 3))
def test_norm_of_a_second_order_plant(a, b, c):
    """The integral of the square of the impulse response, from the table of James and Nichols."""
    assert gramians(f"({c}*s + 1)/(s**2 + {a}*s + {b})").norm_squared == Rational(
        c * c * b + 1, 2 * a * b
    )


@fewer(3)
@given(systems(max_block=1))
def test_discrete_gramians_against_impulse_sums(system):
    size = max(1, sum(abs(entry) for entry in system.A)) * 2
    A = system.A / size  # of norm at most 1/2, so that 60 terms are exact to 1e-15
    gramian_pair = gramians((A, system.B, system.C, system.D), "z")
    a, b, c, d = map(as_numpy, (A, system.B, system.C, system.D))
    reached, energy, power = np.zeros(a.shape), np.sum(d * d), np.eye(len(a))
    for _ in range(60):
        reached += power @ b @ b.T @ power.T
        energy += np.sum((c @ power @ b) ** 2)
        power = a @ power
    assert np.allclose(as_numpy(gramian_pair.controllability), reached, rtol=1e-9, atol=1e-12)
    assert np.isclose(float(gramian_pair.norm_squared), energy, rtol=1e-9)


@fewer(3)
@given(systems(max_block=1), st.integers(1, 3))
def test_continuous_gramians_against_scipy(system, shift):
    A = system.A - (shift + sum(abs(entry) for entry in system.A)) * sympy.eye(system.n)
    gramian_pair = gramians((A, system.B, system.C), "s")
    a, b, c = map(as_numpy, (A, system.B, system.C))
    for mine, one, two in (
        (gramian_pair.controllability, a, b @ b.T),
        (gramian_pair.observability, a.T, c.T @ c),
    ):
        expected = scipy.linalg.solve_continuous_lyapunov(one, -two)
        assert np.allclose(as_numpy(mine), expected, rtol=1e-9, atol=1e-12)
    hankel = gramian_pair.hankel_polynomial()
    assert hankel.degree() == system.n and hankel.TC() * (-1) ** system.n >= 0  # fmt: skip


def test_gramians_say_what_is_wrong():
    for plant in ("1/(s - 1)", "1/s", "1/(z - 2)"):
        with pytest.raises(NoSolutionError, match="not stable"):
            gramians(plant)
    with pytest.raises(InputError, match="time domain of x"):
        gramians("1/(x + 1)")
    assert gramians("(s + 2)/(s + 1)").norm_squared == sympy.oo
    assert gramians("1/(z**2 + a*z + b)", "z").conditions
    a, b = sympy.symbols("a b")
    expected = (1 + b) / ((1 - b) * (1 + a + b) * (1 - a + b))
    assert sympy.cancel(gramians("1/(z**2 + a*z + b)", "z").norm_squared - expected) == 0


@fewer(3)
@given(systems(max_block=1), small_matrices(2, 2), st.data())
def test_regulator_equations_against_their_linear_system(system, S, data):
    n, p = system.n, system.C.rows
    Q, P = data.draw(small_matrices(p, 2)), data.draw(small_matrices(n, 2))
    kron, eye = sympy.kronecker_product, sympy.eye
    upper = (kron(eye(n), S.T) - kron(system.A, eye(2))).row_join(-kron(system.B, eye(2)))
    lower = kron(system.C, eye(2)).row_join(kron(system.D, eye(2)))
    left, right = upper.col_join(lower), Matrix([*P, *(-Q)])
    free = kronecker(left, right)
    if free is None:
        with pytest.raises(NoSolutionError, match="zero of the plant"):
            solve_regulator_equations(system, S, Q, P)
        return
    solution = solve_regulator_equations(system, S, Q, P)
    assert len(solution.homogeneous) == free and solution.certificate.holds
    unknown = Matrix([*solution.Pi, *solution.Gamma])
    assert (left * unknown - right).is_zero_matrix


def test_the_error_dies_out():
    """The loop with the feedforward, simulated: e(t) -> 0 for every start."""
    plant = realisation("(s + 2)/(s**3 + s)")
    S, Q = [[0, 1], [-4, 0]], [[-1, 0]]
    solution = solve_regulator_equations(plant, S, Q)
    K = Matrix([[-6, -10, -6]])  # s**3 + 6 s**2 + 11 s + 6
    L = solution.feedforward(K)
    closed = (plant.A + plant.B * K).row_join(plant.B * L)
    whole = closed.col_join(sympy.zeros(2, 3).row_join(Matrix(S)))
    end = scipy.linalg.expm(20 * as_numpy(whole)) @ np.array([1, -2, 3, 1, 1])
    assert abs((as_numpy(plant.C.row_join(Matrix(Q))) @ end)[0]) < 1e-6
    with pytest.raises(InputError, match="needs a gain"):
        solution.feedforward([[1]])


def test_a_zero_at_the_exosystem():
    blocked = "(s**2 + 4)/(s + 1)**3"
    assert invariant_zeros(blocked).polynomial.as_expr() == sympy.Symbol("s") ** 2 + 4
    with pytest.raises(NoSolutionError, match="invariant_zeros"):
        solve_regulator_equations(blocked, [[0, 1], [-4, 0]], [[-1, 0]])


@pytest.mark.parametrize(
    "call",
    [lambda: solve_sylvester([[1, 2]], [[1]], [[1]]), lambda: solve_lyapunov([[1]], [[1, 2]]),
     lambda: solve_stein([], []), lambda: solve_lyapunov([["1/x", "nan"]], [[1]]),
     lambda: solve_sylvester([[1]], [[1]], "C"), lambda: solve_lyapunov([[2**0.5]], [["sqrt(2)"]]),
     lambda: solve_regulator_equations("1/s", [[0, 1]], [[1]]),
     lambda: solve_regulator_equations("1/s", [], []),
     lambda: solve_lyapunov(sympy.eye(130), sympy.eye(130)),
     lambda: solve_lyapunov(Matrix(6, 6, lambda i, j: sympy.Symbol(f"a{i}{j}")), sympy.eye(6)),
     lambda: gramians("s")],
)  # fmt: skip
def test_bad_input(call):
    with pytest.raises(CompensatorError):
        call()


def test_a_solution_with_integers_that_python_does_not_print_is_written():
    """Their length is that of the answer, which no budget of the input knows."""
    large = 10**1500
    solution = solve_lyapunov([[-1, large], [0, -large - 1]], [[large, 7], [7, 1]])
    longest = max(map(len, re.findall(r"\d+", text(solution.X))))
    assert longest == 4500 and len(solution._repr_latex_()) > 4 * longest


def test_a_determinant_with_too_many_terms_is_refused():
    A = sympy.Matrix(4, 4, lambda i, j: (3 * i + 5 * j + i * j) % 7)
    with_symbols = A + sympy.diag(*sympy.symbols("a b c d"))
    shifted = with_symbols - 50 * sympy.eye(4)
    with pytest.raises(BudgetError, match="determinant of the matrix equation"):
        solve_sylvester(with_symbols, shifted, sympy.eye(4))
    few = A + sympy.diag(*sympy.symbols("a b"), 0, 0)
    solution = solve_sylvester(few, A - 50 * sympy.eye(4), sympy.eye(4))
    assert solution.certificate.holds and solution.is_unique
