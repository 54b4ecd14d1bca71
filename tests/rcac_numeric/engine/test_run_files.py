"""A run as an object: saved and loaded bit for bit, handed to pandas and xarray."""

import sys
from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rcac_numeric as r
from compensator_theory.errors import InputError
from rcac_numeric import FunctionPlant, load_run, simulate, simulate_reference
from rcac_numeric.compiled._updates import ARGUMENTS
from rcac_numeric.controllers._forgetting import Forgetting
from rcac_numeric.engine._runs import RECORDS
from tests.rcac_numeric import samples
from tests.support.examples import EXAMPLE_4_6


@settings(max_examples=20)
@given(st.integers(0, 1000))
def test_a_loaded_run_goes_on_as_the_saved_one_would(tmp_path_factory, seed):
    run = samples.run(seed)
    file = tmp_path_factory.mktemp("runs") / "run.npz"
    run.save(file)
    again = load_run(file)
    more = np.random.default_rng(seed).standard_normal((7, run.plant.l_w))
    first, second = (
        simulate(r.plant, r.settings, more, start=r.state, saturation=r.saturation)
        for r in (run, again)
    )
    assert first == second and np.array_equal(first.theta, second.theta)


def test_every_update_and_every_forgetting_can_stand_in_a_file():
    classes = {cls.__name__ for cls in (*ARGUMENTS, *get_args(Forgetting))}
    assert classes <= set(RECORDS._classes)


@pytest.mark.parametrize("seed", [0, 1])
def test_runs_of_capped_forgetting_and_of_a_gain_schedule_are_loaded(tmp_path, seed):
    plant, w = r.standard_plant("1/(q - 0.5)"), np.ones((20, 1))
    for controller in (
        r.ControllerSettings(
            structure=r.iir(1), target=r.TargetModel([0, 1.0]),
            update=r.UD(1.0, lambda_=r.CappedForgetting(0.99)),
        ),
        r.GainSchedule([0, 1 + seed], [r.Compensator(np.zeros((0, 1, 1)), [[[0.1]]])] * 2),
    ):  # fmt: skip
        run = simulate(plant, controller, w)
        run.save(tmp_path / "run.npz")
        assert load_run(tmp_path / "run.npz") == run


@pytest.mark.costly
def test_no_damaged_file_is_read(tmp_path):
    """Every byte of the arrays and of the tree is under the checksum or the archive's own."""
    run, file = samples.run(3), tmp_path / "run.npz"
    run.save(file)
    whole = file.read_bytes()
    rng, refused = np.random.default_rng(0), 0
    for at in rng.integers(0, len(whole), 300):
        damaged = bytearray(whole)
        damaged[at] ^= int(rng.integers(1, 256))
        file.write_bytes(damaged)
        try:
            assert load_run(file) == run  # a byte that nothing reads, such as a date
        except InputError as error:
            assert str(file) in str(error)
            refused += 1
    assert refused > 200
    for rest in (0, 10, len(whole) // 2):
        file.write_bytes(whole[:rest])
        with pytest.raises(InputError, match=r"run\.npz"):
            load_run(file)


def test_what_is_no_saved_run_is_refused_by_name(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        load_run(tmp_path / "none.npz")
    np.savez(tmp_path / "other.npz", u=np.zeros(3))
    with pytest.raises(InputError, match="holds no saved run"):
        load_run(tmp_path / "other.npz")
    with pytest.raises(InputError, match=r"must end in \.npz"):
        samples.run(0).save(tmp_path / "run.mat")
    with pytest.raises(InputError, match="cannot be written"):
        samples.run(0).save(tmp_path / "nowhere" / "run.npz")
    done = samples.run(0, steps=3)
    reference = simulate_reference(done.plant, done.settings, done.w)
    with pytest.raises(InputError, match="ReferenceRun cannot be saved"):
        reference.save(tmp_path / "run.npz")


def advance(k, x, u, w):
    return 0.5 * x + u + w


def state_twice(k, x, w):
    return x, x


def seen_2(k, x, w):
    return x, x + w


def test_a_plant_made_of_functions_is_asked_for(tmp_path):
    plant, other = (
        FunctionPlant(advance=advance, output=output, n=1, l_u=1, l_w=1, l_y=1, l_z=1)
        for output in (state_twice, seen_2)
    )
    run = simulate(plant, samples.adaptive(1), np.ones((9, 1)))
    file = tmp_path / "run.npz"
    run.save(file)
    with pytest.raises(InputError, match=r"plant is made of functions.*plant="):
        load_run(file)
    assert load_run(file, plant=plant) == run
    with pytest.raises(InputError, match="another plant"):
        load_run(file, plant=other)


@pytest.mark.costly
def test_tables_hold_the_arrays():
    run = EXAMPLE_4_6.run(stride=10)
    frame, data = run.to_pandas(), run.to_xarray()
    assert list(frame.index) == list(run.k) and frame.index.name == "k"
    for name in ("z", "u", "w", "y"):
        values = getattr(run, name)
        columns = [c for c in frame if c.rstrip("0123456789") == name]
        assert np.array_equal(frame[columns].to_numpy(), values)
        assert np.array_equal(data[name].values, values)
    remaining = data["theta"].dropna("k").values
    assert np.array_equal(remaining, run.theta)


@pytest.mark.parametrize("library", ["pandas", "xarray"])
def test_a_library_that_is_missing_is_named_with_its_extra(library, monkeypatch):
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(InputError, match=rf"{library} is not installed.*\[pandas\]"):
        getattr(samples.run(0), f"to_{library}")()


@pytest.mark.parametrize("period", [0.05, 1.0, 1 / 3])
def test_a_plant_that_was_read_with_its_sample_time_comes_back_with_it(tmp_path, period):
    control = pytest.importorskip("control")
    plant = r.servo_plant(control.tf([0.5], [1, -0.7], period))
    fixed = r.FixedController(r.Compensator(past_u=[[[0.2]]], past_y=[[[0.1]], [[0.3]]]))
    run = r.simulate(plant, fixed, np.ones((9, 3)))
    run.save(tmp_path / "run.npz")
    back = r.load_run(tmp_path / "run.npz")
    assert back == run
    assert back.sample_time == back.plant.sample_time == period
    assert back.plant.exact.sample_time == plant.exact.sample_time
