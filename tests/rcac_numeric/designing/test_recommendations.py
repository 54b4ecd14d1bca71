"""What a comparison recommends, at its bounds, and what `design` refuses and passes on."""

from types import SimpleNamespace

import numpy as np
import pytest

from compensator_theory.errors import InputError
from rcac_numeric import (
    Compensator,
    FixedController,
    Recorded,
    Step,
    design,
    pid,
    simulate,
)
from rcac_numeric.arrays._seeds import JUDGING
from rcac_numeric.designing._design import (
    NONE,
    PEAK,
    WORTH,
    Comparison,
    Recommendation,
    _choice,
    _meaning_of_sign,
    _over_none,
)
from rcac_numeric.designing._expected import read_expected
from rcac_numeric.designing._plants import Variation, read_plant
from rcac_numeric.designing._trials import BOXED, FIXED, FULL, PID, RCAC, Trials

SMALL = {"noise": 0.1, "seeds": 1, "steps": 100}  # the least that design runs
BELOW, ABOVE = np.nextafter(WORTH, 0), np.nextafter(1 / WORTH, 2)


def compared(ratio=1.0, interval=(0.0, np.inf), peak=1.0, wins=0, losses=0):
    return Comparison(ratio, interval, (3, 3), (3, 3), (0.4, 1.0), "none", peak, wins, losses)


@pytest.mark.parametrize(
    ("comparison", "use", "words"),
    [
        (compared(interval=(0.5, BELOW)), RCAC, "over the uncertainty"),
        (compared(interval=(0.5, WORTH)), FIXED, "significant, but not significantly more than"),
        (compared(0.96, (0.946, 0.969)), FIXED, "by 4 %: significant, but not significantly more"),
        (compared(0.96, (0.946, np.nextafter(1, 0))), FIXED, "than the 5 % that justify"),
        (compared(interval=(0.5, 0.9), losses=1, wins=1), RCAC, "over the uncertainty"),
        (compared(interval=(0.5, 0.9), losses=1), FIXED, "1 are unstable with RCAC alone"),
        (compared(interval=(0.5, 0.9), peak=PEAK), RCAC, "over the uncertainty"),
        (compared(interval=(0.5, 0.9), peak=1.6), FIXED, "1.6 times as large"),
        (compared(interval=(0.9, np.nextafter(1 / WORTH, 0)), wins=1), RCAC, "1 of 3 test runs"),
        (compared(interval=(0.9, 1 / WORTH), wins=1), FIXED, "which is not significant"),
        (compared(interval=(0.9, 1.0), wins=1, losses=1), FIXED, "0.5 %: not significant."),
        (compared(interval=(1.2, 1.4), wins=1), FIXED, "1 of 3 test runs"),
        (compared(interval=(1.2, 1.4)), FIXED, "RCAC changes"),
        (compared(interval=(ABOVE, 1.4)), FIXED, "over the uncertainty"),
        (compared(interval=(1 / WORTH, 1.4)), FIXED, "0.5 %, which is significant"),
        (compared(interval=(np.nextafter(1, 2), 1.4)), FIXED, "which is significant"),
        (compared(interval=(1.0, 1.4)), FIXED, ": not significant."),
        (compared(ratio=np.nan, interval=(np.nan, np.nan)), FIXED, ": not significant."),
    ],
)
def test_the_choice_at_its_bounds(comparison, use, words):
    choice, why = _choice(SimpleNamespace(stable=(True,)), comparison)
    assert choice == use and words in why
    lost, reason = _choice(SimpleNamespace(stable=(True, False)), comparison)
    assert lost == FIXED and "nominal plant" in reason


@pytest.mark.parametrize(
    ("ratio", "words"),
    [
        (0.1, "lowers the rms error by 90 %"),
        (1.9, "raises the rms error by 90 %"),
        (0.99, "lowers the rms error by 1 %"),
        (1.0051, "raises the rms error by 1 %"),
        (1.0049, "changes the rms error by less than 0.5 %"),
        (1.0, "changes the rms error by less than 0.5 %"),
    ],
)
def test_the_change_is_in_percent(ratio, words):
    assert words in _choice(SimpleNamespace(stable=(True,)), compared(ratio))[1]


@pytest.mark.parametrize(
    ("interval", "wins", "losses", "is_better"),
    [
        ((0.5, BELOW), 0, 0, True),
        ((0.5, WORTH), 0, 0, False),
        ((0.5, 0.9), 1, 1, True),
        ((0.5, 0.9), 0, 1, False),
        ((0.5, 0.97), 1, 0, False),
    ],
)
def test_better_is_significant_and_loses_no_more_than_it_wins(interval, wins, losses, is_better):
    assert compared(interval=interval, wins=wins, losses=losses).is_better == is_better


@pytest.mark.parametrize(
    ("over", "is_worse"),
    [(None, False), (NONE, False), (np.nextafter(NONE, 2), True), (0.5, False)],
)
def test_no_controller_is_better_above_three_digits(over, is_worse):
    verdict = Recommendation(FIXED, "why.", compared(), 1.5, over)
    assert verdict.is_worse_than_none == is_worse
    assert str(verdict).startswith("Use no controller" if is_worse else "Use the fixed controller")


IDLE = FixedController(Compensator(np.zeros((1, 1, 1)), np.zeros((2, 1, 1))))
GAIN = FixedController(Compensator(np.zeros((1, 1, 1)), [[[-0.3]], [[0.1]]]))


def trials_of(controller, G="1/(q - 0.9)", steps=200, disturbance=None):
    disturbance = Step(0.5) if disturbance is None else disturbance
    plant = read_plant(G, None, 0.0)
    expected, _ = read_expected(disturbance, 0.05, None, np.inf, plant.low_gain)
    return Trials({FIXED: controller}, plant, expected, (Variation("nominal"),), steps, 3)


def test_over_none_is_the_larger_of_the_ratios_of_whole_run_and_tail():
    """By the definition: geometric means over the draws of the rms of r - y_0."""
    assert _over_none(trials_of(IDLE), FIXED) == pytest.approx(1, rel=1e-12)
    by_first = Recorded(np.r_[np.full(150, 0.5), np.full(50, 1e-3)])  # so that the tail is worse
    for disturbance in (Step(0.5), by_first):
        trials = trials_of(GAIN, disturbance=disturbance)
        plant = trials.plant.servo()
        ratios = []
        for part in (slice(None), slice(150, None)):
            logs = []
            for i in range(3):
                w = trials.expected.w(200, JUDGING + i)
                e = [
                    (r.z + w[:, 2:])[part]
                    for r in (simulate(plant, one, w) for one in (GAIN, IDLE))
                ]
                logs.append(np.log(np.linalg.norm(e[0]) / np.linalg.norm(e[1])))
            ratios.append(np.exp(np.mean(logs)))
        assert abs(ratios[0] / ratios[1] - 1) > 1e-3
        assert _over_none(trials, FIXED) == pytest.approx(max(ratios), rel=1e-9)


def test_there_is_no_ratio_to_an_error_without_bound_or_of_zero():
    assert _over_none(trials_of(GAIN, "0.1/(q - 1)"), FIXED) is None
    late = Recorded(np.r_[np.zeros(1000), 1.0])  # acts after the runs
    assert _over_none(trials_of(IDLE, disturbance=late), FIXED) is None


def test_the_smallest_design_has_its_parts():
    designed = design("1/(q - 0.9)", disturbance=Step(0.5), u_limits=(-0.9, 0.9), **SMALL)
    assert set(designed.runs) == {RCAC, FIXED, PID} and designed.runs[RCAC].steps == 100
    assert designed.certified is None and set(designed.alternatives) == {PID}
    assert not np.array_equal(designed.runs[RCAC].u, designed.runs[FIXED].u)


def test_a_structure_has_lqg_beside_it_and_no_command_leaves_no_alternative():
    designed = design("1/(q - 0.9)", disturbance=Step(0.5), structure=pid("PI"), **SMALL)
    assert set(designed.runs) == {RCAC, FIXED, FULL, PID}
    assert designed.alternatives[FULL].compensator is designed.reference.full


def test_a_certified_set_has_the_box_beside_it():
    kept = design("1/(q - 0.9)", disturbance=Step(0.5), kept="certified", **SMALL)
    assert set(kept.runs) == {RCAC, BOXED, FIXED, PID}
    assert kept.settings.bounds == kept.certified.bounds


class Frame:
    """What a DataFrame is known by."""

    columns, index = ["valve", "level"], [0, 1]


@pytest.mark.parametrize("plant", [Frame(), [Frame()], (Frame(), Frame())])
def test_a_frame_is_refused_with_the_call_that_reads_it(plant):
    with pytest.raises(InputError, match=r"read_log.*valve, level"):
        design(plant, **SMALL)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"steps": 99}, "steps"),
        ({"seeds": 0}, "seeds"),
        ({"u_limits": (0.5, 0.5)}, "must have low < high"),
        ({"uncertainty": 0.2}, "uncertainty"),
        ({"structure": "PI"}, "structure"),
    ],
)
def test_arguments_are_refused_before_the_plant_is_read(options, words):
    with pytest.raises(InputError, match=words):
        design(None, **{**SMALL, **options})


@pytest.mark.parametrize(
    ("plant", "sign", "words"),
    [
        ("1/(s + 1)", "+", "of y at rest"),
        ("1/s", "+", "in the end"),
        ("15/(3*s - 1)", "+", "G(1) = -15 is the equilibrium, which is unstable"),
        ("-15/(3*s - 1)", "-", "G(1) = 15 is the equilibrium, which is unstable"),
    ],
)
def test_the_assumed_sign_names_its_response(plant, sign, words):
    """y of 15/(3 s - 1) grows after a step of u, and its equilibrium for a constant u is -15 u."""
    model = read_plant(plant, 0.1, 0.0)
    assert model.sign == sign and words in _meaning_of_sign(model)
