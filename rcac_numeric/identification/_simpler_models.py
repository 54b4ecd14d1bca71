"""Models with fewer coefficients or poles, where the record does not show that they are there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.identification._box_jenkins import (
    ONE,
    NoiseModel,
    ProcessFit,
    Start,
    inverse_information,
    start_of,
)

NEAR = 0.3  # from a pole: a zero that may cancel it
OF_NOISE = ("C less D", "last of C", "last of D")  # of which one is left out at a time
QUICK = 0.5  # modulus of a pole that a coefficient of B may stand for
OVER = 0.05  # from 1: a root of C that all but cancels a difference


def simpler_starts(fit: ProcessFit, *, is_known: bool) -> Iterator[Start]:
    """The model without coefficients at the ends of B, of C and D that are within their deviation.

    Where their squares over the covariance are below log N each, BIC falls without them to first
    order (Wald). Then without one of its real poles. `is_known`: the delay.
    """
    trimmed = _trimmed(fit, is_known)
    if trimmed is not None:
        yield trimmed
    noise = fit.noise
    C = _without_root_near_1(noise.C) if noise.differences and not fit.armax else None
    if C is not None:
        yield replace(start_of(fit), noise=NoiseModel(C, noise.D, 0))
    if fit.order > 1:
        yield from _with_a_pole_less(start_of(fit))


@dataclass(frozen=True)
class _Part:
    """A combination of coefficients that may be 0, and its row in terms of all of them."""

    name: str
    value: float
    row: Array


def _trimmed(fit: ProcessFit, is_known: bool) -> Start | None:
    """Without the parts that may all be 0; None if there are none."""
    start, names = start_of(fit), _small_parts(fit, is_known)
    B, noise = fit.B, fit.noise
    C, D, delay = noise.C, noise.D, fit.delay
    if "last of B" in names:
        B = B[:-1]
    if "first of B" in names and len(B) > 1:
        B, delay = B[1:], delay + 1
    if "C less D" in names:
        C = D = ONE
    elif "last of C" in names:
        C = C[:-1]
    elif "last of D" in names:
        D = D[:-1]
    if not names or not B.any():
        return None
    return replace(start, B=B, delay=delay, noise=NoiseModel(C, D, noise.differences))


def _small_parts(fit: ProcessFit, is_known: bool) -> set[str]:
    """The names of the parts that may be 0 together, the smallest first."""
    covariance, parts = _covariance(fit), _parts(fit, is_known)
    limit = float(np.log(len(fit.e)))
    if not np.isfinite(covariance).all():
        return set()

    def wald(some: list[_Part]) -> float:
        rows, values = np.stack([one.row for one in some]), np.array([one.value for one in some])
        return float(values @ np.linalg.pinv(rows @ covariance @ rows.T, hermitian=True) @ values)

    chosen: list[_Part] = []
    for part in sorted(parts, key=lambda one: wald([one])):
        is_of_noise = part.name in OF_NOISE and any(one.name in OF_NOISE for one in chosen)
        if not is_of_noise and wald([*chosen, part]) < limit * (len(chosen) + 1):
            chosen.append(part)
    return {one.name for one in chosen}


def _parts(fit: ProcessFit, is_known: bool) -> Iterator[_Part]:
    """What may be left out alone."""
    noise, unit = fit.noise, np.eye(len(fit.jacobian))
    n, m, of_C = fit.order, len(fit.B), len(noise.C) - 1
    if m > 1:
        yield _Part("last of B", fit.B[-1], unit[n + m - 1])
    if m > 1 and not is_known:
        yield _Part("first of B", fit.B[0], unit[n])
    if fit.armax:  # C is that of the reflected A
        return
    at = n + m
    if len(noise.C) == len(noise.D) == 2:
        yield _Part("C less D", noise.C[1] - noise.D[1], unit[at] - unit[at + 1])
    if of_C:
        yield _Part("last of C", noise.C[-1], unit[at + of_C - 1])
    if len(noise.D) > 1:
        yield _Part("last of D", noise.D[-1], unit[at + of_C + len(noise.D) - 2])


def _covariance(fit: ProcessFit) -> Array:
    """That of A, B, C and D; of heavy tails too large, so that more is tried and BIC decides."""
    return inverse_information(fit.jacobian) * float(np.mean(fit.e**2))


def _with_a_pole_less(start: Start) -> Iterator[Start]:
    """Without a real pole and the zero beside it, or without a pole near 0."""
    poles, zeros = np.roots(start.A), np.roots(start.B)
    for i in np.flatnonzero(np.abs(poles.imag) < 1e-9):
        pole = float(poles[i].real)
        if start.armax and abs(pole) > 1:
            continue
        A = np.atleast_1d(np.real(np.poly(np.delete(poles, i))))
        distance = np.abs(zeros - pole)
        if distance.min(initial=np.inf) < NEAR:
            near = int(distance.argmin())
            others = np.delete(zeros, near)
            if zeros[near].imag:  # of a pair a real zero is left
                others[np.abs(others - zeros[near].conj()).argmin()] = zeros[near].real
            top = np.atleast_1d(np.real(np.poly(others)))
        elif abs(pole) < QUICK:
            top = start.B
        else:
            continue
        scale = (1 - pole) * float(top.sum())
        if scale:
            noise = _without_root_at(start.noise, pole) if start.armax else start.noise
            yield replace(start, A=A, B=top * float(start.B.sum()) / scale, noise=noise)


def _without_root_near_1(C: Array) -> Array | None:
    """C without a root that all but cancels the difference of the noise; None if there is none."""
    roots = np.roots(C)
    distance = np.where(np.abs(roots.imag) < 1e-9, np.abs(roots - 1), np.inf)
    if not distance.min(initial=np.inf) < OVER:
        return None
    return np.atleast_1d(np.real(np.poly(np.delete(roots, int(distance.argmin())))))


def _without_root_at(noise: NoiseModel, pole: float) -> NoiseModel:
    """Without the real root of C that is next to a pole, which stands below C in ARMAX."""
    roots = np.roots(noise.C)
    distance = np.where(np.abs(roots.imag) < 1e-9, np.abs(roots - pole), np.inf)
    if not np.isfinite(distance.min(initial=np.inf)):
        return noise
    C = np.atleast_1d(np.real(np.poly(np.delete(roots, int(distance.argmin())))))
    return NoiseModel(C, noise.D, noise.differences)
