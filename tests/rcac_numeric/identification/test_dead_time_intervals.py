"""The interval of the dead time holds that of the plant in continuous time, whatever the stamps."""

import numpy as np
import pytest

from compensator_theory.errors import InputError
from rcac_numeric import ControllerLog, read_log
from rcac_numeric.designing._logs import plant_from_log
from rcac_numeric.identification import identify_process

ROWS = 300


def table_of(seed, stamps, sample_time=0.5):
    """A log of one or two lags behind a dead time, whose u moves at its rows, and the dead time."""
    rng = np.random.default_rng([15, seed])
    t = np.arange(ROWS) + rng.uniform(-0.1, 0.1, ROWS) * (stamps == "jitter")
    if stamps == "irregular":
        t = np.cumsum(rng.uniform(0.4, 1.6, ROWS))
    T, late = rng.uniform(4, 15), rng.uniform(0, 12)
    lags = (T, rng.uniform(0.2, 0.7) * T) if rng.random() < 0.5 else (T, 0.0)
    u = np.repeat(rng.choice([-1.0, 0.0, 1.0], ROWS), max(2, int(T)))[:ROWS]
    u[:8] = 0.0
    moves = np.flatnonzero(np.diff(u, prepend=0.0))
    after = np.maximum(t[:, None] - t[moves] - late, 0.0)
    responses = 1 - sum(
        sign * lag * np.exp(-after / lag) / (lags[0] - lags[1])
        for sign, lag in zip((1, -1), lags, strict=True) if lag
    )  # fmt: skip
    y = responses @ np.diff(u, prepend=0.0)[moves]
    y += 0.03 * y.std() * rng.standard_normal(ROWS)
    return {"t": sample_time * t, "u": u, "y": y}, sample_time * late


def interval_of(table, sample_time=0.5, resample=None):
    log = read_log(table, resample=resample)
    model = identify_process(log.u, log.y, sample_time=sample_time, time_skew=log.time_skew)
    return model.dead_time_interval


@pytest.mark.costly
@pytest.mark.parametrize("stamps", ["regular", "jitter", "irregular"])
def test_95_percent_hold_the_dead_time(stamps):
    """Fewer than 16 of 20 have probability 3e-4 where 95 % hold it."""
    resample = 0.5 if stamps == "irregular" else None
    count = 0
    for seed in range(20):
        table, late = table_of(seed, stamps)
        low, high = interval_of(table, resample=resample)
        count += low <= late <= high
    assert count >= 16


@pytest.mark.costly
def test_the_interval_is_a_step_wide_at_least_and_narrow():
    table, late = table_of(3, "regular")
    low, high = interval_of(table)
    assert low <= late <= high and 0.5 <= high - low < 2.5


def test_resampled_stamps_give_the_lag_of_the_moves():
    """u moves at 1.3, 2.6 and 3.9 s; steps of 1 s show it 0.7, 0.4 and 0.1 s later."""
    t = np.array([0.0, 0.9, 1.3, 2.1, 2.6, 3.2, 3.9, 4.5, 5.6])
    u = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0])
    log = read_log({"t": t, "u": u, "y": t}, resample=1.0)
    assert log.time_skew == pytest.approx((0.1 + 0.05 * 0.3, 0.7 - 0.05 * 0.3))
    assert log.notes[0].endswith("0.115 to 0.685 s late")
    at_steps = read_log({"t": np.arange(9.0), "u": u, "y": u}, resample=1.0)
    assert at_steps.time_skew == (0.0, 0.0)


def test_jitter_of_rows_is_a_skew_of_either_sign_and_coarse_stamps_are_none():
    rng = np.random.default_rng(1)
    t = 0.1 * np.arange(400) + 0.01 * rng.uniform(-1, 1, 400)
    signals = {"u": rng.standard_normal(400), "y": rng.standard_normal(400)}
    low, high = read_log({"t": t, **signals}).time_skew
    assert -0.02 < low < -0.01 and 0.01 < high < 0.02
    assert read_log({"t": np.floor(0.1 * np.arange(400)), **signals}).time_skew == (0.0, 0.0)


@pytest.mark.costly
def test_the_skew_of_a_log_widens_the_intervals_of_its_model():
    table, _ = table_of(5, "regular")
    plain, skewed = (
        plant_from_log(ControllerLog(
            table["u"], table["y"], sample_time=0.5, time_skew=skew
        ), 0.5)
        for skew in ((0.0, 0.0), (-0.1, 0.7))
    )  # fmt: skip
    (low, high), (least, most) = (one.model.dead_time_interval for one in (plain, skewed))
    assert least == pytest.approx(max(low - 0.1, 0.0)) and most == pytest.approx(high + 0.7)
    first, last = plain.model.delay_interval
    assert skewed.model.delay_interval == (max(first - 1, 0), last + 2)
    assert f"to {most / 0.5:.4g} steps" in skewed.evidence
    assert f"to {most:.4g} s" in str(skewed.model)


@pytest.mark.parametrize("skew", [(1.0, 0.0), (0.0,), (0.0, np.nan)])
def test_a_skew_is_two_numbers_in_order(skew):
    with pytest.raises(InputError, match="time_skew"):
        ControllerLog([0.0, 1.0], [0.0, 1.0], time_skew=skew)
