"""Interpolants of Nevanlinna and Pick, multiplied out, in floats, and against Blaschke products."""

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import QQ_I, I, Rational

from compensator_theory import CompensatorError, InputError, h_infinity_norm, transfer_function
from compensator_theory.errors import NoSolutionError
from compensator_theory.interpolation import nevanlinna_pick
from compensator_theory.stability import _pick_interpolation as module
from compensator_theory.stability._pick_interpolation import solve_pick
from tests.support.bad_inputs import BAD
from tests.support.structure_cases import fewer

s, z = sympy.symbols("s z")
HALVES = st.integers(-4, 4).map(lambda k: Rational(k, 2))


@st.composite
def closed_data(draw, most=2):
    """Points right of the axis, real ones and pairs, with values of a real function there."""
    real = draw(
        st.lists(st.integers(1, 8).map(lambda k: Rational(k, 2)), max_size=most, unique=True)
    )
    parts = st.tuples(st.integers(1, 3), st.integers(1, 3))
    pairs = draw(st.lists(parts, min_size=not real, max_size=most - 1, unique=True))
    points, values = list(real), [draw(HALVES) for _ in real]
    for x, y in pairs:
        w = draw(HALVES) + I * draw(HALVES)
        points += [x + I * y, x - I * y]
        values += [w, sympy.conjugate(w)]
    return points, values


def in_discrete_time(points):
    """Of (1 + p)/(1 - p), outside of the circle where p lies right of the axis."""
    return [sympy.expand(sympy.simplify((1 + p) / (1 - p))) for p in points]


PARAMETERS = {
    "s": [None, "1", "-1/2", "(s - 1)/(s + 1)", "1/(s + 2)", "(s**2 - s + 1)/(s**2 + s + 1)"],
    "z": [None, "1", "-1/2", "1/z", "1/(2*z - 1)", "(1 - z/2)/(z*(z - 1/2))"],
}


def check(f, points, values, bound):
    """Values by SymPy, poles and gains in floats, the norm by its own algorithm."""
    x = f.variable
    N, D = f.numerator.as_expr(), f.denominator.as_expr()
    for p, w in zip(points, values, strict=True):
        assert sympy.expand(N.subs(x, p) - w * D.subs(x, p)) == 0
    poles = np.roots([float(c) for c in f.denominator.all_coeffs()])
    assert not len(poles) or max(abs(poles) - 1 if x == z else poles.real) < 0
    angles = np.linspace(1e-4, np.pi - 1e-4, 400)
    places = np.exp(1j * angles) if x == z else 1j * np.tan(angles / 2)
    top, below = ([float(c) for c in p.all_coeffs()] for p in (f.numerator, f.denominator))
    gains = abs(np.polyval(top, places) / np.polyval(below, places))
    assert gains.max() <= float(bound) * (1 + 1e-7) + 1e-12
    assert h_infinity_norm(f).value <= bound
    return gains


@fewer(2)
@given(closed_data(), st.sampled_from(["s", "z"]), st.integers(0, 5), st.integers(0, 3))
def test_an_interpolant_takes_the_values_within_the_bound(data, variable, choice, excess):
    points, values = data
    if variable == "z":
        if 1 in points:
            return
        points = in_discrete_time(points)
    least = nevanlinna_pick(points, values, 1, variable=variable).enclosure.upper
    bound = Rational(int(sympy.ceiling(sympy.sqrt(least) * 8)) + excess, 8) + Rational(1, 8)
    interpolation = nevanlinna_pick(points, values, bound, variable=variable)
    assert interpolation.is_feasible and not interpolation.is_unique
    parameter = PARAMETERS[variable][choice]
    f = interpolation.interpolant(parameter)
    assert f.variable.name == variable and f.certificate.holds and f.order <= len(points) + 2
    gains = check(f, points, values, bound)
    if parameter == "1":  # lossless with it
        assert np.allclose(gains, float(bound))
    g = transfer_function(parameter or 0, variable)
    assert end(f) == bound * end(g)


def end(f):
    """The value at infinity, in discrete time at -1, exactly."""
    if f.variable == z:
        return f.numerator.eval(-1) / f.denominator.eval(-1)
    return f.numerator.coeff_monomial(s**f.order)


@st.composite
def blaschke_products(draw):
    """Real, of order 0 to 3, by their zeros."""
    zeros = draw(st.lists(st.integers(1, 6).map(lambda k: Rational(k, 3)), max_size=2))
    product = sympy.Integer(draw(st.sampled_from([1, -1])))
    order = len(zeros)
    for a in zeros:
        product *= (s - a) / (s + a)
    if draw(st.booleans()):
        x, y = draw(st.integers(1, 2)), draw(st.integers(1, 3))
        product *= (s**2 - 2 * x * s + x**2 + y**2) / (s**2 + 2 * x * s + x**2 + y**2)
        order += 2
    return product, order


@fewer(3)
@given(blaschke_products(), st.data(), st.sampled_from([1, Rational(5, 2)]))
def test_a_blaschke_product_comes_back_from_more_values_than_its_order(drawn, data, bound):
    product, order = drawn
    points = data.draw(
        st.lists(st.integers(1, 9), min_size=order + 1, max_size=order + 2, unique=True)
    )
    points = [Rational(p, 2) for p in points]
    if data.draw(st.booleans()):
        points = [1 + 2 * I, 1 - 2 * I, *points]
    values = [sympy.expand(sympy.simplify(bound * product.subs(s, p))) for p in points]
    interpolation = nevanlinna_pick(points, values, bound)
    assert interpolation.is_feasible and interpolation.is_unique
    f = interpolation.interpolant()
    assert f.order == order and sympy.cancel(f.as_expr() - bound * product) == 0
    with pytest.raises(InputError, match="unique"):
        interpolation.interpolant("0")


@fewer(5)
@given(closed_data(most=2), blaschke_products(), st.sampled_from([Rational(1, 2), Rational(9, 10)]))
def test_values_of_a_bounded_function_are_feasible(data, drawn, size):
    """Of a function below the bound, which is one of many."""
    points, function = data[0], size * drawn[0]
    values = [sympy.expand(sympy.simplify(function.subs(s, p))) for p in points]
    interpolation = nevanlinna_pick(points, values)
    assert interpolation.is_feasible and not interpolation.is_unique
    one, other = interpolation.interpolant(), interpolation.interpolant("1/2")
    assert one != other
    for f in (one, other):
        check(f, points, values, 1)


@st.composite
def touching_data(draw, variable):
    """Points with a value and up to two derivatives of a real function each."""
    points, values = draw(closed_data(most=2))
    lengths = {p: draw(st.integers(0, 2)) for p in points if sympy.im(p) >= 0}
    chains = []
    for p, w in zip(points, values, strict=True):
        k = lengths.get(p, lengths.get(sympy.conjugate(p)))
        if sympy.im(p) < 0:  # what its partner has, conjugated
            chains.append([sympy.conjugate(v) for v in chains[-1]])
        else:
            chains.append([w, *(draw(HALVES) for _ in range(k))])
    if variable == "z":
        points = in_discrete_time(points)
    return points, chains


def derivatives(f, point, count):
    """By division of the Taylor series of numerator and denominator at the point."""
    t, field, series = sympy.Dummy(), sympy.QQ_I, []
    top, bottom = (
        sympy.Poly(p.as_expr().subs(f.variable, point + t), t, domain=field).rep.to_list()[::-1]
        + [field.zero] * count
        for p in (f.numerator, f.denominator)
    )
    for k in range(count):
        rest = sum((bottom[j] * series[k - j] for j in range(1, k + 1)), field.zero)
        series.append((top[k] - rest) / bottom[0])
    return [field.to_sympy(c) * sympy.factorial(k) for k, c in enumerate(series)]


@fewer(4)
@given(st.data(), st.sampled_from(["s", "z"]), st.integers(0, 5))
def test_an_interpolant_has_the_derivatives_that_were_given(data, variable, choice):
    points, chains = data.draw(touching_data(variable))
    if any(p == sympy.zoo for p in points):
        return
    least = nevanlinna_pick(points, chains, 1, variable=variable).enclosure.upper
    bound = Rational(int(sympy.ceiling(sympy.sqrt(least) * 8)) + 1, 8) + Rational(1, 8)
    interpolation = nevanlinna_pick(points, chains, bound, variable=variable)
    f = interpolation.interpolant(PARAMETERS[variable][choice])
    check(f, points, [chain[0] for chain in chains], bound)
    for point, chain in zip(points, chains, strict=True):
        assert derivatives(f, point, len(chain)) == chain
    assert interpolation.matrix == interpolation.matrix.H and interpolation.values == tuple(
        map(tuple, chains)
    )


@fewer(4)
@given(st.data(), st.sampled_from(["s", "z"]))
def test_derivatives_are_limits_of_values_nearby(data, variable):
    """The least bound is that of values of a polynomial with these derivatives, close together."""
    p = Rational(data.draw(st.integers(3, 8)), 2)
    chain = [data.draw(HALVES) for _ in range(2)]
    least = nevanlinna_pick([p], [chain], 1, variable=variable).enclosure
    h = Rational(1, 10**8)
    values = [chain[0], chain[0] + h * chain[1]]
    nearby = nevanlinna_pick([p, p + h], values, 1, variable=variable).enclosure
    assert abs(float(least.lower - nearby.upper)) <= 1e-5 * (1 + float(least.upper))


@fewer(4)
@given(blaschke_products(), st.integers(1, 5))
def test_a_blaschke_product_comes_back_from_its_derivatives_at_one_point(drawn, point):
    product, order = drawn
    point += Rational(1, 4)  # no zero of the product
    chain = [sympy.simplify(sympy.diff(product, s, k).subs(s, point)) for k in range(order + 1)]
    interpolation = nevanlinna_pick([point], [chain])
    assert (
        interpolation.is_unique
        and sympy.cancel(interpolation.interpolant().as_expr() - product) == 0
    )


def test_a_double_zero_of_the_sensitivity():
    """By hand: f(1) = 0, f'(1) = d: f = (s - 1)/(s + 1) g, d = g(1)/2, so that |d| <= 1/2."""
    assert nevanlinna_pick([1], [[0, "1/2"]]).is_unique
    assert not nevanlinna_pick([1], [[0, "51/100"]]).is_feasible
    assert nevanlinna_pick([1], [[0, "1/3"]]).least_squared == Rational(4, 9)


def test_known_functions():
    assert str(nevanlinna_pick([2, 3], ["1/3", "1/2"]).interpolant()) == "(s - 1)/(s + 1)"
    assert str(nevanlinna_pick([2, -2], [1, 1], 1, variable="q").interpolant()) == "(1)/(1)"
    assert str(nevanlinna_pick([1, 2], [0, 0], 0).interpolant()) == "(0)/(1)"
    # One point: 2 a w/(s + a - ... ) by hand, f = w 2 a/((1 - w^2) (s - a) + 2 a) is bounded by 1.
    a, w = Rational(3), Rational(1, 2)
    f = nevanlinna_pick([a], [w]).interpolant().as_expr()
    assert sympy.cancel(f - 2 * a * w / ((1 - w**2) * s + (1 + w**2) * a)) == 0


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [(lambda: nevanlinna_pick([1, 2], [1, -1], 5).interpolant(), NoSolutionError, "least bound is"),
     (lambda: nevanlinna_pick(["1+j"], ["1/2"]).interpolant(), InputError, "conjugates"),
     (lambda: nevanlinna_pick(["1+j", "1-j"], ["1/2", "1/3"]).interpolant(), InputError, "conjug"),
     (lambda: nevanlinna_pick([1], ["j/2"]).interpolant(), InputError, "conjugates"),
     (lambda: nevanlinna_pick([1], [["1/2", "j/9"]]).interpolant(), InputError, "f'.1. = I/9"),
     (lambda: nevanlinna_pick(["1+j", "1-j"], [["1/2", 0], "1/2"]).interpolant(), InputError,
      "f'.1 . I. = 0"),
     (lambda: nevanlinna_pick([1, 1], ["1/2", 0]), InputError, "in one list"),
     (lambda: nevanlinna_pick([1], [[]]), InputError, "its value")],
)  # fmt: skip
def test_what_no_real_function_does(call, error, words):
    with pytest.raises(error, match=words):
        call()


def test_parameters_that_are_none():
    interpolation = nevanlinna_pick([1, 2], ["1/2", "1/3"])
    ours = ["2", "-11/10", "s", "1/(s - 1)", "1/s", "a", "1/z", "j/2", [["0", "1"]]]
    for bad in (*BAD, *ours, transfer_function("1/(z - 1/2)")):
        if bad is None:  # left out
            continue
        with pytest.raises(CompensatorError):
            interpolation.interpolant(bad)


def test_a_function_that_misses_is_refused(monkeypatch):
    """Both checks look at the function, not at the way to it."""
    interpolation = nevanlinna_pick([1, 2], ["1/2", "1/3"])
    wrong = transfer_function("1/(s + 2)")
    monkeypatch.setattr(module, "solve_pick", lambda *a, **k: wrong)
    with pytest.raises(NoSolutionError, match="FAILS"):
        interpolation.interpolant()
    with pytest.raises(NoSolutionError, match="bounded real"):  # 2 is above the bound
        solve_pick([(QQ_I(1), [QQ_I(2)])], s, transfer_function(0, "s"), discrete=False)
