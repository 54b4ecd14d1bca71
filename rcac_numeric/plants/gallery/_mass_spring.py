"""The mass-spring-damper of Chapter 8, on which RCMR is compared with Kalman filters."""

from __future__ import annotations

from dataclasses import dataclass

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import number, real_array
from rcac_numeric.plants.gallery._continuous import ContinuousPlant
from rcac_numeric.plants.gallery._operating_points import require_positive


@dataclass(frozen=True)
class MassSpringDamper:
    """A mass-spring-damper from a force w to its velocity, (8.64)-(8.67).

    m q'' + c q' + kappa q = w,  y = q'

    Parameters
    ----------
    mass, damping, stiffness : float
        m, c and kappa in kg, N s/m and N/m. Examples 8.1 and 8.2 have 1, 5 and 10; 8.3 has 0.9, 5
        and 30.

    Raises
    ------
    InputError
        If a parameter is not positive.

    Examples
    --------
    >>> from rcac_numeric.gallery import MassSpringDamper
    >>> MassSpringDamper().continuous().zeros()
    array([0.+0.j])
    """

    mass: float = 1.0
    damping: float = 5.0
    stiffness: float = 10.0

    def __post_init__(self) -> None:
        require_positive(mass=self.mass, damping=self.damping, stiffness=self.stiffness)

    def continuous(self) -> ContinuousPlant:
        """The plant (8.66)-(8.67)."""
        return ContinuousPlant(
            A=[[0.0, 1.0], [-self.stiffness / self.mass, -self.damping / self.mass]],
            B=[[0.0], [1 / self.mass]],
            C=[[0, 1]],
            states=["position, m", "velocity, m/s"],
            inputs=["force, N"],
            outputs=["velocity, m/s"],
        )

    def euler(self, h: float = 0.1) -> tuple[Array, Array]:
        """I + h A and h B, the discretisation (8.68) that Chapter 8 uses; h in s."""
        require_positive(h=number(h, "h"))
        plant = self.continuous()
        A = [[1.0, h], [h * plant.A[1, 0], 1.0 + h * plant.A[1, 1]]]
        return real_array(A, "A"), real_array(h * plant.B, "B")
