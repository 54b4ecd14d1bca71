"""Exact data in, exact prediction out: nothing is rounded to float64 and read back."""

import inspect

import numpy as np
import pytest
from sympy import Poly, Symbol

import rcac_numeric
from compensator_theory import CompensatorError
from rcac_numeric import (
    Compensator,
    ModellingInformation,
    compare_exactly,
    pole_placement_target,
    standard_plant,
)
from rcac_numeric.targets import modelling_information
from rcac_numeric.targets._modelling import factor_not_inside, zeros_not_inside
from tests.support.public import public_objects

q = Symbol("q")
# Beside a zero at 1/3; none of the roots is rational, and none inside the unit circle.
OUTSIDE = {
    "a pair": "q**2 - 17/7*q + 34/9",
    "a pair of whole parts": "q**2 + 7",
    "two real ones": "q**2 - 5*q + 16/3",
    "three": "q**3 + 3*q**2 + 7*q + 11",
    "a pair on the circle": "q**2 - 10/7*q + 1",
    "a double pair": "(q**2 + 7)**2",
}
PLANTS = ("standard_plant", "servo_plant", "plant_of")
# What a function that makes a target model of a plant is given besides.
BESIDES = {
    "pole_placement_target": (["1/3"],),
    "markov_target": (4,),
}


def numerator(words):
    return f"({words})*(q - 1/3)/7"


def constructors():
    """The public functions that make a target model of a plant."""
    result = {}
    for name, one in public_objects("rcac_numeric").items():
        if not inspect.isfunction(one):
            continue
        signature = inspect.signature(one)
        first = next(iter(signature.parameters.values()), None)
        if (
            first is not None
            and "TargetModel" in str(signature.return_annotation)
            and "Plant" in str(first.annotation)
        ):
            result[name.rpartition(".")[2]] = one
    return result


CONSTRUCTORS = constructors()


def plant(kind, words):
    degree = Poly(numerator(words), q).degree() + 2
    return getattr(rcac_numeric, kind)(f"({numerator(words)})/((q - 2/3)*q**{degree})")


def test_the_known_ones_are_walked():
    assert {"fir_target", "pole_placement_target", "markov_target"} <= set(CONSTRUCTORS)
    assert set(BESIDES) <= set(CONSTRUCTORS)


@pytest.mark.parametrize("kind", PLANTS)
@pytest.mark.parametrize("name", sorted(CONSTRUCTORS))
def test_no_coefficient_was_a_decimal_on_the_way(name, kind):
    """No fraction of the plant has a factor of 5 in it; digits would bring it in."""
    refused = {
        "high_authority_target": {"a pair on the circle"},
        "zero_direction_target": {"a double pair"},
    }.get(name, set())
    if name == "high_authority_target" and kind == "servo_plant":
        refused = set(OUTSIDE)  # w = [r; d; v] is for no LQG without its noises
    for label, words in OUTSIDE.items():
        if label in refused:
            with pytest.raises(CompensatorError):
                CONSTRUCTORS[name](plant(kind, words), *BESIDES.get(name, ()))
            continue
        target = CONSTRUCTORS[name](plant(kind, words), *BESIDES.get(name, ()))
        assert target.exact is not None
        for side in (target.exact.numerator, target.exact.denominator):
            for c in side.all_coeffs():
                assert c.q % 5, (words, c)


@pytest.mark.parametrize("kind", ["standard_plant", "servo_plant"])
@pytest.mark.parametrize("name", ["fir_target", "pole_placement_target"])
@pytest.mark.parametrize("words", OUTSIDE.values(), ids=OUTSIDE)
def test_the_target_of_a_plant_has_an_exact_prediction_for_it(name, kind, words):
    one = plant(kind, words)
    target = CONSTRUCTORS[name](one, *BESIDES.get(name, ()))
    again = CONSTRUCTORS[name](modelling_information(one), *BESIDES.get(name, ()))
    assert again == target and again.exact == target.exact
    n_c = one.n
    zero = Compensator(past_u=np.zeros((n_c, 1, 1)), past_y=np.zeros((n_c + 1, 1, 1)))
    comparison = compare_exactly(one, zero, target)
    assert not comparison.obstacle
    N_zu = one.problem.numerator("zu")
    left = comparison.requested * target.exact.numerator
    assert (left - N_zu * Poly(q**n_c, q) * target.exact.denominator).is_zero


def test_where_conjugates_are_on_both_sides_nothing_is_called_exact():
    """Of q^2 - 3 q + 1 one zero is NMP, and no rational polynomial has it alone."""
    one = standard_plant("(q**2 - 3*q + 1)/(q**3*(q - 1/2))")
    known = modelling_information(one)
    assert not known.is_exact and factor_not_inside(Poly("q**2 - 3*q + 1", q)) is None
    for source in (one, known):
        target = pole_placement_target(source, ["1/2"])
        assert target.exact is None
        zero = Compensator(past_u=np.zeros((5, 1, 1)), past_y=np.zeros((6, 1, 1)))
        assert "float64" in compare_exactly(one, zero, target).obstacle
    golden = (3 + 5**0.5) / 2
    assert np.allclose(target.numerator.ravel()[2:4], [1, -golden])


@pytest.mark.parametrize("words", OUTSIDE.values(), ids=OUTSIDE)
def test_another_gain_or_delay_keeps_the_zeros_exact(words):
    known = modelling_information(plant("standard_plant", words))
    factor = Poly(words, q, domain="QQ")
    assert known.nmp_polynomial() == factor
    other = known.changed(d_zu=7, H="1/3")
    assert (other.d_zu, other.H) == (7, "1/3") and other.nmp_polynomial() == factor
    mine = known.changed(nmp_zeros=(2,))
    assert mine == ModellingInformation(known.d_zu, known.H, (2,))
    assert len(zeros_not_inside(factor)) == factor.degree() == len(known.nmp_zeros)
