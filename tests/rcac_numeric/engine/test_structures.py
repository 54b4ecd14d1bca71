"""Every controller structure: its regressor, its compensator, and how structures combine."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from tests.support.comparisons import tame
from tests.support.engine_cases import KINDS, cases, engine_plants, settings_for, structures
from tests.support.signals import noise
from tests.support.strategies import seeds, sizes
from tests.support.textbook_loop import assert_follows


@pytest.mark.costly
@pytest.mark.parametrize("kind", KINDS)
@given(st.data(), sizes, sizes, sizes, st.integers(1, 2), seeds)
def test_every_structure_follows_the_text(kind, data, l_u, l_y, l_z, l_r, seed):
    l_r = l_r if kind in ("centralised", "fb_fir", "ff", "table") else 0
    settings, regressor = data.draw(cases(l_u, l_y, l_z, l_r, [kind]))
    plant = data.draw(engine_plants(l_u, l_y, l_z, settings.structure.l_r))
    run = tame(rn.simulate(plant, settings, noise(seed, 14, plant.l_w)))
    assert_follows(run, [(settings, regressor)])


@pytest.mark.exact_data  # theta is compared with what was given
@given(st.data(), sizes, sizes, st.integers(0, 2), seeds)
def test_a_compensator_is_its_frozen_controller(data, l_u, l_y, l_r, seed):
    """The difference equation in u, y and r against the controller with its derived signals."""
    structure, _ = data.draw(structures(l_u, l_y, l_r))
    rng = np.random.default_rng(seed)
    theta = rng.uniform(-1, 1, structure.l_theta) / len(structure.taps)
    settings = rn.ControllerSettings(
        structure=structure,
        target=rn.TargetModel(np.ones((2, 1, l_u))),
        update=rn.UD(R_theta=1.0),
        theta_0=theta,
        freeze=((0, None),),
    )
    controller, fixed = rn.Controller(settings), settings.compensator_of(theta)
    steps = settings.k_w + 25
    y, r = noise(seed, steps, l_y), noise(seed + 1, steps, structure.l_r)
    y[: settings.k_w] = 0  # u = 0 is what the compensator makes of them, too
    r[: settings.k_w] = 0
    u = np.zeros((steps, l_u))
    v = np.concatenate([y, r], axis=1)
    for k in range(steps):
        output = controller.step(y[k], [0.0], r[k] if structure.l_r else None)
        for i in range(1, min(fixed.n_c, k) + 1):
            u[k] += fixed.past_u[i - 1] @ u[k - i]
        for i in range(min(fixed.n_c, k) + 1):
            u[k] += fixed.past_y[i] @ v[k - i]
        size = max(1.0, np.abs(u[: k + 1]).max())
        assert output == pytest.approx(u[k], abs=1e-9 * size)
    assert np.array_equal(controller.theta, theta)


def test_the_pid_controller_of_the_text_by_hand():
    """(2.58)-(2.62) for e = 1, 2, 3, 4, 5: gamma(k-1) = 0, 0, 1, 3, 6."""
    settings = rn.ControllerSettings(
        structure=rn.pid(), target=rn.TargetModel([0, 1.0]), update=rn.UD(R_theta=1.0),
        theta_0=[100.0, 10.0, 1.0], freeze=((0, None),),
    )  # fmt: skip
    controller = rn.Controller(settings)
    u = [controller.step(e, 0.0)[0] for e in (1.0, 2.0, 3.0, 4.0, 5.0)]
    assert u == [0, 0, 200 + 10 * 1 + 1, 300 + 10 * 3 + 1, 400 + 10 * 6 + 1]


@pytest.mark.parametrize(("k_c", "first_r"), [(0, None), (1, None), (0, 0), (0, 1), (1, 2)])
def test_a_feedforward_reads_r_from_k_c_on_unless_told(k_c, first_r):
    """r(k - i) for i from first_r to n_c = 2, and as many of u and of y as (2.23) has."""
    structure = rn.feedforward(2, k_c=k_c, first_r=first_r)
    lags = [tap.delay for tap in structure.taps if tap.signal == "r"]
    assert lags == list(range(k_c if first_r is None else first_r, 3))
    assert structure.l_theta == 2 + (3 - k_c) + len(lags)


@given(st.data(), sizes, sizes, sizes, st.booleans(), seeds)
def test_decentralised_controllers_follow_the_text(data, l_u, l_y, l_z, shared_u, seed):
    """Figure 2.16: each controller's Phi and G_f hold its own u, or the sum."""
    parts = [
        data.draw(cases(l_u, l_y, l_z, l_r, [kind], update=update))
        for l_r, kind, update in ((0, "fir", rn.UD), (1, "ff", rn.Covariance))
    ]
    plant = data.draw(engine_plants(l_u, l_y, l_z, 1))
    both = rn.Decentralized([settings for settings, _ in parts], shared_u=shared_u)
    run = tame(rn.simulate(plant, both, noise(seed, 14, plant.l_w)))
    assert_follows(run, parts, shared_u=shared_u)


@pytest.mark.costly
@pytest.mark.parametrize("kind", ["fb_fir", "iir", "pid", "fir_integrator", "table"])
@given(st.data(), sizes, seeds)
def test_a_decentralised_compensator_is_the_frozen_sum(kind, data, l_y, seed):
    """With u of their own the two denominators multiply; with the shared u the taps add."""
    plant = data.draw(engine_plants(1, l_y, 1, 1))
    drawn = [data.draw(structures(1, l_y, 1, [kind]))[0] for kind in (kind, "ff")]
    k_w = max(s.n_c for s in drawn) + 3
    parts = [data.draw(settings_for(s, 1, freeze=((0, None),), k_w=k_w, k_update=0)) for s in drawn]
    w = noise(seed, k_w + 12, plant.l_w)
    w[:k_w] = 0
    for shared_u in (False, True):
        both = rn.Decentralized(parts, shared_u=shared_u)
        run = tame(rn.simulate(plant, both, w))
        fixed = run.compensator
        v = np.concatenate([run.y, w[:, 1:]], axis=1)
        for k in range(len(w)):
            u = sum(fixed.past_u[i - 1] @ run.u[k - i] for i in range(1, min(fixed.n_c, k) + 1))
            u = u + sum(fixed.past_y[i] @ v[k - i] for i in range(min(fixed.n_c, k) + 1))
            assert u == pytest.approx(run.u[k], abs=1e-9 * max(1.0, np.abs(run.u).max()))
