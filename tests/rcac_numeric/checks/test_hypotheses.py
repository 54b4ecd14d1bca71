"""Which problem a log is of: decided by prediction, or undecided, and never by default."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory.errors import InputError
from rcac_numeric.checks._hypotheses import decide_problem

G = "0.1*(q - 0.4)/((q - 0.9)*(q - 0.7))"
PLANTS = {"standard": rn.standard_plant(G), "servo": rn.servo_plant(G)}


@given(
    seed=st.integers(0, 2**32 - 1),
    sign=st.sampled_from([1, -1]),
    delay=st.integers(0, 3),
    unit=st.sampled_from([1.0, 2.0**-40, 2.0**40]),
)
def test_an_excited_log_tells_its_sign_and_delay_in_any_unit(seed, sign, delay, unit):
    rng = np.random.default_rng(seed)
    u, y = rng.standard_normal(300), np.zeros(300)
    late = np.concatenate([np.zeros(delay), u])[:300]
    for k in range(2, 300):
        y[k] = 1.6 * y[k - 1] - 0.63 * y[k - 2] + sign * 0.1 * (late[k - 1] - 0.4 * late[k - 2])
        y[k] += 0.02 * rng.standard_normal()
    decision = decide_problem(rn.ControllerLog(unit * u, unit * y), PLANTS).decided
    assert (decision.problem, decision.delay) == ("standard" if sign > 0 else "servo", delay)


def test_a_log_without_control_is_undecided():
    rng = np.random.default_rng(0)
    decision = decide_problem(rn.ControllerLog(np.zeros(300), rng.standard_normal(300)), PLANTS)
    assert decision.is_undecided and str(decision).startswith("UNDECIDED")


def test_what_cannot_be_compared_is_refused():
    short = rn.ControllerLog(np.ones(20), np.arange(20.0))
    with pytest.raises(InputError, match="too few"):
        decide_problem(short, PLANTS)
    with pytest.raises(InputError, match="there is one plant"):
        decide_problem(short, {"standard": PLANTS["standard"]})
    with pytest.raises(InputError, match="l_y = 2"):
        decide_problem(rn.ControllerLog(np.ones(200), np.ones((200, 2))), PLANTS)
