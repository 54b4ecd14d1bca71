"""Routh's and Jury's arrays against exact counting, Hurwitz's determinants and textbooks."""

import pytest
import sympy
from hypothesis import example, given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.errors import BudgetError, InputError
from compensator_theory.strategies import boundary_polynomials, polynomials, rationals

a, b, c, d = sympy.symbols("a b c d")


@given(polynomials(min_degree=1, max_degree=7) | boundary_polynomials())
@example(ct.polynomial("s**4 + s**3 + 2*s**2 + 2*s + 5"))  # a zero pivot
@example(ct.polynomial("s**5 + 2*s**4 + 24*s**3 + 48*s**2 - 25*s - 50"))  # Ogata: a zero row
@example(ct.polynomial("s**6 + s**5 + 2*s**4 + 2*s**3 + s**2 + s"))
@example(ct.polynomial("s**3"))
def test_the_first_column_counts(p):
    array = ct.routh_array(p)
    count = ct.count_roots(p)
    assert array.count == count
    if not array.zero_pivots or count.boundary == 0:
        assert array.sign_changes == count.unstable
    assert len(array.rows) == p.degree() + 1


@given(polynomials(min_degree=1, max_degree=7))
def test_a_zero_row_has_the_roots_symmetric_about_the_origin(p):
    """The auxiliary polynomial divides; its degree is that of the common factor with p(-s)."""
    p = ct.polynomial(p.as_expr() * (p.gen**2 + 2), "s")
    array = ct.routh_array(p)
    if array.zero_pivots:  # epsilon may hide the zero row
        return
    _, auxiliary = array.zero_rows[0]
    mirrored = p.compose(-p.gen.as_poly(p.gen))
    assert auxiliary.monic() == p.gcd(mirrored).monic()


@given(st.lists(rationals(), min_size=3, max_size=4), st.sampled_from("sz"))
def test_conditions_decide(values, variable):
    letters = (a, b, c, d)[: len(values)]
    x = sympy.Symbol(variable)
    n = len(values)
    general = x**n + sum(letter * x ** (n - 1 - k) for k, letter in enumerate(letters))
    function = ct.routh_array if variable == "s" else ct.jury_array
    conditions = function(general, variable).conditions
    point = dict(zip(letters, values, strict=True))
    stable = bool(ct.decide_stability(general.subs(point)))
    assert all(condition.subs(point) > 0 for condition in conditions) == stable


@given(st.lists(rationals(), min_size=3, max_size=3))
def test_rows_with_symbols_are_those_of_numbers(values):
    array = ct.routh_array("s**3 + a*s**2 + b*s + c")
    point = dict(zip((a, b, c), values, strict=True))
    if any(e.subs(point) == 0 for e in array.exceptional):
        return
    numbers = ct.routh_array(sympy.sympify("s**3 + a*s**2 + b*s + c").subs(point))
    assert numbers.rows == tuple(tuple(e.subs(point) for e in row) for row in array.rows)


@given(polynomials("z", min_degree=1, max_degree=5))
def test_jury_counts_and_decides(p):
    array = ct.jury_array(p)
    count = ct.count_roots(p)
    assert array.count == count
    holds = all(condition > 0 for condition in array.conditions)
    assert holds == (count.stable == count.total)
    words = "every root lies inside" if holds else "fails"
    assert words in array.conclusion


def test_published_arrays():
    """Ogata, Modern Control Engineering, examples 5-11 and 5-13; Discrete-Time, example 4-4."""
    assert [row[0] for row in ct.routh_array("s**4 + 2*s**3 + 3*s**2 + 4*s + 5").rows] == [
        1, 2, 1, -6, 5,
    ]  # fmt: skip
    array = ct.routh_array("s**5 + 2*s**4 + 24*s**3 + 48*s**2 - 25*s - 50")
    assert array.first_column == (1, 2, 8, 24, sympy.Rational(338, 3), -50)
    gain = ct.routh_array("s**4 + 3*s**3 + 3*s**2 + 2*s + K")  # stable for 0 < K < 14/9
    assert set(gain.conditions) == {sympy.Symbol("K"), sympy.sympify("14 - 9*K")}
    jury = ct.jury_array("z**4 - 1.2*z**3 + 0.07*z**2 + 0.3*z - 0.08")
    assert jury.count.total == jury.count.stable
    assert [row[0] for row in jury.rows] == [sympy.Rational("-0.08"), sympy.Rational("-0.9936"),
        sympy.Rational("0.9936") ** 2 - sympy.Rational("0.204") ** 2]  # fmt: skip


def test_the_array_counts_where_symbols_do_not_decide():
    """A positive symbol decides, one of either sign does not."""
    k = sympy.Symbol("k", positive=True)
    s = sympy.Symbol("s")
    known = ct.routh_array((s + k) * (s + 1) * (s + 2), "s")
    assert (known.sign_changes, known.count.stable) == (0, 3)
    open_case = ct.routh_array("s**2 + a*s + 1")
    assert open_case.sign_changes is None and open_case.count is None
    assert ct.jury_array("z + a").count is None


@pytest.mark.parametrize(
    ("text", "stable", "counted"),
    [
        ("(s**2 + sqrt(2))*(s - 1)*(s**2 + s + 2 + sqrt(2))", False, None),  # epsilon misleads
        ("s**3 + sqrt(2)*s**2 + 3*s + 1", True, 3),
        ("s**4 + s**3 + sqrt(2)*s**2 + sqrt(2)*s + 1", False, 2),
    ],
)
def test_irrational_numbers(text, stable, counted):
    """Counted by the array where no root can be on the axis; the signs of the roots by mpmath."""
    array = ct.routh_array(text)
    roots = [complex(r) for r in sympy.Poly(sympy.sympify(text), sympy.Symbol("s")).nroots(n=30)]
    assert all(r.real < -1e-20 for r in roots) == stable
    assert all(condition.is_positive for condition in array.conditions) == stable
    assert array.conclusion.startswith("not stable" if counted is None else array.conclusion[:1])
    if counted is None:
        assert array.count is None
    else:
        assert array.count.stable == counted


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("z**2 + sqrt(2)*z/3 + sqrt(3)/9", "stable: every condition holds"),
        ("z**2 + sqrt(2)*z + 2", "not stable: the condition"),
        ("z**2 + sqrt(2)*a*z", "stable if and only if"),
    ],
)
def test_jury_with_irrational_numbers(text, words):
    assert ct.jury_array(text, "z").conclusion.startswith(words)


def test_epsilon_that_misleads_is_named():
    """Where roots lie on the axis beside a zero pivot the count is the exact one."""
    array = ct.routh_array("(s**2 + 1)*(s - 1)*(s**2 + s + 3)")
    assert (array.sign_changes, array.count.unstable, array.count.boundary) == (3, 1, 2)
    assert "epsilon misleads" in array.conclusion


@pytest.mark.parametrize(
    ("call", "error"),
    [
        (lambda: ct.routh_array("3"), InputError),
        (lambda: ct.routh_array("z + 1"), InputError),
        (lambda: ct.jury_array("s + 1"), InputError),
        (lambda: ct.routh_array([0, 0, 3]), InputError),
        (lambda: ct.jury_array("x + y"), InputError),
        (lambda: ct.routh_array("s**2000 + 1"), BudgetError),
    ],
)
def test_refusals(call, error):
    with pytest.raises(error):
        call()


@pytest.mark.parametrize(
    "text", ["s**4 + 3*s**2 + 2", "s**6 + 2*s**4 + 3*s**2 + 7", "s**2 + 1", "s**4 + 2*s**2 + 1"]
)
def test_the_row_of_s_to_the_p_has_half_of_p_and_one_entries(text):
    """Also where the derivative of an even polynomial, without its constant, stands in the row."""
    array = ct.routh_array(text)
    lengths = [len(row) for row in array.rows]
    assert lengths == [power // 2 + 1 for power in range(len(lengths) - 1, -1, -1)]
