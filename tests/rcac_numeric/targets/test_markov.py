"""Markov-parameter target models: the series, and which zeros it shows."""

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import InputError
from rcac_numeric import Plant, servo_plant, standard_plant
from rcac_numeric.targets import markov_parameters, markov_target, modelling_information
from tests.support.strategies import plants

OMEGA = np.linspace(0.1, 3.0, 7)


def zeros(target):
    return np.roots(np.trim_zeros(target.numerator[:, 0, 0], "f"))


@given(plants(feedthrough=True))
def test_the_parameters_are_the_impulse_response(plant):
    """Against python-control, for any numbers of signals."""
    system = control.ss(plant.A, plant.B, plant.E_1, plant.E_2, True)
    response = control.impulse_response(system, np.arange(9), squeeze=False).outputs
    assert markov_parameters(plant, 9) == pytest.approx(np.moveaxis(response, 2, 0), abs=1e-9)


@given(plants(feedthrough=True), st.integers(1, 12))
def test_what_the_truncation_leaves_out(plant, n_bar):
    """G_zu - G_f = E_1 A^n_bar (qI - A)^{-1} B q^-n_bar: the rest of the series, summed."""
    q = np.exp(1j * OMEGA)[:, None, None]
    state = np.linalg.solve(q * np.eye(plant.n) - plant.A, (plant.B + 0j)[None])
    rest = plant.E_1 @ np.linalg.matrix_power(plant.A, n_bar) @ state / q**n_bar
    G_zu = plant.E_1 @ state + plant.E_2
    G_f = markov_target(plant, n_bar).frequency_response(OMEGA)
    assert G_f + rest == pytest.approx(G_zu, abs=1e-9 * np.abs(state).max())


@pytest.mark.exact_data
def test_cancellation_does_not_hide_the_relative_degree():
    """E_1 B = 0.1*3 - 0.3 is 5.6e-17 in float64 and 0 in truth."""
    plant = Plant(A=[[0.5, 0], [0, 0.2]], B=[[3.0], [-0.3]], D_1=[[1.0], [0]], C=[[0.1, 1.0]])
    assert (plant.C @ plant.B).item() != 0
    assert markov_target(plant, 5).relative_degree == 2


@pytest.mark.parametrize("n_bar", [1, 2, 7])
def test_every_truncation_has_the_relative_degree_and_sign_of_the_servo_problem(n_bar):
    plant = servo_plant("3*(q - 1.1)/((q - 0.8)*(q - 0.9))")
    target = markov_target(plant, n_bar)
    assert (target.relative_degree, target.n_f) == (1, n_bar)
    assert target.numerator[1] == pytest.approx(-3.0)
    assert target.exact.leading_coefficient == -3


def test_the_zeros_approximate_nmp_zeros_beyond_the_spectral_radius():
    """At the rate (0.9/1.2)^n_bar, which the example plant of this test shows."""
    plant = standard_plant("(q - 1.2)*(q - 0.5)/(q*(q - 0.3)*(q - 0.9))")
    errors = {n: np.abs(zeros(markov_target(plant, n)) - 1.2).min() for n in (20, 40, 60)}
    for shorter, longer in ((20, 40), (40, 60)):
        assert errors[longer] / errors[shorter] == pytest.approx(0.75**20, rel=0.3)
    others = [z for z in zeros(markov_target(plant, 60)) if abs(z - 1.2) > 1e-3]
    assert max(map(abs, others)) < 1, "no other zero looks like an NMP one"


def test_a_pole_on_the_circle_draws_zeros_that_the_plant_does_not_have():
    """Example 4.2: the NMP pair is found to 1e-8, among 117 others outside the unit circle."""
    plant = standard_plant(
        "(q - 0.5)*(q**2 - 1.92*q + 1.44)/((q - 1)*(q - 0.9)*(q**2 - 1.62*q + 0.81))"
    )
    zeros_of_plant = zeros(markov_target(plant, 120))
    pair = np.abs(zeros_of_plant - (0.96 + 0.72j)), np.abs(zeros_of_plant - (0.96 - 0.72j))
    assert max(pair[0].min(), pair[1].min()) < 1e-8
    others = zeros_of_plant[(pair[0] > 0.01) & (pair[1] > 0.01)]
    assert len(others) == 117 and np.all(np.abs(others) > 1)


def test_nmp_zeros_within_the_spectral_radius_are_not_seen():
    """An unstable pole at 1.5 beside an NMP zero at 1.2: the series diverges at the zero."""
    plant = standard_plant("(q - 1.2)*(q - 2)/(q*(q - 0.3)*(q - 1.5))")
    assert [float(z) for z in modelling_information(plant).nmp_zeros] == [2.0, 1.2]
    zeros_of_plant = zeros(markov_target(plant, 60))
    assert np.abs(zeros_of_plant - 2.0).min() < 1e-6
    assert np.abs(zeros_of_plant - 1.2).min() > 0.1
    assert np.sum(np.abs(zeros_of_plant) > 1.2) > 40, "and many that the plant does not have"


def test_matrix_parameters_and_arrays():
    H = np.arange(12.0).reshape(3, 2, 2)
    H[0] = 0
    target = markov_target(H)
    assert (target.l_z, target.l_u, target.n_f, target.relative_degree) == (2, 2, 2, 1)
    assert np.array_equal(markov_target(H, n_bar=1).numerator, H[:2])
    assert markov_target([0.0, 0.0, 3.0]).numerator.ravel().tolist() == [0, 0, 3]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: markov_target([0.0, 0.0]), "does not act on z"),
        (lambda: markov_target([0.0, 0.0, 1.0], n_bar=1), "relative degree d_zu = 2"),
        (lambda: markov_target([0.0, 1.0], n_bar=2), "last Markov parameter given is H_1"),
        (lambda: markov_target(np.ones((2, 2))), r"shape \(2, 2\)"),
        (lambda: markov_target([]), "n_bar"),
        (lambda: markov_target(standard_plant("1/q**3"), 2), "d_zu = 3"),
        (lambda: markov_target(standard_plant("0/(q - 0.5)"), 2), "does not act on z"),
        (lambda: markov_target(standard_plant("1/q")), "n_bar is needed"),
        (lambda: markov_target(standard_plant("1/q"), -1), "n_bar = -1"),
        (lambda: markov_target(standard_plant("1/(q - 10)"), 400), "range of float64|finite"),
    ],
)
def test_bad_input_is_named(make, message):
    with pytest.raises(InputError, match=message):
        make()
