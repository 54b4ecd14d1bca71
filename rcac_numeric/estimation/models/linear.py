"""A linear model for the Kalman filter."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import matrix
from rcac_numeric.arrays.values import Value
from rcac_numeric.estimation.models.any_model import places_of_angles


@dataclass(frozen=True, eq=False, init=False)
class LinearModel(Value):
    """x(k+1) = A x(k) + B u(k) + noise, y(k) = C x(k) + D u(k) + noise.

    With it the extended and the unscented Kalman filter are the Kalman filter, and every step
    runs in the compiled kernel.

    Parameters
    ----------
    A : array, shape (n, n)
    C : array, shape (l_y, n)
    B : array, shape (n, l_u), optional
        Without it there is no known input.
    D : array, shape (l_y, l_u), optional
        Zero by default.
    angles : sequence of int
        Which measurements are angles, in radians: their innovations go the shorter way round.

    Raises
    ------
    InputError
        Where the shapes do not fit together, or an entry is not finite.

    Examples
    --------
    >>> from rcac_numeric.estimation import LinearModel
    >>> LinearModel(A=[[1, 0.1], [0, 1]], C=[[1, 0]], B=[[0], [0.1]]).l_u
    1
    """

    A: Array
    C: Array
    B: Array
    D: Array
    angles: tuple[int, ...]

    def __init__(
        self,
        A: ArrayLike,
        C: ArrayLike,
        B: ArrayLike | None = None,
        D: ArrayLike | None = None,
        angles: Iterable[int] = (),
    ) -> None:
        set_ = partial(object.__setattr__, self)
        read = matrix(A, "A", (None, None))
        n = read.shape[0]
        set_("A", matrix(A, "A", (n, n)))
        set_("C", matrix(C, "C", (None, n)))
        set_("B", matrix(np.zeros((n, 0)) if B is None else B, "B", (n, None)))
        shape = (self.C.shape[0], self.B.shape[1])
        set_("D", matrix(np.zeros(shape) if D is None else D, "D", shape))
        set_("angles", places_of_angles(angles, self.C.shape[0]))

    @property
    def n(self) -> int:
        """Number of states."""
        return int(self.A.shape[0])

    @property
    def names(self) -> tuple[str, ...]:
        """x[0], x[1], ..."""
        return tuple(f"x[{i}]" for i in range(self.n))

    @property
    def l_u(self) -> int:
        """Number of known inputs."""
        return int(self.B.shape[1])

    @property
    def l_y(self) -> int:
        """Number of measurements."""
        return int(self.C.shape[0])
