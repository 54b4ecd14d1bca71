"""Every natural way to write a system, through every numeric function that takes a plant or a loop.

As in the exact half: each answers as for the canonical object, or refuses with an error of ours.
Numeric plants are sampled, so that the table is that in z; of that in s some rows are tried too,
which every door but `design` and the exact ones refuses.
"""

import inspect
import random
import warnings
from functools import cache

import numpy as np
import pytest

import rcac_numeric as rcac
from compensator_theory.errors import CompensatorError
from rcac_numeric.plants._linear import MATRICES
from tests.support.natural_inputs import REFUSED, system_inputs
from tests.support.numeric_doors import DOORS, PUBLIC

DRAWN = 12
WITH_VARIABLE = {"plant_of", "standard_plant", "servo_plant"}
"""The doors at which a variable can be named."""
READS_OTHERWISE = {
    "target_model": {  # lists are coefficients in ascending powers of 1/q there
        "pair of lists", "pair of tuples", "pair of arrays", "pair with leading zeros",
        "pair of Series", "three levels over one", "matrices of several", "a list of two lists",
        "two numbers", "constant rows", "rows as tuples",
    },
    "markov_target": {"two numbers"},
    "zero_direction_target": {"pair with leading zeros", "constant rows"},  # H itself
}  # fmt: skip
SYSTEMS = {"plant", "system", "G", "loop", "filter"}


def outcome(door, value, variable):
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return DOORS[door](value, variable)
    except CompensatorError as refusal:
        assert str(refusal)
        return None


@cache
def rows():
    of_s = [row for row in system_inputs("s") if row.name in ("text", "pair of lists", "SciPy")]
    return [*system_inputs("z"), *of_s]


@cache
def canonical_outcome(door, index):
    row = rows()[index]
    return REFUSED if row.canonical is REFUSED else outcome(door, row.canonical, row.variable)


def essence(answer):
    """What a float64 answer says; a plant's exact source and a basis are no part of it."""
    if isinstance(answer, rcac.Plant):
        return [getattr(answer, name) for name in MATRICES]
    if isinstance(answer, PUBLIC["TargetModel"]):
        return [answer.numerator, answer.denominator]
    if isinstance(answer, PUBLIC["Margins"]):
        bounds = answer.gain_up, answer.gain_down, answer.phase, answer.delay
        return [answer.is_stable, *(None if b is None else np.round(b.value, 6) for b in bounds)]
    if isinstance(answer, rcac.ClosedLoop):
        return [*essence(answer.plant), answer.compensator]
    return [answer]


def same(one, other):
    if one is None or other is None:
        return one is other
    pairs = zip(essence(one), essence(other), strict=True)
    return all(
        np.shape(a) == np.shape(b) and np.allclose(a, b, equal_nan=True)
        if isinstance(a, np.ndarray) else a == b
        for a, b in pairs
    )  # fmt: skip


def differs(door, index):
    row = rows()[index]
    if row.name in READS_OTHERWISE.get(door, ()) or (
        row.name == "another letter alone" and door not in WITH_VARIABLE
    ):
        return False
    received = outcome(door, row.make(), row.variable)
    return received is not None and not same(received, canonical_outcome(door, index))


def test_every_function_of_a_plant_or_a_loop_is_a_door_of_the_table():
    for name, function in PUBLIC.items():
        if inspect.isfunction(function):
            assert name in DOORS or not SYSTEMS & set(inspect.signature(function).parameters), name


@pytest.mark.costly
@pytest.mark.cases(14)
@pytest.mark.parametrize("door", sorted(DOORS))
def test_systems_are_read_alike_at_every_door(door, in_full):
    indices = range(len(rows()))
    drawn = indices if in_full else random.sample(indices, DRAWN)
    assert not [rows()[index].name for index in drawn if differs(door, index)]
