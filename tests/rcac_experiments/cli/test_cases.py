"""Examples shown, other values set, runs kept, and what a shell completes."""

import json
import tomllib

import pytest
from click.testing import CliRunner

from rcac_experiments.cli._cases import known_keys
from rcac_experiments.cli._main import main
from rcac_experiments.dissertation import load_example
from rcac_experiments.files._builder import build
from rcac_numeric import load_run


def rcac(*arguments, **environment):
    return CliRunner().invoke(main, list(arguments), prog_name="rcac", env=environment)


def test_an_example_is_shown_as_it_is_and_can_be_run_as_ones_own(tmp_path):
    shown = rcac("show", "4.7")
    assert shown.exit_code == 0
    assert build(tomllib.loads(shown.output), "4.7").main_run == load_example("4.7").main_run


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["show", "9.9"], "no example '9.9'"),
        (["show", "4.7", "--json"], "options of `rcac show`"),
        (["verify", "4.7", "--set", "controller.R_theta"], "KEY=VALUE"),
        (["verify", "4.7", "--set", "controller.R_thet=1"], "Did you mean 'R_theta'"),
        (["verify", "4.7", "--set", "controler.R_theta=1"], "Did you mean 'controller'"),
        (["verify", "4.7", "--set", "controller.structure=fir"], "Text needs quotes"),
        (["verify", "4.7", "--set", "run.steps=1\nseed=2"], "one value"),
        (["verify", "4.7", "--save", "run.mat"], "must end in .npz"),
        (["verify", "4.7", "--save", "nowhere/run.npz"], "no folder"),
    ],
)
def test_bad_input_is_refused_with_the_way_out(arguments, words):
    result = rcac(*arguments)
    assert result.exit_code == 2 and words in result.output


@pytest.mark.exact_data
def test_a_value_that_is_set_is_run_and_kept_and_checked(tmp_path):
    file = str(tmp_path / "run.npz")
    values = ["--set", "controller.R_theta=0.125", "--set", "run.steps=80"]
    done = rcac("verify", "4.7", *values, "--save", file)
    assert done.exit_code == 0 and "verdicts of record" not in done.output
    run = load_run(file)
    assert run.settings.update.R_theta == 0.125 and run.steps == 80
    checked = rcac("check", file, "--json")
    assert checked.exit_code == 0
    record = json.loads(checked.output)
    assert record["replay"]["agrees"] and record["replay"]["worst"] < 1e-12
    assert record["target"]["poles"] and record["steps"] == 80 and record["source"] == file


@pytest.mark.costly
@pytest.mark.parametrize("number", ["2.6", "2.7", "5.2"])
def test_any_kept_run_is_checked_as_it_is(number, tmp_path):
    """With a saturation, several controllers, a command, a schedule."""
    file = tmp_path / "run.npz"
    load_example(number).reduced(1).main_run.execute().first.run.save(file)
    result = rcac("check", str(file), "--json")
    assert result.exit_code in (0, 1, 5) and "loop" in json.loads(result.output)


def test_a_shell_completes_commands_cases_and_keys():
    def completed(words):
        requested = rcac(_RCAC_COMPLETE="bash_complete", COMP_WORDS=words,
                     COMP_CWORD=str(words.count(" ")))  # fmt: skip
        return [line.partition(",")[2] for line in requested.output.split()]

    assert completed("rcac ve") == ["verify"]
    assert completed("rcac verify 4.7 --se") == ["--set", "--seeds"]
    assert completed("rcac show B.") == ["B.1", "B.2", "B.3", "B.4", "B.5"]
    assert completed("rcac verify 4.7 --set controller.R_t") == ["controller.R_theta="]


def test_every_key_that_is_completed_is_one_that_files_know():
    """Each is refused, if at all, for its value and not for its name."""
    for key, _ in known_keys():
        table, name = key.split(".")
        if table in ("controller", "run", "target"):
            result = rcac("verify", "4.7", "--set", f"{key}=[[['x']]]")
            assert f"unknown key '{name}'" not in result.output


@pytest.mark.parametrize(
    ("key", "proposal"),
    [
        ("R_theta", "--set controller.R_theta=1?"),
        ("R_thetaa", "--set controller.R_theta=1?"),
        ("steps", "--set run.steps=1?"),
    ],
)
def test_the_full_key_is_proposed(key, proposal):
    result = CliRunner().invoke(main, ["verify", "4.7", "--set", f"{key}=1"])
    assert result.exit_code == 2 and proposal in result.stderr


def test_poles_that_are_missed_are_said_first(tmp_path):
    """With 60 steps and a large R_theta RCAC cannot have placed anything."""
    changed = ["--set", "controller.R_theta=1e3"]
    missed = CliRunner().invoke(main, ["verify", "4.7", *changed])
    assert "NOT reached: 4 of 4 target poles" in missed.output.splitlines()[1]
    assert "NOT reached" not in CliRunner().invoke(main, ["verify", "4.7"]).output


BOUNDED = """
[plant]
problem = "standard"
G = "1/(q - 0.9)"
[signals]
w = { white_noise = 1.0 }
[target]
model = "filter"
numerator = [0.0, 1.0]
denominator = [1.0, -1.2, 0.4]
[controller]
n_c = 3
R_theta = 1e-4
[run]
steps = 300
"""


def test_poles_that_bounds_keep_from_their_places_are_no_failure(tmp_path):
    stored = "bounds = { low = -0.01, high = 0.01 }"
    for name, more in (("free", ""), ("held", stored)):
        text = BOUNDED.replace("R_theta = 1e-4", f"R_theta = 1e-4\n{more}")
        (tmp_path / f"{name}.toml").write_text(text)
    free, stored = (
        " ".join(CliRunner().invoke(main, ["verify", str(tmp_path / name)]).output.split())
        for name in ("free.toml", "held.toml")
    )
    words = "the bounds decide the poles"
    assert "NOT reached" in free and words not in free
    assert "NOT reached" not in stored and words in stored
