"""The analyses of a run and of a log are the same ones."""

import numpy as np
import pytest

import rcac_numeric as rn
from compensator_theory.errors import InputError
from rcac_numeric import (
    ClosedLoop,
    Compensator,
    LoopAnalysis,
    Plant,
    TargetModel,
    check_controller,
    compare_exactly,
    h2_cost,
    multivariable_disk_margin,
    observer_forms,
    simulate,
    stability_margins,
    target_model,
)
from rcac_numeric.analysis._loop_analysis import attempted
from tests.support.examples import EXAMPLE_4_7
from tests.support.signals import noise


@pytest.fixture(scope="module")
def run():
    return EXAMPLE_4_7.run()


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
    analysis = LoopAnalysis(run, other)
    assert analysis.compared_with == other and analysis.match.worst > 1e-2
    assert LoopAnalysis(run).compared_with == run.settings.target


@pytest.mark.exact_data  # the same w twice
def test_a_run_cut_off_is_the_run_of_so_many_steps():
    """With the target in force at the last of them, 29 of 30, which is not the one of step 30."""
    plant, w = rn.standard_plant("1/(q - 0.5)"), noise(2, 60, 1)
    targets = [rn.TargetModel([0, 1.0, -0.1 * i]) for i in range(4)]
    settings = rn.ControllerSettings(
        structure=rn.iir(2), target=targets[0], update=rn.UD(0.1),
        target_changes={10: targets[1], 29: targets[2], 30: targets[3]},
    )  # fmt: skip
    whole, part = (rn.LoopAnalysis(rn.simulate(plant, settings, w[:steps])) for steps in (60, 30))
    cut = whole.until(30)
    assert whole.until(30) is cut and whole.until(60) is whole
    assert (cut.last_step, cut.compared_with, whole.compared_with) == (29, targets[2], targets[3])
    assert cut.compared_with == part.compared_with and np.array_equal(cut.run.z, part.run.z)
    assert cut.compensator == part.compensator


def test_without_a_target_there_is_a_loop_and_nothing_to_compare_it_with(run):
    alone = LoopAnalysis((run.plant, run.compensator))
    assert alone.loop.is_stable and alone.zeros.keys() == {"w"} and not alone.obstacle
    for ask in (lambda: alone.match, lambda: alone.comparison):
        assert attempted(ask) == (None, "the target model is missing; give it as target=")
    with pytest.raises(InputError, match="is missing"):
        alone.split_of(u=run.u, y=run.y, z=run.z, w=run.w)
    for ask in (lambda: alone.run, lambda: alone.split, lambda: alone.until(50)):
        with pytest.raises(InputError, match="but no run"):
            ask()


def test_two_controllers_have_one_target_or_none_is_known():
    plant, targets = rn.standard_plant("1/(q - 0.5)"), [rn.TargetModel([0, c]) for c in (1.0, 2.0)]
    one, other = (
        rn.ControllerSettings(structure=rn.iir(1), target=target, update=rn.UD(1.0))
        for target in targets
    )
    for pair, known in (([one, one], True), ([one, other], False)):
        run = rn.simulate(plant, rn.Decentralized(pair), noise(4, 20, 1))
        compared, why = attempted(lambda run=run: rn.LoopAnalysis(run).compared_with)
        assert compared == (targets[0] if known else None) and ("different" in why) != known


def test_a_target_of_another_size_is_refused(run):
    two = TargetModel(numerator=np.array([np.zeros((2, 2)), np.eye(2)]))
    wide = LoopAnalysis((run.plant, run.compensator), two)
    with pytest.raises(InputError, match="2 x 2; the plant's G_zu is 1 x 1"):
        _ = wide.match


def test_a_run_is_a_loop_to_every_function_of_loops(run):
    loop = ClosedLoop(run.plant, run.compensator)
    pair = (run.plant, run.compensator)
    assert compare_exactly(run).reached == compare_exactly(*pair, run.settings.target).reached
    for of in (run, pair, LoopAnalysis(run)):
        assert stability_margins(of) == stability_margins(loop)
        assert multivariable_disk_margin(of) == multivariable_disk_margin(loop)
    assert h2_cost(run).value == h2_cost(*pair).value
    forms, again = observer_forms(run), observer_forms(*pair)
    assert len(forms) and np.array_equal(forms.K, again.K)


def test_a_plant_may_be_a_text_or_a_transfer_function(run):
    G = run.plant.problem.transfer_function("yu")
    for plant in (str(G.as_expr()), G):
        again = simulate(plant, run.settings, run.w)
        assert np.array_equal(again.theta, run.theta)
        compared = compare_exactly(plant, again.compensator, run.settings.target)
        assert compared.reached == compare_exactly(run).reached


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda run: compare_exactly(run.plant), "a loop needs a controller"),
        (lambda run: compare_exactly(run, run.compensator), "a run contains its controller"),
        (lambda run: compare_exactly(run.plant, run.compensator), "give it as target="),
        (lambda run: compare_exactly(run.plant, 3), "compensator = 3 is not a Compensator"),
        (lambda run: h2_cost(run.plant), "a loop needs a controller"),
        (lambda run: h2_cost(run, run.compensator), "a run contains its controller"),
        (lambda run: stability_margins(run.plant), "a Plant is not a loop; give a Run"),
        (lambda run: observer_forms(run.plant), "a loop needs a controller"),
        (lambda run: LoopAnalysis(5), "a int is not a loop; give a Run, or a pair"),
        (lambda run: LoopAnalysis((run.plant,)), "a tuple is not a loop; give a Run, or a pair"),
        (lambda run: LoopAnalysis((run.plant, 3)), "compensator = 3 is not a Compensator"),
        (lambda run: LoopAnalysis(run, 5), "target = 5 is not a TargetModel"),
        (lambda run: compare_exactly(run, target="1/("), "cannot read"),
        (lambda run: multivariable_disk_margin(3), "a int is not a loop; give a Run"),
    ],
)
def test_what_is_no_loop_is_refused(run, ask, words):
    with pytest.raises(InputError, match=words):
        ask(run)


def test_reports_begin_with_stability(run):
    unstable = compare_exactly(run.plant, run.compensator, target_model("1/q"))
    assert "stable, spectral radius" in compare_exactly(run).report().splitlines()[1]
    assert "NOT" not in str(unstable)  # all poles of 1/q at zero ask for no poles
    gain = run.compensator.past_y * 3
    worse = type(run.compensator)(past_u=run.compensator.past_u, past_y=gain)
    lines = compare_exactly(run.plant, worse, run.settings.target).report().splitlines()
    assert "UNSTABLE" in lines[1] and "NOT reached" in lines[2]
    assert "UNSTABLE" in LoopAnalysis((run.plant, worse)).report().splitlines()[1]
    assert "completed after 100 steps" in LoopAnalysis(run).report().splitlines()[0]


def test_plant_compensator_and_target_may_be_texts():
    plant, compensator = "1/(q - 2)", "-4/(q + 2)"  # D D_c - N N_c = q^2
    comparison = compare_exactly(plant, compensator, "1/q")
    assert comparison.worst_distance == 0 and comparison.controller_distance == 0
    assert LoopAnalysis((plant, compensator), "1/q").match.worst < 1e-12
    assert not LoopAnalysis((plant, "0")).loop.is_stable


def test_a_report_says_once_why_there_is_no_exact_comparison():
    two = Plant(A=np.diag([0.5, 0.2]), B=np.eye(2), D_1=np.ones((2, 1)), C=np.eye(2))
    nothing = Compensator(np.zeros((1, 2, 2)), np.zeros((2, 2, 2)))
    words = " ".join(LoopAnalysis((two, nothing)).report().split())
    assert "Exact comparison not evaluated: it is for scalar signals" in words


def test_an_earlier_step_of_a_run_that_keeps_every_third_theta(run):
    """The controller of step k is that of the run that keeps all."""
    sparse = EXAMPLE_4_7.run(stride=3)
    for k in (0, 3, 12):
        earlier = LoopAnalysis(sparse).until(k)
        assert np.array_equal(earlier.run.theta_final, run.theta[k])
        assert earlier.compensator == LoopAnalysis(run).until(k).compensator
