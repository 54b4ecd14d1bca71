"""Where learning a target model is hard: unstable plants and noise at the sensor; with guards."""

import numpy as np

from rcac_numeric import (
    UD,
    ControllerSettings,
    DataDriven,
    Step,
    WhiteNoise,
    exogenous,
    fir_target,
    h2_cost,
    iir,
    lqg_controller,
    pid,
    servo_plant,
    simulate,
    standard_plant,
)

P_48 = "(q - 1.2)/((q - 1.1)*(q - 2))"
MILD = "(q - 1.5)/((q - 1.05)*(q - 0.5))"
P_25 = "(q - 0.975)*(q - 1.2)/((q - 0.99)*(q**2 - 1.6*q + 0.965))"


def ends(G, target, seeds, R_theta):
    """J over LQG's of each seed; inf where the run did not come to its end."""
    plant = standard_plant(G)
    best = lqg_controller(plant).cost.value
    result = []
    for seed in seeds:
        settings = ControllerSettings(
            structure=iir(8), target=target(seed, plant), update=UD(R_theta)
        )
        w = exogenous([WhiteNoise(0.01)], 10000, seed)
        run = simulate(plant, settings, w, stride=1000)
        done = run.outcome == "completed"
        result.append(h2_cost(plant, run.compensator).value / best if done else np.inf)
    return np.array(result)


def test_a_plant_that_doubles_at_every_step(in_full):
    """Example 4.8: a short start, p = n, d_zu and H told; with the usual start none lives."""
    seeds = range(12 if in_full else 3)

    def short(seed, plant):
        return DataDriven(order=2, start=12, dither=0.1, d_zu=1, H=1.0, seed=seed)

    end_points = ends(P_48, lambda seed, plant: fir_target(plant), seeds, 1e-6)
    learnt = ends(P_48, short, seeds, 1e-6)
    assert np.isfinite(learnt).all() and np.median(learnt) <= 1.02 * np.median(end_points)
    usual = ends(P_48, lambda seed, plant: DataDriven(order=20, seed=seed), seeds, 1e-6)
    assert np.isinf(usual).all()


def test_a_mildly_unstable_plant_needs_only_a_dither(in_full):
    """Pole 1.05, start 50: with a dither of ten times w nothing need be told."""
    seeds = range(12 if in_full else 3)

    def loud(seed, plant):
        return DataDriven(order=4, start=50, dither=0.1, seed=seed)

    assert (ends(MILD, loud, seeds, 1e-3) <= 1.1).all()
    usual = ends(MILD, lambda seed, plant: DataDriven(order=20, seed=seed), seeds, 1e-3)
    assert np.isinf(usual).all()


def test_a_dither_of_ten_times_the_sensor_noise(in_full):
    """Example 2.5 with noise 0.01 at the sensor: z ends as noise; a tenth loses loops."""
    plant, steps = servo_plant(P_25), 6000

    def rms(dither, seed):
        settings = ControllerSettings(
            structure=pid("PID"),
            update=UD(1e4),
            target=DataDriven(order=10, dither=dither, seed=seed),
        )
        w = exogenous([Step(2), Step(-1.1), WhiteNoise(0.01)], steps, seed)
        run = simulate(plant, settings, w, stride=steps)
        return float(np.sqrt(np.mean(run.z[-1000:] ** 2))) if run.outcome == "completed" else np.inf

    seeds = range(12 if in_full else 4)
    assert max(rms(0.1, seed) for seed in seeds) <= 0.0125
    assert sum(rms(0.001, seed) > 0.1 for seed in seeds) >= len(seeds) / 2
