"""What watches a controller: it changes nothing where all is well, and acts where it is not."""

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory.errors import DivergedError, InputError
from rcac_numeric import (
    UD,
    CappedForgetting,
    Compensator,
    Controller,
    ControllerSettings,
    Covariance,
    Saturation,
    SavedState,
    SimulationCase,
    Supervision,
    SupervisionWarning,
    TargetModel,
    fir,
    fir_target,
    iir,
    pid,
    simulate,
    simulate_many,
    standard_plant,
)
from tests.support.engine_cases import cases, engine_plants

PLANT = standard_plant("1/(q - 0.9)")
LAG = 0.9
QUIET = 8000  # lambda = 0.9 takes P from 1 beyond float64 in 6738 steps


def settings_of(lambda_=0.9, update=UD, R_theta=1.0, **others):
    return ControllerSettings(
        structure=iir(n_c=2), target=fir_target(PLANT), update=update(R_theta, lambda_=lambda_),
        **others,
    )  # fmt: skip


def driven(controller, steps, noise=0.0, x=0.0, seed=1):
    """u and x of the lag plant under a controller, step by step."""
    rng, us, xs = np.random.default_rng(seed), [], []
    for _ in range(steps):
        (u,) = controller.step(x, x)
        us.append(float(u))
        xs.append(x)
        x = LAG * x + float(u) + noise * rng.standard_normal()
    return np.array(us), np.array(xs), x


def unwarned(call):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SupervisionWarning)
        return call()


@given(st.data())
def test_the_mildest_policy_changes_nothing(data):
    settings, _ = data.draw(cases(1, 1, 1))
    plant = data.draw(engine_plants(1, 1, 1))
    w = np.random.default_rng(0).standard_normal((60, plant.l_w))
    plain = simulate(plant, settings, w, supervision=Supervision("off"))
    watched = simulate(plant, settings, w)
    for name in ("u", "y", "z", "theta", "theta_final"):
        assert np.array_equal(getattr(plain, name), getattr(watched, name))
    assert plain.outcome == watched.outcome


def test_a_wound_up_controller_says_so_once_and_survives_its_own_overflow():
    """The review's finding on a device: step raised, and the plant had no control."""
    controller = Controller(settings_of())
    with pytest.warns(SupervisionWarning) as message:
        _, _, x = driven(controller, 300, noise=1.0)
        looks = {}
        for _ in range(QUIET):
            (u,) = controller.step(x, x)
            looks[controller.k] = controller.theta
            x = LAG * x + float(u)
            assert np.isfinite(u)
    assert [str(one.message).split(":")[1].split()[0] for one in message] == ["windup", "overflow"]
    record = controller.record
    assert record.troubles["windup"].worst > 1e300 and record.troubles["overflow"].episodes == 1
    assert 300 < record.troubles["windup"].first < 300 + 132 + 32  # 0.9^-132 is above 1e6
    before = looks[record.troubles["windup"].first + 1 - 16]  # the last look without trouble
    assert np.array_equal(controller.theta, before)
    off = Controller(settings_of(), Supervision("off"))
    with pytest.raises(DivergedError):
        driven(off, 300 + QUIET, noise=0.0, x=1.0)


@pytest.mark.parametrize("update", [UD, Covariance])
@pytest.mark.parametrize("policy", ["freeze", "bound", "reset"])
def test_a_policy_keeps_the_next_disturbance_small(policy, update):
    """With the growth left alone the same kick reaches 1e5 times as much."""
    peaks = {}
    for name, supervision in (("none", Supervision()), ("acts", Supervision(policy, growth=10))):
        controller = Controller(settings_of(update=update), supervision)
        _, _, x = driven(controller, 200, noise=1.0)
        _, _, x = unwarned(lambda c=controller, x=x: driven(c, 1000, x=x))
        _, xs, _ = unwarned(lambda c=controller, x=x: driven(c, 60, noise=0.01, x=x, seed=2))
        peaks[name] = np.abs(xs).max()
    assert peaks["acts"] < 0.2
    assert peaks["none"] > 2 * peaks["acts"]
    done = {"freeze": "frozen", "bound": "bounded", "reset": "reset"}[policy]
    assert controller.record.troubles[done].steps > 0
    if policy == "bound" and update is Covariance:  # and what grows between two looks
        assert (np.diag(controller.P) <= 10 * 0.9**-16 * 1.01).all()
    if policy == "freeze":
        assert controller.record.is_frozen
        controller.resume()
        assert not controller.record.is_frozen


@pytest.mark.parametrize("update", [UD, Covariance])
@pytest.mark.parametrize("excited", [0, 1])
def test_growth_is_that_of_the_variance_without_excitation(update, excited):
    """R_theta is diagonal: P of the measurement that stays 0 is divided by lambda at every step."""
    settings = ControllerSettings(
        structure=fir(1, l_y=2), target=TargetModel([0.0, 1.0]),
        update=update(np.diag([1.0, 4.0]), lambda_=0.9),
    )  # fmt: skip
    controller, rng = Controller(settings), np.random.default_rng(excited)
    for _ in range(40):
        controller.step(np.eye(2)[excited] * rng.standard_normal(), rng.standard_normal())
    # The last look is that of step 32, after 31 updates.
    assert controller.record.growth == pytest.approx(0.9**-31, rel=1e-12)


def test_a_policy_acts_in_a_run_too():
    w = np.zeros((1500, 1))
    w[:200, 0] = np.random.default_rng(3).standard_normal(200)
    run = simulate(PLANT, settings_of(), w, supervision=Supervision("bound", growth=1.0))
    assert run.supervision.troubles["bounded"].steps > 0
    assert run.supervision.growth < 0.9**-16 * 1.001  # what may grow between two looks
    noted = simulate(PLANT, settings_of(), w).supervision
    assert noted.troubles["windup"].steps > 0 and "bounded" not in noted.troubles


@pytest.mark.parametrize("y", [np.nan, np.inf, [np.nan], np.float32("nan")])
def test_a_missed_sample_moves_k_holds_u_and_is_counted(y):
    controller = Controller(settings_of(1.0))
    us, _, x = driven(controller, 50, noise=1.0)
    theta = controller.theta
    for number in range(1, 4):
        assert controller.step(y, y)[0] == us[-1]
        assert controller.k == 50 + number and np.array_equal(controller.theta, theta)
    assert controller.record.troubles["missed sample"].steps == 3
    assert controller.record.troubles["missed sample"].episodes == 1
    controller.step(x, np.nan)  # y is known: u is Phi theta again, theta waits
    assert np.array_equal(controller.theta, theta)
    controller.step(x, x)
    assert not np.array_equal(controller.theta, theta)


def test_a_loop_with_gaps_and_jumps_stays_bounded_and_is_restored_bit_for_bit(tmp_path):
    rng = np.random.default_rng(7)
    settings = settings_of(CappedForgetting(0.999), R_theta=1e-2)
    controller, x = Controller(settings, Supervision(jump=30)), 0.0
    missed = jumps = 0
    for k in range(20_000):
        y = x
        if k >= 100 and rng.random() < 0.02:
            y = np.nan
        elif k >= 100 and rng.random() < 0.001:
            y = x + 1e6 * rng.standard_normal()
        if k == 12_345:
            controller.state.save(tmp_path / "state.npz")
            other = Controller(settings, Supervision(jump=30))
            other.restore(SavedState.load(tmp_path / "state.npz"))
        (u,) = controller.step(y, y)
        if k >= 12_345:
            assert other.step(y, y)[0] == u
        missed += not np.isfinite(y)
        jumps += bool(np.isfinite(y) and abs(y - x) > 1e3)
        x = LAG * x + float(u) + 0.1 * rng.standard_normal()
        assert abs(x) < 10
    troubles = controller.record.troubles
    assert troubles["jump"].steps == jumps > 5
    assert troubles["missed sample"].steps == missed + jumps
    assert other.record == controller.record and other.state == controller.state


def test_the_fallback_takes_over_and_gives_back_without_a_bump():
    """By limit: a kick beyond 50 is nothing for RCAC to learn from."""
    proportional = Compensator(np.zeros((0, 1, 1)), [[[-0.5]]])
    supervision = Supervision("fallback", limit=50.0, fallback=proportional, fade=0.8)
    settings = ControllerSettings(structure=pid("PI"), target=fir_target(PLANT), update=UD(1.0))
    controller = Controller(settings, supervision)
    _, _, x = driven(controller, 100, noise=0.1)
    x += 100.0
    u = float(controller.step(x, x)[0])  # z is seen after u was made
    assert controller.record.in_fallback
    x = LAG * x + u
    before, bump = u, None
    for i in range(30):
        u = float(controller.step(x, x)[0])
        if bump is None:
            assert u == pytest.approx(before, rel=1e-12)
            bump = before + 0.5 * x
        assert u == pytest.approx(-0.5 * x + 0.8**i * bump, rel=1e-9, abs=1e-9)
        x = LAG * x + u
    theta = controller.theta
    controller.resume()
    again = float(controller.step(x, x)[0])
    assert again == pytest.approx(u, rel=1e-12, abs=1e-12)
    assert not controller.record.in_fallback
    _, xs, _ = driven(controller, 200, noise=0.1, x=LAG * x + again)
    assert np.abs(xs[100:]).max() < 5 and not np.array_equal(controller.theta, theta)


def test_a_fallback_makes_u_where_samples_are_missed():
    proportional = Compensator(np.zeros((0, 1, 1)), [[[-0.5]]])
    supervision = Supervision(fallback=proportional, missed="fallback", fade=0.0)
    controller = Controller(settings_of(1.0), supervision)
    us, _, _ = driven(controller, 50, noise=1.0)
    first = float(controller.step(np.nan, np.nan)[0])
    assert first == pytest.approx(us[-1])  # no bump
    assert not controller.record.in_fallback


def test_saturation_is_noted_after_a_while():
    run = simulate(
        PLANT, settings_of(1.0), 10 * np.ones((400, 1)), saturation=Saturation(low=-0.1, high=0.1),
        supervision=Supervision(patience=50),
    )  # fmt: skip
    assert run.supervision.troubles["saturated"].episodes == 1
    free = simulate(
        PLANT, settings_of(1.0), np.ones((400, 1)), saturation=Saturation(low=-99, high=99)
    )
    assert "saturated" not in free.supervision.troubles


def test_lanes_note_what_the_ordinary_loop_notes():
    w = np.zeros((700, 1))
    w[:100, 0] = np.random.default_rng(3).standard_normal(100)
    runs = [SimulationCase(PLANT, settings_of(), w[: 400 + 37 * i]) for i in range(8)]
    for one, other in zip(simulate_many(runs), simulate_many(runs, lanes=True), strict=True):
        assert (
            [(e.step, e.kind) for e in one.supervision.events]
            == [(e.step, e.kind) for e in other.supervision.events]
            != []
        )
        assert other.supervision.growth == pytest.approx(one.supervision.growth, rel=1e-6)


def test_a_cut_run_notes_what_the_whole_one_notes():
    w = np.zeros((700, 1))
    w[:100, 0] = np.random.default_rng(3).standard_normal(100)
    whole = simulate(PLANT, settings_of(), w)
    first = simulate(PLANT, settings_of(), w[:333])
    rest = simulate(PLANT, settings_of(), w[333:], start=first.state)
    assert rest.supervision == whole.supervision and rest.state == whole.state
    with pytest.raises(InputError, match="other settings"):
        simulate(PLANT, settings_of(), w, start=first.state, supervision=Supervision("bound"))


# Forgetting with a cap.


def factors(P):
    """P = U diag(d) U' with U unit upper triangular, from the Cholesky factor of P turned over."""
    L = np.linalg.cholesky(P[::-1, ::-1])[::-1, ::-1]
    return L / np.diag(L), np.diag(L) ** 2


@given(seed=st.integers(0, 2**32 - 1), lambda_=st.floats(0.7, 1.0), R_theta=st.floats(0.1, 10.0))
def test_capped_forgetting_is_its_formula(seed, lambda_, R_theta):
    """(2.42)-(2.45) on full matrices, with the cap on the factors of P / lambda."""
    w = np.random.default_rng(seed).standard_normal((60, 1))
    w[20:40] = 0.0
    run = simulate(PLANT, settings_of(CappedForgetting(lambda_), R_theta=R_theta), w)
    theta, P, u, y = np.zeros(4), np.eye(4) / R_theta, run.u[:, 0], run.y[:, 0]
    for k in range(2, 60):
        assert np.allclose(run.theta[k], theta, rtol=1e-7, atol=1e-9)
        past = [u[k - 2], u[k - 3] if k > 2 else 0.0, y[k - 2], y[k - 3] if k > 2 else 0.0]
        phi_f = np.array(past)  # G_f = 1/q
        gain = P @ phi_f / (lambda_ + phi_f @ P @ phi_f)
        theta = theta - gain * (run.z[k, 0] - u[k - 1] + phi_f @ theta)
        P = (P - np.outer(gain, phi_f @ P)) / lambda_
        U, d = factors((P + P.T) / 2)
        P = (U * np.minimum(d, 1 / R_theta)) @ U.T


def test_the_cap_holds_where_nothing_is_excited():
    controller = Controller(settings_of(CappedForgetting(0.9), R_theta=0.5))
    _, _, x = driven(controller, 200, noise=1.0)
    _, _, x = driven(controller, 20_000, x=x)
    assert controller.record.growth <= 1.0 and not controller.record.troubles
    _, xs, _ = driven(controller, 100, noise=0.01, x=x, seed=5)
    assert np.abs(xs).max() < 0.2


@pytest.mark.parametrize("update", [UD, Covariance])
def test_a_theta_that_leaves_float64_beside_a_finite_P_is_restored(update):
    """The first gain is about 1000: one z of 1e308 moves theta out of float64, and not P."""
    controller = Controller(settings_of(update=update, R_theta=1e-10, lambda_=1.0))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for k in range(12):
            controller.step(y=1e-3, z=1e308 if k == 8 else 1e-3)
            assert np.isfinite(controller.theta).all() and np.isfinite(controller.P).all()
    assert controller.record.troubles["overflow"].first == 8


def test_what_is_no_supervision_is_refused():
    with pytest.raises(InputError, match="needs a compensator"):
        Supervision("fallback")
    with pytest.raises(InputError, match="below 1"):
        Supervision(growth=0.5)
    with pytest.raises(InputError, match="fade"):
        Supervision(fade=1.0)
    with pytest.raises(InputError, match="3 inputs and 1 outputs"):
        Controller(
            settings_of(), Supervision(fallback=Compensator(np.zeros((0, 1, 1)), [[[1, 2, 3.0]]]))
        )
    with pytest.raises(InputError, match="use UD"):
        Covariance(1.0, lambda_=CappedForgetting(0.9))
    with pytest.raises(InputError, match="supervision"):
        Controller(settings_of(), "warn")
    with pytest.raises(InputError, match="fade"):
        Controller(settings_of()).take_over(0.0, fade=1.0)


def test_target_models_change_under_supervision():
    controller = Controller(settings_of(1.0), Supervision("bound"))
    driven(controller, 60, noise=1.0)
    controller.set_target(TargetModel([0.0, 1.0, 0.1]))
    driven(controller, 60, noise=1.0)
    assert not controller.record.troubles
