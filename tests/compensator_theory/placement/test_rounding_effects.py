"""Whether rounding is dangerous: what is decided without roots, against the roots."""

from hypothesis import assume, given
from hypothesis import strategies as st

from compensator_theory import locate_roots, polynomial
from compensator_theory.placement._rounding_effects import (
    RoundingEffect,
    are_far,
    is_stable,
    stay_close,
)
from compensator_theory.strategies import polynomials

PAIRS = st.sampled_from("sz").flatmap(
    lambda s: st.tuples(
        polynomials(s, min_degree=1, max_degree=6),
        polynomials(s, max_degree=6),
        st.integers(0, 9),
    )
)


@given(PAIRS)
def test_the_bounds_and_the_roots_agree(drawn):
    before, change, digits = drawn
    assume(change.degree() < before.degree())
    after = before + change.quo_ground(10**digits)
    effect = RoundingEffect(before, after, is_stable(before), is_stable(after))
    if stay_close(before, after):
        assert effect.share <= 0.1
    if are_far(before, after):
        assert effect.share > 0.1
    assert effect.is_dangerous == (effect.is_lost or effect.share > 0.1)


# Real parts of integers that differ: every root is at least 1 from the others and from the axis.
SEPARATED = st.dictionaries(
    st.integers(-6, 6).filter(bool), st.integers(0, 7), min_size=1, max_size=3
)


@given(SEPARATED, st.integers(1, 9), st.integers(7, 12))
def test_a_small_change_is_proved_small(parts, leading, digits):
    before = polynomial("s").one.mul_ground(leading)
    for real, imaginary in parts.items():
        factor = f"(s - ({real}))**2 + {imaginary}**2" if imaginary else f"s - ({real})"
        before *= polynomial(factor, "s")
    assert stay_close(before, before + before.one.mul_ground(leading).quo_ground(10**digits))


@given(polynomials("s", min_degree=1, max_degree=6), st.integers(0, 5))
def test_a_large_change_of_any_coefficient_is_proved_large(before, index):
    k = 1 + index % before.degree()
    reach = 2 + sum(abs(c / before.LC()) for c in before.all_coeffs())
    far = (10 * before.degree() * reach) ** k * before.LC()
    after = before + far * before.one.mul_ground(1) * before.gen ** (before.degree() - k)
    assert are_far(before, after)


@given(polynomials("s", min_degree=1, max_degree=6), polynomials("z", min_degree=1, max_degree=6))
def test_stability_by_coefficients_and_by_roots(continuous, discrete):
    assert is_stable(continuous) == (
        locate_roots(continuous, time="continuous").stable == continuous.degree()
    )
    assert is_stable(discrete) == (
        locate_roots(discrete, time="discrete").stable == discrete.degree()
    )
