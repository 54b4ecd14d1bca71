"""The guards of the pole placement at their boundaries."""

import pytest

import compensator_theory as ct
from compensator_theory.errors import ImproperError, InputError, NoSolutionError


def test_the_only_pair_may_be_improper():
    """(s^2 + s + 1) + (s^2 + 1) s is the target: D_c = 1 has too low a degree for N_c = s."""
    with pytest.raises(ImproperError):
        ct.place_poles("(s**2+1)/(s**2+s+1)", polynomial=[1, 1, 2, 1], feedback=-1)


def test_an_exactly_proper_plant_and_a_numerator_of_degree_n_c():
    """From n_c = n on the loop's leading coefficient depends on the family's parameter."""
    plant = "(s+2)/(s+1)"
    with pytest.raises(InputError):
        ct.place_poles(plant, polynomial=[1, 3, 2], numerator_degree=1, feedback=-1)
    assert ct.place_poles(plant, polynomial=[1, 3, 2], numerator_degree=0, feedback=-1).is_unique
    strictly_proper = ct.place_poles(
        "1/(s+1)", polynomial=[1, 3, 2], numerator_degree=1, feedback=-1
    )
    assert len(strictly_proper.homogeneous) == 1 and strictly_proper.residual.is_zero


def test_the_denominator_is_monic():
    """2 (s + 1) - (s + 2) = s: the pair D_c = 2, N_c = -1 is the compensator -1/2."""
    placement = ct.place_poles("(s+2)/(s+1)", polynomial=[1, 0], feedback=-1)
    assert placement.denominator.is_monic
    assert placement.compensator == ct.transfer_function("-1/2", variable="s")


def test_a_numerator_of_degree_minus_one_is_zero():
    placement = ct.place_poles("1/(s+1)", polynomial=[1, 3, 2], numerator_degree=-1, feedback=-1)
    assert placement.numerator.is_zero and placement.denominator == ct.polynomial("s + 2")
    with pytest.raises(InputError):
        ct.place_poles("1/(s+1)", polynomial=[1, 3, 2], numerator_degree=-2, feedback=-1)


def test_a_plant_without_poles():
    """The loop of the gain 2 has the poles of the compensator with N_c = 0."""
    placement = ct.place_poles("2", polynomial=[1, 3], variable="s", feedback=-1)
    assert placement.numerator.is_zero and placement.denominator == ct.polynomial("s + 3")


@pytest.mark.parametrize(
    "request_",
    [
        {"n_c": "most"},
        {"n_c": "least", "numerator_degree": 0},
        {"n_c": "least", "polynomial": [1, 3, 2]},
    ],
)
def test_the_least_order_takes_roots_alone(request_):
    with pytest.raises(InputError):
        ct.place_poles("1/s", [-1, -2], **request_, feedback=-1)
    assert ct.place_poles("1/s", [-1], "least", feedback=-1).residual.is_zero


def test_properness_and_the_degree_of_the_numerator():
    """At n = n_c = 1 a strictly proper numerator has degree 0, an exactly proper one degree 1."""

    def place(properness, degree):
        return ct.place_poles(
            "1/s",
            polynomial=[1, 3, 2],
            numerator_degree=degree,
            properness=properness,
            feedback=-1,
        )

    assert place("strictly proper", 0).numerator.degree() == 0
    assert place("exactly proper", 1).numerator.degree() == 1
    for properness, degree in (("strictly proper", 1), ("exactly proper", 0)):
        with pytest.raises(InputError):
            place(properness, degree)
    with pytest.raises(NoSolutionError):  # the only one, of degree n - 1 < n_c, is not
        ct.place_poles("1/s**2", polynomial=[1, 0, 0, 1], properness="exactly proper", feedback=-1)
