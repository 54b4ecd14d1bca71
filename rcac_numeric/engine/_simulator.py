"""The compiled plant for a loop in Python."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from compensator_theory.errors import FunctionFailedError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import vector
from rcac_numeric.compiled._callbacks import Failures
from rcac_numeric.compiled._plants import compiled_plant
from rcac_numeric.plants._any_plant import AnyPlant
from rcac_numeric.plants._foreign import as_plant


class Simulator:
    """A plant at step `k` in state `x`; the arithmetic is that of `simulate`, bit for bit.

    Parameters
    ----------
    plant : Plant, PlantSchedule or FunctionPlant
    x_0 : array, shape (n,), optional
        Initial state; zero by default.

    Examples
    --------
    >>> from rcac_numeric import Simulator, standard_plant
    >>> body = Simulator(standard_plant("1/(q - 0.5)"), x_0=[1.0])
    >>> for k in range(3):
    ...     y, z = body.output(u=0, w=0)
    ...     body.advance(u=0, w=0)
    >>> body.k, body.x
    (3, array([0.125]))
    """

    def __init__(self, plant: AnyPlant, x_0: ArrayLike | None = None) -> None:
        plant = as_plant(plant)
        self._failures = Failures()
        self._body = compiled_plant(plant, x_0, self._failures)
        self._plant, self._l_u, self._l_w, self._k = plant, plant.l_u, plant.l_w, 0

    def __reduce__(self) -> tuple[Any, ...]:
        """Support copies and pickles: separate plants in the same state."""
        return _rebuilt, (self._plant, self._k, self._body.save())

    @property
    def k(self) -> int:
        """The step k."""
        return self._k

    @property
    def x(self) -> Array:
        """A copy of the state x(k)."""
        return self._body.x.copy()

    def output(self, u: ArrayLike, w: ArrayLike) -> tuple[Array, Array]:
        """Return y(k) and z(k), shapes (l_y,) and (l_z,), without advancing the plant.

        Parameters
        ----------
        u, w : array_like, shapes (l_u,) and (l_w,)

        Raises
        ------
        InputError
            If an array has the wrong size or holds what is not a finite real number.
        FunctionFailedError
            If a function of the plant raised; the exception is the cause.
        """
        works, y, z = self._body.output(self._k, self._row(u, "u"), self._row(w, "w"))
        self._require(works, "output")
        return y, z

    def advance(self, u: ArrayLike, w: ArrayLike) -> None:
        """Advance to x(k+1); arguments and errors as for `output`."""
        works = self._body.advance(self._k, self._row(u, "u"), self._row(w, "w"))
        self._require(works, "advance")
        self._k += 1

    def _row(self, value: ArrayLike, name: str) -> Array:
        return vector(value, name, self._l_u if name == "u" else self._l_w)

    def _require(self, works: bool, function: str) -> None:
        if not works:
            error = self._failures.take()
            why = "it returned a nonzero number."
            if error is not None:
                why = f"{type(error).__name__}: {error}"
            raise FunctionFailedError(
                f"the function {function} of the plant failed at step {self._k}: {why}"
            ) from error

    def __repr__(self) -> str:
        return f"Simulator(k={self._k}, x={self.x})"


def _rebuilt(plant: AnyPlant, k: int, state: Array) -> Simulator:
    simulator = Simulator(plant)
    simulator._body.restore(state)
    simulator._k = k
    return simulator
