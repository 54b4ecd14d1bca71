"""Many runs at once give what each would give alone, in order, whatever becomes of the others."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from compensator_theory import FunctionFailedError, InputError
from rcac_numeric import (
    UD,
    ControllerSettings,
    FunctionPlant,
    Saturation,
    SimulationCase,
    Step,
    TargetModel,
    WhiteNoise,
    exogenous,
    fir_target,
    iir,
    simulate,
    simulate_many,
    standard_plant,
)
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
            options["saturation"] = Saturation(low=-0.5, high=0.5)
        cases.append(SimulationCase(plant, settings, w, options))
    together = simulate_many(cases, threads=threads)
    for case, run in zip(cases, together, strict=True):
        assert same(run, simulate(case.plant, case.settings, case.w, **case.options))


def test_a_diverging_case_does_not_touch_the_others():
    good, bad = standard_plant("1/(q - 0.5)"), standard_plant("1/(q - 3)")
    w = exogenous([Step()], 400)
    wrong_sign = ControllerSettings(
        structure=iir(1), target=TargetModel([0, -1.0]), update=UD(R_theta=1e6)
    )
    right = ControllerSettings(structure=iir(1), target=fir_target(good), update=UD(R_theta=1.0))
    runs = simulate_many(
        [
            SimulationCase(good, right, w),
            SimulationCase(bad, wrong_sign, w),
            SimulationCase(good, right, w),
        ]
    )
    assert [run.outcome for run in runs] == ["completed", "diverged", "completed"]
    assert same(runs[0], simulate(good, right, w)) and same(runs[0], runs[2])


def test_seeds_are_independent_of_their_neighbours():
    plant = standard_plant("(q - 0.5)/(q*(q - 0.9))")
    settings = ControllerSettings(
        structure=iir(3), target=fir_target(plant), update=UD(R_theta=1.0)
    )
    cases = [
        SimulationCase(plant, settings, exogenous([WhiteNoise()], 200, seed)) for seed in range(9)
    ]
    runs = simulate_many(cases, threads=2)
    assert all(
        same(r, simulate(c.plant, c.settings, c.w)) for r, c in zip(runs, cases, strict=True)
    )
    assert len({float(run.theta_final[0]) for run in runs}) == 9


def test_bad_cases_are_named_by_number():
    plant = standard_plant("1/(q - 0.5)")
    settings = ControllerSettings(
        structure=iir(1), target=fir_target(plant), update=UD(R_theta=1.0)
    )
    fine = SimulationCase(plant, settings, np.zeros((5, 1)))
    with pytest.raises(InputError, match="case 1: w has shape"):
        simulate_many([fine, SimulationCase(plant, settings, np.zeros((5, 2)))])
    with pytest.raises(InputError, match=r"options of case 0: .*strid"):
        simulate_many([SimulationCase(plant, settings, np.zeros((5, 1)), {"strid": 2})])
    with pytest.raises(InputError, match="case 0 is 3"):
        simulate_many([3])
    with pytest.raises(InputError, match="cases = 5 must be a list"):
        simulate_many(5)
    with pytest.raises(InputError, match="threads = 0"):
        simulate_many([fine], threads=0)
    assert simulate_many([]) == []

    def advance(k, x, u, w):
        if k == 3:
            raise RuntimeError("the valve stuck")
        return x

    broken = FunctionPlant(
        advance=advance, output=lambda k, x, w: (x, x), n=1, l_u=1, l_w=1, l_y=1, l_z=1
    )
    with pytest.raises(FunctionFailedError, match=r"case 1: .* step 3.*the valve stuck") as caught:
        simulate_many([fine, SimulationCase(broken, settings, np.zeros((5, 1)))])
    assert caught.value.run.steps == 3
