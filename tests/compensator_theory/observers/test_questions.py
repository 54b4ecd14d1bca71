"""Theorem 1 in its true strength, for pairs and transfer functions, and what LQG makes of it."""

import itertools
from collections import Counter

import control
import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.errors import ImproperError, NotCoprimeError
from compensator_theory.loops._siso import closed_loop_of_pair
from compensator_theory.observers import (
    count_observer_forms,
    is_lqg_suboptimal,
    pair_is_observer_based,
    realisation_is_observer_based,
    transfer_function_is_observer_based,
)
from compensator_theory.observers._counting import count_partitions
from compensator_theory.roots._counts import has_real_root, number_of_real_roots
from compensator_theory.strategies import polynomials, spectra, strictly_proper_plants

s = sympy.Symbol("s")
SIGNS = st.sampled_from([1, -1])
SERVO = "1/(s**3 + s**2 + 2*s)"  # the plant of the counterexamples with n = 3


def real_choices(roots, size):
    """Every multiset of that size, closed under conjugation: brute force over subsets."""
    names = set()
    for chosen in itertools.combinations(roots, size):
        if Counter(chosen) == Counter(sympy.conjugate(root) for root in chosen):
            names.add(frozenset(Counter(chosen).items()))
    return names


@given(st.integers(1, 8).flatmap(spectra), st.integers(0, 5))
def test_divisors_are_counted_as_brute_force_counts_them(roots, n):
    Dtilde = ct.polynomial_from_roots(roots, "s")
    assert count_observer_forms(Dtilde, n) == len(real_choices(roots, n))
    assert number_of_real_roots(Dtilde) == sum(root.is_real for root in roots)
    assert has_real_root(Dtilde) is any(root.is_real for root in roots)


@given(st.lists(st.sampled_from([(-1,), (-2,), (1j, -1j), (-1 + 2j, -1 - 2j)]), max_size=5))
def test_repeated_roots_are_counted_as_brute_force_counts_them(groups):
    roots = [sympy.nsimplify(root) for group in groups for root in group]
    Dtilde = ct.polynomial_from_roots(roots, "s")
    for n in range(5):
        assert count_observer_forms(Dtilde, n) == len(real_choices(roots, n))


@given(st.integers(2, 6).flatmap(spectra), st.integers(0, 2), st.integers(0, 2))
def test_three_way_splits_are_counted_as_brute_force_counts_them(roots, i, j):
    third = len(roots) - i - j
    assume(third >= 0)
    splits = set()
    for first in real_choices(roots, i):
        rest = list((Counter(roots) - Counter(dict(first))).elements())
        splits |= {(first, second) for second in real_choices(rest, j)}
    assert count_partitions(ct.polynomial_from_roots(roots, "s"), (i, j, third)) == len(splits)


def test_multiplicity_counts():
    assert number_of_real_roots(ct.polynomial("(s + 1)**2*(s**2 + 1)**2")) == 2
    assert count_observer_forms("(s + 1)**6", 3) == 1
    assert count_observer_forms("s**16 - 1", 8) == sum(
        sympy.binomial(7, 4 - k // 2) * sympy.binomial(2, k) for k in (0, 2)
    )


@given(strictly_proper_plants(max_order=3), SIGNS, st.data())
def test_theorem_1_for_pairs(plant, feedback, data):
    """Yes exactly if some split of the roots gives gains whose compensator is the pair itself."""
    n = plant.order
    roots = data.draw(spectra(2 * n))
    pair = ct.place_poles(
        plant, ct.polynomial_from_roots(roots, "s"), feedback=feedback
    ).compensator
    decision = pair_is_observer_based(plant, pair, feedback=feedback)
    splits = real_choices(roots, n)
    assert decision.answer is bool(splits) and decision.number_of_forms == len(splits)
    assert decision.answer is (n % 2 == 0 or any(root.is_real for root in roots))
    signed = (feedback * pair.numerator, pair.denominator)
    for split in itertools.islice(splits, 3):
        inner = Counter(dict(split))
        design = ct.observer_based_compensator(
            plant, list(inner.elements()), list((Counter(roots) - inner).elements())
        )
        built = design.transfer_function
        assert (built.numerator, built.denominator) == signed
    sharp = transfer_function_is_observer_based(plant, pair, feedback=feedback)
    if pair.is_coprime:
        assert sharp.answer is decision.answer
    else:
        assert sharp.answer is True and sharp.number_of_forms == "a continuum"


@given(strictly_proper_plants(max_order=3), SIGNS, st.data())
def test_fewer_poles_than_the_plant_always_work(plant, feedback, data):
    """The common factor that the decision promises exists: a design has the transfer function."""
    n = plant.order
    r = data.draw(st.integers(0, n - 1))
    D_c = data.draw(polynomials("s", r, r, is_monic=True))
    N_c = data.draw(polynomials("s", 0, max(r - 1, 0))) if r else ct.polynomial(0, "s")
    G_c = ct.transfer_function((N_c, D_c))
    decision = transfer_function_is_observer_based(plant, G_c, feedback=feedback)
    assert decision.answer is True and decision.number_of_forms == "a continuum"
    factor = ct.polynomial_from_roots(range(1, n - G_c.reduced().order + 1), "s")
    pair = (G_c.reduced().numerator * factor, G_c.reduced().denominator * factor)
    assert pair_is_observer_based(plant, pair, feedback=feedback)


@given(strictly_proper_plants(max_order=3), polynomials("s", 1, 4, is_monic=True), st.data())
def test_lemma_1_and_proposition_2(plant, D_c, data):
    """Lemma 1: b q + a p = 0 with deg a <= deg b, deg p < deg q only for a = b = 0."""
    n_c = D_c.degree()
    other_D = data.draw(polynomials("s", n_c, n_c, is_monic=True))
    bound = min(n_c, plant.order - 1)
    N_c, other_N = (data.draw(polynomials("s", 0, bound)) for _ in range(2))
    difference = plant.denominator * (D_c - other_D) + plant.numerator * (N_c - other_N)
    assert difference.is_zero is ((N_c, D_c) == (other_N, other_D))


def test_proposition_2_needs_a_minimal_plant():
    plant = ct.transfer_function("(s + 1)/((s + 1)*(s + 2))")
    one = ct.transfer_function(("s + 7", "s**2 + 3*s + 5"))
    other = ct.transfer_function(("2*s + 9", "s**2 + 3*s + 4"))
    assert one != other
    assert closed_loop_of_pair(plant, one, -1) == closed_loop_of_pair(plant, other, -1)
    with pytest.raises(NotCoprimeError, match="s \\+ 1"):
        pair_is_observer_based(plant, one, feedback=-1)


@pytest.mark.parametrize(
    ("pair", "other", "loop"),
    [
        (("-s - 1", "s + 1"), ("-2*s - 3", "s + 2"), "s**2 + 2*s + 1"),  # Example 7.3
        (
            ("-3*s - 1", "s**2 + 2*s + 1"),
            ("-4*s - 3", "s**2 + 2*s + 2"),
            "s**3 + 4*s**2 + 2*s + 1",
        ),  # Example 7.4
    ],
)
def test_examples_7_3_and_7_4(pair, other, loop):
    plant = ct.transfer_function("1/(s + 2)")
    for compensator in (pair, other):
        G_c = ct.transfer_function(compensator)
        assert closed_loop_of_pair(plant, G_c, -1) == ct.polynomial(loop)
        assert not pair_is_observer_based(plant, G_c, feedback=-1)
    assert not transfer_function_is_observer_based(plant, pair, feedback=-1)


def test_example_7_6_is_not_observer_based():
    plant = ct.realisation(
        ([[0, 1, 0], [0, -2, 0.85], [0, -3, -1]], [[0], [0], [1]], [[1, 0, 0]]), variable="s"
    )
    roots = ["-0.5+0.1j", "-0.5-0.1j", "-1+0.5j", "-1-0.5j", "-2+1j", "-2-1j"]
    G_c = ct.place_poles(plant.transfer_function(), roots, feedback=-1).compensator
    for question in (pair_is_observer_based, transfer_function_is_observer_based):
        decision = question(plant, G_c, feedback=-1)
        assert decision.answer is False and decision.number_of_forms == 0
        assert "no real root" in decision.reason and not any(r.is_real for r in decision.roots)
    suboptimal = is_lqg_suboptimal(plant, G_c, feedback=-1)
    assert suboptimal.answer is True and "lowest terms" in suboptimal.reason


def test_counterexample_a_one_transfer_function_two_pairs():
    for factor, answer, forms in (("(s + 3)*(s + 4)", True, 4), ("(s**2 + 4*s + 5)", False, 0)):
        pair = (f"2*{factor}", f"(s + 1)*{factor}")
        decision = pair_is_observer_based(SERVO, pair, feedback=-1)
        assert (decision.answer, decision.number_of_forms) == (answer, forms)
        assert transfer_function_is_observer_based(SERVO, pair, feedback=-1)


def test_counterexample_d_repeated_real_roots():
    pair = ct.place_poles(SERVO, "(s + 1)**2*(s**2 + 1)**2", feedback=-1).compensator
    decision = pair_is_observer_based(SERVO, pair, feedback=-1)
    assert decision.answer is True and decision.number_of_forms == 1
    assert "2 real roots" in decision.reason


def test_not_observer_based_and_yet_optimal():
    """The pair is not observer-based, but its transfer function is LQG-optimal."""
    plant, g = "1/(s**3 + 3*s**2 + 8*s + 6)", "(s**2 + 4*s + 5)"
    pair = (f"4*{g}", f"(s + 1)*{g}")
    assert not pair_is_observer_based(plant, pair, feedback=-1)
    decision = is_lqg_suboptimal(plant, pair, feedback=-1)
    assert decision.answer is False and "cost ignores that" in decision.reason
    # The problem that the answer names, by python-control: its optimum is this transfer function.
    design = ct.observer_based_compensator(
        plant, "(s + 4)*(s**2 + 2*s + 5)", "(s + 3)*(s**2 + 2*s + 2)"
    )
    K, F = np.array(design.K, float), np.array(design.F, float)
    assert (K.tolist(), F.T.tolist()) == ([[-14, -5, -3]], [[2, -6, 2]])
    assert str(design.transfer_function.reduced()) == "(-4)/(s + 1)"
    A, B, C = (np.array(m, float) for m in (design.plant.A, design.plant.B, design.plant.C))
    regulator, P, _ = control.lqr(A, B, K.T @ K, np.eye(1), -K.T)
    estimator, Q, _ = control.lqr(A.T, C.T, F @ F.T, np.eye(1), F)
    assert np.allclose(-regulator, K, atol=1e-8) and np.allclose(estimator.T, F, atol=1e-8)
    assert np.allclose(P, 0, atol=1e-8) and np.allclose(Q, 0, atol=1e-8)


def test_other_answers_about_lqg():
    assert is_lqg_suboptimal("1/(s - 1)", "1/(s + 1)", feedback=+1).reason.endswith("unstable")
    assert is_lqg_suboptimal("1/s", "1", feedback=-1).answer is True  # not strictly proper
    assert is_lqg_suboptimal("1/(z - 1)", "1/2", feedback=-1).answer is None
    assert is_lqg_suboptimal("1/(s + a)", "1/(s + b)", feedback=-1).answer is None
    assert is_lqg_suboptimal("1/(z - 1/2)", "1/(16*z)", feedback=-1).answer is False
    assert is_lqg_suboptimal("1/(s + 1)", "1/(s**2 + 9*s + 9)", feedback=-1).answer is True
    assert is_lqg_suboptimal("1/(s + 1)", "-1/(s + 1)", feedback=-1).answer is None  # s (s + 2)


def test_symbols():
    assert pair_is_observer_based("1/(s**2 + a)", "1/(s**2 + b)", feedback=1).answer is True
    # The discriminants (a - b)^2 + 4 and (a - b)^2 - 4.
    assert pair_is_observer_based("1/(s + a)", "1/(s + b)", feedback=1).answer is True
    assert pair_is_observer_based("1/(s + a)", "1/(s + b)", feedback=-1).answer is None
    undecided = transfer_function_is_observer_based("1/(s + a)", "1/(s + b)", feedback=-1)
    assert undecided.answer is None and undecided.number_of_forms is None
    with pytest.raises(ct.InputError, match="undecided"):
        bool(undecided)
    # Real for every real b: a root at -b whatever it is.
    sure = pair_is_observer_based("1/s", ("-a*b", "s + a + b"), feedback=1)
    assert sure.answer is True and "Closed loop" in str(sure) and "D" in sure._repr_latex_()
    complex_for_all = pair_is_observer_based("1/s", ("-1 - a**2", "s"), feedback=1)
    assert complex_for_all.answer is False


def test_refusals():
    for feedback in (0, True, None):
        with pytest.raises(ct.InputError, match="feedback"):
            pair_is_observer_based("1/s", "1/s", feedback=feedback)
    with pytest.raises(ImproperError):
        pair_is_observer_based("1/s", "s**2/(s + 1)", feedback=1)
    with pytest.raises(ct.InputError, match="same variable"):
        transfer_function_is_observer_based("1/s", "1/z", feedback=1)
    with pytest.raises(ct.InputError, match="no state"):
        pair_is_observer_based(ct.transfer_function(("2", "1"), "s"), "1/s", feedback=1)
    for n in (-1, 1.0, True, "2"):
        with pytest.raises(ct.InputError):
            count_observer_forms("s + 1", n)
    for bad in ("s + a", 0, "1/s", None):
        with pytest.raises(ct.InputError):
            count_observer_forms(ct.polynomial(bad, "s") if bad == 0 else bad, 1)
    assert not pair_is_observer_based(SERVO, "1/(s + 1)", feedback=1)
    assert not pair_is_observer_based("1/s", "1/(s**2 + 1)", feedback=1)
    assert ct.observer_forms("1/s", "-1/(s + 2)").forms[0].K[0] == -1


def test_suboptimality_is_decided_exactly_near_the_boundary():
    question = lambda plant, G_c: is_lqg_suboptimal(plant, G_c, feedback=-1).answer  # noqa: E731
    assert question("1/(s - 1e-20)", "0/(s + 2)") is True
    assert question("1/(s + 1e-20)", "0/(s + 2)") is not None
    with pytest.raises(ImproperError, match="not well posed"):
        is_lqg_suboptimal("(s + 2)/(s + 1)", "1", feedback=1)


def test_more_states_than_the_plant_and_no_split_that_works():
    """All roots are rational, so that every real split is tested: the answer is no."""
    decision = realisation_is_observer_based(
        ([[2]], [[0]], [[0]]), ([[3, -1], [0, 0]], [[2], [0]], [[-1, -2]]), variable="s"
    )
    assert decision.answer is False
