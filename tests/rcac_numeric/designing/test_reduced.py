"""References of another kind, and settings without a model."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory.errors import InputError, NoSolutionError
from rcac_numeric.analysis._closed_loop import frozen_loop
from rcac_numeric.designing._closed_loop_design import settings_of
from rcac_numeric.designing._expected import read_expected
from rcac_numeric.designing._plants import read_plant, variations
from rcac_numeric.designing._reduced import reduced_reference, with_feedforward
from rcac_numeric.designing._reference import MOST, WeightGrid, reference_loop, sensitivity_peak
from rcac_numeric.designing._trials import FULL, measured
from rcac_numeric.targets import DirectionInformation

LAGS = "1/((20*s + 1)*(3*s + 1))"
STRUCTURE = rn.Structure(
    [rn.Tap("y", 0, 1), rn.Tap("y", 0, 3), rn.Tap("derived", 0, 1)], 1, 1,
    derived=[rn.DerivedSignal((1.0,), (0.0,), 0.9)],
)  # fmt: skip


def grid_of(G, disturbance=rn.Step(0.5), noise=0.01, command=None, dead_time=3.0, saturation=None):
    plant = read_plant(G, 1.0, dead_time)
    half = np.inf if saturation is None else 1.0
    expected, _ = read_expected(disturbance, noise, command, half, plant.low_gain)
    others = variations(plant, rn.Uncertainty())
    return WeightGrid(plant, expected, half, others, saturation)


# A structure.


@pytest.mark.costly
@pytest.mark.parametrize(
    "structure", [rn.pid("PI"), rn.pid("PID"), rn.fir_integrator(8), rn.fir(15), STRUCTURE]
)
def test_a_reduced_reference_is_robust_and_of_that_structure(structure):
    grid = grid_of(LAGS)
    result = reduced_reference(grid, structure)
    again = structure.compensator(result.theta)
    assert np.allclose(again.past_u, result.compensator.past_u)
    assert np.allclose(again.past_y, result.compensator.past_y, rtol=1e-12)
    assert sensitivity_peak(result.loop(grid.plant)) == pytest.approx(result.peak, rel=1e-3)
    assert result.peak <= 1.01 * MOST
    for one in grid.others:
        assert frozen_loop(grid.plant.servo(one), result.compensator, 0).is_stable


@pytest.mark.costly
def test_an_fir_controller_with_an_integrator_does_nearly_what_lqg_does():
    grid = grid_of(LAGS)
    w, errors = grid.expected.w(2000, seed=5), []
    for one in (grid.best(), reduced_reference(grid, rn.fir_integrator(20))):
        errors.append(measured(rn.simulate(grid.plant.servo(), one.fixed, w))[1])
    assert errors[1] < 1.1 * errors[0]


@pytest.mark.costly
@pytest.mark.parametrize("structure", [rn.pid("PI"), STRUCTURE])
def test_z_answers_to_the_virtual_perturbation_of_a_structure_as_its_target_says(structure):
    """u = Phi theta + u~ by simulation: z is the impulse response of G_f to a pulse of u~."""
    grid = grid_of(LAGS, dead_time=1.0)
    result = reduced_reference(grid, structure)
    settings = settings_of(grid.plant, result, grid.expected)
    servo, steps = grid.plant.servo(), 200
    loop = result.loop(grid.plant)
    # d adds to u outside the controller: for one of y alone that is where u~ enters.
    w = np.zeros((steps, 3))
    w[0, 1] = 1.0
    z = rn.simulate(servo, result.fixed, w).z[:, 0]
    response = settings.target.frequency_response(np.linspace(0, np.pi, 4097))[:, 0, 0]
    pulse = np.fft.irfft(response, 8192)[:steps]
    assert loop.is_stable
    assert np.allclose(pulse, z, atol=1e-6 * np.abs(z).max())


def test_a_structure_that_cannot_hold_the_plant_is_refused_by_name():
    with pytest.raises(NoSolutionError, match="no PI controller"):
        reduced_reference(grid_of("1/s**2", dead_time=0.0), rn.pid("PI"))


@pytest.mark.parametrize(
    ("structure", "words"),
    [
        (rn.iir(3), "its own past u"), (rn.feedforward(3), "reads r"), ("PID", "give one such as"),
        (rn.pid("PI", 2, 2), "2 controls"),
    ],
)  # fmt: skip
def test_other_structures_are_refused_by_name(structure, words):
    with pytest.raises(InputError, match=words):
        rn.design(LAGS, sample_time=1.0, structure=structure)


@pytest.mark.costly
@pytest.mark.parametrize("structure", [rn.pid("DI"), rn.fir(6), rn.fir_integrator(5), STRUCTURE])
def test_a_reduced_design_has_lqg_beside_it(structure):
    designed = rn.design(
        LAGS, sample_time=1.0, disturbance=0.5, noise=0.01, structure=structure, seeds=1, steps=300
    )
    assert isinstance(designed.alternatives[FULL], rn.FixedController)
    assert any(trial.controller == FULL for trial in designed.evidence)
    assert designed.settings.structure == structure


# The command.


def test_feedforward_leaves_the_loop_and_lowers_the_error_of_a_step():
    grid = grid_of(LAGS, command=rn.Step(1.0))
    plain = grid.best()
    result = with_feedforward(grid.plant, plain, grid.expected)
    w = np.zeros((300, 3))
    ours, theirs = (rn.simulate(grid.plant.servo(), one.fixed, w) for one in (result, plain))
    assert np.allclose(result.compensator.past_u, plain.compensator.past_u)
    w[:, 1] = 1.0  # what d does is as it was
    ours, theirs = (rn.simulate(grid.plant.servo(), one.fixed, w) for one in (result, plain))
    assert np.allclose(ours.z, theirs.z, atol=1e-9)
    w[:, :2] = [1.0, 0.0]
    ours, theirs = (rn.simulate(grid.plant.servo(), one.fixed, w) for one in (result, plain))
    assert np.sum(ours.z**2) < np.sum(theirs.z**2)
    assert np.abs(ours.u).max() < np.abs(theirs.u).max()
    assert np.abs(ours.z[-1]).max() < 5e-3


def test_a_design_with_feedforward():
    designed = rn.design(
        LAGS, sample_time=1.0, disturbance=0.1, noise=0.01, command=rn.Step(1.0), feedforward=True,
        seeds=1, steps=300,
    )  # fmt: skip
    assert designed.settings.l_r == designed.fixed.l_r == 1
    first = designed.settings.compensator_of(designed.settings.theta_0)
    assert np.array_equal(first.past_y, designed.fixed.compensator.past_y)
    alone = rn.Compensator(first.past_u, first.past_y[:, :, :1])
    assert (
        rn.intercalated_match(rn.ClosedLoop(designed.plant, alone), designed.settings.target).worst
        < 1e-6
    )


def test_feedforward_needs_a_command():
    with pytest.raises(InputError, match="reads the command"):
        rn.design(LAGS, sample_time=1.0, feedforward=True)


# The disturbance, and the actuator.


@pytest.mark.costly
@settings(max_examples=3)
@given(first=st.floats(0.1, 0.25), apart=st.floats(0.2, 0.5))
def test_every_sinusoid_that_is_known_has_its_model(first, apart):
    plant = read_plant("0.1/((q - 0.9)*(q - 0.5))", None, 0.0)
    omegas = first, first + apart
    disturbance = rn.Harmonic(omegas[0], 0.5) + rn.Harmonic(omegas[1], 0.3) + rn.Step(0.2)
    expected, _ = read_expected(disturbance, 0.01, None, np.inf, plant.low_gain)
    poles = reference_loop(plant, expected).compensator.poles()
    for one in (1.0, *np.exp(1j * np.array(omegas))):
        assert np.abs(poles - one).min() < 1e-4


def test_with_limits_the_controller_is_one_that_works_at_them():
    """Sampled fast, hardly any noise: it settles, and loses a tenth at most to one without them."""
    limits = rn.Saturation(low=-1.5, high=1.5)
    G = "1/((30*s + 1)*(20*s + 1))"
    free, stored = (
        grid_of(G, rn.Step(0.3), 1e-4, rn.Step(1.0), 0.0, one) for one in (None, limits)
    )  # fmt: skip
    w = stored.expected.w(600, seed=3)
    ours, theirs = (
        rn.simulate(stored.plant.servo(), one.best().fixed, w, saturation=limits)
        for one in (stored, free)
    )
    assert np.abs(ours.z[-200:]).max() < 0.02
    assert np.sum(ours.z**2) < 1.1**2 * np.sum(theirs.z**2)


def test_what_an_actuator_cannot_give_at_rest_is_said():
    designed = rn.design(
        "1.8/((120*s + 1)*(15*s + 1))", sample_time=5.0, disturbance=rn.Step(0.2), noise=0.05,
        u_limits=(0, 1), seeds=1, steps=300,
    )  # fmt: skip
    message = {question.name: question.words for question in designed.questions}
    assert "u = -0.2 at rest" in message["u_limits"]
    assert "times that without control" in message["disturbance"]


def test_what_to_use_runs_on_a_device():
    designed = rn.design(
        "1/(8*s + 1)", sample_time=1.0, disturbance=rn.Step(0.5), seeds=1, steps=300
    )
    w = designed.expected.w(100, 1)
    ours, theirs = (
        rn.simulate(designed.plant, one, w) for one in (designed.frozen, designed.fixed)
    )
    assert np.allclose(ours.u, theirs.u, rtol=1e-9, atol=1e-12)
    assert designed.frozen.freeze == ((0, None),)


# Without a model.


@given(u=st.floats(-6, 6), y=st.floats(-6, 6))
def test_a_cold_start_is_the_same_in_any_units(u, y):
    """Theta of y has the unit u/y, and what it makes of z that of y."""
    u, y = 10.0**u, 10.0**y
    one = rn.cold_start(rn.ModellingInformation(2, 1.0, [1.3]), order=3, stable=True)
    other = rn.cold_start(rn.ModellingInformation(2, y / u, [1.3]), order=3, stable=True, u=u, y=y)
    by = np.repeat([1.0, u / y], 6)
    R_theta = other.update.R_theta * np.outer(by, by) / y**2
    assert np.allclose(R_theta, one.update.R_theta)
    assert np.allclose(other.target.numerator, y / u * one.target.numerator)
    assert one.structure.n_c == 6 and one.k_w == 50


def test_a_cold_start_of_an_unstable_plant_does_not_wait():
    unstable = rn.cold_start(rn.ModellingInformation(2, 1.0, [1.3]), order=3, stable=False)
    assert unstable.k_w == 6


def test_a_cold_start_with_directions():
    known = DirectionInformation(H=[[1, 0], [0, 2]], zeros=[(1.5, [1, -1])])
    built = rn.cold_start(known, order=4, stable=True)
    eta = np.array([1, -1])
    powers = 1.5 ** -np.arange(len(built.target.numerator), dtype=float)
    blocked = eta @ np.tensordot(powers, built.target.numerator, 1)
    assert np.allclose(blocked, 0, atol=1e-12)
    assert built.structure == rn.iir(6, 2, 2) and np.allclose(built.update.R_theta, 40 * np.eye(48))
    with pytest.raises(InputError, match="must be ModellingInformation"):
        rn.cold_start("1/(s + 1)", order=1, stable=True)
    with pytest.raises(InputError, match="size of a signal"):
        rn.cold_start(known, order=4, stable=True, u=0.0)
