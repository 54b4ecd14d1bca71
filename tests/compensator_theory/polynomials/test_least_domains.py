"""The least domain of a polynomial with symbols, against SymPy's retract."""

from hypothesis import given
from hypothesis import strategies as st
from sympy import QQ, ZZ, Poly, Symbol, symbols

from compensator_theory.polynomials._formatting import in_least_domain

s, a, b, c = symbols("s a b c")
SORTED = [Symbol("x_10"), Symbol("x_2"), a]
DOMAINS = [QQ[a, b, c], ZZ[b, a], QQ[tuple(SORTED)], QQ.frac_field(a, b, c), ZZ.frac_field(c, a),
           QQ.frac_field(c, b)]  # fmt: skip
COEFFICIENTS = st.tuples(
    st.integers(-3, 3), st.integers(0, 2), st.integers(0, 2), st.integers(0, 2), st.integers(1, 3)
)


def value(drawn, domain):
    factor, place, power, below, divisor = drawn
    symbol = domain.symbols[place % len(domain.symbols)]
    other = domain.symbols[below % len(domain.symbols)]
    number = factor * symbol**power + (0 if domain.domain.is_ZZ else QQ.to_sympy(QQ(1, divisor)))
    return number / (other + 1) if domain.is_FractionField and below else number


@given(st.sampled_from(DOMAINS), st.lists(COEFFICIENTS, min_size=1, max_size=4))
def test_it_is_the_one_that_is_found_by_reading_the_coefficients_again(domain, drawn):
    poly = Poly([value(d, domain) for d in drawn], s, domain=domain)
    expected = poly.retract()
    over = expected.domain
    expected = expected.set_domain(QQ if over.is_ZZ else over.set_domain(QQ) if over.is_Composite
                                   else over)  # fmt: skip
    result = in_least_domain(poly)
    assert (
        result == expected and result.domain == expected.domain and hash(result) == hash(expected)
    )


def test_other_domains_are_left_alone():
    assert in_least_domain(Poly(s + 1, s, domain=QQ)) is None
    assert (
        in_least_domain(Poly(s + a, s, domain=QQ.algebraic_field(2 ** QQ.to_sympy(QQ(1, 2)))[a]))
        is None
    )
