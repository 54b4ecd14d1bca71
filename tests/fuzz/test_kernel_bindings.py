"""The compiled module called directly, with arguments that fit, nearly fit and do not fit at all.

Whatever is given, it answers or raises one of three exceptions. That nothing is read or written
out of bounds meanwhile is for the sanitizers to say: .ci/sanitize runs this file under them.
"""

from datetime import datetime_CAPI  # a capsule, and no function

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcac_numeric.compiled import _kernel
from tests.support.kernel_arguments import (
    SIZES,
    controller_arguments,
    damaged,
    damaged_state,
    perhaps_damaged,
    plant_arguments,
    python_plant_arguments,
    seeds,
)
from tests.support.kernel_calls import attempt


def use_controller(draw, controller, l_u, l_y, l_z, l_r):
    """Steps, changes and damaged states in any order."""
    sizes = {"y": np.full(l_y, 0.3), "z": np.full(l_z, 0.2), "r": np.zeros(l_r)}
    sizes["u_applied"] = np.zeros(draw(st.sampled_from([0, l_u])))
    for _ in range(draw(st.integers(1, 12))):
        deed = draw(st.integers(0, 7))
        if deed <= 3:
            attempt(controller.step, **(perhaps_damaged(draw, sizes) if deed == 3 else sizes))
        elif deed == 4:
            attempt(controller.restore, damaged_state(draw, controller.save()))
        elif deed == 5:
            attempt(controller.freeze, damaged(draw, True))
        elif deed == 6:
            attempt(controller.reset_covariance)
        else:
            n = len(controller.theta)
            assert controller.P.shape == (n, n)
            assert controller.k >= 0
            assert controller.guard_count >= 0 and controller.guard_first_step >= -1


@given(SIZES, st.integers(0, 2), st.data())
def test_controllers(sizes, l_r, data):
    l_u, l_y, l_z, *_ = sizes
    arguments = perhaps_damaged(data.draw, controller_arguments(data.draw, l_u, l_y, l_z, l_r))
    controller = attempt(_kernel.controller, **arguments)
    if controller is not None:
        use_controller(data.draw, controller, l_u, l_y, l_z, l_r)


@given(SIZES, st.integers(0, 2), st.data())
def test_arguments_that_fit_are_taken(sizes, l_r, data):
    """Else the other tests would show nothing."""
    l_u, l_y, l_z, *_ = sizes
    controller = _kernel.controller(**controller_arguments(data.draw, l_u, l_y, l_z, l_r))
    controller.restore(controller.save())
    controller.step(np.zeros(l_y), np.zeros(l_z), np.zeros(l_r), None)
    assert controller.k == 1
    _kernel.linear_plant(**plant_arguments(data.draw, *sizes))


@given(SIZES, st.booleans(), st.data())
def test_plants(sizes, linear, data):
    make = _kernel.linear_plant if linear else _kernel.python_plant
    expected = plant_arguments if linear else python_plant_arguments
    plant = attempt(make, **perhaps_damaged(data.draw, expected(data.draw, *sizes)))
    if plant is None:
        return
    row = {"k": data.draw(st.integers(0, 12)), "u": np.ones(sizes[0]), "w": np.ones(sizes[4])}
    for _ in range(data.draw(st.integers(1, 8))):
        move = data.draw(st.sampled_from([plant.output, plant.advance]))
        attempt(move, **perhaps_damaged(data.draw, row))
        assert plant.x.ndim == 1


@given(st.data())
def test_compiled_functions_are_capsules_of_their_signature(data):
    good = {"sizes": (1, 1, 1, 1, 1), "advance": datetime_CAPI, "output": datetime_CAPI}
    with pytest.raises(ValueError, match="a compiled function has the signature"):
        _kernel.compiled_plant(**good, x_0=np.zeros(1))
    arguments = perhaps_damaged(data.draw, {**good, "x_0": np.zeros(1)})
    assert attempt(_kernel.compiled_plant, **arguments) is None


def closed_loop(draw, sizes, l_r):
    """A loop, perhaps of several controllers, with up to three arguments damaged."""
    l_u, l_y, l_z, _, l_w = sizes
    linear = draw(st.integers(0, 3)) > 0
    make = _kernel.linear_plant if linear else _kernel.python_plant
    body = make(**(plant_arguments if linear else python_plant_arguments)(draw, *sizes))
    parts = [
        _kernel.controller(**controller_arguments(draw, l_u, l_y, l_z, l_r))
        for _ in range(draw(st.sampled_from([1, 1, 1, 2])))
    ]
    bounds = l_u * draw(st.integers(0, 1))
    arguments = {
        "controllers": parts,
        "plant": body,
        "low": np.full(bounds, -1.0),
        "high": np.full(bounds, 1.0),
        "rate": np.full(bounds, 0.5),
        "limit": 1e100,
        "stop_where_unsupported": draw(st.booleans()),
        "shared_u": draw(st.booleans()),
        "r_in_w": l_w - l_r,
    }
    return attempt(_kernel.Loop, **perhaps_damaged(draw, arguments))


def record(loop, draw, sizes, steps):
    """A job on the loop, with up to three arrays damaged."""
    l_u, l_y, l_z, _, l_w = sizes
    stride, l_theta = draw(st.integers(1, 4)), len(loop.theta_before())
    arguments = {
        "loop": loop,
        "w": np.full((steps, l_w), 0.1),
        "u": np.zeros((steps, l_u)),
        "u_applied": draw(st.sampled_from([None, np.zeros((steps, l_u))])),
        "y": np.zeros((steps, l_y)),
        "z": np.zeros((steps, l_z)),
        "theta": np.zeros((-(-steps // stride), l_theta)),
        "stride": stride,
    }
    return attempt(_kernel.Job, **perhaps_damaged(draw, arguments))


@given(SIZES, st.integers(0, 1), st.data())
def test_loops_and_jobs(sizes, l_r, data):
    sizes = (*sizes[:4], max(sizes[4], l_r))
    loops = [closed_loop(data.draw, sizes, l_r) for _ in range(data.draw(st.integers(1, 3)))]
    loops = [loop for loop in loops if loop is not None]
    jobs = [record(loop, data.draw, sizes, data.draw(st.integers(0, 30))) for loop in loops]
    jobs = [job for job in jobs if job is not None]
    for _ in range(data.draw(st.integers(1, 8))):
        if loops and data.draw(st.booleans()):
            loop = data.draw(st.sampled_from(loops))
            attempt(loop.restore, damaged_state(data.draw, loop.save()))
        arguments = {
            "jobs": jobs,
            "threads": data.draw(st.integers(0, 2)),
            "seconds": data.draw(st.sampled_from([0.0, 1e-5, 1e-3, 0.05])),
            "lanes": data.draw(st.booleans()),
            "instruction_set": data.draw(st.sampled_from(["", *_kernel.instruction_sets()])),
        }
        attempt(_kernel.run_jobs, **perhaps_damaged(data.draw, arguments))
        for job in jobs:
            assert job.done >= 0 and 0 <= job.outcome <= 5


@given(st.booleans(), st.integers(1, 12), st.integers(1, 3), st.data())
def test_replays(in_lanes, l_theta, l_z, data):
    rng, lanes = np.random.default_rng(data.draw(seeds)), _kernel.lanes
    name = data.draw(st.sampled_from(["", *_kernel.instruction_sets()]))
    if in_lanes:
        arguments = {
            "Phi_f": rng.standard_normal((4, l_theta, lanes)),
            "target": rng.standard_normal((4, lanes)),
            "P_0": np.array([np.eye(l_theta)] * lanes),
            "theta_0": np.zeros((l_theta, lanes)),
        }
    else:
        arguments = {
            "update": data.draw(st.sampled_from(["ud", "covariance"])),
            "Phi_f": rng.standard_normal((4, l_z, l_theta)),
            "target": rng.standard_normal((4, l_z)),
            "R_z": np.eye(l_z),
            "R_u": np.zeros((l_z, l_z)),
            "P_0": np.eye(l_theta),
            "theta_0": np.zeros(l_theta),
        }
    arguments.update(forgetting=0.99, instruction_set=name)
    replay = _kernel.replay_ud_lanes if in_lanes else _kernel.replay_updates
    replay(**arguments)
    attempt(replay, **perhaps_damaged(data.draw, arguments))


@pytest.mark.parametrize("update", ["sliding window", "joint"])
def test_rows_that_an_update_has_no_room_for(update):
    """Found by .ci/sanitize: the rows of a penalty that came later were written beyond a window."""

    def made():
        one = np.eye(1)
        return _kernel.controller(
            l_u=1, l_y=1, l_r=0, l_z=1, derived=[], regressor=[(0, 1), (1, 1)],
            channels=[(0, 0), (0, 1), (1, 1)], filtered=[(1, 0), (2, 0)],
            targets=[(np.ones((2, 1, 1)), np.array([[[1.0]], [[0.0]]]))], R_z=one, R_u=0 * one,
            forgetting_factor=1.0, k_w=0, k_update=0, k_filter=0, filter_form=False,
            reflect_poles=False, events=[], forgetting=(0, 0, 0.0, 1.0),
            reset=(0, 0.0, 0.0, 1, 2), noise=np.zeros(0), update=update, P_0=np.eye(2),
            theta_0=np.zeros(2), window=3, step_size=1.0,
        )  # fmt: skip

    controller = made()
    with pytest.raises(ValueError, match="no room"):
        controller.set_weights(2 * np.eye(1), None, np.eye(1))
    for k in range(6):
        controller.step(np.ones(1), np.full(1, float(k)), np.zeros(0), None)
    unchanged = made()
    for k in range(6):
        unchanged.step(np.ones(1), np.full(1, float(k)), np.zeros(0), None)
    np.testing.assert_array_equal(controller.theta, unchanged.theta)
    for place in range(len(state := controller.save())):
        other = state.copy()
        other[place] = 0.75
        attempt(controller.restore, other)
        controller.step(np.ones(1), np.ones(1), np.zeros(0), None)
