"""Target models with zero directions: from plants, in loops, against forms that look right."""

import numpy as np
import pytest

from benchmarks.yardsticks.directed_plants import cost_ratio, plant_of_fractions, random_plant
from compensator_theory.errors import InputError, NoSolutionError
from rcac_numeric import UD, ControllerSettings, Plant, TargetModel, iir, simulate, standard_plant
from rcac_numeric.targets import (
    DirectionInformation,
    check_directions,
    direction_information,
    output_subspace_target,
    zero_direction_target,
)
from rcac_numeric.targets._pole_placement import fir_target
from tests.support.directed_plants import directions

KINDS = ("one real", "complex pair", "two real")
H = np.array([[1.0, 0.5], [-0.3, 1.2]])
V = np.array([[1.0, 0.4], [0.7, 1.0]])
# P1 to P4 differ in zero and poles; of P4 the outputs have denominators of their own.
PLANTS = {
    "P1": (1.5, [(0.6, 0.8), (0.6, 0.8)], 1.01),
    "P2": (1.15, [(0.6, 0.8), (0.6, 0.8)], 1.01),
    "P3": (1.5, [(0.9, 0.95), (0.9, 0.95)], 1.06),
    "P4": (1.5, [(0.6, 0.8), (0.2, -0.4)], 1.01),
}


def case(name):
    zero, poles, largest = PLANTS[name]
    X = V @ np.diag([zero, 0.3]) @ np.linalg.inv(V)
    return plant_of_fractions(poles, H, X), zero, X, largest


def fir(*taps):
    return TargetModel(np.array([np.zeros_like(taps[0]), *taps]))


@pytest.mark.costly
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("size", [2, 3])
def test_directions_of_plants_are_the_eigenvectors(kind, size):
    rng = np.random.default_rng(5)
    for _ in range(3):
        plant, (poles, _, X, _) = random_plant(rng, size, kind)
        known = direction_information(plant)
        outside = [z for z in np.linalg.eigvals(X) if abs(z) > 1 and z.imag >= 0]
        result = [z for z, _ in known.zeros]
        assert np.allclose(np.sort_complex(result), np.sort_complex(outside), rtol=1e-8)
        target = zero_direction_target(known)
        for zero, eta in known.zeros:
            expected = directions(poles, X, zero)
            assert abs(abs(np.vdot(expected, eta)) - 1) < 1e-10
            value = np.tensordot(zero ** -np.arange(target.n_f + 1.0), target.numerator, 1)
            assert np.abs(expected @ value).max() < 1e-7 * np.abs(target.numerator).max()


@pytest.mark.parametrize(
    ("X", "zeros"),
    [
        ([[1.0, 0.5], [0.0, 0.25]], [1]),
        ([[0.5, 0.25], [0.0, -1.0]], [-1]),
        ([[0.0, -1.0], [1.0, 0.0]], [1j]),
        ([[1.0, 0.5], [0.0, 2.0]], [1, 2]),
        ([[1 - 2.0**-40, 0.5], [0.0, 0.25]], []),
    ],
)
def test_a_zero_exactly_on_the_unit_circle_counts_as_nmp(X, zeros):
    """All numbers are dyadic, so that det(qI - X) has its root on the circle and not beside it."""
    X, poles = np.array(X), [(0.5, 0.75), (0.25, -0.5)]
    known = direction_information(plant_of_fractions(poles, np.eye(2), X)).zeros
    assert sorted(abs(z) for z, _ in known) == pytest.approx(sorted(abs(z) for z in zeros))
    for zero, eta in known:
        assert min(abs(zero - z) for z in zeros) < 1e-12
        assert abs(abs(np.vdot(directions(poles, X, zero), eta)) - 1) < 1e-10


@pytest.mark.costly
@pytest.mark.parametrize("name", PLANTS)
def test_four_plants(name):
    plant, _, _, largest = case(name)
    target = zero_direction_target(plant)
    assert check_directions(target, plant).is_kept
    ratios = [cost_ratio(plant, target, seed) for seed in range(4)]
    assert all(1 - 1e-6 < ratio <= largest for ratio in ratios)  # nan fails, too


@pytest.mark.parametrize("name", PLANTS)
def test_a_delay_alone_is_matched_by_cancelling_the_zero(name):
    """The hidden instability: a pole of the controller at the zero, while the loop diverges."""
    plant, zero, _, _ = case(name)
    target = fir(H)
    assert check_directions(target, plant).forms == ("not a zero",)
    settings = ControllerSettings(
        structure=iir(n_c=8, l_u=2, l_y=2), target=target, update=UD(R_theta=1e-3)
    )
    w = 0.01 * np.random.default_rng(0).standard_normal((30000, 2))
    run = simulate(plant, settings, w)
    assert run.outcome == "diverged"
    nearest = min(
        np.abs(settings.compensator_of(theta).poles() - zero).min() for theta in run.theta[-40:]
    )
    assert nearest < 1e-6


@pytest.mark.costly
def test_every_wrong_form_has_its_name():
    for name in PLANTS:
        plant, zero, X, _ = case(name)
        [(_, eta)] = direction_information(plant).zeros
        e = np.real(eta)

        def turned(degrees, e=e, zero=zero):
            c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
            f = np.array([c * e[0] - s * e[1], s * e[0] + c * e[1]])
            return fir(H, -zero * np.outer(f, f) @ H)

        G = plant.C @ np.linalg.solve(zero * np.eye(4) - plant.A, plant.B)
        v = np.linalg.svd(G)[2][-1]
        numerator = "kept" if name != "P4" else "on the input side"
        for target, form in [
            (fir(H), "not a zero"),
            (fir(H, -zero * H), "in every channel"),
            (turned(0), "kept"),
            (turned(4.9), "kept"),
            (turned(30), "in another direction"),
            (fir(H, -zero * np.diag([1, 0]) @ H), "in one channel"),
            (fir(H, -zero * H @ np.outer(v, v)), "on the input side"),
            (fir(H, -X @ H), numerator),
        ]:
            check = check_directions(target, plant)
            assert check.forms == (form,)
            assert len(check.warnings) == (form != "kept")
        assert abs(check_directions(turned(5), plant).angles[0] - 5) < 1e-6


def test_five_degrees_cost_little():
    plant, zero, _, _ = case("P1")
    e = np.real(direction_information(plant).zeros[0][1])
    c, s = np.cos(np.radians(5)), np.sin(np.radians(5))
    f = np.array([c * e[0] - s * e[1], s * e[0] + c * e[1]])
    assert cost_ratio(plant, fir(H, -zero * np.outer(f, f) @ H)) < 1.02


@pytest.mark.costly
@pytest.mark.parametrize("kind", KINDS)
def test_random_plants(kind, request):
    """J/JL <= 1.01 on 95 of 100 with one real zero."""
    in_full = request.config.getoption("--long")
    rng = np.random.default_rng(911)
    count = 100 if in_full else 8
    ratios = []
    for _ in range(count):
        plant, _ = random_plant(rng, 2, kind)
        ratios.append(cost_ratio(plant, zero_direction_target(plant)))
    assert sum(r <= 1.01 for r in ratios) >= (0.95 if kind == "one real" else 0.8) * count


def test_scalar_wide_and_tall():
    scalar = standard_plant("(q - 1.5)*(q + 2)/((q - 0.5)*(q - 0.2)*(q + 0.1))")
    assert np.allclose(zero_direction_target(scalar).numerator, fir_target(scalar).numerator)
    tall = Plant(
        A=[[0.5, 0.0], [0.0, 0.9]], B=[[1.0], [2.0]], D_1=[[1.0], [0.0]], C=[[1.0, 0], [0, -1.0]]
    )
    expected = output_subspace_target(tall).numerator
    assert np.allclose(zero_direction_target(tall).numerator, expected)
    # [q - 0.3, q - 3]/((q - 0.6)(q - 0.8)): no transmission zero, but G [1; 1] has 1.65.
    wide = Plant(
        A=[[1.4, 1.0], [-0.48, 0.0]], B=[[1.0, 1.0], [-0.3, -3.0]], D_1=[[1.0], [0.0]],
        C=[[1.0, 0.0]],
    )  # fmt: skip
    with pytest.raises(InputError, match="squaring"):
        zero_direction_target(wide)
    both = zero_direction_target(wide, squaring=[[1], [1]])
    assert np.allclose(both.numerator[1:, 0], [[1, 1], [-1.65, -1.65]])
    assert np.allclose(zero_direction_target(wide, squaring=[[1], [0]]).numerator[1:, 0], [[1, 0]])


def test_delays_of_their_own_per_row():
    """G = diag(q^-1, q^-2) K, whose first Markov parameter is singular."""
    H = np.array([[1.0, 0.5], [-0.3, 1.2]])
    target = zero_direction_target(DirectionInformation(H, [(1.5, [1, 2])], delays=(1, 2)))
    assert np.allclose(target.numerator[1, 0], H[0]) and not target.numerator[1, 1].any()
    value = np.tensordot(1.5 ** -np.arange(target.n_f + 1.0), target.numerator, 1)
    assert np.abs([1, 2] @ value).max() < 1e-12


@pytest.mark.exact_data
def test_refusals():
    repeated = plant_of_fractions([(0.1, 0.2)] * 2, np.eye(2), np.array([[1.5, 1.0], [0.0, 1.5]]))
    with pytest.raises(NoSolutionError, match="multiplicity 2 and 1"):
        zero_direction_target(repeated)
    with pytest.raises(InputError, match="pole of the plant too"):
        zero_direction_target(plant_of_fractions([(1.5, 0.5)] * 2, np.eye(2), np.diag([1.5, 0.25])))
    with pytest.raises(InputError, match="pairs"):
        DirectionInformation(H, [1.5])
    with pytest.raises(InputError, match="square matrices"):
        check_directions(TargetModel([0, 1]), case("P1")[0])


@pytest.mark.parametrize(
    ("zero", "words"),
    [
        ((float("nan"), [1]), "not a finite number"), ((10**400, [1]), "too large for float64"),
        ((1.5, [float("inf")]), "not a finite number"), (("q", [1]), "contains symbols"),
        ((1.5, 1), "must be pairs"), ((None, [1]), "not a number"), ((1.5, [10**400]), "too large"),
    ],
)  # fmt: skip
def test_zeros_that_are_none(zero, words):
    with pytest.raises(InputError, match=words):
        DirectionInformation([[1.0]], [zero])
