"""The high-authority target model (4.24), against its corrected formula and the Riccati pencil."""

import numpy as np
import pytest

import compensator_theory
from compensator_theory import InputError
from compensator_theory.errors import NoSolutionError, UnitCircleError
from rcac_numeric import servo_plant, standard_plant
from rcac_numeric.targets import high_authority_target, modelling_information
from tests.support.dissertation_plants import PLANT_4_1

OMEGA = np.linspace(0.1, 3.0, 9)
Q = np.exp(1j * OMEGA)


def numerator(plant, channel):
    """Float coefficients of N over det(qI - A)."""
    return np.array(plant.problem.numerator(channel).all_coeffs(), dtype=float)


def test_example_4_1_is_the_corrected_formula():
    """G_f = H q^(n-d_zu-d_yw) prod(q-z) / [prod(q-1/z) N_yw,s prod(q-1/zeta)], by NumPy's roots."""
    N_zu, N_yw = numerator(PLANT_4_1, "zu"), numerator(PLANT_4_1, "yw")
    z, zeta = np.roots(N_zu), np.roots(N_yw)
    z, inside, zeta = z[abs(z) > 1], zeta[abs(zeta) < 1], zeta[abs(zeta) > 1]
    assert len(z) > 0, "the example is NMP"
    assert len(zeta) > 0
    d_zu, d_yw = 6 - len(N_zu), 6 - len(N_yw)

    def at(zeros):
        return np.prod(Q[:, None] - np.asarray(zeros)[None, :], axis=1)

    expected = (
        N_zu[0] * Q ** float(5 - d_zu - d_yw) * at(z) / (at(1 / z) * at(inside) * at(1 / zeta))
    )
    target = high_authority_target(PLANT_4_1)
    assert target.frequency_response(OMEGA)[:, 0, 0] == pytest.approx(expected, rel=1e-9)
    assert target.relative_degree == d_zu == modelling_information(PLANT_4_1).d_zu
    assert target.numerator[d_zu].item() == pytest.approx(N_zu[0])


def test_its_poles_are_those_of_the_riccati_pencil():
    """D_HA by another way: the LQG poles of the exact half, where E_2 = D_2 = 0."""
    closed_loop = compensator_theory.lqg_poles(PLANT_4_1.problem).enclosure.coefficients
    D_HA = np.polyval([float(ball.centre) for ball in closed_loop], Q)
    expected = np.polyval(numerator(PLANT_4_1, "zu"), Q) * Q**5 / D_HA
    response = high_authority_target(PLANT_4_1).frequency_response(OMEGA)[:, 0, 0]
    assert response == pytest.approx(expected, rel=1e-9)


@pytest.mark.exact_data
def test_it_is_the_exact_target_rounded_once():
    plant = standard_plant("3*(q - 2)*(q - 1/3)/(q**3 - 1/8)")
    exact = compensator_theory.high_authority_target(plant.problem).transfer_function
    target = high_authority_target(plant)
    assert target.exact == exact
    assert target.denominator.ravel().tolist() == [float(c) for c in exact.denominator.all_coeffs()]


def test_irrational_zeros_come_from_their_enclosures():
    plant = standard_plant("3*(q**2 - 3*q + 1)/(q**3 - 1/8)")
    target = high_authority_target(plant)
    assert target.exact is None
    zero = (3 + 5**0.5) / 2
    # N_zu = N_yw here, with relative degree 1: m = 3 - 1 - 1.
    expected = 3 * Q * (Q - zero) / (Q - 1 / zero) ** 3
    assert target.frequency_response(OMEGA)[:, 0, 0] == pytest.approx(expected)


@pytest.mark.parametrize(
    ("plant", "error", "message"),
    [
        (standard_plant("(q - 1)/(q - 0.5)**2"), UnitCircleError, "zero on the unit circle"),
        (servo_plant("(q - 0.9)/(q - 0.5)**2"), InputError, "scalar u, w, y and z"),
        (standard_plant("0/(q - 0.5)"), NoSolutionError, "u does not reach z"),
    ],
)
def test_errors_of_the_exact_half_pass_through(plant, error, message):
    with pytest.raises(error, match=message):
        high_authority_target(plant)
