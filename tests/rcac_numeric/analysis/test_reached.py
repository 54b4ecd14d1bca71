"""Whether poles are reached: by the backward error, never by the distance of multiple roots."""

import numpy as np
import pytest

import rcac_numeric as rn
from tests.support.placed_loops import compensator_of, delayed_run, matching, missing


@pytest.mark.costly
def test_no_loop_that_matches_is_missed_and_none_that_misses_is_unseen():
    """500 of each: `python benchmarks/missed_poles.py`."""
    far = 0
    for seed in range(8):
        for loop in (matching(seed), missing(seed)):
            comparison = rn.compare_exactly(loop.plant, loop.compensator, loop.target)
            assert comparison.is_reached == loop.is_same, (seed, loop.words)
            assert bool(comparison.missed) != loop.is_same
            far += loop.is_same and comparison.worst_distance > 0.05
            if loop.run is not None:
                codes = {warning.code for warning in rn.loop_health(loop.run).warnings}
                assert ("missed poles" in codes) != loop.is_same, (seed, loop.words)
    assert far  # a distance would have raised a false alarm


def test_a_sixfold_pole_at_zero_is_reached_everywhere_that_is_asked():
    run = delayed_run()
    comparison = rn.compare_exactly(run)
    assert (
        comparison.worst_distance > 0.05
        and comparison.backward_error < 1e-3
        and comparison.is_reached
    )
    assert "NOT reached" not in comparison.report() and "moves by" in comparison.report()
    assert not [w for w in rn.loop_health(run).warnings if w.code == "missed poles"]
    check = rn.check_controller(run)
    assert check.comparison.is_reached and "NOT reached" not in check.report()


@pytest.mark.costly
def test_one_that_misses_has_the_line_and_the_warning():
    run = delayed_run(R_theta=1e4, steps=300)
    comparison = rn.compare_exactly(run)
    assert not comparison.is_reached and comparison.backward_error > 0.05
    assert "NOT reached" in comparison.report()
    (warning,) = [w for w in rn.loop_health(run).warnings if w.code == "missed poles"]
    assert f"{comparison.worst_distance:.2g}" in warning.sentence
    assert "NOT reached" in rn.check_controller(run).report()


@pytest.mark.parametrize("d", [0.005, 0.06, 0.2])
@pytest.mark.parametrize("p", [-0.7, 0.0, 0.4, 0.9])
def test_a_simple_pole_that_is_off_by_d_is_off_by_d_over_its_distance_from_the_circle(p, d):
    """1/(q - 1/2) under u = Q_1 y(k-1) + P_1 u(k-1) has two poles; one is moved inwards."""
    plant, rest = rn.standard_plant("1/(q - 1/2)"), 0.3
    requested = (f"{p}", f"{rest}")
    moved = p - d if p > 0 else p + d
    # (q - 1/2)(q - P) - Q = (q - moved)(q - rest)
    P = moved + rest - 0.5
    Q = 0.5 * P - moved * rest
    c = rn.Compensator(past_u=[[[P]]], past_y=[[[0.0]], [[Q]]])
    comparison = rn.compare_exactly(plant, c, rn.pole_placement_target(plant, requested))
    nearest = 1 - max(abs(p), abs(moved))
    assert comparison.backward_error == pytest.approx(d / (d + nearest), rel=1e-6)
    assert comparison.is_reached == (d == 0.005)


def test_a_pole_that_cancels_a_zero_does_not_count_for_the_one_asked_for_there():
    """A zero and a pole of G_f at -0.16: the loop has one pole there, and the other at -0.22."""
    loop = missing(304)
    comparison = rn.compare_exactly(loop.plant, loop.compensator, loop.target)
    assert comparison.worst_distance < 1e-9 and not comparison.is_reached and comparison.missed


def test_poles_on_the_circle_are_reached_by_what_rounds_to_them():
    plant = rn.standard_plant("1/(q - 1/2)")
    c = rn.Compensator(past_u=[[[0.5 + 1e-12]]], past_y=[[[0.0]], [[0.25]]])
    comparison = rn.compare_exactly(plant, c, rn.pole_placement_target(plant, ["1", "0"]))
    assert comparison.worst_distance < 1e-11 and comparison.is_reached


def test_without_an_exact_prediction_the_poles_at_zero_are_judged_alike():
    """A target model of float64 coefficients, as `design` makes them."""
    run = delayed_run()
    exact = run.settings.target
    rounded = rn.TargetModel(exact.numerator, exact.denominator)
    comparison = rn.compare_exactly(run.plant, run.compensator, rounded)
    assert (
        comparison.requested is None and comparison.is_reached and comparison.backward_error < 1e-3
    )
    scaled = rn.TargetModel(1.5 * exact.numerator, exact.denominator)  # no loop reaches its gain
    comparison = rn.compare_exactly(run.plant, run.compensator, scaled)
    assert comparison.is_reached and comparison.worst_distance > 0.05  # and its poles are there
    other = rn.TargetModel(exact.numerator, np.convolve(exact.denominator.ravel(), [1, -0.6]))
    assert not rn.compare_exactly(run.plant, run.compensator, other).is_reached


def test_what_a_multiple_pole_moves_by_is_what_it_moves_by():
    """u = 0 leaves q**7 (q - 1/2); the last coefficient changes by 1e-9."""
    plant = rn.standard_plant("1/(q**6*(q - 1/2))")
    zero = compensator_of([0, 0], [1, 0])
    comparison = rn.compare_exactly(plant, zero, rn.pole_placement_target(plant, ["1/2"]))
    pole, m, moved = comparison.sensitivity(1e-9)
    assert (pole, m) == (0, 7) and comparison.is_reached
    roots = np.roots([1, -0.5, *[0] * 6, 1e-9])
    largest = np.sort(np.abs(roots))[-2]
    assert moved == pytest.approx(largest, rel=0.1)
    simple = rn.standard_plant("1/(q - 1/2)")
    target = rn.pole_placement_target(simple, ["1/2", "1/4"])
    assert rn.compare_exactly(simple, zero, target).sensitivity() is None


@pytest.mark.costly
def test_a_design_with_dead_time_has_no_false_warning():
    designed = rn.design("1.7/(55*s+1)", sample_time=3.0, dead_time=12.0, disturbance=rn.Step(0.4),
                   noise=0.02, seeds=1, steps=600)  # fmt: skip
    assert not designed.health.warnings


@pytest.mark.parametrize("d", [0.0, 1e-6, 0.004, 0.012, 0.02])
@pytest.mark.parametrize("p", [-0.5, 0.0, 0.5])
def test_poles_that_are_reached_nearly_are_said_with_the_number_first(p, d):
    """As above: one of two simple poles is moved inwards by d."""
    plant, rest = rn.standard_plant("1/(q - 1/2)"), 0.3
    moved = p - d if p > 0 else p + d
    P = moved + rest - 0.5
    c = rn.Compensator(past_u=[[[P]]], past_y=[[[0.0]], [[0.5 * P - moved * rest]]])
    target = rn.pole_placement_target(plant, [f"{p}", f"{rest}"])
    comparison = rn.compare_exactly(plant, c, target)
    assert comparison.is_reached
    u, y = np.zeros((50, 1)), np.zeros((50, 1))
    log = rn.ControllerLog(u=u, y=y, D_c=c.denominator, N_c=c.numerator)
    check = rn.check_controller(log, plant=plant, target=target)
    for report in (comparison.report(), check.report()):
        first = next(line for line in report.splitlines()[:3] if "oles" in line or "stable" in line)
        number = f"{100 * comparison.backward_error:.2g} %"
        assert ("reached; " in first and number in first) == (comparison.backward_error > 1e-3)
        if d > 1e-3:
            assert f"error {d:.2g}" in " ".join(report.split())
