"""Runs of every kind of controller: the check of an unchanged one is never "inconsistent"."""

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory.errors import InputError
from rcac_numeric.controllers._stepwise import StepwiseController
from rcac_numeric.engine._compatibility import AnyController, OneController
from rcac_numeric.estimation import RCMR, IndirectSettings
from tests.support.engine_cases import cases, engine_plants
from tests.support.strategies import seeds

LIMITS = rn.Saturation(low=-0.2, high=0.3)
RATE = rn.Saturation(low=-0.5, rate=0.05)
STEPS = 40


def adaptive(draw, **fixed):
    return draw(cases(1, 1, 1, kinds=("iir", "fir", "pid", "table"), **fixed))[0]


def compensator(draw, l_y=1):
    rng = np.random.default_rng(draw(seeds))
    return rn.Compensator(rng.uniform(-0.5, 0.5, (2, 1, 1)), rng.standard_normal((3, 1, l_y)) / 5)


def predictive(draw, **options):
    problem = draw(st.sampled_from(["standard", "servo", "tracking"]))
    return rn.PredictiveCost(
        draw(st.integers(1, 3)), draw(st.integers(1, 8)), R=draw(st.floats(0.01, 1)),
        problem=problem, lambda_=draw(st.sampled_from([0.95, 1.0])), **options,
    )  # fmt: skip


def scheduled(draw, variable="y", l_r=0):
    parts = [compensator(draw, 1 + l_r) for _ in range(2)]
    parts[1] = rn.Compensator(parts[0].past_u, parts[1].past_y)  # poles between them are theirs
    return rn.GainSchedule([-0.5, 0.5], parts, variable=variable, l_r=l_r)


def learning(draw):
    target = rn.DataDriven(order=3, start=20, dither=0.1, running_dither=0.05)
    update = rn.UD(R_theta=draw(st.floats(0.1, 10)))
    return rn.ControllerSettings(structure=rn.iir(2), target=target, update=update, k_w=20)


def change_of(run):
    return rn.ControllerChange(lambda_=0.9, R_u=0.1) if run.steps == 30 else None


# Settings, and options of `simulate`.
KINDS = {
    "RCAC": lambda draw: (adaptive(draw), {}),
    "RCAC with a stride": lambda draw: (adaptive(draw), {"stride": 7}),
    "RCAC within limits": lambda draw: (adaptive(draw), {"saturation": LIMITS}),
    "RCAC within a rate": lambda draw: (adaptive(draw), {"saturation": RATE}),
    "RCAC beside a compensator": lambda draw: (adaptive(draw, fixed=compensator(draw)), {}),
    "RCAC changed": lambda draw: (adaptive(draw), {"on_step": change_of, "every": 10}),
    "RCAC changed within limits": lambda draw: (
        adaptive(draw), {"on_step": change_of, "every": 10, "saturation": LIMITS},
    ),
    "RCAC that learns its target": lambda draw: (learning(draw), {}),
    "two RCAC": lambda draw: (rn.Decentralized([adaptive(draw), adaptive(draw)]), {}),
    "two RCAC of one u": lambda draw: (
        rn.Decentralized([adaptive(draw), adaptive(draw)], shared_u=True), {"saturation": LIMITS},
    ),
    "fixed": lambda draw: (rn.FixedController(compensator(draw)), {}),
    "fixed within a rate": lambda draw: (
        rn.FixedController(compensator(draw)), {"saturation": RATE},
    ),
    "gain schedule": lambda draw: (scheduled(draw), {}),
    "gain schedule of the command": lambda draw: (scheduled(draw, "r", 1), {}),
    "PCAC": lambda draw: (predictive(draw), {}),
    "PCAC within limits": lambda draw: (
        predictive(draw, limits=rn.ControlLimits(low=-0.1, high=0.2, rise=0.05)), {},
    ),
    "PCAC with bounds in its cost": lambda draw: (
        predictive(
            draw, limits=rn.ControlLimits(low=-0.1, high=0.2), limited_by="least squares"
        ), {},
    ),
}  # fmt: skip


@st.composite
def runs(draw, kind):
    """A run with at least two steps, and its options."""
    controller, options = KINDS[kind](draw)
    l_r = getattr(controller, "l_r", 0)
    plant = draw(engine_plants(1, 1, 1, l_r))
    w = np.random.default_rng(draw(seeds)).standard_normal((STEPS, plant.l_w))
    return rn.simulate(plant, controller, w, **options), options


def with_u(run, k, difference):
    u, applied = run.u.copy(), run.u_applied.copy()
    u[k] += difference
    applied[k] += difference
    return replace(run, u=u, u_applied=applied)


def test_every_kind_of_controller_is_drawn():
    known = {
        *get_args(OneController),
        *get_args(AnyController),
        *StepwiseController.__subclasses__(),
    }
    known = {one for one in known if isinstance(one, type)}
    drawn = {rn.ControllerSettings, rn.Decentralized, rn.FixedController, rn.GainSchedule,
             rn.PredictiveCost}  # fmt: skip
    assert known - {StepwiseController} == {*drawn, IndirectSettings}  # the last: below


@pytest.mark.costly
@pytest.mark.parametrize("kind", KINDS)
@given(data=st.data())
@settings(max_examples=3)
def test_a_saved_run_is_consistent(kind, data, tmp_path_factory):
    run, _ = data.draw(runs(kind))
    if not run.steps:
        return
    file = tmp_path_factory.mktemp("runs") / "run.npz"
    run.save(file)
    check = rn.check_controller(rn.load_run(file))
    assert check.is_consistent, check.replay
    assert "replay" in check.unanswered or check.replay.agrees


@pytest.mark.costly
@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "RCAC changed within limits"])
@given(data=st.data())
@settings(max_examples=3)
def test_a_changed_u_is_found_at_its_step(kind, data):
    run, _ = data.draw(runs(kind))
    begin = getattr(run.settings, "k_w", 0)
    if isinstance(run.settings, rn.Decentralized):
        begin = max(one.k_w for one in run.settings.controllers)
    if run.steps < begin + 5:
        return
    k = data.draw(st.integers(begin, run.steps - 1))
    difference = 0.1 * (np.abs(run.u).max() or 1.0)
    check = rn.check_controller(with_u(run, k, difference))
    assert not check.is_consistent
    if check.replay.of != "theta":  # with a dither or a change theta alone did not make u
        assert check.replay.worst_step >= k


@given(data=st.data())
@settings(max_examples=5)
def test_a_changed_theta_of_predictive_cost_is_found(data):
    run, _ = data.draw(runs("PCAC"))
    theta = run.theta.copy()
    k = data.draw(st.integers(0, len(theta) - 1))
    theta[k] += 1e-3 * np.abs(theta).max()
    check = rn.check_controller(replace(run, theta=theta))
    assert check.replay.of == "the logged theta" and check.replay.worst_step == k
    assert not check.is_consistent


@given(data=st.data())
@settings(max_examples=5)
def test_the_kernel_repeats_its_bits(data):
    """The kinds whose u is compiled and not that of one logged theta."""
    compiled = ("two RCAC", "two RCAC of one u", "fixed", "fixed within a rate")
    run, _ = data.draw(runs(data.draw(st.sampled_from(compiled))))
    if not run.steps:
        return
    assert rn.check_controller(run).replay.worst == 0.0


def test_a_run_that_continues_another_one_is_not_judged():
    plant, w = rn.standard_plant("1/(q - 0.9)"), rn.exogenous([rn.WhiteNoise()], 100)
    update, target = rn.UD(R_theta=1.0), rn.TargetModel([0.0, 1.0])
    adapting = rn.ControllerSettings(structure=rn.iir(2), target=target, update=update)
    for controller in (adapting, rn.PredictiveCost(1, 5)):
        first = rn.simulate(plant, controller, w[:50])
        rest = rn.simulate(plant, controller, w[50:], start=first.state)
        check = rn.check_controller(rest)
        assert check.is_consistent and check.replay is None
        assert "continues another one" in check.unanswered["replay"]


def test_a_run_whose_supervision_acted_is_not_judged():
    plant, w = rn.standard_plant("1/(q - 0.9)"), rn.exogenous([rn.WhiteNoise()], 100)
    adapting = rn.ControllerSettings(
        structure=rn.iir(2), target=rn.TargetModel([0.0, 1.0]), update=rn.UD(R_theta=1.0)
    )
    gentle = rn.Compensator(np.zeros((1, 1, 1)), [[[0.0]], [[-0.3]]])
    watch = rn.Supervision("fallback", limit=0.5, fallback=gentle)
    run = rn.simulate(plant, adapting, w, supervision=watch)
    assert run.supervision.in_fallback
    check = rn.check_controller(run)
    assert check.is_consistent and "supervision" in check.unanswered["replay"]


def test_an_indirect_controller_is_refused_by_name():
    model = RCMR(A=0.9, B=1, D_1=1, C=1, E_1=1, delays=(1,), beta=10)
    plant = rn.servo_plant("1/(q - 0.9)")
    controller = IndirectSettings(model, C_r=1, R_1=1, R_2=1)
    run = rn.simulate(plant, controller, rn.exogenous([rn.Step(), rn.Step(0), rn.Step(0)], 50))
    with pytest.raises(InputError, match="IndirectSettings"):
        rn.check_controller(run)


@pytest.mark.parametrize("tolerance", [0.0, -1e-9, float("nan")])
def test_a_tolerance_that_is_none_is_refused(tolerance):
    plant = rn.standard_plant("1/(q - 0.9)")
    run = rn.simulate(plant, rn.PredictiveCost(1, 5), [[1.0]] * 20)
    with pytest.raises(InputError, match="tolerance"):
        rn.check_controller(run, tolerance=tolerance)
