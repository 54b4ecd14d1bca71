"""The digits of a log: what they leave open, and no more, counts as the same u."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory.errors import InputError
from rcac_numeric import ControllerLog, check_controller, iir, replay
from rcac_numeric.arrays._values import replaced as replace
from tests.support.strategies import seeds

pytestmark = pytest.mark.exact_data  # how many digits they have is what is tested

WRITERS = {
    "%.4f": lambda v: float(f"{v:.4f}"),
    "%.2f": lambda v: float(f"{v:.2f}"),
    "%.5g": lambda v: float(f"{v:.5g}"),
    "%.3e": lambda v: float(f"{v:.3e}"),
    "single": lambda v: float(np.float32(v)),
    "float64": float,
}


def rounded(values, writer):
    return np.vectorize(WRITERS[writer], otypes=[float])(values)


def random_log(seed, steps=60, n_c=2, size=1.0):
    """u(k) = Phi(k) theta(k) of random, bounded signals and coefficients that move."""
    rng = np.random.default_rng(seed)
    y = size * rng.standard_normal(steps)
    theta = rng.uniform(-0.4, 0.4, (steps, 2 * n_c))
    u = np.zeros(steps)
    for k in range(steps):
        past_u = [u[k - i] if k >= i else 0.0 for i in range(1, n_c + 1)]
        past_y = [y[k - i] if k >= i else 0.0 for i in range(1, n_c + 1)]
        u[k] = theta[k] @ (past_u + past_y)
    return ControllerLog(u=u, y=y, theta=theta)


@given(seeds, st.sampled_from(sorted(WRITERS)), st.sampled_from([1.0, 30.0]))
def test_a_log_of_any_digits_agrees_and_a_fault_beyond_them_does_not(seed, writer, size):
    log = random_log(seed, size=size)
    written = ControllerLog(
        **{name: rounded(getattr(log, name), writer) for name in ("u", "y", "theta")}
    )
    replayed = replay(written, iir(n_c=2))
    assert replayed.agrees, str(replayed)
    u = written.u.copy()
    # The tolerance is that of the worst step; at another one it may be ten times as large.
    beyond = 4 * max(replayed.tolerance, 1e-9)
    u[40] += beyond * max(np.abs(u).max(), 1.0) * (1 + 4 * 0.4 * 4)
    faulty = replay(ControllerLog(u=u, y=written.y, theta=written.theta), iir(n_c=2))
    assert not faulty.agrees


@given(seeds)
def test_the_more_digits_the_less_is_left_open(seed):
    log = random_log(seed)
    tolerances = []
    for writer in ("%.2f", "%.4f", "single", "float64"):
        written = {name: rounded(getattr(log, name), writer) for name in ("u", "y", "theta")}
        tolerances.append(replay(ControllerLog(**written), iir(n_c=2)).tolerance)
    assert tolerances == sorted(tolerances, reverse=True)
    assert tolerances[-1] < 1.001e-9 and 1e-5 < tolerances[1] < 1e-2


def exploding_log(seed, digits, steps=40):
    """u grows to 1e13, and the terms that it is the sum of exceed it by up to 1e6."""
    rng = np.random.default_rng(seed)
    u, y = np.zeros(steps), rng.standard_normal(steps) * 2.1 ** np.arange(steps)
    theta = np.zeros((steps, 2))
    for k in range(1, steps):
        past = np.array([u[k - 1], y[k - 1]])
        across = np.array([-past[1], past[0]]) / np.hypot(*past)
        wanted = past * (y[k] / (past @ past))
        theta[k] = [float(f"{v:.{digits}g}") for v in wanted + across * 10 ** rng.uniform(0, 6)]
        u[k] = float(f"{theta[k] @ past:.{digits}g}")
    return ControllerLog(u=u, y=y, theta=theta)


@given(seeds, st.sampled_from([13, 15, 17]), st.integers(1, 39))
def test_a_fault_is_seen_at_any_step_of_a_log_that_explodes(seed, digits, k):
    """Neither the later u nor the terms of u, which cancel, are the measure of a step."""
    log = exploding_log(seed, digits)
    assert (replayed := replay(log, iir(n_c=1))).agrees, str(replayed)
    u = log.u.copy()
    u[k] += 1e-3 * np.abs(u[: k + 1]).max()
    faulty = replay(replace(log, u=u), iir(n_c=1))
    assert not faulty.agrees and faulty.worst_step >= k


def test_the_report_says_what_is_allowed_and_the_option_decides():
    log = random_log(1)
    written = ControllerLog(
        **{name: rounded(getattr(log, name), "%.4f") for name in ("u", "y", "theta")}
    )
    replayed = replay(written, iir(n_c=2))
    assert "u to 4 decimals, y to 4 decimals, theta to 4 decimals" in str(replayed)
    assert not replay(written, iir(n_c=2), tolerance=1e-12).agrees
    check = check_controller(written, structure=iir(n_c=2), tolerance=1e-12)
    assert not check.is_consistent and "tolerance 1e-12" in check.report()
    with pytest.raises(InputError, match="tolerance"):
        replay(written, iir(n_c=2), tolerance=0.0)


def test_a_log_is_what_it_holds():
    log = random_log(3)
    assert pickle.loads(pickle.dumps(log)) == log == replace(log)
    other = replace(log, y=log.y + 1)
    assert other != log and other.source == log.source
    assert hash(log) == hash(replace(log))
