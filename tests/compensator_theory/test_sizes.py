"""Requests of the sizes that people bring are answered, and what is larger is refused at once."""

import random

import flint
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import (
    budget,
    count_roots,
    decide_bounded_real,
    descriptor_realisation,
    doubly_coprime_fractions,
    h_infinity_norm,
    kalman_decomposition,
    observer_based_compensator,
    regulator_spectrum,
    solve_riccati,
    solve_stein,
    stability_margins,
    state_feedback_family,
    transfer_function,
)
from compensator_theory.errors import BudgetError
from compensator_theory.forms import (
    hermite_form,
    jordan_form,
    popov_form,
    row_reduced_form,
    smith_mcmillan_form,
)
from compensator_theory.matrices._echelon import echelon, pivot_columns
from compensator_theory.matrices._linear_algebra import rank
from compensator_theory.matrices._quotients_modulo import quotient_modulo
from compensator_theory.roots._descartes import real_root_balls
from compensator_theory.roots._unit_circle import _has_root_on_circle
from tests.support.work import at_most


def _matrix(rows, columns, seed=1):
    draw = random.Random(seed)
    return sympy.ImmutableMatrix(rows, columns, lambda *_: draw.randint(-9, 9))


def test_a_jordan_form_looks_for_no_chain_where_the_kernel_is_spanned():
    with at_most(500_000):  # a chain from each of n unit vectors took 2 000 000
        form = jordan_form(_matrix(20, 20).tolist())
    assert form.certificate.holds
    assert [length for _, length in form.blocks] == [1]


def test_pivots_are_those_of_the_echelon_form():
    wide = _matrix(4, 9)
    deficient = sympy.ImmutableMatrix.hstack(wide[:, :1], wide[:, :1] * 2, wide)
    for matrix in (wide, wide.T, wide[:, :4], deficient, deficient.T, sympy.zeros(3, 2)):
        assert pivot_columns(matrix)[0] == matrix.rref()[1] == echelon(matrix).pivots
        assert rank(matrix) == matrix.rank()


def test_a_rank_with_symbols_is_the_generic_one():
    a, b = sympy.symbols("a b")
    assert rank(sympy.Matrix([[a, 1], [1, b]])) == 2
    assert rank(sympy.Matrix([[a, a * b], [1, b]])) == 1
    assert rank(sympy.Matrix([[1 / a, 1, 0], [b, a * b, 1 / b]])) == 2


@pytest.mark.parametrize("half", range(1, 6))
def test_roots_on_the_circle_are_those_of_the_folded_polynomial(half):
    draw, z = random.Random(half), sympy.Symbol("z")
    degrees = set()
    for _ in range(40):
        side = [draw.randint(-9, 9) or 1 for _ in range(half)]
        poly = sympy.Poly([*side, draw.randint(-30, 30), *side[::-1]], z, domain=sympy.QQ)
        if poly.is_irreducible:
            balls = flint.fmpz_poly(list(map(int, poly.all_coeffs()))).complex_roots()
            near = any(abs(float(abs(root)) - 1) < 1e-9 for root, _ in balls)
            assert _has_root_on_circle(poly) == near
            degrees.add(near)
    assert degrees


@pytest.mark.costly
def test_a_regulator_spectrum_is_that_of_the_pencil():
    A, B, N, s = _matrix(3, 3), _matrix(3, 2, 2), _matrix(3, 2, 3), sympy.Symbol("s")
    Q, R = A + A.T, sympy.Matrix([[3, 1], [1, 2]])
    one, zero = sympy.eye(3), sympy.zeros
    pencil = sympy.Matrix(
        sympy.BlockMatrix([[A - s * one, zero(3, 3), B], [-Q, -A.T - s * one, -N], [N.T, B.T, R]])
    )
    spectrum = regulator_spectrum(A, B, Q, R, N, time="continuous")
    assert sympy.expand(spectrum.as_expr() + pencil.det()) == 0


def test_a_gain_is_proven_without_a_long_characteristic_polynomial():
    A, B = _matrix(8, 8), _matrix(8, 2, 2)
    poles = [-1 - sympy.Rational(k, 3) for k in range(8)]
    K = state_feedback_family(A, B, poles).gain()
    s = sympy.Symbol("s")
    goal = sympy.Poly(sympy.prod(s - pole for pole in poles), s)
    assert (A + B * K).charpoly(s).as_expr() == goal.as_expr()


def test_forty_states_are_decomposed():
    with at_most(2_000_000):
        decomposition = kalman_decomposition((_matrix(40, 40), _matrix(40, 1), _matrix(1, 40)), "s")
    assert decomposition.dimensions == (0, 40, 0, 0)


def test_coprimeness_with_symbols_is_not_decided_by_a_written_resultant():
    names = ("(s+a)/(s+b)", "(s+a)/(s+a+1)", "(s+a)/(s**2-a**2)", "(s-a)/(s**2+a*s+1)")
    answers = [transfer_function(text, "s").is_coprime for text in names]
    assert answers == [None, True, False, None]


def test_the_norm_of_many_states_is_refused_before_its_polynomial_is_made():
    s, below = sympy.Symbol("s"), sympy.Poly(1, sympy.Symbol("s"))
    for k in range(50):
        below *= sympy.Poly(s + 1 + sympy.Rational(k, 7), s)
    above = sympy.Poly(_matrix(1, 50).tolist()[0], s)
    with (
        at_most(500_000),
        budget(entries=1000),
        pytest.raises(BudgetError, match="the polynomial of the norm"),
    ):
        h_infinity_norm((above, below))


@pytest.mark.costly
def test_a_compensator_with_symbols_is_refused_before_its_adjugate():
    names = sympy.symbols("a b c")
    A = _matrix(4, 4) + sympy.diag(*names, 0)
    plant = (A, _matrix(4, 1, 2), _matrix(1, 4, 3))
    compensator = observer_based_compensator(
        plant, [-1, -2, -3, -4], [-5, -6, -7, -8], variable="s"
    )
    assert compensator.certificate.holds
    with at_most(2_000_000), pytest.raises(BudgetError, match="denominators of symbols"):
        str(compensator)


@given(
    st.lists(st.fractions(-8, 8, max_denominator=4).filter(bool), max_size=5, unique=True),
    st.lists(st.tuples(st.integers(-4, 4), st.integers(1, 4)), max_size=2, unique=True),
)
def test_real_roots_are_isolated_without_the_complex_ones(real, pairs):
    poly = flint.fmpz_poly([1])
    for root in real:
        poly *= flint.fmpz_poly([-root.numerator, root.denominator])
    for centre, distance in pairs:
        poly *= flint.fmpz_poly([centre**2 + distance**2, -2 * centre, 1])
    balls = real_root_balls(poly, 64)
    assert balls is not None
    assert len(balls) == len(real)
    for ball, root in zip(balls, sorted(real), strict=True):
        assert (ball * root.denominator - root.numerator).contains(0)
        assert ball.rad() * 2**63 <= abs(ball.mid())
    positive = real_root_balls(poly, 64, positive=True)
    assert positive is not None
    assert len(positive) == sum(root > 0 for root in real)


def test_bounded_realness_isolates_no_complex_root(monkeypatch):
    s, below = sympy.Symbol("s"), sympy.Poly(1, sympy.Symbol("s"))
    for k in range(30):
        below *= sympy.Poly(s + 1 + sympy.Rational(k, 7), s)
    above = sympy.Poly(_matrix(1, 30).tolist()[0], s)
    monkeypatch.setattr("compensator_theory.stability._critical_values.decided_balls", None)
    size = below.eval(0) / above.eval(0)  # the norm is at least |G(0)|
    assert not decide_bounded_real((above * (2 * size), below)).holds
    assert decide_bounded_real((below * sympy.Rational(1, 2), below)).holds


@pytest.mark.parametrize("time", ["continuous", "discrete"])
@pytest.mark.parametrize("inputs", [1, 2])
def test_a_spectrum_of_few_inputs_is_that_of_the_response(time, inputs):
    """p at a point is det(X(mirror)' [Q N; N' R] X), from linear equations with numbers."""
    n, s = 5, sympy.Symbol("s" if time == "continuous" else "q")
    A, B, N = _matrix(n, n), _matrix(n, inputs, 2), _matrix(n, inputs, 3)
    Q, R = A + A.T, sympy.zeros(inputs, inputs)
    with at_most(60_000):
        spectrum = regulator_spectrum(A, B, Q, R, N, time=time, variable=s)
    whole = sympy.Matrix(sympy.BlockMatrix([[Q, N], [N.T, R]]))
    for point in (sympy.Rational(1, 2), 3, -2):
        mirror = -point if time == "continuous" else 1 / sympy.Rational(point)
        X, Y = (
            ((x * sympy.eye(n) - A).LUsolve(B)).col_join(sympy.eye(inputs)) for x in (point, mirror)
        )
        bottoms = sympy.prod((x * sympy.eye(n) - A).det() for x in (point, mirror))
        factor = 1 if time == "continuous" else sympy.Rational(point) ** n
        assert spectrum.eval(point) == factor * bottoms * (Y.T * whole * X).det()


@pytest.mark.parametrize(
    ("form", "step"),
    [
        (hermite_form, "elimination"),
        (popov_form, "Popov form"),
        (row_reduced_form, "row-reduced form"),
    ],
)
def test_each_step_of_an_elimination_counts_for_the_budget(form, step):
    s, draw = sympy.Symbol("s"), random.Random(1)
    matrix = [
        [draw.randint(1, 9) * s**2 + draw.randint(-9, 9) for _ in range(6)] for _ in range(12)
    ]
    assert form(matrix).certificate.holds
    with budget(entries=80), pytest.raises(BudgetError, match=f"the {step}"):
        form(matrix)


@pytest.mark.costly
def test_a_smith_mcmillan_form_with_four_symbols_is_made_of_short_steps():
    a, b, c, d, s = sympy.symbols("a b c d s")
    below = s**4 + a * s**3 + b * s**2 + c * s + d
    above = [s**3 + a * s + 1, s**3 + b, s**2 + c * s + 2, s**3 + d * s**2 + 3]
    with at_most(6_000_000):  # SymPy's remainders over fractions took more than 60 s
        form = smith_mcmillan_form([[above[0] / below, above[1] / below],
                                    [above[2] / below, above[3] / below]])  # fmt: skip
    assert form.mcmillan_degree == 8
    det = sympy.expand(above[0] * above[3] - above[1] * above[2])
    assert sympy.rem(det, form.zero_polynomial.as_expr(), s) == 0


@pytest.mark.costly
def test_doubly_coprime_fractions_with_symbols_are_refused_before_they_are_made():
    names = sympy.symbols("a b c")
    plant = (_matrix(4, 4) + sympy.diag(*names, 0), _matrix(4, 1, 2), _matrix(1, 4, 3))
    with at_most(9_000_000), pytest.raises(BudgetError, match="denominators of symbols"):
        doubly_coprime_fractions(plant, [-1, -2, -3, -4], [-5, -6, -7, -8], variable="s")


@pytest.mark.costly
def test_a_realisation_with_symbols_takes_one_elimination():
    a, b, s = sympy.symbols("a b s")
    below = (s + a) * (s + b) * (s + 1)
    G = [[(s + 1) / below, (s + 2) / below], [a / below, (s**4 + b) / below]]
    with at_most(2_500_000):
        system = descriptor_realisation(G)
    back = system.transfer_matrix().as_matrix() - sympy.Matrix(G)
    assert sympy.simplify(back).is_zero_matrix


def test_the_formula_of_a_gain_is_made_of_rational_rows():
    n = 12
    with at_most(1_500_000):
        formula = solve_riccati(
            _matrix(n, n), _matrix(n, 1, 2), sympy.eye(n), [[1]], time="continuous"
        ).formula
    assert formula.certificate.holds
    assert len(formula.relations) == n


def test_a_quotient_modulo_a_rational_factor_is_left_to_flint():
    """Euclid's algorithm in SymPy's lists takes 9000 calls, and minutes for a loop of order 40."""
    s, draw = sympy.Symbol("s"), random.Random(1)
    factor, top = (sympy.Poly([1, *(draw.randint(-9, 9) for _ in range(n))], s, domain="QQ")
                   for n in (60, 59))  # fmt: skip
    with at_most(2_000):
        quotient = quotient_modulo(factor, top, top + 1)
    assert (quotient * (top + 1) - top).rem(factor).is_zero


def test_a_gain_margin_is_read_and_printed_without_the_roots_of_sympy():
    s, below = sympy.Symbol("s"), sympy.Poly(1, sympy.Symbol("s"))
    for k in range(14):
        below *= sympy.Poly(s + 1 + sympy.Rational(k, 3), s)
    above = sympy.Poly([1, 2, -3, 4, 5, 6, 7], s)
    margins = stability_margins((above, below), feedback=-1)
    assert margins.is_stable
    with at_most(200_000):
        printed = [str(margins.gain_up), str(margins.gain_down)]
    up = float(printed[0].split()[0])
    poles = [sympy.Poly(below + above * sympy.Rational(f"{up * f:.12f}"), s) for f in (0.99, 1.01)]
    assert [count_roots(p).unstable > 0 for p in poles] == [False, True]


def test_a_stein_equation_is_asked_for_products_of_eigenvalues():
    names = sympy.symbols("a b c d")
    A = _matrix(4, 4) + sympy.diag(*names)
    with at_most(200_000), pytest.raises(BudgetError, match="matrix equation with symbols"):
        solve_stein(A, sympy.eye(4))
    a, b, c, d = names
    assert solve_stein([[a, b], [c, d]], sympy.eye(2)).certificate.holds
