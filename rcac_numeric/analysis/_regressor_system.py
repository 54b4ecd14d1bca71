"""The loop of a controller structure as a linear system from u to the regressor, exact."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from flint import fmpq, fmpq_mat
from numpy.typing import NDArray

from compensator_theory.errors import BudgetError, ImproperError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._structure import DerivedSignal, Structure, Tap
from rcac_numeric.plants._linear import Plant

Exact = NDArray[Any]
"""An array of rational numbers of python-flint."""

MOST_STATES = 150  # beyond it one proof takes a minute


@dataclass(frozen=True, eq=False)
class RegressorSystem:
    """x(k+1) = A x(k) + B u(k), phi(k) = C x(k) with w = 0, where u = Theta phi closes the loop.

    x holds the plant, past u, y and derived signals, and the past of a fixed compensator in
    parallel, as the structure keeps them. So A + B Theta C is the loop of every Theta of shape
    (l_u, taps), at every step of a moving Theta too, without terms in theta(k) - theta(k-1).

    Attributes
    ----------
    A, B, C : flint.fmpq_mat
        Exact: the float64 numbers of plant and structure are dyadic rationals.
    plant_inputs : flint.fmpq_mat
        The part of B that acts through the plant, n x l_u; the rest of B is memory of u.
    parallel : flint.fmpq_mat
        The output of the fixed compensator in parallel, l_u x n.
    """

    A: fmpq_mat
    B: fmpq_mat
    C: fmpq_mat
    plant_inputs: fmpq_mat
    parallel: fmpq_mat

    def loop(self, theta: Array) -> fmpq_mat:
        """Return A + B Theta C for the coefficients theta in the order of the product."""
        Theta = theta.reshape(self.C.nrows(), self.B.ncols()).T
        return self.A + self.B * rational_matrix(exact(Theta)) * self.C

    def loop_matrix(self, theta: Array) -> Array:
        """Return A + B Theta C, rounded once."""
        return rounded_matrix(self.loop(theta))

    @cached_property
    def rounded(self) -> Array:
        """A, rounded."""
        return rounded_matrix(self.A)

    @cached_property
    def inputs(self) -> Array:
        """B, rounded."""
        return rounded_matrix(self.B)

    @cached_property
    def outputs(self) -> Array:
        """C, rounded."""
        return rounded_matrix(self.C)


def regressor_system(
    plant: Plant, structure: Structure, fixed: Compensator | None = None
) -> RegressorSystem:
    """Return the system from u to the regressor of a plant and a structure.

    Raises
    ------
    InputError
        Where plant and structure have different numbers of signals.
    ImproperError
        Where y follows u at once.
    BudgetError
        Where the loop has more than 150 states.
    """
    if (plant.l_u, plant.l_y) != (structure.l_u, structure.l_y):
        raise InputError(
            f"the plant has l_u = {plant.l_u}, l_y = {plant.l_y}; the controller has "
            f"l_u = {structure.l_u}, l_y = {structure.l_y}."
        )
    if plant.y_needs_u:
        raise ImproperError(
            "y follows u at once (D_0 is not zero), and the regressor of a certified set holds no "
            "u of its own step. Put one step of delay at the input of the plant."
        )
    return _Registers(plant, structure, fixed).system()


class _Registers:
    """The places of past signals in x, and the rows that read the present ones."""

    def __init__(self, plant: Plant, structure: Structure, fixed: Compensator | None) -> None:
        self.plant, self.structure, self.fixed = plant, structure, fixed
        used = {tap.component for tap in structure.taps if tap.signal == "derived"}
        self.derived = {
            i: signal for i, signal in enumerate(structure.derived)
            if i in used and _reads_y(signal, plant.l_y)
        }  # fmt: skip
        signals = self.derived.values()
        lags = {
            "u": self._longest("u"),
            "y": max(self._longest("y"), int(any(_remembers_y(s, plant.l_y) for s in signals))),
            "derived": max(self._longest("derived"), int(any(s.pole for s in signals))),
            "fixed": 0,
        }
        if fixed is not None:
            lags["y"] = max(lags["y"], fixed.n_c)
            lags["fixed"] = fixed.n_c if fixed.past_u.any() else 0
        widths = {"u": plant.l_u, "y": plant.l_y, "derived": len(self.derived), "fixed": plant.l_u}
        self.start, self.lags, self.widths = {}, lags, widths
        self.n = plant.n
        for name, width in widths.items():
            self.start[name] = self.n
            self.n += width * lags[name]
        if self.n > MOST_STATES:
            raise BudgetError(
                f"the loop of this {structure.name} structure has {self.n} states with the past "
                f"signals that it holds; a certified set is proved for at most {MOST_STATES}. Use "
                "a smaller n_c, or a plant with fewer states."
            )

    def _longest(self, name: str) -> int:
        taps = [t for t in self.structure.taps if t.signal == name]
        if name == "derived":
            taps = [t for t in taps if t.component in self.derived]
        return max((tap.delay for tap in taps), default=0)

    def past(self, name: str, lag: int) -> Exact:
        """Return the rows that read a signal so many steps back, lag >= 1."""
        width = self.widths[name]
        first = self.start[name] + width * (lag - 1)
        rows = exact(np.zeros((width, self.n)))
        rows[np.arange(width), first + np.arange(width)] = fmpq(1)
        return rows

    @cached_property
    def y(self) -> Exact:
        """The rows of y(k)."""
        rows = exact(np.zeros((self.plant.l_y, self.n)))
        rows[:, : self.plant.n] = exact(self.plant.C)
        return rows

    @cached_property
    def signals(self) -> Exact:
        """The rows of the derived signals that read y."""
        rows = exact(np.zeros((len(self.derived), self.n)))
        outputs = self.plant.l_y
        for i, signal in enumerate(self.derived.values()):
            rows[i] = exact(np.array(signal.now[:outputs])) @ self.y
            if _remembers_y(signal, outputs):
                rows[i] += exact(np.array(signal.before[:outputs])) @ self.past("y", 1)
            if signal.pole:
                rows[i] += fmpq(*signal.pole.as_integer_ratio()) * self.past("derived", 1)[i]
        return rows

    @cached_property
    def beside(self) -> Exact:
        """The rows of the output of the fixed compensator in parallel."""
        rows = exact(np.zeros((self.plant.l_u, self.n)))
        if self.fixed is not None:
            for lag, Q in enumerate(self.fixed.past_y):
                Q_y = Q[:, : self.plant.l_y]  # the other columns read the command
                if Q_y.any():
                    rows += exact(Q_y) @ (self.past("y", lag) if lag else self.y)
            for lag, P in enumerate(self.fixed.past_u, start=1):
                if P.any():
                    rows += exact(P) @ self.past("fixed", lag)
        return rows

    def read(self, tap: Tap) -> Exact:
        """Return the row of one entry of the regressor; zero for an entry that only r moves."""
        if tap.signal == "derived" and tap.component in self.derived:
            place = list(self.derived).index(tap.component)
            rows = self.past("derived", tap.delay) if tap.delay else self.signals
            return np.asarray(rows[place])
        if tap.signal in ("u", "y"):
            rows = self.past(tap.signal, tap.delay) if tap.delay else self.y
            return np.asarray(rows[tap.component])
        return exact(np.zeros(self.n))

    def system(self) -> RegressorSystem:
        """Return the system."""
        plant, n, m = self.plant, self.n, self.plant.l_u
        A, B = exact(np.zeros((n, n))), exact(np.zeros((n, m)))
        A[: plant.n, : plant.n], B[: plant.n] = exact(plant.A), exact(plant.B)
        if self.fixed is not None:
            A[: plant.n] += exact(plant.B) @ self.beside
        present = {"y": self.y, "derived": self.signals, "fixed": self.beside}
        for name, width in self.widths.items():
            for lag in range(1, self.lags[name] + 1):
                rows = slice(self.start[name] + width * (lag - 1), self.start[name] + width * lag)
                if lag > 1:
                    A[rows] = self.past(name, lag - 1)
                elif name == "u":
                    B[rows] = exact(np.eye(m))
                else:
                    A[rows] = present[name]
        C = np.array([self.read(tap) for tap in self.structure.taps], dtype=object)
        inputs = exact(np.zeros((n, m)))
        inputs[: plant.n] = exact(plant.B)
        parts = (A, B, C, inputs, self.beside)
        return RegressorSystem(*(rational_matrix(part) for part in parts))


def _reads_y(signal: DerivedSignal, l_y: int) -> bool:
    return any(signal.now[:l_y]) or any(signal.before[:l_y])


def _remembers_y(signal: DerivedSignal, l_y: int) -> bool:
    return any(signal.before[:l_y])


def exact(values: Array) -> Exact:
    """Return float64 numbers as the rationals that they are."""
    zero = fmpq(0)
    entries = [fmpq(*v.as_integer_ratio()) if v else zero for v in np.ravel(values).tolist()]
    whole = np.empty(len(entries), dtype=object)
    whole[:] = entries
    return whole.reshape(np.shape(values))


def rational_matrix(values: Exact) -> fmpq_mat:
    """Return an array of rational numbers as a matrix of python-flint."""
    return fmpq_mat(*values.shape, values.ravel().tolist())


def array_of(matrix: fmpq_mat) -> Exact:
    """Return a matrix of python-flint as an array of rational numbers."""
    whole = np.empty(matrix.nrows() * matrix.ncols(), dtype=object)
    whole[:] = matrix.entries()
    return whole.reshape(matrix.nrows(), matrix.ncols())


def rounded_matrix(matrix: fmpq_mat) -> Array:
    """Return a rational matrix in float64, each entry rounded once."""
    entries = [int(e.p) / int(e.q) if e else 0.0 for e in matrix.entries()]
    return np.array(entries, dtype=np.float64).reshape(matrix.nrows(), matrix.ncols())
