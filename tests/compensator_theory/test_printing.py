"""Integers of any length, written and read without Python's limit of digits being touched."""

import sys
import traceback
from fractions import Fraction

import pytest
import sympy
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sympy.printing.latex import LatexPrinter
from sympy.printing.str import StrPrinter

import compensator_theory as exact
from compensator_theory._printing import decimal, formula, fraction_of, integer_of, text
from compensator_theory.polynomials._budget import quoted, repr_of
from compensator_theory.polynomials._values import ExactValue
from tests.compensator_theory.samples import SAMPLES

LONG = 10**6000 + 7
S, A = sympy.symbols("s a")
RESULTS = [cls for cls in SAMPLES if issubclass(cls, ExactValue)]
NUMBERS = st.one_of(st.integers(-(10**700), 10**700), st.integers(-9, 9)).map(sympy.Integer)
EXPRESSIONS = st.recursive(
    NUMBERS | st.sampled_from([S, A, sympy.I, sympy.sqrt(2), sympy.pi]),
    lambda inner: st.one_of(
        st.builds(sympy.Add, inner, inner),
        st.builds(sympy.Mul, inner, inner),
        st.builds(lambda x, y: x / (y if y.is_nonzero else 3), inner, NUMBERS),
        st.builds(lambda x, k: x**k if x != 0 else x, inner, st.sampled_from([-1, 2, 3])),
    ),
    max_leaves=5,
)


@pytest.fixture
def least_limit():
    """The least number of digits to which Python can be limited."""
    usual = sys.get_int_max_str_digits()
    sys.set_int_max_str_digits(640)
    yield
    assert sys.get_int_max_str_digits() == 640
    sys.set_int_max_str_digits(usual)


@given(number=st.integers() | st.integers(-(10**3000), 10**3000))
def test_integers_are_written_as_python_does_and_read_back(number):
    assert decimal(number) == str(number)
    assert integer_of(str(abs(number))) == abs(number)


@given(
    digits=st.text("0123456789", min_size=1, max_size=900),
    decimals=st.text("0123456789", max_size=900),
    exponent=st.none() | st.integers(-99, 99),
)
def test_decimals_are_read_as_python_does(digits, decimals, exponent):
    written = f"{digits}.{decimals}" + ("" if exponent is None else f"e{exponent}")
    assert fraction_of(written) == Fraction(written)


def test_digits_of_another_script_are_read_as_python_does():
    written = "\N{ARABIC-INDIC DIGIT THREE}" * 700
    assert integer_of(written) == int(written)


@settings(suppress_health_check=[HealthCheck.too_slow])
@given(expression=EXPRESSIONS)
def test_expressions_are_written_as_sympy_does(expression):
    assert text(expression) == str(expression)
    assert formula(expression) == sympy.latex(expression)
    matrix = sympy.Matrix([[expression, 1], [0, expression / 3]])
    assert text(matrix) == str(matrix)
    assert formula(matrix) == sympy.latex(matrix)


def test_matrices_of_long_integers_and_empty_ones():
    assert text(sympy.Matrix([[LONG, 1]])) == f"Matrix([[{decimal(LONG)}, 1]])"
    for empty in (sympy.zeros(0, 2), sympy.zeros(2, 0)):
        assert text(empty) == str(empty)


@pytest.mark.costly
@pytest.mark.cases(40)
@pytest.mark.parametrize("cls", RESULTS, ids=lambda cls: cls.__name__)
def test_no_result_prints_with_a_limit(cls, monkeypatch):
    """As if every number were too long for Python: SymPy's own printers refuse them all."""
    refused = []

    def limited(printer, name):
        value = getattr(printer, name)

        def write(self, number):
            callers = {frame.name for frame in traceback.extract_stack(limit=12)}
            if refused and type(self) is printer and "sort_key" not in callers:
                raise ValueError("Exceeds the limit for integer string conversion")
            return value(self, number)

        monkeypatch.setattr(printer, name, write)

    limited(StrPrinter, "_print_Integer")
    limited(StrPrinter, "_print_Rational")
    limited(LatexPrinter, "_print_Rational")

    @settings(suppress_health_check=[HealthCheck.too_slow], max_examples=3, deadline=None)
    @given(value=SAMPLES[cls])
    def prints(value):
        usual = [str(value), repr(value), value._repr_latex_()]
        refused.append(True)
        try:
            assert [str(value), repr(value), value._repr_latex_()] == usual
        finally:
            refused.clear()

    prints()


def test_long_results_are_printed_under_the_least_limit(least_limit):
    G = exact.TransferFunction(sympy.Poly(1, S), sympy.Poly(S + LONG, S))
    placed = exact.place_poles(G, [-1], feedback=-1)
    for result in (G, placed, exact.results.Enclosure(sympy.Integer(LONG), sympy.Integer(0))):
        for written in (str(result), repr(result), result._repr_latex_()):
            assert "0" * 5000 in written
    assert "0" * 5000 in exact.canonical(G)


@pytest.mark.slow
def test_a_long_radicand_is_printed(least_limit):
    value = sympy.Pow(LONG, sympy.S.Half, evaluate=False) * S * A + 1
    for written in (text(value), formula(value)):
        assert "0" * 5000 in written and "s" in written and "a" in written


def test_long_numbers_are_read_under_the_least_limit(least_limit):
    digits = "1" * 3000
    assert exact.exact_number(digits) == sympy.Integer((10**3000 - 1) // 9)
    assert exact.exact_number(f"0.{digits}e2").q == 10**2998
    with exact.budget(digits=10_000, characters=20_000):
        assert exact.exact_number("1" + 9000 * "0") == sympy.Integer(10) ** 9000


def test_errors_quote_long_numbers(least_limit):
    assert quoted(LONG).startswith("1000") and repr_of(LONG).startswith("1000")
    assert quoted(S + sympy.Integer(LONG)).endswith("7")
    assert repr_of([LONG, "s"]).startswith("[1000")
    with pytest.raises(exact.InputError, match=r"10000.*cannot be certified"):
        exact.certified_roots(exact.polynomial([1, sympy.Integer(LONG) * A], "s"))
