"""Exact examples: each statement can hold and can fail, and a wrong file is refused by name."""

import copy

import pytest
from click.testing import CliRunner

from compensator_theory import InputError
from rcac_experiments import verify
from rcac_experiments.cli._main import main
from rcac_experiments.dissertation import load_example
from rcac_experiments.dissertation._examples import example_ids, read_example
from rcac_experiments.experiments._exact_statements import STATEMENTS, ExactCheck, ExactSystem
from rcac_experiments.files._builder import build

EXACT = [number for number in example_ids() if "exact" in read_example(number)[0]]
PLANT = ExactSystem(A=[[-1, 4], [0, -3]], B=[[0], [1]], C=[[1, 0]])
ODD = ExactSystem(G="1/(s**3 + s**2 + 2*s)")
CUBIC = "s**3 + 2*s**2 + 4*s + 1"
PAIR = ExactSystem(a="s + 1", b="s**2 + 3*s + 2")
G_C = "(33/4*s + 93/4)/(s**2 + 13*s + 49)"
# One that holds and one that does not, for every statement.
CASES = {
    "regulator_gain": (PLANT, {"poles": [-5, -4]}, "equals", [[-3, -5]], [[-3, -4]]),
    "observer_gain": (PLANT, {"poles": [-2, -6]}, "equals", [[4], ["-3/4"]], [[4], ["3/4"]]),
    "observer_based_compensator": (
        PLANT, {"regulator": [-5, -4], "observer": [-2, -6]}, "equals", G_C, f"-{G_C}"
    ),
    "closed_loop": (
        PLANT, {"compensator": G_C}, "polynomial", "(s + 2)*(s + 4)*(s + 5)*(s + 6)",
        "(s + 2)*(s + 4)*(s + 5)*(s + 7)",
    ),
    "placement": (
        PLANT, {"poles": [-6, -5, -4, -2]}, "compensator", G_C,
        "(8.26*s + 93/4)/(s**2 + 13*s + 49)",
    ),
    "no_unique_placement": (
        ExactSystem(G="1/(s + 2)"), {"poles": [-1, -1], "n_c": 1}, "numerator_degree", 1, 0
    ),
    "observer_based": (ODD, {"compensator": "5/((s**2 + 1)*(s + 1))"}, "answer", False, True),
    "placed_pair_is_observer_based": (PLANT, {"poles": [-6, -5, -4, -2]}, "answer", True, False),
    "sylvester_matrix": (
        PAIR, {}, "equals", [[1, 0, 1], [1, 1, 3], [0, 1, 2]], [[1, 1, 0], [0, 1, 1], [1, 3, 2]]
    ),
    "sylvester_rank": (PAIR, {}, "equals", 2, 3),
    "sylvester_determinant": (PAIR, {}, "equals", 0, 1),
    "common_roots": (PAIR, {}, "equals", 1, 2),
}  # fmt: skip


def test_chapters_7_and_b_are_all_here():
    expected = {f"7.{i}" for i in range(1, 7)} | {f"B.{i}" for i in range(1, 6)}
    assert set(EXACT) == expected


def test_every_statement_has_a_case():
    assert set(CASES) == set(STATEMENTS)


@pytest.mark.parametrize("name", CASES)
def test_a_statement_can_hold_and_can_fail(name):
    system, rest, key, right, wrong = CASES[name]
    assert ExactCheck(name, system, {**rest, key: right}).evaluate().holds is True
    assert ExactCheck(name, system, {**rest, key: wrong}).evaluate().holds is False


@pytest.mark.parametrize("number", EXACT)
def test_no_verdict_is_typed_in(number):
    """The file without its verdicts gives the same ones."""
    table = copy.deepcopy(read_example(number)[0])
    recorded = [claim.pop("verdict") for claim in table["claims"]]
    assert [v.verdict for v in verify(build(table, number)).verdicts] == recorded


@pytest.mark.parametrize(("decimals", "holds"), [(3, True), (4, False)])
def test_rounded_coefficients_are_as_good_as_their_digits(decimals, holds):
    motor = ExactSystem(
        A=[[0, 1, 0], [0, -2, "0.85"], [0, -3, -1]], B=[[0], [0], [1]], C=[[1, 0, 0]]
    )
    poles = "((s + 1/2)**2 + 1/100)*((s + 1)**2 + 1/4)*((s + 2)**2 + 1)"
    printed = "(5.585*s**2 + 8.034*s + 1.912)/(s**3 + 4*s**2 + 3.96*s + 0.73)"
    arguments = {"poles": poles, "compensator": printed, "decimals": decimals}
    assert ExactCheck("placement", motor, arguments).evaluate().holds is holds


def test_what_runs_nothing_says_so():
    experiment = load_example("7.1")
    with pytest.raises(InputError, match=r"'7\.1' is exact: nothing is run"):
        experiment.main_run  # noqa: B018
    with pytest.raises(InputError, match="nothing ran"):
        verify(experiment).plot()


def test_the_command_tells_claims_and_answers():
    result = CliRunner().invoke(main, ["verify", "B.3"])
    assert result.exit_code == 0
    assert "Exact result" in result.stdout and "det M_1 = 216" in result.stdout


CASE = {
    "exact": {"a": "s + 1", "b": "s + 2"},
    "claims": [{"text": "coprime", "checks": [{"statement": "common_roots", "equals": 0}]}],
}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"claims": [{"text": "x", "checks": [{"statement": "common_root"}]}]}, "common_roots"),
        ({"claims": [{"text": "x", "checks": [{"statement": "common_roots"}]}]}, "'equals'"),
        ({"claims": [{"text": "x", "checks": []}]}, "not an empty one"),
        ({"exact": {"a": "s", "c": "s"}}, "unknown key 'c'"),
        ({"exact": {"G": "1/s", "feedback": 0}}, "1 or -1"),
        ({"plant": {"G": "1/q"}}, "unknown key 'plant'"),
    ],
)
def test_a_wrong_file_is_refused_by_name(change, message):
    assert verify(build(CASE, "case.toml")).exit_status == 0
    with pytest.raises(InputError, match=message):
        build({**CASE, **change}, "case.toml")


def test_a_statement_about_what_is_not_there_names_it():
    table = {**CASE, "exact": {"G": "1/s"}}
    (verdict, *_) = verify(build(table, "case.toml")).verdicts
    assert verdict.verdict == "no answer"
    assert "'common_roots': this statement is about two polynomials" in verdict.measured
