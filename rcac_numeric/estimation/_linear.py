"""A linear model for the Kalman filter."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import attrs
import numpy as np

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import array_like, matrix, optional_array_like
from rcac_numeric.arrays._values import Value
from rcac_numeric.estimation._any_model import places_of_angles


@attrs.frozen(eq=False, slots=False)
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

    A: Array = attrs.field(converter=array_like)
    C: Array = attrs.field(converter=array_like)
    B: Array = attrs.field(default=None, converter=optional_array_like)
    D: Array = attrs.field(default=None, converter=optional_array_like)
    angles: Sequence[int] = ()

    def __attrs_post_init__(self) -> None:
        set_ = partial(object.__setattr__, self)
        n = len(matrix(self.A, "A", (None, None)))
        set_("A", matrix(self.A, "A", (n, n)))
        set_("C", matrix(self.C, "C", (None, n)))
        set_("B", matrix(np.zeros((n, 0)) if self.B is None else self.B, "B", (n, None)))
        shape = (len(self.C), self.B.shape[1])
        set_("D", matrix(np.zeros(shape) if self.D is None else self.D, "D", shape))
        set_("angles", places_of_angles(self.angles, len(self.C)))

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
