"""Extraction of the pure delay of a scalar state-space system."""

from __future__ import annotations

import numpy as np

from rcac_numeric.arrays._array_types import Array

Matrices = tuple[Array, Array, Array, Array]


def without_delay(A: Array, B: Array, C: Array, D: Array) -> tuple[int, Matrices]:
    """Return k >= 0 and a system with C (zI - A)^{-1} B + D = z^{-k} times its response.

    A state is a step of delay where it is another one a step ago, by entries that are 1. Steps are
    taken away where the output reads nothing else, where the input enters nothing else, and where
    every path from the input to the output passes a chain of them. The states that leave have their
    poles at 0.
    """
    if D.any() or not len(A):
        return 0, (A, B, C, D)
    steps, (A, B, C) = _inner_chains(A, B, C)
    for is_dual in (False, True):
        if is_dual:
            A, B, C = A.T, C.T, B.T
        while (shorter := _without_last(A, B, C)) is not None:
            steps, (A, B, C) = steps + 1, shorter
        if is_dual:
            A, B, C = A.T, C.T, B.T
    return steps, (A, B, C, D)


def _without_last(A: Array, B: Array, C: Array) -> tuple[Array, Array, Array] | None:
    """Remove an output delay step and an unread state; None if there is no such step.

    y = C x = z^{-1} C A x where no state that is read takes anything of the input.
    """
    read = np.flatnonzero(C[0])
    is_shift = (np.count_nonzero(A[read], axis=1) == 1) & (A[read].max(axis=1) == 1)
    if not len(read) or not is_shift.all() or B[read].any() or A[read, read].any():
        return None
    C = C @ A
    retained = A.any(axis=0) | C.any(axis=0)
    if retained.all() or not C.any():
        return None
    return A[np.ix_(retained, retained)], B[retained], C[:, retained]


def _inner_chains(A: Array, B: Array, C: Array) -> tuple[int, tuple[Array, Array, Array]]:
    """Contract every delay chain that all paths pass to its first state."""
    is_shift = (np.count_nonzero(A, axis=1) == 1) & (A.max(axis=1) == 1) & ~B.any(axis=1)
    readers = np.count_nonzero(A, axis=0) + np.count_nonzero(C, axis=0)
    # follows[j] = i: x_j is x_i a step ago, and nothing else reads x_i
    follows = {}
    for j in np.flatnonzero(is_shift):
        i = int(A[j].argmax())
        if i != j and readers[i] == 1:
            follows[int(j)] = i
    leads = {i: j for j, i in follows.items()}
    steps, removed = 0, np.zeros(len(A), dtype=bool)
    A, C = A.copy(), C.copy()
    for first in leads.keys() - follows.keys():
        chain = [first]
        while chain[-1] in leads:
            chain.append(leads[chain[-1]])
        if not _is_passed_once(A, B, C, first):
            continue
        last = chain[-1]
        A[:, first], C[:, first] = A[:, last], C[:, last]
        removed[chain[1:]] = True
        steps += len(chain) - 1
    retained = ~removed
    return steps, (A[np.ix_(retained, retained)], B[retained], C[:, retained])


def _is_passed_once(A: Array, B: Array, C: Array, state: int) -> bool:
    """Whether every path from input to output passes a state exactly once."""
    links = A != 0
    onward = np.zeros(len(A), dtype=bool)
    onward[state] = True
    back = _reached(links, links[:, state])
    links[:, state] = False
    round_it = _reached(links, (B[:, 0] != 0) & ~onward)
    return not back[state] and not (round_it & ~onward & (C[0] != 0)).any()


def _reached(links: Array, start: Array) -> Array:
    """Return the states reachable from `start`, by links[to, from]."""
    reached = start.copy()
    while True:
        more = np.logical_or(reached, links[:, reached].any(axis=1))
        if (more == reached).all():
            return reached
        reached = np.asarray(more)
