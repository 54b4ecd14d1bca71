"""A verification begins with the health of its loop, in text, on its page and in its record."""

import json

import pytest

from rcac_experiments import load_experiment, verify
from rcac_experiments.reports._cases import case_of
from rcac_experiments.reports._verification import verification_sheet
from rcac_numeric import loop_health, stability_margins
from rcac_numeric.reports._sheet import as_dict

MOTOR = """
title = "A motor with unit steps"
[plant]
problem = "servo"
G = "(0.0001*q + 0.00009)/(q**2 - 1.9*q + 0.9)"
[signals]
r = { step = 1.0 }
[target]
model = "fir"
[controller]
structure = "iir"
n_c = 4
R_theta = 1e-6
[run]
steps = 2000
"""


def codes(health):
    return [warning.code for warning in health.warnings]


@pytest.fixture(scope="module")
def motor(tmp_path_factory):
    file = tmp_path_factory.mktemp("motor") / "motor.toml"
    file.write_text(MOTOR)
    return verify(load_experiment(file))


def test_a_motor_that_blew_up_on_the_way_does_not_end_green(motor):
    run, health = motor.main.first.run, loop_health(motor)
    assert health == loop_health(run)
    sheet = verification_sheet(motor)
    assert [t.level for t in sheet.health][:3] == ["warning", "bad", "bad"]
    record = as_dict(sheet)
    assert record["health"]["signals"]["u"]["after"]["peak"] == abs(run.u).max()
    assert [w["code"] for w in record["warnings"]] == codes(health)
    assert all(w["next_step"] and w["sentence"] for w in record["warnings"])
    json.dumps(record, allow_nan=False)


@pytest.mark.costly
def test_text_and_page_begin_with_what_the_record_says(motor):
    text, body = str(motor), case_of(motor).body
    first = text.split("\n\n", maxsplit=1)[0]
    assert repr(motor) == first and "Warning (large transient)" in first
    assert body.index("Warning (large transient)") < body.index("The problem")


def test_the_boost_converter_says_its_gain_margin():
    verification = verify(load_experiment("examples/boost_converter.toml"))
    health = loop_health(verification)
    oracle = stability_margins(verification.main.first.loop).gain_up.value
    assert oracle < 1.5 and health.margins["u"].gain_up.value == oracle
    assert "small margins" in codes(health)
    assert f"unstable with {oracle:.3g} times the gain" in str(verification).split("The problem")[0]
    assert health.is_stable and "NOT reached" not in str(verification), (
        "an example shows what works"
    )
