"""Polynomials over different irrational fields, with large rational parts, at the doors.

SymPy's own conversion between such fields raises CoercionFailed for most of these.
"""

import pytest
import sympy
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st

import compensator_theory as ct

surds = st.builds(
    "{}e{}*{}".format,
    st.integers(1, 9),
    st.integers(-20, 30),
    st.sampled_from(["sqrt(2)", "sqrt(3)", "10**(3/4)"]),
)
same_field = st.builds(
    "{}e{}*10**({}/8)".format, st.integers(1, 9), st.integers(-4, 15), st.sampled_from([2, 3, 6])
)
few = settings(max_examples=8, phases=set(Phase) - {Phase.shrink, Phase.explain})  # seconds
POINT = sympy.Rational(7, 5)


def value(G):
    """The value at one point to 60 digits."""
    return (G.numerator.as_expr() / G.denominator.as_expr()).subs(G.variable, POINT).evalf(60)


def near(number, expected):
    return abs(number - expected) <= 1e-40 * abs(expected)


@pytest.mark.costly
@few
@given(gains=st.tuples(surds, surds) | st.tuples(same_field, same_field))
def test_loops_of_two_fields_have_their_own_values(gains):
    g, h = gains
    G, H = ct.transfer_function(f"1/(s + {g})"), ct.transfer_function(f"{h}/(s + 1)")
    along, back = value(G), value(H)
    assert near(value(ct.feedback_connection(G, H, feedback=-1)), along / (1 + along * back))
    assert near(value(ct.sensitivity_function(G, H, feedback=-1)), 1 / (1 + along * back))
    assert near(value(G * H), along * back) and near(value(G + H), along + back)
    square = ct.transfer_matrix([[G, H], [H, G]])
    result = (square @ square).reduced()
    corner = result.numerators[0][0].as_expr() / result.denominator.as_expr()
    assert near(corner.subs(G.variable, POINT).evalf(60), along**2 + back**2)


@pytest.mark.costly
@few
@given(gain=same_field, pole=same_field)
def test_a_loop_is_placed_over_another_field(gain, pole):
    assert ct.place_poles(f"{gain}/s", [f"-{pole}"] * 2, feedback=-1).residual.is_zero


@pytest.mark.slow
@few
@example(a="3e0*10**(6/8)", b="2e18*10**(3/8)")
@given(a=same_field, b=same_field)
def test_equations_of_two_fields_are_solved(a, b):
    with ct.budget(digits=10**5):
        assert ct.bezout_identity(f"s**2 + {a}", f"s + {b}").residual.is_zero
        assert ct.solve_diophantine(f"s**2 + {a}", f"s + {b}", "s**3 + 1").certificate.holds


def test_gains_over_irrational_coefficients_are_refused():
    with pytest.raises(ct.InputError, match=r"irrational number sqrt\(2\).*rational number close"):
        ct.stabilising_gains("1/(s*(s + sqrt(2)))", feedback=-1)
