"""Structures with which RCMR replaces an unknown subsystem."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import attrs
import numpy as np
import sympy

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import (
    array_like,
    instance_of,
    integer,
    items,
    number,
    optional_array_like,
    reads,
    real_array,
    with_checks,
)
from rcac_numeric.arrays._values import Result, Value


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class FIRSubsystem(Value):
    """u^(k) = N_0 y_0^(k) + ... + N_{n_c-1} y_0^(k-n_c+1), or one step later, (8.57).

    Parameters
    ----------
    n_c : int
        Number of coefficient matrices.
    strictly_proper : bool
        u^(k) = N_1 y_0^(k-1) + ... + N_nc y_0^(k-n_c), as (8.57) has it. That cannot represent the
        parameter kappa of (8.29), which acts at once: the default is proper.

    Examples
    --------
    >>> from rcac_numeric.estimation import FIRSubsystem
    >>> FIRSubsystem(n_c=3, strictly_proper=True)
    FIRSubsystem(n_c=3, strictly_proper=True)
    """

    n_c: int = attrs.field(default=1, metadata=reads(integer, at_least=1, at_most=1_000_000))
    strictly_proper: bool = attrs.field(default=False, metadata=reads(instance_of, kind=bool))


@attrs.frozen(eq=False, slots=False)
class RepeatedParameters(Value):
    """u^(k) = sum over j of theta_j (A_j x^(k) + D_j w(k)): parameters in several places (8.73).

    The model's matrices are A + sum theta_j A_j and D_1 + sum theta_j D_j; B^ is the identity.

    Parameters
    ----------
    A : array, shape (l_theta, n, n)
        A_j, the derivative of A with respect to parameter j.
    D : array, shape (l_theta, n, l_w), optional
        D_j, the derivative of D_1; zero by default.

    Raises
    ------
    InputError
        Where the shapes do not fit, or a parameter stands nowhere.

    Examples
    --------
    >>> from rcac_numeric.estimation import RepeatedParameters
    >>> RepeatedParameters(A=[[[0, 0], [3, 0.5]]], D=[[[0], [-0.1]]]).l_theta  # (8.84)
    1
    """

    A: Array = attrs.field(converter=array_like)
    D: Array = attrs.field(default=None, converter=optional_array_like)

    def __attrs_post_init__(self) -> None:
        set_ = partial(object.__setattr__, self)
        read = real_array(self.A, "A")
        if read.ndim != 3 or read.shape[1] != read.shape[2] or not read.size:
            raise InputError(f"A has shape {read.shape}; (l_theta, n, n) is needed.")
        set_("A", read)
        l_theta, n = read.shape[:2]
        D = real_array(np.zeros((l_theta, n, 0)) if self.D is None else self.D, "D")
        if D.ndim != 3 or D.shape[:2] != (l_theta, n):
            raise InputError(f"D has shape {D.shape}; ({l_theta}, {n}, l_w) is needed.")
        set_("D", D)
        for j in range(l_theta):
            if not (read[j].any() or D[j].any()):
                raise InputError(f"parameter {j} occurs neither in A nor in D; leave it out.")

    @property
    def l_theta(self) -> int:
        """Number of parameters."""
        return int(self.A.shape[0])


@dataclass(frozen=True, eq=False)
class Linearisation(Result):
    """A discretised model and how it depends on its parameters.

    Attributes
    ----------
    A : array, shape (n, n)
    D_1 : array, shape (n, l_w)
    subsystem : RepeatedParameters
        Its theta is the difference of the parameters from `at`.
    at : array, shape (l_theta,)
    """

    A: Array
    D_1: Array
    subsystem: RepeatedParameters
    at: Array


def repeated_parameters(
    A_c: sympy.Matrix,
    D_c: sympy.Matrix,
    parameters: Sequence[sympy.Symbol],
    at: Sequence[float],
    h: float,
) -> Linearisation:
    """Linearise x' = A_c x + D_c w about parameter values and discretise it (8.70)-(8.74).

    A = I + h A_c, D_1 = h D_c by Euler's rule, and their derivatives, taken symbolically. The true
    system is linear in the parameters only to first order: an estimate far from `at` is biased.

    Parameters
    ----------
    A_c, D_c : sympy.Matrix
        In the symbols `parameters`.
    parameters : sequence of symbols
    at : sequence of float
        The initial estimates.
    h : float
        Sampling period in s.

    Raises
    ------
    InputError
        Where shapes do not fit, or a symbol has no value.

    Examples
    --------
    >>> import sympy
    >>> from rcac_numeric.estimation import repeated_parameters
    >>> m = sympy.Symbol("m")
    >>> A_c = sympy.Matrix([[0, 1], [-30 / m, -5 / m]])
    >>> D_c = sympy.Matrix([[0], [1 / m]])
    >>> repeated = repeated_parameters(A_c, D_c, [m], at=[1], h=0.1)
    >>> repeated.subsystem.A[0], repeated.subsystem.D[0]  # (8.84)
    (array([[0. , 0. ],
           [3. , 0.5]]), array([[ 0. ],
           [-0.1]]))
    """
    symbols = list(parameters)
    values = [number(value, "at") for value in items(at, "at")]
    if len(symbols) != len(values) or not symbols:
        raise InputError(f"{len(symbols)} parameters and {len(values)} values in at.")
    period = number(h, "h")
    for name, matrix in (("A_c", A_c), ("D_c", D_c)):
        if not isinstance(matrix, sympy.MatrixBase):
            raise InputError(f"{name} = {matrix!r} is no SymPy matrix.")
        if matrix.free_symbols - set(symbols):
            others = ", ".join(sorted(map(str, matrix.free_symbols - set(symbols))))
            raise InputError(f"{name} holds {others}, which is no parameter; give it a value.")
    if A_c.rows != A_c.cols or D_c.rows != A_c.rows:
        raise InputError(f"A_c is {A_c.shape} and D_c {D_c.shape}; n x n and n x l_w are needed.")
    there = dict(zip(symbols, values, strict=True))

    def evaluated(matrix: sympy.Matrix, name: str) -> Array:
        entries = [complex(entry.subs(there)) for entry in matrix]
        if any(entry.imag for entry in entries):
            raise InputError(f"{name} is not real at {there}.")
        return real_array([e.real for e in entries], f"{name} at {there}").reshape(matrix.shape)

    return Linearisation(
        A=np.eye(A_c.rows) + period * evaluated(A_c, "A_c"),
        D_1=period * evaluated(D_c, "D_c"),
        subsystem=RepeatedParameters(
            A=[period * evaluated(A_c.diff(s), f"dA_c/d{s}") for s in symbols],
            D=[period * evaluated(D_c.diff(s), f"dD_c/d{s}") for s in symbols],
        ),
        at=np.array(values),
    )
