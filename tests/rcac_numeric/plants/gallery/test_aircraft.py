"""The aircraft of Chapter 3 against its printed numbers, figures and errata."""

import numpy as np
import pytest

from compensator_theory import InputError
from rcac_numeric import PlantChange, PlantSchedule, standard_plant
from rcac_numeric.gallery import (
    aircraft,
    aircraft_matrices,
    aircraft_plant,
    aircraft_transition,
    plant_zeros,
    zero_path,
)
from rcac_numeric.plants._schedules import plant_at
from rcac_numeric.targets import output_subspace_zeros
from tests.support.aircraft import NOMINAL, OFF_NOMINAL

CONDITIONS = ("nominal", "off-nominal")


def radius(A):
    return np.abs(np.linalg.eigvals(A)).max()


def test_the_printed_matrices_are_a_zero_order_hold_and_not_eulers():
    for condition, local in zip(CONDITIONS, (NOMINAL, OFF_NOMINAL), strict=True):
        exact = aircraft_matrices(condition)
        corrected = aircraft_matrices(condition, "corrected")
        for ours, text, remaining in zip(exact, corrected, local, strict=True):
            assert np.abs(ours - text).max() <= 0.5e-4 * (1 + 1e-9), "four decimals"
            assert np.array_equal(text, remaining)
        plant = aircraft(condition)
        euler = np.eye(4) + 0.1 * plant.A
        assert np.abs(euler - corrected[0]).max() > 0.1
        assert radius(euler) > 1 > radius(corrected[0])


def test_the_two_wrong_digits_of_3_4():
    printed, corrected = (aircraft_matrices("off-nominal", s) for s in ("printed", "corrected"))
    assert np.argwhere(printed[0] != corrected[0]).tolist() == [[0, 0], [1, 1]]
    assert np.allclose((printed[0] - corrected[0])[[0, 1], [0, 1]], 0.1)
    assert radius(printed[0]) == pytest.approx(1.0838, abs=5e-5)
    for s in ("printed", "corrected"):
        assert np.array_equal(
            aircraft_matrices("nominal", s)[0], aircraft_matrices("nominal", "printed")[0]
        )


def test_the_zeros_that_the_text_prints():
    """Section 3.5 and Example 1.2; from the four-decimal matrices, (3.4) corrected."""
    zeros = {c: plant_zeros(aircraft_plant(c, source="corrected")) for c in CONDITIONS}
    pair = [-0.9959, 0.9818 + 0.0556j, 0.9818 - 0.0556j]
    assert zeros["nominal"] == pytest.approx(pair, abs=5e-5)
    assert zeros["off-nominal"][:2] == pytest.approx([1.1369, -1.0027], abs=5e-5)
    assert aircraft("off-nominal").zeros()[1] == pytest.approx(1.274, abs=5e-4)


def test_the_sampling_zero_is_outside_the_circle_in_both_conditions():
    """Erratum: -0.9959 and -1.0027 are rounding; with all digits it is NMP before and after."""
    for condition in CONDITIONS:
        zeros = plant_zeros(aircraft_plant(condition))
        sampling = zeros[zeros.real < 0]
        assert len(sampling) == 1 and -1.0005 < sampling[0].real < -1.0003


def test_the_transition_of_figures_3_4_and_3_5():
    """The pair becomes real and NMP at about 252 s, and ends at 1.1369 after 10 s."""
    path = zero_path(aircraft_transition(source="corrected"), [2500, 2520, 2525, 2550, 2600])
    pair = path.zeros[:, path.zeros[0].real > 0]
    assert (np.abs(pair[:2].imag) > 0).all() and (np.abs(pair[:2]) < 1).all()
    assert (pair[2:].imag == 0).all(), "real from 252.5 s on"
    assert np.abs(pair[2]).max() == pytest.approx(1.0048, abs=5e-5)
    assert (np.diff(np.abs(pair[2:]).max(axis=1)) > 0).all()
    assert np.abs(pair[-1]).max() == pytest.approx(1.1369, abs=5e-5)
    assert not path.is_nonminimum_phase[:2].any() and path.is_nonminimum_phase[2:].all()


def test_the_schedule_moves_linearly_through_stable_plants():
    schedule = aircraft_transition(start=1.0, duration=2.0)
    (A0, B0), (A1, B1) = (aircraft_matrices(c) for c in CONDITIONS)
    for k, part in ((0, 0), (10, 0), (15, 0.25), (20, 0.5), (30, 1), (50, 1)):
        plant = plant_at(schedule, k)
        assert np.allclose(plant.A, (1 - part) * A0 + part * A1, atol=1e-14)
        assert np.allclose(plant.B, (1 - part) * B0 + part * B1, atol=1e-14)
        assert radius(plant.A) < 1
    assert [change.start for change in aircraft_transition(0, 0.1).changes] == [0, 1]


def test_dummy_commands_are_3_5_to_3_7():
    """z_i(k) = x_i(k-1) - x_i(k) and z_4 = r - phi, by running the equations of the text."""
    rng = np.random.default_rng(0)
    A, B = aircraft_matrices("nominal")
    plant = aircraft_plant("nominal", "dummy commands")
    x, last, state = np.zeros(4), np.zeros(3), np.zeros(7)
    for _ in range(20):
        r, d, u = rng.normal(size=3)
        w = np.array([r, d])
        z = plant.E_1 @ state + plant.E_0 @ w
        assert z == pytest.approx([*(last - x[:3]), r - x[3]], abs=1e-12)
        assert plant.C @ state + plant.D_2 @ w == pytest.approx(z)
        state = plant.A @ state + plant.B[:, 0] * u + plant.D_1 @ w
        x, last = A @ x + B[:, 0] * (u + d), x[:3]


def test_output_subspace_zeros():
    """det of the squared pencil against the zeros of B'(qI - A)^-1 B by their polynomial."""
    for condition in CONDITIONS:
        A, B = aircraft_matrices(condition)
        zeros = output_subspace_zeros(aircraft_plant(condition, "state"))
        numerator = np.poly(A - B @ B.T) - np.poly(A)  # det(qI - A + BB') - det(qI - A)
        assert np.sort_complex(zeros.zeros) == pytest.approx(
            np.sort_complex(np.roots(numerator[1:])), abs=1e-9
        )
    assert np.abs(zeros.zeros).max() == pytest.approx(1.149, abs=1e-3)
    dummies = output_subspace_zeros(aircraft_plant("off-nominal", "dummy commands"))
    # q det(qI - A) H'z/u with H = -B and z_i = (1/q - 1) n_i/D for i < 4, z_4 = -n_4/D.
    n = [(np.poly(A - B @ row[None]) - np.poly(A))[1:] for row in np.eye(4)]
    whole = sum(B[i, 0] * np.polymul([1, -1], n[i]) for i in range(3))
    roots = np.roots(np.polyadd(whole, B[3, 0] * np.polymul([1, 0], n[3])))
    assert len(dummies.zeros) == 6, "of the three kept states the scaled output sees one"
    ordered = sorted(dummies.zeros, key=abs)[2:]
    assert np.sort_complex(ordered) == pytest.approx(np.sort_complex(roots), abs=1e-6)
    assert len(dummies.nmp_zeros) == 1, "full-state feedback does not rid the aircraft of it"


def test_a_plant_whose_number_of_zeros_changes_has_no_path():
    schedule = PlantSchedule(
        [
            PlantChange(start=0, plant=standard_plant("(q - 0.5)/(q**2 - 0.3)")),
            PlantChange(start=5, plant=standard_plant("1/(q**2 - 0.3)")),
        ]
    )
    with pytest.raises(InputError, match="1 zeros before step 5 and 0 at it"):
        zero_path(schedule, [0, 5])
    with pytest.raises(InputError, match="steps is empty"):
        zero_path(schedule, [])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: aircraft("upside down"), "condition"),
        (lambda: aircraft_matrices(source="rumour"), "source"),
        (lambda: aircraft_plant(measured="pitch"), "measured"),
        (lambda: aircraft_transition(0.05), "start = 0.05 s is no multiple"),
        (lambda: aircraft_transition(-1.0), "start = -1 s"),
        (lambda: aircraft_transition(1.0, 0.0), "duration = 0"),
        (lambda: aircraft_transition(1.0, float("inf")), "duration"),
    ],
)
def test_what_is_no_aircraft_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
