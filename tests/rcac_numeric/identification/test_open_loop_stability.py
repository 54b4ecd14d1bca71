"""Unstable plants of records in open loop: every method refuses, or has the pole."""

import numpy as np
import pytest
from scipy.signal import lfilter

from compensator_theory.errors import UndecidedError
from rcac_numeric import ControllerLog
from rcac_numeric.designing._logs import LogSearch
from rcac_numeric.identification import (
    identify_output_error,
    identify_process,
    identify_step_response,
)
from rcac_numeric.identification._joint_stability import open_loop_gate

# Kind of noise, its size, steps of u held, steps and seed.
RECORDS = [("white", 0.001, 5, 300, 8), ("armax", 0.1, 17, 100, 14), ("armax", 0.001, 5, 200, 19)]


def growing(noise, size, hold, steps, seed):
    """y = 0.5/(q - 1.02) u + noise: 20 to 2000 times larger at its end."""
    rng = np.random.default_rng(seed)
    u = np.repeat(rng.choice([-1.0, 1.0], steps // hold + 1), hold)[:steps]
    u[:10] = 0.0
    e = size * rng.standard_normal(steps)
    y = lfilter([0, 0.5], [1, -1.02], u)
    return u, 2.0 + y + (lfilter([1], [1, -1.02], e) if noise == "armax" else e)


@pytest.mark.costly
@pytest.mark.parametrize("record", RECORDS)
def test_a_growing_record_has_no_stable_model(record):
    u, y = growing(*record)
    try:
        model = identify_process(u, y)
    except UndecidedError as error:
        assert "unstable" in str(error)
    else:
        failed = [gate.name for gate in model.failed]
        assert "stability" in failed or abs(model.poles).max() == pytest.approx(1.02, abs=2e-3)
        search = LogSearch(ControllerLog(u[:, None], y[:, None]))
        fit = next(search.candidates())
        assert fit.is_unstable or "stability" in [
            gate.name for gate in search.first_gates(fit) if not gate.passed
        ]
    if len(u) >= 200:
        with pytest.raises(UndecidedError, match="seems unstable"):
            identify_output_error(u, y)


@pytest.mark.costly
@pytest.mark.parametrize("seed", [1, 2])
def test_a_step_test_of_an_unstable_plant(seed):
    """Without the gate it was an integrator with a lag of five times the record."""
    rng = np.random.default_rng(seed)
    u = np.where(np.arange(200) < 40, 0.0, 1.0)
    y = lfilter([0, 0.5], [1, -1.02], u) + 0.5 * rng.standard_normal(200)
    with pytest.raises(UndecidedError, match="stability: a long regression"):
        identify_step_response(u, y)


@pytest.mark.parametrize("late", [0, 15, 40])
def test_a_rise_is_no_growth(late):
    """An integrator with a lag of 30 steps, of whose response the record has the beginning.

    Its errors are those of the true model: of 40 records none fails, which is 6e-5 likely of a
    level of 0.2.
    """
    for seed in range(40):
        rng = np.random.default_rng(seed)
        u = np.where(np.arange(160) < 20, 0.0, 1.0)
        pole = np.exp(-1 / 30)
        x = lfilter(np.r_[np.zeros(late + 1), 1 - pole], np.convolve([1, -1], [1, -pole]), u)
        e = 0.3 * rng.standard_normal(160)
        assert open_loop_gate(u, x + e, late, e, 8).passed
