"""LQG: published costs, exact poles, optimality, forms, cross terms, bias, errors by name."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import compensator_theory
from compensator_theory import InputError
from compensator_theory.errors import (
    ImproperError,
    NoSolutionError,
    NotControllableError,
    NotObservableError,
    UnitCircleError,
)
from rcac_numeric import Plant, h2_cost, lqg_controller, servo_plant, standard_plant, with_bias
from rcac_numeric.analysis._lqg import cost_of_solutions, filter_gain
from rcac_numeric.analysis._noise import noise_inputs
from rcac_numeric.arrays._values import replaced
from tests.support.dissertation_plants import (
    PLANT_4_1,
    PLANT_4_2,
    PLANT_4_3,
    PLANT_4_4,
    PLANT_4_4_LITERAL,
    PLANT_6_1,
    PLANT_6_2,
    PLANT_A_1,
    PLANT_A_2,
    rescaled,
)
from tests.support.strategies import plants, seeds

# What a plant with R_2 and V_2 nonsingular needs: as many components of z as of u, of w as of y.
REGULAR = {"l_u": st.integers(1, 2), "l_y": st.integers(1, 2)} | {
    "l_z": st.integers(2, 3),
    "l_w": st.integers(2, 3),
}


def regular_plants():
    return plants(**REGULAR, feedthrough=True)


# The printed G of 4.2 and 4.3 lacks a gain; with norm(B) = norm(C) = 1, as the plants in state
# space have, it is alpha G with these alpha^2, and the text's costs come out.
@pytest.mark.parametrize(
    "plant, noise, cost, tolerance",
    [
        pytest.param(PLANT_4_1, None, 1.0585, 1e-4, id="4.1"),
        pytest.param(PLANT_4_2, None, 47.573, 1e-3, id="4.2 as printed"),
        pytest.param(rescaled(PLANT_4_2, 0.60864**0.5), None, 28.955, 1e-3, id="4.2 rescaled"),
        pytest.param(PLANT_4_3, {"d": 1}, 1.36, 1e-4, id="4.3 as printed"),
        pytest.param(rescaled(PLANT_4_3, 0.78869**0.5), {"d": 1}, 1.0726, 1e-4, id="4.3 rescaled"),
        pytest.param(PLANT_4_4, {"d": 1, "v": 1}, 2.5436, 1e-4, id="4.4, d and v independent"),
        pytest.param(PLANT_4_4_LITERAL, None, 0.686, 1e-3, id="4.4, d = v"),
        pytest.param(PLANT_6_1, None, 1.9620, 1e-4, id="6.1"),
        pytest.param(PLANT_6_2, None, 2.2769, 1e-4, id="6.2"),
        pytest.param(PLANT_A_1, None, 0.81367, 1e-5, id="A.1"),
        pytest.param(PLANT_A_2, None, 3.40068, 1e-5, id="A.2"),
    ],
)
def test_costs_of_the_text(plant, noise, cost, tolerance):
    design = lqg_controller(plant, noise=noise)
    assert design.cost.value == pytest.approx(cost, abs=tolerance)
    assert design.cost_from_riccati == pytest.approx(design.cost.value, rel=1e-10)
    assert design.agreement.coefficient_distance < 1e-12
    assert float(h2_cost(plant, design.compensator, noise=noise)) == pytest.approx(
        design.cost.value, rel=1e-9
    )


@pytest.mark.parametrize("plant", [PLANT_A_1, PLANT_A_2, PLANT_4_1], ids=["A.1", "A.2", "4.1"])
def test_spectra_are_the_exact_prediction(plant):
    """Against the spectral factors, which no Riccati solver had a part in; and the exact cost."""
    design, exact = lqg_controller(plant), compensator_theory.lqg_controller(plant.problem)
    assert design.agreement.coefficient_distance < 1e-13
    expected = [float(c) for c in exact.enclosure.centre.all_coeffs()]
    assert np.abs(np.poly(design.poles).real - expected).max() < 1e-13
    # and by the loop itself, from its coefficients (2.28)
    assert np.abs(np.poly(design.loop.poles()).real - expected).max() < 1e-12
    P, Q = (
        np.array([[float(c.centre) for c in row] for row in s.P_enclosure])
        for s in (exact.regulator, exact.estimator)
    )
    K = np.array([[float(c.centre) for c in row] for row in exact.regulator.K_enclosure])
    S = float(exact.regulator.factor.constant.centre)
    J = plant.D_1.T @ P @ plant.D_1 + S * K @ Q @ K.T
    assert design.cost.value == pytest.approx(J.item(), rel=1e-12)


@given(regular_plants(), st.sampled_from(["predictor", "filter"]))
def test_cost_spectrum_and_exact_poles_of_any_plant(plant, form):
    design = lqg_controller(plant, form=form)
    # what the conditions of the two equations allow, and no less than a few hundred roundings
    condition = max(design.regulator.condition, design.estimator.condition)
    accuracy = max(1e-10, 1e-14 * condition)
    # every term of the predictor form's cost is positive; the filter form's may cancel to nothing
    size = lqg_controller(plant).cost_from_riccati
    assert design.cost.value >= 0
    assert abs(design.cost.value - design.cost_from_riccati) < 100 * accuracy * size
    assert design.agreement.reason == ""
    assert design.agreement.coefficient_distance < accuracy
    from rcac_numeric.analysis._costs import loop_matrices
    from rcac_numeric.analysis._noise import noise_inputs

    loop = loop_matrices(plant, design.state_space, noise_inputs(plant))[0]
    gap = np.poly(loop) - np.poly(design.poles)  # (A.11)
    assert np.abs(gap).max() < 100 * accuracy * np.abs(np.poly(loop)).max()


@given(regular_plants(), seeds, st.sampled_from(["predictor", "filter"]), st.floats(1e-4, 0.3))
def test_no_other_gains_cost_less(plant, seed, form, size):
    """Strictly proper neighbours for the predictor form, exactly proper ones for the filter."""
    design = lqg_controller(plant, form=form)
    rng = np.random.default_rng(seed)
    for _ in range(3):
        moved = [m + size * rng.standard_normal(m.shape) for m in design.state_space]
        if form == "predictor":
            moved[3] = np.zeros_like(moved[3])
        assert float(h2_cost(plant, moved)) >= design.cost.value * (1 - 1e-9)


@given(regular_plants(), seeds)
def test_the_filter_form_costs_no_more_and_the_predictor_form_ignores_E_0(plant, seed):
    predictor, filtered = lqg_controller(plant), lqg_controller(plant, form="filter")
    assert filtered.cost.value <= predictor.cost.value * (1 + 1e-12)
    other = Plant(
        **{name: getattr(plant, name) for name in ("A", "B", "D_1", "C", "D_0", "D_2", "E_1")},
        E_2=plant.E_2,
        E_0=np.random.default_rng(seed).standard_normal(plant.E_0.shape),
    )
    for mine, its in zip(predictor.state_space, lqg_controller(other).state_space, strict=True):
        assert (mine == its).all()
    change = np.sum(other.E_0**2) - np.sum(plant.E_0**2)
    assert lqg_controller(other).cost.value == pytest.approx(
        predictor.cost.value + change, rel=1e-8
    )


@given(plants(l_u=st.just(1), l_y=st.just(1), l_z=st.just(1), l_w=st.just(1)))
def test_singular_weights_have_the_exact_poles(plant):
    """R_2 = 0 and V_2 = 0: the closed loop is that of high-authority LQG, to the coefficients."""
    plant = Plant(A=plant.A, B=plant.B, D_1=plant.D_1, C=plant.C, E_1=plant.E_1)
    try:
        design = lqg_controller(plant)
    except UnitCircleError:
        assume(False)
    accuracy = 1e-15 * max(design.regulator.condition, design.estimator.condition)
    assert design.agreement.coefficient_distance < max(1e-12, 1e3 * accuracy)
    assert design.cost.value == pytest.approx(design.cost_from_riccati, rel=max(1e-9, accuracy))


@given(regular_plants())
def test_roots_of_the_solutions_and_the_solutions_have_one_filter_gain_and_cost(plant):
    """D_f and J from P and Q themselves, of which the roots are Cholesky's."""
    inputs = noise_inputs(plant)
    design = lqg_controller(plant, form="filter")
    both = design.regulator, design.estimator
    accuracy = 1e3 * max(1e-13, *(1e-15 * one.condition for one in both))
    assume(accuracy < 1e-3)
    results = []
    for roots in (True, False):
        solutions = [replaced(one, P_root=cholesky(one.P) if roots else None) for one in both]
        D_f = filter_gain(plant, inputs, *solutions)
        results.append((D_f, cost_of_solutions(inputs, *solutions, D_f, plant.E_2)))
    (D_f, cost), (other, its_cost) = results
    assert np.abs(D_f - other).max() < accuracy * max(1, np.abs(D_f).max())
    size = lqg_controller(plant).cost_from_riccati
    assert abs(cost - its_cost) < accuracy * size
    assert abs(cost - design.cost_from_riccati) < accuracy * size


def cholesky(P):
    """S with S'S = P, of a P that may be singular."""
    values, vectors = np.linalg.eigh(P)
    return np.sqrt(np.maximum(values, 0))[:, None] * vectors.T


def test_by_hand():
    """x(k+1) = 2x + u + d, y = x + v: Q from a quadratic; with y(k) at hand, E[x^2] is Q."""
    plant = servo_plant("1/(q - 2)", performance="true")
    Q = (1.75 + np.sqrt(1.75**2 + 1)) / 2
    noise = {"d": 1.0, "v": 0.25}
    strict, proper = (
        lqg_controller(plant, noise=noise, form=form) for form in ("predictor", "filter")
    )
    assert strict.estimator.P[0, 0] == pytest.approx(Q)
    assert strict.cost.value == pytest.approx(1 + 4 * Q)  # P = 1, S = 1, K = -2
    assert proper.cost.value == pytest.approx(Q)  # 1 + 4 Q V_2 / (Q + V_2)
    assert not strict.compensator.past_y[0].any() and proper.compensator.past_y[0].any()
    assert strict.to_control().nstates == 1


def test_a_plant_with_many_signals_and_an_unstable_controller():
    """Example 6.1's, and one with two inputs and unstable modes on both sides of zero."""
    design = lqg_controller(PLANT_6_1)
    assert np.abs(np.linalg.eigvals(design.state_space[0]) - 1.0025).min() < 1e-4
    assert design.spectral_radius > 1 and design.loop.is_stable
    rng = np.random.default_rng(2)
    plant = Plant(
        A=np.diag([2.0, 0.5, -1.5]), B=rng.standard_normal((3, 2)),
        D_1=rng.standard_normal((3, 4)), C=rng.standard_normal((2, 3)),
        D_2=np.eye(2, 4), E_1=rng.standard_normal((3, 3)), E_2=rng.standard_normal((3, 2)),
    )  # fmt: skip
    for form in ("predictor", "filter"):
        design = lqg_controller(plant, form=form)
        assert design.loop.is_stable
        assert float(h2_cost(plant, design.compensator)) == pytest.approx(design.cost.value)


def test_4_2_with_a_bias_in_mind():
    """The bias of 4.2 is twice the deviation of w: mean square 4 per unit of white noise.

    The costs of the text are those of the design that knows of no bias. One that does pays for it
    in white noise, less as the bias is slower, and lets less of the bias through.
    """
    plant = rescaled(PLANT_4_2, 0.60864**0.5)
    plain = lqg_controller(plant)
    costs = []
    for pole in (0.99, 0.999, 0.9999, 0.99999):
        biased = with_bias(plant, "w", pole=pole, mean_square=4.0)
        design = lqg_controller(biased)
        costs.append(float(h2_cost(plant, design.state_space)))
        assert float(h2_cost(biased, plain.state_space)) > design.cost.value
        at_dc, plain_at_dc = (
            np.abs(d.loop.frequency_response(0.0)[0, 0, 0]) for d in (design, plain)
        )
        assert at_dc < plain_at_dc
    assert sorted(costs, reverse=True) == costs
    assert plain.cost.value < costs[-1] < 1.02 * plain.cost.value


def test_bias_is_an_ar_model():
    plant = with_bias(PLANT_4_4, "d", pole=0.9, mean_square=2.0)
    assert plant.blocks == {"r": 1, "d": 1, "v": 1, "d_bias": 1} and plant.n == 6
    from scipy.linalg import solve_discrete_lyapunov

    drive = plant.D_1[:, [3]]
    stationary = solve_discrete_lyapunov(plant.A, drive @ drive.T)
    assert stationary[5, 5] == pytest.approx(2.0)
    for wrong, words in (
        ({"pole": 1.0, "mean_square": 1.0}, "inside"),
        ({"pole": 0.9, "mean_square": -1.0}, "negative"),
    ):
        with pytest.raises(InputError, match=words):
            with_bias(PLANT_4_4, "d", **wrong)
    with pytest.raises(InputError, match="no channel 'x'"):
        with_bias(PLANT_4_4, "x", pole=0.9, mean_square=1.0)


@pytest.mark.parametrize(
    "plant, noise, error, words",
    [
        (standard_plant("(q - 1)/(q**2 - 0.3*q)"), None, UnitCircleError, "G_zu has .* at 1 "),
        (PLANT_4_4, {"v": 1.0}, None, ""),
        (PLANT_4_4, {}, NoSolutionError, "G_yw has rank 0"),
        (
            Plant(A=np.diag([1.5, 0.5]), B=[[0], [1]], D_1=[[1], [1]], C=[[1, 1]]),
            None,
            NotControllableError,
            "the mode 1.5",
        ),
        (
            Plant(A=np.diag([1.5, 0.5]), B=[[1], [1]], D_1=[[1], [1]], C=[[0, 1]], E_1=[[1, 2]]),
            None,
            NotObservableError,
            r"\(A, C\) is not detectable: .* the mode 1.5",
        ),
        (
            Plant(
                A=[[0.5]], B=[[1.0]], D_1=[[1.0]], C=[[1.0], [2.0]], D_2=[[0.0], [0.0]],
                E_1=[[1.0]],
            ),
            None,
            NoSolutionError,
            "G_yw has rank 1 .* y has 2",
        ),
        (
            Plant(A=[[0.5]], B=[[1.0, 1.0]], D_1=[[1.0]], C=[[1.0]]),
            None,
            NoSolutionError,
            "G_zu has rank 1 .* u has 2",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_designed_is_named(plant, noise, error, words):
    if error is None:
        assert lqg_controller(plant, noise=noise).loop.is_stable
        return
    with pytest.raises(error, match=words):
        lqg_controller(plant, noise=noise)


@pytest.mark.parametrize("name", ["E_1", "D_1", "D_2"])
def test_weights_beyond_float64_are_named(name):
    parts = {"A": [[0.5]], "B": [[1.0]], "D_1": [[1.0]], "C": [[1.0]], "E_1": [[1.0]]}
    with pytest.raises(InputError, match=r"beyond float64 .* 1e\+200"):
        lqg_controller(Plant(**parts | {name: [[1e200]]}))


def test_a_filter_form_that_no_controller_has():
    """D_0 such that I + D_f D_0 = 0."""
    plant = servo_plant("1/(q - 2)", performance="true")
    noise = {"d": 1.0, "v": 0.25}
    design = lqg_controller(plant, noise=noise, form="filter")
    D_f = design.state_space[3].item()
    through = Plant(
        A=plant.A, B=plant.B, D_1=plant.D_1, C=plant.C, D_0=[[-1 / D_f]], D_2=plant.D_2,
        E_1=plant.E_1, E_0=plant.E_0, blocks=plant.blocks,
    )  # fmt: skip
    with pytest.raises(ImproperError, match="predictor"):
        lqg_controller(through, noise=noise, form="filter")
    assert lqg_controller(through, noise=noise).cost.value == pytest.approx(
        lqg_controller(plant, noise=noise).cost.value
    )


def test_no_exact_poles_are_explained():
    """A plant whose numbers are beyond what the exact half reads says why."""
    plant = servo_plant("1/(q - 2)", performance="true")
    controller = lqg_controller(
        plant, noise={"d": 1.0, "v": 2.0}
    ).agreement  # sqrt(2), rounded once
    assert controller.coefficient_distance < 1e-14
    with pytest.raises(InputError, match="form = 'both'"):
        lqg_controller(plant, form="both")
    with pytest.raises(InputError, match="plant = 3"):
        lqg_controller(3)
