"""A masked sample of NumPy is a missed one, as NaN is; without supervision both are refused."""

import numpy as np
import pytest

import rcac_numeric as rn
from compensator_theory import InputError

SETTINGS = rn.ControllerSettings(
    structure=rn.iir(1), target=rn.TargetModel([0, 1.0]), update=rn.UD(1.0), k_w=2
)
MASKED = [np.ma.masked, np.ma.masked_array([5.0], mask=[True]),
          np.ma.masked_array([5], mask=[True]),
          [np.ma.masked], np.ma.masked_equal(-9999.0, -9999.0)]  # fmt: skip
Y = np.random.default_rng(0).standard_normal(12)


def theta_after(controller, gap):
    for k, y in enumerate(Y):
        sample = gap if k in (5, 8) else y
        controller.step(y=sample, z=sample)
    return getattr(controller, "controller", controller).theta.copy()


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("masked", MASKED, ids=repr)
def test_a_masked_sample_is_a_missed_one(masked):
    expected = theta_after(rn.Controller(SETTINGS), np.nan)
    assert np.array_equal(theta_after(rn.Controller(SETTINGS), masked), expected)
    assert not np.array_equal(theta_after(rn.Controller(SETTINGS), 5.0), expected)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("masked", MASKED, ids=repr)
def test_without_supervision_it_is_refused_and_nothing_has_moved(masked):
    controller = rn.Controller(SETTINGS, supervision=rn.Supervision(policy="off"))
    controller.step(y=1.0, z=1.0)
    before = controller.k, controller.theta.copy()
    with pytest.raises(InputError):
        controller.step(y=masked, z=1.0)
    assert controller.k == before[0] and np.array_equal(controller.theta, before[1])


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("signal", ["y", "z", "r"])
def test_a_masked_sample_of_one_signal_is_a_missed_one(signal):
    """The two others are plain numbers, which the kernel reads by itself."""
    settings = rn.ControllerSettings(
        structure=rn.feedforward(1), target=rn.TargetModel([0, 1.0]), update=rn.UD(1.0), k_w=2
    )
    ends = []
    for gap in (np.nan, np.ma.masked_array([5.0], mask=[True]), 5.0):
        controller = rn.Controller(settings)
        for k, value in enumerate(Y):
            samples = {"y": value, "z": value, "r": 1.0}
            controller.step(**samples | ({signal: gap} if k in (5, 8) else {}))
        ends.append(controller.state.values.tobytes())
    assert ends[0] == ends[1] != ends[2]


def test_unmasked_arrays_step_as_plain_ones():
    plain, other = rn.Controller(SETTINGS), rn.Controller(SETTINGS)
    for y in Y:
        one = plain.step(y=y, z=y)
        assert one == other.step(y=np.ma.masked_array([y], mask=[False]), z=np.ma.masked_array([y]))


@pytest.mark.filterwarnings("ignore")
def test_a_recorder_logs_a_masked_sample_as_a_missed_one(tmp_path):
    logs = []
    for gap in (np.nan, np.ma.masked_array([5.0], mask=[True])):
        path = tmp_path / f"{len(logs)}.csv"
        with rn.Recorder(rn.Controller(SETTINGS), path) as recorder:
            theta_after(recorder, gap)
        logs.append(path.read_text())
    assert logs[0] == logs[1]


def test_a_log_says_where_its_masked_rows_are():
    y = np.ma.masked_equal(np.where(np.arange(20) % 7 == 6, -9999.0, 1.0), -9999.0)
    with pytest.raises(InputError, match=r"y has 2 gaps .*the first at step 6"):
        rn.ControllerLog(np.ones(20), y)
    integers = np.ma.masked_equal(np.where(np.arange(20) == 3, -9999, 1), -9999)
    with pytest.raises(InputError, match=r"u has 1 gaps .*the first at step 3"):
        rn.ControllerLog(integers, np.ones(20))
