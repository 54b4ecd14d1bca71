"""The first step from which a finished run is proved stable as a time-varying loop."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from flint import arb, arb_mat

from compensator_theory._few_lines import in_few_lines
from compensator_theory.errors import CompensatorError, InputError, NoSolutionError
from compensator_theory.matrices._definiteness import pivots_are_positive
from compensator_theory.polynomials._ball_precision import ball_precision
from rcac_numeric.analysis._certified_set import (
    CAP,
    MARGINS,
    CertifiedMember,
    CertifiedSet,
    dependent_directions,
    proved,
)
from rcac_numeric.analysis._ellipsoids import (
    WeightedPoints,
    geometric_mean,
    lower_factor,
    weighted_points,
)
from rcac_numeric.analysis._moving_gains import centered_loop, perturbed_loop
from rcac_numeric.analysis._regressor_system import (
    RegressorSystem,
    exact,
    rational_matrix,
    regressor_system,
)
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._showing import report_of, summary_of
from rcac_numeric.arrays._validation import instance_of
from rcac_numeric.arrays._values import Result
from rcac_numeric.controllers._bounds import ellipsoid_radii
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.engine._runs import Run
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import PlantSchedule, plant_at

BITS = 256  # of the balls that hold theta - center in coordinates of the ellipsoid
REACH = 1 - 6e-4  # square of the radius that the search gives to the farthest theta
ITERATIONS = 60  # most updates of the weights for one step
ROWS = 150  # thetas that a search begins with
ROUNDS = 4  # most times that centers are tried
WORST = 20  # thetas that join them at a time
ROUND = 1e-10  # of the mean, added to the second moment of the changes of theta


@dataclass(frozen=True, eq=False)
class CertifiedTail(Result):
    """The proof that a run is stable as a time-varying loop, from a step on.

    Every theta(k) from k0 on lies in one certified set. So the loop of the run from there on is
    uniformly exponentially stable while theta moves, and stays so if the run is continued as long
    as theta stays in the set.

    Attributes
    ----------
    start, stop : int
        The steps of the run in which the plant is the same: start <= k < stop.
    k0 : int or None
        First step of the proof; None where there is none.
    set : CertifiedSet or None
        Its center is the last theta, or a point between it and earlier ones.
    theta : array, shape (steps, l_theta)
        theta(k0), ..., with the one after the last step.
    reason : str
        Why there is no proof; empty where there is one.
    earlier : tuple of CertifiedTail
        The same for the plants before, where the plant changes.
    earliest : int or None
        First step from which on the loop of each theta, held constant, is stable in float64, with
        the controller on and no limit of u: no set proves an earlier step.
    """

    _REST: ClassVar[str] = "report() has all of it"

    start: int
    stop: int
    k0: int | None
    set: CertifiedSet | None
    theta: Array
    reason: str = ""
    earlier: tuple[CertifiedTail, ...] = ()
    earliest: int | None = None

    @property
    def is_verified(self) -> bool:
        """Whether there is a proof, and it holds: the set, and theta(k) inside it, both exact."""
        return (
            self.set is not None
            and self.k0 is not None
            and _is_inside(self.set, self.theta)
            and self.set.is_verified
        )

    @property
    def is_moving(self) -> bool:
        """Whether theta still moves at k0 or later."""
        return bool(len(self.theta) and (self.theta != self.theta[-1]).any())

    def _sheet(self) -> Any:
        from rcac_numeric.reports._certified import tail_sheet

        return tail_sheet(self)

    def report(self) -> str:
        """Return the report: from which step on the loop is proved stable, or why not."""
        return report_of(self._sheet())

    @in_few_lines
    def __str__(self) -> str:
        return summary_of(self._sheet())

    def __repr__(self) -> str:
        return f"CertifiedTail(k0={self.k0}, steps {self.start} to {self.stop - 1})"


def certified_from(run: Run) -> CertifiedTail:
    """Find the first step from which on a run is proved stable while theta moves.

    The ellipsoid is centered at the last theta, or between it and earlier ones, and shaped by the
    thetas that lead to it: M solves min over M of max over k of Delta(k)' M^-1 Delta(k) with
    T* M T < 1, for the earliest k0 for which the minimum is below 1.

    Parameters
    ----------
    run : Run
        Of one adaptive controller on a linear plant, with theta stored at every step. Where the
        plant changes, each plant has a proof of its own; none while it drifts.

    Returns
    -------
    CertifiedTail

    Raises
    ------
    InputError
        Where the plant is nonlinear, the controller is not one `ControllerSettings`, or theta was
        stored with a stride.

    Notes
    -----
    The search is in float64, by multipliers of frequencies and of steps with a lower bound that
    ends it; what it finds is proved as in `certified_set`, and each theta(k) is shown to lie
    inside in balls. Steps between `earliest` and k0 are not excluded by that: other centers, and
    other functions than quadratic ones of one P, may do better.

    Of 36 examples of the text 31 are proved, from a median of 45 steps after control begins (0 to
    1662). A theta that is unstable when held lies in no set, which excludes the first 30 of them in
    the median; 16 proofs begin at most 2 steps later. In a trial on ten loops a semidefinite
    program began at 9.5 steps where an ellipsoid without one began at 12 (medians); there is no
    such solver here.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, Step, certified_from, exogenous, fir_target, iir, simulate,
    ...     standard_plant)
    >>> plant = standard_plant("1/(q - 0.9)")
    >>> settings = ControllerSettings(structure=iir(2), target=fir_target(plant), update=UD(1e-2))
    >>> tail = certified_from(simulate(plant, settings, exogenous([Step()], steps=200)))
    >>> tail.is_verified, tail.k0 < 20
    (True, True)
    """
    return tail_of_run(run, ROUNDS)


def tail_of_run(run: Run, rounds: int = 0) -> CertifiedTail:
    """As `certified_from`, with fewer rounds of centers beside the last theta, for reports."""
    instance_of(run, "run", Run)
    settings = instance_of(run.settings, "the controller of the run", ControllerSettings)
    if run.stride != 1:
        raise InputError(
            f"theta was stored every {run.stride} steps, and a proof needs every theta(k); "
            "simulate with stride=1."
        )
    if not run.steps:
        raise InputError("the run has no completed step.")
    tails: list[CertifiedTail] = []
    for start, stop, plant in _segments(run):
        tails.append(_tail(run, settings, start, stop, plant, rounds))
    last = tails[-1]
    return replace(last, earlier=tuple(tails[:-1]))


def _segments(run: Run) -> Iterator[tuple[int, int, Plant | None]]:
    """Yield first and last steps, and the plant between them; None while it drifts."""
    end = run.first_step + run.steps
    if not isinstance(run.plant, PlantSchedule):
        yield run.first_step, end, plant_at(run.plant, 0)
        return
    changes = run.plant.changes
    ends = [*(change.start for change in changes[1:]), end]
    for change, following in zip(changes, ends, strict=True):
        start, stop = max(change.start, run.first_step), min(following, end)
        if start < stop:
            yield start, stop, None if change.ramp else plant_at(run.plant, change.start)


def _tail(
    run: Run, settings: ControllerSettings, start: int, stop: int, plant: Plant | None, rounds: int
) -> CertifiedTail:
    def none(reason: str) -> CertifiedTail:
        return _no_tail(start, stop, run.theta.shape[1], reason)

    if plant is None:
        return none("the plant drifts, and a proof is for a plant that stays where it is")
    first = max(start, settings.k_w, _last_limited(run, stop) + 1)
    if first >= stop:
        return none(f"no step before {stop} is one of the controller without a limit of u")
    row = first - run.first_step
    after = run.theta[stop - run.first_step - 1 :][:1]
    if stop == run.first_step + run.steps:
        after = run.theta_final[None]
    thetas = np.vstack([run.theta[row : stop - run.first_step], after])
    steps = (start, first, stop)
    return _tail_of(plant, settings.structure, settings.fixed, thetas, steps, rounds)


def certified_from_log(
    plant: Plant, structure: Structure, theta: Array, first: int
) -> CertifiedTail:
    """As `tail_of_run`, of theta(first), ... of a log and a plant that stays."""
    return _tail_of(plant, structure, None, theta, (0, first, first + len(theta)), 0)


def _no_tail(start: int, stop: int, l_theta: int, reason: str) -> CertifiedTail:
    return CertifiedTail(start, stop, None, None, np.zeros((0, l_theta)), reason)


def _tail_of(
    plant: Plant, structure: Structure, fixed: Compensator | None, thetas: Array,
    steps: tuple[int, int, int], rounds: int,
) -> CertifiedTail:  # fmt: skip
    """Return the tail of theta(first), ..., for the steps (start, first, stop)."""
    start, first, stop = steps
    try:
        region, index, possible = _largest_tail(plant, structure, fixed, thetas, rounds)
    except CompensatorError as error:
        return _no_tail(start, stop, thetas.shape[1], str(error).rstrip("."))
    return CertifiedTail(
        start, stop, first + index, region, np.array(thetas[index:]), earliest=first + possible
    )


def _last_limited(run: Run, stop: int) -> int:
    """Return the last step before `stop` at which a limit moved u; one before the first if none."""
    moved = (run.u_applied != run.u).any(axis=1)[: stop - run.first_step]
    return run.first_step + (int(np.flatnonzero(moved)[-1]) if moved.any() else -1)


def _largest_tail(
    plant: Plant, structure: Structure, fixed: Compensator | None, thetas: Array, rounds: int
) -> tuple[CertifiedSet, int, int]:
    """Return a proved set, the first row from which on all are inside, and the first possible."""
    last = np.array(thetas[-1])
    system = regressor_system(plant, structure, fixed)
    radius = centered_loop(system, last).spectral_radius
    if not radius < 1:
        raise NoSolutionError(
            f"the loop of the last theta has a pole at {radius:.6g}, outside the unit circle."
        )
    search = _CenterSearch(system, structure, thetas)
    center, K, first = search.earliest(rounds)
    scale = search.scale
    K, storages = proved([perturbed_loop(system, center)], K, scale, 1.0, [np.zeros(0)])
    outside = np.flatnonzero(_squares(K, _changes(thetas, center, scale))[0] >= 1 - 1e-9)
    index = int(outside[-1]) + 1 if outside.size else 0
    responses = centered_loop(system, center).responses(1.0)
    region = CertifiedSet(
        structure=structure, fixed=fixed, center=center, regressor_factor=K,
        input_scale=scale, rate=1.0, shape="tail",
        members=(CertifiedMember("the plant of the run", plant, storages[0]),),
        uncovered=UNCOVERED, dependent=dependent_directions(responses),
    )  # fmt: skip
    return region, index, first


class _CenterSearch:
    """Centers of an ellipsoid that holds the thetas of a run from as early a step as possible."""

    def __init__(self, system: RegressorSystem, structure: Structure, thetas: Array) -> None:
        self.system, self.thetas = system, thetas
        self.scale = _scale_of_rows(thetas, structure)
        self.caps = _caps_of_run(thetas, structure, self.scale)

    def earliest(self, rounds: int = ROUNDS) -> tuple[Array, Array, int]:
        """Return center, K and the first row that any set may hold.

        The last theta is the first center. Then come points between it and where the set begins,
        as long as a round of them finds an earlier step.
        """
        last = self.thetas[-1]
        K, best = self._around(last, 0, None) or self._none()
        center, first = last, self._first_stable(best)
        for _ in range(rounds):
            before = best
            for candidate in self._candidates(first, best):
                better = self._around(candidate, first, best) if best > first else None
                if better is not None:
                    center, (K, best) = candidate, better
            if best == before:
                break
        return np.array(center), K, first

    def _none(self) -> tuple[Array, int]:
        raise NoSolutionError("no ellipsoid around the last theta was found.")

    def _candidates(self, first: int, best: int) -> list[Array]:
        """Return centers for a set that is to begin between two rows."""
        thetas, last = self.thetas, self.thetas[-1]
        return [
            0.75 * last + 0.25 * thetas[first],
            0.5 * last + 0.5 * thetas[first],
            0.5 * last + 0.5 * thetas[best - 1],
            thetas[best],
            thetas[first:].mean(axis=0),
            thetas[best - 1 :].mean(axis=0),
        ]

    def _around(self, center: Array, low: int, high: int | None) -> tuple[Array, int] | None:
        """Return K and its first row, earlier than `high`; None where there seems to be none."""
        loop = centered_loop(self.system, center)
        if not loop.spectral_radius < 1:
            return None
        responses = loop.responses(1.0) * self.scale
        points = weighted_points(np.concatenate(list(responses.transpose(2, 0, 1))), self.caps)
        changes = _changes(self.thetas, center, self.scale)
        K = _Search(points, changes).earliest(low, high)
        if K is None:
            return None
        K = K / max(loop.peak(K, self.scale, 1.0), 1.0) * (1 - MARGINS[0])
        outside = np.flatnonzero(_squares(K, changes)[0] >= 1 - 1e-9)
        row = int(outside[-1]) + 1 if outside.size else 0
        return None if high is not None and row >= high else (K, row)

    def _first_stable(self, row: int) -> int:
        """Return the first row from which on every theta, held constant, is stable."""
        while row and self._is_stable(self.thetas[row - 1]):
            row -= 1
        return row

    def _is_stable(self, theta: Array) -> bool:
        Theta = theta.reshape(-1, self.system.inputs.shape[1]).T
        A = self.system.rounded + self.system.inputs @ Theta @ self.system.outputs
        return bool(np.abs(np.linalg.eigvals(A)).max(initial=0.0) < 1)


UNCOVERED = (
    "other plants than that of the run",
    "the run before this step, and its continuation where theta leaves the set",
    "limits of u, if the continuation reaches them",
)


def _changes(thetas: Array, center: Array, scale: Array) -> Array:
    """Return R^1/2 Delta(k), shape (steps, l_phi, l_u)."""
    return np.asarray((thetas - center).reshape(len(thetas), -1, len(scale)) / scale)


def _scale_of_rows(thetas: Array, structure: Structure) -> Array:
    """Return the relative size of the motion of each row of Theta, powers of two."""
    motion = (thetas - thetas[-1]).reshape(len(thetas), -1, structure.l_u)
    sizes = np.sqrt((motion**2).mean(axis=(0, 1)))
    if structure.l_u == 1 or not sizes.all():
        return np.ones(structure.l_u)
    return np.asarray(np.exp2(np.round(np.log2(sizes / sizes.max()))), dtype=np.float64)


def _caps_of_run(thetas: Array, structure: Structure, scale: Array) -> Array:
    """Return the largest sqrt(M_ii), by the size of each coefficient in the run."""
    sizes = (np.abs(thetas).max(axis=0).reshape(-1, structure.l_u) / scale).max(axis=1)
    return np.asarray(CAP * np.maximum(sizes, 1e-6 * sizes.max(initial=0.0) + 1e-12))


def _squares(K: Array, changes: Array) -> tuple[Array, Array]:
    """Return abs(R^1/2 Delta K^-T)^2 of each step, and Delta' w for its left singular vector w."""
    steps, taps, inputs = changes.shape
    V = np.linalg.solve(K, changes.transpose(1, 0, 2).reshape(taps, -1))
    V = V.reshape(taps, steps, inputs).transpose(1, 2, 0)
    if inputs == 1:
        return np.asarray((V[:, 0] ** 2).sum(axis=1)), np.asarray(changes[:, :, 0])
    values, vectors = np.linalg.eigh(V @ V.transpose(0, 2, 1))
    return np.asarray(values[:, -1]), np.asarray(
        np.einsum("kta,ka->kt", changes, vectors[:, :, -1])
    )


class _Search:
    """The earliest step from which on the changes of theta fit into an ellipsoid."""

    def __init__(self, points: WeightedPoints, changes: Array) -> None:
        self.points = points
        # in whitened coordinates, where M = basis N basis'
        self.changes = np.einsum("ij,kja->kia", points.inverse, changes)
        self.steps = len(changes)

    def earliest(self, low: int = 0, before: int | None = None) -> Array | None:
        """Return K for the earliest step from `low` on, by bisection; a success may skip many.

        None where a step earlier than `before` is wanted, and there seems to be none.
        """
        high, trial, best = self.steps - 1, low, None
        if before is None:
            best = self._scaled(geometric_mean(self.points.moment, np.eye(len(self.points.basis))))
        else:
            best = self._fitting(before - 1)
            if best is None:
                return None
            high = self._begins(best, before - 1)
        while low < high:
            N = self._fitting(trial)
            if N is None:
                low = trial + 1
            else:
                best, high = N, self._begins(N, trial)
            trial = (low + high) // 2
        return lower_factor(self.points.basis @ np.linalg.cholesky(best))

    def _begins(self, N: Array, trial: int) -> int:
        """Return the row from which on every change fits, at most `trial`."""
        outside = np.flatnonzero(self._sizes(N)[0] >= REACH)
        return min(trial, int(outside[-1]) + 1 if outside.size else 0)

    def _scaled(self, N: Array) -> Array:
        return np.asarray(N / self.points.sizes(N).max())

    def _sizes(self, N: Array, rows: Any = slice(None)) -> tuple[Array, Array]:
        return _squares(np.asarray(np.linalg.cholesky(N), np.float64), self.changes[rows])

    def _fitting(self, first: int) -> Array | None:
        """Return N that holds every change from a step on; None where there seems to be none.

        The mean of the sizes of the points times the mean square radius of the changes, both by
        their weights, is a lower bound of the product of the largest of both (duality).
        """
        rows = np.unique(np.linspace(first, self.steps - 1, ROWS).astype(int))
        weights = np.full(len(rows), 1 / len(rows))
        points, taps = self.points, len(self.points.basis)
        directions = self._sizes(np.eye(taps), rows)[1]
        for step in range(ITERATIONS):
            moment = (directions * weights[:, None]).T @ directions
            moment += ROUND * max(float(np.trace(moment)), 1e-280) / taps * np.eye(taps)
            N = geometric_mean(points.moment, moment)
            sizes = points.sizes(N)
            squares, directions = self._sizes(N, rows)
            mean = points.reweighted(sizes)
            average = float(weights @ squares)
            if mean * average > 1:
                return None
            if sizes.max() * squares.max() < REACH:
                N = self._scaled(N)
                every, all_directions = self._sizes(N, slice(first, None))
                if every.max() < REACH:
                    return N
                worst = first + np.argsort(-every)[:WORST]
                new = np.setdiff1d(worst, rows)
                rows = np.concatenate([rows, new])
                weights = np.concatenate([weights, np.full(len(new), weights.max() / 4)])
                weights /= weights.sum()
                directions = np.concatenate([directions, all_directions[new - first]])
                continue
            weights = weights * squares
            weights /= weights.sum()
            if step % 10 == 9:
                points = points.thinned(sizes)
        return None


def _is_inside(region: CertifiedSet, thetas: Array) -> bool:
    """Whether every theta lies inside: by its computed radius and its rounding error, or in balls.

    A computed radius below the limit of `ellipsoid_radii` proves that the true one is below 1
    (Higham 2002, theorem 8.5). The others are few: R^1/2 Delta K^-T has a norm below 1 in balls.
    """
    scale, taps = region.input_scale, len(region.regressor_factor)
    distinct = np.unique(thetas, axis=0)
    with contextlib.suppress(InputError):  # axes that are too unequal for that bound
        distinct = distinct[~(region.radius_of(distinct) < ellipsoid_radii(region.bounds)[0])]
    if not len(distinct):
        return True
    moved = exact(distinct) - exact(region.center)
    moved = moved.reshape(len(distinct), taps, len(scale)) / exact(scale)
    columns = moved.transpose(1, 0, 2).reshape(taps, -1)
    with ball_precision(BITS):
        K = arb_mat(rational_matrix(exact(region.regressor_factor)))
        try:
            V = K.solve(arb_mat(rational_matrix(columns))).transpose().tolist()
        except ZeroDivisionError:
            return False
        m = len(scale)
        return all(_is_contraction(V[k : k + m]) for k in range(0, len(V), m))


def _is_contraction(rows: list[list[arb]]) -> bool:
    """Whether I - VV' is positive definite, by pivots in balls."""
    m = len(rows)
    left = [
        [arb(int(i == j)) - sum((a * b for a, b in zip(rows[i], rows[j], strict=True)), arb(0))
         for j in range(m)] for i in range(m)
    ]  # fmt: skip
    return pivots_are_positive(left) is True
