"""How often an exact question stays undecided: never for numbers, else because of a symbol."""

import itertools
from collections import Counter

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

import compensator_theory as exact
from compensator_theory.strategies import compensators, noncoprime_pairs, polynomials

TEXTS = ("0", "1", "2", "a", "b")
VALUES = [{"a": a, "b": b} for a in (-1, 0, 1, 2, 3) for b in (-1, 0, 1, 2, 3)]
KINDS = st.lists(st.sampled_from(["uncontrollable", "unobservable", "both"]), max_size=2)


@given(polynomials(min_degree=1, max_degree=6))
def test_stability_of_rational_polynomials_is_always_decided(p):
    for variable in ("s", "z"):
        decision = exact.decide_stability(p.replace(p.gen, sympy.Symbol(variable)))
        assert decision.is_stable is not None
        assert decision.by_coefficients is not None and decision.by_roots is not None


@given(noncoprime_pairs(), KINDS, st.data())
def test_structure_of_rational_systems_is_always_decided(pair, kinds, data):
    a, b, _ = pair
    G = exact.transfer_function((b, a))
    assert (G.is_coprime, G.is_proper, G.is_strictly_proper) == (False, True, True)
    assert exact.bezout.number_of_common_roots(a, b) is not None
    system = data.draw(compensators(2, tuple(kinds)))
    answers = (system.is_controllable, system.is_observable, system.is_minimal)
    assert None not in answers
    lost = {"uncontrollable": (0, 1), "unobservable": (1, 0), "both": (0, 0)}
    hidden = [lost[kind] for kind in kinds]
    assert answers[0] == all(c for c, _ in hidden) and answers[1] == all(o for _, o in hidden)


def test_a_symbolic_question_is_undecided_where_a_value_decides():
    """Of 25 pairs the 14 whose difference has a symbol."""
    undecided = set()
    for p, q in itertools.product(TEXTS, TEXTS):
        pair = (exact.polynomial(f"s - ({root})", "s") for root in (p, q))
        count = exact.bezout.number_of_common_roots(*pair)
        if count is None:
            undecided.add((p, q))
        else:
            assert count == int(p == q)
    assert undecided == {(p, q) for p in TEXTS for q in TEXTS if p != q and {p, q} & {"a", "b"}}
    assert len(undecided) == 14


@given(noncoprime_pairs(), st.sampled_from(["a", "a**2 + 1"]))
def test_a_common_factor_with_a_symbol_counts_for_all_values(pair, root):
    a, b, _ = pair
    numbers = exact.bezout.number_of_common_roots(a, b)
    factor = exact.polynomial(f"s - ({root})", "s")
    pair = (exact.polynomial(p.as_expr().subs(p.gen, "s") * factor.as_expr(), "s") for p in (a, b))
    assert exact.bezout.number_of_common_roots(*pair) == numbers + 1
    coprime = exact.bezout.number_of_common_roots(
        factor * factor, factor * exact.polynomial("s - 1")
    )
    assert coprime is None or (root != "a" and coprime == 1)  # a = 1 makes it 2


def test_a_common_factor_that_does_not_vanish_elsewhere():
    assert (
        exact.bezout.number_of_common_roots("(s + a)*(s + 2)", "(s + a)*(s + 3)", variable="s") == 1
    )
    assert (
        exact.bezout.number_of_common_roots("(s + a)**2*(s + 2)", "(s + a)**2", variable="s") == 2
    )
    assert exact.bezout.number_of_common_roots("a*(s + b)", "a*(s + b)", variable="s") is None


def truths(*conditions):
    """What all of the conditions, expressions that must not vanish, are at the values."""
    parts = [sympy.sympify(c) for c in conditions]
    return {all(part.subs(at) != 0 for part in parts) for at in VALUES}


def agrees(answer, truth):
    """A decided answer holds at every value, and None is about values that differ."""
    return truth == ({answer} if answer is not None else {True, False})


def test_coprimeness_is_undecided_where_values_decide():
    """Of 25 pairs of one root each the 14 whose difference has a symbol, at both doors."""
    counts = Counter()
    for p, q in itertools.product(TEXTS, TEXTS):
        one, other = (exact.polynomial(f"s - ({root})", "s") for root in (p, q))
        answers = {
            exact.bezout_identity(one, other).is_coprime,
            exact.transfer_function((one, other)).is_coprime,
        }
        assert len(answers) == 1 and agrees(*answers, truths(f"({p}) - ({q})"))
        counts[answers.pop()] += 1
    assert counts == {True: 6, False: 5, None: 14}


def test_properness_is_undecided_where_a_leading_coefficient_may_vanish():
    counts, leading = Counter(), (*TEXTS, "a - b", "a + 1", "2*b")
    for c, top in itertools.product(leading, (0, 1, 2, 3)):
        G = exact.transfer_function(f"(({c})*s**{top} + 3)/(s**2 + s + 5)", "s")
        for answer, most in ((G.is_proper, 2), (G.is_strictly_proper, 1)):
            # not proper where the coefficient is not zero
            truth = {True} if top <= most else {not x for x in truths(c)}
            assert agrees(answer, truth)
            counts[answer] += 1
    assert counts == {True: 43, False: 6, None: 15}
    direct = Counter(
        exact.Realisation([[1]], [[1]], [[1]], [[c]]).is_strictly_proper for c in TEXTS
    )
    assert direct == {True: 1, False: 2, None: 2}


@pytest.mark.costly
def test_structure_is_undecided_where_symbols_decide():
    """Of diag(p, q) with input (1, r) and output (1, 1): reached where r (p - q) is not zero."""
    counts = {name: Counter() for name in ("controllable", "observable", "minimal", "Kalman")}
    for p, q, r in itertools.product(TEXTS, TEXTS, ("0", "1", "b")):
        system = exact.Realisation([[p, 0], [0, q]], [[1], [r]], [[1, 1]])
        gap = f"({p}) - ({q})"
        reached, shown = truths(gap, r), truths(gap)
        assert system.is_controllable == exact.is_controllable(system.A, system.B)
        answers = system.is_controllable, system.is_observable, system.is_minimal
        for answer, truth in zip(answers, (reached, shown, reached), strict=True):
            assert agrees(answer, truth)
        kalman = exact.kalman_decomposition(system).is_minimal
        assert agrees(kalman, reached)
        for name, answer in zip(counts, (*answers, kalman), strict=True):
            counts[name][answer] += 1
    assert counts["controllable"] == counts["minimal"] == counts["Kalman"]
    assert counts["controllable"] == {True: 6, False: 35, None: 34}
    assert counts["observable"] == {True: 18, False: 15, None: 42}


@pytest.mark.costly
def test_several_inputs_are_undecided_where_no_minor_settles_it():
    """The oracle is the rank at 25 values, in floats: all entries are small integers there."""
    counts, more = Counter(), 0
    for p, x, y, v in itertools.product(("0", "1", "a"), *[("0", "1", "b", "1 - b")] * 3):
        A, B = sympy.Matrix([[p, 0], [0, 1]]), sympy.Matrix([[1, x], [y, v]])
        answer = exact.is_controllable(A, B)
        kalman = B.row_join(A * B)
        numbers = sympy.lambdify(sympy.symbols("a b"), kalman)
        ranks = {bool(np.linalg.matrix_rank(numbers(**at)) == 2) for at in VALUES}
        assert answer is None or ranks == {answer}
        counts[answer] += 1
        more += answer is None and len(ranks) == 1
    assert counts == {True: 52, False: 20, None: 120}
    assert more == 16  # of the 120 look the same at all 25 values
