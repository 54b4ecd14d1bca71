"""Poles and zeros that all but cancel: hidden modes of every loop, and parts of a disturbance."""

from __future__ import annotations

import numpy as np

from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.identification._box_jenkins import ProcessFit

CANCELLED, BESIDE = 0.1, 0.95  # distance of a zero from a pole of a larger modulus
ALIKE = 2e-3  # distance at which a pair all but cancels at 0.02 rad/step and above
# Frequencies that a record resolves are 2 pi over its steps apart: a pole half of that from the
# circle, and a zero within it, are a part of the disturbance as far as the record can tell.
RESOLVED = 2 * float(np.pi)


def has_hidden_pair(fit: ProcessFit) -> bool:
    """Whether a pole near the circle and a zero all but cancel: a hidden mode of every loop."""
    return hides_a_pair(fit.poles, roots_of(fit.B), len(fit.e))


def hides_a_pair(poles: ComplexArray, zeros: ComplexArray, steps: int) -> bool:
    """Whether a pole near the circle and a zero all but cancel, as far as a record can tell."""
    resolved = RESOLVED / steps
    alike = cancelling_pairs(poles, zeros, ALIKE)
    return bool(alike or cancelling_pairs(poles, zeros, resolved, 1 - resolved / 2))


def has_unstable_part(fit: ProcessFit) -> bool:
    """Whether a pole is outside the circle, and no zero all but cancels it."""
    zeros = np.roots(fit.B)
    for pole in fit.poles[np.abs(fit.poles) > 1.001]:
        nearest = np.abs(zeros - pole).min(initial=np.inf)
        if nearest > max(ALIKE, 0.1 * (abs(pole) - 1)):
            return True
    return False


def cancelling_pairs(
    poles: ComplexArray, zeros: ComplexArray, distance: float = CANCELLED, beside: float = BESIDE
) -> list[tuple[list[int], list[int]]]:
    """Indices of poles near the circle, real or a pair, and of the zeros beside them."""
    pairs = []
    for i, pole in enumerate(poles):
        if abs(pole) < beside or pole.imag < -1e-9 or not len(zeros):
            continue
        near = np.argsort(np.abs(zeros - pole))
        if abs(zeros[near[0]] - pole) > distance:
            continue
        if pole.imag <= 1e-9:
            if abs(zeros[near[0]].imag) < 1e-9:
                pairs.append(([i], [int(near[0])]))
            continue
        partner = int(np.argmin(np.abs(poles - pole.conj())))
        if len(zeros) > 1 and abs(zeros[near[0]].imag) > 1e-9:
            other = int(np.argmin(np.abs(zeros - zeros[near[0]].conj())))
            pairs.append(([i, partner], [int(near[0]), other]))
    return pairs


def roots_of(A: Array) -> ComplexArray:
    """The roots, complex where all are real, too."""
    return np.asarray(np.roots(A), dtype=np.complex128)
