"""The Kalman filters as data."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial

import attrs
import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight, square_root_columns
from rcac_numeric.arrays._validation import (
    array_like,
    instance_of,
    integer,
    items,
    matrix,
    number,
    one_of,
    optional_array_like,
    optional_number,
    reads,
    vector,
    with_checks,
)
from rcac_numeric.arrays._values import Value
from rcac_numeric.estimation._any_model import AnyModel, any_model


@attrs.frozen(eq=False, slots=False)
class KalmanSettings(Value):
    """Common settings of the filters: model, initial estimate, noises."""

    model: AnyModel
    Q: Array = attrs.field(converter=array_like)
    R: Array = attrs.field(converter=array_like)
    x_0: Array = attrs.field(default=None, converter=optional_array_like)
    P_0: Array = attrs.field(default=1.0, converter=array_like)

    def __attrs_post_init__(self) -> None:
        set_ = partial(object.__setattr__, self)
        model = any_model(self.model)
        set_("Q", constant_weight(self.Q, "Q", model.n, definite=False))
        set_("R", constant_weight(self.R, "R", model.l_y, definite=False))
        set_("x_0", vector(np.zeros(model.n) if self.x_0 is None else self.x_0, "x_0", model.n))
        set_("P_0", constant_weight(self.P_0, "P_0", model.n, definite=False))


@attrs.frozen(eq=False, slots=False)
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

    form: str = "square root"

    def __attrs_post_init__(self) -> None:
        super().__attrs_post_init__()
        one_of(self.form, "form", ("square root", "joseph"))


@attrs.frozen(eq=False, slots=False)
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
        centre has a negative weight, and P may lose its definiteness, which is then reported.
    beta : float
        How much more the centre weighs in covariances than in means; 0 by default, and 2 as Wan and
        van der Merwe propose for Gaussian beliefs.

    Raises
    ------
    InputError
        Where sizes do not fit, an entry is not finite, a covariance is not semidefinite, alpha
        is not positive or beta negative.

    Notes
    -----
    Source: S. J. Julier and J. K. Uhlmann, Unscented filtering and nonlinear estimation,
    Proceedings of the IEEE 92 (2004).

    Examples
    --------
    >>> from rcac_numeric.estimation import UKF, LinearModel, estimate
    >>> still = LinearModel(A=1, C=1)
    >>> estimate(UKF(still, Q=0, R=1, P_0=1), y=[2.0, 4.0]).x[-1].round(12)
    array([2.])
    """

    alpha: float = attrs.field(default=None, converter=optional_number)
    beta: float = 0.0

    def __attrs_post_init__(self) -> None:
        super().__attrs_post_init__()
        n = self.model.n
        spread = max(n, 3) if self.alpha is None else number(self.alpha, "alpha")
        if spread <= 0:
            raise InputError(f"alpha = {spread:.6g} must be positive; n = {n} is safe.")
        object.__setattr__(self, "alpha", float(spread))
        object.__setattr__(self, "beta", number(self.beta, "beta"))
        if self.beta < 0:
            raise InputError(f"beta = {self.beta:.6g} must not be negative; 0 and 2 are usual.")


@attrs.frozen(eq=False, slots=False)
class IMM(Value):
    r"""The interacting multiple model filter, for a plant that jumps between modes.

    The mode is a Markov chain with P(mode j at k+1 | mode i at k) = Pi_ij. Each step, with
    probabilities mu_i of the modes and c_j = sum_i Pi_ij mu_i, every filter j goes on from the
    mixture of all beliefs with the weights Pi_ij mu_i/c_j, and mu_j becomes proportional to c_j
    times the likelihood of y under its innovation. Covariances of mixtures are made of square
    roots by orthogonal transformations, and probabilities are kept as logarithms. The estimate is
    exact where Pi = I, and a Gaussian approximation of M^k hypotheses elsewhere.

    Parameters
    ----------
    filters : sequence of EKF or UKF
        One for each mode, in square roots; their models have the same n, l_u and l_y and may have
        other noises and other first beliefs.
    transitions : array, shape (M, M)
        Pi; each row adds up to 1.
    probabilities : array, shape (M,), optional
        Of the modes at k = 0, before y(0); all alike by default.

    Raises
    ------
    InputError
        Where sizes do not fit together, or probabilities are negative or do not add up to 1.

    Notes
    -----
    H. A. P. Blom and Y. Bar-Shalom, The interacting multiple model algorithm for systems with
    Markovian switching coefficients, IEEE Transactions on Automatic Control 33(8), 1988.

    Examples
    --------
    >>> from rcac_numeric.estimation import EKF, IMM, LinearModel, estimate
    >>> level = LinearModel(A=1, C=1)
    >>> still, moving = EKF(level, Q=1e-6, R=0.01), EKF(level, Q=4.0, R=0.01)
    >>> jumps = IMM([still, moving], transitions=[[0.95, 0.05], [0.5, 0.5]])
    >>> estimates = estimate(jumps, y=[0.0, 0.1, 0.0, 0.1, 3.0, 3.1, 3.0, 3.1])
    >>> estimates.most_probable  # the level jumped before k = 4
    array([0, 0, 0, 0, 1, 0, 0, 0])
    """

    filters: Sequence[EKF | UKF]
    transitions: Array = attrs.field(converter=array_like)
    probabilities: Array = attrs.field(default=None, converter=optional_array_like)

    def __attrs_post_init__(self) -> None:
        set_ = partial(object.__setattr__, self)
        set_("filters", items(self.filters, "filters", EKF | UKF))  # type: ignore[arg-type]
        modes = len(self.filters)
        if modes == 0:
            raise InputError("filters is empty: give one EKF or UKF for each mode.")
        sizes = [(one.model.n, one.model.l_u, one.model.l_y) for one in self.filters]
        for j, one in enumerate(self.filters):
            if isinstance(one, EKF) and one.form != "square root":
                raise InputError(f'filter {j} has the form {one.form!r}; give form="square root".')
            if sizes[j] != sizes[0]:
                raise InputError(
                    f"the model of filter {j} has (n, l_u, l_y) = {sizes[j]}, that of filter 0 "
                    f"{sizes[0]}; add to the smaller one states that stay zero."
                )
        set_("transitions", matrix(self.transitions, "transitions", (modes, modes)))
        probabilities = (
            np.full(modes, 1 / modes) if self.probabilities is None else self.probabilities
        )
        first = vector(probabilities, "probabilities", modes)
        set_("probabilities", _distribution(first, "probabilities"))
        for i, row in enumerate(self.transitions):
            _distribution(row, f"row {i} of transitions")

    @property
    def model(self) -> AnyModel:
        """The model of the first mode, with the sizes of all."""
        return self.filters[0].model


def _distribution(values: Array, name: str) -> Array:
    if values.min() < 0 or abs(values.sum() - 1) > 1e-9:
        raise InputError(
            f"{name} = {values} is no distribution: probabilities >= 0 that add up to 1 are needed."
        )
    return values


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class AdaptiveNoises(Value):
    r"""An extended Kalman filter that learns Q and R from its measurements as it runs.

    After every `window` steps Q and R are replaced by the means of E[w w'] and E[v v'] given all
    measurements of these steps, from a smoother in square roots: expectation maximisation, block by
    block. An iteration never makes the measurements of its block less likely (where the model is
    linear), and both matrices are sums of squares. What Q does not reach at first it never reaches:
    Q = G q G' stays of this form.

    Parameters
    ----------
    filter : EKF
        With Q and R to begin with.
    window : int
        Steps from which a new Q and R are made. What is learned scatters like 1/sqrt(window), and
        follows noises that change within a few windows.
    iterations : int
        Of each window. The last step of a window costs about 3 window iterations steps of a filter.
    learn : sequence of {"Q", "R"}
        What is learned; the other is taken as known.
    diagonal : bool
        Whether what is learned is diagonal.

    Raises
    ------
    InputError
        Where `filter` is none, a number is too small, or what is to be learned is zero.

    Notes
    -----
    R. H. Shumway and D. S. Stoffer, An approach to time series smoothing and forecasting using the
    EM algorithm, Journal of Time Series Analysis 3(4), 1982; by blocks: S. Le Corff and G. Fort,
    Online expectation maximization based algorithms for inference in hidden Markov models,
    Electronic Journal of Statistics 7, 2013.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.estimation import EKF, AdaptiveNoises, LinearModel, estimate
    >>> y = 3.0 * np.random.default_rng(1).standard_normal(4000)
    >>> known = EKF(LinearModel(A=0.5, C=1), Q=0.01, R=1.0)
    >>> estimates = estimate(AdaptiveNoises(known, window=1000, learn=["R"]), y)
    >>> estimates.R[[0, 1, -1], 0, 0].round(1)  # R = 9 is estimates within the first window
    array([1. , 8.8, 9.4])
    """

    filter: EKF = attrs.field(metadata=reads(instance_of, kind=EKF))
    window: int = attrs.field(default=200, metadata=reads(integer, at_least=2))
    iterations: int = attrs.field(default=10, metadata=reads(integer, at_least=1, at_most=10_000))
    learn: Sequence[str] = ("Q", "R")
    diagonal: bool = attrs.field(default=False, metadata=reads(instance_of, kind=bool))

    def __attrs_post_init__(self) -> None:
        object.__setattr__(self, "learn", learned_noises(self.filter, self.learn))

    @property
    def model(self) -> AnyModel:
        """The model of the filter."""
        return self.filter.model


def learned_noises(settings: EKF, learn: Iterable[str]) -> tuple[str, ...]:
    """Which of Q and R are learned, where they are more than zero to begin with."""
    named = items(learn, "learn")
    for name in named:
        one_of(name, "an entry of learn", ("Q", "R"))
        if not (settings.Q if name == "Q" else settings.R).any():
            raise InputError(
                f"{name} is zero, and learning keeps its range: begin with a positive {name}."
            )
    if not named:
        raise InputError('learn is empty: give ["Q"], ["R"] or ["Q", "R"].')
    return tuple(name for name in ("Q", "R") if name in named)


AnyFilter = EKF | UKF | IMM | AdaptiveNoises


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


def covariance_of(root: Array) -> Array:
    """SS', exactly symmetric."""
    covariance = root @ root.T
    return np.asarray((covariance + covariance.T) / 2)
