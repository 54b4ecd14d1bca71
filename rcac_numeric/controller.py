"""One RCAC controller for any simulator or device."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import DivergedError, InputError
from rcac_numeric.compensators import Compensator
from rcac_numeric.controller_settings import ControllerSettings
from rcac_numeric.validation import Array, real_array


class Controller:
    """An adaptive controller for any simulator or device.

    One call of `step` is one step of RCAC in the order measure, control, filter, update. It takes
    y(k) and z(k) before u(k) is known, so neither may depend on u(k): D_0 = 0 and E_2 = 0, as for
    every sampled plant without feedthrough. (`simulate` knows the plant and allows both.)

    Parameters
    ----------
    settings : ControllerSettings

    Examples
    --------
    >>> from rcac_numeric import Controller, ControllerSettings, TargetModel, iir
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=2), target=TargetModel([0, 1]), R_theta=1e-6)
    >>> controller, x = Controller(settings), 0.0
    >>> for k in range(100):  # x(k+1) = 0.9 x(k) + u(k) + 1
    ...     (u,) = controller.step(y=x, z=x)
    ...     x = 0.9 * x + u + 1
    >>> bool(abs(x) < 1e-6)
    True
    """

    def __init__(self, settings: ControllerSettings) -> None:
        self.settings = settings
        self._kernel = settings.kernel()

    def step(self, y: ArrayLike, z: ArrayLike) -> Array:
        """One step of the controller.

        Parameters
        ----------
        y : array, shape (l_y,), or a number
            The measurement y(k).
        z : array, shape (l_z,), or a number
            The performance variable z(k).

        Returns
        -------
        array, shape (l_u,)
            The control u(k).

        Raises
        ------
        InputError
            Where y or z has the wrong size or is not finite; the controller has not moved.
        DivergedError
            Where the controller's own numbers have left float64.
        """
        structure = self.settings.structure
        y, z = self._sized(y, "y", structure.l_y), self._sized(z, "z", self.settings.target.l_z)
        u, finite = self._kernel.step(y, z)
        if not (finite and np.isfinite(u).all()):
            raise DivergedError(
                f"the controller left the range of float64 at step {self.k - 1}; its coefficients "
                "are no longer usable. Start a new one, with a larger R_theta or another target."
            )
        return np.asarray(u)

    @property
    def k(self) -> int:
        """Number of steps taken."""
        return int(self._kernel.k)

    @property
    def theta(self) -> Array:
        """The controller coefficients theta(k); shape (l_theta,)."""
        return np.asarray(self._kernel.theta)

    @property
    def P(self) -> Array:
        """The covariance P(k); shape (l_theta, l_theta)."""
        return np.asarray(self._kernel.P)

    @property
    def compensator(self) -> Compensator:
        """The present controller as a fixed compensator."""
        return self.settings.structure.compensator(self.theta)

    @staticmethod
    def _sized(value: ArrayLike, name: str, size: int) -> Array:
        array = real_array(value, name).reshape(-1)
        if array.size != size:
            raise InputError(f"{name} has {array.size} entries; the controller expects {size}.")
        return array
