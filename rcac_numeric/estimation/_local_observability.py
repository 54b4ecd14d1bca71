"""Observable directions of a state along a record."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight
from rcac_numeric.arrays._validation import signal_array
from rcac_numeric.arrays._values import Result
from rcac_numeric.compiled._estimators import (
    EstimationModel,
    estimation_failure,
    sensitivity,
)
from rcac_numeric.estimation._any_model import AnyModel, any_model
from rcac_numeric.estimation._compiled import compiled_model

# Steps that are looked at: enough for the rank, and the cost does not grow with the record.
LONGEST_LOOK = 300
# Below this share of the largest sensitivity a direction is told from none by rounding only.
ROUNDING = 1e-10
# What grows further hides what does not.
LARGEST_GROWTH = 1e5


class UnobservableWarning(UserWarning):
    """A record says nothing about some direction of the state, or about some parameter."""


class UnidentifiableWarning(UserWarning):
    """A record says nothing about some direction of theta, or of the covariances of noises."""


@dataclass(frozen=True, eq=False)
class Observability(Result):
    """How strongly the measurements of a record depend on each direction of the initial state.

    Attributes
    ----------
    names : tuple of str
        The entries of x.
    sensitivity : array, shape (n,)
        Singular values of [H(0); H(1) F(0); H(2) F(1) F(0); ...] after scaling x by the deviations
        of P_0, largest first.
    unseen : tuple of array
        Directions of x (in its own units) that no measurement depends on.
    steps : int
        How many steps of the record were looked at.
    """

    names: tuple[str, ...]
    sensitivity: Array
    unseen: tuple[Array, ...]
    steps: int

    def __str__(self) -> str:
        """Describe the unobservable directions."""
        if not self.unseen:
            return "the measurements determine every direction of the state."
        words = []
        for direction in self.unseen:
            share = np.abs(direction) / np.abs(direction).max()
            parts = [name for name, s in zip(self.names, share, strict=True) if s > 1e-6]
            words.append(parts[0] if len(parts) == 1 else "a combination of " + ", ".join(parts))
        return (
            f"the measurements of {self.steps} steps contain no information on "
            f"{'; '.join(words)}: the "
            "estimate remains the initial one. Excite or measure it, or take it as "
            "known."
        )


def observability(
    model: AnyModel,
    x: ArrayLike,
    u: ArrayLike | None = None,
    P_0: ArrayLike = 1.0,
) -> Observability:
    """Whether measurements along a trajectory determine the state and the parameters.

    The rank of [H(0); H(1) F(0); ...] with the Jacobians at x(k), u(k): local observability, and
    identifiability where the model has parameters.

    Parameters
    ----------
    model : LinearModel, SymbolicModel or NonlinearModel
    x : array, shape (steps, n)
        Where the model is linearised: a simulation, or an estimate.
    u : array, shape (steps, l_u), optional
        The known input, zero by default.
    P_0 : array, shape (n, n), or a number
        How uncertain the entries of x(0) are; only its diagonal matters.

    Raises
    ------
    InputError
        Where shapes do not fit or an entry is not finite.
    FunctionFailedError
        Where a function of the model failed.

    Examples
    --------
    >>> from rcac_numeric.estimation import LinearModel, observability
    >>> apart = LinearModel(A=[[0.5, 0], [0, 0.9]], C=[[1, 0]])
    >>> print(observability(apart, x=[[0, 0]] * 5))
    the measurements of 5 steps contain no information on x[1]: ...
    """
    any_model(model)
    states = signal_array(x, "x", model.n)
    if not len(states):
        raise InputError("x has no row; one for each step is needed.")
    steps = len(states)
    inputs = signal_array(np.zeros((steps, model.l_u)) if u is None else u, "u", model.l_u, steps)
    weight = constant_weight(P_0, "P_0", model.n, definite=False)
    return observability_along(
        model,
        compiled_model(model),
        states,
        inputs,
        weight,
        np.eye(model.l_y),
        np.ones((steps, model.l_y), dtype=bool),
    )


def observability_along(
    model: AnyModel,
    kernel: EstimationModel,
    x: Array,
    u: Array,
    P_0: Array,
    R: Array,
    measured: Array,
) -> Observability:
    """Return the observability along checked arrays, with rows weighted by the deviations of R."""
    steps = min(len(x), LONGEST_LOOK)
    deviation, noise = np.sqrt(np.diag(P_0)), np.sqrt(np.diag(R))
    scale = np.where(deviation > 0, deviation, 1.0)
    weight = 1.0 / np.where(noise > 0, noise, max(noise.max(initial=0.0), 1.0))
    there = np.ascontiguousarray(measured[:steps], dtype=float)
    states, inputs = np.ascontiguousarray(x[:steps]), np.ascontiguousarray(u[:steps])
    try:
        triangular = sensitivity(kernel, states, inputs, there, scale, weight, LARGEST_GROWTH)
    except Exception as error:
        raise estimation_failure(error, 0) from error
    directions, values, _ = np.linalg.svd(triangular)
    unseen = values <= ROUNDING * values.max(initial=np.finfo(float).tiny)
    return Observability(
        model.names, values, tuple(scale * direction for direction in directions.T[unseen]), steps
    )
