"""Designs of plants with several inputs and outputs."""

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import butter, freqz, lfilter, sosfilt

from compensator_theory import transfer_matrix
from compensator_theory.errors import InputError
from rcac_numeric import (
    ClosedLoop,
    Step,
    design,
    intercalated_match,
)
from rcac_numeric.analysis._conversion import FURTHER, converted
from rcac_numeric.arrays._values import equal
from rcac_numeric.designing._closed_loop_design import advanced, miss, settings_of
from rcac_numeric.designing._expected import read_expected
from rcac_numeric.designing._plants import read_plant
from rcac_numeric.designing._reference import (
    CLOSER,
    MOST,
    WeightGrid,
    reference_loop,
    sensitivity_peak,
)
from rcac_numeric.designing._trials import FIXED, PID, RCAC
from rcac_numeric.plants._saturation import Saturation

TWO = [["2/(10*s + 1)", "0.5/(6*s + 1)"], ["-0.4/(5*s + 1)", "1/(8*s + 1)"]]
THREE = [
    ["1/(10*s + 1)", "0.3/(6*s + 1)", "0"],
    ["0.2/(5*s + 1)", "1/(7*s)", "0.1/(7*s)"],
    ["0", "-0.3/(4*s + 1)", "1/(12*s + 1)"],
]


def of(G, late=1.0, gains=(1.0, 1.0)):
    plant = read_plant(G, 1.0, late)
    u, y = gains
    plant = type(plant)(plant.A, plant.B / u, plant.C * y, plant.delay, sample_time=1.0)
    expected, _ = read_expected(Step(0.5 * u), 0.01 * y, None, np.inf, plant.low_gain, plant.m)
    result = reference_loop(plant, expected)
    return plant, result, settings_of(plant, result, expected)


@pytest.fixture(scope="module", params=[TWO, THREE], ids=["two", "three"])
def designed(request):
    return of(request.param)


@pytest.fixture(scope="module")
def two():
    return design(TWO, sample_time=1.0, dead_time=1.0, disturbance=Step(0.5), noise=0.01, seeds=1,
                  steps=300)  # fmt: skip


@pytest.mark.costly
def test_the_peak_is_that_of_the_sensitivity_at_u_and_at_y(designed):
    plant, result, _ = designed
    omega = np.concatenate([np.geomspace(1e-4, 0.1, 300), np.linspace(0.1, np.pi, 1500)])
    G = plant.response(omega)
    A, B, C, _ = result.compensator.state_space()
    z = np.exp(1j * omega)[:, None, None]
    G_c = C @ np.linalg.solve(z * np.eye(len(A)) - A, B[None])
    eye = np.eye(plant.m)
    # Of the servo problem u = G_c e and y_0 = G u, with e = r - y_0.
    peaks = [
        np.linalg.norm(np.linalg.inv(eye + L), 2, axis=(1, 2)).max() for L in (G_c @ G, G @ G_c)
    ]
    assert result.peak <= MOST
    assert max(peaks) == pytest.approx(result.peak, rel=0.01)


@pytest.mark.costly
def test_every_error_is_rid_of_every_constant(designed):
    plant, result, _ = designed
    m = plant.m
    to_e = result.loop(plant).frequency_response([1e-5])[0, :, m : 2 * m]
    assert np.abs(to_e).max() < 1e-2 * plant.low_gain


@pytest.mark.costly
def test_the_target_is_what_the_reference_loop_is(designed):
    plant, result, settings_ = designed
    omega = np.linspace(0, np.pi, 400)
    expected = result.loop(plant).intercalated_response(omega)
    gap = np.abs(settings_.target.frequency_response(omega) - expected).max()
    assert gap < 1e-2 * np.abs(expected).max()
    assert np.median(intercalated_match(result.loop(plant), settings_.target).median) < 1e-2
    first = settings_.compensator_of(settings_.theta_0)
    assert equal(first.past_u, result.compensator.past_u)
    assert equal(first.past_y, result.compensator.past_y)
    low, high = settings_.bounds.box(settings_.structure)
    assert (low <= settings_.theta_0).all() and (settings_.theta_0 <= high).all()


@pytest.mark.costly
def test_units_change_nothing_but_units():
    _, result, ours = of(TWO)
    _, other, theirs = of(TWO, gains=(1e3, 1e-4))
    assert other.peak == pytest.approx(result.peak, rel=1e-6)
    P, Q = other.compensator.past_u, other.compensator.past_y * 1e-7
    assert np.abs(P - result.compensator.past_u).max() < 1e-6 * np.abs(P).max()
    assert np.abs(Q - result.compensator.past_y).max() < 1e-6 * np.abs(Q).max()
    assert theirs.R_z.nu * 1e-4 == pytest.approx(ours.R_z.nu, rel=1e-5)


def test_a_target_that_is_wrong_where_the_loop_is_quiet_is_missed():
    """A tenth at high frequencies beside a peak of 100; the octave's rms by filters in time."""
    rng = np.random.default_rng(0)
    u = rng.standard_normal((2**14, 1))
    slow, fast = ([1.0], [1.0, -0.99]), ([0.1, -0.1], [1.0])
    omega = np.linspace(0, np.pi, len(u) // 2 + 1)
    low, high = (freqz(*one, worN=omega)[1][:, None, None] for one in (slow, fast))
    assert np.abs(high).max() < 0.03 * np.abs(low + high).max()  # nothing, beside the peak
    upper = butter(12, 0.5, "highpass", output="sos")
    error, whole = (
        sosfilt(upper, y)
        for y in (lfilter(*fast, u[:, 0]), lfilter(*slow, u[:, 0]) + lfilter(*fast, u[:, 0]))
    )
    expected = np.std(error) / np.std(whole)
    assert expected > 0.1 and miss(low, low + high, u) == pytest.approx(expected, rel=0.05)
    assert miss(low + high, low + high, u) == 0


@given(st.integers(0, 10**6), st.integers(2, 9), st.floats(1e-6, 0.3))
@settings(max_examples=30)
def test_what_truncation_leaves_out_is_bounded(seed, n, share):
    """Twice the sum of what Hankel singular values were left out bounds the error."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    A *= 0.9 / np.abs(np.linalg.eigvals(A)).max()
    B, C = rng.standard_normal((n, 2)), rng.standard_normal((2, n))
    parts = advanced(A, B, C, share)
    whole = control.ss(A, B, C @ A, C @ B, True)
    gap = whole(np.exp(1j * np.linspace(0, np.pi, 60))) - control.ss(*parts, True)(
        np.exp(1j * np.linspace(0, np.pi, 60))
    )
    X, Y = control.dlyap(A, B @ B.T), control.dlyap(A.T, (C @ A).T @ (C @ A))
    sigma = np.sort(np.sqrt(np.abs(np.linalg.eigvals(X @ Y))))[::-1]
    left = sigma[len(parts[0]) :].sum()
    assert np.linalg.norm(gap, 2, axis=(0, 1)).max() <= 2 * left * (1 + 1e-6) + 1e-6 * sigma[0]
    assert np.abs(np.linalg.eigvals(parts[0])).max() < 1


@pytest.mark.costly
def test_it_is_a_design_as_any_other(two):
    assert len(two.runs) == 2 and set(two.runs) == {RCAC, FIXED}
    assert "one input and one output" in two.alternatives[PID]
    assert all(all(t.stable) for t in two.evidence if t.variation.name == "nominal")
    assert {"input 1 x 0.8, others x 1.25"} <= {t.variation.name for t in two.evidence}
    assert "direction" in two.report() and two.plot().axes
    assert ClosedLoop(two.plant, two.fixed.compensator).is_stable


@pytest.mark.parametrize(
    ("G", "words"),
    [
        ([["1/(s + 1)", "2/(s + 1)"]], r"2 inputs and 1 outputs.*transfer_matrix\(G\) @ W"),
        ([["1/(s + 1)"], ["2/(s + 1)"]], r"1 inputs and 2 outputs.*S @ transfer_matrix\(G\)"),
        ([["1/(s + 1)", "0"], ["0", "1000/(s + 1)"]], "output 1 of the plant"),
        ([["1/(s + 1)", "0"], ["1/(s + 2)", "0"]], "input 2 of the plant"),
    ],
)
def test_what_the_road_cannot_do_is_refused_by_name(G, words):
    with pytest.raises(InputError, match=words):
        design(G, sample_time=1.0)


def test_the_advice_on_plants_that_are_not_square_works():
    wide = transfer_matrix([["1/(s + 1)", "2/(s + 3)"]])
    assert read_plant(wide @ [[1], [2]], 0.1, 0.0).m == 1
    assert read_plant([[1, 2]] @ wide.T, 0.1, 0.0).m == 1


FAST = (
    ([["1/(8.5*s + 1)", "-0.38/(14.1*s + 1)"], ["0.39/(14.1*s + 1)", "0.8/(14.7*s + 1)"]],
     [[1.4, 0.8], [0.8, 0.8]]),
    ([["1/(12*s + 1)", "0.42/(12.9*s + 1)"], ["-0.31/(11.6*s + 1)", "0.8/(10.4*s + 1)"]],
     [[0.6, 0.6], [0.8, 1.4]]),
)  # fmt: skip


@pytest.mark.parametrize(("G", "late"), FAST)
def test_a_plant_that_is_sampled_fast_has_a_controller_at_the_first_try(G, late, monkeypatch):
    """A deadbeat observer of the first has gains of 1e4: of 24 candidates none was converted."""
    plant = read_plant(G, 0.2, late)
    expected, _ = read_expected(0.1, 0.05, None, np.inf, plant.low_gain, plant.m)
    converted_orders = []

    def counted(parts, *accepted):
        converted_orders.append(len(parts[0]))
        return converted(parts, *accepted)

    monkeypatch.setattr("rcac_numeric.designing._reference.converted", counted)
    result = reference_loop(plant, expected)
    assert len(converted_orders) == 1 and result.peak < MOST
    G_c = result.compensator
    assert 2 * G_c.n_c <= converted_orders[0] + 2 * (FURTHER + 1)
    assert result.loop(plant).spectral_radius < 1
    assert sensitivity_peak(result.loop(plant)) == pytest.approx(result.peak, rel=CLOSER)


def test_no_controller_to_run_is_an_order_of_none():
    plant = read_plant(TWO, 1.0, 1.0)
    expected, _ = read_expected(0.1, 0.05, None, 5.0, plant.low_gain, plant.m)
    grid = WeightGrid(plant, expected, 5.0, saturation=Saturation(low=-5.0, high=5.0))
    assert grid.in_runs([]) == []
