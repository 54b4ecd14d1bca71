"""Greatest common divisors over fields of symbols, by roots that are known."""

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import polynomial
from compensator_theory.polynomials._multivariate import common_divisor_by_flint
from compensator_theory.polynomials._poly import common_divisor, monic
from compensator_theory.sampling import matched

s, a, b = sympy.symbols("s a b")
ROOTS = [a, b, a + b, a * b, 1 / a, b / (a + 1), sympy.Integer(2), -a]


def product(roots, factor=1):
    return polynomial(sympy.expand(factor * sympy.prod(s - r for r in roots)), "s")


@given(*[st.lists(st.sampled_from(ROOTS), max_size=3)] * 3)
def test_shared_roots_are_the_greatest_common_divisor(shared, one, two):
    p, q = product([*shared, *one], a + 2), product([*shared, *two], b)
    both = list(shared)
    rest = list(two)
    for root in one:
        if root in rest:
            rest.remove(root)
            both.append(root)
    assert common_divisor(p, q) == product(both)
    result = common_divisor_by_flint(p, q)
    assert result is None or monic(result) == common_divisor(p, q)


@pytest.mark.costly
def test_what_sympys_heuristic_gives_up_on():
    """Its gcd raises HeuristicGCDFailed in the field of e^-h and tan(h/2)."""
    sampled = matched("(s**2 + 1)**2/((s + 1)**2 + 1)**2", "1/10").realisation
    assert sampled.transfer_function().reduced().order == 4
