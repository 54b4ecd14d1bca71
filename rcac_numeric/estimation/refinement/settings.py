"""Retrospective cost model refinement as data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.definite_matrices import constant_weight
from rcac_numeric.arrays.validation import instance_of, integer, matrix, number, one_of, vector
from rcac_numeric.arrays.values import Value
from rcac_numeric.estimation.refinement.markov import require_solvable, retrospective_matrix
from rcac_numeric.estimation.refinement.subsystems import FIRSubsystem, RepeatedParameters

METHODS = ("nearest", "smallest", "pseudoinverse", "direct")


@dataclass(frozen=True, eq=False, init=False)
class RCMR(Value):
    """Retrospective cost model refinement (8.25)-(8.63), corrected.

    x^(k+1) = A x^(k) + D_1 w(k) + B u^(k), with the unknown subsystem u^ = G_s y_0^,
    y_0^ = E_1 x^, refined until z = C x^ - y is small. What the text leaves open is asked here;
    the defaults are what works for Examples 8.1 and 8.2.

    Parameters
    ----------
    A, B, D_1, C, E_1 : arrays
        The model's matrices; B and E_1 are left out for `RepeatedParameters`.
    subsystem : FIRSubsystem or RepeatedParameters
    beta : float or array, shape (l_theta, l_theta)
        P(0) = beta I.
    lambda_ : float
        Forgetting factor in (0, 1].
    delays : sequence of int
        The i of the past outputs u^(k-i) that are reconstructed: H~ holds H_i = C A^(i-1) B in
        their columns. The default is u^(k-2) alone, the text's "last entry of U~" for r = 2.
    stack : sequence of int
        The k_j of the stacked performance Z(k) = [z(k-k_1); ...].
    d : int, optional
        Which u*(k-d) theta is fitted to; the largest of `delays` by default.
    method : {"nearest", "smallest", "pseudoinverse", "direct"}
        "nearest" reconstructs U~* as close to U~ as the performance allows, so that z = 0 is a
        fixed point. "smallest" is (8.56) as printed, which is refused where it is singular;
        "pseudoinverse" the same with its least solution, biased unless all H_i are alike.
        "direct" minimises the retrospective performance over theta itself, as RCAC does; it is
        (8.79) made recursive and the one to use for repeated parameters.
    eta_bar : float
        Regularisation eta = eta_bar z'z of (8.51).
    R : array, shape (s l_y, s l_y), or a number
        Weight of Z.
    k_update : int, optional
        First step with an update; by default when all reconstructed outputs exist.
    theta_0 : array, shape (l_theta,), optional
        Zero by default.
    x_0 : array, shape (n,), optional
        x^(0); zero by default.

    Raises
    ------
    InputError
        Where shapes do not fit or an entry is not finite.
    IllConditionedError
        Where (8.56) is singular, or no H_i sees the subsystem.

    Examples
    --------
    >>> from rcac_numeric.estimation import RCMR, FIRSubsystem
    >>> RCMR(A=[[1, 0.1], [0, 0.5]], B=[0, -0.1], D_1=[0, 0.1], C=[0, 1], E_1=[1, 0],
    ...      beta=0.42).H  # H_2
    array([[-0.05]])
    """

    A: Array
    B: Array
    D_1: Array
    C: Array
    E_1: Array
    subsystem: FIRSubsystem | RepeatedParameters
    beta: Array
    lambda_: float
    delays: tuple[int, ...]
    stack: tuple[int, ...]
    d: int
    method: str
    eta_bar: float
    R: Array
    k_update: int
    theta_0: Array
    x_0: Array

    def __init__(
        self,
        A: ArrayLike,
        D_1: ArrayLike,
        C: ArrayLike,
        B: ArrayLike | None = None,
        E_1: ArrayLike | None = None,
        subsystem: FIRSubsystem | RepeatedParameters | None = None,
        beta: ArrayLike = 1.0,
        lambda_: float = 1.0,
        delays: Sequence[int] = (2,),
        stack: Sequence[int] = (0,),
        d: int | None = None,
        method: str = "nearest",
        eta_bar: float = 0.0,
        R: ArrayLike = 1.0,
        k_update: int | None = None,
        theta_0: ArrayLike | None = None,
        x_0: ArrayLike | None = None,
    ) -> None:
        set_ = partial(object.__setattr__, self)
        n = matrix(A, "A", (None, None)).shape[0]
        set_("A", matrix(A, "A", (n, n)))
        set_("D_1", matrix(_column(D_1, n), "D_1", (n, None)))
        set_("C", matrix(_row(C), "C", (None, n)))
        part = FIRSubsystem() if subsystem is None else subsystem
        set_("subsystem", instance_of(part, "subsystem", FIRSubsystem | RepeatedParameters))
        self._read_channels(B, E_1)
        set_("delays", _steps(delays, "delays", 1))
        set_("stack", _steps(stack, "stack", 0))
        set_("d", max(self.delays) if d is None else integer(d, "d", at_least=1))
        if self.d not in self.delays:
            raise InputError(f"d = {self.d} is none of the delays {self.delays} of U~.")
        set_("method", one_of(method, "method", METHODS))
        set_("eta_bar", number(eta_bar, "eta_bar"))
        if self.eta_bar < 0:
            raise InputError(f"eta_bar = {self.eta_bar:.6g} must not be negative.")
        set_("lambda_", number(lambda_, "lambda_"))
        if not 0 < self.lambda_ <= 1:
            raise InputError(f"lambda_ = {self.lambda_:.6g} must lie in (0, 1].")
        rows = len(self.stack) * self.l_y
        set_("R", constant_weight(R, "R", rows, definite=True))
        set_("beta", constant_weight(beta, "beta", self.l_theta, definite=True))
        first = max(self.delays) + 1 if k_update is None else integer(k_update, "k_update")
        set_("k_update", first)
        zero = np.zeros(self.l_theta)
        set_("theta_0", vector(zero if theta_0 is None else theta_0, "theta_0", self.l_theta))
        set_("x_0", vector(np.zeros(n) if x_0 is None else x_0, "x_0", n))
        require_solvable(self.H, self.method, self.eta_bar, self.delays)

    def _read_channels(self, B: ArrayLike | None, E_1: ArrayLike | None) -> None:
        set_ = partial(object.__setattr__, self)
        n, part = self.n, self.subsystem
        if isinstance(part, FIRSubsystem):
            if B is None or E_1 is None:
                raise InputError("an FIRSubsystem needs B, where it acts, and E_1, what it reads.")
            set_("B", matrix(_column(B, n), "B", (n, None)))
            set_("E_1", matrix(_row(E_1), "E_1", (None, n)))
            return
        if B is not None or E_1 is not None:
            raise InputError("RepeatedParameters say themselves where they act: no B, no E_1.")
        wide = part.D.shape[2] in (0, self.l_w)
        if part.A.shape[1] != n or not wide:
            raise InputError(
                f"the subsystem has A_j of size {part.A.shape[1]} and D_j with {part.D.shape[2]} "
                f"columns; the model has n = {n} and l_w = {self.l_w}."
            )
        set_("B", np.eye(n))
        set_("E_1", np.eye(n))

    @property
    def n(self) -> int:
        """Number of states of the model."""
        return int(self.A.shape[0])

    @property
    def l_w(self) -> int:
        """Number of known inputs."""
        return int(self.D_1.shape[1])

    @property
    def l_u(self) -> int:
        """Number of outputs of the subsystem."""
        return int(self.B.shape[1])

    @property
    def l_y(self) -> int:
        """Number of measurements."""
        return int(self.C.shape[0])

    @property
    def l_theta(self) -> int:
        """Number of coefficients."""
        if isinstance(self.subsystem, RepeatedParameters):
            return self.subsystem.l_theta
        return self.l_u * self.subsystem.n_c * int(self.E_1.shape[0])

    @property
    def H(self) -> Array:
        """H~ of (8.45), shape (s l_y, m l_u): the Markov parameters of the stacked performance."""
        return retrospective_matrix(self.A, self.B, self.C, self.delays, self.stack)


def _steps(values: Sequence[int], name: str, least: int) -> tuple[int, ...]:
    try:
        steps = [integer(value, f"an entry of {name}", least, 1_000_000) for value in values]
    except TypeError:
        raise InputError(f"{name} = {values!r} must be a list of steps.") from None
    if not steps or sorted(set(steps)) != steps:
        raise InputError(f"{name} = {values!r} must hold at least one step, in increasing order.")
    return tuple(steps)


def _column(value: ArrayLike, n: int) -> ArrayLike:
    array = np.asarray(value)
    return array.reshape(n, 1) if array.ndim == 1 and array.size == n else value


def _row(value: ArrayLike) -> ArrayLike:
    array = np.asarray(value)
    return array.reshape(1, -1) if array.ndim == 1 else value
