"""Numbers and text become exact, and nothing in a text is ever executed."""

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

import compensator_theory as ct
import compensator_theory as exact
from compensator_theory.bezout import sylvester_m
from compensator_theory.loops import target_characteristic_polynomial
from compensator_theory.polynomials._expressions import read_text
from compensator_theory.polynomials._numbers import PLAIN
from compensator_theory.roots import reciprocal_polynomial, split_at_unit_circle


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_float_is_its_shortest_decimal_and_comes_back(x):
    exact = ct.exact_number(x)
    assert Fraction(int(exact.p), int(exact.q)) == Fraction(repr(x))
    assert int(exact.p) / int(exact.q) == x


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_binary_value_is_exact(x):
    exact = ct.exact_number(x, binary=True)
    assert Fraction(int(exact.p), int(exact.q)) == Fraction(x)


@given(st.fractions(), st.fractions())
def test_fractions_strings_and_decimals(p, q):
    assert ct.exact_number(p) == sympy.Rational(p.numerator, p.denominator)
    assert ct.exact_number(f"({p}) - ({q})*j") == ct.exact_number(p) - sympy.I * ct.exact_number(q)


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (True + 1, 2),
        (Decimal("0.10"), "1/10"),
        (np.float32(0.1), "1/10"),
        (np.int8(-3), -3),
        (np.array(0.3), "3/10"),
        (0.5 - 0.8j, "1/2 - 4*I/5"),
        (np.complex128(0.1 + 1j), "1/10 + I"),
        (sympy.Float(0.1), "1/10"),
        (0.1 * sympy.Symbol("a"), "a/10"),
        (".5e1", 5),
        ("2^3*a", "8*a"),
        ("-0.8j", "-4*I/5"),
        ("sqrt(8)", "2*sqrt(2)"),
    ],
)
def test_readable_values(value, expected):
    assert ct.exact_number(value) == sympy.sympify(expected)


@pytest.mark.parametrize(
    "value",
    [float("nan"), float("inf"), -np.inf, np.float32("nan"), Decimal("NaN"), Decimal("-Infinity"),
     sympy.nan, sympy.oo, sympy.zoo, complex("nan"), "nan", "-inf", "oo", "Infinity", True, None,
     object(), np.array([1, 2]), [1]],
)  # fmt: skip
def test_not_a_finite_number(value):
    with pytest.raises(ct.InputError):
        ct.exact_number(value)


@pytest.mark.parametrize(
    "text",
    ["__import__('os').system('true')", "().__class__", "a.b", "x[0]", "f(x)", "eval(1)", "a__b",
     "__a", "lambda: 1", "[1, 2]", "1, 2", "'s'", "1 if a else 2", "a < b", "a == b", "not a",
     "a // b", "a % b", "a @ b", "a := 1", "9**9**9", "s**1001", "((s + 1)**500)**500",
     "((s + 1)**900 + 1)*(s + 2)**900", "2**s", "1e99999999", "0x10", "1_000", "2s", "2(s + 1)", "",
     "   ", "1/0", "s/(2 - 2)", "0**-1", "(" * 500, "1" * 30000, "i", "s;1",
     "sqrt(1, 2)", "sqrt(x=2)", "\x00", "True", "yield", "s\n)"],
)  # fmt: skip
def test_refused_text(text):
    with pytest.raises(ct.InputError):
        ct.parse_expression(text)


@pytest.mark.costly
@given(st.text(max_size=40))
def test_arbitrary_text_is_read_or_refused(text):
    try:
        ct.parse_expression(text)
    except ct.InputError as error:
        assert str(error)


def test_sides_of_a_quotient_are_not_cancelled():
    s = sympy.Symbol("s")
    assert read_text("(s + 1)/((s + 1)*(s + 2))").sides() == (s + 1, s**2 + 3 * s + 2)
    numerator, denominator = read_text("1/(s + 1) + 1/(s + 2)").sides()
    assert sympy.expand(numerator) == 2 * s + 3
    assert sympy.expand(denominator - (s + 1) * (s + 2)) == 0


@pytest.mark.parametrize(
    "call",
    [
        lambda: ct.certified_roots(3),
        lambda: split_at_unit_circle(b"q - 2"),
        lambda: ct.place_poles("1/(s - 1)", [-1, -2], 1.0, feedback=1),
        lambda: ct.place_poles("1/(s - 1)", [-1, -2], feedback=1, numerator_degree=0.5),
        lambda: sylvester_m("s + 1", "1", 1.5, 1),
        lambda: ct.standard_problem("1/(q - sqrt(2))"),
        lambda: ct.StandardProblem(
            [["sqrt(2)"]], [[1]], [[1]], [[1]], None, None, [[1]], None, None
        ),
    ],
)
def test_wrong_types_are_our_errors(call):
    with pytest.raises(ct.InputError):
        call()


@pytest.mark.parametrize(
    "text",
    ["(a + b + c + d)**1000", "((a + b + c + d)**10)**20", "(a + b + c + d + e + f + g + h)**30",
     "(sqrt(a + b) + sqrt(c) + sqrt(d) + 1)**500", "(a + b)**400*(a - b)**90",
     "*".join(f"(a{i} + b{i})" for i in range(60)),
     "+".join(f"1/(s + a{i})" for i in range(30)), "1/(a + b + c + d + e + f)**-40",
     "(1/(a + b + c + d + e + f))**40"],
)  # fmt: skip
def test_expansions_without_end_are_refused(text):
    with pytest.raises(ct.InputError, match="terms"):
        ct.parse_expression(text)


@pytest.mark.costly
@pytest.mark.parametrize(
    "text",
    ["(s + 1)**1000", "(a*s + b)**120", "(a + b + s)**30", "(sqrt(2) + s)**40",
     "+".join(f"a{i}*s**{i}" for i in range(200)), "*".join(f"(s + {i})" for i in range(300)),
     "+".join(f"1/(s + a{i})" for i in range(8)), "s*(a + b)*(c + d)*(e + f)*(g + h)",
     "+".join(["1"] * 9999), "+".join(f"1/(s + {i})" for i in range(300)),
     "*".join(f"(s + {i})" for i in range(900))],
)  # fmt: skip
def test_what_fits_is_read(text):
    ct.parse_expression(text)


@pytest.mark.parametrize(
    "collect", [list, tuple, set, np.array, iter], ids=["list", "tuple", "set", "array", "iterator"]
)
def test_any_collection_holds_roots(collect):
    """Not coefficients: a silent change of meaning would place other poles."""
    placed = ct.place_poles("4/((s+1)*(s+3))", collect([-6, -5, -4, -2]), feedback=-1)
    assert placed.target == ct.polynomial("(s+6)*(s+5)*(s+4)*(s+2)")
    gain = ct.regulator_gain([[0, 1], [0, 0]], [[0], [1]], collect([-1, -2]))
    assert gain.tolist() == [[-2, -3]]


@pytest.mark.parametrize(
    "call",
    [
        lambda: ct.polynomial_from_roots(["s"], "s"),
        lambda: ct.polynomial_from_roots(5, "s"),
        lambda: ct.monic("s + 1"),
        lambda: reciprocal_polynomial([1, 2]),
        lambda: ct.parse_expression(5),
        lambda: ct.lqg_poles(None),
        lambda: ct.closed_loop_matrix("1/s", None),
        lambda: ct.intercalated_transfer_function(None, 1, "q"),
        lambda: target_characteristic_polynomial(None, 1, "1/q"),
        lambda: sylvester_m("s + 1", "1", "a", 1),
        lambda: sylvester_m("s**2 + 1", "s + 3", 10**7, 1),
        lambda: ct.polynomial(sympy.Poly("s + 1", modulus=5)),
    ],
)
def test_more_wrong_input_is_our_error(call):
    with pytest.raises(ct.InputError):
        call()


def test_float_polynomials_become_decimals_at_the_door():
    s = sympy.Symbol("s")
    assert ct.polynomial(sympy.Poly(0.5 * s + 1.5, s)) == ct.polynomial("s/2 + 3/2")
    with pytest.raises(ct.InputError, match="not exact"):
        ct.monic(sympy.Poly(1.0 * s + 1.5, s))


def test_lists_are_matrices_everywhere():
    assert ct.is_controllable([[0, 1], [0, 0]], [[0], [1]]) is True


@pytest.mark.parametrize("text", ["s₁ + 1", "½*s", "s ₂", "②*s"])
def test_small_figures_are_no_part_of_a_name(text):
    with pytest.raises(exact.InputError, match="there; write numbers"):
        exact.transfer_function(text)


def test_an_odd_root_of_a_negative_number_has_several_meanings():
    for text in ("(-8)**(1/3)", "(-pi)**(1/3)", "(1 - sqrt(2))**(3/5)"):
        with pytest.raises(exact.InputError, match="has several meanings"):
            exact.exact_number(text)
    assert exact.canonical("(-pi)**(1/2)") == "I*sqrt(pi)"


def test_a_sum_whose_fractions_cancel_is_its_own_canonical_form():
    echo = exact.canonical("q/q - s - b")
    assert exact.canonical(echo) == echo == exact.canonical("1 - s - b")


def test_a_field_asks_for_the_digits_of_its_discriminant():
    text = "*".join(["((3.+0.45082763499547807 - I^.5)**(1/3))"] * 10)
    with pytest.raises(exact.errors.BudgetError, match="discriminant"):
        exact.polynomial(text, "s")


@given(st.from_regex(PLAIN, fullmatch=True))
def test_plain_texts_are_what_the_parser_reads(text):
    assert ct.exact_number(text) == ct.parse_expression(text)


def test_plain_texts_obey_the_budget():
    with ct.budget(characters=3), pytest.raises(ct.InputError, match="characters"):
        ct.exact_number("1/23")
    with ct.budget(digits=2), pytest.raises(ct.InputError, match="digits"):
        ct.exact_number("1234")
    with pytest.raises(ct.InputError, match="zero"):
        ct.exact_number("1/0")
