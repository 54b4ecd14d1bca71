"""What a plant that changes is at one step: a fixed linear plant."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

import compensator_theory as exact
from compensator_theory.errors import InputError
from rcac_numeric.plants.any_plant import AnyPlant, block_start
from rcac_numeric.plants.linear import MATRICES, Plant
from rcac_numeric.plants.problems import from_problem
from rcac_numeric.plants.schedules import PlantChange, PlantSchedule


def plant_at(plant: AnyPlant, k: int) -> Plant:
    """The plant at step k; a delay of its input is written out as states."""
    if isinstance(plant, Plant):
        return plant
    if not isinstance(plant, PlantSchedule):
        raise InputError(f"{plant!r} is not linear, so it has no fixed loop at a step.")
    change = plant.at(k)
    return _delayed(_moved(plant, change, k), change.delay)


def measuring_command(plant: Plant) -> Plant:
    """The plant with y and the command r as its measurement, for a controller that reads both."""
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
    """The plant of a change, at step k of its ramp."""
    if not change.ramp or k == change.start:
        return change.plant
    end = next(b for a, b in pairwise(plant.changes) if a is change)
    share = (k - change.start) / (end.start - change.start)
    matrices: dict[str, Any] = {
        name: (1 - share) * getattr(change.plant, name) + share * getattr(end.plant, name)
        for name in MATRICES
    }
    return Plant(**matrices, blocks=plant.first.blocks)


@lru_cache(maxsize=32)  # made exactly, and asked for at every kept theta of a run
def _delayed(plant: Plant, delay: int) -> Plant:
    """[x; u(k-1); ...; u(k-delay)] as the state."""
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
