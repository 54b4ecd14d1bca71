"""Every update and every rule that changes it, against batch minimisers of the stated costs."""

from functools import partial

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import rcac_numeric as rn
from tests.support.comparisons import steady, tame
from tests.support.engine_cases import cases, engine_plants, positive, settings_for, structures
from tests.support.signals import noise
from tests.support.strategies import seeds, sizes, targets
from tests.support.textbook import iir_regressor
from tests.support.textbook_loop import assert_follows

RECURSIVE = st.sampled_from([rn.UD, rn.Covariance])
PLAIN = ["iir", "fir", "pid"]
STEPS = 18


def step_of(size):
    """An update that needs no R_theta."""
    return lambda R_theta: rn.Gradient(step_size=size)


def follows(data, seed, l_u, l_y, l_z, kinds=PLAIN, l_r=0, saturation=None, **fixed):
    settings, regressor = data.draw(cases(l_u, l_y, l_z, l_r, kinds, **fixed))
    plant = data.draw(engine_plants(l_u, l_y, l_z, l_r))
    w = noise(seed, STEPS, plant.l_w)
    settings = steady(plant, settings, regressor, w, saturation)
    run = rn.simulate(plant, settings, w, saturation=saturation)
    return tame(run), assert_follows(run, [(settings, regressor)])["books"][0]


@pytest.mark.parametrize("l_z", [1, 2, 3])
@pytest.mark.parametrize(
    "update",
    [rn.UD(1.0), rn.Covariance(1.0), rn.SlidingWindow(1.0, window=4), rn.Instantaneous(1.0),
     rn.Gradient(0.01)], ids=repr,
)  # fmt: skip
def test_definite_weights_let_every_step_be_made(update, l_z):
    """A run that ends early agrees with a book that ends early: here none may end."""
    rng = np.random.default_rng(l_z)
    target = rn.TargetModel(rng.standard_normal((3, l_z, 1)) * [[[0.0]], [[1.0]], [[1.0]]])
    settings = rn.ControllerSettings(
        structure=rn.iir(2),
        target=target,
        update=update,
        R_z=np.eye(l_z) + 0.4,
        R_u=rn.SignalWeight(0.1),
    )
    controller = rn.Controller(settings, rn.Supervision("off"))
    for k in range(12):
        before = controller.theta
        controller.step(rng.standard_normal(1), rng.standard_normal(l_z))
        assert k < 4 or not np.array_equal(controller.theta, before)


def test_updates_without_a_recursion_of_P_keep_their_metric():
    R_theta = np.array([[2.0, 0.5, 0, 0], [0.5, 1, 0, 0.1], [0, 0, 3, 0], [0, 0.1, 0, 1]])
    for update, P in (
        (rn.Gradient(0.25), 0.25 * np.eye(4)),
        (rn.Instantaneous(R_theta), np.linalg.inv(R_theta)),
    ):
        settings = rn.ControllerSettings(
            structure=rn.iir(2), target=rn.TargetModel([0, 1.0]), update=update
        )
        controller = rn.Controller(settings)
        for k in range(8):
            assert np.allclose(controller.P, P, rtol=1e-12, atol=1e-15)
            controller.step(np.sin(k), np.cos(k))


ROWS_CHANGE_PLACES = {  # definite: in either the last row is the pivot of the first column
    # and of the second column the second row, since a zero stands below it
    "once": [[1.0, 1, 2], [1, 2, 2], [2, 2, 8]],
    # and of the second column the third row, since the second begins with a zero
    "twice": [[1.0, 1, 2], [1, 2, 4], [2, 4, 16]],
}


@pytest.mark.parametrize("R_z", ROWS_CHANGE_PLACES.values(), ids=ROWS_CHANGE_PLACES)
@pytest.mark.parametrize("update", [rn.UD, rn.Covariance, rn.Instantaneous, rn.SlidingWindow])
def test_weights_whose_elimination_changes_rows(update, R_z):
    """A wrong pivot of R_z + R_u is here a zero."""
    window = {"window": 4} if update is rn.SlidingWindow else {}
    rng = np.random.default_rng(1)
    plant = rn.Plant(A=[[0.5]], B=[[1.0]], D_1=[[1.0]], C=[[1.0]], E_1=rng.standard_normal((3, 1)))
    settings = rn.ControllerSettings(
        structure=rn.iir(2),
        target=rn.TargetModel(rng.standard_normal((3, 3, 1)) * [[[0.0]], [[1.0]], [[1.0]]]),
        update=update(1.0, **window),
        R_z=R_z,
    )
    run = rn.simulate(plant, settings, noise(1, STEPS, 1))
    assert_follows(run, [(settings, iir_regressor(2))])
    assert not np.array_equal(run.theta_final, run.theta[0])


@given(st.data(), sizes, sizes, sizes, RECURSIVE, st.sampled_from([1.0, 0.98, 0.8]), seeds)
def test_the_recursions_minimise_2_41(data, l_u, l_y, l_z, update, lambda_, seed):
    follows(data, seed, l_u, l_y, l_z, update=partial(update, lambda_=lambda_))


@given(st.data(), sizes, sizes, sizes, RECURSIVE, seeds)
def test_forgetting_may_change_on_schedule(data, l_u, l_y, l_z, update, seed):
    rule = rn.ScheduledForgetting({7: 0.9, 12: 1.0, 15: 0.95}, initial=0.97)
    follows(data, seed, l_u, l_y, l_z, update=partial(update, lambda_=rule))


@given(st.data(), sizes, sizes, sizes, RECURSIVE, seeds)
def test_variable_rate_forgetting_is_its_formula(data, l_u, l_y, l_z, update, seed):
    short = data.draw(st.integers(1, 3))
    rule = rn.VariableRateForgetting(short, data.draw(st.integers(short + 1, 9)), gain=0.3)
    follows(data, seed, l_u, l_y, l_z, update=partial(update, lambda_=rule))


@given(st.data(), sizes, sizes, sizes, RECURSIVE, seeds)
def test_weights_follow_the_signals(data, l_u, l_y, l_z, update, seed):
    R_u = data.draw(
        st.sampled_from(
            [
                rn.SignalWeight(0.3, 0.1),
                rn.SignalWeight(0.2),
                lambda k, y, z, u: 0.1 * k + y @ y + u @ u,
            ]
        )
    )
    R_z = data.draw(
        st.sampled_from([rn.SignalWeight(0.1, 0.5), lambda k, y, z, u: 1 + abs(z[0]) + u @ u])
    )
    form = data.draw(st.sampled_from(["predictor", "filter"]))
    follows(
        data, seed, l_u, l_y, l_z, update=update, R_u=R_u, R_z=R_z,
        form=form, strictly_proper=form == "filter",
    )  # fmt: skip


@given(st.data(), sizes, sizes, sizes, RECURSIVE, seeds)
def test_a_covariance_reset_is_a_new_prior(data, l_u, l_y, l_z, update, seed):
    rule = data.draw(
        st.sampled_from(
            [
                rn.CovarianceReset(at=[9, 3, 14]),
                rn.CovarianceReset(every=4),
                rn.CovarianceReset(trace_below=0.5),
                rn.CovarianceReset(growth=1.1, short=1, long=4),
                rn.CovarianceReset(at=[10], every=5, trace_below=0.3),
            ]
        )
    )
    run, book = follows(data, seed, l_u, l_y, l_z, update=partial(update, lambda_=0.95, reset=rule))
    assert run.resets == book.resets


@given(st.data(), sizes, sizes, sizes, seeds)
def test_frozen_steps_are_no_data(data, l_u, l_y, l_z, seed):
    freeze = data.draw(
        st.sampled_from(
            [
                ((5, 9),),
                ((4, 8), (8, 10)),
                ((4, 12), (6, 9)),
                ((6, 9), (4, 12)),
                ((10, None), (3, 12)),
            ]
        )
    )
    update = data.draw(
        st.sampled_from(
            [rn.UD, partial(rn.SlidingWindow, window=4), rn.Instantaneous, step_of(0.01)]
        )
    )
    run, _ = follows(data, seed, l_u, l_y, l_z, update=update, freeze=freeze)
    for start, stop in freeze:
        end = STEPS if stop is None else stop
        assert (run.theta[start:end] == run.theta[start]).all()


@given(st.data(), sizes, sizes, sizes, RECURSIVE, st.sampled_from(["predictor", "filter"]), seeds)
def test_process_noise_is_a_random_walk_of_theta(data, l_u, l_y, l_z, update, form, seed):
    """(2.46) and (2.47)-(2.48) are Kalman filters; Q may be singular."""
    structure, regressor = data.draw(structures(l_u, l_y, 0, PLAIN))
    rng = np.random.default_rng(seed)
    Q = 0.1 * positive(rng, structure.l_theta)
    if data.draw(st.booleans()):
        Q[0], Q[:, 0] = 0, 0
    settings = data.draw(
        settings_for(structure, l_z, strictly_proper=form == "filter", form=form,
                     update=partial(update, process_noise=Q))
    )  # fmt: skip
    plant = data.draw(engine_plants(l_u, l_y, l_z))
    run = tame(rn.simulate(plant, settings, noise(seed, STEPS, plant.l_w)))
    assert_follows(run, [(settings, regressor)])


@given(st.data(), sizes, sizes, sizes, st.sampled_from([1.0, 0.9]), seeds)
def test_the_filter_form_uses_z_before_u(data, l_u, l_y, l_z, lambda_, seed):
    update = data.draw(st.sampled_from([rn.UD, rn.Covariance, rn.Instantaneous]))
    if update is not rn.Instantaneous:
        update = partial(update, lambda_=lambda_)
    follows(
        data, seed, l_u, l_y, l_z, kinds=["iir", "fir", "pid", "table"], update=update,
        form="filter", strictly_proper=True,
    )  # fmt: skip


@given(st.data(), sizes, sizes, sizes, st.integers(1, 20), st.sampled_from([1.0, 0.8]), seeds)
def test_the_sliding_window_is_its_batch(data, l_u, l_y, l_z, window, lambda_, seed):
    update = partial(rn.SlidingWindow, window=window, lambda_=lambda_)
    follows(data, seed, l_u, l_y, l_z, update=update)


def test_a_window_longer_than_float64_remembers():
    """0.5^-2000 is infinite: what is older than that is forgotten, and the run goes on."""
    plant, w = rn.standard_plant("1/(q - 0.9)"), noise(1, 1500, 1)
    settings = {"structure": rn.iir(1), "target": rn.TargetModel([0, 1.0])}
    updates = [rn.SlidingWindow(R_theta=1.0, window=n, lambda_=0.5) for n in (1400, 1000)]
    longer, long = (
        rn.simulate(plant, rn.ControllerSettings(update=update, **settings), w)
        for update in updates
    )
    assert longer.outcome == long.outcome == "completed"
    assert longer.theta == pytest.approx(long.theta, rel=1e-9)


@given(st.data(), sizes, sizes, sizes, st.booleans(), seeds)
def test_the_memoryless_updates(data, l_u, l_y, l_z, gradient, seed):
    follows(data, seed, l_u, l_y, l_z, update=step_of(0.02) if gradient else rn.Instantaneous)


@given(st.data(), sizes, sizes, sizes, st.sampled_from(["predictor", "filter"]), seeds)
def test_the_target_may_change(data, l_u, l_y, l_z, form, seed):
    later = {k: data.draw(targets(l_z, l_u)) for k in (6, 11)}
    if form == "filter":
        later = {
            k: rn.TargetModel(np.concatenate([0 * t.numerator[:1], t.numerator]), t.denominator)
            for k, t in later.items()
        }
    follows(data, seed, l_u, l_y, l_z, target_changes=later, form=form,
            strictly_proper=form == "filter")  # fmt: skip


@given(st.data(), sizes, sizes, seeds)
def test_reflected_poles_are_inside(data, l_y, l_z, seed):
    update = data.draw(st.sampled_from([rn.UD, partial(rn.Covariance, lambda_=0.9), step_of(0.01)]))
    structure, regressor = data.draw(structures(1, l_y, 0, ["iir"]))
    settings = data.draw(settings_for(structure, l_z, update=update, reflect_poles=True))
    plant = data.draw(engine_plants(1, l_y, l_z))
    w = noise(seed, STEPS, plant.l_w)
    settings = steady(plant, settings, regressor, w)
    run = rn.simulate(plant, settings, w)
    of_u = slice(0, structure.n_c)
    sizes_of_poles = [np.abs(np.roots([1.0, *-row])) for row in run.theta[:, of_u]]
    moved = run.theta[settings.k_update + 1 :]
    assert all((p <= 1 + 1e-7).all() for p in sizes_of_poles[settings.k_update + 1 :]) or not len(
        moved
    )
    # Where a pole is on the circle to rounding, or double, either answer is right.
    assume(all((np.abs(p - 1) > 1e-6).all() for p in sizes_of_poles))
    book = assert_follows(tame(run), [(settings, regressor)], tolerance=1e-7)["books"][0]
    assert run.reflections == book.reflections


@pytest.mark.exact_data  # bit for bit in two ways, whose intermediate results are read anew
@given(st.data(), sizes, sizes, sizes, seeds)
def test_the_regressor_holds_what_was_applied(data, l_u, l_y, l_z, seed):
    """Figure 2.13: u_a in Phi and u_f; the step-by-step door learns of it one step later."""
    bounds = data.draw(
        st.sampled_from([{"low": -0.2, "high": 0.1}, {"rate": 0.05}, {"high": 0.1, "rate": 0.1}])
    )
    run, book = follows(
        data, seed, l_u, l_y, l_z, kinds=["iir", "quasi_fir", "table"], strictly_proper=True,
        saturation=rn.Saturation(**bounds),
    )  # fmt: skip
    if "low" in bounds:
        assert run.u_applied.min() >= -0.2 and run.u_applied.max() <= 0.1
    controller, applied = rn.Controller(book.c), None
    for k in range(run.steps):
        assert np.array_equal(controller.theta, run.theta[k])
        assert np.array_equal(controller.step(run.y[k], run.z[k], u_applied=applied), run.u[k])
        applied = run.u_applied[k]
    assert np.array_equal(controller.theta, run.theta_final)


@given(st.data(), sizes, sizes, sizes, st.floats(1e-3, 1), seeds)
def test_the_covariance_stays_positive_definite(data, l_u, l_y, l_z, size, seed):
    lambda_ = data.draw(st.sampled_from([1.0, 0.9]))
    case, _ = data.draw(cases(l_u, l_y, l_z, update=partial(rn.UD, lambda_=lambda_)))
    controller, rng = rn.Controller(case), np.random.default_rng(seed)
    for _ in range(25):
        controller.step(rng.standard_normal(l_y), size * rng.standard_normal(l_z))
        P = controller.P
        scale = 1 / np.sqrt(np.diag(P))
        correlation = P * scale * scale[:, None]
        assert np.array_equal(P, P.T) and (np.diag(P) > 0).all()
        assert np.linalg.eigvalsh(correlation).min() > -1e-15 * len(P)


def test_a_gradient_step_by_hand():
    """theta = 0, z = 1, phi_f = 2, R_z = 1: half the gradient of (1 + 2 theta)^2 is 2."""
    controller = rn.Controller(
        rn.ControllerSettings(
            structure=rn.fir(1), target=rn.TargetModel([0, 1.0]), update=rn.Gradient(step_size=0.25)
        )
    )
    for y, z in ((2.0, 0.0), (0.0, 0.0), (0.0, 1.0)):
        controller.step(y, z)
    assert controller.theta == pytest.approx([-0.5], abs=1e-15)
