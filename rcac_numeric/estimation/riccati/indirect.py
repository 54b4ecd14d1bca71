"""Indirect adaptive command following: RCMR finds the plant, forward Riccati gains control it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError, NotObservableError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import instance_of, integer, matrix, vector
from rcac_numeric.estimation.refinement.refinement import ModelRefinement
from rcac_numeric.estimation.refinement.settings import RCMR
from rcac_numeric.estimation.refinement.subsystems import FIRSubsystem, RepeatedParameters
from rcac_numeric.estimation.riccati.forward import ForwardEstimator, ForwardRegulator


def refined_matrices(settings: RCMR, theta: Array) -> tuple[Array, Array]:
    """(A, D_1) of the model with theta in it.

    A + B N_0 E_1 for a static proper subsystem, A + sum theta_j A_j and D_1 + sum theta_j D_j for
    repeated parameters.

    Parameters
    ----------
    settings : RCMR
    theta : array, shape (l_theta,)

    Raises
    ------
    InputError
        Where the subsystem has dynamics of its own.
    """
    part = settings.subsystem
    if isinstance(part, RepeatedParameters):
        D_1 = settings.D_1
        if part.D.shape[2]:
            D_1 = D_1 + np.tensordot(theta, part.D, 1)
        return settings.A + np.tensordot(theta, part.A, 1), D_1
    if isinstance(part, FIRSubsystem) and (part.n_c > 1 or part.strictly_proper):
        raise InputError(
            f"{part!r} has dynamics; a static one, FIRSubsystem(n_c=1), is a parameter of A."
        )
    return settings.A + settings.B @ theta.reshape(settings.l_u, -1) @ settings.E_1, settings.D_1


class IndirectController:
    """Servo control (8.91)-(8.99), corrected, of the plant that RCMR identifies meanwhile.

    The control u is the known input w of the refined model x(k+1) = A x + D_1 u + B u^. With
    gamma(k+1) = gamma(k) + r(k) - C_r x(k), u = K [x; gamma]: full-state feedback, or with an
    observer for x alone. gamma stands outside the observer: no measurement sees it, so that
    (8.100) for [x; gamma] has no stabilising solution; and (8.97) as printed has no command in it,
    its u is zero for ever.

    Parameters
    ----------
    model : RCMR
        Its D_1 is the input matrix of u; its subsystem is static.
    C_r : array, shape (1, n)
        What is to follow the command; in output feedback also what is measured.
    R_1 : array, shape (n + 1, n + 1), or a number
    R_2 : array, shape (l_u, l_u), or a number
        Weights of the regulator, P(0) = 0.
    V_1, V_2 : arrays or numbers, optional
        Covariances of the observer, Q(0) = V_1; with them `step` takes y = C_r x, else y = x.
    k_identify : int
        First step at which RCMR runs.

    Raises
    ------
    InputError
        Where a size does not fit, or only one of V_1, V_2 is given.
    NotObservableError
        Where the observer's model has a mode that C_r does not see.

    Examples
    --------
    >>> from rcac_numeric import RCMR, IndirectController
    >>> model = RCMR(A=0.9, B=1, D_1=1, C=1, E_1=1, delays=(1,), beta=10)
    >>> controller, x = IndirectController(model, C_r=1, R_1=1, R_2=1), 0.0
    >>> for k in range(300):
    ...     (u,) = controller.step(y=x, r=1)
    ...     x = 1.1 * x + u  # 0.2 more than the model has
    >>> round(float(x), 5), controller.theta.round(3)
    (1.0, array([0.2]))
    """

    def __init__(
        self,
        model: RCMR,
        C_r: ArrayLike,
        R_1: ArrayLike,
        R_2: ArrayLike,
        V_1: ArrayLike | None = None,
        V_2: ArrayLike | None = None,
        k_identify: int = 0,
    ) -> None:
        self.model = instance_of(model, "model", RCMR)
        n = model.n
        row = np.asarray(C_r)
        self.C_r = matrix(row.reshape(1, -1) if row.ndim == 1 else row, "C_r", (1, n))
        self.k_identify = integer(k_identify, "k_identify")
        refined_matrices(model, model.theta_0)
        self.regulator = ForwardRegulator(n + 1, model.l_w, R_1, R_2)
        if (V_1 is None) != (V_2 is None):
            raise InputError("an observer needs both V_1 and V_2; full-state feedback neither.")
        self.estimator: ForwardEstimator | None = None
        if V_1 is not None and V_2 is not None:
            self.estimator = ForwardEstimator(n, 1, V_1, V_2, V_1)
            self._require_observable()
        self.refinement = ModelRefinement(model)
        self.x_c = np.array(model.x_0)
        self.gamma, self.k = 0.0, 0
        self._A_a, self._B_a = np.eye(n + 1), np.zeros((n + 1, model.l_w))
        self._A_a[-1, :-1] = -self.C_r[0]

    def _require_observable(self) -> None:
        A, _ = refined_matrices(self.model, self.model.theta_0)
        rows = [self.C_r]
        for _ in range(self.model.n - 1):
            rows.append(rows[-1] @ A)
        scaled = [row / max(np.abs(row).max(), np.finfo(float).tiny) for row in rows]
        rank = np.linalg.matrix_rank(np.vstack(scaled), tol=1e-12)
        if rank < self.model.n:
            raise NotObservableError(
                f"C_r sees {rank} of the {self.model.n} modes of the model: an observer cannot "
                "correct the others. Measure more, or use full-state feedback."
            )

    def step(self, y: ArrayLike, r: float, y_model: ArrayLike | None = None) -> Array:
        """u(k) from the measurement and the command.

        Parameters
        ----------
        y : array
            x(k), shape (n,), or C_r x(k) where there is an observer.
        r : float
            The command.
        y_model : array, shape (l_y,), optional
            What RCMR compares C x^ with; by default C times the measured or observed state.

        Returns
        -------
        array, shape (l_w,)
            u(k).

        Raises
        ------
        InputError
            Where a size does not fit or an entry is not finite; nothing has moved.
        DivergedError
            Where the model or a Riccati matrix left the range of float64.
        """
        model = self.model
        command = float(vector(r, "r", 1)[0])
        measured = vector(y, "y", model.n if self.estimator is None else 1)
        x = self.x_c if self.estimator is not None else measured
        seen = model.C @ x if y_model is None else vector(y_model, "y_model", model.l_y)
        if self.k >= self.k_identify:
            self.refinement.measure(seen, x)
        A, B = refined_matrices(model, self.refinement.theta)
        self._A_a[:-1, :-1], self._B_a[:-1] = A, B
        K = self.regulator.moved(self._A_a, self._B_a)
        u = K @ np.append(x, self.gamma)
        output = float(measured[0]) if self.estimator is not None else float((self.C_r @ x)[0])
        if self.estimator is not None:
            F = self.estimator.moved(A, self.C_r)
            self.x_c = A @ x + B @ u + F @ (measured - self.C_r @ x)
        if self.k >= self.k_identify:
            self.refinement.advance(u)
        self.gamma += command - output
        self.k += 1
        return np.asarray(u)

    @property
    def theta(self) -> Array:
        """The parameters that RCMR has found."""
        return self.refinement.theta
