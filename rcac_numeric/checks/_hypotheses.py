"""Decide the plant convention, sign and delay of a log by prediction errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.checks._logs import ControllerLog
from rcac_numeric.checks._plant_residual import (
    AR,
    LONGEST,
    MOST_NUMBERS,
    inputs,
    one_step_errors,
    whitened,
)
from rcac_numeric.plants._linear import Plant

DELAYS = (0, 1, 2, 3, -1)  # steps that u may act later than the plant says, or earlier
BLOCKS, DECISIVE = 20, 4.0  # of the paired comparison; its Student's t
CLEARLY = 3.0  # rms over rms that decides by itself
FEWEST = 60  # steps
EQUATIONS = {
    "standard": "y = z = G(u + w)",
    "servo": "y = z = r - G(u + d) - v",
    "negated": "y = -z = -G(u + w)",
}


@dataclass(frozen=True)
class Hypothesis:
    """A plant convention that the log may have.

    Attributes
    ----------
    problem : str
        The name of the plant, "standard" or "servo" for instance.
    delay : int
        Steps that u acts later than that plant says.
    rms : float
        Of its one-step error of y, less a constant and what its own past predicts.
    """

    problem: str
    delay: int
    rms: float

    def __str__(self) -> str:
        return f"{self.convention} (whitened prediction error {self.rms:.3g})"

    @property
    def convention(self) -> str:
        """The equation of the problem, with the delay of u."""
        equation = EQUATIONS.get(self.problem)
        words = self.problem if equation is None else f"{self.problem}, {equation}"
        return words + (f", {self.late}" if self.delay else "")

    @property
    def late(self) -> str:
        """The delay of u in words."""
        steps = f"{abs(self.delay)} step{'s' * (abs(self.delay) > 1)}"
        return f"u {steps} {'later' if self.delay > 0 else 'earlier'}"


@dataclass(frozen=True)
class Decision:
    """The plant convention of a log, by one-step prediction errors.

    Attributes
    ----------
    hypotheses : tuple of Hypothesis
        The best first.
    decided : Hypothesis or None
        The one that predicts better than those of every other problem; None where two problems
        explain the log as well as each other.
    stays : float
        Rms of y(k) - y(k-1): the error of "y stays".
    """

    hypotheses: tuple[Hypothesis, ...]
    decided: Hypothesis | None
    stays: float

    @property
    def is_undecided(self) -> bool:
        """Whether two problems explain the log as well as each other."""
        return self.decided is None

    @property
    def is_contradicted(self) -> bool:
        """Whether y(k) = y(k-1) predicts better than every problem."""
        return bool(self.hypotheses[0].rms > self.stays)

    def __str__(self) -> str:
        if self.decided is None:
            best = "; ".join(map(str, self.hypotheses[:3]))
            return f"UNDECIDED plant convention: the log fits more than one problem: {best}."
        decided = self.decided
        other = next((one for one in self.hypotheses if one is not decided), None)
        best = ""
        if other is not None:
            names = [other.problem] * (other.problem != decided.problem)
            names += [other.late] * (other.delay != 0)
            change = " and ".join(names) or "u as the plant says"
            best = f"; next best {other.rms:.3g} with {change}"
        worse = ""
        if self.is_contradicted:
            worse = f" The prediction y(k) = y(k-1) is better, with error {self.stays:.3g}."
        return (
            f"Plant convention, from the log: {decided.convention} (rms of the prediction "
            f"error of y, whitened by an AR({AR}) model: {decided.rms:.3g}{best}).{worse}"
        )


def decide_problem(log: ControllerLog, plants: Mapping[str, Plant]) -> Decision:
    """Compare problems on a log by their one-step errors.

    The error of y, from the n steps before, is taken for every problem and for u up to three steps
    later and one earlier; a constant, and what an AR(8) of its own past predicts, are no evidence,
    since a disturbance may be like that. Two problems differ where the better leaves a third of the
    other's error, or where over 20 blocks the mean logarithm of the ratio of their mean squares is
    4 standard errors from zero.
    """
    if len(plants) < 2:
        raise InputError("there is one plant, so nothing to compare; give two or more.")
    errors: dict[tuple[str, int], Array] = {}
    for name, plant in plants.items():
        for delay in DELAYS:
            residual = _errors(log, plant, delay)
            if residual is not None:
                errors[name, delay] = residual
    if not errors:
        raise InputError(
            f"{log.source}: {log.steps} steps are too few to compare problems by prediction, or "
            "its signals are constant; name the problem."
        )
    steps = min(map(len, errors.values()))
    errors = {key: e[-steps:] for key, e in errors.items()}
    stays = float(np.sqrt(np.mean(np.diff(log.y[-steps:], axis=0) ** 2)))
    floor = 1e-12 * float(np.abs(log.y).max(initial=0.0))
    rms = {key: float(np.sqrt(np.mean(e**2))) for key, e in errors.items()}
    rms = {key: 0.0 if value <= floor else value for key, value in rms.items()}
    order = sorted(rms, key=lambda key: (rms[key], abs(key[1])))
    hypotheses = tuple(Hypothesis(*key, rms[key]) for key in order)
    best = order[0]
    others = [key for key in order if key[0] != best[0]]
    decided = all(_differ(errors[best], errors[key], floor) for key in others)
    # Of the same problem the delay that was given stands where no other is clearly better.
    decided_problem = (best[0], 0)
    if decided_problem in rms and not _differ(errors[best], errors[decided_problem], floor):
        best = decided_problem
    best_hypothesis = next(one for one in hypotheses if (one.problem, one.delay) == best)
    return Decision(hypotheses, best_hypothesis if decided else None, stays)


def _errors(log: ControllerLog, plant: Plant, delay: int) -> Array | None:
    """One-step errors minus a constant and the prediction from past errors."""
    if (plant.l_u, plant.l_y) != (log.u.shape[1], log.y.shape[1]):
        raise InputError(
            f"{log.source}: the log has l_u = {log.u.shape[1]}, l_y = {log.y.shape[1]}, the plant "
            f"{plant.l_u} and {plant.l_y}."
        )
    B, D, known = inputs(log, plant)
    n = max(plant.n, 1)
    steps = min(log.steps, LONGEST, MOST_NUMBERS // ((n + 1) * (plant.l_y + B.shape[1])))
    if steps < n + FEWEST:
        return None
    u, y, known = log.u[:steps], log.y[:steps], known[:steps]
    if delay > 0:
        u = np.vstack([np.zeros((delay, u.shape[1])), u[:-delay]])
    elif delay < 0:
        u = np.vstack([u[-delay:], np.repeat(u[-1:], -delay, axis=0)])
    with np.errstate(all="ignore"):
        e = one_step_errors(plant, B, D, np.hstack([u, known]), y)
    if len(e) < FEWEST or not np.isfinite(e).all() or not np.diff(y, axis=0).any():
        return None
    return whitened(e)


def _differ(better: Array, worse: Array, floor: float) -> bool:
    """Whether the first error is significantly smaller."""
    a, b = np.sum(better**2, axis=1), np.sum(worse**2, axis=1)
    if np.sqrt(b.mean()) <= 10 * floor:
        return False  # both are rounding
    if np.sqrt(b.mean()) > CLEARLY * np.sqrt(a.mean()):
        return True
    # Logarithms, since the start of a log may outweigh all that follows.
    blocks = zip(np.array_split(a, BLOCKS), np.array_split(b, BLOCKS), strict=True)
    ratios = np.array([np.log((d.mean() + floor**2) / (c.mean() + floor**2)) for c, d in blocks])
    spread = ratios.std(ddof=1) / np.sqrt(BLOCKS)
    return bool(b.mean() > a.mean() and ratios.mean() > DECISIVE * spread)
