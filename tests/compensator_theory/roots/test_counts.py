"""Roots of higher degrees: Descartes and Routh in balls against exact chains and planted roots."""

from fractions import Fraction

import flint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import certified_roots, count_roots, locate_roots, polynomial
from compensator_theory.matrices._flint_polynomials import (
    from_flint_polynomial,
    to_flint_polynomial,
)
from compensator_theory.results import RootCount
from compensator_theory.roots import _counts as counts
from compensator_theory.roots import number_of_real_roots
from compensator_theory.roots._descartes import _sign, distinct_real_roots

S = polynomial("s").gen
REAL = st.fractions(-9, 9, max_denominator=8)
PAIRS = st.tuples(REAL, st.fractions(Fraction(1, 8), 9, max_denominator=8))


def planted(real, pairs):
    poly = flint.fmpq_poly([1])
    for root in real:
        poly *= flint.fmpq_poly([-flint.fmpq(root.numerator, root.denominator), 1])
    for a, b in pairs:
        square = a * a + b * b
        poly *= flint.fmpq_poly([
            flint.fmpq(square.numerator, square.denominator),
            -2 * flint.fmpq(a.numerator, a.denominator), 1,
        ])  # fmt: skip
    return from_flint_polynomial(poly, S)


@given(st.lists(REAL, max_size=12), st.lists(PAIRS, max_size=8))
def test_planted_roots_of_higher_degree(real, pairs):
    poly = planted(real, pairs)
    assert number_of_real_roots(poly) == len(real)
    signs = real + [a for a, _ in pairs for _ in range(2)]
    expected = RootCount(
        sum(r < 0 for r in signs), sum(r == 0 for r in signs), sum(r > 0 for r in signs)
    )
    assert count_roots(poly, time="continuous") == expected


@given(st.lists(st.integers(-50, 50), min_size=14, max_size=30).filter(lambda c: c[0]))
def test_routh_in_balls_and_in_full_and_the_roots_agree(descending):
    poly = polynomial(descending, "s")
    whole = flint.fmpz_poly(descending[::-1])
    assert counts._count_in_balls(whole) in (None, counts._count_by_chain(whole))
    assert count_roots(poly, time="continuous") == locate_roots(poly, time="continuous")
    assert number_of_real_roots(poly) == sum(r.multiplicity * r.is_real for r in
                                             certified_roots(poly))  # fmt: skip


def test_symmetric_roots_are_taken_out_and_a_singular_array_is_left_to_the_chain():
    for text, expected in {
        "(s + 1)**9*(s - 2)**7": RootCount(9, 0, 7),
        "(s + 1)**9*(s**2 + 1)**3*s": RootCount(9, 7, 0),
        "(s + 1)**9*(s**4 + 4)*(s**2 - 9)": RootCount(12, 0, 3),
    }.items():
        assert counts._count_in_balls(to_flint_polynomial(polynomial(text)).numer()) == expected
    singular = polynomial("s**15 + s**14 + 2*s**13 + 2*s**12 + 3")  # a zero in the first column
    assert counts._count_in_balls(to_flint_polynomial(singular).numer()) is None
    assert count_roots(singular, time="continuous") == locate_roots(singular, time="continuous")


@pytest.mark.parametrize("degree", [30, 60])
def test_roots_that_almost_coincide_are_left_to_sturm(degree):
    poly = polynomial(f"s**{degree} - 2*(1000*s - 1)**2")  # Mignotte: two at a distance of 1e-45
    integers = flint.fmpz_poly([int(c) for c in reversed(poly.all_coeffs())])
    assert distinct_real_roots(integers) is None and number_of_real_roots(poly) == 4


def test_a_zero_in_the_first_column_is_no_sign():
    """A zero row, pivots 1, 2, 1, 4, and those of the polynomial in -s."""
    assert counts._first_column([flint.fmpz(1)] * 4) is None
    assert counts._first_column([flint.fmpz(c) for c in (1, 2, 3, 4)]) == [True] * 4
    assert counts._first_column([flint.fmpz(c) for c in (1, -2, 3, -4)]) == [
        True,
        False,
        True,
        False,
    ]


def test_signs_that_balls_do_not_decide_are_exact():
    poly = flint.fmpz_poly([-2, 0, 1]) * flint.fmpz_poly([-1, 3])
    balls = flint.arb_poly(poly)
    root = flint.fmpq(int(flint.fmpz(2 << 10_000).isqrt()), 1 << 5_000)  # below, by 2**-5000
    places = [root, root + flint.fmpq(1, 1 << 5_000), flint.fmpq(1, 3), flint.fmpq(0)]
    assert [_sign(poly, balls, place) for place in places] == [-1, 1, 0, 1]
