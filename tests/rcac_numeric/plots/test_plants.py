"""Pictures of plants show the numbers that they are about."""

import numpy as np
import pytest

from rcac_numeric.gallery import (
    aircraft_transition,
    no_guaranteed_margins,
    plant_zeros,
    rohrs_plant,
    zero_path,
)


def points(axis):
    """All points drawn with a dot."""
    drawn = [line for line in axis.get_lines() if line.get_marker() == "."]
    return np.concatenate([np.column_stack(line.get_data()) for line in drawn])


def test_a_zero_path_shows_every_zero_in_the_plane_and_over_the_steps():
    path = zero_path(aircraft_transition(source="corrected"), [2500, 2520, 2550, 2600])
    plane, moduli = path.plot().axes
    assert np.allclose(np.sort(points(plane) @ [1, 1j]), np.sort(path.zeros.ravel()))
    assert np.allclose(np.sort(points(moduli)[:, 1]), np.sort(path.magnitudes.ravel()))
    first, last = plane.get_xlim()
    assert last > 1.137 and first < 0.851, "both ends of the pair are in the picture"


def test_a_continuous_plant_shows_poles_response_and_sampling_zeros():
    plant = rohrs_plant()
    plane, response, sampled = plant.plot([0.1, 0.3]).axes
    poles = next(line for line in plane.get_lines() if line.get_label() == "poles")
    assert np.allclose(poles.get_xdata() + 1j * poles.get_ydata(), plant.poles())
    (line,) = response.get_lines()
    assert line.get_ydata()[-1] == pytest.approx(2, abs=0.02), "T(0) = 2"
    expected = [abs(z) for h in (0.1, 0.3) for z in plant_zeros(plant.sampled(h))]
    assert points(sampled)[:, 1] == pytest.approx(expected)


def test_an_unstable_plant_has_a_short_step_response():
    (line,) = no_guaranteed_margins().plot([0.01]).axes[1].get_lines()
    assert line.get_xdata()[-1] <= 3 and np.isfinite(line.get_ydata()).all()
