"""The H2 cost of a stabilising compensator, and the share of each disturbance in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from compensator_theory.errors import IllConditionedError, ImproperError, InputError
from rcac_numeric.analysis.gramians import stein_solution
from rcac_numeric.analysis.stability import EPS, decide_stability
from rcac_numeric.arrays.algebraic_loops import closes
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.values import Value
from rcac_numeric.h2.cost_evidence import (
    NARROW,
    enclosed_cost,
    loop_rounding,
    moved_cost,
    residual_error,
)
from rcac_numeric.h2.noise import NoiseInputs, NoiseIntensities, noise_inputs
from rcac_numeric.h2.state_space import StateSpace, state_space_of
from rcac_numeric.plants.foreign.reading import linear_plant
from rcac_numeric.plants.linear import Plant

# Relative error of J, by the bound that its residuals and its data leave, up to which float64 is
# trusted; beyond it the cost is computed in ball arithmetic.
TRUSTED = 1e-9


@dataclass(frozen=True, eq=False)
class H2Cost(Value):
    """The stationary mean square of z for white noise w, in its parts.

    Attributes
    ----------
    value : float
        J of (A.3); infinite where the loop is not asymptotically stable, or J is beyond float64.
    shares : mapping from names of noises to floats
        Each noise's own part of `value`, the others being off.
    terms : mapping from names to floats
        "state" tr(Q_1 R_1), "cross" 2 tr(R_12 C_c Q_12'), "control" tr(Q_2 C_c' R_2 C_c) and
        "direct", what w adds to z within the same step.
    spectral_radius : float
        Of the closed loop, from computed eigenvalues; those of a strongly non-normal loop are
        wrong by more than rounding, and whether `value` is finite is not read off them.
    discrepancy : float
        Difference between `value`, from the dual equation, and the sum of the terms, from the
        covariance (4.23), over the sum of their sizes.
    error_bound : float
        Relative error of `value` that is left: by the residuals of both Lyapunov equations and
        the rounding of the loop's matrices, to first order.
    sensitivity : float
        Relative change of J, to first order, when every entry of the loop's matrices changes by
        one rounding of float64: digits beyond it are those of the numbers as given.
    evidence : {"float64", "ball arithmetic", "unstable", "beyond float64"}
        How `value` is known.
    """

    value: float
    shares: Mapping[str, float]
    terms: Mapping[str, float]
    spectral_radius: float
    discrepancy: float
    error_bound: float = 0.0
    sensitivity: float = 0.0
    evidence: str = "float64"

    def __float__(self) -> float:
        return self.value

    def __repr__(self) -> str:
        parts = ", ".join(f"{name} {share:.6g}" for name, share in self.shares.items())
        return f"H2Cost({self.value:.6g}: {parts})"


def h2_cost(plant: Plant, compensator: Any, *, noise: NoiseIntensities | None = None) -> H2Cost:
    """Compute J = lim E[z'z] of the loop u = G_c y for white noise w.

    J = tr(Q_1 R_1) + 2 tr(R_12 C_c Q_12') + tr(Q_2 C_c' R_2 C_c) + tr(E_0 E_0')

    for a strictly proper compensator; an exactly proper one adds its D_c to u and to each term.

    Parameters
    ----------
    plant : Plant
    compensator : Compensator, python-control system or (A_c, B_c, C_c, D_c)
        For the positive feedback u = G_c y of chapters 2 and 4.
    noise : mapping, optional
        Intensities of blocks or channels of w, see `noise_inputs`; 1 for every channel by
        default. What it leaves out is zero.

    Returns
    -------
    H2Cost
        `float` of it is J.

    Raises
    ------
    ImproperError
        Where I - D_c D_0 is singular.
    InputError
        Where the compensator or the intensities do not fit the plant.
    IllConditionedError
        Where the loop is stable for these numbers, but changing each entry by one rounding can
        change J by as much as J: rounding decides, and J is undecided.

    Notes
    -----
    Stability is decided by `decide_stability`, never by the computed radius; J is taken from
    float64 where its error is at most 1e-9 by the bound, else from ball arithmetic.
    Source: (4.20)-(4.23). Errata: (4.21) leaves out the cross term, which is zero for R_12 = 0
    only, and the direct term.

    Examples
    --------
    >>> from rcac_numeric import Compensator, h2_cost, standard_plant
    >>> none = Compensator(past_u=[[[0.0]]], past_y=[[[0.0]], [[0.0]]])
    >>> h2_cost(standard_plant("1/(q - 0.6)"), none)  # 1 / (1 - 0.36)
    H2Cost(1.5625: w 1.5625)
    >>> float(h2_cost(standard_plant("1/(q - 1)"), none))
    inf
    """
    plant = linear_plant(plant)
    parts = state_space_of(compensator, plant.l_u, plant.l_y)
    inputs = noise_inputs(plant, noise)
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is looked for
        return _cost(plant, parts, inputs)


def _cost(plant: Plant, compensator: StateSpace, inputs: NoiseInputs) -> H2Cost:
    A, B, (E_x, E_w), (K_x, K_w) = loop_matrices(plant, compensator, inputs)
    if not (np.isfinite(A).all() and np.isfinite(B).all()):
        raise InputError("the closed loop has entries beyond float64; rescale the signals.")
    radius = float(np.abs(np.linalg.eigvals(A)).max(initial=0.0))
    u_x, u_w = plant.E_2 @ K_x, plant.E_2 @ K_w
    rounding = loop_rounding(plant, compensator, inputs)
    try:
        if not decide_stability(A, rounding[0]).is_stable:
            return _infinite(inputs, radius)
    except IllConditionedError:
        return _enclosed(plant, compensator, inputs, radius)
    Z, W = E_x + u_x, E_w + u_w
    X, Y = stein_solution(A, B @ B.T), stein_solution(A.T, Z.T @ Z)
    terms = {
        "state": _mean_square(E_x, X),
        "cross": 2 * float(np.sum((E_x @ X) * u_x)),
        "control": _mean_square(u_x, X),
        "direct": float(np.sum(W**2)),
    }
    each = np.sum(B * (Y @ B), axis=0) + np.sum(W**2, axis=0)
    value = float(each.sum())
    loop, gramians = (A, B, Z), (X, Y)
    error = residual_error(loop, gramians) + moved_cost(loop, gramians, rounding)
    if not error <= TRUSTED * value:
        return _enclosed(plant, compensator, inputs, radius)
    once = (EPS * np.abs(A), EPS * np.abs(B), EPS * np.abs(Z))
    sensitivity = moved_cost(loop, gramians, once)
    return _result(
        inputs, [float(one) for one in each], terms, radius,
        error_bound=error / value if value else 0.0,
        sensitivity=sensitivity / value if value else 0.0,
    )  # fmt: skip


def _enclosed(plant: Plant, compensator: StateSpace, inputs: NoiseInputs, radius: float) -> H2Cost:
    found = enclosed_cost(plant, compensator, inputs)
    if found is None:
        return _infinite(inputs, radius)
    each, terms, sensitivity = found
    return _result(
        inputs, each, terms, radius,
        error_bound=NARROW, sensitivity=sensitivity, evidence="ball arithmetic",
    )  # fmt: skip


def _result(
    inputs: NoiseInputs, each: list[float], terms: dict[str, float], radius: float, **evidence: Any
) -> H2Cost:
    # The shares are sums of squares; the terms may cancel and leave less than nothing.
    each = [max(share, 0.0) for share in each]
    value, total = sum(each), sum(terms.values())
    if not (np.isfinite(value) and np.isfinite(total)):
        return _infinite(inputs, radius, "beyond float64")
    shares = dict.fromkeys(inputs.names, 0.0)
    for name, share in zip(inputs.names, each, strict=True):
        shares[name] += share
    size = sum(map(abs, terms.values()))
    gap = abs(value - total) / size if size else 0.0
    return H2Cost(value, shares, terms, radius, gap, **evidence)


def loop_matrices(
    plant: Plant, compensator: StateSpace, inputs: NoiseInputs
) -> tuple[Array, Array, tuple[Array, Array], tuple[Array, Array]]:
    """A and B of the loop with the state [x; x_c], z without E_2 u, and u, each from state and w.

    Raises
    ------
    ImproperError
        Where I - D_c D_0 is singular.
    """
    A_c, B_c, C_c, D_c = compensator
    n, n_c, l_noise = plant.n, len(A_c), len(inputs.names)
    if not closes(D_c, plant.D_0):
        raise ImproperError("I - D_c D_0 is singular: u and y depend on each other in a circle.")
    direct = np.eye(plant.l_u) - D_c @ plant.D_0
    K_x = np.asarray(np.linalg.solve(direct, np.hstack([D_c @ plant.C, C_c])), dtype=np.float64)
    K_w = np.asarray(np.linalg.solve(direct, D_c @ inputs.D_2), dtype=np.float64)
    y_x = np.hstack([plant.C, np.zeros((plant.l_y, n_c))]) + plant.D_0 @ K_x
    y_w = inputs.D_2 + plant.D_0 @ K_w
    own = np.vstack(
        [np.hstack([plant.A, np.zeros((n, n_c))]), np.hstack([np.zeros((n_c, n)), A_c])]
    )
    A = own + np.vstack([plant.B @ K_x, B_c @ y_x])
    B = np.vstack([inputs.D_1 + plant.B @ K_w, B_c @ y_w]).reshape(n + n_c, l_noise)
    return A, B, (np.hstack([plant.E_1, np.zeros((plant.l_z, n_c))]), inputs.E_0), (K_x, K_w)


def _mean_square(C: Array, covariance: Array) -> float:
    return float(np.sum((C @ covariance) * C))


def _infinite(inputs: NoiseInputs, radius: float, why: str = "unstable") -> H2Cost:
    """Where a share cannot be told from the others each is infinite too."""
    infinite = float("inf")
    terms = dict.fromkeys(("state", "cross", "control", "direct"), infinite)
    return H2Cost(infinite, dict.fromkeys(inputs.names, infinite), terms, radius, 0.0, evidence=why)
