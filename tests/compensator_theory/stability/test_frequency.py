"""Norms and passivity against singular values on a refined grid, and against passive networks."""

import flint
import mpmath
import numpy as np
import pytest
import scipy.optimize
import scipy.signal
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st
from sympy import Rational

import compensator_theory as ct
from compensator_theory.errors import NoSolutionError
from compensator_theory.stability._norms import _discriminant
from tests.support.structure_cases import fewer

s = sympy.Symbol("s")
STABLE = ["s + 1", "s + 3", "s**2 + s + 1", "s**2 + s/4 + 4", "(s + 1)**2", "2"]


@st.composite
def stable_matrices(draw, max_size=2):
    rows, columns = draw(st.integers(1, max_size)), draw(st.integers(1, max_size))

    def entry():
        bottom = sympy.sympify(draw(st.sampled_from(STABLE)))
        size = sympy.Poly(bottom, s).degree() + 1
        top = draw(st.lists(st.integers(-3, 3), min_size=size, max_size=size))
        return sympy.Poly(top, s).as_expr() / bottom

    return sympy.Matrix(rows, columns, lambda i, j: entry())


def gain(G):
    """The largest singular value as a function of log10 of the frequency."""
    numeric = sympy.lambdify(s, G, "numpy")
    return lambda x: np.linalg.svd(np.array(numeric(1j * 10**x), complex), compute_uv=False)[0]


def peak(G):
    """Of the gain over a grid, refined at its local maxima; with both limits."""
    f = gain(G)
    grid = np.linspace(-5, 5, 401)
    values = np.array([f(x) for x in grid])
    best = max(values.max(), f(-12), f(12))
    for k in scipy.signal.argrelmax(values)[0]:  # the highest on the grid need not be the highest
        result = scipy.optimize.minimize_scalar(
            lambda x: -f(x), bounds=(grid[k - 1], grid[k + 1]), method="bounded",
            options={"xatol": 1e-10},
        )  # fmt: skip
        best = max(best, -result.fun)
    return best


@pytest.mark.costly
@fewer(3)
@given(stable_matrices())
def test_the_norm_is_the_peak(G):
    norm = ct.h_infinity_norm(G.tolist(), "s")
    assert np.isclose(float(norm.enclosure), peak(G), rtol=1e-6, atol=1e-9)
    square = norm.square_polynomial
    ends = [square.eval(end**2) for end in (norm.enclosure.lower, norm.enclosure.upper)]
    assert ends[0] * ends[1] <= 0 and square.is_irreducible


@pytest.mark.costly
@fewer(4)
@given(stable_matrices())
def test_bounded_real_on_both_sides_of_the_norm(G):
    norm = ct.h_infinity_norm(G.tolist(), "s")
    above = norm.enclosure.upper * Rational(1001, 1000) + Rational(1, 10**6)
    assert ct.decide_bounded_real((G / above).tolist(), "s").holds
    if norm.enclosure.lower > 0:
        below = norm.enclosure.lower * Rational(999, 1000)
        denied = ct.decide_bounded_real((G / below).tolist(), "s")
        assert not denied.holds
        at = float(denied.violated) ** 0.5
        assert gain(G / below)(np.log10(max(at, 1e-12))) > 1 - 1e-9
        if norm.value.is_Rational:  # exactly at the norm
            assert ct.decide_bounded_real((G / norm.value).tolist(), "s").holds


@pytest.mark.costly
@fewer(4)
@given(stable_matrices(max_size=1))
def test_discrete_time_is_the_half_plane_mapped(G):
    z = sympy.Symbol("z")
    mapped = sympy.cancel(G[0, 0].subs(s, (z - 1) / (z + 1)))
    assert ct.h_infinity_norm(mapped, "z").value == ct.h_infinity_norm(G.tolist(), "s").value
    moved = ct.decide_positive_real(mapped, "z")
    assert moved.holds == ct.decide_positive_real(G.tolist(), "s").holds


def test_known_norms():
    assert ct.h_infinity_norm("1/(s**2 + s + 1)").value == 2 / sympy.sqrt(3)
    expected = sympy.sqrt((5 + 4 * sympy.sqrt(2)) / 7)
    assert sympy.simplify(ct.h_infinity_norm("(s + 1)/(s**2 + s + 2)").value - expected) == 0
    for allpass in ("(s - 1)/(s + 1)", "(s**2 - s + 1)/(s**2 + s + 1)", "(1 - z/2)/(z - 1/2)"):
        assert ct.h_infinity_norm(allpass).value == 1 and ct.decide_bounded_real(allpass).holds
    assert str(ct.h_infinity_norm("0/(s + 1)")) == "0" and ct.h_infinity_norm("0", "s").value == 0
    assert ct.h_infinity_norm("(s + 1)*(s - 1)/((s - 1)*(s + 1))").value == 1
    # the sum of squares for a system with one output
    row = [["1/(s + 1)", "2/(s + 1)"]]
    column = [[x] for x in row[0]]
    assert ct.h_infinity_norm(row).value == sympy.sqrt(5) == ct.h_infinity_norm(column).value


def test_a_level_of_negative_frequencies_squared_is_none():
    """(1 + 9 w)/(w^2 + 7 w + 1) is at least 1.56 between its poles, where w < 0."""
    G = "(3*s + 1)/(s**2 + 3*s + 1)"
    w = sympy.Symbol("w", positive=True)
    square = (1 + 9 * w) / (w**2 + 7 * w + 1)
    (at,) = sympy.solve(sympy.diff(square, w))
    alone, beside = ct.h_infinity_norm(G), ct.h_infinity_norm([[G, 0], [0, "1/2"]])
    assert sympy.simplify(alone.value**2 - square.subs(w, at)) == 0
    assert beside.value == alone.value < 1.2  # a constant entry has no frequency
    assert ct.h_infinity_norm([[G, 0], [0, 3]]).value == 3


LEVELS = st.lists(st.integers(-4, 4), min_size=1, max_size=3)


@given(st.lists(LEVELS, min_size=3, max_size=5))
def test_the_discriminant_is_that_of_sympy(rows):
    """Between levels, some of which may lower the degree, and up to a number."""
    w, g = sympy.symbols("w g")
    factor = [flint.fmpz_poly(row) for row in rows]
    assume(factor[-1])
    both = sympy.Poly([sympy.Poly(row[::-1], g).as_expr() for row in reversed(rows)], w)
    expected = sympy.Poly(sympy.discriminant(both), g)
    result = sympy.Poly([int(c) for c in reversed(_discriminant(factor).coeffs())] or [0], g)
    assert result.is_zero == expected.is_zero
    assert result.is_zero or result.monic() == expected.monic()


def test_the_norm_of_a_sensitivity_with_twelve_states():
    """Poles, zeros and gain with 15 digits, as an aircraft's autopilot has them."""
    read = lambda *texts: sympy.prod([s - Rational(x) for x in texts])  # noqa: E731
    pair = lambda a, b: (s - Rational(a)) ** 2 + Rational(b) ** 2  # noqa: E731
    zeros = (
        read("-101.47795511977208", "-48.91219110762173", "-7.96322290641594")
        * read("-0.7114937019357614")
        * pair("-7.282563985219324", "7.114985406231401")
        * pair("-1.5268748507837735", "1.2594070637611725")
    )
    poles = (
        read("-101.32273797977184", "-49.510558929948274", "-20", "-11.82446898287247")
        * read("-10.604444850836952", "-0.6235091399063754", "-0.2743617810110765")
        * pair("-5.297845964509693", "6.146324852257861")
        * pair("-1.4795349979133343", "1.2376578249023653")
    )
    loop = Rational("704.6392766532747") * zeros * Rational("0.6") * (s + Rational(1, 2))
    top = sympy.Poly(poles * s, s)
    bottom = sympy.Poly(poles * s + loop, s)
    norm = ct.h_infinity_norm((top, bottom))
    with mpmath.workdps(50):
        N, D = ([mpmath.mpf(c.p) / c.q for c in p.all_coeffs()] for p in (top, bottom))
        size = lambda w: abs(mpmath.polyval(N, 1j * w) / mpmath.polyval(D, 1j * w))  # noqa: E731
        at = mpmath.findroot(lambda w: mpmath.diff(size, w), 5.8)
        grid = [size(mpmath.mpf(10) ** (k / 20)) for k in range(-80, 81)]
        assert max(grid) < size(at)
        error = abs(size(at) - mpmath.mpf(norm.enclosure.centre.p) / norm.enclosure.centre.q)
        assert error < 1e-18
    assert norm.square_polynomial.is_irreducible
    assert isinstance(norm.value**2, sympy.CRootOf)


@st.composite
def networks(draw, depth=3):
    """Impedances of resistors, inductors and capacitors in series and in parallel: passive."""
    if depth == 0 or draw(st.booleans()):
        size = Rational(draw(st.integers(1, 4)), draw(st.integers(1, 3)))
        return draw(st.sampled_from([size, size * s, size / s]))
    one, two = draw(networks(depth - 1)), draw(networks(depth - 1))
    return sympy.cancel(one + two if draw(st.booleans()) else one * two / (one + two))


@fewer(3)
@given(networks())
def test_passive_networks_are_positive_real(Z):
    assert ct.decide_positive_real(Z, "s").holds
    assert ct.decide_positive_real(1 / Z, "s").holds
    assert not ct.decide_positive_real(-Z, "s").holds


@pytest.mark.costly
@fewer(6)
@given(networks(depth=2), networks(depth=2), networks(depth=2), st.integers(-2, 2))
def test_passive_two_ports(a, b, c, gyration):
    """Two arms with a common branch, and a gyrator, which changes nothing."""
    Z = [[a + c, c + gyration], [c - gyration, b + c]]
    assert ct.decide_positive_real(Z, "s").holds
    spoiled = [[a + c, c + 1000], [c, b + c]]
    assert ct.decide_positive_real(spoiled, "s").holds == on_a_grid(sympy.Matrix(spoiled))


def on_a_grid(G):
    """The definition, at many points of the right half plane."""
    numeric = sympy.lambdify(s, G, "numpy")
    points = [10.0**x * np.exp(1j * y) for x in np.linspace(-4, 4, 60) for y in (0, 0.8, 1.5, 1.57)]
    values = [np.array(numeric(p), complex) for p in points]
    return all(np.linalg.eigvalsh(v + v.conj().T)[0] > -1e-6 * np.abs(v).max() for v in values)


@fewer(2)
@given(stable_matrices(max_size=1))
def test_the_real_part_decides(G):
    """Of a stable function: positive real if and only if Re G(j w) >= 0."""
    numeric = sympy.lambdify(s, G[0, 0], "numpy")
    real = np.array([np.real(numeric(1j * w)) for w in [0, *np.logspace(-4, 4, 3000)]])
    decided = ct.decide_positive_real(G.tolist(), "s")
    if real.min() < -1e-7:
        assert not decided.holds
    if real.min() > 1e-7:
        assert decided.holds


@pytest.mark.costly
@pytest.mark.parametrize(
    ("text", "holds"),
    [("s", True), ("1/s", True), ("s + 1/s", True), ("s**2", False), ("1/s**2", False),
     ("-1/s", False), ("s/(s**2 + 1)", True), ("1/(s**2 + 1)", False), ("-1", False), ("0", True),
     ("(s + 1)/(s*(s + 2))", True), ("(s + 2)/(s*(s + 1))", False), ("1/(s - 1)", False)],
)  # fmt: skip
def test_known_functions(text, holds):
    assert ct.decide_positive_real(text, "s").holds is holds
    assert str(ct.decide_positive_real(text, "s")).startswith("positive") is holds


def test_what_is_said_of_a_failure():
    assert "1 unstable" in str(ct.decide_bounded_real("1/(s - 1)"))
    assert "det(G + I)" in str(ct.decide_positive_real([[-1, 0], [0, "1/s"]], "s"))
    assert "omega^2" in str(ct.decide_bounded_real("2/(s + 1)"))
    with pytest.raises(NoSolutionError, match="not stable"):
        ct.h_infinity_norm("1/(s**2 + 1)")
    with pytest.raises(NoSolutionError, match="not stable"):
        ct.h_infinity_norm("1/(z + 1)")


@pytest.mark.parametrize(
    "call", [ct.h_infinity_norm, ct.decide_bounded_real, ct.decide_positive_real]
)
@pytest.mark.parametrize("bad", ["1/(s + a)", "1/(x + 1)", [["a"]], [], "1/0", None, [[1], [1, 2]]])
def test_bad_input(call, bad):
    with pytest.raises(ct.CompensatorError):
        call(bad)


def test_shapes_and_properness():
    with pytest.raises(ct.CompensatorError, match="square"):
        ct.decide_positive_real([["1", "s"]])
    for call in (ct.h_infinity_norm, ct.decide_bounded_real):
        with pytest.raises(ct.CompensatorError, match="improper"):
            call(ct.transfer_matrix("s"))
