"""The command `rcac step`: a spreadsheet of a step test, and its refusals."""

import json
import shlex

import numpy as np
import pytest
from click.testing import CliRunner

from rcac_experiments.cli._main import main

ROWS = 200


def rcac(*arguments):
    return CliRunner().invoke(main, [str(one) for one in arguments])


def heater(path, first=0):
    """A spreadsheet in German of a heater that is stepped at 80 s; rows before `first` are cut."""
    t = 2.0 * np.arange(ROWS)
    u = np.where(t < 80, 40.0, 60.0)
    y = 23.5 + 0.6 * 20 * (1 - np.exp(-np.maximum(t - 80 - 10, 0) / 50))
    y += 0.1 * np.random.default_rng(3).standard_normal(ROWS)
    lines = ["Zeit;Heizung [%];Temperatur [degC]"]
    for k in range(first, ROWS):
        stamp = f"01.02.2024 10:{int(t[k]) // 60:02}:{int(t[k]) % 60:02}"
        lines.append(f"{stamp};{u[k]:g};" + f"{y[k]:.2f}".replace(".", ","))
    path.write_text("\n".join(lines))
    return path


NAMES = ("--names", "u=Heizung,y=Temperatur")


@pytest.mark.costly
def test_a_spreadsheet_to_the_command_of_a_design(tmp_path):
    path, picture = heater(tmp_path / "heater.csv"), tmp_path / "heater.svg"
    result = rcac("step", path, *NAMES, "--plot", picture)
    assert result.exit_code == 0, result.output
    assert picture.exists() and "rcac design" in result.output
    record = json.loads(rcac("step", path, *NAMES, "--json").output)["step_response"]
    assert record["sample_time"] == 2.0
    assert record["gain"] == pytest.approx(0.6, rel=0.05)
    low, high = record["dead_time_interval"]
    assert low - 2 < 10 < high + 2
    command = next(line for line in result.output.splitlines() if line.startswith("Next: "))
    assert record["plant"] in command and f"--dead-time {record['dead_time']:.4g}" in command
    line = command.replace("Next: rcac ", "").replace("SIZE", "20").replace("LOW,HIGH", "-40,40")
    design = rcac(*shlex.split(line), "--seeds", 1)
    assert "missing" not in design.output and design.exit_code in (0, 1), design.output


def test_a_record_after_its_step_and_a_column_that_is_not_there(tmp_path):
    path = heater(tmp_path / "late.csv", first=45)
    result = rcac("step", path, *NAMES)
    assert result.exit_code == 2 and "before the step" in result.output
    result = rcac("step", path)
    assert result.exit_code == 2 and "--names" in result.output


@pytest.mark.parametrize(
    "names",
    ["y=T, degC,u=Valve, zone 1", "u=Valve, zone 1, y=T", " u = Valve, zone 1,y=T,"],
)
def test_names_of_columns_hold_commas_and_units(tmp_path, names):
    path = tmp_path / "valve.csv"
    rows = "".join(f"{k},{float(k > 20)},{20 + 3 * (k > 25)}.5\n" for k in range(60))
    path.write_text(f'time (s),"Valve, zone 1","T, degC"\n{rows}')
    result = rcac("log", path, "--names", names)
    assert result.exit_code == 0, result.output
    used = result.output.partition("Used by")[2].split()
    assert used[-6:] == ["u", "Valve,", "zone", "1", "y", "T"]
