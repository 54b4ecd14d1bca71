"""Target models from plants and from modelling information alone."""

import numpy as np
import pytest

from compensator_theory import CompensatorError, InputError
from compensator_theory.errors import ImproperError
from rcac_numeric import (
    ModellingInformation,
    TargetModel,
    fir_target,
    pole_placement_target,
    servo_plant,
    standard_plant,
    target_model,
)
from rcac_numeric.targets import modelling_information

OMEGA = np.linspace(0.1, 3.0, 7)
Q = np.exp(1j * OMEGA)


def response(target):
    return target.frequency_response(OMEGA)[:, 0, 0]


def test_minimum_phase_fir_is_2_49():
    plant = standard_plant("3*(q - 0.5)/((q - 0.1)*(q - 0.2)*(q - 0.3))")
    assert response(fir_target(plant)) == pytest.approx(3 / Q**2)


def test_nmp_fir_is_2_50():
    plant = standard_plant("2*(q - 1.2)*(q - 0.5)/((q - 0.9)*(q - 0.95)*(q - 0.1))")
    assert response(fir_target(plant)) == pytest.approx(2 * (Q - 1.2) / Q**2)


def test_the_servo_problem_turns_the_sign():
    """G_zu = -G_u, so the target of the servo problem starts with -H of G_u."""
    G = "(q - 0.85)/((q - 0.8)*(q - 0.9))"
    assert response(fir_target(servo_plant(G))) == pytest.approx(-1 / Q)
    assert response(fir_target(standard_plant(G))) == pytest.approx(1 / Q)


def test_pole_placement_is_4_38_and_4_39():
    D_p = (Q - 0.1) * (Q - 0.3) * (Q**2 + 0.09)
    poles = ["0.1", "0.3", "0.3j", "-0.3j"]
    information = ModellingInformation(d_zu=2, H=-1.5)
    assert response(pole_placement_target(information, poles)) == pytest.approx(-1.5 * Q**2 / D_p)
    information = ModellingInformation(d_zu=1, H=1.0, nmp_zeros=["1.2", "-2"])
    assert response(pole_placement_target(information, poles)) == pytest.approx(
        Q * (Q - 1.2) * (Q + 2) / D_p
    )


def test_few_poles_leave_the_rest_at_zero():
    """n_p < d_zu: the negative power of q in (4.38) is a delay."""
    information = ModellingInformation(d_zu=3, H=1.0)
    assert response(pole_placement_target(information, ["0.5"])) == pytest.approx(
        1 / (Q**2 * (Q - 0.5))
    )


def test_zeros_on_the_unit_circle_count_as_nmp():
    plant = standard_plant("(q**2 + 1)*(q - 0.5)/(q - 0.1)**4")
    zeros = [complex(z) for z in modelling_information(plant).nmp_zeros]
    assert sorted(zeros, key=lambda z: z.imag) == pytest.approx([-1j, 1j])


def test_a_hidden_unstable_mode_counts_as_a_zero():
    """det(qI - A) is not reduced, so a cancelled unstable mode of the plant stays in N_zu."""
    plant = standard_plant("(q - 1.5)/((q - 1.5)*(q - 0.5))")
    assert [float(z) for z in modelling_information(plant).nmp_zeros] == [1.5]


def test_multiple_zeros_count_with_multiplicity():
    plant = standard_plant("(q - 2)**2*(q - 0.5)/(q*(q - 0.1)*(q - 0.2)*(q - 0.3))")
    assert [float(z) for z in modelling_information(plant).nmp_zeros] == [2.0, 2.0]


@pytest.mark.parametrize(
    ("numerator", "outside"),
    [
        ("q - 0.99999999999999999999", 0),
        ("q - 1.00000000000000000001", 1),
        ("q**2 - 1.9999999999999999999*q + 0.99999999999999999998", 0),
        ("q**4 - 3*q**3 + 3*q**2 - 3*q + 1", 3),  # two on the circle, one on each side
    ],
)
def test_the_unit_circle_is_decided_exactly(numerator, outside):
    plant = standard_plant(f"({numerator})/(q*(q - 0.5)*(q - 0.2)*(q - 0.1)*(q - 0.3))")
    assert len(modelling_information(plant).nmp_zeros) == outside


def test_irrational_zeros_are_found():
    plant = standard_plant("(q**2 - 3*q + 1)/(q*(q - 0.5)*(q - 0.2))")
    (zero,) = modelling_information(plant).nmp_zeros
    assert complex(zero) == pytest.approx((3 + 5**0.5) / 2)
    assert response(fir_target(plant)) == pytest.approx((Q - complex(zero)) / Q**2)


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: target_model("q**2/(q - 0.5)"), ImproperError, "more zeros than poles"),
        (lambda: ModellingInformation(1, 0.0), InputError, "H = 0"),
        (lambda: ModellingInformation(1, 1.0, [0.5]), InputError, "0.5 has modulus 0.5 < 1"),
        (lambda: ModellingInformation(-1, 1.0), InputError, "d_zu = -1"),
        (lambda: ModellingInformation(1, float("nan")), CompensatorError, "NaN|nan"),
        (lambda: TargetModel([0.0, 0.0]), InputError, "target model is zero"),
        (lambda: TargetModel([0.0, 1.0], exact=5), InputError, "exact = 5 is not a Transfer"),
        (lambda: ModellingInformation(1, "a"), InputError, "contains symbols"),
        (lambda: ModellingInformation(1, 1.0, ["a"]), InputError, "contains symbols"),
        (lambda: ModellingInformation(1, 1.0, 1.5), InputError, "must be a list"),
        (lambda: ModellingInformation(10**6, 1.0), InputError, "at most 10000"),
        (lambda: pole_placement_target(ModellingInformation(1, 1.0), 0.5), InputError, "list of r"),
        (
            lambda: pole_placement_target(ModellingInformation(1, 1.0), "q - q"),
            InputError,
            "is zero",
        ),
        (lambda: pole_placement_target(ModellingInformation(1, 1.0), "s - 1"), InputError, "in q"),
        (lambda: target_model("a/q"), InputError, "contains a, which is not a number"),
        (lambda: target_model("1/s"), InputError, "not a transfer function in q"),
        (lambda: standard_plant("1/(q - sqrt(2))"), InputError, "irrational number sqrt"),
        (lambda: standard_plant("1/(s + 1)"), InputError, "RCAC runs in discrete time"),
        (lambda: TargetModel([0.0, 1.0], [2.0, 1.0]), InputError, "must be the identity"),
        (lambda: TargetModel(np.ones((2, 2, 1)), np.ones((2, 1, 1))), InputError, "l_z = 2"),
        (
            lambda: pole_placement_target(ModellingInformation(1, 1.0), ["0.5j"]),
            CompensatorError,
            "conjugate",
        ),
        (
            lambda: fir_target(standard_plant("0/(q - 0.5)")),
            CompensatorError,
            "can be adapted|zero",
        ),
    ],
)
def test_bad_input_is_named(make, error, message):
    with pytest.raises(error, match=message):
        make()


def test_coefficients_that_are_not_those_of_the_exact_form_are_refused():
    target = target_model("(q - 2)/(q**2 - 1/3*q)")
    assert TargetModel(target.numerator, target.denominator, target.exact) == target
    for numerator in ([0.0, 1.0, -2.0 - 1e-9], [1.0, -2.0], [0.0, 0.0, 1.0, -2.0]):
        with pytest.raises(InputError, match="not those of its exact form"):
            TargetModel(numerator, target.denominator, target.exact)
    with pytest.raises(InputError, match="its exact form 1 x 1"):
        TargetModel(np.ones((2, 1, 2)), exact=target.exact)
