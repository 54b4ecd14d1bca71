"""Whatever Python calls numbers is read by `Controller.step` as the same ones, or refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory.errors import InputError
from rcac_numeric import UD, Controller, ControllerSettings, Supervision, TargetModel, iir

SETTINGS = ControllerSettings(
    structure=iir(n_c=2, l_y=2), target=TargetModel([0.0, 1.0]), update=UD(R_theta=1.0)
)
KINDS = {
    "list": list,
    "tuple": tuple,
    "float64": np.array,
    "float32": lambda v: np.array(v, dtype=np.float32),
    "float16": lambda v: np.array(v, dtype=np.float16),
    "int64": lambda v: np.array(v, dtype=np.int64),
    "int16": lambda v: np.array(v, dtype=np.int16),
    "uint8": lambda v: np.array(v, dtype=np.uint8),
    "strided": lambda v: np.repeat(np.array(v), 2)[::2],
    "big endian": lambda v: np.array(v, dtype=">f8"),
    "row": lambda v: np.array([v]),
    "scalars": lambda v: [np.float32(x) for x in v],
    "list of ints": lambda v: [int(x) for x in v],
}


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_numbers_makes_the_same_step(kind):
    first, second = Controller(SETTINGS), Controller(SETTINGS)
    for k in range(12):
        y, z = [float(k % 5), float(3 * k % 7)], float(k % 3)
        expected = first.step(np.array(y), np.array([z]))
        assert second.step(KINDS[kind](y), KINDS[kind]([z])) == expected
    assert np.array_equal(first.theta, second.theta)


@pytest.mark.parametrize(
    "y",
    [[1.0], [1.0, 2.0, 3.0], [1.0, float("nan")], (1.0, float("inf")), ["1", "x"], [1.0, None],
     [1.0, 1j], np.array([1.0, np.nan], dtype=np.float32), np.array([1 + 0j, 2]), 10**400,
     [1, 10**400], np.array(["a", "b"]), {1.0, 2.0}, None, int, [[1.0], [2.0, 3.0]]],
    ids=lambda y: repr(y)[:30],
)  # fmt: skip
def test_what_is_no_measurement_is_refused_and_nothing_moves(y):
    controller, untouched = (Controller(SETTINGS, Supervision("off")) for _ in range(2))
    for one in (controller, untouched):
        one.step([1.0, 2.0], 1.0)
    with pytest.raises(InputError):
        controller.step(y, 1.0)
    assert controller.state == untouched.state


@pytest.mark.parametrize(
    "y",
    [[True, False], np.array([True, False]), np.ma.array([True, False]), np.array([1j, 0]),
     np.ma.array([1j, 0]), np.ma.array(["1", "2"]), np.array([np.nan, np.nan, 1.0])],
    ids=repr,
)  # fmt: skip
def test_supervision_takes_only_numbers_and_gaps(y):
    controller, untouched = (Controller(SETTINGS, Supervision()) for _ in range(2))
    with pytest.raises(InputError, match=r"^y "):
        controller.step(y, 1.0)
    assert controller.state == untouched.state


@given(st.integers(-(2**63), 2**63 - 1))
def test_integers_are_read_as_float64_would_be(value):
    a, b = Controller(SETTINGS), Controller(SETTINGS)
    a.step(np.array([value, 0]), 0.0)
    b.step([float(value), 0.0], 0.0)
    assert a.state == b.state
