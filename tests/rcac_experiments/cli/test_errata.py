"""The command `rcac errata`."""

import json

from click.testing import CliRunner

from rcac_experiments.cli._main import main
from rcac_experiments.dissertation import find_errata


def run(*arguments):
    return CliRunner().invoke(main, ["errata", *arguments])


def test_it_lists_all_of_them():
    result = run("--json")
    listed = json.loads(result.stdout)["errata"]
    assert [entry["name"] for entry in listed] == [entry.name for entry in find_errata()]
    assert len(listed) >= 70


def test_words_of_a_place_need_no_quotes():
    assert run("Example", "7.1").stdout == run("Example 7.1").stdout
    assert "33/4 s + 93/4" in run("Example", "7.1").stdout


def test_checks_run_and_say_what_they_found():
    listed = json.loads(run("(8.87)", "--check", "--json").stdout)["errata"]
    assert listed[0]["holds"] is True
    assert "All checks hold (1)" in run("(8.87)", "--check").stdout


def test_a_place_without_errata_is_an_answer():
    result = run("(2.1)")
    assert result.exit_code == 0
    assert "none known at (2.1)" in result.stdout
