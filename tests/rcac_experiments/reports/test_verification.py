"""The report of a verification: the health of the loop first, then what changed; its record."""

import pytest

from rcac_experiments import verify
from rcac_experiments.dissertation import load_example
from rcac_experiments.experiments._experiment import Claim
from rcac_experiments.reports._verification import verification_sheet
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.reports._sheet import as_dict
from rcac_numeric.reports._terminal import as_text


@pytest.fixture(scope="module")
def example():
    return verify(load_example("4.7"))


def test_a_verification_begins_with_the_health_of_the_loop(example):
    sheet = verification_sheet(example)
    assert "is stable, spectral radius 0." in sheet.health[0].words
    assert sheet.health[0].level == "warning"  # 4.7 has a gain margin of 4 %
    lines = as_text(sheet).split("\n")
    assert "stable" in lines[1] and not any("changed" in line for line in lines)


def test_the_record_holds_what_scripts_read(example):
    record = as_dict(verification_sheet(example))
    assert record.keys() >= {
        "id", "title", "claims", "runs", "match", "residual", "poles", "requested_poles", "zeros",
        "characteristic_polynomial", "worst_pole_distance", "controller_distance",
    }  # fmt: skip
    assert record["runs"][0].keys() >= {
        "name", "arithmetic", "outcome", "expected", "steps", "updates_decided_by_rounding",
        "theta",
    }  # fmt: skip
    comparison = example.main.first.comparison
    assert [complex(*p) for p in record["poles"]] == list(comparison.poles)
    assert record["characteristic_polynomial"]["requested"] == [
        str(c) for c in comparison.requested.all_coeffs()
    ]


def test_a_changed_verdict_is_said_first(example):
    """A claim whose verdict of record is another one."""
    first = example.verdicts[0]
    claim = replace(first.claim, recorded="not reproduced")
    assert isinstance(claim, Claim)
    changed = replace(example, verdicts=(replace(first, claim=claim), *example.verdicts[1:]))
    sheet = verification_sheet(changed)
    assert [t.level for t in sheet.health][:2] == ["warning", "bad"]
    assert "1 of the recorded verdicts changed" in sheet.health[1].words
    assert "recorded verdict:" in as_text(sheet)
