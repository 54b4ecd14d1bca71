"""Estimators of one parameter: Kalman filters of [x; p], and RCMR on a record or in a loop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, ClassVar, Literal

import attrs
import numpy as np
import sympy
from numpy.typing import ArrayLike

from compensator_theory.errors import (
    CompensatorError,
    DivergedError,
    IllConditionedError,
    InputError,
)
from rcac_experiments.experiments._estimation_studies import EstimatedRun, Estimation
from rcac_experiments.experiments._true_systems import TrueSystem, columns_of, rows_of
from rcac_experiments.format._values import Numbers
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight
from rcac_numeric.arrays._validation import instance_of, integer, matrix, number, vector
from rcac_numeric.engine._simulation import simulate
from rcac_numeric.estimation._estimates import estimated_record
from rcac_numeric.estimation._indirect import IndirectSettings
from rcac_numeric.estimation._refinement import refined_record
from rcac_numeric.estimation._refinement_settings import RCMR
from rcac_numeric.estimation._settings import EKF, UKF
from rcac_numeric.estimation._subsystems import FIRSubsystem, RepeatedParameters
from rcac_numeric.estimation._symbolic import SymbolicModel
from rcac_numeric.plants._linear import Plant

OF_MODEL = "Of the model."


@attrs.frozen(eq=False, slots=False)
class JointFilter(Estimation):
    """A filter of [x; p] with x(k+1) = (A + p A_p) x + D_1 w and y = C x, p taken as constant."""

    kind: ClassVar[str]

    A: Annotated[Array, "Of the model, without the parameter."]
    A_p: Annotated[Array, "The derivative of A with respect to the parameter."]
    D_1: Annotated[Array, OF_MODEL]
    C: Annotated[Array, OF_MODEL]
    Q: Annotated[
        Array,
        "Covariance of the noise of [x; p]: a matrix, its diagonal, or a number for a multiple of"
        " I.",
    ]
    R: Annotated[Array, "Covariance of the noise of y."]
    x_0: Annotated[Array | None, "What is believed of [x; p] at first."] = None
    P_0: Annotated[float | Array, Numbers(), "Its covariance."] = 1.0
    alpha: Annotated[float | None, "Of the UKF, see {py:class}`rcac_numeric.estimation.UKF`."] = (
        None
    )

    def __attrs_post_init__(self) -> None:
        set_ = partial(object.__setattr__, self)
        n = matrix(self.A, "A", (None, None)).shape[0]
        set_("A", matrix(self.A, "A", (n, n)))
        set_("A_p", matrix(self.A_p, "A_p", (n, n)))
        set_("D_1", columns_of(self.D_1, "D_1", n))
        set_("C", rows_of(self.C, "C", n))
        set_("Q", _covariance(self.Q, "Q", n + 1))
        set_("R", _covariance(self.R, "R", self.C.shape[0]))
        first = np.zeros(n + 1) if self.x_0 is None else self.x_0
        set_("x_0", vector(first, "x_0", n + 1))
        set_("P_0", _covariance(self.P_0, "P_0", n + 1))
        self.settings  # noqa: B018  # raises where something does not fit

    @property
    def settings(self) -> EKF | UKF:
        """The filter for `estimate`."""
        x = sympy.symbols(f"x:{len(self.A)}")
        w = sympy.symbols(f"w:{self.D_1.shape[1]}")
        p, state = sympy.Symbol("p"), sympy.Matrix(x)
        moved = sympy.Matrix(self.A) * state + sympy.Matrix(self.D_1) * sympy.Matrix(w)
        moved += p * (sympy.Matrix(self.A_p) * state)
        model = SymbolicModel(list(moved), list(sympy.Matrix(self.C) * state), x, w, [p])
        if self.kind == "ekf":
            return EKF(model, self.Q, self.R, self.x_0, self.P_0)
        return UKF(model, self.Q, self.R, self.x_0, self.P_0, self.alpha)

    @property
    def words(self) -> str:
        """EKF or UKF."""
        return self.kind.upper()

    def execute(self, system: TrueSystem, steps: int, seed: int) -> EstimatedRun:
        """Estimate with the record of one seed."""
        record = system.record(steps, seed)
        try:
            record_of_estimates = estimated_record(self.settings, record.y, record.w)
        except (DivergedError, IllConditionedError) as error:
            return _nothing(record.truth, error)
        return EstimatedRun(
            record_of_estimates.x[:, -1].copy(), record.truth, record_of_estimates.innovation
        )


@attrs.frozen(eq=False, slots=False)
class ExtendedFilter(JointFilter):
    """A filter of [x; p] with x(k+1) = (A + p A_p) x + D_1 w and y = C x, p taken as constant."""

    kind = "ekf"


@attrs.frozen(eq=False, slots=False)
class UnscentedFilter(JointFilter):
    """A filter of [x; p] with x(k+1) = (A + p A_p) x + D_1 w and y = C x, p taken as constant."""

    kind = "ukf"


def _nothing(truth: Array, error: CompensatorError) -> EstimatedRun:
    none = np.full(len(truth), np.nan)
    return EstimatedRun(none, truth, none[:, None], outcome="diverged")


def _covariance(value: ArrayLike, name: str, n: int) -> Array:
    """A matrix, its diagonal, or a number."""
    array = np.asarray(value)
    return constant_weight(np.diag(array) if array.ndim == 1 else value, name, n, definite=False)


@dataclass(frozen=True, eq=False)
class Refinement(Estimation):
    """RCMR of one parameter.

    Attributes
    ----------
    model : RCMR
        With one coefficient.
    offset : float
        Offset: the estimate is theta plus this.
    """

    model: RCMR
    offset: float = 0.0

    def __post_init__(self) -> None:
        if instance_of(self.model, "model", RCMR).l_theta != 1:
            raise InputError(f"RCMR has {self.model.l_theta} coefficients; an example has one.")

    @property
    def words(self) -> str:
        """RCMR."""
        return "RCMR"

    def execute(self, system: TrueSystem, steps: int, seed: int) -> EstimatedRun:
        """Estimate with the record of one seed."""
        record = system.record(steps, seed)
        try:
            refinement = refined_record(self.model, record.w, record.y)
        except DivergedError:
            none = np.full(steps, np.nan)
            return EstimatedRun(none, record.truth, none[:, None], outcome="diverged")
        initial_share = float(refinement.evidence.kept.max())
        return EstimatedRun(
            self.offset + refinement.theta[:, 0], record.truth, refinement.z, initial_share
        )


@dataclass(frozen=True, eq=False)
class IndirectLoop(Estimation):
    """Indirect adaptive control of the true system, D_1 being where the control acts.

    Attributes
    ----------
    controller : IndirectSettings
    command : float
        The height of the step r(k).
    """

    controller: IndirectSettings
    command: float

    @property
    def words(self) -> str:
        """The measurement that is fed back."""
        fed_back = "output" if self.controller.has_observer else "full state"
        return f"RCMR and FPRE, {fed_back}"

    def execute(self, system: TrueSystem, steps: int, seed: int) -> EstimatedRun:
        """Return the loop, up to a divergence."""
        plant = system.schedule(self._plant)
        r = np.full(steps, self.command)
        with np.errstate(all="ignore"):  # a loop that leaves float64 is reported
            run = simulate(plant, self.controller, r, x_0=system.x_0)
        outcome = "completed" if run.outcome == "completed" else "diverged"
        truth = system.parameter_trajectory(steps)
        return EstimatedRun(run.theta[:, 0], truth[: run.steps], run.z, outcome=outcome)

    def _plant(self, A: Array, D_1: Array, C: Array) -> Plant:
        """The true system with the command in w, the fed-back output in y, and r - C_r x in z."""
        C_r = self.controller.C_r
        measured = C_r if self.controller.has_observer else np.eye(len(A))
        l_y, l_u = len(measured), D_1.shape[1]
        return Plant(
            A=A, B=D_1, D_1=np.zeros((len(A), 1)), C=measured, D_0=np.zeros((l_y, l_u)),
            D_2=np.zeros((l_y, 1)), E_1=-C_r, E_2=np.zeros((1, l_u)), E_0=[[1.0]], blocks={"r": 1},
        )  # fmt: skip


def refined(
    A: ArrayLike,
    D_1: ArrayLike,
    C: ArrayLike,
    B: ArrayLike | None = None,
    E_1: ArrayLike | None = None,
    A_p: ArrayLike | None = None,
    D_p: ArrayLike | None = None,
    strictly_proper: bool = False,
    beta: float = 1.0,
    lambda_: float = 1.0,
    delays: Sequence[int] | None = None,
    window: int | None = None,
    d: int | None = None,
    method: Literal["nearest", "smallest", "pseudoinverse", "direct"] = "nearest",
    eta_bar: float = 0.0,
    k_update: int | None = None,
    theta_0: float = 0.0,
    x_0: ArrayLike | None = None,
    offset: float = 0.0,
) -> Refinement:
    """RCMR of one parameter, {py:class}`rcac_numeric.estimation.RCMR`.

    Parameters
    ----------
    A, D_1, C : matrix
        Of the model, at theta = 0.
    B, E_1 : matrix
        Where a subsystem acts and what it reads: its output is theta E_1 x.
    A_p, D_p : matrix
        In place of B and E_1: the derivatives of A and D_1 with respect to theta.
    strictly_proper : bool
        The subsystem is one step late, as (8.57) prints it.
    beta : number
        P(0).
    lambda_ : number
        Forgetting factor.
    delays : list of steps
        The Markov parameters H_i in H~; [2] where they are left out.
    window : int
        In place of delays: all from 1 to this.
    d : int
        Which u*(k - d) theta is fitted to.
    method : {"nearest", "smallest", "pseudoinverse", "direct"}
        How u* is reconstructed.
    eta_bar : number
        Regularisation (8.51).
    k_update : int
        First step with an update.
    theta_0 : number
        Initial estimate.
    x_0 : list of numbers
        Initial state of the model.
    offset : number
        Offset: the estimate is theta plus this.
    """
    options: dict[str, Any] = {"B": B, "E_1": E_1, "subsystem": FIRSubsystem(1, strictly_proper)}
    if A_p is not None:
        l_p = np.asarray(A_p)[None]
        D = None if D_p is None else columns_of(D_p, "D_p", l_p.shape[1])[None]
        options = {"subsystem": RepeatedParameters(l_p, D)}
        if B is not None or E_1 is not None:
            raise InputError("A_p defines where theta acts; leave B and E_1 out.")
    listed: Sequence[int] = (2,) if delays is None else delays
    if window is not None:
        listed = range(1, integer(window, "window", at_least=1) + 1)
        if delays is not None:
            raise InputError("window defines the delays; leave delays out.")
    model = RCMR(
        A, D_1, C, **options, beta=beta, lambda_=lambda_, delays=tuple(listed), d=d, method=method,
        eta_bar=eta_bar, k_update=k_update, theta_0=[theta_0], x_0=x_0,
    )  # fmt: skip
    return Refinement(model, number(offset, "offset"))


def controlled(
    A: ArrayLike,
    D_1: ArrayLike,
    C: ArrayLike,
    B: ArrayLike,
    E_1: ArrayLike,
    C_r: ArrayLike,
    R_1: float,
    R_2: float,
    command: float,
    V_1: float | None = None,
    V_2: float | None = None,
    k_identify: int = 0,
    beta: float = 1.0,
    lambda_: float = 1.0,
    delays: Sequence[int] | None = None,
    k_update: int | None = None,
    theta_0: float = 0.0,
) -> IndirectLoop:
    """RCMR and forward gains in a loop, {py:class}`rcac_numeric.estimation.IndirectSettings`.

    Parameters
    ----------
    A, D_1, C : matrix
        Of the model, at theta = 0; D_1 is where the control acts, C what RCMR compares.
    B, E_1 : matrix
        Where theta acts and what it reads.
    C_r : matrix
        The output that follows the command.
    R_1, R_2 : number
        Weights of the regulator.
    command : number
        Height of the step.
    V_1, V_2 : number
        Covariances of the observer; the full state is fed back where they are left out.
    k_identify : int
        First step at which RCMR runs.
    beta, lambda_ : number
        P(0) of RCMR, and its forgetting factor.
    delays : list of steps
        The Markov parameters H_i in H~; [1] where they are left out.
    k_update : int
        First step with an update.
    theta_0 : number
        Initial estimate.
    """
    model = RCMR(A, D_1, C, B=B, E_1=E_1, beta=beta, lambda_=lambda_, delays=tuple(delays or (1,)),
                 k_update=k_update, theta_0=[theta_0])  # fmt: skip
    settings = IndirectSettings(model, C_r, R_1, R_2, V_1, V_2, k_identify)
    return IndirectLoop(settings, number(command, "command"))
