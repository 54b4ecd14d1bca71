"""Limits of continuous LQG: poles at tiny weights in 60 digits, and closed forms."""

import itertools

import flint
import mpmath
import pytest
import sympy
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from sympy import Matrix, Rational, diag, eye, zeros

import compensator_theory as ct
from compensator_theory.errors import NoSolutionError, NotControllableError
from compensator_theory.strategies import polynomials, strictly_proper_plants

R_2, s = sympy.symbols("R_2 s")
ROTATION = Matrix([[3, -4], [4, 3]]) / 5  # leaves R_2 = I as it is


def problem(A, B, E_1, C, D_1, E_2=None, D_2=None):
    """A plant in s; what is not weighed is high authority."""
    u, y, z, w = B.cols, C.rows, E_1.rows, D_1.cols
    nothing = zeros(z, u), zeros(y, w)
    return ct.StandardProblem(
        A=A, B=B, C=C, D_1=D_1, D_0=None, D_2=nothing[1] if D_2 is None else D_2, E_1=E_1,
        E_2=nothing[0] if E_2 is None else E_2, E_0=None, variable="s",
    )  # fmt: skip


def weighed(plant, root):
    """The plant with the weight root**2 for u and for the sensor noise."""
    u, y = plant.l_u, plant.l_y
    E_1, D_1 = Matrix(plant.E_1), Matrix(plant.D_1)
    return problem(
        plant.A, plant.B, E_1.col_join(zeros(u, plant.n)), plant.C, D_1.row_join(zeros(plant.n, y)),
        zeros(E_1.rows, u).col_join(root * eye(u)), zeros(y, D_1.cols).row_join(root * eye(y)),
    )  # fmt: skip


@st.composite
def scalar_plants(draw):
    """u to z and w to y through one plant each way, in one realisation: D_1 and E_1 are drawn."""
    plant = ct.realisation(draw(strictly_proper_plants(max_order=4)))
    n = plant.A.rows
    rows = st.lists(st.integers(-3, 3), min_size=n, max_size=n).filter(any)
    return problem(plant.A, plant.B, plant.C, Matrix([draw(rows)]), Matrix(draw(rows)))


def limits_of(plant):
    try:
        return ct.high_authority_limits(plant, digits=60)
    except (NoSolutionError, NotControllableError):
        return None
    except ValueError as error:  # an unstable mode that y does not show
        assert "unobservable" in str(error)
        return None


def roots_of(factor):
    """Certified roots of the exact centres, which are within 1e-60 of the coefficients."""
    centres = [c.centre for c in reversed(factor.enclosure.coefficients)]
    common = sympy.ilcm(1, *(c.q for c in centres))
    with flint.ctx.workprec(256):
        balls = flint.fmpz_poly([int(c * common) for c in centres]).complex_roots()
        texts = [(b.real.mid().str(65, radius=False), b.imag.mid().str(65, radius=False))
                 for b, multiplicity in balls for _ in range(multiplicity)]  # fmt: skip
    with mpmath.workdps(60):
        return [mpmath.mpc(real, imaginary) for real, imaginary in texts]


def nearest(poles, expected):
    """The largest distance of expected poles, each matched with one that was found."""
    poles, worst = list(poles), mpmath.mpf(0)
    for pole in sorted(expected, key=abs):
        best = min(poles, key=lambda other: abs(other - pole))
        poles.remove(best)
        worst = max(worst, abs(best - pole))
    return worst


def errors(limit, factor, weight):
    """Distances of the finite poles and of those of each pattern from where they should be."""
    with mpmath.workdps(60):
        poles = sorted(roots_of(factor), key=abs)
        finite = roots_of(limit.finite)
        away = [
            [mpmath.mpmathify(sympy.N(p, 60)) for p in pattern.poles(weight)]
            for pattern in limit.patterns
        ]
        # The orders of magnitude are apart, larger orders are nearer.
        expected = sorted(itertools.chain(*away), key=abs)
        assert len(poles) == len(finite) + len(expected)
        return nearest(poles[: len(finite)], finite), nearest(poles[len(finite) :], expected)


@pytest.mark.costly
@settings(max_examples=8)
@given(scalar_plants())
def test_one_signal_each_at_small_weights(plant):
    limits = limits_of(plant)
    assume(limits is not None)
    for limit, channel in ((limits.regulator, "zu"), (limits.estimator, "yw")):
        N = plant.numerator(channel)
        (pattern,) = limit.patterns
        assert pattern.order == plant.n - N.degree() and pattern.gain == N.LC() ** 2
        assert (
            limit.finite.enclosure == ct.spectral_factor(N, digits=60, time="continuous").enclosure
        )
    first, second = Rational(1, 10**20), Rational(1, 10**24)
    near, nearer = (ct.lqg_poles(weighed(plant, r), digits=60) for r in (first, second))
    for side in ("regulator", "estimator"):
        limit = getattr(limits, side)
        k = limit.number_to_infinity
        one = errors(limit, getattr(near, side), first**2)
        two = errors(limit, getattr(nearer, side), second**2)
        if sympy.discriminant(limit.finite.spectrum) != 0:  # simple zeros: the error is O(R_2)
            assert two[0] <= max(mpmath.mpf("1.1e-8") * one[0], mpmath.mpf("1e-55"))
        assert two[0] <= max(one[0] / 2, mpmath.mpf("1e-25"))
        rate = mpmath.power(10, mpmath.mpf(-8) / (2 * k))
        assert two[1] <= max(1.2 * rate * one[1], mpmath.mpf("1e-40"))


@pytest.mark.costly
@settings(max_examples=6)
@given(st.tuples(*[strictly_proper_plants(max_order=3)] * 2), st.booleans())
def test_two_signals_are_one_pattern_for_each_zero_at_infinity(plants, same):
    """Two loops in one plant, inputs and outputs turned: a rotation changes no singular value."""
    first, second = (ct.realisation(plants[0 if same else i]) for i in range(2))
    B, C = diag(first.B, second.B) * ROTATION, ROTATION * diag(first.C, second.C)
    plant = problem(diag(first.A, second.A), B, C, C, B)
    limits = limits_of(plant)
    assume(limits is not None)
    expected = sorted(
        (int(G.denominator.degree() - G.numerator.degree()), G.numerator.LC() ** 2)
        for G in (part.transfer_function() for part in (first, second))
    )
    for limit in (limits.regulator, limits.estimator):
        ordered = sorted((pattern.order, pattern.gain) for pattern in limit.patterns)
        assert ordered == expected
    small = Rational(1, 10**30)
    poles = ct.lqg_poles(weighed(plant, small), digits=60)
    for side in ("regulator", "estimator"):
        finite, away = errors(getattr(limits, side), getattr(poles, side), small**2)
        assert finite < 1e-9 and away < 1


@pytest.mark.costly
@given(polynomials(min_degree=0, max_degree=2), st.integers(1, 3))
def test_the_whole_polynomial_converges_after_division(numerator, k):
    """The closed-loop polynomial over `growth` at points, against the spectral factor."""
    N = numerator.set_domain(sympy.QQ)
    assume(not N.is_zero)
    D = sympy.Poly((N.gen + 1) ** (int(N.degree()) + k - 1) * (N.gen - 2), N.gen)
    assume(sympy.gcd(N, D).degree() == 0)
    try:
        limit = ct.high_authority_limits(standard_like(N, D)).regulator
    except NoSolutionError:
        return
    small = Rational(1, 10**40)
    chi = ct.spectral_factor(N, D, small, digits=60, time="continuous").enclosure.coefficients
    finite = limit.finite.enclosure.coefficients
    with mpmath.workdps(70):
        growth = mpmath.mpmathify(sympy.N(limit.growth.subs(R_2, small), 60))
        for point in (0, 1, -3, 2j):
            ours, theirs = (
                mpmath.polyval([mpmath.mpf(c.centre.p) / c.centre.q for c in side], point)
                for side in (finite, chi)
            )
            assert abs(theirs / growth - ours) < mpmath.mpf("1e-5") * (1 + abs(ours))


def standard_like(N, D):
    plant = ct.realisation((N, D))
    return problem(plant.A, plant.B, plant.C, plant.C, plant.B)


def test_closed_form_of_the_double_integrator():
    plant = problem(Matrix([[0, 1], [0, 0]]), Matrix([0, 1]), Matrix([[1, 0]]), Matrix([[1, 0]]),
                    Matrix([0, 1]))  # fmt: skip
    limit = ct.high_authority_limits(plant).regulator
    (pattern,) = limit.patterns
    poles = pattern.poles("1/16")
    x = sympy.Symbol("x")
    exact = [c.subs(R_2, Rational(1, 16)) for c in ct.regulator_locus("1", "s**2").closed_form]
    product = sympy.expand(sympy.prod(x - sympy.expand_complex(pole) for pole in poles))
    assert sympy.simplify(product - sympy.Poly(exact, x).as_expr()) == 0
    assert pattern.angles == (3 * sympy.pi / 4, 5 * sympy.pi / 4)
    assert limit.spectrum == ct.regulator_locus("1", "s**2").spectrum


def test_irrational_gains_of_two_inputs():
    """G = M/s with M'M = [[2, 1], [1, 1]]: the gains are its eigenvalues (3 +- sqrt(5))/2."""
    M = Matrix([[1, 0], [1, 1]])
    plant = problem(zeros(2, 2), M, eye(2), eye(2), M)
    result = {pattern.gain for pattern in ct.high_authority_limits(plant).regulator.patterns}
    assert result == {(3 + sympy.sqrt(5)) / 2, (3 - sympy.sqrt(5)) / 2}


def test_fewer_outputs_than_inputs():
    """One combination of the inputs does nothing: its pole tends to that of the plant."""
    plant = problem(diag(-1, -2), eye(2), Matrix([[1, 0]]), Matrix([[1, 1]]), Matrix([1, 1]))
    limit = ct.high_authority_limits(plant).regulator
    assert limit.finite.polynomial == sympy.Poly(s + 2, s, domain="QQ")
    assert [(p.order, p.gain) for p in limit.patterns] == [(1, 1)]


def test_a_weight_that_is_given_says_its_direction():
    """R_2 = 4 rho in place of rho: a quarter of the gain."""
    base = problem(Matrix([[-1]]), Matrix([[1]]), Matrix([[3], [0]]), Matrix([[1]]),
                   Matrix([[1, 0]]), Matrix([[0], [2]]), Matrix([[0, 1]]))  # fmt: skip
    assert ct.high_authority_limits(base).regulator.patterns[0].gain == Rational(9, 4)


@pytest.mark.parametrize(
    ("plant", "error", "words"),
    [
        (1, ct.InputError, "StandardProblem"),
        (ct.standard_problem("1/(q - 2)"), ct.InputError, "discrete time"),
        (standard_like(sympy.Poly(s, s), sympy.Poly((s + 1) * (s + 2), s)), NoSolutionError,
         "imaginary axis"),
        (problem(eye(1), zeros(1, 1), eye(1), eye(1), eye(1)), NotControllableError, "mode"),
        (problem(-eye(1), eye(1), eye(1), eye(1), eye(1), eye(1)), ct.InputError, "E_1'E_2"),
        (problem(-eye(2), eye(2), eye(3)[:, :2], eye(2), eye(2),
                 Matrix([[0, 0], [0, 0], [1, 0]])), ct.InputError, "some signals only"),
    ],
)  # fmt: skip
def test_refusals(plant, error, words):
    with pytest.raises(error, match=words):
        ct.high_authority_limits(plant)


@pytest.mark.parametrize("weight", [0, -1, "sqrt(2)", "a"])
def test_a_weight_is_a_positive_rational_number(weight):
    limit = ct.high_authority_limits(standard_like(sympy.Poly(1, s), sympy.Poly(s + 1, s)))
    with pytest.raises(ct.InputError, match="positive rational"):
        limit.regulator.patterns[0].poles(weight)
