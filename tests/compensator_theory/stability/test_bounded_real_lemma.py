"""Certificates of the bounded real lemma, held against the exact H-infinity norm."""

from dataclasses import replace
from fractions import Fraction

import flint
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from sympy import Matrix, Rational, symbols

from compensator_theory import decide_bounded_real, h_infinity_norm
from compensator_theory.matrices._definiteness import is_positive_definite
from compensator_theory.stability._bounded_real_lemma import GainBound

entries = st.integers(-4, 4)
z = symbols("z")


@st.composite
def systems(draw):
    """Stable A = N/8 of order 1 or 2, B, C of one or two inputs and outputs; none is zero."""
    n, m, p = draw(st.integers(1, 2)), draw(st.integers(1, 2)), draw(st.integers(1, 2))
    A = [[Rational(draw(entries), 8) for _ in range(n)] for _ in range(n)]
    B = [[draw(entries) for _ in range(m)] for _ in range(n)]
    C = [[Rational(draw(entries), 4) for _ in range(n)] for _ in range(p)]
    A, B, C = Matrix(A), Matrix(B), Matrix(C)
    G = (C * (z * Matrix.eye(n) - A).inv() * B).applyfunc(lambda e: e.cancel())
    assume(any(G))
    assume(max(sum(abs(e) for e in A.row(i)) for i in range(n)) < 1)
    return A, B, C, G


def in_flint(matrix):
    rows = [[flint.fmpq(int(e.p), int(e.q)) for e in row] for row in matrix.tolist()]
    return flint.fmpq_mat(rows)


def bound(A, B, C, rate=1):
    R = flint.fmpq_mat([[int(i == j) for j in range(B.cols)] for i in range(B.cols)])
    return GainBound(in_flint(A), in_flint(B), in_flint(C), R, flint.fmpq(rate))


@pytest.mark.costly
@settings(max_examples=40)
@given(systems())
def test_it_is_proved_below_the_norm_and_not_above(system):
    A, B, C, G = system
    norm = Rational(float(h_infinity_norm(G.tolist()).enclosure))
    for factor, holds in ((Rational(9999, 10000), True), (Rational(10001, 10000), False)):
        scaled = bound(A, B, C * factor / norm)
        P = scaled.certificate()
        assert (P is not None) == holds
        if holds:
            assert scaled.is_proved_by(P)
            assert decide_bounded_real((G * factor / norm).tolist()).holds


@given(systems(), st.sampled_from([Fraction(9, 10), Fraction(1, 2)]))
def test_a_rate_below_one_is_the_bound_of_the_system_that_is_scaled_by_it(system, rate):
    A, B, C, _ = system
    at_rate = bound(A, B, C, flint.fmpq(rate.numerator, rate.denominator))
    scaled = bound(A / Rational(rate), B / Rational(rate), C)
    for one, other in ((at_rate, scaled), (scaled, at_rate)):
        if (P := one.certificate()) is not None:
            assert other.is_proved_by(P)


def test_an_unstable_mode_that_the_output_does_not_see_is_refused():
    """T is 1/(4z - 2) with or without the second state, at 1.01."""
    A, B = Matrix([[Rational(1, 2), 0], [0, Rational(101, 100)]]), Matrix([[Rational(1, 4)], [0]])
    assert bound(A[:1, :1], B[:1, :], Matrix([[1]])).certificate() is not None
    assert bound(A, B, Matrix([[1, 1]])).certificate() is None


def test_a_matrix_that_is_not_symmetric_or_of_another_size_proves_nothing():
    one = bound(Matrix([[Rational(1, 2)]]), Matrix([[1]]), Matrix([[Rational(1, 4)]]))
    P = one.certificate()
    assert one.is_proved_by(P)
    assert not one.is_proved_by(flint.fmpq_mat(2, 2, [P[0, 0], 0, 0, P[0, 0]]))
    assert not one.is_proved_by(-P)


@pytest.mark.costly
@settings(max_examples=40)
@given(systems(), st.data())
def test_a_direct_term_counts_and_the_largest_matrix_is_above_the_other(system, data):
    A, B, C, G = system
    D = Matrix(C.rows, B.cols, lambda i, j: Rational(data.draw(entries), 4))
    whole = (G + D).applyfunc(lambda e: e.cancel())
    assume(any(whole))
    norm = Rational(float(h_infinity_norm(whole.tolist()).enclosure))
    for factor, holds in ((Rational(999, 1000), True), (Rational(1001, 1000), False)):
        scaled = replace(bound(A, B, C * factor / norm), D=in_flint(D * factor / norm))
        P, largest = scaled.certificate(), scaled.largest_certificate()
        assert (P is not None) == (largest is not None) == holds
        if P is not None and largest is not None:
            assert scaled.is_proved_by(largest)
            # no P that proves it exceeds the largest one, but for its slack
            assert is_positive_definite(largest * flint.fmpq(1001, 1000) - P)
