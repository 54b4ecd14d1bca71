"""What a controller lets its user change between two steps."""

from __future__ import annotations

from abc import ABC, abstractmethod

from numpy.typing import ArrayLike

from rcac_numeric.controllers.weights import SignalWeight
from rcac_numeric.engine import _kernel
from rcac_numeric.engine.live.changes import AppliedChange, ControllerChange
from rcac_numeric.targets.model import TargetModel


class LiveMethods(ABC):
    """Changes of a running controller; a saved state holds them too."""

    _kernel: _kernel.Controller

    @property
    def bounded(self) -> int:
        """Updates so far after which theta was moved to its bounds."""
        return int(self._kernel.bounded)

    @abstractmethod
    def change(self, change: ControllerChange, evidence: str = "") -> AppliedChange:
        """Make several changes at once, or none of them.

        Parameters
        ----------
        change : ControllerChange
        evidence : str
            Kept with what is returned.

        Raises
        ------
        InputError, ImproperError, DivergedError
            Where a part does not fit; the controller is as it was.
        """

    def set_target(self, target: TargetModel, covariance: str = "blend") -> AppliedChange:
        """Another G_f from the next step on; theta is kept.

        The past of the filter is what the new G_f makes of the stored signals, as if it had been
        there from the beginning: exactly for an FIR model, and for one with D_f as far as its poles
        have settled within 200 steps. With rho = ``sum |new - old|^2 / sum |new|^2`` of the
        filtered signals over the last 64 steps P becomes

        - "keep": what it is. The fastest to forgive where the zero hardly moved.
        - "reset": P(0). Where the old model was wrong rather than moved.
        - "blend": with P = U D U', d_j <- max(d_j, min(d_j / (1 - rho), d_j(0))), and P(0) where
          rho >= 0.999 or the number of NMP zeros changes, the default.
        - "replay": P(0), and the last 200 steps once more with the new filter; costs as much as
          they do.

        `Instantaneous` and `Gradient` keep nothing, so that nothing becomes of it; the window of a
        `SlidingWindow` is filled again from the stored signals, but for "keep".

        Parameters
        ----------
        target : TargetModel
            Of the same shape; an order up to 200 above the greatest in the settings.
        covariance : {"blend", "keep", "reset", "replay"}

        Raises
        ------
        InputError, ImproperError, DivergedError
            Where the target does not fit; the controller is as it was.

        Examples
        --------
        >>> from rcac_numeric import UD, Controller, ControllerSettings, TargetModel, iir
        >>> controller = Controller(ControllerSettings(
        ...     structure=iir(n_c=2), target=TargetModel([0, 1]), update=UD(R_theta=1e-3)))
        >>> for k in range(20):
        ...     _ = controller.step(y=k % 3, z=k % 2)
        >>> controller.set_target(TargetModel([0, 1, -1.5])).covariance  # an NMP zero came
        'reset'
        """
        return self.change(ControllerChange(target, covariance=covariance))

    def set_lambda(self, lambda_: float) -> AppliedChange:
        """Another forgetting factor from the next step on, until a scheduled one.

        Parameters
        ----------
        lambda_ : float
            In (0, 1].

        Raises
        ------
        InputError
            Where the update forgets nothing, or by a rule of its own.
        """
        return self.change(ControllerChange(lambda_=lambda_))

    def set_weights(
        self,
        R_z: ArrayLike | SignalWeight | None = None,
        R_u: ArrayLike | SignalWeight | None = None,
        R_u_unfiltered: ArrayLike | None = None,
    ) -> AppliedChange:
        """Other weights of (2.41) from the next step on; None leaves one as it is.

        Parameters
        ----------
        R_z, R_u : float, array of shape (l_z, l_z), or SignalWeight
            A function is refused, because a saved state could not hold it.
        R_u_unfiltered : float or array of shape (l_u, l_u)

        Raises
        ------
        InputError
            Where a weight has another shape, or is not definite as it should be.
        """
        return self.change(ControllerChange(R_z=R_z, R_u=R_u, R_u_unfiltered=R_u_unfiltered))
