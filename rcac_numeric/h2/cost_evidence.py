"""How well the H2 cost of a loop is known: rounding, residuals, and balls that hold the cost."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from flint import arb, arb_mat, fmpq_mat

from compensator_theory.errors import IllConditionedError
from compensator_theory.polynomials.ball_precision import ball_precision
from rcac_numeric.analysis.gramians import PRECISIONS, enclosed_gramians, rational
from rcac_numeric.analysis.stability import EPS, counted_stable
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.h2.noise import NoiseInputs
from rcac_numeric.h2.state_space import StateSpace
from rcac_numeric.plants.linear import Plant

# Relative radius of the ball of J that is asked for, and the largest order that is tried.
NARROW, LARGEST = 1e-12, 150
Arrays = Sequence[Array]
Costs = tuple[list[float], dict[str, float], float]


def loop_rounding(
    plant: Plant, compensator: StateSpace, inputs: NoiseInputs
) -> tuple[Array, Array, Array]:
    """How far rounding may have moved the entries of A, B and Z, z's map from the state."""
    A_c, B_c, C_c, D_c = map(np.abs, compensator)
    P = {name: np.abs(getattr(plant, name)) for name in ("A", "B", "C", "D_0", "E_1", "E_2")}
    D_1, D_2 = np.abs(inputs.D_1), np.abs(inputs.D_2)
    n, n_c = plant.n, len(A_c)
    gain = np.abs(np.linalg.inv(np.eye(plant.l_u) - compensator[3] @ plant.D_0))
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
    """By how much J changes, to first order, when the entries of A, B and Z move by so much.

    dJ = 2 tr(Y dA X A') + 2 tr(Y dB B') + 2 tr(X dZ' Z)
    """
    return _moved(loop, gramians, gramians[0] @ loop[0].T, moved)


def _moved(loop: Arrays, gramians: Sequence[Array], through: Array, moved: Arrays) -> float:
    _, B, Z = (np.abs(part) for part in loop)
    X, Y = (np.abs(part) for part in gramians)
    change = np.sum(Y * (moved[0] @ np.abs(through))) + np.sum(Y * (moved[1] @ B.T))
    return 2 * float(change + np.sum(X * (moved[2].T @ Z)))


def residual_error(loop: Arrays, gramians: Sequence[Array]) -> float:
    """How wrong J may be by what is left of both Lyapunov equations, rounding included.

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
    """Costs of each noise, the terms of their sum, and its sensitivity; None for an unstable loop.

    The loop is formed over the rationals, so that the given float64 numbers are the only ones;
    stability is decided for it, and J enclosed in a ball that is narrow to 1e-12.

    Raises
    ------
    IllConditionedError
        Where changing each entry of the loop by one rounding can change J by as much as J, or the
        loop is larger than 150 states.
    """
    A, B, maps = exact_loop(plant, compensator, inputs)
    n = A.nrows()
    if n > LARGEST:
        raise IllConditionedError(
            f"float64 does not determine the cost of this loop, and with {n} states ball "
            "arithmetic takes too long. Scale states and signals to like size."
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
        "the H2 cost of this loop is decided by rounding: changing each entry of plant and "
        "compensator by one rounding of float64 can change the cost by as much as the cost "
        "itself, because poles are that near to the unit circle. Use another compensator, or "
        "scale states and signals to like size."
    )


def exact_loop(
    plant: Plant, compensator: StateSpace, inputs: NoiseInputs
) -> tuple[fmpq_mat, fmpq_mat, tuple[fmpq_mat, fmpq_mat, fmpq_mat, fmpq_mat]]:
    """A and B of the loop, and (E_x, E_w, U_x, U_w) of z = E_x x + E_w w + U_x x + U_w w."""
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
    own = _above(_beside(p["A"], fmpq_mat(n, n_c)), _beside(fmpq_mat(n_c, n), A_c))
    A = own + _above(p["B"] * K_x, B_c * y_x)
    B = _above(D_1 + p["B"] * K_w, B_c * y_w)
    return A, B, (
        _beside(p["E_1"], fmpq_mat(plant.l_z, n_c)), E_0, p["E_2"] * K_x, p["E_2"] * K_w
    )  # fmt: skip


def _balls(
    B: fmpq_mat,
    maps: tuple[fmpq_mat, fmpq_mat, fmpq_mat, fmpq_mat],
    gramians: tuple[arb_mat, arb_mat],
) -> tuple[list[arb], dict[str, arb]]:
    """The cost of each column of B, from the dual, and the terms of their sum."""
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
    """By how much J changes, to first order, when each entry of A, B and Z is rounded once."""
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
