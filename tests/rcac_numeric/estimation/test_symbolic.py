"""A SymPy model in the kernel says what SymPy itself says."""

import math
import pickle

import numpy as np
import pytest
import sympy
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st

from rcac_numeric.estimation import EKF, UKF, SymbolicModel, estimate, observability
from rcac_numeric.estimation._compiled import NAMES, NoTapeError, tape

X, Y, U, K = sympy.symbols("x y u k")
UNARY = [
    sympy.sin, sympy.cos, sympy.tanh, sympy.atan, sympy.Abs, sympy.sign,
    lambda e: sympy.exp(-(e**2)), lambda e: sympy.log(2 + e**2), lambda e: sympy.sqrt(1 + e**2),
    lambda e: 1 / (3 + e**2), lambda e: e**3, lambda e: sympy.asin(e / (4 + e**2)),
    lambda e: sympy.acos(e / (4 + e**2)), lambda e: sympy.sinh(sympy.sin(e)), lambda e: -e,
    lambda e: sympy.cosh(sympy.cos(e)), lambda e: sympy.tan(sympy.sin(e)),
    lambda e: (2 + sympy.sin(e)) ** sympy.Rational(-5, 3),
]  # fmt: skip
BINARY = [
    lambda a, b: a + b, lambda a, b: a - b, lambda a, b: a * b, lambda a, b: a / (2 + b**2),
    sympy.Min, sympy.Max, lambda a, b: sympy.atan2(a, 2 + b**2),
]  # fmt: skip
leaves = st.sampled_from(
    [X, Y, U, K, sympy.Integer(2), sympy.Rational(-1, 3), sympy.pi, sympy.Float(0.1)]
)
expressions = st.recursive(
    leaves,
    lambda inner: st.one_of(
        st.builds(lambda f, a: f(a), st.sampled_from(UNARY), inner),
        st.builds(lambda f, a, b: f(a, b), st.sampled_from(BINARY), inner, inner),
    ),
    max_leaves=4,
)


few = settings(max_examples=10, suppress_health_check=[HealthCheck.too_slow])


def run(program, values):
    """A tape in plain Python: the oracle of what its steps mean."""
    operations = [
        lambda a, b: a + b, lambda a, b: a - b, lambda a, b: a * b, lambda a, b: a / b,
        lambda a, b: a**b, lambda a, b: -a, *(
            (lambda a, b, f=f: f(a)) for f in (
                math.sqrt, math.exp, math.log, math.sin, math.cos, math.tan, math.asin, math.acos,
                math.atan)
        ), math.atan2, *((lambda a, b, f=f: f(a)) for f in (math.sinh, math.cosh, math.tanh, abs)),
        lambda a, b: float(np.sign(a)), min, max,
    ]  # fmt: skip
    assert len(operations) == len(NAMES)
    constants, steps, results = program
    registers = [*constants, *values]
    for operation, a, b in steps:
        registers.append(operations[operation](registers[a], registers[b]))
    return [registers[i] for i in results]


@few
@example(formulas=[sympy.Abs(sympy.exp(-(X**2)))])  # of parts of x, where x may be complex
@given(formulas=st.lists(expressions, min_size=1, max_size=3))
def test_a_tape_is_its_formulas(formulas):
    formulas = [sympy.sympify(f) for f in formulas]
    assume(not any(f.has(sympy.I) for f in formulas))  # SymPy writes some atan2 with logarithms
    values = {X: 0.7, Y: -1.3, U: 0.4, K: 3.0}
    outcome = run(tape(formulas, [X, Y, U, K]), values.values())
    exact = np.array([complex(sympy.N(f.subs(values), 30)) for f in formulas])
    assert np.abs(exact.imag).max() < 1e-20  # of those logarithms, once values are in
    assert np.allclose(outcome, exact.real, rtol=1e-12, atol=1e-12)


@pytest.mark.costly
@few
@given(first=expressions, second=expressions)
def test_the_kernel_runs_the_tape(first, second):
    """Two steps of the filter: f in the first, f of f in the second."""
    first, second = (e + X / 2 for e in (sympy.sin(first), sympy.cos(second)))
    model = SymbolicModel([first, second], [X, Y], [X, Y], [U], step=K)
    f = model.function(model.f)
    x = np.array([0.3, -0.8])
    u = np.array([[0.2], [0.5], [-0.1]])
    expected = [x]
    for k in range(2):
        expected.append(np.ravel(f(k, expected[-1], u[k])))
    # P(0) = 0 and Q = 0: what was known exactly stays so, whatever is measured.
    estimates = estimate(UKF(model, Q=0, R=1, x_0=x, P_0=0), np.zeros((3, 2)), u)
    assert np.allclose(estimates.x, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("kind", [EKF, UKF])
def test_what_the_kernel_does_not_know_runs_in_python(kind):
    bent = sympy.Piecewise((X / 2, X > 0), (X / 3, True))
    with pytest.raises(NoTapeError):
        tape([bent], [X])
    smooth = SymbolicModel([X / 2 + U], [X], [X], [U])
    piecewise = SymbolicModel([sympy.Piecewise((X / 2, X > -100), (X, True)) + U], [X], [X], [U])
    y, u = np.sin(np.arange(20.0)), np.cos(np.arange(20.0))
    one, other = (estimate(kind(m, Q=0.1, R=0.1), y, u) for m in (smooth, piecewise))
    assert np.allclose(one.x, other.x, rtol=1e-14)


def test_derivatives_are_real_and_hold_almost_everywhere():
    """SymPy differentiates |x| of a complex x, and makes Dirac's delta of sign x."""
    bent = SymbolicModel([abs(X) + sympy.Max(X, 2) + sympy.sign(X) + U], [X], [X], [U])
    F = sympy.lambdify(X, bent.F[0])
    assert [F(v) for v in (-3.0, 1.0, 5.0)] == [-1, 1, 2]
    estimates = estimate(EKF(bent, Q=0.1, R=0.1), np.ones(5), np.ones(5))
    assert np.isfinite(estimates.x).all()


def test_the_step_may_stand_in_the_model():
    model = SymbolicModel([X + K], [X], [X], step=K)
    estimates = estimate(EKF(model, Q=0, R=1, P_0=0), np.zeros(6))
    assert np.array_equal(estimates.x[:, 0], [0, 0, 1, 3, 6, 10])


def test_parameters_are_the_last_entries_of_the_state():
    model = SymbolicModel([Y * X], [X], [X], parameters=[Y])
    assert model.names == ("x", "y") and sympy.Matrix([[Y, X], [0, 1]]) == model.F
    assert pickle.loads(pickle.dumps(model)) == model
    assert not observability(model, x=[[1, 0.5]] * 5).unseen
