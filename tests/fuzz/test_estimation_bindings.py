"""The estimators' bindings called directly, with arguments that fit and that do not.

.ci/sanitize can be given this file: nothing may be read or written out of bounds.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcac_numeric.compiled import _kernel
from rcac_numeric.estimation import RCMR, FIRSubsystem
from rcac_numeric.estimation._refinement import compiled_refinement
from tests.support.kernel_arguments import damaged_state, perhaps_damaged
from tests.support.kernel_calls import attempt


def tape(n, l_u, size):
    """x_0 + u_0 or x_0 + x_0, as often as it is asked for."""
    steps = np.array([[0, 1, 1 + n if l_u else 1]], dtype=np.int32)
    return np.array([2.0]), steps, np.full(size, 1 + n + l_u + 1, dtype=np.int32)


@given(n=st.integers(1, 3), l_u=st.integers(0, 2), l_y=st.integers(1, 2), data=st.data())
def test_filters(n, l_u, l_y, data):
    draw = data.draw
    sizes = {"n": n, "l_u": l_u, "l_y": l_y}
    matrices = {
        "A": np.eye(n) / 2, "B": np.ones((n, l_u)), "C": np.ones((l_y, n)), "D": np.ones((l_y, l_u))
    }  # fmt: skip
    linear = attempt(
        _kernel.linear_estimation_model, **sizes, **perhaps_damaged(draw, matrices)
    ) or _kernel.linear_estimation_model(**sizes, **matrices)
    program = _kernel.tape_estimation_model(
        **sizes, f=tape(n, l_u, n), h=tape(n, l_u, l_y),
        f_F=tape(n, l_u, n + n * n), h_H=tape(n, l_u, l_y + l_y * n),
    )  # fmt: skip
    arguments = {
        "x_0": np.zeros(n), "S_0": np.eye(n), "Q_root": np.eye(n), "R_root": np.eye(l_y),
        "alpha": draw(st.sampled_from([3.0, 0.5, -1.0, np.nan])),
        "beta": draw(st.sampled_from([0.0, 2.0, -1.0, np.nan])),
    }  # fmt: skip
    kind = draw(st.sampled_from(["extended", "joseph", "unscented", "other"]))
    model = draw(st.sampled_from([linear, program]))
    built = attempt(_kernel.filter, kind, model, **perhaps_damaged(draw, arguments))
    if built is None:
        return
    for _ in range(draw(st.integers(1, 6))):
        samples = perhaps_damaged(draw, {"y": np.ones(l_y), "u": np.ones(l_u)})
        attempt(built.move, **samples, corrects=draw(st.booleans()), predicts=draw(st.booleans()))
        attempt(built.restore, damaged_state(draw, built.save()))
        assert built.x.shape == (n,) and built.P.shape == (n, n) and built.k >= 0


@pytest.mark.parametrize(
    "wrong",
    [
        (np.array([1.0]), np.array([[99, 0, 0]], dtype=np.int32), np.array([0], dtype=np.int32)),
        (np.array([1.0]), np.array([[0, 0, 3]], dtype=np.int32), np.array([0], dtype=np.int32)),
        (np.array([1.0]), np.array([[0, -1, 0]], dtype=np.int32), np.array([0], dtype=np.int32)),
        (np.array([1.0]), np.array([[0, 0, 0]], dtype=np.int32), np.array([4], dtype=np.int32)),
        (np.array([1.0]), np.array([[0, 0, 0]], dtype=np.int32), np.array([0, 0], dtype=np.int32)),
        (np.array([1.0]), np.array([[0, 0]], dtype=np.int32), np.array([0], dtype=np.int32)),
        (np.array([1.0]), None, np.array([0], dtype=np.int32)),
        "tape",
    ],
)
def test_a_tape_that_leads_beyond_its_registers_is_refused(wrong):
    good = (np.array([1.0]), np.array([[0, 1, 1]], dtype=np.int32), np.array([3], dtype=np.int32))
    two = (*good[:2], np.array([3, 3], dtype=np.int32))
    _kernel.tape_estimation_model(1, 0, 1, good, good, two, two)
    with pytest.raises((ValueError, TypeError)):
        _kernel.tape_estimation_model(1, 0, 1, wrong, good, two, two)


@given(data=st.data())
def test_refinements(data):
    draw = data.draw
    built = compiled_refinement(
        RCMR(
            A=np.eye(2) / 2, B=np.eye(2), D_1=[0, 1], C=np.eye(2), E_1=np.eye(2),
            subsystem=FIRSubsystem(2, strictly_proper=draw(st.booleans())), delays=(1, 3),
        )
    )  # fmt: skip
    for _ in range(draw(st.integers(1, 8))):
        samples = perhaps_damaged(draw, {"w": np.ones(1), "y": np.ones(2), "x": np.ones(2)})
        attempt(built.step, **samples)
        attempt(built.half, np.ones(draw(st.integers(0, 3))), None, draw(st.booleans()))
        attempt(built.restore, damaged_state(draw, built.save()))
        assert built.theta.shape == (8,) and built.P.shape == (8, 8) and built.k >= 0
