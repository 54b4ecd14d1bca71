"""Examples 8.6 and 8.7: the lateral aircraft follows a step after its transition."""

import copy

import numpy as np
import pytest

from compensator_theory.errors import CompensatorError, InputError, NotObservableError
from rcac_numeric import RCMR, FIRSubsystem, IndirectController
from tests.support.lateral_aircraft import (
    A_0,
    A_1,
    B_0,
    B_1,
    B_HAT,
    E_1,
    FOLLOWED,
    euler,
    without_A21,
)

H, SWITCH, STEP = 0.01, 6000, 0.15
BEFORE, AFTER = euler(A_0, B_0, H), euler(A_1, B_1, H)


def model(beta, **changes):
    """All nominal but A_21, which RCMR estimates; B is the mean of both plants."""
    arguments = {
        "A": without_A21(BEFORE[0]), "B": B_HAT, "D_1": (BEFORE[1] + AFTER[1]) / 2,
        "C": [0, 1, 0, 0], "E_1": E_1, "delays": (1,), "theta_0": [BEFORE[0][1, 0]],
    }  # fmt: skip
    return RCMR(**(arguments | {"beta": beta} | changes))


def flown(controller, steps, observed=False):
    """phi(k) while the plant changes at SWITCH, in one step."""
    x, phi = np.zeros(4), []
    for k in range(steps):
        A, B = BEFORE if k < SWITCH else AFTER
        phi.append(x[3])
        x = A @ x + B @ controller.step(x[3:] if observed else x, STEP)
    return np.array(phi) - STEP


def test_example_8_6(in_full):
    """Full-state feedback follows after the transition, with A_21 not quite right."""
    controller = IndirectController(model(2e5), FOLLOWED, R_1=1, R_2=10, k_identify=1000)
    error = flown(controller, 20_000 if in_full else 9_000)
    assert abs(error[5500:SWITCH]).max() < 1e-6
    assert 3.5 < abs(error[SWITCH:]).max() < 4.5  # the deviation that the text shows as a picture
    assert abs(error[-500:]).max() < (1e-8 if in_full else 1e-3)
    assert controller.theta[0] == pytest.approx(-1.0851, abs=1e-3)  # of -1.0880


def test_example_8_7(in_full):
    """Output feedback follows too, after a larger deviation."""
    controller = IndirectController(
        model(2), FOLLOWED, R_1=1, R_2=100, V_1=1, V_2=1, k_identify=1000
    )
    error = flown(controller, 20_000 if in_full else 12_000, observed=True)
    assert abs(error[5500:SWITCH]).max() < 1e-5
    assert abs(error[SWITCH:]).max() > 20
    assert abs(error[-500:]).max() < (1e-8 if in_full else 1e-2)
    assert controller.theta[0] == pytest.approx(-1.060, abs=1e-2)


def test_without_identification_the_loop_diverges():
    controller = IndirectController(model(2e5, k_update=10**9), FOLLOWED, R_1=1, R_2=10)
    with np.errstate(all="ignore"):
        assert abs(flown(controller, 10_000)).max() > 1e6


def test_a_copy_goes_on_as_the_original():
    controller = IndirectController(model(2), FOLLOWED, 1, 100, V_1=1, V_2=1)
    flown(controller, 300, observed=True)
    other = copy.deepcopy(controller)
    for k in range(20):
        assert np.array_equal(controller.step(0.01 * k, STEP), other.step(0.01 * k, STEP))


def controller_of(**changes):
    return IndirectController(model(1), FOLLOWED, R_1=1, R_2=1, **changes)


@pytest.mark.parametrize(
    ("make", "error", "says"),
    [
        (lambda: controller_of(V_1=1), InputError, "both V_1 and V_2"),
        (lambda: IndirectController(model(1), [1, 0], 1, 1), InputError, "C_r has shape"),
        (
            lambda: IndirectController(
                model(1, subsystem=FIRSubsystem(2), theta_0=None), FOLLOWED, 1, 1
            ),
            InputError, "has dynamics; a static one",
        ),
        (
            lambda: IndirectController(model(1, theta_0=[0], A=np.diag([0.9, 0.8, 0.7, 0.6])),
                                       FOLLOWED, 1, 1, V_1=1, V_2=1),
            NotObservableError, "sees 1 of the 4 modes",
        ),
        (lambda: controller_of().step([1, 2], 0), InputError, "y has 2"),
        (
            lambda: controller_of().step([np.nan] * 4, 0),
            InputError, "y has the entry nan",
        ),
    ],
)  # fmt: skip
def test_bad_input(make, error, says):
    with pytest.raises(error, match=says) as caught:
        make()
    assert isinstance(caught.value, CompensatorError)
