"""Zeros and directions from records: the plants of known directions, and refusals."""

import numpy as np
import pytest

from benchmarks.yardsticks.directed_plants import cost_ratio, plant_of_fractions
from compensator_theory.errors import InputError
from rcac_numeric.identification import directions_from_data
from rcac_numeric.targets import zero_direction_target
from tests.support.directed_plants import directions

H = np.array([[1.0, 0.5], [-0.3, 1.2]])
V = np.array([[1.0, 0.4], [0.7, 1.0]])
X = V @ np.diag([1.5, 0.3]) @ np.linalg.inv(V)
POLES = {"one denominator": [(0.6, 0.8), (0.6, 0.8)], "two": [(0.6, 0.8), (0.2, -0.4)]}


def record(poles, seed, steps, std=0.01, X=X, amplitude=0.01):
    """Open loop: u white, and w of the same size where u enters."""
    plant = plant_of_fractions(poles, H, X)
    rng = np.random.default_rng(seed)
    u, w = rng.standard_normal((2, steps, 2)) * [[[amplitude]], [[std]]]
    x, z = np.zeros(4), []
    for k in range(steps):
        z.append(plant.C @ x)
        x = plant.A @ x + plant.B @ (u[k] + w[k])
    return plant, u, np.array(z)


@pytest.mark.parametrize("poles", POLES.values(), ids=POLES)
def test_without_noise_they_are_exact(poles):
    _, u, z = record(poles, 0, 200, std=0.0)
    result = directions_from_data(u, z, order=2)
    [(z0, eta)] = result.information.zeros
    assert abs(z0 - 1.5) < 1e-9 and np.allclose(result.information.H, H)
    expected = directions(poles, X, 1.5)
    assert abs(np.vdot(expected, eta)) > (1 - 1e-12) * np.linalg.norm(eta)


@pytest.mark.costly
@pytest.mark.parametrize("poles", POLES.values(), ids=POLES)
def test_noise_as_large_as_the_input(poles):
    """1000 steps carry a target: four seeds of four, at most 7 % above LQG."""
    for seed in range(4):
        plant, u, z = record(poles, seed, 1000)
        directions = directions_from_data(u, z, order=4, level=0.0)
        assert len(directions.information.zeros) == 1
        assert cost_ratio(plant, zero_direction_target(directions.information), seed) <= 1.07


def test_the_standard_error_is_that_of_many_records():
    """The zero of 60 records of exact order and white error of the equations spreads as claimed."""
    rng, zeros, claimed = np.random.default_rng(1), [], []
    for _ in range(60):
        u, e = rng.standard_normal((2, 400, 2)) * [[[1.0]], [[0.1]]]
        z = np.zeros((400, 2))
        for k in range(2, 400):
            z[k] = 0.5 * z[k - 1] + H @ u[k - 1] - X @ H @ u[k - 2] + e[k]
        directions = directions_from_data(u, z, order=2)
        nearest = np.argmin(np.abs(directions.zeros - 1.5))
        zeros.append(directions.zeros[nearest].real)
        claimed.append(directions.errors[nearest])
    assert 0.75 < np.std(zeros) / np.median(claimed) < 1.33


def test_a_zero_near_the_circle_is_lost_to_the_bias_of_a_low_order():
    """1.15 with noise as large as u: order 4 never has it, however long; 3 times the u does."""
    near = V @ np.diag([1.15, 0.3]) @ np.linalg.inv(V)

    def right(seed, steps, amplitude):
        _, u, z = record(POLES["one denominator"], seed, steps, X=near, amplitude=amplitude)
        try:
            zeros = directions_from_data(u, z, order=4).information.zeros
        except InputError:
            return False
        return len(zeros) == 1 and abs(zeros[0][0] - 1.15) < 0.1

    assert not any(right(seed, 1000, 0.01) for seed in range(5))
    assert not any(right(seed, 8000, 0.01) for seed in range(1))
    assert sum(right(seed, 1000, 0.03) for seed in range(5)) >= 4


def test_refusals():
    _, u, z = record(POLES["two"], 0, 400)
    with pytest.raises(InputError, match="inside or outside"):
        directions_from_data(u[:60], z[:60], order=4)
    with pytest.raises(InputError, match="too few"):
        directions_from_data(u[:20], z[:20], order=4)
    with pytest.raises(InputError, match="do not determine"):
        directions_from_data(np.ones_like(u), z, order=4)
    with pytest.raises(InputError, match="square"):
        directions_from_data(u, z[:, :1], order=4)
    late = np.vstack([np.zeros((2, 2)), u[:-2]])
    with pytest.raises(InputError, match="relative degree"):
        directions_from_data(u, late, order=2)
