"""The limit of predictive cost adaptive control: its polynomial, its gain, and what is refused."""

import numpy as np
import pytest
import scipy.linalg
import sympy
from hypothesis import given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.errors import CompensatorError, ImproperError, InputError
from compensator_theory.strategies import matrices, strictly_proper_plants

q = sympy.Symbol("q")
WEIGHS = ("moves", "u")


@st.composite
def models(draw):
    """(b, a) of n lags, m inputs and p outputs."""
    n, m, p = draw(st.sampled_from([(1, 1, 1), (2, 1, 1), (3, 1, 1), (2, 2, 1), (1, 2, 2)]))
    return [draw(matrices(p, m)) for _ in range(n)], [draw(matrices(p, p)) for _ in range(n)]


def difference_equation(b, a):
    """The plant as its outputs and inputs of the past, with no observer form in it."""
    n, (p, m) = len(a), b[0].shape
    size = n * (p + m)
    A, B = sympy.zeros(size, size), sympy.zeros(size, m)
    for i in range(n):
        A[:p, i * p : (i + 1) * p] = a[i]
        A[:p, n * p + i * m : n * p + (i + 1) * m] = b[i]
    for i in range(1, n):
        A[i * p : (i + 1) * p, (i - 1) * p : i * p] = sympy.eye(p)
        A[n * p + i * m : n * p + (i + 1) * m, n * p + (i - 1) * m : n * p + i * m] = sympy.eye(m)
    B[n * p : n * p + m, :] = sympy.eye(m)
    return A, B


def estimate_of_past(b, a):
    """x^(k) as a matrix of the y(k-1), ..., y(k-n), u(k-1), ..., u(k-n): equations (26)-(28)."""
    n, (p, m) = len(a), b[0].shape
    window = sympy.zeros(n * p, n * (p + m))
    for row in range(n):  # x_row(k) = sum_{i >= row} a_i y(k - 1 - i + row) + b_i u(...)
        for i in range(row, n):
            j = i - row
            window[row * p : (row + 1) * p, j * p : (j + 1) * p] = a[i]
            window[row * p : (row + 1) * p, n * p + j * m : n * p + (j + 1) * m] = b[i]
    return window


@given(models(), st.integers(1, 4), st.sampled_from(WEIGHS), st.data())
def test_the_loop_in_past_signals_has_the_polynomial(model, horizon, weighs, data):
    """The polynomial comes from the difference equation by SymPy; up to the power of q."""
    b, a = model
    R = data.draw(st.sampled_from([1, "1/3", 10]))
    limit = ct.predictive_cost_compensator(model, horizon=horizon, Q=2, P=5, R=R, weighs=weighs)
    A, B = difference_equation(b, a)
    n, (p, m) = len(a), b[0].shape
    law = sympy.Matrix(limit.K) * estimate_of_past(b, a)
    if limit.K_u is not None:
        law[:, n * p : n * p + m] += sympy.Matrix(limit.K_u)
    loop = sympy.Poly((A + B * law).charpoly(q).as_expr(), q)
    exact = limit.characteristic_polynomial
    assert exact.degree() == limit.compensator.n + limit.model.n
    lower, upper = sorted((loop, exact), key=sympy.Poly.degree)
    assert (lower * sympy.Poly(q ** (upper.degree() - lower.degree()), q) - upper).is_zero
    assert limit.certificate.holds


@given(strictly_proper_plants("q"), st.integers(1, 6), st.sampled_from(WEIGHS))
def test_the_gain_minimises_the_cost_in_float64(G, horizon, weighs):
    """The oracle is a least squares problem over all controls at once."""
    if not G.denominator.degree():
        return
    limit = ct.predictive_cost_compensator(G, horizon=horizon, Q=2, P=5, R="1/2", weighs=weighs)
    A, B, C = (np.array(M.tolist(), dtype=float) for M in limit.model.matrices[:3])
    x, u_past = np.linspace(1, 2, len(A)), 0.7
    rows, constants = [], []
    reach, free = np.zeros((len(A), horizon)), x
    for j in range(horizon + 1):
        weight = np.sqrt(5 if j == horizon else 2)
        rows.append(weight * (C @ reach)[0])
        constants.append(weight * (C @ free)[0])
        if j < horizon:
            free, reach = A @ free, A @ reach
            reach[:, j] += B[:, 0]
    for j in range(horizon):
        row = np.eye(horizon)[j]
        if weighs == "moves" and j:
            row = row - np.eye(horizon)[j - 1]
        rows.append(np.sqrt(0.5) * row)
        constants.append(-np.sqrt(0.5) * u_past if weighs == "moves" and not j else 0.0)
    u = scipy.linalg.lstsq(np.array(rows), -np.array(constants))[0]
    law = (np.array(limit.K.tolist(), dtype=float) @ x)[0]
    if limit.K_u is not None:
        law += float(limit.K_u[0, 0]) * u_past
    condition = np.linalg.cond(np.array(rows))
    size = np.linalg.norm(constants)
    assert abs(law - u[0]) <= 1e-13 * condition**2 * (1 + size)


def test_symbols_for_every_model_and_gain_of_order_three():
    names = "b1 b2 b3 a1 a2 a3 k1 k2 k3"
    b1, b2, b3, a1, a2, a3, k1, k2, k3 = sympy.symbols(names)
    limit = ct.predictive_cost_compensator(([b1, b2, b3], [a1, a2, a3]), [[k1, k2, k3]])
    G = (b1 * q**2 + b2 * q + b3) / (q**3 - a1 * q**2 - a2 * q - a3)
    G_c = limit.transfer_function
    loop = G.as_numer_denom()[1] * G_c.denominator.as_expr()
    loop -= G.as_numer_denom()[0] * G_c.numerator.as_expr()
    chi = (q * sympy.eye(3) - sympy.Matrix(limit.model.A)
           - sympy.Matrix(limit.model.B) * sympy.Matrix([[k1, k2, k3]])).det()  # fmt: skip
    assert sympy.expand(loop - q**3 * chi) == 0
    assert limit.certificate.holds


def test_a_wrong_gain_has_no_certificate():
    limit = ct.predictive_cost_compensator("1/(q - 2)", horizon=3, weighs="u")
    wrong = ct.results.PredictiveCostCompensator(
        limit.model, limit.K, None, limit.regulator, (2 * limit.gains[0], *limit.gains[1:]),
        limit.Q, limit.P, limit.R,
    )  # fmt: skip
    other = ct.results.PredictiveCostCompensator(limit.model, 2 * limit.K, None, limit.regulator)
    assert limit.is_verified and not wrong.is_verified and not other.is_verified


@pytest.mark.parametrize(
    ("arguments", "options", "kind", "words"),
    [
        (("1/(q - 2)",), {}, InputError, "the gain K or the horizon"),
        (("1/(q - 2)", [[1]]), {"horizon": 2}, InputError, "not both"),
        (("1/(q - 2)", [[1, 2, 3]]), {}, InputError, "1 x 1 is needed"),
        (("1/(s - 2)",), {"horizon": 2}, InputError, "continuous time"),
        (("q/(q - 2)",), {"horizon": 2}, ImproperError, "feedthrough"),
        (("1/(q - 2)",), {"horizon": 0}, InputError, "at least 1"),
        (("1/(q - 2)",), {"horizon": 2, "R": 0}, InputError, "positive definite"),
        (("1/(q - 2)",), {"horizon": 2, "Q": -1}, InputError, "positive semidefinite"),
        (("1/(q - 2)",), {"horizon": 2, "Q": [[1, 0], [0, 1]]}, InputError, "1 x 1 is needed"),
        (("1/(q - 2)",), {"horizon": 2, "weighs": "y"}, InputError, "'moves' or 'u'"),
        ((([1, 2], [1]),), {"horizon": 2}, InputError, "equal number"),
        ((([], []),), {"horizon": 2}, InputError, "at least one"),
        ((([[[1, 2]], [[1]]], [1, 2]),), {"horizon": 2}, InputError, "b_2 is 1 x 1"),
        ((("b", [1]),), {"horizon": 2}, InputError, "must be a list"),
        (("1/(q - 2)",), {"horizon": 10**7}, CompensatorError, "the limit is"),
    ],
)
def test_bad_input(arguments, options, kind, words):
    with pytest.raises(kind, match=words):
        ct.predictive_cost_compensator(*arguments, **options)
