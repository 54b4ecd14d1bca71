"""The arguments of `check_controller`: those of a run, precedence, replay, and refusals."""

from dataclasses import replace

import numpy as np
import pytest

import rcac_numeric as rn
from compensator_theory.errors import InputError
from rcac_numeric.checks._check import arguments_of_run, fixed_compensator

STEPS = 40
PLANT = rn.standard_plant("1/(q - 0.5)")
TARGET = rn.TargetModel([0.0, 1.0])
GAIN = rn.Compensator([[[0.2]]], [[[0.1]], [[-0.3]]])
OTHER = rn.Compensator([[[0.2]]], [[[0.1]], [[0.3]]])


def settings(**options):
    return rn.ControllerSettings(**{
        "structure": rn.iir(n_c=1), "target": TARGET, "update": rn.UD(R_theta=1.0), "k_w": 7,
        **options,
    })  # fmt: skip


def run_of(controller, plant=PLANT, steps=STEPS, **options):
    w = np.random.default_rng(1).standard_normal((steps, plant.l_w))
    return rn.simulate(plant, controller, w, **options)


@pytest.fixture(scope="module")
def adaptive():
    return run_of(settings())


@pytest.fixture(scope="module")
def fixed():
    return run_of(rn.FixedController(GAIN))


def altered(run, k=30):
    u = run.u.copy()
    u[k] += 1.0
    return replace(run, u=u, u_applied=u.copy())


# What goes before what.


def test_a_run_brings_all_that_it_knows(adaptive):
    check = rn.check_controller(adaptive)
    assert check.run is adaptive and check.settings is adaptive.settings and not check.is_fixed
    assert check.plant is PLANT and check.target is TARGET and check.structure == rn.iir(n_c=1)
    assert check.plant_residual is None  # of its own plant there is none
    assert check.replay.agrees and check.replay.start == 7 and check.conventions is None
    assert check.is_consistent and check.disk is None and check.drift is not None
    assert check.unanswered == {}


def test_another_plant_goes_before_that_of_the_run(adaptive):
    other = rn.standard_plant("1/(q - 0.6)")
    check = rn.check_controller(
        adaptive, plant=other, target=(target := rn.TargetModel([0.0, 2.0]))
    )
    assert check.plant is other and check.target is target
    assert check.run is None and check.settings is adaptive.settings
    assert check.plant_residual is not None and check.plant_residual.is_doubtful


@pytest.mark.parametrize(
    ("options", "is_fixed"), [({"structure": rn.iir(n_c=1)}, False), ({"compensator": GAIN}, True)]
)
def test_another_controller_goes_before_that_of_the_run(adaptive, fixed, options, is_fixed):
    check = rn.check_controller(adaptive, **options)
    assert check.settings is None and check.is_fixed == is_fixed
    assert check.structure == options.get("structure") and check.target is TARGET
    # The k_w of the settings is none of another controller: by default n_c, or the last tenth.
    assert check.replay.start == (STEPS - STEPS // 10 if is_fixed else 1)
    assert rn.check_controller(fixed).is_fixed and not rn.check_controller(adaptive).is_fixed


def test_k_w_goes_before_that_of_the_run(adaptive):
    assert rn.check_controller(adaptive, k_w=20).replay.start == 20
    for refused in (-1, 2.5):
        with pytest.raises(InputError, match="k_w"):
            rn.check_controller(adaptive, k_w=refused)


def test_k_w_is_that_of_a_compensator_and_not_of_the_last_polynomials(fixed):
    log = arguments_of_run(fixed)["log"]
    assert rn.check_controller(log, compensator=GAIN, k_w=5).replay.start == 5
    last = rn.check_controller(log, compensator=GAIN).replay.start
    ended = rn.ControllerLog(u=log.u, y=log.y, D_c=GAIN.denominator, N_c=GAIN.numerator)
    assert rn.check_controller(ended, k_w=5).replay.start == last > 5
    # A structure without theta is none of the polynomials.
    assert rn.check_controller(ended, structure=rn.iir(n_c=3)).replay.start == last


def test_the_sample_time_of_the_log_is_that_of_the_plant():
    log = rn.ControllerLog(u=np.ones(20), y=np.ones(20), sample_time=0.1)
    plant = rn.Plant(A=[[0.5]], B=[[1.0]], D_1=[[1.0]], C=[[1.0]], sample_time=0.2)
    with pytest.raises(InputError, match="sample"):
        rn.check_controller(log, compensator=GAIN, plant=plant)
    with pytest.raises(InputError, match=r"every 0\.1 s, and sample_time = 0\.2"):
        rn.check_controller(log, compensator=GAIN, plant=plant, sample_time=0.2)
    log = rn.ControllerLog(u=log.u, y=log.y)
    assert rn.check_controller(log, compensator=GAIN, plant=plant, sample_time=0.2).plant is plant


def test_limits_go_before_those_of_the_run():
    limited = run_of(rn.FixedController(GAIN), saturation=rn.Saturation(low=-0.1, high=0.2))
    check = rn.check_controller(limited)
    assert check.log.u.min() == -0.1 and check.log.u.max() == 0.2 and check.replay.agrees
    narrower = rn.check_controller(limited, u_limits=(-0.05, 0.1))
    assert narrower.log.u.min() == -0.05 and narrower.log.u.max() == 0.1
    rate = run_of(rn.FixedController(GAIN), saturation=rn.Saturation(low=-0.1, rate=0.05))
    assert rn.check_controller(rate).replay.agrees  # a rate is no limit of a log
    log = rn.ControllerLog(u=limited.u, y=limited.y)  # u before the limits
    assert np.array_equal(rn.check_controller(log, compensator=GAIN).log.u, limited.u)
    with_limits = rn.check_controller(log, compensator=GAIN, u_limits=(-0.1, 0.2))
    assert np.array_equal(with_limits.log.u, limited.u_applied)


# Which replay stands for a log.


def test_conventions_are_searched_where_ours_does_not_replay(adaptive):
    log = arguments_of_run(altered(adaptive))["log"]
    of_theta, of_compensator = {"structure": rn.iir(n_c=1)}, {"compensator": GAIN}
    for controller, convention, is_searched in (
        (of_theta, None, True), (of_theta, "own u", True), (of_theta, "-y", False),
        (of_compensator, None, True), (of_compensator, "-y", False),
    ):  # fmt: skip
        check = rn.check_controller(log, **controller, convention=convention)
        assert not check.is_consistent and (check.conventions is not None) == is_searched
    fits = rn.check_controller(arguments_of_run(adaptive)["log"], structure=rn.iir(n_c=1))
    assert fits.is_consistent and fits.conventions is None and not fits.is_fixed
    own = rn.check_controller(altered(adaptive), convention="-y")
    assert own.settings is None and own.conventions is None and not own.is_consistent


def test_theta_by_another_convention_is_converted(adaptive):
    negated = adaptive.theta * [1, -1]  # acts on -y
    check = rn.check_controller(
        adaptive.u, adaptive.y, theta=negated, structure=rn.iir(n_c=1), convention="-y"
    )
    assert check.is_consistent and check.drift is not None
    assert np.array_equal(check.log.theta, adaptive.theta)
    last = [check.compensator.past_u.item(), check.compensator.past_y[1].item()]
    assert last == adaptive.theta[-1].tolist()


def test_a_compensator_that_replays_needs_no_conventions(fixed):
    check = rn.check_controller(arguments_of_run(fixed)["log"], compensator=GAIN)
    assert check.is_consistent and check.conventions is None and check.unanswered["convergence"]


def test_an_altered_run_has_the_replay_of_its_theta(adaptive, fixed):
    check = rn.check_controller(altered(adaptive))
    assert not check.is_consistent and check.conventions is not None
    assert check.replay.of != "the controller with its settings"
    check = rn.check_controller(altered(fixed))
    assert not check.is_consistent and check.replay.of == "the controller with its settings"


def test_what_theta_alone_does_not_make_is_replayed_from_the_settings():
    learning = rn.DataDriven(order=1, start=10, dither=0.1, running_dither=0.05)
    run = run_of(settings(target=learning, k_w=10))
    check = rn.check_controller(run)
    assert check.is_consistent and check.replay.of == "the controller with its settings"
    assert check.conventions is None
    alone = rn.check_controller(run, structure=rn.iir(n_c=1))
    assert not alone.is_consistent and "replay" not in alone.unanswered
    later = replace(run, first_step=STEPS)  # as if it continued another one
    check = rn.check_controller(later)
    assert check.replay is None and "continues another one" in check.unanswered["replay"]
    assert check.is_consistent and check.conventions is None


def test_a_fixed_controller_is_replayed_though_its_run_continues_another(fixed):
    check = rn.check_controller(replace(fixed, first_step=STEPS))
    assert check.replay.agrees and "replay" not in check.unanswered


def test_a_log_fills_the_memory_of_the_controller_or_is_not_replayed():
    ones = np.ones(2)
    long = rn.check_controller(ones, ones, compensator=GAIN)
    short = rn.check_controller(ones[:1], ones[:1], compensator=GAIN)
    assert long.replay is not None and short.replay is None
    assert "the log of 1 steps" in short.unanswered["replay"]


def test_why_there_is_no_convergence(adaptive):
    log = arguments_of_run(adaptive)["log"]
    assert rn.check_controller(log, compensator=GAIN).unanswered["convergence"] == (
        "theta was not used"
    )
    bare = rn.ControllerLog(u=log.u, y=log.y)
    assert rn.check_controller(bare, compensator=GAIN).unanswered["convergence"] == (
        "no theta was logged"
    )
    last = rn.check_controller(log.u, log.y, theta=adaptive.theta_final, structure=rn.iir(n_c=1))
    assert last.drift is None and "logged only once" in last.unanswered["convergence"]


# Of several inputs.


@pytest.mark.parametrize("radius", [0.5, 1.5])
def test_the_disk_of_all_inputs_is_that_of_a_stable_loop(radius):
    plant = rn.Plant(A=radius * np.eye(2), B=np.eye(2), D_1=np.ones((2, 1)), C=np.eye(2))
    weak = rn.Compensator(np.zeros((1, 2, 2)), 0.1 * np.ones((2, 2, 2)))
    check = rn.check_controller(np.zeros((20, 2)), np.zeros((20, 2)), plant=plant, compensator=weak)
    assert (check.disk is not None) == check.loop.is_stable == (radius < 1)


# The arguments of a run.


@pytest.mark.parametrize("first_step", [0, 60])
def test_the_target_and_the_plant_are_those_of_the_last_step(first_step):
    first, second, third = (rn.TargetModel([0.0, a]) for a in (1.0, 2.0, 3.0))
    last = first_step + STEPS - 1
    changes = {10: first, last: second, last + 1: third}
    later = rn.standard_plant("1/(q - 0.3)")
    for k, target, plant in ((last, second, later), (last + 1, first, PLANT)):
        changes_of_plant = [
            rn.PlantChange(start=0, plant=PLANT),
            rn.PlantChange(start=k, plant=later),
        ]
        schedule = rn.PlantSchedule(changes_of_plant)
        those = {at: one for at, one in changes.items() if at != last or k == last}
        run = replace(run_of(settings()), plant=schedule, first_step=first_step,
                      settings=settings(target_changes=those))  # fmt: skip
        known = arguments_of_run(run)
        assert known["target"] is target and known["plant"] == plant
        assert ("structure" in known) == (first_step == 0)


def test_theta_is_the_controller_of_a_run_if_it_alone_makes_u(adaptive, fixed):
    known = arguments_of_run(adaptive)
    assert known["structure"] == rn.iir(n_c=1) and known["k_w"] == 7
    assert "compensator" not in known and np.array_equal(known["log"].theta, adaptive.theta)
    coarse = arguments_of_run(run_of(settings(), stride=5))["log"]
    assert np.array_equal(coarse.theta.ravel(), adaptive.theta_final.ravel())
    for run in (
        run_of(settings(), saturation=rn.Saturation(low=-9.0, high=9.0)),
        run_of(settings(fixed=GAIN)),
        replace(adaptive, first_step=STEPS),
        fixed,
    ):
        known = arguments_of_run(run)
        assert not {"structure", "k_w"} & known.keys() and known["log"].theta is None
        assert np.array_equal(known["compensator"].past_y, run.compensator.past_y)
        assert ("target" in known) == (run is not fixed)


def test_the_command_is_the_block_of_w_that_the_controller_reads():
    plant = rn.servo_plant("1/(q - 0.5)")
    run = run_of(settings(structure=rn.feedforward(n_c=1)), plant)
    start = list(plant.blocks).index("r")
    assert np.array_equal(arguments_of_run(run)["log"].r, run.w[:, start : start + 1])
    assert arguments_of_run(run_of(settings(), plant))["log"].r is None


def test_a_run_of_functions_has_no_linear_plant():
    nonlinear = rn.FunctionPlant(
        advance=lambda k, x, u, w: 0.5 * np.asarray(x) + np.asarray(u),
        output=lambda k, x, w: (np.asarray(x) + np.asarray(w), np.asarray(x)),
        n=1, l_u=1, l_w=1, l_y=1, l_z=1,
    )  # fmt: skip
    run = run_of(rn.FixedController(GAIN), nonlinear)
    check = rn.check_controller(run)
    assert "plant" not in arguments_of_run(run) and check.plant is None
    assert check.replay.agrees and check.unanswered["poles"] == "the plant is not known"


def test_a_run_without_steps_has_nothing_to_check(adaptive):
    none = {
        name: getattr(adaptive, name)[:0] for name in ("u", "u_applied", "y", "z", "w", "theta")
    }
    with pytest.raises(InputError, match="no step"):
        arguments_of_run(replace(adaptive, **none))


def test_predictive_control_is_checked_as_a_compensator():
    run = run_of(rn.PredictiveCost(1, 3, R=0.1), steps=80)
    known = arguments_of_run(run)
    assert {"target", "structure", "k_w"}.isdisjoint(known) and known["plant"] is PLANT
    assert np.array_equal(known["compensator"].past_y, run.compensator.past_y)


# The controller at the end of a log.


def test_a_compensator_goes_before_theta_and_theta_before_polynomials():
    u, theta = np.ones(9), np.array([0.2, -0.3])
    polynomials = {"D_c": [1.0, -0.5], "N_c": [0.25]}
    log = rn.ControllerLog(u=u, y=u, theta=theta, **polynomials)
    assert fixed_compensator(log, rn.iir(n_c=1), GAIN) is GAIN
    of_theta = fixed_compensator(log, rn.iir(n_c=1), None)
    assert of_theta.past_u.item() == 0.2 and of_theta.past_y.ravel().tolist() == [0.0, -0.3]
    for one, structure in ((log, None), (rn.ControllerLog(u=u, y=u, **polynomials), rn.iir(n_c=1))):
        ended = fixed_compensator(one, structure, None)
        assert ended.past_u.item() == 0.5 and ended.past_y.ravel().tolist() == [0.0, 0.25]


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({}, "no theta"),
        ({"theta": np.ones(2)}, "theta needs the structure it belongs to"),
        ({"D_c": [1.0, -0.5]}, "no theta"),
        ({"N_c": [0.5]}, "no theta"),
    ],
)
def test_a_log_without_a_controller_is_refused(more, words):
    with pytest.raises(InputError, match=words):
        fixed_compensator(rn.ControllerLog(u=np.ones(9), y=np.ones(9), **more), None, None)


def test_the_plant_is_compared_with_the_signal_of_the_convention():
    """The log has the plant's output and r; the controller reads r - y, which is the plant's y."""
    plant = rn.servo_plant("0.68/(q - 0.82)")
    settings = rn.ControllerSettings(
        structure=rn.iir(2), target=rn.fir_target(plant), update=rn.UD(1e-3)
    )
    run = rn.simulate(plant, settings, np.outer(np.arange(300) // 50 % 2, [1.0, 0, 0]))
    r = run.w[:, :1]
    options = {"r": r, "theta": run.theta, "structure": rn.iir(2), "plant": plant}
    check = rn.check_controller(run.u, r - run.y, **options)
    assert str(check.conventions.matches[0].convention) == "r - y for y"
    assert check.plant_residual.rms <= 1e-12 and not check.plant_residual.is_doubtful
    named = rn.check_controller(run.u, r - run.y, **options, convention="r - y for y")
    assert named.plant_residual.rms == check.plant_residual.rms and named.is_consistent
    wrong = rn.check_controller(
        run.u, run.y, **{**options, "plant": rn.servo_plant("0.55/(q - 0.82)")}
    )
    assert wrong.is_consistent and wrong.plant_residual.is_contradicted
