"""What was written before the settings became typed specifications is read, and is the same.

`saved/run.npz` and the fingerprints here were written by the dataclasses that came before; the
state is of format 2, which keeps what the supervisor knows, and one of format 1 is refused. Who
changes a field or a name of one of these classes changes the fingerprint of every state
that was ever saved: that is refused here, until the files' version moves.
"""

from pathlib import Path

import numpy as np
import pytest

import rcac_numeric as rn
from compensator_theory.errors import InputError
from rcac_numeric.arrays._values import fingerprint

SAVED = Path(__file__).parent / "saved"
TARGET = rn.TargetModel([0.0, 1.0])


def settings(**others):
    return rn.ControllerSettings(
        structure=rn.iir(n_c=2),
        target=TARGET,
        update=rn.UD(
            0.5, lambda_=rn.ScheduledForgetting({5: 0.9}), reset=rn.CovarianceReset(at=[7], every=9)
        ),
        R_z=rn.SignalWeight(constant=1, nu=0.25),
        R_u=0.01,
        k_w=3,
        theta_0=[0.1, 0.0, -0.1, 0.0],
        freeze=[(10, 12), (18, None)],
        z_normalization=rn.Normalization(5.0, function="tanh"),
        bounds=rn.CoefficientBounds(-2, 2, gains={"P_1": (-0.5, None)}, method="clip"),
        fixed=rn.Compensator([[[0.5]]], [[[0]], [[0.25]]]),
        target_changes={8: rn.TargetModel([0.0, 0.5])},
        **others,
    )


VALUES = {
    "settings": (settings, "d075e0a52be80bb0"),
    "filter form": (lambda: settings(form="filter"), "cb54acbbfb36b1a2"),
    "pid": (
        lambda: rn.ControllerSettings(structure=rn.pid(), target=TARGET, update=rn.UD(1.0)),
        "5be3c3e035c7b025",
    ),
    "learning": (
        lambda: rn.ControllerSettings(
            structure=rn.iir(3), target=rn.DataDriven(order=9), update=rn.UD(1.0)
        ),
        "4449d598aa37e747",
    ),
    "covariance": (
        lambda: rn.Covariance([[2.0, 0.0], [0.0, 1.0]], process_noise=0.1),
        "db307426e962b0b9",
    ),
    "variable rate": (
        lambda: rn.UD(0.5, lambda_=rn.VariableRateForgetting(5, 50, 0.2)),
        "a1c94da102f8172e",
    ),
    "subspace": (lambda: rn.UD(0.5, lambda_=rn.SubspaceForgetting(0.99)), "ecc9e17773ef1b6b"),
    "window": (lambda: rn.SlidingWindow(0.5, window=20, lambda_=0.9), "539670a19acdf403"),
    "joint": (lambda: rn.JointUD(0.5, n_d=2, rho=2.0), "ec25a7114e3e4833"),
    "instantaneous": (lambda: rn.Instantaneous(0.5), "4567422e4518fc56"),
    "gradient": (lambda: rn.Gradient(1e-3), "b880c980d9e2d555"),
    "reset": (lambda: rn.CovarianceReset(growth=2.0, short=5), "b7b1b9858e9b0e0e"),
    "saturation": (lambda: rn.Saturation(low=-1, high=[1.0, 2.0], rate=0.5), "66dc88d44f007853"),
    "step": (lambda: rn.Step(2, start=3), "b4cbac23eaf41bf8"),
    "ramp": (lambda: rn.Ramp(0.5), "4f22f6e59e1bd1a9"),
    "pulse": (lambda: rn.Pulse(2, 5, 3), "7e879f776ac038b6"),
    "harmonic": (lambda: rn.Harmonic(0.5, phase=1), "58102fb73bf25b69"),
    "noise": (lambda: rn.WhiteNoise(0.1), "16a0e2416de7cdc4"),
    "levels": (lambda: rn.Levels([1, -1], hold=2), "c775f552d20d1a93"),
    "piecewise": (
        lambda: rn.Piecewise([(0, rn.Step()), (5, 2 * rn.Ramp() + rn.Step(1))]),
        "76745055b03931ac",
    ),
}


@pytest.mark.exact_data
@pytest.mark.parametrize("name", VALUES)
def test_a_fingerprint_is_what_it_was(name):
    make, known = VALUES[name]
    assert fingerprint(make()) == known


def run():
    w = np.linspace(-1.0, 1.0, 25)[:, None]
    return rn.simulate(
        rn.standard_plant("(q - 0.5)/(q*(q - 0.9))"),
        settings(),
        w,
        saturation=rn.Saturation(high=0.5),
    )


def controller():
    controller = rn.Controller(settings())
    for k in range(6):
        controller.step(y=[0.1 * k], z=[0.2 * k])
    return controller


@pytest.mark.exact_data
def test_a_saved_run_is_read():
    old, new = rn.load_run(SAVED / "run.npz"), run()
    assert old.settings == new.settings and old.plant == new.plant
    np.testing.assert_allclose(old.theta, new.theta, rtol=1e-12, atol=1e-12)
    assert old.saturation == rn.Saturation(high=0.5)


@pytest.mark.exact_data
def test_a_saved_state_goes_on():
    going_on = rn.Controller(settings())
    going_on.restore(rn.SavedState.load(SAVED / "controller.npz"))
    assert going_on.k == 6
    there = controller().step(y=[0.7], z=[0.1])
    np.testing.assert_allclose(going_on.step(y=[0.7], z=[0.1]), there, rtol=1e-12, atol=1e-15)


def test_a_state_of_another_format_is_refused():
    with pytest.raises(InputError, match="another format than this version reads; run again"):
        rn.Controller(settings()).restore(rn.SavedState.load(SAVED / "controller-of-format-1.npz"))
