"""Plants of many states, measured impulse responses above all, as plants of few."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import block_diag

from compensator_theory.errors import BudgetError, NoSolutionError
from rcac_numeric import ClosedLoop, Compensator, Plant, Step, design
from rcac_numeric.analysis._closed_loop import frozen_loop
from rcac_numeric.designing._plants import LONGEST_DELAY, DesignPlant
from rcac_numeric.designing._reference import sensitivity_peak
from rcac_numeric.designing._truncation import (
    AT_REST,
    MOST_STATES,
    OF_PEAK,
    Truncation,
    truncated,
)


def impulse_response(modes, late, taps=120):
    """A DesignPlant of so many taps: damped oscillations (frequency, damping), late by steps."""
    k = np.arange(taps - late)
    sum_of = sum(np.exp(-zeta * w * k) * np.sin(w * (k + 1)) for w, zeta in modes)
    h = np.append(np.zeros(late), sum_of)
    return DesignPlant(np.eye(taps, k=-1), np.eye(taps, 1), h[None])


@pytest.mark.costly
@given(
    st.lists(st.tuples(st.floats(0.3, 2.5), st.floats(0.1, 0.4)), min_size=1, max_size=3),
    st.integers(0, 8),
)
def test_few_states_are_near_at_frequencies_that_chose_nothing(modes, late):
    whole = impulse_response(modes, late)
    reduced = truncated(whole)
    omega = np.random.default_rng(0).uniform(0, np.pi, 300)
    difference = np.abs(whole.response(omega) - reduced.plant.response(omega)).max()
    peak = np.abs(whole.response(np.linspace(0, np.pi, 600))).max()
    assert difference <= (1.2 * reduced.error + 1e-12) * peak
    assert reduced.error <= min(OF_PEAK, AT_REST * whole.low_gain / peak) * (1 + 1e-12)
    assert reduced.plant.is_stable
    assert reduced.plant.delay >= late
    assert len(reduced.plant.A) <= 20  # two for each mode, and a few for the tail that was cut off


def test_a_resonance_between_two_frequencies_of_the_grid_is_seen():
    """Its peak is a thousandth of the grid wide, and half as high again as what is allowed."""
    pole = (1 - 3e-6) * np.exp(1j * (np.pi / 599) * 100.5)
    others = DesignPlant(np.diag(np.linspace(-0.8, 0.8, 60)), np.ones((60, 1)), np.ones((1, 60)))
    peak = np.abs(others.response(np.linspace(0, np.pi, 600))).max()
    allowed = min(OF_PEAK * peak, AT_REST * others.low_gain)
    high = np.sqrt(2 * 1.5 * allowed * (1 - abs(pole)))
    A = block_diag([[pole.real, pole.imag], [-pole.imag, pole.real]], others.A)
    B = np.append([high, 0.0], np.ones(60))[:, None]
    whole = DesignPlant(A, B, B.T)
    at = np.angle(pole)
    assert abs(whole.response(at) - others.response(at)).item() > 1.4 * allowed
    reduced = truncated(whole)
    assert abs(whole.response(at) - reduced.plant.response(at)).item() < 1.01 * allowed
    assert len(reduced.plant.A) < 20


@pytest.mark.costly
@given(st.floats(0.1, 1.0), st.floats(0.0, 0.95), st.sampled_from([-1, 1]))
def test_small_gain_is_enough_for_the_whole_plant(share, pole, sign):
    """Much is left out, a whole mode: what it promises of stability and of Ms is so even then."""
    whole = impulse_response([(0.4, 0.15), (1.1, 0.5)], 2, taps=50)
    few = truncated(impulse_response([(0.4, 0.15)], 2)).plant
    omega = np.linspace(0, np.pi, 3000)
    left_out = np.abs(whole.response(omega) - few.response(omega)).ravel()
    result = Truncation(whole, few, omega, left_out, 0.0)
    gain = sign * share * (1 - pole) / np.abs(few.response(omega)).max()  # below 1 around the loop
    controller = Compensator(past_u=[[[pole]]], past_y=[[[0.0]], [[gain]]])
    small = result.small_gain(controller)
    assert small > 1e-3
    if small < 1:
        by_few, by_all = (ClosedLoop(one.servo(), controller) for one in (few, whole))
        assert by_all.is_stable
        assert sensitivity_peak(by_all) <= sensitivity_peak(by_few) / (1 - small) * (1 + 1e-3)


def test_dead_time_leaves_room_for_the_coefficients_of_several_signals():
    one = impulse_response([(1.0, 0.3)], 40)
    two = DesignPlant(*(np.kron(np.eye(2), M) for M in (one.A, one.B, one.C)))
    assert truncated(one).plant.delay == 40
    assert truncated(two).plant.delay == LONGEST_DELAY // 2


def test_what_is_small_or_unstable_is_left_as_it_is():
    small = impulse_response([(1.0, 0.2)], 0, taps=MOST_STATES)
    unstable = DesignPlant(np.diag(np.linspace(-0.9, 1.1, 60)), np.ones((60, 1)), np.ones((1, 60)))
    assert truncated(small) is None and truncated(unstable) is None


@pytest.mark.costly
@pytest.mark.parametrize("reads_r", [False, True])
def test_the_controller_of_the_truncation_is_held_against_the_whole_plant(reads_r):
    whole = impulse_response([(0.4, 0.1), (0.9, 0.06), (1.5, 0.05)], 5)
    plant = Plant(whole.A, whole.B, whole.B, whole.C)
    designed = design(plant, noise=0.01, seeds=1, steps=400, command=Step(0.1), feedforward=reads_r)
    assert len(designed.model.A) < 12
    assert designed.model.delay == 5
    assert "of its 120 states" in designed.questions[0].assumed
    assert frozen_loop(whole.servo(), designed.fixed.compensator, 0).is_stable


def test_a_controller_that_the_whole_plant_does_not_bear_is_refused(monkeypatch):
    from rcac_numeric.designing import _design as module

    whole = impulse_response([(0.4, 0.1)], 0)
    turned = truncated(DesignPlant(whole.A, whole.B, -whole.C))
    wrong = replace(turned, whole=whole, left_out=np.full_like(turned.omega, 1e3))
    monkeypatch.setattr(module, "truncated", lambda plant: wrong)
    with pytest.raises(NoSolutionError, match="give a model of lower order"):
        design(Plant(whole.A, whole.B, whole.B, whole.C), seeds=1, steps=100)


def poles_on_a_circle(n, radius):
    """A plant whose poles are n points of a circle: no state of it may be left out."""
    A = np.eye(n, k=-1)
    A[0, -1] = radius**n
    return Plant(
        A=A, B=np.eye(n)[:, [0]], C=np.eye(n)[[-1]], D_1=np.eye(n)[:, [0]], E_1=np.eye(n)[[-1]]
    )


@pytest.mark.costly
@pytest.mark.parametrize(
    "plant",
    [
        "1/(q - 1)**400",
        "1/(q - 1/2)**60",
        poles_on_a_circle(60, 1.01),
        poles_on_a_circle(60, 0.999),
    ],
    ids=["chain of integrators", "multiple pole", "unstable", "rings"],
)
def test_more_states_than_a_design_takes_are_refused_before_an_equation_is_solved(
    plant, monkeypatch
):
    monkeypatch.setattr("rcac_numeric.designing._design.WeightGrid", None)
    with pytest.raises(BudgetError, match=r"the plant has \d+ states.*Reduce its order"):
        design(plant)
