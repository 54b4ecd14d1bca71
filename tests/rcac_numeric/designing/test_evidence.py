"""No controller where none is better, limits that are never reached, and no disturbance."""

import numpy as np
import pytest

from compensator_theory.errors import InputError
from rcac_numeric import Compensator, FixedController, Recorded, Step, design, pid, simulate
from rcac_numeric.arrays._seeds import JUDGING

QUICK = {"seeds": 2, "steps": 400}
SQUARE = Recorded(np.tile([1.0, 1.0, -1.0, -1.0], 1000))  # faster than any loop with dead time


def size_of(designed, controller):
    """Rms of r - y_0 on the nominal plant, over the draws of the verdict."""
    sizes = []
    for i in range(QUICK["seeds"]):
        w = designed.expected.w(designed.steps, JUDGING + i)
        run = simulate(designed.plant, controller, w)
        sizes.append(np.sqrt(np.mean((run.z + w[:, -1:]) ** 2)))
    return np.exp(np.mean(np.log(sizes)))


@pytest.mark.costly
@pytest.mark.parametrize("lag", [2, 3, 4])
def test_where_u_zero_is_better_the_first_line_and_the_status_say_so(lag):
    designed = design(f"0.5/(q**{lag}*(q - 0.5))", disturbance=SQUARE, noise=0.01, **QUICK)
    idle = FixedController(Compensator(np.zeros((1, 1, 1)), np.zeros((2, 1, 1))))
    chosen = designed.settings if designed.verdict.use == "RCAC" else designed.fixed
    size = size_of(designed, chosen) / size_of(designed, idle)
    first, *rest = designed._sheet().health
    assert designed.verdict.is_worse_than_none == (designed.verdict.over_none > 1.005)
    if size > 1.005:
        assert first.words.startswith("Use no controller") and first.level == "bad"
        assert f"{designed.verdict.over_none:.3g} times" in first.words
        assert not any("leaves" in line.words for line in rest)
    assert designed.verdict.over_none >= size * (1 - 1e-9)


@pytest.mark.costly
def test_some_of_those_are_worse_than_none_and_a_step_is_not():
    square = design("0.5/(q**3*(q - 0.5))", disturbance=SQUARE, noise=0.01, **QUICK)
    step = design("0.5/(q*(q - 0.5))", disturbance=Step(0.5), noise=0.01, **QUICK)
    assert square.verdict.is_worse_than_none and not step.verdict.is_worse_than_none
    assert str(step.verdict).startswith("Use the fixed") or str(step.verdict).startswith("Use RCAC")


def test_of_an_integrating_plant_nothing_is_said_of_u_zero():
    designed = design("0.1/(q - 1)", disturbance=Step(0.5), noise=0.01, **QUICK)
    assert designed.verdict.over_none is None and not designed.verdict.is_worse_than_none


PLANTS = [
    ("2.1/((80*s + 1)*(15*s + 1))", {"sample_time": 5.0, "dead_time": 20.0}),
    ("1/(10*s + 1)", {"sample_time": 1.0, "dead_time": 3.0, "structure": pid("PI")}),
    ("0.2/(q - 1.05)", {}),
]


@pytest.mark.costly
@pytest.mark.parametrize(("G", "options"), PLANTS)
def test_limits_that_are_never_reached_change_nothing(G, options):
    argument = {"disturbance": Step(0.3), "noise": 0.05, "seeds": 1, "steps": 300, **options}
    free, wide = design(G, **argument), design(G, u_limits=(-1e4, 1e4), **argument)
    for side in ("past_u", "past_y"):
        of_free, of_wide = (getattr(one.fixed.compensator, side) for one in (free, wide))
        np.testing.assert_array_equal(of_free, of_wide)
    np.testing.assert_array_equal(free.settings.theta_0, wide.settings.theta_0)
    assert str(free.verdict) == str(wide.verdict)


@pytest.mark.costly
def test_limits_that_are_reached_do():
    argument = {"disturbance": Step(0.3), "noise": 0.05, "seeds": 1, "steps": 300, **PLANTS[0][1]}
    free, narrow = (
        design(PLANTS[0][0], **argument),
        design(PLANTS[0][0], u_limits=(-0.35, 0.35), **argument),
    )
    assert free.reference.R_2 != narrow.reference.R_2


@pytest.mark.parametrize("none", [None, 0, 0.0])
def test_no_disturbance_can_be_said(none):
    argument = {"command": Step(2.0), "noise": 0.01, "seeds": 1, "steps": 300}
    designed = design("0.1/(q**2*(q - 0.9))", disturbance=none, **argument)
    assert designed.expected.disturbance_size == 0 and designed.expected.is_known
    assert "disturbance" not in {q.name for q in designed.questions}
    d = designed.runs["fixed"].w[:, 1]
    assert not d.any() and designed.verdict.over_none < 1


@pytest.mark.parametrize("command", [None, Step(0.0)])
@pytest.mark.parametrize("none", [None, 0, Step(0.0)])
def test_nothing_to_control_is_refused_in_those_words(none, command):
    with pytest.raises(InputError, match="nothing to control"):
        design("0.1/(q - 0.9)", disturbance=none, command=command, noise=0.1)
