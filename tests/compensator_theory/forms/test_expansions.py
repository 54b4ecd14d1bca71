"""Markov parameters against powers of A, partial fractions against SymPy's."""

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.errors import BudgetError, ImproperError
from compensator_theory.strategies import minimal_plants, polynomials

s = sympy.Symbol("s")


@given(minimal_plants())
def test_markov_parameters_are_those_of_the_realisation(plant):
    A, power, C = plant.A, plant.B, plant.C
    expected = [0]
    for _ in range(2 * A.rows):
        expected.append((C * power)[0, 0])
        power = A * power
    assert list(ct.markov_parameters(plant, len(expected))) == expected


def test_symbolic_markov_parameters():
    a, b = sympy.symbols("a b")
    assert ct.markov_parameters("b/(s + a)", 4) == (0, b, -a * b, a**2 * b)


def pairs():
    factors = st.lists(
        st.tuples(polynomials(min_degree=1, max_degree=2, is_monic=True), st.integers(1, 3)),
        min_size=1,
        max_size=2,
    )
    return st.builds(
        lambda top, parts: ct.TransferFunction(top, sympy.prod([p**k for p, k in parts])),
        polynomials(max_degree=5),
        factors,
    )


@given(pairs())
def test_partial_fractions(G):
    fractions = ct.partial_fractions(G)
    assert fractions.certificate.holds
    for term in fractions.terms:
        assert term.numerator.degree() < term.factor.degree() and term.factor.is_irreducible
    whole = fractions.polynomial.as_expr() + sum(
        term.numerator.as_expr() / term.factor.as_expr() ** term.power for term in fractions.terms
    )
    assert sympy.together(whole - sympy.apart(G.as_expr(), s)).expand() == 0


def test_published_expansions():
    """Ogata's example of a double pole; shared factors have no term."""
    assert str(ct.partial_fractions("(s**2 + 2*s + 3)/(s + 1)**3")) == (
        "(1)/(s + 1) + (2)/(s + 1)**3"
    )
    assert str(ct.partial_fractions("(s + 1)/((s + 1)*(s + 2))")) == "(1)/(s + 2)"


def test_symbols():
    fractions = ct.partial_fractions(ct.transfer_function("1/((s + a)*(s + b))", "s"))
    a, b = sympy.symbols("a b")
    assert {sympy.simplify(t.numerator.as_expr() * (a - b)) for t in fractions.terms} == {1, -1}


def test_bad_input():
    with pytest.raises(ImproperError):
        ct.markov_parameters("s", 2)
    for count in (0, -1, 1.5, True):
        with pytest.raises(ct.InputError, match="positive integer"):
            ct.markov_parameters("1/s", count)
    with pytest.raises(BudgetError):
        ct.markov_parameters("1/s", 10**9)


@pytest.mark.parametrize(
    "text", ["a/(s*(s + sqrt(2)))", "1/((s + a)*(s + sqrt(2)))", "1/((s + a)**2*(s + sqrt(3)))"]
)
def test_surds_beside_symbols(text):
    """Factors over Q(sqrt(2))(a), a field that SymPy's polynomials do not choose."""
    fractions = ct.partial_fractions(text, "s")
    assert fractions.certificate.holds
    assert all(term.factor.degree() == 1 for term in fractions.terms)
