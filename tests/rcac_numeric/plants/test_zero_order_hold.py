"""Sampling bounds the spectrum, not the norm: stiff plants and Pade delays against 150 digits."""

import control
import mpmath
import numpy as np
import pytest

from compensator_theory import InputError
from rcac_numeric import design, plant_of
from rcac_numeric.plants._zero_order_hold import zero_order_hold

pytestmark = pytest.mark.exact_data


def by_mpmath(A, B, h):
    """exp(h [A B; 0 0]) with 150 digits, each entry rounded once."""
    n, m = np.shape(B)
    with mpmath.workdps(150):
        rows = mpmath.zeros(n + m)
        for i in range(n):
            for j, entry in enumerate([*A[i], *B[i]]):
                rows[i, j] = mpmath.mpf(repr(float(entry))) * mpmath.mpf(repr(float(h)))
        # Scaled down by more than any norm here, and squared back.
        result = mpmath.expm(rows / 2**60, method="taylor")
        for _ in range(60):
            result = result * result
        return np.array([[float(result[i, j]) for j in range(n + m)] for i in range(n)])


def matrices(transfer_function):
    built = control.ss(transfer_function)
    return built.A, built.B


def pade(late, order):
    return control.tf([1], [1, 1]) * control.tf(*control.pade(late, order))


CASES = {
    **{
        f"time constants of 1 s and {tau:g} s": ([[-1 / tau, 0], [1, -1]], [[1 / tau], [0]], 1.0)
        for tau in (2e-3, 1e-5, 1e-8)
    },
    **{
        f"a delay of {late:g} s by Pade {order}": (*matrices(pade(late, order)), late / 10)
        for late, order in ((0.1, 3), (1.0, 4), (0.01, 5))
    },
    "a resonance of 1000 rad/s": ([[0, 1], [-1e6, -10]], [[0], [1e6]], 1.0),
    "an integrator behind a capacitor": ([[-1e9, 0], [1, 0]], [[1e9], [0]], 1e-3),
    "a growing mode": ([[600.0, 1e5], [0, -1e5]], [[0], [1]], 1.0),
}


@pytest.mark.parametrize("name", CASES)
def test_each_entry_is_the_nearest_to_the_true_one(name):
    A, B, h = CASES[name]
    A, B = np.asarray(A, dtype=float), np.asarray(B, dtype=float)
    assert np.hstack(zero_order_hold(A, B, h)).tolist() == by_mpmath(A, B, h).tolist()


def test_a_fast_actuator_on_a_slow_process_is_sampled_and_designed_for():
    plant = plant_of("1/((0.002*s + 1)*(s + 1))", sample_time=1.0)
    oracle = control.c2d(control.ss([[-500, 0], [1, -1]], [[500], [0]], [[0, 1]], 0), 1.0)
    h = [(plant.C @ np.linalg.matrix_power(plant.A, k) @ plant.B).item() for k in range(5)]
    ours = [(oracle.C @ np.linalg.matrix_power(oracle.A, k) @ oracle.B).item() for k in range(5)]
    assert np.allclose(h, ours, rtol=1e-12, atol=0)
    designed = design(
        "2/((10*s + 1)*(0.0001*s + 1))", sample_time=1.0, disturbance=0.1, noise=0.01, seeds=1,
        steps=200,
    )  # fmt: skip
    assert designed.plant.sample_time == 1.0


@pytest.mark.parametrize("rate", [720.0, 1e300])
def test_what_grows_beyond_float64_is_refused_with_its_rate(rate):
    with pytest.raises(InputError, match=r"the fastest growing mode of A is (720|1e\+300) per sec"):
        zero_order_hold([[rate]], [[1.0]], 1.0)
    A_D, B_D = zero_order_hold([[-rate]], [[1.0]], 1.0)
    assert A_D.item() == 0.0 if rate > 720 else 0.0 < A_D.item() < 1e-300
    assert B_D.item() == 1 / rate
