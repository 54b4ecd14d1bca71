"""The aircraft learns its nonminimum-phase zero while it flies, and refuses what shows nothing."""

import numpy as np
import pytest

import rcac_numeric as rn
from compensator_theory import InputError
from rcac_numeric.gallery import aircraft_plant, aircraft_transition, plant_zeros

STEPS = 8000
# The best settings found for Example 3.2 with the zeros known.
SETTINGS = rn.ControllerSettings(
    structure=rn.iir(40),
    target=rn.fir_target(rn.ModellingInformation(1, -0.0126)),
    update=rn.UD(R_theta=0.62, lambda_=0.9997),
    R_u=rn.SignalWeight(22000),
)


def flight(seed, *, dither=1e-4, noise=0.0, learns=True, steps=STEPS):
    """x(0) and the dither of one seed; the first target model knows no zero."""
    rng = np.random.default_rng([seed, 7])
    w = np.zeros((steps, 3))
    w[:, 0] = 0.15
    w[:, 1], w[:, 2] = dither * rng.standard_normal(steps), noise * rng.standard_normal(steps)
    x_0 = 0.01 * np.random.default_rng([seed, 2]).standard_normal(4)
    learner = rn.TargetLearner(mu=10, n_mod=4, order=4)
    hook = {"on_step": learner, "every": 70} if learns else {}
    plant = aircraft_transition(source="corrected")
    return rn.simulate(plant, SETTINGS, w, x_0=x_0, stride=steps, **hook), learner


def zeros_before(run, k, window=70):
    """The zeros that the window before step k shows, with their uncertainty."""
    u, z = run.u_applied + run.w[:, 1:2], run.z - run.w[:, :1]
    rows = slice(k - window, k)
    return rn.target_from_data(u[rows], z[rows], mu=10, n_mod=4, order=4).zeros


def rms(values):
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.costly
def test_it_follows_through_the_transition_because_it_learns(in_full):
    """With a dither of 1e-4 rad on 3 initial states, on 20 with --long."""
    true = plant_zeros(aircraft_plant("off-nominal", source="corrected"))
    for seed in range(20 if in_full else 3):
        run, learner = flight(seed)
        assert rms(run.z[2300:2500]) < 0.015 and rms(run.z[7000:]) < 1e-3
        assert np.abs(run.z).max() < 0.5
        updates = [result for result in learner.windows if result.action == "updated"]
        assert [change.k for change in run.changes] == [result.k for result in updates]
        before, after = (result.nmp_zeros for result in updates)
        assert len(before) == 0 and updates[1].k < 2800
        result = zeros_before(run, updates[1].k)
        assert np.array_equal(after, np.sort_complex(result.zeros[:2]))
        # Without noise the data hold rounding alone, whose share in the zeros they say themselves.
        for index, zero in enumerate(true[:2]):
            assert result.contains(index, zero, level=1 - 1e-9)
    ignorant, _ = flight(0, learns=False)
    assert rms(ignorant.z[7000:]) > 0.2, "without the zeros it does not"


def test_windows_that_hold_the_transition_are_refused():
    _, learner = flight(0, steps=2800)
    stored = [result for result in learner.windows if 2500 < result.k < 2670]
    assert len(stored) == 3 and {result.action for result in stored} == {"refused"}
    assert all(result.reason for result in stored)


def test_noise_that_hides_the_zeros_leaves_the_run_as_it_is():
    """Every window is refused, by name, and nothing has changed bit for bit."""
    learned, learner = flight(0, noise=1e-3, steps=700)
    plain, _ = flight(0, noise=1e-3, steps=700, learns=False)
    assert len(learner.windows) == 9
    assert {result.action for result in learner.windows} == {"refused"}
    assert all(result.reason.endswith(".") for result in learner.windows)
    assert np.array_equal(learned.u, plain.u) and not learned.changes


def test_too_few_samples_are_refused():
    learner = rn.TargetLearner(mu=10, n_mod=4, order=4, window=70)
    w = np.full((60, 3), [0.15, 0.0, 0.0])
    rn.simulate(aircraft_transition(), SETTINGS, w, on_step=learner, every=50)
    (result,) = learner.windows
    assert (result.k, result.action, result.reason) == (50, "refused", "only 50 samples so far")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"mu": 0}, "mu = 0"),
        ({"window": 0}, "window = 0"),
        ({"moved": -0.1}, "moved = -0.1"),
        ({"residual_growth": 0.5}, "residual_growth = 0.5"),
        ({"covariance": "forget"}, "covariance"),
        ({"level": "high"}, "level"),
    ],
)
def test_settings_that_make_no_sense_are_refused(options, message):
    with pytest.raises(InputError, match=message):
        rn.TargetLearner(**{"mu": 10, "n_mod": 4, "order": 4, **options})
