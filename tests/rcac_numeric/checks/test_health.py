"""The health of a loop: what is wrong is said first, with the remedy that cures it."""

import numpy as np
import pytest

import rcac_numeric as rn
from compensator_theory.errors import InputError
from rcac_numeric.analysis._internal_models import drift_of
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.checks._health import excitation_of
from rcac_numeric.checks._rules import small_margins
from rcac_numeric.checks._target_errors import target_errors
from rcac_numeric.checks._trials import next_disturbance
from rcac_numeric.reports._check import check_sheet
from rcac_numeric.reports._loop import health_lines
from tests.support.examples import EXAMPLE_4_7


def codes(health):
    return [warning.code for warning in health.warnings]


def adapted(plant, target, w, R_theta=1e-2, n_c=2, **options):
    settings = rn.ControllerSettings(
        structure=rn.iir(n_c=n_c), target=target, update=rn.UD(R_theta=R_theta)
    )
    return rn.simulate(plant, settings, w, **options)


def motor(R_theta):
    """A motor that follows a unit step."""
    plant = rn.servo_plant("(0.0001*q + 0.00009)/(q**2 - 1.9*q + 0.9)")
    w = rn.exogenous([rn.Step(), rn.Step(0), rn.Step(0)], steps=2000)
    return adapted(plant, rn.fir_target(plant), w, R_theta, n_c=4)


def test_a_motor_that_blew_up_on_the_way_does_not_end_green():
    run = motor(R_theta=1e-6)
    assert run.outcome == "completed" and abs(run.u).max() > 1e6 and abs(run.z[-1]).max() < 1e-9
    assert {"large transient", "large control"} <= set(codes(rn.loop_health(run)))


def test_a_larger_R_theta_cures_the_motor_as_the_warning_says():
    """R_theta = 1: |u| stays below 1, and no grave warning is left."""
    health = rn.loop_health(motor(R_theta=1.0))
    assert health.signals["u"].after.peak < 1
    assert not any(warning.is_grave for warning in health.warnings)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_a_loop_at_1e52_has_diverged_by_default_whatever_the_scale(scale):
    """1e15 times what acts on the loop: no digit of it is left in float64."""
    plant = rn.standard_plant("1/(q - 1.5)")
    idle = rn.FixedController(rn.Compensator(np.zeros((0, 1, 1)), np.zeros((1, 1, 1))))
    run = rn.simulate(plant, idle, scale * np.ones((300, 1)))
    assert run.outcome == "diverged" and abs(run.z).max() <= 1e15 * max(scale, 1.0)
    health = rn.loop_health(run)
    assert health.is_stable is False and codes(health)[:2] == ["diverged", "unstable"]


def test_a_wrong_sign_is_named_and_turning_it_is_the_cure():
    plant = rn.servo_plant("1/(q - 0.5)")
    w = rn.exogenous([rn.Step(), rn.WhiteNoise(0.01)], steps=500)[:, :1] @ np.array(
        [[1.0, 0.0, 0.0]]
    )
    right = rn.fir_target(plant)
    wrong = rn.TargetModel(-right.numerator, right.denominator)
    bad, good = (rn.loop_health(adapted(plant, target, w)) for target in (wrong, right))
    assert "wrong sign" in codes(bad) and bad.is_stable is False
    assert "the sign of H" in bad.warnings[0].next_step
    assert "wrong sign" not in codes(good) and good.is_stable


def test_contradictions_between_target_and_plant():
    plant = rn.standard_plant("(q - 1.25)/(q**2*(q - 0.5))")
    assert target_errors(plant, rn.fir_target(plant)) == ()
    result = target_errors(plant, rn.TargetModel([0.0, 1.0]))
    assert [e.code for e in result] == ["wrong d_zu", "unmodelled zero"]
    assert "d_zu = 2" in result[0].next_step and "1.25" in result[1].next_step


def test_excitation_is_the_count_of_a_plain_sum():
    """Against the regressor written out step by step."""
    plant = rn.standard_plant("(q - 0.3)/(q*(q - 0.9))")
    w = rn.exogenous([rn.WhiteNoise()], steps=200, seed=4)
    for R_theta in (1e-3, 50.0, 1e9):
        run = adapted(plant, rn.fir_target(plant), w, R_theta)
        N = run.settings.target.numerator[:, 0, 0]
        pairs = [(signal, lag) for signal in (run.u, run.y) for lag in (1, 2)]
        phi = [np.array([s[k - i, 0] if k >= i else 0.0 for s, i in pairs]) for k in range(200)]
        total = np.zeros((4, 4))
        for k in range(run.settings.k_update, run.steps):
            row = sum((N[i] * phi[k - i] for i in range(len(N)) if k >= i), np.zeros(4))
            total += np.outer(row, row)
        expected = int((np.linalg.eigvalsh(total) > R_theta).sum())
        assert excitation_of(run).outweighed == expected
    assert "no excitation" in codes(rn.loop_health(run)) and expected == 0


def test_saturation_rounding_and_a_short_record_are_said():
    plant = rn.servo_plant("1/(q - 0.99)")
    w = np.zeros((400, 3))
    w[:, 0] = 1.0
    stored = adapted(
        plant, rn.fir_target(plant), w, 1e-3, saturation=rn.Saturation(low=-0.005, high=0.005)
    )
    health = rn.loop_health(stored)
    assert "saturated" in codes(health)
    assert health.signals["u"].after.peak > 0.005 == health.signals["u_applied"].after.peak
    assert "u_applied" not in rn.loop_health(adapted(plant, rn.fir_target(plant), w, 1e-3)).signals
    idle = rn.FixedController(rn.Compensator(np.zeros((0, 1, 1)), np.zeros((1, 1, 1))))
    assert codes(rn.loop_health(rn.simulate(plant, idle, w[:50]))) == ["slow"]
    guarded = replace(stored, guard_count=3, guard_first_step=7)
    assert "rounding" in codes(rn.loop_health(guarded))


def test_numbers_that_are_none_in_u_and_in_u_applied_are_no_saturation():
    plant = rn.standard_plant("1/(q - 0.9)")
    run = adapted(plant, rn.fir_target(plant), rn.exogenous([rn.WhiteNoise()], 100))
    lost = run.u.copy()
    lost[-3:] = np.nan
    ended = replace(run, u=lost, u_applied=lost.copy())
    assert set(rn.loop_health(ended).signals) == {"z", "u"}
    assert "saturated" not in codes(rn.loop_health(ended))


def test_health_has_the_margins_of_every_channel_without_the_disk():
    """The disk margin is the costly one; stability_margins computes it."""
    plant = rn.standard_plant("1/(q - 1.2)")
    controller = rn.FixedController(rn.lqg_controller(plant).compensator)
    run = rn.simulate(plant, controller, rn.exogenous([rn.Step()], steps=100))
    expected = rn.stability_margins(run)
    (margins,) = rn.loop_health(run).margins.values()
    assert margins.disk is None and expected.disk is not None
    assert margins.gain_up == expected.gain_up and margins.phase == expected.phase


@pytest.mark.parametrize(("steps", "is_saturated"), [(4, False), (5, True), (40, True)])
def test_saturated_is_an_actuator_that_misses_more_than_a_tenth_of_the_last_tenth(
    steps, is_saturated
):
    """Of 400 steps the last 40 count; before them the actuator may do what it likes."""
    plant = rn.servo_plant("1/(q - 0.99)")
    run = adapted(plant, rn.fir_target(plant), np.ones((400, 3)) * [0.001, 0, 0],
                  saturation=rn.Saturation(low=-5, high=5))  # fmt: skip
    applied = run.u.copy()
    applied[:360] += 1.0
    applied[len(applied) - steps :] += 1.0
    health = rn.loop_health(replace(run, u_applied=applied))
    assert ("saturated" in codes(health)) == is_saturated


@pytest.mark.parametrize(("moved", "is_unsettled"), [(0.09, False), (0.12, True), (0.8, True)])
def test_unsettled_is_theta_that_moves_by_more_than_a_tenth_of_its_size(moved, is_unsettled):
    """Of a run and of its log: what theta was when the last tenth began, beside what it became."""
    plant = rn.standard_plant("1/(q - 0.9)")
    run = adapted(plant, rn.fir_target(plant), rn.exogenous([rn.WhiteNoise()], 400))
    theta = np.repeat(run.theta_final[None], 400, axis=0)
    theta[:380] *= 1 - moved
    assert drift_of(theta).relative == pytest.approx(moved)
    shown = [rn.loop_health(replace(run, theta=theta))]
    shown.append(
        rn.loop_health(rn.check_controller(run.u, run.y, theta=theta, structure=rn.iir(2)))
    )
    for health in shown:
        assert ("unsettled" in codes(health)) == is_unsettled


def test_a_check_begins_with_health_too():
    plant = rn.standard_plant("1/(q - 2)")
    gain = rn.Compensator(past_u=[[[-1.0]]], past_y=[[[0.0]], [[-2.5]]])
    u, y = np.zeros((20, 1)), np.zeros((20, 1))
    sheet = check_sheet(rn.check_controller(u, y, compensator=gain, plant=plant))
    assert sheet.health[0].words.startswith("The closed loop is stable")
    assert [w["code"] for w in sheet.record["warnings"]] == ["small margins"]
    margins = sheet.record["health"]["margins"]["u"]
    assert margins["gain_up"] == pytest.approx(1.2) and margins["gain_down"] == pytest.approx(0.8)


def test_margins_that_textbooks_accept_are_not_small():
    loop = rn.Compensator(np.zeros((0, 1, 1)), [[[-0.2]]])
    check = rn.check_controller(np.zeros(9), np.zeros(9), compensator=loop,
                             plant=rn.standard_plant("1/(q - 0.5)"))  # fmt: skip
    assert small_margins(check.margins["u"]) == [] and rn.loop_health(check).is_healthy
    assert health_lines(rn.loop_health(check))[0].level == "good"


def test_a_run_has_the_margins_of_its_last_controller():
    plant = rn.standard_plant("1/(q - 0.9)")
    run = adapted(plant, rn.fir_target(plant), rn.exogenous([rn.WhiteNoise()], 200))
    margins = rn.loop_health(run).margins["u"]
    direct = rn.stability_margins(rn.ClosedLoop(plant, run.compensator))
    assert (margins.gain_up.value, margins.phase.value) == (
        direct.gain_up.value,
        direct.phase.value,
    )


def test_what_has_no_health_is_refused():
    with pytest.raises(InputError, match="give a Run"):
        rn.loop_health(3)


@pytest.mark.parametrize("size", [0.02, 0.1, 0.25, 0.3])
def test_the_next_disturbance_of_a_constant_has_its_size_not_that_of_its_rounding(size):
    plant = rn.standard_plant("(q + 2)/(q**2 - 2*q + 1.04)")
    settings = rn.ControllerSettings(
        structure=rn.iir(n_c=3), target=rn.fir_target(plant), update=rn.UD(R_theta=1e-8), k_w=60
    )
    candidates = next_disturbance(rn.simulate(plant, settings, rn.exogenous([rn.Step(size)], 160)))
    assert candidates.frozen > 0.05 * size


def test_the_health_of_a_log_without_z():
    """Its signals are y and u; a health without a loop gives the reason."""
    run = EXAMPLE_4_7.run(60)
    health = rn.loop_health(rn.check_controller(run.u, run.y, compensator=run.compensator))
    assert list(health.signals) == ["y", "u"]
    assert health.obstacle and health.is_stable is None
