"""What a user may do to a controller or to a saved state by mistake does no silent harm."""

import copy
import pickle
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory import InputError
from compensator_theory.errors import DivergedError, FunctionFailedError
from rcac_numeric.arrays._values import replaced as replace

SETTINGS = rn.ControllerSettings(
    structure=rn.iir(2), target=rn.TargetModel([0, 1.0]), update=rn.UD(R_theta=1.0)
)
PLANT = rn.standard_plant("1/(q - 0.9)")
SCHEDULE = rn.PlantSchedule(
    [
        rn.PlantChange(start=0, plant=PLANT),
        rn.PlantChange(start=5, plant=rn.standard_plant("1/(q - 1/2)"), delay=3),
    ]
)
RULES = [
    {},
    {"update": rn.SlidingWindow(R_theta=1.0, window=7)},
    {
        "update": rn.UD(
            R_theta=1.0,
            lambda_=rn.VariableRateForgetting(3, 9, 0.1),
            reset=rn.CovarianceReset(at=[3, 30], growth=1.5),
        )
    },
    {"target_changes": {5: rn.TargetModel([0, 2.0])}, "k_filter": 3, "freeze": [(3, 6)]},
]


def driven(settings, steps=9):
    controller = rn.Controller(settings)
    for k in range(steps):
        controller.step(k % 3, k % 2)
    return controller


@pytest.mark.parametrize(
    "duplicate", [copy.copy, copy.deepcopy, lambda c: pickle.loads(pickle.dumps(c))]
)
def test_a_copy_is_a_controller_of_its_own(duplicate):
    original = driven(SETTINGS)
    twin = duplicate(original)
    before = original.theta
    u = twin.step(1.0, 1.0)
    assert original.k == 9 and twin.k == 10 and (original.theta == before).all()
    assert (original.step(1.0, 1.0) == u).all() and (original.theta == twin.theta).all()


@pytest.mark.parametrize("act", ["step", "restore", "freeze", "state", "reset_covariance"])
def test_a_weight_cannot_drive_its_own_controller(act):
    acts = {
        "step": lambda c: c.step(1.0, 1.0),
        "restore": lambda c: c.restore(start),
        "freeze": lambda c: c.freeze(),
        "state": lambda c: c.state,
        "reset_covariance": lambda c: c.reset_covariance(),
    }

    def weight(k, y, z, u):
        acts[act](controller)
        return 0.0

    controller = rn.Controller(replace(SETTINGS, R_u=weight))
    start = controller.state
    with pytest.raises(FunctionFailedError, match="is executing a step"):
        for _ in range(5):
            controller.step(1.0, 1.0)


def test_a_step_that_was_interrupted_is_not_gone_on_from():
    def weight(k, y, z, u):
        if k == 4:
            raise KeyboardInterrupt
        return 0.0

    controller = rn.Controller(replace(SETTINGS, R_u=weight))
    for _ in range(4):
        controller.step(1.0, 1.0)
    good = controller.state
    with pytest.raises(KeyboardInterrupt):
        controller.step(1.0, 1.0)
    for use in (lambda: controller.step(1.0, 1.0), lambda: controller.state):
        with pytest.raises(DivergedError, match="was interrupted"):
            use()
    controller.restore(good)
    assert controller.k == 4


@pytest.mark.parametrize(
    "update",
    [rn.SlidingWindow(R_theta=1.0, window=3), rn.Instantaneous(R_theta=1.0), rn.Gradient(0.1)],
)
def test_only_a_covariance_can_be_reset(update):
    controller = rn.Controller(replace(SETTINGS, update=update))
    with pytest.raises(InputError, match="has no covariance to reset"):
        controller.reset_covariance()


@pytest.mark.parametrize("rules", RULES)
@given(st.data())
def test_no_damaged_state_reaches_beyond_an_array(rules, data):
    """Any word of a state may hold anything: it is refused, or it is a number like another."""
    settings = replace(SETTINGS, **rules)
    w = np.ones((9, 1))
    for state, resume in (
        (
            driven(settings).state,
            lambda s: (c := rn.Controller(settings)).restore(s) or c.step(1, 1),
        ),
        (
            rn.simulate(SCHEDULE, settings, w).state,
            lambda s: rn.simulate(SCHEDULE, settings, w, start=s),
        ),
    ):
        bits = state.values.view(np.int64).copy()
        place = data.draw(st.integers(0, len(bits) - 1))
        bits[place] = data.draw(
            st.sampled_from([-1, 7, 10, 2**31, 2**40, 2**62, -(2**62)])
            | st.integers(-(2**63), 2**63 - 1)
        )
        damaged = bits.view(np.float64)
        if damaged.tobytes() != state.values.tobytes():
            with pytest.raises(InputError, match="damaged: it was changed after it was saved"):
                resume(replace(state, values=damaged))
        with suppress(
            InputError, DivergedError, rn.SupervisionWarning
        ):  # by one who knows the checksum, too
            resume(rn.SavedState.of_values(state.kind, state.k, damaged, state.fingerprint))


@pytest.mark.parametrize("values", ["abc", [1.0, 2.0], None, np.ones(3, int), np.ones((3, 1))])
def test_the_values_of_a_state_are_an_array(values):
    state = driven(SETTINGS).state
    with pytest.raises(InputError, match="instead of a float64 array"):
        rn.Controller(SETTINGS).restore(replace(state, values=values))


def test_a_state_that_cannot_be_written_is_named(tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        driven(SETTINGS).state.save(tmp_path / "no folder" / "state.npz")


def test_a_frozen_twin_starts_where_the_run_did():
    x_0 = np.array([1.0])
    run = rn.simulate(PLANT, SETTINGS, np.ones((30, 1)), x_0=x_0, divergence_limit=50.0)
    x_0[0] = 100.0
    twin = rn.frozen_twin(run, 30)
    assert (twin.z == run.z).all() and twin.divergence_limit == 50.0


CROWDED = """
import resource
import numpy as np
from rcac_numeric import SimulationCase, simulate, simulate_many
from tests.support.lane_cases import GOOD, PLANT
cases = [SimulationCase(PLANT, GOOD, np.ones((50, 1)))] * 300
simulate(PLANT, GOOD, np.ones((50, 1)))  # everything is loaded
size = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (size + 2**27, size + 2**27))
print({run.outcome for run in simulate_many(cases, threads=300)})
"""


@pytest.mark.costly
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs Linux's resource limits")
def test_a_system_that_gives_no_more_threads():
    """Sixteen stacks of 8 MiB fit where 300 are asked for."""
    process = subprocess.run(
        [sys.executable, "-c", CROWDED], capture_output=True, text=True, check=False
    )
    assert process.stdout.strip() == "{'completed'}", process.stderr


def test_a_w_of_another_width_is_told_its_columns():
    plant = rn.servo_plant("1/(q - 0.5)")
    with pytest.raises(InputError, match=r"\(steps, 3\) is needed.*: r, d, v"):
        rn.simulate(plant, rn.FixedController("1/q"), np.ones((50, 1)))
