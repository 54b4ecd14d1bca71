"""Many runs at once give what each would give alone, in order, whatever becomes of the others."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory import InputError
from tests.support.comparisons import same
from tests.support.strategies import controllers, plants, seeds


@given(st.data(), st.integers(1, 3), seeds)
@hypothesis_settings(max_examples=15)
def test_batches_of_different_cases_equal_single_runs(data, threads, seed):
    rng = np.random.default_rng(seed)
    cases = []
    for number in range(data.draw(st.integers(1, 6))):
        plant = data.draw(plants())
        settings = data.draw(controllers(plant.l_u, plant.l_y, plant.l_z))
        w = rng.standard_normal((int(rng.integers(1, 40)), plant.l_w))
        options = {"stride": 1 + number % 3}
        if number % 2:
            options["saturation"] = rn.Saturation(low=-0.5, high=0.5)
        cases.append(rn.SimulationCase(plant, settings, w, options))
    together = rn.simulate_many(cases, threads=threads)
    for case, run in zip(cases, together, strict=True):
        assert same(run, rn.simulate(case.plant, case.settings, case.w, **case.options))


def test_a_diverging_case_does_not_touch_the_others():
    good, bad = rn.standard_plant("1/(q - 0.5)"), rn.standard_plant("1/(q - 3)")
    w = rn.exogenous([rn.Step()], 400)
    wrong_sign = rn.ControllerSettings(
        structure=rn.iir(1), target=rn.TargetModel([0, -1.0]), update=rn.UD(R_theta=1e6)
    )
    right = rn.ControllerSettings(
        structure=rn.iir(1), target=rn.fir_target(good), update=rn.UD(R_theta=1.0)
    )
    runs = rn.simulate_many(
        [
            rn.SimulationCase(good, right, w),
            rn.SimulationCase(bad, wrong_sign, w),
            rn.SimulationCase(good, right, w),
        ]
    )
    assert [run.outcome for run in runs] == ["completed", "diverged", "completed"]
    assert same(runs[0], rn.simulate(good, right, w)) and same(runs[0], runs[2])


def test_seeds_are_independent_of_their_neighbours():
    plant = rn.standard_plant("(q - 0.5)/(q*(q - 0.9))")
    settings = rn.ControllerSettings(
        structure=rn.iir(3), target=rn.fir_target(plant), update=rn.UD(R_theta=1.0)
    )
    cases = [
        rn.SimulationCase(plant, settings, rn.exogenous([rn.WhiteNoise()], 200, seed))
        for seed in range(9)
    ]
    runs = rn.simulate_many(cases, threads=2)
    assert all(
        same(r, rn.simulate(c.plant, c.settings, c.w)) for r, c in zip(runs, cases, strict=True)
    )
    assert len({float(run.theta_final[0]) for run in runs}) == 9


def test_bad_cases_are_named_by_number():
    plant = rn.standard_plant("1/(q - 0.5)")
    settings = rn.ControllerSettings(
        structure=rn.iir(1), target=rn.fir_target(plant), update=rn.UD(R_theta=1.0)
    )
    fine = rn.SimulationCase(plant, settings, np.zeros((5, 1)))
    with pytest.raises(InputError, match="case 1: w has shape"):
        rn.simulate_many([fine, rn.SimulationCase(plant, settings, np.zeros((5, 2)))])
    with pytest.raises(InputError, match=r"options of case 0: .*strid"):
        rn.simulate_many([rn.SimulationCase(plant, settings, np.zeros((5, 1)), {"strid": 2})])
    with pytest.raises(InputError, match="case 0 is 3"):
        rn.simulate_many([3])
    with pytest.raises(InputError, match="cases = 5 must be a list"):
        rn.simulate_many(5)
    with pytest.raises(InputError, match="threads = 0"):
        rn.simulate_many([fine], threads=0)
    assert rn.simulate_many([]) == []

    def advance(k, x, u, w):
        if k == 3:
            raise RuntimeError("the valve stuck")
        return x

    broken = rn.FunctionPlant(
        advance=advance, output=lambda k, x, w: (x, x), n=1, l_u=1, l_w=1, l_y=1, l_z=1
    )
    failing = rn.SimulationCase(broken, settings, np.zeros((5, 1)))
    runs = rn.simulate_many([fine, failing, fine])
    assert runs[1].outcome == "plant failed" and runs[1].steps == 3
    assert "the valve stuck" in runs[1].failure and not runs[0].failure
    assert same(runs[0], rn.simulate(plant, settings, fine.w)) and same(runs[0], runs[2])
