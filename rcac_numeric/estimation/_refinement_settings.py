"""Retrospective cost model refinement as data."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import attrs
import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight
from rcac_numeric.arrays._validation import (
    array_like,
    float_array,
    instance_of,
    integer,
    matrix,
    number,
    one_of,
    optional_array_like,
    optional_integer,
    reads,
    vector,
    with_checks,
)
from rcac_numeric.arrays._values import Value
from rcac_numeric.estimation._markov import require_solvable, retrospective_matrix
from rcac_numeric.estimation._subsystems import FIRSubsystem, RepeatedParameters

METHODS = ("nearest", "smallest", "pseudoinverse", "direct")


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class RCMR(Value):
    """Retrospective cost model refinement (8.25)-(8.63), corrected.

    x^(k+1) = A x^(k) + D_1 w(k) + B u^(k), with the unknown subsystem u^ = G_s y_0^,
    y_0^ = E_1 x^, refined until z = C x^ - y is small. What the text leaves open is a setting;
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

    A: Array = attrs.field(converter=array_like)
    D_1: Array = attrs.field(converter=array_like)
    C: Array = attrs.field(converter=array_like)
    B: Array = attrs.field(default=None, converter=optional_array_like)
    E_1: Array = attrs.field(default=None, converter=optional_array_like)
    subsystem: FIRSubsystem | RepeatedParameters = attrs.field(
        factory=FIRSubsystem, metadata=reads(instance_of, kind=FIRSubsystem | RepeatedParameters)
    )
    beta: Array = attrs.field(default=1.0, converter=array_like)
    lambda_: float = 1.0
    delays: Sequence[int] = (2,)
    stack: Sequence[int] = (0,)
    d: int = attrs.field(default=None, converter=optional_integer)
    method: str = "nearest"
    eta_bar: float = 0.0
    R: Array = attrs.field(default=1.0, converter=array_like)
    k_update: int = attrs.field(default=None, converter=optional_integer)
    theta_0: Array = attrs.field(default=None, converter=optional_array_like)
    x_0: Array = attrs.field(default=None, converter=optional_array_like)

    def __attrs_post_init__(self) -> None:
        set_ = partial(object.__setattr__, self)
        n = matrix(self.A, "A", (None, None)).shape[0]
        set_("A", matrix(self.A, "A", (n, n)))
        set_("D_1", matrix(_column(self.D_1, n), "D_1", (n, None)))
        set_("C", matrix(_row(self.C), "C", (None, n)))
        self._read_channels()
        set_("delays", _steps(self.delays, "delays", 1))
        set_("stack", _steps(self.stack, "stack", 0))
        set_("d", max(self.delays) if self.d is None else integer(self.d, "d", at_least=1))
        if self.d not in self.delays:
            raise InputError(f"d = {self.d} is none of the delays {self.delays} of U~.")
        one_of(self.method, "method", METHODS)
        set_("eta_bar", number(self.eta_bar, "eta_bar"))
        if self.eta_bar < 0:
            raise InputError(f"eta_bar = {self.eta_bar:.6g} must not be negative.")
        set_("lambda_", number(self.lambda_, "lambda_"))
        if not 0 < self.lambda_ <= 1:
            raise InputError(f"lambda_ = {self.lambda_:.6g} must lie in (0, 1].")
        rows = len(self.stack) * self.l_y
        set_("R", constant_weight(self.R, "R", rows, definite=True))
        set_("beta", constant_weight(self.beta, "beta", self.l_theta, definite=True))
        first = max(self.delays) + 1 if self.k_update is None else self.k_update
        set_("k_update", integer(first, "k_update"))
        for name, size in (("theta_0", self.l_theta), ("x_0", n)):
            value = getattr(self, name)
            set_(name, vector(np.zeros(size) if value is None else value, name, size))
        require_solvable(self.H, self.method, self.eta_bar, self.delays)

    def _read_channels(self) -> None:
        set_ = partial(object.__setattr__, self)
        n, part = self.n, self.subsystem
        B: ArrayLike | None = self.B
        E_1: ArrayLike | None = self.E_1
        if isinstance(part, FIRSubsystem):
            if B is None or E_1 is None:
                raise InputError("an FIRSubsystem needs B (where it acts) and E_1 (its inputs).")
            set_("B", matrix(_column(B, n), "B", (n, None)))
            set_("E_1", matrix(_row(E_1), "E_1", (None, n)))
            return
        if B is not None or E_1 is not None:
            raise InputError(
                "RepeatedParameters contain their inputs and outputs: leave out B and E_1."
            )
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
    array = float_array(value, "a column")
    return array.reshape(n, 1) if array.ndim == 1 and array.size == n else value


def _row(value: ArrayLike) -> ArrayLike:
    array = float_array(value, "a row")
    return array.reshape(1, -1) if array.ndim == 1 else value
