"""Linear plants in continuous time, with named signals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory import figures
from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array, ComplexArray
from rcac_numeric.arrays.showing import picture_of
from rcac_numeric.arrays.validation import matrix
from rcac_numeric.arrays.values import Value
from rcac_numeric.plants.gallery.zeros import plant_zeros
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.problems import servo_plant
from rcac_numeric.plants.zero_order_hold import zero_order_hold


@dataclass(frozen=True, eq=False, init=False)
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

    A: Array
    B: Array
    C: Array
    D: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    def __init__(
        self,
        A: ArrayLike,
        B: ArrayLike,
        C: ArrayLike,
        D: ArrayLike | None = None,
        states: Sequence[str] = (),
        inputs: Sequence[str] = (),
        outputs: Sequence[str] = (),
    ) -> None:
        n = len(matrix(A, "A", (None, None)))
        read = {"A": matrix(A, "A", (n, n)), "B": matrix(B, "B", (n, None))}
        read["C"] = matrix(C, "C", (None, n))
        size = (len(read["C"]), read["B"].shape[1])
        read["D"] = matrix(np.zeros(size) if D is None else D, "D", size)
        for name, value in read.items():
            object.__setattr__(self, name, value)
        counts = {"states": (states, n), "inputs": (inputs, size[1]), "outputs": (outputs, size[0])}
        for name, (given, count) in counts.items():
            numbered = tuple(f"{name[:-1]} {i + 1}" for i in range(count))
            names = tuple(given) or numbered
            if len(names) != count:
                raise InputError(f"{name} = {names}: {count} names are needed.")
            object.__setattr__(self, name, names)

    def poles(self) -> ComplexArray:
        """Eigenvalues of A, rad/s, largest modulus first."""
        found = np.linalg.eigvals(self.A).astype(np.complex128)
        return found[np.lexsort((-found.imag, -found.real, -np.abs(found)))]

    def zeros(self) -> ComplexArray:
        """Invariant zeros from u to y, rad/s, from certified isolation."""
        # The Rosenbrock pencil does not know whether its variable is s or q.
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
        return picture_of(self, periods)

    def __repr__(self) -> str:
        n, l_u, l_y = len(self.A), self.B.shape[1], len(self.C)
        return f"ContinuousPlant(n={n}, l_u={l_u}, l_y={l_y})"
