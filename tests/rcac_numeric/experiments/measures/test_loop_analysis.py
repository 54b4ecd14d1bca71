"""The analyses of a run and of a log are the same ones."""

import numpy as np
import pytest

from compensator_theory.errors import InputError
from rcac_numeric import TargetModel, check_controller, target_model
from rcac_numeric.dissertation import load_example
from rcac_numeric.experiments.measures.loop_analysis import LoopAnalysis, attempted


@pytest.fixture(scope="module")
def run():
    return load_example("4.7").main_run.execute().first.run


def test_a_run_and_its_log_have_the_same_analyses(run):
    of_run = LoopAnalysis(run)
    of_log = check_controller(
        run.u, run.y, z=run.z, w=run.w, compensator=run.compensator, plant=of_run.plant,
        target=of_run.compared_with,
    )  # fmt: skip
    assert of_log.comparison.reached == of_run.comparison.reached
    assert np.array_equal(of_log.loop.poles(), of_run.loop.poles())
    assert of_log.match.worst == of_run.match.worst
    assert np.array_equal(of_log.split.residual, of_run.split.residual)


def test_the_target_that_is_given_goes_before_that_of_the_settings(run):
    other = target_model("1/q")
    given = LoopAnalysis(run, other)
    assert given.compared_with == other and given.match.worst > 1e-2
    assert LoopAnalysis(run).compared_with == run.settings.target


def test_without_a_target_there_is_a_loop_and_nothing_to_compare_it_with(run):
    alone = LoopAnalysis((run.plant, run.compensator))
    assert alone.loop.is_stable and alone.zeros.keys() == {"w"} and not alone.obstacle
    for ask in (lambda: alone.match, lambda: alone.comparison):
        assert attempted(ask) == (None, "the target model is not known")
    with pytest.raises(InputError, match="not known"):
        alone.split_of(u=run.u, y=run.y, z=run.z, w=run.w)
    for ask in (lambda: alone.run, lambda: alone.split, lambda: alone.until(50), alone.plot):
        with pytest.raises(InputError, match="no run is known"):
            ask()


def test_a_target_of_another_size_is_refused(run):
    two = TargetModel(numerator=np.array([np.zeros((2, 2)), np.eye(2)]))
    wide = LoopAnalysis((run.plant, run.compensator), two)
    with pytest.raises(InputError, match="2 x 2; the plant's G_zu is 1 x 1"):
        _ = wide.match
