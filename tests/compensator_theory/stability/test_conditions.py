"""Conditions on numbers: Hurwitz's determinants as they are defined, also where one is zero."""

import pytest
import sympy
from hypothesis import example, given
from hypothesis import strategies as st
from sympy import Matrix, Poly, Rational

from compensator_theory import stability_conditions
from tests.support.work import at_most

s = sympy.Symbol("s")
numbers = st.sampled_from([0, 1, -1, 2, -3, 5, Rational(1, 3), Rational(-7, 4)])


@given(st.lists(numbers, min_size=2, max_size=8))
@example([1, 1, 2, 2, 1, 1])  # the second determinant is zero, not the fourth
@example([1, 0, 2, 0, 1])
def test_numbers_that_are_no_conditions_are_positive_determinants(coefficients):
    p = Poly([1, *coefficients], s)
    n, a = int(p.degree()), p.all_coeffs()

    def entry(i, j):
        k = 2 * (j + 1) - (i + 1)
        return a[k] if 0 <= k <= n else 0

    chosen = [p.nth(k) for k in [0, *range(1 + n % 2, n, 2)]]
    minors = [Matrix(k, k, entry).T.det() for k in range(n - 1, 1, -2)]
    listed = [sympy.sign(c) for c in stability_conditions(p)]
    negative = {sympy.sign(c) for c in [*chosen, *minors] if c <= 0}
    assert set(listed) == negative


@pytest.mark.parametrize("unstable", [False, True])
def test_determinants_of_a_hundred_numbers_come_from_one_array(unstable):
    roots = [Rational(-k, 10) for k in range(1, 80)] + [Rational(1 if unstable else -1, 7)]
    p = Poly(1, s)
    for root in roots:
        p *= Poly(s - root, s)
    with at_most(1_000_000):  # one determinant after the other takes 15 times as many
        conditions = stability_conditions(p)
    assert (len(conditions) > 0) == unstable
