"""In how many directions of theta the data of a run outweigh R_theta."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rcac_numeric.controllers.regressor import (
    filtered_regressor,
    has_common_filter,
    regressor_of,
)
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.engine.compatibility import command_position
from rcac_numeric.engine.runs import Run

ROWS = 20_000  # steps that are looked at: the first ones from k_w on


@dataclass(frozen=True)
class Excitation:
    """How much the data of a run say of theta.

    Attributes
    ----------
    l_theta : int
        Number of coefficients.
    outweighed : int
        Number of directions of theta in which sum Phi_f' R_z Phi_f exceeds R_theta: there the data
        move theta, in the others theta stays near theta(0).
    excited : int
        Number of directions that the data excite by more than rounding.
    """

    l_theta: int
    outweighed: int
    excited: int

    def __str__(self) -> str:
        words = f"the data outweigh R_theta in {self.outweighed} of {self.l_theta} directions"
        if self.excited < self.l_theta:
            words += f", and excite {self.excited} of them by more than rounding"
        return words


def excitation_of(run: Run) -> Excitation | None:
    """The excitation of a run with recursive least squares and constant weights; else None.

    None too with a fixed compensator in parallel, whose part of u the run does not tell apart.
    """
    settings = run.settings
    if not isinstance(settings, ControllerSettings) or not run.steps:
        return None
    R_theta, R_z = getattr(settings.update, "R_theta", None), settings.R_z
    structure, target = settings.structure, settings.target
    if settings.learning is not None:
        told = [one.change.target for one in run.changes if one.change.target is not None]
        if not told:
            return None
        target = told[-1]
    if R_theta is None or not isinstance(R_z, np.ndarray) or not has_common_filter(target):
        return None
    if settings.fixed is not None:
        return None
    start = max(settings.k_update - run.first_step, 0)
    rows = slice(0, start + ROWS)
    r = None
    if structure.l_r:
        at = command_position(run.plant, structure.l_r)
        r = run.w[rows, at : at + structure.l_r]
    phi = regressor_of(structure, {"u": run.u_applied[rows], "y": run.y[rows], "r": r}, np.asarray)
    size = structure.l_theta
    information = np.zeros((size, size))
    with np.errstate(all="ignore"):
        root = np.linalg.cholesky(R_z)
        Phi_f = np.einsum("zs,ksj->kzj", root.T, filtered_regressor(phi, target)[start:])
        for block in np.array_split(Phi_f.reshape(-1, size), max(len(Phi_f) // 1000, 1)):
            information += block.T @ block
        if not np.isfinite(information).all():
            return None
        scale = np.eye(size) * R_theta if np.ndim(R_theta) == 0 else np.asarray(R_theta)
        inverse = np.linalg.inv(np.linalg.cholesky(scale))
        outweighed = np.linalg.eigvalsh(inverse @ information @ inverse.T) > 1
        spread = np.sqrt(np.diag(information))
        spread[spread == 0] = 1.0
        values = np.linalg.eigvalsh(information / np.outer(spread, spread))
    return Excitation(size, int(outweighed.sum()), int((values > 1e-13 * size).sum()))
