"""Riccati equations and LQG over number fields: substitution, textbooks, SciPy, mpmath."""

from operator import attrgetter

import flint
import numpy as np
import pytest
import scipy.linalg
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

from compensator_theory import (
    CompensatorError,
    StandardProblem,
    budget,
    lqg_controller,
    lqg_poles,
    lqg_problem,
    solve_riccati,
    standard_problem,
)
from compensator_theory.errors import NotControllableError
from compensator_theory.roots._number_fields import Arithmetic, NumberField, stable_factors
from compensator_theory.strategies import matrices

s = sympy.Symbol("s")
ROOT = sympy.sqrt


def as_float(matrix):
    return np.array(sympy.Matrix(matrix).tolist(), dtype=float)


def centres(rows):
    return np.array([[float(c) for c in row] for row in rows])


def with_roots(poly):
    return flint.fmpq_poly([int(c) for c in reversed(sympy.Poly(poly, s).all_coeffs())])


@pytest.mark.parametrize(
    ("spectrum", "minimal", "factor"),
    [
        (s**4 + 1, "sigma**2 - 2", s**2 + ROOT(2) * s + 1),
        ((s**4 + 1) ** 2, "sigma**2 - 2", (s**2 + ROOT(2) * s + 1) ** 2),
        (2 - s**2, "sigma**2 - 2", s + ROOT(2)),
        ((1 - s**2) * (4 - s**2), "sigma", (s + 1) * (s + 2)),
        ((2 - s**2) * (3 - s**2), "sigma**4 - 10*sigma**2 + 1", (s + ROOT(2)) * (s + ROOT(3))),
        ((s**2 - 2 * s - 1) * (s**2 + 2 * s - 1), "sigma**2 - 8", s**2 + 2 * ROOT(2) * s + 1),
    ],
)
def test_known_factors(spectrum, minimal, factor):
    """Written down by hand; the last one has irreducible parts with roots on both sides."""
    factors = stable_factors(with_roots(spectrum))
    assert factors.field.minimal.as_expr() == sympy.sympify(minimal)
    generator = factors.field.generator
    written = sum(
        sum(sympy.Rational(int(x.p), int(x.q)) * generator**i for i, x in enumerate(c.coeffs()))
        * s**k
        for k, c in enumerate(factors.factors[0])
    )
    difference = sympy.Poly(sympy.expand(written - factor), s).all_coeffs()
    assert all(sympy.simplify(c) == 0 for c in difference)


@given(
    st.lists(st.integers(-5, 5), min_size=1, max_size=4),
    st.lists(st.integers(-5, 5), min_size=1, max_size=4),
)
def test_factors_are_those_of_the_left_roots(first, second):
    D, N = flint.fmpq_poly([*first, 1]), flint.fmpq_poly(second)

    def squared(p):
        return p * flint.fmpq_poly([-c if k % 2 else c for k, c in enumerate(p.coeffs())])

    spectrum = squared(D) + squared(N)
    roots = np.roots([float(c.p) / float(c.q) for c in spectrum.coeffs()[::-1]])
    assume(len(roots) == 0 or min(abs(roots.real)) > 1e-3)
    factors = stable_factors(spectrum)
    place = factors.field.ball(200)
    values = [float(flint.arb_poly(c)(place)) for c in factors.factors[0]]
    left = np.poly([r for r in roots if r.real < 0]).real[::-1]
    assert np.allclose(values, left, rtol=1e-4, atol=1e-4 * max(abs(left)))


@given(st.integers(1, 4), st.lists(st.integers(-3, 3), min_size=24, max_size=24))
def test_linear_systems_have_one_answer_by_both_ways(size, numbers):
    """One rational system of d times the size, and rounding at the conjugates."""
    work = Arithmetic(
        NumberField(sympy.Poly(sympy.Symbol("sigma") ** 3 - 4 * sympy.Symbol("sigma") - 1))
    )
    n = min(size, 2)
    entries = iter(numbers)
    grids = [
        [[flint.fmpq_poly([next(entries) for _ in range(3)]) for _ in range(m)] for _ in range(n)]
        for m in (n, 1)
    ]
    try:
        direct = work.solve(*grids)
    except ZeroDivisionError:
        return
    assert work._solve_at_conjugates(*grids, flint.fmpz(1)) == direct
    assert work.product(grids[0], direct) == grids[1]


def test_textbook_answers():
    """The double integrator; 2 + sqrt(5) for a = 2; a filter that colours the noise."""
    double = solve_riccati(
        [[0, 1], [0, 0]], [[0], [1]], Q=[[1, 0], [0, 0]], R=[[1]], time="continuous"
    )
    assert list(double.K) == [-1, -ROOT(2)] and list(double.P) == [ROOT(2), 1, 1, ROOT(2)]
    assert solve_riccati([[2]], [[1]], Q=[[1]], R=[[1]], time="discrete").P[0] == 2 + ROOT(5)
    hidden = solve_riccati(
        [[-1, 1], [0, -2]], [[1], [0]], Q=[[1, 0], [0, 0]], R=[[1]], time="continuous"
    )
    assert hidden.P[0] == ROOT(2) - 1
    three = solve_riccati(
        [[0, 1, 0], [0, 0, 1], [0, 0, 0]], [[0], [0], [1]], Q=sympy.diag(1, 0, 0), R=[[1]],
        time="continuous",
    )  # fmt: skip
    assert list(three.K) == [-1, -2, -2]  # Butterworth's polynomial s**3 + 2 s**2 + 2 s + 1


@st.composite
def equations(draw, sizes):
    n, m = draw(sizes), draw(st.integers(1, 2))
    A, B = draw(matrices(n, n)), draw(matrices(n, m))
    M = draw(matrices(n + m, n + m))
    W = M.T * M
    time = draw(st.sampled_from(["continuous", "discrete"]))
    R = W[n:, n:] + (
        sympy.eye(m) if time == "continuous" or draw(st.booleans()) else 0 * sympy.eye(m)
    )
    return A, B, W[:n, :n], R, W[:n, n:], time


@given(equations(st.integers(1, 3)))
def test_every_solution_is_substituted(data):
    """The equation in the field, and SciPy's solver where it succeeds."""
    A, B, Q, R, N, time = data
    try:
        solution = solve_riccati(A, B, Q=Q, R=R, N=N, time=time)
    except CompensatorError:
        assume(False)
    assert solution.is_exact and solution.certificate.holds
    assert all(0 in entry for row in solution.residual for entry in row)
    solver = (
        scipy.linalg.solve_continuous_are
        if time == "continuous"
        else scipy.linalg.solve_discrete_are
    )
    roots = np.roots([float(c) for c in solution.factor.enclosure.coefficients])
    margin = -roots.real if time == "continuous" else 1 - abs(roots)
    assert min(margin) > -1e-6
    assume(min(margin) > 1e-2)
    try:
        P = solver(*map(as_float, (A, B, Q, R)), s=as_float(N))
    except (np.linalg.LinAlgError, ValueError):
        return
    assert np.allclose(centres(solution.P_enclosure), P, rtol=1e-5, atol=1e-5 * (1 + abs(P).max()))
    closed = as_float(A) + as_float(B) @ centres(solution.K_enclosure)
    moments = np.poly(closed)
    expected = [float(c) for c in solution.factor.enclosure.coefficients]
    assert np.allclose(moments, expected, rtol=1e-6, atol=1e-6 * max(map(abs, expected)))


def test_an_eigenvalue_at_minus_one_is_moved_away():
    """z = -1 goes to infinity on the half plane: a feedback comes first, and P is what it was."""
    solution = solve_riccati(
        [[-1, 1], [0, -1]], [[0], [1]], Q=sympy.eye(2), R=[[1]], time="discrete"
    )
    P = scipy.linalg.solve_discrete_are(
        *map(np.array, ([[-1.0, 1], [0, -1]], [[0.0], [1]])), np.eye(2), np.eye(1)
    )
    assert solution.certificate.holds and np.allclose(centres(solution.P_enclosure), P)
    with pytest.raises(NotControllableError):
        solve_riccati([[-1]], [[0]], Q=[[1]], R=[[1]], time="discrete")


def test_beyond_the_budget_there_are_balls():
    """Of five spectra of growing degree the last two need fields of degree 64 and 128."""
    counts = []
    for n in range(3, 8):
        A = [[int(j == i + 1) for j in range(n)] for i in range(n - 1)] + [
            [(3 * j + n) % 7 - 3 for j in range(n)]
        ]
        B = [[0]] * (n - 1) + [[1]]
        Q = sympy.diag(*(1 + (5 * i + n) % 4 for i in range(n)))
        if n == 5:
            continue  # within the budget, and the slowest
        solution = solve_riccati(A, B, Q=Q, R=[[2]], time="continuous", digits=40)
        counts.append(solution.is_exact)
        assert (solution.K_in_field is None) is (solution.field is None) is not solution.is_exact
        small = solution.field is not None and solution.field.degree <= 32
        assert (solution.K is None) is (solution.P is None) is not small
        assert (solution.certificate is None) is not solution.is_exact
        assert solution.formula.certificate.holds
        assert all(0 in entry for row in solution.residual for entry in row)
        assert max(e.radius for row in solution.P_enclosure for e in row) <= sympy.Rational(
            1, 10**40
        )
        P = scipy.linalg.solve_continuous_are(*map(as_float, (A, B, Q, [[2]])))
        assert np.allclose(centres(solution.P_enclosure), P, rtol=1e-7)
    assert counts == [True, True, True, False]


@pytest.mark.parametrize("time", ["continuous", "discrete"])
def test_formulas_hold_at_any_order(time):
    """The gain is linear in the coefficients of the factor; their relations vanish at its balls."""
    n = 9
    A = [[int(j == i + 1) for j in range(n)] for i in range(n - 1)] + [
        [(3 * j) % 7 - 3 for j in range(n)]
    ]
    B = [[0]] * (n - 1) + [[1]]
    solution = solve_riccati(A, B, Q=sympy.eye(n), R=[[2]], time=time)
    formula = solution.formula
    assert not solution.is_exact and formula.certificate.holds
    at = {
        name: value.centre for name, value in zip(formula.coefficients, formula.values, strict=True)
    }
    for relation in formula.relations:
        assert abs(relation.subs(at)) < 1e-20
    assert len(formula.relations) == n + (time == "discrete")
    for entry, ball in zip(formula.K, solution.K_enclosure[0], strict=True):
        assert abs(entry.subs(at) - ball.centre) < 1e-20
    several = solve_riccati([[2]], [[1, 1]], Q=[[1]], R=sympy.eye(2), time=time)
    assert several.formula is None


def controller(variable, n=2, seed=0):
    rng = np.random.default_rng(seed)

    def drawn(*shape):
        return rng.integers(-3, 4, shape).tolist()

    continuous = variable == "s"
    return StandardProblem(
        drawn(n, n), drawn(n, 1), drawn(1, n), [[*r, 0] for r in drawn(n, 1)], None, [[0, 1]],
        [*drawn(1, n), [0] * n], [[0], [1]] if continuous else None, None, variable=variable,
    )  # fmt: skip


@pytest.mark.parametrize("variable", ["s", "z"])
@pytest.mark.parametrize("seed", range(8))
def test_the_compensator_closes_the_loop(variable, seed):
    """Closed-loop poles and the power of z, from floats of the exact matrices."""
    plant = controller(variable, seed=seed)
    try:
        result = lqg_controller(plant, digits=40)
    except CompensatorError:
        return
    matrices_ = result.matrices_in_field
    A_c, B_c, C_c = (centres(m.enclosures()) for m in matrices_)
    A, B, C, D_1, D_2, E_1, E_2 = (
        as_float(getattr(plant, name)) for name in ("A", "B", "C", "D_1", "D_2", "E_1", "E_2")
    )
    loop = np.block([[A, B @ C_c], [B_c @ C, A_c]])
    expected = [float(c) for c in result.enclosure.coefficients]
    assert np.allclose(np.poly(loop), expected, rtol=1e-6, atol=1e-6 * max(map(abs, expected)))
    # The cost is the power of z, from the closed loop's own Gramian.
    noise, out = np.vstack([D_1, B_c @ D_2]), np.hstack([E_1, E_2 @ C_c])
    solver = scipy.linalg.solve_continuous_lyapunov if variable == "s" else None
    if solver is not None:
        W = solver(loop, -noise @ noise.T)
    else:
        W = scipy.linalg.solve_discrete_lyapunov(loop, noise @ noise.T)
    assert np.isclose(float(result.cost_enclosure), np.trace(out @ W @ out.T), rtol=1e-5)
    ball = result.cost_in_field.enclosures()[0][0]
    assert abs(result.cost_enclosure.centre - ball.centre) <= ball.centre / 10**20
    assert lqg_poles(plant).enclosure.degree == 4


def test_double_integrator_with_unit_weights():
    """Every textbook's: K = (1, sqrt 2), the compensator and the cost 6 sqrt 2."""
    plant = StandardProblem(
        A=[[0, 1], [0, 0]], B=[[0], [1]], C=[[1, 0]], D_1=[[0, 0], [1, 0]], D_0=None,
        D_2=[[0, 1]], E_1=[[1, 0], [0, 0]], E_2=[[0], [1]], E_0=None, variable="s",
    )  # fmt: skip
    controller = lqg_controller(plant)
    G_c = controller.compensator
    assert G_c.numerator.as_expr() == -2 * ROOT(2) * s - 1
    assert G_c.denominator.as_expr() == s**2 + 2 * ROOT(2) * s + 4
    assert controller.cost == 6 * ROOT(2) and controller.polynomial is None
    assert all("sqrt" in str(x) for x in (controller.compensator, controller.regulator))


def test_several_signals_and_stable_hidden_modes_have_controllers():
    plant = StandardProblem(
        A=[[1, 0, 0], [0, 2, 1], [0, 0, "-1/2"]], B=[[1, 0], [0, 1], [0, 0]],
        C=[[1, 0, 0], [0, 1, 0]], D_1=[[1, 0, 0], [0, 0, 0], [2, 0, 0]], D_0=[[1, 0], [0, 2]],
        D_2=[[0, 1, 0], [0, 0, 1]], E_1=[[1, 1, 0], [0, 0, 0], [0, 0, 0]],
        E_2=[[0, 0], [1, 0], [0, 1]], E_0=None, variable="s",
    )  # fmt: skip
    controller = lqg_controller(plant)
    assert (
        controller.is_exact
        and controller.regulator.certificate.holds
        and controller.estimator.certificate.holds
    )
    A_c, B_c, C_c = (centres(m.enclosures()) for m in controller.matrices_in_field)
    A, B, C, D_0 = (as_float(getattr(plant, name)) for name in ("A", "B", "C", "D_0"))
    loop = np.block([[A, B @ C_c], [B_c @ C, A_c + B_c @ D_0 @ C_c]])
    expected = [float(c) for c in controller.enclosure.coefficients]
    assert np.allclose(np.poly(loop), expected, rtol=1e-8)
    assert controller.regulator.factor.enclosure.centre.eval(sympy.Rational(-1, 2)) < 1e-20


@pytest.mark.costly
def test_the_cost_of_a_sampled_plant_with_two_outputs():
    """Its field has degree 64 and long numbers: SymPy would isolate the generator for minutes."""
    A, B, C = [[1, -1, -1], [2, 0, 2], [2, 2, -1]], [[0], [2], [2]], [[0, 1, 1], [2, -1, 2]]
    Q, R = [[3, 2, "5/2"], [2, 6, -1], ["5/2", -1, "17/4"]], [["13/3"]]
    W = [["21/4", 3, 0], [3, "21/4", "3/2"], [0, "3/2", "5/4"]]
    plant = lqg_problem((A, B, C), Q, R, W, sympy.eye(2), variable="z")
    controller = lqg_controller(plant)
    assert controller.is_exact and controller.matrices_in_field[0].field.degree == 64
    assert controller.cost is controller.realisation is None
    (ball,) = controller.cost_in_field.enclosures()[0]
    assert abs(controller.cost_enclosure.centre - ball.centre) <= ball.centre / 10**20
    with budget(field_degree=64):
        assert controller.cost.atoms(sympy.CRootOf)
    W, V, Q, R = (as_float(M) for M in (W, sympy.eye(2), Q, R))
    P = scipy.linalg.solve_discrete_are(*(as_float(M) for M in (A, B)), Q, R)
    at, ct = as_float(A).T, as_float(C).T
    S = scipy.linalg.solve_discrete_are(at, ct, W, V)
    K = centres(controller.regulator.K_enclosure)
    weight = R + as_float(B).T @ P @ as_float(B)
    assert np.isclose(float(ball), np.trace(P @ W) + np.trace(K.T @ weight @ K @ S), rtol=1e-9)


def test_gains_are_exact_where_their_joint_field_is_too_large():
    """Order 6: each gain in a field of degree 64 at most, the compensator as two of them."""
    n = 6
    A = [[int(j == i + 1) for j in range(n)] for i in range(n - 1)] + [[1, -2, 0, 3, -1, 2]]
    plant = StandardProblem(
        A, [[0]] * (n - 1) + [[1]], [[1] + [0] * (n - 1)], [[i % 2, 0] for i in range(n)], None,
        [[0, 1]], [[1, 1] + [0] * (n - 2), [0] * n], [[0], [1]], None, variable="s",
    )  # fmt: skip
    controller = lqg_controller(plant)
    assert controller.is_exact and controller.regulator.field.degree == 64
    assert controller.regulator.certificate.holds and controller.estimator.certificate.holds
    assert (
        controller.matrices_in_field
        is controller.realisation
        is controller.compensator
        is controller.cost
        is None
    )
    assert controller.cost_enclosure.centre > 0 and str(controller).startswith("D = ")


def test_the_budget_is_a_door():
    plant = standard_problem("(q**2 - 3*q + 1)/(q**3 - 5)")
    with budget(field_degree=64):
        assert lqg_controller(plant).is_exact


def test_a_controller_without_a_formula_says_which_numbers_are_certified():
    unit = [[1, 0], [0, 1]]
    plant = lqg_problem(
        ([[1, 2], [0, 3]], [[1], [2]], [[1, 1]]), unit, [[1]], unit, [[1]], variable="s"
    )
    designed = lqg_controller(plant)
    assert designed.compensator is None
    named = str(designed).partition("certified are ")[2].replace(" and ", ", ").split(", ")
    assert len(named) == 3
    assert all(attrgetter(name)(designed) is not None for name in named)
