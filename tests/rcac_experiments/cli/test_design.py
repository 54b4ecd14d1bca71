"""The command `rcac design`: what it says, asks, refuses and writes."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.signal import lfilter

from rcac_experiments import load_experiment
from rcac_experiments.cli import _design as command
from rcac_experiments.cli._main import main
from rcac_numeric import CertifiedBounds

KNOWN = ("--disturbance", "0.5", "--noise", "0.01", "--u-limits", "-2,2", "--seeds", "1")
LAG = ("1/(8*s + 1)", "--sample-time", "1", "--dead-time", "2")


def run(*arguments, answers=None):
    return CliRunner().invoke(main, ["design", *map(str, arguments)], input=answers)


def test_a_plant_becomes_a_file(tmp_path):
    path = tmp_path / "tuned.toml"
    result = run(*LAG, *KNOWN, "-o", path)
    assert result.exit_code == 0, result.output
    assert "Use " in result.output and str(path) in result.output
    experiment = load_experiment(path)
    assert set(experiment.runs) == {"RCAC", "fixed"}
    assert experiment.main_run.saturation.high == 2.0


@pytest.mark.costly
def test_the_record_is_json():
    record = json.loads(run(*LAG, *KNOWN, "--json").output)
    assert record["verdict"]["use"] in ("RCAC", "fixed")
    assert {one["controller"] for one in record["evidence"]} == {"RCAC", "fixed", "SIMC PID"}
    assert {one["name"] for one in record["verdict"]["questions"]} == {
        "plant", "dead_time", "disturbance"
    }  # fmt: skip


def test_in_a_pipe_what_nobody_said_is_refused_by_name():
    result = run(*LAG, "--noise", "0.01")
    assert result.exit_code == 2
    assert "--disturbance, --u-limits" in result.stderr and "--assume" in result.stderr
    assert "--noise," not in result.stderr


def test_at_a_terminal_it_is_asked(monkeypatch):
    monkeypatch.setattr(command, "at_a_terminal", lambda: True)
    result = run(*LAG, "--seeds", "1", answers="0.5\nunknown\n-2,2\n")
    assert result.exit_code == 0, result.output
    assert "Size of the disturbance" in result.output
    assert "noise: 0.00" in result.output and "u_limits" not in result.output


@pytest.mark.parametrize("terminal", [True, False])
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("2/(10 s+1)",), "spell products out"),
        (("1/(8*s + 1)",), "sample_time"),
        (("1/(q - 1",), "cannot read"),
        ((*LAG[:-1], "1, x"), "--dead-time"),
        (("nowhere.toml",), "nowhere.toml"),
    ],
)
def test_what_cannot_be_read_is_said_before_anything_is_asked(
    arguments, words, terminal, monkeypatch
):
    monkeypatch.setattr(command, "at_a_terminal", lambda: terminal)
    result = run(*arguments)
    assert result.exit_code == 2 and words in result.stderr
    assert "Size of" not in result.output and "not given" not in result.stderr


@pytest.mark.parametrize("word", ["none", "0"])
def test_no_disturbance_can_be_said(word):
    argument = ("--noise", "0.01", "--u-limits", "none", "--seeds", "1", "--command", "1")
    result = run(*LAG, "--disturbance", word, *argument)
    assert result.exit_code == 0, result.output
    assert "Assumed for disturbance" not in result.output
    nothing = run(*LAG, "--disturbance", word, *argument[:-2])
    assert nothing.exit_code == 2 and "nothing to control" in nothing.stderr


def test_where_no_control_is_better_the_status_is_1(tmp_path):
    file = tmp_path / "square.toml"
    values = ", ".join(["1.0, 1.0, -1.0, -1.0"] * 1000)
    file.write_text(
        '[plant]\nproblem = "servo"\nG = "0.5/(q**3*(q - 0.5))"\n'
        f"[signals]\nd = {{ recorded = [{values}] }}\nv = {{ white_noise = 0.01 }}\n"
    )
    result = run(file, "--u-limits", "none", "--seeds", "1")
    assert result.exit_code == 1 and "Use no controller" in result.output, result.output


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("1/(8*s + 1)", "--assume"), "sample_time"),
        (("1/(8*s + 1)", "--assume", "--dead-time", "1, x"), "--dead-time 1, x: write seconds"),
        ((*LAG[:-1], "1, 2", "--assume"), "rows of transfer functions"),
        ((*LAG, "--assume", "--noise", "some"), "--noise some: write a number"),
        ((*LAG, "--assume", "--u-limits", "2"), "LOW,HIGH"),
        (("nowhere.toml", "--assume"), "nowhere.toml"),
        (("[[1/(s + 1), 1/s]]", "--assume"), "2 inputs and 1 outputs"),
        (("1/(s + 1), 1/s; 1", "--assume"), "rows of one and the same"),
        ((*LAG, "--assume", "--structure", "PX"), '--structure PX: write "PI"'),
        ((*LAG, "--assume", "--uncertain-gain", "2"), "--uncertain-gain 2: write LOW,HIGH"),
        ((*LAG, "--assume", "--feedforward"), "reads the command"),
    ],
)
def test_bad_input_has_status_2(arguments, words):
    result = run(*arguments)
    assert result.exit_code == 2 and words in result.stderr


def test_a_file_answers_what_it_can(tmp_path):
    file = tmp_path / "plant.toml"
    file.write_text(
        '[plant]\nproblem = "servo"\nG = "1/(q - 0.9)"\n[signals]\nv = { white_noise = 0.1 }\n'
    )
    result = run(file)
    assert result.exit_code == 2 and "--disturbance, --u-limits are" in result.stderr
    assert run(file, "--assume", "--seeds", "1").exit_code == 0


@pytest.mark.costly
def test_tune_writes_what_it_found(tmp_path):
    path = tmp_path / "tuned.toml"
    result = CliRunner().invoke(
        main,
        ["tune", "1/(q - 0.9)", "--disturbance", "1", "--noise", "0.05", "--u-limits", "none",
         "--budget", "2", "--held-out", "1", "-o", str(path)],
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    assert result.output.startswith("A tuned controller") and "Candidates" in result.output
    assert set(load_experiment(path).runs) == {"RCAC", "fixed"}


@pytest.mark.costly
def test_a_log_is_a_plant(tmp_path):
    rng = np.random.default_rng(2)
    u = rng.standard_normal(600)
    y = lfilter([0, 0, 0.2], [1, -0.8], u) + 0.02 * rng.standard_normal(600)
    path = tmp_path / "log.csv"
    np.savetxt(path, np.stack([u, y], axis=1), delimiter=",", header="u,y", comments="")
    result = run(path, "--assume", "--seeds", "1")
    assert result.exit_code == 0, result.output
    assert "the model of the log, order 1, delay 1" in result.output


def test_a_log_that_leaves_its_plant_open_is_status_1_and_no_controller(tmp_path):
    """A level jump beside the only step of u."""
    rng = np.random.default_rng(3)
    k = np.arange(400)
    y = 3.0 * (k >= 203) + 0.3 * rng.standard_normal(400)
    path = tmp_path / "log.csv"
    log = np.stack([1.0 * (k >= 200), y], axis=1)
    np.savetxt(path, log, delimiter=",", header="u,y", comments="")
    result = run(path, "--assume", "--seeds", "1")
    assert result.exit_code == 1, result.output
    assert "Use " not in result.output and "jumps" in result.output


@pytest.mark.costly
def test_a_certified_design_is_verified_and_exported(tmp_path):
    path, board = tmp_path / "kept.toml", tmp_path / "board"
    result = run(*LAG, *KNOWN[:4], "--u-limits", "none", "--seeds", "1", "--kept", "certified",
                 "--json", "-o", path)  # fmt: skip
    assert result.exit_code == 0, result.output
    record = json.loads(result.stdout)
    assert record["verdict"]["certified"]["reason"] is None
    assert record["verdict"]["guarantee"]["radius"] <= 1
    settings = load_experiment(path).runs["RCAC"].settings
    assert isinstance(settings.bounds, CertifiedBounds)
    exported = CliRunner().invoke(main, ["export", str(path), "-o", str(board), "--run", "RCAC"])
    assert exported.exit_code == 0, exported.output
    assert "the same bits" in exported.output


def test_only_the_two_ways_to_keep_theta_are_read():
    result = run(*LAG, *KNOWN, "--kept", "stable")
    assert result.exit_code == 2 and "--kept" in result.stderr and "certified" in result.stderr
