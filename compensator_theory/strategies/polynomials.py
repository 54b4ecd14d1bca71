"""Numbers and polynomials for Hypothesis."""

from __future__ import annotations

from hypothesis import strategies as st
from sympy import QQ, Poly, Rational, Symbol

from compensator_theory.polynomials._poly import canonical


def rationals(max_numerator: int = 9, max_denominator: int = 4) -> st.SearchStrategy[Rational]:
    """Draw rational numbers with small numerators and denominators; they shrink to 0.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import rationals
    >>> @given(rationals(5, 3))
    ... def check(x):
    ...     assert abs(x) <= 5 and x.q <= 3
    >>> check()
    """
    numerators = st.integers(-max_numerator, max_numerator)
    return st.builds(Rational, numerators, st.integers(1, max_denominator))


def nonzero_rationals(
    max_numerator: int = 9, max_denominator: int = 4
) -> st.SearchStrategy[Rational]:
    """Draw rational numbers other than 0; they shrink to 1.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import nonzero_rationals
    >>> @given(nonzero_rationals())
    ... def check(x):
    ...     assert x != 0
    >>> check()
    """
    numerators = st.integers(-max_numerator, max_numerator - 1).map(lambda k: k + (k >= 0))
    return st.builds(Rational, numerators, st.integers(1, max_denominator))


@st.composite
def polynomials(
    draw: st.DrawFn,
    variable: str = "s",
    min_degree: int = 0,
    max_degree: int = 4,
    is_monic: bool = False,
) -> Poly:
    """Draw rational polynomials whose degree lies in the given range (zero excluded)."""
    degree = draw(st.sampled_from(range(min_degree, max_degree + 1)))
    leading = Rational(1) if is_monic else draw(nonzero_rationals())
    rest = draw(st.lists(rationals(), min_size=degree, max_size=degree))
    return canonical(Poly([leading, *rest], Symbol(variable)))


@st.composite
def coprime_pairs(draw: st.DrawFn, variable: str = "s", max_degree: int = 4) -> tuple[Poly, Poly]:
    """Draw (a, b) without a common root; a is monic of degree 1 or more, deg b < deg a, b != 0.

    With the defaults some two in five have a root of a with multiplicity 2 or 3, and as many a
    constant b, where a has the degree 1 or by choice.

    Where b shares a root with a, the least of 1, 2, ... that removes it is added to b: each of the
    deg a roots rules out one number.
    """
    # lower degrees come first, to shrink to, and are the rarer ones
    degree = draw(st.sampled_from([1, *(d for d in range(2, max_degree + 1) for _ in range(2))]))
    multiplicity = draw(st.sampled_from([1, 1, 1, 1, 2, 2, 3])) if degree > 1 else 1
    a = draw(polynomials(variable, degree, degree, is_monic=True))
    if multiplicity > 1:
        root, times = draw(rationals()), min(multiplicity, degree)
        rest = draw(polynomials(variable, degree - times, degree - times, is_monic=True))
        a = Poly([1, -root], Symbol(variable), domain=QQ) ** times * rest
    highest = draw(st.sampled_from([0, *(d for d in range(1, degree) for _ in range(3))]))
    return canonical(a), coprime_to(a, draw(polynomials(variable, highest, highest)))


def coprime_to(a: Poly, b: Poly) -> Poly:
    """Add the least nonnegative integer to b that makes it coprime to a (deg a > 0, not zero)."""
    while b.is_zero or a.gcd(b).degree() > 0:
        b += 1
    return canonical(b)
