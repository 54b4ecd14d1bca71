"""Wrong files, and to the letter what is said of them: refusals.toml has both, before and now."""

import tomllib
from pathlib import Path

import pytest

from compensator_theory import CompensatorError
from rcac_experiments import load_experiment

TABLE = tomllib.loads(Path(__file__).with_name("refusals.toml").read_text("utf-8"))


def text_of(case):
    text = TABLE["base"].lstrip("\n")
    for old, new in case.get("edits", ()):
        assert old in text
        text = text.replace(old, new, 1)
    first = f"{case['first']}\n" if "first" in case else ""
    last = f"\n{case['last']}" if "last" in case else ""
    return first + text + last


@pytest.fixture
def refusal(tmp_path, monkeypatch):
    """What is said of a text in a file."""
    monkeypatch.chdir(tmp_path)

    def said_of(text):
        Path("case.toml").write_text(text, "utf-8")
        with pytest.raises(CompensatorError) as error:
            load_experiment("case.toml")
        return str(error.value).removeprefix("case.toml: ")

    return said_of


def test_the_base_itself_is_right(tmp_path):
    file = tmp_path / "case.toml"
    file.write_text(TABLE["base"], "utf-8")
    assert load_experiment(file).main_run.steps == 100


@pytest.mark.parametrize("case", TABLE["case"], ids=lambda case: case["name"])
def test_what_is_said_of_a_wrong_file(case, refusal):
    assert refusal(text_of(case)) == case.get("after", case["before"])
