"""The reference in ball arithmetic does what the engine does, or says that it does not."""

from functools import partial

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory import InputError
from tests.support.changing_plants import schedules
from tests.support.engine_cases import cases, engine_plants, positive, with_update
from tests.support.function_plants import TWO_STATES, as_functions
from tests.support.signals import noise
from tests.support.strategies import seeds, sizes, targets

RULES = [
    {},
    {
        "update": partial(
            rn.Covariance, lambda_=rn.ScheduledForgetting({5: 1.0, 8: 0.9}, initial=0.95)
        )
    },
    {"freeze": ((3, 6), (5, 8))},
    {"update": partial(rn.UD, reset=rn.CovarianceReset(at=[4, 9], every=5))},
    {"R_u": rn.SignalWeight(0.3), "R_z": rn.SignalWeight(0.1, 1.0)},
    {"update": rn.Instantaneous},
    {"update": lambda R_theta: rn.Gradient(step_size=0.01)},
]


@given(st.data(), sizes, sizes, sizes, st.sampled_from(RULES), st.booleans(), seeds)
@hypothesis_settings(max_examples=25)
def test_the_engine_follows_the_reference(data, l_u, l_y, l_z, rule, filter_form, seed):
    l_r = data.draw(st.integers(0, 1))
    form = {"form": "filter", "strictly_proper": True} if filter_form else {}
    if data.draw(st.booleans()) and not filter_form:
        form["target_changes"] = {6: data.draw(targets(l_z, l_u))}
    settings, _ = data.draw(cases(l_u, l_y, l_z, l_r, **rule, **form))
    if data.draw(st.booleans()) and not rule:
        Q = positive(np.random.default_rng(seed), settings.structure.l_theta) / 50
        settings = with_update(settings, process_noise=Q)
    l_r = settings.structure.l_r
    plant = data.draw(schedules(l_u, l_y, l_z) if l_r == 0 else engine_plants(l_u, l_y, l_z, l_r))
    w, x_0 = noise(seed, 12, plant.l_w), np.ones(plant.n)
    run = rn.simulate(plant, settings, w, x_0=x_0)
    assume(run.outcome == "completed" and np.abs(run.u).max() < 1e2)
    exact = rn.simulate_reference(plant, settings, w, x_0=x_0, digits=200)
    assert exact.digits > 50
    # The loop amplifies what rounding does to theta; u bounds by how much.
    size = max(1.0, np.abs(exact.theta).max()) * max(1.0, np.abs(exact.u).max()) ** 3
    for name in ("theta", "theta_final", "u", "y", "z"):
        assert np.abs(getattr(run, name) - getattr(exact, name)).max() <= 1e-10 * size, name


PLANT = rn.standard_plant("1/(q - 0.5)")
GOOD = {"structure": rn.iir(1), "target": rn.TargetModel([0, 1.0]), "update": rn.UD(R_theta=1.0)}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"R_u": lambda k, y, z, u: 1.0}, "R_u as a weight that is a function"),
        ({"R_z": lambda k, y, z, u: 1.0}, "R_z as a weight that is a function"),
        (
            {"update": rn.SlidingWindow(R_theta=1.0, window=3)},
            "the update SlidingWindow; it knows UD, Covariance, Instantaneous, Gradient",
        ),
        (
            {"update": rn.UD(1.0, lambda_=rn.VariableRateForgetting(1, 2, 1.0))},
            "the forgetting VariableRateForgetting",
        ),
        (
            {"update": rn.UD(1.0, reset=rn.CovarianceReset(trace_below=0.5))},
            "a covariance reset by trace_below or growth",
        ),
        (
            {"update": rn.UD(1.0, reset=rn.CovarianceReset(growth=2.0))},
            "a covariance reset by trace_below or growth",
        ),
        ({"reflect_poles": True}, "reflect_poles"),
    ],
)
def test_what_the_reference_does_not_do_is_refused_by_name(change, message):
    settings = rn.ControllerSettings(**{**GOOD, **change})
    with pytest.raises(InputError, match=f"does not know {message}"):
        rn.simulate_reference(PLANT, settings, np.ones((3, 1)))


def test_the_reference_runs_one_controller_on_a_linear_plant():
    settings = rn.ControllerSettings(**GOOD)
    with pytest.raises(InputError, match="one adaptive controller, not a Decentralized"):
        rn.simulate_reference(PLANT, rn.Decentralized([settings]), np.ones((3, 1)))
    with pytest.raises(InputError, match="needs a linear plant"):
        rn.simulate_reference(as_functions(TWO_STATES), settings, np.ones((3, 1)))


def test_no_steps_at_all():
    settings = rn.ControllerSettings(
        structure=rn.fir(1), target=rn.TargetModel([0, 1.0]), update=rn.UD(R_theta=1.0)
    )
    for run in (rn.simulate_reference, rn.simulate):
        nothing = run(PLANT, settings, np.zeros((0, 1)))
        assert nothing.steps == 0 and np.array_equal(nothing.theta_final, [0.0])
