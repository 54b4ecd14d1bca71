"""What is reported of results: the numbers of the record are those of the sentences."""

import json
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from compensator_theory import place_poles
from rcac_numeric import Compensator, check_controller
from rcac_numeric.reports._check import check_sheet
from rcac_numeric.reports._loop import radius_text
from rcac_numeric.reports._observer import observer_sheet
from rcac_numeric.reports._placement import placement_sheet
from rcac_numeric.reports._sheet import as_dict
from rcac_numeric.reports._terminal import as_text
from tests.support.strategies import plants, seeds


@pytest.mark.costly
@settings(max_examples=15)
@given(plants(), seeds, st.integers(0, 2))
def test_any_check_has_a_strict_record_with_the_numbers_that_are_said(plant, seed, n_c):
    rng = np.random.default_rng(seed)
    compensator = Compensator(
        0.3 * rng.standard_normal((n_c, plant.l_u, plant.l_u)),
        np.concatenate([np.zeros((1, plant.l_u, plant.l_y)),
                        0.3 * rng.standard_normal((n_c, plant.l_u, plant.l_y))]),
    )  # fmt: skip
    u, y = np.zeros((30, plant.l_u)), rng.standard_normal((30, plant.l_y))
    for k in range(30):
        lags = range(min(k, n_c))
        u[k] = sum((compensator.past_u[i] @ u[k - i - 1] for i in lags), np.zeros(plant.l_u))
        u[k] += sum(compensator.past_y[i + 1] @ y[k - i - 1] for i in lags)
    check = check_controller(u, y, compensator=compensator, plant=plant)
    sheet = check_sheet(check)
    record = as_dict(sheet)
    json.dumps(record, allow_nan=False)
    foreign = check_controller(u + 1, y, compensator=compensator, plant=plant)
    other = as_dict(check_sheet(foreign))
    json.dumps(other, allow_nan=False)
    assert foreign.is_consistent or not {"loop", "margins", "costs"} & other.keys()
    doubt = record["plant_residual"] is not None and record["plant_residual"]["is_doubtful"]
    assert doubt == sheet.health[0].words.startswith("The log is NOT")
    stability = sheet.health[int(doubt)]
    assert record["loop"]["is_stable"] == (stability.level != "bad")
    assert (record["warnings"] == []) == (stability.level == "good")
    assert f"radius {radius_text(record['loop']['spectral_radius'])}." in stability.words
    assert record["margins"].keys() == check.margins.keys()
    assert record["unanswered"] == check.unanswered and as_text(sheet) == check.report()
    assert pickle.loads(pickle.dumps(check)) == check


def test_a_placement_and_the_observer_question():
    placed = placement_sheet(place_poles("4/((s + 1)*(s + 3))", [-6, -5, -4, -2], feedback=-1))
    assert "G_c = (33*s/4 + 93/4)/(s**2 + 13*s + 49)" in as_text(placed)
    assert as_dict(placed)["denominator"] == ["1", "13", "49"]
    observer = observer_sheet("1/(s^3 + s)", "(s^2 + s + 1)/(s^3 + s + 5)", -1)
    record = as_dict(observer)
    assert len(record["float64_forms"]) == record["decisions"]["pair"]["number_of_forms"]
    assert "float64: 4 observer-based forms" in as_text(observer)
