"""How often an exact question stays undecided: never for numbers, else because of a symbol."""

import itertools

from hypothesis import given
from hypothesis import strategies as st

import compensator_theory as exact
from compensator_theory.strategies import compensators, noncoprime_pairs, polynomials

KINDS = st.lists(st.sampled_from(["uncontrollable", "unobservable", "both"]), max_size=2)


@given(polynomials(min_degree=1, max_degree=6))
def test_stability_of_rational_polynomials_is_always_decided(p):
    for decide in (exact.decide_hurwitz, exact.decide_schur):
        found = decide(p)
        assert found.is_stable is not None
        assert found.by_coefficients is not None and found.by_roots is not None


@given(noncoprime_pairs(), KINDS, st.data())
def test_structure_of_rational_systems_is_always_decided(pair, kinds, data):
    a, b, _ = pair
    G = exact.transfer_function((b, a))
    assert (G.is_coprime, G.is_proper, G.is_strictly_proper) == (False, True, True)
    assert exact.number_of_common_roots(a, b) is not None
    system = exact.Realisation(*data.draw(compensators(2, tuple(kinds))))
    answers = (system.is_controllable, system.is_observable, system.is_minimal)
    assert None not in answers
    lost = {"uncontrollable": (0, 1), "unobservable": (1, 0), "both": (0, 0)}
    hidden = [lost[kind] for kind in kinds]
    assert answers[0] == all(c for c, _ in hidden) and answers[1] == all(o for _, o in hidden)


def test_a_symbolic_question_is_undecided_where_a_value_decides():
    """Of 25 pairs the 14 whose difference has a symbol."""
    texts = ("0", "1", "2", "a", "b")
    undecided = set()
    for p, q in itertools.product(texts, texts):
        pair = (exact.polynomial(f"s - ({root})", "s") for root in (p, q))
        count = exact.number_of_common_roots(*pair)
        if count is None:
            undecided.add((p, q))
        else:
            assert count == int(p == q)
    assert undecided == {(p, q) for p in texts for q in texts if p != q and {p, q} & {"a", "b"}}
    assert len(undecided) == 14


@given(noncoprime_pairs(), st.sampled_from(["a", "a**2 + 1"]))
def test_a_common_factor_with_a_symbol_counts_for_all_values(pair, root):
    a, b, _ = pair
    numbers = exact.number_of_common_roots(a, b)
    factor = exact.polynomial(f"s - ({root})", "s")
    pair = (exact.polynomial(p.as_expr().subs(p.gen, "s") * factor.as_expr(), "s") for p in (a, b))
    assert exact.number_of_common_roots(*pair) == numbers + 1
    coprime = exact.number_of_common_roots(factor * factor, factor * exact.polynomial("s - 1"))
    assert coprime is None or (root != "a" and coprime == 1)  # a = 1 makes it 2


def test_a_common_factor_that_does_not_vanish_elsewhere():
    assert exact.number_of_common_roots("(s + a)*(s + 2)", "(s + a)*(s + 3)", variable="s") == 1
    assert exact.number_of_common_roots("(s + a)**2*(s + 2)", "(s + a)**2", variable="s") == 2
    assert exact.number_of_common_roots("a*(s + b)", "a*(s + b)", variable="s") is None
