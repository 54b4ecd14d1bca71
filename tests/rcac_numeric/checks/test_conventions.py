"""A log of another program: the convention by which it is u = Phi theta, and no other."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from compensator_theory.errors import InputError
from rcac_numeric import ControllerLog, check_controller, fir, iir, loop_health, replay
from rcac_numeric import standard_plant as standard
from rcac_numeric.checks._conventions import WORDS, convention_of, orders
from tests.support.strategies import seeds

pytestmark = pytest.mark.exact_data  # the digits of the log are part of what is tested

N_C = 2
# The words of --convention, and what the program that is simulated does.
KINDS = {
    "ours": {},
    "-y": {"sign_y": -1},
    "-u": {"sign_u": -1},
    "-u, -y": {"sign_u": -1, "sign_y": -1},
    "y first": {"order": (3, 4, 1, 2)},
    "-y, y first": {"sign_y": -1, "order": (3, 4, 1, 2)},
    "interleaved": {"order": (1, 3, 2, 4)},
    "y first, interleaved": {"order": (3, 1, 4, 2)},
    "oldest first": {"order": (2, 1, 4, 3)},
    "z for y": {"reads": "z"},
    "-y, z for y": {"reads": "z", "sign_y": -1},
    "r - y for y": {"reads": "r - y"},
    "r + y for y": {"reads": "r + y"},
}
LIMITED = {"ours": "applied", "own u": "computed"}
WRITERS = {
    "float64": float,
    "%.6g": lambda v: float(f"{v:.6g}"),
    "%.9g": lambda v: float(f"{v:.9g}"),
    "%.6f": lambda v: float(f"{v:.6f}"),
}


def program(seed, *, sign_u=1, sign_y=1, order=(1, 2, 3, 4), reads="y", limit=np.inf,
            past="applied", logs="applied", dtype=float, steps=160):  # fmt: skip
    """The loop of another program, written out coefficient by coefficient; nothing is shared."""
    rng = np.random.default_rng(seed)
    ends = rng.choice((-1, 1), 4) * rng.uniform([0.1, 0.1, 0.4, 0.4], [0.3, 0.3, 0.7, 0.7])
    moves = 1 + 0.3 * rng.standard_normal((steps, 4)) * np.exp(-np.arange(steps) / 50)[:, None]
    P1, P2, Q1, Q2 = (ends * moves).astype(dtype).T
    r = np.where(np.arange(steps) % 40 < 20, 1.0, -0.5).astype(dtype)
    y, z = rng.standard_normal((2, steps)).astype(dtype)
    read = {"y": y, "z": z, "r - y": r - y, "r + y": r + y}[reads]
    applied, computed = np.zeros(steps, dtype), np.zeros(steps, dtype)
    memory = {"applied": applied, "computed": computed}
    for k in range(N_C, steps):
        u, v = memory[past], read
        old = P1[k] * u[k - 1] + P2[k] * u[k - 2]
        new = Q1[k] * v[k - 1] + Q2[k] * v[k - 2]
        computed[k] = dtype(sign_u) * old + dtype(sign_y) * new
        applied[k] = np.clip(computed[k], -dtype(limit), dtype(limit))
    columns = dict(enumerate((P1, P2, Q1, Q2), 1))
    theta = np.column_stack([columns[i] for i in order])
    signals = {"u": memory[logs], "y": y, "z": z, "r": r, "theta": theta}
    return {name: np.asarray(values, float) for name, values in signals.items()}


def checked(signals, writer="float64", **options):
    write = np.vectorize(WRITERS[writer], otypes=[float])
    log = ControllerLog(**{name: write(values) for name, values in signals.items()})
    return check_controller(log, structure=iir(N_C), **options)


formats = st.sampled_from(sorted(WRITERS))
precisions = st.sampled_from([np.float64, np.float32])


@pytest.mark.costly
@given(seeds, st.sampled_from(sorted(KINDS)), formats, precisions, st.sampled_from([0, 1, -1]))
@settings(max_examples=30)
def test_the_convention_is_named_and_the_option_reads_it(seed, words, writer, dtype, shift):
    signals = program(seed, dtype=dtype, **KINDS[words])
    rows = np.clip(np.arange(len(signals["u"])) + shift, 0, len(signals["u"]) - 1)
    signals["theta"] = signals["theta"][rows]
    check = checked(signals, writer)
    if words == "ours":
        assert check.is_consistent and check.replay.shift == shift and check.conventions is None
        return
    assert not check.is_consistent and "another convention" in check.report().splitlines()[1]
    (match,) = check.conventions.matches
    assert str(match.convention) == words and match.replay.shift == shift
    assert checked(signals, writer, convention=words).is_consistent


@pytest.mark.costly
@given(seeds, st.sampled_from(sorted(KINDS)), formats, precisions, st.integers(0, 3))
@settings(max_examples=30)
def test_a_coefficient_off_by_a_thousandth_replays_by_no_convention(
    seed, words, writer, dtype, index
):
    signals = program(seed, dtype=dtype, **KINDS[words])
    signals["theta"][:, index] *= 1.001
    check = checked(signals, writer)
    assert not check.is_consistent and check.conventions.matches == ()
    assert "under any of" in check.report().splitlines()[1]


@pytest.mark.costly
@given(seeds, st.sampled_from(sorted(LIMITED)), formats, precisions)
@settings(max_examples=15)
def test_limits_of_u_are_recognised(seed, words, writer, dtype):
    signals = program(seed, limit=0.5, past=LIMITED[words], dtype=dtype)
    (match,) = checked(signals, writer).conventions.matches
    assert str(match.convention) == words and np.allclose(match.u_limits, (-0.5, 0.5))
    again = checked(signals, writer, convention=words, u_limits=match.u_limits)
    assert again.is_consistent and again.replay.limited > 0


@pytest.mark.costly
@given(seeds, formats, precisions, st.sampled_from([0.5, 0.6180339887]))
@settings(max_examples=15)
def test_u_that_was_logged_before_its_limits_gives_them(seed, writer, dtype, limit):
    signals = program(seed, limit=limit, logs="computed", dtype=dtype)
    (match,) = checked(signals, writer).conventions.matches
    assert str(match.convention) == "ours"
    assert np.allclose(match.u_limits, (-limit, limit), rtol=1e-4)
    again = checked(signals, writer, u_limits=match.u_limits)
    assert again.is_consistent and np.abs(again.log.u).max() <= 1.001 * limit


@given(st.integers(1, 2), st.integers(1, 2), st.integers(1, 3), st.booleans(), st.data())
def test_a_theta_in_another_order_is_ours_after_the_conversion(l_u, l_y, n_c, is_fir, data):
    """Labels in place of coefficients: each stands where our taps say."""
    structure = fir(n_c, l_u, l_y) if is_fir else iir(n_c, l_u, l_y)
    convention = data.draw(st.sampled_from(list(orders(structure))))
    labels = np.arange(structure.l_theta)
    foreign = np.empty_like(labels)
    foreign[convention.positions(structure)] = labels
    assert (convention.theta(foreign, structure) == labels).all()
    assert convention_of(str(convention)) == convention


def test_the_orders_of_two_inputs_are_those_of_matrices():
    """Theta = [P_1 P_2 Q_1 Q_2] of 2 x 2 matrices, by rows and each matrix by rows."""
    structure = iir(2, 2, 2)
    P1, P2, Q1, Q2 = np.arange(16.0).reshape(4, 2, 2)
    ours = np.hstack([P1, P2, Q1, Q2]).T.ravel()
    written = {
        "by rows": np.hstack([P1, P2, Q1, Q2]).ravel(),
        "lags by rows": np.concatenate([m.ravel() for m in (P1, P2, Q1, Q2)]),
        "y first": np.hstack([Q1, Q2, P1, P2]).T.ravel(),
        "interleaved": np.hstack([P1, Q1, P2, Q2]).T.ravel(),
        "oldest first": np.hstack([P2, P1, Q2, Q1]).T.ravel(),
        "by component": np.column_stack(
            [m[:, j] for one in ((P1, P2), (Q1, Q2)) for j in (0, 1) for m in one]
        ).T.ravel(),
    }
    for words, theta in written.items():
        assert (convention_of(words).theta(theta, structure) == ours).all(), words


def test_no_stability_is_claimed_of_a_loop_that_did_not_run():
    signals = program(0, sign_y=-1)
    check = checked(signals, plant=standard("1/(q - 2)"))
    health = loop_health(check)
    assert health.is_stable is None and not health.margins
    assert "unstable" not in {warning.code for warning in health.warnings}
    assert "UNSTABLE" not in check.report() and "Margins" not in check.report()


def test_a_fixed_controller_of_the_other_sign_is_named():
    signals = program(1)
    theta = signals.pop("theta")[-1]
    u, y = np.zeros(160), signals["y"]
    for k in range(N_C, 160):
        u[k] = theta @ [u[k - 1], u[k - 2], y[k - 1], y[k - 2]]
    log = ControllerLog(**{**signals, "u": u})
    compensator = iir(N_C).compensator(theta * [1, 1, -1, -1])
    check = check_controller(log, compensator=compensator, k_w=N_C)
    (match,) = check.conventions.matches
    assert str(match.convention) == "-y" and not check.is_consistent
    assert check_controller(log, compensator=compensator, k_w=N_C, convention="-y").is_consistent
    with pytest.raises(InputError, match="about theta"):
        check_controller(log, compensator=compensator, convention="y first")


def test_two_conventions_that_replay_are_both_named():
    """At rest the order of the lags does not matter: the log does not tell it."""
    y, u = np.full(400, 2.0), np.zeros(400)
    for k in range(2, 400):
        u[k] = 0.2 * u[k - 1] + 0.1 * u[k - 2] - 0.3 * y[k - 1] - 0.2 * y[k - 2]
    check = check_controller(u, y, theta=[0.2, 0.1, 0.3, 0.2], structure=iir(2))
    names = [str(one.convention) for one in check.conventions.matches]
    assert names == ["-y", "-y, oldest first"]
    report = " ".join(check.report().split())
    assert all(f'--convention "{name}"' in report for name in names)


def test_the_sign_of_a_zero_is_no_convention():
    y, u = np.random.default_rng(0).standard_normal(60), np.zeros(60)
    u[1:] = -0.4 * y[:-1]
    check = check_controller(u, y, theta=np.tile([0.0, 0.4], (60, 1)), structure=iir(1))
    (match,) = check.conventions.matches
    assert str(match.convention) == "-y"


@pytest.mark.parametrize("words", ["-x", "y first, sideways", 3])
def test_words_that_are_none_are_refused(words):
    with pytest.raises(InputError, match="convention"):
        convention_of(words)
    with pytest.raises(InputError, match="two words"):
        convention_of("z for y, r - y for y")


def test_a_signal_that_the_log_lacks_is_refused():
    log = ControllerLog(np.ones(9), np.ones(9), theta=np.ones((9, 2)))
    for words in ("z for y", "r - y for y"):
        with pytest.raises(InputError, match=r"no z|no r"):
            replay(log, iir(1), convention=words)
    assert {name for name, _ in WORDS.values()} >= {"negative_y", "signal", "own_u"}


@pytest.mark.parametrize("first", [81, 120])
def test_the_first_step_that_differs_is_named(first):
    """u is 0.1 % off from one step on; y is zero until step 40, where every convention holds."""
    rng = np.random.default_rng(4)
    y, u, theta = (
        rng.standard_normal((160, 1)),
        np.zeros((160, 1)),
        rng.uniform(-0.4, 0.4, (160, 2)),
    )
    y[:40] = 0
    for k in range(1, 160):
        u[k] = (theta[k] @ [u[k - 1, 0], y[k - 1, 0]]) * (1.001 if k >= first else 1)
    check = check_controller(u, y, theta=theta, structure=iir(1))
    assert check.replay.first_difference == first and not check.replay.agrees
    words = str(check.conventions)
    assert words.startswith(f"u = Phi theta holds up to step {first - 1}, and differs first at")
    assert "relative difference" in words


def test_steps_at_rest_show_no_convention():
    """With y = 0 until step 40 every convention holds there; the first difference says nothing."""
    rng = np.random.default_rng(5)
    y, u = rng.standard_normal((160, 1)), 0.1 * rng.standard_normal((160, 1))
    y[:40], u[:40] = 0, 0
    check = check_controller(u, y, theta=rng.uniform(-0.4, 0.4, (160, 2)), structure=iir(1))
    assert check.replay.first_difference == 40 and "under any of" in str(check.conventions)
