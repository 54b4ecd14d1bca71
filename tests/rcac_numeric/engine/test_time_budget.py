"""The kernel comes back in time, whatever a step costs, and where it is cut changes nothing."""

import _thread
import threading
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import rcac_numeric as rn
from rcac_numeric.compiled import _kernel
from tests.support.comparisons import same
from tests.support.engine_cases import cases, engine_plants
from tests.support.lane_cases import ready_run
from tests.support.strategies import seeds, sizes

BODY = rn.standard_plant("(q - 0.5)/(q*(q - 0.9))")


def rcac(l_theta, update=rn.UD(R_theta=1.0), **options):
    return rn.ControllerSettings(
        structure=rn.iir(l_theta // 2), target=rn.fir_target(BODY), update=update, **options
    )


EXPENSIVE = {
    "l_theta = 500": (rcac(500), 1, False),
    "l_theta = 500, as printed": (rcac(500, rn.Covariance(R_theta=1.0)), 1, False),
    "l_theta = 500 in lanes": (rcac(500), 8, True),
    "l_theta = 500, eight runs": (rcac(500), 8, False),
    "a window of 200": (rcac(40, rn.SlidingWindow(R_theta=1.0, window=200)), 1, False),
}


@pytest.mark.costly
@pytest.mark.parametrize("name", EXPENSIVE)
def test_no_time_at_all_is_one_step(name):
    """However much a step costs, and in lanes one of each."""
    settings, count, lanes = EXPENSIVE[name]
    w = np.random.default_rng(0).standard_normal((5, 1))
    runs = [ready_run(BODY, settings, w, stride=len(w)) for _ in range(count)]
    jobs = [run.job for run in runs]
    together = count if lanes else 1  # one after another, the next begins when there is time
    for built in range(together, 5 * count + 1, together):
        assert _kernel.run_jobs(jobs, 2, 0.0, lanes) == (built < 5 * count)
        assert sum(job.done for job in jobs) == built
    assert not _kernel.run_jobs(jobs, 2, 0.0, lanes)


QUICK, SLOW = range(10**6), range(0)
SECONDS, MOST = 0.2, 64  # of a slice; steps between two looks at the clock


@pytest.mark.parametrize(("quick", "last"), [(QUICK, 1000), (SLOW, 20), (range(500), 600)])
def test_few_steps_are_begun_when_the_time_is_up(quick, last):
    """The time is up in step `last` at the latest, which waits for it; the steps are counted.

    From the second look on a slow step is followed by a look at the clock, however quick those
    before it were.
    """
    begun = []

    def advance(k, x, u, w):
        begun.append(time.perf_counter())
        if k not in quick:
            time.sleep(1e-3)
        while k == last and time.perf_counter() <= begun[0] + SECONDS:
            time.sleep(1e-3)
        return 0.5 * x + u + w

    one = {"n": 1, "l_u": 1, "l_w": 1, "l_y": 1, "l_z": 1}
    plant = rn.FunctionPlant(advance=advance, output=lambda k, x, w: (x, x), **one)
    run = ready_run(plant, rcac(8), np.zeros((30_000, 1)), stride=30_000)
    assert _kernel.run_jobs([run.job], 1, SECONDS)
    assert run.job.done == len(begun)
    late = sum(moment > begun[0] + SECONDS for moment in begun)
    slow = sum(k not in quick for k in range(len(begun) - late))
    assert late <= (1 if slow > MOST or not quick else MOST)


@pytest.mark.costly
@given(sizes, sizes, sizes, seeds, st.data())
@hypothesis_settings(max_examples=15)
def test_where_it_is_cut_changes_nothing(l_u, l_y, l_z, seed, data):
    settings, _ = data.draw(cases(l_u, l_y, l_z))
    plant, rng = data.draw(engine_plants(l_u, l_y, l_z)), np.random.default_rng(seed)
    noise = [rng.standard_normal((60, plant.l_w)) for _ in range(3)]
    for lanes in (False, True):
        results = []
        for seconds in (0.0, 1e-5, 1e9):
            runs = [ready_run(plant, settings, w) for w in noise]
            while _kernel.run_jobs([run.job for run in runs], 1, seconds, lanes):
                pass
            results.append([run.result() for run in runs])
        for cut in results[:2]:
            assert all(same(a, b) for a, b in zip(cut, results[2], strict=True))


class Watched:
    """The kernel, where a key is pressed in the middle of the third slice."""

    def __init__(self):
        self.slices, self.after, self.is_pressed = 0, 0, False
        self.run_as_before = _kernel.run_jobs
        self.thread = threading.Thread(target=self.press)

    def press(self):
        _thread.interrupt_main()
        self.is_pressed = True

    def run_jobs(self, jobs, threads, seconds, lanes):
        assert seconds <= 0.1, "what a key waits for"
        self.slices, self.after = self.slices + 1, self.after + self.is_pressed
        if self.slices == 3:
            self.thread.start()
        return self.run_as_before(jobs, threads, seconds, lanes)


@pytest.mark.parametrize("lanes", [None, False, True])
def test_a_key_is_answered(lanes, monkeypatch, at_a_terminal):
    """At the end of the slice in which it was pressed."""
    w = np.random.default_rng(0).standard_normal((50_000, 1))
    case = rn.SimulationCase(BODY, rcac(500), w, {"stride": len(w)})
    kernel = Watched()
    monkeypatch.setattr(_kernel, "run_jobs", kernel.run_jobs)
    with pytest.raises(KeyboardInterrupt):
        if lanes is None:
            rn.simulate(BODY, case.settings, w, stride=len(w))
        else:
            rn.simulate_many([case] * 3, threads=2, lanes=lanes)
    kernel.thread.join()
    assert kernel.is_pressed and kernel.after == 0
