"""Compensators given in state space: read from several forms, and written as (2.28)."""

from __future__ import annotations

from typing import Any

import numpy as np
from sympy import Matrix, Symbol

import compensator_theory as exact
from compensator_theory.errors import InputError
from compensator_theory.systems.state_space import transfer_matrix_of_realisation
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import matrix
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.h2.lyapunov import stein_solution

StateSpace = tuple[Array, Array, Array, Array]


def state_space_of(compensator: Any, l_u: int, l_y: int) -> StateSpace:
    """(A_c, B_c, C_c, D_c) of a Compensator, a python-control system or four arrays.

    Raises
    ------
    InputError
        Where it is none of them, is in continuous time or has the wrong numbers of signals.

    Examples
    --------
    >>> from rcac_numeric import Compensator
    >>> from rcac_numeric.h2.state_space import state_space_of
    >>> state_space_of(Compensator(past_u=[[[0.5]]], past_y=[[[0.0]], [[2.0]]]), 1, 1)
    (array([[0.5]]), array([[2.]]), array([[1.]]), array([[0.]]))
    """
    if isinstance(compensator, Compensator):
        parts: Any = compensator.state_space()
    elif isinstance(compensator, tuple | list):
        parts = compensator
    else:
        parts = _of_control(compensator)
    if len(parts) != 4:
        raise InputError(
            f"a compensator in state space is (A_c, B_c, C_c, D_c); {len(parts)} matrices were "
            "given. Write D_c = 0 for a strictly proper one."
        )
    A_c = matrix(parts[0], "A_c", (None, None))
    n_c = len(A_c)
    return (
        matrix(A_c, "A_c", (n_c, n_c)),
        matrix(parts[1], "B_c", (n_c, l_y)),
        matrix(parts[2], "C_c", (l_u, n_c)),
        matrix(parts[3], "D_c", (l_u, l_y)),
    )


def compensator_from_state_space(A_c: Any, B_c: Any, C_c: Any, D_c: Any = None) -> Compensator:
    """The difference equation (2.28) of a compensator in state space.

    With one output D_c(q) = det(qI - A_c), computed exactly and rounded once. With several, each
    is followed back to the first of its past values that the later ones determine (observability
    indices); outputs that are nearly combinations of the others only follow. What (2.28) has more
    states than A_c are poles at 0, and modes of A_c that u does not show are left out.

    Parameters
    ----------
    A_c, B_c, C_c, D_c : arrays of shape (n_c, n_c), (n_c, l_y), (l_u, n_c), (l_u, l_y)
        D_c is zero by default.

    Returns
    -------
    Compensator
        Of an order of at most n_c, at least 1.

    Examples
    --------
    >>> from rcac_numeric import compensator_from_state_space
    >>> G_c = compensator_from_state_space([[0.5, 1.0], [0.0, 0.2]], [[0.0], [1.0]], [[1.0, 0.0]])
    >>> G_c.denominator, G_c.numerator
    (array([ 1. , -0.7,  0.1]), array([0., 0., 1.]))
    """
    A = matrix(A_c, "A_c", (None, None))
    A = matrix(A, "A_c", (len(A), len(A)))
    B = matrix(B_c, "B_c", (len(A), None))
    C = matrix(C_c, "C_c", (None, len(A)))
    l_u, l_y = C.shape[0], B.shape[1]
    D = np.zeros((l_u, l_y)) if D_c is None else matrix(D_c, "D_c", (l_u, l_y))
    if not (A.size and C.any()):
        return Compensator(np.zeros((1, l_u, l_u)), np.stack([D, np.zeros_like(D)]))
    if l_u == 1:
        return _of_one_output(A, B, C, D)
    # Any set of outputs that shows every mode can lead; the best has the smallest coefficients.
    leaders = [set(range(l_u)), *({i} for i in range(l_u))]
    if l_u > 2:
        leaders += [set(range(l_u)) - {i} for i in range(l_u)]
    rank = _observable(A, C)
    found = [P for chosen in leaders if (P := _row_relations(A, C, chosen, rank)) is not None]
    return min(
        (Compensator(P, _numerators(P, A, B, C, D)) for P in found),
        key=lambda c: float(max(np.abs(c.past_u).max(), np.abs(c.past_y).max())),
    )


def _of_one_output(A: Array, B: Array, C: Array, D: Array) -> Compensator:
    a, b, c, d = (
        Matrix(*m.shape, [exact.exact_number(float(entry), binary=True) for entry in m.ravel()])
        for m in (A, B, C, D)
    )
    maps = transfer_matrix_of_realisation(a, b, c, d, Symbol("q"))
    n = len(A)
    denominator = maps[0, 0].denominator
    P = [-float(denominator.nth(n - i)) for i in range(1, n + 1)]
    Q = [
        [float(maps[0, column].numerator.nth(n - i)) for column in range(B.shape[1])]
        for i in range(n + 1)
    ]
    return Compensator(np.array(P)[:, None, None], np.array(Q)[:, None, :])


def _numerators(P: Array, A: Array, B: Array, C: Array, D: Array) -> Array:
    """The coefficients of D_c(q) G_c(q), from the Markov parameters of G_c."""
    markov, row = [D], C
    for _ in range(len(P)):
        markov.append(row @ B)
        row = row @ A
    Q = np.array(markov)
    for i in range(len(P), 0, -1):
        Q[i] = markov[i] - sum(P[j - 1] @ markov[i - j] for j in range(1, i + 1))
    return Q


def _row_relations(A: Array, C: Array, leaders: set[int], rank: int) -> Array | None:
    """P_1, P_2, ... with C A^N = sum of P_j C A^{N-j}; None where the leaders miss a mode.

    The rows of C, CA, ... are searched in this order for those that the earlier ones do not give.
    A leader is closed by its first dependent row, the others by the last power of all.
    """
    l_u, n = C.shape
    scale = max(float(np.abs(np.linalg.eigvals(A)).max()), 1e-3)
    powers = [C]
    for _ in range(n):
        powers.append(powers[-1] @ A / scale)
    chosen: list[tuple[int, int]] = []  # (output, power) of the independent rows found so far
    closed: dict[int, int] = {}
    for power, output in ((p, i) for p in range(n + 1) for i in sorted(leaders)):
        if output in closed:
            continue
        rows = [powers[p][i] for i, p in [*chosen, (output, power)]]
        if _independent(np.array(rows)) and len(chosen) < rank:
            chosen.append((output, power))
        else:
            closed[output] = power
    if len(chosen) < rank and len(leaders) < l_u:
        return None
    order = max(1, *closed.values())
    closed.update({output: order for output in range(l_u) if output not in leaders})
    leading, P = np.eye(l_u), np.zeros((order, l_u, l_u))
    for output, index in closed.items():
        known = [(i, p) for i, p in chosen if p < index or (p == index and (i < output))]
        basis = np.array([powers[p][i] for i, p in known]).reshape(-1, n).T
        values = np.linalg.lstsq(basis, powers[index][output], rcond=None)[0]
        for value, (other, p) in zip(values, known, strict=True):
            if p == index:  # the same step: an earlier leader
                leading[output, other] -= value
            else:
                P[index - p - 1, output, other] += value * scale ** (index - p)
    return np.asarray(np.linalg.solve(leading, P))


def _independent(rows: Array) -> bool:
    sizes = np.linalg.norm(rows, axis=1, keepdims=True)
    if not sizes.all() or len(rows) > rows.shape[1]:
        return False
    return bool(np.linalg.svd(rows / sizes, compute_uv=False)[-1] > 1e-10)


def _observable(A: Array, C: Array) -> int:
    """The number of modes of A that C shows, by the observability Gramian of a scaled A."""
    scale = 2 * max(float(np.abs(np.linalg.eigvals(A)).max()), 1e-3)
    gramian = stein_solution(A.T / scale, C.T @ C)
    values = np.linalg.eigvalsh(gramian)
    return int(np.sum(values > 1e-20 * values.max())) if values.size else 0


def _of_control(system: Any) -> StateSpace:
    import control

    if not isinstance(system, control.StateSpace | control.TransferFunction):
        raise InputError(
            f"{system!r} is no compensator; give a Compensator, a python-control system or "
            "(A_c, B_c, C_c, D_c)."
        )
    if system.isctime(strict=True):
        raise InputError("the compensator is in continuous time; discretise it first, with c2d.")
    system = control.ss(system)
    return system.A, system.B, system.C, system.D
