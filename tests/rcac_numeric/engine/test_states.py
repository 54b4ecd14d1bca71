"""Runs that are cut, saved, restored, frozen or driven step by step are the same runs."""

from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory import InputError
from compensator_theory.errors import FunctionFailedError
from rcac_numeric.arrays._values import replaced as replace
from tests.support.changing_plants import schedules
from tests.support.engine_cases import cases, engine_plants, positive, with_update
from tests.support.function_plants import as_functions
from tests.support.signals import noise
from tests.support.strategies import seeds, sizes

SIGNALS = ("w", "u", "u_applied", "y", "z", "theta")


@st.composite
def rules(draw):
    """Every update with something that it must remember."""
    update = draw(
        st.sampled_from([rn.UD, rn.Covariance, rn.SlidingWindow, rn.Instantaneous, rn.Gradient])
    )
    if update is rn.SlidingWindow:
        return {"update": partial(update, window=draw(st.integers(1, 6)), lambda_=0.9)}
    if update is rn.Instantaneous:
        return {"update": update, "form": "filter", "strictly_proper": True}
    if update is rn.Gradient:
        return {"update": lambda R_theta: rn.Gradient(0.01), "freeze": ((5, 9), (14, None))}
    if draw(st.integers(0, 4)) == 0:
        return {"update": update, "freeze": ((4, 7), (11, 15))}
    extra = draw(
        st.sampled_from(
            [
                {"lambda_": rn.ScheduledForgetting({6: 0.9, 12: 1.0})},
                {"lambda_": rn.VariableRateForgetting(2, 7, 0.5)},
                {"reset": rn.CovarianceReset(at=[8, 13], every=5, trace_below=0.3)},
                {"reset": rn.CovarianceReset(growth=1.2, short=2, long=5)},
            ]
        )
    )
    return {"update": partial(update, **extra)}


@given(st.data(), sizes, sizes, sizes, st.sampled_from(["linear", "schedule", "functions"]), seeds)
def test_a_run_cut_in_pieces_is_the_run(data, l_u, l_y, l_z, kind, seed):
    l_r = data.draw(st.integers(0, 1)) if kind == "linear" else 0
    settings, _ = data.draw(cases(l_u, l_y, l_z, l_r, **data.draw(rules())))
    if (
        data.draw(st.booleans())
        and isinstance(settings.update, rn.UD)
        and settings.update.lambda_ == 1.0
    ):
        Q = positive(np.random.default_rng(seed), settings.structure.l_theta) / 50
        settings = with_update(settings, process_noise=Q)
    plant = data.draw(
        schedules(l_u, l_y, l_z)
        if kind == "schedule"
        else engine_plants(l_u, l_y, l_z, settings.structure.l_r)
    )
    plant = as_functions(plant) if kind == "functions" else plant
    saturation = data.draw(st.sampled_from([None, rn.Saturation(low=-0.5, high=0.4, rate=0.2)]))
    w, steps = noise(seed, 20, plant.l_w), 20
    whole = rn.simulate(plant, settings, w, saturation=saturation)
    if whole.outcome != "completed":
        return
    cut = data.draw(st.integers(1, steps - 1))
    # The usual limit is that of what comes from outside, of which the first piece sees a part.
    limit = whole.divergence_limit
    first = rn.simulate(plant, settings, w[:cut], saturation=saturation, divergence_limit=limit)
    rest = rn.simulate(plant, settings, w[cut:], start=first.state, saturation=saturation)
    assert rest.divergence_limit == limit and rest.state == whole.state
    assert rest.first_step == cut and rest.state.k == steps
    for name in SIGNALS:
        pieces = np.concatenate([getattr(first, name), getattr(rest, name)])
        assert np.array_equal(pieces, getattr(whole, name)), name
    assert np.array_equal(rest.theta_final, whole.theta_final)
    assert rest.state.values.tobytes() == whole.state.values.tobytes()
    assert (rest.resets, rest.guard_count) == (whole.resets, whole.guard_count)


@pytest.mark.parametrize("number", ["w", "x_0"])
def test_a_state_carries_the_size_of_what_came_from_outside(number, tmp_path):
    """A run that goes on from a large signal diverges where the whole run does."""
    plant = rn.Plant(A=[[1.2]], B=[[1.0]], D_1=[[1.0]], C=[[1.0]], E_1=[[1.0]])
    update = rn.UD(1.0)
    settings = rn.ControllerSettings(
        structure=rn.iir(1), target=rn.TargetModel([0, 1.0]), update=update, k_w=10**6
    )
    w, x_0 = np.zeros((300, 1)), [1e4 if number == "x_0" else 0.0]
    w[3] = 0.0 if number == "x_0" else 1e4
    whole = rn.simulate(plant, settings, w, x_0=x_0)
    first = rn.simulate(plant, settings, w[:50], x_0=x_0)
    first.state.save(tmp_path / "state.npz")
    state = rn.SavedState.load(tmp_path / "state.npz")
    assert state == first.state and state.scale == 1e4
    rest = rn.simulate(plant, settings, w[50:], start=state)
    assert whole.outcome == rest.outcome == "diverged" and whole.divergence_limit == 1e19
    assert 50 + rest.steps == whole.steps
    with pytest.raises(InputError, match="damaged"):
        rn.simulate(plant, settings, w[50:], start=replace(state, scale=1.0))


@given(st.data(), sizes, sizes, sizes, seeds)
def test_a_restored_controller_goes_on_bit_for_bit(data, l_u, l_y, l_z, seed):
    l_r = data.draw(st.integers(0, 1))
    settings, _ = data.draw(cases(l_u, l_y, l_z, l_r, **data.draw(rules())))
    l_r = settings.structure.l_r
    rng = np.random.default_rng(seed)
    inputs = [
        (
            rng.standard_normal(l_y),
            rng.standard_normal(l_z),
            rng.standard_normal(l_r) if l_r else None,
        )
        for _ in range(20)
    ]
    one, other = rn.Controller(settings), rn.Controller(settings)
    cut = data.draw(st.integers(0, 19))
    for step in inputs[:cut]:
        one.step(*step)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "state.npz"
        one.state.save(path)
        state = rn.SavedState.load(path)
    assert state.values.tobytes() == one.state.values.tobytes() and state.k == cut
    for step in inputs[: data.draw(st.integers(0, 19))]:  # whatever it did before is forgotten
        other.step(*step)
    other.restore(state)
    for step in inputs[cut:]:
        assert np.array_equal(one.step(*step), other.step(*step))
    assert np.array_equal(one.theta, other.theta) and np.array_equal(one.P, other.P)


@given(st.data(), sizes, sizes, sizes, seeds)
def test_step_by_step_with_r_is_the_run(data, l_u, l_y, l_z, seed):
    settings, _ = data.draw(cases(l_u, l_y, l_z, 2, ["centralised", "fb_fir", "ff"]))
    plant = data.draw(engine_plants(l_u, l_y, l_z, 2))
    run = rn.simulate(plant, settings, noise(seed, 15, plant.l_w))
    controller = rn.Controller(settings)
    for k in range(run.steps):
        assert np.array_equal(controller.theta, run.theta[k])
        assert np.array_equal(controller.step(run.y[k], run.z[k], run.w[k, 1:]), run.u[k])


@given(st.data(), sizes, sizes, st.integers(0, 16), seeds)
def test_a_frozen_twin_is_the_run_until_it_stops_adapting(data, l_u, l_z, k, seed):
    freeze = data.draw(st.sampled_from([(), ((2, 10),), ((3, 6), (12, 14))]))
    parts = [data.draw(cases(l_u, 1, l_z, kinds=["fir", "iir"], freeze=freeze)) for _ in range(2)]
    plant = data.draw(engine_plants(l_u, 1, l_z))
    for settings in (parts[0][0], rn.Decentralized([part[0] for part in parts])):
        run = rn.simulate(plant, settings, noise(seed, 16, plant.l_w), x_0=np.ones(plant.n))
        twin = rn.frozen_twin(run, k)
        if run.outcome != "completed" or twin.outcome != "completed":
            return
        until = min(k + 1, 16)
        assert np.array_equal(twin.u[:until], run.u[:until])
        assert np.array_equal(twin.theta[:until], run.theta[:until])
        assert (twin.theta[k:] == twin.theta[k : k + 1]).all()
        assert k == 16 or np.array_equal(twin.theta_final, run.theta[k])


@pytest.mark.exact_data  # bit for bit in two ways, whose intermediate results are read anew
def test_the_coefficients_of_a_filter_run_are_those_that_made_u():
    """In the filter form theta(k) has seen z(k); `compensator_at` is the controller of step k."""
    plant_settings = rn.ControllerSettings(
        structure=rn.iir(1),
        target=rn.TargetModel([0, 1.0]),
        update=rn.UD(R_theta=0.1),
        form="filter",
        k_w=1,
    )
    rng = np.random.default_rng(0)
    run = rn.simulate(rn.standard_plant("1/(q - 0.5)"), plant_settings, rng.standard_normal((9, 1)))
    phi = np.array([run.u[4, 0], run.y[4, 0]])
    assert run.u[5, 0] == pytest.approx(phi @ run.theta[5], rel=1e-14)
    assert run.compensator_at(5).past_y[1, 0, 0] == run.theta[5, 1]


SIMPLE = rn.ControllerSettings(
    structure=rn.iir(1), target=rn.TargetModel([0, 1.0]), update=rn.UD(R_theta=1.0)
)


def test_a_state_of_another_controller_or_loop_is_refused():
    controller = rn.Controller(SIMPLE)
    controller.step(1.0, 1.0)
    longer = rn.ControllerSettings(
        structure=rn.iir(2), target=rn.TargetModel([0, 1.0]), update=rn.UD(R_theta=1.0)
    )
    changes = [
        {"update": rn.UD(R_theta=2.0)},
        {"update": rn.Covariance(R_theta=1.0)},
        {"freeze": ((3, 4),)},
    ]
    for other in (longer, *(replace(SIMPLE, **change) for change in changes)):
        fresh = rn.Controller(other)
        with pytest.raises(InputError, match="belongs to a controller with other settings"):
            fresh.restore(controller.state)
        assert fresh.k == 0
    plant = rn.standard_plant("1/(q - 0.5)")
    run = rn.simulate(plant, SIMPLE, np.ones((5, 1)))
    with pytest.raises(
        InputError, match="a controller cannot be restored from the state of a loop"
    ):
        controller.restore(run.state)
    with pytest.raises(
        InputError, match="a loop cannot be restored from the state of a controller"
    ):
        rn.simulate(plant, SIMPLE, np.ones((5, 1)), start=controller.state)
    with pytest.raises(InputError, match="is not a SavedState"):
        rn.simulate(plant, SIMPLE, np.ones((5, 1)), start="state.npz")
    with pytest.raises(InputError, match="is not a SavedState"):
        controller.restore(run.theta)
    for changed in (rn.standard_plant("1/(q - 0.6)"), rn.standard_plant("1/(q^2 - 0.5*q)")):
        with pytest.raises(InputError, match="other settings"):
            rn.simulate(changed, SIMPLE, np.ones((5, 1)), start=run.state)
    with pytest.raises(InputError, match="other settings"):
        rn.simulate(
            plant, SIMPLE, np.ones((5, 1)), start=run.state, saturation=rn.Saturation(low=0)
        )
    with pytest.raises(InputError, match="give either x_0 or start"):
        rn.simulate(plant, SIMPLE, np.ones((5, 1)), start=run.state, x_0=[1.0])
    for k, values, message in (
        (5, run.state.values[:-1], "the state of this loop is damaged"),
        (4, run.state.values, "its header has step 4, its contents step 5"),
    ):
        other = rn.SavedState.of_values("loop", k, values, run.state.fingerprint)
        with pytest.raises(InputError, match=message):
            rn.simulate(plant, SIMPLE, np.ones((5, 1)), start=other)


def test_a_file_that_holds_no_state_is_named(tmp_path):
    path = tmp_path / "state.npz"
    rn.Controller(SIMPLE).state.save(path)
    whole = path.read_bytes()
    for length in (0, 3, 10, len(whole) // 2, len(whole) - 5):
        path.write_bytes(whole[:length])
        with pytest.raises(InputError, match=r"holds no saved state|cannot be read"):
            rn.SavedState.load(path)
    np.savez(tmp_path / "foreign.npz", theta=np.zeros(3))
    np.savez(
        tmp_path / "shapes.npz", kind="loop", k=np.zeros(2), bits=np.zeros(2, "i8"), fingerprint=""
    )
    np.savez(tmp_path / "types.npz", kind="loop", k=0, bits=np.zeros(3, "i4"), fingerprint="")
    np.savez(tmp_path / "pickled.npz", kind=np.array([{}], object), k=0, bits=[1], fingerprint="")
    np.save(tmp_path / "array.npy", np.zeros(3))
    (tmp_path / "text.npz").write_text("not a state")
    for name in ("foreign.npz", "shapes.npz", "types.npz", "pickled.npz", "array.npy", "text.npz"):
        with pytest.raises(InputError, match="holds no saved state"):
            rn.SavedState.load(tmp_path / name)
    with pytest.raises(InputError, match="cannot be read"):
        rn.SavedState.load(tmp_path / "missing.npz")


def test_a_restored_controller_forgets_that_a_weight_failed():
    broken = []

    def R_u(k, y, z, u):
        if broken:
            raise OSError("the table is gone")
        return 0.1

    controller = rn.Controller(replace(SIMPLE, R_u=R_u))
    controller.step(1.0, 1.0)
    controller.step(1.0, 1.0)
    state = controller.state
    broken.append(1)
    with pytest.raises(FunctionFailedError, match="the table is gone"):
        controller.step(1.0, 1.0)
    broken.clear()
    controller.restore(state)
    controller.step(1.0, 1.0)
    assert controller.k == 3


def test_a_file_from_before_states_had_a_scale_is_read(tmp_path):
    """It has no such entry, and its checksum counts none: the state of a loop at rest."""
    plant = rn.Plant(A=[[0.5]], B=[[1.0]], D_1=[[1.0]], C=[[1.0]], E_1=[[1.0]])
    settings = rn.ControllerSettings(
        structure=rn.iir(1), target=rn.TargetModel([0, 1.0]), update=rn.UD(1.0)
    )
    state = rn.simulate(plant, settings, np.zeros((5, 1))).state
    state.save(tmp_path / "new.npz")
    with np.load(tmp_path / "new.npz") as entries:
        np.savez(tmp_path / "old.npz", **{k: v for k, v in entries.items() if k != "scale"})
    assert rn.SavedState.load(tmp_path / "old.npz") == state and state.scale == 0.0
