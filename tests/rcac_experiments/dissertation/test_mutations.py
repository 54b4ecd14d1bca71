"""Every check can fail: a generated change of its example's file, or a NaN, turns it."""

import numpy as np
import pytest

from compensator_theory import CompensatorError
from rcac_experiments.dissertation import load_example
from rcac_experiments.dissertation._examples import example_ids, read_example
from rcac_experiments.judging._claim import HOLDS, OURS, Check, CheckResult, outcome_of
from tests.support.mutations import mutations, outcomes

QUICK = ("2.2", "4.7", "7.1", "7.3", "7.6", "B.2", "B.3")
# Claims that no mutation turns, by example and the words that they begin with, each with a reason.
UNTURNED = {
    ("7.4", "Without deg"): "no compensator of that degree is unique, whatever the plant",
    ("7.3", "Without deg"): "the same",
    ("7.6", "It is not observer-based."): "poles without a real one cannot be shared, by any plant",
    ("B.1", "a and b are coprime"): "two polynomials are, unless they are chosen",
    ("B.3", "a and b are coprime"): "a constant has no roots, whatever a is",
    ("B.3", "M_1(a, b) is nonsingular"): "6 I is the matrix of every a of that degree",
    ("B.5", "By Theorem A1 every root"): "b = 0 has every root of every a",
    ("A.1", "The closed-loop spectrum is"): "a theorem, of every plant",
    ("A.1", "The closed loop is asymptotically stable"): "the same",
    ("A.2", "The closed-loop spectrum is"): "the same",
    ("A.2", "The zeros of G_zw and G_yu"): "the same",
    ("A.2", "The closed loop is asymptotically stable"): "the same",
    ("1.1", "No zero of (1.1)-(1.2)"): "a plant of the library, of which the file sets the period",
    ("1.1", "The plant (1.3)-(1.4) is minimum phase"): "the same",
    ("1.2", "Both plants are stable"): "the same",
    ("1.3", "T is asymptotically stable"): "the same",
    ("3.2", "The nominal plant has the zeros"): "a plant of the library, until its transition",
    ("8.4", "With a bias the EKF is not"): "an estimator that is broken is not able to, either",
}


def turned(number):
    """The quoted claims that hold, and those of them that some mutation turns."""
    table = read_example(number)[0]
    ours = outcomes(table, number)
    claims = [claim for claim in load_example(number).claims if claim.owner != OURS]
    stored = {i for i, outcome in enumerate(ours) if outcome == HOLDS}
    names = set()
    for _, changed in mutations(table):
        try:
            after = outcomes(changed, number)
        except CompensatorError:
            continue  # a plant that is none shows nothing
        names |= {i for i in stored if after[i] != HOLDS}
    return {i: claims[i].text for i in stored}, names


@pytest.mark.parametrize(
    "number",
    [pytest.param(n, marks=() if n in QUICK else pytest.mark.long) for n in example_ids()],
)
def test_a_change_of_the_file_turns_every_claim_that_holds(number, request):
    if number not in QUICK and not request.config.getoption("--long"):
        pytest.skip("runs every example several times; --long runs them all")
    stored, result = turned(number)
    left = {text for i, text in stored.items() if i not in result}
    known = {words for (example, words) in UNTURNED if example == number}
    assert all(any(text.startswith(words) for words in known) for text in left), left


@pytest.mark.costly
@pytest.mark.parametrize("number", example_ids())
def test_nan_satisfies_no_check(number):
    """Whatever a check asks for: values that are none are not inside."""
    for claim in load_example(number).claims:
        for check in claim.checks:
            if isinstance(check, Check):
                lost = CheckResult(check, (np.nan,) * 20, over_seeds=True)
                assert lost.holds is False and outcome_of((lost,)) != HOLDS


@pytest.mark.parametrize(
    ("number", "printed", "changed"),
    [("2.2", 1.71, 1.61), ("2.7", 1.2, 1.4), ("4.7", 1.44, 1.34), ("4.8", 1.2, 1.25)],
)
def test_a_changed_digit_of_a_plant_is_noticed(number, printed, changed):
    """The examples in which a reviewer changed a digit and no verdict moved."""
    table = read_example(number)[0]
    before = outcomes(table, number)
    assert str(printed) in table["plant"]["G"] and set(before) == {HOLDS}
    table["plant"]["G"] = table["plant"]["G"].replace(str(printed), str(changed))
    assert outcomes(table, number) != before
