"""The Kalman filters as data."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.definite_matrices import constant_weight, square_root_columns
from rcac_numeric.arrays.validation import number, one_of, vector
from rcac_numeric.arrays.values import Value
from rcac_numeric.estimation.models.any_model import AnyModel, any_model


@dataclass(frozen=True, eq=False, init=False)
class KalmanSettings(Value):
    """What the filters have in common: the model, what is believed at first, and the noises."""

    model: AnyModel
    Q: Array
    R: Array
    x_0: Array
    P_0: Array

    def _read(
        self,
        model: AnyModel,
        Q: ArrayLike,
        R: ArrayLike,
        x_0: ArrayLike | None,
        P_0: ArrayLike,
    ) -> None:
        set_ = partial(object.__setattr__, self)
        set_("model", any_model(model))
        set_("Q", constant_weight(Q, "Q", model.n, definite=False))
        set_("R", constant_weight(R, "R", model.l_y, definite=False))
        set_("x_0", vector(np.zeros(model.n) if x_0 is None else x_0, "x_0", model.n))
        set_("P_0", constant_weight(P_0, "P_0", model.n, definite=False))


@dataclass(frozen=True, eq=False, init=False)
class EKF(KalmanSettings):
    r"""The extended Kalman filter (8.5)-(8.8), corrected.

    K = P- H' (H P- H' + R)^-1 with P- = F P F' + Q, F taken at x(k-1|k-1) and H at x(k|k-1); as
    printed, (8.8) is one step late. The square root of P is propagated by orthogonal
    transformations, so that P cannot lose its definiteness.

    Parameters
    ----------
    model : LinearModel, SymbolicModel or NonlinearModel
    Q : array, shape (n, n), or a number
        Covariance of the noise of x in each step; a number stands for that multiple of I.
    R : array, shape (l_y, l_y), or a number
        Covariance of the noise of y.
    x_0 : array, shape (n,), optional
        What is believed of x(0) before y(0); zero by default.
    P_0 : array, shape (n, n), or a number
        Covariance of that belief.
    form : {"square root", "joseph"}
        "joseph" propagates P itself, by (I - K H) P (I - K H)' + K R K'.

    Raises
    ------
    InputError
        Where sizes do not fit, an entry is not finite, or a covariance is not semidefinite.

    Examples
    --------
    >>> from rcac_numeric.estimation import EKF, LinearModel, estimate
    >>> still = LinearModel(A=1, C=1)
    >>> estimate(EKF(still, Q=0, R=1, P_0=1), y=[2.0, 4.0]).x[-1]  # (0 + 2 + 4)/3
    array([2.])
    """

    form: str

    def __init__(
        self,
        model: AnyModel,
        Q: ArrayLike,
        R: ArrayLike,
        x_0: ArrayLike | None = None,
        P_0: ArrayLike = 1.0,
        form: str = "square root",
    ) -> None:
        self._read(model, Q, R, x_0, P_0)
        object.__setattr__(self, "form", one_of(form, "form", ("square root", "joseph")))


@dataclass(frozen=True, eq=False, init=False)
class UKF(KalmanSettings):
    """The unscented Kalman filter (8.9)-(8.24), corrected.

    2 n + 1 points x and x +- sqrt(alpha) S_i with SS' = P and the weights (alpha - n)/alpha and
    1/(2 alpha); the weights printed in (8.11) do not add up to 1. The points are drawn again after
    Q was added: as printed, the filter is not the Kalman filter where the model is linear.

    Parameters
    ----------
    model : LinearModel, SymbolicModel or NonlinearModel
    Q : array, shape (n, n), or a number
        Covariance of the noise of x in each step.
    R : array, shape (l_y, l_y), or a number
        Covariance of the noise of y.
    x_0 : array, shape (n,), optional
        What is believed of x(0) before y(0); zero by default.
    P_0 : array, shape (n, n), or a number
        Covariance of that belief.
    alpha : float, optional
        How far the points spread; max(n, 3) by default, 3 as for a Gaussian kurtosis. Below n the
        centre has a negative weight, and P may lose its definiteness, which is then said.
    beta : float
        How much more the centre weighs in covariances than in means; 0 by default, and 2 as Wan and
        van der Merwe propose for Gaussian beliefs.

    Raises
    ------
    InputError
        Where sizes do not fit, an entry is not finite, a covariance is not semidefinite, alpha
        is not positive or beta negative.

    Examples
    --------
    >>> from rcac_numeric.estimation import UKF, LinearModel, estimate
    >>> still = LinearModel(A=1, C=1)
    >>> estimate(UKF(still, Q=0, R=1, P_0=1), y=[2.0, 4.0]).x[-1].round(12)
    array([2.])
    """

    alpha: float
    beta: float

    def __init__(
        self,
        model: AnyModel,
        Q: ArrayLike,
        R: ArrayLike,
        x_0: ArrayLike | None = None,
        P_0: ArrayLike = 1.0,
        alpha: float | None = None,
        beta: float = 0.0,
    ) -> None:
        self._read(model, Q, R, x_0, P_0)
        spread = max(self.model.n, 3) if alpha is None else number(alpha, "alpha")
        if spread <= 0:
            raise InputError(f"alpha = {spread:.6g} must be positive; n = {self.model.n} is safe.")
        object.__setattr__(self, "alpha", float(spread))
        object.__setattr__(self, "beta", number(beta, "beta"))
        if self.beta < 0:
            raise InputError(f"beta = {self.beta:.6g} must not be negative; 0 and 2 are usual.")


def noise_roots(
    settings: EKF | UKF, Q: ArrayLike | None = None, R: ArrayLike | None = None
) -> tuple[Array, Array]:
    """Square roots of Q and R, those of the settings where none are given."""
    n, l_y = settings.model.n, settings.model.l_y
    return (
        square_root(settings.Q if Q is None else constant_weight(Q, "Q", n, definite=False)),
        square_root(settings.R if R is None else constant_weight(R, "R", l_y, definite=False)),
    )


def square_root(covariance: Array) -> Array:
    """A square matrix S with SS' = the covariance, lower triangular."""
    columns = square_root_columns(covariance)
    n = len(covariance)
    padded = np.zeros((n, n))
    padded[:, : columns.shape[1]] = columns
    triangular = np.asarray(np.linalg.qr(padded.T, mode="r")).T
    return np.ascontiguousarray(triangular * np.where(np.diag(triangular) < 0, -1.0, 1.0))
