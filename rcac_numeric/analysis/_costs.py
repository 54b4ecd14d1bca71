"""The H2 cost of a stabilising compensator, with the share of each disturbance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import arb, arb_mat, fmpq_mat

from compensator_theory.errors import IllConditionedError, ImproperError, InputError
from compensator_theory.polynomials._ball_precision import ball_precision
from rcac_numeric.analysis._gramians import PRECISIONS, enclosed_gramians, rational, stein_solution
from rcac_numeric.analysis._loop_analysis import closed_loop
from rcac_numeric.analysis._noise import NoiseInputs, NoiseIntensities, noise_inputs
from rcac_numeric.analysis._stability import EPS, counted_stable, is_schur_stable
from rcac_numeric.analysis._state_space import StateSpace, state_space_of
from rcac_numeric.arrays._algebraic_loops import closes
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._values import Result
from rcac_numeric.engine._runs import Run
from rcac_numeric.plants._foreign import agreed_times, linear_plant
from rcac_numeric.plants._linear import Plant

# Largest relative error bound of J for a float64 result; above it the cost is computed in ball
# arithmetic.
TRUSTED = 1e-9


@dataclass(frozen=True, eq=False)
class H2Cost(Result):
    """The stationary mean square of z for white noise w, with its parts.

    Attributes
    ----------
    value : float
        J of (A.3); infinite where the loop is not asymptotically stable, or J is beyond float64.
    shares : mapping from names of noises to floats
        The part of `value` of each noise, with the others zero.
    terms : mapping from names to floats
        "state" tr(Q_1 R_1), "cross" 2 tr(R_12 C_c Q_12'), "control" tr(Q_2 C_c' R_2 C_c) and
        "direct", the part of z by w of the same step.
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


def h2_cost(
    plant: Plant | Run, compensator: Any = None, *, noise: NoiseIntensities | None = None
) -> H2Cost:
    """Compute J = lim E[z'z] of the loop u = G_c y for white noise w.

    J = tr(Q_1 R_1) + 2 tr(R_12 C_c Q_12') + tr(Q_2 C_c' R_2 C_c) + tr(E_0 E_0')

    for a strictly proper compensator; an exactly proper one adds its D_c to u and to each term.

    Parameters
    ----------
    plant : Plant, a system that `plant_of` reads, or Run
        A run has its compensator: its last controller.
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
    Stability is decided as `ClosedLoop.is_stable`, never by the computed radius; J is taken from
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
    if isinstance(plant, Run):
        if compensator is not None:
            raise InputError("a run contains its controller; leave compensator out.")
        loop = closed_loop(plant)
        plant, compensator = loop.plant, loop.compensator
    plant = linear_plant(plant)
    if compensator is None:
        raise InputError("a loop needs a controller; give the compensator, or a Run.")
    agreed_times([plant, compensator])
    parts = state_space_of(compensator, plant.l_u, plant.l_y)
    inputs = noise_inputs(plant, noise)
    with np.errstate(over="ignore", invalid="ignore"):  # overflow is checked below
        return _cost(plant, parts, inputs)


def _cost(plant: Plant, compensator: StateSpace, inputs: NoiseInputs) -> H2Cost:
    A, B, (E_x, E_w), (K_x, K_w) = loop_matrices(plant, compensator, inputs)
    if not (np.isfinite(A).all() and np.isfinite(B).all()):
        raise InputError("the closed loop has entries beyond float64; rescale the signals.")
    radius = float(np.abs(np.linalg.eigvals(A)).max(initial=0.0))
    u_x, u_w = plant.E_2 @ K_x, plant.E_2 @ K_w
    rounding = loop_rounding(plant, compensator, inputs)
    try:
        if not is_schur_stable(A, rounding[0]):
            return _infinite(inputs, radius)
    except IllConditionedError:
        return _enclosed(plant, compensator, inputs, radius)
    Z, W = E_x + u_x, E_w + u_w
    try:
        X, Y = stein_solution(A, B @ B.T), stein_solution(A.T, Z.T @ Z)
    except IllConditionedError:
        return _enclosed(plant, compensator, inputs, radius)
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
    cost = enclosed_cost(plant, compensator, inputs)
    if cost is None:
        return _infinite(inputs, radius)
    each, terms, sensitivity = cost
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
    """Return A and B of the loop with state [x; x_c], and z without E_2 u, and u."""
    A_c, B_c, C_c, D_c = compensator
    n, n_c, l_noise = plant.n, len(A_c), len(inputs.names)
    if not closes(D_c, plant.D_0):
        raise ImproperError(
            "I - D_c D_0 is singular: the algebraic loop of u and y is not well posed."
        )
    direct = np.eye(plant.l_u) - D_c @ plant.D_0
    K_x = np.asarray(np.linalg.solve(direct, np.hstack([D_c @ plant.C, C_c])), dtype=np.float64)
    K_w = np.asarray(np.linalg.solve(direct, D_c @ inputs.D_2), dtype=np.float64)
    y_x = np.hstack([plant.C, np.zeros((plant.l_y, n_c))]) + plant.D_0 @ K_x
    y_w = inputs.D_2 + plant.D_0 @ K_w
    dynamics = np.vstack(
        [np.hstack([plant.A, np.zeros((n, n_c))]), np.hstack([np.zeros((n_c, n)), A_c])]
    )
    A = dynamics + np.vstack([plant.B @ K_x, B_c @ y_x])
    B = np.vstack([inputs.D_1 + plant.B @ K_w, B_c @ y_w]).reshape(n + n_c, l_noise)
    return A, B, (np.hstack([plant.E_1, np.zeros((plant.l_z, n_c))]), inputs.E_0), (K_x, K_w)


def _mean_square(C: Array, covariance: Array) -> float:
    return float(np.sum((C @ covariance) * C))


def _infinite(inputs: NoiseInputs, radius: float, why: str = "unstable") -> H2Cost:
    """Return an infinite cost; shares that cannot be separated are infinite too."""
    infinite = float("inf")
    terms = dict.fromkeys(("state", "cross", "control", "direct"), infinite)
    return H2Cost(infinite, dict.fromkeys(inputs.names, infinite), terms, radius, 0.0, evidence=why)


# Accuracy of the H2 cost: rounding, residuals, and enclosures in balls.

# Target relative radius of the ball of J, and the largest order.
NARROW, LARGEST = 1e-12, 150
Arrays = Sequence[Array]
Costs = tuple[list[float], dict[str, float], float]


def loop_rounding(
    plant: Plant, compensator: StateSpace, inputs: NoiseInputs
) -> tuple[Array, Array, Array]:
    """Return the rounding errors of the entries of A, B and Z, the map from state to z."""
    A_c, B_c, C_c, D_c = map(np.abs, compensator)
    P = {name: np.abs(getattr(plant, name)) for name in ("A", "B", "C", "D_0", "E_1", "E_2")}
    D_1, D_2 = np.abs(inputs.D_1), np.abs(inputs.D_2)
    n, n_c = plant.n, len(A_c)
    direct = np.eye(plant.l_u) - compensator[3] @ plant.D_0
    gain = np.abs(np.linalg.inv(direct))
    # Where D_c D_0 is near I the rounding of their difference counts by its inverse once more.
    gain = gain @ (np.abs(direct) + D_c @ P["D_0"]) @ gain
    K_x, K_w = gain @ np.hstack([D_c @ P["C"], C_c]), gain @ D_c @ D_2
    y_x = np.hstack([P["C"], np.zeros((plant.l_y, n_c))]) + P["D_0"] @ K_x
    y_w = D_2 + P["D_0"] @ K_w
    A = np.vstack([P["B"] @ K_x, B_c @ y_x])
    A[:n, :n] += P["A"]
    A[n:, n:] += A_c
    B = np.vstack([D_1 + P["B"] @ K_w, B_c @ y_w])
    Z = P["E_2"] @ K_x
    Z[:, :n] += P["E_1"]
    share = 2 * (plant.n + n_c + plant.l_u + plant.l_y + 4) * EPS
    return share * A, share * B, share * Z


def moved_cost(loop: Arrays, gramians: Sequence[Array], moved: Arrays) -> float:
    """Return the first-order change of J for changes of the entries of A, B and Z.

    dJ = 2 tr(Y dA X A') + 2 tr(Y dB B') + 2 tr(X dZ' Z)
    """
    return _moved(loop, gramians, gramians[0] @ loop[0].T, moved)


def _moved(loop: Arrays, gramians: Sequence[Array], through: Array, moved: Arrays) -> float:
    _, B, Z = (np.abs(part) for part in loop)
    X, Y = (np.abs(part) for part in gramians)
    change = np.sum(Y * (moved[0] @ np.abs(through))) + np.sum(Y * (moved[1] @ B.T))
    return 2 * float(change + np.sum(X * (moved[2].T @ Z)))


def residual_error(loop: Arrays, gramians: Sequence[Array]) -> float:
    """Return a bound of the error of J from the residuals of both Lyapunov equations.

    tr(Z (X - X_true) Z') = -tr(Y R), R = A X A' + B B' - X, and so for the dual.
    """
    A, B, Z = loop
    total = 0.0
    for A_, F, X, Y in ((A, B, *gramians), (A.T, Z.T, gramians[1], gramians[0])):
        a, f = np.abs(A_), np.abs(F)
        through = X @ A_.T
        share = 2 * (len(A) + F.shape[1] + 4) * EPS
        left = np.abs(A_ @ through + F @ F.T - X)
        left += share * (a @ np.abs(through) + a @ np.abs(X) @ a.T + f @ f.T)
        total += float(np.sum(np.abs(Y) * left))
    return total


def enclosed_cost(plant: Plant, compensator: StateSpace, inputs: NoiseInputs) -> Costs | None:
    """Enclose the cost of each noise, the terms and the sensitivity; None for an unstable loop.

    The loop is formed over the rationals, so that the given float64 numbers are the only ones;
    stability is decided for it, and J enclosed in a ball that is narrow to 1e-12.
    """
    A, B, maps = exact_loop(plant, compensator, inputs)
    n = A.nrows()
    if n > LARGEST:
        raise IllConditionedError(
            f"float64 does not determine the cost of this loop, and with {n} states ball "
            "arithmetic takes too long. Scale states and signals to similar magnitude."
        )
    E, U = maps[0], maps[2]
    for precision in PRECISIONS:
        gramians = enclosed_gramians(A, B * B.transpose(), _square(E + U), precision)
        if gramians is None:
            if not counted_stable(A):
                return None
            continue
        with ball_precision(precision):
            each, terms = _balls(B, maps, gramians)
            total = sum(each, arb(0))
            if float(total.rad()) <= NARROW * abs(float(total.mid())) or total == 0:
                middles = {name: float(term.mid()) for name, term in terms.items()}
                change = _change(A, B, E + U, gramians)
                if np.isfinite(change) and 0 < sum(map(abs, middles.values())) <= change:
                    break
                relative = change / float(total.mid()) if total != 0 else 0.0
                return [float(one.mid()) for one in each], middles, relative
    raise IllConditionedError(
        "float64 does not determine the H2 cost of this loop: poles are so close to the unit "
        "circle that one rounding of each entry of plant and compensator can change the cost "
        "by 100 %. Use another compensator, or scale states and signals to similar "
        "magnitude."
    )


def exact_loop(
    plant: Plant, compensator: StateSpace, inputs: NoiseInputs
) -> tuple[fmpq_mat, fmpq_mat, tuple[fmpq_mat, fmpq_mat, fmpq_mat, fmpq_mat]]:
    """Return A and B of the loop, and (E_x, E_w, U_x, U_w) of z = (E_x + U_x) x + (E_w + U_w) w."""
    A_c, B_c, C_c, D_c = map(rational, compensator)
    p = {name: rational(getattr(plant, name)) for name in ("A", "B", "C", "D_0", "E_1", "E_2")}
    D_1, D_2, E_0 = (rational(m) for m in (inputs.D_1, inputs.D_2, inputs.E_0))
    n, n_c, l_u = plant.n, A_c.nrows(), plant.l_u
    one = fmpq_mat(l_u, l_u, [int(i == j) for i in range(l_u) for j in range(l_u)])
    inverse = (one - D_c * p["D_0"]).inv()
    K_x = inverse * _beside(D_c * p["C"], C_c)
    K_w = inverse * (D_c * D_2)
    y_x = _beside(p["C"], fmpq_mat(plant.l_y, n_c)) + p["D_0"] * K_x
    y_w = D_2 + p["D_0"] * K_w
    dynamics = _above(_beside(p["A"], fmpq_mat(n, n_c)), _beside(fmpq_mat(n_c, n), A_c))
    A = dynamics + _above(p["B"] * K_x, B_c * y_x)
    B = _above(D_1 + p["B"] * K_w, B_c * y_w)
    return A, B, (
        _beside(p["E_1"], fmpq_mat(plant.l_z, n_c)), E_0, p["E_2"] * K_x, p["E_2"] * K_w
    )  # fmt: skip


def _balls(
    B: fmpq_mat,
    maps: tuple[fmpq_mat, fmpq_mat, fmpq_mat, fmpq_mat],
    gramians: tuple[arb_mat, arb_mat],
) -> tuple[list[arb], dict[str, arb]]:
    """Return the cost of each column of B from the dual equation, and the terms of the sum."""
    X, Y = gramians
    E, E_w, U, U_w = (arb_mat(part) for part in maps)
    drive, direct = arb_mat(B), E_w + U_w
    each = [_inner(column, Y * column) for column in _columns(drive)]
    each = [a + _inner(d, d) for a, d in zip(each, _columns(direct), strict=True)]
    return each, {
        "state": _inner(E, E * X),
        "cross": 2 * _inner(U, E * X),
        "control": _inner(U, U * X),
        "direct": _inner(direct, direct),
    }


def _change(A: fmpq_mat, B: fmpq_mat, Z: fmpq_mat, gramians: tuple[arb_mat, arb_mat]) -> float:
    """Return the first-order change of J when each entry of A, B and Z is rounded once."""
    loop = tuple(_middles(arb_mat(part)) for part in (A, B, Z))
    through = _middles(gramians[0] * arb_mat(A).transpose())
    once = [EPS * np.abs(part) for part in loop]
    with np.errstate(all="ignore"):  # beyond float64
        return _moved(loop, [_middles(part) for part in gramians], through, once)


def _middles(A: arb_mat) -> Array:
    return np.array([float(e.mid()) for e in A.entries()]).reshape(A.nrows(), A.ncols())


def _square(Z: fmpq_mat) -> fmpq_mat:
    return Z.transpose() * Z


def _inner(a: arb_mat, b: arb_mat) -> arb:
    return sum((x * y for x, y in zip(a.entries(), b.entries(), strict=True)), arb(0))


def _columns(A: arb_mat) -> list[arb_mat]:
    rows = range(A.nrows())
    return [arb_mat(A.nrows(), 1, [A[i, j] for i in rows]) for j in range(A.ncols())]


def _beside(left: fmpq_mat, right: fmpq_mat) -> fmpq_mat:
    entries = [
        (left[i, j] if j < left.ncols() else right[i, j - left.ncols()])
        for i in range(left.nrows())
        for j in range(left.ncols() + right.ncols())
    ]
    return fmpq_mat(left.nrows(), left.ncols() + right.ncols(), entries)


def _above(top: fmpq_mat, bottom: fmpq_mat) -> fmpq_mat:
    return _beside(top.transpose(), bottom.transpose()).transpose()
