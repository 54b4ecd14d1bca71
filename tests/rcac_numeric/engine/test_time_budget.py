"""The kernel comes back in time, whatever a step costs, and where it is cut changes nothing."""

import _thread
import threading
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from rcac_numeric import (
    ControllerSettings,
    FunctionPlant,
    SimulationCase,
    fir_target,
    iir,
    simulate,
    simulate_many,
    standard_plant,
)
from rcac_numeric.engine import _kernel
from rcac_numeric.engine.jobs import PreparedRun
from tests.support.comparisons import same
from tests.support.engine_cases import cases, engine_plants
from tests.support.strategies import seeds, sizes

BODY = standard_plant("(q - 0.5)/(q*(q - 0.9))")


def rcac(l_theta, **options):
    return ControllerSettings(
        structure=iir(l_theta // 2), target=fir_target(BODY), R_theta=1.0, **options
    )


def slow(k, x, u, w):
    time.sleep(1e-3)
    return 0.5 * x + u + w


def slow_later(k, x, u, w):
    return slow(k, x, u, w) if k > 1000 else 0.5 * x + u + w


def function_plant(advance):
    one = {"n": 1, "l_u": 1, "l_w": 1, "l_y": 1, "l_z": 1}
    return FunctionPlant(advance=advance, output=lambda k, x, w: (x, x), **one)


EXPENSIVE = {
    "l_theta = 500": (BODY, rcac(500), 1, False),
    "l_theta = 500, as printed": (BODY, rcac(500, update="covariance"), 1, False),
    "l_theta = 500 in lanes": (BODY, rcac(500), 8, True),
    "l_theta = 500, eight runs": (BODY, rcac(500), 8, False),
    "l_theta = 500 from step 20000 on": (BODY, rcac(500, k_update=20_000), 1, False),
    "a window of 200": (BODY, rcac(40, update="sliding window", window=200), 1, False),
    "a slow plant": (function_plant(slow), rcac(8), 1, False),
    "a plant that becomes slow": (function_plant(slow_later), rcac(8), 1, False),
}


@pytest.mark.parametrize("name", EXPENSIVE)
def test_the_kernel_comes_back(name):
    """After 0.05 s and a step: 1 s is for a machine that has other things to do."""
    plant, settings, count, lanes = EXPENSIVE[name]
    w = np.random.default_rng(0).standard_normal((30_000, 1))
    runs = [PreparedRun(plant, settings, w, stride=len(w)) for _ in range(count)]
    start, longest = time.perf_counter(), 0.0
    while time.perf_counter() - start < 0.7:
        before, done = time.perf_counter(), sum(run.job.done for run in runs)
        more = _kernel.run_jobs([run.job for run in runs], 2, 0.05, lanes)
        longest = max(longest, time.perf_counter() - before)
        assert sum(run.job.done for run in runs) > done
        if not more:
            break
    assert longest < 1.0


@given(sizes, sizes, sizes, seeds, st.data())
@hypothesis_settings(max_examples=15)
def test_where_it_is_cut_changes_nothing(l_u, l_y, l_z, seed, data):
    settings, _ = data.draw(cases(l_u, l_y, l_z))
    plant, rng = data.draw(engine_plants(l_u, l_y, l_z)), np.random.default_rng(seed)
    noise = [rng.standard_normal((60, plant.l_w)) for _ in range(3)]
    for lanes in (False, True):
        results = []
        for seconds in (0.0, 1e-5, 1e9):
            runs = [PreparedRun(plant, settings, w) for w in noise]
            while _kernel.run_jobs([run.job for run in runs], 1, seconds, lanes):
                pass
            results.append([run.result() for run in runs])
        for cut in results[:2]:
            assert all(same(a, b) for a, b in zip(cut, results[2], strict=True))


def test_no_time_at_all_is_one_step():
    run = PreparedRun(BODY, rcac(4), np.ones((5, 1)))
    for done in range(1, 6):
        assert _kernel.run_jobs([run.job], 1, 0.0) == (done < 5)
        assert run.job.done == done
    assert not _kernel.run_jobs([run.job], 1, 0.0)


@pytest.mark.parametrize("lanes", [None, False, True])
def test_a_key_is_answered(lanes):
    """Within 0.1 s on an idle machine, instead of after 65536 steps."""
    w = np.random.default_rng(0).standard_normal((200_000, 1))
    case = SimulationCase(BODY, rcac(500), w, {"stride": len(w)})
    pressed = []

    def press():
        pressed.append(time.perf_counter())
        _thread.interrupt_main()

    threading.Timer(0.5, press).start()
    with pytest.raises(KeyboardInterrupt):
        if lanes is None:
            simulate(BODY, case.settings, w, stride=len(w))
        else:
            simulate_many([case] * 3, threads=2, lanes=lanes)
    assert time.perf_counter() - pressed[0] < 1.0
