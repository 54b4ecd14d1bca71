"""Observer-based forms in float64, held against the exact ones and against the exact counts."""

import control
import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

import compensator_theory
from compensator_theory import (
    InputError,
    Realisation,
    observer_based_compensator,
    polynomial_from_roots,
    realisation,
)
from compensator_theory.errors import NoSolutionError
from compensator_theory.observers import realisation_is_observer_based
from compensator_theory.strategies import spectra, strictly_proper_plants
from rcac_numeric import observer_forms


def as_array(matrix):
    return np.array(matrix, float)


@given(strictly_proper_plants(max_order=3), st.data())
def test_float_forms_agree_with_the_exact_ones(plant, data):
    n = plant.order
    p, r = (polynomial_from_roots(data.draw(spectra(n)), "s") for _ in range(2))
    design = observer_based_compensator(plant, p, r)
    exact = compensator_theory.observer_forms(design.plant, design.compensator)
    assume(not exact.families)
    numeric = observer_forms(design.plant, design.compensator)
    assert len(numeric) == len(exact.forms)
    assert numeric.rejected == len(exact.rejections)
    for form in exact.forms:
        roots = np.array([np.poly(row).real for row in numeric.regulator_roots])
        expected = as_array(form.regulator.all_coeffs())
        index = int(np.argmin(np.abs(roots - expected).sum(axis=1)))
        assert np.allclose(roots[index], expected, rtol=1e-9, atol=1e-9)
        T = as_array(form.T)
        accuracy = 1e-9 * numeric.condition[index] * (1 + np.linalg.norm(T))
        assert np.allclose(numeric.T[index], T, rtol=1e-6, atol=accuracy)
        condition = np.linalg.cond(T)
        assert numeric.condition[index] == pytest.approx(condition, rel=1e-4) or condition > 1e8
    assert numeric.residual.max(initial=0) < 1e-9


@pytest.mark.parametrize("n_c", [1, 2, 3, 4])
def test_random_minimal_loops_have_as_many_forms_as_real_divisors(n_c):
    rng = np.random.default_rng(n_c)
    for n in (2, 3, 4):
        for _ in range(5):
            plant = [rng.integers(-9, 9, shape) / 4 for shape in ((n, n), (n, 1), (1, n))]
            other = [rng.integers(-9, 9, shape) / 4 for shape in ((n_c, n_c), (n_c, 1), (1, n_c))]
            system, controller = (Realisation(*matrices) for matrices in (plant, other))
            if not (system.is_minimal and controller.is_minimal):
                continue
            forms = observer_forms(system, controller)
            loop = np.block([[plant[0], plant[1] @ other[2]], [other[1] @ plant[2], other[0]]])
            assert forms.rejected == 0
            if n_c <= n:
                decision = realisation_is_observer_based(system, controller)
                assert decision.number_of_forms == len(forms)
            for i in range(len(forms)):
                A_R = plant[0] + plant[1] @ forms.K[i]
                left = np.vstack([np.eye(n), forms.T[i]])
                assert np.allclose(
                    loop @ left, left @ A_R, rtol=1e-6, atol=1e-6 * forms.condition[i]
                )
                both = np.concatenate([forms.regulator_roots[i], forms.observer_roots[i]])
                assert np.allclose(
                    np.poly(both).real, np.poly(np.linalg.eigvals(loop)).real, rtol=1e-6, atol=1e-6
                )
                if n_c == n:
                    built = A_R - forms.F[i] @ plant[2]
                    T = forms.T[i]
                    assert np.allclose(
                        other[0] @ T, T @ built, rtol=1e-6, atol=1e-8 * forms.condition[i] ** 2
                    )


@given(st.data())
def test_hidden_modes_are_rejected_as_the_exact_rule_says(data):
    plant = realisation(data.draw(strictly_proper_plants(max_order=3)))
    n = plant.n
    shown = data.draw(
        st.lists(st.sampled_from([(1, 1), (1, 0), (0, 1), (0, 0)]), min_size=n, max_size=n)
    )
    modes = data.draw(st.lists(st.integers(-9, 9), min_size=n, max_size=n, unique=True))
    compensator = realisation((
        sympy.diag(*modes), [[b] for b, _ in shown], [[c for _, c in shown]]
    ), "s")  # fmt: skip
    decision = realisation_is_observer_based(plant, compensator)
    try:
        forms = observer_forms(plant, compensator)
    except InputError as error:
        assert "Jordan blocks" in str(error)
        assert decision.number_of_forms == "a continuum" or decision.number_of_forms in (0, None)
        return
    assert decision.number_of_forms == len(forms)


def test_a_regulator_that_stands_still_has_its_form():
    """A + BK = 0: both sides of T^-1 A_c T = A + BK - FC are zero, and so is not what they sum."""
    matrices = [[-2]], [[1]], [[1]]
    (result,) = observer_forms(
        Realisation(*matrices, variable="s"), Realisation([[0]], [[0]], [[1]], variable="s")
    ).T
    assert np.allclose(result, 2)


def test_repeated_roots_keep_their_digits():
    for n in (2, 3, 4, 5):
        design = observer_based_compensator(f"1/(s**{n} + 1)", [-1] * n, [-1] * n)
        forms = observer_forms(design.plant, design.compensator)
        assert len(forms) == 1
        assert np.allclose(forms.K[0], as_array(design.K), rtol=1e-8)
        assert np.allclose(forms.F[0], as_array(design.F), rtol=1e-8)


def test_several_signals_and_python_control():
    A, K, F = (
        np.array([[0.0, 1], [2, -1]]),
        np.array([[-4.0, 0], [1, -3]]),
        np.array([[5.0, 1], [0, 7]]),
    )
    plant = control.ss(A, np.eye(2), np.eye(2), np.zeros((2, 2)))
    compensator = control.ss(A + K - F, F, K, np.zeros((2, 2)))
    forms = observer_forms(plant, compensator)
    closest = forms.closest_to(K, F)
    assert np.allclose(closest.K, K) and np.allclose(closest.F, F)
    assert forms.best_conditioned() == forms.forms[int(np.argmin(np.linalg.cond(forms.T)))]
    slowest = forms.observer_roots.real.max(axis=1)
    assert forms.fastest_observer().observer_roots.real.max() == slowest.min()
    assert len(forms.forms) == len(forms) and forms.forms[0].residual == forms.residual[0]
    assert "cond(T)" in str(forms)


def test_refusals():
    with pytest.raises(InputError, match="Jordan blocks"):
        observer_forms(
            Realisation([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]]),
            Realisation([[-6, 0], [0, -5]], [[1], [0]], [[12, 0]]),
        )
    with pytest.raises(InputError, match="rational"):
        observer_forms("1/(s + a)", "1/(s + 1)")
    with pytest.raises(InputError, match="limit"):
        observer_forms("1/s**2", "-(4*s + 2)/(s**2 + 4*s + 5)", limit=1)
    for singular in (0, 1, -1e-6):
        with pytest.raises(InputError, match="must lie between 0 and 1"):
            observer_forms("1/s**2", "-(4*s + 2)/(s**2 + 4*s + 5)", singular=singular)
    with pytest.raises(InputError, match="states"):
        observer_forms("1/s", Realisation(sympy.zeros(0, 0), sympy.zeros(0, 1), sympy.zeros(1, 0)))
    none = observer_forms(
        Realisation([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]]),
        Realisation([[-6, 0], [0, -7]], [[1], [0]], [[12, 0]]),
    )
    assert len(none) == 0 and none.rejected == 6 and "no observer-based form" in str(none)
    with pytest.raises(NoSolutionError):
        none.fastest_observer()
    three = observer_forms("1/s", "-2/(s + 3)")
    with pytest.raises(InputError, match="shapes"):
        three.closest_to([[1, 2]], [[1]])


@pytest.mark.parametrize("n, poles", [(6, 20), (7, 11), (7, 15)])
def test_forms_that_float64_does_not_resolve_are_named_and_the_rest_delivered(n, poles):
    """1/((s+1)...(s+n)) with its like: LinAlgError once, and residuals up to 0.8."""

    def plant(first):
        return "1/(" + "*".join(f"(s + {first + i})" for i in range(n)) + ")"

    forms = observer_forms(plant(1), plant(poles))
    unresolved = len(forms.unresolved_roots)
    assert len(forms) and unresolved and forms.unresolved_roots.shape[1] == n
    assert len(forms) + unresolved + forms.rejected in (924, 3432)  # n of 2n simple real roots
    assert forms.residual.max() <= 1e-6
    assert np.isfinite(forms.K).all() and np.isfinite(forms.F).all()
    assert f"{unresolved} unresolved in float64" in str(forms)
    system, other = realisation(plant(1)), realisation(plant(poles))
    A, B, C, A_c, B_c, C_c = map(
        as_array, (system.A, system.B, system.C, other.A, other.B, other.C)
    )
    for i in (0, len(forms) // 2, len(forms) - 1):
        T, K, F = forms.T[i], forms.K[i], forms.F[i]
        terms = [np.linalg.norm(part) for part in (B_c @ C, A_c @ T, T @ A, T @ B @ K)]
        assert np.linalg.norm(B_c @ C + A_c @ T - T @ (A + B @ K)) <= 1e-3 * max(terms)
        assert np.linalg.norm(T @ F - B_c) <= 1e-6 * np.linalg.norm(T) * np.linalg.norm(F)
        assert np.allclose(C_c @ T, K)
