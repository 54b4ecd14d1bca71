"""What published settings have beside the text's: engine, reference, states and lanes."""

import pickle

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import rcac_numeric as rn
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.controllers._normalization import FUNCTIONS
from tests.support.engine_cases import cases, engine_plants
from tests.support.signals import noise
from tests.support.strategies import seeds, sizes

PLANT = rn.standard_plant("(q - 0.3)/((q - 0.9)*(q - 0.5))")
FIXED = rn.Compensator([[[0.5]], [[-0.1]]], [[[0.0]], [[-0.2]], [[0.1]]])


def ellipsoid(size):
    return rn.CertifiedBounds(np.zeros(size), 0.04 * np.eye(size) + 0.01 * np.tri(size))


ADDITIONS = {
    "R_u_unfiltered": {"R_u_unfiltered": 0.3},
    "z_normalization": {"z_normalization": rn.Normalization(limit=0.5)},
    "row weight": {"R_z": rn.SignalWeight(constant=1.0, nu=0.7)},
    "metric": {"bounds": rn.CoefficientBounds(-0.05, 0.05)},
    "clip": {"bounds": rn.CoefficientBounds(-0.05, 0.05, method="clip")},
    "ellipsoid": {"bounds": ellipsoid(6)},
    "fixed": {"fixed": FIXED},
    "all": {
        "R_u_unfiltered": 0.3,
        "z_normalization": rn.Normalization(2.0, 1.5, "tanh"),
        "R_z": rn.SignalWeight(constant=1.0, nu=0.7),
        "bounds": rn.CoefficientBounds(-0.05, 0.05),
        "fixed": FIXED,
    },
}
UPDATES = {
    "ud": rn.UD(0.1, lambda_=0.99),
    "subspace": rn.UD(0.1, lambda_=rn.SubspaceForgetting(0.98)),
    "covariance": rn.Covariance(0.1),
    "window": rn.SlidingWindow(0.1, window=7),
    "instantaneous": rn.Instantaneous(0.5),
    "gradient": rn.Gradient(0.01),
}


def settings_of(**more):
    argument = {
        "structure": rn.iir(3),
        "target": rn.TargetModel([0, 1.0, -0.3]),
        "update": rn.UD(0.1),
    }
    return rn.ControllerSettings(**{**argument, **more})


@st.composite
def additions(draw, settings):
    """The settings with some of the additions that the reference knows."""
    s, rng, more = settings.structure, np.random.default_rng(draw(seeds)), {}
    if draw(st.booleans()):
        root = rng.standard_normal((s.l_u, s.l_u))
        R = root @ root.T + 0.1 * np.eye(s.l_u)
        more["R_u_unfiltered"] = (R + R.T) / 2
    if draw(st.booleans()):
        limit, slope = draw(st.floats(0.2, 3)), draw(st.floats(0.5, 2))
        more["z_normalization"] = rn.Normalization(limit, slope, draw(st.sampled_from(FUNCTIONS)))
    if draw(st.booleans()):
        more["R_z"] = rn.SignalWeight(z_squared=0.2, constant=1.0, nu=draw(st.floats(0.1, 2)))
    if draw(st.booleans()):
        size = np.abs(settings.theta_0).max(initial=0.0) + draw(st.floats(0.01, 0.5))
        more["bounds"] = rn.CoefficientBounds(-size, size, method="clip")
        if draw(st.booleans()):
            L = np.tril(rng.uniform(-size, size, (s.l_theta, s.l_theta)), -1) / s.l_theta
            L += np.diag(size * rng.uniform(0.2, 1.0, s.l_theta))
            more["bounds"] = rn.CertifiedBounds(settings.theta_0, L)
    if draw(st.booleans()):
        n, inputs = draw(st.integers(0, 2)), s.l_y + s.l_r
        P, Q = rng.standard_normal((n, s.l_u, s.l_u)), rng.standard_normal((n + 1, s.l_u, inputs))
        more["fixed"] = rn.Compensator(P / 5, Q / 5)
    if s.derived and draw(st.booleans()):
        stored = [
            rn.DerivedSignal(d.now, d.before, d.pole, draw(st.floats(0.1, 2))) for d in s.derived
        ]
        more["structure"] = replace(s, derived=stored)
    return replace(settings, **more)


RULES = [
    {},
    {"update": rn.Covariance},
    {"update": rn.Instantaneous},
    {"update": lambda R: rn.Gradient(0.01)},
]


@pytest.mark.costly
@given(st.data(), sizes, sizes, sizes, st.sampled_from(RULES), st.booleans(), seeds)
@hypothesis_settings(max_examples=40)
def test_the_engine_follows_the_reference(data, l_u, l_y, l_z, rule, filter_form, seed):
    form = {"form": "filter", "strictly_proper": True} if filter_form else {}
    plain, _ = data.draw(cases(l_u, l_y, l_z, data.draw(st.integers(0, 1)), **rule, **form))
    settings = data.draw(additions(plain))
    plant = data.draw(engine_plants(l_u, l_y, l_z, settings.structure.l_r))
    w, x_0 = noise(seed, 12, plant.l_w), np.ones(plant.n)
    run = rn.simulate(plant, settings, w, x_0=x_0)
    assume(run.outcome == "completed" and np.abs(run.u).max() < 1e2)
    exact = rn.simulate_reference(plant, settings, w, x_0=x_0, digits=200)
    size = max(1.0, np.abs(exact.theta).max()) * max(1.0, np.abs(exact.u).max()) ** 3
    for name in ("theta", "theta_final", "u", "y", "z"):
        assert np.abs(getattr(run, name) - getattr(exact, name)).max() <= 1e-10 * size, name


@pytest.mark.costly
@pytest.mark.parametrize("structure", ["iir", "pid"])
@pytest.mark.parametrize("update", UPDATES)
@pytest.mark.parametrize("name", ADDITIONS)
def test_a_run_cut_in_two_is_the_run(name, update, structure):
    table = {"iir": rn.iir(3), "pid": rn.pid(k_c=0, integral_limit=0.4)}
    more = ADDITIONS[name]
    if name == "ellipsoid":
        more = {"bounds": ellipsoid(table[structure].l_theta)}
    settings = settings_of(structure=table[structure], update=UPDATES[update], **more)
    w = noise(5, 80, 1)
    whole = rn.simulate(PLANT, settings, w)
    plain = rn.simulate(PLANT, settings_of(structure=settings.structure, update=settings.update), w)
    assert whole.outcome == "completed" and not np.array_equal(whole.u, plain.u)
    for cut in (2, 41):
        first = rn.simulate(PLANT, settings, w[:cut])
        rest = rn.simulate(PLANT, settings, w[cut:], start=first.state)
        assert np.array_equal(np.concatenate([first.u, rest.u]), whole.u)
        assert rest.state.values.tobytes() == whole.state.values.tobytes()
        assert rest.bounded == whole.bounded


@pytest.mark.costly
@pytest.mark.parametrize("form", ["predictor", "filter"])
@pytest.mark.parametrize("name", ADDITIONS)
def test_a_controller_at_a_device_is_the_one_in_the_loop(name, form, tmp_path):
    settings = settings_of(form=form, **ADDITIONS[name])
    run = rn.simulate(PLANT, settings, noise(6, 60, 1))
    controller = rn.Controller(settings)
    u = [controller.step(y, z) for y, z in zip(run.y[:30], run.z[:30], strict=True)]
    other = pickle.loads(pickle.dumps(controller))
    u += [other.step(y, z) for y, z in zip(run.y[30:], run.z[30:], strict=True)]
    assert np.array_equal(u, run.u)
    assert other.bounded == run.bounded
    run.save(tmp_path / "run.npz")
    assert rn.load_run(tmp_path / "run.npz") == run


@pytest.mark.parametrize("name", sorted(ADDITIONS.keys() - {"ellipsoid"}))
def test_lanes_leave_what_they_do_not_know_to_the_ordinary_loop(name):
    settings = settings_of(**ADDITIONS[name])
    data = [noise(seed, 50, 1) for seed in range(8)]
    together = rn.simulate_many([rn.SimulationCase(PLANT, settings, w) for w in data], lanes=True)
    assert together == [rn.simulate(PLANT, settings, w) for w in data]


@given(seeds, st.floats(0.05, 1.0))
def test_a_clamped_integrator_never_leaves_its_limit(seed, limit):
    """gamma(k) of (6.5), clamped at every step, is what u is made of."""
    structure = rn.fir_integrator(2, integral_limit=limit)
    theta = np.array([0.1, -0.2, 0.3])
    settings = settings_of(structure=structure, theta_0=theta, k_update=10**6)
    run = rn.simulate(PLANT, settings, noise(seed, 60, 1))
    gamma, stored = 0.0, []
    for y in run.y[:, 0]:
        gamma = min(max(gamma + y, -limit), limit)
        stored.append(gamma)
    y = run.y[:, 0]
    u = theta[0] * y[1:-1] + theta[1] * y[:-2] + theta[2] * np.array(stored[2:])
    assert np.allclose(run.u[2:, 0], u, atol=1e-12)
    free = rn.simulate(PLANT, replace(settings, structure=rn.fir_integrator(2)), noise(seed, 60, 1))
    assert np.abs(np.cumsum(free.y)).max() <= limit or not np.array_equal(free.u, run.u)


def test_the_log_of_a_clamped_integrator_is_consistent():
    run = rn.simulate(PLANT, settings_of(structure=rn.pid(integral_limit=0.3)), noise(8, 200, 1))
    assert rn.check_controller(run).is_consistent
    loose = replace(run.settings, structure=rn.pid())
    assert not rn.check_controller(replace(run, settings=loose)).is_consistent
