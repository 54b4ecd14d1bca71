"""Test vectors of an export: inputs, and the controller's outputs."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from compensator_theory.errors import DivergedError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.compiled._callbacks import Failures
from rcac_numeric.compiled._controllers import compiled_controller
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.engine._compatibility import command_position
from rcac_numeric.engine._runs import Run
from rcac_numeric.engine._simulator import Simulator
from rcac_numeric.export._tables import CoreTables
from rcac_numeric.plants._saturation import Saturation

STEPS = 200
LARGEST_U = 1e4  # around the stand-in plant, whose noise is below one: it then diverges
LEFT_RANGE = 2 | 1024  # RCAC_DIVERGED, RCAC_RESTORED
Rows = list[tuple[Any, ...]]  # y, z, r and u of each step, in float64 or float32


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


class _RunSignals:
    """The recorded signals of a run."""

    def __init__(self, run: Run, l_r: int) -> None:
        first = command_position(run.plant, l_r)
        self.y, self.z = run.y, run.z
        self.r = run.w[:, first : first + l_r]

    def measured(self, k: int, u: Array | None) -> tuple[Array, Array, Array]:
        """y, z and r of step k; u is that of the step, where it is known."""
        return self.y[k], self.z[k], self.r[k]

    def move(self, k: int, u: Array) -> None:
        """Do nothing: the signals of a run are recorded."""


class _Loop(_RunSignals):
    """The plant of a run, simulated again."""

    def __init__(self, run: Run, l_r: int) -> None:
        super().__init__(run, l_r)
        self.w, self.body, self.idle = run.w, Simulator(run.plant, run.x_0), np.zeros(run.plant.l_u)

    def measured(self, k: int, u: Array | None) -> tuple[Array, Array, Array]:
        y, z = self.body.output(self.idle if u is None else u, self.w[k])
        return y, z, self.r[k]

    def move(self, k: int, u: Array) -> None:
        self.body.advance(u, self.w[k])


class _PlaceholderSignals(_RunSignals):
    """x(k+1) = 0.8 x(k) + 0.1 sum u(k) + noise; y and z are x with separate noises."""

    def __init__(self, t: CoreTables) -> None:
        draws = np.random.Generator(np.random.PCG64(31)).integers(-1000, 1001, (STEPS, 9))
        self.noise, self.x = draws[:, 0] / 2048, 0.0
        column = np.arange(max(t.l_y, t.l_z, t.l_r))
        self.y = draws[:, 1 + column[: t.l_y] % 3] / 8192
        self.z = draws[:, 4 + column[: t.l_z] % 2] / 8192
        self.r = np.ascontiguousarray(draws[:, 6 + column[: t.l_r] % 3]) / 2048

    def measured(self, k: int, u: Array | None) -> tuple[Array, Array, Array]:
        return self.y[k] + self.x, self.z[k] + self.x, self.r[k]

    def move(self, k: int, u: Array) -> None:
        total = 0.0
        for value in u:  # in this order on every machine
            total += float(value)
        self.x = 0.8 * self.x + 0.1 * total + float(self.noise[k])


def usable(run: Run | None) -> Run | None:
    """Return the run if its signals can be replayed from the first step on."""
    fits = run is not None and run.first_step == 0 and not run.changes and run.steps > 0
    return run if fits else None


def recorded(
    controller: ControllerSettings | FixedController | Compensator,
    tables: CoreTables,
    saturation: Saturation | None = None,
    run: Run | None = None,
) -> Recording:
    """Record the engine with the plain instruction set on a run's inputs, or in a small loop."""
    if isinstance(controller, Compensator):
        controller = FixedController(controller)
    if saturation is not None and not tables.strictly_proper:
        raise InputError(
            "a saturation with a target model that is not strictly proper cannot be compared with "
            "the engine step by step; leave the saturation to the host."
        )
    run = usable(run)
    kernel = compiled_controller(controller, tables.l_z, Failures(), "plain")
    if run is None:
        signals: _RunSignals = _PlaceholderSignals(tables)
    elif run.plant.y_needs_u or run.plant.z_needs_u:
        signals = _RunSignals(run, tables.l_r)
    else:
        signals = _Loop(run, tables.l_r)
    limits = _Limits(saturation, tables.l_u)
    rows: Rows = []
    theta, applied = kernel.theta, None
    for k in range(STEPS if run is None else min(STEPS, run.steps)):
        y, z, r = signals.measured(k, None)
        if not tables.adapts:  # it reads no z
            z = np.zeros(1)
        answer = kernel.step(y, z, r if tables.l_r else None, applied)
        if answer is None:
            if rows:
                break
            raise InputError("the first signals are not finite, or do not fit the controller.")
        u = limits.applied(answer[0])
        if (
            not answer[1]
            or not np.isfinite(u).all()
            or (run is None and np.abs(u).max() > LARGEST_U)
        ):
            break
        applied, theta = (None if saturation is None else u), kernel.theta
        rows.append((y, z, r, u))
        signals.move(k, u)
    return _recording(rows, theta, run)


def compiled_recording(program: Path, tables: CoreTables, run: Run | None, steps: int) -> Recording:
    """Record the compiled core in float32 in the same closed loop."""
    t, run = tables, usable(run)
    signals = _PlaceholderSignals(t) if run is None else _Loop(run, t.l_r)
    rows: Rows = []
    theta = np.array(t.theta_0, dtype=np.float32)
    with subprocess.Popen([str(program)], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin is not None and process.stdout is not None

        def send(k: int, u: Array | None) -> tuple[Any, ...]:
            row = [np.asarray(v, dtype=np.float32) for v in signals.measured(k, u)]
            if not t.adapts:
                row[1] = np.zeros(1, dtype=np.float32)
            process.stdin.write(b"".join(v.tobytes() for v in row))  # type: ignore[union-attr]
            process.stdin.flush()  # type: ignore[union-attr]
            return tuple(row)

        for k in range(steps):
            if t.measures_first:
                send(k, None)
            u = np.frombuffer(process.stdout.read(4 * t.l_u), dtype=np.float32)
            row = send(k, u.astype(np.float64))
            status = int.from_bytes(process.stdout.read(4), "little")
            if status & LEFT_RANGE:
                process.kill()
                raise DivergedError(f"in float32 the controller overflows at step {k}.")
            theta = np.frombuffer(process.stdout.read(4 * t.l_theta), dtype=np.float32)
            rows.append((*row, u))
            signals.move(k, u.astype(np.float64))
        process.stdin.close()
        process.stdout.read()
    return _recording(rows, theta, run)


def _recording(rows: Rows, theta: Any, run: Run | None) -> Recording:
    if not rows:
        raise DivergedError(
            "the controller leaves the range of float64 within its first steps: there is no "
            "reference for the export."
        )
    y, z, r, u = (np.array(column) for column in zip(*rows, strict=True))
    source = "a stand-in plant" if run is None else "the run"
    return Recording(y, z, r, u, np.asarray(theta), source)


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
