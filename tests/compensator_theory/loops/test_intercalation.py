"""The intercalated transfer function: (4.14) on recorded data, formulas, reachable targets."""

from fractions import Fraction

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import Poly

import compensator_theory as ct
from compensator_theory.errors import (
    ImproperError,
    NoSolutionError,
    NotReachableTargetError,
    UnitCircleError,
)
from compensator_theory.loops import (
    closed_loop_transfer_matrix,
    control_perturbation_transfer_function,
    target_characteristic_polynomial,
)
from compensator_theory.roots import split_at_unit_circle
from compensator_theory.strategies import (
    matrices,
    polynomials,
    rationals,
    standard_problems,
    strictly_proper_plants,
)

q = sympy.Symbol("q")
STEPS = 9


def fractions(matrix):
    return [[Fraction(int(x.p), int(x.q)) for x in row] for row in matrix.tolist()]


def times(matrix, vector):
    return [sum((m * x for m, x in zip(row, vector, strict=True)), Fraction(0)) for row in matrix]


def plus(*vectors):
    return [sum(parts, Fraction(0)) for parts in zip(*vectors, strict=True)]


def response(G, signal):
    """Response from rest of a transfer matrix to a recorded signal, entry by entry.

    D(q) z = N(q) u with D monic of degree n: z(k) = sum_j N_j u(k-j) - sum_{j>0} D_j z(k-j).
    """
    n = G.denominator.degree()
    d = [Fraction(int(c.p), int(c.q)) for c in G.denominator.all_coeffs()]
    total = [[Fraction(0)] * G.shape[0] for _ in signal]
    for i, row in enumerate(G.numerators):
        for j, entry in enumerate(row):
            b = [entry.coeff_monomial(q ** (n - k)) for k in range(n + 1)]
            b = [Fraction(int(c.p), int(c.q)) for c in b]
            out = []
            for k in range(len(signal)):
                past = range(min(k, n) + 1)
                value = sum((b[m] * signal[k - m][j] for m in past), Fraction(0))
                out.append(value - sum((d[m] * out[k - m] for m in past if m), Fraction(0)))
                total[k][i] += out[k]
    return total


@given(st.sampled_from([0, 1, 2]), st.booleans(), st.data())
def test_4_14_holds_for_any_recorded_control_and_any_theta(k_c, has_direct_term, data):
    problem = data.draw(standard_problems(2, has_direct_term=has_direct_term))
    n_c = data.draw(st.integers(max(k_c, 1), 2))
    l_u, l_y, l_w = problem.l_u, problem.l_y, problem.l_w
    P = [data.draw(matrices(l_u, l_u)) for _ in range(n_c)]
    Q = [data.draw(matrices(l_u, l_y)) for _ in range(n_c + 1 - k_c)]
    N_c, D_c = ct.compensator_polynomials(P, Q, n_c, k_c)
    record = [fractions(data.draw(matrices(1, l_u + l_w)))[0] for _ in range(STEPS)]
    u, w = [r[:l_u] for r in record], [r[l_u:] for r in record]
    A, B, C, D_1, D_0, D_2, E_1, E_2, E_0 = (
        fractions(getattr(problem, name))
        for name in ("A", "B", "C", "D_1", "D_0", "D_2", "E_1", "E_2", "E_0")
    )
    x, y, z = [Fraction(0)] * problem.n, [], []
    for k in range(STEPS):  # the plant under the recorded control
        y.append(plus(times(C, x), times(D_0, u[k]), times(D_2, w[k])))
        z.append(plus(times(E_1, x), times(E_2, u[k]), times(E_0, w[k])))
        x = plus(times(A, x), times(B, u[k]), times(D_1, w[k]))
    P, Q = [fractions(p) for p in P], [fractions(m) for m in Q]
    u_tilde = []
    for k in range(STEPS):  # u~(k) = u(k) - Phi(k) theta*
        past_u = [times(P[i - 1], u[k - i]) for i in range(1, min(n_c, k) + 1)]
        past_y = [times(Q[i - k_c], y[k - i]) for i in range(k_c, min(n_c, k) + 1)]
        star = plus([Fraction(0)] * l_u, *past_u, *past_y)
        u_tilde.append([a - b for a, b in zip(u[k], star, strict=True)])
    try:
        closed = closed_loop_transfer_matrix(problem, N_c, D_c)
        intercalated = ct.intercalated_transfer_matrix(problem, N_c, D_c)
    except ImproperError:
        assert k_c == 0 and has_direct_term
        return
    parts = zip(response(closed, w), response(intercalated, u_tilde), strict=True)
    assert z == [plus(from_w, from_u_tilde) for from_w, from_u_tilde in parts]


@given(standard_problems(2), st.integers(1, 2), st.data())
def test_4_16_at_a_rational_point(problem, n_c, data):
    P = [data.draw(matrices(problem.l_u, problem.l_u)) for _ in range(n_c)]
    Q = [data.draw(matrices(problem.l_u, problem.l_y)) for _ in range(n_c)]
    N_c, D_c = ct.compensator_polynomials(P, Q, n_c, 1)
    point = sympy.Rational(191, 7)
    G_zu, G_yu = (problem.transfer_matrix(c).as_matrix().subs(q, point) for c in ("zu", "yu"))
    inverse = D_c.subs(q, point).inv()
    G_c = inverse * N_c.subs(q, point)
    middle = (sympy.eye(problem.l_y) - G_yu * G_c).inv()
    expected = point**n_c * G_zu * (inverse + G_c * middle * G_yu * inverse)
    result = ct.intercalated_transfer_matrix(problem, N_c, D_c)
    assert result.as_matrix().subs(q, point) == expected
    assert result.denominator.degree() == problem.n + problem.l_u * n_c


@given(standard_problems(3, 1), polynomials("q", 0, 1), polynomials("q", 2, 2))
def test_scalar_forms(problem, N_c, D_c):
    D_c = D_c.monic()
    loop = ct.closed_loop_polynomial(problem, N_c, D_c)
    result = ct.intercalated_transfer_function(problem, N_c, D_c)
    assert (result.numerator, result.denominator) == (problem.numerator("zu") * Poly(q**2, q), loop)
    outside = control_perturbation_transfer_function(problem, N_c, D_c)
    assert (outside.numerator, outside.denominator) == (problem.numerator("zu") * D_c, loop)


@given(strictly_proper_plants("q", 3), st.integers(0, 2), st.data())
def test_target_for_pole_placement_4_38_and_4_39(plant, slack, data):
    N, d_zu = plant.numerator, plant.relative_degree
    try:
        stable, unstable = split_at_unit_circle(N)
    except (UnitCircleError, NoSolutionError):
        return
    n_u = unstable.degree()
    n_p = data.draw(st.integers(d_zu + n_u, d_zu + n_u + 2))
    D_p = data.draw(polynomials("q", n_p, n_p, is_monic=True))
    n_c = n_p + slack
    numerator = N.LC() * Poly(q ** (n_p - d_zu - n_u), q) * unstable
    problem = ct.standard_problem(plant)
    polynomial = target_characteristic_polynomial(problem, n_c, (numerator, D_p))
    assert polynomial == stable * Poly(q ** (n_c - n_p + d_zu + n_u), q) * D_p
    assert polynomial == target_characteristic_polynomial((N, plant.order), n_c, (numerator, D_p))
    if n_c >= plant.order:  # strictly proper compensators reach it, and the match is exact
        placement = ct.place_poles(plant, polynomial, feedback=+1)
        matched = ct.intercalated_transfer_function(
            problem, placement.numerator, placement.denominator
        )
        assert matched.numerator * D_p == numerator * matched.denominator


@pytest.mark.parametrize(
    ("target", "reason"),
    [("2*q/(q**3 - 0.1)", "relative degree"), ("q/(q**2 - 0.1)", "leading coefficient"),
     ("2*(q - 0.7)/(q**2 - 0.1)", "zeros at the roots of q - 7/10"), ("0/(q + 1)", "is 0"),
     ("2*q**3*(q - 0.5)/(q**5 + 1)", "at most 2")],
)  # fmt: skip
def test_targets_out_of_reach(target, reason):
    plant = ct.standard_problem("2*(q - 0.5)/((q - 1)*(q - 2))")
    with pytest.raises(NotReachableTargetError, match=reason):
        target_characteristic_polynomial(plant, 2, target)


def test_target_with_symbols_and_common_factors():
    plant = ct.standard_problem("b*(q - c)/(q**2 + a*q)")
    polynomial = target_characteristic_polynomial(plant, 2, "b*q*(q + 5)/((q**2 + p)*(q + 5))")
    assert polynomial == ct.polynomial("q*(q - c)*(q**2 + p)", "q")
    with pytest.raises(NotReachableTargetError):
        target_characteristic_polynomial(plant, 2, "d*q/(q**2 + p)")


@given(rationals())
def test_refusals(x):
    plant = ct.standard_problem("1/(q - 2)")
    for n_c in (-1, 1.0, True):
        with pytest.raises(ct.InputError):
            target_characteristic_polynomial(plant, n_c, "1/q")
    with pytest.raises(ct.InputError, match="N_zu = 0"):
        target_characteristic_polynomial(ct.standard_problem("0/(q - 2)"), 1, "1/q")
    for P, Q, n_c, k_c in (([1], [1], 2, 1), ([1], [1, 2], 1, 1), ([1], [1], 1, 2), ([], [], 0, -1),
                           ([[[1, 2]]], [x], 1, 1), ([1], [[1, 2]], 1, 1)):  # fmt: skip
        with pytest.raises(ct.InputError):
            ct.compensator_polynomials(P, Q, n_c, k_c)
    N_c, D_c = ct.compensator_polynomials([x], [1, x], 1, 0)
    assert (N_c[0], D_c[0]) == (q + x, q - x)
