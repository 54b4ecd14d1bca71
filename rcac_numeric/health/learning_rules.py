"""When a target model was not learnt as it should have been: the rules of `DataDriven` runs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from compensator_theory.errors import CompensatorError, DivergedError, InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.engine.runs import Run
from rcac_numeric.health.warning import HealthWarning
from rcac_numeric.identification.online.arx import WHITE, RecursiveARX
from rcac_numeric.plants.frozen import plant_at
from rcac_numeric.targets.data_driven import DataDriven

LONGEST = 20_000  # steps that the model is fitted to again
VISIBLE = 1e-3  # a residual this small beside z is of a start, a step or rounding, and never white
POOR = 0.1  # share of R_theta in what is known of the worst known coefficient
GROWTH = 1e6  # of an unstable mode while u is the dither alone
CAUSES = ("poor excitation", "unstable start")  # said where there is another warning


@dataclass(frozen=True)
class _Look:
    """What an ARX model of so many steps says of itself."""

    steps: int
    whiteness: float
    excitation: float
    visible: bool


def learning_warnings(run: Run) -> Iterator[HealthWarning]:
    """The warnings of a run with `DataDriven`, `CAUSES` among them where they would explain others.

    Parameters
    ----------
    run : Run

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, DataDriven, WhiteNoise, exogenous, iir, simulate,
    ...     standard_plant)
    >>> from rcac_numeric.health.learning_rules import learning_warnings
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=4), update=UD(R_theta=1), target=DataDriven(order=4, dither=1e-6))
    >>> run = simulate(standard_plant("1/(q - 0.5)"), settings, exogenous([WhiteNoise()], 400))
    >>> [warning.code for warning in learning_warnings(run)]
    ['nothing learnt']
    """
    settings = run.settings
    if not isinstance(settings, ControllerSettings) or settings.learning is None:
        return
    learning = settings.learning
    if run.first_step or run.steps <= learning.order + 1:
        return
    yield from _unstable_start(run, learning)
    if run.steps <= learning.start:
        return
    if not run.changes:
        yield HealthWarning(
            "nothing learnt",
            f"In {run.steps} steps u was not seen to act on z: there is no target model, and u is "
            "the dither alone.",
            f"a larger dither than {learning.dither:.3g}, ten times the noise in z; then a later "
            "start",
            is_grave=True,
        )
        return
    looks = _looks(run, learning)
    coloured = [look for look in looks if look.visible and look.whiteness < WHITE]
    if coloured:
        first = coloured[0]
        yield HealthWarning(
            "low order",
            f"The residuals of the ARX({learning.order}) are not white after {first.steps} steps "
            f"(probability {first.whiteness:.1g}): the order is below that of the plant and its "
            "noise, or the plant changed, and the zeros that were learnt may be wrong.",
            f"order = {2 * learning.order}; for a plant that changes lambda = 0.999 and a running "
            "dither",
        )
    if looks and looks[0].excitation > POOR:
        yield HealthWarning(
            "poor excitation",
            f"In the {looks[0].steps} steps of the start the dither of {learning.dither:.3g} did "
            "not excite every coefficient of the model: of the worst, "
            f"{looks[0].excitation:.0%} of what is known comes from its R_theta.",
            "a larger dither, a later start, or a smaller order",
        )


def _unstable_start(run: Run, learning: DataDriven) -> Iterator[HealthWarning]:
    try:
        plant = plant_at(run.plant, 0)
    except CompensatorError:  # no linear plant is known
        return
    radius = float(np.abs(np.linalg.eigvals(plant.A)).max(initial=0.0))
    with np.errstate(over="ignore"):
        growth = np.float64(radius) ** learning.start
    if radius > 1 and growth > GROWTH:
        least = max(learning.order + 1, int(np.log(1e3) / np.log(radius)))
        yield HealthWarning(
            "unstable start",
            f"The plant is unstable, spectral radius {radius:.4g}: in the {learning.start} steps "
            f"with the dither alone a mode grows {growth:.2g} times.",
            f"start = {least} or so, the least order, a dither ten times the noise, and d_zu and H "
            "told",
        )


def _looks(run: Run, learning: DataDriven) -> list[_Look]:
    """After the start, and at the end of what is looked at."""
    model = RecursiveARX(learning.order, R_theta=learning.R_theta, lambda_=learning.lambda_)
    found: list[_Look] = []
    steps = min(run.steps, LONGEST)
    for first, last in ((0, learning.start), (learning.start, steps)):
        try:
            model.update(run.u_applied[first:last], run.z[first:last])
            online = model.estimate()
        except DivergedError:
            break
        except InputError:  # u is not seen to act on z yet
            continue
        size = _rms(run.z[:last])
        visible = np.sqrt(model.variance) > VISIBLE * size
        found.append(_Look(last, online.whiteness, model.excitation(), bool(visible)))
    return found


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
