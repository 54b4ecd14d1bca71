"""Zeros of a plant, and of a plant that changes over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import compensator_theory as exact
from compensator_theory import figures
from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import integer, items
from rcac_numeric.arrays._values import Result
from rcac_numeric.plants._foreign import linear_plant
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import PlantSchedule, plant_at
from rcac_numeric.plants._transmission_zeros import transmission_zero_polynomial


@dataclass(frozen=True, eq=False)
class ZeroPath(Result):
    """The zeros of a time-varying plant, frozen at some steps.

    Attributes
    ----------
    steps : array of int, shape (count,)
    zeros : complex array, shape (count, number of zeros)
        A column follows one zero from step to step, by nearness.
    """

    steps: Array
    zeros: ComplexArray

    @property
    def magnitudes(self) -> Array:
        """Moduli, shape (count, number of zeros), as figure 3.5 shows them."""
        return np.asarray(np.abs(self.zeros), dtype=np.float64)

    @property
    def is_nonminimum_phase(self) -> NDArray[np.bool_]:
        """Whether a zero has modulus 1 or more, at each step."""
        return np.asarray((self.magnitudes >= 1).any(axis=1))

    def plot(self) -> figures.Figure:
        """The zeros in the plane and their moduli over the steps, figures 3.4 and 3.5."""
        from rcac_numeric.plots._plants import plot_zero_path

        return plot_zero_path(self)


def plant_zeros(plant: Plant) -> ComplexArray:
    """The invariant zeros from u to z with multiplicity, largest modulus first.

    Parameters
    ----------
    plant : Plant, or a system that `plant_of` reads

    Returns
    -------
    complex array
        Roots of `transmission_zero_polynomial`, from certified isolation.

    Examples
    --------
    >>> from rcac_numeric import standard_plant
    >>> from rcac_numeric.gallery import plant_zeros
    >>> plant_zeros(standard_plant("(q - 1.5)*(q - 0.2)/(q - 0.5)**3"))
    array([1.5+0.j, 0.2+0.j])
    """
    plant = linear_plant(plant)
    scalar = plant.l_u == plant.l_z == 1
    # The numerator over det(qI - A), unreduced, is the same polynomial and faster to compute.
    polynomial = plant.scalar_map("zu")[0] if scalar else transmission_zero_polynomial(plant)
    if polynomial.is_zero:
        raise InputError("G_zu = 0: every number is a zero. Choose an output that u acts on.")
    if polynomial.degree() < 1:
        return np.zeros(0, dtype=np.complex128)
    roots = exact.certified_roots(polynomial)
    values = [complex(root.value) for root in roots for _ in range(root.multiplicity)]
    return np.array(sorted(values, key=lambda z: (-abs(z), -z.real, -z.imag)))


def zero_path(schedule: PlantSchedule, steps: Sequence[int]) -> ZeroPath:
    """The zeros of a plant schedule, frozen at given steps; figures 3.4 and 3.5.

    Parameters
    ----------
    schedule : PlantSchedule
    steps : sequence of int
        By increasing step.

    Raises
    ------
    InputError
        If no step is given, or the number of zeros changes on the way.

    Notes
    -----
    Zeros of the plant frozen at a step; a plant that moves as fast as its own dynamics has none.

    Examples
    --------
    >>> from rcac_numeric.gallery import aircraft_transition, zero_path
    >>> path = zero_path(aircraft_transition(), [2500, 2525, 2600])
    >>> path.magnitudes.max(axis=1).round(3)
    array([1.   , 1.004, 1.136])
    """
    steps = [integer(step, "steps") for step in items(steps, "steps")]
    if not steps:
        raise InputError("steps is empty; give at least one step.")
    rows: list[ComplexArray] = []
    for step in steps:
        zeros = plant_zeros(plant_at(schedule, step))
        if rows and len(zeros) != len(rows[-1]):
            raise InputError(
                f"the plant has {len(rows[-1])} zeros before step {step} and {len(zeros)} at it; "
                "call zero_path for the two ranges of steps separately."
            )
        if rows:
            from scipy.optimize import linear_sum_assignment  # imported here: it takes 0.17 s

            _, order = linear_sum_assignment(np.abs(rows[-1][:, None] - zeros[None, :]))
            zeros = zeros[order]
        rows.append(zeros)
    return ZeroPath(np.array(steps, dtype=np.float64), np.array(rows))
