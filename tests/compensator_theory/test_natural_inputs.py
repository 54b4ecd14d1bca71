"""Every natural way to write an input, through every public function that takes one.

Each answers as for the canonical object, or refuses with an error of ours: no other answer, and no
other error. The functions and the places of their arguments are found by their annotations, so that
a new function is held to the same. Of the product a draw is run each time, all of it under
`--long`.
"""

import inspect
import random
from functools import cache

import pytest

import compensator_theory as exact
from tests.support.bad_inputs import GOOD
from tests.support.natural_inputs import REFUSED, polynomial_inputs, system_inputs
from tests.support.public import public_objects

PUBLIC = public_objects("compensator_theory")
SYSTEMS = ("TransferFunctionLike", "TransferMatrixLike", "RealisationLike", "LoopPart")
POLYNOMIALS = ("PolynomialLike", "PolynomialOrSystem")
DRAWN = 9
"""Rows of a table that are tried at a door in each run."""

_G, _D, _CUBIC = "(s + 5)/(s**2 + 3*s + 2)", "s**2 + 3*s + 2", "s**3 + 2*s + 1"
_STATES = exact.Realisation([[0, 1], [-2, -3]], [[0], [1]], [[5, 1]])
FITTING = {
    "place_poles": ([_G, [-3, -4, -5]], {"feedback": -1}),
    "place_matrix_poles": ([_G, [[-3, -4, -5]], 1], {"feedback": -1}),
    "decouple": ([_STATES], {}),
    "observer_forms": ([_G, "-1/(s + 9)"], {"feedback": 1}),
    "youla_forms": ([_G, "-24/((s + 1)*(s + 7))"], {"feedback": 1}),
    "lqg_problem": ([_STATES, [[1, 0], [0, 1]], [[1]], [[1, 0], [0, 1]], [[1]]], {}),
    "compensator_from_sensitivity": ([_G, "s/(s + 5)"], {"feedback": -1}),
    "solve_diophantine": (["s**3 + 7", "s + 7", "s**3"], {}),
    "spectral_factor": (["s + 7", _CUBIC, 3], {"time": "continuous"}),
    "check_proposition_3": ([_CUBIC, "s + 5", 2, 1], {}),
    "check_proposition_4": ([_CUBIC, "s + 5", 2, 1], {}),
    "sylvester_m": ([_CUBIC, "s + 5", 2, 1], {}),
}
"""Calls that suit the plant of the table better than those of tests/support/bad_inputs.py."""


READS_OTHERWISE = {
    "canonical": (
        "two letters",
        "a complex text",
        "two numbers",
        "dead time",
    ),  # no system
    **dict.fromkeys(
        ("certified_roots", "count_roots", "decide_stability", "stability_conditions"),
        ("a complex coefficient",),
    ),
    "partial_fractions": ("a complex text",),
    "stability_margins": ("dead time",),
    "sylvester_m1": ("a list with a leading zero",),  # which counts in the formal degree
    "sylvester_m2": ("a list with a leading zero",),
}
"""Rows that mean something else at one door, by its definition."""


def doors(kinds):
    """The functions that take such an input, with the places of these arguments."""
    for name, function in PUBLIC.items():
        if not inspect.isfunction(function) or name not in GOOD:
            continue
        for place, parameter in enumerate(inspect.signature(function).parameters.values()):
            count = len(FITTING.get(name, GOOD[name])[0])
            kind = str(parameter.annotation)
            is_one = not kind.startswith("Sequence") and any(one in kind for one in kinds)
            if place < count and is_one:
                yield name, place


def outcome(name, place, value, variable):
    """The answer, or None where it is refused; another error comes out."""
    function, (arguments, keywords) = PUBLIC[name], FITTING.get(name, GOOD[name])
    arguments, keywords = [*arguments], {**keywords}
    arguments[place] = value
    takes = "variable" in inspect.signature(function).parameters
    by_place = len(arguments) > 1 and list(inspect.signature(function).parameters)[1] == "variable"
    if variable is not None and takes and not by_place:
        keywords["variable"] = variable
    try:
        return function(*arguments, **keywords)
    except exact.CompensatorError as refusal:
        assert str(refusal)
        return None


@cache
def tables():
    polynomials = {x: polynomial_inputs(x) for x in "sz"}
    systems = {x: system_inputs(x) for x in "sz"}
    of_z = [
        row for row in systems["z"] if any(name in row.name for name in ("dt", "SciPy", "sampled"))
    ]
    return polynomials["s"], [*systems["s"], *of_z]


@cache
def canonical_outcome(name, place, table, index):
    row = tables()[table][index]
    known = place > 0 or "s" in FITTING.get(name, GOOD[name])[0]  # by the other arguments
    canonical = row.beside if row.canonical is REFUSED and known else row.canonical
    if canonical is REFUSED:
        return REFUSED
    return outcome(name, place, canonical, row.variable)


def differences(name, place, table, indices):
    """Rows that are answered otherwise than their canonical object; and how many are answered."""
    wrong, answers = [], 0
    for index in indices:
        row = tables()[table][index]
        received = outcome(name, place, row.make(), row.variable)
        if received is None:
            continue
        answers += 1
        if received != canonical_outcome(name, place, table, index) and row.name not in (
            READS_OTHERWISE.get(name, ())
        ):
            wrong.append(row.name)
    return wrong, answers


def draw(table, name, place, in_full):
    indices = range(len(tables()[table]))
    return indices if in_full else random.sample(indices, DRAWN)


@pytest.mark.parametrize("x", "sz")
def test_each_row_is_what_it_says(x):
    """And no row is only ever refused."""
    rows = polynomial_inputs(x), system_inputs(x)
    assert sum(row.canonical is not REFUSED for row in [*rows[0], *rows[1]]) > 60
    for row in rows[0]:
        assert outcome("polynomial", 0, row.make(), row.variable) == row.canonical, row.name
    for row in rows[1]:
        read = "realisation" if isinstance(row.canonical, exact.Realisation) else "transfer_matrix"
        expected = row.canonical and PUBLIC[read](row.canonical)
        assert outcome(read, 0, row.make(), row.variable) == expected, row.name


@pytest.mark.costly
@pytest.mark.cases(25)
@pytest.mark.parametrize(("name", "place"), sorted(doors(SYSTEMS)))
def test_systems_are_read_alike_at_every_door(name, place, in_full):
    wrong, _ = differences(name, place, 1, draw(1, name, place, in_full))
    assert not wrong


@pytest.mark.costly
@pytest.mark.cases(12)
@pytest.mark.parametrize(("name", "place"), sorted(doors(POLYNOMIALS)))
def test_polynomials_are_read_alike_at_every_door(name, place, in_full):
    wrong, _ = differences(name, place, 0, draw(0, name, place, in_full))
    assert not wrong
