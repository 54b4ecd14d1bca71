"""The strategies of hard corners: what they promise, and how often each kind is drawn."""

import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory import strategies as ours
from compensator_theory.bezout import number_of_common_roots
from compensator_theory.errors import NotCoprimeError
from compensator_theory.loops._closed_loop_matrix import closed_loop_matrix
from tests.support.shares import shares


@pytest.mark.costly
@pytest.mark.cases(2)
@pytest.mark.parametrize(
    ("strategy", "conditions", "least"),
    [
        (
            ours.noncoprime_pairs(),
            (
                lambda d: d[2].degree() == 1,
                lambda d: d[2].degree() == 2,
                lambda d: sympy.discriminant(d[2]) == 0 and d[2].degree() == 2,
            ),
            (0.6, 0.1, 0.07),
        ),
        (
            ours.nearly_cancelling_plants(),
            (
                lambda p: p.denominator.gcd(p.denominator.diff()).degree() == 0,
                lambda p: p.denominator.gcd(p.denominator.diff()).degree() == 1,
                lambda p: p.denominator.gcd(p.denominator.diff()).degree() == 2,
            ),
            (0.3, 0.1, 0.2),
        ),
        (
            ours.irrational_polynomials(2),
            (
                lambda p: all(r.is_real for r in ct.certified_roots(p)),
                lambda p: not any(r.is_real for r in ct.certified_roots(p)),
                lambda p: len({r.is_real for r in ct.certified_roots(p)}) == 2,
                lambda p: len(ct.certified_roots(p)) < 4,
            ),
            (0.2, 0.2, 0.1, 0.1),
        ),
        (
            ours.exactly_proper_plants(),
            tuple((lambda p, n=n: p.order == n) for n in range(1, 5)),
            (0.1, 0.1, 0.1, 0.1),
        ),
        (
            ours.derogatory_loops(3),
            tuple((lambda d, n=n: d[0].n == n) for n in range(1, 4)),
            (0.1, 0.1, 0.1),
        ),
    ],
    ids=["noncoprime", "nearly cancelling", "irrational", "exactly proper", "derogatory"],
)
def test_each_kind_is_drawn_as_often_as_stated(strategy, conditions, least):
    for result, bound in zip(shares(strategy, *conditions), least, strict=True):
        assert result >= bound


@settings(max_examples=20)
@given(ours.noncoprime_pairs(max_degree=2))
def test_common_roots_are_counted_and_placement_refuses(drawn):
    a, b, g = drawn
    assert number_of_common_roots(a, b) == g.degree()
    target = sympy.Poly(a.gen - 1000, a.gen) ** int(2 * a.degree() - 1)
    with pytest.raises(NotCoprimeError):
        ct.place_poles((b, a), polynomial=target, feedback=-1)


@settings(max_examples=20)
@given(ours.nearly_cancelling_plants(max_order=3))
def test_exact_placement_minds_no_near_cancellation(plant):
    target = sympy.Poly(plant.variable + 1, plant.variable) ** (2 * plant.order - 1)
    assert ct.place_poles(plant, polynomial=target, feedback=1).residual.is_zero


@settings(max_examples=15)
@given(ours.derogatory_loops(2))
def test_a_derogatory_loop_has_an_eigenvalue_of_geometric_multiplicity_two(loop):
    A = closed_loop_matrix(*loop)
    whole = sympy.Matrix(A)
    multiplicities = [
        len((whole - value * sympy.eye(A.rows)).nullspace())
        for value in whole.charpoly().ground_roots()
    ]
    assert max(multiplicities) >= 2


@settings(max_examples=15)
@given(st.integers(1, 3), st.integers(1, 3), st.integers(1, 2), st.data())
def test_mcmillan_degree_is_that_which_was_asked(n, inputs, outputs, data):
    plant = data.draw(ours.minimal_mimo_plants(n, inputs, outputs))
    assert (plant.B.cols, plant.C.rows) == (inputs, outputs)
    assert ct.mcmillan_degree(plant.transfer_matrix()) == n


def test_no_state_is_refused():
    @given(ours.minimal_mimo_plants(0))
    def draw(_):
        pass

    with pytest.raises(ct.InputError):
        draw()
