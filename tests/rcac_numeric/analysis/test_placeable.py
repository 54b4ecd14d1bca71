"""Whether a structure's coefficients place the poles that a target asks for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn

PLANTS = ("1/(q - 0.9)", "1/((q - 0.8)*(q - 0.5))", "(q - 0.4)/((q - 1.1)*(q - 0.6))")


def comparison(plant, structure, theta, poles):
    target = rn.pole_placement_target(plant, poles)
    return rn.compare_exactly(plant, structure.compensator(theta), target)


@given(
    plant=st.sampled_from(PLANTS),
    poles=st.lists(st.integers(-8, 8), min_size=1, max_size=2),
    seed=st.integers(0, 1000),
)
def test_iir_of_the_plants_order_places_them_whatever_it_is_now(plant, poles, seed):
    plant = rn.standard_plant(plant)
    structure = rn.iir(plant.n + 1)
    theta = np.random.default_rng(seed).uniform(-1, 1, structure.l_theta)
    compared = comparison(plant, structure, theta, [f"{p}/10" for p in poles])
    assert compared.can_be_placed_by(structure) is True


def test_two_gains_place_what_two_gains_make_and_nothing_else():
    """PI on 1/(q - a): q^3 - (1 + a + k) q^2 + ..., by hand: u = k_p y(k-1) + k_i sum, (2.58)."""
    plant, structure = rn.standard_plant("1/(q - 9/10)"), rn.pid("PI")
    theta = np.array([-0.2, -0.05])
    n_c = structure.compensator(theta).n_c
    reached = comparison(plant, structure, theta, ["1/2"]).reached
    roots = np.roots([float(c) for c in reached.all_coeffs()])
    assert len(roots) == plant.n + n_c
    compared = comparison(plant, structure, theta, ["1/2", "1/3"])
    # least squares over the two gains, by the polynomials of two other gains
    columns = [
        [float(c) for c in comparison(plant, structure, e, ["1/2"]).reached.all_coeffs()]
        for e in (np.zeros(2), np.array([1.0, 0]), np.array([0, 1.0]))
    ]
    base, M = np.array(columns[0]), np.array(columns[1:]).T - np.array(columns[0])[:, None]
    values = np.array([float(c) for c in compared.requested.all_coeffs()])
    left = np.linalg.lstsq(M, values - base, rcond=None)[1]
    assert (left.size and left[0] > 1e-6) == (compared.can_be_placed_by(structure) is False)
    assert compared.can_be_placed_by(structure) is False


def test_what_is_not_from_y_to_u_alone_is_not_decided():
    plant = rn.standard_plant(PLANTS[0])
    compared = comparison(plant, rn.iir(2), np.zeros(4), ["1/2"])
    assert compared.can_be_placed_by(rn.feedforward(2)) is None
    assert compared.can_be_placed_by(rn.fir(2)) is False  # no past u: fewer than the loop has poles


@pytest.mark.parametrize("kind", ["P", "PI", "PID"])
def test_the_report_says_it_is_the_structure(kind):
    """A loop of two gains opens with what they cannot do, and in no alarm."""
    from rcac_numeric.reports._loop import missed_poles

    plant, structure = rn.standard_plant(PLANTS[1]), rn.pid(kind)
    compared = comparison(plant, structure, np.full(structure.l_theta, -0.1), ["1/2", "1/4"])
    (line,) = missed_poles(compared, structure)
    assert line.level == "warning" and f"{structure.l_theta} coefficients" in line.words
    (alarm,) = missed_poles(compared)
    assert alarm.level == "bad" and "NOT reached" in alarm.words
