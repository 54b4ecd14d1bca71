"""Everything public pickles, and unpickles to an equal object in a process that never saw it."""

import dataclasses
import inspect
import pickle
import struct
import subprocess
import sys

import pytest
import sympy
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import compensator_theory as exact
from tests.support.public import public_objects

from .samples import POLYS, SAMPLES, SYMBOLIC_POLYS

PUBLIC = [*public_objects("compensator_theory").values()]
DATA_CLASSES = [cls for cls in PUBLIC if inspect.isclass(cls) and dataclasses.is_dataclass(cls)]
ERRORS = [cls for cls in PUBLIC if inspect.isclass(cls) and issubclass(cls, Exception)]

OTHER_PROCESS = """
import pickle, struct, sys
while size := sys.stdin.buffer.read(8):
    value = pickle.loads(sys.stdin.buffer.read(struct.unpack("Q", size)[0]))
    answer = pickle.dumps((value, repr(value), str(value)))
    sys.stdout.buffer.write(struct.pack("Q", len(answer)) + answer)
    sys.stdout.buffer.flush()
"""


@pytest.fixture(scope="module")
def elsewhere():
    """Send an object through a fresh process; it has computed nothing, so that no cache helps."""
    command = [sys.executable, "-c", OTHER_PROCESS]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:

        def sent(value):
            data = pickle.dumps(value)
            process.stdin.write(struct.pack("Q", len(data)) + data)
            process.stdin.flush()
            (size,) = struct.unpack("Q", process.stdout.read(8))
            return pickle.loads(process.stdout.read(size))

        yield sent
        process.stdin.close()


def test_every_public_data_class_has_a_sample():
    assert set(DATA_CLASSES) == set(SAMPLES)


@pytest.mark.cases(40)
@pytest.mark.parametrize("cls", DATA_CLASSES, ids=lambda cls: cls.__name__)
@settings(max_examples=8, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_a_result_survives(elsewhere, cls, data):
    value = data.draw(SAMPLES[cls])
    assert type(value) is cls
    back, representation, text = elsewhere(value)
    assert type(back) is cls and back == value
    assert (representation, text) == (repr(value), str(value))
    assert dataclasses.replace(back) == value
    for field in dataclasses.fields(cls):
        remaining = getattr(back, field.name)
        if isinstance(remaining, sympy.Poly):
            assert remaining.domain == getattr(value, field.name).domain


@given(poly=POLYS | SYMBOLIC_POLYS)
def test_an_unpickled_polynomial_is_read_at_every_door(elsewhere, poly):
    back, _, _ = elsewhere(poly)
    assert exact.polynomial(back) == poly
    assert exact.monic(back) == exact.monic(poly)


@pytest.mark.parametrize("cls", ERRORS, ids=lambda cls: cls.__name__)
def test_an_error_survives(elsewhere, cls):
    back, _, text = elsewhere(cls("what was wrong"))
    assert type(back) is cls and back.args == ("what was wrong",) and text == "what was wrong"


def test_functions_are_found_by_name(elsewhere):
    for function in filter(inspect.isfunction, PUBLIC):
        assert elsewhere(function)[0] is function
