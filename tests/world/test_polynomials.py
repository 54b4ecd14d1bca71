"""Resultants, gcds, Diophantine equations, partial fractions, roots."""

import flint
import numpy as np
import pytest
import sympy as sp
from numpy.polynomial import Chebyshev, Legendre, Polynomial

import compensator_theory as ct
from compensator_theory.bezout import number_of_common_roots, subresultants, sylvester_m
from compensator_theory.errors import NoSolutionError
from tests.support.world import case

s, x, t = sp.symbols("s x t")
HALF = sp.Rational(1, 2)

RESULTANTS = [
    # Res(a, b) = lc(a)^deg(b) times the product of b over the roots of a.
    case("SymPy-10666", ("x + 2", "x**3"), -8),
    case("SymPy-10666b", ("x**3", "x + 2"), 8),
    case("SymPy-25406", ("x**3", "x + 1"), 1),
    case("SymPy-25406b", ("x + 1", "x**3"), -1),
    case("JAC-signs", ("x + 5", "x**3"), -125),
    case("JAC-signs-b", ("x**3", "x + 5"), 125),
    case("zero-second", ("x + 1", "0"), 0),
    case("zero-first", ("0", "x + 1"), 0),
]


@pytest.mark.parametrize(("pair", "right"), RESULTANTS)
def test_resultants(pair, right):
    """By hand, from the roots; SymPy 1.14 has the sign wrong in some orders."""
    assert ct.resultant(*pair, variable="x") == right


def test_sylvester_matrix_of_a_newsgroup():
    """MATLAB newsgroup: degrees 3 and 1 make 4 columns and rows, by its definition."""
    M = sylvester_m("s**3 + 2*s**2 + 3*s + 4", "5*s + 6", 1, 2, variable="s")
    assert M.shape == (4, 4)
    assert abs(M.det()) == abs(sp.resultant(s**3 + 2 * s**2 + 3 * s + 4, 5 * s + 6, s))


def test_subresultants_with_a_parameter():
    """Yacas sf59: a chain in x with t; the last is the resultant that the roots give."""
    a, b = x**2 + t * x + 1, x - t
    assert sp.expand(ct.resultant(a, b, variable="x") - (2 * t**2 + 1)) == 0
    chain = subresultants(a, b, variable="x").chain
    assert {sp.expand(poly.as_expr()) for poly in chain} >= {2 * t**2 + 1, b}


EQUAL_NUMBERS = [
    case("golden-ratio", sp.GoldenRatio, (1 + sp.sqrt(5)) / 2),
    case("nested-roots", sp.sqrt(5 + 2 * sp.sqrt(6)), sp.sqrt(2) + sp.sqrt(3)),
    case("sin-pi-7", sp.sin(sp.pi / 7), sp.cos(5 * sp.pi / 14)),
    case("SymPy-24347-log", sp.log(6), sp.log(2) + sp.log(3)),
    case("SymPy-24347-sin2", sp.sin(2), 2 * sp.sin(1) * sp.cos(1)),
    case("SymPy-24347-cos2", sp.cos(2), 1 - 2 * sp.sin(1) ** 2),
]


@pytest.mark.parametrize(("u", "v"), EQUAL_NUMBERS)
def test_equal_numbers_cancel_or_are_refused(u, v):
    """1/(s + u) - 1/(s + v) with u = v, as mpmath's 50 digits say: degree 0, or a refusal."""
    assert sp.N(u - v, 50, chop=True) == 0
    try:
        assert ct.mcmillan_degree(1 / (s + u) - 1 / (s + v), "s") == 0
    except ct.CompensatorError:
        assert u.has(sp.log, sp.sin, sp.cos)


@pytest.mark.parametrize(
    ("u", "v"),
    [case("SymPy-24347-bezout", sp.log(6), sp.log(2) + sp.log(3))],
)
def test_a_gcd_is_no_division_by_zero(u, v):
    try:
        identity = ct.bezout_identity(s + u, s + v, variable="s")
    except ct.CompensatorError:
        return
    assert not str(identity).startswith("gcd = 1 ")
    assert number_of_common_roots(s + u, s + v, variable="s") != 0


FRACTIONS = [
    # SymPy #14371: decimals twice and thrice in the denominator; the sum is multiplied out again.
    case("SymPy-14371", "1/(s + 0.9)**2/(s + 2)"),
    case("SymPy-14371b", "(s + 3)/((s + 0.9)**3*(s + 1))"),
    case("SymPy-15738", 1 / ((s + sp.pi) * (s + 1))),
    case("SymPy-10123", 1 / ((s + sp.E) * (s + 2))),
    case("diofant-1075", "1/(s**6 + 1)"),
    case("SymPy-25352", "9/((s + 0.3)*(s + 1.5))"),
    case("SymPy-20059", "(0.1*s + 3)/(s**2*(s + 0.25))"),
]


@pytest.mark.parametrize("fraction", FRACTIONS)
def test_partial_fractions(fraction):
    """Oracle: SymPy adds the terms up again, over rationals."""
    fractions = ct.partial_fractions(fraction, "s")
    whole = sp.sympify(fraction, rational=True) if isinstance(fraction, str) else fraction
    total = fractions.polynomial.as_expr() + sum(term_of(term) for term in fractions.terms)
    assert sp.simplify(total - whole) == 0


def term_of(term):
    return term.numerator.as_expr() / term.factor.as_expr() ** term.power


def test_a_term_with_a_parameter_is_not_lost():
    """SymPy #12177: a(-t + (1-t)(2t-1))/(2t-1) = a(1-t) - a t/(2t-1)."""
    a = sp.Symbol("a")
    argument = a * (-t + (1 - t) * (2 * t - 1)) / (2 * t - 1)
    fractions = ct.partial_fractions(argument, "t")
    total = fractions.polynomial.as_expr() + sum(term_of(term) for term in fractions.terms)
    assert sp.simplify(total - argument) == 0


ROOTS = [
    case("SymPy-25316", "y**3 - 6*y**2 + 11.25*y - 6.25", {1.0: 1, 2.5: 2}),
    case("loom-2", "(y - 1)**2*(y + 3)**3", {1.0: 2, -3.0: 3}),
    case("SymPy-24013", sp.prod([x - k for k in range(1, 21)]), dict.fromkeys(range(1, 21), 1)),
]


@pytest.mark.parametrize(("poly", "right"), ROOTS)
def test_roots_with_their_multiplicities(poly, right):
    """By hand: each polynomial is written from its roots."""
    result = {root.value.real: root.multiplicity for root in ct.certified_roots(poly)}
    assert result == pytest.approx(right)
    assert all(root.is_real for root in ct.certified_roots(poly))


def test_legendre_64():
    """SymPy #7393: 64 simple real roots in (-1, 1), as the nodes of Gauss's rule."""
    ordered = sorted(root.value.real for root in ct.certified_roots(sp.legendre(64, x)))
    assert ordered == pytest.approx(np.polynomial.legendre.leggauss(64)[0], abs=1e-13)


def test_an_equation_without_a_solution():
    """A forum's RST regulator: A R + (z-1) B S = C where z - 1 divides A and not C."""
    with pytest.raises(NoSolutionError, match="z - 1"):
        ct.solve_diophantine("(z - 1)*(z - 0.5)", "(z - 1)*0.2", "z**2", variable="z")


ASCENDING = [
    case("numpy-Polynomial", Polynomial([35, 12, 1])),
    case("numpy-Chebyshev", Polynomial([35, 12, 1]).convert(kind=Chebyshev)),
    case("numpy-Legendre", Polynomial([35, 12, 1]).convert(kind=Legendre)),
    case("flint-fmpq", flint.fmpq_poly([35, 12, 1])),
    case("flint-fmpz", flint.fmpz_poly([35, 12, 1])),
    case("numpy-poly1d", np.poly1d([1, 12, 35])),
    case("list", [1, 12, 35]),
]


@pytest.mark.parametrize("obj", ASCENDING)
def test_polynomials_of_other_libraries(obj):
    """(z + 5)(z + 7), which each class says of itself; its roots are outside the circle."""
    try:
        read = ct.polynomial(obj, "z")
    except ct.CompensatorError:
        return  # to refuse is right too
    assert read.as_expr() == sp.expand((sp.Symbol("z") + 5) * (sp.Symbol("z") + 7))
    assert not ct.decide_stability(read, "z").is_stable


REFUSED = [
    case("SymPy-14183", lambda: ct.resultant("x**n", "x + 1", variable="x"), "n"),
    case("Sage-35217", lambda: ct.resultant("x + I", "x**2 + 2", variable="x"), "conjugate"),
    case("SymPy-25326", lambda: ct.polynomial(sp.exp(-5 * s) * (s + 1), "s"), "exp"),
    case("SymPy-21585", lambda: ct.partial_fractions(1 / (s + sp.exp(-s)), "s"), "exp"),
]


@pytest.mark.parametrize(("ask", "words"), REFUSED)
def test_questions_outside_are_refused(ask, words):
    with pytest.raises(ct.CompensatorError, match=words):
        ask()


@pytest.mark.parametrize(
    "text", ["1/(s + 1 + 2j)", "1/(s**2 + 2*s + 2)", "s/((s + 2j)**2*(s - 1))"]
)
def test_partial_fractions_with_complex_coefficients(text):
    """SymPy-628: of complex poles, where the coefficients are."""
    answer = ct.partial_fractions(text, "s")
    total = answer.polynomial.as_expr() + sum(
        term.numerator.as_expr() / term.factor.as_expr() ** term.power for term in answer.terms
    )
    assert sp.simplify(total - sp.sympify(text.replace("2j", "2*I"))) == 0
