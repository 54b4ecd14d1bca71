"""Contradictions of a target model and its plant: sign, delay, nonminimum-phase zeros."""

from __future__ import annotations

import numpy as np

from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import require_dense
from rcac_numeric.checks._health import HealthWarning
from rcac_numeric.checks._warnings import Finding, warning_of
from rcac_numeric.plants._linear import Plant
from rcac_numeric.targets._model import TargetModel

TURNED = 1e-6  # a parameter this much smaller than the largest is rounding
LARGEST = 20  # states of a plant whose numerator is computed exactly
NEAR = 0.05  # a zero of G_f this near, relatively, stands for one of the plant


def target_errors(plant: Plant, target: TargetModel) -> tuple[HealthWarning, ...]:
    """The contradictions of G_f and a plant with one u and one z."""
    if (plant.l_u, plant.l_z, target.l_u, target.l_z) != (1, 1, 1, 1):
        return ()
    require_dense(plant.n, "the plant")
    require_dense(target.n_f, "the target model")
    response = _impulse_response(plant)
    errors: list[Finding] = []
    d_zu = _first(response)
    if d_zu is None:
        return ()
    d_f, lead = target.relative_degree, float(target.numerator[target.relative_degree, 0, 0])
    zeros = zeros_of(plant)
    zeros = zeros[np.abs(zeros) > 1 + TURNED]
    if d_f == d_zu and lead * response[d_zu] < 0:
        errors.append(("wrong sign", {"lead": lead, "delay": d_zu, "plant": response[d_zu]}))
    elif d_f != d_zu:
        errors.append(("wrong d_zu", {"delay": d_f, "d_zu": d_zu}))
    modelled = np.roots(target.numerator[d_f:, 0, 0])
    missing = [z for z in zeros if not (np.abs(modelled - z) <= NEAR * np.abs(z)).any()]
    if missing:
        words = ", ".join(f"{z.real:.4g}" if abs(z.imag) < TURNED else f"{z:.4g}" for z in missing)
        errors.append(("unmodelled zero", {"zeros": words}))
    return tuple(map(warning_of, errors))


def _impulse_response(plant: Plant) -> Array:
    state, values = plant.B[:, 0], [float(plant.E_2[0, 0])]
    with np.errstate(all="ignore"):
        for _ in range(plant.n + 1):
            values.append(float(plant.E_1[0] @ state))
            state = plant.A @ state
    return np.array(values)


def _first(response: Array) -> int | None:
    """Index of the first parameter that is not rounding."""
    if not np.isfinite(response).all() or not response.any():
        return None
    return int(np.flatnonzero(np.abs(response) > TURNED * np.abs(response).max())[0])


def zeros_of(plant: Plant) -> ComplexArray:
    """The zeros of a scalar G_zu, from its exact numerator; none of a plant of many states."""
    if plant.n > LARGEST:
        return np.zeros(0, dtype=np.complex128)
    numerator, _ = plant.scalar_map("zu")
    with np.errstate(all="ignore"):
        zeros = np.roots(np.array([float(c) for c in numerator.all_coeffs()]))
    return zeros.astype(np.complex128)
