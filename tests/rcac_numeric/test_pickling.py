"""Public data are equal by content, and pickle to an equal object in a fresh process."""

import copy
import inspect
import pickle
import re
import struct
import subprocess
import sys
from dataclasses import is_dataclass
from pathlib import Path

import attrs
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import rcac_experiments
import rcac_numeric as rcac
from compensator_theory.errors import DivergedError
from rcac_experiments import sweeps
from rcac_numeric import identification
from rcac_numeric.arrays._values import equal, field_names
from tests.rcac_numeric.samples import SAMPLES, SEEDS
from tests.support.estimation_samples import ESTIMATORS
from tests.support.public import public_objects

PUBLIC = [
    value for p in ("rcac_numeric", "rcac_experiments") for value in public_objects(p).values()
]
CLASSES = [cls for cls in PUBLIC if inspect.isclass(cls)]
DATA_CLASSES = [cls for cls in CLASSES if attrs.has(cls) or is_dataclass(cls)]
# What runs, what it raises, and what all signals have in common.
NO_DATA = ESTIMATORS | {
    rcac.Controller, rcac.Simulator, rcac.Signal, rcac.RunInterrupted,
    sweeps.ProgressLine, identification.RecursiveARX, identification.RecursiveMarkov,
    identification.RecursiveMuMarkov, sweeps.StoreError, sweeps.StudyInterrupted,
    rcac.Recorder, rcac.SupervisionWarning, rcac.TargetLearner, rcac.results.ScheduledSteps,
}  # fmt: skip

FRESH = """
import pickle, struct, sys
while size := sys.stdin.buffer.read(8):
    data = sys.stdin.buffer.read(struct.unpack("Q", size)[0])
    value, again = pickle.loads(data), pickle.loads(data)
    alike = value == again and hash(value) == hash(again) and not value != again
    answer = pickle.dumps((value, alike, repr(value)))
    sys.stdout.buffer.write(struct.pack("Q", len(answer)) + answer)
    sys.stdout.buffer.flush()
"""

ADDRESS = re.compile(r" at 0x\w+")  # of a function
seeds = st.integers(0, SEEDS - 1)
DESIGNED = [rcac.results.Design, rcac_experiments.results.Tuned, rcac.results.LoggedPlant]
every_class = pytest.mark.parametrize(
    "cls", [cls for cls in SAMPLES if cls not in DESIGNED], ids=lambda cls: cls.__name__
)
few = settings(max_examples=8)


@pytest.fixture(scope="module")
def elsewhere():
    """Send an object through one process that has made nothing itself."""
    root = Path(__file__).parents[2]
    command = [sys.executable, "-c", FRESH]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=root
    ) as process:

        def sent(value):
            data = pickle.dumps(value)
            process.stdin.write(struct.pack("Q", len(data)) + data)
            process.stdin.flush()
            (size,) = struct.unpack("Q", process.stdout.read(8))
            return pickle.loads(process.stdout.read(size))

        yield sent
        process.stdin.close()


def test_every_public_data_class_has_a_sample():
    assert not set(DATA_CLASSES) - set(SAMPLES), "give it a line in tests/rcac_numeric/samples.py"
    assert set(CLASSES) - set(DATA_CLASSES) == NO_DATA


def pickles_elsewhere(elsewhere, cls, seed):
    value = SAMPLES[cls](seed)
    assert type(value) is cls
    back, alike, text = elsewhere(value)
    assert alike and type(back) is cls
    assert back == value and value == back and hash(back) == hash(value)
    assert ADDRESS.sub("", text) == ADDRESS.sub("", repr(value))


def compares(cls, seed, other):
    value, again, different = (SAMPLES[cls](s) for s in (seed, seed, other))
    assert value is not again
    assert value == again and hash(value) == hash(again)
    assert value != different
    assert value != "something else"
    for name in field_names(cls, compared=True):
        if equal(getattr(value, name), getattr(different, name)):
            continue
        twin = copy.copy(value)
        object.__setattr__(twin, name, getattr(different, name))
        assert twin != value and value != twin, name


@pytest.mark.costly
@pytest.mark.cases(50)
@every_class
@few
@given(seed=seeds)
def test_it_pickles_to_an_equal_object_in_a_fresh_process(elsewhere, cls, seed):
    pickles_elsewhere(elsewhere, cls, seed)


@pytest.mark.costly
@pytest.mark.cases(50)
@every_class
@few
@given(seed=seeds, other=seeds)
def test_it_is_equal_where_all_that_it_holds_is_equal(cls, seed, other):
    assume(seed != other)
    compares(cls, seed, other)


@pytest.mark.costly
@pytest.mark.cases(1)
@pytest.mark.parametrize("cls", DESIGNED, ids=lambda cls: cls.__name__)
def test_what_takes_seconds_to_design_does_so_once(elsewhere, cls):
    pickles_elsewhere(elsewhere, cls, 3)
    compares(cls, 3, 4)


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
    made = rcac.Controller(
        rcac.ControllerSettings(
            structure=rcac.iir(2), target=rcac.fir_target(plant), update=rcac.UD(1.0)
        )
    )
    for y in range(5):
        made.step(y, y)
    return made


def _learner():
    return rcac.TargetLearner(mu=6, n_mod=2, order=2, window=40)


def _scheduled():
    compensator = rcac.Compensator(past_u=[[[0.5]]], past_y=[[[1.0]], [[0.5]]])
    made = rcac.GainSchedule([0, 1], [compensator] * 2).started()
    for y in range(5):
        made.step([y])
    return made


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
    rcac.TargetLearner: (_learner, lambda learner: (learner.windows, vars(learner))),
}
OTHERWISE = [  # another's data
    rcac.Signal, rcac.RunInterrupted, sweeps.ProgressLine, sweeps.StoreError,
    sweeps.StudyInterrupted, rcac.SupervisionWarning, rcac.Recorder,
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
