"""Transfer functions with one dead time: reading, algebra, values, Pade approximants."""

import cmath
from itertools import pairwise

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import pade as scipy_pade
from scipy.special import factorial
from sympy.physics.control import TransferFunction as SympyTransferFunction

import compensator_theory as exact
from compensator_theory import DelayedTransferFunction, InputError, transfer_function
from compensator_theory.interpolation import pade_approximant
from compensator_theory.strategies import strictly_proper_plants

s, theta = sympy.symbols("s theta")
DELAYS = st.sampled_from([1, 3, sympy.Rational(1, 2), sympy.Rational(7, 3)])
DELAYED = st.builds(DelayedTransferFunction, strictly_proper_plants(max_order=3), DELAYS)


@pytest.mark.parametrize(
    ("written", "rational", "delay"),
    [
        ("2*exp(-3*s)/(10*s + 1)", "2/(10*s + 1)", 3),
        ("10/(s+1)*exp(-s/2)", "10/(s + 1)", "1/2"),
        ("10/(s+1)*exp(-0.1*s)", "10/(s + 1)", "1/10"),
        ("1/(exp(2*s)*(s + 1))", "1/(s + 1)", 2),
        ("(s + 2)*exp(-s)/((s + 2)*(s + 1))", "(s + 2)/((s + 2)*(s + 1))", 1),
        ("exp(-s)/(s + 1) + 2*exp(-s)/(s + 2)", "1/(s + 1) + 2/(s + 2)", 1),
        ("exp(-s)*exp(-2*s)/(s + 1)", "1/(s + 1)", 3),
        ("exp(-s)**2/(s + 1)", "1/(s + 1)", 2),
        ("exp(-2*s - 1)/(s + 1)", "exp(-1)/(s + 1)", 2),
        (2 * sympy.exp(-3 * s) / (10 * s + 1), "2/(10*s + 1)", 3),
        (("2*exp(-3*s)", "10*s + 1"), "2/(10*s + 1)", 3),
        ((2, sympy.exp(3 * s) * (10 * s + 1)), "2/(10*s + 1)", 3),
        (
            SympyTransferFunction(2 * sympy.exp(-3 * s), 10 * s + 1, s),
            "2/(10*s + 1)", 3,
        ),
    ],
)  # fmt: skip
def test_what_is_read(written, rational, delay):
    G = transfer_function(written)
    assert DelayedTransferFunction(transfer_function(rational), delay) == G
    assert transfer_function(G) is G


def test_symbols_and_a_named_variable():
    G = transfer_function("k*exp(-theta*s)/(s + a)")
    assert G.delay == theta and G.rational == transfer_function("k/(s + a)")
    assert G.subs({"theta": 2, "k": 1}) == transfer_function("exp(-2*s)/(s + a)")
    p = transfer_function("exp(-2*p)/(p + z)", "p")
    assert p.variable == sympy.Symbol("p") and p.delay == 2


def test_exponentials_that_cancel_are_no_dead_time():
    assert transfer_function("exp(-s)*exp(s)/(s + 1)") == transfer_function("1/(s + 1)")
    assert transfer_function("exp(-a)/(s + 1)").subs("a", 0) == transfer_function("1/(s + 1)")


@pytest.mark.parametrize(
    ("written", "word"),
    [
        ("exp(-s)/(s + 1) + exp(-2*s)", "1 s and 2 s"),
        ("exp(-s) + 1/(s + 1)", "0 s and 1 s"),
        ("1/(s + exp(-s))", "feedback"),
        ("exp(s)/(s + 1)", "predicts"),
        ("exp(-z)/(z + 1)", "z\\*\\*-d"),
        ("exp(-s**2)/(s + 1)", "no dead time"),
        ("exp(-s/(s + 1))/(s + 1)", "no dead time"),
        ("exp(-sqrt(2)*s)/(s + 1)", "irrational"),
    ],
)
def test_refused_by_name(written, word):
    with pytest.raises(InputError, match=word):
        transfer_function(written)


@pytest.mark.parametrize(
    "call",
    [
        lambda G: exact.root_locus(G, feedback=-1),
        lambda G: exact.place_poles(G, [-1], feedback=-1),
        lambda G: exact.stabilising_gains(G, feedback=-1),
        exact.realisation,
        lambda G: exact.transfer_matrix([[G, 1]]),
        lambda G: exact.feedback_connection(G, 1, feedback=-1),
        exact.h_infinity_norm,
    ],
)
@pytest.mark.parametrize("form", [str, transfer_function])
def test_other_functions_refuse_it_and_name_pade(call, form):
    with pytest.raises(InputError, match="pade"):
        call(form("2*exp(-3*s)/(10*s + 1)"))


@given(DELAYED)
def test_its_text_reads_back(G):
    assert transfer_function(str(G), "s") == G
    assert eval(repr(G), {"transfer_function": transfer_function}) == G
    assert transfer_function(sympy.sympify(G), "s").delay == G.delay


@pytest.mark.costly
@given(DELAYED, DELAYED, strictly_proper_plants(max_order=2))
def test_values_of_products_sums_and_powers(G, H, R):
    point = sympy.Rational(1, 3) + 2 * sympy.I
    g, h, r = (complex(X(point)) for X in (G, H, R))
    assert g == pytest.approx(
        complex(G.rational(point)) * cmath.exp(-float(G.delay) * complex(point))
    )
    same = DelayedTransferFunction(H.rational, G.delay)
    pairs = [(G * H, g * h), (G * R, g * r), (R * G, g * r), (-G, -g), (G**2, g**2), (3 * G, 3 * g),
             (G + same, g + complex(same(point))), (G - same, g - complex(same(point))),
             (sum([G, same]), g + complex(same(point)))]  # fmt: skip
    if not same.rational.numerator.is_zero:
        pairs += [(G / same, g / complex(same(point)))]
    for X, value in pairs:
        assert complex(X(point)) == pytest.approx(value, rel=1e-9, abs=1e-12)
    assert (G * H).delay == G.delay + H.delay


@pytest.mark.parametrize(
    "operation",
    [lambda G: G + 1, lambda G: 1 - G, lambda G: 1 / G, lambda G: G**-1, lambda G: G / G**2,
     lambda G: G + G * G],
)  # fmt: skip
def test_what_has_no_dead_time_of_its_own_is_refused(operation):
    with pytest.raises(InputError):
        operation(transfer_function("2*exp(-3*s)/(10*s + 1)"))


def test_operands_of_other_kinds():
    G = transfer_function("exp(-s)/s")
    for operand in (object(), [1, 2], None):
        with pytest.raises(TypeError):
            G * operand
        with pytest.raises(TypeError):
            G + operand


@pytest.mark.parametrize("m", range(4))
@pytest.mark.parametrize("n", range(1, 5))
def test_pade_of_any_degrees(m, n):
    """By the linear equations of the series, and by SciPy's."""
    D = transfer_function("exp(-3*s)")
    G = D.pade(n, numerator=m)
    series = [sympy.Rational((-3) ** k, sympy.factorial(k)) for k in range(m + n + 1)]
    assert pade_approximant(series, m, n).approximant == G
    assert G.certificate.holds
    p, q = scipy_pade([float((-3.0) ** k / factorial(k)) for k in range(m + n + 1)], n, m)
    point = 0.3 + 0.4j
    assert complex(G("0.3 + 0.4j")) == pytest.approx(p(point) / q(point), rel=1e-6)


def test_pade_with_symbols_and_its_error():
    G = transfer_function("exp(-theta*s)/(s + a)").pade(2)
    assert G.subs({"theta": 3, "a": 1}) == transfer_function("exp(-3*s)/(s + 1)").pade(2)
    errors = [
        abs(complex(transfer_function("exp(-s)").pade(n)("1j")) - np.exp(-1j)) for n in (1, 2, 3, 4)
    ]
    assert all(b < a / 20 for a, b in pairwise(errors))
    # all-pass
    assert abs(complex(transfer_function("exp(-s)").pade(3)("5j"))) == pytest.approx(1)


@pytest.mark.parametrize("arguments", [(0,), (-1,), (1.5,), (True,), (2, -1), (10**7,)])
def test_degrees_that_are_none(arguments):
    with pytest.raises(InputError):
        transfer_function("exp(-s)/s").pade(*arguments)


@pytest.mark.parametrize(
    ("rational", "delay"),
    [("1/(z + 1)", 1), ("1/(s + 1)", 0), ("1/(s + 1)", -1), ("1/(s + 1)", "s"),
     ("1/(s + 1)", "sqrt(2)"), ("1/(s + 1)", float("nan"))],
)  # fmt: skip
def test_fields_that_are_none(rational, delay):
    with pytest.raises(InputError):
        DelayedTransferFunction(transfer_function(rational), delay)


def test_a_sample_time_is_refused():
    with pytest.raises(InputError):
        transfer_function("exp(-s)/s", sample_time=1)
