"""Ctrl-C: what had been computed is kept, and what had ended before keeps its outcome."""

import numpy as np
import pytest

import rcac_numeric as rn
from rcac_numeric.compiled import _kernel

PLANT = rn.standard_plant("1/(q - 0.9)")
UNSTABLE = rn.standard_plant("1/(q - 2)")
LONG = np.random.default_rng(0).standard_normal((2000, 1))


def rcac(n_c, plant=PLANT):
    return rn.ControllerSettings(
        structure=rn.iir(n_c), target=rn.fir_target(plant), update=rn.UD(R_theta=1.0)
    )


@pytest.fixture
def pressed(monkeypatch):
    """A key is pressed after so many looks at the keyboard, one step of every job apart."""
    run_jobs = _kernel.run_jobs

    class Kernel:
        looks = 0

        def run_jobs(self, jobs, threads, seconds, lanes):
            self.looks -= 1
            if self.looks < 0:
                raise KeyboardInterrupt
            return run_jobs(jobs, threads, 0.0, lanes)

    kernel = Kernel()
    monkeypatch.setattr(_kernel, "run_jobs", kernel.run_jobs)
    return kernel


def test_a_run_goes_on_where_it_was_interrupted(pressed, monkeypatch):
    pressed.looks = 30
    with pytest.raises(rn.RunInterrupted) as caught:
        rn.simulate(PLANT, rcac(4), LONG)
    monkeypatch.undo()
    run = caught.value.run
    assert run.outcome == "interrupted" and 0 < run.steps < len(LONG)
    assert run.state is not None and run.state.k == run.steps
    rest = rn.simulate(PLANT, rcac(4), LONG[run.steps :], start=run.state)
    straight = rn.simulate(PLANT, rcac(4), LONG)
    assert np.array_equal(rest.u, straight.u[run.steps :])
    assert np.array_equal(run.u, straight.u[: run.steps])


def test_what_ended_before_keeps_its_outcome(pressed):
    wrong = rn.ControllerSettings(
        structure=rn.iir(1), target=rn.TargetModel([0, -1.0]), update=rn.UD(R_theta=1e6)
    )
    cases = [
        rn.SimulationCase(PLANT, rcac(2), LONG[:5]),
        rn.SimulationCase(UNSTABLE, wrong, LONG, {"divergence_limit": 100.0}),
        rn.SimulationCase(PLANT, rcac(2), LONG),
    ]
    pressed.looks = 200
    with pytest.raises(rn.RunInterrupted, match="interrupted after") as caught:
        rn.simulate_many(cases, threads=1)
    assert [run.outcome for run in caught.value.runs] == ["completed", "diverged", "interrupted"]


def test_a_key_pressed_in_a_function_of_the_plant():
    """In the middle of a step: there is no state to go on from, and the rows before are good."""

    def advance(k, x, u, w):
        if k == 20:
            raise KeyboardInterrupt
        return 0.5 * x + u + w

    one = {"n": 1, "l_u": 1, "l_w": 1, "l_y": 1, "l_z": 1}
    plant = rn.FunctionPlant(advance=advance, output=lambda k, x, w: (x, x), **one)
    with pytest.raises(rn.RunInterrupted) as caught:
        rn.simulate(plant, rcac(2), LONG[:100])
    run = caught.value.run
    assert run.outcome == "interrupted" and run.state is None and run.steps in (20, 21)
    linear = rn.simulate(rn.standard_plant("1/(q - 0.5)"), rcac(2), LONG[:20])
    assert run.u[:20] == pytest.approx(linear.u, abs=1e-12)
