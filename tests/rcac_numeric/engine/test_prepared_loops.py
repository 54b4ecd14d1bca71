"""A loop that is compiled once for many runs gives each of them what its own loop would."""

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory import InputError
from rcac_numeric.arrays._values import replaced
from rcac_numeric.compiled import _kernel
from rcac_numeric.controllers._settings import settings_with_numbers
from rcac_numeric.engine import _batches
from rcac_numeric.engine._jobs import PreparedRun, run_to_end
from rcac_numeric.engine._loops import REMEMBERED, PreparedLoop, PreparedLoops
from tests.support.comparisons import same
from tests.support.engine_cases import cases as settings_of
from tests.support.lane_cases import GOOD, PLANT
from tests.support.strategies import plants, seeds


def compiled_anew(case, lanes):
    """The run of a loop that is made for it alone, of Python's arguments, as it stands there."""
    options = dict(case.options)
    loop = PreparedLoop(case.plant, case.settings, options.pop("saturation", None))
    loop._template = None
    run = PreparedRun(loop, case.w, **options)
    run_to_end([run], lanes=lanes)
    return run.result()


def same_bits(one, other):
    """Whether two runs hold the same bytes, their states too."""
    for field in fields(one):
        a, b = getattr(one, field.name), getattr(other, field.name)
        if isinstance(a, rn.SavedState):
            a, b = a.values, b.values
        if isinstance(a, np.ndarray) and a.tobytes() != b.tobytes():
            return False
    return same(one, other)


@st.composite
def numbers_of(draw, settings, rng):
    """The settings, or others that differ from them in numbers alone."""
    change = {}
    if isinstance(settings.update, rn.UD) and isinstance(settings.update.lambda_, float):
        R = float(10.0 ** rng.uniform(-3, 3))
        if draw(st.booleans()):
            R = R * np.diag(rng.uniform(0.5, 2.0, settings.l_theta))
        lambda_ = 1.0 if settings.update.process_noise is not None else rng.uniform(0.9, 1.0)
        change["update"] = replaced(settings.update, R_theta=R, lambda_=lambda_)
    if draw(st.booleans()) and settings.bounds is None:
        change["theta_0"] = 0.1 * rng.standard_normal(settings.l_theta)
    if draw(st.booleans()) and isinstance(settings.R_z, np.ndarray):
        change["R_z"] = settings.R_z * rng.uniform(0.5, 2.0)
    if draw(st.booleans()) and isinstance(settings.R_z, np.ndarray) and len(settings.R_z) == 1:
        change["R_z"] = rn.SignalWeight(z_squared=rng.uniform(0, 1), constant=1.0)
    if draw(st.booleans()) and settings.target.n_f and not settings.target_changes:
        numerator = settings.target.numerator * rng.uniform(0.5, 2.0)
        change["target"] = rn.TargetModel(numerator, settings.target.denominator)
    return replaced(settings, **change)


@given(st.data(), st.integers(1, 3), st.booleans(), seeds)
def test_a_batch_is_its_runs_made_alone(data, threads, lanes, seed):
    """Structures, updates, plants, options; several runs each, numbers that differ, divergence."""
    rng, cases = np.random.default_rng(seed), []
    for _ in range(data.draw(st.integers(1, 3))):
        plant = data.draw(plants())
        settings, _ = data.draw(settings_of(plant.l_u, plant.l_y, plant.l_z))
        saturation = data.draw(st.sampled_from([None, None, rn.Saturation(low=-0.5, high=0.5)]))
        for _ in range(data.draw(st.integers(1, 4))):
            w = rng.standard_normal((int(rng.integers(1, 60)), plant.l_w))
            options = {"stride": int(rng.integers(1, 4)), "saturation": saturation}
            if data.draw(st.booleans()):
                options["x_0"] = rng.standard_normal(plant.n)
            if data.draw(st.booleans()):
                options["divergence_limit"] = float(10.0 ** rng.uniform(0, 3))
            if data.draw(st.booleans()):
                w *= 1e200  # its squares leave float64
            ours = data.draw(numbers_of(settings, rng)) if data.draw(st.booleans()) else settings
            cases.append(rn.SimulationCase(plant, ours, w, options))
    data.draw(st.randoms(use_true_random=False)).shuffle(cases)
    together = rn.simulate_many(cases, threads=threads, lanes=lanes)
    for case, run in zip(cases, together, strict=True):
        assert same_bits(run, compiled_anew(case, lanes))
    stream = rn.simulate_stream(cases, threads=threads, lanes=lanes, at_once=3)
    for result in stream:
        assert same_bits(result.value, together[result.number])


def numbered(draw_R, lambda_, theta):
    rng = np.random.default_rng(abs(theta))
    change = {"theta_0": 0.1 * rng.standard_normal(GOOD.l_theta)} if theta else {}
    return replaced(GOOD, update=rn.UD(R_theta=draw_R, lambda_=lambda_), **change)


def test_numbers_alone_need_no_other_loop():
    """R_theta, lambda, theta(0), R_z, R_u and G_f of one order; what is more is compiled."""
    base = PreparedLoop(PLANT, GOOD)
    half = rn.TargetModel(0.5 * GOOD.target.numerator, GOOD.target.denominator)
    for change in (
        {"update": rn.UD(R_theta=3.0, lambda_=0.99)},
        {"theta_0": np.full(GOOD.l_theta, 0.1)},
        {"R_z": 2.0, "R_u": rn.SignalWeight(z_squared=0.1)},
        {"target": half},
    ):
        assert base.with_numbers_of(replaced(GOOD, **change)) is not None, change
    longer = rn.TargetModel(np.r_[GOOD.target.numerator, [[[0.1]]]])
    for change in (
        {"update": rn.UD(R_theta=3.0, process_noise=0.1)},
        {"update": rn.UD(R_theta=3.0, stop_where_unsupported=True)},
        {"update": rn.Covariance(R_theta=3.0)},
        {"target": longer},
        {"target_changes": {5: half}},
        {"freeze": [(3, 4)]},
        {"k_w": GOOD.k_w + 1},
        {"R_z": lambda k, y, z, u: 1.0},
        {"R_u_unfiltered": 0.1},
    ):
        assert base.with_numbers_of(replaced(GOOD, **change)) is None, change


@pytest.mark.parametrize(
    ("of_update", "of_settings"),
    [
        ({}, {"R_z": 2.0}),
        ({}, {"R_u": 0.0}),
        ({}, {"R_z": 3.0, "R_u": 0.5}),
        ({"R_theta": 3.0, "lambda_": 0.9}, {"theta_0": np.full(GOOD.l_theta, 0.1)}),
    ],
)
def test_settings_with_other_numbers_are_those_made_anew(of_update, of_settings):
    settings = settings_with_numbers(GOOD, of_update, of_settings)
    assert settings == replaced(GOOD, update=replaced(GOOD.update, **of_update), **of_settings)
    for wrong in ({"R_z": 0.0}, {"R_z": -1.0}, {"R_u": -0.5}):
        with pytest.raises(InputError):
            settings_with_numbers(GOOD, of_update, of_settings | wrong)


@pytest.mark.parametrize("lanes", [False, True])
def test_a_map_is_compiled_once(lanes, monkeypatch):
    """Cells that differ in R_theta and lambda: one controller of Python's arguments."""
    built = []
    whole = _kernel.controller

    def counted(**arguments):
        built.append(arguments)
        return whole(**arguments)

    monkeypatch.setattr(_kernel, "controller", counted)
    w = np.random.default_rng(0).standard_normal((40, 1))
    cells = [numbered(10.0**i, 1.0 - 0.01 * (i % 2), i) for i in range(-3, 4)]
    runs = rn.simulate_many([rn.SimulationCase(PLANT, cell, w) for cell in cells], lanes=lanes)
    assert len(built) == 1
    monkeypatch.undo()
    for cell, run in zip(cells, runs, strict=True):
        assert same_bits(run, compiled_anew(rn.SimulationCase(PLANT, cell, w), lanes))


def test_what_calls_functions_is_compiled_for_each_run():
    plant = rn.FunctionPlant(
        advance=lambda k, x, u, w: 0.5 * x + u + w, output=lambda k, x, w: (x, x),
        n=1, l_u=1, l_w=1, l_y=1, l_z=1,
    )  # fmt: skip
    weighted = replaced(GOOD, R_z=lambda k, y, z, u: 1.0 + z[0] ** 2)
    for loop in (PreparedLoop(plant, GOOD), PreparedLoop(PLANT, weighted)):
        assert loop._template is None
    w = np.ones((30, 1))
    cases = [rn.SimulationCase(plant, GOOD, w), rn.SimulationCase(PLANT, weighted, w)] * 2
    runs = rn.simulate_many(cases)
    for case, run in zip(cases, runs, strict=True):
        assert same_bits(run, compiled_anew(case, False))


def test_another_divergence_limit_is_another_limit():
    w = np.random.default_rng(1).standard_normal((50, 1))
    small, large = (
        rn.SimulationCase(PLANT, GOOD, w, {"divergence_limit": limit}) for limit in (0.5, 1e9)
    )
    runs = rn.simulate_many([small, large, small], lanes=True)
    assert [run.outcome for run in runs] == ["diverged", "completed", "diverged"]
    assert [run.divergence_limit for run in runs] == [0.5, 1e9, 0.5]


def test_what_a_run_hands_out_is_its_own():
    w = np.random.default_rng(2).standard_normal((30, 1))
    first, second = rn.simulate_many([rn.SimulationCase(PLANT, GOOD, w)] * 2, lanes=True)
    before = second.z.copy()
    for name in ("u", "y", "z", "theta", "theta_final"):
        assert not np.shares_memory(getattr(first, name), getattr(second, name))
        getattr(first, name)[:] = 7.0
    assert np.array_equal(second.z, before)
    assert not first.state.values.flags.writeable


def test_loops_are_forgotten():
    """So that ids of objects that are gone lead nowhere, and a stream needs no more memory."""
    loops, w = PreparedLoops(), np.ones((3, 1))
    for i in range(3 * REMEMBERED):
        schedule = rn.PlantSchedule([rn.PlantChange(start=0, plant=PLANT)])
        settings = numbered(1.0 + i, 1.0, i)
        run = PreparedRun(loops.of(schedule, settings), w)
        assert run.settings is settings and run.plant is schedule
    assert len(loops._loops) == len(loops._bases) == REMEMBERED


def test_other_instructions_are_compiled_anew(monkeypatch):
    w = np.random.default_rng(3).standard_normal((60, 1))
    case, answer = rn.SimulationCase(PLANT, GOOD, w), {}

    def cases():
        for name in ("plain", _kernel.instruction_sets()[0]):
            monkeypatch.setenv("RCAC_INSTRUCTION_SET", name)
            yield case

    for result, name in zip(
        rn.simulate_stream(cases(), at_once=1),
        ("plain", _kernel.instruction_sets()[0]),
        strict=True,
    ):
        answer[name] = result.value.theta_final.tobytes()
        monkeypatch.setenv("RCAC_INSTRUCTION_SET", name)
        assert compiled_anew(case, False).theta_final.tobytes() == answer[name]


def test_a_key_pressed_leaves_all_runs_in_their_order(monkeypatch):
    """Those that had ended, those under way and those that had not begun."""
    monkeypatch.setattr(_batches, "GROUP", 2)

    def plant(presses):
        def advance(k, x, u, w):
            if presses and k == 20:
                raise KeyboardInterrupt
            return 0.5 * x + u + w

        return rn.FunctionPlant(
            advance=advance, output=lambda k, x, w: (x, x), n=1, l_u=1, l_w=1, l_y=1, l_z=1
        )

    steps = [30, 31, 32, 33, 34]
    cases = [rn.SimulationCase(plant(i == 2), GOOD, np.ones((k, 1))) for i, k in enumerate(steps)]
    with pytest.raises(rn.RunInterrupted) as caught:
        rn.simulate_many(cases, threads=1)
    runs = caught.value.runs
    assert [run.plant for run in runs] == [case.plant for case in cases]
    assert [run.outcome for run in runs[:2]] == ["completed"] * 2
    assert (runs[2].outcome, runs[2].steps) == ("interrupted", 20)
    assert (runs[4].outcome, runs[4].steps) == ("interrupted", 0)


BAD = {
    "x_0": rn.SimulationCase(PLANT, GOOD, np.ones((5, 1)), {"x_0": [1.0]}),
    "w": rn.SimulationCase(PLANT, GOOD, np.ones((5, 2))),
    "stride": rn.SimulationCase(PLANT, GOOD, np.ones((5, 1)), {"stride": 0}),
    "divergence_limit": rn.SimulationCase(PLANT, GOOD, np.ones((5, 1)), {"divergence_limit": -1.0}),
    "start": rn.SimulationCase(
        PLANT, GOOD, np.ones((5, 1)),
        {"start": rn.SavedState("loop", 1, np.zeros(3), "0" * 16, "0" * 16)},
    ),
    "saturation": rn.SimulationCase(PLANT, GOOD, np.ones((5, 1)), {"saturation": 1.0}),
    "supervision": rn.SimulationCase(PLANT, GOOD, np.ones((5, 1)), {"supervision": "warn"}),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_nothing_runs_where_a_case_is_refused(name, monkeypatch):
    monkeypatch.setattr(_batches, "run_to_end", None)  # a call would fail
    good = rn.SimulationCase(PLANT, GOOD, np.ones((5, 1)))
    with pytest.raises(InputError, match=f"case 2: .*{name if name != 'start' else 'state'}"):
        rn.simulate_many([good, good, BAD[name], good])


# Arrays of shape (runs, steps, width) in and out.


@pytest.mark.exact_data  # bit for bit in two ways, of which one reads w twice
@given(st.data(), st.integers(1, 3), st.booleans(), seeds)
def test_a_batch_of_arrays_is_its_runs(data, threads, lanes, seed):
    """Bit for bit, with settings for each run, and NaN from the step on that failed."""
    rng = np.random.default_rng(seed)
    plant = data.draw(plants())
    settings, _ = data.draw(settings_of(plant.l_u, plant.l_y, plant.l_z))
    count = data.draw(st.integers(1, 12))
    each = [data.draw(numbers_of(settings, rng)) for _ in range(count)]
    w = rng.standard_normal((count, 30, plant.l_w))
    if data.draw(st.booleans()):
        w[0] *= 1e200
    x_0 = data.draw(st.sampled_from([None, np.ones(plant.n), np.ones((count, plant.n))]))
    options = {} if x_0 is None else {"x_0": np.ones(plant.n)}
    saturation = data.draw(st.sampled_from([None, rn.Saturation(low=-0.5, high=0.5)]))
    limit = data.draw(st.sampled_from([None, 3.0]))
    batch = rn.simulate_batch(
        plant, each, w, x_0=x_0, divergence_limit=limit, saturation=saturation,
        threads=threads, lanes=lanes,
    )  # fmt: skip
    options |= {"divergence_limit": limit, "saturation": saturation}
    cases = [
        rn.SimulationCase(plant, ours, one, options) for ours, one in zip(each, w, strict=True)
    ]
    for i, run in enumerate(rn.simulate_many(cases, threads=threads, lanes=lanes)):
        assert (batch.outcomes[i], batch.steps[i]) == (run.outcome, run.steps)
        assert batch.guard_counts[i] == run.guard_count and batch.failures[i] == run.failure
        assert batch.theta_final[i].tobytes() == run.theta_final.tobytes()
        for name in "uyz":
            signal = getattr(batch, name)[i]
            assert signal[: run.steps].tobytes() == getattr(run, name).tobytes()
            assert np.isnan(signal[run.steps :]).all()


@pytest.mark.parametrize(
    ("settings", "w", "options", "words"),
    [
        (GOOD, np.ones((5, 1)), {}, r"\(runs, steps, l_w\)"),
        (GOOD, np.ones((0, 5, 1)), {}, "no run"),
        (GOOD, np.ones((2, 5, 3)), {}, "run 0: w has shape"),
        ([GOOD], np.ones((2, 5, 1)), {}, "1 settings for 2 runs"),
        (GOOD, np.ones((2, 5, 1)), {"x_0": np.ones((3, 2))}, "x_0 has 3 rows"),
        (GOOD, np.ones((2, 5, 1)), {"x_0": np.ones(7)}, "run 0: x_0 has 7 entries"),
        ([GOOD, "pid"], np.ones((2, 5, 1)), {}, "settings"),
        ("pid", np.ones((3, 5, 1)), {}, "settings"),
    ],
)
def test_batches_that_cannot_be_are_refused(settings, w, options, words):
    with pytest.raises(InputError, match=words):
        rn.simulate_batch(PLANT, settings, w, **options)
