"""Recursive Markov parameters, with the update of the controller."""

from __future__ import annotations

import numpy as np

from compensator_theory.errors import DivergedError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import integer
from rcac_numeric.compiled._estimators import make_mu_markov
from rcac_numeric.controllers._forgetting import forgetting_factor
from rcac_numeric.identification._mu_markov import IdentifiedMarkovParameters
from rcac_numeric.identification._recursive_regression import RecursiveRegression, floor_of
from rcac_numeric.identification._zeros import IdentifiedZeros, identified_zeros
from rcac_numeric.identification._zeros_of_arx import whiteness

# Residuals this unlikely to be white leave the correlations between the H_j unknown.
WHITE = 0.001


class RecursiveMuMarkov(RecursiveRegression):
    """The mu-Markov model (3.8) of one input and one output, by UD recursive least squares.

    z(k) = sum_{j<mu} H_j u(k-j) + sum_{j=mu}^{mu+n_mod-1} (b_j u(k-j) - a_j z(k-j)) + e(k)

    theta = (H, b, -a) minimises sum_k e(k)^2 + R_theta norm(theta)^2. With `lambda_` < 1 it forgets
    as `SubspaceForgetting` does: nothing winds up while u is at rest, and what is hardly excited is
    hardly forgotten.

    Parameters
    ----------
    mu : int
        Number of Markov parameters, 1 to 1000.
    n_mod : int
        Order of the model, 0 to 500; at least that of the plant for the model to be exact.
    R_theta : float
        Weight of theta - 0 at the start, and the floor of what is forgotten.
    lambda_ : float
        Forgetting factor, in (0, 1]. theta forgets no faster than at 1 - 1/(2 l_theta), l_theta =
        mu + 2 n_mod.

    Raises
    ------
    InputError
        Where a setting is out of range.

    Notes
    -----
    With a white input in open loop H is consistent whatever the output noise. Its covariance is
    variance P, of a residual taken as white: the error of each H_j is then right, but in coloured
    noise the H_j are correlated otherwise than P says, and where the input is coloured too each
    error is wrong. No recursion of P can know that. `identify_markov_parameters` sums the products
    of regressor and residual over lags (`NeweyWest`), and `RecursiveMarkov`, without this update's
    floor, sums them step by step. `zeros`, which needs the correlations, refuses residuals that
    are not white. With forgetting the errors are on the safe side. Source: (3.8)-(3.10); the
    update is that of `RecursiveARX`.

    Examples
    --------
    >>> import numpy as np, scipy.signal
    >>> from rcac_numeric.identification import RecursiveMuMarkov
    >>> rng = np.random.default_rng(0)
    >>> u = rng.standard_normal(2000)
    >>> z = scipy.signal.lfilter([0, 1, -1.2], [1, -0.5, 0], u) + 0.1 * rng.standard_normal(2000)
    >>> fit = RecursiveMuMarkov(mu=12, n_mod=2)
    >>> fit.update(u, z)
    >>> (fit.H[:4].round(1) + 0.0).tolist()
    [0.0, 1.0, -0.7, -0.4]
    >>> found = fit.zeros(order=2)
    >>> found.phases(), found.contains(0, 1.2)
    (('nonminimum phase',), True)
    """

    SHOWN = ("k", "mu", "n_mod", "lambda_", "samples")

    def __init__(self, mu: int, n_mod: int, *, R_theta: float = 1e-6, lambda_: float = 1.0) -> None:
        self.mu = integer(mu, "mu", at_least=1, at_most=1000)
        self.n_mod = integer(n_mod, "n_mod", at_most=500)
        self.R_theta, self.lambda_ = floor_of(R_theta), forgetting_factor(lambda_)
        super().__init__(
            make_mu_markov(
                mu=self.mu,
                n_mod=self.n_mod,
                R_theta=self.R_theta,
                forgetting_factor=self.lambda_,
            ),
            mu=self.mu,
            n_mod=self.n_mod,
            R_theta=self.R_theta,
            lambda_=self.lambda_,
        )

    @property
    def H(self) -> Array:
        """The current H_0, ..., H_(mu-1), whether or not the data support them; shape (mu,)."""
        return np.asarray(self._kernel.theta[: self.mu])

    @property
    def b(self) -> Array:
        """Coefficients of u(k-mu), ..., u(k-mu-n_mod+1)."""
        return np.asarray(self._kernel.theta[self.mu : self.mu + self.n_mod])

    @property
    def a(self) -> Array:
        """Coefficients of -z(k-mu), ..., -z(k-mu-n_mod+1), with the sign of (3.8)."""
        return -np.asarray(self._kernel.theta[self.mu + self.n_mod :])

    @property
    def samples(self) -> float:
        """The number of equations in memory, old ones by their weight."""
        return float(self._kernel.weight)

    def excitation(self) -> float:
        """The share of R_theta in the information on the least excited combination of the H_j.

        R_theta times the largest eigenvalue of P_HH: 1 where the data say nothing of one, near 0
        where they show all.

        Raises
        ------
        DivergedError
            Where the numbers left float64.
        """
        inverse = _finite(self.P[: self.mu, : self.mu])
        return float(np.linalg.eigvalsh(inverse)[-1]) * self.R_theta

    def parameters(self) -> IdentifiedMarkovParameters:
        """The Markov parameters with their standard errors, the residual taken as white.

        cov H = s^2 P_HH, s^2 = samples variance/(samples - coefficients). A standard error is at
        least the bound of rounding and the pull of R_theta, abs(R_theta P theta). `residual` has
        the last 256 errors of prediction, each scaled to the variance of e; in `condition_number`
        the regressors of H, delays of one signal, count as equally long.

        Raises
        ------
        InputError
            Where there are no more equations than coefficients, or the data do not excite H.
        DivergedError
            Where the numbers left float64.
        """
        P, theta = self.P, np.asarray(self._kernel.theta)
        inverse = _finite(P[: self.mu, : self.mu])
        if self.samples <= len(theta):
            raise InputError(
                f"{self.samples:.0f} equations do not determine {len(theta)} coefficients; wait, "
                "choose a lambda_ nearer to 1, or lower mu or n_mod."
            )
        if self.excitation() > 0.1:
            raise InputError(
                "the data do not excite every combination of the Markov parameters: for the worst, "
                "more than a tenth of the information comes from R_theta. Perturb u (a dither), or "
                "choose a smaller R_theta, mu or n_mod."
            )
        freedom = self.samples - len(theta)
        white = inverse * (self.variance * self.samples / freedom)
        condition = _condition(inverse)
        rounding = np.finfo(float).eps * self.samples * condition * float(np.abs(self.H).max())
        least = rounding + np.abs(self.R_theta * P @ theta)[: self.mu]
        covariance = white + np.diag(np.maximum(least**2 - np.diag(white), 0.0))
        return IdentifiedMarkovParameters(
            H=self.H.reshape(-1, 1, 1),
            standard_error=np.sqrt(np.diag(covariance)).reshape(-1, 1, 1),
            covariance=covariance,
            b=self.b.reshape(-1, 1, 1),
            a=self.a.reshape(-1, 1, 1),
            residual=self._errors().reshape(-1, 1),
            freedom=freedom,
            condition_number=condition,
        )

    def zeros(self, order: int | None = None, d_zu: int | None = None) -> IdentifiedZeros:
        """The zeros of the Markov parameters with their errors, as `identified_zeros` has them.

        Parameters
        ----------
        order : int, optional
            Number of states; by default as many as singular values stand out of their errors.
        d_zu : int, optional
            Relative degree; by default the index of the first significant parameter.

        Raises
        ------
        InputError
            As `parameters` and `identified_zeros`, and where the last 256 residuals are not white.
        DivergedError, IllConditionedError
            As these.
        """
        markov = self.parameters()
        errors = markov.residual[:, 0]
        probability = whiteness(errors)
        # No correlation makes of these errors more than their sum of squares: where that is below
        # the variance (no noise; it holds the start, weighted by R_theta) colour changes nothing.
        if probability < WHITE and errors @ errors > self.variance:
            raise InputError(
                f"the residuals are not white (probability {probability:.1g}), so that the H_j are "
                "correlated in a way that the recursion does not model, and the zeros' errors "
                "would be "
                "wrong. Record a window and give identify_markov_parameters(u, z, mu, n_mod) to "
                "identified_zeros, or raise n_mod if it is below the plant's order."
            )
        return identified_zeros(markov, order=order, d_zu=d_zu)

    def _errors(self) -> Array:
        errors = np.asarray(self._kernel.errors)
        return errors[len(errors) - int(min(self.samples, len(errors))) :]


def _finite(P: Array) -> Array:
    if not np.isfinite(P).all():
        raise DivergedError("the identification left the range of float64; start anew, scaled.")
    return P


def _condition(P: Array) -> float:
    """The condition number of the regressors of H, from its covariance."""
    size = np.linalg.eigvalsh(P)
    # Below that eigvalsh shows its own rounding.
    return float(np.sqrt(size[-1] / max(size[0], np.finfo(float).eps * size[-1])))
