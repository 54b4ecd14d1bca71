"""The command `rcac log`, and logs at the commands that read them."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from rcac_experiments.cli._main import main


def rcac(*arguments):
    return CliRunner().invoke(main, [str(one) for one in arguments])


@pytest.fixture
def heater(tmp_path):
    """A spreadsheet in German: stamps, units, decimal comma, a column of texts."""
    rng, y = np.random.default_rng(0), 0.0
    lines = ["Zeit;Modus;Heizung [%];Temperatur [°C]"]
    for k in range(60):
        u = float(rng.integers(0, 100))
        y += 0.1 * (u / 10 - y)
        stamp = f"01.02.2024 10:{k // 60:02}:{k % 60:02}"
        lines.append(f"{stamp};AUTO;{u:g};" + f"{y:.2f}".replace(".", ","))
    path = tmp_path / "heater.csv"
    path.write_text("\n".join(lines), encoding="latin-1")
    return path


def test_the_report_and_its_record(heater):
    result = rcac("log", heater)
    assert result.exit_code == 1 and "has no 'u'" in result.output
    assert "decimal comma" in result.output and "latin-1" in result.output
    result = rcac("log", heater, "--names", "u=Heizung,y=Temperatur", "--json")
    assert result.exit_code == 0, result.output
    record = json.loads(result.output)["log"]
    assert record["clocks"][""]["sample_time"] == 1.0 and record["refused"] is None
    columns = {column["name"]: column for column in record["columns"]}
    assert columns["Heizung"]["unit"] == "%" and columns["Heizung"]["used_as"] == "u"
    assert columns["Temperatur"]["rounding"]["quantum"] == 0.01
    assert columns["Modus"]["problem"] and columns["Zeit"]["used_as"] == "time"


@pytest.mark.parametrize("width", ["40", "80", "200"])
def test_a_long_name_can_be_copied_from_the_report(tmp_path, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", width)
    names = [
        f"Reactor jacket cooling water {side} temperature measured and filtered"
        for side in ("inlet", "outlet")
    ]
    path = tmp_path / "log.csv"
    rows = [f"{k};{k % 7};{k // 10 % 2}" for k in range(80)]
    path.write_text("\n".join([";".join(["time", *names]), *rows]))
    refused = rcac("log", path)
    assert f'--names "u={names[0]}"' in refused.output
    result = rcac("log", path, "--names", f"u={names[1]},y={names[0]}")
    lines = [line.strip() for line in result.output.splitlines()]
    for name in names:
        assert sum(line.endswith(f"] {name}") for line in lines) == 1, result.output
    assert width == "40" or any(" used" in line for line in lines), result.output


@pytest.mark.parametrize(
    ("contents", "options", "words"),
    [
        ("1,2\n3,4\n", (), "--columns t,u,y"),
        ("1,2\n3,4\n", ("--columns", "u"), "has 2 columns, and 1 names"),
        ("1,2\n3,4\n", ("--columns", "u,u"), "distinct name"),
        ("t,u,y\n0,1,2\n1,2,3\n", ("--time", "clock"), "no column 'clock' with times"),
        ("", (), "is empty"),
        ("\0\1\2" * 99, (), "null characters"),
    ],
)
def test_bad_logs(tmp_path, contents, options, words):
    path = tmp_path / "log.csv"
    path.write_text(contents)
    result = rcac("log", path, *options)
    assert result.exit_code in {1, 2} and words in result.output, result.output


def test_the_shell_is_told_its_own_options(tmp_path):
    t = np.cumsum(np.random.default_rng(1).exponential(0.1, 300))
    path = tmp_path / "log.csv"
    np.savetxt(
        path, np.c_[t, np.sign(np.sin(t)), np.sin(t)], delimiter=",", header="t,u,y", comments=""
    )
    for command in (("check", "--controller", "0.5/q"), ("design", "--assume")):
        result = rcac(command[0], path, *command[1:])
        assert result.exit_code == 2 and "--resample" in result.output, result.output
        assert "--time none" in result.output
    result = rcac("check", path, "--controller", "0.5/q", "--resample", 0.05)
    assert "interpolated" in result.output and result.exit_code == 1


def test_a_check_has_the_time_of_the_log(tmp_path):
    """A contradicting sample time is refused; without one margins have seconds."""
    rng, y, rows = np.random.default_rng(2), 0.3, []
    for k in range(80):
        u = -1.9 * y
        rows.append((0.02 * k, u, y))
        y = 2 * y + u + 0.01 * rng.standard_normal()
    path = tmp_path / "log.csv"
    np.savetxt(path, rows, delimiter=",", header="t [s],u,y", comments="", fmt="%.17g")
    options = ("--controller", "-1.9", "--plant", "1/(q - 2)", "--problem", "standard")
    result = rcac("check", path, *options)
    assert result.exit_code == 0, result.output
    assert "sample time 0.02 s, from t [s]" in result.output
    assert " s" in result.output.split("delay")[1].split("\n")[0]
    result = rcac("check", path, *options, "--sample-time", 0.2)
    assert result.exit_code == 2 and "is sampled every 0.02 s" in result.output


@pytest.fixture(scope="module")
def step_test(tmp_path_factory):
    """A heater of 35 s, with a row every second."""
    t, rng = np.arange(444), np.random.default_rng(0)
    y = 21 + 8 * (1 - np.exp(-np.maximum(t - 88, 0) / 35)) + 0.05 * rng.standard_normal(444)
    path = tmp_path_factory.mktemp("step") / "heater.csv"
    rows = [f"{k},{40 + 10 * (k >= 80)},{y[k]:.4f}" for k in t]
    path.write_text("\n".join(["t,u,y", *rows]))
    return path


@pytest.mark.parametrize("command", [("step",), ("design", "--assume")])
@pytest.mark.parametrize("clock", [(), ("--resample", "1")])
def test_no_command_takes_another_sample_time_than_that_of_the_log(step_test, command, clock):
    result = rcac(command[0], step_test, *command[1:], *clock, "--sample-time", 2)
    assert result.exit_code == 2, result.output
    assert "is sampled every 1 s by " in result.output
    assert "sample_time = 2. Leave sample_time out" in result.output


@pytest.mark.costly
@pytest.mark.parametrize("command", [("step",), ("design", "--assume", "--seeds", "1")])
def test_the_report_of_a_resampled_log_states_its_error(step_test, command):
    result = rcac(command[0], step_test, *command[1:], "--resample", 1)
    assert result.exit_code in {0, 1}, result.output  # 1: u = 0 is as good
    assert "y: interpolated; a sample is predicted from its neighbours" in result.output
    record = json.loads(rcac(command[0], step_test, *command[1:], "--json").output)
    assert record["log"]["clock"] == "sample time 1 s, from t [s, assumed]"
    assert record["log"]["notes"] == []


@pytest.mark.costly
def test_steps_are_no_seconds(step_test):
    result = rcac("step", step_test, "--time", "none")
    assert result.exit_code == 0 and " steps" in result.output
    assert 'rcac design "' not in result.output
    assert "Next: the same command with --sample-time SECONDS" in result.output
    result = rcac("step", step_test, "--time", "none", "--sample-time", 1)  # 2 s for the controller
    assert 'Next: rcac design "' in result.output and "--sample-time 2 " in result.output


def test_a_log_that_is_read_and_cannot_be_used_has_the_status_of_one(tmp_path):
    path = tmp_path / "overflow.csv"
    path.write_text("u,y\n" + "1e999,2\n" + "1,2\n" * 40)
    result = rcac("log", path)
    assert result.exit_code == 1 and "infinite" in result.output
