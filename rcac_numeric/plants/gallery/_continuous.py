"""Linear plants in continuous time, with named signals."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import attrs
import numpy as np

from compensator_theory import figures
from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import array_like, matrix, optional_array_like
from rcac_numeric.arrays._values import Value
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._problems import servo_plant
from rcac_numeric.plants._zero_order_hold import zero_order_hold
from rcac_numeric.plants.gallery._zeros import plant_zeros


@attrs.frozen(eq=False, slots=False)
class ContinuousPlant(Value):
    """A linear plant x' = A x + B u, y = C x + D u in continuous time.

    Parameters
    ----------
    A, B, C, D : arrays, shapes (n, n), (n, l_u), (l_y, n), (l_y, l_u)
        Per second; D is zero where it is left out.
    states, inputs, outputs : sequences of str
        What the signals are, with their units; numbered where they are left out.

    Raises
    ------
    InputError
        If sizes do not fit each other, or a name is missing.

    Examples
    --------
    >>> from rcac_numeric.gallery import ContinuousPlant
    >>> lag = ContinuousPlant(A=[[-1.0]], B=[[1.0]], C=[[2.0]], outputs=["speed, m/s"])
    >>> lag.sampled(0.5).A.round(6)
    array([[0.606531]])
    """

    A: Array = attrs.field(converter=array_like)
    B: Array = attrs.field(converter=array_like)
    C: Array = attrs.field(converter=array_like)
    D: Array = attrs.field(default=None, converter=optional_array_like)
    states: Sequence[str] = ()
    inputs: Sequence[str] = ()
    outputs: Sequence[str] = ()

    def __attrs_post_init__(self) -> None:
        set_ = partial(object.__setattr__, self)
        n = len(matrix(self.A, "A", (None, None)))
        set_("A", matrix(self.A, "A", (n, n)))
        set_("B", matrix(self.B, "B", (n, None)))
        set_("C", matrix(self.C, "C", (None, n)))
        size = (len(self.C), self.B.shape[1])
        set_("D", matrix(np.zeros(size) if self.D is None else self.D, "D", size))
        for name, count in (("states", n), ("inputs", size[1]), ("outputs", size[0])):
            numbered = tuple(f"{name[:-1]} {i + 1}" for i in range(count))
            names = tuple(getattr(self, name)) or numbered
            if len(names) != count:
                raise InputError(f"{name} = {names}: {count} names are needed.")
            set_(name, names)

    def poles(self) -> ComplexArray:
        """Eigenvalues of A, rad/s, largest modulus first."""
        poles = np.linalg.eigvals(self.A).astype(np.complex128)
        return poles[np.lexsort((-poles.imag, -poles.real, -np.abs(poles)))]

    def zeros(self) -> ComplexArray:
        """Invariant zeros from u to y, rad/s, from certified isolation."""
        # The Rosenbrock pencil is the same in s and in q.
        return plant_zeros(Plant(A=self.A, B=self.B, D_1=self.B, C=self.C, D_0=self.D, E_2=self.D))

    def sampled(self, h: float) -> Plant:
        """The standard problem with period h in s: y = z and w matched with u, (2.15)."""
        A, B = zero_order_hold(self.A, self.B, h)
        return Plant(
            A=A, B=B, D_1=B, C=self.C, D_0=self.D, D_2=self.D, E_2=self.D, E_0=self.D
        )  # fmt: skip

    def servo(self, h: float) -> Plant:
        """The servo problem (2.16)-(2.27) with period h in s, d colocated with u."""
        A, B = zero_order_hold(self.A, self.B, h)
        matrices = {"A": A, "B": B, "D_1": B, "C": self.C, "D_0": self.D}
        return servo_plant(**{name: value.tolist() for name, value in matrices.items()})

    def plot(self, periods: Sequence[float]) -> figures.Figure:
        """Poles and zeros, step response, and the sampled zeros against the period in s."""
        from rcac_numeric.plots._plants import plot_continuous_plant

        return plot_continuous_plant(self, periods)

    def __repr__(self) -> str:
        n, l_u, l_y = len(self.A), self.B.shape[1], len(self.C)
        return f"ContinuousPlant(n={n}, l_u={l_u}, l_y={l_y})"
