"""The H2 cost against a simulation, python-control and itself."""

import control
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.signal import correlate

from compensator_theory import InputError
from compensator_theory.errors import IllConditionedError
from rcac_numeric import ClosedLoop, Compensator, Plant, h2_cost, lqg_controller, standard_plant
from rcac_numeric.analysis._conversion import compensator_from_state_space
from rcac_numeric.analysis._costs import enclosed_cost
from rcac_numeric.analysis._noise import noise_inputs
from rcac_numeric.analysis._state_space import state_space_of
from tests.support.dissertation_plants import PLANT_4_1, PLANT_4_4
from tests.support.strategies import plants, seeds


def random_compensator(rng, plant, n_c, proper):
    """A small compensator, which leaves a stable plant stable more often than not."""
    A_c = rng.uniform(-0.4, 0.4, (n_c, n_c))
    B_c, C_c = rng.uniform(-0.3, 0.3, (n_c, plant.l_y)), rng.uniform(-0.3, 0.3, (plant.l_u, n_c))
    D_c = rng.uniform(-0.1, 0.1, (plant.l_u, plant.l_y)) * proper
    return A_c, B_c, C_c, D_c


@given(plants(feedthrough=True), seeds, st.integers(1, 3), st.booleans())
def test_it_is_python_controls_norm(plant, seed, n_c, proper):
    """Including the cross term, which (4.21) leaves out, and any direct term."""
    compensator = random_compensator(np.random.default_rng(seed), plant, n_c, proper)
    cost = h2_cost(plant, compensator)
    assume(cost.spectral_radius < 0.99)
    # z = G_zw w from the plant with inputs [w; u] and outputs [z; y], closed by control.lft
    whole = control.ss(
        plant.A,
        np.hstack([plant.D_1, plant.B]),
        np.vstack([plant.E_1, plant.C]),
        np.block([[plant.E_0, plant.E_2], [plant.D_2, plant.D_0]]),
        True,
    )
    closed = whole.lft(control.ss(*compensator, True))
    norm = control.norm(closed, 2)
    assert cost.value == pytest.approx(norm**2, rel=1e-8)
    assert cost.discrepancy < 1e-8
    assert sum(cost.shares.values()) == pytest.approx(cost.value, rel=1e-8)
    assert sum(cost.terms.values()) == pytest.approx(cost.value, rel=1e-12)


@given(plants(feedthrough=True), seeds)
def test_each_share_is_the_cost_of_that_noise_alone(plant, seed):
    rng = np.random.default_rng(seed)
    compensator = random_compensator(rng, plant, 2, True)
    intensities = dict(zip(plant.channels, rng.uniform(0.0, 2.0, plant.l_w), strict=True))
    cost = h2_cost(plant, compensator, noise=intensities)
    assume(np.isfinite(cost.value))
    for name, intensity in intensities.items():
        alone = h2_cost(plant, compensator, noise={name: intensity})
        assert cost.shares[name] == pytest.approx(alone.value, rel=1e-9, abs=1e-12)
        assert alone.value == pytest.approx(
            intensity * h2_cost(plant, compensator, noise={name: 1.0}).value, rel=1e-9, abs=1e-12
        )


@given(plants(), seeds)
def test_a_compensator_and_its_state_space_cost_the_same(plant, seed):
    rng = np.random.default_rng(seed)
    P = rng.uniform(-0.3, 0.3, (2, plant.l_u, plant.l_u))
    Q = rng.uniform(-0.2, 0.2, (3, plant.l_u, plant.l_y))
    compensator = Compensator(P, Q)
    cost = h2_cost(plant, compensator)
    assume(np.isfinite(cost.value))
    for other in (compensator.state_space(), compensator.to_control()):
        assert float(h2_cost(plant, other)) == pytest.approx(cost.value, rel=1e-9)
    # and the same as by the observability Gramian of the loop that injects u_tilde
    A, B, C, D = ClosedLoop(plant, compensator).matrices
    from scipy.linalg import solve_discrete_lyapunov

    B, C, D = B[:, : plant.l_w], C[: plant.l_z], D[: plant.l_z, : plant.l_w]
    gramian = solve_discrete_lyapunov(A.T, C.T @ C)
    assert cost.value == pytest.approx(np.trace(B.T @ gramian @ B) + np.sum(D**2), rel=1e-8)


@pytest.mark.parametrize(
    "plant, noise",
    [(PLANT_4_1, {"w": 1.0}), (PLANT_4_4, {"d": 1.0, "v": 1.0}), (PLANT_4_1, {"w": 0.01})],
)
@pytest.mark.parametrize("form", ["predictor", "filter"])
def test_a_long_simulation_agrees_within_its_sampling_error(plant, noise, form):
    design = lqg_controller(plant, noise=noise, form=form)
    steps, settle = 60_000, 2_000
    rng = np.random.default_rng(7)
    inputs = noise_inputs(plant, noise)
    w = rng.standard_normal((steps, inputs.factor.shape[1])) @ inputs.factor.T
    z = design.loop.simulate(w, np.zeros((steps, 1)))[settle:, 0]
    # The variance of a mean of z^2, z Gaussian: (2/N) sum of R(tau)^2 over all tau.
    R = correlate(z, z, method="fft")[len(z) - 1 - 400 : len(z) + 400] / len(z)
    deviation = np.sqrt(2 * np.sum(R**2) / len(z))
    assert abs(np.mean(z**2) - design.cost.value) < 4 * deviation
    assert deviation < 0.05 * design.cost.value  # and the test could have failed


def test_unstable_and_marginal_loops_cost_infinity():
    none = Compensator([[[0.0]]], [[[0.0]], [[0.0]]])
    for pole in ("1", "-1", "1.5", "1.0000000001"):
        cost = h2_cost(standard_plant(f"1/(q - ({pole}))"), none)
        assert cost.value == np.inf and cost.shares == {"w": np.inf}
    barely = h2_cost(standard_plant("1/(q - 0.99999999)"), none)
    assert barely.value == pytest.approx(1 / (1 - 0.99999999**2), rel=1e-7)


def test_a_stable_compensator_pole_outside_counts_even_if_cancelled():
    """An unstable mode that y does not show makes the loop unstable, and the cost infinite."""
    plant = standard_plant("1/(q - 0.5)")
    hidden = (np.diag([0.2, 1.1]), [[1.0], [0.0]], [[0.1, 0.0]], [[0.0]])
    assert float(h2_cost(plant, hidden)) == np.inf


def test_a_constant_gain():
    """x(k+1) = 2x + u + w with u = -1.5 x: the variance is 1/(1 - 0.25)."""
    plant = standard_plant("1/(q - 2)")
    for gain in (control.ss([], [], [], [[-1.5]], True), control.tf([-1.5], [1], True)):
        assert float(h2_cost(plant, gain)) == pytest.approx(1 / 0.75)


def test_numbers_at_the_end_of_float64():
    big = Plant(A=[[0.5]], B=[[1.0]], D_1=[[1e200]], C=[[1.0]])
    none = Compensator([[[0.0]]], [[[0.0]], [[0.0]]])
    assert float(h2_cost(big, none)) == np.inf
    with pytest.raises(InputError, match="beyond float64"):
        h2_cost(
            Plant(A=[[0.5]], B=[[1e200]], D_1=[[1.0]], C=[[1e200]]),
            ([[0.5]], [[1e200]], [[1e200]], [[1e200]]),
        )


@pytest.mark.parametrize(
    "compensator, words",
    [
        (([[0.5]], [[1.0]], [[1.0]]), "3 matrices"),
        (([[0.5]], [[1.0, 2.0]], [[1.0]], [[0.0]]), "B_c has shape"),
        (5, "no compensator"),
        (control.ss(-1, 1, 1, 0), "continuous time"),
    ],
)
def test_compensators_that_do_not_fit(compensator, words):
    with pytest.raises(InputError, match=words):
        h2_cost(standard_plant("1/(q - 0.5)"), compensator)


@pytest.mark.parametrize(
    "noise, words",
    [
        ({"x": 1.0}, "no block or channel 'x'; it has r, d, v"),
        ({"d": -1.0}, "intensity of d has the eigenvalue -1"),
        ({"d": [[1.0, 0.0]]}, "intensity of d has shape"),
        (["d"], "must map names"),
    ],
)
def test_intensities_that_do_not_fit(noise, words):
    with pytest.raises(InputError, match=words):
        h2_cost(PLANT_4_4, Compensator([[[0.0]]], [[[0.0]], [[0.0]]]), noise=noise)


def test_correlated_noise_of_a_block():
    plant = Plant(A=[[0.5]], B=[[1.0]], D_1=[[1.0, -1.0]], C=[[1.0]], blocks={"d": 2})
    none = Compensator([[[0.0]]], [[[0.0]], [[0.0]]])
    same = h2_cost(plant, none, noise={"d": [[1.0, 1.0], [1.0, 1.0]]})
    assert float(same) == pytest.approx(0.0, abs=1e-15)  # equal and opposite
    assert float(h2_cost(plant, none)) == pytest.approx(2 / 0.75)
    with pytest.raises(InputError, match="given twice"):
        h2_cost(plant, none, noise={"d": np.eye(2), "d1": 1.0})


@given(seeds, st.integers(1, 5), st.integers(1, 3), st.integers(1, 3))
def test_a_difference_equation_has_the_response_of_its_state_space(seed, n, l_u, l_y):
    rng = np.random.default_rng(seed)
    parts = (
        rng.standard_normal((n, n)) / n,
        rng.standard_normal((n, l_y)),
        rng.standard_normal((l_u, n)),
        rng.standard_normal((l_u, l_y)),
    )
    compensator = compensator_from_state_space(*parts)
    assert compensator.n_c <= n
    points = np.array([2.0, -1.7, 1.3j, 0.9 + 1.1j])

    def response(A, B, C, D):
        return np.array([C @ np.linalg.solve(z * np.eye(len(A)) - A, B) + D for z in points])

    responses = response(*parts)
    size = np.abs(compensator.past_u).max() + np.abs(compensator.past_y).max() + 1
    assert (
        np.abs(response(*compensator.state_space()) - responses).max()
        < 1e-9 * size * np.abs(responses).max()
    )
    # det D_c is det(qI - A_c) and a power of q: nothing unstable is hidden
    poles, ours = compensator.poles(), np.linalg.eigvals(parts[0])
    assert len(poles) == l_u * compensator.n_c >= n
    for z in points:
        ratio = np.prod(z - poles) / (np.prod(z - ours) * z ** (len(poles) - n))
        assert abs(ratio - 1) < 1e-9 * size


def test_nearly_parallel_outputs_and_hidden_modes():
    A = np.diag([0.5, -0.4, 1.3])
    parallel = [[1.0, 1.0, 1.0], [1.0, 1.0, 1.0 + 1e-9]]
    compensator = compensator_from_state_space(A, [[1.0], [2.0], [1.0]], parallel)
    assert max(np.abs(compensator.past_u).max(), np.abs(compensator.past_y).max()) < 100
    hidden = compensator_from_state_space(A, np.ones((3, 1)), [[1.0, 1.0, 0.0], [1.0, -1.0, 0.0]])
    assert np.abs(hidden.poles()).max() < 0.6  # u does not show the mode 1.3
    constant = compensator_from_state_space(A, np.ones((3, 1)), np.zeros((2, 3)), [[1.0], [2.0]])
    assert constant.past_y[0].tolist() == [[1.0], [2.0]] and not constant.past_u.any()
    assert state_space_of(constant, 2, 1)[3].tolist() == [[1.0], [2.0]]


def test_where_rounding_decides_the_cost_is_undecided_by_name():
    """(q^2 - 0.56 q + 1): modulus 1, of which the float64 coefficients of the loop keep less."""
    none = Compensator(past_u=[[[0.0]]], past_y=[[[0.0]], [[0.0]]])
    for poles in ("(q**2 - 0.56*q + 1)*(q - 0.3)*(q + 0.7)", "(q**2 + 0.3*q + 1)*(q - 0.9)"):
        try:
            assert np.isinf(float(h2_cost(standard_plant(f"1/({poles})"), none)))
        except IllConditionedError as error:
            assert "float64 does not determine" in str(error)
    near = standard_plant("1/(q - 0.99999999)")
    assert float(h2_cost(near, none)) == pytest.approx(1 / (1 - 0.99999999**2), rel=1e-7)


@given(seeds, st.floats(1, 8))
def test_the_bound_holds_where_the_feedthrough_of_the_loop_is_nearly_one(seed, digits):
    """D_c D_0 = 1 - 10^-digits: u is what is left of a difference, divided by as little."""
    rng, near = np.random.default_rng(seed), 10.0**-digits
    D_0 = rng.uniform(0.5, 2.0)
    plant = Plant(
        A=[[0.5]], B=[[near]], C=[[rng.uniform(-1, 1)]], D_0=[[D_0]], D_1=[[1.0, 0.0]],
        D_2=[[0.0, 0.1]], E_1=[[1.0]], E_2=[[near]],
    )  # fmt: skip
    compensator = [[0.2]], [[0.1 * near]], [[rng.uniform(-1, 1)]], [[(1 - near) / D_0]]
    cost = h2_cost(plant, compensator)
    assume(np.isfinite(cost.value))
    parts = tuple(map(np.array, compensator))
    exact = sum(enclosed_cost(plant, parts, noise_inputs(plant, None))[0])
    assert abs(cost.value - exact) <= cost.error_bound * exact


def test_a_cost_of_nothing_is_not_negative():
    """Where u cancels all of z the terms of the cost cancel; shares are sums of squares."""
    rng = np.random.default_rng(1)
    for _ in range(50):
        plant = Plant(
            A=[[-0.25]], B=rng.standard_normal((1, 2)), D_1=rng.standard_normal((1, 2)),
            C=rng.standard_normal((2, 1)), D_2=rng.standard_normal((2, 2)),
            E_1=rng.standard_normal((2, 1)), E_2=rng.standard_normal((2, 2)),
            E_0=rng.standard_normal((2, 2)),
        )  # fmt: skip
        # u = -E_2^{-1}(E_1 x + E_0 w), with x and w from y and the past: z = 0
        K, W = -np.linalg.solve(plant.E_2, plant.E_1), -np.linalg.solve(plant.E_2, plant.E_0)
        to_w = np.linalg.inv(plant.D_2)  # w = D_2^{-1}(y - C x)
        D_c = W @ to_w
        C_c = K - D_c @ plant.C
        A_c = plant.A - plant.D_1 @ to_w @ plant.C + plant.B @ C_c
        cost = h2_cost(plant, (A_c, plant.D_1 @ to_w + plant.B @ D_c, C_c, D_c))
        size = sum(map(abs, cost.terms.values()))
        assert cost.value >= 0 and (np.isinf(cost.value) or cost.value <= 1e-13 * size)


def test_what_is_no_plant_is_refused():
    with pytest.raises(InputError, match="not a Plant"):
        h2_cost(5, Compensator(past_u=[[[0.0]]], past_y=[[[0.0]], [[0.0]]]))


def test_a_cost_of_zero_is_zero_without_error():
    """At the boundary error = 0 <= TRUSTED * 0 no ball arithmetic is needed."""
    plant = Plant(A=[[0.5]], B=[[1.0]], C=[[1.0]], D_1=[[1.0]], E_1=[[0.0]], E_2=[[0.0]])
    cost = h2_cost(plant, ([[0.2]], [[0.3]], [[0.1]], [[0.0]]))
    assert cost.value == cost.error_bound == cost.sensitivity == 0.0
    assert cost.evidence != "ball arithmetic"
