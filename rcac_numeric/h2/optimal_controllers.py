"""What two Riccati solutions make: the gain of the innovation, the controller and its cost."""

from __future__ import annotations

import numpy as np

from compensator_theory.errors import ImproperError, InputError
from rcac_numeric.arrays.algebraic_loops import closes
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.h2.noise import NoiseInputs
from rcac_numeric.h2.riccati.solutions import StabilisingSolution
from rcac_numeric.h2.state_space import StateSpace
from rcac_numeric.plants.linear import Plant


def weights(E_1: Array, E_2: Array) -> tuple[Array, Array, Array]:
    """(R_1, R_12, R_2) = (E_1'E_1, E_1'E_2, E_2'E_2), or those of the noise from transposes.

    Raises
    ------
    InputError
        Where a square is beyond float64.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.h2.optimal_controllers import weights
    >>> weights(np.array([[3.0]]), np.array([[2.0]]))
    (array([[9.]]), array([[6.]]), array([[4.]]))
    """
    with np.errstate(over="ignore", invalid="ignore"):
        weights = E_1.T @ E_1, E_1.T @ E_2, E_2.T @ E_2
    if not all(np.isfinite(weight).all() for weight in weights):
        largest = max(np.abs(E).max(initial=0.0) for E in (E_1, E_2))
        raise InputError(
            f"the squares of the entries of E_1, E_2, D_1 or D_2 are beyond float64 (the largest "
            f"entry is {largest:.3g}); scale z and w to like size."
        )
    return weights


def filter_gain(
    plant: Plant, inputs: NoiseInputs, regulator: StabilisingSolution,
    estimator: StabilisingSolution,
) -> Array:  # fmt: skip
    """D_f: the best estimate of C_c x - S^{-1}(E_2'E_0 + B'PD_1) w from the innovation."""
    from_w = -np.linalg.solve(
        regulator.innovation, plant.E_2.T @ inputs.E_0 + plant.B.T @ regulator.P @ inputs.D_1
    )
    correlation = regulator.gain @ estimator.P @ plant.C.T + from_w @ inputs.D_2.T
    return np.asarray(np.linalg.solve(estimator.innovation, correlation.T).T)


def controller_matrices(plant: Plant, C_c: Array, B_c: Array, D_f: Array) -> StateSpace:
    """(A.4) with the direct term; D_0 makes e depend on u, which is solved for u."""
    if not closes(-D_f, plant.D_0):
        raise ImproperError(
            "I + D_f D_0 is singular, so that the filter form is no proper controller of y; use "
            'form = "predictor".'
        )
    loop = np.eye(plant.l_u) + D_f @ plant.D_0
    C = np.asarray(np.linalg.solve(loop, C_c - D_f @ plant.C), dtype=np.float64)
    D = np.asarray(np.linalg.solve(loop, D_f), dtype=np.float64)
    through = plant.B - B_c @ plant.D_0
    return plant.A - B_c @ plant.C + through @ C, B_c + through @ D, C, D


def cost_of_solutions(
    inputs: NoiseInputs, regulator: StabilisingSolution, estimator: StabilisingSolution, D_f: Array
) -> float:
    """tr(P V_1) + tr(S C_c Q C_c') + tr(E_0 E_0') - tr(S D_f V D_f')."""
    S, V = regulator.innovation, estimator.innovation
    K, Q = regulator.gain, estimator.P
    return float(
        np.trace(inputs.D_1.T @ regulator.P @ inputs.D_1)
        + np.trace(S @ K @ Q @ K.T)
        + np.sum(inputs.E_0**2)
        - np.trace(S @ D_f @ V @ D_f.T)
    )
