"""Runs that cannot be made, and weights that fail while one is made."""

import numpy as np
import pytest

import rcac_numeric as rn
from compensator_theory import CompensatorError, InputError
from compensator_theory.errors import FunctionFailedError, ImproperError

GOOD = {"structure": rn.iir(1), "target": rn.TargetModel([0, 1.0]), "update": rn.UD(R_theta=1.0)}
SETTINGS = rn.ControllerSettings(**GOOD)
PLANT = rn.standard_plant("1/(q - 0.5)")
BOTH = rn.Decentralized([SETTINGS] * 2)
ONES = np.ones((5, 1))
NAN = float("nan")


def with_r(**change):
    return rn.ControllerSettings(**{**GOOD, "structure": rn.feedforward(1), **change})


@pytest.mark.parametrize(
    ("run", "message"),
    [
        (
            lambda: rn.simulate(5, SETTINGS, ONES),
            "plant = 5 is not a Plant or PlantSchedule or FunctionPlant",
        ),
        (lambda: rn.simulate(PLANT, 5, ONES), "settings = 5 is not a ControllerSettings or Fixe"),
        (lambda: rn.simulate(PLANT, SETTINGS, None), "w must be an array of real numbers"),
        (lambda: rn.simulate(PLANT, SETTINGS, ONES, stride=0), "stride = 0 must be at least 1"),
        (lambda: rn.simulate(PLANT, SETTINGS, ONES, divergence_limit=-1), "must be positive"),
        (lambda: rn.simulate(PLANT, SETTINGS, ONES, saturation=5), "saturation = 5 is not a Satur"),
        (
            lambda: rn.simulate(PLANT, SETTINGS, ONES, saturation=rn.Saturation(low=[0, 0])),
            "low has 2",
        ),
        (lambda: rn.simulate(PLANT, with_r(), ONES), "reads a command with l_r = 1"),
        (
            lambda: rn.simulate(PLANT, BOTH, ONES, saturation=rn.Saturation(low=0)),
            "do not receive their applied parts",
        ),
        (lambda: rn.frozen_twin(5, 1), "run = 5 is not a Run"),
        (lambda: rn.frozen_twin(rn.simulate(PLANT, SETTINGS, ONES), -1), "k = -1"),
        (lambda: rn.Controller(5), "settings = 5: ControllerSettings are needed"),
        (lambda: rn.Controller(SETTINGS).step(1.0, 1.0, 1.0), "l_r = 0 commands; r = 1.0"),
        (lambda: rn.Controller(with_r()).step(1.0, 1.0), "l_r = 1 commands; r = None"),
        (lambda: rn.Controller(SETTINGS).step(1.0, 1.0, u_applied=1.0), "leave it out at step 0"),
        (
            lambda: rn.Controller(SETTINGS).step(1.0, 1.0, u_applied=[1, 2]),
            "u_applied has 2 entries",
        ),
    ],
)
def test_a_run_that_cannot_be_made(run, message):
    with pytest.raises(InputError, match=message):
        run()


def test_the_filter_form_needs_a_plant_without_feedthrough():
    plant = rn.Plant(A=[[0.5]], B=[[1.0]], D_1=[[1.0]], C=[[1.0]], E_2=[[1.0]])
    with pytest.raises(ImproperError, match="E_2 is not zero"):
        rn.simulate(plant, rn.ControllerSettings(**GOOD, form="filter"), ONES)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"R_u": lambda k, y, z, u: -1.0}, r"R_u\(3\) has the eigenvalue -1"),
        ({"R_u": lambda k, y, z, u: [[1, 2]]}, r"R_u\(3\) has shape \(1, 2\)"),
        ({"R_u": lambda: 1}, r"could not be called as R_u\(k, y, z, u\)"),
        ({"R_u": lambda k, y, z, u: 1 / (z[0] - z[0])}, "failed at step 3"),
        ({"R_z": lambda k, y, z, u: 0.0}, r"R_z\(3\) has the eigenvalue 0"),
        ({"R_z": lambda k, y, z, u: None}, r"R_z\(3\) must be an array"),
        ({"R_z": lambda k, y, z, u: NAN}, r"R_z\(3\) has the entry nan"),
    ],
)
@pytest.mark.parametrize("update", [rn.UD, rn.Covariance])
def test_a_weight_that_fails_keeps_the_steps_before(change, message, update):
    """The first update is that of step 3."""
    settings = rn.ControllerSettings(
        **{**GOOD, "update": update(R_theta=1.0)}, k_update=3, **change
    )
    with np.errstate(all="ignore"), pytest.raises(FunctionFailedError, match=message) as caught:
        rn.simulate(PLANT, settings, ONES)
    run = caught.value.run
    assert run.outcome == "weight failed"
    assert run.steps == 3 and np.array_equal(run.theta_final, settings.theta_0)
    controller = rn.Controller(settings)
    for k in range(4):
        if k < 3:
            controller.step(1.0, 1.0)
        else:
            with np.errstate(all="ignore"), pytest.raises(FunctionFailedError):
                controller.step(1.0, 1.0)
    with pytest.raises(CompensatorError, match="create a new controller"):
        controller.step(1.0, 1.0)


def test_a_weight_that_is_not_symmetric():
    plant = rn.Plant(A=[[0.5]], B=[[1.0]], D_1=[[1.0]], C=[[1.0]], E_1=[[1.0], [2.0]])
    settings = rn.ControllerSettings(
        structure=rn.iir(1), target=rn.TargetModel(np.ones((2, 2, 1))), update=rn.UD(R_theta=1.0),
        R_z=lambda k, y, z, u: [[1.0, 0.5], [0.0, 1.0]],
    )  # fmt: skip
    with pytest.raises(FunctionFailedError, match=r"R_z\(1\) is not symmetric"):
        rn.simulate(plant, settings, ONES)
