"""Public data are equal by content, and pickle to an equal object in a fresh process."""

import copy
import dataclasses
import inspect
import pickle
import re
import struct
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import rcac_numeric as rcac
from rcac_numeric.arrays.values import equal
from tests.rcac_numeric.samples import SAMPLES, SEEDS
from tests.support.estimation_samples import ESTIMATORS

PUBLIC = [getattr(rcac, name) for name in rcac.__all__]
CLASSES = [cls for cls in PUBLIC if inspect.isclass(cls)]
DATA_CLASSES = [cls for cls in CLASSES if dataclasses.is_dataclass(cls)]
# What runs, what it raises, and what all signals have in common.
NO_DATA = ESTIMATORS | {
    rcac.Controller, rcac.Simulator, rcac.Signal, rcac.RunInterrupted,
    rcac.ProgressLine, rcac.RecursiveARX, rcac.RecursiveMarkov, rcac.StoreError,
    rcac.RecursiveMuMarkov, rcac.StudyInterrupted, rcac.TargetLearner,
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
every_class = pytest.mark.parametrize("cls", SAMPLES, ids=lambda cls: cls.__name__)
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


@every_class
@few
@given(seed=seeds)
def test_it_pickles_to_an_equal_object_in_a_fresh_process(elsewhere, cls, seed):
    value = SAMPLES[cls](seed)
    assert type(value) is cls
    back, alike, text = elsewhere(value)
    assert alike and type(back) is cls
    assert back == value and value == back and hash(back) == hash(value)
    assert ADDRESS.sub("", text) == ADDRESS.sub("", repr(value))


@every_class
@few
@given(seed=seeds, other=seeds)
def test_it_is_equal_where_all_that_it_holds_is_equal(cls, seed, other):
    assume(seed != other)
    value, again, different = (SAMPLES[cls](s) for s in (seed, seed, other))
    assert value is not again
    assert value == again and hash(value) == hash(again)
    assert value != different
    assert value != "something else"
    for field in dataclasses.fields(cls):
        if not field.compare or equal(getattr(value, field.name), getattr(different, field.name)):
            continue
        twin = copy.copy(value)
        object.__setattr__(twin, field.name, getattr(different, field.name))
        assert twin != value and value != twin, field.name
