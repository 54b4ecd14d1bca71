"""A recursive ARX model, with the update of the controller."""

from __future__ import annotations

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import integer
from rcac_numeric.compiled._estimators import make_arx
from rcac_numeric.controllers._forgetting import forgetting_factor
from rcac_numeric.identification._recursive_regression import RecursiveRegression, floor_of
from rcac_numeric.identification._zeros_of_arx import OnlineZeros, zeros_of

# Residuals this unlikely to be white say that the order is too small.
WHITE = 0.001


class RecursiveARX(RecursiveRegression):
    """z(k) = sum a_i z(k-i) + sum b_i u(k-i) + e(k), i = 1, ..., p, by UD recursive least squares.

    With `lambda_` < 1 it forgets as `SubspaceForgetting` does: nothing winds up while u is at rest.

    Parameters
    ----------
    order : int
        p; it must cover the plant and its noise. Generous is right, too small is wrong for good:
        `zeros` refuses where the residuals are not white.
    R_theta : float
        Weight of theta - 0 at the start, and the floor of what is forgotten.
    lambda_ : float
        Forgetting factor, in (0, 1].

    Raises
    ------
    InputError
        Where a setting is out of range.

    Examples
    --------
    >>> import numpy as np, scipy.signal
    >>> from rcac_numeric.identification import RecursiveARX
    >>> rng = np.random.default_rng(0)
    >>> u = rng.standard_normal(2000)
    >>> z = scipy.signal.lfilter([0, 1, -1.2], [1, -0.5, 0], u)
    >>> z = z + scipy.signal.lfilter([0.1], [1, -0.5], rng.standard_normal(2000))
    >>> fit = RecursiveARX(order=4)
    >>> fit.update(u, z)
    >>> found = fit.zeros()
    >>> found.d_zu, bool(abs(found.zeros[0] - 1.2) < 0.05), found.phases[0]
    (1, True, 'nonminimum phase')
    """

    SHOWN = ("k", "order", "lambda_", "b", "a")

    def __init__(self, order: int, *, R_theta: float = 1e-6, lambda_: float = 1.0) -> None:
        self.order = integer(order, "order", at_least=1, at_most=1000)
        self.R_theta, self.lambda_ = floor_of(R_theta), forgetting_factor(lambda_)
        super().__init__(
            make_arx(
                order=self.order,
                R_theta=self.R_theta,
                forgetting_factor=self.lambda_,
                l_u=1,
                l_y=1,
                target=0,
                theta_0=np.zeros(0),
            ),
            order=self.order,
            R_theta=self.R_theta,
            lambda_=self.lambda_,
        )

    @property
    def b(self) -> Array:
        """Coefficients of u(k-1), ..., u(k-p)."""
        return np.asarray(self._kernel.theta[: self.order])

    @property
    def a(self) -> Array:
        """Coefficients of z(k-1), ..., z(k-p)."""
        return np.asarray(self._kernel.theta[self.order :])

    @property
    def P(self) -> Array:
        """The covariance of (b, a) divided by `variance`; shape (2p, 2p)."""
        return super().P

    def excitation(self) -> float:
        """The share of R_theta in the information on the least excited coefficient of u.

        max_i P_ii R_theta over the b_i: 1 where nothing was learnt of one, near 0 where all are
        known from the data.
        """
        return float(np.max(np.diag(self.P)[: self.order])) * self.R_theta

    def estimate(self, level: float = 1.96, d_zu: int | None = None) -> OnlineZeros:
        """The estimate, whether or not the data support it; see `zeros`.

        Parameters
        ----------
        level : float
            Standard errors between a zero and the circle from which on it is decided.
        d_zu : int, optional
            The relative degree where it is known.
        """
        samples = min(self._kernel.weight, float(len(self._kernel.errors)))
        errors = np.asarray(self._kernel.errors)[len(self._kernel.errors) - int(samples) :]
        covariance = self.variance * self.P[: self.order, : self.order]
        return zeros_of(
            self.b, covariance, errors=errors, samples=self._kernel.weight, level=level, d_zu=d_zu
        )

    def zeros(self, level: float = 1.96, d_zu: int | None = None) -> OnlineZeros:
        """Relative degree, leading coefficient and zeros, if the data support them.

        Parameters
        ----------
        level : float
            Standard errors between a zero and the circle from which on it is decided.
        d_zu : int, optional
            The relative degree where it is known.

        Raises
        ------
        InputError
            Where there are fewer equations than coefficients, the data do not excite a
            coefficient of u, none is significant, or the residuals are not white: the order is
            too small, and every zero may be wrong then.
        """
        if self._kernel.weight <= 2 * self.order:
            raise InputError(
                f"{self._kernel.weight:.0f} equations do not determine {2 * self.order} "
                "coefficients; wait, or choose a smaller order."
            )
        if self.excitation() > 0.1:
            raise InputError(
                "the data do not excite every coefficient of u: for the worst, more than a tenth "
                "of "
                "the information comes from R_theta. Perturb u (a dither), or choose a smaller "
                "R_theta or order."
            )
        estimate = self.estimate(level, d_zu)
        if estimate.whiteness < WHITE:
            raise InputError(
                f"the residuals of the ARX({self.order}) are not white (probability "
                f"{estimate.whiteness:.1g}): the order is below that of the plant and its "
                "noise, and "
                "the zeros are not reliable. Choose a larger order."
            )
        return estimate
