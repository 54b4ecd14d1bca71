"""Irrational splits proved in balls: float64 subspaces, a known counterexample, rates of None."""

import itertools
from collections import Counter

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from compensator_theory import Realisation, observer_forms
from compensator_theory.loops._closed_loop_matrix import closed_loop_matrix
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.observers import _ball_proofs as ball_proofs
from compensator_theory.observers import realisation_is_observer_based
from compensator_theory.observers._ball_proofs import prove_forms
from compensator_theory.strategies import (
    compensators,
    derogatory_loops,
    matrices,
    minimal_mimo_plants,
    minimal_plants,
)


@st.composite
def mimo_loops(draw, orders=(1, 2, 3)):
    plant = draw(st.integers(2, 3).flatmap(minimal_mimo_plants))
    n_c = draw(st.sampled_from(orders))
    compensator = draw(matrices(n_c, n_c)), draw(matrices(n_c, 2)), draw(matrices(2, n_c))
    return plant, Realisation(*compensator)


def real_splits(values, n):
    """Index sets of n eigenvalues, closed under conjugation; the spectrum is simple."""
    for chosen in itertools.combinations(range(len(values)), n):
        picked = [values[i] for i in chosen]
        if all(min(abs(v.conjugate() - w) for w in picked) < 1e-9 for v in picked):
            yield list(chosen)


@settings(max_examples=25)
@given(mimo_loops(orders=(2, 3)))
def test_as_many_forms_as_well_conditioned_subspaces_in_floats(loop):
    plant, compensator = loop
    n, A = plant.n, closed_loop_matrix(plant, compensator)
    if compensator.n > n:
        return
    values, vectors = np.linalg.eig(np.array(A.tolist(), dtype=float))
    gaps = [abs(a - b) for a, b in itertools.combinations(values, 2)]
    if min(gaps) < 1e-3:
        return
    good = 0
    for chosen in real_splits(values, n):
        V = vectors[:, chosen]
        if np.linalg.cond(V[:n]) > 1e8:
            continue
        T = V[n:] @ np.linalg.inv(V[:n])
        good += np.linalg.svd(T, compute_uv=False)[-1] > 1e-8
    proof = prove_forms(A, characteristic_polynomial(A, plant.variable), n)
    assert proof.is_exhaustive and proof.proved >= good
    if proof.tried == good:
        assert proof.proved == proof.tried


@settings(max_examples=20)
@given(minimal_plants(2), compensators(2))
def test_where_all_forms_are_rational_both_ways_count_the_same(plant, compensator):
    if plant.n != 2:
        return
    forms = observer_forms(plant, compensator)
    if forms.is_complete and not forms.has_continuum and not forms.undecided:
        loop = closed_loop_matrix(plant, compensator)
        proof = prove_forms(loop, forms.characteristic_polynomial, 2)
        assert proof.proved == len(forms.forms)


def test_a_repeated_irrational_pair_is_split_by_its_chain(monkeypatch):
    """(s^2 - 2)^2, one Jordan block for each root: one line from each, or a whole block.

    What eight bits leave open is tried with more, and what is proved is not tried again.
    """
    A = sympy.Matrix([[0, 1, 0, 0], [2, 0, 1, 0], [0, 0, 0, 1], [0, 0, 2, 0]])
    T = sympy.Matrix([[1, 0, 0, 0], [1, 1, 0, 0], [0, 2, 1, 0], [3, 0, 1, 1]])
    loop = sympy.ImmutableMatrix(T * A * T.inv())
    s = sympy.Symbol("s")
    Dtilde = characteristic_polynomial(loop, s)
    assert prove_forms(loop, Dtilde, 2).tried == 3
    for precisions, proved in (((8,), 0), ((8, 128), 3), ((128, 8), 3)):
        monkeypatch.setattr(ball_proofs, "PRECISIONS", precisions)
        assert prove_forms(loop, Dtilde, 2).proved == proved


@pytest.mark.parametrize(("n", "n_c", "splits"), [(1, 1, 2), (1, 2, 6), (1, 3, 12), (2, 3, 30)])
def test_real_roots_are_split_in_three_where_the_compensator_is_larger(n, n_c, splits):
    """Regulator, Youla parameter, observer: (n + n_c)!/(n! (n_c - n)! n!) ways."""
    size = n + n_c
    turn = sympy.eye(size) + sympy.Matrix(size, size, lambda i, j: int(i == j + 1))
    loop = sympy.ImmutableMatrix(turn * sympy.diag(*range(1, size + 1)) * turn.inv())
    proof = prove_forms(loop, characteristic_polynomial(loop, sympy.Symbol("s")), n)
    assert proof.tried == splits and proof.is_exhaustive


def test_the_minimal_loop_of_even_order_without_a_form_stays_no():
    """notes of the theory, (c): its only two real planes give T infinite and T singular."""
    one = sympy.eye(2)
    plant = Realisation([[-1, "-1/2"], [1, "-1/2"]], one, one)
    compensator = Realisation(
        [[0, "-1/2"], [1, "-1/2"]], [[0, "-1/2"], [-1, "1/2"]], [[0, "1/2"], [1, "1/2"]]
    )
    assert realisation_is_observer_based(plant, compensator).answer is False
    A = closed_loop_matrix(plant, compensator)
    assert prove_forms(A, characteristic_polynomial(A, plant.variable), 2).proved == 0


def test_a_zero_that_is_no_accident_is_never_proved():
    """u does not reach the irrational modes of the plant, which the compensator cannot see."""
    plant = Realisation([[0, 2], [1, 0]], [[0], [0]], [[0, 0]])
    compensator = Realisation([[0, 3], [1, 0]], [[0], [0]], [[0, 0]])
    answer = realisation_is_observer_based(plant, compensator)
    assert answer.answer is not True


def shares(strategy, count):
    observed = Counter()

    @settings(max_examples=count, database=None, derandomize=True)
    @given(strategy)
    def run(loop):
        observed[realisation_is_observer_based(*loop).answer] += 1

    run()
    return observed


@st.composite
def nonminimal_plants(draw):
    kinds = draw(st.sampled_from([("uncontrollable",), ("unobservable",)]))
    return draw(compensators(2, kinds)), draw(compensators(2))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("strategy", "count", "most"),
    [
        (mimo_loops(), 80, 0.02),
        (nonminimal_plants(), 60, 0.02),
        (derogatory_loops(3), 60, 0.02),
    ],
    ids=["several signals", "hidden plant modes", "derogatory"],
)
def test_how_often_it_is_undecided(strategy, count, most):
    """Without balls nine of ten loops with irrational factors were undecided."""
    observed = shares(strategy, count)
    assert observed[True] > 0 and observed[None] <= most * observed.total()
