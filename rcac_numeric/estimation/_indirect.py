"""Indirect adaptive command following: RCMR and forward Riccati gains."""

from __future__ import annotations

from functools import partial

import attrs
import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError, NotObservableError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight
from rcac_numeric.arrays._validation import (
    array_like,
    instance_of,
    integer,
    matrix,
    optional_array_like,
    reads,
    vector,
    with_checks,
)
from rcac_numeric.controllers._stepwise import Stepper, StepwiseController
from rcac_numeric.engine._runs import RECORDS
from rcac_numeric.estimation._forward import ForwardEstimator, ForwardRegulator
from rcac_numeric.estimation._refinement import ModelRefinement
from rcac_numeric.estimation._refinement_settings import RCMR
from rcac_numeric.estimation._resumable import Resumable
from rcac_numeric.estimation._subsystems import FIRSubsystem, RepeatedParameters


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class IndirectSettings(StepwiseController):
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
        Covariances of the observer, Q(0) = V_1; with them the measurement is y = C_r x, else y = x.
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
    In `simulate`, as any other controller; the plant has 0.2 more than the model:

    >>> from rcac_numeric import Plant, Step, exogenous, simulate
    >>> from rcac_numeric.estimation import RCMR, IndirectSettings
    >>> model = RCMR(A=0.9, B=1, D_1=1, C=1, E_1=1, delays=(1,), beta=10)
    >>> settings = IndirectSettings(model, C_r=1, R_1=1, R_2=1)
    >>> plant = Plant(A=1.1, B=1, D_1=0, C=1, D_0=0, D_2=0, E_1=-1, E_2=0, E_0=1, blocks={"r": 1})
    >>> run = simulate(plant, settings, exogenous([Step()], steps=300))
    >>> bool(abs(run.z[-1, 0]) < 1e-5), run.theta_final.round(3)
    (True, array([0.2]))
    """

    model: RCMR = attrs.field(metadata=reads(instance_of, kind=RCMR))
    C_r: Array = attrs.field(converter=array_like)
    R_1: Array = attrs.field(converter=array_like)
    R_2: Array = attrs.field(converter=array_like)
    V_1: Array | None = attrs.field(default=None, converter=optional_array_like)
    V_2: Array | None = attrs.field(default=None, converter=optional_array_like)
    k_identify: int = attrs.field(default=0, metadata=reads(integer))

    def __attrs_post_init__(self) -> None:
        set_ = partial(object.__setattr__, self)
        model, V_1, V_2 = self.model, self.V_1, self.V_2
        row = np.asarray(self.C_r)
        set_("C_r", matrix(row.reshape(1, -1) if row.ndim == 1 else row, "C_r", (1, model.n)))
        refined_matrices(model, model.theta_0)
        set_("R_1", constant_weight(self.R_1, "R_1", model.n + 1, definite=False))
        set_("R_2", constant_weight(self.R_2, "R_2", model.l_w, definite=True))
        if (V_1 is None) != (V_2 is None):
            raise InputError(
                "an observer needs both V_1 and V_2; full-state feedback needs neither."
            )
        set_("V_1", None if V_1 is None else constant_weight(V_1, "V_1", model.n, definite=False))
        set_("V_2", None if V_2 is None else constant_weight(V_2, "V_2", 1, definite=True))
        if self.has_observer:
            require_observable(model, self.C_r)

    @property
    def has_observer(self) -> bool:
        """Whether the controller measures C_r x alone, and has an observer."""
        return self.V_1 is not None

    @property
    def l_u(self) -> int:
        """Number of controls."""
        return self.model.l_w

    @property
    def l_y(self) -> int:
        """Number of measurements: 1 with an observer, else n."""
        return 1 if self.has_observer else self.model.n

    @property
    def l_r(self) -> int:
        """1: the command."""
        return 1

    @property
    def l_theta(self) -> int:
        """Number of parameters that RCMR estimates."""
        return self.model.l_theta

    def started(self) -> Stepper:
        """The controller at step 0."""
        return IndirectController(self)


RECORDS.include(IndirectSettings, RCMR, FIRSubsystem, RepeatedParameters)  # of saved runs


class IndirectController(Resumable[IndirectSettings]):
    """Indirect adaptive control beside a simulator or a device.

    Parameters
    ----------
    settings : IndirectSettings

    Examples
    --------
    >>> from rcac_numeric.estimation import RCMR, IndirectController, IndirectSettings
    >>> model = RCMR(A=0.9, B=1, D_1=1, C=1, E_1=1, delays=(1,), beta=10)
    >>> controller = IndirectController(IndirectSettings(model, C_r=1, R_1=1, R_2=1))
    >>> x = 0.0
    >>> for k in range(300):
    ...     (u,) = controller.step(y=x, r=1)
    ...     x = 1.1 * x + u  # 0.2 more than the model has
    >>> round(float(x), 5), controller.theta.round(3)
    (1.0, array([0.2]))
    """

    kind = "indirect controller"

    def __init__(self, settings: IndirectSettings) -> None:
        super().__init__(instance_of(settings, "settings", IndirectSettings))
        model, n = settings.model, settings.model.n
        self.regulator = ForwardRegulator(n + 1, model.l_w, settings.R_1, settings.R_2)
        self.estimator: ForwardEstimator | None = None
        if settings.V_1 is not None and settings.V_2 is not None:
            self.estimator = ForwardEstimator(n, 1, settings.V_1, settings.V_2, settings.V_1)
        self.refinement = ModelRefinement(model)
        self.x_c = np.array(model.x_0)
        self.gamma, self._k = 0.0, 0
        self._A_a, self._B_a = np.eye(n + 1), np.zeros((n + 1, model.l_w))
        self._A_a[-1, :-1] = -settings.C_r[0]

    def step(self, y: ArrayLike, r: ArrayLike, y_model: ArrayLike | None = None) -> Array:
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
        model, C_r = self.settings.model, self.settings.C_r
        command = float(vector(r, "r", 1)[0])
        measured = vector(y, "y", self.settings.l_y)
        x = self.x_c if self.estimator is not None else measured
        measured_output = model.C @ x if y_model is None else vector(y_model, "y_model", model.l_y)
        identifies = self._k >= self.settings.k_identify
        if identifies:
            self.refinement.measure(measured_output, x)
        A, B = refined_matrices(model, self.refinement.theta)
        self._A_a[:-1, :-1], self._B_a[:-1] = A, B
        K = self.regulator.moved(self._A_a, self._B_a)
        u = K @ np.append(x, self.gamma)
        output = float(measured[0]) if self.estimator is not None else float((C_r @ x)[0])
        if self.estimator is not None:
            F = self.estimator.moved(A, C_r)
            self.x_c = A @ x + B @ u + F @ (measured - C_r @ x)
        if identifies:
            self.refinement.advance(u)
        self.gamma += command - output
        self._k += 1
        return np.asarray(u)

    @property
    def k(self) -> int:
        """Number of steps taken."""
        return self._k

    @property
    def theta(self) -> Array:
        """The parameters that RCMR has identified."""
        return self.refinement.theta

    def save(self) -> Array:
        """Every number that later steps depend on."""
        parts = [np.array([self._k, self.gamma]), self.x_c, self.regulator.P.ravel()]
        if self.estimator is not None:
            parts.append(self.estimator.Q.ravel())
        return np.concatenate([*parts, self.refinement.save()])

    def take_up(self, values: Array) -> None:
        """Continue from a saved state."""
        n, read = self.settings.model.n, iter(np.split(values, self._ends()))
        k, gamma = next(read)
        x_c, P = next(read).copy(), next(read).reshape(n + 1, n + 1)
        Q = None if self.estimator is None else next(read).reshape(n, n)
        self.refinement.take_up(np.ascontiguousarray(next(read)))
        self._k, self.gamma, self.x_c = int(k), float(gamma), x_c
        self.regulator.go_on(P, self._k)
        if self.estimator is not None and Q is not None:
            self.estimator.go_on(Q, self._k)

    def _ends(self) -> list[int]:
        """The ends of the parts of `save`."""
        n = self.settings.model.n
        widths = [2, n, (n + 1) ** 2, *([] if self.estimator is None else [n * n])]
        return [sum(widths[: i + 1]) for i in range(len(widths))]


# The model of RCMR with what it has found in it, and whether an observer sees it.


def refined_matrices(settings: RCMR, theta: Array) -> tuple[Array, Array]:
    """(A, D_1) of the model with theta in it.

    A + B N_0 E_1 for a static proper subsystem, A + sum theta_j A_j and D_1 + sum theta_j D_j for
    repeated parameters.
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


def require_observable(settings: RCMR, C: Array) -> None:
    """Raise where an observer of the model with theta_0 could not correct some mode."""
    A, _ = refined_matrices(settings, settings.theta_0)
    rows = [C]
    for _ in range(settings.n - 1):
        rows.append(rows[-1] @ A)
    scaled = [row / max(np.abs(row).max(), np.finfo(float).tiny) for row in rows]
    rank = np.linalg.matrix_rank(np.vstack(scaled), tol=1e-12)
    if rank < settings.n:
        raise NotObservableError(
            f"C_r observes {rank} of the {settings.n} modes of the model: an observer cannot "
            "correct "
            "the others. Measure more, or use full-state feedback."
        )
