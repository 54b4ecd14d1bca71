"""Approximants and interpolation against series, Berlekamp and Massey, and Schur's algorithm."""

import mpmath
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st
from sympy import Rational

import compensator_theory as ct
from compensator_theory.errors import BudgetError, NoSolutionError
from compensator_theory.interpolation import (
    laurent_expansion,
    nevanlinna_pick,
    pade_approximant,
    partial_realisation,
)
from compensator_theory.strategies import coprime_pairs, rationals, strictly_proper_plants
from tests.support.structure_cases import fewer, transfer_matrices

s = sympy.Symbol("s")


def taylor(N, D, count):
    """Coefficients of N/D at 0 by long division in ascending powers."""
    n, d = ([p.coeff_monomial(s**k) for k in range(count)] for p in (N, D))
    result = []
    for k in range(count):
        result.append((n[k] - sum(d[j] * result[k - j] for j in range(1, k + 1))) / d[0])
    return result


@given(coprime_pairs(max_degree=3), st.integers(0, 2))
def test_a_rational_function_comes_back(pair, extra):
    D, N = pair
    assume(D.eval(0) != 0)
    m, n = max(0, N.degree()), D.degree()
    series = taylor(N, D, m + n + 2 * extra + 1)
    approximant = pade_approximant(series, m + extra, n + extra)
    assert approximant.approximant == ct.transfer_function((N, D)).reduced()


@given(st.lists(rationals(3, 3), min_size=7, max_size=7), st.integers(0, 3), st.integers(0, 3))
def test_the_series_agrees_or_there_is_none(series, m, n):
    """An approximant exists if and only if N - c D vanishes for some D with D(0) = 1."""
    table = sympy.Matrix(n, n, lambda i, j: series[m + i - j] if m + i >= j else 0)
    right = sympy.Matrix(n, 1, lambda i, _: -series[m + 1 + i])
    exists = table.rank() == table.row_join(right).rank()
    if not exists:
        with pytest.raises(NoSolutionError, match="no Pade approximant"):
            pade_approximant(series, m, n)
        return
    approximant = pade_approximant(series, m, n).approximant
    assert approximant.numerator.degree() <= m and approximant.denominator.degree() <= n
    assert taylor(approximant.numerator, approximant.denominator, m + n + 1) == series[: m + n + 1]


def test_against_mpmath():
    series = [Rational(1) / sympy.factorial(k) for k in range(8)]
    for m, n in ((3, 4), (2, 2), (4, 3)):
        approximant = pade_approximant(series, m, n).approximant
        top, bottom = mpmath.pade([float(c) for c in series[: m + n + 1]], m, n)
        scale = approximant.denominator.eval(0)
        mine = [
            [float(p.coeff_monomial(s**k) / scale) for k in range(d + 1)]
            for p, d in ((approximant.numerator, m), (approximant.denominator, n))
        ]
        assert mpmath.norm(mpmath.matrix(mine[0]) - mpmath.matrix(top)) < 1e-9
        assert mpmath.norm(mpmath.matrix(mine[1]) - mpmath.matrix(bottom)) < 1e-9


def berlekamp_massey(h):
    """The linear complexity of a sequence over the rationals."""
    C, B, length, shift, last = [Rational(1)], [Rational(1)], 0, 1, Rational(1)
    for k, value in enumerate(h):
        gap = value + sum(C[j] * h[k - j] for j in range(1, min(length, len(C) - 1) + 1))
        if gap == 0:
            shift += 1
            continue
        before = list(C)
        C = C + [Rational(0)] * (len(B) + shift - len(C))
        for j, b in enumerate(B):
            C[j + shift] -= gap / last * b
        if 2 * length <= k:
            length, B, last, shift = k + 1 - length, before, gap, 1
        else:
            shift += 1
    return length


@given(st.lists(st.integers(-2, 2).map(Rational), min_size=1, max_size=8))
def test_partial_realisation_against_berlekamp_massey(h):
    system = partial_realisation(h)
    assert system.order == berlekamp_massey(h) == system.transfer_function.order
    back = ct.markov_parameters(system.transfer_function, len(h) + 1)
    assert [sympy.sympify(c) for c in back[1:]] == h and back[0] == 0
    assert system.free_parameters == max(0, 2 * system.order - len(h))


@given(strictly_proper_plants(max_order=4))
def test_a_plant_comes_back(plant):
    h = ct.markov_parameters(plant, 2 * plant.order + 2)[1:]
    system = partial_realisation(h, "s")
    assert system.transfer_function == plant and system.is_unique
    assert ct.hankel_matrix(plant, plant.order, plant.order).rank() == system.order


def schur_verdict(points, values, gamma):
    """Schur's algorithm: each step divides by a Blaschke factor; all parameters within bounds."""
    data = [(p, sympy.expand(w / gamma)) for p, w in zip(points, values, strict=True)]
    while data:
        (p, rho), rest = data[0], data[1:]
        size = sympy.expand(rho * sympy.conjugate(rho))
        if size > 1:
            return False
        if size == 1:
            return all(w == rho for _, w in rest)
        data = []
        for q, w in rest:
            blaschke = (q - p) / (q + sympy.conjugate(p))
            moved = (
                (w - rho) / (1 - sympy.conjugate(rho) * w) / blaschke
                if sympy.expand(sympy.conjugate(rho) * w) != 1
                else None
            )
            if moved is None:
                return False
            data.append((q, sympy.radsimp(sympy.expand(moved), symbolic=False)))
    return True


@st.composite
def interpolation_data(draw, is_complex=False):
    count = draw(st.integers(1, 3))
    real = st.integers(1, 6).map(lambda k: Rational(k, 2))
    part = st.integers(-2, 2).map(lambda k: Rational(k, 2))

    def number(first):
        return first + (sympy.I * draw(part) if is_complex else 0)

    points = draw(st.lists(real, min_size=count, max_size=count, unique=True))
    values = [number(draw(part)) for _ in points]
    return [number(p) for p in points], values


@fewer(2)
@given(
    interpolation_data() | interpolation_data(is_complex=True),
    st.sampled_from([1, 2, Rational(1, 2), 5]),
)
def test_feasibility_against_schurs_algorithm(data, gamma):
    points, values = data
    interpolation = nevanlinna_pick(points, values, gamma)
    assert interpolation.is_feasible == schur_verdict(points, values, gamma)
    size = max(sympy.expand(w * sympy.conjugate(w)) for w in values)
    assert interpolation.enclosure.upper >= size  # no function is smaller than a value of it
    assert (
        interpolation.is_feasible == (interpolation.enclosure.lower <= gamma**2)
        or interpolation.is_unique
    )


@given(interpolation_data())
def test_discrete_time_is_the_half_plane_mapped(data):
    points, values = data
    assume(1 not in points)
    mapped = [(1 + p) / (1 - p) for p in points]  # |z| > 1 for p > 0
    one, other = nevanlinna_pick(points, values), nevanlinna_pick(mapped, values, variable="z")
    assert one.is_feasible == other.is_feasible and one.polynomial == other.polynomial


def test_known_bounds():
    interpolation = nevanlinna_pick([1, 2], [1, -1], 5)
    assert sympy.expand(interpolation.least_squared - (3 + 2 * sympy.sqrt(2)) ** 2) == 0
    assert not interpolation.is_feasible and nevanlinna_pick([1, 2], [1, -1], 6).is_feasible
    blaschke = nevanlinna_pick([2, 3], ["1/3", "1/2"])  # of (s - 1)/(s + 1): the only function
    assert blaschke.is_feasible and blaschke.is_unique
    assert nevanlinna_pick(["1 + 2j", "1 - 2j"], ["1/2 + j/2", "1/2 - j/2"]).is_feasible


@pytest.mark.parametrize(
    "call",
    [lambda: pade_approximant([1, 2], 1, 1), lambda: pade_approximant([1], -1, 0),
     lambda: pade_approximant([1, 2], True, 0), lambda: pade_approximant([], 0, 0),
     lambda: pade_approximant(["s"], 0, 0), lambda: pade_approximant([1] * 9, 5000, 3),
     lambda: partial_realisation([]), lambda: partial_realisation(["s"]),
     lambda: partial_realisation([float("nan")]), lambda: partial_realisation([1] * 900),
     lambda: nevanlinna_pick([1], [1, 2]), lambda: nevanlinna_pick([1, 1], [1, 2]),
     lambda: nevanlinna_pick([-1], [1]), lambda: nevanlinna_pick([1], [1], -1),
     lambda: nevanlinna_pick([1], [1], variable="z"), lambda: nevanlinna_pick(["a"], [1]),
     lambda: nevanlinna_pick("1", [1]), lambda: nevanlinna_pick([1], [1], variable="x"),
     lambda: nevanlinna_pick([sympy.sqrt(2)], [1]), lambda: nevanlinna_pick([], []),
     lambda: nevanlinna_pick([s**100000, 1], [1, 2]), lambda: pade_approximant([1], 10**5000, 0),
     lambda: pade_approximant([f"a{k}" for k in range(11)], 5, 5)],
)  # fmt: skip
def test_bad_input(call):
    with pytest.raises(ct.CompensatorError):
        call()


def test_symbols_say_where_they_hold():
    a, b = sympy.symbols("a b")
    assert pade_approximant([1, "a", "b"], 1, 1).exceptional == (a, b)
    system = partial_realisation(["a", "b"])
    assert system.order == 1 and a in system.exceptional


@pytest.mark.costly
@fewer(6)
@given(transfer_matrices(extra=1), st.sampled_from([0, -1, -2, 1, Rational(1, 3)]))
def test_laurent_against_derivatives(G, point):
    """The coefficients are derivatives of (s - p)^order G at p (Taylor)."""
    expansion = laurent_expansion(G, point, 4)
    cleared = (G.as_matrix() * (s - point) ** expansion.order).applyfunc(sympy.cancel)
    for k, coefficient in enumerate(expansion.coefficients):
        derivative = cleared.diff(s, k).applyfunc(sympy.cancel).subs(s, point)
        assert coefficient == derivative / sympy.factorial(k)
    if expansion.order:
        assert not expansion.coefficients[0].is_zero_matrix
    assert expansion[-expansion.order - 1].is_zero_matrix and expansion.certificate.holds


@fewer(3)
@given(strictly_proper_plants(max_order=3), st.integers(-2, 2))
def test_residues_against_sympy(plant, point):
    expansion = laurent_expansion(plant, point, plant.order + 1)
    assert expansion.residue[0, 0] == sympy.residue(plant.as_expr(), s, point)


def test_laurent_with_symbols_and_complex_points():
    a = sympy.Symbol("a")
    expansion = laurent_expansion("1/((s - a)*(s + 1))", "a", 2, variable="s")
    assert (
        expansion.order == 1
        and expansion.residue[0, 0] == 1 / (a + 1)
        and expansion.exceptional == (a + 1,)
    )
    assert laurent_expansion("1/(s**2 + 1)", "j", 1).residue[0, 0] == -sympy.I / 2
    for call in (
        lambda: laurent_expansion("1/s", "s", 1),
        lambda: laurent_expansion("1/s", 0, 0),
        lambda: laurent_expansion("1/s", sympy.sqrt(2), 1),
        lambda: laurent_expansion("1/s", 0, 10**6),
        lambda: laurent_expansion("1/s", 0, 10**5000),
        lambda: laurent_expansion("1/(s**5 + 1)", "a", 60),
        lambda: laurent_expansion("1/(s**500 + 1)", "1/3", 499),
        lambda: laurent_expansion("1/(s**900 + 1)", "1/3 + j/2", 3),
        lambda: laurent_expansion("1/s", 0, 1)[5],
    ):
        with pytest.raises(ct.CompensatorError):
            call()


def test_a_pick_matrix_beyond_the_budget():
    points, values = list(range(1, 61)), [0] * 60
    with pytest.raises(BudgetError, match="Pick's matrix"):
        nevanlinna_pick(points, values)
    with ct.budget(entries=10), pytest.raises(BudgetError):
        nevanlinna_pick(points[:5], values[:5])
    assert nevanlinna_pick(points[:5], values[:5]).is_feasible
