"""Predictive cost adaptive control: the settings, and the gain of a model."""

from __future__ import annotations

from functools import partial
from typing import Literal, NamedTuple

import attrs
import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import DivergedError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight
from rcac_numeric.arrays._validation import (
    array_like,
    instance_of,
    integer,
    number,
    one_of,
    reads,
    real_array,
    vector,
    with_checks,
)
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._forgetting import forgetting_factor
from rcac_numeric.controllers._limits import ControlLimits
from rcac_numeric.controllers._stepwise import StepwiseController


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class PredictiveCost(StepwiseController):
    r"""Predictive cost adaptive control (PCAC): recursive ARX, then a finite-horizon cost.

    At every step the model

        y(k) = a_1 y(k-1) + ... + a_n y(k-n) + b_1 u(k-1) + ... + b_n u(k-n)

    is updated by recursive least squares, its block observable form is predicted from x^(k), the
    window of the past n values of y and u, and u(k) is the first control of

        min sum_{j=0}^{l-1} (e_j' Q e_j + v_j' R v_j) + e_l' P e_l,   e_j = y_j - r(k),

    by the Riccati recursion. u(k) reads y(k-1) at the latest. Forgetting is that of
    `SubspaceForgetting`: of the excited direction alone, and along it never below R_theta.

    Parameters
    ----------
    order : int
        n, the number of lags of the model.
    horizon : int
        l, the number of predicted controls.
    Q, P : float or array, shape (l_y, l_y)
        Weights of the predicted outputs and of the last one; semidefinite.
    R : float or array, shape (l_u, l_u)
        Weight of v; definite.
    weighs : {"moves", "u"}
        v_j = u_j - u_{j-1}, or v_j = u_j; with "u" a constant command is followed with an offset.
    problem : {"standard", "servo", "tracking"}
        "standard": y is regulated to 0. "servo": y = r - y_0 is the error of `servo_plant`, and y_0
        is modelled and follows r. "tracking": y itself follows r.
    R_theta : float
        Weight of theta - theta_0 at the start, the inverse of P(0), and the floor of forgetting.
    lambda_ : float
        Forgetting factor, in (0, 1].
    theta_0 : float or array, shape (l_y, n (l_u + l_y))
        Initial coefficients; a row for each output: b_1, ..., b_n, then a_1, ..., a_n.
    limits : ControlLimits, optional
        Bounds of u and of its change in a step.
    limited_by : {"saturation", "least squares"}
        How the bounds act: u(k) is cut to them; or they enter the cost as bounds of every predicted
        u, and where one is active SciPy's `lsq_linear` solves the bounded least squares problem.
        Rates bound the first move in both cases. There are no limits on y.
    l_u, l_y : int
        Numbers of controls and measurements.

    Raises
    ------
    InputError
        Where a setting is out of range, or theta_0 has b = 0, with which u would stay 0.

    Notes
    -----
    T.-W. Nguyen, S. A. U. Islam, D. S. Bernstein and I. V. Kolmanovsky, IEEE Control Syst. Mag. 41
    (2021) 64-96. For a constant theta it is the compensator of
    `compensator_theory.predictive_cost_compensator`.

    Examples
    --------
    An unstable nonminimum-phase plant of which the order alone is known:

    >>> from rcac_numeric import PredictiveCost, Step, exogenous, servo_plant, simulate
    >>> plant = servo_plant("(q - 13/10)/(q**2 - 7/5*q + 3/10)")
    >>> settings = PredictiveCost(order=2, horizon=20, Q=2, P=5, problem="servo", R_theta=1e-6)
    >>> run = simulate(plant, settings, exogenous([Step(), Step(0), Step(0)], steps=100))
    >>> bool(abs(run.z[-1, 0]) < 1e-4), run.theta_final.round(3)
    (True, array([ 1. , -1.3,  1.4, -0.3]))
    """

    order: int = attrs.field(metadata=reads(integer, at_least=1, at_most=200))
    horizon: int = attrs.field(metadata=reads(integer, at_least=1, at_most=1000))
    Q: Array = attrs.field(default=1.0, converter=array_like, kw_only=True)
    P: Array = attrs.field(default=1.0, converter=array_like, kw_only=True)
    R: Array = attrs.field(default=1.0, converter=array_like, kw_only=True)
    weighs: Literal["moves", "u"] = attrs.field(
        default="moves", kw_only=True, metadata=reads(one_of, choices=("moves", "u"))
    )
    problem: Literal["standard", "servo", "tracking"] = attrs.field(
        default="standard",
        kw_only=True,
        metadata=reads(one_of, choices=("standard", "servo", "tracking")),
    )
    R_theta: float = attrs.field(default=1e-3, kw_only=True)
    lambda_: float = attrs.field(default=1.0, kw_only=True, metadata=reads(forgetting_factor))
    theta_0: Array = attrs.field(default=0.01, converter=array_like, kw_only=True)
    limits: ControlLimits | None = attrs.field(
        default=None, kw_only=True, metadata=reads(instance_of, kind=ControlLimits, optional=True)
    )
    limited_by: Literal["saturation", "least squares"] = attrs.field(
        default="saturation",
        kw_only=True,
        metadata=reads(one_of, choices=("saturation", "least squares")),
    )
    inputs: int = attrs.field(
        default=1, kw_only=True, alias="l_u", metadata=reads(integer, at_least=1, at_most=100)
    )
    outputs: int = attrs.field(
        default=1, kw_only=True, alias="l_y", metadata=reads(integer, at_least=1, at_most=100)
    )

    def __attrs_post_init__(self) -> None:
        set_ = partial(object.__setattr__, self)
        set_("Q", constant_weight(self.Q, "Q", self.l_y, definite=False))
        set_("P", constant_weight(self.P, "P", self.l_y, definite=False))
        set_("R", constant_weight(self.R, "R", self.l_u, definite=True))
        if not 1e-300 < number(self.R_theta, "R_theta") < 1e300:
            raise InputError(f"R_theta = {self.R_theta:g} must be positive.")
        shape = (self.l_y, self.order * (self.l_u + self.l_y))
        theta_0 = real_array(self.theta_0, "theta_0")
        if theta_0.ndim == 0:
            theta_0 = np.full(shape, float(theta_0))
        elif theta_0.size != shape[0] * shape[1]:
            raise InputError(f"theta_0 has shape {theta_0.shape}; {shape} is needed, or a number.")
        theta_0 = theta_0.reshape(shape)
        if not theta_0[:, : self.order * self.l_u].any():
            raise InputError(
                "theta_0 has b = 0: the gain is zero then, u stays 0, and the model is never "
                "identified. Give b another value, such as 0.01."
            )
        set_("theta_0", theta_0)
        if self.limits is not None:
            self.limits.bounds(self.l_u)
        elif self.limited_by == "least squares":
            raise InputError('limited_by = "least squares" needs limits=ControlLimits(...).')

    @property
    def l_u(self) -> int:
        """Number of controls."""
        return self.inputs

    @property
    def l_y(self) -> int:
        """Number of measurements."""
        return self.outputs

    @property
    def l_r(self) -> int:
        """Number of commands: l_y, and 0 in the standard problem."""
        return 0 if self.problem == "standard" else self.outputs

    @property
    def l_theta(self) -> int:
        """Number of coefficients, l_y n (l_u + l_y)."""
        return self.l_y * self.order * (self.l_u + self.l_y)

    def model(self, theta: ArrayLike) -> tuple[Array, Array]:
        """Return the coefficients (b, a) of theta, shapes (n, l_y, l_u) and (n, l_y, l_y)."""
        rows = vector(theta, "theta", self.l_theta).reshape(self.l_y, -1)
        b, a = rows[:, : self.order * self.l_u], rows[:, self.order * self.l_u :]
        return (
            b.reshape(self.l_y, self.order, self.l_u).transpose(1, 0, 2).copy(),
            a.reshape(self.l_y, self.order, self.l_y).transpose(1, 0, 2).copy(),
        )

    def gain(self, theta: ArrayLike) -> tuple[Array, Array, Array]:
        """Return (K, K_u, K_r) of u(k) = K x^(k) + K_u u(k-1) + K_r r(k) for a model.

        Parameters
        ----------
        theta : array, shape (l_theta,)

        Returns
        -------
        arrays of shape (l_u, n l_y), (l_u, l_u), (l_u, l_y)
            K_u is zero where the cost weighs u.

        Raises
        ------
        DivergedError
            Where the recursion leaves the range of float64.
        """
        first = gains_of(self, prediction_of(self, theta))[0]
        n, m = self.order * self.l_y, self.l_u
        return first[:, :n], first[:, n : n + m], first[:, n + m :]

    def compensator_of(self, theta: ArrayLike) -> Compensator:  # type: ignore[override]
        """Return the compensator of a constant theta, without limits; it reads [y; r], or y.

        Of order n: x^(k) is a window of the past n values of y and u.
        """
        K, K_u, K_r = self.gain(theta)
        b, a = self.model(theta)
        past_u, past_y = window_of(K, b), window_of(K, a)
        past_u[0] += K_u
        if self.problem == "standard":
            nothing = np.zeros((1, self.l_u, self.l_y))
            return Compensator(past_u, np.concatenate([nothing, past_y]))
        from_r = np.zeros_like(past_y)
        if self.problem == "servo":
            past_y, from_r = -past_y, past_y
        now = np.concatenate([np.zeros((self.l_u, self.l_y)), K_r], axis=1)
        return Compensator(
            past_u, np.concatenate([now[None], np.concatenate([past_y, from_r], axis=2)])
        )


class Prediction(NamedTuple):
    """x(j+1) = A x(j) + B u(j), e(j) = C x(j), of the states [x^; u(j-1); r], u not its move."""

    A: Array
    B: Array
    C: Array


def block_observable_form(b: Array, a: Array) -> tuple[Array, Array, Array]:
    """Return (A, Gamma, C) of the coefficients, shapes (np, np), (np, l_u), (l_y, np)."""
    n, p = a.shape[:2]
    A = np.eye(n * p, k=p)
    A[:, :p] += a.reshape(n * p, p)
    return A, b.reshape(n * p, -1), np.eye(p, n * p)


def prediction_of(settings: PredictiveCost, theta: ArrayLike) -> Prediction:
    """Return the prediction of a model, with the last control and the command as states."""
    A, Gamma, C = block_observable_form(*settings.model(theta))
    n, m, p = len(A), settings.l_u, settings.l_y
    whole = np.zeros((n + m + p, n + m + p))
    whole[:n, :n] = A
    whole[n + m :, n + m :] = np.eye(p)
    inputs = np.concatenate([Gamma, np.eye(m), np.zeros((p, m))])
    return Prediction(whole, inputs, np.concatenate([C, np.zeros((p, m)), -np.eye(p)], axis=1))


def gains_of(settings: PredictiveCost, prediction: Prediction) -> list[Array]:
    """Return the gains of u(j) by the Riccati recursion backward, the first one first.

    With moves the cost has the cross term of (u - u_past)' R (u - u_past).
    """
    A, B, C = prediction
    n, m, R = settings.order * settings.l_y, settings.l_u, settings.R
    N, running = np.zeros((len(A), m)), C.T @ settings.Q @ C
    if settings.weighs == "moves":
        N[n : n + m] = -R
        running[n : n + m, n : n + m] += R
    S, gains = C.T @ settings.P @ C, list[Array]()
    with np.errstate(all="ignore"):
        for _ in range(settings.horizon):
            weight, moved = R + B.T @ S @ B, B.T @ S @ A + N.T
            try:
                gain = -np.linalg.solve(weight, moved)
            except np.linalg.LinAlgError:
                raise riccati_overflow() from None
            gains.append(np.asarray(gain))
            closed = A + B @ gain
            # (A + BK)'S(A + BK) + [I; K]'W[I; K] is semidefinite in rounding too.
            S = closed.T @ S @ closed + running + gain.T @ R @ gain + N @ gain + (N @ gain).T
            S = (S + S.T) / 2
    if not np.isfinite(gains[-1]).all():
        raise riccati_overflow()
    return gains[::-1]


def riccati_overflow() -> DivergedError:
    """Return the error of a recursion that left float64."""
    return DivergedError(
        "the Riccati recursion left the range of float64: the model is far from any plant, or the "
        "horizon is too long for an unstable model. Choose a larger R_theta or a shorter horizon."
    )


def window_of(K: Array, coefficients: Array) -> Array:
    """Return K S^(i-1) M, i = 1, ..., n: the weights of a past signal in K x^(k)."""
    n, p = coefficients.shape[:2]
    stacked, weights = coefficients.reshape(n * p, -1), []
    for i in range(n):
        weights.append(K[:, : (n - i) * p] @ stacked[i * p :])
    return np.array(weights)


def estimate_of(b: Array, a: Array, past_u: Array, past_y: Array) -> Array:
    """Return x^(k) of the past n values of u and y, newest first."""
    n, p = a.shape[:2]
    x = np.zeros(n * p)
    for i in range(n):
        part = b[i:] @ past_u[i] + a[i:] @ past_y[i]
        x[: (n - i) * p] += part.reshape(-1)
    return x


def rolled_out(prediction: Prediction, gains: list[Array], state: Array) -> Array:
    """Return the predicted controls without bounds, shape (horizon, l_u)."""
    A, B, _ = prediction
    controls = []
    for gain in gains:
        controls.append(gain @ state)
        state = A @ state + B @ controls[-1]
    return np.array(controls)


def bounded_controls(
    settings: PredictiveCost, prediction: Prediction, state: Array, low: Array, high: Array
) -> Array:
    """Return the predicted controls within bounds by bounded least squares."""
    from scipy.optimize import lsq_linear  # imported here: only an active bound needs SciPy

    A, B, C = prediction
    horizon, m = low.shape
    n, moves = settings.order * settings.l_y, settings.weighs == "moves"
    Q, P, R = (_root(weight) for weight in (settings.Q, settings.P, settings.R))
    effort = np.zeros(horizon * m)
    if moves:
        effort[:m] = -R @ state[n : n + m]
    reach, rows, constants = np.zeros((len(A), horizon * m)), [], []
    for j in range(horizon + 1):
        weight = (P if j == horizon else Q) @ C
        rows.append(weight @ reach)
        constants.append(weight @ state)
        if j < horizon:
            state, reach = A @ state, A @ reach
            reach[:, j * m : (j + 1) * m] += B
    difference = np.eye(horizon) - np.eye(horizon, k=-1) if moves else np.eye(horizon)
    matrix = np.concatenate([*rows, np.kron(difference, R)])
    target = -np.concatenate([*constants, effort])
    if not (np.isfinite(matrix).all() and np.isfinite(target).all()):
        raise riccati_overflow()
    lower, upper = low.reshape(-1), high.reshape(-1)
    controls, free = lower.copy(), lower < upper  # lsq_linear needs an interval for each
    if free.any():
        target = target - matrix[:, ~free] @ controls[~free]
        bounds = lower[free], upper[free]
        controls[free] = lsq_linear(matrix[:, free], target, bounds, method="bvls").x
    return controls.reshape(horizon, m)


def _root(weight: Array) -> Array:
    """Return W with W'W the weight."""
    values, vectors = np.linalg.eigh(weight)
    return np.asarray(np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T)
