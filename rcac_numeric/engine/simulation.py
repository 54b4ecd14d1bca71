"""The closed loop at full speed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import instance_of, integer
from rcac_numeric.controllers.decentralized import Decentralized
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.engine import _kernel
from rcac_numeric.engine.jobs import AnyPlant, PreparedRun
from rcac_numeric.engine.runs import Run
from rcac_numeric.engine.states import SavedState
from rcac_numeric.plants.saturation import Saturation

# Seconds that the kernel runs before Python may look at a key that was pressed.
CHUNK = 0.05


def simulate(
    plant: AnyPlant,
    settings: ControllerSettings | Decentralized,
    w: ArrayLike,
    *,
    x_0: Array | None = None,
    stride: int = 1,
    divergence_limit: float = 1e100,
    saturation: Saturation | None = None,
    start: SavedState | None = None,
) -> Run:
    """Run a controller on a plant.

    Parameters
    ----------
    plant : Plant, PlantSchedule or FunctionPlant
    settings : ControllerSettings or Decentralized
    w : array, shape (steps, l_w)
        The exogenous input; its length is the number of steps. Where the structure reads a
        command, that is the block "r" of w.
    x_0 : array, shape (n,), optional
        Initial state; zero by default.
    stride : int
        theta is kept at every stride-th step.
    divergence_limit : float
        The loop counts as diverged where an entry of u, y, z, x or theta exceeds it in size.
    saturation : Saturation, optional
    start : SavedState, optional
        The state of an earlier run with the same plant, settings and saturation; this run goes on
        from there, bit for bit as if it had not been cut.

    Raises
    ------
    InputError
        Where sizes do not fit, or `start` belongs to another loop.
    ImproperError
        Where u(k) and y(k) depend on each other.
    FunctionFailedError
        Where a function of the plant or of a weight raised or returned the wrong shape; the
        attribute `run` of the error holds what came before.

    Examples
    --------
    >>> from rcac_numeric import *
    >>> plant = servo_plant("(q - 0.85)/((q - 0.8)*(q - 0.9))")
    >>> settings = ControllerSettings(structure=iir(n_c=3), target=fir_target(plant), R_theta=0.2)
    >>> w = exogenous([step(), step(0), step(0)], steps=1000)
    >>> run = simulate(plant, settings, w)
    >>> run
    Run(completed, steps=1000, Plant(n=2, l_u=1, l_w=3, l_y=1, l_z=1))
    >>> bool(abs(run.z[-1, 0]) < 0.01)
    True
    >>> half = simulate(plant, settings, w[:500])
    >>> rest = simulate(plant, settings, w[500:], start=half.state)
    >>> bool((rest.theta_final == run.theta_final).all())
    True
    """
    prepared = PreparedRun(
        plant,
        settings,
        w,
        x_0=x_0,
        stride=stride,
        divergence_limit=divergence_limit,
        saturation=saturation,
        start=start,
    )
    while _kernel.run_jobs([prepared.job], 1, CHUNK):
        pass
    return prepared.result()


def frozen_twin(run: Run, k: int) -> Run:
    """The same run with the adaptation stopped at step k: the fixed controller beside it.

    Examples
    --------
    >>> from rcac_numeric import *
    >>> slow, fast = standard_plant("1/(q - 0.9)"), standard_plant("4/(q - 0.9)")
    >>> plant = PlantSchedule(
    ...     [PlantChange(start=0, plant=slow), PlantChange(start=500, plant=fast)])
    >>> settings = ControllerSettings(structure=iir(n_c=1), target=fir_target(slow), R_theta=1e-3)
    >>> run = simulate(plant, settings, exogenous([white_noise()], 1000))
    >>> run.outcome, frozen_twin(run, 500).outcome
    ('completed', 'completed')
    """
    if instance_of(run, "run", Run).first_step != 0:
        raise InputError("the run is the continuation of another; freeze the whole run instead.")
    freeze = ((integer(k, "k"), None),)
    if isinstance(run.settings, Decentralized):
        frozen: Any = replace(
            run.settings,
            controllers=[replace(c, freeze=(*c.freeze, *freeze)) for c in run.settings.controllers],
        )
    else:
        frozen = replace(run.settings, freeze=(*run.settings.freeze, *freeze))
    return simulate(
        run.plant,
        frozen,
        run.w,
        x_0=run.x_0,
        stride=run.stride,
        divergence_limit=run.divergence_limit,
        saturation=run.saturation,
    )
