"""What a supervised core notes, against `Controller` with Supervision("warn"): the same bits."""

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, note, settings
from hypothesis import strategies as st

from compensator_theory.errors import InputError
from rcac_numeric import (
    UD,
    Compensator,
    Controller,
    ControllerSettings,
    Saturation,
    Supervision,
    TargetModel,
    WhiteNoise,
    exogenous,
    export_controller,
    iir,
    simulate,
    standard_plant,
)
from rcac_numeric.export._tables import core_tables, scaled
from tests.support import core_builds
from tests.support.core_builds import (
    DIVERGED,
    HELD_BACK,
    LARGE_Z,
    MISSED,
    OK,
    OUT_OF_ORDER,
    RESTORED,
    WOUND_UP,
    Core,
)
from tests.support.core_cases import Loop, core_settings
from tests.support.strategies import seeds

pytestmark = [
    pytest.mark.skipif(
        core_builds.compiler() is None, reason="there is no C compiler on this machine"
    ),
    pytest.mark.filterwarnings("ignore::rcac_numeric.controllers._supervision.SupervisionWarning"),
]
PLANT = standard_plant("(q - 0.3)/((q - 0.9)*(q - 0.5))")
SETTINGS = ControllerSettings(
    structure=iir(2), target=TargetModel([0, 1.0, -0.3]), update=UD(0.05), k_w=3
)


@pytest.fixture(autouse=True)
def plain(monkeypatch):
    """The bits that every processor shares."""
    monkeypatch.setenv("RCAC_INSTRUCTION_SET", "plain")


def draws(count):
    """Each is compiled, so that shrinking would take minutes."""
    phases = [Phase.explicit, Phase.generate]
    return settings(max_examples=count, phases=phases, suppress_health_check=list(HealthCheck))


def same(a, b):
    return np.asarray(a).tobytes() == np.asarray(b).tobytes()


def of_the_engine(record):
    """The record as the core keeps it, which does not count the restoring beside the overflow."""
    return {
        name: (t.steps, t.episodes, t.first, t.last, t.worst)
        for name, t in record.troubles.items()
        if name != "restored"
    }


def spoilt(rng, values, odds):
    """With entries that are missing, or so large that what comes of them leaves float64."""
    if values is None:
        return None
    values = np.array(values)
    for i in range(len(values)):
        if rng.random() < odds:
            values[i] = rng.choice([np.nan, np.inf, -np.inf])
    if rng.random() < odds / 4:
        values *= 1e200
    return values


supervisions = st.builds(
    lambda growth, limit, patience: Supervision(growth=growth, limit=limit, patience=patience),
    st.sampled_from([1.0, 1.5, 1e6]),
    st.sampled_from([np.inf, 3.0]),
    st.sampled_from([1, 3, 100]),
)


def hold_together(case, supervision, seed, strictly_proper, steps=150):
    """u, theta, the flags and the record of both, with samples that are missing."""
    exported, plant = case
    note((exported, supervision))
    core = Core(core_tables(exported, supervision=supervision))
    controller = Controller(exported, supervision)
    rng, loop = np.random.default_rng(seed), Loop(plant, exported.l_r, steps, seed)
    applied, flags = None, []
    for k in range(steps):
        odds = 0.05 if k > 10 else 0.0
        y, z, r = (spoilt(rng, values, odds) for values in loop.signals(k))
        if applied is not None:
            assert core.correct(applied) == OK
        before = core.troubles.get("overflow", (0,))[0]
        status, u = core.step(y, z, r)
        expected = controller.step(y, z, r, applied)
        assert same(u, expected), (k, u, expected)
        assert same(core.theta, controller.theta), (k, core.theta - controller.theta)
        assert np.isfinite(u).all() and not status & DIVERGED
        known = all(np.isfinite(v).all() for v in (y, z, r) if v is not None)
        assert bool(status & MISSED) == (not known)
        assert bool(status & RESTORED) == (core.troubles.get("overflow", (0,))[0] > before)
        flags.append(status)
        applied = None
        if strictly_proper and rng.random() < 0.5:
            applied = np.clip(expected, -0.3, 0.3)
        loop.move(k, np.clip(u, -1e3, 1e3) if applied is None else applied)
        if not np.abs(loop.x).max() < 1e6:
            loop.x[:] = 0.0
    record = controller.record
    assert core.troubles == of_the_engine(record)
    assert core.growth == record.growth
    for flag, name in ((WOUND_UP, "windup"), (LARGE_Z, "large z"), (HELD_BACK, "saturated")):
        assert any(status & flag for status in flags) == (name in record.troubles)
    return record.troubles


@pytest.mark.costly
@draws(4)
@given(core_settings(strictly_proper=True), supervisions, seeds)
def test_drawn_settings_with_missing_samples_and_an_actuator(case, supervision, seed):
    hold_together(case, supervision, seed, strictly_proper=True)


@pytest.mark.costly
@draws(3)
@given(core_settings(), supervisions, seeds)
def test_drawn_settings_with_missing_samples(case, supervision, seed):
    hold_together(case, supervision, seed, strictly_proper=False)


@pytest.mark.long
def test_many_settings(in_full):
    """60 settings; none where they are not asked for."""
    if not in_full:
        return
    names = set()

    @draws(60)
    @given(core_settings(strictly_proper=True), supervisions, seeds)
    def many(case, supervision, seed):
        names.update(hold_together(case, supervision, seed, strictly_proper=True))

    many()
    assert names >= set(core_builds.TROUBLES)


def test_every_trouble_is_noted():
    """Forgetting without excitation, then samples that are missing, too large, and not applied."""
    exported = ControllerSettings(
        structure=iir(2), target=TargetModel([0, 1.0]), update=UD(1.0, lambda_=0.9), k_w=3
    )
    supervision = Supervision(growth=100.0, limit=50.0, patience=5)
    core = Core(core_tables(exported, supervision=supervision))
    controller = Controller(exported, supervision)
    met, u = 0, np.zeros(1)
    for k in range(200):
        y = 0.0 if 20 < k < 120 else np.sin(k) if k < 150 else (-1.0) ** k
        z = {130: 60.0, 140: np.nan, 141: np.nan, 180: 1e308}.get(k, y)
        applied = None
        if 150 < k < 170:
            applied = u + 1.0
            core.correct(applied)
        status, u = core.step([np.inf if k == 145 else y], [z])
        assert same(u, controller.step([np.inf if k == 145 else y], [z], None, applied)), k
        assert same(core.theta, controller.theta), k
        met |= status
    assert core.troubles == of_the_engine(controller.record)
    assert met & ~16 == MISSED | WOUND_UP | LARGE_Z | HELD_BACK | RESTORED
    saved, troubles = core.save(), core.troubles
    core.init()
    assert not core.troubles
    assert core.restore(saved) == OK and core.troubles == troubles


def test_a_saturation_of_the_core_is_noted_as_the_engine_notes_it():
    limits, supervision = Saturation(low=-0.2, high=0.2), Supervision(patience=2)
    run = simulate(PLANT, SETTINGS, exogenous([WhiteNoise()], 300, 5), saturation=limits,
                   supervision=supervision)  # fmt: skip
    core = Core(core_tables(SETTINGS, saturation=limits, supervision=supervision))
    for k in range(300):
        assert same(core.step(run.y[k], run.z[k])[1], run.u_applied[k])
    assert core.troubles == of_the_engine(run.supervision)
    assert core.troubles["saturated"][0] > 10


def test_halves_of_a_step_and_what_is_not_given():
    core = Core(core_tables(SETTINGS, supervision=Supervision()))
    assert core.step([1.0], [1.0])[0] == OK
    assert core.step(None, None)[0] == MISSED  # NULL is not known either
    assert core.control()[0] == OK  # u(k) is out before y(k) is measured
    assert core.adapt([np.nan], [1.0]) == MISSED
    assert core.adapt([0.0], [1.0]) == OUT_OF_ORDER
    assert core.troubles["missed sample"] == (2, 1, 1, 2, 1.0)


def test_float32_goes_on_where_its_numbers_end():
    tables = scaled(core_tables(SETTINGS, supervision=Supervision()))
    core, rng = Core(tables, "float32"), np.random.default_rng(0)
    restored = 0
    for k in range(400):
        y = rng.standard_normal(1) * (1e37 if k % 50 == 49 else 1)
        status, u = core.step(y, y)
        restored += bool(status & RESTORED)
        assert np.isfinite(u).all() and np.isfinite(core.theta).all()
    steps = core.troubles["overflow"][0]  # of u and of the update are two in one step
    assert 0 < restored <= steps <= 2 * restored


@pytest.mark.parametrize(
    ("supervision", "words"),
    [
        (Supervision("freeze"), "freeze.*act on its status"),
        (Supervision("bound"), "bound"),
        (Supervision("reset"), "reset"),
        (Supervision("fallback", fallback=Compensator(np.zeros((0, 1, 1)), np.ones((1, 1, 1)))),
         "fallback"),
        (Supervision(jump=10.0), "jump"),
    ],
)  # fmt: skip
def test_what_the_core_does_not_do_is_refused_by_name(supervision, words):
    with pytest.raises(InputError, match=words):
        core_tables(SETTINGS, supervision=supervision)


def test_a_folder_says_what_is_watched(tmp_path):
    watched = Supervision(growth=50.0, limit=4.0, patience=7)
    exported = export_controller(SETTINGS, tmp_path, prefix="roll", supervision=watched)
    assert exported.is_verified
    text = (tmp_path / "README.md").read_text()
    for words in ("ROLL_LARGE_Z where abs(z) exceeds 4", "more than 50 times", "for 7 steps"):
        assert words in text
    assert "#define ROLL_SUPERVISED 1" in (tmp_path / "src" / "roll_config.h").read_text()


def test_without_supervision_there_is_nothing_of_it():
    for off in (None, Supervision("off")):
        assert core_tables(SETTINGS, supervision=off) == core_tables(SETTINGS)
    with pytest.raises(InputError, match="fixed compensator"):
        core_tables(Compensator(np.zeros((0, 1, 1)), np.ones((1, 1, 1))), supervision=Supervision())
