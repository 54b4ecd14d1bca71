"""A controller that learns its target model step by step is the run of simulate; cuts, refusals."""

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory import InputError
from compensator_theory.errors import FunctionFailedError

PLANT = rn.standard_plant("(q - 0.8)*(q - 1.5)/((q - 0.5)*(q**2 - 1.9*q + 1))")
STEPS = 260


def settings_of(start=100, every=10, **more):
    target = rn.DataDriven(order=6, start=start, every=every, running_dither=0.01, **more)
    return rn.ControllerSettings(structure=rn.iir(6), target=target, update=rn.UD(0.5))


def run_of(settings, saturation=None, seed=3, steps=STEPS):
    w = rn.exogenous([rn.WhiteNoise(0.01)], steps, seed)
    return rn.simulate(PLANT, settings, w, saturation=saturation)


def drive(controller, run, steps, saturated=False):
    """u of the controller at these steps, given what the run measured."""
    u = []
    for k in steps:
        applied = run.u_applied[k - 1] if saturated and k else None
        u.append(controller.step(run.y[k], run.z[k], u_applied=applied))
    return np.array(u)


@pytest.mark.costly
@pytest.mark.exact_data  # bit for bit in two ways, whose intermediate results are read anew
@given(
    st.sampled_from(["reset", "blend", "keep", "replay"]),
    st.sampled_from([1.0, 0.99]),
    st.sampled_from([1, 3, 10]),
    st.booleans(),
    st.integers(0, STEPS),
    st.integers(0, 100),
)
def test_step_by_step_cut_anywhere_it_is_the_run(covariance, lambda_, every, saturates, cut, seed):
    """u, theta, target and changes bit for bit, with what the actuator made of u told later."""
    settings = settings_of(every=every, covariance=covariance, lambda_=lambda_)
    saturation = rn.Saturation(low=-0.02, high=0.02) if saturates else None
    run = run_of(settings, saturation, seed)
    first, second = rn.Controller(settings), rn.Controller(settings)
    u = drive(first, run, range(cut), saturates)
    second.restore(first.state)
    assert second.state == first.state
    rest = drive(second, run, range(cut, run.steps), saturates)
    assert np.array_equal(np.vstack([u.reshape(-1, 1), rest.reshape(-1, 1)]), run.u)
    assert np.array_equal(second.theta, run.theta_final)
    assert first.changes + second.changes == run.changes
    if run.changes:
        assert second.target == run.changes[-1].change.target


@pytest.mark.exact_data  # bit for bit in two ways, whose intermediate results are read anew
def test_a_state_goes_through_a_file_and_copies_are_their_own(tmp_path):
    run, settings = run_of(settings_of()), settings_of()
    one = rn.Controller(settings)
    drive(one, run, range(150))
    one.state.save(tmp_path / "state.npz")
    other = rn.Controller(settings)
    other.restore(rn.SavedState.load(tmp_path / "state.npz"))
    for controller in (other, copy.deepcopy(one), pickle.loads(pickle.dumps(one)), one):
        assert np.array_equal(drive(controller, run, range(150, STEPS)), run.u[150:])


@pytest.mark.exact_data  # bit for bit in two ways, whose intermediate results are read anew
def test_what_is_refused_moves_nothing():
    """A step with bad numbers is neither learnt nor counted."""
    run, settings = run_of(settings_of()), settings_of()
    controller = rn.Controller(settings)
    for k in range(STEPS):
        for wrong in ((1j, 0.0), (0.0, [1, 2]), ("x", 0.0)):
            with pytest.raises(InputError):
                controller.step(*wrong)
        with pytest.raises(InputError, match=r"u_applied|entries"):
            controller.step(run.y[k], run.z[k], u_applied=[1.0, 2.0])
        assert controller.k == k
        assert np.array_equal(controller.step(run.y[k], run.z[k]), run.u[k])
    assert controller.changes == run.changes


@pytest.mark.exact_data  # bit for bit in two ways, whose intermediate results are read anew
def test_freeze_holds_theta_and_not_the_model():
    """Frozen before the first look: the target is learnt, theta waits for `resume`."""
    run, settings = run_of(settings_of()), settings_of()
    controller = rn.Controller(settings)
    controller.freeze()
    drive(controller, run, range(130))
    assert controller.changes[0] == run.changes[0] and not controller.theta.any()
    again = rn.Controller(settings)
    again.restore(controller.state)
    drive(again, run, range(130, 140))
    assert not again.theta.any()
    again.resume()
    drive(again, run, range(140, 150))
    assert again.theta.any()
    early = rn.Controller(settings)
    early.resume()  # there is no target model yet: nothing to adapt to
    drive(early, run, range(100))
    assert not early.theta.any() and early.changes == ()


def test_a_target_from_outside_is_refused():
    settings = settings_of()
    controller = rn.Controller(settings)
    before = controller.state
    with pytest.raises(InputError, match="learns the target model"):
        controller.set_target(rn.TargetModel([0, 1]))
    with pytest.raises(InputError, match="learns the target model"):
        controller.change(rn.ControllerChange(rn.TargetModel([0, 1]), R_u=0.1))
    assert controller.state == before
    controller.set_weights(R_u=0.1)  # what is not learnt may change
    assert controller.changes[-1].change == rn.ControllerChange(R_u=0.1)
    with pytest.raises(FunctionFailedError, match="learns the target model"):
        rn.simulate(
            PLANT, settings, np.zeros((20, 1)), every=5,
            on_step=lambda run: rn.ControllerChange(rn.TargetModel([0, 1])),
        )  # fmt: skip


def test_states_of_others_are_refused():
    settings, run = settings_of(), run_of(settings_of())
    controller = rn.Controller(settings)
    drive(controller, run, range(50))
    with pytest.raises(InputError, match="of a loop"):
        controller.restore(run.state)
    with pytest.raises(InputError, match="other settings"):
        rn.Controller(settings_of(every=20)).restore(controller.state)
    state = controller.state
    for values in (state.values[:-1], state.values[:3], np.r_[state.values[:-2], 0.5, 5.0]):
        bad = rn.SavedState.of_values("controller", state.k, values, state.fingerprint)
        with pytest.raises(InputError, match="damaged"):
            controller.restore(bad)
        assert controller.state == state
