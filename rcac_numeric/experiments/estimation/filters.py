"""EKF and UKF of the states and one parameter, for a model that is linear in each."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
import sympy
from numpy.typing import ArrayLike

from compensator_theory.errors import CompensatorError, DivergedError, IllConditionedError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.definite_matrices import constant_weight
from rcac_numeric.arrays.validation import matrix, one_of, vector
from rcac_numeric.estimation.estimates import estimated_record
from rcac_numeric.estimation.models.symbolic import SymbolicModel
from rcac_numeric.estimation.settings import EKF, UKF
from rcac_numeric.experiments.estimation.studies import EstimatedRun, Estimation
from rcac_numeric.experiments.estimation.true_systems import TrueSystem, columns_of, rows_of


@dataclass(frozen=True, eq=False, init=False)
class JointFilter(Estimation):
    """A filter of [x; p] with x(k+1) = (A + p A_p) x + D_1 w and y = C x, p taken as constant.

    Parameters
    ----------
    A : matrix
        Of the model, without the parameter.
    A_p : matrix
        The derivative of A with respect to the parameter.
    D_1, C : matrix
        Of the model.
    Q : numbers
        Covariance of the noise of [x; p]: a matrix, its diagonal, or a number for a multiple of I.
    R : numbers
        Covariance of the noise of y.
    x_0 : list of numbers
        What is believed of [x; p] at first.
    P_0 : numbers
        Its covariance.
    alpha : number
        Of the UKF, see {py:class}`rcac_numeric.estimation.UKF`.
    """

    kind: str
    A: Array
    A_p: Array
    D_1: Array
    C: Array
    Q: Array
    R: Array
    x_0: Array
    P_0: Array
    alpha: float | None

    def __init__(
        self,
        kind: str,
        A: ArrayLike,
        A_p: ArrayLike,
        D_1: ArrayLike,
        C: ArrayLike,
        Q: ArrayLike,
        R: ArrayLike,
        x_0: ArrayLike | None = None,
        P_0: ArrayLike = 1.0,
        alpha: float | None = None,
    ) -> None:
        set_ = partial(object.__setattr__, self)
        n = matrix(A, "A", (None, None)).shape[0]
        set_("kind", one_of(kind, "kind", ("ekf", "ukf")))
        set_("A", matrix(A, "A", (n, n)))
        set_("A_p", matrix(A_p, "A_p", (n, n)))
        set_("D_1", columns_of(D_1, "D_1", n))
        set_("C", rows_of(C, "C", n))
        set_("Q", _covariance(Q, "Q", n + 1))
        set_("R", _covariance(R, "R", self.C.shape[0]))
        set_("x_0", vector(np.zeros(n + 1) if x_0 is None else x_0, "x_0", n + 1))
        set_("P_0", _covariance(P_0, "P_0", n + 1))
        set_("alpha", alpha)
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
            found = estimated_record(self.settings, record.y, record.w)
        except (DivergedError, IllConditionedError) as error:
            return _nothing(record.truth, error)
        return EstimatedRun(found.x[:, -1].copy(), record.truth, found.innovation)


def _nothing(truth: Array, error: CompensatorError) -> EstimatedRun:
    none = np.full(len(truth), np.nan)
    return EstimatedRun(none, truth, none[:, None], outcome="diverged")


def _covariance(value: ArrayLike, name: str, n: int) -> Array:
    """A matrix, its diagonal, or a number."""
    array = np.asarray(value)
    return constant_weight(np.diag(array) if array.ndim == 1 else value, name, n, definite=False)
