"""Transfer matrices: how they are read, and that sums and products are those of their values."""

import control
import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import Matrix
from sympy.physics.control import MIMOSeries, StateSpace, TransferFunctionMatrix
from sympy.physics.control import TransferFunction as Sympys

import compensator_theory as ct
from compensator_theory.forms import smith_mcmillan_form
from compensator_theory.strategies import rationals
from tests.support.structure_cases import nonzero_point, transfer_matrices

s, a = sympy.symbols("s a")


def at(G, point):
    """The value by SymPy."""
    return Matrix(G.numerator_matrix().subs(s, point)) / G.denominator.eval(point)


@given(transfer_matrices(), transfer_matrices(), rationals())
def test_values_add_and_multiply(G, H, number):
    point = nonzero_point(G.denominator, H.denominator)
    g, h = at(G, point), at(H, point)
    if G.shape == H.shape:
        assert at(G + H, point) == g + h and at(G - H, point) == g - h
        assert (G + H).denominator.degree() in (
            {G.denominator.degree()}
            if G.denominator == H.denominator
            else {G.denominator.degree() + H.denominator.degree()}
        )
    else:
        with pytest.raises(ct.InputError, match="no sum"):
            G + H
    if G.shape[1] == H.shape[0]:
        assert at(G @ H, point) == at(G * H, point) == g * h
    else:
        with pytest.raises(ct.InputError, match="no product"):
            G @ H
    assert at(-G, point) == -g and at(+G, point) == g and at(G.T, point) == g.T
    assert at(number * G, point) == at(G * number, point) == number * g
    scalar = ct.transfer_function("(s + 1)/(s + 50)")
    assert at(scalar * G, point) == at(G * scalar, point) == scalar(point) * g


@given(transfer_matrices(max_size=3), st.data())
def test_constant_matrices_of_every_kind(G, data):
    p, m = G.shape
    K = Matrix(m, 2, data.draw(st.lists(st.integers(-3, 3), min_size=2 * m, max_size=2 * m)))
    point = nonzero_point(G.denominator)
    expected = at(G, point) * K
    for constant in (K, K.as_immutable(), K.tolist(), np.array(K.tolist(), dtype=int)):
        assert at(G @ constant, point) == expected
    left = sympy.ones(2, p)
    for constant in (left, left.tolist(), np.ones((2, p))):
        assert at(constant @ G, point) == left * at(G, point)
    assert (left * G) == (left @ G)
    zero = G - G
    assert at(zero, point).is_zero_matrix and zero.denominator == G.denominator


@given(transfer_matrices(max_size=3))
def test_every_description_is_read_alike(G):
    rows = [[G[i, j] for j in range(G.shape[1])] for i in range(G.shape[0])]
    point = nonzero_point(G.denominator)
    texts = [[str(entry) for entry in row] for row in rows]
    pairs = [[(entry.numerator, entry.denominator) for entry in row] for row in rows]
    sympys = TransferFunctionMatrix([[entry.to_sympy() for entry in row] for row in rows])
    for read in (rows, texts, pairs, G.as_matrix(), sympys):
        assert at(ct.transfer_matrix(read, "s"), point) == at(G, point)
    assert ct.transfer_matrix(rows) == G == ct.transfer_matrix(G)


@given(transfer_matrices(max_size=2))
def test_poles_and_zeros_are_those_of_the_smith_mcmillan_form(G):
    form = smith_mcmillan_form(G)
    assert G.poles() == form.poles and G.zeros() == form.zeros
    of_pencil = ct.minimal_realisation(G).realisation if is_proper(G) else None
    if of_pencil is not None:  # another way to the poles, by the order of a realisation
        assert sum(root.multiplicity for root in G.poles()) == of_pencil.n


def is_proper(G):
    return all(G[i, j].is_proper for i in range(G.shape[0]) for j in range(G.shape[1]))


def test_poles_and_zeros_of_known_matrices():
    def of(rows):
        G = ct.transfer_matrix(rows, "s")
        return [[(int(r.value.real), r.multiplicity) for r in f()] for f in (G.poles, G.zeros)]

    assert of([["1/s", 0], [0, "1/s"]]) == [[(0, 2)], []]  # two, and not the one of 1/s
    assert of([["1/s", "1/s"], ["1/s", "1/s"]]) == [[(0, 1)], []]
    assert of([["1/(s + 1)", 0], [0, "(s + 1)/(s + 2)"]]) == [[(-2, 1), (-1, 1)], [(-1, 1)]]
    assert of([["(s - 1)/(s + 2)", "4/(s + 2)"], ["9/(2*(s + 2))", "2*(s - 1)/(s + 2)"]]) == [
        [(-2, 1)],
        [(4, 1)],
    ]  # Skogestad and Postlethwaite, example 4.11
    assert of([["1/(s + 1)", "1/(s + 2)", "1/(s + 3)"]])[1] == []  # a row has no common zero
    (pole,) = ct.transfer_matrix([["1/(s + a)"]], "s").poles()
    assert pole.value == -sympy.Symbol("a")


def test_systems_of_python_control():
    system = control.tf([[[1], [2]], [[3], [4]]], [[[1, 1], [1, 2]], [[1, 1], [1, 3]]])
    texts = [["1/(s + 1)", "2/(s + 2)"], ["3/(s + 1)", "4/(s + 3)"]]
    assert ct.transfer_matrix(system) == ct.transfer_matrix(texts)
    space = control.ss([[1, 2], [3, 4]], np.eye(2), np.eye(2), np.zeros((2, 2)), True)
    expected = ct.Realisation(
        [[1, 2], [3, 4]], np.eye(2), np.eye(2), variable="z"
    ).transfer_matrix()
    assert ct.transfer_matrix(space) == expected
    assert ct.transfer_matrix(control.tf([1], [1, 2])) == ct.transfer_matrix("1/(s + 2)")
    several = Sympys(1, s, s)
    assert ct.transfer_matrix(several) == ct.transfer_matrix([["1/s"]])


def test_common_factors_of_an_entry_stay():
    G = ct.transfer_matrix([["(s + 1)/((s + 1)*(s + 2))", "1/(s + 2)"]])
    assert str(G) == "[[s + 1, s + 1]]/(s**2 + 3*s + 2)"
    assert ct.transfer_matrix([["1/(s + a)", 1]]).denominator.as_expr() == s + a


@pytest.mark.parametrize(
    "rows",
    [[], [[]], [["1/s"], [1, 2]], 5, ["1/s"], "x y", [[None]], None, {}, [[float("nan")]],
     [["1/s", "1/z"]], [[1, 2]], [["1/0"]], [["sin(s)"]], {"poles"}, b"1/s", [[[1, 2, 3]]],
     [["s" * 30_000]], [[sympy.Symbol("a", positive=True) / s, "a"]], [["1/s", "1/(s"]]],
)  # fmt: skip
def test_bad_rows(rows):
    with pytest.raises(ct.InputError):
        ct.transfer_matrix(rows)


def test_bad_operands():
    G = ct.transfer_matrix([["1/s", 1]])
    with pytest.raises(ct.InputError, match="one variable"):
        G + ct.transfer_matrix([["1/z", 1]])
    with pytest.raises(ct.InputError, match="variable s"):
        G @ [["s"], [1]]
    with pytest.raises(ct.InputError, match="in s, not in z"):
        ct.transfer_matrix(G, "z")
    with pytest.raises(TypeError):
        G + G[0, 0]
    with pytest.raises(TypeError):
        G * object()
    with pytest.raises(ct.InputError):
        G * float("nan")


def test_what_sympy_joined_last_does_not_answer_for_another():
    """SymPy 1.14 keeps in its class whether a connection holds a StateSpace."""
    entry = Sympys(1, s + 1, s)
    rows = TransferFunctionMatrix([[entry, entry], [entry, entry]])
    joined = MIMOSeries(rows, rows)
    gain = StateSpace(*[sympy.eye(2)] * 4)
    MIMOSeries(gain, gain)
    assert ct.transfer_matrix(joined) == ct.transfer_matrix([[2 / (s + 1) ** 2] * 2] * 2)
