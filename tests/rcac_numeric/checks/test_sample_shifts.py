"""Controllers of other programs that read newer samples, written as loops of a script."""

import re

import numpy as np
import pytest

from rcac_numeric import ControllerLog, check_controller, iir, pid

N = 300
LOOPS = [(P, S, M) for P in (0, 1) for S in (0, 1, 2) for M in ("e", "-y", "y")]


def script(newest, sum_to, signal, *, is_adaptive):
    """A PID loop: P and D read e(k - newest), the sum runs up to e(k - sum_to)."""
    rng = np.random.default_rng([newest, sum_to, is_adaptive])
    gains = np.array([0.6, 0.1, 0.2]) + 0.02 * is_adaptive * rng.standard_normal((N, 3))
    r = np.repeat(rng.choice([-1.0, 0.5, 1.0], N // 25), 25)
    u, y, x, e = np.zeros(N), np.zeros(N), 0.0, np.zeros(N + 3)
    for k in range(N):
        y[k] = x + 0.01 * rng.standard_normal()
        e[k] = r[k] - y[k] if signal == "e" else -y[k]
        at = k - newest  # e[-1] to e[-3] are zero
        sums = e[: max(k - sum_to + 1, 0)].sum()
        u[k] = gains[k] @ [e[at], sums, e[at] - e[at - 1]]
        x = 0.9 * x + 0.1 * (u[k] + 0.1)
    theta = gains if signal != "y" else -gains
    return {"u": u, "y": y, "r": r if signal == "e" else None, "theta": theta}


def in_python(words, theta):
    """Do what a message says, with theta of the log."""
    theta = np.array(theta)
    for to, one, other in re.findall(r"theta\(:, (\d)\) = theta\(:, (\d)\) \+ theta\(:, (\d)\);",
                                     words):  # fmt: skip
        theta[:, int(to) - 1] = theta[:, int(one) - 1] + theta[:, int(other) - 1]
    k_c = re.search(r"--k-c (\d)", words)
    convention = re.search(r'--convention "([^"]*)"', words)
    return theta, int(k_c[1]) if k_c else None, convention[1] if convention else None


@pytest.mark.parametrize("is_adaptive", [False, True])
@pytest.mark.parametrize(("newest", "sum_to", "signal"), LOOPS)
def test_a_script_of_a_pid_is_read_as_the_message_says(newest, sum_to, signal, is_adaptive):
    log = script(newest, sum_to, signal, is_adaptive=is_adaptive)
    for k_c in (0, 1):
        check = check_controller(ControllerLog(**log), structure=pid(k_c=k_c))
        shift = check.sample_shift
        is_ours = (newest, sum_to) == (k_c, k_c + 1)  # gamma is one step behind the running sum
        is_read = sum_to - newest in (0, 1)
        assert (shift is not None) == (is_read and not is_ours)
        if shift is None:
            assert check.is_consistent or check.conventions.matches or not is_read
            continue
        words = str(shift)
        assert shift.next_step in " ".join(check.report().split())
        theta, new_k_c, convention = in_python(words, log["theta"])
        again = check_controller(
            ControllerLog(**{**log, "theta": theta}), convention=convention,
            structure=pid(k_c=k_c if new_k_c is None else new_k_c),
        )  # fmt: skip
        assert again.is_consistent
        assert shift.summed == (sum_to == newest) and shift.read == newest - k_c


@pytest.mark.parametrize("l_y", [1, 2])
def test_an_iir_controller_that_reads_the_newest_sample(l_y):
    rng = np.random.default_rng(l_y)
    y, u, theta = (
        rng.standard_normal((N, l_y)),
        np.zeros(N),
        0.2 * rng.standard_normal((N, 2 + 2 * l_y)),
    )
    for k in range(2, N):
        u[k] = theta[k] @ [u[k - 1], u[k - 2], *y[k], *y[k - 1]]
    shift = check_controller(
        ControllerLog(u, y, theta=theta), structure=iir(2, l_y=l_y)
    ).sample_shift
    assert shift.read == -1 and "--k-c 0, after theta has coefficients 0 of y(k - 2)" in str(shift)
    padded = ControllerLog(u, y, theta=np.hstack([theta, np.zeros((N, l_y))]))
    assert check_controller(padded, structure=iir(2, l_y=l_y, k_c=0)).is_consistent


@pytest.mark.parametrize("seed", range(5))
def test_a_controller_that_is_none_has_no_shift(seed):
    rng = np.random.default_rng(seed)
    log = script(0, 0, "e", is_adaptive=False)
    log["u"] = log["u"] + 0.01 * rng.standard_normal(N)
    check = check_controller(ControllerLog(**log), structure=pid())
    assert check.sample_shift is None and not check.is_consistent
