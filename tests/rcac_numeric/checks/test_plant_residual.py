"""How far a log is from a plant: an identity for the right one, doubt about any other."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from rcac_numeric import (
    UD,
    ControllerLog,
    ControllerSettings,
    FixedController,
    Plant,
    fir_target,
    iir,
    lqg_controller,
    plant_residual,
    servo_plant,
    simulate,
    standard_plant,
)


def response(plant, u, w, x_0):
    """y(k) of the plant, step by step."""
    x, y = x_0, []
    for now, outside in zip(u, w, strict=True):
        y.append(plant.C @ x + plant.D_0 @ now + plant.D_2 @ outside)
        x = plant.A @ x + plant.B @ now + plant.D_1 @ outside
    return np.array(y)


@given(
    st.integers(1, 4), st.integers(1, 2), st.integers(1, 2), st.integers(0, 2),
    st.integers(0, 2**32 - 1),
)  # fmt: skip
def test_nothing_is_left_where_all_of_w_is_known(n, l_u, l_y, l_w, seed):
    """Unstable plants, initial states and direct terms included: Cayley and Hamilton."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    plant = Plant(
        A=A * rng.uniform(0.3, 1.1) / max(abs(np.linalg.eigvals(A))),
        B=rng.standard_normal((n, l_u)), D_1=rng.standard_normal((n, l_w)),
        C=rng.standard_normal((l_y, n)), D_0=rng.standard_normal((l_y, l_u)),
        D_2=rng.standard_normal((l_y, l_w)),
    )  # fmt: skip
    u, w = rng.standard_normal((60, l_u)), rng.standard_normal((60, l_w))
    y = response(plant, u, w, rng.standard_normal(n))
    residual = plant_residual(ControllerLog(u, y, w=w if l_w else None), plant)
    assert residual.rms <= 1e-6 * np.abs(y).max() and not residual.is_doubtful
    assert "fits" in str(residual)


@pytest.mark.parametrize(
    "plant", ["1/(q + 0.5)", "0.2/(q - 0.5)", "1/(q - 0.9)", "q/((q - 0.5)*(q + 0.9))"]
)
def test_another_plant_is_doubted(plant):
    rng = np.random.default_rng(7)
    u, w = rng.standard_normal((400, 1)), 0.05 * rng.standard_normal((400, 1))
    y = response(standard_plant("1/(q - 0.5)"), u, w, np.zeros(1))
    assert not plant_residual(ControllerLog(u, y), standard_plant("1/(q - 0.5)")).is_doubtful
    residual = plant_residual(ControllerLog(u, y), standard_plant(plant))
    assert residual.is_doubtful and "another plant" in str(residual)


@pytest.mark.parametrize("seed", range(5))
def test_white_noise_raises_no_doubt(seed):
    """Through the plant, or at the sensor, as large as what u makes."""
    rng = np.random.default_rng(seed)
    plant = servo_plant("(q - 0.3)/((q - 0.9)*(q - 0.5))")
    u, w = rng.standard_normal((400, 1)), rng.standard_normal((400, 3))
    for block in (1, 2):
        one = w * (np.arange(3) == block)
        y = response(plant, u, one, np.zeros(plant.n))
        assert not plant_residual(ControllerLog(u, y), plant).is_doubtful


@pytest.mark.parametrize(("words", "change"), [
    ("sign", lambda u: -u),
    ("one step later", lambda u: np.vstack([u[1:], u[-1:]])),
    ("one step earlier", lambda u: np.vstack([u[:1], u[:-1]])),
])  # fmt: skip
def test_a_simple_mistake_is_named(words, change):
    rng = np.random.default_rng(3)
    u = rng.standard_normal((300, 1))
    plant = standard_plant("(q - 0.2)/(q*(q - 0.8))")
    y = response(plant, u, 0.01 * rng.standard_normal((300, 1)), np.zeros(2))
    residual = plant_residual(ControllerLog(change(u), y), plant)
    assert residual.is_doubtful and words in residual.remedy and words in str(residual)


def test_the_command_is_known_where_it_was_logged():
    rng = np.random.default_rng(5)
    plant = servo_plant("1/(q - 0.5)")
    u, r = rng.standard_normal((200, 1)), rng.standard_normal((200, 1))
    w = np.hstack([r, np.zeros((200, 2))])
    y = response(plant, u, w, np.zeros(plant.n))
    assert plant_residual(ControllerLog(u, y, r=r), plant).rms <= 1e-12
    assert plant_residual(ControllerLog(u, y), plant).rms > 0.5


def slow_plant(rng, n, factor=1.0, pole=1.0):
    """Real poles that are sampled fast, so that y hardly changes from step to step."""
    V = rng.standard_normal((n, n))
    A = V @ np.diag(rng.uniform(0.5, 0.99) ** rng.uniform(0.3, 3, n)) @ np.linalg.inv(V)
    B, C = rng.standard_normal((n, 1)), rng.standard_normal((1, n))
    return Plant(A=pole * A, B=factor * B, D_1=B, C=C)


@pytest.mark.parametrize("is_logged", [True, False])
@pytest.mark.parametrize(
    "wrong",
    [{"factor": 0.0}, {"factor": -1.0}, {"factor": 1.5}, {"factor": 1.05}, {"pole": 0.97}],
    ids=str,
)
@given(st.integers(1, 4), st.integers(0, 2**32 - 1))
def test_however_little_it_leaves_another_plant_is_doubted_where_a_fit_leaves_nothing(
    is_logged, wrong, n, seed
):
    """All of w is logged, or none acts: what a fitted plant leaves is the yardstick, not y."""
    right = slow_plant(np.random.default_rng(seed), n)
    message = slow_plant(np.random.default_rng(seed), n, **wrong)
    rng = np.random.default_rng([1, seed])
    u = np.cumsum(0.1 * rng.standard_normal((300, 1)), axis=0)
    w = 0.3 * rng.standard_normal((300, 1)) if is_logged else np.zeros((300, 1))
    y = response(right, u, w, np.zeros(n))
    log = ControllerLog(u, y, w=w if is_logged else None)
    assert not plant_residual(log, right).is_doubtful
    residual = plant_residual(log, message)
    assert residual.is_doubtful and "fits the log" not in str(residual)


@given(st.integers(1, 3), st.floats(0.5, 5), st.integers(0, 2**32 - 1))
def test_where_w_is_logged_a_constant_error_counts(n, size, seed):
    """No load that is not in w explains it."""
    plant = slow_plant(np.random.default_rng(seed), n)
    rng = np.random.default_rng([2, seed])
    u, w = rng.standard_normal((100, 1)), rng.standard_normal((100, 1))
    y = response(plant, u, w + size, np.zeros(n))
    known = plant_residual(ControllerLog(u, y, w=w), plant)
    assert known.rms >= known.offset * (1 - 1e-9) and known.is_known
    assert plant_residual(ControllerLog(u, y, w=w + size), plant).rms <= 1e-6 * np.abs(y).max()


def test_a_short_log_says_nothing():
    plant = standard_plant("1/(q - 0.5)")
    assert plant_residual(ControllerLog(np.ones(5), np.ones(5)), plant) is None


@given(st.integers(1, 3), st.floats(0.2, 5), st.integers(0, 2**32 - 1))
def test_a_constant_that_was_not_logged_contradicts_no_plant(n, size, seed):
    """A load at the input and an offset of y leave a constant error, which is said as one."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    plant = Plant(
        A=A * rng.uniform(0.3, 0.9) / max(abs(np.linalg.eigvals(A))),
        B=rng.standard_normal((n, 1)), D_1=rng.standard_normal((n, 1)),
        C=rng.standard_normal((1, n)),
    )  # fmt: skip
    u = rng.standard_normal((80, 1))
    y = response(plant, u, np.full((80, 1), size), rng.standard_normal(n)) + size
    residual = plant_residual(ControllerLog(u, y), plant)
    assert residual.rms <= 1e-6 * np.abs(y).max()
    assert not residual.is_doubtful and not residual.is_contradicted
    if residual.offset > 1e-3:
        assert "a constant" in str(residual)


RIGHT = "(q - 0.3)/((q - 0.9)*(q - 0.5))"
K = np.arange(600)
DISTURBANCES = {
    "tone": lambda rng: np.sin(rng.uniform(0.05, 2) * K),
    "slow tone": lambda rng: 3 * np.sin(0.02 * K + 1),
    "step": lambda rng: 1.0 * (K > 200),
    "ramp": lambda rng: 0.01 * K,
    "square": lambda rng: np.sign(np.sin(0.05 * K)),
    "coloured noise": lambda rng: lfilter([0.3], [1, -0.95], rng.standard_normal(600)),
    "white noise": lambda rng: rng.standard_normal(600),
}


def controllers(plant):
    """A fixed and an adaptive one."""
    yield FixedController(lqg_controller(plant).compensator)
    target = fir_target(plant)
    yield ControllerSettings(structure=iir(2 * plant.n), target=target, update=UD(1e-2))


@pytest.mark.parametrize("disturbance", DISTURBANCES)
@pytest.mark.parametrize("index", range(2))
def test_no_disturbance_that_was_not_logged_contradicts_the_right_plant(disturbance, index):
    """It may raise doubt, as y(k) = y(k-1) may predict better; the words then name both causes."""
    plant = standard_plant(RIGHT)
    for seed in range(4):
        w = DISTURBANCES[disturbance](np.random.default_rng(seed))[:, None]
        run = simulate(plant, list(controllers(plant))[index], w)
        residual = plant_residual(ControllerLog(run.u, run.y), plant)
        assert not residual.is_contradicted and "NOT" not in str(residual)
        assert not residual.is_doubtful or "disturbances act" in str(residual)


@pytest.mark.parametrize("gain", [0.55, 0.66, -0.68])
@pytest.mark.parametrize("command", [np.sin(0.2 * K), 1.0 * (K // 100 % 2)], ids=["tone", "steps"])
def test_a_log_without_disturbance_contradicts_another_gain(gain, command):
    right = servo_plant("0.68/(q - 0.82)")
    run = simulate(right, list(controllers(right))[1], np.outer(command, [1, 0, 0]))
    log = ControllerLog(run.u, run.y, r=run.w[:, :1])
    residual = plant_residual(log, servo_plant(f"{gain}/(q - 0.82)"))
    assert residual.is_contradicted and "NOT" in str(residual)
    assert not plant_residual(log, right).is_doubtful


def test_a_fit_that_explains_nothing_is_no_agreement():
    """u has the wrong sign in 600 of 1500 rows: no fixed model predicts y."""
    plant = standard_plant("0.68/(q - 0.82)")
    u = np.random.default_rng(2).standard_normal((1500, 1))
    y = response(plant, u, np.zeros((1500, 1)), np.zeros(1))
    assert "The plant fits the log" in str(plant_residual(ControllerLog(u, y), plant))
    u[500:1100] *= -1
    residual = plant_residual(ControllerLog(u, y), plant)
    assert not residual.is_contradicted and "agree" not in str(residual)
    assert "neither confirms nor contradicts" in str(residual)


def test_noise_that_leaves_the_plant_visible_is_agreement():
    plant = standard_plant("0.68/(q - 0.82)")
    rng = np.random.default_rng(2)
    u, w = rng.standard_normal((1500, 1)), 0.2 * rng.standard_normal((1500, 1))
    y = response(plant, u, w, np.zeros(1))
    assert "agree within the noise" in str(plant_residual(ControllerLog(u, y), plant))
