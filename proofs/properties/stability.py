"""Stability from coefficients, parity of real roots, all compensators by one parameter."""

from hypothesis import assume
from hypothesis import strategies as st
from sympy import Expr, Poly, Rational, Symbol

from compensator_theory import (
    TransferFunction,
    bezout_identity,
    decide_interval_stability,
    decide_stability,
    decide_strong_stabilisability,
    place_poles,
    polynomial_from_roots,
    stabilising_compensators,
)
from compensator_theory.strategies import (
    boundary_polynomials,
    coprime_pairs,
    hurwitz_spectra,
    polynomials,
    rationals,
    schur_spectra,
    spectra,
    strictly_proper_plants,
)

from ..ledger.checks import for_all

s, z = Symbol("s"), Symbol("z")
positive = st.builds(Rational, st.integers(1, 9), st.integers(1, 4))
sizes = st.integers(1, 5)


def _from(roots: tuple[Expr, ...], variable: str) -> Poly:
    return polynomial_from_roots(roots, variable)


continuous = st.one_of(
    sizes.flatmap(hurwitz_spectra).map(lambda roots: _from(roots, "s")),
    sizes.flatmap(spectra).map(lambda roots: _from(roots, "s")),
    boundary_polynomials("s"),
).map(lambda p: p if p.LC() > 0 else -p)
discrete = st.one_of(
    sizes.flatmap(schur_spectra).map(lambda roots: _from(roots, "z")),
    sizes.flatmap(spectra).map(lambda roots: _from(roots, "z")),
    boundary_polynomials("z"),
)


def _routh(p: Poly) -> bool:
    """Whether the coefficient before the first of every polynomial of Routh's array is positive."""
    for n in range(p.degree(), 0, -1):
        if p.nth(n - 1) <= 0:
            return False
        other = Poly({(i,): p.nth(i) for i in range(n - 1, -1, -2)}, s)
        p = p - p.nth(n) / p.nth(n - 1) * Poly(s, s) * other
    return True


@for_all(p=continuous)
def routh_array(p: Poly) -> bool:
    """Routh's array says of a polynomial what its certified roots say: whether it is Hurwitz."""
    return _routh(p) is decide_stability(p, time="continuous").by_roots


@for_all(
    roots=st.integers(2, 4).flatmap(hurwitz_spectra),
    shift=st.sampled_from([0, 0, Rational(1, 2), 1, 2]),
)
def hurwitz_inequalities(roots: tuple[Expr, ...], shift: Rational) -> bool:
    """The inequalities for degrees 2, 3 and 4 say what the certified roots say, of Hurwitz
    polynomials and of such with their roots shifted to the right.
    """
    _, *coefficients = _from(tuple(root + shift for root in roots), "s").all_coeffs()
    if len(coefficients) == 2:
        a, b = coefficients
        expected = a > 0 and b > 0
    elif len(coefficients) == 3:
        a, b, c = coefficients
        expected = a > 0 and c > 0 and c < a * b
    else:
        a, b, c, d = coefficients
        expected = a > 0 and c > 0 and d > 0 and a**2 * d < c * (a * b - c)
    p = Poly([1, *coefficients], s)
    return bool(expected) is decide_stability(p, time="continuous").by_roots


@for_all(
    center=st.integers(3, 4).flatmap(hurwitz_spectra),
    widths=st.lists(st.integers(0, 3), min_size=4, max_size=4),
    stretch=st.sampled_from([4, 16, 64]),
)
def kharitonov_polynomials(center: tuple[Expr, ...], widths: list[int], stretch: int) -> bool:
    """One polynomial for degree 3 and two for degree 4 decide what Kharitonov's four decide, where
    the lower ends are positive.
    """
    coefficients = _from(center, "s").all_coeffs()[1:]
    ends = [
        (c * (1 - Rational(w, stretch)), c * (1 + Rational(w, stretch)))
        for c, w in zip(coefficients, widths, strict=False)
    ]
    (a_1, a_2), (b_1, _), (c_1, c_2), *rest = ends
    if rest:
        ((_, d_2),) = rest
        deciding = [[1, a_1, b_1, c_2, d_2], [1, a_2, b_1, c_1, d_2]]
    else:
        deciding = [[1, a_1, b_1, c_2]]
    stable = all(decide_stability(Poly(p, s), time="continuous").by_roots for p in deciding)
    return stable is decide_interval_stability([1, *ends]).is_stable


@for_all(
    center=st.integers(3, 5).flatmap(hurwitz_spectra),
    widths=st.lists(st.integers(0, 4), min_size=6, max_size=6),
    stretch=st.sampled_from([8, 32, 128]),
    shares=st.lists(st.integers(0, 4), min_size=6, max_size=6),
)
def four_polynomials_decide_the_box(
    center: tuple[Expr, ...], widths: list[int], stretch: int, shares: list[int]
) -> bool:
    """Routh's test of the four polynomials says what the decision on the box says, and where that
    is yes, a polynomial of the box is Hurwitz.
    """
    ascending = list(reversed(_from(center, "s").all_coeffs()))
    low = [c * (1 - Rational(w, stretch)) for c, w in zip(ascending, widths, strict=False)]
    high = [c * (1 + Rational(w, stretch)) for c, w in zip(ascending, widths, strict=False)]

    def corner(even: int, odd: int) -> Poly:
        upper = [((odd if i % 2 else even) + i // 2) % 2 for i in range(len(low))]
        ends = [h if u else l for u, l, h in zip(upper, low, high, strict=True)]  # noqa: E741
        return Poly(ends[::-1], s)

    stable = all(_routh(corner(even, odd)) for even in (0, 1) for odd in (0, 1))
    box = list(zip(low, high, strict=True))[::-1]
    if stable is not decide_interval_stability(box).is_stable:
        return False
    gaps = zip(low, high, shares, strict=False)
    member = [at + (end - at) * Rational(t, 4) for at, end, t in gaps]
    return not stable or _routh(Poly(member[::-1], s))


def _schur(p: Poly) -> bool:
    """Whether a_0^2 < a_n^2 in every polynomial of the table of Schur and Cohn."""
    for n in range(p.degree(), 0, -1):
        a, b = p.nth(n), p.nth(0)
        if b**2 >= a**2:
            return False
        p = Poly([a * p.nth(i + 1) - b * p.nth(n - i - 1) for i in range(n - 1, -1, -1)], z)
    return True


@for_all(p=discrete)
def schur_table(p: Poly) -> bool:
    """The table of Schur and Cohn says what the certified roots say: whether all are inside."""
    return _schur(p) is decide_stability(p, time="discrete").by_roots


@st.composite
def quadratics_and_cubics(draw: st.DrawFn) -> Poly:
    """Draw monic polynomials of degree 2 or 3: with all roots inside the circle, with such roots
    stretched by 5/4 to 2, or any.
    """
    size, stretch = draw(st.integers(2, 3)), draw(st.sampled_from([0, 4, 5, 6, 8]))
    if stretch:
        roots = draw(schur_spectra(size))
        return _from(tuple(root * stretch / 4 for root in roots), "z")
    return Poly([1, *draw(st.lists(rationals(3, 4), min_size=size, max_size=size))], z)


@for_all(p=quadratics_and_cubics())
def jury_inequalities(p: Poly) -> bool:
    """Jury's inequalities for degrees 2 and 3 say what the certified roots say."""
    _, a, b, *rest = p.all_coeffs()
    if rest:
        (c,) = rest
        expected = abs(c) < 1 and abs(b - a * c) < 1 - c**2 and -1 - b < a + c < 1 + b
        expected = expected and 1 + a + b + c > 0
    else:
        expected = b < 1 and abs(a) < 1 + b
    return bool(expected) is decide_stability(p, time="discrete").by_roots


def _between(p: Poly, low: Rational, high: Rational) -> int:
    """Count the real roots of a polynomial between two numbers, each as often as it counts."""
    return sum(m * factor.count_roots(low, high) for factor, m in p.sqf_list()[1])


@for_all(
    roots=st.lists(rationals(), min_size=1, max_size=3),
    zeros=st.lists(positive, min_size=2, max_size=2, unique=True),
    rest=polynomials(max_degree=1),
    D_c=st.integers(0, 2).flatmap(hurwitz_spectra),
    N_c=polynomials(max_degree=2),
)
def loop_has_the_parity_of_the_plant(
    roots: list[Rational], zeros: list[Rational], rest: Poly, D_c: tuple[Expr, ...], N_c: Poly
) -> bool:
    """With a stable D_c the loop has between two positive zeros of the plant an even number of real
    roots where D has one, and an odd number where D has: not none.
    """
    low, high = sorted(zeros)
    assume(low not in roots and high not in roots)
    D = _from(tuple(roots), "s")
    N = (Poly(s, s) - low) * (Poly(s, s) - high) * rest
    loop = D * _from(D_c, "s") + N * N_c
    return (_between(loop, low, high) - _between(D, low, high)) % 2 == 0


@for_all(
    places=st.lists(st.integers(-3, 12), min_size=2, max_size=6, unique=True),
    order=st.integers(1, 6),
)
def strongly_stabilisable_plants_interlace(places: list[int], order: int) -> bool:
    """A strictly proper plant with real poles and zeros is strongly stabilisable if and only if
    between two zeros that are not negative, infinity among them, the number of poles is even.
    """
    poles = places[: max(order % len(places), len(places) // 2 + 1)]
    zeros = places[len(poles) :]
    unstable = sorted(zero for zero in zeros if zero >= 0)
    above = [sum(pole > zero for pole in poles) for zero in unstable]
    plant = TransferFunction(_from(tuple(zeros), "s"), _from(tuple(poles), "s"))
    decision = decide_strong_stabilisability(plant).is_strongly_stabilisable
    return bool(decision) is all(number % 2 == 0 for number in above)


@for_all(pair=coprime_pairs(), D_c=polynomials(max_degree=3), N_c=polynomials(max_degree=3))
def pairs_have_one_parameter(pair: tuple[Poly, Poly], D_c: Poly, N_c: Poly) -> bool:
    """Of X N + Y D = 1: Q = Y N_c - X D_c gives D_c = D~ Y - Q N and N_c = D~ X + Q D."""
    D, N = pair
    identity = bezout_identity(D, N)
    Y, X = identity.x, identity.y
    placed, Q = D * D_c + N * N_c, Y * N_c - X * D_c
    return bool((X * N + Y * D).is_one and D_c == placed * Y - Q * N and N_c == placed * X + Q * D)


@st.composite
def plants_with_spectra(
    draw: st.DrawFn,
) -> tuple[TransferFunction, tuple[Expr, ...], tuple[Expr, ...]]:
    """Draw a plant of order n and n stable poles for the regulator and for the observer."""
    plant = draw(strictly_proper_plants(max_order=2))
    spectrum = hurwitz_spectra(plant.order)
    return plant, draw(spectrum), draw(spectrum)


@for_all(case=plants_with_spectra(), gain=rationals(), pole=positive)
def compensators_of_stable_parameters(
    case: tuple[TransferFunction, tuple[Expr, ...], tuple[Expr, ...]],
    gain: Rational,
    pole: Rational,
) -> bool:
    """The observer-based compensator with a stable Q stabilises the plant, its parameter is Q, and
    with an unstable Q of degree 1 it does not.
    """
    plant, regulator, observer = case
    every = stabilising_compensators(plant, regulator, observer, feedback=-1)

    def answers(sign: int) -> tuple[bool, bool]:
        Q = TransferFunction(Poly(gain, s), Poly(s, s) + sign * pole)
        C = every.compensator(Q).transfer_function()
        parameter = every.parameter(C)[0, 0]
        loop = plant.denominator * C.denominator + plant.numerator * C.numerator
        return (
            bool(decide_stability(loop, time="continuous").is_stable),
            (parameter.numerator * Q.denominator - Q.numerator * parameter.denominator).is_zero,
        )

    return answers(1) == (True, True) and (gain == 0 or not answers(-1)[0])


@st.composite
def plants_and_poles(draw: st.DrawFn) -> tuple[TransferFunction, tuple[Expr, ...]]:
    """Draw a plant of order n and n + n_c poles, n - 1 <= n_c <= n + 1."""
    plant = draw(strictly_proper_plants(max_order=3))
    return plant, draw(spectra(2 * plant.order - 1 + draw(st.integers(0, 2))))


@for_all(case=plants_and_poles(), Q=polynomials(max_degree=2))
def placements_differ_by_one_polynomial(
    case: tuple[TransferFunction, tuple[Expr, ...]], Q: Poly
) -> bool:
    """D_0 - Q N and N_0 + Q D place what D_0 and N_0 place, and N_0 is the only numerator of them
    below the degree of D.
    """
    plant, poles = case
    D, N = plant.denominator, plant.numerator
    compensator = place_poles(plant, polynomial_from_roots(poles, "s"), feedback=-1).compensator
    D_0, N_0 = compensator.denominator, compensator.numerator
    D_c, N_c = D_0 - Q * N, N_0 + Q * D
    return bool(
        D * D_c + N * N_c == polynomial_from_roots(poles, "s")
        and N_c.rem(D) == N_0
        and N_c.degree() - D.degree() == Q.degree()
    )
