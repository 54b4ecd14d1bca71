"""The stand-alone core against `Controller`: the same bits, step by step."""

import re

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, note, settings

import rcac_numeric as rn
from compensator_theory.errors import DivergedError
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.export._tables import core_tables, scaled
from tests.support import core_builds
from tests.support.core_builds import (
    BAD_INPUT,
    DIVERGED,
    OK,
    OUT_OF_ORDER,
    REFUSED,
    UNSUPPORTED,
    Core,
)
from tests.support.core_cases import Loop, core_settings
from tests.support.strategies import seeds

STEPS = 120
pytestmark = pytest.mark.skipif(
    core_builds.compiler() is None, reason="there is no C compiler on this machine"
)


@pytest.fixture(autouse=True)
def plain(monkeypatch):
    """The bits that every processor shares."""
    monkeypatch.setenv("RCAC_INSTRUCTION_SET", "plain")


def same(a, b):
    return np.asarray(a).tobytes() == np.asarray(b).tobytes()


def unsupervised(controller):
    """What leaves the range of the numbers is an error, as it is in the core."""
    return rn.Controller(controller, rn.Supervision("off"))


def hold_together(case, seed, steps=STEPS):
    """u, theta, the guard and the end of both; with a step that is refused in between."""
    exported, plant = case
    note(exported)
    core = Core(core_tables(exported))
    controller = unsupervised(exported)
    loop = Loop(plant, exported.l_r, steps, seed)
    guards = 0
    for k in range(steps):
        y, z, r = loop.signals(k)
        if k == steps // 2:
            before, u_before = core.save(), core.u.copy()
            status, u = core.step(y, z * np.nan, r)
            assert status == BAD_INPUT and same(u, u_before) and core.save() == before
        status, u = core.step(y, z, r)
        guards += bool(status & UNSUPPORTED)
        try:
            expected = controller.step(y, z, r)
        except DivergedError:
            assert status & DIVERGED
            assert np.isfinite(u).all()
            return
        assert not status & DIVERGED
        assert same(u, expected), (k, u, expected)
        assert same(core.theta, controller.theta), (k, core.theta - controller.theta)
        loop.move(k, u)
    assert guards == controller.guard_count or len(plant.E_1) > 1  # which counts rows
    assert core.library.rcac_guard_count(core.state) == controller.guard_count


def draws(count):
    """Each is compiled, so that shrinking would take minutes."""
    phases = [Phase.explicit, Phase.generate]
    return settings(max_examples=count, phases=phases, suppress_health_check=list(HealthCheck))


@pytest.mark.costly
@draws(5)
@given(core_settings(), seeds)
def test_u_and_theta_are_those_of_the_controller(case, seed):
    hold_together(case, seed)


@pytest.mark.long
def test_two_hundred_settings(in_full):
    """200 settings over all structures and options; a few where they are not asked for."""
    if not in_full:
        return

    @draws(200)
    @given(core_settings(), seeds)
    def many(case, seed):
        hold_together(case, seed)

    many()


# ---- what a host does between the steps


def closed_loop(controller, core, loop, steps, between=lambda k: None, move=True):
    """Both through a loop, bit for bit; `between` acts on both before a step."""
    for k in range(steps):
        between(k)
        y, z, r = loop.signals(k)
        status, u = core.step(y, z, r)
        try:
            expected = controller.step(y, z, r)
        except DivergedError:
            assert status & DIVERGED
            return k
        assert same(u, expected) and same(core.theta, controller.theta), k
        if move:
            loop.move(k, u)
    return steps


PLANT = rn.standard_plant("(q - 0.3)/((q - 0.9)*(q - 0.5))")
SETTINGS = rn.ControllerSettings(
    structure=rn.iir(2), target=rn.TargetModel([0, 1.0, -0.3]), update=rn.UD(0.05), k_w=3
)


@pytest.mark.cases(4)
@pytest.mark.parametrize("past", ["keep", "reset", "blend"])
@pytest.mark.parametrize("denominator", [[1.0], [1.0, 0.4], [1.0, -0.2, 0.1, 0.05]])
def test_a_target_model_that_is_set_while_it_runs(past, denominator):
    core = Core(core_tables(SETTINGS, live_order=4))
    controller = unsupervised(SETTINGS)
    order = max(2, len(denominator) - 1)
    first = rn.TargetModel(np.append([0, 0.9, -0.2], [0.0] * (order - 2)), denominator)
    second = rn.TargetModel([0, 0.8])

    def between(k):
        for at, model in ((60, first), (400, second), (430, first)):
            if k == at:
                controller.set_target(model, past)
                used = controller.changes[-1].covariance
                number = ("keep", "reset", "blend").index(used)
                padded = model.numerator, model.denominator
                assert core.set_target(rn.TargetModel(*padded), number) == OK
        if k == 200:
            controller.set_lambda(0.99)
            assert core.set_lambda(0.99) == OK
        if k in (220, 240):
            (controller.freeze if k == 220 else controller.resume)()
            core.call("freeze", k == 220)
        if k == 300:
            controller.reset_covariance()
            core.call("reset_covariance")

    assert closed_loop(controller, core, Loop(PLANT, 0, 500, 3), 500, between) == 500


@pytest.mark.costly
@draws(3)
@given(core_settings(strictly_proper=True), seeds)
def test_what_an_actuator_left_of_u(case, seed):
    """One step later by rcac_correct, or within the step by rcac_adapt."""
    exported, plant = case
    tables = core_tables(exported)
    later = Core(tables)
    halves = later.another()
    controller = unsupervised(exported)
    loop = Loop(plant, exported.l_r, 60, seed)
    applied = None
    for k in range(60):
        y, z, r = loop.signals(k)
        if k:
            assert later.correct(applied) == OK
        status, u = later.step(y, z, r)
        try:
            expected = controller.step(y, z, r, applied)
        except DivergedError:
            assert status & DIVERGED
            return
        applied = np.clip(expected, -0.3, 0.3)
        _, early = halves.control(y, z, r)
        halves.adapt(y, z, r, applied)
        assert same(u, expected) and same(u, early)
        assert same(later.theta, controller.theta)
        if exported.form == "predictor":
            assert same(halves.theta, controller.theta) or not later.tables.strictly_proper
        loop.move(k, applied)


def test_a_saturation_that_the_core_applies_itself():
    limits = rn.Saturation(low=-0.4, high=0.3, rate=0.2)
    w = rn.exogenous([rn.WhiteNoise()], 400, 5)
    run = rn.simulate(PLANT, SETTINGS, w, saturation=limits)
    core = Core(core_tables(SETTINGS, saturation=limits))
    for k in range(400):
        status, u = core.step(run.y[k], run.z[k])
        assert status == OK and same(u, run.u_applied[k])
        if k + 1 < 400:
            assert same(core.theta, run.theta[k + 1])


def test_control_before_the_measurement():
    """A strictly proper controller gives u(k) out before y(k) is known."""
    core, controller = Core(core_tables(SETTINGS)), unsupervised(SETTINGS)
    loop = Loop(PLANT, 0, 300, 1)
    for k in range(300):
        status, u = core.control()
        assert status == OK
        y, z, _ = loop.signals(k)
        assert core.control()[0] == OUT_OF_ORDER
        assert core.adapt(y, z) == OK
        assert core.adapt(y, z) == OUT_OF_ORDER
        assert same(u, controller.step(y, z)) and same(core.theta, controller.theta)
        loop.move(k, u)


@pytest.mark.costly
def test_a_fixed_compensator():
    rng = np.random.default_rng(4)
    for l_u, l_y, order in ((1, 1, 3), (2, 1, 2), (1, 2, 0), (2, 2, 1)):
        compensator = rn.Compensator(
            0.3 * rng.standard_normal((order, l_u, l_u)), rng.standard_normal((order + 1, l_u, l_y))
        )
        core = Core(core_tables(compensator))
        plant = rn.Plant(np.zeros((1, 1)), np.zeros((1, l_u)), np.ones((1, 1)), C=np.ones((l_y, 1)))
        run = rn.simulate(plant, rn.FixedController(compensator), rng.standard_normal((100, 1)))
        for k in range(100):
            status, u = core.step(run.y[k], None)
            assert status == OK and same(u, run.u[k])


def test_a_saved_state_goes_on_bit_for_bit():
    core = Core(core_tables(SETTINGS, live_order=2))
    loop = Loop(PLANT, 0, 200, 2)
    answers = []
    for k in range(200):
        if k == 100:
            saved, x = core.save(), loop.x.copy()
        answers.append(core.step(*loop.signals(k)[:2])[1])
        loop.move(k, answers[-1])
    core.init()
    assert core.restore(saved) == OK
    loop.x = x
    for k in range(100, 200):
        u = core.step(*loop.signals(k)[:2])[1]
        assert same(u, answers[k])
        loop.move(k, u)
    for damage in (0, 5, 9, 40, len(saved) - 1):
        changed = bytearray(saved)
        changed[damage] ^= 4
        now = core.save()
        assert core.restore(bytes(changed)) == REFUSED and core.save() == now
    other = Core(core_tables(replace(SETTINGS, update=rn.UD(0.06)), live_order=2))
    assert other.restore(saved) == REFUSED


def test_what_does_not_fit_is_refused():
    core = Core(core_tables(SETTINGS))
    assert core.set_target(SETTINGS.target, 0) == REFUSED
    assert [core.set_lambda(v) for v in (0.0, 1.5, np.nan, 0.5)] == [REFUSED] * 3 + [OK]
    assert core.correct([0.0]) == REFUSED  # before the first step
    live = Core(core_tables(SETTINGS, live_order=2))
    live.step([0.1], [0.2])
    before = live.save()
    wrong = [
        ([0, 1.0], [1.0, np.inf], 1, 0), ([0, np.nan], [1.0, 0.0], 1, 0),
        ([0, 1.0], [2.0, 0.0], 1, 0),
        ([0, 1.0], [1.0, 0.0], 3, 0), ([0, 1.0], [1.0, 0.0], -1, 0), ([0, 1.0], [1.0, 0.0], 1, 3),
    ]  # fmt: skip
    for numerator, denominator, order, past in wrong:
        status = live.call(
            "set_target", live._array(numerator), live._array(denominator), order, past
        )
        assert status == REFUSED and live.save() == before
    assert live.correct([0.1]) == OK
    assert live.set_target(rn.TargetModel([0.5, 1.0, 0.0]), 0) == OK
    assert live.correct([0.1]) == REFUSED  # u(k) is in the filter already


def without_pragmas(text):
    return re.sub(r"(?m)^#pragma .*$", "", text)


FAST = ("-ffast-math", "-funsafe-math-optimizations")
PX4 = ("-fno-signed-zeros", "-fno-trapping-math", "-freciprocal-math", "-fno-math-errno")


@pytest.mark.costly
@pytest.mark.cases(1)
@pytest.mark.parametrize("real", ["float64", "float32"])
def test_fast_math_does_not_reach_the_core(real):
    """PX4 sets it globally; the pragmas keep it out, and the self-check says where they do not."""
    tables = scaled(core_tables(SETTINGS)) if real == "float32" else core_tables(SETTINGS)
    loop = Loop(PLANT, 0, 200, 9)
    signals = []
    cores = [Core(tables, real, ["-std=c99", "-O2"])]
    cores += [Core(tables, real, ["-std=c99", "-O2", flag]) for flag in FAST]
    cores.append(Core(tables, real, ["-std=gnu11", "-O3", *PX4]))
    cores += [Core(tables, real, ["-std=c99", level]) for level in ("-O0", "-Os")]
    cores += [Core(tables, real, ["-std=c++17", "-O2"], "g++")]
    for k in range(200):
        signals.append(loop.signals(k)[:2])
        answers = [core.step(*signals[-1]) for core in cores]
        assert all(status == OK and same(u, answers[0][1]) for status, u in answers)
        assert all(same(core.theta, cores[0].theta) for core in cores)
        loop.move(k, answers[0][1].astype(float))
    assert {core.library.rcac_self_check() for core in cores} == {0}
    for flag in FAST:
        bare = Core(tables, real, ["-std=c99", "-O2", flag], edit=without_pragmas)
        assert bare.library.rcac_self_check() != 0, flag
