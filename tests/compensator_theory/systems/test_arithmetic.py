"""Sums, products, powers and compositions of transfer functions, nothing cancelled."""

from fractions import Fraction

import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st
from sympy.physics.control import Feedback, Parallel, Series

import compensator_theory as ct
from compensator_theory.errors import BudgetError, ImproperError
from compensator_theory.strategies import polynomials, rationals

s, z, a, b = sympy.symbols("s z a b")
quotients = st.builds(
    ct.TransferFunction,
    polynomials(max_degree=3),
    polynomials(min_degree=1, max_degree=3, is_monic=True),
)
points = rationals().map(lambda p: p + sympy.Rational(1, 997))  # seldom a pole


def values(point, *functions):
    """The values there, of examples that have one."""
    assume(all(G.denominator.eval(point) != 0 for G in functions))
    return [G(point) for G in functions]


@given(quotients, quotients, points)
def test_values_add_and_multiply(G, H, point):
    at_g, at_h = values(point, G, H)
    assert (G + H)(point) == at_g + at_h
    assert (G - H)(point) == at_g - at_h
    assert (G * H)(point) == at_g * at_h
    assert (-G)(point) == -at_g
    if at_h != 0:
        assert (G / H)(point) == at_g / at_h
        assert (H**-2)(point) == at_h**-2


@given(quotients, quotients)
def test_nothing_cancels(G, H):
    assert (G * H).order == G.order + H.order
    assert (G + H).order == (G.order if G.denominator == H.denominator else G.order + H.order)
    difference = G - G
    assert difference.numerator.is_zero and difference.denominator == G.denominator
    if not G.numerator.is_zero:
        assert (G / G).numerator == (G / G).denominator
        assert (G / G).order == G.order + G.numerator.degree()


@given(quotients, quotients)
def test_the_operators_are_those_of_a_text(G, H):
    for sign, result in (("+", G + H), ("-", G - H), ("*", G * H)):
        assert ct.transfer_function(f"({G}) {sign} ({H})", "s") == result
    if not H.numerator.is_zero:
        assert ct.transfer_function(f"({G})/({H})", "s") == G / H
    assert ct.transfer_function(f"({G})**3", "s") == G**3


@pytest.mark.costly
@given(quotients, quotients, st.sampled_from([-1, 1]))
def test_connections_are_those_of_sympy(G, H, sign):
    """SymPy's control module as the oracle, compared as rational functions."""
    first, second = G.to_sympy(), H.to_sympy()

    def same(connection, expected):
        numerator, denominator = expected.num, expected.den
        return (
            sympy.expand(
                connection.numerator.as_expr() * denominator
                - numerator * connection.denominator.as_expr()
            )
            == 0
        )

    assert same(G + H, Parallel(first, second).doit())
    assert same(G * H, Series(first, second).doit())
    closed = G.denominator * H.denominator - sign * G.numerator * H.numerator
    assume(closed.degree() == G.order + H.order)
    loop = ct.feedback_connection(G, H, feedback=sign)
    assert same(loop, Feedback(first, second, sign).doit()) and loop.order == G.order + H.order


def test_frequency_response_is_that_of_python_control():
    G, H = ct.transfer_function("(s + 3)/(s**2 + s + 1)"), ct.transfer_function("2/(s + 4)")
    omega = np.logspace(-2, 2, 20)
    ours = (G * (1 - H) / (H + 2)).to_control()
    theirs = G.to_control() * (1 - H.to_control()) / (H.to_control() + 2)
    assert np.allclose(ours(1j * omega), theirs(1j * omega), rtol=1e-10)


def test_everything_that_is_a_quotient_may_stand_beside():
    G = ct.transfer_function("1/(s + 1)")
    expected = ct.transfer_function("(3*s + 5)/(2*s + 2)")
    for other in (1.5, Fraction(3, 2), sympy.Rational(3, 2), "3/2"):
        assert G + other == expected and other + G == expected
    assert (a * G, G * s, s / G) == (
        ct.TransferFunction(ct.polynomial("a", "s"), ct.polynomial("s + 1")),
        ct.transfer_function("s/(s + 1)"),
        ct.transfer_function("s**2 + s"),
    )
    assert G * ct.polynomial("s + 2") == ct.transfer_function("(s + 2)/(s + 1)")
    assert np.float64(2.0) * G == 2 * G and sum([G, G]) == 2 * G


def test_values():
    G = ct.transfer_function("(s + a)/(s**2 + 1)", "s")
    assert G(2) == (a + 2) / 5 and G("2j") == -(a + 2 * sympy.I) / 3
    assert ct.transfer_function("1/(z**2 - 2)")("sqrt(3)") == 1
    with pytest.raises(ct.InputError, match="a pole"):
        G("1j")
    with pytest.raises(ct.InputError, match=r"share; take \.reduced"):
        ct.transfer_function("(s + 1)/((s + 1)*s)")(-1)
    with pytest.raises(ct.InputError):
        G(float("nan"))


@given(quotients)
def test_compositions(G):
    tustin, back = (
        ct.transfer_function("2*(z - 1)/(z + 1)"),
        ct.transfer_function("(2 + s)/(2 - s)"),
    )
    assume(G.denominator.eval(2) != 0 or G.numerator.eval(2) != 0)  # 2 is mapped to infinity
    there = G.compose(tustin)
    assert there.variable == z
    assert max(there.order, there.numerator.degree()) == max(G.order, G.numerator.degree())
    assert there.compose(back).reduced() == G.reduced()
    assert G.compose(tustin)(3) == G(1) if G.denominator.eval(1) else True


def test_symbols_get_values():
    G = ct.transfer_function("(a*s + b)/(s + a/b)", "s")
    assert G.subs({a: b, "b": a}) == ct.transfer_function("(b*s + a)/(s + b/a)", "s")
    assert G.subs({"a": 1, "b": 2})(0) == 4
    with pytest.raises(ct.InputError, match="divides by zero there"):
        G.subs({"b": 0})
    with pytest.raises(ct.InputError, match="has no symbol c; its symbols: a, b"):
        G.subs("c", 0)
    with pytest.raises(ct.InputError, match=r"compose\(...\)"):
        G.subs({"s": 0})
    with pytest.raises(ct.InputError, match="contains s"):
        G.subs({"a": s})


def test_what_cannot_be_computed_is_refused_by_name():
    G = ct.transfer_function("1/(s + 1)")
    with pytest.raises(ct.InputError, match="both need one variable"):
        G + ct.transfer_function("1/(z + 1)")
    for other in ("1/(z + 1)", z, 1 / (z + 1)):
        with pytest.raises(ct.InputError, match="use one variable"):
            G + other
    assert str(G + "q*s") == "(q*s**2 + q*s + 1)/(s + 1)"  # q is a parameter there
    for operation in (lambda: G / 0, lambda: 1 / (0 * G), lambda: (0 * G) ** -1):
        with pytest.raises(ct.InputError, match="has no inverse"):
            operation()
    for other in (None, [1, 2], np.ones(2), {}):
        with pytest.raises(TypeError):
            G + other
        with pytest.raises(TypeError):
            other * G
    with pytest.raises(TypeError):
        G**0.5
    with pytest.raises(BudgetError):
        G**2000
    with pytest.raises(ct.InputError, match="denominator becomes zero"):
        G.compose(-1)


def square(D):
    """A realisation of two signals with the direct term D."""
    return ct.Realisation([[0, 1], [-2, "a"]], [[1, 0], [0, 1]], [[1, 0], [1, 1]], D)


@pytest.mark.parametrize(
    "combination", [lambda R: R, ct.Realisation.transfer_matrix], ids=["states", "map"]
)
def test_systems_of_several_signals_compute_as_matrices(combination):
    G, H = combination(square([[1, 0], [0, 2]])), combination(square([[1, 1], [0, 1]]))

    def at(system):
        whole = system.transfer_matrix() if isinstance(system, ct.Realisation) else system
        return whole.subs({"a": 5}).as_matrix().subs(s, 2)

    g, h = at(G), at(H)
    assert at(G * H) == g * h and at(G - H) == g - h
    assert at(2 * G) == at(G * 2) == 2 * g and at(G / "1/3") == 3 * g
    assert at(G / H) == g * h.inv() and at(G**3) == g**3 and at(G**-2) == g**-2
    assert at(G**1) == g and (G**0).subs({}) == G**0
    for wrong in (lambda: G / 0, lambda: G.subs("b", 1), lambda: G.subs({"s": 1})):
        with pytest.raises(ct.InputError):
            wrong()
    with pytest.raises(TypeError):
        G ** "2"


def test_what_has_no_inverse_is_refused():
    with pytest.raises(ImproperError, match="no inverse"):
        square([[0, 0], [0, 1]]) ** -1
    with pytest.raises(ct.InputError, match="not square"):
        ct.transfer_matrix([["1/s", 1]]) ** 2
