"""Jacobians against finite differences, and the published poles and transfer functions."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import InputError
from rcac_numeric import standard_plant
from rcac_numeric.gallery import (
    BoostConverter,
    CartPendulum,
    MassSpringDamper,
    no_guaranteed_margins_standard,
    plant_zeros,
)
from rcac_numeric.results import OperatingPoint

EXAMPLE = Path(__file__).resolve().parents[4] / "examples" / "boost_converter.toml"

positive = st.floats(0.1, 10)


def differences(function, x, step):
    """Central differences of fourth order, column by column."""
    columns = []
    for i in range(len(x)):
        e = np.zeros(len(x))
        e[i] = step * max(1.0, abs(x[i]))
        values = [function(x + k * e) for k in (-2, -1, 1, 2)]
        columns.append((values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * e[i]))
    return np.array(columns).T


def is_the_jacobian(plant, point):
    rest = plant.derivative(point.x, point.u)
    model = plant.linearised(point)
    A = differences(lambda x: plant.derivative(x, point.u), point.x, 1e-3)
    B = differences(lambda u: plant.derivative(point.x, u), point.u, 1e-3)
    scale = max(np.abs(model.A).max(), np.abs(model.B).max())
    assert np.abs(rest).max() <= 1e-12 * scale, "nothing moves there"
    assert np.abs(model.A - A).max() <= 1e-6 * np.abs(model.A).max()
    assert np.abs(model.B - B).max() <= 1e-6 * np.abs(model.B).max()


@given(positive, positive, positive, positive, st.floats(0, 0.95))
def test_the_boost_converter(supply, inductance, capacitance, resistance, duty):
    plant = BoostConverter(supply, 1e-4 * inductance, 1e-4 * capacitance, 10 * resistance)
    point = plant.operating_point(duty)
    is_the_jacobian(plant, point)
    zero = plant.linearised(point).zeros()[0].real
    assert zero == pytest.approx((1 - duty) ** 2 * plant.resistance / plant.inductance)


@given(positive, positive, positive, positive, positive, st.sampled_from(["upright", "hanging"]))
def test_the_pendulum(M, m, b, length, inertia, kind):
    plant = CartPendulum(M, m, b, length, inertia)
    is_the_jacobian(plant, plant.operating_point(kind))


def test_the_boost_converter_is_that_of_the_example():
    """Its G has four decimals: -0.7107 (q - 1.6682)/(q^2 - 1.9703 q + 0.9802)."""
    plant = BoostConverter()
    sampled = plant.linearised(plant.operating_point(0.5)).sampled(2e-5)
    assert (sampled.C @ sampled.B).item() == pytest.approx(-0.7107, abs=5e-5)
    assert plant_zeros(sampled) == pytest.approx([1.6682], abs=5e-5)
    assert np.poly(sampled.A) == pytest.approx([1, -1.9703, 0.9802], abs=5e-5)
    example = standard_plant(re.search(r'^G = "(.*)"$', EXAMPLE.read_text(), re.MULTILINE)[1])
    assert plant_zeros(example) == pytest.approx(plant_zeros(sampled), abs=5e-5)


def test_the_poles_of_the_control_tutorials():
    plant = CartPendulum()
    upright, hanging = (plant.linearised(plant.operating_point(k)) for k in ("upright", "hanging"))
    published = [-5.6041, -0.1428, 0, 5.5651]
    assert np.sort(upright.poles().real) == pytest.approx(published, abs=5e-5)
    assert np.abs(upright.poles().imag).max() < 1e-12
    assert hanging.poles().real.max() <= 1e-12, "hanging it is stable"


def test_a_pendulum_without_friction_keeps_its_energy_and_momentum():
    """Independent of the Jacobian: along the equations of motion both are constant."""
    plant = CartPendulum(friction=1e-300)
    M, m, l_, inertia, g = 0.5, 0.2, 0.3, 0.006, 9.8

    def conserved(x):
        _, v, phi, rate = x
        kinetic = 0.5 * (M + m) * v**2 - m * l_ * v * rate * np.cos(phi)
        kinetic += 0.5 * (inertia + m * l_**2) * rate**2
        return np.array(
            [kinetic + m * g * l_ * np.cos(phi), (M + m) * v - m * l_ * rate * np.cos(phi)]
        )

    for x in np.random.default_rng(0).normal(size=(20, 4)):
        gradient = differences(conserved, x, 1e-3)
        assert gradient @ plant.derivative(x, [0.0]) == pytest.approx([0, 0], abs=1e-8)


def test_the_mass_of_chapter_8():
    """(8.66) and (8.68) as printed."""
    plant = MassSpringDamper()
    A, B = plant.euler(0.1)
    assert np.allclose(A, [[1, 0.1], [-1, 0.5]]) and np.allclose(B, [[0], [0.1]])
    sampled = plant.continuous().sampled(1e-4)
    assert np.abs(sampled.A - plant.euler(1e-4)[0]).max() < 1e-6, "Euler to second order"


def test_the_plant_without_guaranteed_margins_has_its_noise():
    plant = no_guaranteed_margins_standard()
    h = 0.01
    # exp(hA) = e^h [1 h; 0 1]; the integral of e^t [1 + t; 1] from 0 to h is [h e^h; e^h - 1].
    assert plant.D_1[:, 0] == pytest.approx([h * np.exp(h), np.expm1(h)], rel=1e-12)
    assert plant_zeros(plant) == pytest.approx([1.0], abs=1e-9)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: BoostConverter(inductance=0), "inductance = 0; it must be positive"),
        (lambda: BoostConverter().operating_point(1.0), "duty = 1"),
        (lambda: CartPendulum(length=-1), "length = -1"),
        (lambda: CartPendulum().operating_point("sideways"), "kind"),
        (lambda: MassSpringDamper(mass=float("inf")), "mass"),
        (lambda: MassSpringDamper().euler(-1), "h = -1"),
        (lambda: OperatingPoint([float("nan")], [0]), "x has the entry nan"),
    ],
)
def test_impossible_parameters_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
