"""The stand-alone core against `Controller`: the same bits, step by step."""

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, note, settings

from compensator_theory.errors import DivergedError
from rcac_numeric import Controller
from rcac_numeric.export.tables import core_tables
from tests.support import core_builds
from tests.support.core_builds import BAD_INPUT, DIVERGED, UNSUPPORTED, Core
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


def hold_together(case, seed, steps=STEPS):
    """u, theta, the guard and the end of both; with a step that is refused in between."""
    given_settings, plant = case
    note(given_settings)
    core = Core(core_tables(given_settings))
    controller = Controller(given_settings)
    loop = Loop(plant, given_settings.l_r, steps, seed)
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


@draws(8)
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
