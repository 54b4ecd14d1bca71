"""High-authority LQG: the examples of the text, residuals, and SciPy's Riccati solver."""

import numpy as np
import pytest
import scipy.linalg
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.errors import (
    NoSolutionError,
    NotControllableError,
    NotObservableError,
    UnitCircleError,
)
from compensator_theory.loops import target_characteristic_polynomial
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.roots import (
    enclose_split_at_unit_circle,
    monic_reciprocal_polynomial,
    split_at_unit_circle,
)
from compensator_theory.strategies import matrices, standard_problems

q, z = sympy.symbols("q z")


def problem(A, B, D_1, C, E_1):
    def column(values):
        return [[x] for x in values]

    return ct.StandardProblem(A, column(B), [C], column(D_1), None, None, [E_1], None, None)


EXAMPLE_A1 = problem(
    A=[[".4", ".0958", ".1183", ".3162"], [0, ".81", 1, 0], [0, "-.1539", ".81", ".4813"],
       [0, 0, 0, "-.5"]],
    B=[0, 0, 0, 1], D_1=["-.3807", "-.2039", ".1771", ".8844"],
    C=[".4456", ".0832", "-.332", "-.8272"], E_1=["-.274", ".2625", ".3241", ".8666"],
)  # fmt: skip
EXAMPLE_A2 = problem(
    A=[[".81", 1, 0], ["-.1539", ".81", ".6998"], [0, 0, ".5"]],
    B=[0, 0, 1], D_1=[".1841", ".1074", ".9770"],
    C=[".9280", ".1102", ".3558"], E_1=[".4531", "-.3513", ".8193"],
)  # fmt: skip
EXAMPLE_4_1 = problem(
    A=[[".855", 1, 0, 0, 0], ["-.1715", ".855", "-.4266", "-.3607", ".4952"],
       [0, 0, ".5", "-.5072", ".6964"], [0, 0, 0, ".6716", 1], [0, 0, 0, "-.4514", ".6716"]],
    B=[0, 0, 0, 0, 1], D_1=["-.6269", ".3985", "-.3306", ".4415", ".3794"],
    C=[".7298", "-.3954", "-.3605", ".4003", ".1447"],
    E_1=[".1717", ".3351", "-.5294", "-.4476", ".6145"],
)  # fmt: skip


def as_float(matrix):
    return np.array(matrix.tolist(), dtype=float)


def scipy_polynomial(side):
    """Coefficients of the regulator's polynomial by SciPy; poles at 0 are too ill-conditioned."""
    A, B, Q, R, N = (as_float(getattr(side, name)) for name in "ABQRN")
    P = scipy.linalg.solve_discrete_are(A, B, Q, R, s=N)
    K = -np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A + N.T)
    return P, np.poly(A + B @ K)


def coefficients(enclosure):
    return np.array([float(c) for c in enclosure.coefficients])


@pytest.mark.parametrize("plant", [EXAMPLE_A1, EXAMPLE_A2], ids=["A.1", "A.2"])
def test_examples_a1_and_a2_are_exact(plant):
    controller = ct.lqg_controller(plant)
    for side in (controller.regulator, controller.estimator):
        assert side.is_rational and side.certificate.holds
        assert all(ball.centre == ball.radius == 0 for row in side.residual for ball in row)
        closed = side.A + side.B * side.K
        assert characteristic_polynomial(closed, q) == side.factor.polynomial
        assert ct.decide_stability(side.factor.polynomial, time="discrete").by_roots
        assert (side.B.T * side.P * side.B)[0] == side.factor.constant.centre
    assert ct.closed_loop_polynomial(
        plant, controller.compensator.numerator, controller.compensator.denominator
    ) == controller.polynomial  # fmt: skip


def test_example_a1_has_the_zeros_of_the_plant_and_two_poles_at_0():
    controller = ct.lqg_controller(EXAMPLE_A1).polynomial
    expected = q**2 * (EXAMPLE_A1.numerator("zu") * EXAMPLE_A1.numerator("yw")).monic().as_expr()
    assert sympy.expand(controller.as_expr() - expected) == 0


def test_example_a2_has_one_pole_at_0_on_each_side():
    """(A.15) as printed has only n - n_u = 1 zeros on each side; the plant has order 3."""
    poles = ct.lqg_controller(EXAMPLE_A2).poles
    for factor, channel in ((poles.regulator, "zu"), (poles.estimator, "yw")):
        N = EXAMPLE_A2.numerator(channel)
        inside, outside = split_at_unit_circle(N)
        assert inside.degree() == 0 and outside.degree() == 2
        assert factor.polynomial == q * monic_reciprocal_polynomial(outside)
        moduli = [abs(root.value) for root in ct.certified_roots(outside)]
        expected = 1.200 if channel == "zu" else 1.289
        assert moduli == pytest.approx([expected] * 2, abs=5e-4)


def test_example_4_1_is_enclosed():
    controller = ct.lqg_controller(EXAMPLE_4_1)
    innovation = controller.regulator.factor.constant
    assert "0.8953897282086" in repr(innovation) and innovation.radius < sympy.Rational(1, 10**30)
    outside = enclose_split_at_unit_circle(EXAMPLE_4_1.numerator("zu"))[1]
    H = EXAMPLE_4_1.numerator("zu").LC()
    assert abs((outside.coefficients[-1].centre * H) ** 2 - innovation.centre) < 1e-25
    for side in (controller.regulator, controller.estimator):
        assert side.is_exact and not side.is_rational and side.certificate.holds
        assert all(0 in ball for row in side.residual for ball in row)
        worst = max(ball.radius for row in side.P_enclosure for ball in row)
        assert worst <= sympy.Rational(1, 10**30)
        P, scipys = scipy_polynomial(side)
        assert coefficients(side.factor.enclosure) == pytest.approx(scipys, abs=1e-13)
        mine = np.array([[float(c) for c in row] for row in side.P_enclosure])
        assert mine == pytest.approx(P, abs=1e-12)
    assert (controller.polynomial, controller.compensator) == (None, None)
    assert controller.enclosure.degree == 10
    target = ct.high_authority_target(EXAMPLE_4_1)
    assert target.transfer_function is None and target.d_zu == target.d_yw == 1
    # Literally, (4.24) has relative degree -4 here; it must be d_zu, with leading coefficient H.
    assert target.denominator.degree - target.numerator.degree == 1
    assert H in target.numerator.coefficients[0]
    assert target.denominator.coefficients[0].centre == 1


@pytest.mark.costly
@given(standard_problems(max_order=3, max_signals=1, has_direct_term=True))
def test_riccati_equations_of_random_plants(plant):
    try:
        controller = ct.lqg_controller(plant)
    except ct.CompensatorError as error:
        assert isinstance(
            error, NoSolutionError | UnitCircleError | NotControllableError | NotObservableError
        )
        assume(False)
    pencil = ct.lqg_poles(plant)
    for side, factor in (
        (controller.regulator, pencil.regulator), (controller.estimator, pencil.estimator)
    ):  # fmt: skip
        assert all(0 in ball for row in side.residual for ball in row)
        assert side.factor.polynomial == factor.polynomial
        assert abs(side.factor.constant.centre - factor.constant.centre) < 1e-20
    if controller.polynomial is not None:
        target = ct.high_authority_target(plant).transfer_function
        assert target_characteristic_polynomial(plant, plant.n, target) == controller.polynomial
        G_c = controller.compensator
        loop = ct.closed_loop_polynomial(plant, G_c.numerator, G_c.denominator)
        assert loop == controller.polynomial


@given(standard_problems(max_order=3, max_signals=1))
def test_scipy_agrees_on_the_coefficients(plant):
    try:
        side = ct.lqg_controller(plant).regulator
    except ct.CompensatorError:
        assume(False)
    assume(all(abs(abs(r.value) - 1) > 0.05 for r in ct.certified_roots(plant.numerator("zu"))))
    _, scipys = scipy_polynomial(side)
    assert coefficients(side.factor.enclosure) == pytest.approx(scipys, abs=1e-6)


@given(st.integers(1, 3), st.integers(1, 3), st.integers(1, 3), st.data())
def test_the_pencil_of_several_signals(n, l_u, l_z, data):
    A, B = data.draw(matrices(n, n)), data.draw(matrices(n, l_u))
    E_1, E_2 = data.draw(matrices(l_z, n)), data.draw(matrices(l_z, l_u))
    spectrum = ct.regulator_spectrum(A, B, E_1=E_1, E_2=E_2, time="discrete", variable=z)
    # The identity G~ G = p / (D D~), by the transfer matrices themselves.
    point = sympy.Rational(7, 3)
    assume(all((x * sympy.eye(n) - A).det() != 0 for x in (point, 1 / point)))
    forward = E_1 * (point * sympy.eye(n) - A).inv() * B + E_2
    backward = E_1 * (sympy.eye(n) / point - A).inv() * B + E_2
    expected = (backward.T * forward).det() * (
        (point * sympy.eye(n) - A).det() * (sympy.eye(n) / point - A).det() * point**n
    )
    assert spectrum.eval(point) == expected
    coefficients = [spectrum.coeff_monomial(z**k) for k in range(2 * n + 1)]
    assert coefficients == coefficients[::-1]


def test_several_signals_against_scipy():
    rng = np.random.default_rng(5)
    for n, l_u, l_z in ((3, 2, 2), (4, 2, 3), (5, 3, 3)):
        entries = [
            sympy.Matrix(
                *shape, [sympy.Rational(int(x), 7) for x in rng.integers(-9, 9, np.prod(shape))]
            )
            for shape in ((n, n), (n, l_u), (l_z, n), (2, n), (n, 2))
        ]
        A, B, E_1, C, D_1 = entries
        D_2 = sympy.Matrix([[0, 0], [0, 0]])
        plant = ct.StandardProblem(A, B, C, D_1, None, D_2, E_1, None, None)
        poles = ct.lqg_poles(plant)
        controller = ct.lqg_controller(plant)
        for side in (controller.regulator, controller.estimator):
            P, _ = scipy_polynomial(side)
            mine = np.array([[float(c) for c in row] for row in side.P_enclosure])
            assert mine == pytest.approx(P, rel=1e-7, abs=1e-7 * abs(P).max())
            assert not side.is_exact or side.certificate.holds
        _, regulator = scipy_polynomial(controller.regulator)
        _, estimator = scipy_polynomial(controller.estimator)
        assert coefficients(poles.regulator.enclosure) == pytest.approx(regulator, abs=1e-9)
        assert coefficients(poles.estimator.enclosure) == pytest.approx(estimator, abs=1e-9)
        assert coefficients(poles.enclosure) == pytest.approx(
            np.polymul(regulator, estimator), abs=1e-8
        )


def test_unique_only_among_the_stabilising_solutions():
    """P = E_1'E_1 solves (A.7) with R_2 = 0 too, and leaves the plant's unstable zeros as poles."""
    A, B, E_1 = EXAMPLE_A2.A, EXAMPLE_A2.B, EXAMPLE_A2.E_1
    P = E_1.T * E_1
    gain_row = B.T * P * A
    innovation = (B.T * P * B)[0]
    assert (A.T * P * A - gain_row.T * gain_row / innovation + E_1.T * E_1 - P).is_zero_matrix
    closed = characteristic_polynomial(A - B * gain_row / innovation, q)
    assert not ct.decide_stability(closed, time="discrete").is_stable
    assert ct.solve_riccati(A, B, E_1=E_1, time="discrete").P != P


@pytest.mark.parametrize(
    ("G", "error", "message"),
    [
        ("(q - 1)/(q**2 - 1/4)", UnitCircleError, "q - 1"),
        ("(q**2 + 1)/(q**3 - 1/8)", UnitCircleError, r"q\*\*2 \+ 1"),
        ("0/(q - 1/2)", NoSolutionError, "N_zu = 0"),
        ("(q - 3)/((q - 3)*(q - 2))", NotObservableError, "unobservable"),
        ("(q - a)/(q**2 - 1/4)", ct.InputError, "a"),
        ("q/(q**2 - a)", ct.InputError, "a"),
    ],
)
def test_refused_by_name(G, error, message):
    with pytest.raises(error, match=message):
        ct.lqg_controller(ct.standard_problem(G, "q"))


def test_other_bad_input():
    two = ct.StandardProblem([[2]], [[1, 1]], [[1]], [[1]], None, None, [[1]], None, None)
    with pytest.raises(ct.InputError, match="scalar"):
        ct.high_authority_target(two)
    with pytest.raises(NoSolutionError, match="rank"):
        ct.lqg_controller(two)
    for function in (ct.lqg_controller, ct.high_authority_target):
        with pytest.raises(ct.InputError):
            function("1/q")
    with pytest.raises(NoSolutionError, match="rank"):
        ct.lqg_poles(two)
    with pytest.raises(UnitCircleError, match="from u to z"):
        ct.lqg_poles(ct.standard_problem("(q - 1)/(q**2 - 1/4)"))
    for arguments in (([[1, 2]], [[1]], [[1]]), ([[1]], [[1], [2]], [[1]]), ([["a"]], [[1]], [[1]]),
                      ([[1]], [[1]], [[1, 2]]), ([[float("nan")]], [[1]], [[1]]),
                      ([], [], [])):  # fmt: skip
        with pytest.raises(ct.InputError):
            ct.solve_riccati(*arguments, time="discrete")
        with pytest.raises(ct.InputError):
            ct.regulator_spectrum(*arguments, time="discrete", variable=q)
    with pytest.raises(ct.InputError):
        ct.lqg_controller(ct.standard_problem("(q - 2)/(q**2 - 1/4)"), digits=0)


def test_they_print():
    for plant in (EXAMPLE_A2, EXAMPLE_4_1):
        controller = ct.lqg_controller(plant)
        items = (
            controller,
            controller.poles,
            controller.regulator,
            ct.high_authority_target(plant),
        )
        for item in items:
            assert str(item) and item._repr_latex_().startswith(r"$\displaystyle")


def test_a_hidden_unstable_mode_has_no_lqg_poles():
    with pytest.raises(ct.CompensatorError, match="not all inside the unit circle"):
        ct.lqg_poles(ct.standard_problem("(q - 2)/((q - 2)*(q - 3))"))
    stable = ct.lqg_poles(ct.standard_problem("(q - 1/4)/((q - 1/4)*(q - 3))")).polynomial
    assert stable.eval(sympy.Rational(1, 4)) == 0
