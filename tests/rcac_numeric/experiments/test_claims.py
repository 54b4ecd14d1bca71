"""What a claim may not be: each is refused when the file is read, before anything runs."""

import copy

import pytest

from compensator_theory import InputError
from rcac_numeric import verify
from rcac_numeric.experiments.claims import Check
from rcac_numeric.experiments.files.builder import build

CASE = {
    "plant": {"problem": "servo", "G": "(q - 0.5)/((q - 0.9)*(q - 0.3))"},
    "signals": {"r": 1},
    "target": {"model": "fir"},
    "controller": {"n_c": 3, "R_theta": 0.1},
    "run": {"steps": 100},
}


def with_check(**check):
    check = {"measure": "rms", "at_most": 1, **check}
    table = copy.deepcopy(CASE)
    kept = {key: value for key, value in check.items() if value is not None}
    return {**table, "claims": [{"text": "x", "checks": [kept]}]}


@pytest.mark.parametrize(
    ("check", "message"),
    [
        ({"relative_to": ["main"]}, "relative_to = ['main'] must be a string"),
        ({"relative_to": 0}, "relative_to = 0 must be a string"),
        ({"measure": ["rms"]}, "measure = ['rms'] must be a string"),
        ({"measure": "rsm"}, "Did you mean 'rms'"),
        ({"measure": None}, "needs the key 'measure'"),
        ({"run": False}, "run = False must be a string"),
        ({"measure": "settling_step", "band": [1, 2]}, "band must be a real number"),
        ({"band": 0.1}, "sets 'band', which measure = \"rms\" does not read"),
        ({"bnd": 0.1}, "unknown key 'bnd'"),
        ({"signal": "x"}, "signal = 'x' is not known"),
        ({"start": 0.5}, "start must be an integer"),
        ({"start": -1}, "start = -1 must be at least 0"),
        ({"at_most": None}, "a check without a bound cannot fail"),
        ({"at_most": "no"}, "is not"),
        ({"at_most": float("nan")}, "at_most has the entry nan"),
        ({"at_least": 2}, "at least 2.0 and at most 1.0, which no number is"),
        ({"statistic": "mean"}, "statistic = 'mean' is not known"),
        ({"measure": "closed_loop_zero_distance"}, "needs the key 'channel'"),
    ],
)
def test_checks_that_are_refused(check, message):
    with pytest.raises(InputError) as refused:
        build(with_check(**check), "case")
    assert message in str(refused.value) and str(refused.value).startswith("case: ")


@pytest.mark.parametrize("check", [{"run": "other"}, {"relative_to": "mian"}])
def test_a_run_that_there_is_not(check):
    with pytest.raises(InputError, match="refers to the run"):
        verify(build(with_check(**check), "case"))


def test_a_check_of_ones_own_is_asked_before_anything_runs():
    experiment = build(CASE, "case")
    started = []
    for check, message in [
        (Check("rsm", "main", at_most=1), "Did you mean 'rms'"),
        (Check("rms", "main", at_most=1, arguments={"band": 1}), "unexpected keyword argument"),
    ]:
        claim = build(with_check(), "case").claims[0]
        own = type(claim)(claim.text, "", (check,))
        with pytest.raises(InputError, match=message):
            verify(type(experiment)("i", "t", "s", experiment.runs, [own]), started.append)
    assert not started
