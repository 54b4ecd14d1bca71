"""Linear plants that change during a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any

import attrs
import numpy as np

import compensator_theory as exact
from compensator_theory.errors import InputError
from compensator_theory.systems._sample_times import agreed_period
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import (
    instance_of,
    integer,
    items,
    matrix,
    optional_array_like,
    reads,
    real_array,
    with_checks,
)
from rcac_numeric.arrays._values import Value
from rcac_numeric.plants._any_plant import AnyPlant, block_start
from rcac_numeric.plants._linear import MATRICES, Plant
from rcac_numeric.plants._problems import from_problem


@attrs.frozen(eq=False, slots=False, kw_only=True, field_transformer=with_checks)
class PlantChange(Value):
    """The plant from step `start` on.

    Parameters
    ----------
    start : int
    plant : Plant
    ramp : bool
        The matrices move linearly from `start` on and reach those of the next change at its
        start.
    state_map : array, shape (n, n before), optional
        x <- state_map x at `start`; the state stays as it is where it is left out, which needs
        equal orders.
    delay : int
        u acts this many steps late; what was sent before the change is kept.

    Examples
    --------
    >>> from rcac_numeric import PlantChange, standard_plant
    >>> PlantChange(start=100, plant=standard_plant("3/(q - 0.5)")).ramp
    False
    """

    start: int = attrs.field(metadata=reads(integer))
    plant: Plant
    ramp: bool = attrs.field(default=False, metadata=reads(instance_of, kind=bool))
    state_map: Array | None = attrs.field(
        default=None, converter=optional_array_like, metadata=reads(real_array, optional=True)
    )
    delay: int = attrs.field(default=0, metadata=reads(integer, at_most=100_000))

    def __attrs_post_init__(self) -> None:
        instance_of(self.plant, "the plant of a change", Plant)


@dataclass(frozen=True, eq=False)
class PlantSchedule(Value):
    """A linear plant that switches, drifts, or receives its input later.

    A change of gain is a change of B (or of C and E_1); a moved zero is a change of C and E_1
    with the state kept. The first change begins at step 0.

    Parameters
    ----------
    changes : sequence of PlantChange
        By increasing step.

    Raises
    ------
    InputError
        Where steps are not increasing, sizes do not fit, or a ramp has no end.

    Examples
    --------
    >>> from rcac_numeric import PlantChange, PlantSchedule, standard_plant
    >>> before, after = standard_plant("1/(q - 0.5)"), standard_plant("3/(q - 0.5)")
    >>> PlantSchedule(
    ...     [PlantChange(start=0, plant=before), PlantChange(start=100, plant=after, delay=2)])
    PlantSchedule(n=1, l_u=1, l_w=1, l_y=1, l_z=1, changes at 0, 100)
    """

    changes: Sequence[PlantChange]

    def __post_init__(self) -> None:
        changes = items(self.changes, "changes", PlantChange)
        if not changes:
            raise InputError("a plant schedule needs a list of PlantChange(start=..., plant=...).")
        object.__setattr__(self, "changes", changes)
        if changes[0].start != 0 or changes[0].state_map is not None:
            raise InputError("the first change must begin at step 0, without a state map.")
        if changes[-1].ramp:
            raise InputError("the last change cannot ramp: no plant follows it.")
        sizes = _sizes(changes[0].plant)
        advice = "all plants of a schedule need the same sample time: resample one."
        agreed_period(*(c.plant.sample_time for c in changes), at="a plant", remedy=advice)
        for before, now in pairwise(changes):
            if now.start <= before.start:
                raise InputError(
                    f"the change at {now.start} does not follow that at {before.start}."
                )
            if _sizes(now.plant)[1:] != sizes[1:] or now.plant.blocks != changes[0].plant.blocks:
                raise InputError(f"the plant at {now.start} has other inputs or outputs.")
            n_before, n = before.plant.n, now.plant.n
            if now.state_map is not None:
                matrix(now.state_map, "state_map", (n, n_before))
            elif n != n_before:
                raise InputError(
                    f"the plant at {now.start} has {n} states after {n_before}; give state_map, "
                    f"the matrix from the old state to the new one."
                )
            if before.ramp and n != n_before:
                raise InputError(f"the ramp from {before.start} joins plants of different order.")

    @property
    def sample_time(self) -> float | None:
        """Sample time of the plants, in seconds; None if no plant has one."""
        period: float | None = agreed_period(*(change.plant.sample_time for change in self.changes))
        return period

    @property
    def first(self) -> Plant:
        """The plant at step 0."""
        return self.changes[0].plant

    def at(self, k: int) -> PlantChange:
        """Return the change in force at step k; during a ramp, the plant at its start."""
        return [change for change in self.changes if change.start <= k][-1]

    @property
    def n(self) -> int:
        """Number of states at step 0."""
        return self.first.n

    @property
    def l_u(self) -> int:
        """Number of control inputs."""
        return self.first.l_u

    @property
    def l_w(self) -> int:
        """Number of exogenous inputs."""
        return self.first.l_w

    @property
    def l_y(self) -> int:
        """Number of measurements."""
        return self.first.l_y

    @property
    def l_z(self) -> int:
        """Number of performance variables."""
        return self.first.l_z

    @property
    def blocks(self) -> Mapping[str, int]:
        """The blocks of w."""
        return self.first.blocks

    @property
    def y_needs_u(self) -> bool:
        """Whether y(k) depends on u(k) at some step."""
        return any(change.plant.y_needs_u for change in self.changes)

    @property
    def z_needs_u(self) -> bool:
        """Whether z(k) depends on u(k) at some step."""
        return any(change.plant.z_needs_u for change in self.changes)

    def __repr__(self) -> str:
        sizes = repr(self.first)[len("Plant(") : -1]
        starts = ", ".join(str(change.start) for change in self.changes)
        return f"PlantSchedule({sizes}, changes at {starts})"


def _sizes(plant: Plant) -> tuple[int, int, int, int, int]:
    return plant.n, plant.l_u, plant.l_w, plant.l_y, plant.l_z


def plant_at(plant: AnyPlant, k: int) -> Plant:
    """Return the plant at step k, with an input delay as states."""
    if isinstance(plant, Plant):
        return plant
    if not isinstance(plant, PlantSchedule):
        raise InputError(
            f"{plant!r} is not linear, so the loop at a step has no transfer function."
        )
    change = plant.at(k)
    return _delayed(_moved(plant, change, k), change.delay)


def measuring_command(plant: Plant) -> Plant:
    """Return the plant with measurement [y; r], for a controller that reads the command."""
    l_r = plant.blocks.get("r", 0)
    start = block_start(plant, "r") if l_r else 0
    reads = np.zeros((l_r, plant.l_w))
    reads[:, start : start + l_r] = np.eye(l_r)
    return Plant(
        **{
            **{name: getattr(plant, name) for name in MATRICES},
            "C": np.vstack([plant.C, np.zeros((l_r, plant.n))]),
            "D_0": np.vstack([plant.D_0, np.zeros((l_r, plant.l_u))]),
            "D_2": np.vstack([plant.D_2, reads]),
        },
        blocks=plant.blocks,
    )


def _moved(plant: PlantSchedule, change: PlantChange, k: int) -> Plant:
    """Return the interpolated plant at step k of a ramp."""
    if not change.ramp or k == change.start:
        return change.plant
    end = next(b for a, b in pairwise(plant.changes) if a is change)
    share = (k - change.start) / (end.start - change.start)
    matrices: dict[str, Any] = {
        name: (1 - share) * getattr(change.plant, name) + share * getattr(end.plant, name)
        for name in MATRICES
    }
    return Plant(**matrices, blocks=plant.first.blocks)


@lru_cache(maxsize=32)  # cached: exact, and evaluated at every stored theta of a run
def _delayed(plant: Plant, delay: int) -> Plant:
    """Return the plant with the state [x; u(k-1); ...; u(k-delay)]."""
    if delay == 0:
        return plant
    from sympy import ImmutableMatrix, eye, zeros

    p = plant.problem
    n, l_u, chain = plant.n, plant.l_u, delay * plant.l_u
    last = zeros(l_u, chain)
    last[:, chain - l_u :] = eye(l_u)
    shift = zeros(chain, chain)
    shift[l_u:, : chain - l_u] = eye(chain - l_u)
    first = zeros(chain, l_u)
    first[:l_u, :] = eye(l_u)
    A = ImmutableMatrix.vstack(
        ImmutableMatrix.hstack(p.A, p.B * last),
        ImmutableMatrix.hstack(zeros(chain, n), ImmutableMatrix(shift)),
    )
    problem = exact.StandardProblem(
        A=A,
        B=ImmutableMatrix.vstack(zeros(n, l_u), ImmutableMatrix(first)),
        D_1=ImmutableMatrix.vstack(p.D_1, zeros(chain, plant.l_w)),
        C=ImmutableMatrix.hstack(p.C, p.D_0 * last),
        D_0=None,
        D_2=p.D_2,
        E_1=ImmutableMatrix.hstack(p.E_1, p.E_2 * last),
        E_2=None,
        E_0=p.E_0,
        sample_time=p.sample_time,
    )
    return from_problem(problem, plant.blocks)
