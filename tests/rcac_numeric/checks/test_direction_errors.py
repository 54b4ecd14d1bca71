"""Target models that lose a zero of several inputs and outputs are named, in text and JSON."""

import numpy as np
import pytest

from benchmarks.yardsticks.directed_plants import plant_of_fractions
from rcac_numeric import UD, ControllerSettings, Plant, TargetModel, iir, loop_health, simulate
from rcac_numeric.checks._rules import direction_errors
from rcac_numeric.targets import markov_target, zero_direction_target

H = np.array([[1.0, 0.5], [-0.3, 1.2]])
V = np.array([[1.0, 0.4], [0.7, 1.0]])
X = V @ np.diag([1.5, 0.3]) @ np.linalg.inv(V)
ONE, TWO = [(0.6, 0.8), (0.6, 0.8)], [(0.6, 0.8), (0.2, -0.4)]
P1, P4 = plant_of_fractions(ONE, H, X), plant_of_fractions(TWO, H, X)


def fir(*taps):
    return TargetModel(np.array([np.zeros_like(taps[0]), *taps]))


def of(plant):
    """The input direction of the zero, by the plant's value there."""
    G = plant.C @ np.linalg.solve(1.5 * np.eye(plant.n) - plant.A, plant.B)
    return np.linalg.svd(G)[2][-1]


WRONG = {
    "T1": (P1, fir(H), "unmodelled zero"),
    "T3": (P1, fir(H, -1.5 * H), "zero in every channel"),
    "T6": (P1, fir(H, -1.5 * np.diag([1, 0]) @ H), "zero in one channel"),
    "T7": (P4, fir(H, -X @ H), "zero on the input side"),
    "T8": (P1, fir(H, -1.5 * H @ np.outer(of(P1), of(P1))), "zero on the input side"),
    "turned": (
        P1, fir(H, -1.5 * np.outer([0.6, 0.8], [0.6, 0.8]) @ H), "zero in another direction"
    ),
}  # fmt: skip


def health_of(plant, target, steps=400):
    settings = ControllerSettings(structure=iir(8, l_u=2, l_y=2), target=target, update=UD(1e-3))
    w = 0.01 * np.random.default_rng(0).standard_normal((steps, 2))
    return loop_health(simulate(plant, settings, w))


@pytest.mark.costly
@pytest.mark.parametrize("name", WRONG)
def test_every_form_that_hides_an_instability_is_named(name):
    """Also of a loop that has not diverged yet, and with the remedy that cures it."""
    plant, target, code = WRONG[name]
    result = [w for w in health_of(plant, target).warnings if w.code == code]
    assert len(result) == 1 and "1.5" in result[0].sentence
    assert "zero_direction_target" in result[0].next_step
    early = [w.code for w in health_of(plant, target, steps=12).warnings]
    assert code in early


def test_the_right_forms_are_not():
    for plant in (P1, P4):
        for target in (zero_direction_target(plant), markov_target(plant, 12)):
            assert direction_errors(plant, target) == ()
    assert direction_errors(P1, WRONG["T7"][1]) == ()  # one denominator: its numerator is right


def test_what_is_not_square_or_too_large_is_not_asked():
    wide = Plant(A=[[0.5]], B=[[1.0, 1.0]], D_1=[[1.0]], C=[[1.0]])
    assert direction_errors(wide, TargetModel([[[0, 0]], [[1, 1]]])) == ()
    poles = [(0.1 * i, 0.2) for i in range(6)]
    large = plant_of_fractions(poles, np.eye(6), 1.5 * np.eye(6))
    assert direction_errors(large, fir(np.eye(6))) == ()
