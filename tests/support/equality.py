"""Tests of data with samples: equal by content, and pickled to an equal object elsewhere.

Each function here makes a test for the classes of a package and their samples, a function from a
seed below `SEEDS` to a value; a module of tests gives it its name.
"""

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
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rcac_numeric.arrays._values import LINES, WIDTH, Value, equal, field_names
from tests.support.public import public_objects

SEEDS = 100_000  # seeds are below
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


def classes_of(package):
    """The public classes of a package: those that are data, and the others."""
    every = {cls for cls in public_objects(package).values() if inspect.isclass(cls)}
    data = {cls for cls in every if attrs.has(cls) or is_dataclass(cls)}
    return data, every - data


def pickles_elsewhere(elsewhere, cls, value):
    assert type(value) is cls
    back, alike, text = elsewhere(value)
    assert alike and type(back) is cls
    assert back == value and value == back and hash(back) == hash(value)
    assert ADDRESS.sub("", text) == ADDRESS.sub("", repr(value))


def compares(cls, sample, seed, other):
    value, again, different = (sample(s) for s in (seed, seed, other))
    assert value is not again
    assert value == again and hash(value) == hash(again)
    # Of few options two seeds may draw the same.
    assert value != different or repr(value) == repr(different)
    assert value != "something else"
    for name in field_names(cls, compared=True):
        if equal(getattr(value, name), getattr(different, name)):
            continue
        twin = copy.copy(value)
        object.__setattr__(twin, name, getattr(different, name))
        assert twin != value and value != twin, name


def each_of(samples):
    return pytest.mark.parametrize("cls", samples, ids=lambda cls: cls.__name__)


def pickling_of(samples, cases):
    """The test that pickles, of so many of its classes in a run."""

    @pytest.mark.costly
    @pytest.mark.cases(cases)
    @each_of(samples)
    @settings(max_examples=8)
    @given(seed=seeds)
    def test(elsewhere, cls, seed):
        pickles_elsewhere(elsewhere, cls, samples[cls](seed))

    return test


def equality_of(samples, cases):
    """The test that compares, of so many of its classes in a run."""

    @pytest.mark.costly
    @pytest.mark.cases(cases)
    @each_of(samples)
    @settings(max_examples=8)
    @given(seed=seeds, other=seeds)
    def test(cls, seed, other):
        assume(seed != other)
        compares(cls, samples[cls], seed, other)

    return test


def both_once(samples):
    """The test of what takes seconds to make, with one sample."""

    @pytest.mark.costly
    @pytest.mark.cases(1)
    @each_of(samples)
    def test(elsewhere, cls):
        pickles_elsewhere(elsewhere, cls, samples[cls](3))
        compares(cls, samples[cls], 3, 4)

    return test


def printing_of(samples, cases):
    """The test that data print as their repr or field by field."""
    plain = {
        cls: sample
        for cls, sample in samples.items()
        if issubclass(cls, Value) and cls.__str__ is Value.__str__
    }

    @pytest.mark.costly
    @pytest.mark.cases(cases)
    @each_of(plain)
    @settings(max_examples=3)
    @given(seed=seeds)
    def test(cls, seed):
        value = plain[cls](seed)
        text = str(value)
        if text == repr(value) and len(text) <= WIDTH and "\n" not in text:
            return
        assert len(text.splitlines()) <= LINES
        first, *rest = value.overview().splitlines()
        assert first == cls.__name__
        shown = [line.split()[0] for line in rest if re.match(r"  \S", line)]
        stored = [name for name in field_names(cls) if getattr(value, name) is not None]
        assert set(shown) <= set(stored) and shown == sorted(shown, key=stored.index) and shown
        assert max(map(len, rest)) <= 2 * WIDTH

    return test
