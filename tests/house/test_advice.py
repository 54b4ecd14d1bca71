"""A message advises what can be done: keywords that the function has, functions that exist.

Every public function of the exact half gets every malformed input at every place of its call in
tests/support/bad_inputs.py, those of the numeric half in tests/support/numeric_doors.py. A draw of
the inputs is tried in each run, all of them under `--long`.
"""

import inspect
import random
import re
import warnings
from functools import cache

import numpy as np
import pytest
import sympy

import compensator_theory as exact
import rcac_numeric as rcac
from compensator_theory.errors import CompensatorError
from tests.support.advice import known, wrong_advice
from tests.support.bad_inputs import GOOD
from tests.support.example_calls import doors, is_array
from tests.support.numeric_doors import DOORS as NUMERIC
from tests.support.public import public_objects

s, a, T, z = sympy.symbols("s a T z")
INPUTS = {
    "open bracket": "1/(s", "a space": "2/(10 s + 1)", "a pair": ([2], [10, 1]), "a list": [1, 2],
    "poly1d": np.poly1d([1, 2]), "exp in a text": "exp(-s)/(s + 1)", "exp": sympy.exp(-s * T) / s,
    "exp with its time": sympy.exp(-2 * s) / (s + 1), "a quotient": "1/(s + 1)", "PD": "s**2 + 1",
    "two letters": "(s + z)/(s + p)", "a mask": np.ma.masked_array([1.0, 2.0], [0, 1]),
    "a sampled plant": exact.sampling.zero_order_hold("1/(s + 1)", "T"),
    "one with numbers": exact.sampling.zero_order_hold("1/(s + 1)", "1/2"),
    "a symbol": "1/(a*s + 1)", "a root": "1/(sqrt(2)*z + 3)", "e": 1 / (z - sympy.exp(-1)),
    "unstable": "1/(s*(s - 1))", "one": "1", "a letter": "a", "a cube": np.zeros((2, 2, 2)),
    "a dict": {"a": 1}, "None": None, "a matrix": [[1, 2], [3, 4]], "a row": [[1, 2, 3]],
    "texts": [["1/s", "1/z"]], "deep": [[[1, 2]]], "complex": [1, 2j], "two texts": ("s", "z"),
    "with dt": ([1], [1, 2], 0.5), "matrices": ([[0]], [[1]], [[1]]), "sin": "sin(a)/s",
    "long": np.ma.masked_array(np.zeros(500), [0, 1] * 250), "NaN": [float("nan")] * 300,
}  # fmt: skip
LONGEST = 700  # characters
TABLE = known()
EXACT = public_objects("compensator_theory")
ARRAYS = {k: v for k, v in doors("rcac_numeric", is_array).items() if inspect.isfunction(v[0])}


def refusal(call):
    """The message of an error of ours; None for an answer. Another error comes out."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            call()
    except CompensatorError as error:
        return str(error)
    return None


def drawn(name, in_full):
    names = sorted(INPUTS)
    return names if in_full else random.Random(name).sample(names, 6)


def advice(name, door, call, chosen):
    """What is wrong in what is said to a call with each of these inputs."""
    wrong = []
    for one in chosen:
        message = refusal(lambda one=one: call(INPUTS[one]))
        if message is not None:
            wrong += [f"{name}({one}): {w}: {message}" for w in wrong_advice(message, door, TABLE)]
            if len(message) > LONGEST:
                wrong.append(f"{name}({one}) says {len(message)} characters")
    return wrong


@pytest.mark.parametrize("name", sorted(GOOD))
def test_what_an_exact_function_advises_can_be_done(name, in_full):
    arguments, keywords = GOOD[name]
    for place in range(len(arguments)):

        def call(argument, place=place):
            return EXACT[name](*[*arguments[:place], argument, *arguments[place + 1 :]], **keywords)

        assert not advice(name, EXACT[name], call, drawn(f"{name}{place}", in_full))


@cache
def numeric_names():
    return public_objects("rcac_numeric")


@pytest.mark.parametrize("name", sorted(NUMERIC))
def test_what_a_numeric_function_advises_of_a_system_can_be_done(name, in_full):
    door = numeric_names()[name.partition(".")[0]]
    chosen = [*{*drawn(name, in_full), "a pair", "a quotient", "a mask"}]
    assert not advice(name, door, lambda argument: NUMERIC[name](argument, None), chosen)


@pytest.mark.parametrize("name", sorted(ARRAYS))
def test_what_a_numeric_function_advises_of_arrays_can_be_done(name, in_full):
    door, call, arrays = ARRAYS[name]
    for array in arrays:

        def given(value, array=array):
            return door(**{**call, array: value})

        chosen = [*{*drawn(f"{name}{array}", in_full)[:3], "long", "NaN"}]
        assert not advice(name, door, given, chosen)


def test_wrong_advice_is_found():
    door = exact.place_poles
    assert wrong_advice("name it, as in variable='s'", exact.is_controllable, TABLE)
    assert wrong_advice("give no_such_function(G)", door, TABLE)
    assert wrong_advice("give transfer_function(G, letter='s')", door, TABLE)
    assert wrong_advice("as nothing= to design", door, TABLE)
    for fine in ("transfer_function(..., sample_time=1)", "feedback=-1", "control.c2d(G, h)"):
        assert not wrong_advice(f"give {fine}, as dead_time= to design", door, TABLE)


# Advice that was followed and led nowhere.


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: exact.spectral_factor([1, 2], time=None), "list of coefficients"),
        (lambda: exact.transfer_function(np.poly1d([1, 2])), "list of coefficients"),
        (lambda: exact.root_locus(sympy.exp(-s * T) / (s + 1), feedback=-1), "dead time"),
        (lambda: exact.polynomial(sympy.exp(-s) + 1, "s"), "dead time"),
        (lambda: exact.certified_roots("s + sqrt(2)"), "close to the irrational"),
        (lambda: exact.certified_roots("s + a", ), "numbers for a"),
        (lambda: exact.sampling.tustin("s + 1", "1/10"), r"as in G/\(1 \+ s/100\)"),
        (lambda: exact.decide_stability("1/(s + 1)"), "numerator or the denominator"),
    ],
)  # fmt: skip
def test_what_is_said_is_of_what_was_given(call, words):
    with pytest.raises(CompensatorError, match=words):
        call()


def test_nobody_is_told_to_substitute_numbers_where_there_is_no_symbol(in_full):
    irrational = ("1/(sqrt(2)*s + 3)", "1/(z + sqrt(3)/4)")
    names = [name for name, (arguments, _) in GOOD.items() if isinstance(arguments[0], str)]
    for name in names if in_full else random.Random(0).sample(sorted(names), 20):
        arguments, keywords = GOOD[name]
        for argument in irrational:
            call = (argument, *arguments[1:])
            message = (
                refusal(lambda name=name, call=call, k=keywords: EXACT[name](*call, **k)) or ""
            )
            if re.search("substitute numbers", message):
                assert re.search(r"numbers for \w", message), (name, message)
                letter = re.search(r"numbers for (\w+)", message)[1]
                assert letter not in ("s", "z", "the"), (name, message)


SPECTRA = {
    "place_poles": lambda p: exact.place_poles("1/((s + 1)*(s + 2))", p, feedback=-1),
    "regulator_gain": lambda p: EXACT["regulator_gain"]([[0, 1], [0, 0]], [[0], [1]], p),
    "observer_gain": lambda p: EXACT["observer_gain"]([[0, 1], [0, 0]], [[1, 0]], p),
    "state_feedback_family": lambda p: EXACT["state_feedback_family"](
        [[0, 1], [0, 0]], [[0], [1]], p),
    "pole_placement_target": lambda p: numeric_names()["pole_placement_target"](
        rcac.standard_plant("1/(q - 2)"), p),
}  # fmt: skip


@pytest.mark.parametrize("name", sorted(SPECTRA))
@pytest.mark.parametrize("count", [1, 2, 3])
def test_an_array_that_numpy_poly_may_have_made_is_asked_about(name, count):
    roots = [0.5, 0.25, 0.125][:count]
    with pytest.raises(CompensatorError, match="may be roots, one of them 1, or the coefficients"):
        SPECTRA[name](np.poly(roots))
    as_roots = refusal(lambda: SPECTRA[name]([*np.poly(roots)]))
    assert as_roots is None or "may be roots" not in as_roots
    as_polynomial = refusal(lambda: SPECTRA[name](np.poly1d(np.poly(roots))))
    assert as_polynomial is None or "may be roots" not in as_polynomial
    as_array = refusal(lambda: SPECTRA[name](np.array(roots)))
    assert as_array is None or "may be roots" not in as_array
