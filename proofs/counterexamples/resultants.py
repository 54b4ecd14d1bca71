"""Appendix B as it is worded."""

from collections.abc import Iterator

from sympy import Matrix

from compensator_theory import polynomial
from compensator_theory.bezout import sylvester_m1, sylvester_m2
from compensator_theory.matrices._linear_algebra import determinant, rank

Facts = Iterator[tuple[str, bool]]


def both_leading_zeros() -> Facts:
    """a = 0 s^2 + s + 1, b = 0 s + 5: with a_k = 0 = b_l the rank counts a root at infinity."""
    matrix = sylvester_m1([0, 1, 1], [0, 5], 2, 1)
    yield "k + l - rank M_1(a, b) = 1", 3 - rank(matrix) == 1
    yield "gcd(a, b) = 1", polynomial("s + 1").gcd(polynomial("5", "s")).degree() == 0


def more_rows_for_b() -> Facts:
    """k = 1 < l = 2, as in Example B.2: l <= k of the text is violated, and the theorem holds."""
    a, b = polynomial("s + 1"), polynomial("(s + 1)*(s + 2)")
    yield "k + l - rank M_1(a, b) = 1", 3 - rank(sylvester_m1(a, b, 1, 2)) == 1
    yield "gcd(a, b) = s + 1", a.gcd(b) == a


def multiple_roots() -> Facts:
    """a = (s + 1)^2 (s + 2), b = (s + 1)^2: one distinct common root, and k + l - rank = 2."""
    a, b = polynomial("(s + 1)**2*(s + 2)"), polynomial("(s + 1)**2")
    yield "k + l - rank M_1(a, b) = 2", 5 - rank(sylvester_m1(a, b, 3, 2)) == 2
    yield "the one distinct common root is -1", a.gcd(b).sqf_part() == polynomial("s + 1")


def leading_zeros() -> Facts:
    """k = 3, l = 1: b gets k - l = 2 leading zeros; with the k + l - 1 = 3 of the remark there are
    more coefficients than M_2 has room for.
    """
    a, b = [2, 3, 5, 7], [1, 4]
    padded = [0] * 2 + b
    M_2 = sylvester_m2(a, padded)
    yield "with k - l zeros b has k + 1 coefficients", len(padded) == len(a)
    yield "with k + l - 1 it has k + 2", len([0] * 3 + b) == len(a) + 1
    ratio = determinant(M_2) / determinant(sylvester_m1(a, b, 3, 1))
    yield "det M_2 = a_k^(k - l) det M_1", ratio == 2**2
    yield "M_2 is 2k x 2k", Matrix(M_2).shape == (6, 6)
