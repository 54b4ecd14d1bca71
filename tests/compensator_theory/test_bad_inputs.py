"""Bad input at every public function: refused in our own words, before any work is done for it.

What a door can use is in tests/support/bad_inputs.py, and so is what it cannot. Each argument is
replaced by every bad input under `--long`, and by a draw otherwise. Some of them are inputs that a
door can use and that take work: those may take more.
"""

import inspect
import random
from contextlib import nullcontext

import numpy as np
import pytest
import scipy.sparse
import sympy

import compensator_theory as exact
from tests.support.bad_inputs import BAD, GOOD, LAST_ARGUMENTS, NOT_DOORS
from tests.support.public import public_objects
from tests.support.work import Endless, Long, at_most, at_most_bytes

# An endless list is read as far as the budget of entries goes, a call for each, and no farther.
CALLS_TO_REFUSE = exact.Budget().entries + 300_000
CALLS_TO_ANSWER, BYTES = 20_000_000, 50_000_000
ENOUGH, DRAWN = 50, 3
PUBLIC = public_objects("compensator_theory")


def functions():
    return {name for name in PUBLIC if name[0].islower()} - NOT_DOORS


def refuses(door, arguments, keywords, memory=nullcontext):
    """Tell whether it refuses; fail where another error comes out, or it costs too much."""
    with at_most(CALLS_TO_ANSWER) as work, memory():
        try:
            door(*arguments, **keywords)
        except exact.CompensatorError as error:
            assert str(error) and len(str(error)) <= 1600
            assert work.made <= CALLS_TO_REFUSE
            return True
    return False


def test_every_public_function_is_a_door_of_the_table():
    missing, unknown = functions() - set(GOOD), set(GOOD) - functions()
    assert not missing, f"a line in tests/support/bad_inputs.py is due for {sorted(missing)}"
    assert not unknown, f"{sorted(unknown)} in tests/support/bad_inputs.py are no public functions"


@pytest.mark.costly
@pytest.mark.cases(70)
@pytest.mark.parametrize("name", sorted(GOOD))
def test_bad_inputs_are_refused(name, in_full):
    door, (arguments, keywords) = PUBLIC[name], GOOD[name]
    door(*arguments, **keywords)
    draw = random.Random(name)
    for place in range(len(arguments)):
        bad = BAD if in_full else [Long(10**7), Endless(), *draw.sample(BAD, DRAWN)]
        refused = [
            refuses(door, [*arguments[:place], value, *arguments[place + 1 :]], keywords)
            for value in bad
        ]
        if in_full and place == 0:
            assert sum(refused) >= ENOUGH


@pytest.mark.costly
@pytest.mark.parametrize("name", ["canonical", "kronecker_form", "smith_form"])
def test_refusals_stay_small(name):
    door, (arguments, keywords) = PUBLIC[name], GOOD[name]
    door(*arguments, **keywords)
    for place in range(len(arguments)):
        for value in BAD:
            argument = [*arguments[:place], value, *arguments[place + 1 :]]
            refuses(door, argument, keywords, lambda: at_most_bytes(BYTES))


SETTINGS = [np.zeros((2, 2, 2)), scipy.sparse.eye(2), {1: 2}, [10**5000], 10**30, Long(10**7)]


@pytest.mark.costly
@pytest.mark.parametrize("name", sorted(GOOD))
def test_bad_settings_end_in_no_foreign_error(name):
    door, (arguments, keywords) = PUBLIC[name], GOOD[name]
    for setting, parameter in list(inspect.signature(door).parameters.items())[len(arguments) :]:
        for value in random.Random(name + setting).sample(SETTINGS, 3):
            if parameter.kind is parameter.VAR_POSITIONAL:
                refuses(door, [*arguments, value], keywords)
            else:
                refuses(door, arguments, keywords | {setting: value})


@pytest.mark.costly
@pytest.mark.parametrize(("name", "argument"), sorted(LAST_ARGUMENTS))
def test_last_arguments_are_read_as_strictly(name, argument):
    door, (arguments, keywords) = PUBLIC[name], GOOD[name]
    place = list(inspect.signature(door).parameters).index(argument)
    for value in LAST_ARGUMENTS[name, argument]:
        refuses(door, arguments[:place], keywords | {argument: value})


def test_the_step_is_no_variable_and_its_exponentials_are_not_endless():
    for step in ("s", "z"):
        with pytest.raises(
            exact.InputError, match="is the variable of a plant and cannot also be the step"
        ):
            exact.sampling.zero_order_hold("1/(s + 1)", step)
    with pytest.raises(exact.errors.BudgetError, match="exponential of a pole with this step"):
        exact.sampling.zero_order_hold("1/(s + 1)", 10**50 * sympy.log(2))
    with exact.budget(digits=40_000):
        fine = exact.sampling.zero_order_hold("1/(s + 1)", 50_000 * sympy.log(2))
    assert fine.realisation.A[0, 0] == sympy.Integer(2) ** -50_000


@pytest.mark.parametrize("letters", ["12", b"12", {1: 3, 2: 4}])
def test_letters_and_keys_are_no_list(letters):
    with pytest.raises(exact.InputError, match="must be a list"):
        exact.loops.direction_residual([["(q - 2)/q", 0], [0, "1/q"]], 2, letters)


@pytest.mark.costly
@pytest.mark.parametrize(
    ("limits", "door", "value"),
    [({"degree": 3000, "terms": 3000}, exact.polynomial, "(s + 1)**2000"),
     ({"degree": 3000}, exact.canonical, "s**2000"),
     ({"digits": 9000}, exact.exact_number, 10**5000),
     ({"nesting": 200}, exact.parse_expression, "(" * 100 + "s" + ")" * 100),
     ({"characters": 90_000}, exact.parse_expression, "s+" * 30_000 + "1"),
     ({"terms": 5000}, exact.parse_expression, "(a + b + c + s)**22"),
     ({"degree": 1001}, lambda count: exact.markov_parameters("1/(s + 1)", count), 1002),
     ({"field_degree": 32}, exact.parse_expression,
      "sqrt(2 + sqrt(2 + sqrt(2 + sqrt(2 + sqrt(3)))))")],
    ids=map(str, range(8)),
)  # fmt: skip
def test_the_budget_refuses_and_can_be_raised(limits, door, value):
    with pytest.raises(exact.errors.BudgetError, match=next(iter(limits))):
        door(value)
    with exact.budget(**limits):
        assert door(value) is not None


@pytest.mark.parametrize("limit", [0, -1, 1.5, True, "9", None, float("nan"), [3]])
def test_a_limit_is_a_positive_integer(limit):
    with pytest.raises(exact.InputError, match="positive integer"), exact.budget(degree=limit):
        pass


LONG = "1/(s + 1/10**40)**3"


@pytest.mark.parametrize(
    ("call", "subject"),
    [
        (lambda: exact.stability_margins(LONG, feedback=-1), "the frequencies of the margins"),
        (lambda: exact.stabilising_gains(LONG, feedback=-1), "the gains that stabilise"),
        (lambda: exact.spectral_factor("(z - 3/10**40)**3", "z**3"), "the spectral factor"),
        (lambda: exact.stability_region("s**4/10**20 + a*s**2 + b*s + 1", "a", "b"), "the region"),
        (lambda: exact.transition_matrix([[0, 1], [-20, -30]]), "the transition matrix"),
        (
            lambda: exact.forms.row_reduced_form([["s**2", 1, 1], ["s", 0, 2], [1, "s", 0]]),
            "row-reduced",
        ),
    ],
)
def test_work_that_grows_with_degree_and_digits_is_refused_before_it_begins(call, subject):
    with exact.budget(entries=10), pytest.raises(exact.errors.BudgetError, match=subject):
        call()
