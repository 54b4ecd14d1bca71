"""A fixed controller is its difference equation, in every loop that an adaptive one runs in."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory import InputError
from compensator_theory.errors import ImproperError
from rcac_numeric.arrays._values import replaced as replace
from tests.support.changing_plants import schedules
from tests.support.comparisons import identical, tame
from tests.support.engine_cases import engine_plants, settings_for, structures
from tests.support.function_plants import as_functions
from tests.support.signals import noise, white
from tests.support.strategies import plants, seeds
from tests.support.textbook_loop import BookPlant, actuated, r_position

STEPS = 16
pairs = st.integers(1, 2)


@st.composite
def fixed(draw, l_u, l_y, l_r=0, strictly_proper=False):
    """Of order 0 to 3; the last inputs are commands."""
    n_c, rng = draw(st.integers(0, 3)), np.random.default_rng(draw(seeds))
    past_u = 0.4 * rng.standard_normal((n_c, l_u, l_u))
    past_y = 0.4 * rng.standard_normal((n_c + 1, l_u, l_y + l_r))
    if strictly_proper or draw(st.booleans()):
        past_y[0] = 0
    return rn.FixedController(rn.Compensator(past_u, past_y), l_r, k_w=draw(st.integers(0, 4)))


@st.composite
def loops(draw):
    """(plant, controller, saturation): every kind of plant, with and without commands."""
    l_u, l_y, l_z = draw(pairs), draw(pairs), draw(pairs)
    kind = draw(st.sampled_from(["linear", "schedule", "functions", "feedthrough"]))
    l_r = draw(st.integers(0, 1)) if kind in ("linear", "functions") else 0
    controller = draw(fixed(l_u, l_y, l_r, strictly_proper=kind == "feedthrough"))
    if kind == "schedule":
        plant = draw(schedules(l_u, l_y, l_z))
    elif kind == "feedthrough":
        plant = draw(plants(st.just(l_u), st.just(l_y), st.just(l_z), feedthrough=True))
    else:
        plant = draw(engine_plants(l_u, l_y, l_z, l_r))
    bounds = rn.Saturation(low=-0.5, high=0.4, rate=0.3)
    run_on = as_functions(plant) if kind == "functions" else plant
    return plant, run_on, controller, draw(st.sampled_from([None, bounds]))


def loop_in_python(plant, controller, w, saturation, x_0, forced):
    """(2.28) around (2.1)-(2.3), the last step anew from the signals of the run `forced`."""
    c, body = controller.compensator, BookPlant(plant, x_0)
    start, nothing = r_position(plant), np.zeros(c.l_u)
    u, v, record = [], [], {"u": [], "u_applied": [], "y": [], "z": []}
    for k, w_k in enumerate(w):
        body.begin()
        r = w_k[start : start + controller.l_r]
        expected = nothing
        if k >= controller.k_w:
            expected = sum(
                (c.past_u[i - 1] @ u[k - i] for i in range(1, min(c.n_c, k) + 1)), nothing
            )
            expected = expected + sum(c.past_y[i] @ v[k - i] for i in range(1, min(c.n_c, k) + 1))
            if c.past_y[0].any():  # then y(k) does not need u(k)
                y, _ = body.outputs(nothing, w_k)
                expected = expected + c.past_y[0] @ np.concatenate([y, r])
        record["u"].append(expected)
        record["u_applied"].append(actuated(saturation, expected, u[-1] if u else nothing))
        u.append(forced.u_applied[k])
        y, z = body.outputs(u[k], w_k)
        record["y"].append(y)
        record["z"].append(z)
        v.append(np.concatenate([y, r]))
        body.advance(u[k], w_k)
    return record


@given(loops(), seeds)
def test_a_fixed_controller_is_its_difference_equation(loop, seed):
    plant, run_on, controller, saturation = loop
    w, x_0 = noise(seed, STEPS, plant.l_w), noise(seed + 1, 1, plant.n)[0]
    run = rn.simulate(run_on, controller, w, x_0=x_0, saturation=saturation)
    assert run.outcome == "completed"
    message = loop_in_python(plant, controller, w, saturation, x_0, run)
    size = max(1.0, *(np.abs(getattr(run, name)).max() for name in ("u", "y", "z")))
    for name, values in message.items():
        assert np.abs(np.array(values) - getattr(run, name)).max() <= 1e-12 * size, name
    assert not run.u[: controller.k_w].any()
    assert run.theta.shape == (STEPS, 0) and run.theta_final.shape == (0,)
    assert run.compensator is controller.compensator
    assert run.compensator_at(3) is controller.compensator
    assert (run.guard_count, run.resets, run.reflections) == (0, 0, 0)


@given(loops(), st.integers(1, STEPS - 1), st.integers(1, 5), seeds)
def test_a_run_cut_in_pieces_is_the_run(tmp_path_factory, loop, cut, stride, seed):
    _, plant, controller, saturation = loop
    w = noise(seed, STEPS, plant.l_w)
    options = {"saturation": saturation, "stride": stride}
    whole = rn.simulate(plant, controller, w, **options)
    first = rn.simulate(plant, controller, w[:cut], **options)
    path = tmp_path_factory.mktemp("states") / "state.npz"
    first.state.save(path)
    rest = rn.simulate(plant, controller, w[cut:], start=rn.SavedState.load(path), **options)
    for name in ("u", "u_applied", "y", "z"):
        pieces = np.concatenate([getattr(first, name), getattr(rest, name)])
        assert np.array_equal(pieces, getattr(whole, name)), name
    assert rest.state.values.tobytes() == whole.state.values.tobytes()
    assert [run.theta.shape for run in (whole, first)] == [
        (-(-steps // stride), 0) for steps in (STEPS, cut)
    ]


@given(st.data(), pairs, pairs, pairs, st.integers(0, 1), seeds)
def test_a_frozen_adaptive_controller_is_a_fixed_one(data, l_u, l_y, l_z, l_r, seed):
    """From the same past, u = 0 up to k_w, whatever y was."""
    kinds = ["iir", "fir", "quasi_fir", *(["centralised", "fb_fir", "ff"] if l_r else [])]
    structure, _ = data.draw(structures(l_u, l_y, l_r, kinds))
    settings = data.draw(settings_for(structure, l_z, freeze=((0, None),)))
    settings = replace(settings, theta_0=4 * settings.theta_0)
    plant = data.draw(engine_plants(l_u, l_y, l_z, structure.l_r))
    w = noise(seed, settings.k_w + STEPS, plant.l_w)
    run = tame(rn.simulate(plant, settings, w))
    controller = rn.FixedController(run.compensator, structure.l_r, settings.k_w)
    alone = rn.simulate(plant, controller, w)
    size = max(1.0, np.abs(run.u).max()) ** 2
    for name in ("u", "y", "z"):
        assert np.abs(getattr(alone, name) - getattr(run, name)).max() <= 1e-10 * size, name


def test_a_converged_controller_goes_on_as_a_fixed_one():
    """The loop is stable, so it forgets that it was once adapted."""
    plant, steps = rn.standard_plant("(q - 0.5)/(q^2 - 1.2*q + 0.72)"), 3000
    settings = rn.ControllerSettings(
        structure=rn.iir(3), target=rn.fir_target(plant), update=rn.UD(R_theta=1e-2),
        freeze=((2000, None),),
    )  # fmt: skip
    w = white(steps, seed=4)
    run = rn.simulate(plant, settings, w)
    alone = rn.simulate(plant, rn.FixedController(run.compensator), w)
    loop = rn.ClosedLoop(plant, run.compensator)
    assert np.abs(loop.poles()).max() < 0.97  # 0.97 ** 1000 is 6e-14
    assert np.abs(run.u[:100] - alone.u[:100]).max() > 1e-3
    assert np.abs(run.u[-10:] - alone.u[-10:]).max() < 1e-9 * np.abs(run.u).max()


@pytest.mark.exact_data  # the gain is given as a number
def test_no_saturation_is_a_wide_one_and_a_twin_is_the_run():
    plant = rn.standard_plant("1/(q - 1.2)")
    controller = rn.FixedController(rn.Compensator(np.zeros((0, 1, 1)), [[[-0.9]]]), k_w=3)
    run = rn.simulate(plant, controller, white(60), x_0=[0.5], stride=7)
    wide = rn.simulate(
        plant, controller, white(60), x_0=[0.5], saturation=rn.Saturation(low=-1e9, high=1e9)
    )
    assert np.array_equal(run.u, wide.u) and np.array_equal(wide.u_applied, wide.u)
    assert np.array_equal(run.u[3:], -0.9 * run.y[3:])  # n_c = 0: a gain
    assert identical(rn.frozen_twin(run, 20), run)
    cases = [rn.SimulationCase(plant, controller, white(60), {"x_0": [0.5], "stride": 7})] * 9
    for lanes in (False, True):
        assert all(identical(one, run) for one in rn.simulate_many(cases, lanes=lanes))


def test_a_compensator_of_zeros_leaves_the_plant_alone():
    plant = rn.standard_plant("1/(q - 0.5)")
    for n_c in range(3):
        nothing = rn.Compensator(np.zeros((n_c, 1, 1)), np.zeros((n_c + 1, 1, 1)))
        run = rn.simulate(plant, rn.FixedController(nothing), white(20))
        assert not run.u.any() and run.z.any() and run.theta.shape == (20, 0)


def test_what_does_not_fit_is_refused():
    proper = rn.Plant(A=[[0.5]], B=[[1.0]], D_1=[[1.0]], C=[[1.0]], D_0=[[1.0]])
    gain = rn.FixedController(rn.Compensator(np.zeros((0, 1, 1)), [[[0.3]]]))
    with pytest.raises(ImproperError, match=r"exactly proper .* D_0 is not zero"):
        rn.simulate(proper, gain, white(5))
    plant = rn.standard_plant("1/(q - 0.5)")
    with pytest.raises(InputError, match="plant has l_y = 1 and the controller l_y = 0"):
        rn.simulate(plant, rn.FixedController(gain.compensator, l_r=1), white(5))
    wide = rn.Compensator(np.zeros((0, 1, 1)), [[[0.3, 0.1]]])
    with pytest.raises(InputError, match="reads a command with l_r = 1"):
        rn.simulate(plant, rn.FixedController(wide, l_r=1), white(5))
    with pytest.raises(InputError, match="has 1 inputs; l_r = 2 of them"):
        rn.FixedController(gain.compensator, l_r=2)
    with pytest.raises(InputError, match="compensator = 5 is not a Compensator"):
        rn.FixedController(5)
    with pytest.raises(InputError, match="one adaptive controller, not a FixedController"):
        rn.simulate_reference(plant, gain, white(5))
    with pytest.raises(InputError, match="no adapted coefficients"):
        gain.compensator_of([1.0])
    state = rn.simulate(plant, gain, white(5)).state
    with pytest.raises(InputError, match="other settings"):
        rn.simulate(plant, replace(gain, k_w=1), white(5), start=state)
