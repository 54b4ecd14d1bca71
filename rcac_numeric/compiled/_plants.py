"""Compiled plants from plants as data.

Register a new class of plants with `@compiled_plant.register(YourPlant)`. A class derived from
a kind that is, and is not registered itself, is refused: the kernel would run it without what it
adds.
"""

from __future__ import annotations

from functools import partial, singledispatch
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import float_array, real_array
from rcac_numeric.compiled import _kernel
from rcac_numeric.compiled._callbacks import Failures
from rcac_numeric.compiled._updates import require_kind
from rcac_numeric.plants._any_plant import AnyPlant
from rcac_numeric.plants._functions import FunctionPlant
from rcac_numeric.plants._linear import MATRICES, Plant
from rcac_numeric.plants._schedules import PlantChange, PlantSchedule


@singledispatch
def compiled_plant(plant: object, x_0: ArrayLike | None, failures: Failures) -> _kernel.Plant:
    """Return the compiled plant in the state x_0."""
    kinds = [kind.__name__ for kind in compiled_plant.registry if kind is not object]
    raise InputError(f"plant = {plant!r} is not a {' or '.join(kinds)}.")


@compiled_plant.register(Plant)
def _(plant: Plant, x_0: ArrayLike | None, failures: Failures) -> _kernel.Plant:
    require_kind(plant, "plant", compiled_plant.registry)
    segments = [(0, _matrices(plant), False, np.zeros(0), 0)]
    return _kernel.linear_plant(_sizes(plant), segments, initial_state(x_0, plant.n))


@compiled_plant.register(PlantSchedule)
def _(plant: PlantSchedule, x_0: ArrayLike | None, failures: Failures) -> _kernel.Plant:
    require_kind(plant, "plant", compiled_plant.registry)
    require_linear(plant)
    segments = [
        (
            change.start,
            _matrices(change.plant),
            change.ramp,
            np.zeros(0) if change.state_map is None else change.state_map,
            change.delay,
        )
        for change in plant.changes
    ]
    return _kernel.linear_plant(_sizes(plant.first), segments, initial_state(x_0, plant.first.n))


@compiled_plant.register(FunctionPlant)
def _(plant: FunctionPlant, x_0: ArrayLike | None, failures: Failures) -> _kernel.Plant:
    require_kind(plant, "plant", compiled_plant.registry)
    start = initial_state(x_0, plant.n)
    if plant.is_compiled:
        return _kernel.compiled_plant(
            _sizes(plant), _capsule(plant.advance), _capsule(plant.output), start
        )
    return _kernel.python_plant(
        _sizes(plant),
        failures.guard(partial(_checked_advance, plant)),
        failures.guard(partial(_checked_output, plant)),
        start,
    )


def require_linear(plant: Plant | PlantSchedule, who: str = "engine") -> None:
    """Raise for subclasses of Plant, PlantSchedule and PlantChange."""
    require_kind(plant, "plant", (Plant, PlantSchedule), who)
    for change in plant.changes if isinstance(plant, PlantSchedule) else ():
        require_kind(change, "a change", (PlantChange,), who)
        require_kind(change.plant, f"the plant from step {change.start} on", (Plant,), who)


def initial_state(x_0: ArrayLike | None, n: int) -> Array:
    """Return x(0) as an array of n entries; zero by default."""
    start = np.zeros(n) if x_0 is None else real_array(x_0, "x_0").reshape(-1)
    if start.size != n:
        raise InputError(f"x_0 has {start.size} entries; the plant has {n} states.")
    return start


def _capsule(function: Any) -> object:
    # A LowLevelCallable is a tuple of a capsule and what it was made from, but refuses [0].
    return tuple.__getitem__(function, 0)


def _sizes(plant: AnyPlant) -> tuple[int, int, int, int, int]:
    return plant.n, plant.l_u, plant.l_w, plant.l_y, plant.l_z


def _matrices(plant: Plant) -> list[Array]:
    return [getattr(plant, name) for name in MATRICES]


def _checked_advance(plant: FunctionPlant, k: int, x: Array, u: Array, w: Array) -> Array:
    return _sized(plant.advance(k, x, u, w), "advance", "x(k+1)", plant.n)


def _checked_output(plant: FunctionPlant, k: int, x: Array, w: Array) -> tuple[Array, Array]:
    try:
        y, z = plant.output(k, x, w)
    except (TypeError, ValueError) as error:
        if error.__traceback__ and error.__traceback__.tb_next:  # raised inside the function
            raise
        raise InputError("output must return the pair (y, z).") from None
    return _sized(y, "output", "y", plant.l_y), _sized(z, "output", "z", plant.l_z)


def _sized(value: ArrayLike, function: str, name: str, size: int) -> Array:
    # The kernel reports NaN; complex numbers, texts and None are refused here.
    array = float_array(value, f"what {function} returned as {name}").reshape(-1)
    if array.size != size:
        raise InputError(f"{function} returned {array.size} numbers as {name}; {size} are needed.")
    return array
