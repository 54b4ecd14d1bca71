"""Realisations, connections and zeros of systems."""

import control
import numpy as np
import pytest
import sympy as sp
from scipy import signal
from sympy.physics.control.lti import TransferFunction as SympyTransferFunction

import compensator_theory as ct
from tests.support.world import case

s = sp.Symbol("s")
NUM, DEN = [[[1], [2]], [[3], [4]]], [[[1, 1], [1, 2]], [[1, 3], [1, 4]]]


def same(answer, right):
    return sp.simplify(sp.sympify(answer) - sp.sympify(right)) == 0


THERE_AND_BACK = [
    case("SymPy-26827", "K/(T_1*s + 1)", 1),
    case("SymPy-26827b", "(K*s + 2)/(T_1*s + 1)", 1),
    case("SymPy-26827c", "(b*s + c)/(3*s**2 + a)", 2),
    case("SymPy-29179", "5", 0),
    case("SymPy-28685", "a/b", 0),
    case("SymPy-30450", "7/3", 0),
    case("pc-1068-motor", "0.01/(0.005*s**3 + 0.06*s**2 + 0.1001*s)", 3),
    case("JL-475", "1/s**4", 4),
]


@pytest.mark.parametrize(("text", "order"), THERE_AND_BACK)
def test_a_realisation_gives_its_transfer_function_back(text, order):
    """By hand: the degree; a constant has no state, a motor no zeros."""
    system = ct.realisation(text, "s")
    assert system.n == order
    want = sp.sympify(text, rational=True, locals={"s": s})
    assert same(system.transfer_function().as_expr(), want)


def test_three_systems_in_series():
    """SymPy #28220: each of order 2, so 6 states; 8(s-1)^3/(s-1)^6, written out by hand."""
    part = ct.realisation("2*(s - 1)/(s - 1)**2", "s")
    whole = part @ part @ part
    assert whole.n == 6
    assert same(whole.transfer_function().as_expr(), "8*(s - 1)**3/(s - 1)**6")


@pytest.mark.parametrize(
    "operation",
    [
        case(
            "SymPy-26863",
            lambda a, b: (a.feedback_with(b, feedback=-1), lambda x, y: x.feedback(y)),
        ),
        case("SymPy-26718", lambda a, b: (a + b, lambda x, y: x + y)),
        case("SymPy-26647", lambda a, b: (a @ b, lambda x, y: x * y)),
        case(
            "pc-1172",
            lambda a, b: (a.feedback_with(b, feedback=1), lambda x, y: x.feedback(y, sign=1)),
        ),
    ],
)
def test_operations_of_several_inputs(operation):
    """Against python-control, at 0.7j."""
    A, B, C, D = [[0, 1], [-2, -3]], [[1, 0], [0, 1]], [[1, 2], [0, 1]], [[0, 0], [0, 0]]
    F, G, H, J = [[-1, 2], [0, -4]], [[1, 1], [0, 2]], [[1, 0], [3, 1]], [[1, 0], [0, 2]]
    ours, theirs = operation(ct.realisation((A, B, C, D), "s"), ct.realisation((F, G, H, J), "s"))
    want = theirs(control.ss(A, B, C, D), control.ss(F, G, H, J))(0.7j)
    values = np.array(
        ours.transfer_matrix().as_matrix().subs(s, sp.I * sp.Rational(7, 10)).evalf().tolist(),
        complex,
    )
    assert values == pytest.approx(want, abs=1e-12)


DEGREES = [
    case("pc-111", [["1/s", 0], [0, "1/s"]], 2),
    case("pc-240", [["1/(s + 1)", "2/(s + 1)"], ["1/(s + 2)", "2/(s + 2)"]], 2),
    case("JL-828", [["1/(s + 1)", 0], [0, "1/(s + 1)"]], 2),
    case("pc-240-tiny", "1/(1e-10*s**3 + s**2 + 3*s + 2)", 3),
    case("pc-111-num-den", (NUM, DEN), 4),
    case("harold-1-num-den", ([[[1], [2]]], [[[1, 1], [1, 2]]]), 2),
    case("pc-1172-control", control.tf(NUM, DEN), 4),
]


@pytest.mark.parametrize(("system", "right"), DEGREES)
def test_mcmillan_degrees(system, right):
    """By hand, from the minors; of num and den as MATLAB and python-control take them."""
    try:
        result = ct.mcmillan_degree(system, "s")
    except ct.CompensatorError:
        assert isinstance(system, tuple)  # refused is right too: such a nest is ambiguous
        return
    assert result == right
    if not isinstance(system, tuple):
        assert ct.minimal_realisation(system, "s").order == right


def test_num_and_den_have_the_shape_of_python_control():
    """One output, two inputs."""
    argument = ([[[1], [2]], [[3], [4]]], [[[1, 1], [1, 2]], [[1, 3], [1, 4]]])
    want = control.tf(*argument)(1.0)
    G = ct.transfer_matrix(control.tf(*argument)).as_matrix().subs(s, 1)
    assert np.array(G.evalf().tolist(), float) == pytest.approx(want.real)


REDUCED = [
    case("pc-640", "(0.1*s + 0.2)/((0.1*s + 0.2)*(s + 0.5))", "2/(2*s + 1)"),
    case("JL-545", "(s + 0.3)*(s + 1.1)/((s + 0.3)*(s + 1.1)*(s + 2))", "1/(s + 2)"),
    case("JL-835", "s*(s + 2)/(s*(s + 2)*(s + 3))", "1/(s + 3)"),
    case("JL-341", "1/(1/R + 1/(s*L + 1/(s*C)))", "(s**2*L*C + 1)*R/(s**2*L*C + 1 + R*C*s)"),
]


@pytest.mark.parametrize(("system", "right"), REDUCED)
def test_common_factors_of_decimals_cancel(system, right):
    """By hand."""
    assert same(ct.transfer_function(system, "s").reduced().as_expr(), right)


@pytest.mark.costly
def test_nested_loops_with_ten_symbols():
    """SymPy #26161, #26293: two loops around each other, against SymPy's cancel."""
    a, b, c, d, e, f, g, h, k, m = sp.symbols("a b c d e f g h k_1 m_1")
    inner_plant, inner = (a * s + b) / (c * s + d), e / (f * s + 1)
    outer_plant, outer = g / (h * s + 1), k * s + m
    first = ct.feedback_connection(inner_plant, inner, feedback=-1, variable="s")
    whole = ct.feedback_connection(
        first * ct.transfer_function(outer_plant, "s"),
        ct.transfer_function(outer, "s"),
        feedback=-1,
    )
    want = inner_plant / (1 + inner_plant * inner)
    want = want * outer_plant / (1 + want * outer_plant * outer)
    assert same(sp.cancel(whole.as_expr() - want), 0)


LOOPS = [
    case("SCS-8", "b/(s + a)", "(K_p*s + K_i)/s", 2),
    case("JL-503", "1/(s + 1)", "(2*s + 1)/s", 2),
    case("pc-1102", "500*s/((s + 5)*(s + 10))", "1", 2),
]


@pytest.mark.parametrize(("plant", "controller", "degree"), LOOPS)
def test_a_closed_loop_has_the_least_degree(plant, controller, degree):
    """Plant and controller have so many poles, and the loop no more."""
    loop = ct.feedback_connection(plant, controller, feedback=-1, variable="s")
    assert sp.degree(sp.fraction(sp.cancel(loop.as_expr()))[1], s) <= degree
    assert loop.order <= degree


def test_feedback_keeps_the_sample_time():
    """JL #125."""
    loop = ct.feedback_connection(
        ct.transfer_function(control.tf([1], [1, -0.5], 1)),
        ct.transfer_function(control.tf([1], [1, 0], 1)),
        feedback=-1,
    )
    assert str(loop.variable) == "z"


ZEROS = [
    case("pc-1158", [["1/(s + 1)", "2/(s + 1)"], ["3/(s + 1)", "4/(s + 2)"]], "s + 4"),
    case("pc-859", [["(s - 1)/(s + 1)**2"]], "s - 1"),
    case("pc-229", [["1/(s + 1)", "1/(s + 2)"], ["1/(s + 3)", "1/(s + 3)"]], "1"),
    case("harold-1", [["(s - 2)/(s + 1)", 0], [0, "(s + 3)/(s + 2)"]], "s**2 + s - 6"),
    case("JL-891", [["(s + 1)*(s + 2)/(s + 3)**3", "1/(s + 3)**3", "s/(s + 3)**3"]], "1"),
    case("JL-891b", [["(s + 1)*(s + 2)/(s + 3)**3"]], "s**2 + 3*s + 2"),
]


@pytest.mark.parametrize(("G", "right"), ZEROS)
def test_transmission_zeros(G, right):
    """By hand, from the numerators of the largest minors over the pole polynomial."""
    assert same(ct.transmission_zeros(G, "s").polynomial.as_expr(), right)


def test_no_invariant_zero_is_invented():
    """pc #1068: a chain of four integrators; none, where float64 gives some near 1e4."""
    A = [[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]]
    plant = (A, [[0], [0], [0], [1]], [[1, 0, 0, 0]], [[0]])
    assert ct.invariant_zeros(plant, "s").polynomial.degree() == 0


POLES = [
    case(
        "SymPy-26975",
        "8*(s + 1)*(s - 2)/((s + 3)*(s**2 + 2*s + 2))",
        {-1, 2},
        {-3, -1 + 1j, -1 - 1j},
    ),
    case("JL-835b", "(s + 1)/(s**2 + 3*s)", {-1}, {0, -3}),
]


@pytest.mark.parametrize(("system", "zeros", "poles"), POLES)
def test_poles_and_zeros(system, zeros, poles):
    """By hand: written from them."""
    G = ct.transfer_function(system, "s")
    assert sorted(map(complex, (r.value for r in G.zeros())), key=str) == pytest.approx(
        sorted(map(complex, zeros), key=str)
    )
    ordered = sorted((r.value for r in G.poles()), key=lambda v: (v.real, v.imag))
    assert ordered == pytest.approx(sorted(map(complex, poles), key=lambda v: (v.real, v.imag)))


DOORS = [
    case("greek-text", lambda: ct.transfer_function("1/(s + beta)", "s").order, 1),
    case("caret", lambda: ct.transfer_function("1/(s^2 + 1)").order, 2),
    case(
        "E-is-a-symbol",
        lambda: len(ct.transfer_function("E/(s + N)", "s").as_expr().free_symbols),
        3,
    ),
    case("Python-j", lambda: ct.transfer_function("1/((s + 1 + 2j)*(s + 1 - 2j))", "s").order, 2),
    case("lead-with-z-lists", lambda: ct.transfer_function(([1, "z"], [1, "p"]), "s").order, 1),
    case("lead-with-z-text", lambda: ct.transfer_function("(s + z)/(s + p)", "s").order, 1),
    case(
        "pc-715", lambda: ct.realisation(([[0, 1], [0, 0]], [[0], [1]], [[1, 0]], [[0]]), "s").n, 2
    ),
    case("pi-in-text", lambda: ct.transfer_function("1/(s + pi)").as_expr().subs(s, 0), 1 / sp.pi),
    case("scipy-lti", lambda: ct.transfer_function(signal.lti([1], [1, 3, 2])).order, 2),
    case(
        "SymPy-TransferFunction",
        lambda: ct.transfer_function(SympyTransferFunction(s + 1, s**2, s)).order,
        2,
    ),
]


@pytest.mark.parametrize(("ask", "right"), DOORS)
def test_what_people_write_is_read(ask, right):
    assert ask() == right


REFUSED = [
    case("text-i", lambda: ct.transfer_function("1/(s + i)", "s"), "I"),
    case("text-0/0", lambda: ct.transfer_function("0/0", "s"), "zero|0"),
    case("text-nan", lambda: ct.transfer_function("nan/(s + 1)"), "nan"),
    case("pc-626", lambda: ct.realisation(sp.exp(-s) / (s + 1), "s"), "pade"),
    case("pc-238-text", lambda: ct.partial_fractions("exp(-5*s)/(s + 1)", "s"), "pade"),
    case("two-variables", lambda: ct.transfer_function("(s + 1)/(z + 1)"), "variable"),
]


def test_a_dead_time_is_part_of_a_system():
    """pc-626, pc-238: exp(-5*s) in a transfer function, as expression and as text."""
    for one in (sp.exp(-5 * s) / (s + 1), "exp(-5*s)/(s + 1)"):
        G = ct.transfer_function(one, "s")
        assert (G.delay, G.rational) == (5, ct.transfer_function("1/(s + 1)"))


@pytest.mark.parametrize(("ask", "words"), REFUSED)
def test_what_has_no_meaning_is_refused(ask, words):
    with pytest.raises(ct.CompensatorError, match=words):
        ask()
