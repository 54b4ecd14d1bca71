"""Plants with exponentials as coefficients: compared with rational plants 1e-34 away, and ties."""

from fractions import Fraction

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import Poly, Rational, Symbol, exp

import compensator_theory as exact
from compensator_theory import (
    count_roots,
    decide_stability,
    h_infinity_norm,
    stability_margins,
    transfer_function,
)
from compensator_theory.errors import ImproperError, InputError, NoSolutionError
from compensator_theory.polynomials._poly import canonical
from compensator_theory.roots._enclosures import Enclosure
from compensator_theory.roots._independent_numbers import IndependentNumbers
from compensator_theory.sampling import first_order_hold, zero_order_hold
from compensator_theory.stability._nearest_margins import CrossingGains
from tests.support.structure_cases import fewer

x, z = sympy.symbols("x z")
NEAR = Rational(1, 10**20)

PLANTS = st.sampled_from(
    [
        "1/(10*s + 1)", "1/s", "2/((s + 1)*(2*s + 1))", "1/(s**2 + s + 1)", "3/(s*(s + 1))",
        "(s + 2)/((s + 1)*(s + 3))", "(1 - s)/((s + 1)*(s + 2))", "1/(s**2 + 2*s - 1)",
        "5/(s + 1)**3", "1/(s - 1)",
    ]
)  # fmt: skip
STEPS = st.sampled_from([Rational(1, 10), Rational(1, 2), Rational(2)])


def rational_neighbour(sampled):
    values = {name: Rational(str(value.evalf(34))) for name, value in sampled.exponentials}
    return sampled.realisation.subs(values)


def centres(enclosures):
    return [getattr(e, "centre", e) for e in enclosures]


def agree(mine, theirs):
    assert len(mine) == len(theirs)
    for one, other in zip(mine, theirs, strict=True):
        assert abs(sympy.N(one - other, 40)) <= NEAR * max(1, abs(other))


@pytest.mark.costly
@fewer(3)
@given(PLANTS, STEPS, st.sampled_from(["1", "1/3", "(z - 1/2)/(z + 1/3)", "-2"]))
def test_margins_are_those_of_a_rational_plant_close_by(plant, step, compensator):
    sampled = zero_order_hold(plant, step)
    mine = stability_margins(sampled, compensator, feedback=-1)
    theirs = stability_margins(rational_neighbour(sampled), compensator, feedback=-1)
    if theirs.is_real or (
        0 in (theirs.hidden.degree(), mine.hidden.degree())
        and (mine.hidden.degree() != theirs.hidden.degree())
    ):
        return  # 1e-34 from a common root is none
    assert (mine.open_loop, mine.closed_loop) == (theirs.open_loop, theirs.closed_loop)
    assert mine.is_stable == theirs.is_stable and mine.encirclements == theirs.encirclements
    for name in ("frequency", "phase_margin", "delay"):
        agree(
            centres(getattr(c, name) for c in mine.gain_crossovers),
            centres(getattr(c, name) for c in theirs.gain_crossovers),
        )
    agree(
        centres(c.gain_enclosure for c in mine.phase_crossovers),
        centres(c.gain_enclosure for c in theirs.phase_crossovers),
    )
    for name in ("gain_up", "gain_down", "phase", "phase_lag", "phase_lead"):
        one, other = getattr(mine, name), getattr(theirs, name)
        assert (one is None) == (other is None)
        if one is not None:
            printed, expected = (float(str(margin).split()[0]) for margin in (one, other))
            assert printed == pytest.approx(expected, rel=1e-5), name


@fewer(3)
@given(PLANTS, STEPS)
def test_the_norm_is_that_of_a_rational_plant_close_by(plant, step):
    sampled = zero_order_hold(plant, step)
    if decide_stability(sampled).is_stable:
        mine = h_infinity_norm(sampled)
        agree(
            [mine.enclosure.centre], [h_infinity_norm(rational_neighbour(sampled)).enclosure.centre]
        )
    else:
        with pytest.raises(NoSolutionError, match="not stable"):
            h_infinity_norm(sampled)


ROOTS = st.sampled_from(
    [x, 1 / x, x**2, -x, 1 - x, 1, -1, 2, Rational(1, 3), 1 + x, x / (1 + x), 0]
)
PAIRS = st.sampled_from([z**2 + 1, z**2 + x * z + 1, z**2 + x, z**2 - 3 * x * z + 9, x * z**2 + 1])


@fewer(3)
@given(st.lists(ROOTS, max_size=4), st.lists(PAIRS, max_size=2))
def test_planted_roots_are_counted(roots, pairs):
    """The moduli of the planted roots, as SymPy evaluates them; ties are planted as such."""
    p = sympy.prod([z - r for r in roots] + pairs)
    if not (roots or pairs):
        return
    number = exp(Rational(-1, 10))
    moduli = [abs(sympy.sympify(r).subs(x, number)) for r in roots]
    for pair in pairs:
        a, b, c = Poly(pair, z).all_coeffs()
        moduli += [sympy.sqrt((c / a).subs(x, number))] * 2  # complex pairs
        assert (b**2 - 4 * a * c).subs(x, number) < 0
    count = IndependentNumbers(((x, number),)).count(
        canonical(Poly(sympy.expand(p), z)), "discrete"
    )
    expected = [sum(1 for m in moduli if sympy.sign(m - 1) == sign) for sign in (-1, 0, 1)]
    assert [count.stable, count.boundary, count.unstable] == expected


def test_ties_are_decided():
    """1 + L = 0 exactly at z = -1: (1 + exp(-1)) / (z - exp(-1)) at z = -1 is -1."""
    answer = stability_margins("(1 + exp(-1))/(z - exp(-1))", feedback=-1)
    assert answer.closed_loop.boundary == 1 and not answer.is_stable
    sampled = zero_order_hold("1/(s + 1)", 1)
    hidden = stability_margins(sampled, "(z - exp(-1))/z", feedback=-1)
    assert hidden.hidden.degree() == 1 and hidden.is_stable
    with pytest.raises(ImproperError, match="not well posed"):
        stability_margins("exp(-1)", "-exp(1)", feedback=-1, variable="z")
    all_pass = stability_margins("(z*exp(-1) - 1)/(z - exp(-1))", feedback=-1)
    assert all_pass.gain_crossovers == () and all_pass.closed_loop.boundary == 1


def test_two_parts_share_their_exponential():
    """exp(-1/10) and exp(-1/15) are powers of exp(-1/30); the loop has the difference of no two."""
    answer = stability_margins("1/(z - exp(-1/10))", "(z - exp(-1/15))/z", feedback=-1)
    ((_, value),) = answer.exponentials
    assert value == exp(Rational(-1, 30)) and answer.hidden.degree() == 0


def test_texts_and_objects_are_read_alike():
    typed = transfer_function("(1 - exp(-1/10))/(z - exp(-1/10))")
    sampled = zero_order_hold("1/(10*s + 1)", 1)
    values = [h_infinity_norm(G).enclosure.centre for G in (typed, sampled, str(typed))]
    agree(values, [1, 1, 1])
    assert decide_stability("z - exp(-1/10)").is_stable
    assert not decide_stability("z - exp(1/10)").is_stable
    assert count_roots("(z - exp(-1))*(z - exp(1))*(z + 1)**2").boundary == 2
    assert decide_stability(first_order_hold("1/(s + 1)", "1/2")).is_stable


def test_continuous_time():
    """1/(s + exp(-1)): crossover at sqrt(1 - exp(-2)), norm exp(1)."""
    answer = stability_margins("1/(s + exp(-1))", feedback=-1)
    (crossover,) = answer.gain_crossovers
    agree([crossover.frequency.centre], [sympy.sqrt(1 - exp(-2))])
    agree([h_infinity_norm("1/(s + exp(-1))").enclosure.centre], [sympy.E])


@pytest.mark.parametrize(
    "plant",
    ["1/(z - exp(-sqrt(2)))", "1/(z - exp(-a))", "sqrt(2)/(z - exp(-1))", "1/(z - exp(-pi))"],
)
def test_other_numbers_are_refused(plant):
    for function in (h_infinity_norm, lambda G: stability_margins(G, feedback=-1)):
        with pytest.raises(InputError):
            function(plant)


def test_symbols_without_a_value_are_refused():
    for sampled in (zero_order_hold("1/(s + 1)"), zero_order_hold("1/(s + a)", 1)):
        with pytest.raises(InputError, match="substitute"):
            stability_margins(sampled, feedback=-1)
    with pytest.raises(InputError, match="frequencies"):
        stability_margins(
            zero_order_hold("1/(s**2 + 1)", 1), zero_order_hold("1/(s**2 + 2)", 1), feedback=-1
        )
    assert exact.decide_stability(zero_order_hold("1/(s + 1)")).is_stable is None
    assert Symbol("x") in zero_order_hold("1/(s + 1)").realisation.A.free_symbols


class Gains(CrossingGains):
    is_stable = True

    def __init__(self, factors):
        self.factors = factors

    def _factors(self):
        return [(factor, None) for factor in self.factors]


ROUNDED = Rational(1, 10**30)
GAINS = st.fractions(Fraction(1, 50), 100, max_denominator=50).filter(lambda g: g != 1)


@given(st.lists(st.tuples(GAINS, st.sampled_from([Rational(0), ROUNDED])), max_size=6))
def test_gain_margins_are_the_nearest_factors_whether_exact_or_enclosed(factors):
    loop = Gains([Enclosure(Rational(g.numerator, g.denominator), r) for g, r in factors])
    gains = [Rational(g.numerator, g.denominator) for g, _ in factors]
    low, high = loop.gain_down.value, loop.gain_up.value
    assert getattr(low, "centre", low) == max([g for g in gains if g < 1], default=0)
    assert getattr(high, "centre", high) == min([g for g in gains if g > 1], default=sympy.oo)


@pytest.mark.parametrize(
    ("loop", "step", "symbols"),
    [("k/(10*s + 1)", 1, "k"), ("1/(10*s + 1)", "T", "T"), ("k/(10*s + a)", "T", "T, a, k")],
)
def test_a_refusal_names_unknown_symbols_alone(loop, step, symbols):
    """The exponentials have symbols, too, and those are known."""
    sampled = zero_order_hold(loop, step)
    with pytest.raises(InputError, match=f"substitute numbers for {symbols}$"):
        stability_margins(sampled, feedback=-1)
    with pytest.raises(InputError, match=f"substitute numbers for {symbols}$"):
        h_infinity_norm(sampled)


@pytest.mark.parametrize("gain", [-1, -2, 1])
def test_the_other_sign_of_a_sampled_loop(gain):
    pair = [stability_margins(f"{gain}/(z - exp(1/10))", feedback=sign) for sign in (-1, 1)]
    for one, other in (pair, pair[::-1]):
        assert ("with the other sign" in str(one)) == (other.is_stable and not one.is_stable)
