"""Roots counted and located by routes that share nothing, against planted spectra and NumPy."""

from functools import partial

import control
import numpy as np
import pytest
import sympy
from hypothesis import example, given
from hypothesis import strategies as st

from compensator_theory import (
    InputError,
    bezout_identity,
    certified_roots,
    count_roots,
    decide_stability,
    locate_roots,
    polynomial,
    polynomial_from_roots,
    realisation,
    transfer_function,
    transfer_matrix,
)
from compensator_theory.results import RootCount
from compensator_theory.roots import (
    hurwitz_determinants,
    monic_reciprocal_polynomial,
    number_of_real_roots,
    reciprocal_polynomial,
    reflection_coefficients,
    split_at_unit_circle,
)
from compensator_theory.roots._schur_cohn import has_root_outside
from compensator_theory.strategies import polynomials, spectra

ANY_SPECTRUM = st.integers(0, 6).flatmap(spectra)
ON_AXIS = {"1": 0, "s": 1, "s**2": 2, "s**2 + 1": 2, "(s**2 + 4)**2": 4, "s**2 - 1": 0,
           "s**4 + 4": 0, "s**4 + s**2 + 1": 0, "s**4 - 5*s**2 + 4": 0}  # fmt: skip
SYMMETRIC = st.sampled_from(list(ON_AXIS))
ON_CIRCLE = st.sampled_from(["1", "z - 1", "(z + 1)**2", "z**2 + 1", "(z - 2)*(z - 1/2)",
                             "5*z**2 - 6*z + 5", "z**2 - 3*z + 1"])  # fmt: skip


def planted_count(values):
    return RootCount(
        sum(bool(v < 0) for v in values),
        sum(bool(v == 0) for v in values),
        sum(bool(v > 0) for v in values),
    )


@given(ANY_SPECTRUM)
def test_planted_spectra(planted):
    poly, in_s = (-3 * polynomial_from_roots(planted, x) for x in ("z", "s"))
    half_plane = planted_count([sympy.re(root) for root in planted])
    disk = planted_count([sympy.expand(root * root.conjugate()) - 1 for root in planted])
    assert count_roots(in_s) == locate_roots(in_s) == half_plane
    assert count_roots(poly) == locate_roots(poly) == disk
    assert number_of_real_roots(poly) == sum(root.is_real for root in planted)
    assert has_root_outside(poly) == (disk.unstable > 0)


@given(polynomials(max_degree=5), SYMMETRIC)
def test_the_singular_cases_of_routh(p, symmetric):
    poly = p * polynomial(symmetric, "s")
    decision = decide_stability(poly, time="continuous")
    assert decision.is_unanimous and decision.counts_by_roots.total == poly.degree()
    assert decision.counts_by_roots.boundary == (
        locate_roots(p, time="continuous").boundary + ON_AXIS[symmetric]
    )


@given(
    polynomials("z", max_degree=5),
    ON_CIRCLE,
    ON_CIRCLE,
    st.sampled_from(["1", "(z - 2)*(2*z + 1)"]),
)
def test_roots_outside_beside_roots_on_the_circle_and_in_pairs(p, first, second, of_product_one):
    poly = p * polynomial(first, "z") * polynomial(second, "z") * polynomial(of_product_one, "z")
    assert has_root_outside(poly) == (locate_roots(poly, time="discrete").unstable > 0)


@given(polynomials("z", max_degree=5), ON_CIRCLE)
def test_the_singular_cases_of_jury(p, special):
    decision = decide_stability(p * polynomial(special, "z"), time="discrete")
    assert decision.is_unanimous
    assert decision.is_stable == (decision.counts_by_roots.unstable == 0 and
                                  decision.counts_by_roots.boundary == 0)  # fmt: skip
    assert decision.by_coefficients == decision.by_roots


@given(polynomials(min_degree=1, max_degree=6))
def test_decisions_agree_with_numpy_away_from_the_boundary(p):
    roots = np.roots([float(c) for c in p.all_coeffs()])
    if np.min(np.abs(roots.real)) > 1e-3:
        assert decide_stability(p, time="continuous").is_stable == (roots.real.max() < 0)
    if np.min(np.abs(np.abs(roots) - 1)) > 1e-3:
        in_z = p.replace(p.gen, sympy.Symbol("z"))
        assert decide_stability(in_z).is_stable == (np.abs(roots).max() < 1)


@given(polynomials(max_degree=6, is_monic=True))
def test_hurwitz_determinants_decide(p):
    determinants = hurwitz_determinants(p)
    assert len(determinants) == p.degree()
    assert all(d > 0 for d in determinants) == decide_stability(p, time="continuous").by_roots


@given(st.lists(st.fractions(-3, 3, max_denominator=2), min_size=1, max_size=6))
@example([0, 1, 2, 0, 3])  # a zero at the top of Routh's array
@example([1, 1, 1, 1])  # a row of zeros
def test_hurwitz_determinants_are_minors_of_the_hurwitz_matrix(tail):
    a, n = [1, *map(sympy.Rational, tail)], len(tail)
    H = sympy.Matrix(n, n, lambda i, j: a[2 * j - i + 1] if 0 <= 2 * j - i + 1 <= n else 0)
    minors = tuple(H[:k, :k].det(method="berkowitz") for k in range(1, n + 1))
    assert hurwitz_determinants([3 * c for c in a], "s") == minors


@given(polynomials("z", min_degree=1, max_degree=6))
def test_reflection_coefficients_rebuild_the_polynomial(p):
    coefficients = reflection_coefficients(p)
    if len(coefficients) == p.degree() and abs(coefficients[-1]) < 1:
        z, rebuilt = p.gen, polynomial(1, "z")
        for k in reversed(coefficients):  # Levinson's recursion
            rebuilt = rebuilt * z + k * polynomial(rebuilt.all_coeffs()[::-1], "z")
        assert polynomial(rebuilt) == p.monic()
    else:
        assert abs(coefficients[-1]) >= 1


def test_classical_arrays():
    # A zero in the first column, a row of zeros, and the one of Gantmacher with roots on the axis.
    assert (
        count_roots(polynomial("s**4 + s**3 + 2*s**2 + 2*s + 3"), time="continuous").unstable == 2
    )
    assert count_roots(
        polynomial("s**5 + s**4 + 2*s**3 + 2*s**2 + s + 1"), time="continuous"
    ) == RootCount(1, 4, 0)
    assert number_of_real_roots(polynomial("(s + 1)**2*(s**2 + 1)**2")) == 2
    assert number_of_real_roots(polynomial(5, "s")) == 0
    assert decide_stability(polynomial(5, "s"), time="continuous").is_stable


def test_high_degrees():
    p = polynomial_from_roots([sympy.Rational(-k, 7) for k in range(1, 41)], "s")
    assert decide_stability(p, time="continuous").counts_by_coefficients == RootCount(40, 0, 0)
    near = polynomial([10**40, -(10**40) - 1], "z") * polynomial([10**40, -(10**40) + 1], "z")
    decision = decide_stability(near * polynomial("z**2 + 1"), time="discrete")
    assert decision.is_unanimous and decision.counts_by_roots == RootCount(1, 2, 1)


def test_symbols():
    a, b = sympy.symbols("a b", positive=True)
    s = sympy.Symbol("s")
    assert (
        decide_stability(s**3 + (a + 1) * s**2 + (b + 1) * s + b, time="continuous").is_stable
        is True
    )
    assert decide_stability(s**3 + a * s**2 + b * s + 1, time="continuous").is_stable is None
    assert decide_stability(s**2 - a * s + b, time="continuous").is_stable is False
    assert decide_stability("z**2 + a*z + 2", time="discrete").is_stable is False
    assert decide_stability("z**2 + a*z + 1/2", time="discrete").is_stable is None
    real, z = sympy.Symbol("a", real=True), sympy.Symbol("z")
    # The sign of a determinant depends on a; at a = 0 the degree drops, and there is no root.
    for open_question in (z**2 + real * z + sympy.Rational(1, 2), real**2 * z + real**2 + 1):
        assert decide_stability(open_question, time="discrete").is_stable is None
    for decision in (
        decide_stability("s + a", time="continuous"),
        decide_stability("(z - 1/2)", time="discrete"),
        decide_stability("z - a", time="discrete"),
    ):
        assert str(decision) and decision._repr_latex_().startswith("$")


@pytest.mark.parametrize("scale", [2, sympy.Rational(-1, 3), sympy.Symbol("k", negative=True)])
@pytest.mark.parametrize(
    "text",
    ["x - a", "x**2 + a*x + 1/2", "x**2 + b*x + 2", "x**2 + b", "2*x + b/(b + 1)",
     "x**3 + (b + 1)*x**2 + b*x + b/2"],
)  # fmt: skip
@pytest.mark.parametrize("time", ["continuous", "discrete"])
def test_a_factor_without_roots_changes_no_decision_with_symbols(time, text, scale):
    x = sympy.Symbol("x")
    names = {"x": x, "a": sympy.Symbol("a", real=True), "b": sympy.Symbol("b", positive=True)}
    p = sympy.sympify(text, names)
    one, other = (decide_stability(sympy.expand(c * p), x, time=time) for c in (1, scale))
    assert one.is_stable is other.is_stable
    pairs = zip(one.evidence, other.evidence, strict=True)
    assert all(sympy.simplify(u - v) == 0 for u, v in pairs)


@given(polynomials(max_degree=4), polynomials(max_degree=4))
def test_reciprocals(p, other):
    assert reciprocal_polynomial(p * other) == reciprocal_polynomial(p) * reciprocal_polynomial(
        other
    )
    if p.TC() != 0:
        assert reciprocal_polynomial(reciprocal_polynomial(p)) == p
        reflected = monic_reciprocal_polynomial(p)
        assert reflected.LC() == 1
        inverse = [1 / root.value for root in certified_roots(p)]
        result = [root.value for root in certified_roots(reflected)]
        assert len(inverse) == len(result)
        for value in inverse:
            assert min(abs(value - x) for x in result) < 1e-6 * max(1, abs(value))


@given(polynomials(max_degree=3), polynomials(max_degree=3), polynomials(max_degree=3))
def test_bezout_identities(a, b, common):
    identity = bezout_identity(a * common, b * common)
    assert identity.residual.is_zero and identity.gcd.is_monic
    assert identity.gcd == (a * common).gcd(b * common).monic()
    assert identity.gcd * identity.quotients[0] == a * common
    assert identity.gcd * identity.quotients[1] == b * common
    assert identity.is_coprime == (identity.gcd.degree() == 0)


def test_bezout_with_symbols():
    identity = bezout_identity("(s + a)*(s + b)", "(s + a)*s", variable="s")
    assert identity.residual.is_zero and identity.is_coprime is False
    assert bezout_identity("s + a", "s + b", variable="s").is_coprime is None
    assert bezout_identity("s + 1", 0).gcd == polynomial("s + 1")
    assert "gcd" in str(identity) and identity._repr_latex_().startswith("$")


@pytest.mark.parametrize(
    "function",
    [number_of_real_roots, reflection_coefficients,
     *(partial(f, time=time) for f in (count_roots, locate_roots)
       for time in ("continuous", "discrete"))],
)  # fmt: skip
@pytest.mark.parametrize(
    "bad",
    [polynomial(0, "s"), polynomial("s + a"), "1/s", None, "s*z", [], [1, None], float("nan")],
)
def test_bad_input_of_counts(function, bad):
    with pytest.raises(InputError):
        function(bad)


def test_bad_input():
    decisions = [partial(decide_stability, time=time) for time in ("continuous", "discrete")]
    for function in (*decisions, hurwitz_determinants):
        for bad in (polynomial(0, "s"), "1/s", float("nan"), None, "s*z"):
            with pytest.raises(InputError):
                function(bad)
    for bad in (polynomial(0, "s"), polynomial("s**2 + s")):
        with pytest.raises(InputError):
            monic_reciprocal_polynomial(bad)
    with pytest.raises(InputError):
        reciprocal_polynomial(polynomial(0, "s"))
    for a, b in ((0, 0), ("s", "1/s"), (float("inf"), "s")):
        with pytest.raises(InputError):
            bezout_identity(a, b)


@pytest.mark.parametrize(
    ("text", "stable", "unstable"),
    [
        ("q**2 - 1.9999999999999999999*q + 0.99999999999999999998", 2, 0),
        ("q**2 - 1.9999999999999999999*q + 1.00000000000000000002", 0, 2),
        ("q**2 - 1.5*q + 0." + 60 * "9", 2, 0),
        ("q**2 - 1.5*q + 1." + 59 * "0" + "1", 0, 2),
    ],
)
def test_roots_closer_to_the_circle_than_float64_can_tell(text, stable, unstable):
    poly = polynomial(text)
    for count in (locate_roots(poly, time="discrete"), count_roots(poly, time="discrete")):
        assert (count.stable, count.boundary, count.unstable) == (stable, 0, unstable)
    inside, outside = split_at_unit_circle(poly)
    assert (inside.degree(), outside.degree()) == (stable, unstable)


def test_schur_with_irrational_numbers_and_with_symbols():
    assert decide_stability("q - sqrt(2)/2", time="discrete").is_stable is True
    assert decide_stability("2*q**2 - sqrt(2)*q + 1", time="discrete").is_stable is True
    assert decide_stability("q**2 - sqrt(2)*q + 1", time="discrete").is_stable is False
    assert decide_stability("pi*q - 4", time="discrete").is_stable is False
    # Both roots are real, by hand (-pi/3 +- sqrt(pi**2/9 - 1))/2 = -0.68 and -0.37.
    assert decide_stability("q**2 + pi*q/3 + 1/4", time="discrete").is_stable is True
    b, q = sympy.Symbol("b", positive=True), sympy.Symbol("q")
    first_order = polynomial((1 + b) * q - b, q)
    assert decide_stability(first_order, time="discrete").is_stable is True
    assert (
        decide_stability("a*q**2 + q + 2*a", time="discrete").is_stable is None
    )  # it is q where a = 0


@pytest.mark.parametrize("first", ["exp(-1/10)", "exp(1/10)", "-exp(-2)"])
@pytest.mark.parametrize("second", ["1/2", "-exp(-1/3)", "-2*exp(-1/2)"])
def test_exponentials_are_decided_as_their_roots_are(first, second):
    roots = [complex(sympy.sympify(root)) for root in (first, second)]
    in_s, in_z = (f"({x} - ({first}))*({x} - ({second}))" for x in "sz")
    assert decide_stability(in_s).is_stable is all(root.real < 0 for root in roots)
    assert decide_stability(in_z).is_stable is all(abs(root) < 1 for root in roots)


def test_a_large_degree_is_decided_soon():
    assert decide_stability("(s + 1)**120", time="continuous").is_stable is True


@given(spectra(3), st.sampled_from("sz"))
def test_a_system_is_asked_for_its_poles(spectrum, variable):
    """Those that a zero cancels are counted; its variable says the time domain."""
    poles = polynomial_from_roots([*spectrum, 2], variable)
    G = transfer_function((polynomial_from_roots([2], variable), poles))
    for system in (G, realisation(G)):
        for question in (decide_stability, count_roots, locate_roots):
            assert question(system) == question(poles)
    assert not decide_stability(G).is_stable


def test_a_system_that_is_not_read_names_what_reads_it():
    for system in (control.tf([1], [1, 1]), transfer_matrix([["1/(s + 1)"]])):
        with pytest.raises(InputError, match=r"is a system, .*give transfer_function\(system\)"):
            decide_stability(system)


@pytest.mark.parametrize("ask", [decide_stability, count_roots, locate_roots])
def test_a_matrix_names_what_reads_it(ask):
    A = [[0, 1], [-1, -1]]
    for obj in (A, np.array(A), sympy.Matrix(A), (A, [[0], [1]], [[1, 0]])):
        with pytest.raises(InputError, match=r"charpoly"):
            ask(obj)
    assert ask(sympy.Matrix(A).charpoly("s")) == ask("s**2 + s + 1")
