"""Gains, observers and compensators that place poles."""

import pytest
import sympy as sp

import compensator_theory as ct
from compensator_theory.errors import NotControllableError
from tests.support.world import case

s = sp.Symbol("s")

GAINS = [
    # u = K x, so that A + B K has the poles; by comparing coefficients.
    case("pc-177", [[0, 1], [100, 0]], [[0], [1]], ["-20+10j", "-20-10j"], [[-600, -40]]),
    case("forum-double", [[0, 1], [0, 0]], [[0], [1]], [-2, -3], [[-6, -5]]),
    case("JL-456-single", [[0, 1], [2, 3]], [[0], [1]], [-1, -1], [[-3, -5]]),
    case(
        "Google-group",
        [["a", "b"], ["c", "d"]],
        [[0], [1]],
        ["p", "q"],
        [["(-a**2 + a*(p + q) - b*c - p*q)/b", "p + q - a - d"]],
    ),
]


@pytest.mark.parametrize(("A", "B", "poles", "right"), GAINS)
def test_regulator_gains(A, B, poles, right):
    """By hand: the characteristic polynomial of A + B K, compared."""
    matrix = sp.Matrix(ct.regulator_gain(A, B, poles))
    want = sp.Matrix(right).applyfunc(sp.sympify)
    assert (matrix - want).applyfunc(sp.simplify) == sp.zeros(*matrix.shape)


def test_an_aerospace_exercise():
    """AE353's third-order pair with poles -1, -3, -4: checked by the determinant."""
    A, B = sp.Matrix([[1, 2, 0], [0, 1, 3], [1, 0, 1]]), sp.Matrix([[1], [0], [1]])
    K = sp.Matrix(ct.regulator_gain(A, B, [-1, -3, -4]))
    assert sp.factor((s * sp.eye(3) - A - B * K).det() - (s + 1) * (s + 3) * (s + 4)) == 0


def test_a_luenberger_double_pole():
    """NPTEL: oscillator at w, both poles at -10 w: gains 20 w and 99 w^2."""
    w = sp.Symbol("w")
    gain = ct.observer_gain([[0, 1], ["-w**2", 0]], [[1, 0]], ["-10*w", "-10*w"])
    assert gain == sp.Matrix([20 * w, 99 * w**2])


FAMILIES = [
    case("pc-1190", [[0, 1, 0], [0, 0, 1], [1, 2, 3]], [[1, 0], [0, 1], [1, 1]], [-1, -2, -3]),
    case("pc-117", [[0, 1], [-2, -3]], [[1, 0], [0, 1]], [-4, -5]),
    case("JL-456", [[1, 1], [0, 2]], [[1, 2], [3, 5]], [-1, -2]),
]


@pytest.mark.parametrize(("A", "B", "poles"), FAMILIES)
def test_with_several_inputs_every_gain_is_given(A, B, poles):
    """One of them by regulator_gain, all by the family; checked by det."""
    one = sp.Matrix(ct.regulator_gain(A, B, poles))
    placed = (s * sp.eye(len(A)) - sp.Matrix(A) - sp.Matrix(B) * one).det()
    assert sp.simplify(placed - sp.prod([s - pole for pole in poles])) == 0
    family = ct.state_feedback_family(A, B, poles)
    m, n = family.shape
    some = sp.Matrix(family.gain([[7 * i + 2 * j + 1 for j in range(n)] for i in range(m)]))
    result = (s * sp.eye(len(A)) - sp.Matrix(A) - sp.Matrix(B) * some).det()
    assert sp.simplify(result - sp.prod([s - pole for pole in poles])) == 0


PLACED = [
    case("LSU-slide-plant", "1/s**2", [-1, -2, -3]),
    case("RST-forum", "0.2/(z - 0.5)", ["0.1"]),
    case("Hagander-odd", "(s + 2)/(s*(s - 1))", [-1, -2, -3]),
]


@pytest.mark.parametrize(("plant", "poles"), PLACED)
def test_compensators(plant, poles):
    """The closed-loop polynomial, multiplied out by SymPy: D D_c + N N_c."""
    placement = ct.place_poles(plant, poles, feedback=-1)
    v = sp.Symbol("z" if "z" in plant else "s")
    N, D = sp.fraction(sp.cancel(sp.sympify(plant, rational=True, locals={"s": v, "z": v})))
    closed = sp.Poly(D * placement.denominator.as_expr() + N * placement.numerator.as_expr(), v)
    want = sp.prod([v - sp.Rational(str(pole)) for pole in poles])
    assert sp.expand(closed.as_expr() / closed.LC() - want) == 0


def test_an_observer_based_compensator_may_be_unstable():
    """An LSU slide shows one. By Youla: a pole between the zeros 1 and infinity, so each is."""
    plant = ct.realisation("(s - 1)/((s - 2)*(s + 1))", "s")
    G_c = ct.observer_based_compensator(plant, [-10, -10], [-10, -10]).transfer_function
    N_c, D_c = sp.fraction(sp.cancel(G_c.as_expr()))
    assert max(sp.re(root) for root in sp.Poly(D_c, s).nroots()) > 0
    closed = sp.Poly((s - 2) * (s + 1) * D_c - (s - 1) * N_c, s)  # u = G_c y
    assert sp.expand(closed.monic().as_expr() - (s + 10) ** 4) == 0


HIDDEN = [
    case(
        "cart-pole",
        [[0, 1, 0, 0], [0, 0, "-m*g", 0], [0, 0, 0, 1], [0, 0, "g*(m + M)/l", 0]],
        [[0], [1], [0], ["-1/l"]],
        "1",
    ),
    case(
        "Furuta-uncoupled",
        [[0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1], [0, 0, "-g/l", 0]],
        [[0], [1], [0], [0]],
        "s**2 + g/l",
    ),
    case("exam-modes", [[1, 0], [0, 1]], [[1], [1]], "s - 1"),
]


@pytest.mark.parametrize(("A", "B", "right"), HIDDEN)
def test_hidden_modes(A, B, right):
    """By hand: what the input does not reach."""
    polynomial = ct.uncontrollable_polynomial(A, B).as_expr()
    assert sp.simplify(polynomial - sp.sympify(right)) == 0


def test_an_entry_may_be_called_s():
    """diag(s, s) with b = (1, 1)': the mode s is not reached, whatever the variable is called."""
    A, b = [["s", 0], [0, "s"]], [[1], [1]]
    polynomial = ct.uncontrollable_polynomial(A, b)
    assert (
        sp.expand(polynomial.as_expr() - (polynomial.gen - sp.Symbol("s")))
        == 0
        != polynomial.gen - sp.Symbol("s")
    )
    with pytest.raises(ct.CompensatorError):
        ct.uncontrollable_polynomial(A, b, variable="s")


def test_a_pendulum_at_an_angle():
    """sin^2 + cos^2 = 1: diag(1, 1) with b = (1, 1)' has a mode that is not reached."""
    theta = sp.Symbol("theta")
    A = sp.Matrix([[1, 0], [0, sp.sin(theta) ** 2 + sp.cos(theta) ** 2]])
    with pytest.raises(ct.CompensatorError):
        ct.regulator_gain(A, [[1], [1]], [-1, -2])


def test_every_stabilising_compensator_of_a_lag():
    """Youla: b/(s - a) with symbols; the loop of the central one has the poles -1 and -2."""
    result = ct.stabilising_compensators("b/(s - a)", [-1], [-2], feedback=-1, variable="s")
    assert result.closed_loop_polynomial().as_expr() == s**2 + 3 * s + 2


def test_an_uncontrollable_pair_is_named():
    """Two equal integrators at one input."""
    with pytest.raises(NotControllableError):
        ct.regulator_gain([[0, 0], [0, 0]], [[1], [1]], [-1, -2])
