"""The model of RCMR with what it has found in it, and whether an observer sees it."""

from __future__ import annotations

import numpy as np

from compensator_theory.errors import InputError, NotObservableError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.estimation.refinement.settings import RCMR
from rcac_numeric.estimation.refinement.subsystems import FIRSubsystem, RepeatedParameters


def refined_matrices(settings: RCMR, theta: Array) -> tuple[Array, Array]:
    """(A, D_1) of the model with theta in it.

    A + B N_0 E_1 for a static proper subsystem, A + sum theta_j A_j and D_1 + sum theta_j D_j for
    repeated parameters.

    Parameters
    ----------
    settings : RCMR
    theta : array, shape (l_theta,)

    Raises
    ------
    InputError
        Where the subsystem has dynamics of its own.
    """
    part = settings.subsystem
    if isinstance(part, RepeatedParameters):
        D_1 = settings.D_1
        if part.D.shape[2]:
            D_1 = D_1 + np.tensordot(theta, part.D, 1)
        return settings.A + np.tensordot(theta, part.A, 1), D_1
    if isinstance(part, FIRSubsystem) and (part.n_c > 1 or part.strictly_proper):
        raise InputError(
            f"{part!r} has dynamics; a static one, FIRSubsystem(n_c=1), is a parameter of A."
        )
    return settings.A + settings.B @ theta.reshape(settings.l_u, -1) @ settings.E_1, settings.D_1


def require_observable(settings: RCMR, C: Array) -> None:
    """Raise where an observer of the model with theta_0 could not correct some mode.

    Parameters
    ----------
    settings : RCMR
    C : array, shape (1, n)
        What is measured.

    Raises
    ------
    NotObservableError
        Says how many modes are seen.
    """
    A, _ = refined_matrices(settings, settings.theta_0)
    rows = [C]
    for _ in range(settings.n - 1):
        rows.append(rows[-1] @ A)
    scaled = [row / max(np.abs(row).max(), np.finfo(float).tiny) for row in rows]
    rank = np.linalg.matrix_rank(np.vstack(scaled), tol=1e-12)
    if rank < settings.n:
        raise NotObservableError(
            f"C_r sees {rank} of the {settings.n} modes of the model: an observer cannot correct "
            "the others. Measure more, or use full-state feedback."
        )
