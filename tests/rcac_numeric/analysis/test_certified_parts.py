"""The parts of a certified set: metric, corners, size, and the gains that move beside it."""

import numpy as np
import pytest

from compensator_theory.errors import IllConditionedError, InputError, NoSolutionError
from rcac_numeric import (
    UD,
    ControllerSettings,
    Gradient,
    Plant,
    TargetModel,
    certified_set,
    fir,
    iir,
    standard_plant,
)
from rcac_numeric.analysis import _certified_set as parts
from rcac_numeric.analysis._moving_gains import centered_loop, input_gains
from rcac_numeric.analysis._regressor_system import regressor_system
from tests.support.certified_loops import PLANT, first_order

STRUCTURE = iir(1)


def loop_of(plant=PLANT, theta_0=(0.2, -0.3), gains=input_gains((1.0, 1.0), 1.0)):
    return centered_loop(regressor_system(plant, STRUCTURE), np.array(theta_0), gains)


# The metric of the prior.


def test_the_prior_is_the_inverse_of_R_theta():
    scalar = parts._prior(first_order(update=UD(R_theta=4.0)))
    np.testing.assert_array_equal(scalar, np.eye(2) / 4)
    sizes = np.array([1e-90, 1e90])  # whose products leave float64 unless they are scaled
    R_theta = np.array([[2.0, 0.5], [0.5, 1.0]]) * np.outer(sizes, sizes)
    P_0 = parts._prior(first_order(update=UD(R_theta=R_theta)))
    expected = np.array([[1.0, -0.5], [-0.5, 2.0]]) / 1.75 / np.outer(sizes, sizes)
    np.testing.assert_allclose(P_0, expected, rtol=1e-12)
    with pytest.raises(InputError, match=r"no R_theta.*volume"):
        parts._prior(first_order(update=Gradient(0.1)))


def test_the_prior_shapes_its_set_and_no_other():
    """An ellipsoid of one plant that the caps do not bound is as long as the prior is."""
    weights = [UD(R_theta=np.diag([1.0, w])) for w in (0.01, 100.0)]
    regions = [certified_set(PLANT, first_order(update=one)) for one in weights]
    ratios = [np.diff(list(one.intervals().values())).ravel() for one in regions]
    assert ratios[0][1] / ratios[0][0] > 2 * ratios[1][1] / ratios[1][0]
    flat = [certified_set(PLANT, first_order(update=one), shape="volume") for one in weights]
    np.testing.assert_array_equal(flat[0].factor, flat[1].factor)


# Its size.


def test_the_set_reaches_the_norm_and_has_no_multipliers():
    for shape in ("prior", "volume"):
        region = certified_set(PLANT, first_order(), shape=shape)
        assert 1 - 2e-4 < region.peaks["nominal"] <= 1 and region.shape == shape
        assert [one.multipliers.size for one in region.members] == [0]


def test_a_set_of_which_the_caps_bind_one_interval_reaches_the_norm():
    """The largest matrix within the caps has a norm of 0.993 here."""
    slow = standard_plant("1e-3/(q - 0.5)")
    region = certified_set(slow, first_order(theta_0=[0.0, 0.0]), shape="volume")
    assert 1 - 2e-4 < region.peaks["nominal"] <= 1


@pytest.mark.parametrize("shape", ["volume", "prior"])
def test_the_set_does_not_depend_on_the_units_of_inputs(shape):
    """Rows of Theta are intervals in units of their input; powers of two change no digit."""

    def widths(units):
        B = np.array([[1.0, 0.3], [0.2, -0.7]]) * units
        plant = Plant(
            A=[[0.5, 0.2], [-0.1, 0.6]], B=B, D_1=[[1.0], [1.0]], C=[[1.0, 0.4]], E_1=[[1.0, 0.4]]
        )
        settings = ControllerSettings(
            structure=fir(2, l_u=2),
            target=TargetModel([[[0.0, 0.0]], [[1.0, 1.0]]]),
            update=UD(R_theta=np.diag(np.tile(units**2, 2))),
            theta_0=(np.array([[0.1, -0.2], [0.05, 0.1]]) / units).ravel(),
        )
        return np.diff(list(certified_set(plant, settings, shape=shape).intervals().values()))

    units = np.array([2.0**6, 2.0**-3])
    expected = widths(np.ones(2)).reshape(2, 2) / units
    np.testing.assert_allclose(widths(units).reshape(2, 2), expected, rtol=1e-9)


# The corners, of which each is stable.


def test_theta_0_decays_at_the_rate_on_every_plant():
    radius = loop_of().spectral_radius
    assert 0.6 < radius < 0.7
    certified_set(PLANT, first_order(), rate=radius + 0.01)
    with pytest.raises(NoSolutionError) as refused:
        certified_set(PLANT, first_order(), rate=radius - 0.01)
    words = str(refused.value)
    assert f"decay rate {radius - 0.01:g}" in words and "nominal (spectral radius" in words
    assert "input_gain" not in words


def test_a_lost_plant_is_named_without_a_rate_and_with_its_gain():
    with pytest.raises(NoSolutionError) as refused:
        certified_set(PLANT, first_order(), uncertainty={"gain x 9": "9/(q - 0.9)"})
    words = str(refused.value)
    assert "decay rate" not in words and "on gain x 9 (spectral" in words
    assert "nominal" not in words and "narrow" not in words
    with pytest.raises(NoSolutionError) as refused:
        certified_set(PLANT, first_order(), input_gain=(0.9, 9.0))
    words = str(refused.value)
    assert "nominal with " in words and "narrow input_gain" in words


def test_the_corners_are_the_loops_with_their_gains_held():
    gains = input_gains((0.8, 1.25), 1.0)
    loop = loop_of(gains=gains)
    corners = parts._stable_corners({"nominal": loop}, gains, 1.0)
    held = [loop.held(deltas) if deltas else loop for _, deltas in gains.corners(1)]
    assert len(corners) == len(held) > 1
    for ours, theirs in zip(corners, held, strict=True):
        np.testing.assert_array_equal(ours.A, theirs.A)
    assert len({corner.A.tobytes() for corner in corners}) == len(corners)


def test_a_loop_at_the_edge_of_float64_counts_as_lost(monkeypatch):
    def undecided(A):
        raise IllConditionedError("between the circles")

    monkeypatch.setattr(parts, "is_schur_stable", undecided)
    with pytest.raises(NoSolutionError, match="theta_0 itself"):
        certified_set(PLANT, first_order())


# Gains that move.


def beside(K, caps, gains=(0.8, 1.25)):
    gains = input_gains(gains, 1.0)
    loops = {"nominal": loop_of(gains=gains), "slower": loop_of(first_lag(0.8), gains=gains)}
    K, multipliers = parts._beside_gains(loops, K, np.ones(1), 1.0, caps, None)
    radii = [
        loop.radius(K, np.ones(1), 1.0, s)
        for loop, s in zip(loops.values(), multipliers, strict=True)
    ]
    return K, multipliers, min(radii)


def first_lag(pole):
    return Plant(A=[[pole]], B=[[1.0]], D_1=[[1.0]], C=[[1.0]])


K_0 = np.array([[0.1, 0.0], [0.02, 0.1]])


def test_the_set_beside_moving_gains_is_as_large_as_its_multipliers_prove():
    _, multipliers, radius = beside(K_0, np.full(2, 100.0))
    assert radius == pytest.approx(1, rel=1e-6) and len(multipliers) == 2


def test_without_alternation_the_set_keeps_its_directions(monkeypatch):
    monkeypatch.setattr(parts, "ALTERNATIONS", 0)
    K, multipliers, radius = beside(10 * K_0, np.full(2, 100.0))
    np.testing.assert_allclose(K / K[0, 0], K_0 / K_0[0, 0], rtol=1e-12)
    assert radius == pytest.approx(1, rel=1e-6) and len(multipliers) == 2


def test_caps_bound_the_set_where_the_norm_does_not():
    """The set is that of the caps, a little larger, as it is without gains that move."""
    caps = np.full(2, 1e-3)
    K, _, radius = beside(K_0, caps)
    longest = np.sqrt((K @ K.T).diagonal().max())
    assert radius > 1 and longest == pytest.approx(caps[0] / parts.CAPPED, rel=1e-3)


def test_each_gain_that_moves_has_a_multiplier():
    region = certified_set(PLANT, first_order(), input_gain=(0.9, 1.1))
    assert region.is_verified and region.input_gain == (0.9, 1.1)
    assert [one.multipliers.size for one in region.members] == [1]


def test_gains_beyond_what_is_proved_are_refused():
    with pytest.raises(
        NoSolutionError, match=r"(slower|nominal): stability is not proved for gains"
    ):
        beside(K_0, np.full(2, 100.0), gains=(0.02, 2.9))
