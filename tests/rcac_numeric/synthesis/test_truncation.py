"""Plants of many states, measured impulse responses above all, as plants of few."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory.errors import NoSolutionError
from rcac_numeric import design
from rcac_numeric.analysis.closed_loop import ClosedLoop
from rcac_numeric.plants.linear import Plant
from rcac_numeric.synthesis.plants import DesignPlant
from rcac_numeric.synthesis.truncation import AT_REST, MOST_STATES, OF_PEAK, truncated


def impulse_response(modes, late, taps=120):
    """A DesignPlant of so many taps: damped oscillations (frequency, damping), late by steps."""
    k = np.arange(taps - late)
    sum_of = sum(np.exp(-zeta * w * k) * np.sin(w * (k + 1)) for w, zeta in modes)
    h = np.append(np.zeros(late), sum_of)
    return DesignPlant(np.eye(taps, k=-1), np.eye(taps, 1), h[None])


@given(
    st.lists(st.tuples(st.floats(0.3, 2.5), st.floats(0.1, 0.4)), min_size=1, max_size=3),
    st.integers(0, 8),
)
def test_few_states_are_near_at_frequencies_that_chose_nothing(modes, late):
    plant = impulse_response(modes, late)
    found, error = truncated(plant)
    omega = np.random.default_rng(0).uniform(0, np.pi, 300)
    difference = np.abs(plant.response(omega) - found.response(omega)).max()
    peak = np.abs(plant.response(np.linspace(0, np.pi, 600))).max()
    assert difference <= (1.2 * error + 1e-12) * peak
    assert error <= min(OF_PEAK, AT_REST * plant.low_gain / peak) * (1 + 1e-12)
    assert found.is_stable
    assert found.delay >= late
    assert len(found.A) <= 20  # two for each mode, and a few for the tail that was cut off


def test_what_is_small_or_unstable_is_left_as_it_is():
    small = impulse_response([(1.0, 0.2)], 0, taps=MOST_STATES)
    unstable = DesignPlant(np.diag(np.linspace(-0.9, 1.1, 60)), np.ones((60, 1)), np.ones((1, 60)))
    for plant in (small, unstable):
        assert truncated(plant) == (plant, 0.0)


@pytest.mark.costly
def test_the_controller_of_the_truncation_is_held_against_the_whole_plant():
    whole = impulse_response([(0.4, 0.1), (0.9, 0.06), (1.5, 0.05)], 5)
    found = design(Plant(whole.A, whole.B, whole.B, whole.C), noise=0.01, seeds=1, steps=400)
    assert len(found.model.A) < 12
    assert found.model.delay == 5
    assert "of its 120 states" in found.questions[0].assumed
    assert ClosedLoop(whole.servo(), found.fixed.compensator).is_stable


def test_a_controller_that_the_whole_plant_does_not_bear_is_refused(monkeypatch):
    from rcac_numeric.synthesis import design as module

    wrong = impulse_response([(0.4, 0.1)], 0)
    other, _ = truncated(DesignPlant(wrong.A, wrong.B, -wrong.C))
    monkeypatch.setattr(module, "truncated", lambda plant: (other, 0.01))
    with pytest.raises(NoSolutionError, match="give a model of lower order"):
        design(Plant(wrong.A, wrong.B, wrong.B, wrong.C), seeds=1, steps=100)
