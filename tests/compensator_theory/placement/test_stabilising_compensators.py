"""All stabilising compensators, against the closed-loop matrix and direct linear algebra."""

import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st
from sympy import Matrix

import compensator_theory as ct
import compensator_theory as exact
from compensator_theory.errors import ImproperError, NotControllableError
from compensator_theory.strategies import hurwitz_spectra, matrices, rationals
from tests.support.structure_cases import G_OF_THE_NOTES, fewer, nonzero_point

s, a, b = sympy.symbols("s a b")


@st.composite
def plants(draw, max_order=3):
    """Minimal realisations with one or two inputs and outputs, exactly proper ones too."""
    n, m, p = draw(st.integers(1, max_order)), draw(st.integers(1, 2)), draw(st.integers(1, 2))
    A, B, C = draw(matrices(n, n)), draw(matrices(n, m)), draw(matrices(p, n))
    D = draw(matrices(p, m)) if draw(st.booleans()) else None
    result = ct.Realisation(A, B, C, D)
    assume(result.is_minimal)
    return result


@st.composite
def families(draw):
    plant = draw(plants())
    spectra = [draw(hurwitz_spectra(plant.n)) for _ in range(2)]
    return ct.stabilising_compensators(plant, *spectra, feedback=draw(st.sampled_from([1, -1])))


def parameters(family):
    """Proper parameters, stable or not, of order 0 to 2."""
    p, m = family.plant.D.shape
    return st.integers(0, 2).flatmap(
        lambda n: st.builds(
            ct.Realisation, matrices(n, n), matrices(n, p), matrices(m, n), matrices(m, p)
        )
    )


def loop_matrix(plant, compensator, sign):
    """The states of a plant and a compensator in u = f C y, direct terms and all."""
    A, B, C, D = plant.A, plant.B, plant.C, plant.D
    C_c, D_c = sign * compensator.C, sign * compensator.D
    inner = (sympy.eye(D.rows) - D * D_c).inv()  # y = inner (C x + D C_c x_c)
    y_x, y_c = inner * C, inner * D * C_c
    u_x, u_c = D_c * y_x, C_c + D_c * y_c
    return Matrix(sympy.BlockMatrix([
        [A + B * u_x, B * u_c], [compensator.B * y_x, compensator.A + compensator.B * y_c]
    ]))  # fmt: skip


@pytest.mark.costly
@fewer(2)
@given(families(), st.data())
def test_the_poles_of_the_loop(family, data):
    Q = data.draw(parameters(family))
    assume((sympy.eye(family.plant.D.rows) + family.plant.D * Q.D).det() != 0)
    compensator = family.compensator(Q)
    closed = loop_matrix(family.plant, compensator, family.feedback)
    poly = ct.polynomial(closed.charpoly(s).as_expr(), "s")
    assert poly == family.closed_loop_polynomial(Q)
    assert compensator.n == family.plant.n + Q.n and compensator.feedback == family.feedback


@pytest.mark.costly
@fewer(3)
@given(families(), st.data())
def test_the_parameter_comes_back(family, data):
    Q = data.draw(parameters(family))
    assume((sympy.eye(family.plant.D.rows) + family.plant.D * Q.D).det() != 0)
    compensator = family.compensator(Q)
    back = family.parameter(compensator)
    G = Q.transfer_matrix()
    assert all(entry.is_zero for row in (back - G).numerators for entry in row)
    hidden = (compensator.uncontrollable_modes, compensator.unobservable_modes)
    if all(poly.degree() == 0 for poly in hidden):
        expected = ct.decide_stability(
            family.closed_loop_polynomial(Q), time="continuous"
        ).is_stable
        assert family.stabilises(compensator) == expected


@pytest.mark.costly
@fewer(3)
@given(families(), st.data())
def test_the_closed_loop_is_affine_in_the_parameter(family, data):
    """Against the loop solved at one point of the complex plane, real as it is."""
    Q = data.draw(parameters(family))
    assume((sympy.eye(family.plant.D.rows) + family.plant.D * Q.D).det() != 0)
    C = family.compensator(Q).transfer_matrix()
    G, H = family.plant.transfer_matrix(), family.closed_loop_map()(Q.transfer_matrix())
    point = nonzero_point(G.denominator, C.denominator, H.denominator)

    def at(matrix):
        return matrix.numerator_matrix().subs(s, point) / matrix.denominator.eval(point)

    g, c = at(G), family.feedback * at(C)
    p, m = family.plant.D.shape
    loop = sympy.eye(p) - g * c
    assume(loop.det() != 0)
    S, S_u = loop.inv(), (sympy.eye(m) - c * g).inv()
    expected = Matrix(sympy.BlockMatrix([[S, g * S_u], [c * S, S_u]]))
    assert Matrix(at(H)) == expected


@fewer(3)
@given(families())
def test_both_fractions_are_the_plant(family):
    f = family.fractions
    G = family.plant.transfer_matrix()
    for difference in (G @ f.M_r - f.N_r, f.M_l @ G - f.N_l):
        assert all(entry.is_zero for row in difference.numerators for entry in row)
    assert f.certificate.holds
    for name in ("M_r", "N_r", "U_r", "V_r", "M_l", "N_l", "U_l", "V_l"):
        part = getattr(f, name)
        assert ct.decide_stability(part.denominator, time="continuous").is_stable
        assert all(part[i, j].is_proper for i in range(part.shape[0]) for j in range(part.shape[1]))


@pytest.mark.costly
@fewer(2)
@given(rationals(), rationals())
def test_placed_compensators_are_members(pole, zero):
    """place_poles and the parametrisation, for the same plant."""
    assume(pole != -7)  # nothing cancels
    plant = exact.transfer_function(f"(s + 7)/((s - ({pole}))*(s + 8)*(s**2 + 1))")
    placed = exact.place_poles(plant, [-1, -2, -3, -4, -5, -6, abs(zero) * -1 - 1], feedback=-1)
    family = ct.stabilising_compensators(plant.reduced(), [-1] * plant.reduced().order,
                                      [-2] * plant.reduced().order, feedback=-1)  # fmt: skip
    assert family.stabilises(placed.compensator)
    unstable = exact.place_poles(plant, [-1, -2, -3, -4, -5, -6, 1], feedback=-1)
    assert not family.stabilises(unstable.compensator)


def test_the_example_of_the_notes():
    family = ct.stabilising_compensators("1/(s**2 - s - 2)", [-1, -1], [-1, -1], feedback=1)
    f = family.fractions
    assert (list(f.K), list(f.F)) == ([-3, -3], [3, 6])
    assert str(f.M_r.reduced()) == "[[s - 2]]/(s + 1)" and str(f.U_r.reduced()) == "[[-27]]/(s + 1)"
    q = sympy.Symbol("q_0")
    member = family.compensator([[q]]).transfer_function()
    assert sympy.expand(member.numerator.as_expr() - (s + 1) * (q * (s - 2) - 27)) == 0
    assert sympy.expand(member.denominator.as_expr() - (s**2 + 5 * s + 13 + q)) == 0
    integrator = family.compensator("-13").transfer_function()
    assert str(family).startswith("C = (U_r")  # with feedback=-1 it is -C
    negative = ct.stabilising_compensators("1/(s**2 - s - 2)", [-1, -1], [-1, -1], feedback=-1)
    assert str(negative) == f"-{family}"
    assert str(integrator) == "(-13*s**2 - 14*s - 1)/(s**2 + 5*s)"


def test_several_signals_and_no_states():
    family = ct.stabilising_compensators(G_OF_THE_NOTES, [-1, -2, -3], [-4, -5, -6], feedback=-1)
    assert family.compensator().n == 3 and family.stabilises([[0, 0], [0, 0]])
    static = ct.stabilising_compensators([[2]], [], [], variable="s", feedback=1)
    assert str(static.compensator("1/(s + 1)").transfer_matrix()) == "[[1]]/(s + 3)"


def test_symbols_say_where_they_hold():
    family = ct.stabilising_compensators("1/(s - a)", [-1], ["-2"], variable="s", feedback=-1)
    result = family.compensator().transfer_function()
    assert sympy.cancel(result.as_expr() - (a + 1) * (a + 2) / (s + a + 3)) == 0
    assert family.fractions.certificate.holds and family.exceptional == ()
    unobservable = ct.Realisation([[0, 1], [0, a]], [[0], [1]], [[1, b]])
    result = ct.doubly_coprime_fractions(unobservable, [-1, -1], [-2, -2])
    assert a * b + 1 in result.exceptional


FAMILY = ct.stabilising_compensators("(s + 2)/(s - 1)", [-1], [-1], feedback=1)


@pytest.mark.parametrize(
    ("call", "error"),
    [
        (lambda: ct.stabilising_compensators("1/(s - 1)", [1], [-1], feedback=1), ct.InputError),
        (lambda: ct.stabilising_compensators("1/(s - 1)", [-1], [0], feedback=1), ct.InputError),
        (
            lambda: ct.stabilising_compensators("1/(s - 1)", [-1, -2], [-1], feedback=1),
            ct.InputError,
        ),
        (lambda: ct.stabilising_compensators("1/(s - 1)", [-1], [-1], feedback=2), ct.InputError),
        (lambda: ct.stabilising_compensators("1/(x - 1)", [-1], [-1], feedback=1), ct.InputError),
        (lambda: ct.stabilising_compensators("s", [], [], feedback=1), ImproperError),
        (
            lambda: ct.doubly_coprime_fractions(([[1]], [[0]], [[1]]), [-1], [-1], variable="s"),
            NotControllableError,
        ),
        (lambda: FAMILY.compensator("-1"), ImproperError),
        (lambda: FAMILY.compensator("s"), ImproperError),
        (lambda: FAMILY.compensator([[1, 2]]), ct.InputError),
        (lambda: FAMILY.compensator("1/z"), ct.InputError),
        (lambda: FAMILY.parameter([[1, 2]]), ct.InputError),
        (lambda: FAMILY.parameter("(s - 1)/(s + 2)"), ct.InputError),
        (lambda: ct.transfer_matrix([[0]], "s").inverse(), ct.InputError),
        (lambda: ct.transfer_matrix([["1/s", 1]]).inverse(), ct.InputError),
    ],
)
def test_bad_input(call, error):
    with pytest.raises(error):
        call()


@given(matrices(2, 2), rationals())
def test_the_inverse_of_a_transfer_matrix(numbers, pole):
    numerators = numbers + Matrix([[s, 1], [0, s + 1]])
    G = ct.transfer_matrix([[(e, s - pole) for e in row] for row in numerators.tolist()], "s")
    product = G @ G.inverse()
    assert all(entry.is_zero for row in (product - sympy.eye(2)).numerators for entry in row)
