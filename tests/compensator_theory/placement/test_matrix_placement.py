"""Poles of plants with several signals, against the states of plant and compensator joined."""

import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.errors import ImproperError, NoSolutionError
from compensator_theory.strategies import rationals, spectra, strictly_proper_plants
from tests.support.structure_cases import G_OF_THE_NOTES, fewer, transfer_matrices

s, a = sympy.symbols("s a")


def loop_polynomial(G, G_c, sign):
    """The poles of a loop: det(I - f G G_c) times the poles of both, by SymPy."""
    g = G.numerator_matrix() / G.denominator.as_expr()
    c = G_c.numerator_matrix() / G_c.denominator.as_expr()
    M = sympy.eye(g.rows) - sign * g * c
    difference = M[0, 0] if g.rows == 1 else M[0, 0] * M[1, 1] - M[0, 1] * M[1, 0]
    poles = ct.coprime_fractions(G).pole_polynomial * ct.coprime_fractions(G_c).pole_polynomial
    return sympy.cancel(difference * poles.as_expr())


@pytest.mark.costly
@fewer(3)
@given(transfer_matrices(), st.sampled_from([1, -1]), st.data())
def test_the_poles_are_the_roots_of_the_targets(G, sign, data):
    G = (G * "1/(s + 5)").reduced()
    degrees = place_degrees(G)
    order = max(2, *degrees)
    targets = [ct.polynomial_from_roots(data.draw(spectra(d + order)), "s") for d in degrees]
    try:
        placement = ct.place_matrix_poles(G, targets, order, feedback=sign)
    except NoSolutionError:
        assert order < ct.coprime_fractions(G).order  # never from the number of states on
        return
    product = sympy.prod([t.as_expr() for t in targets])
    G_c = placement.compensator
    if ct.coprime_fractions(G_c).order == order * G.shape[0]:  # nothing cancels in N_c D_c^-1
        assert sympy.expand(loop_polynomial(G, G_c, sign) - product) == 0
    if placement.homogeneous:
        values = [data.draw(rationals()) for _ in placement.homogeneous]
        other = placement.member(values)
        if ct.coprime_fractions(other).order == order * G.shape[0]:
            assert sympy.expand(loop_polynomial(G, other, sign) - product) == 0


def place_degrees(G):
    """The observability indices, by ranks of Hankel matrices row by row."""
    plant = ct.minimal_realisation(G).realisation
    p, n, result = plant.C.rows, plant.n, []
    ranks = [0]
    for k in range(1, n + 2):
        rows = sympy.Matrix.vstack(*(plant.C * plant.A**i for i in range(k)))
        ranks.append(rows.rank() if n else 0)
    steps = [ranks[k + 1] - ranks[k] for k in range(len(ranks) - 1)]
    for i in range(p):
        result.append(sum(step > i for step in steps))
    return sorted(result)


@fewer(2)
@given(strictly_proper_plants(max_order=3), st.data())
def test_one_signal_is_what_place_poles_finds(plant, data):
    order = plant.order + data.draw(st.integers(-1, 1))
    target = ct.polynomial_from_roots(data.draw(spectra(plant.order + order)), "s")
    ours = ct.place_matrix_poles([[plant]], [target], order, feedback=-1)
    theirs = ct.place_poles(plant, target, feedback=-1, numerator_degree=order)
    assert len(ours.homogeneous) == len(theirs.homogeneous)
    for N_c, D_c in ((ours.N_c, ours.D_c), *((ours.N_c + d, ours.D_c + e) for d, e in
                                              ours.homogeneous)):  # fmt: skip
        closed = plant.denominator * D_c[0, 0] + plant.numerator * N_c[0, 0]
        assert (closed - target).is_zero


@fewer(2)
@given(strictly_proper_plants(max_order=2), st.sampled_from(["s", "s**2 + 1", "s*(s - 1)"]))
def test_an_internal_model_divides_the_denominator(plant, model):
    alpha = ct.polynomial(model)
    assume(alpha.gcd(plant.numerator).degree() == 0)
    order = plant.order - 1 + alpha.degree()
    target = ct.polynomial_from_roots([-k - 1 for k in range(plant.order + order)], "s")
    placement = ct.place_matrix_poles([[plant]], [target], order, feedback=-1, internal_model=model)
    assert placement.D_c[0, 0].rem(alpha).is_zero and placement.D_c[0, 0].degree() == order
    closed = plant.denominator * placement.D_c[0, 0] + plant.numerator * placement.N_c[0, 0]
    assert (closed - target).is_zero


def test_the_example_of_the_notes():
    placement = ct.place_matrix_poles(
        G_OF_THE_NOTES, ["(s + 3)**2", "(s + 4)**3"], 1, variable="s", feedback=-1
    )
    assert len(placement.homogeneous) == 2  # a line of answers for each column
    family = ct.stabilising_compensators(G_OF_THE_NOTES, [-1, -2, -3], [-4, -5, -6], feedback=-1)
    assert family.stabilises(placement.compensator)
    assert family.stabilises(placement.member(["1/2", -3]))


def test_integrators_for_several_signals():
    G = [["1/(s - 1)", 0], ["1/(s + 2)", "1/(s + 1)"]]
    expected = [[-1, -2, -3], [-1, -2, -3, -4]]
    placement = ct.place_matrix_poles(G, expected, 2, feedback=-1, internal_model="s")
    assert all(entry.eval(0) == 0 for row in placement.D_c.rows for entry in row)
    product = sympy.prod([(s + 1) ** 2, (s + 2) ** 2, (s + 3) ** 2, s + 4])
    closed = loop_polynomial(ct.transfer_matrix(G), placement.compensator, -1)
    assert sympy.expand(closed - product) == 0
    with pytest.raises(NoSolutionError, match="raise the order"):
        ct.place_matrix_poles(G, [w[:-1] for w in expected], 1, feedback=-1, internal_model="s")
    with pytest.raises(NoSolutionError):  # the plant has a zero where the model has its root
        ct.place_matrix_poles([["s/(s - 1)**2"]], [[-1] * 4], 2, feedback=-1, internal_model="s")


def test_symbols_say_where_they_hold():
    placement = ct.place_matrix_poles(
        [["1/(s - a)"]], [[-1, -2]], 1, variable="s", feedback=-1, internal_model="s"
    )
    assert str(placement.compensator) == "[[(a + 3)*s + 2]]/(s)" and placement.exceptional == ()


@pytest.mark.parametrize(
    ("call", "error"),
    [
        (lambda: ct.place_matrix_poles([["1/s"]], [[-1]], 0, feedback=0), ct.InputError),
        (lambda: ct.place_matrix_poles([["s/(s + 1)"]], [[-1]], 0, feedback=1), ImproperError),
        (lambda: ct.place_matrix_poles([["1/s"]], [[-1, -2]], 0, feedback=1), ct.InputError),
        (lambda: ct.place_matrix_poles([["1/s"]], [[-1], [-2]], 0, feedback=1), ct.InputError),
        (lambda: ct.place_matrix_poles([["1/s"]], "s + 1", 0, feedback=1), ct.InputError),
        (lambda: ct.place_matrix_poles([["1/s"]], [[-1]], -1, feedback=1), ct.InputError),
        (
            lambda: ct.place_matrix_poles([["1/s"]], [[-1]], 0, feedback=1, internal_model="s"),
            ct.InputError,
        ),
        (
            lambda: ct.place_matrix_poles([["1/s"]], [[-1]], 0, feedback=1).member([1]),
            ct.InputError,
        ),
    ],
)
def test_bad_input(call, error):
    with pytest.raises(error):
        call()
