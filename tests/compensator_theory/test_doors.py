"""What an audit of the doors found, each reproducer kept: misreadings, hangs, raw errors."""

import inspect
from decimal import Decimal
from functools import partial

import control
import numpy as np
import pytest
import scipy.signal
import scipy.sparse
import sympy
import sympy.physics.control as sympy_control
from sympy import CRootOf, I, Poly, Rational, Symbol, exp, pi, sqrt

import compensator_theory as exact
from compensator_theory import InputError
from compensator_theory.errors import BudgetError, NotCoprimeError
from tests.support.public import public_objects
from tests.support.work import Endless, Long, at_most, at_most_bytes

PUBLIC = public_objects("compensator_theory")

a, s, x, z = sympy.symbols("a s x z")
POSITIVE = Symbol("a", positive=True)
PLANT = "1/(s**2 + 1)"
BUTTERWORTH = [exp(I * pi * Rational(2 * k + 5, 8)) for k in range(4)]
CONTINUOUS = "(s + 2)/((s + 1)*(s + 3))"


# ---- parsers that cannot misread
@pytest.mark.parametrize("text", ["-1 -2", "1 2", "-1 +2j -1 -2j", "2 i", "1. 5", "3 -j"])
def test_two_numbers_are_not_one(text):
    with pytest.raises(InputError):
        exact.exact_number(text)


@pytest.mark.parametrize("text", ["-1 -2", "-1, -2", "-1;-2", " -1 ,\t-2 ", "-1.0 -4/2"])
def test_a_list_of_roots_in_a_text(text):
    assert exact.read_roots(text) == (-1, -2)
    placed = exact.place_poles("1/(s - 1)", exact.read_roots(text), feedback=-1)
    assert placed.target == exact.polynomial("(s + 1)*(s + 2)")


@pytest.mark.parametrize("number", ["-3", "-1/2", "-1e-3", "-sqrt(2)", "0"])
def test_one_number_is_a_list_of_one_root(number):
    placed = exact.place_poles("1/(s - 1)", number, feedback=-1)
    assert placed.target == exact.polynomial(f"s - ({number})", "s")
    with pytest.raises(InputError):  # a polynomial, and zero
        exact.place_poles("1/(s - 1)", f"s - s + 0*({number})", feedback=-1)


@pytest.mark.parametrize("text", ["-1 - 2", "-1 -2, -3", "-1,,-2", "", ",", "-1,", "-1; x y"])
def test_a_list_that_is_not_clear(text):
    with pytest.raises(InputError):
        exact.read_roots(text)


def test_i_after_a_number_is_the_imaginary_unit():
    assert exact.exact_number("2i") == exact.exact_number("2j") == 2 * I
    assert exact.read_roots("-1+2i -1-2i") == (-1 + 2 * I, -1 - 2 * I)


@pytest.mark.parametrize(
    "obj",
    ["(s+1)*(s+.5)", "2i - .25", "1/s + 1/(s + 1)", "s/s", 0.1, sqrt(8), exp(I * pi / 4), 1j,
     "sqrt(2)*s + a", "(s + 1)/((s + 1)*(s + a))", CRootOf(x**5 + x + 1, 0), "2**(1/3)", "0", a / s,
     "sqrt(sqrt(2) + 2)", 10**30, "pi*s", control.tf([1], [1, 2])],
)  # fmt: skip
def test_what_was_read_is_echoed_and_reads_back(obj):
    echo = exact.canonical(obj)
    assert exact.canonical(echo) == echo


# ---- one variable rule
@pytest.mark.parametrize(
    "function",
    [exact.resultant, exact.bezout.number_of_common_roots, exact.bezout_identity,
     exact.bezout.sylvester_m1, exact.bezout.sylvester_m2,
     partial(exact.spectral_factor, time="discrete")],
)  # fmt: skip
@pytest.mark.parametrize("pair", [("s + 1", "a"), ("s + 1", "z + 1"), ("s*(s + 1)", "k")])
def test_ambiguity_is_refused_by_name(function, pair):
    with pytest.raises(InputError, match="not evident"):
        function(*pair)


def test_the_variable_can_be_named():
    assert exact.resultant("s + 1", "a", variable="s") == a == exact.resultant("s + 1", ["a"])
    assert exact.resultant("s + a", "s + 2*a", variable="a") == -s
    listed = exact.bezout.sylvester_m("s**2 + a*s", ["b"], 1, 1)
    assert exact.bezout.sylvester_m("s**2 + a*s", "b", 1, 1, variable="s") == listed
    with pytest.raises(InputError, match="not evident"):
        exact.bezout.sylvester_m("s**2 + a*s", "b", 1, 1)
    with pytest.raises(InputError, match="not evident"):
        exact.transfer_function(("k", "s + 1"))
    with pytest.raises(InputError, match="one variable"):
        exact.place_poles(PLANT, "z**2 + 1", feedback=-1)
    with pytest.raises(InputError, match="one variable"):
        exact.closed_loop_polynomial(exact.standard_problem("1/q"), "z", "q")


@pytest.mark.parametrize(
    "call",
    [lambda: exact.polynomial([POSITIVE, "a"], "s"),
     lambda: exact.polynomial(POSITIVE**2 + a * a, "s"),
     lambda: exact.Realisation([[POSITIVE]], [["a"]], [[1]]),
     lambda: exact.is_controllable([[POSITIVE]], [["a"]]),
     lambda: exact.sensitivity_function("1/(s + a)", (POSITIVE, Poly(s + 1, s)), feedback=-1),
     lambda: exact.polynomial(Symbol("s", real=True) + 1, "s")],
)  # fmt: skip
def test_one_name_is_one_symbol(call):
    with pytest.raises(InputError):
        call()


# ---- time
@pytest.mark.parametrize(
    "call",
    [lambda: exact.high_authority_target(exact.standard_problem(CONTINUOUS)),
     lambda: exact.high_authority_limits(exact.standard_problem("1/(q - 2)")),
     lambda: exact.lqg_poles(exact.standard_problem("1/(x - 2)")),
     lambda: exact.lqg_controller(exact.standard_problem("1/(x - 2)")),
     lambda: exact.solve_riccati([[2]], [[1]], [[1]], variable="s", time="discrete"),
     lambda: exact.solve_riccati([[2]], [[1]], [[1]], [[1]], variable="z", time="continuous"),
     lambda: exact.regulator_spectrum([[2]], [[1]], [[1]], variable="s", time="discrete")],
)  # fmt: skip
def test_lqg_refuses_a_variable_of_the_other_time_domain_or_of_none(call):
    with pytest.raises(InputError, match="discrete"):
        call()


@pytest.mark.parametrize(
    "function",
    [partial(exact.count_roots, "x + 1"), partial(exact.locate_roots, "x + 1"),
     partial(exact.decide_stability, "x + 1"), partial(exact.decide_stability, "x + a", "x"),
     partial(exact.spectral_factor, "x + 1"), partial(exact.solve_riccati, [[2]], [[1]], [[1]]),
     partial(exact.regulator_spectrum, [[2]], [[1]], [[1]])],
)  # fmt: skip
@pytest.mark.parametrize("time", ["Continuous", "s", "", None, 0, True, [], b"discrete"])
def test_what_does_not_carry_its_time_domain_is_told(function, time):
    with pytest.raises(InputError, match="time='continuous' or time='discrete'"):
        function(time=time)
    with pytest.raises((InputError, TypeError), match="time"):
        function()


def test_a_variable_that_says_nothing_about_time():
    with pytest.raises(InputError, match="time domain of x"):
        exact.observers.is_lqg_suboptimal("1/(x - 1)", "-3/(x + 2)", feedback=1)
    with pytest.raises(InputError, match="time domain of x"):
        exact.observer_forms("1/(x - 1)", "-6/(x + 4)").fastest_observer()
    for letter, time_ in (("s", "continuous"), ("z", "discrete")):
        answer = exact.observers.is_lqg_suboptimal(
            f"1/({letter} - 1)", f"-3/({letter} + 2)", feedback=1
        )
        assert f"{time_} time" in answer.question
    assert (
        exact.solve_riccati(
            [[2]], [[1]], [[1]], variable="z", time="discrete"
        ).factor.polynomial.gen
        == z
    )


# ---- irrational roots
@pytest.mark.costly
@pytest.mark.parametrize(
    "roots",
    [[exp(I * pi / 4), exp(-I * pi / 4), -1], sympy.solve(x**3 + x + 1),
     Poly(x**3 + x + 1).all_roots(), BUTTERWORTH, [sqrt(2), -sqrt(2), -3], ["1+sqrt(3)", -1],
     [(-1) ** Rational(1, 3), -((-1) ** Rational(2, 3))], [CRootOf(x**3 + x + 1, 0), -1]],
)  # fmt: skip
def test_symmetric_irrational_roots_are_placed(roots):
    with at_most(calls=5_000_000):  # a tenth of it, where nothing was computed before
        placed = exact.place_poles("1/(s + 3)", roots, feedback=-1)
        assert placed.residual.is_zero
    assert not any(c.has(I) for c in placed.target.all_coeffs())
    near = [sympy.N(root, 30) for root in placed.roots]  # before SymPy joins their fields
    values = [complex(placed.target.as_expr().subs(s, root)) for root in near]
    assert max(map(abs, values)) < 1e-10


@pytest.mark.parametrize(
    "roots",
    [[(-1) ** Rational(1, 3)], [CRootOf(x**3 + x + 1, 1)], [exp(I * pi / 4), exp(I * pi / 4)],
     [*BUTTERWORTH[:2], *BUTTERWORTH[:2]], [sqrt(-2)], [I * pi]],
)  # fmt: skip
def test_a_complex_root_without_its_conjugate(roots):
    with pytest.raises(InputError):
        exact.place_poles("1/(s + 3)", roots, feedback=-1)


# ---- misreadings
@pytest.mark.parametrize("obj", [{2: 1, 0: 3}, {1, 2}, b"12", bytearray(b"1"), frozenset([1])])
def test_what_has_no_order_is_no_polynomial(obj):
    with pytest.raises(InputError):
        exact.polynomial(obj, "s")


def test_lists_of_roots_and_of_coefficients():
    placed = exact.place_poles("1/(s**2 + s)", [1, 6, 11, 6], feedback=-1)
    assert "ROOTS 1, 6, 11, 6" in repr(placed) and "polynomial=" in repr(placed)
    placement = exact.place_poles("1/(s**2 + s)", polynomial=[1, 6, 11, 6], feedback=-1)
    assert placement.target == exact.polynomial("(s + 1)*(s + 2)*(s + 3)") and "ROOTS" not in repr(
        placement
    )
    for both in ({}, {"target": [1], "polynomial": [1, 2]}):
        with pytest.raises(InputError):
            exact.place_poles("1/s", feedback=-1, **both)


@pytest.mark.parametrize(
    "function",
    [
        exact.observer_forms,
        exact.observers.realisation_is_observer_based,
        exact.observers.youla_forms,
    ],
)
def test_the_sign_travels_with_the_compensator(function):
    order = 2 if function is exact.observers.youla_forms else 1
    plant = "1/(s - 1)"
    placed = exact.place_poles(plant, [-1, -2, -3][: order + 1], feedback=-1)
    for part in (placed.compensator, exact.realisation(placed.compensator)):
        with pytest.raises(InputError, match="designed for feedback = -1"):
            function(plant, part)
        with pytest.raises(InputError, match="designed for feedback = -1"):
            function(plant, part, feedback=1)
        function(plant, part, feedback=-1)  # answers
    forms = exact.observer_forms(plant, placed.compensator, feedback=-1)
    assert forms.characteristic_polynomial == placed.target
    with pytest.raises(InputError, match="designed"):
        exact.closed_loop_matrix(exact.realisation(plant), exact.realisation(placed.compensator))


# ---- budget
def nested(depth):
    number = sympy.Integer(2)
    for _ in range(depth):
        number = sqrt(number + 1)
    return number


EIGHT = sum(sqrt(p) for p in (2, 3, 5, 7, 11, 13, 17, 19))


@pytest.mark.parametrize(
    "call",
    [lambda: exact.exact_number(Decimal("1E+999999999")), lambda: exact.exact_number(10**5000),
     lambda: exact.exact_number("1e999999999"), lambda: exact.exact_number("1" * 5000),
     lambda: exact.polynomial(s + EIGHT), lambda: exact.polynomial_from_roots([EIGHT], "s"),
     lambda: exact.polynomial("s + " + "sqrt(1 + " * 40 + "2" + ")" * 40),
     lambda: exact.parse_expression(f"sqrt({'7' * 3999})"), lambda: exact.polynomial(s ** (10**9)),
     lambda: exact.polynomial(range(10**9), "s"), lambda: exact.polynomial(iter(range(10**9)), "s"),
     lambda: exact.bezout.sylvester_m1("s + 1", "s", 3000, 3000),
     lambda: exact.bezout.sylvester_m("s", "1", 10**4, 0),
     lambda: exact.bezout.sylvester_m1("s + 1", "s", 10**9),
     lambda: exact.bezout.check_proposition_3("s", "1", 10**7, 0),
     lambda: exact.loops.target_characteristic_polynomial(
         exact.standard_problem("1/q"), 10**8, "1/q"),
     lambda: exact.parse_expression("sqrt(0.5-1e300**999)"), lambda: exact.read_roots("1 " * 9000),
     lambda: exact.parse_expression("j**1e300**999"), lambda: exact.parse_expression("(" * 5000),
     lambda: exact.exact_number(sympy.Float(10) ** 100000),
     lambda: exact.parse_expression(f"({'9' * 3998})**(1/3)"),
     lambda: exact.polynomial_from_roots([10**3990 + sqrt(2), sqrt(3)], "s")],
)  # fmt: skip
def test_what_is_too_large_is_refused_at_once(call):
    with at_most(calls=300_000), at_most_bytes(5_000_000), pytest.raises(InputError):
        call()


@pytest.mark.parametrize("depth", [40, 90])
def test_roots_inside_roots_are_refused_at_once(depth):
    number = nested(depth) + s
    with at_most(calls=300_000), at_most_bytes(5_000_000), pytest.raises(BudgetError):
        exact.polynomial(number, "s")


@pytest.mark.parametrize("values", [Long(10**9), Endless()], ids=["a length", "no end"])
def test_no_more_is_drawn_than_a_limit_allows(values):
    with pytest.raises(BudgetError), exact.budget(degree=20):
        exact.read_roots(values)
    assert values.drawn <= 22  # one more than the degree, and one too many


def test_of_what_has_no_order_nothing_is_drawn_as_coefficients():
    values = Endless()
    with pytest.raises(InputError, match="first and which its last"):
        exact.polynomial(values, "s")
    assert values.drawn == 0


def test_a_refusal_says_what_to_do_and_a_limit_can_be_raised():
    with pytest.raises(BudgetError, match=r"1500 as degree, and the limit is 1000.*budget\(degree"):
        exact.polynomial("s**1500 + 1")
    with exact.budget(degree=2000) as limits:
        assert limits.degree == 2000 and exact.polynomial("s**1500 + 1").degree() == 1500
    with pytest.raises(BudgetError):
        exact.polynomial("s**1500 + 1")
    for wrong in ({"degrees": 3}, {"degree": 0}, {"degree": True}, {"degree": 1.5}):
        with pytest.raises(InputError), exact.budget(**wrong):
            pass


@pytest.mark.costly
def test_what_is_long_but_small_simply_works():
    with at_most(calls=20_000_000):
        total = exact.transfer_function("+".join(f"1/(s + {i})" for i in range(300)))
        assert (total.order, total.relative_degree, total.leading_coefficient) == (300, 1, 300)
        product = exact.polynomial("*".join(f"(s + {i})" for i in range(900)))
        assert product.degree() == 900 and product.eval(1) == sympy.factorial(900)
        assert exact.polynomial(sympy.Mul(*(s + i for i in range(900)))) == product
        assert exact.observers.count_observer_forms("s + 1", 10**9) == 0


# ---- raw errors
def test_any_domain_is_read_at_the_door():
    assert exact.roots.number_of_real_roots(Poly(2 * s**2 + 3 * s + 1, s)) == 2
    assert exact.roots.reflection_coefficients(Poly(2 * z**2 + 3 * z + 1, z)) == (Rational(1, 2), 1)
    for function in (exact.certified_roots, exact.roots.number_of_real_roots, exact.monic):
        with pytest.raises(InputError):
            function(Poly(s * a + 1, s, a))
        with pytest.raises(InputError):
            function(Poly(s + 1, s, modulus=5))


def test_sympy_prints_a_compensator():
    G = exact.transfer_function("1/(s + 1)")
    assert sympy.latex(G) == r"\frac{1}{s + 1}" and sympy.sstr([G]) == "[(1)/(s + 1)]"
    assert sympy.pretty(G) == "(1)/(s + 1)"


FRACTION = sympy_control.TransferFunction(s + 1, s**2 + 1, s)
STATES = sympy_control.StateSpace(
    sympy.Matrix([[0, 1], [-1, -2]]), sympy.Matrix([0, 1]), sympy.Matrix([[1, 0]]), sympy.zeros(1)
)


@pytest.mark.parametrize(
    ("system", "expected"),
    [(FRACTION, "(s + 1)/(s**2 + 1)"), (STATES, "1/(s**2 + 2*s + 1)"),
     (sympy_control.Series(FRACTION, FRACTION), "((s + 1)/(s**2 + 1))**2"),
     (sympy_control.Series(STATES, FRACTION), "(s + 1)/((s + 1)**2*(s**2 + 1))"),
     (sympy_control.Parallel(FRACTION, FRACTION), "2*(s + 1)/(s**2 + 1)"),
     (sympy_control.Feedback(FRACTION), "(s + 1)*(s**2 + 1)/((s**2 + 1)*(s**2 + s + 2))"),
     (sympy_control.TransferFunctionMatrix([[FRACTION]]), "(s + 1)/(s**2 + 1)"),
     (scipy.signal.lti([1], [1, 2]), "1/(s + 2)"),
     (scipy.signal.lti([1], [2], 3), "3*(s - 1)/(s - 2)"),
     (scipy.signal.lti([[2]], [[1]], [[1]], [[0]]), "1/(s - 2)"),
     (scipy.signal.dlti([1], [1, 0.5], dt=0.1), "1/(z + 1/2)"),
     (control.tf([1], [1, 2]), "1/(s + 2)"),
     (control.ss(0.5, 1, 1, 0, True), "1/(z - 1/2)"),
     (control.feedback(control.ss(1, 1, 1, 0), 1), "1/s")],
)  # fmt: skip
def test_foreign_systems_of_every_kind(system, expected):
    G = exact.transfer_function(system)
    written = exact.transfer_function(expected, sample_time=G.sample_time)
    assert G.reduced() == written.reduced()
    realised = exact.realisation(system)
    assert realised.transfer_function().reduced() == G.reduced()


@pytest.mark.parametrize(
    "obj",
    [np.array(3), np.array([1, 2]), np.array([[1]]), scipy.sparse.eye(2), Poly(s * a + 1), object(),
     sympy.MatrixSymbol("A", 1, 1), sympy.Function("f")(s), sympy.Eq(s, 1), sympy.sin(s), True,
     b"1/s",
     control.frd([1, 2], [1, 2]), control.NonlinearIOSystem(None, lambda *_: 0),
     sympy_control.TransferFunctionMatrix([[FRACTION, FRACTION]]),
     control.tf([[[1], [2]]], [[[1, 1], [1, 2]]]),
     (np.ones((2, 2)), [1, 2]), (object(), 1), ([[1]], [[1]], [[1]], 5), {"gain": [1]}, {1: 2}],
)  # fmt: skip
@pytest.mark.parametrize("read", [exact.transfer_function, exact.realisation])
def test_what_is_no_system_is_our_error(read, obj):
    with pytest.raises(InputError):
        read(obj)


def test_more_raw_errors():
    one = exact.Realisation([[1]], [[1]], [[1]])
    with pytest.raises(InputError, match="2 x 2"):
        one.in_basis([[1, 0], [0, 1]])
    with pytest.raises(InputError, match="sparse"):
        exact.Realisation(*[scipy.sparse.eye(1)] * 3)
    family = exact.place_poles("1/(s - 1)", [-1, -2], feedback=-1, numerator_degree=1)
    with pytest.raises(InputError, match="variable"):
        family.member(["s"])
    with pytest.raises(NotCoprimeError):
        exact.place_poles("(s + 1)/((s + 1)*(s + 2))", ["-3", "-4", "-5"], feedback=-1)


SYSTEM = exact.Realisation([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]])
KINDS = {
    "text": "1/(s**2 + 3*s + 2)",
    "rows of texts": [["1/(s**2 + 3*s + 2)"]],
    "matrices": (SYSTEM.A, SYSTEM.B, SYSTEM.C),
    "expression": SYSTEM.transfer_function().as_expr(),
    "our matrix": SYSTEM.transfer_matrix(),
    "descriptor": exact.DescriptorSystem([[1, 0], [0, 1]], SYSTEM.A, SYSTEM.B, SYSTEM.C),
    "python-control": SYSTEM.to_control(),
    "SciPy": scipy.signal.StateSpace([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]], [[0]]),
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_system_of_any_kind_is_read_where_one_is_asked_for(kind):
    system, s = KINDS[kind], sympy.Symbol("s")
    symbol = "s" if kind == "matrices" else None
    G = SYSTEM.transfer_function()
    assert exact.transfer_function(system, symbol) == G
    assert exact.realisation(system, symbol).transfer_function() == G
    assert exact.transfer_matrix(system, symbol)[0, 0] == G
    if kind != "rows of texts":  # a list is coefficients there
        assert exact.canonical(system, symbol) == str(G)
    for loop in (
        exact.closed_loop_matrix(system, "1/(s + 4)", variable=symbol),
        exact.closed_loop_matrix("1/(s + 4)", system, variable=symbol),
    ):
        assert loop.charpoly(s).as_expr() == sympy.expand((s**2 + 3 * s + 2) * (s + 4) - 1)


# ---- conversions certify themselves
@pytest.mark.parametrize("text", ["(s + 3)/(s**2 + 2*s)", "(s**2 + a)/((s + 1)*(s + b))", "2/3"])
@pytest.mark.parametrize("form", ["controllable", "observable"])
def test_conversions_carry_their_certificate(text, form):
    G = exact.transfer_function(text, "s")
    realised = exact.realisation(G, form=form)
    assert realised.certificate.holds and "det(sI - A)" in str(realised.certificate)
    back = realised.transfer_function()
    assert back == G and back.certificate.holds
    assert realised.transfer_matrix()[0, 0].certificate.holds


def test_loops_carry_their_certificate():
    plant = exact.servo_problem("1/(q**2 - 2*q)")
    closed = exact.loops.closed_loop_transfer_matrix(plant, "-2*q", "q**2 + a")
    assert closed.certificate.holds and closed[0, 0].certificate.holds
    assert exact.intercalated_transfer_function(plant, "1", "q").certificate.holds
    design = exact.lqg_controller(exact.standard_problem("(q - 2)/(q**2 - 1/4)"))
    assert design.regulator.certificate.holds and design.estimator.certificate.holds


@pytest.mark.parametrize(
    ("door", "value"),
    [
        (exact.polynomial, np.array(3)),
        (exact.certified_roots, "s+" * 30_000 + "1"),
        (exact.roots.number_of_real_roots, 10**100_000 * s),
        (lambda v: exact.solve_riccati(v, [[1]], [[1]], time="discrete"), "9" * 50_000),
    ],
)
def test_a_refusal_is_ours_and_short(door, value):
    with pytest.raises(InputError) as caught:
        door(value)
    assert len(str(caught.value)) < 500


# ---- matrices, at every door that takes a transfer function
MATRICES = ([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]])


@pytest.mark.parametrize(
    "answer",
    [exact.mcmillan_degree, exact.h_infinity_norm, exact.coprime_fractions,
     exact.forms.smith_mcmillan_form, exact.transfer_matrix, exact.transfer_function,
     partial(exact.place_poles, target="-1, -2, -3, -4", feedback=-1),
     partial(exact.stabilising_gains, feedback=-1), exact.partial_fractions,
     partial(exact.markov_parameters, count=4), exact.decide_strong_stabilisability,
     partial(exact.decide_simultaneous_stabilisability, second="1/s", feedback=-1),
     partial(exact.stable_compensator, feedback=-1),
     *(partial(loop, compensator="-9/(s**2 + 7*s + 1)", feedback=1) for loop in (
         exact.sensitivity_function, exact.feedback_connection,
         exact.observers.pair_is_observer_based,
         exact.observers.transfer_function_is_observer_based, exact.observers.is_lqg_suboptimal)),
     partial(exact.loops.compensator_from_sensitivity, sensitivity="s*(s + 1)/(s*(s + 1) + 3)",
             feedback=-1)],
)  # fmt: skip
def test_matrices_are_their_transfer_function(answer):
    G = exact.transfer_function("1/(s**2 + 3*s + 2)")
    arrays = tuple(map(np.array, MATRICES))
    for matrices in (MATRICES, (*MATRICES, [[0]]), (*MATRICES, None), arrays):
        assert answer(matrices, variable="s") == answer(G)
        with pytest.raises(InputError, match="do not show the time domain"):
            answer(matrices)


@pytest.mark.parametrize(
    "answer",
    [partial(exact.observer_forms, compensator="-9/(q**2 + 7*q + 1)"),
     partial(exact.observers.realisation_is_observer_based, compensator="-9/(q**2 + 7*q + 1)"),
     partial(exact.observers.youla_forms, compensator="-9/((q**2 + 7*q + 1)*(q + 2))"),
     partial(exact.observer_based_compensator, regulator_poles=[0, 0], observer_poles=[0, 0]),
     partial(exact.solve_regulator_equations, S=[[1]], Q=[[-1]])],
)  # fmt: skip
def test_matrices_have_the_variable_that_is_written(answer):
    assert answer(MATRICES, variable="q") == answer(exact.realisation(MATRICES, "q"))


@pytest.mark.parametrize("name", sorted(PUBLIC.keys() - {"target_characteristic_polynomial"}))
def test_whatever_reads_a_text_lets_its_variable_be_named(name):
    """(That one's plant, a StandardProblem, says it.)"""
    function = PUBLIC[name]
    if inspect.isfunction(function):
        parameters = inspect.signature(function).parameters
        kinds = ("TransferFunctionLike", "TransferMatrixLike", "RealisationLike", "LoopPart",
                 "PolynomialLike")  # fmt: skip
        reads = any(kind in str(one.annotation) for kind in kinds for one in parameters.values())
        assert not reads or "variable" in parameters


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_settings_stand_in_one_place(name):
    """What reads one object takes `variable` second; everything else takes it by name alone."""
    if not inspect.isfunction(PUBLIC[name]):
        return
    parameters = inspect.signature(PUBLIC[name]).parameters
    by_place = [one.name for one in parameters.values() if one.kind is not one.KEYWORD_ONLY]
    assert not {"feedback", "time", "digits"} & set(by_place)
    if "variable" in parameters:
        assert ("variable" in by_place) == (by_place[1:] in ([], ["variable"]))


def test_rows_of_a_transfer_matrix_are_no_matrices():
    pairs = [[(1, 2), (3, 4)], [(5, 6), (7, 8)], [(1, 2), (1, "s + 3")]]
    assert exact.transfer_matrix(pairs, "s").shape == (3, 2)
    assert exact.transfer_matrix(pairs[:2], "s").shape == (2, 2)
    pairs[2][1] = (1, 3)  # may be A, B and C
    with pytest.raises(InputError, match="may be the matrices"):
        exact.transfer_matrix(pairs, "s")
    matrices = [[[1, 2], [3, 4]], [[5, 6], [7, 8]], [[1, 2], [1, 3]]]
    assert exact.transfer_matrix(matrices, "s") == exact.transfer_matrix(tuple(matrices), "s")
    assert exact.transfer_matrix([["1/s"], ["2/s"], ["3/s"]]).shape == (3, 1)
