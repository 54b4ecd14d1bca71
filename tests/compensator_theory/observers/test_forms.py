"""Every observer-based form of a realisation: the theorem, its limits, the counterexamples."""

import itertools
from collections import Counter

import numpy as np
import pytest
import sympy
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from compensator_theory import (
    InputError,
    Realisation,
    TransferFunction,
    closed_loop_matrix,
    observer_based_compensator,
    observer_forms,
    place_poles,
    polynomial,
    polynomial_from_roots,
    realisation,
)
from compensator_theory.errors import NoSolutionError
from compensator_theory.observers import (
    count_observer_forms,
    realisation_is_observer_based,
    youla_forms,
)
from compensator_theory.observers._counting import count_partitions
from compensator_theory.roots._counts import number_of_real_roots
from compensator_theory.strategies import polynomials, rationals, spectra, strictly_proper_plants

s = sympy.Symbol("s")
EXAMPLE_7_1 = ([[-1, 4], [0, -3]], [[0], [1]], [[1, 0]])
SECOND_ORDER = Realisation([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]])
SERVO = "1/(s**3 + s**2 + 2*s)"


def characteristic(matrix):
    return sympy.Poly(sympy.Matrix(matrix).charpoly(s).as_expr(), s, domain="QQ")


def holds(form):
    """(7.13) and both spectra, by SymPy's own matrix products, inverse and determinant."""
    plant, compensator, T = form.plant, form.compensator, sympy.Matrix(form.T)
    A, B, C = (sympy.Matrix(m) for m in (plant.A, plant.B, plant.C))
    K = sympy.Matrix(compensator.C) * T
    F = T.inv() * sympy.Matrix(compensator.B)
    return (
        (sympy.Matrix(form.K), sympy.Matrix(form.F)) == (K, F)
        and T.inv() * sympy.Matrix(compensator.A) * T == A + B * K - F * C
        and characteristic(A + B * K) == form.regulator
        and characteristic(A - F * C) == form.observer
        and form.is_verified
    )


@st.composite
def minimal_loops(draw, excess, max_order=3):
    """A minimal SISO plant and a minimal compensator, in random bases, rational spectrum.

    The larger of the two is chosen to place the poles; the loop is symmetric in them.
    """
    smaller = draw(strictly_proper_plants(max_order=max_order))
    size = 2 * smaller.order + abs(excess)
    roots = draw(spectra(size))
    larger = place_poles(smaller, polynomial_from_roots(roots, "s"), feedback=+1).compensator
    assume(larger.is_coprime)
    plant, compensator = (larger, smaller) if excess < 0 else (smaller, larger)
    entries = st.integers(-2, 2)
    n_c = compensator.order
    lower, upper = sympy.eye(n_c), sympy.eye(n_c)
    for i, j in itertools.combinations(range(n_c), 2):
        lower[j, i], upper[i, j] = draw(entries), draw(entries)
    return realisation(plant), realisation(compensator).in_basis(lower * upper), roots


@pytest.mark.costly
@given(minimal_loops(excess=0))
def test_every_real_invariant_subspace_of_a_minimal_loop_gives_a_form(loop):
    plant, compensator, roots = loop
    forms = observer_forms(plant, compensator)
    assert not forms.rejections and not forms.families and not forms.undecided
    assert len(forms.forms) <= count_observer_forms(forms.characteristic_polynomial, plant.n)
    assert forms.is_complete and len(forms.forms) == forms.number_of_candidates
    assert all(holds(form) for form in forms.forms[:4])
    decision = realisation_is_observer_based(plant, compensator)
    assert decision.number_of_forms == len(forms.forms)
    assert decision.answer is (plant.n % 2 == 0 or any(root.is_real for root in roots))


@pytest.mark.costly
@given(minimal_loops(excess=-1, max_order=2))
def test_fewer_states_observe_a_function_of_the_state(loop):
    plant, compensator, _ = loop
    forms = observer_forms(plant, compensator)
    assert forms.is_complete and not forms.rejections
    for form in forms.forms:
        A, B, C = (sympy.Matrix(m) for m in (plant.A, plant.B, plant.C))
        A_c, B_c, C_c = (sympy.Matrix(m) for m in (compensator.A, compensator.B, compensator.C))
        T = sympy.Matrix(form.T)
        error = A_c - T * B * C_c  # x_c - Tx obeys this matrix, whatever x does:
        assert B_c * C + A_c * T - T * A - T * B * C_c * T == sympy.zeros(*T.shape)
        assert characteristic(error) == form.observer
        assert characteristic(A + B * C_c * T) == form.regulator
        assert T.rank() == compensator.n and form.F is None and form.is_verified
    decision = realisation_is_observer_based(plant, compensator)
    assert (decision.answer, decision.number_of_forms) == (bool(forms.forms), len(forms.forms))


@pytest.mark.costly
@settings(max_examples=20)
@given(minimal_loops(excess=1, max_order=2))
def test_more_states_add_a_youla_parameter(loop):
    plant, compensator, _ = loop
    n = plant.n
    result = youla_forms(plant, compensator)
    whole = characteristic(closed_loop_matrix(plant, compensator))
    assert len(result) == count_partitions(whole, (n, n, 1))
    for form in result:
        assert form.is_verified
        assert form.regulator * form.observer * form.parameter == whole
        Q, K, F = form.Q, form.K, form.F
        A, B, C = plant.A, plant.B, plant.C
        top = sympy.Matrix.hstack(A + B * K - F * C, B * Q.C)
        rebuilt = Realisation(
            top.col_join(sympy.Matrix.hstack(-Q.B * C, Q.A)), F.col_join(Q.B), K.row_join(Q.C)
        )
        assert rebuilt.transfer_function() == compensator.transfer_function()
    decision = realisation_is_observer_based(plant, compensator)
    assert (decision.answer, decision.number_of_forms) == (bool(result), len(result))
    two_way = observer_forms(plant, compensator)
    assert not two_way.rejections and two_way.is_complete
    assert all(form.is_verified for form in two_way.forms)


def test_a_regulator_and_yet_no_youla_form():
    compensator = realisation("-(2)/(s**2 + 3*s + 2)")
    plant = realisation("1/(s + 1)")
    loop = characteristic(closed_loop_matrix(plant, compensator))
    assert number_of_real_roots(loop) == 1
    assert observer_forms(plant, compensator).number_of_candidates == 1
    assert realisation_is_observer_based(plant, compensator).answer is False


@st.composite
def hidden_loops(draw):
    """A minimal SISO plant and a full-order compensator with hidden modes."""
    n = draw(st.integers(1, 3))
    D = polynomial_from_roots(draw(spectra(n)), "s")
    N = draw(polynomials("s", 0, n - 1))
    assume(D.gcd(N).degree() == 0)
    plant = TransferFunction(N, D)
    kinds = draw(st.lists(st.sampled_from(["shown", "unreached", "unseen", "joint"]),
                          min_size=n, max_size=n))  # fmt: skip
    modes = draw(st.lists(st.integers(-9, 9), min_size=n, max_size=n, unique=True))
    B_c = sympy.Matrix([int(kind in ("shown", "unseen")) for kind in kinds])
    C_c = sympy.Matrix([[draw(st.integers(1, 3)) * (kind in ("shown", "unreached"))
                         for kind in kinds]])  # fmt: skip
    return realisation(plant), Realisation(sympy.diag(*modes), B_c, C_c)


@given(hidden_loops())
def test_hidden_modes_are_counted_as_the_subspaces_are(loop):
    """Two independent routes: divisors with forced factors, and a rank test of each subspace."""
    plant, compensator = loop
    decision = realisation_is_observer_based(plant, compensator)
    forms = observer_forms(plant, compensator)
    if not (forms.families or forms.undecided):
        assert decision.number_of_forms is None or decision.number_of_forms >= len(forms.forms)
    if forms.is_complete and not (forms.families or forms.undecided):
        assert (decision.answer, decision.number_of_forms) == (bool(forms.forms), len(forms.forms))
    assert decision.answer is not False or not (forms.forms or forms.families)
    assert all(holds(form) for form in forms.forms[:2])
    assert all(form.is_verified for form in forms.families)


def test_example_7_1_all_six_from_the_transfer_function_alone():
    forms = observer_forms(
        EXAMPLE_7_1, realisation("-(33/4*s + 93/4)/(s**2 + 13*s + 49)", variable="s"), variable="s"
    )
    pairs = {
        (frozenset(sympy.roots(form.regulator)), frozenset(sympy.roots(form.observer)))
        for form in forms.forms
    }
    poles = {-2, -4, -5, -6}
    assert pairs == {
        (frozenset(pair), frozenset(poles - set(pair)))
        for pair in itertools.combinations(poles, 2)
    }  # fmt: skip
    gains = {(tuple(form.K), tuple(form.F)) for form in forms.forms}
    quarter = sympy.Rational(1, 4)
    assert ((-3, -5), (4, -3 * quarter)) in gains  # Example 7.1
    assert ((-5, -7), (2, -quarter)) in gains  # Example 7.2
    assert len(gains) == 6 and all(holds(form) for form in forms.forms)
    # An independent oracle: the gains that Ackermann's formula gives for each split.
    for pair in itertools.combinations(poles, 2):
        design = observer_based_compensator(
            EXAMPLE_7_1, list(pair), list(poles - set(pair)), variable="s"
        )
        assert (tuple(design.K), tuple(design.F)) in gains
    assert "1. regulator" in str(forms) and forms._repr_latex_().count("p_R") == 6


def test_counterexample_b1_even_order_and_no_form():
    plant = ([[3, 0], [0, 4]], [[1], [1]], [[1, 1]])
    disconnected = ([[1, 0], [0, 2]], [[0], [0]], [[0, 0]])
    forms = observer_forms(plant, disconnected, variable="s")
    assert (len(forms.forms), len(forms.rejections), forms.is_complete) == (0, 6, True)
    decision = realisation_is_observer_based(plant, disconnected, variable="s")
    assert decision.answer is False and "both uncontrollable and unobservable" in decision.reason


def test_counterexample_b2_a_hidden_mode_and_no_form():
    hidden = ([[-6, 0], [0, -7]], [[1], [0]], [[12, 0]])
    forms = observer_forms(SECOND_ORDER, hidden, variable="s")
    assert sorted(sympy.roots(forms.characteristic_polynomial)) == [-7, -5, -4, 0]
    assert (len(forms.forms), len(forms.rejections)) == (0, 6)
    assert realisation_is_observer_based(SECOND_ORDER, hidden, variable="s").answer is False


def test_counterexample_b2_with_a_double_root_has_a_family():
    hidden = ([[-6, 0], [0, -5]], [[1], [0]], [[12, 0]])
    forms = observer_forms(SECOND_ORDER, hidden, variable="s")
    assert forms.has_continuum and not forms.forms
    for family in forms.families:
        assert len(family.parameters) == 1 and family.is_verified
        members = [family.at([value]) for value in (1, sympy.Rational(-7, 3))]
        assert all(holds(member) for member in members)
        assert members[0].T != members[1].T
        assert members[0].K == members[1].K  # the regulator polynomial fixes K, not T
        with pytest.raises(InputError):
            family.at([])
        with pytest.raises(InputError, match="other values"):
            family.at([0])
    decision = realisation_is_observer_based(SECOND_ORDER, hidden, variable="s")
    assert decision.answer is True and decision.number_of_forms == "a continuum"
    with pytest.raises(NoSolutionError, match="at"):
        forms.best_conditioned()


@pytest.mark.parametrize("form", ["controllable", "observable"])
def test_counterexample_b3_real_roots_and_no_form(form):
    factor = "(s + 3)*(s + 4)"
    hidden = realisation(f"-2*{factor}/((s + 1)*{factor})", form=form)
    forms = observer_forms(SERVO, hidden)
    assert (len(forms.forms), len(forms.rejections)) == (0, 4)
    decision = realisation_is_observer_based(SERVO, hidden)
    assert decision.answer is False and "s**2 + 7*s + 12" in decision.reason


def test_counterexample_b3_mixed_has_exactly_two():
    mixed = ([[-1, 0, 0], [0, -3, 0], [0, 0, -4]], [[1], [1], [0]], [[-2, 0, 1]])
    forms = observer_forms(SERVO, mixed, variable="s")
    assert len(forms.forms) == 2 and all(holds(form) for form in forms.forms)
    for form in forms.forms:
        assert form.regulator.eval(-4) == 0 and form.observer.eval(-3) == 0
    decision = realisation_is_observer_based(SERVO, mixed, variable="s")
    assert (decision.answer, decision.number_of_forms) == (True, 2)


def test_counterexample_c_several_signals():
    half, one = sympy.Rational(1, 2), [[1, 0], [0, 1]]
    plant = Realisation([[-1, -half], [1, -half]], one, one)
    compensator = Realisation(
        [[0, -half], [1, -half]], [[0, -half], [-1, half]], [[0, half], [1, half]]
    )
    assert plant.is_minimal and compensator.is_minimal
    forms = observer_forms(plant, compensator)
    assert forms.characteristic_polynomial == polynomial("(s**2 + 1)*(s**2 + 2*s + 2)")
    assert (len(forms.forms), len(forms.rejections), forms.is_complete) == (0, 2, True)
    assert realisation_is_observer_based(plant, compensator).answer is False


def test_several_signals_generically_work():
    one = sympy.eye(2)
    A, K, F = (
        sympy.Matrix([[0, 1], [2, -1]]),
        sympy.Matrix([[-4, 0], [1, -3]]),
        sympy.Matrix([[5, 1], [0, 7]]),
    )
    plant = Realisation(A, one, one)
    compensator = Realisation(A + K - F, F, K).in_basis([[1, 2], [1, 3]])
    forms = observer_forms(plant, compensator)
    assert any((form.K, form.F) == (K, F) for form in forms.forms)
    assert all(holds(form) for form in forms.forms)


def test_grassmannian_of_forms_is_represented():
    """Plant and compensator 1 and 0 without coupling: every invertible T is a form."""
    one, zero = sympy.eye(2), sympy.zeros(2, 2)
    forms = observer_forms((one, one, one), (one, zero, zero), variable="s")
    assert forms.has_continuum and forms.families[0].is_verified
    assert (
        realisation_is_observer_based(
            (one, one, one), (one, zero, zero), variable="s"
        ).number_of_forms
        == "a continuum"
    )


def test_where_the_general_subspace_gives_no_form_none_of_an_irreducible_family_does():
    """C_c = 0, so that K = 0 and the regulator polynomial of a form is that of A, (s + 1)^2."""
    plant = ([[-1, 0], [0, -1]], [[0, 0], [0, -1]], [[1, 0]])
    forms = observer_forms(plant, ([[0]], [[1]], [[0], [0]]), variable="s")
    assert forms.continua == ((polynomial("s**2 + s"), 1, 1),) and forms.is_complete
    assert [poly for poly, _ in forms.rejections] == [polynomial("s**2 + s")]
    (form,) = forms.forms  # T A = B_c C
    assert list(form.T) == [-1, 0] and form.regulator == polynomial("(s + 1)**2")


def test_a_family_may_have_forms_where_another_of_the_same_polynomial_has_none():
    plant = ([[0, 0, 0], [0, 0, -1], [-1, 0, 0]], [[0, 1], [0, 0], [1, -1]], [[0, 0, 1]])
    forms = observer_forms(plant, ([[0, 0], [0, 0]], [[0], [0]], [[0, 1], [0, 0]]), variable="s")
    assert [family.regulator for family in forms.families] == [polynomial("s**3")]
    assert forms.families[0].is_verified and not (forms.rejections or forms.undecided)


def test_samples_that_fail_are_no_proof():
    """T B C_c T = 0 for no invertible T, which the samples of a reducible variety cannot show."""
    plant = (sympy.zeros(2), [[1], [1]], [[1, 0]])
    forms = observer_forms(plant, (sympy.zeros(2), [[0], [0]], [[0, 1]]), variable="s")
    assert forms.undecided == (polynomial("s**2"),)
    assert not (forms.forms or forms.families or forms.rejections)


@pytest.mark.costly
@settings(max_examples=20)
@given(rationals(), rationals())
def test_repeated_spectrum_has_one_form(shift, root):
    plant = observer_based_compensator("1/(s**3 + s)", [root] * 3, [root] * 3)
    assume(plant.compensator.is_minimal)
    forms = observer_forms(
        plant.plant, plant.compensator.in_basis([[1, shift, 0], [0, 1, 2], [0, 0, 1]])
    )
    assert len(forms.forms) == 1 and holds(forms.forms[0])
    assert (forms.forms[0].K, forms.forms[0].F) == (plant.K, plant.F)


def test_irrational_factors_are_counted_and_left_to_float64():
    forms = observer_forms("1/s**2", realisation("-(4*s + 1)/(s**2 + 1)"))
    assert not forms.forms and forms.is_complete is False
    assert "irrational" in str(forms)
    assert realisation_is_observer_based("1/s**2", realisation("-(4*s + 1)/(s**2 + 1)")).answer


def test_choice_by_criterion():
    result = observer_forms(
        EXAMPLE_7_1, realisation("-(33/4*s + 93/4)/(s**2 + 13*s + 49)", variable="s"), variable="s"
    )
    assert set(sympy.roots(result.fastest_observer().observer)) == {-5, -6}
    assert tuple(result.closest_to([[-3, -5]], [[4], [-0.7]]).K) == (-3, -5)
    conditions = [np.linalg.cond(np.array(f.T, float), "fro") ** 2 for f in result.forms]
    best = result.forms[int(np.argmin(conditions))]
    assert result.best_conditioned() == best
    assert float(best.squared_condition) == pytest.approx(min(conditions))
    with pytest.raises(InputError, match="shapes"):
        result.closest_to([[1]], [[1]])
    discrete = observer_based_compensator("1/z**2", ["1/2", "1/3"], ["-9/10", "1/5"])
    forms = observer_forms(discrete.plant, discrete.compensator)
    slowest = Counter(sympy.roots(forms.fastest_observer().observer))
    assert slowest == Counter([sympy.Rational(1, 3), sympy.Rational(1, 5)])


def test_plants_with_a_direct_term():
    design = observer_based_compensator("(2*s**2 + 1)/(s**2 + 3*s)", [-1, -2], [-3, -4])
    forms = observer_forms(design.plant, design.compensator)
    assert len(forms.forms) == 6 and all(form.is_verified for form in forms.forms)
    assert any((form.K, form.F) == (design.K, design.F) for form in forms.forms)


@pytest.mark.costly
def test_symbolic_plants():
    design = observer_based_compensator("1/(s**2 + a*s)", ["-p", "-2"], [-1, -3])
    forms = observer_forms(design.plant, design.compensator)
    assert len(forms.forms) == 6 and all(form.is_verified for form in forms.forms)
    assert forms.is_complete is None
    assert realisation_is_observer_based(design.plant, design.compensator).answer is True


def test_refusals():
    with pytest.raises(InputError, match="direct term"):
        observer_forms("1/s", "(s + 2)/(s + 1)")
    assert realisation_is_observer_based("1/s", "(s + 2)/(s + 1)").answer is False
    with pytest.raises(InputError, match="limit = 3"):
        observer_forms(
            EXAMPLE_7_1, realisation("-(33/4*s + 93/4)/(s**2 + 13*s + 49)"), limit=3, variable="s"
        )
    six = realisation("-(33/4*s + 93/4)/(s**2 + 13*s + 49)")
    assert len(observer_forms(EXAMPLE_7_1, six, limit=6, variable="s").forms) == 6
    with pytest.raises(InputError, match="states"):
        observer_forms("1/s", Realisation(sympy.zeros(0, 0), sympy.zeros(0, 1), sympy.zeros(1, 0)))
    with pytest.raises(InputError, match="observer_forms"):
        youla_forms("1/s", "1/(s + 1)")
    with pytest.raises(InputError, match="continuum"):
        youla_forms("1/(s + 5)", Realisation([[-5, 0], [0, -5]], [[0], [0]], [[0, 0]]))
    with pytest.raises(NoSolutionError, match="rejections"):
        observer_forms(
            SECOND_ORDER, Realisation([[-6, 0], [0, -7]], [[1], [0]], [[12, 0]])
        ).fastest_observer()
