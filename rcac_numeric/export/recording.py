"""Inputs, and what the source of a controller makes of them: what an export is held against."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from compensator_theory.errors import DivergedError, InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.controllers.fixed import FixedController
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.engine.compatibility import command_position
from rcac_numeric.engine.compiled.callbacks import Failures
from rcac_numeric.engine.compiled.controllers import compiled_controller
from rcac_numeric.engine.runs import Run
from rcac_numeric.plants.saturation import Saturation

STEPS = 200
LEFT_OUT = 20  # before a divergence: what comes there hangs on the last digits


@dataclass(frozen=True, eq=False)
class Recording:
    """y, z and r of some steps with u of each and theta after the last, one row for each step."""

    y: Array
    z: Array
    r: Array
    u: Array
    theta: Array
    source: str

    @property
    def steps(self) -> int:
        """Number of steps."""
        return len(self.u)


def recorded(
    controller: ControllerSettings | FixedController | Compensator,
    saturation: Saturation | None = None,
    run: Run | None = None,
) -> Recording:
    """What the engine's plain instruction set makes of the inputs of a run, or of drawn ones.

    Parameters
    ----------
    controller : ControllerSettings, FixedController or Compensator
    saturation : Saturation, optional
    run : Run, optional
        From step 0 on; its y, z and r are the inputs. Without it a small plant with noise stands
        in.

    Raises
    ------
    DivergedError
        Where the controller leaves the range of float64 at once.
    InputError
        Where a saturation meets a target model that is not strictly proper.
    """
    if isinstance(controller, Compensator):
        controller = FixedController(controller)
    adaptive = isinstance(controller, ControllerSettings)
    if adaptive and saturation is not None and controller.target.relative_degree == 0:
        raise InputError(
            "a saturation with a target model that is not strictly proper cannot be held against "
            "the engine step by step; leave the saturation to the host."
        )
    fits = run is not None and run.first_step == 0 and not run.changes and run.steps > 0
    steps = min(STEPS, run.steps) if fits and run is not None else STEPS
    for _ in range(3):  # shorter, where it diverges
        found, diverged = _driven(controller, saturation, run if fits else None, steps)
        if diverged is None:
            return found
        steps = max(diverged - LEFT_OUT, diverged // 2)
        if not steps:
            break
    raise DivergedError(
        "the controller leaves the range of float64 within its first steps, so that there is "
        "nothing to hold an export against."
    )


def _driven(
    controller: ControllerSettings | FixedController,
    saturation: Saturation | None,
    run: Run | None,
    steps: int,
) -> tuple[Recording, int | None]:
    """The recording, and the step at which it diverged."""
    if isinstance(controller, ControllerSettings):
        s = controller.structure
        l_u, l_y, l_r, l_z = s.l_u, s.l_y, s.l_r, controller.target.l_z
    else:
        c = controller.compensator
        l_u, l_y, l_r, l_z = c.l_u, c.l_y - controller.l_r, controller.l_r, 1
    kernel = compiled_controller(controller, l_z, Failures(), "plain")
    plant = _Given(run, l_r) if run is not None else _StandIn(l_u, l_y, l_r, l_z, steps)
    if run is not None and not isinstance(controller, ControllerSettings):
        plant.z = np.zeros((steps, 1))
    limits = _Limits(saturation, l_u)
    rows: list[tuple[Array, ...]] = []
    applied = None
    for k in range(steps):
        y, z, r = plant.signals(k)
        answer = kernel.step(y, z, r if l_r else None, applied)
        if answer is None:
            raise InputError(f"the run's signals at step {k} are not finite.")
        u, is_fine = answer
        if not is_fine:
            return _recording(rows, kernel.theta, plant.source), k
        u = limits.applied(u)
        applied = u if saturation is not None else None
        rows.append((y, z, r, u))
        plant.move(u)
    return _recording(rows, kernel.theta, plant.source), None


def _recording(rows: Sequence[tuple[Array, ...]], theta: Array, source: str) -> Recording:
    columns = [np.array(column) for column in zip(*rows, strict=True)] or [np.zeros((0, 1))] * 4
    return Recording(*columns, np.asarray(theta), source)


class _Given:
    """The signals of a run."""

    source = "the run"

    def __init__(self, run: Run, l_r: int) -> None:
        first = command_position(run.plant, l_r)
        self.y, self.z = run.y, run.z
        self.r = run.w[:, first : first + l_r]

    def signals(self, k: int) -> tuple[Array, Array, Array]:
        return self.y[k], self.z[k], self.r[k]

    def move(self, u: Array) -> None:
        """A run has moved already."""


class _StandIn(_Given):
    """x(k+1) = 0.8 x(k) + 0.1 sum u(k) + noise, y and z of it with noise of their own."""

    source = "a stand-in plant"

    def __init__(self, l_u: int, l_y: int, l_r: int, l_z: int, steps: int) -> None:
        draws = np.random.Generator(np.random.PCG64(31)).integers(-1000, 1001, (steps, 9))
        noise = draws[:, :1] / 2048
        self.y = np.repeat(noise, l_y, axis=1) * 0.25
        self.z = np.repeat(draws[:, 1:2] / 8192, l_z, axis=1)
        for i in range(l_y):
            self.y[:, i] += draws[:, 2 + i % 3] / 8192
        self.r = np.stack([draws[:, 5 + i % 4] / 2048 for i in range(l_r)], axis=1) if l_r else (
            np.zeros((steps, 0))
        )  # fmt: skip
        self.noise, self.x, self.k = noise[:, 0], 0.0, 0

    def signals(self, k: int) -> tuple[Array, Array, Array]:
        return self.y[k] + self.x, self.z[k] + self.x, self.r[k]

    def move(self, u: Array) -> None:
        total = 0.0
        for value in u:
            total += float(value)
        self.x = 0.8 * self.x + 0.1 * total + float(self.noise[self.k])
        self.k += 1


class _Limits:
    """The actuator, as the kernel rounds it."""

    def __init__(self, saturation: Saturation | None, l_u: int) -> None:
        self.bounds = None if saturation is None else saturation.bounds(l_u)
        self.last = np.zeros(l_u)

    def applied(self, u: Array) -> Array:
        if self.bounds is None:
            return u
        low, high, rate = self.bounds
        self.last = np.clip(np.clip(u, self.last - rate, self.last + rate), low, high)
        return self.last
