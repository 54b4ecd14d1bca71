"""Controllers on a plant: a log that survives the process, limits in the step, a takeover."""

import signal
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory.errors import InputError

PLANT = rn.standard_plant("1/(q - 0.9)")
SETTINGS = rn.ControllerSettings(
    structure=rn.iir(n_c=2), target=rn.fir_target(PLANT), update=rn.UD(1.0)
)

KILLED = """
import os, signal, sys
import numpy as np
from rcac_numeric import *
plant = standard_plant("1/(q - 0.9)")
settings = ControllerSettings(structure=iir(n_c=2), target=fir_target(plant), update=UD(1.0))
recorder, x = Recorder(Controller(settings), sys.argv[1]), 0.0
rng = np.random.default_rng(0)
for k in range(500):
    (u,) = recorder.step(x, x)
    x = 0.9 * x + u + rng.standard_normal()
os.kill(os.getpid(), signal.SIGKILL)
"""


FULL = """
import resource, sys, warnings
import numpy as np
from rcac_numeric import *
plant = standard_plant("1/(q - 0.9)")
settings = ControllerSettings(structure=iir(n_c=2), target=fir_target(plant), update=UD(1.0))
bare = Controller(settings)
resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    with Recorder(Controller(settings), sys.argv[1]) as recorder:
        for k in range(100):
            assert recorder.step(np.sin(k), np.sin(k)) == bare.step(np.sin(k), np.sin(k))
assert len(caught) == 1 and "The controller goes on" in str(caught[0].message)
assert recorder.failure
"""


def driven(one, steps, seed=0):
    rng, x, us = np.random.default_rng(seed), 0.0, []
    for _ in range(steps):
        u = float(one.step(x, x)[0])
        us.append(u)
        x = 0.9 * x + u + rng.standard_normal()
    return np.array(us)


@pytest.mark.costly
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no SIGKILL")
def test_a_killed_process_leaves_a_log_that_can_be_checked(tmp_path):
    path = tmp_path / "log.csv"
    done = subprocess.run([sys.executable, "-c", KILLED, str(path)], check=False)
    assert done.returncode == -signal.SIGKILL
    log = rn.read_log(path)
    assert log.steps == 499
    check = rn.check_controller(log, structure=SETTINGS.structure, plant=PLANT)
    assert check.is_consistent and check.loop.is_stable
    assert np.array_equal(log.u[:, 0], driven(rn.Controller(SETTINGS), 499))


@pytest.mark.costly
@pytest.mark.skipif(sys.platform == "win32", reason="no limit of a file's size")
def test_a_full_disk_leaves_whole_rows_and_takes_no_u(tmp_path):
    path = tmp_path / "log.csv"
    done = subprocess.run(
        [sys.executable, "-c", FULL, str(path)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    lines = path.read_text().splitlines(keepends=True)
    assert 1 < len(lines) < 100 and lines[-1].endswith("\n")
    assert len({line.count(",") for line in lines}) == 1
    assert rn.read_log(path).steps == len(lines) - 1


def test_a_log_holds_what_was_applied_and_what_was_missed(tmp_path):
    path = tmp_path / "log.csv"
    with rn.Recorder(rn.Controller(SETTINGS), path) as recorder:
        recorder.step(1.0, 1.0)
        recorder.step(2.0, 2.0, u_applied=0.5)
        recorder.step(float("nan"), float("nan"))
    with pytest.raises(InputError, match="is closed"):
        recorder.step(1.0, 1.0)
    rows = np.genfromtxt(path, delimiter=",", names=True)
    assert rows["u"][0] == 0.5 and rows["y"].tolist() == [1.0, 2.0, 2.0]
    assert rows["missed"].tolist() == [0, 0, 1]
    with pytest.raises(InputError, match="cannot be written"):
        rn.Recorder(rn.Controller(SETTINGS), path)


@given(
    seed=st.integers(0, 2**32 - 1), low=st.floats(-2, 0), high=st.floats(0, 2),
    rise=st.floats(0.05, 2), fall=st.floats(0.05, 2),
)  # fmt: skip
def test_u_keeps_to_its_limits_and_the_regressor_knows(seed, low, high, rise, fall):
    limits = rn.ControlLimits(low=low, high=high, rise=rise, fall=fall)
    controller = rn.Controller(SETTINGS, limits=limits)
    us = driven(controller, 60, seed)
    assert (us >= low).all() and (us <= high).all()
    steps = np.diff(us, prepend=0.0)
    assert (steps <= rise + 1e-12).all() and (steps >= -fall - 1e-12).all()
    # The same with a saturation outside that is told, one step late.
    outside, x, applied = rn.Controller(SETTINGS), 0.0, None
    rng, other = np.random.default_rng(seed), []
    for _ in range(60):
        value = float(outside.step(x, x, u_applied=applied)[0])
        last = 0.0 if applied is None else applied
        applied = min(max(min(max(value, last - fall), last + rise), low), high)
        other.append(applied)
        x = 0.9 * x + applied + rng.standard_normal()
    assert us == pytest.approx(np.array(other), rel=1e-9, abs=1e-9)


def test_every_column_of_a_wide_log_has_its_name(tmp_path):
    path, rng = tmp_path / "log.csv", np.random.default_rng(0)
    structure = rn.iir(1, 2, 3)
    target = rn.TargetModel([np.zeros((1, 2)), [[1.0, 0.5]]])
    settings = rn.ControllerSettings(structure=structure, target=target, update=rn.UD(1.0))
    with rn.Recorder(rn.Controller(settings), path) as recorder:
        applied = [recorder.step(rng.standard_normal(3), [1.0]) for _ in range(5)]
    names = path.read_text().splitlines()[0].split(",")
    assert len(set(names)) == len(names) == 2 + 3 + 1 + structure.l_theta + 1
    assert {"u[0]", "u[1]", "y[2]", "z", "missed"} <= set(names)
    log = rn.read_log(path)
    assert np.array_equal(log.u, applied) and log.y.shape == (5, 3)


def test_limits_are_saved_and_checked():
    limits = rn.ControlLimits(rise=0.1)
    one, two = rn.Controller(SETTINGS, limits=limits), rn.Controller(SETTINGS, limits=limits)
    driven(one, 30)
    two.restore(one.state)
    assert one.step(1.0, 1.0) == two.step(1.0, 1.0)
    with pytest.raises(InputError, match="other settings"):
        rn.Controller(SETTINGS).restore(one.state)
    for supervision in (rn.Supervision(), rn.Supervision("bound")):  # of other limits, or of none
        one = rn.Controller(SETTINGS, supervision=supervision, limits=limits)
        for other in (rn.ControlLimits(rise=0.2), None):
            with pytest.raises(InputError, match="other settings"):
                rn.Controller(SETTINGS, supervision=supervision, limits=other).restore(one.state)
    for wrong, words in (
        ({}, "low, high"),
        ({"low": 1, "high": 0}, "exceeds"),
        ({"fall": 0}, "positive"),
    ):
        with pytest.raises(InputError, match=words):
            rn.ControlLimits(**wrong)
    with pytest.raises(InputError, match="l_u = 1"):
        rn.Controller(SETTINGS, limits=rn.ControlLimits(low=[0.0, 1.0]))


def test_a_takeover_has_no_bump():
    controller = rn.Controller(SETTINGS)
    us = driven(controller, 50)
    controller.take_over(us[-1] + 3.0, fade=0.5)
    twin = rn.Controller(SETTINGS)
    driven(twin, 50)
    requested, applied = float(twin.step(1.0, 1.0)[0]), float(controller.step(1.0, 1.0)[0])
    assert applied == pytest.approx(us[-1] + 3.0) and abs(requested - applied) > 0.1
