"""Intervals of one parameter and lists of inequalities, against roots at drawn values."""

from functools import partial

import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.errors import BudgetError
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.strategies import polynomials, rationals, strictly_proper_plants

s, z, k, a, b, c, d = sympy.symbols("s z k a b c d")
MIDDLE, WIDTH = sympy.Rational(59, 2), 3 * sympy.sqrt(17) / 2


def ends(solution):
    return [(cell.lower, cell.upper) for cell in solution.intervals]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("s*(s - 1)*(s**2 + 4*s + 16) + k*(s + 1)", [(MIDDLE - WIDTH, MIDDLE + WIDTH)]),
        ("z*(z - 1)*(z - 1/2) + k", [(0, sympy.sqrt(17) / 4 - sympy.Rational(3, 4))]),
        ("s + k", [(0, sympy.oo)]),
        ("s**2 + k", []),
        ("s*(s**2 + k*s + 1)", []),
        ("k*s + 1", [(0, sympy.oo)]),
        ("s + 1/k", [(0, sympy.oo)]),
        ("(z - k)*(z - 1/2)", [(-1, 1)]),
        ("(z + 1)*(z - k)", []),
        ("s**2 + s + (k - 1)**2*(k + 1)", [(-1, 1), (1, sympy.oo)]),
        ("s**2 + 2*s + 1", [(-sympy.oo, sympy.oo)]),
    ],
)  # fmt: skip
def test_known_intervals(text, expected):
    """The first two are those of the textbooks; the last but one touches the boundary at 1."""
    end_points = ends(ct.stability_intervals(text, "k", variable="z" if "z" in text else "s"))
    assert end_points == expected


@given(
    polynomials(min_degree=1, max_degree=4, is_monic=True),
    polynomials(max_degree=3),
    st.lists(rationals(), min_size=3, max_size=3),
    st.sampled_from([s, z]),
)
def test_membership_is_stability(first, second, values, variable):
    p, q = (poly.as_expr().subs(poly.gen, variable) for poly in (first, second))
    intervals = ct.stability_intervals(p + k * q, k, variable=variable)
    decide = partial(ct.decide_stability, time="continuous" if variable == s else "discrete")
    for value in values:
        there = ct.polynomial(p + value * q, variable)
        assume(not there.is_zero)
        assert (value in intervals) == decide(there).is_stable  # of what is left, where it drops
    for cell in intervals.cells:
        assert cell.sample in cell and cell.count.total == intervals.polynomial.degree()


@given(strictly_proper_plants(max_order=4), st.sampled_from([-1, 1]))
def test_a_root_reaches_the_boundary_at_the_ends(G, sign):
    """Eigenvalues in float64 as the oracle: at a finite end the largest real part is 0."""
    gains = ct.stabilising_gains(G, feedback=sign)
    N, D = ([float(x) for x in poly.all_coeffs()] for poly in (G.numerator, G.denominator))
    for cell in gains.intervals:
        for end in (cell.lower, cell.upper):
            if end.is_finite:
                closed = np.polysub(D, sign * float(end) * np.array(N))
                assert abs(np.roots(closed).real.max()) < 1e-4 * max(1, abs(np.roots(closed)).max())


def test_conditional_stability_and_margins():
    gains = ct.stabilising_gains("(s + 2)**2/(s**3)", "1", feedback=-1)
    assert ends(gains) == [(1, sympy.oo)]
    assert ct.stabilising_gains("1/(s*(s + 1)*(s + 2))", feedback=-1).around(1).upper == 6
    assert ends(ct.stabilising_gains("1/(s*(s + 1)*(s + 2))", feedback=1)) == [(-6, 0)]
    assert not ct.stabilising_gains("(s - 1)/((s - 1)*(s + 2))", feedback=-1).intervals


@given(
    st.lists(st.integers(-2, 2), min_size=2, max_size=2),
    st.lists(st.lists(st.integers(-2, 2), min_size=1, max_size=2), min_size=1, max_size=3),
    st.sampled_from([s, z]),
)
def test_where_the_degree_drops_what_is_left_decides(leading, lower, variable):
    """At the zero of the leading coefficient, against the decision on the lower polynomial."""
    assume(leading[0])
    columns = [leading, *lower]
    degree = len(columns) - 1
    p = sum(sympy.Poly(c, k).as_expr() * variable ** (degree - i) for i, c in enumerate(columns))
    value = sympy.Rational(-leading[1], leading[0])
    there = ct.polynomial(sympy.expand(p.subs(k, value)), variable)
    intervals = ct.stability_intervals(ct.polynomial(p, variable), "k")
    time = "continuous" if variable == s else "discrete"
    expected = not there.is_zero and bool(ct.decide_stability(there, time=time).is_stable)
    assert (value in intervals) == expected
    if expected:
        assert value in intervals.around(value)


def test_degree_drops_of_the_textbooks():
    """s + 1 is stable, so k = 0 is; a loop loses a root to infinity there, and is not."""
    assert 0 in ct.stability_intervals("k*s**2 + s + 1", "k")
    assert str(ct.stability_intervals("k*s**3 + s + 1", "k")).endswith(
        "k in {0}, where the degree drops"
    )
    irrational = ct.stability_intervals("(k**2 - 2)*s**3 + (k + 1)*s + 1", "k")
    assert [point.lower for point in irrational.points] == [sympy.sqrt(2)]
    loop = ct.stabilising_gains("(s**2 + 1)/(s**2 + 2*s + 3)", feedback=1)
    assert 1 not in loop and sympy.Rational(1, 2) in loop
    region = ct.stability_region("a*s**2 + b*s + 1", "a", "b")
    assert (0, 1) in region and (1, 0) not in region


def test_what_is_refused():
    with pytest.raises(ct.InputError, match="give the others values"):
        ct.stability_intervals("s + a + k", "k")
    with pytest.raises(ct.InputError, match="cannot be the parameter"):
        ct.stability_intervals("s + 1", "s")
    with pytest.raises(ct.InputError, match="continuous time"):
        ct.stability_intervals("x + k", "k", variable="x")
    with pytest.raises(ct.InputError, match="zero polynomial"):
        ct.stability_intervals("k - k + 0*s", "k", variable="s")
    with pytest.raises(ct.InputError, match="k = 7 is not stable"):
        ct.stabilising_gains("1/(s*(s + 1)*(s + 2))", feedback=-1).around(7)
    with pytest.raises(ct.InputError, match="must be"):
        ct.stabilising_gains("1/s", feedback=0)


def test_published_conditions():
    """The cubic and the quartic of every textbook; Jury's triangle."""
    assert set(ct.stability_conditions("s**3 + a*s**2 + b*s + c")) == {a, c, a * b - c}
    quartic = ct.stability_conditions("s**4 + a*s**3 + b*s**2 + c*s + d")
    assert set(quartic) == {a, c, d, a * b * c - c**2 - a**2 * d}
    assert set(ct.stability_conditions("z**2 + a*z + b")) == {1 - b, 1 + a + b, 1 - a + b}
    assert ct.stability_conditions("s + 1") == () and ct.stability_conditions("s**2 + 1") == (0,)
    for p in ("s + 1", "s - 1", "s + a"):
        with pytest.raises(ct.InputError, match="decide_stability"):
            bool(ct.stability_conditions(p))
    assert ct.stability_conditions("a*s + b") == (a, b)


@pytest.mark.parametrize("variable", [s, z])
@given(n=st.integers(1, 6), values=st.lists(rationals(), min_size=6, max_size=6))
def test_conditions_decide(n, values, variable):
    """Half of Hurwitz's determinants say what the roots say; coefficients near the boundary."""
    names = sympy.symbols(f"a0:{n}")
    generic = variable**n + sum(x * variable**i for i, x in enumerate(names))
    conditions = ct.stability_conditions(ct.polynomial(generic, variable))
    if variable == s:
        values = [abs(value) for value in values]
    at = dict(zip(names, values[:n], strict=True))
    verdict = all(condition.subs(at) > 0 for condition in conditions)
    there = ct.polynomial(generic.subs(at), variable)
    time = "continuous" if variable == s else "discrete"
    assert verdict == ct.decide_stability(there, time=time).is_stable


COEFFICIENTS = [sympy.sympify(x) for x in (1, -2, 0)]
COEFFICIENTS += sympy.sympify(["a", "a*b - c", "(a + 1)/b", "d/c", "2*a/3 + d", "(b + d)/(a*c)"])


@given(
    st.lists(st.sampled_from(COEFFICIENTS), min_size=2, max_size=6),
    st.lists(rationals(), min_size=4, max_size=4),
    st.sampled_from([s, z]),
    st.sampled_from([2000, 20, 5]),
)
def test_conditions_with_denominators_multiplied_out_or_not(drawn, values, variable, terms):
    """With few terms they are products of sums, which have the same signs."""
    generic = sum(x * variable**i for i, x in enumerate(drawn))
    at = dict(zip((a, b, c, d), values, strict=True))
    assume(sympy.sympify(generic).has(a, b, c, d) and at[b] != 0 and at[a] * at[c] != 0)
    leading = next(x for x in reversed(drawn) if x != 0)
    assume(leading.subs(at) * (-1 if leading.is_negative else 1) > 0)
    try:
        with ct.budget(terms=terms):
            conditions = ct.stability_conditions(generic, variable)
    except BudgetError as refusal:
        assert terms < 2000 and "budget(terms=" in str(refusal)
        return
    verdict = all(condition.subs(at) > 0 for condition in conditions)
    there = ct.polynomial(generic.subs(at), variable)
    time = "continuous" if variable == s else "discrete"
    assert verdict == ct.decide_stability(there, time=time).is_stable
    assert terms == 2000 or all(len(x.args) <= terms for x in conditions)


@pytest.mark.parametrize(("terms", "is_product"), [(9, False), (8, True)])
def test_a_coefficient_over_a_symbolic_denominator_has_as_many_terms_as_are_allowed(
    terms, is_product
):
    with ct.budget(terms=terms):
        (condition,) = ct.stability_conditions("s + (a + b + c)/(d + e + f)", "s")
    expected = sympy.sympify("(a + b + c)*(d + e + f)")
    assert condition == (expected if is_product else sympy.expand(expected))


def test_two_pendula_with_sixteen_symbols():
    """The gains of a state feedback and the data of the plant, at points of both kinds."""
    I_L, I_T, d_L, d_T, m_L, m_T, l_L, g = plant = sympy.symbols("I_L I_T d_L d_T m_L m_T l_L g")
    shared = I_T + m_T * (d_T**2 + d_T * l_L)
    inertia = sympy.Matrix(
        [[I_L + I_T + d_L**2 * m_L + m_T * (d_T + l_L) ** 2, shared], [shared, I_T + d_T**2 * m_T]]
    )
    torque = g * d_T * m_T
    gravity = sympy.Matrix([[g * (d_L * m_L + (d_T + l_L) * m_T), torque], [torque, torque]])
    gains = sympy.Matrix(2, 4, sympy.symbols("k0:8"))
    upper = sympy.zeros(2).row_join(sympy.eye(2))
    lower = inertia.inv() * (gravity - gains[:, :2]).row_join(-gains[:, 2:])
    poly = characteristic_polynomial(upper.col_join(lower), s)
    conditions = ct.stability_conditions(poly)
    assert len(conditions) == 4
    verdicts = set()
    for size in (100, -100, 3):
        values = [1, 2, 1, 1, 3, 2, 1, 10, size, size / 3, 30, 10, size / 4, size, 10, 20]
        at = dict(zip([*plant, *gains], map(sympy.Rational, map(str, values)), strict=True))
        verdict = all(condition.xreplace(at) > 0 for condition in conditions)
        there = ct.polynomial(poly.as_expr().xreplace(at), s)
        assert verdict == ct.decide_stability(there).is_stable
        verdicts.add(verdict)
    assert verdicts == {True, False}
