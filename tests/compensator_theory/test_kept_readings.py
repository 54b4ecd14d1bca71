"""Readings that are right where those of others are not, which a change of a door must keep."""

import pytest
import sympy
from sympy import CRootOf, GoldenRatio, I, Rational, Symbol, cos, pi, sin, sqrt

import compensator_theory as exact

x = Symbol("x")


@pytest.mark.parametrize(
    ("text", "value"),
    [("2i", 2 * I), ("0.8j", 4 * I / 5), ("I", I), ("1e-3", Rational(1, 1000)), ("2^3", 8),
     ("pi", pi), ("sqrt(8)", 2 * sqrt(2)), ("-1.5e2", -150)],
)  # fmt: skip
def test_numbers_in_a_text(text, value):
    assert exact.exact_number(text) == value


@pytest.mark.parametrize("name", ["E", "N", "S", "Q", "O", "e", "gamma", "beta", "zeta", "C", "re"])
def test_names_that_are_functions_elsewhere_are_symbols(name):
    assert exact.parse_expression(f"{name}*s + 1") == Symbol(name) * Symbol("s") + 1


@pytest.mark.parametrize(
    ("text", "words"),
    [("i*s", "ambiguous"), ("s/0", "divides by zero"), ("0/0", "divides"),
     ("nan", "finite"), ("1/(s - s)", "divides by zero"), ("sin(s)", "no rational function"),
     ("2 s", "spell products out")],
)  # fmt: skip
def test_refusals_that_name_what_is_wrong(text, words):
    with pytest.raises(exact.InputError, match=words):
        exact.transfer_function(text, "s")
    with pytest.raises(exact.InputError, match="lacks its conjugate"):
        exact.polynomial_from_roots(["1 + j"], "s")
    with pytest.raises(exact.InputError, match="not a number"):
        exact.polynomial([True, 1], "s")


@pytest.mark.parametrize(
    ("one", "other"),
    [(GoldenRatio, (1 + sqrt(5)) / 2), (sqrt(5 + 2 * sqrt(6)), sqrt(2) + sqrt(3)),
     (CRootOf(x**3 - 2, 0), 2 ** Rational(1, 3)), (sin(pi / 7), cos(5 * pi / 14))],
)  # fmt: skip
def test_algebraic_numbers_are_decided_and_not_compared_as_trees(one, other):
    s = Symbol("s")
    assert exact.bezout_identity(s + one, s + other, variable="s").gcd.degree() == 1
    assert exact.mcmillan_degree(1 / (s + one) - 1 / (s + other), "s") == 0


def test_symbols_of_one_name_are_one_or_refused():
    positive = Symbol("a", positive=True)
    G = exact.transfer_function(1 / (Symbol("s") + positive), "s")
    assert str(G) == "(1)/(s + a)"
    with pytest.raises(exact.InputError, match="different assumptions"):
        exact.polynomial([positive, "a"], "s")


def test_the_sign_of_feedback_is_always_asked():
    for door in (exact.stability_margins, exact.root_locus, exact.stabilising_gains):
        with pytest.raises(TypeError, match="feedback"):
            door("1/s")


def test_a_resultant_keeps_its_sign_in_both_orders():
    for a, b in (("x + 2", "x**3"), ("x**3", "x + 1"), ("x + 5", "x**3")):
        there, back = exact.resultant(a, b), exact.resultant(b, a)
        assert back == -there  # degrees 1 and 3
        assert there == sympy.prod(
            sympy.Poly(b, x).eval(root) for root in sympy.Poly(a, x).all_roots())  # fmt: skip
