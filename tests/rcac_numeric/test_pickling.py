"""Public data are equal by content, and pickle to an equal object in a fresh process."""

import copy
import pickle

import numpy as np
import pytest

import rcac_numeric as rcac
from compensator_theory.errors import DivergedError
from rcac_numeric import identification
from rcac_numeric.arrays._values import equal
from tests.rcac_numeric.samples import SAMPLES
from tests.support.equality import (  # noqa: F401
    both_once,
    classes_of,
    elsewhere,
    equality_of,
    pickling_of,
)
from tests.support.estimation_samples import ESTIMATORS

DATA_CLASSES, OTHERS = classes_of("rcac_numeric")
# What runs, what it raises, and what all signals have in common.
NO_DATA = ESTIMATORS | {
    rcac.Controller, rcac.Simulator, rcac.Signal, rcac.RunInterrupted,
    identification.RecursiveARX, identification.RecursiveMarkov, identification.RecursiveMuMarkov,
    rcac.Recorder, rcac.SupervisionWarning, rcac.TargetLearner, rcac.results.ScheduledSteps,
    rcac.PredictiveCostController,
}  # fmt: skip
FROM_LOGS = ("LoggedPlant", "LoggedMatrix", "ProcessModel", "StepResponse")
SLOW = {cls: SAMPLES[cls] for cls in (getattr(rcac.results, n) for n in ("Design", *FROM_LOGS))}
QUICK = {cls: sample for cls, sample in SAMPLES.items() if cls not in SLOW}


def test_every_public_data_class_has_a_sample():
    assert not DATA_CLASSES - set(SAMPLES), "give it a line in tests/rcac_numeric/samples.py"
    assert OTHERS == NO_DATA


test_it_pickles_to_an_equal_object_in_a_fresh_process = pickling_of(QUICK, cases=45)
test_it_is_equal_where_all_that_it_holds_is_equal = equality_of(QUICK, cases=45)
test_what_takes_seconds_to_design_does_so_once = both_once(SLOW)


def _fit(cls, **settings):
    fit = cls(**settings)
    fit.update(*_noise(60, 2))
    return fit


def _markov():
    fit = identification.RecursiveMarkov(l_u=1, l_y=1, mu=3, n_mod=2)
    for u, z in _noise(2, 40):
        fit.update(u, z)
    return fit


def _noise(steps, width):
    return np.random.default_rng(3).standard_normal((width, steps))


def _simulator():
    after = rcac.standard_plant("1/(q*(q - 0.5))")
    changes = [
        rcac.PlantChange(start=start, plant=after, delay=delay, state_map=mapped)
        for start, delay, mapped in ((0, 2, None), (4, 1, [[0, 1], [1, 0]]), (6, 0, None))
    ]
    body = rcac.Simulator(rcac.PlantSchedule(changes), x_0=[1.0, -1.0])
    for u in range(4):
        body.advance(u, 0)
    return body


def _controller():
    plant = rcac.standard_plant("1/(q - 0.5)")
    controller = rcac.Controller(
        rcac.ControllerSettings(
            structure=rcac.iir(2), target=rcac.fir_target(plant), update=rcac.UD(1.0)
        )
    )
    for y in range(5):
        controller.step(y, y)
    return controller


def _learner():
    return rcac.TargetLearner(mu=6, n_mod=2, order=2, window=40)


def _predictive():
    controller = rcac.PredictiveCostController(
        rcac.PredictiveCost(order=2, horizon=3, lambda_=0.99)
    )
    for k in range(5):
        controller.step(0.5**k)
    return controller


def _scheduled():
    compensator = rcac.Compensator(past_u=[[[0.5]]], past_y=[[[1.0]], [[0.5]]])
    schedule = rcac.GainSchedule([0, 1], [compensator] * 2).started()
    for y in range(5):
        schedule.step([y])
    return schedule


# What holds a compiled object or moves: how it is made, and what the next steps of it say.
LIVE = {
    rcac.Simulator: (
        _simulator,
        lambda body: [(body.output(k, 0), body.advance(k, 0), body.x) for k in range(9)],
    ),
    identification.RecursiveARX: (
        lambda: _fit(identification.RecursiveARX, order=3, lambda_=0.99),
        lambda fit: (fit.update(*_noise(20, 2)), fit.k, fit.a, fit.b, fit.P, fit.variance),
    ),
    identification.RecursiveMuMarkov: (
        lambda: _fit(identification.RecursiveMuMarkov, mu=3, n_mod=2),
        lambda fit: (fit.update(*_noise(20, 2)), fit.k, fit.H, fit.a, fit.b, fit.P),
    ),
    identification.RecursiveMarkov: (
        _markov,
        lambda fit: ([fit.update(u, z) for u, z in _noise(2, 30)], fit.H, fit.standard_error),
    ),
    rcac.Controller: (_controller, lambda made: [made.step(k, -k) for k in range(9)]),
    rcac.results.ScheduledSteps: (
        _scheduled,
        lambda made: ([made.step([k]) for k in range(9)], made.k, made.theta),
    ),
    rcac.PredictiveCostController: (
        _predictive,
        lambda made: ([made.step(k) for k in range(9)], made.k, made.theta, made.covariance),
    ),
    rcac.TargetLearner: (_learner, lambda learner: (learner.windows, vars(learner))),
}
OTHERWISE = [  # another's data
    rcac.Signal, rcac.RunInterrupted, rcac.SupervisionWarning, rcac.Recorder,
]  # fmt: skip


def test_every_live_class_is_copied_here():
    assert set(LIVE) == NO_DATA - set(OTHERWISE) - ESTIMATORS  # tests/rcac_numeric/estimation


@pytest.mark.costly
@pytest.mark.parametrize("cls", LIVE, ids=lambda cls: cls.__name__)
@pytest.mark.parametrize(
    "copied",
    [copy.copy, copy.deepcopy, lambda value: pickle.loads(pickle.dumps(value))],
    ids=["copy", "deepcopy", "pickle"],
)
def test_a_copy_goes_on_by_itself_bit_for_bit(cls, copied):
    make, later = LIVE[cls]
    original = make()
    twin = copied(original)
    assert type(twin) is cls and twin is not original
    first = later(twin)
    assert equal(first, later(original)), "the original moved with its copy, or otherwise"


@pytest.mark.parametrize("before", [0, 1], ids=["between steps", "within a step"])
def test_a_plant_with_delays_is_copied_wherever_it_stands(before):
    original = _simulator()
    for _ in range(before):
        original.output(7.0, 0.0)
    twin = copy.copy(original)
    for k in range(6):
        assert equal(twin.output(k, 0.0), original.output(k, 0.0))
        twin.advance(k, 0.0), original.advance(k, 0.0)
        assert equal(twin.x, original.x)


@pytest.mark.parametrize("make", [
    lambda: identification.RecursiveARX(order=2),
    lambda: identification.RecursiveMuMarkov(mu=2, n_mod=1),
])  # fmt: skip
def test_a_fit_that_left_float64_is_not_copied(make):
    fit = make()
    with pytest.raises(DivergedError):
        fit.update(np.full(50, 1e200), np.full(50, -1e200))
    with pytest.raises(DivergedError, match="make a new one"):
        copy.copy(fit)
