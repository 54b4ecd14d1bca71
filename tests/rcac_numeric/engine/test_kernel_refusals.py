"""What the compiled module refuses when it is called directly, and what a refusal leaves behind."""

import threading

import numpy as np
import pytest

from rcac_numeric.compiled import _kernel
from tests.support.kernel_arguments import segment


class Surprise(Exception):
    """What a function of the user may raise."""


def good_arguments(**changes):
    """A controller with one tap on u and y, as keyword arguments."""
    one = np.ones((1, 1))
    return {
        **{"l_u": 1, "l_y": 1, "l_r": 0, "l_z": 1, "derived": []},
        **{"regressor": [(0, 1), (1, 1)], "channels": [(0, 0), (1, 0)]},
        **{"filtered": [(0, 1), (1, 1)], "targets": [(np.array([0.0, 1.0]), np.array([1.0, 0.0]))]},
        **{"R_z": one, "R_u": 0 * one, "forgetting_factor": 1.0, "k_w": 1, "k_update": 1},
        **{"k_filter": 0, "filter_form": False, "reflect_poles": False, "events": []},
        **{"forgetting": (0, 0, 0.0, 1.0), "reset": (0, 0.0, 0.0, 1, 2), "noise": np.zeros(0)},
        **{"update": "ud", "P_0": np.eye(2), "theta_0": np.zeros(2), "window": 0, "step_size": 0.0},
        **changes,
    }


def good_loop(controllers=None, plant=None):
    sizes, none = (1, 1, 1, 1, 1), np.zeros(0)
    matrices = segment(np.random.default_rng(0), *sizes)
    return _kernel.Loop(
        controllers=controllers or [_kernel.controller(**good_arguments())],
        plant=plant or _kernel.linear_plant(sizes, [(0, matrices, False, none, 0)], np.zeros(1)),
        **{"low": none, "high": none, "rate": none, "limit": 1e100},
        **{"stop_where_unsupported": False, "shared_u": True, "r_in_w": 0},
    )


def good_job(loop, steps=20):
    column = lambda width=1: np.zeros((steps, width))  # noqa: E731
    return _kernel.Job(loop, column(), column(), None, column(), column(), column(2), 1)


def all_of(jobs, **options):
    while _kernel.run_jobs(jobs, 2, 0.05, **options):
        pass


@pytest.mark.parametrize("deed", ["step", "restore", "run", "raise", "wrong shape", "none"])
def test_a_weight_may_do_anything_but_move_its_own_controller(deed):
    """A function that a step calls finds the controller half-way, and is refused there."""
    message, calls = [], []

    def weight(k, y, z, u):
        calls.append(k)
        if calls.count(3) == 1 and k == 3:
            try:
                return reactions[deed]()
            except ValueError as error:
                message.append(str(error))
        return np.eye(1)

    def surprise():
        raise Surprise

    controller = _kernel.controller(**good_arguments(R_z=weight))
    loop = good_loop([controller])
    job, zero, state = good_job(loop), np.zeros(1), controller.save()
    reactions = {
        "step": lambda: controller.step(zero, zero, None, None),
        "restore": lambda: controller.restore(state),
        "run": lambda: all_of([job]),
        "raise": surprise,
        "wrong shape": lambda: np.zeros(5),
        "none": lambda: None,
    }
    if deed in ("raise", "wrong shape"):
        with pytest.raises((Surprise, ValueError)):
            all_of([job])
        assert (job.done, job.outcome) == (3, 4)  # ended there
        assert not _kernel.run_jobs([job], 1, 0.0)
    else:
        all_of([job], lanes=True)
        assert (job.done, job.outcome) == ((3, 2) if deed == "none" else (20, 0))
        assert message == ([] if deed == "none" else [message[0]])
        assert all("in the middle of a step" in text for text in message)
    loop.restore(loop.save())
    controller.step(zero, zero, None, None)


def test_what_is_at_work_elsewhere_is_refused():
    entered, leave = threading.Event(), threading.Event()

    def advance(k, x, u, w):
        entered.set()
        leave.wait(10)
        return x

    sizes = (1, 1, 1, 1, 1)
    plant = _kernel.python_plant(sizes, advance, lambda k, x, w: (x, x), np.zeros(1))
    controller = _kernel.controller(**good_arguments())
    loop = good_loop([controller], plant)
    job, state, zero = good_job(loop, 3), loop.save(), np.zeros(1)
    worker = threading.Thread(target=all_of, args=([job],))
    worker.start()
    assert entered.wait(10)
    for act in (
        lambda: loop.restore(state),
        loop.save,
        lambda: _kernel.run_jobs([good_job(loop)], 1, 0.0),
        lambda: controller.step(zero, zero, None, None),
        lambda: plant.advance(0, zero, zero),
        lambda: plant.x,
    ):
        with pytest.raises(ValueError, match="in the middle of a step"):
            act()
    leave.set()
    worker.join()
    assert (job.done, job.outcome) == (3, 0)
    loop.restore(state)


def test_a_refused_state_leaves_the_loop_as_it_was():
    one, two = good_loop(), good_loop()
    jobs = [good_job(one), good_job(two)]
    for cut in (0, 1, 5, -1):
        with pytest.raises(ValueError):
            one.restore(one.save()[: cut or 0])
    all_of(jobs)
    assert np.array_equal(one.save().view(np.int64), two.save().view(np.int64))


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"l_u": 0, "P_0": np.zeros((0, 0)), "theta_0": np.zeros(0)}, "l_u is 0"),
        ({"l_z": 0}, "l_z is 0"),
        ({"regressor": [], "filtered": []}, "the regressor is empty"),
        ({"channels": [(1, 0)], "filtered": [(0, 0), (0, 1)]}, "channel 0 is not that entry of u"),
        ({"targets": []}, "no target model"),
        ({"targets": [(np.zeros(0), np.zeros(0))]}, "no coefficient"),
        ({"update": "sliding window"}, "window is 0"),
        ({"update": "sliding window", "window": 2**40}, "window is 1099511627776"),
        ({"regressor": [(0, 2**62), (1, 1)]}, "regressor would need more than"),
        ({"reflect_poles": True, "regressor": [(0, 0), (1, 1)]}, "in its own regressor"),
        ({"events": [(1, "target", np.inf)]}, "no such target model"),
        ({"events": [(9, "reset", 0.0), (1, "reset", 0.0)]}, "not in order"),
        ({"k_update": -(2**63)}, "k_update is -9223372036854775808"),
        ({"noise": np.zeros(3)}, "noise: 3 numbers"),
        ({"R_z": "one"}, "R_z is not a matrix"),
    ],
)
def test_refusals_are_sentences(changes, sentence):
    with pytest.raises((ValueError, TypeError), match=sentence):
        _kernel.controller(**good_arguments(**changes))


def test_objects_that_are_none():
    loop, controller = good_loop(), _kernel.controller(**good_arguments())
    for act in (
        lambda: good_loop([None]),
        lambda: good_loop([controller, controller]),
        lambda: good_job(None),
        lambda: _kernel.run_jobs([None], 1, 0.0),
        lambda: _kernel.run_jobs([good_job(loop)] * 2, 1, 0.0),
        lambda: _kernel.run_jobs([good_job(loop)], 1, float("nan")),
        lambda: good_loop(plant=controller),
    ):
        with pytest.raises((ValueError, TypeError)):
            act()
