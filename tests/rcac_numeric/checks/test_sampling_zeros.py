"""Where the controller cancels a zero near -1: the health names it before R_theta, and it helps."""

import control
import numpy as np
import pytest

import rcac_numeric as rn
from rcac_numeric.checks._rules import sampling_zero_remedies
from rcac_numeric.targets import modelling_information

G = control.c2d(control.tf([2], [0.5, 1.2, 1]), 0.1)
SAMPLED = rn.servo_plant(G)
H = modelling_information(SAMPLED).H
CANCELLED, LISTED = rn.fir_target(SAMPLED), rn.fir_target(rn.ModellingInformation(1, H, [-1]))
SIZES = ("large transient", "large control")


def ran(target, R_theta, seed=0):
    w = rn.exogenous([rn.Step(), rn.Step(0), rn.WhiteNoise(0.01)], 600, seed=seed)
    settings = rn.ControllerSettings(structure=rn.iir(n_c=4), target=target, update=rn.UD(R_theta))
    run = rn.simulate(SAMPLED, settings, w)
    return np.abs(run.u).max(), rn.loop_health(run)


@pytest.mark.parametrize("seed", range(3))
def test_the_zero_is_named_before_R_theta_and_only_it_helps(seed):
    peak, health = ran(CANCELLED, 1e-2, seed)
    advice = [w.next_step for w in health.warnings if w.code in SIZES]
    zero = f"{float(control.zeros(G)[0].real):.4g}"
    assert advice and all(f"the zero {zero} of" in message.split(";")[0] for message in advice)
    assert all(
        "nmp_zeros" in message and message.index("-1") < message.index("100 times")
        for message in advice
    )
    larger, _ = ran(CANCELLED, 1.0, seed)
    message, mended = ran(LISTED, 1e-2, seed)
    assert larger > peak > 5 * message
    assert not any(warning.is_grave for warning in mended.warnings)


@pytest.mark.parametrize(
    ("zeros", "left"),
    [
        ("(q + 0.92)", ["-0.92"]), ("(q + 0.95)*(q + 0.91)", ["-0.95", "-0.91"]),
        ("(q + 0.89)", []), ("(q - 0.95)", []), ("(q**2 + 0.9)", []), ("(q + 1.1)", []),
    ],
)  # fmt: skip
def test_only_real_zeros_near_minus_one_that_the_target_lacks(zeros, left):
    plant = rn.standard_plant(f"{zeros}/((q - 0.5)*(q - 0.6)*(q - 0.7))")
    d_zu = modelling_information(plant).d_zu

    def remedies(target):
        return sampling_zero_remedies(
            plant, rn.fir_target(rn.ModellingInformation(d_zu, 1, target))
        )

    assert bool(remedies([])) == bool(left) and all(zero in remedies([])[0] for zero in left)
    assert remedies([-1] * len(left)) == ()
    if len(left) == 2:
        assert remedies([-1])[0].startswith("the zero ")
