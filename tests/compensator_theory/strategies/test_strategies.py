"""The public strategies: what they promise, how often they filter, what they shrink to."""

from collections import Counter

import pytest
import sympy
from hypothesis import HealthCheck, Phase, find, given, settings
from hypothesis import strategies as st
from hypothesis.statistics import collector
from sympy import ImmutableMatrix

from compensator_theory import (
    InputError,
    certified_roots,
    count_roots,
    decide_stability,
    polynomial_from_roots,
)
from compensator_theory import strategies as ours
from compensator_theory.loops._siso import closed_loop_of_pair, is_well_posed
from compensator_theory.matrices._linear_algebra import rank
from compensator_theory.observers import realisation_is_observer_based
from tests.support.shares import shares

ALL = {
    "rationals": ours.rationals(),
    "nonzero_rationals": ours.nonzero_rationals(),
    "polynomials": ours.polynomials(),
    "coprime_pairs": ours.coprime_pairs(),
    "spectra": ours.spectra(4),
    "real spectra": ours.spectra(3, real_roots=True),
    "hurwitz_spectra": ours.hurwitz_spectra(4),
    "schur_spectra": ours.schur_spectra(4, real_roots=False),
    "strictly_proper_plants": ours.strictly_proper_plants(),
    "minimal_plants": ours.minimal_plants(3),
    "compensators": ours.compensators(3),
    "hidden modes": ours.compensators(4, ("uncontrollable", "unobservable", "both")),
    "matrices": ours.matrices(2, 2),
    "standard_problems": ours.standard_problems(2),
    "noncoprime_pairs": ours.noncoprime_pairs(),
    "exactly_proper_plants": ours.exactly_proper_plants(),
    "nearly_cancelling_plants": ours.nearly_cancelling_plants(),
    "irrational_polynomials": ours.irrational_polynomials(2),
    "minimal_mimo_plants": ours.minimal_mimo_plants(2),
    "derogatory_loops": ours.derogatory_loops(2),
    "symmetric_matrices": ours.symmetric_matrices(3),
    "semidefinite_matrices": ours.semidefinite_matrices(3),
    "definite matrices": ours.semidefinite_matrices(2, is_definite=True),
    "hurwitz_matrices": ours.hurwitz_matrices(3),
    "schur_matrices": ours.schur_matrices(3),
    "plants_with_gain": ours.plants_with_gain(),
    "plants_and_compensators": ours.plants_and_compensators(),
    "plants_with_common_factor": ours.plants_with_common_factor(),
    "boundary_loops": ours.boundary_loops("z"),
    "boundary_polynomials": ours.boundary_polynomials(),
    "loops_with_spectrum": ours.loops_with_spectrum(3),
}


@pytest.mark.costly
@pytest.mark.cases(8)
@pytest.mark.parametrize("name", ALL)
def test_almost_no_draw_is_filtered(name):
    """Hypothesis itself counts: "invalid" is a filtered draw, "overrun" one that it cut short."""

    @settings(max_examples=100, database=None, suppress_health_check=list(HealthCheck))
    @given(ALL[name])
    def run(_):
        pass

    observed = []
    with collector.with_value(observed.append):
        run()
    statuses = Counter(case["status"] for case in observed[0]["generate-phase"]["test-cases"])
    assert statuses["valid"] > 0
    assert statuses["invalid"] <= 0.03 * statuses["valid"]


def test_the_measure_of_filtering_sees_a_filter():
    @settings(max_examples=100, database=None, suppress_health_check=list(HealthCheck))
    @given(ours.rationals().filter(lambda x: x > 5))
    def run(_):
        pass

    observed = []
    with collector.with_value(observed.append):
        run()
    statuses = Counter(case["status"] for case in observed[0]["generate-phase"]["test-cases"])
    assert statuses["invalid"] > 0.03 * statuses["valid"]


def controllability(A, B):
    return rank(ImmutableMatrix.hstack(*(A**k * B for k in range(max(A.rows, 1)))))


@given(st.lists(st.sampled_from(["uncontrollable", "unobservable", "both"]), max_size=3),
       st.integers(0, 2), st.data())  # fmt: skip
def test_hidden_modes_are_hidden_as_asked(kinds, visible, data):
    order = visible + len(kinds)
    compensator = data.draw(ours.compensators(order, tuple(kinds)))
    A, B, C = compensator.A, compensator.B, compensator.C
    assert (A.shape, B.shape, C.shape) == ((order, order), (order, 1), (1, order))
    if order:
        lost = kinds.count("uncontrollable") + kinds.count("both")
        assert controllability(A, B) == order - lost
        assert controllability(A.T, C.T) == order - kinds.count("unobservable") - kinds.count(
            "both"
        )


@pytest.mark.parametrize(
    ("strategy", "time"),
    [(ours.hurwitz_spectra, "continuous"), (ours.schur_spectra, "discrete")],
)
@pytest.mark.parametrize("real_roots", [None, True, False])
def test_spectra_lie_where_they_should(strategy, time, real_roots):
    @given(strategy(4, real_roots))
    def check(roots):
        assert len(roots) == 4
        assert decide_stability(polynomial_from_roots(roots, "x"), time=time).is_stable
        has_real = any(root.is_real for root in roots)
        assert real_roots is None or has_real == real_roots

    check()


def occurs(strategy, condition):
    """Find without shrinking."""
    quick = settings(max_examples=300, database=None, phases=[Phase.generate], derandomize=True)
    return find(strategy, condition, settings=quick)


def shrunk(strategy, condition):
    few = settings(max_examples=30, database=None, derandomize=True)
    return find(strategy, condition, settings=few)


def test_every_kind_of_spectrum_occurs():
    for strategy in (ours.spectra, ours.hurwitz_spectra, ours.schur_spectra):
        occurs(strategy(4), lambda roots: all(root.is_real for root in roots))
        occurs(strategy(4), lambda roots: not any(root.is_real for root in roots))
        occurs(strategy(4), lambda roots: len(set(roots)) < 4)


@pytest.mark.slow
def test_they_shrink_to_the_simplest(in_full):
    s = sympy.Symbol("s")
    a, b = shrunk(ours.coprime_pairs(), lambda pair: pair[0].degree() >= 2)
    assert a.as_expr() == s**2 and b.as_expr() == 1
    assert shrunk(ours.spectra(2), lambda r: True) == (0, 0)
    plant = shrunk(ours.strictly_proper_plants(), lambda p: p.order == 2)
    assert str(plant) == "(1)/(s**2)"
    if in_full:
        plant = shrunk(ours.minimal_plants(2), lambda plant: plant.n == 2)
        assert sympy.Matrix([[0, 1], [0, 0]]) == plant.A


def test_bad_input():
    for arguments in ((3, False), (0, True)):
        for strategy in (ours.spectra, ours.hurwitz_spectra, ours.schur_spectra):
            with pytest.raises(InputError):
                occurs(strategy(*arguments), lambda roots: True)
    for order, hidden in ((1, ("both", "both")), (2, ("invisible",)), (-1, ())):
        with pytest.raises(InputError):
            occurs(ours.compensators(order, hidden), lambda c: True)


def _seen(plant, K):
    """The dimension that the output shows of the plant with the gain."""
    return controllability((plant.A + plant.B * K).T, plant.C.T)


@pytest.mark.costly
@pytest.mark.cases(3)
@pytest.mark.parametrize(
    ("strategy", "condition", "least", "most"),
    [
        (ours.strictly_proper_plants(), lambda G: G.numerator.degree() == 0, 0.15, 0.55),
        (ours.strictly_proper_plants(),
         lambda G: G.denominator.gcd(G.denominator.diff()).degree() > 0, 0.15, 0.6),
        (ours.plants_with_gain(),
         lambda c: _seen(*c) < c[0].n, 0.15, 0.6),
        (ours.plants_and_compensators(),
         lambda c: (c[0].numerator * c[1].numerator).gcd(
             c[0].denominator * c[1].denominator).degree() > 0, 0.25, 0.75),
        (ours.plants_with_common_factor(),
         lambda c: c[0].denominator.gcd(c[1].denominator).degree() > 0, 0.25, 0.85),
        (ours.boundary_loops(),
         lambda c: _hidden_on_the_axis(*c), 0.25, 0.75),
        (ours.boundary_loops("z"), lambda c: not is_well_posed(
            closed_loop_of_pair(*c, -1), *c), 0.12, 0.45),
        (ours.semidefinite_matrices(2), lambda M: rank(M) < 2, 0.25, 0.85),
        (ours.schur_matrices(2), lambda A: A[0, 0] * sympy.eye(2) == A, 0.01, 0.4),
    ],
    ids=["constant numerator", "multiple pole", "hidden by the gain", "cancellation", "common pole",
         "hidden on the boundary", "ill-posed", "singular", "scalar"],
)  # fmt: skip
def test_corners_occur_as_often_as_they_should(strategy, condition, least, most):
    (share,) = shares(strategy, condition)
    assert least <= share <= most


def _hidden_on_the_axis(G, G_c):
    N, D = G.numerator * G_c.numerator, G.denominator * G_c.denominator
    return count_roots(N.gcd(D), time="continuous").boundary > 0


@pytest.mark.costly
def test_kinds_of_matrices_are_what_they_say():
    @settings(max_examples=40)
    @given(ours.hurwitz_matrices(2), ours.schur_matrices(3), ours.symmetric_matrices(2),
           ours.semidefinite_matrices(2, is_definite=True))  # fmt: skip
    def check(hurwitz, schur, symmetric, definite):
        assert decide_stability(hurwitz.charpoly("s"), time="continuous").is_stable
        assert decide_stability(schur.charpoly("q"), time="discrete").is_stable
        assert symmetric == symmetric.T and definite == definite.T
        assert definite[0, 0] > 0 and definite.det() > 0

    check()


def test_elements_are_those_that_are_given():
    @given(ours.matrices(2, 2, elements=st.integers(-1, 1)))
    def check(matrix):
        assert set(matrix) <= {-1, 0, 1}

    check()


def test_observability_does_not_survive_feedback():
    """A false theorem is refuted within 60 examples."""
    case = ours.plants_with_gain()
    quick = settings(max_examples=60, database=None, phases=[Phase.generate], derandomize=True)
    find(case, lambda c: _seen(*c) < c[0].n, settings=quick)


@pytest.mark.costly
@pytest.mark.cases(6)
@pytest.mark.parametrize(
    ("options", "time"),
    [({"real_roots": False}, None), ({"feedback": -1}, None), ({"region": "stable"}, "continuous"),
     ({"region": "stable", "variable": "z"}, "discrete")],
)  # fmt: skip
def test_loops_have_the_spectrum_that_was_drawn(options, time):
    @given(ours.loops_with_spectrum(2, **options))
    def check(loop):
        plant, compensator = loop
        assert plant.is_minimal and compensator.is_minimal and plant.n == compensator.n == 2
        sign = options.get("feedback", 1)
        poles = plant.feedback_with(compensator, feedback=sign).characteristic_polynomial
        assert time is None or decide_stability(poles, time=time).is_stable
        if options.get("real_roots") is False:
            assert not any(root.is_real for root in certified_roots(poles))

    check()


@pytest.mark.costly
def test_observers_are_no_rule_in_order_three():
    """Refuted within 60 examples: without real poles no three are closed under conjugation."""
    quick = settings(max_examples=60, database=None, phases=[Phase.generate], derandomize=True)
    plant, compensator = find(
        ours.loops_with_spectrum(3),
        lambda loop: realisation_is_observer_based(*loop).answer is False,
        settings=quick,
    )
    assert plant.n == compensator.n == 3
