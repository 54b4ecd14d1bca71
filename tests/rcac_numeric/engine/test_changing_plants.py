"""Plants that change while they run, and plants given by functions."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from tests.support.changing_plants import schedules
from tests.support.comparisons import tame
from tests.support.engine_cases import cases, engine_plants
from tests.support.function_plants import as_functions
from tests.support.signals import noise
from tests.support.strategies import plants, seeds, sizes
from tests.support.textbook_loop import assert_follows


@given(st.data(), sizes, sizes, sizes, st.booleans(), seeds)
def test_a_schedule_is_its_loop(data, l_u, l_y, l_z, saturated, seed):
    plant = data.draw(schedules(l_u, l_y, l_z))
    case = data.draw(cases(l_u, l_y, l_z, kinds=["iir", "fir", "pid"]))
    saturation = rn.Saturation(low=-0.3, high=0.3, rate=0.2) if saturated else None
    x_0 = np.random.default_rng(seed).standard_normal(plant.n)
    run = tame(
        rn.simulate(plant, case[0], noise(seed, 22, plant.l_w), x_0=x_0, saturation=saturation)
    )
    assert_follows(run, [case])


@given(st.data(), sizes, sizes, sizes, seeds)
def test_feedthrough_is_simulated_too(data, l_u, l_y, l_z, seed):
    drawn = st.just(l_u), st.just(l_y), st.just(l_z)
    plant = data.draw(plants(*drawn, feedthrough=True))
    settings, regressor = data.draw(cases(l_u, l_y, l_z, kinds=["pid"]))
    run = tame(rn.simulate(plant, settings, noise(seed, 14, plant.l_w)))
    assert_follows(run, [(settings, regressor)])


def test_a_delay_switches_what_was_sent():
    """u = 1, 2, 3, ... sent to x(k+1) = u(k - delay): delays 0, 2 from k = 4, 1 from k = 7."""
    plain = rn.Plant(A=[[0.0]], B=[[1.0]], D_1=[[0.0]], C=[[1.0]])
    schedule = rn.PlantSchedule(
        [rn.PlantChange(start=0, plant=plain), rn.PlantChange(start=4, plant=plain, delay=2),
         rn.PlantChange(start=7, plant=plain, delay=1)]
    )  # fmt: skip
    body, observed = rn.Simulator(schedule), []
    for k in range(10):
        for _ in range(k % 3):  # to look, once or more often or never, changes nothing
            measured, _ = body.output(k + 1, 0)
            assert measured == body.x
        observed.append(body.x[0])
        body.advance(k + 1, 0)
    # x(k+1) holds u(k - delay(k)): 1 2 3 4 | 3 4 5 | 7 8 9
    assert observed == [0, 1, 2, 3, 4, 3, 4, 5, 7, 8]


@given(st.data(), sizes, sizes, sizes, st.integers(0, 2), seeds)
def test_functions_of_a_linear_plant_are_the_plant(data, l_u, l_y, l_z, l_r, seed):
    settings, _ = data.draw(cases(l_u, l_y, l_z, l_r))
    plant = data.draw(engine_plants(l_u, l_y, l_z, settings.structure.l_r))
    w = noise(seed, 12, plant.l_w)
    run = tame(rn.simulate(plant, settings, w))
    same = rn.simulate(as_functions(plant), settings, w)
    size = max(1.0, np.abs(run.theta).max()) * max(1.0, np.abs(run.u).max()) ** 3
    assert same.outcome == "completed"
    assert np.abs(same.theta_final - run.theta_final).max() <= 1e-10 * size
    assert np.abs(same.z - run.z).max() <= 1e-10 * size
