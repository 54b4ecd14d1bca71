"""Forward-propagating Riccati gains: LQR and its dual for a plant known only at present."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import DivergedError, IllConditionedError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight
from rcac_numeric.arrays._validation import integer, matrix
from rcac_numeric.arrays._values import ShowsState


class ForwardRegulator(ShowsState):
    r"""The gain (8.95) with P propagated forward by (8.96).

    K(k) = -(R_2 + B'PB)^-1 B'PA and P(k+1) = (A + BK)'P(A + BK) + K'R_2 K + R_1, which is (8.96)
    and keeps P semidefinite. For constant (A, B) the gain converges to that of the Riccati
    equation; for a changing plant nothing guarantees stability, as for any gain that knows the
    present only.

    Parameters
    ----------
    n, l_u : int
        Numbers of states and of inputs.
    R_1 : array, shape (n, n), or a number
        Weight of the state; semidefinite.
    R_2 : array, shape (l_u, l_u), or a number
        Weight of the input; definite.
    P_0 : array, shape (n, n), or a number
        P(0), semidefinite; zero by default.

    Raises
    ------
    InputError
        Where sizes do not fit or a weight is not definite.

    Examples
    --------
    >>> from rcac_numeric.estimation import ForwardRegulator
    >>> regulator = ForwardRegulator(n=1, l_u=1, R_1=1, R_2=1)
    >>> for k in range(50):
    ...     K = regulator.step(A=1, B=1)
    >>> K.round(6)  # P = (1 + sqrt(5))/2
    array([[-0.618034]])
    """

    SHOWN = ("k", "P")

    def __init__(
        self, n: int, l_u: int, R_1: ArrayLike, R_2: ArrayLike, P_0: ArrayLike = 0.0
    ) -> None:
        self.n, self.l_u = integer(n, "n", at_least=1), integer(l_u, "l_u", at_least=1)
        self.R_1 = constant_weight(R_1, "R_1", self.n, definite=False)
        self.R_2 = constant_weight(R_2, "R_2", self.l_u, definite=True)
        self.P = np.array(constant_weight(P_0, "P_0", self.n, definite=False))
        self.k = 0

    def step(self, A: ArrayLike, B: ArrayLike) -> Array:
        """K(k) of the plant at step k; then P moves to k + 1.

        Parameters
        ----------
        A : array, shape (n, n)
        B : array, shape (n, l_u)

        Returns
        -------
        array, shape (l_u, n)
            K(k), for u = K x.

        Raises
        ------
        InputError
            Where a shape does not fit or an entry is not finite; P has not moved.
        IllConditionedError
            Where R_2 + B'PB is singular in float64.
        DivergedError
            Where P leaves the range of float64: the plant is unstable and not stabilisable.
        """
        return self.moved(matrix(A, "A", (self.n, self.n)), matrix(B, "B", (self.n, self.l_u)))

    def go_on(self, P: Array, k: int) -> None:
        """Take up an earlier P(k)."""
        self.P, self.k = np.array(P), k

    def moved(self, a: Array, b: Array) -> Array:
        """`step` for arrays that were checked."""
        PB = self.P @ b
        try:
            K = np.asarray(-np.linalg.solve(self.R_2 + b.T @ PB, PB.T @ a), dtype=float)
        except np.linalg.LinAlgError:
            raise IllConditionedError(
                f"R_2 + B'PB is singular at step {self.k}; use a larger R_2."
            ) from None
        with np.errstate(over="ignore", invalid="ignore"):
            closed = a + b @ K
            P = closed.T @ self.P @ closed + K.T @ self.R_2 @ K + self.R_1
            finite = np.isfinite(P.sum() + K.sum())
        if not finite:
            raise DivergedError(
                f"P left the range of float64 at step {self.k}: (A, B) is not stabilisable. See "
                "that every unstable mode is controllable."
            )
        self.P, self.k = (P + P.T) / 2, self.k + 1
        return K


class ForwardEstimator(ShowsState):
    """The dual: the observer gain (8.99) with Q propagated forward by (8.100).

    F(k) = A Q C' (C Q C' + V_2)^-1 and Q(k+1) = (A - FC) Q (A - FC)' + F V_2 F' + V_1, for the
    observer x(k+1) = A x + B u + F (y - C x).

    Parameters
    ----------
    n, l_y : int
        Numbers of states and of measurements.
    V_1 : array, shape (n, n), or a number
        Covariance of the disturbance; semidefinite.
    V_2 : array, shape (l_y, l_y), or a number
        Covariance of the noise; definite.
    Q_0 : array, shape (n, n), or a number
        Q(0), semidefinite.

    Raises
    ------
    InputError
        Where sizes do not fit or a covariance is not definite.

    Examples
    --------
    >>> from rcac_numeric.estimation import ForwardEstimator
    >>> estimator = ForwardEstimator(n=1, l_y=1, V_1=1, V_2=1)
    >>> for k in range(50):
    ...     F = estimator.step(A=1, C=1)
    >>> F.round(6)
    array([[0.618034]])
    """

    SHOWN = ("k", "Q")

    def __init__(
        self, n: int, l_y: int, V_1: ArrayLike, V_2: ArrayLike, Q_0: ArrayLike = 0.0
    ) -> None:
        states, measured = integer(n, "n", at_least=1), integer(l_y, "l_y", at_least=1)
        self._dual = ForwardRegulator(
            states,
            measured,
            constant_weight(V_1, "V_1", states, definite=False),
            constant_weight(V_2, "V_2", measured, definite=True),
            constant_weight(Q_0, "Q_0", states, definite=False),
        )

    @property
    def Q(self) -> Array:
        """Q(k), shape (n, n)."""
        return self._dual.P

    @property
    def k(self) -> int:
        """Number of steps taken."""
        return self._dual.k

    def step(self, A: ArrayLike, C: ArrayLike) -> Array:
        """F(k) of the plant at step k; then Q moves to k + 1.

        Parameters
        ----------
        A : array, shape (n, n)
        C : array, shape (l_y, n)

        Returns
        -------
        array, shape (n, l_y)
            F(k).

        Raises
        ------
        DivergedError
            Where Q leaves the range of float64: a growing mode is not seen by C.
        """
        n, l_y = self._dual.n, self._dual.l_u
        return self.moved(matrix(A, "A", (n, n)), matrix(C, "C", (l_y, n)))

    def go_on(self, Q: Array, k: int) -> None:
        """Take up an earlier Q(k)."""
        self._dual.go_on(Q, k)

    def moved(self, a: Array, c: Array) -> Array:
        """`step` for arrays that were checked."""
        try:
            return np.ascontiguousarray(-self._dual.moved(a.T, c.T).T)
        except IllConditionedError:
            raise IllConditionedError(
                f"C Q C' + V_2 is singular at step {self.k}; use a larger V_2."
            ) from None
        except DivergedError:
            raise DivergedError(
                f"Q left the range of float64 at step {self.k}: (A, C) is not detectable. See that "
                "every unstable mode is observable."
            ) from None
