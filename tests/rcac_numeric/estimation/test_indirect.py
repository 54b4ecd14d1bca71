"""Examples 8.6 and 8.7: the lateral aircraft follows a step after its transition."""

import copy

import numpy as np
import pytest

from compensator_theory.errors import CompensatorError, InputError, NotObservableError
from rcac_numeric import (
    Plant,
    PlantChange,
    PlantSchedule,
    Saturation,
    SavedState,
    SimulationCase,
    frozen_twin,
    load_run,
    simulate,
    simulate_many,
)
from rcac_numeric.estimation import RCMR, FIRSubsystem, IndirectController, IndirectSettings
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


def indirect(beta=2e5, **choices):
    changes = {name: choices.pop(name) for name in ("k_update",) if name in choices}
    return IndirectSettings(
        model(beta, **changes), FOLLOWED, **({"R_1": 1, "R_2": 10, "k_identify": 1000} | choices)
    )


OUTPUT_FEEDBACK = {"beta": 2, "R_2": 100, "V_1": 1, "V_2": 1}


def flown(controller, steps, observed=False):
    """phi(k) while the plant changes at SWITCH, in one step."""
    x, phi = np.zeros(4), []
    for k in range(steps):
        A, B = BEFORE if k < SWITCH else AFTER
        phi.append(x[3])
        x = A @ x + B @ controller.step(x[3:] if observed else x, STEP)
    return np.array(phi) - STEP


@pytest.mark.costly
def test_example_8_6(in_full):
    """Full-state feedback follows after the transition, with A_21 not quite right."""
    controller = IndirectController(indirect())
    error = flown(controller, 20_000 if in_full else 9_000)
    assert abs(error[5500:SWITCH]).max() < 1e-6
    assert 3.5 < abs(error[SWITCH:]).max() < 4.5  # the deviation that the text shows as a picture
    assert abs(error[-500:]).max() < (1e-8 if in_full else 1e-3)
    assert controller.theta[0] == pytest.approx(-1.0851, abs=1e-3)  # of -1.0880


@pytest.mark.costly
def test_example_8_7(in_full):
    """Output feedback follows too, after a larger deviation."""
    controller = IndirectController(indirect(**OUTPUT_FEEDBACK))
    error = flown(controller, 20_000 if in_full else 12_000, observed=True)
    assert abs(error[5500:SWITCH]).max() < 1e-5
    assert abs(error[SWITCH:]).max() > 20
    assert abs(error[-500:]).max() < (1e-8 if in_full else 1e-2)
    assert controller.theta[0] == pytest.approx(-1.060, abs=1e-2)


def test_without_identification_the_loop_diverges():
    controller = IndirectController(indirect(k_update=10**9))
    with np.errstate(all="ignore"):
        assert abs(flown(controller, 10_000)).max() > 1e6


def test_a_copy_goes_on_as_the_original():
    controller = IndirectController(indirect(**OUTPUT_FEEDBACK, k_identify=0))
    flown(controller, 300, observed=True)
    other = copy.deepcopy(controller)
    for k in range(20):
        assert np.array_equal(controller.step(0.01 * k, STEP), other.step(0.01 * k, STEP))


def body(A, B, observed):
    """A plant with the command r as its input w and z = r - phi."""
    C = np.eye(4)[3:] if observed else np.eye(4)
    zero = np.zeros((len(C), 1))
    return Plant(
        A=A, B=B, D_1=np.zeros((4, 1)), C=C, D_0=zero, D_2=zero,
        E_1=-np.eye(4)[3:], E_2=0, E_0=1, blocks={"r": 1},
    )  # fmt: skip


def aircraft(observed, switch=250):
    before, after = body(*BEFORE, observed), body(*AFTER, observed)
    return PlantSchedule(
        [PlantChange(start=0, plant=before), PlantChange(start=switch, plant=after)]
    )


def late(plant):
    parts = [{"start": 0}, {"start": 5, "delay": 1}]
    return PlantSchedule([PlantChange(plant=plant, **part) for part in parts])


both = pytest.mark.parametrize("observed", [False, True])


def settings_of(observed):
    return indirect(**(OUTPUT_FEEDBACK if observed else {}) | {"k_identify": 100})


@both
def test_simulate_is_a_loop_of_ones_own(observed):
    settings, r = settings_of(observed), np.full(600, STEP)
    run = simulate(aircraft(observed), settings, r, stride=7)
    controller, x = IndirectController(settings), np.zeros(4)
    u, z, theta = [], [], []
    for k in range(600):
        A, B = BEFORE if k < 250 else AFTER
        u.append(controller.step(x[3:] if observed else x, STEP))
        z.append(STEP - x[3])
        theta.append(controller.theta)
        x = A @ x + B @ u[-1]
    assert run.outcome == "completed" and run.settings == settings
    assert np.allclose(run.u, u, rtol=1e-9, atol=1e-12)
    assert np.allclose(run.z[:, 0], z, rtol=1e-9, atol=1e-12)
    assert np.allclose(run.theta, theta[::7], rtol=1e-9)
    assert np.allclose(run.theta_final, theta[-1], rtol=1e-9)


@pytest.mark.costly
@pytest.mark.exact_data  # bit for bit in two ways, whose intermediate results are read anew
@both
@pytest.mark.parametrize("cut", [1, 99, 101, 249, 250, 399])
def test_it_goes_on_bit_for_bit(observed, cut, tmp_path):
    """From a file too, before and after RCMR starts and the plant changes."""
    plant, settings, r = aircraft(observed), settings_of(observed), np.full(400, STEP)
    whole, first = simulate(plant, settings, r), simulate(plant, settings, r[:cut])
    first.state.save(tmp_path / "state.npz")
    rest = simulate(plant, settings, r[cut:], start=SavedState.load(tmp_path / "state.npz"))
    assert rest.first_step == cut
    for name in ("u", "y", "z", "theta"):
        joined = np.concatenate([getattr(first, name), getattr(rest, name)])
        assert np.array_equal(joined, getattr(whole, name))
    assert rest.state == whole.state


@both
def test_a_saved_run_is_loaded_and_goes_on(observed, tmp_path):
    run = simulate(aircraft(observed), settings_of(observed), np.full(150, STEP))
    run.save(tmp_path / "run.npz")
    again = load_run(tmp_path / "run.npz")
    assert again == run
    more = np.full(20, STEP)
    first, second = (simulate(r.plant, r.settings, more, start=r.state) for r in (run, again))
    assert first == second


def test_a_controller_of_ones_own_loop_is_saved_too():
    controller = IndirectController(settings_of(observed=True))
    flown(controller, 300, observed=True)
    state = controller.state
    ahead = [controller.step(0.01 * k, STEP) for k in range(5)]
    controller.restore(state)
    assert np.array_equal([controller.step(0.01 * k, STEP) for k in range(5)], ahead)
    with pytest.raises(InputError, match="other settings"):
        IndirectController(settings_of(observed=False)).restore(state)


def test_a_loop_that_diverges_ends_there():
    run = simulate(aircraft(False, 100), indirect(k_update=10**9), np.full(20_000, STEP))
    assert run.outcome == "diverged" and 100 < run.steps < 20_000 and run.state is None
    assert np.isfinite(run.z).all() and abs(run.z[-1, 0]) > 1e6


@pytest.mark.parametrize(
    ("run", "says"),
    [
        (lambda p, s, r: simulate_many([SimulationCase(p, s, r)]), "case 0: .*IndirectSettings"),
        (
            lambda p, s, r: simulate(p, s, r, saturation=Saturation(low=-1, high=1)),
            "does not support saturation",
        ),
        (lambda p, s, r: simulate(aircraft(True), s, r), "the plant has l_y = 1"),
        (lambda p, s, r: frozen_twin(simulate(p, s, r), 3), "has no freeze"),
        (lambda p, s, r: simulate(p, s, r).compensator, "no compensator of its theta alone"),
        (
            lambda p, s, r: simulate(
                late(p.first), s, r,
                start=simulate(p, s, r).state,
            ),
            "state_map or delay cannot be continued",
        ),
        (
            lambda p, s, r: simulate(p, s, r, start=simulate(aircraft(False, 9), s, r).state),
            "other settings",
        ),
    ],
)  # fmt: skip
def test_what_simulate_refuses(run, says):
    with pytest.raises(InputError, match=says):
        run(aircraft(False), indirect(), np.full(10, STEP))


def controller_of(**changes):
    return IndirectController(IndirectSettings(model(1), FOLLOWED, R_1=1, R_2=1, **changes))


@pytest.mark.parametrize(
    ("make", "error", "says"),
    [
        (lambda: controller_of(V_1=1), InputError, "both V_1 and V_2"),
        (lambda: IndirectSettings(model(1), [1, 0], 1, 1), InputError, "C_r has shape"),
        (
            lambda: IndirectSettings(
                model(1, subsystem=FIRSubsystem(2), theta_0=None), FOLLOWED, 1, 1
            ),
            InputError, "has dynamics; a static one",
        ),
        (
            lambda: IndirectSettings(model(1, theta_0=[0], A=np.diag([0.9, 0.8, 0.7, 0.6])),
                                       FOLLOWED, 1, 1, V_1=1, V_2=1),
            NotObservableError, "observes 1 of the 4 modes",
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
