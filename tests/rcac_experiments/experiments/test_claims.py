"""What a claim may not be: each is refused when the file is read, before anything runs."""

import copy

import pytest

from compensator_theory import InputError
from rcac_experiments import verify
from rcac_experiments.files._builder import build
from rcac_experiments.files._claims import STANDARD_CLAIMS
from rcac_experiments.judging._claim import (
    FAILS,
    HOLDS,
    NO_ANSWER,
    OUTCOMES,
    UNDETERMINED,
    VERDICTS,
    Check,
    CheckResult,
    Claim,
    Verdict,
    outcome_of,
    quoted_interval,
)

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
    remaining = {key: value for key, value in check.items() if value is not None}
    return {**table, "claims": [{"text": "x", "checks": [remaining]}]}


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
        ({"signal": "x"}, "signal = 'x' must be one of"),
        ({"start": 0.5}, "start must be an integer"),
        ({"start": -1}, "start = -1 must be at least 0"),
        ({"at_most": None}, "a check without a bound cannot fail"),
        ({"at_most": "no"}, "must be a real number"),
        ({"at_most": float("nan")}, "at_most has the entry nan"),
        ({"at_least": 2}, "at least 2.0 and at most 1.0, which no number is"),
        ({"statistic": "mean"}, "statistic = 'mean' must be one of"),
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
        ({"verdicts": {"mian": "holds"}}, "refers to the run 'mian'"),
        ({"verdicts": {"main": "reprodced"}}, "Did you mean 'reproduced'"),
        ({"verdict": "reproduced"}, "without a quote"),
        ({"quote": "x", "place": "y", "verdict": "holds"}, "one that quotes has"),
        ({"quote": "x"}, "quote and place, or neither"),
        ({"misprint": "x"}, "misprint without a quote"),
        ({"reading": "x"}, "reading without a quote"),
        ({"control": "mian"}, "refers to the run 'mian'"),
        ({"open": ["k_w"]}, "open = 'k_w' of a claim"),
        ({"over": {"hold": ["main"]}}, "Did you mean 'holds'"),
        ({"over": {"holds": ["mian"]}}, "over, the map of a claim, refers to"),
        ({"verdicts": {"main": "holds"}, "run": "main"}, "remove"),
        ({"verdicts": {"main": "holds"}, "verdict": "holds"}, "remove"),
    ],
)
def test_variants_that_are_refused(claim, message):
    with pytest.raises(InputError) as refused:
        build({**CASE, "claims": [{"text": "x", "checks": [CHECK], **claim}]}, "case")
    assert message in str(refused.value)


def test_a_claim_is_judged_for_each_variant():
    """Checks that name no run are of the variant; a verdict of its own for each."""
    table = {
        **copy.deepcopy(CASE),
        "runs": [{"name": "as printed"}, {"name": "more", "correction": "n_c = 4"}],
        "claims": [
            {
                "text": "x",
                "checks": [CHECK, {**CHECK, "run": "as printed"}],
                "verdicts": {"as printed": "holds", "more": "holds"},
            },
            {"text": "y", "checks": [CHECK], "run": "more"},
            {"text": "z", "checks": [CHECK]},
        ],
    }
    table["runs"][1]["controller"] = {"n_c": 4}
    claims = build(table, "case").claims
    assert [(c.text, c.run) for c in claims] == [
        ("x", "as printed"), ("x", "more"), ("y", "more"), ("z", "")
    ]  # fmt: skip
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
    verdicts = {"verdicts": dict.fromkeys("ab", "does not hold")}
    short = build({**table, "claims": [{"standard": name, **verdicts}]}, "case").claims
    ours = {"text": standard.text, "checks": checks}
    assert short == build({**table, "claims": [{**ours, **verdicts}]}, "case").claims
    assert [check.run for claim in short for check in claim.checks] == [
        run for run in "ab" for _ in checks
    ]


@pytest.mark.parametrize(
    ("claim", "message"),
    [
        ({"text": "x"}, "a claim needs checks, or standard, one of intercalated match"),
        ({"checks": [CHECK]}, "a claim needs text, or standard"),
        ({}, "a claim needs text and checks, or standard"),
        ({"standard": "match"}, "'match' must be one of"),
        ({"standard": "residual split", "text": "x"}, "which replaces text"),
        ({"standard": "residual split", "checks": [CHECK]}, "remove"),
    ],
)
def test_a_claim_is_standard_or_says_its_own(claim, message):
    with pytest.raises(InputError, match=message):
        build({**CASE, "claims": [claim]}, "case")


def test_a_refused_measure_spoils_its_own_claim_and_no_other():
    claims = [{"standard": "residual split"}, {"text": "z is small.", "checks": [CHECK]}]
    first, second = verify(build({**copy.deepcopy(CASE), "claims": claims}, "case")).verdicts
    assert (first.verdict, second.verdict) == (NO_ANSWER, HOLDS)
    assert "theta(1000) was not stored" in first.measured


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
        "1 in the interval, a share between 0.01 and 0.91"
    )


def test_a_ratio_needs_as_many_of_both():
    table = copy.deepcopy(CASE)
    table["runs"] = [{"name": "a", "run": {"seeds": 3}}, {"name": "b"}]
    table["claims"] = [{"text": "x", "checks": [{**CHECK, "run": "a", "relative_to": "b"}]}]
    with pytest.raises(InputError, match="the same number of seeds and repetitions"):
        verify(build(table, "case"))


def test_a_check_of_ones_own_is_asked_before_anything_runs():
    experiment = build(CASE, "case")
    started = []
    for check, message in [
        (Check("rsm", "main", at_most=1), "Did you mean 'rms'"),
        (Check("rms", "main", at_most=1, arguments={"band": 1}), "unexpected keyword argument"),
    ]:
        claim = build(with_check(), "case").claims[0]
        ours = type(claim)(claim.text, (check,))
        with pytest.raises(InputError, match=message):
            verify(type(experiment)("i", "t", "s", experiment.runs, [ours]), started.append)
    assert not started


# What completions, a control and silence make of a claim of a source.


def result(holds, missing_reason=""):
    check = Check("rms", "main", at_most=1.0)
    values = {True: (0.5,), False: (2.0,), None: (0.5, 2.0)}[holds]
    return CheckResult(check, values, missing_reason=missing_reason)


def verdict(is_true, others=(), control=None, **words):
    claim = Claim("x", (), quote="x", place="(1)", run="main", **words)
    mapped = {f"run {i}": (result(holds),) for i, holds in enumerate(others)}
    controlled = () if control is None else (result(control),)
    return Verdict(claim, (result(is_true),), mapped, controlled).verdict


@pytest.mark.parametrize(
    ("holds", "others", "control", "words", "expected"),
    [
        (True, (), None, {}, "reproduced"),
        (True, (True, True), None, {}, "reproduced"),
        (True, (), None, {"misprint": "y for z"}, "misprint"),
        (True, (False,), None, {}, "depends"),
        (False, (True,), None, {}, "depends"),
        (False, (True,), None, {"misprint": "y for z"}, "depends"),
        (None, (True,), None, {}, "depends"),
        (False, (), None, {}, "not reproduced"),
        (False, (False, False), True, {}, "not reproduced"),
        (False, (False,), False, {}, "undetermined"),
        (False, (None,), None, {}, "undetermined"),
        (None, (), None, {}, "undetermined"),
    ],
)
def test_the_verdict_of_completions(holds, others, control, words, expected):
    assert verdict(holds, others, control, **words) == expected


def test_an_outcome_of_record_counts_where_a_completion_did_not_run():
    claim = Claim("x", (), quote="x", place="(1)", run="main", over={"b": FAILS, "c": ""})
    answer = Verdict(claim, (result(True),))
    assert answer.outcomes == {"main": HOLDS, "b": FAILS} and answer.verdict == "depends"
    changed = Verdict(claim, (result(True),), {"b": (result(True),)})
    assert changed.verdict == "reproduced" and "b" in changed.changed_completions


def test_what_is_silent_satisfies_nothing():
    assert outcome_of((result(True, "refused"),)) == NO_ANSWER
    assert outcome_of((result(True), result(False, "refused"))) == NO_ANSWER
    assert outcome_of((result(False), result(True, "refused"))) == FAILS
    assert outcome_of((result(None), result(True))) == UNDETERMINED
    claim = Claim("x", (), quote="x", place="(1)")
    assert Verdict(claim, (result(False, "refused"),)).verdict == "undetermined"


def test_words_of_verdict_are_few_and_have_a_meaning():
    assert list(VERDICTS) == ["reproduced", "depends", "not reproduced", "misprint", "undetermined"]
    assert len(OUTCOMES) == 4 and all({**VERDICTS, **OUTCOMES}.values())


def test_no_adaptation_is_no_answer():
    """R_theta = 1e30: neither that a loop follows nor that it does not is shown."""
    table = copy.deepcopy(CASE)
    table["controller"]["R_theta"] = 1e30
    for bound in ({"at_most": 1e9}, {"at_least": 1e9}):
        check = {"measure": "rms", **bound}
        verification = verify(
            build({**table, "claims": [{"text": "x", "checks": [check]}]}, "case")
        )
        assert verification.verdicts[0].verdict == NO_ANSWER
    of_plant = {"measure": "plant_spectral_radius", "at_most": 0.91}
    verification = verify(build({**table, "claims": [{"text": "x", "checks": [of_plant]}]}, "case"))
    assert verification.verdicts[0].verdict == HOLDS


@pytest.mark.parametrize(
    ("quoted", "within", "interval"),
    [
        ("1.81", 0.1, (1.629, 1.991)),
        ("28.96", None, (28.955, 28.965)),
        ("-0.9959", None, (-0.99595, -0.99585)),
        ("2000", None, (1999.5, 2000.5)),
    ],
)
def test_the_interval_of_a_quoted_number(quoted, within, interval):
    assert quoted_interval(quoted, within) == pytest.approx(interval, rel=1e-12)


@pytest.mark.parametrize(
    ("check", "message"),
    [
        ({"quoted": "1.9"}, "quoted = '1.9' must be part of the quote"),
        ({"quoted": "1.81", "at_most": 2}, "leave at_least and at_most out"),
        ({"quoted": "", "within": 0.1, "at_most": 2}, "give quoted too"),
        ({"quoted": "1.81", "within": -0.1}, "must be above 0"),
        ({"quoted": "one"}, "must be a number as the source prints it"),
        ({"quoted": "1.81", "measure": "plant_zero_distance", "value": 1.8}, "is not the quoted"),
    ],
)
def test_a_quoted_number_that_is_refused(check, message):
    claim = {"quote": "it is 1.81", "place": "(1)", "checks": [{"measure": "rms", **check}]}
    with pytest.raises(InputError) as refused:
        build({**copy.deepcopy(CASE), "claims": [claim]}, "case")
    assert message in str(refused.value)


def test_completions_are_every_combination_and_move_all_runs_of_a_check():
    table = copy.deepcopy(CASE)
    table["runs"] = [{"name": "a"}, {"name": "b", "controller": {"n_c": 4}}]
    table["open"] = [
        {"what": "k_w", "chosen": "n_c", "values": [{"name": "k_w = 9", "controller": {"k_w": 9}}]},
        {"what": "r", "chosen": "1", "values": [{"name": "r = 2", "signals": {"r": 2}}]},
        {"what": "the hold", "chosen": "any"},
    ]
    check = {"measure": "rms", "relative_to": "b", "at_most": 1e9}
    claim = {"quote": "q", "place": "p", "checks": [check], "open": ["k_w", "r", "the hold"]}
    claim["over"] = {"holds": ["k_w = 9", "the rest"]}
    case = build({**table, "claims": [claim]}, "case")
    values = ["r = 2", "k_w = 9", "k_w = 9; r = 2"]
    assert set(case.completions) == {f"{run}; {value}" for run in "ab" for value in values}
    assert case.completions["b; k_w = 9; r = 2"].settings.k_w == 9
    assert case.claims[0].over == dict.fromkeys((f"a; {value}" for value in values), HOLDS)
    few, all_of_them = verify(case), verify(case.completed())
    assert not few.verdicts[0].others and len(all_of_them.verdicts[0].others) == 3
    assert {few.verdicts[0].verdict, all_of_them.verdicts[0].verdict} == {"reproduced"}
    moved = all_of_them.verdicts[0].others["a; r = 2"][0].check
    assert (moved.run, moved.relative_to) == ("a; r = 2", "b; r = 2")


def test_held_out_seeds_are_disjoint_from_those_of_finding():
    table = copy.deepcopy(CASE)
    table["run"] |= {"seeds": 20}
    case = build(table, "case")
    seeds = [
        set(range(run.seed, run.seed + run.seeds))
        for run in (case.main_run, *(case.held_out(group).main_run for group in range(3)))
    ]
    assert len(set().union(*seeds)) == 80


def test_fewer_repetitions_change_no_verdict():
    table = copy.deepcopy(CASE)
    table["signals"] = {"r": 1, "d": {"white_noise": 1}}
    table["run"] |= {"seeds": 5}
    claim = {"text": "x", "checks": [{"measure": "rms", "at_most": 1e-9}], "verdict": "holds"}
    case = build({**table, "claims": [claim]}, "case")
    assert verify(case).exit_status == 1 and verify(case.reduced(2)).exit_status == 0
