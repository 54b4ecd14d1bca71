"""A pure delay that is taken out of the states, against the states with it."""

from unittest.mock import patch

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rcac_numeric import Compensator, stability_margins, standard_plant
from rcac_numeric.analysis._opened_loop import OpenedLoop, broken_loop
from rcac_numeric.analysis._pure_delays import without_delay
from tests.support.loops import random_loop, seeds


@st.composite
def sparse_systems(draw):
    """Few entries, most of them 1, so that chains stand everywhere and some lead round others."""
    n, drawn = draw(st.integers(1, 9)), np.random.default_rng(draw(st.integers(0, 10**6)))
    density = draw(st.sampled_from([0.1, 0.2, 0.4]))
    A, B, C = (
        drawn.choice([1.0, 1.0, 1.0, 0.5, -0.25], shape) * (drawn.random(shape) < density)
        for shape in ((n, n), (n, 1), (1, n))
    )
    A = np.where(np.eye(n, k=-1) > 0, drawn.random((n, n)) < 0.7, A)
    B[0], C[0, -1] = 1.0, 1.0
    return A, B, C, np.zeros((1, 1))


@settings(max_examples=100)
@given(sparse_systems())
def test_the_response_and_the_other_poles_stay(system):
    A, B, C, _ = system
    steps, (A_0, B_0, C_0, _) = without_delay(*system)
    for at in 10 * np.exp(1j * np.linspace(0.1, 3, 9)):  # outside norm(A)
        left = at**steps * C @ np.linalg.solve(at * np.eye(len(A)) - A, B)
        right = C_0 @ np.linalg.solve(at * np.eye(len(A_0)) - A_0, B_0)
        assert np.allclose(left, right, rtol=1e-9, atol=1e-13)
    removed = len(A) - len(A_0)
    assert removed >= steps if steps else removed == 0
    wide = np.concatenate(
        [np.poly(A_0), np.zeros(removed)]
    )  # det(zI - A) = z^removed det(zI - A_0)
    assert np.allclose(np.poly(A), wide, atol=1e-9 * np.abs(wide).max())


CHAINS = {
    "controllable form": (control.tf([0.004], [1, -0.995, *[0] * 30], True), 1),
    "a zero beside it": (control.tf([0.004, 0.002], [1, -0.995, *[0] * 30], True), 2),
    "between plant and compensator": (
        (
            standard_plant("0.004/(q**30*(q - 0.995))"),
            Compensator(past_u=[[[-0.1]]], past_y=[[[0.0]], [[-1.0]]]),
        ),
        3,
    ),
}


@pytest.mark.parametrize("at", ["u", "y"])
@pytest.mark.parametrize("name", CHAINS)
def test_a_chain_leaves_no_states_wherever_it_stands(name, at):
    loop, most = CHAINS[name]
    if isinstance(loop, tuple):
        opened = broken_loop(loop, at=at)
    elif at == "u":
        opened = broken_loop(loop, feedback=-1)
    else:  # the dual form, with the chain behind the input
        parts = broken_loop(loop, feedback=-1)
        opened = OpenedLoop(parts.A.T, parts.C.T, parts.B.T, parts.D)
    steps, inner = opened.undelayed
    assert len(inner.A) <= most
    assert steps >= 29


def test_what_goes_round_a_chain_or_comes_back_keeps_it():
    A = np.eye(4, k=-1)
    for others in ({(3, 0): 0.5}, {(0, 3): 0.5}):  # a second path, and a loop
        for place, entry in others.items():
            changed = A.copy()
            changed[place] = entry
            B, C = np.eye(4)[:, [0]], np.eye(4)[[3]]
            steps, (A_0, *_) = without_delay(changed, B, C, np.zeros((1, 1)))
            assert len(A_0) == 4 - steps
            poles = np.abs(np.linalg.eigvals(A_0))
            assert (poles > 0.1).sum() == (np.abs(np.linalg.eigvals(changed)) > 0.1).sum()


def values(margins):
    disk = margins.disk
    numbers = [margins.gain_up, margins.gain_down, margins.phase_lag, margins.phase_lead]
    numbers = [boundary.value for boundary in [*numbers, margins.delay]]
    return np.array([*numbers, disk.alpha, disk.S_peak, disk.T_peak])


@pytest.mark.costly
@settings(max_examples=25)
@given(seeds, st.integers(1, 30))
def test_the_margins_are_those_with_all_states(seed, steps):
    loop = broken_loop(random_loop(seed), feedback=-1).delayed(steps)
    L = control.ss(loop.A, loop.B, loop.C, loop.D, True)
    ours = stability_margins(L, feedback=-1)
    with patch.object(OpenedLoop, "undelayed", property(lambda self: (0, self))):
        theirs = stability_margins(L, feedback=-1)
    assert ours.is_stable == theirs.is_stable
    assert len(ours.gain_crossovers) == len(theirs.gain_crossovers)
    assert np.allclose(ours.gain_crossovers, theirs.gain_crossovers, atol=1e-7)
    assert np.allclose(ours.phase_crossovers, theirs.phase_crossovers, atol=1e-7)
    if ours.is_stable:
        assert np.allclose(values(ours), values(theirs), rtol=1e-7)
        assert abs(ours.disk.radius_at - 1) < 1e-6
