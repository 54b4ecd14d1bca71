"""Experiment files whose controller is that of LQG."""

import numpy as np
import pytest

from compensator_theory import InputError
from rcac_experiments.files._builder import build
from rcac_numeric import lqg_controller


def table(**controller):
    return {
        "plant": {"problem": "servo", "G": "(q - 0.5)/((q - 0.9)*(q - 0.2))"},
        "signals": {"d": {"white_noise": 1}, "v": {"white_noise": 0.5}},
        "target": {"model": "fir"},
        "controller": {"structure": "lqg", **controller},
        "run": {"steps": 20_000, "stride": 1000},
    }


@pytest.mark.parametrize("form", ["predictor", "filter"])
def test_an_experiment_runs_lqg_without_adapting(form):
    noise = {"d": 1.0, "v": 0.25}
    experiment = build(table(noise=noise, form=form), "case")
    result = experiment.main_run.execute().first.run
    design = lqg_controller(experiment.main_run.plant, noise=noise, form=form)
    assert (result.theta == result.theta[0]).all()
    assert (result.compensator.past_u == design.compensator.past_u).all()
    assert (result.compensator.past_y == design.compensator.past_y).all()
    assert np.mean(result.z[100:] ** 2) == pytest.approx(design.cost.value, rel=0.1)


def test_experiments_of_lqg_that_make_no_sense():
    with pytest.raises(InputError, match="sets 'n_c', which structure = \"lqg\" does not read"):
        build(table(n_c=3), "case")
    with pytest.raises(InputError, match="form = 'both'"):
        build(table(form="both"), "case")
    changing = table()
    changing["plant"]["changes"] = [{"start": 10, "gain": 2}]
    with pytest.raises(InputError, match="this one changes"):
        build(changing, "case")
