"""Which coefficients the data of RCMR have determined."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.values import Value
from rcac_numeric.estimation.refinement.settings import RCMR

# At this share the data weigh as much as the initial estimate.
DETERMINED = 0.5


@dataclass(frozen=True, eq=False)
class Evidence(Value):
    """How much of theta is still its initial estimate, per direction.

    Attributes
    ----------
    kept : array, shape (l_theta,)
        Eigenvalues of lambda^updates P(0)^-1/2 P P(0)^-1/2, the share of the initial estimate in
        P^-1, largest first: 1 where the data say nothing.
    directions : array, shape (l_theta, l_theta)
        Their directions of theta, one in each row.
    """

    kept: Array
    directions: Array

    @property
    def undetermined(self) -> Array:
        """The directions that are still mainly the initial estimate, one in each row."""
        return self.directions[self.kept > DETERMINED]

    def __str__(self) -> str:
        """What is undetermined, in words."""
        unknown = self.undetermined
        if not len(unknown):
            return "the data determine every coefficient."
        if len(self.kept) == 1:
            what = "theta"
        else:
            what = f"{len(unknown)} of {len(self.kept)} directions of theta"
        return (
            f"the data do not determine {what}: the regressor is too small there, and the estimate "
            "is mainly theta_0. Excite the model by a richer w, or raise beta if the signals are "
            "small and clean."
        )


def evidence(settings: RCMR, P: Array, k: int) -> Evidence:
    """The evidence in P after k steps with these settings."""
    share = settings.lambda_ ** max(k - settings.k_update, 0)
    root = np.linalg.cholesky(settings.beta)
    whitened = share * np.linalg.solve(root, np.linalg.solve(root, P).T)
    values, vectors = np.linalg.eigh((whitened + whitened.T) / 2)
    return Evidence(values[::-1], np.ascontiguousarray((root @ vectors[:, ::-1]).T))
