"""u~ with theta frozen: the signal itself, the zeros that it shows, runs that are cut, refusals."""

import numpy as np
import pytest

from compensator_theory import InputError
from rcac_numeric import (
    UD,
    Controller,
    ControllerSettings,
    DataDriven,
    Step,
    WhiteNoise,
    exogenous,
    feedforward,
    fir_target,
    h2_cost,
    iir,
    lqg_controller,
    pid,
    servo_plant,
    simulate,
    standard_plant,
)
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.engine._learner import FrozenPerturbation
from rcac_numeric.identification import RecursiveARX

ZERO = "(q - 0.8)*(q - {})/((q - 0.5)*(q**2 - 1.9*q + 1))"  # example 6.1 with its zero moved
FROZEN = DataDriven(order=9, start=100, every=10, input="frozen u~", n=3, window=150)


def learning(target, n_c=6, update=0.5):
    return ControllerSettings(structure=iir(n_c), target=target, update=UD(update))


def test_it_is_u_minus_what_the_frozen_compensator_makes_of_y():
    """The oracle is the compensator itself, step by step; with a dither, u~ is the dither."""
    plant = standard_plant(ZERO.format(1.5))
    run = simulate(
        plant, learning(replace(FROZEN, running_dither=0.01)), exogenous([WhiteNoise(0.01)], 400, 1)
    )
    window = FrozenPerturbation(iir(6), FROZEN)
    for rows in np.split(np.arange(run.steps), [3, 170, 171, 390]):
        window.take(run.u[rows], run.z[rows], run.y[rows])
    result, z = window.signals(run.theta_final)
    c = run.compensator
    u, y = run.u[:, 0], run.y[:, 0]
    expected = [
        u[k]
        - sum(c.past_u[i - 1, 0, 0] * u[k - i] + c.past_y[i, 0, 0] * y[k - i] for i in range(1, 7))
        for k in range(250, 400)
    ]
    assert np.allclose(result, expected, atol=1e-12 * np.abs(u).max()) and len(result) == 150
    assert np.array_equal(z, run.z[250:, 0])
    settled, _ = window.signals(run.theta[-1])
    assert abs(abs(settled[-1]) - 0.01) < 1e-12  # u = Phi theta + dither


def test_commands_are_read_too():
    """A feedback and feedforward controller: u - Phi theta vanishes for its own last theta."""
    plant = servo_plant("(q - 1.5)/((q - 0.5)*(q - 0.6))")
    settings = ControllerSettings(
        structure=feedforward(3), update=UD(1.0), target=fir_target(plant)
    )
    w = exogenous([Step(1.0), Step(0.5), Step(0)], 60)
    run = simulate(plant, settings, w)
    window = FrozenPerturbation(settings.structure, FROZEN)
    window.take(run.u, run.z, run.y, w[:, :1])
    result, _ = window.signals(run.theta[-1])
    assert abs(result[-1]) < 1e-12 * np.abs(run.u).max() and np.abs(result).max() > 1e-3


@pytest.mark.costly
@pytest.mark.parametrize("zero", [1.1, 1.5])
def test_it_shows_what_u_shows(zero, in_full):
    """The zero from u~ is as near as from u: the median error is at most twice as large."""
    plant, p, steps = standard_plant(ZERO.format(zero)), 20, 4000
    errors = []
    for seed in range(8 if in_full else 5):
        target = DataDriven(order=p, seed=seed, running_dither=0.01)
        w = exogenous([WhiteNoise(0.01)], steps, seed)
        run = simulate(plant, learning(target, 15), w, stride=1000)
        of_u = RecursiveARX(p)
        of_u.update(run.u, run.z)
        window = FrozenPerturbation(iir(15), replace(FROZEN, order=p, window=steps))
        window.take(run.u, run.z, run.y)
        models = of_u, window.model(run.theta_final)
        errors.append([np.abs(one.estimate().zeros - zero).min() for one in models])
    plain, frozen = np.median(errors, axis=0)
    assert frozen <= 2 * plain < 0.02


@pytest.mark.costly
def test_the_cost_of_loops_that_learn_from_it(in_full):
    """Every seed is bounded, at most 7 % above LQG's cost."""
    plant = standard_plant(ZERO.format(1.1))
    best = lqg_controller(plant).cost.value
    for seed in range(6 if in_full else 1):
        target = replace(FROZEN, order=20, start=300, every=200, window=4000, seed=seed)
        settings = learning(replace(target, running_dither=0.01), 15)
        w = exogenous([WhiteNoise(0.01)], 20000, seed)
        run = simulate(plant, settings, w, stride=1000)
        assert h2_cost(plant, run.compensator).value <= 1.07 * best


@pytest.mark.costly
@pytest.mark.exact_data  # bit for bit in two ways, whose intermediate results are read anew
def test_a_run_cut_or_driven_step_by_step_is_the_run():
    plant = standard_plant(ZERO.format(1.5))
    target = DataDriven(order=18, input="frozen u~", n=3, window=1000, running_dither=0.01)
    settings, w = learning(target, 15), exogenous([WhiteNoise(0.01)], 1500, 4)
    run = simulate(plant, settings, w)
    assert run.outcome == "completed" and run.changes[0].k == 300
    controller = Controller(settings)
    for k in range(run.steps):
        if k in (299, 977):
            start = simulate(plant, settings, w[:k]).state
            rest = simulate(plant, settings, w[k:], start=start)
            assert np.array_equal(rest.u, run.u[k:]) and rest.state == run.state
            state, controller = controller.state, Controller(settings)
            controller.restore(state)
        assert np.array_equal(controller.step(run.y[k], run.z[k]), run.u[k])


def test_refusals():
    for name in ("u~", "literal u~"):
        with pytest.raises(InputError, match="fades as theta converges"):
            DataDriven(input=name)
    with pytest.raises(InputError, match="input"):
        DataDriven(input="y")
    with pytest.raises(InputError, match="give n"):
        DataDriven(input="frozen u~")
    with pytest.raises(InputError, match="leave it out"):
        DataDriven(n=3)
    with pytest.raises(InputError, match="more steps"):
        replace(FROZEN, window=18)
    with pytest.raises(InputError, match=r"below n \+ n_c = 3 \+ 7.*order = 10"):
        learning(FROZEN, n_c=7)
    with pytest.raises(InputError, match="derives signals"):
        ControllerSettings(structure=pid("PID"), target=FROZEN, update=UD(1.0))
    controller = Controller(learning(FROZEN))
    state = controller.state
    with pytest.raises(InputError, match="damaged"):
        controller.restore(
            type(state).of_values("controller", 0, state.values[:-9], state.fingerprint)
        )
    assert controller.state == state
