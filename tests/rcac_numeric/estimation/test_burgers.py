"""A nonlinear fluid as the user's own model: viscous Burgers, with a subsystem no sensor sees.

x_t + (x^2/2)_x = nu x_xx on 20 cells between a driven inlet and a free outlet; in one cell a force
-kappa x acts that the model lacks, and one sensor stands four cells downstream. The model runs
freely: what is not linear in it is a known input of RCMR, computed from the model's own state.
"""

import contextlib

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.signal import lfilter

from compensator_theory import InputError
from rcac_numeric.estimation import RCMR, ModelRefinement

N, H, NU, MEAN, KAPPA = 20, 0.002, 0.05, 1.0, 3.0
DX, CELL, SENSOR = 1 / (N + 1), 8, 12
C_POINT = np.eye(N)[CELL]
NEXT = np.eye(N, k=1)
NEXT[-1, -1] = 1  # beyond the outlet the flow is that of the last cell
CENTRAL = (NEXT - np.eye(N, k=-1)) / (2 * DX)
DIFFUSION = (NEXT - 2 * np.eye(N) + np.eye(N, k=-1)) / DX**2


def forces(x, inlet):
    """All but the unknown force: convection and diffusion."""
    around = np.concatenate([[inlet], x, x[-1:]])
    flux = around**2 / 2
    second = around[2:] - 2 * x + around[:-2]
    return NU * second / DX**2 - (flux[2:] - flux[:-2]) / (2 * DX)


def measured(inlet, kappa):
    """y without RCMR: Euler's rule in plain NumPy."""
    x, y = np.full(N, MEAN), []
    for w in inlet:
        y.append(x[SENSOR])
        x = x + H * (forces(x, w) - kappa * C_POINT * x)
    return np.array(y)


def inlet_of(seed, steps):
    return MEAN + 0.5 * lfilter(
        [0.2], [1, -0.8], np.random.default_rng(seed).standard_normal(steps)
    )


def refined(inlet, y, delays=range(20, 61)):
    """kappa over the steps; the linear part is the flow about MEAN, which H~ is made of."""
    linear = NU * DIFFUSION - MEAN * CENTRAL
    model = RCMR(
        A=np.eye(N) + H * linear, B=-H * C_POINT, D_1=H * np.eye(N), C=np.eye(N)[SENSOR],
        E_1=C_POINT, delays=delays, method="direct", beta=1e4, x_0=np.full(N, MEAN),
    )  # fmt: skip
    refinement, kappa = ModelRefinement(model), []
    for k in range(len(y)):
        x = refinement.x
        (result,) = refinement.step(w=forces(x, inlet[k]) - linear @ x, y=y[k])
        kappa.append(result)
    return np.array(kappa)


def test_the_linear_part_is_the_derivative():
    rest, step = np.full(N, MEAN), 1e-6
    columns = [
        (forces(rest + step * e, MEAN) - forces(rest - step * e, MEAN)) / (2 * step)
        for e in np.eye(N)
    ]
    assert np.allclose(np.array(columns).T, NU * DIFFUSION - MEAN * CENTRAL, atol=1e-6)


def test_the_force_is_found(in_full):
    for seed in range(5 if in_full else 1):
        inlet = inlet_of(seed, 4000)
        kappa = refined(inlet, measured(inlet, KAPPA))
        assert abs(kappa[-1] - KAPPA) < 1e-4 and abs(kappa[2000:] - KAPPA).max() < 0.3


@pytest.mark.costly
def test_with_noise_it_is_the_least_squares_fit_of_the_whole_record():
    """The oracle simulates the record for each kappa, and minimises its error."""
    inlet = inlet_of(0, 4000)
    y = measured(inlet, KAPPA) + 0.01 * np.random.default_rng(7).standard_normal(4000)
    fit = minimize_scalar(
        lambda kappa: ((measured(inlet[:1500], kappa) - y[:1500]) ** 2).sum(),
        bounds=(1, 6), method="bounded", options={"xatol": 1e-3},
    )  # fmt: skip
    assert abs(fit.x - KAPPA) < 0.1
    assert abs(refined(inlet, y)[-500:].mean() - fit.x) < 0.15


def test_one_delay_is_too_few():
    """The force reaches the sensor over many steps; one H_i says too little of its way."""
    inlet, result = inlet_of(0, 4000), [np.nan]
    with contextlib.suppress(InputError):  # the model diverged, and with it its forces
        result = refined(inlet, measured(inlet, KAPPA), delays=(40,))
    assert not abs(result[-1] - KAPPA) < 1
