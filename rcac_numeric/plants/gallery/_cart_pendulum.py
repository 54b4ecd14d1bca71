"""The pendulum on a cart, upright or hanging."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import one_of, real_array, vector
from rcac_numeric.plants.gallery._continuous import ContinuousPlant
from rcac_numeric.plants.gallery._operating_points import OperatingPoint, require_positive


@dataclass(frozen=True)
class CartPendulum:
    """A pendulum on a cart with force F; its angle phi is 0 upright.

    (M + m) p'' + b p' - m l cos(phi) phi'' + m l sin(phi) phi'^2 = F
    (I + m l^2) phi'' - m g l sin(phi) = m l cos(phi) p''

    Parameters
    ----------
    cart_mass, pendulum_mass : float
        M and m, kg.
    friction : float
        b of the cart, N s/m.
    length : float
        l from the pivot to the centre of mass, m.
    inertia : float
        I about the centre of mass, kg m^2.
    gravity : float
        g, m/s^2.

    Raises
    ------
    InputError
        If a parameter is not positive.

    Notes
    -----
    Unstable upright, and nonminimum phase from the force to the position. The numbers are those of
    the inverted pendulum of the Control Tutorials for MATLAB and Simulink (University of Michigan),
    whose poles upright are 0, 5.5651, -5.6041 and -0.1428 rad/s; no example of the text.

    Examples
    --------
    >>> from rcac_numeric.gallery import CartPendulum
    >>> pendulum = CartPendulum()
    >>> upright = pendulum.linearised(pendulum.operating_point("upright"))
    >>> (upright.zeros().round(3) + 0).tolist()
    [(4.95+0j), (-4.95+0j)]
    """

    cart_mass: float = 0.5
    pendulum_mass: float = 0.2
    friction: float = 0.1
    length: float = 0.3
    inertia: float = 0.006
    gravity: float = 9.8

    def __post_init__(self) -> None:
        require_positive(
            cart_mass=self.cart_mass, pendulum_mass=self.pendulum_mass, friction=self.friction,
            length=self.length, inertia=self.inertia, gravity=self.gravity,
        )  # fmt: skip

    def derivative(self, x: ArrayLike, u: ArrayLike) -> Array:
        """The rate of change of the state at x = [p, p', phi, phi'] and u = [F]."""
        _, speed, phi, rate = vector(x, "x", 4)
        force = vector(u, "u", 1)[0]
        m, ml = self.pendulum_mass, self.pendulum_mass * self.length
        mass = np.array(
            [
                [self.cart_mass + m, -ml * np.cos(phi)],
                [-ml * np.cos(phi), self.inertia + ml * self.length],
            ]
        )
        forces = [
            force - self.friction * speed - ml * np.sin(phi) * rate**2,
            ml * self.gravity * np.sin(phi),
        ]
        p_dd, phi_dd = np.linalg.solve(mass, forces)
        return real_array([speed, p_dd, rate, phi_dd], "the derivative")

    def operating_point(self, kind: str = "upright") -> OperatingPoint:
        """Return the equilibrium at p = 0, "upright" or "hanging"."""
        phi = 0.0 if one_of(kind, "kind", ("upright", "hanging")) == "upright" else np.pi
        return OperatingPoint([0, 0, phi, 0], [0])

    def linearised(self, point: OperatingPoint) -> ContinuousPlant:
        """Return the linearisation at an operating point (zero speeds and F); y = p."""
        m, l_ = self.pendulum_mass, self.length
        turn = float(np.cos(point.x[2]))
        I_pivot = self.inertia + m * l_**2
        p = (self.cart_mass + m) * I_pivot - (m * l_ * turn) ** 2
        b, weight = self.friction, m * self.gravity * l_
        A = np.zeros((4, 4))
        A[0, 1] = A[2, 3] = 1.0
        A[1, 1:3] = -I_pivot * b / p, m * l_ * turn**2 * weight / p
        A[3, 1:3] = -m * l_ * turn * b / p, (self.cart_mass + m) * weight * turn / p
        return ContinuousPlant(
            A=A,
            B=[[0.0], [I_pivot / p], [0.0], [m * l_ * turn / p]],
            C=[[1, 0, 0, 0]],
            states=["position, m", "speed, m/s", "angle, rad", "angular rate, rad/s"],
            inputs=["force, N"],
            outputs=["position, m"],
        )
