"""What a claim may not be: each is refused when the file is read, before anything runs."""

import copy

import pytest

from compensator_theory import InputError
from rcac_numeric import verify
from rcac_numeric.experiments.claims import Check, CheckResult
from rcac_numeric.experiments.files.builder import build
from rcac_numeric.experiments.files.claims import STANDARD_CLAIMS

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
        ({"run": False}, "run = false must be a string"),
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
        ({"share": 0}, "share = 0.0 must be above 0 and at most 1"),
        ({"share": 1.5}, "share = 1.5 must be above 0"),
        ({"share": 0.5, "statistic": "median"}, "share = 0.5 is for statistic = 'each'"),
        ({"until": 0}, "until = 0 must be at least 1"),
        ({"until": 2.5}, "until must be an integer"),
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


CHECK = {"measure": "rms", "at_most": 1}


@pytest.mark.parametrize(
    ("claim", "message"),
    [
        ({"run": "mian"}, "refers to the run 'mian'; the runs are main. Did you mean 'main'"),
        ({"verdicts": {"mian": "reproduced"}}, "refers to the run 'mian'"),
        ({"verdicts": {"main": "reprodced"}}, "Did you mean 'reproduced'"),
        ({"verdicts": {"main": "reproduced"}, "run": "main"}, "leave them out"),
        ({"verdicts": {"main": "reproduced"}, "verdict": "reproduced"}, "leave them out"),
    ],
)
def test_variants_that_are_refused(claim, message):
    with pytest.raises(InputError) as refused:
        build({**CASE, "claims": [{"text": "x", "checks": [CHECK], **claim}]}, "case")
    assert message in str(refused.value)


def test_a_claim_is_judged_for_each_variant():
    """A run that reads the source differently makes its claims corrected ones; checks follow."""
    table = {
        **copy.deepcopy(CASE),
        "runs": [{"name": "as printed"}, {"name": "more", "correction": "n_c = 4"}],
        "claims": [
            {
                "text": "x",
                "checks": [CHECK, {**CHECK, "run": "as printed"}],
                "verdicts": {"as printed": "reproduced", "more": "reproduced with a correction"},
            },
            {"text": "y", "checks": [CHECK], "run": "more", "correction": "its own"},
            {"text": "z", "checks": [CHECK]},
        ],
    }
    table["runs"][1]["controller"] = {"n_c": 4}
    claims = build(table, "case").claims
    assert [(c.text, c.run, c.correction) for c in claims] == [
        ("x", "as printed", ""),
        ("x", "more", "n_c = 4"),
        ("y", "more", "its own"),
        ("z", "", ""),
    ]
    assert [[check.run for check in c.checks] for c in claims] == [
        ["as printed", "as printed"], ["more", "as printed"], ["more"], ["as printed"]
    ]  # fmt: skip
    assert verify(build(table, "case")).exit_status == 0


@pytest.mark.parametrize("name", STANDARD_CLAIMS)
def test_a_standard_claim_is_the_same_as_its_checks_written_out(name):
    standard = STANDARD_CLAIMS[name]
    table = copy.deepcopy(CASE)
    table["run"] = {**table["run"], "steps": 100_000, "stride": 1000}
    table["runs"] = [{"name": "a"}, {"name": "b", "controller": {"n_c": 4}}]
    checks = [
        {"measure": c.measure, **c.arguments, "until": c.until, "statistic": "median",
         "at_most": c.at_most}
        for c in standard.checks
    ]  # fmt: skip
    verdicts = {"verdicts": dict.fromkeys("ab", "not reproduced")}
    short = build({**table, "claims": [{"standard": name, **verdicts}]}, "case").claims
    own = {"text": standard.text, "claimed": standard.claimed, "checks": checks}
    assert short == build({**table, "claims": [{**own, **verdicts}]}, "case").claims
    assert [check.run for claim in short for check in claim.checks] == [
        run for run in "ab" for _ in checks
    ]


@pytest.mark.parametrize(
    ("claim", "message"),
    [
        ({"text": "x"}, "a claim needs checks, or standard, one of intercalated match"),
        ({"checks": [CHECK]}, "a claim needs text, or standard"),
        ({}, "a claim needs text and checks, or standard"),
        ({"standard": "match"}, "'match' is not known"),
        ({"standard": "residual split", "text": "x"}, "so that text have no meaning"),
        ({"standard": "residual split", "checks": [CHECK]}, "leave them out"),
    ],
)
def test_a_claim_is_standard_or_says_its_own(claim, message):
    with pytest.raises(InputError, match=message):
        build({**CASE, "claims": [claim]}, "case")


def test_a_standard_claim_of_too_short_a_run_says_which_step_is_missing():
    case = {**copy.deepcopy(CASE), "claims": [{"standard": "residual split"}]}
    with pytest.raises(InputError, match=r"theta\(1000\) was not kept"):
        verify(build(case, "case"))


@pytest.mark.parametrize(
    ("check", "values", "over_seeds", "holds"),
    [
        ({}, (0.5, 0.9), False, True),
        ({}, (0.5, 1.1), False, None),
        ({}, (0.5, 1.1), True, False),
        ({}, (1.2, 1.1), False, False),
        ({}, (0.5, float("nan")), False, None),
        ({"share": 0.5}, (0.5, 1.1), False, True),
        ({"share": 0.5}, (0.5, 1.1), True, True),
        ({"share": 0.6}, (0.5, 1.1), False, False),
        ({"share": 2 / 3}, (0.5, 1.1, float("nan")), True, False),
        ({"statistic": "median"}, (0.5, 0.9, 7.0), True, True),
        ({"statistic": "median"}, (0.5, 1.1, 7.0), True, False),
        ({"statistic": "median"}, (0.5, 0.9, float("nan")), True, False),
    ],
)
def test_when_a_check_holds(check, values, over_seeds, holds):
    result = CheckResult(Check("rms", "main", at_most=1.0, **check), values, over_seeds)
    assert result.holds is holds
    assert result.inside == sum(value <= 1 for value in values)


def test_the_words_say_how_many_and_of_what():
    words = str(CheckResult(Check("rms", "main", at_most=1, until=9), (0.5, 2, float("nan")), True))
    assert words == (
        "rms at step 9 (main): median 1.25 [0.5, 2] of 3 seeds, 1 without a value, "
        "1 in the interval"
    )


def test_a_ratio_needs_as_many_of_both():
    table = copy.deepcopy(CASE)
    table["runs"] = [{"name": "a", "run": {"seeds": 3}}, {"name": "b"}]
    table["claims"] = [{"text": "x", "checks": [{**CHECK, "run": "a", "relative_to": "b"}]}]
    with pytest.raises(InputError, match="give them as many seeds and repetitions"):
        verify(build(table, "case"))


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
