"""Pictures of the plants of an experiment: zeros that are identified, zeros of its steps."""

import numpy as np
import pytest

from rcac_experiments import FigureRequest, verify
from rcac_experiments.dissertation import load_example
from rcac_experiments.files._builder import build
from rcac_experiments.judging._measures import windows_of
from rcac_experiments.plots._requested import plot_request
from rcac_numeric.gallery import plant_zeros, rohrs_plant

OPEN_LOOP = {
    "plant": {"problem": "aircraft transition", "start": 14, "duration": 1},
    "signals": {"d": {"white_noise": 1}},
    "target": {"model": "fir"},
    "controller": {"n_c": 4, "R_theta": 1, "k_w": 275},
    "run": {"steps": 280},
}


@pytest.fixture(scope="module")
def flight():
    return verify(build(OPEN_LOOP, "flight"))


def points(axis):
    """All points drawn with a dot."""
    drawn = [line for line in axis.get_lines() if line.get_marker() == "."]
    return np.concatenate([np.column_stack(line.get_data()) for line in drawn])


def test_identified_zeros_lie_on_those_of_the_plant(flight):
    request = FigureRequest("identified zeros", "words")
    (axis,) = plot_request(flight, request).axes
    run = flight.main.first.run
    result = np.concatenate([np.abs(w.zeros.zeros) for w in windows_of(run) if w.zeros is not None])
    drawn = np.concatenate([bar.get_children()[0].get_ydata() for bar in axis.containers])
    assert np.allclose(np.sort(drawn), np.sort(result)) and len(result) == 3 * 3
    assert "1 of 4 windows refused" in axis.get_title(), "that of the transition"


def test_plant_zeros_are_those_of_the_steps_that_are_asked_for(flight):
    request = FigureRequest("plant zeros", "words", first=140, last=150)
    _, moduli = plot_request(flight, request).axes
    assert set(points(moduli)[:, 0]) == set(range(140, 151))
    assert points(moduli)[:, 1].max() == pytest.approx(1.1359, abs=5e-5)


def test_plants_that_do_not_change_are_drawn_in_planes_alone():
    verification = verify(load_example("1.3").reduced(1))
    names = ["h = 0.1, zero known", "h = 0.2"]
    axes = plot_request(verification, FigureRequest("plant zeros", "words", runs=names)).axes
    assert len(axes) == 2 and "moduli 1.822, 0.1164" in axes[0].get_title()
    for axis, h in zip(axes, (0.1, 0.2), strict=True):
        (line,) = [line for line in axis.get_lines() if line.get_label() == "zeros"]
        expected = plant_zeros(rohrs_plant().sampled(h))
        assert np.allclose(line.get_xdata() + 1j * line.get_ydata(), expected)
