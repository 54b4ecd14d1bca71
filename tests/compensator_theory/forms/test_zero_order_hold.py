"""Sampling with a zero-order hold against SciPy, the semigroup of time, and printed zeros."""

import math

import numpy as np
import pytest
import scipy.signal
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st
from sympy import Matrix, Rational, Symbol, log

import compensator_theory as exact
from compensator_theory import Realisation, polynomial
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.sampling import (
    first_order_hold,
    matched,
    sampling_zero_polynomial,
    tustin,
    zero_order_hold,
)
from compensator_theory.strategies import matrices
from compensator_theory.strategies.plants import unimodular_matrices
from tests.support.structure_cases import fewer

h, x, a = sympy.symbols("h x a")


@st.composite
def plants(draw):
    """State spaces with rational poles, some of them multiple and some not."""
    n, m = draw(st.integers(1, 3)), draw(st.integers(1, 2))
    A = Matrix(n, n, lambda i, j: 1 if j in (i + 1, i + 3) else 0)
    for i in range(n):
        A[i, i] = draw(st.sampled_from([0, -1, -2, Rational(-1, 2), 1]))
    S = Matrix(draw(unimodular_matrices(n)))
    A = S * A * S.inv()
    return Realisation(A, draw(matrices(n, m)), draw(matrices(1, n)), draw(matrices(1, m)))


def numbers(matrix, values):
    value = matrix.subs(values).evalf(30)
    return np.array(value.tolist(), dtype=float).reshape(matrix.shape)


@pytest.mark.cases(12)
@pytest.mark.parametrize("sample", [zero_order_hold, first_order_hold])
@pytest.mark.parametrize("h", [sympy.pi / 2, sympy.pi, 3 * sympy.pi / 2, 2 * sympy.pi])
@pytest.mark.parametrize(
    "plant",
    [
        "(s + 3)/(s**2 + 1)",
        "1/((s**2 + 1)*(s**2 + 9))",
        "1/((s + 1)*((s + 1/2)**2 + 4))",
        "s/((s**2 + 4)*(s**2 + 1))",
    ],
)
def test_multiples_of_pi_as_the_step(sample, plant, h):
    if sample is first_order_hold:  # the slope of the line is over h
        with pytest.raises(InputError, match="leave the step a symbol"):
            sample(plant, h)
        return
    result = sample(plant, h)
    values = dict(result.exponentials)
    assert all(value.has(sympy.exp) for value in values.values())  # no tangent is left
    plant = exact.realisation(plant)
    source = [numbers(part, {}) for part in (plant.A, plant.B, plant.C, plant.D)]
    theirs = scipy.signal.cont2discrete(source, float(h), "zoh")
    for one, other in zip((result.realisation.A, result.realisation.B), theirs[:2], strict=True):
        np.testing.assert_allclose(numbers(one, values), other, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    ("plant", "step"),
    [
        ("1/(s**2 + 1)", sympy.pi / 3),  # sqrt(3)
        ("1/(s**2 + 2)", sympy.pi),  # tan(pi/sqrt(2))
        ("1/(s*(s**2 + 1))", sympy.pi),  # the step itself
        ("1/((s**2 - 2)*(s + 1))", sympy.pi),  # exp(pi) and exp(sqrt(2) pi)
        ("1/(s**2 + 1)", -sympy.pi),
        ("1/(s**2 + 1)", sympy.sqrt(2)),
        ("1/(s**2 + 1)", sympy.pi**2),
        ("1/(s**2 + 1)", sympy.pi + 1),
    ],
)
def test_steps_that_are_refused(plant, step):
    with pytest.raises(InputError):
        zero_order_hold(plant, step)


@fewer(2)
@given(plants(), st.sampled_from([Rational(1, 10), Rational(1), Rational(7, 3)]))
def test_scipy_agrees(plant, step):
    sampled = zero_order_hold(plant, step)
    values = dict(sampled.exponentials)
    mine = [numbers(part, values) for part in (sampled.realisation.A, sampled.realisation.B)]
    source = [numbers(part, {}) for part in (plant.A, plant.B, plant.C, plant.D)]
    theirs = scipy.signal.cont2discrete(source, float(step), "zoh")
    for one, other in zip(mine, theirs[:2], strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9)
    assert sampled.realisation.C == plant.C and sampled.realisation.D == plant.D


@fewer(2)
@given(plants())
def test_two_steps_are_one_of_twice_the_length(plant):
    """x_(k+2) of a held input: A_d(2h) = A_d(h)**2 and B_d(2h) = (A_d + I) B_d, as polynomials."""
    sampled = zero_order_hold(plant).realisation
    doubled = {h: 2 * h, x: x**2}
    twice_a, twice_b = (part.subs(doubled, simultaneous=True) for part in (sampled.A, sampled.B))
    identity = sympy.eye(plant.n)
    assert (twice_a - sampled.A**2).applyfunc(sympy.cancel).is_zero_matrix
    assert (twice_b - (sampled.A + identity) * sampled.B).applyfunc(sympy.cancel).is_zero_matrix


@fewer(2)
@given(plants())
def test_the_poles_are_exponentials(plant):
    sampled = zero_order_hold(plant)
    poles = sympy.roots(plant.characteristic_polynomial.as_expr(), Symbol("s"))
    values = {h: 1, **{symbol: value.subs(h, 1) for symbol, value in sampled.exponentials}}
    at_one = sampled.realisation.characteristic_polynomial.as_expr().subs(values)
    for pole, multiplicity in poles.items():
        for k in range(multiplicity):
            value = sympy.diff(at_one, Symbol("z"), k).subs(Symbol("z"), sympy.exp(pole))
            assert abs(float(value.evalf(40))) < 1e-20


@st.composite
def oscillating_plants(draw):
    """Companions of quadratic factors: complex, irrational, repeated, commensurate or neither."""
    quadratics = [
        "s**2 + 1",
        "s**2 + 4",
        "s**2 - 2",
        "s**2 + 2*s + 3",
        "s**2 + s + 1",
        "s + 1",
        "s",
    ]
    factors = draw(st.lists(st.sampled_from(quadratics), min_size=1, max_size=2))
    p = polynomial("*".join(f"({f})" for f in factors), "s")
    n = int(p.degree())
    C = draw(matrices(1, n))
    return Realisation(exact.realisation(f"1/({p.as_expr()})").A, [[0]] * (n - 1) + [[1]], C, [[0]])


@fewer(2)
@given(oscillating_plants(), st.sampled_from([Rational(1, 10), Rational(1), Rational(7, 3)]))
def test_scipy_agrees_on_complex_and_irrational_poles(plant, step):
    sampled = zero_order_hold(plant, step)
    assert sampled.certificate.holds
    values = dict(sampled.exponentials)
    mine = [numbers(part, values) for part in (sampled.realisation.A, sampled.realisation.B)]
    source = [numbers(part, {}) for part in (plant.A, plant.B, plant.C, plant.D)]
    theirs = scipy.signal.cont2discrete(source, float(step), "zoh")
    for one, other in zip(mine, theirs[:2], strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(("function", "name"), [(first_order_hold, "foh"), (tustin, "tustin")])
@fewer(2)
@given(plants() | oscillating_plants(), st.sampled_from([Rational(1, 10), Rational(1)]))
def test_other_rules_against_scipy(function, name, plant, step):
    """The transfer functions: SciPy's realisation of Tustin's rule has another basis."""
    try:
        result = function(plant, step)
    except NoSolutionError:  # 2/h is a pole
        assert function is tustin and (sympy.eye(plant.n) - plant.A * step / 2).det() == 0
        return
    assert result.certificate.holds
    values = dict(result.exponentials)
    S = result.realisation
    A, B, C, D = (numbers(part, values) for part in (S.A, S.B, S.C, S.D))
    source = [numbers(part, {}) for part in (plant.A, plant.B, plant.C, plant.D)]
    a, b, c, d, _ = scipy.signal.cont2discrete(source, float(step), name)
    for z in (2.5 + 0.5j, -3.0, 7j):
        mine = C @ np.linalg.solve(z * np.eye(plant.n) - A, B) + D
        theirs = c @ np.linalg.solve(z * np.eye(plant.n) - a, b) + d
        np.testing.assert_allclose(mine, theirs, rtol=1e-8, atol=1e-8)


ROOTS = st.lists(
    st.one_of(
        st.sampled_from([-3, -1, 0, Rational(-1, 2), Rational(1, 3)]).map(lambda p: (p,)),
        st.tuples(st.sampled_from([-1, 0]), st.integers(1, 2)).map(
            lambda c: (c[0] + sympy.I * c[1], c[0] - sympy.I * c[1])
        ),
    ),
    max_size=2,
).map(lambda groups: [root for group in groups for root in group])


@fewer(4)
@given(ROOTS, ROOTS, st.sampled_from([Rational(1, 10), Rational(2, 3)]))
def test_matched_poles_and_zeros_are_exponentials(zeros, poles, step):
    """And what the plant does at rest is kept: s^i G(s) at 0, ((z - 1)/h)^i G_d(z) at 1."""
    assume(len(zeros) <= len(poles) and poles and not set(zeros) & set(poles))
    s = Symbol("s")
    N, D = (sympy.expand(sympy.prod(s - r for r in roots)) for roots in (zeros, poles))
    sampled = matched(2 * N / D, step)
    values = dict(sampled.exponentials)
    G = sampled.transfer_function
    numerator, denominator = (
        np.array([complex(sympy.sympify(c).subs(values).evalf(30)) for c in p.all_coeffs()])
        for p in (G.numerator, G.denominator)
    )
    at_infinity = max(len(poles) - len(zeros) - 1, 0)
    expected = (
        [sympy.exp(r * step) for r in zeros] + [-1] * at_infinity,
        [sympy.exp(r * step) for r in poles],
    )
    for factor, roots in zip((numerator / numerator[0], denominator), expected, strict=True):
        assert np.allclose(factor, np.poly([complex(r) for r in roots]), rtol=1e-9, atol=1e-9)
    order = poles.count(0) - zeros.count(0)
    at_rest = complex(sympy.limit(2 * s**order * N / D, s, 0))
    for p in (numerator, denominator):
        assert np.allclose(p.imag, 0, atol=1e-12)
    n, d = numerator, denominator
    for _ in range(zeros.count(0)):
        n = np.polydiv(n, [1, -1])[0]
    for _ in range(poles.count(0)):
        d = np.polydiv(d, [1, -1])[0]
    there = np.polyval(n, 1) / np.polyval(d, 1) / float(step) ** order
    assert np.isclose(there, at_rest, rtol=1e-7)


def test_the_rules_of_integrators():
    """h (z + 1)/(2 (z - 1)) is both the line's and Tustin's."""
    expected = exact.transfer_function("h*(z + 1)/(2*(z - 1))", "z")
    assert first_order_hold("1/s").transfer_function == expected
    assert tustin("1/s").transfer_function == expected
    double = first_order_hold("1/s**2").transfer_function
    assert double == exact.transfer_function("h**2*(z**2 + 4*z + 1)/(6*(z - 1)**2)", "z")
    with pytest.raises(exact.CompensatorError, match="another step"):
        tustin("1/(s - 2)", 1)
    with pytest.raises(exact.CompensatorError, match="rational number or a symbol"):
        tustin("1/(s + 2)", log(2))


def test_oscillators_of_the_textbooks():
    """(1 - c)(z + 1)/(z**2 - 2 c z + 1), and that of damping, with c = cos h, x = exp(-h)."""
    z, y = sympy.symbols("z y")
    c, s = (1 - y**2) / (1 + y**2), 2 * y / (1 + y**2)
    sampled = zero_order_hold("1/(s**2 + 1)").transfer_function
    expected = (1 - c) * (z + 1) / (z**2 - 2 * c * z + 1)
    assert sympy.cancel(sampled.numerator.as_expr() / sampled.denominator.as_expr() - expected) == 0
    damped = zero_order_hold("1/((s + 1)**2 + 1)").transfer_function
    expected = ((1 - x * c - x * s) * z + x * (x + s - c)) / (2 * (z**2 - 2 * x * c * z + x**2))
    assert sympy.cancel(damped.numerator.as_expr() / damped.denominator.as_expr() - expected) == 0


def test_frequencies_with_rational_ratios_share_one_symbol():
    sampled = zero_order_hold("1/((s**2 + 4/9)*(s**2 + 1))")
    ((_, value),) = sampled.exponentials
    assert value == 3 * sympy.tan(h / 6)
    assert len(zero_order_hold("1/((s**2 + 2)*(s**2 + 1))").exponentials) == 2
    irrational = zero_order_hold("1/(s**2 - 2)").exponentials
    assert irrational[0][1] == sympy.sqrt(2) * sympy.tanh(sympy.sqrt(2) * h / 2) / 2
    general = zero_order_hold("w**2/(s**2 + 2*d*w*s + w**2)", "h", variable="s")
    assert general.certificate.holds and len(general.exponentials) == 2


def test_the_examples_of_the_notes():
    sampled = zero_order_hold("1/((s + 1)*(s + 2))", log(2))
    expected = exact.transfer_function("(z + 1/2)/(8*(z - 1/2)*(z - 1/4))")
    assert sampled.transfer_function == expected and sampled.exponentials == ()
    third = zero_order_hold("1/s**3")
    expected = exact.transfer_function("h**3*(z**2 + 4*z + 1)/(6*(z - 1)**3)", "z")
    assert third.transfer_function == expected


@pytest.mark.parametrize("order", range(1, 6))
def test_sampling_zeros_of_integrators(order):
    """1/s**r has the Euler-Frobenius zeros at every step."""
    numerator = zero_order_hold(f"1/s**{order}").transfer_function.numerator
    assert exact.monic(numerator) == sampling_zero_polynomial(order)


def test_printed_sampling_zeros():
    """Astrom, Hagander and Sternby (1984), Table 1: the roots outside or on the unit circle."""
    printed = {2: ["-1.000"], 3: ["-3.732"], 4: ["-1.000", "-9.899"], 5: ["-2.322", "-23.20"]}
    for order, expected in printed.items():
        roots = exact.certified_roots(sampling_zero_polynomial(order))
        outside = sorted((r.value.real for r in roots if abs(r.value) > 0.999), reverse=True)
        assert [
            f"{value:.3f}"[: len(text)] for value, text in zip(outside, expected, strict=True)
        ] == expected


def test_a_short_step_brings_the_sampling_zero():
    sampled = zero_order_hold("(s + 1)/((s + 2)*(s + 3)*(s + 4)*(s + 5))", Rational(1, 1000))
    values = dict(sampled.exponentials)
    top = sampled.transfer_function.numerator
    zeros = np.roots([float(c.subs(values).evalf(60)) for c in top.all_coeffs()])
    assert abs(min(zeros.real) - (-2 - math.sqrt(3))) < 0.05


def test_relations_between_exponentials_are_kept():
    sampled = zero_order_hold("1/((s + 1/2)*(s + 1/3))")
    ((symbol, value),) = sampled.exponentials
    assert value == sympy.exp(-h / 6)
    poles = sampled.realisation.characteristic_polynomial
    assert poles == polynomial(f"(z - {symbol}**2)*(z - {symbol}**3)", "z")


def test_symbolic_poles():
    sampled = zero_order_hold("b/(s*(s + a))", "h", variable="s")
    assert sampled.exceptional == (a,) and sampled.certificate.holds
    ((symbol, value),) = sampled.exponentials
    assert value == sympy.exp(-a * h)
    at_two = zero_order_hold("3/(s*(s + 2))")
    special = sampled.realisation.B.subs({a: 2, symbol: x})
    assert (special - at_two.realisation.B).applyfunc(sympy.cancel).is_zero_matrix
    two = zero_order_hold("1/((s + a)*(s + b))", "h", variable="s")
    assert two.exceptional == (a, Symbol("b"), a - Symbol("b"))
    assert len(two.exponentials) == 2


def test_a_name_that_is_taken():
    sampled = zero_order_hold("x/(s + 1)", "h", variable="s")
    ((symbol, _),) = sampled.exponentials
    assert symbol.name == "x_" and sampled.realisation.C[0, 0] == x
    assert zero_order_hold("2", "h", variable="s").realisation.n == 0


@pytest.mark.parametrize(
    "call",
    [
        lambda: zero_order_hold("1/(s**3 - 2)"),
        lambda: zero_order_hold("1/(s**2 + 1)", log(2)),
        lambda: zero_order_hold("1/(s - 1/(a + 1))", "h", variable="s"),
        lambda: zero_order_hold("1/(z + 1)"),
        lambda: zero_order_hold("1/(s + 1)", 0),
        lambda: zero_order_hold("1/(s + 1)", -1),
        lambda: zero_order_hold("1/(s + 1)", "h*k"),
        lambda: zero_order_hold("1/(s + 1)", "sqrt(2)"),
        lambda: zero_order_hold("1/(s + 1)", float("inf")),
        lambda: zero_order_hold("1/(s + 1)**2", log(2)),
        lambda: zero_order_hold("1/(s + 1)", log(Rational(1, 2))),
        lambda: zero_order_hold("1/(s + h)", "h", variable="s"),
        lambda: zero_order_hold("1/(s + 1)", discrete_variable="s"),
        lambda: zero_order_hold("s"),
        lambda: zero_order_hold(None),
        lambda: zero_order_hold("1/((s + 1)*(s + 1000000007))"),
        lambda: matched("(s**3 - 2)/(s + 1)**4"),
        lambda: matched("0/(s + 1)"),
        lambda: matched([["1/s", "1/(s + 1)"]]),
        lambda: matched("1/(z + 1)"),
        lambda: matched("s**2/(s + 1)"),
        lambda: sampling_zero_polynomial(0),
        lambda: sampling_zero_polynomial(True),
        lambda: sampling_zero_polynomial(10**6),
    ],
)
def test_bad_input(call):
    with pytest.raises(exact.CompensatorError):
        call()
