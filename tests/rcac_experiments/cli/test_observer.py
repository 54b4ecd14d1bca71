"""The command `rcac observer`: what it prints, answers as JSON, and refuses."""

import json

import pytest
from click.testing import CliRunner

from rcac_experiments.cli._main import main

EXAMPLE_7_1 = [
    "--plant",
    "4/((s + 1)*(s + 3))",
    "--compensator",
    "(33/4*s + 93/4)/(s^2 + 13*s + 49)",
]


def run(*arguments):
    return CliRunner().invoke(main, ["observer", *arguments])


def test_example_7_1_as_text():
    result = run(*EXAMPLE_7_1)
    assert result.exit_code == 0
    assert result.output.count("Forms: 6") >= 3
    assert result.output.count("; observer ") == 6
    assert "s**4 + 17*s**3 + 104*s**2 + 268*s + 240" in result.output


def test_example_7_1_as_json():
    answer = json.loads(run(*EXAMPLE_7_1, "--feedback", "-1", "--json").output)
    assert answer["decisions"]["pair"] | {"reason": ""} == {
        "answer": True, "reason": "", "number_of_forms": 6
    }  # fmt: skip
    assert {form["regulator"] for form in answer["forms"]} >= {
        "s**2 + 9*s + 20",
        "s**2 + 11*s + 30",
    }
    assert answer["float64_forms"] is None


def test_the_sign_of_the_loop_matters():
    arguments = ["--plant", "1/s", "--compensator", "1/s", "--json"]
    negative = json.loads(run(*arguments).output)
    positive = json.loads(run(*arguments, "--feedback", "+1").output)
    assert negative["decisions"]["pair"]["answer"] is False
    assert positive["decisions"]["pair"]["answer"] is True
    assert positive["forms"][0]["K"] == [["1"]] or positive["forms"][1]["K"] == [["1"]]


def test_irrational_forms_come_in_float64():
    arguments = ["--plant", "1/(s^3 + s)", "--compensator", "(s^2 + s + 1)/(s^3 + s + 5)"]
    answer = json.loads(run(*arguments, "--json").output)
    assert len(answer["float64_forms"]) == answer["decisions"]["pair"]["number_of_forms"] == 4
    assert all(form["residual"] < 1e-10 for form in answer["float64_forms"])
    assert "float64: 4 observer-based forms" in run(*arguments).output


def test_a_compensator_without_state_gets_answers_and_no_forms():
    answer = json.loads(run("--plant", "1/s", "--compensator", "3", "--json").output)
    assert answer["forms"] == [] and answer["decisions"]["transfer_function"]["answer"] is False


@pytest.mark.parametrize(
    ("plant", "compensator", "message"),
    [
        ("1/(s", "1/s", "cannot read"),
        ("1/s", "1/z", "variable"),
        ("(s + 1)/((s + 1)*s)", "1/s", "hidden modes"),
        ("s**2/(s + 1)", "1/s", "improper"),
        ("1/s", "__import__('os')", "cannot read"),
        ("nan", "1/s", "finite"),
    ],
)
def test_bad_input_ends_with_status_2(plant, compensator, message):
    result = run("--plant", plant, "--compensator", compensator)
    assert result.exit_code == 2 and message in result.output
    assert "Traceback" not in result.output
