"""A fixed compensator beside the one that adapts: for RCAC it belongs to the plant."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from compensator_theory import InputError
from compensator_theory.errors import ImproperError
from rcac_numeric import (
    UD,
    Compensator,
    Controller,
    ControllerSettings,
    Decentralized,
    FixedController,
    Plant,
    Saturation,
    TargetModel,
    check_controller,
    iir,
    loop_health,
    pid,
    simulate,
    standard_plant,
)
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.checks._check import arguments_of_run
from tests.support.engine_cases import engine_plants
from tests.support.signals import noise
from tests.support.strategies import seeds, sizes

PLANT = standard_plant("(q - 0.3)/((q - 1.1)*(q - 0.5))")
GAIN = Compensator(np.zeros((0, 1, 1)), [[[-0.5]]])


def settings_of(**more):
    argument = {"structure": iir(3), "target": TargetModel([0, 1.0, -0.3]), "update": UD(0.1)}
    return ControllerSettings(**{**argument, **more})


def closed(plant, c):
    """The plant with a compensator around it, whose input is what is added to u."""
    A, B, C, D = c.state_space()
    n, m = plant.n, len(A)
    return Plant(
        A=np.block([[plant.A + plant.B @ D @ plant.C, plant.B @ C], [B @ plant.C, A]]),
        B=np.vstack([plant.B, np.zeros((m, plant.l_u))]),
        D_1=np.vstack([plant.D_1 + plant.B @ D @ plant.D_2, B @ plant.D_2]),
        C=np.hstack([plant.C, np.zeros((plant.l_y, m))]),
        D_2=plant.D_2,
        E_1=np.hstack([plant.E_1, np.zeros((plant.l_z, m))]),
        E_0=plant.E_0,
    ), n + m


@given(st.data(), sizes, sizes, seeds, st.integers(0, 2))
def test_it_is_rcac_on_the_plant_with_the_compensator_around_it(data, l_u, l_y, seed, n):
    rng = np.random.default_rng(seed)
    plant = data.draw(engine_plants(l_u, l_y, 1))
    P, Q = rng.standard_normal((n, l_u, l_u)), rng.standard_normal((n + 1, l_u, l_y))
    fixed = Compensator(P / 6, Q / 6)
    target = TargetModel(np.concatenate([np.zeros((1, 1, l_u)), rng.standard_normal((2, 1, l_u))]))
    settings = ControllerSettings(
        structure=iir(2, l_u=l_u, l_y=l_y), target=target, update=UD(1.0), fixed=fixed
    )
    inner, order = closed(plant, fixed)
    w = noise(seed, 25, plant.l_w)
    run = simulate(plant, settings, w, x_0=np.ones(plant.n))
    alone = replace(settings, fixed=None)
    x_0 = np.concatenate([np.ones(plant.n), np.zeros(order - plant.n)])
    inside = simulate(inner, alone, w, x_0=x_0)
    assume(run.outcome == "completed" and np.abs(run.u).max() < 1e2 > np.abs(inside.u).max())
    size = max(1.0, np.abs(run.theta).max()) * max(1.0, np.abs(run.u).max()) ** 3
    assert np.abs(run.theta_final - inside.theta_final).max() <= 1e-9 * size
    assert np.abs(run.z - inside.z).max() <= 1e-9 * size


def test_without_adaptation_it_is_the_fixed_controller():
    fixed = Compensator([[[0.3]]], [[[-0.4]], [[0.1]]])
    settings = settings_of(fixed=fixed, k_update=10**6)
    w = noise(3, 100, 1)
    run = simulate(PLANT, settings, w)
    assert np.allclose(run.u, simulate(PLANT, FixedController(fixed), w).u, rtol=1e-12)
    assert run.compensator.n_c == 4
    assert np.allclose(np.sort(run.compensator.poles().real)[-1], 0.3)


def test_what_an_actuator_leaves_of_it_is_its_own_part():
    """u_applied - v is what the regressor and the filter hold, in the loop and at a device."""
    settings = settings_of(fixed=GAIN)
    run = simulate(PLANT, settings, noise(4, 60, 1), saturation=Saturation(low=-0.8, high=0.8))
    assert (run.u != run.u_applied).any()
    controller, before = Controller(settings), None
    for k in range(60):
        u = controller.step(run.y[k], run.z[k], u_applied=before)
        assert np.allclose(u, run.u[k], rtol=1e-12, atol=1e-14)
        before = run.u_applied[k]
    # Given v as a part of the plant, the same controller is told u_applied - v.
    other, before = Controller(replace(settings, fixed=None)), None
    for k in range(60):
        output = other.step(run.y[k], run.z[k], u_applied=before)
        v = -0.5 * run.y[k]
        assert np.allclose(output + v, run.u[k], rtol=1e-9, atol=1e-12)
        before = run.u_applied[k] - v
    report = loop_health(run)
    assert report.is_stable is not None and report.excitation is None


def test_a_check_is_handed_the_whole_compensator():
    run = simulate(PLANT, settings_of(fixed=GAIN), noise(5, 400, 1), stride=400)
    arguments = arguments_of_run(run)
    assert "structure" not in arguments and arguments["compensator"] == run.compensator
    assert check_controller(run).loop.is_stable == loop_health(run).is_stable


def test_it_takes_the_loop_from_step_0_on():
    """The unstable plant stays bounded before k_w, which the adaptive part alone cannot do."""
    fixed, w = settings_of(fixed=GAIN, k_w=400), noise(6, 400, 1)
    assert np.abs(simulate(PLANT, fixed, w).z).max() < 20
    assert np.abs(simulate(PLANT, settings_of(k_w=400), w).z).max() > 1e10


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: settings_of(fixed=3), InputError, "fixed"),
        (
            lambda: settings_of(fixed=Compensator(np.zeros((0, 1, 1)), [[[1.0, 2.0]]])),
            InputError,
            "fixed has 2 inputs and 1 outputs; beside this structure it reads",
        ),
        (lambda: Decentralized([settings_of(fixed=GAIN)]), InputError, "only a single controller"),
        (
            lambda: simulate(
                Plant(A=[[0.5]], B=[[1.0]], D_1=[[1.0]], C=[[1.0]], D_0=[[1.0]], E_1=[[1.0]]),
                settings_of(fixed=GAIN), noise(1, 3, 1),
            ),
            ImproperError,
            "exactly proper",
        ),
        (
            lambda: settings_of(
                structure=pid(l_u=2), target=TargetModel(np.ones((2, 1, 2)) * [[[0]], [[1.0]]]),
                fixed=Compensator(0.1 * np.ones((1, 2, 2)), np.ones((2, 2, 1))),
            ).compensator_of(np.ones(6)),
            InputError,
            "l_u = 1 only",
        ),
    ],
)  # fmt: skip
def test_what_does_not_fit_beside_it_is_refused(make, error, message):
    with pytest.raises(error, match=message):
        make()
