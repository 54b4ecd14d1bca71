"""A PI or PID controller by Skogestad's rules, from poles and zeros: no model reduction by fit."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from compensator_theory.errors import NoSolutionError
from rcac_numeric.arrays._array_types import ComplexArray
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._kinds import pid
from rcac_numeric.designing._plants import DesignPlant, continuous_of
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants.gallery._zeros import plant_zeros

DAMPED = 0.5  # least damping of a pair that counts as two lags
HOLD_DELAY = (
    1.5  # steps: half of the hold, and the step by which a strictly proper controller is late
)
STILL = 1e-7  # 1/step: a pole this slow is an integrator
ROUNDS = 20  # the rules for zeros ask for tau_c, which follows from them


def simc(plant: DesignPlant, *, derivative: bool | None = None) -> FixedController:
    """The SIMC tuning with tau_c = theta, of e = r - y_0 - v, strictly proper.

    K_c = tau_1 / (k (tau_c + theta)), tau_I = min(tau_1, 4 (tau_c + theta)), tau_D = tau_2 in
    series form, where the half rule gives k, tau_1, tau_2 and theta.

    Notes
    -----
    Source: S. Skogestad, Journal of Process Control 13 (2003) 291-309: (10)-(11), (23)-(25), and
    for zeros (14), (30)-(33). A zero in the left half plane goes with the next longer lag, and
    where there is none with the next shorter one.
    """
    if plant.m > 1:
        raise NoSolutionError("the rules are for one input and one output.")
    continuous = continuous_of(plant)
    if continuous is None:
        raise NoSolutionError(
            "its rules are for plants in continuous time, and the sampled plant comes from none."
        )
    A, B = continuous
    C = plant.C[:, : len(A)]
    poles, zeros = np.linalg.eigvals(A) + 0j, plant_zeros(Plant(A, B, B, C))
    at = 1.0 + 1.0j  # anywhere but at a pole or a zero
    response = (C @ np.linalg.solve(at * np.eye(len(A)) - A, B)).item()
    gain = response * np.prod(at - poles) / np.prod(at - zeros)
    gain = gain * np.prod(-zeros) / np.prod(-poles[np.abs(poles) > STILL])
    if not abs(gain) > STILL * abs(response):
        raise NoSolutionError("the plant has a zero at rest, where its gain is 0.")
    late = plant.delay + plant.fraction + HOLD_DELAY
    theta, model = late, (0.0, 0.0, 0.0, False)
    for _ in range(ROUNDS):
        k, lags, later = _without_zeros(gain.real, _lags(list(poles)), zeros, theta)
        theta, *model = _reduced(k, lags, late + later, derivative)  # type: ignore[assignment]
    k, tau_1, tau_2, derives = model
    K_c = (tau_1 if np.isfinite(tau_1) else 1.0) / (k * 2 * theta)
    tau_I = min(tau_1, 8 * theta)
    gains = [K_c * (1 + tau_2 / tau_I), K_c / tau_I, K_c * tau_2]
    structure = pid("PID" if derives else "PI")
    return FixedController(structure.compensator(gains[: 3 if derives else 2]))


def _reduced(
    k: float, lags: list[float], late: float, derivative: bool | None
) -> tuple[float, float, float, float, bool]:
    """(theta, k, tau_1, tau_2, whether tau_2 is used) by the half rule."""
    first, second, third, *rest = *sorted(lags, reverse=True), 0.0, 0.0, 0.0
    if not np.isfinite(second):
        raise NoSolutionError("its two integrators need more than a PI controller.")
    late += sum(rest)
    theta = late + third / 2
    if second > theta if derivative is None else derivative:
        return theta, k, first, second + third / 2, True
    return late + second / 2 + third, k, first + second / 2, 0.0, False


def _without_zeros(
    k: float, lags: list[float], zeros: ComplexArray, tau_c: float
) -> tuple[float, list[float], float]:
    """Absorb the zeros into gain, lags and dead time."""
    late = 0.0
    for zero in zeros:
        T = float(1 / max(np.abs(zero), 1e-12))
        if zero.real > 0:
            late += T
            continue
        finite = [i for i, lag in enumerate(lags) if 0 < lag < np.inf]
        longer = [i for i in finite if lags[i] >= T]
        if not finite:
            raise NoSolutionError("it has a zero, and no lag beside its integrator.")
        at = min(longer, key=lambda i: lags[i]) if longer else max(finite, key=lambda i: lags[i])
        tau = lags[at]
        if not longer:  # T1, T1a, T1b
            k, lags[at] = k * (max(T, tau_c) / max(tau, tau_c)), 0.0
        elif 5 * tau_c <= T:  # T2
            k, lags[at] = k * T / tau, 0.0
        else:  # T3
            shorter = min(tau, 5 * tau_c)
            k, lags[at] = k * shorter / tau, shorter - T
    return k, lags, late


def _lags(poles: Iterable[complex]) -> list[float]:
    """The time constants in steps, infinite for an integrator."""
    lags = []
    for pole in poles:
        size = abs(pole)
        if size <= STILL:
            lags.append(np.inf)
        elif pole.real > 0:
            raise NoSolutionError("the plant is unstable.")
        elif abs(pole.imag) > 1e-9 * size and -pole.real < DAMPED * size:
            damping = -pole.real / size
            raise NoSolutionError(f"the plant oscillates, with a damping of {damping:.2g}.")
        else:
            lags.append(1 / size)
    return lags
