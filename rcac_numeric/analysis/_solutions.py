"""The stabilising solution of a discrete-time Riccati equation, with accuracy measures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from compensator_theory.errors import IllConditionedError
from rcac_numeric.analysis._gramians import norm, stein_solution
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._values import Result


@dataclass(frozen=True, eq=False)
class StabilisingSolution(Result):
    """The stabilising solution of a discrete-time Riccati equation.

    Attributes
    ----------
    A, B : arrays of shape (n, n), (n, m)
    Q, R, N : arrays of shape (n, n), (m, m), (n, m)
        The weights, R_1, R_2 and R_12 of the text.
    P : array, shape (n, n)
    K : array, shape (m, n)
        The gain -(R + B'PB)^{-1} (N' + B'PA), for u = Kx.
    innovation : array, shape (m, m)
        R + B'PB.
    residual : float
        Norm of the residual of the equation over the sum of the norms of its terms.
    P_root : array, shape (n, n), or None
        S with P = S'S, for a solution by the square-root method.
    """

    A: Array
    B: Array
    Q: Array
    R: Array
    N: Array
    P: Array
    K: Array
    innovation: Array
    residual: float
    P_root: Array | None = None

    @property
    def closed_loop(self) -> Array:
        """A + BK, shape (n, n)."""
        return np.asarray(self.A + self.B @ self.K)

    @cached_property
    def poles(self) -> ComplexArray:
        """The n eigenvalues of A + BK."""
        return np.linalg.eigvals(self.closed_loop).astype(np.complex128)

    @property
    def margin(self) -> float:
        """Distance of the closed-loop poles to the unit circle, 1 - spectral radius."""
        return 1.0 - float(np.abs(self.poles).max(initial=0.0))

    @property
    def innovation_condition(self) -> float:
        """Condition number of R + B'PB with its diagonal scaled to one."""
        scale = np.sqrt(np.abs(np.diag(self.innovation)))
        scale = np.where(scale > 0, scale, 1.0)
        return float(np.linalg.cond(self.innovation / np.outer(scale, scale)))

    @cached_property
    def condition(self) -> float:
        """Bound on the relative change of P for relative changes of A, B and the weights.

        Of first order, in the 2-norm: with X = (A+BK)'X(A+BK) + I and W = [Q N; N' R],
        norm(X) norm([I; K]) (norm(W) norm([I; K]) + 2 norm((A+BK)'P) norm([A B])) over norm(P),
        or over norm(Q) where that is larger: cross terms can make P vanish.
        """
        if not self.P.any():
            return 0.0
        if not self.margin > 0:
            return np.inf
        closed = self.closed_loop
        try:
            X = stein_solution(closed.T, np.eye(len(closed)))
        except IllConditionedError:
            return np.inf
        graph = norm(np.vstack([np.eye(len(closed)), self.K]))
        weight = norm(np.block([[self.Q, self.N], [self.N.T, self.R]]))
        data = 2 * norm(closed.T @ self.P) * norm(np.hstack([self.A, self.B]))
        size = max(norm(self.P), norm(self.Q))
        return norm(X) * graph * (weight * graph + data) / size

    def __repr__(self) -> str:
        return (
            f"StabilisingSolution(n={len(self.A)}, residual={self.residual:.1e}, "
            f"margin={self.margin:.3g}, condition={self.condition:.1e})"
        )
