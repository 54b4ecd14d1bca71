"""The closed loop: one step for both doors, start-up, divergence, and the exact reference."""

from functools import partial

import numpy as np
import pytest
from hypothesis import assume, given, reject
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from compensator_theory import CompensatorError, InputError
from compensator_theory.errors import DivergedError, ImproperError
from rcac_numeric import (
    UD,
    Controller,
    ControllerSettings,
    Covariance,
    FixedController,
    Plant,
    Simulator,
    Step,
    Supervision,
    TargetModel,
    exogenous,
    fir,
    fir_target,
    iir,
    servo_plant,
    simulate,
    simulate_reference,
    standard_plant,
)
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.compiled._callbacks import Failures
from rcac_numeric.compiled._plants import compiled_plant
from tests.support.examples import EXAMPLE_4_6
from tests.support.strategies import controllers, plants, seeds


@pytest.mark.exact_data  # bit for bit in two ways, whose intermediate results are read anew
@given(st.data(), seeds)
def test_a_python_loop_gives_the_same_bits(data, seed):
    plant = data.draw(plants())
    settings = data.draw(controllers(plant.l_u, plant.l_y, plant.l_z))
    w = np.random.default_rng(seed).standard_normal((25, plant.l_w))
    run = simulate(plant, settings, w)
    controller, body = Controller(settings), Simulator(plant)
    no_control = np.zeros(plant.l_u)
    for k in range(run.steps):
        assert np.array_equal(controller.theta, run.theta[k])
        y, z = body.output(no_control, w[k])  # no feedthrough: y and z do not need u
        u = controller.step(y, z)
        body.advance(u, w[k])
        assert np.array_equal(y, run.y[k]) and np.array_equal(z, run.z[k])
        assert np.array_equal(u, run.u[k])
    if run.outcome == "completed":
        assert np.array_equal(controller.theta, run.theta_final)


@given(st.data(), seeds)
@hypothesis_settings(max_examples=15)
def test_both_updates_agree_with_300_digits(data, seed):
    plant = data.draw(plants(feedthrough=data.draw(st.booleans())))
    settings = data.draw(controllers(plant.l_u, plant.l_y, plant.l_z, k_c=st.just(1)))
    w = np.random.default_rng(seed).standard_normal((12, plant.l_w))
    try:
        exact = simulate_reference(plant, settings, w, digits=300)
    except DivergedError:
        reject()  # a wildly unstable loop, in which the balls grow past everything
    assume(exact.digits > 50)
    size = np.abs(exact.theta_final).max() * max(1.0, np.abs(exact.u).max() ** 2)
    for kind in (UD, Covariance):
        update = kind(settings.update.R_theta, lambda_=settings.update.lambda_)
        run = simulate(plant, replace(settings, update=update), w)
        assert np.abs(run.theta_final - exact.theta_final).max() <= 1e-11 * size


@pytest.mark.parametrize("R_theta", [1.0, 1e-10, 1e-20, 1e-40])
def test_ud_keeps_ten_digits_where_the_covariance_loses_them(R_theta):
    """Example 4.6 from k_w = n_f = 5: the float64 covariance fails from R_theta = 1e-20 on."""
    plant, w = EXAMPLE_4_6.plant, EXAMPLE_4_6.w()
    settings = replace(EXAMPLE_4_6.settings, k_w=5, k_update=5, update=UD(R_theta=R_theta))
    exact = simulate_reference(plant, settings, w, digits=250)
    assert exact.digits > 50
    size = np.abs(exact.theta_final).max()

    def error(kind):
        run = simulate(plant, replace(settings, update=kind(R_theta=R_theta)), w)
        return np.abs(run.theta_final - exact.theta_final).max() / size

    assert error(UD) < 1e-10
    if R_theta <= 1e-20:
        assert error(Covariance) > 1e-2


def test_the_guard_speaks_where_the_data_cannot_support_the_weight():
    """A filter switched on at k_w makes Example 4.6 ill-posed for R_theta = 1e-40."""
    plant, w = EXAMPLE_4_6.plant, EXAMPLE_4_6.w()
    settings = replace(
        EXAMPLE_4_6.settings, k_w=5, k_update=5, k_filter=5, update=UD(R_theta=1e-40 * np.eye(8))
    )
    assert simulate(plant, settings, w).guard_count > 0
    mild = replace(settings, update=UD(R_theta=1e-6 * np.eye(8)))
    assert simulate(plant, mild, w).guard_count == 0


def test_start_up():
    plant = standard_plant("1/(q - 0.5)")
    settings = ControllerSettings(
        structure=iir(1), target=fir_target(plant), update=UD(R_theta=1e-3), k_w=7, k_update=4
    )
    run = simulate(plant, settings, exogenous([Step()], 12))
    assert not run.u[:7].any() and run.u[7:].all()
    assert not run.theta[:5].any()  # theta(4 + 1) is the first that an update made
    assert run.theta[5:].any(axis=1).all()


def test_a_controller_that_is_good_already_does_not_wait():
    plant = standard_plant("1/(q - 0.5)")
    settings = ControllerSettings(
        structure=iir(1), target=fir_target(plant), update=UD(R_theta=1e-3), theta_0=[0.2, -0.3],
        k_w=0, k_update=4,
    )  # fmt: skip
    run = simulate(plant, settings, exogenous([Step()], 12))
    fixed = simulate(plant, FixedController(settings.compensator_of([0.2, -0.3])), run.w)
    assert run.u[2:].all() and np.allclose(run.u[:5], fixed.u[:5])
    assert (run.theta[:5] == settings.theta_0).all() and (run.theta[5:] != settings.theta_0).all()


def test_divergence_keeps_what_came_before():
    plant = standard_plant("1/(q - 3)")
    settings = ControllerSettings(
        structure=iir(1), target=TargetModel([0, -1.0]), update=UD(R_theta=1e6)
    )
    w = exogenous([Step()], 1000)
    run = simulate(plant, settings, w)
    assert run.outcome == "diverged" and 10 < run.steps < 1000
    arrays = (run.w, run.u, run.y, run.z, run.theta)
    assert all(len(a) == run.steps and np.isfinite(a).all() for a in arrays)
    assert np.isfinite(run.theta_final).all()
    shorter = simulate(plant, settings, w[: run.steps])
    assert shorter.outcome == "completed" and np.array_equal(shorter.z, run.z)
    assert np.array_equal(shorter.theta_final, run.theta_final)


def test_divergence_is_seen_in_coefficients_and_in_hidden_states():
    """Signals of size one, but theta near -1000 or an unobserved state that doubles."""
    small_y = Plant(A=[[0.0]], B=[[0.0]], D_1=[[1.0]], C=[[1e-3]], E_1=[[0.0]], E_0=[[1.0]])
    settings = ControllerSettings(
        structure=fir(1), target=TargetModel([0, 1.0]), update=UD(R_theta=1e-9)
    )
    run = simulate(small_y, settings, np.ones((20, 1)), divergence_limit=100.0)
    assert run.outcome == "diverged" and abs(run.theta_final).max() <= 100
    hidden = Plant(A=[[2.0]], B=[[0.0]], D_1=[[1.0]], C=[[0.0]])
    run = simulate(hidden, settings, np.ones((50, 1)), divergence_limit=1000.0)
    assert run.outcome == "diverged" and run.steps == 9  # x(k) = 2^k - 1


@pytest.mark.exact_data  # an entry is given as a number
def test_what_was_checked_cannot_be_changed_from_outside():
    A, R_theta, w = np.array([[0.5]]), np.eye(2), np.ones((5, 1))
    plant = Plant(A=A, B=[[1.0]], D_1=[[1.0]], C=[[1.0]])
    settings = ControllerSettings(
        structure=iir(1), target=TargetModel([0, 1.0]), update=UD(R_theta=R_theta)
    )
    run = simulate(plant, settings, w)
    A[:], R_theta[:], w[:] = 7.0, -1.0, 9.0
    assert plant.A.item() == 0.5 and settings.update.R_theta[0, 0] == 1.0 and run.w[0, 0] == 1.0
    for array in (plant.A, settings.update.R_theta, settings.theta_0, settings.target.numerator):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0


def test_a_simulator_checks_sizes_and_so_does_the_kernel():
    body = Plant(A=np.eye(3) / 2, B=np.ones((3, 2)), D_1=np.ones((3, 4)), C=np.ones((1, 3)))
    simulator, kernel = Simulator(body), compiled_plant(body, None, Failures())
    for call in (simulator.output, simulator.advance):
        with pytest.raises(InputError, match="u has 1 entries where 2 are needed"):
            call([0.0], np.zeros(4))
        with pytest.raises(InputError, match="w"):
            call([0.0, 0.0], [0.0, 0.0, 0.0, np.nan])
    for call in (partial(kernel.output, 0), partial(kernel.advance, 0)):
        with pytest.raises(ValueError, match="1 numbers where 2 belong"):
            call(np.zeros(1), np.zeros(4))
        with pytest.raises(ValueError, match="1 numbers where 4 belong"):
            call(np.zeros(2), np.zeros(1))


@pytest.mark.parametrize(("R_theta", "speaks"), [(1e-30, True), (1e-20, False)])
def test_the_guard_sees_an_unexcited_direction(R_theta, speaks):
    """y = 1 gives the rows (1, 1): nothing is known of theta_1 - theta_2, and rounding would
    decide it once P(0) exceeds 1 / (16 eps)^2 by far."""
    settings = ControllerSettings(
        structure=fir(2), target=TargetModel([0, 1.0]), update=UD(R_theta=R_theta), k_w=5
    )
    controller = Controller(settings)
    for _ in range(8):
        controller.step(1.0, 0.3)
    assert (controller._kernel.guard_count > 0) is speaks


@pytest.mark.parametrize("stride", [1, 3, 7])
def test_theta_is_kept_at_the_stride(stride):
    plant = servo_plant("(q - 0.85)/((q - 0.8)*(q - 0.9))")
    settings = ControllerSettings(
        structure=iir(2), target=fir_target(plant), update=UD(R_theta=0.2)
    )
    w = exogenous([Step(), Step(0), Step(0)], 20)
    full, remaining = simulate(plant, settings, w), simulate(plant, settings, w, stride=stride)
    assert np.array_equal(remaining.theta, full.theta[::stride])
    assert np.array_equal(remaining.theta_final, full.theta_final)
    with pytest.raises(InputError, match="not stored"):
        remaining.compensator_at(20 * stride)


def test_feedthrough_of_the_plant_is_simulated():
    """z = u here, so the loop is u -> z with no dynamics; checked against the definition."""
    plant = Plant(A=[[0.0]], B=[[0.0]], D_1=[[1.0]], C=[[1.0]], E_1=[[0.0]], E_2=[[2.0]])
    settings = ControllerSettings(
        structure=iir(1), target=TargetModel([2.0]), update=UD(R_theta=1.0), theta_0=[0.5, 0.25]
    )
    run = simulate(plant, settings, np.ones((5, 1)))
    assert np.array_equal(run.z, 2 * run.u) and run.u[2:].all()


def test_bad_input_is_named():
    plant = standard_plant("1/(q - 0.5)")
    good = ControllerSettings(structure=iir(1), target=fir_target(plant), update=UD(R_theta=1.0))
    with pytest.raises(InputError, match=r"w has the entry nan at index \(1, 0\)"):
        simulate(plant, good, [[0.0], [np.nan]])
    with pytest.raises(InputError, match=r"w has shape \(2, 3\)"):
        simulate(plant, good, np.zeros((2, 3)))
    with pytest.raises(InputError, match="x_0 has 2 entries; the plant has 1 states"):
        simulate(plant, good, np.zeros((2, 1)), x_0=np.zeros(2))
    two = ControllerSettings(
        structure=iir(1, l_y=2), target=fir_target(plant), update=UD(R_theta=1.0)
    )
    with pytest.raises(InputError, match="plant has l_y = 1 and the controller l_y = 2"):
        simulate(plant, two, np.zeros((2, 1)))
    proper = Plant(A=[[0.5]], B=[[1.0]], D_1=[[1.0]], C=[[1.0]], D_0=[[1.0]])
    exactly_proper = ControllerSettings(
        structure=iir(1, k_c=0), target=fir_target(plant), update=UD(R_theta=1.0)
    )
    with pytest.raises(ImproperError, match="D_0 is not zero"):
        simulate(proper, exactly_proper, np.zeros((2, 1)))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"update": {"R_theta": -1.0}}, "R_theta has the eigenvalue -1; it must be positive defin"),
        ({"update": {"R_theta": 1e-320}}, "no float64 inverse"),
        ({"update": {"R_theta": np.nan}}, "R_theta has the entry nan"),
        ({"update": {"R_theta": np.eye(3)}}, r"R_theta has shape \(3, 3\)"),
        ({"update": {"R_theta": [[1.0, 0.5], [0.0, 1.0]]}}, "R_theta is not symmetric"),
        ({"R_z": 0.0}, "R_z has the eigenvalue 0"),
        ({"R_u": -0.1}, "R_u has the eigenvalue -0.1"),
        ({"update": {"lambda_": 0.0}}, r"lambda_ = 0.0 is not in \(0, 1\]"),
        ({"update": {"lambda_": 1.1}}, r"lambda_ = 1.1 is not in \(0, 1\]"),
        ({"k_w": 0}, r"k_w = 0 is shorter than max\(n_c, n_f\) = max\(1, 1\) = 1"),
        ({"k_w": 1.5}, "k_w must be an integer"),
        ({"k_update": -1}, "k_update = -1 must be at least 0"),
        ({"theta_0": [1.0]}, "theta_0 has 1 entries"),
        ({"target": TargetModel(np.ones((2, 1, 2)))}, "target model has 2 columns"),
    ],
)
def test_a_setting_out_of_range_is_named(change, message):
    valid = {"structure": iir(1), "target": TargetModel([0.0, 1.0])}
    of_update = change.get("update", {})
    with pytest.raises(CompensatorError, match=message):
        update = UD(**{"R_theta": 1.0, **of_update})
        ControllerSettings(**{**valid, **change, "update": update})


def test_the_controller_object_refuses_bad_signals_and_does_not_move():
    settings = ControllerSettings(
        structure=iir(1), target=TargetModel([0.0, 1.0]), update=UD(R_theta=1.0)
    )
    controller = Controller(settings, Supervision("off"))
    for y, z in ((np.nan, 0.0), (0.0, np.inf), ([1.0, 2.0], 0.0)):
        with pytest.raises(InputError):
            controller.step(y, z)
    assert controller.k == 0
    controller.step(1e200, 1e200)
    with pytest.raises(DivergedError, match="overflowed float64"):
        for _ in range(10):
            controller.step(1e300, 1e300)


def test_the_initial_state_is_where_the_plant_starts():
    plant = Plant(A=[[0.5, 1.0], [0.0, 0.25]], B=[[0.0], [1.0]], D_1=[[0.0], [1.0]], C=[[1.0, 0.0]])
    settings = ControllerSettings(
        structure=iir(1), target=TargetModel([0, 0, 1.0]), update=UD(R_theta=1.0), k_w=6
    )
    run = simulate(plant, settings, np.zeros((6, 1)), x_0=[1.0, -2.0])
    free = [(np.linalg.matrix_power(plant.A, k) @ [1.0, -2.0])[0] for k in range(6)]
    assert run.y[:, 0] == pytest.approx(free, abs=1e-15)


def test_by_default_a_loop_diverges_where_no_digit_of_its_input_is_left():
    """With the right sign the same loop is fine, however large its signals are."""
    wrong = ControllerSettings(
        structure=iir(1), target=TargetModel([0, -1.0]), update=UD(R_theta=1e6)
    )
    plant = standard_plant("1/(q - 2)")
    for scale in (1e-9, 1.0, 1e12):
        run = simulate(plant, wrong, scale * np.ones((400, 1)))
        assert run.outcome == "diverged" and np.abs(run.z[:-1]).max() < run.divergence_limit
        assert run.divergence_limit == 1e15 * max(scale, 1.0)
    stable = standard_plant("1/(q - 0.5)")
    assert simulate(stable, wrong, 1e30 * np.ones((9, 1)), x_0=[1e40]).divergence_limit == 1e55
