"""The closed loop in ball arithmetic: what RCAC does when rounding plays no part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from compensator_theory.polynomials.ball_precision import ball_precision
from compensator_theory.systems.foreign import is_foreign
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import integer, real_array, signal_array
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.controllers.weights import SignalWeight
from rcac_numeric.engine.compatibility import AnyController, command_position, require_fit
from rcac_numeric.engine.compiled.controllers import require_parts
from rcac_numeric.engine.compiled.plants import require_linear
from rcac_numeric.engine.compiled.updates import require_kind
from rcac_numeric.engine.reference.ball_controller import BallController
from rcac_numeric.engine.reference.ball_plants import BallPlant
from rcac_numeric.engine.reference.ball_updates import ball_update
from rcac_numeric.engine.reference.balls import balls
from rcac_numeric.engine.runs import Run
from rcac_numeric.plants.any_plant import AnyPlant
from rcac_numeric.plants.foreign.reading import linear_plant
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.saturation import Saturation
from rcac_numeric.plants.schedules import PlantSchedule


@dataclass(frozen=True, eq=False)
class ReferenceRun(Run):
    """A run in ball arithmetic, rounded once to float64 at the end.

    Attributes
    ----------
    digits : float
        Certified correct digits of the least accurate entry of theta_final, relative to the
        largest entry.
    """

    digits: float = float("nan")


def simulate_reference(
    plant: Plant | PlantSchedule,
    settings: ControllerSettings,
    w: ArrayLike,
    *,
    x_0: ArrayLike | None = None,
    digits: int = 250,
) -> ReferenceRun:
    """The run that `simulate` approximates, with `digits` decimal digits.

    Parameters
    ----------
    plant : Plant or PlantSchedule
    settings, w, x_0
        As for `simulate`; the float64 data are taken as exact. The updates `UD` and
        `Covariance` are the same here.
    digits : int
        Working precision. Balls grow by about one digit every few steps, so a few hundred digits
        serve a few hundred steps.

    Raises
    ------
    InputError
        Where sizes do not fit, or for what the reference does not do: functions as plants or
        weights, several controllers, the sliding window, variable-rate forgetting, resets that
        watch the run, pole reflection, bounds with method = "metric".
    DivergedError
        Where the balls have grown until nothing is certain.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, Step, exogenous, fir_target, iir, simulate_reference,
    ...     standard_plant)
    >>> plant = standard_plant("(q - 0.5)/(q*(q - 0.9))")
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=2), target=fir_target(plant), update=UD(R_theta=1e-20))
    >>> w = exogenous([Step()], steps=20)
    >>> reference = simulate_reference(plant, settings, w)
    >>> reference.digits > 100
    True
    """
    if is_foreign(plant):
        plant = linear_plant(plant)
    require_supported(plant, settings)
    require_fit(plant, settings)
    w = signal_array(w, "w", plant.l_w)
    bits = int(integer(digits, "digits", at_least=16) * 3.33) + 8
    return _run(plant, settings, w, x_0, bits)


def require_supported(
    plant: AnyPlant, controller: AnyController, saturation: Saturation | None = None
) -> tuple[Plant | PlantSchedule, ControllerSettings]:
    """Refuse by name what the reference does not do."""
    if not isinstance(plant, Plant | PlantSchedule):
        raise InputError(f"the reference needs a linear plant, not {plant!r}.")
    if not isinstance(controller, ControllerSettings):
        raise InputError(
            f"the reference runs one adaptive controller, not a {type(controller).__name__}."
        )
    if saturation is not None:
        raise InputError("the reference runs without saturation.")
    for name in ("R_z", "R_u"):
        if not isinstance(getattr(controller, name), np.ndarray | SignalWeight):
            raise InputError(
                f"the reference does not know {name} as a weight that is a function; leave it out."
            )
    if controller.learning is not None:
        raise InputError("the reference learns no target model; give it one.")
    if controller.reflect_poles:
        raise InputError("the reference does not know reflect_poles; leave it out.")
    if controller.bounds is not None and controller.bounds.method == "metric":
        raise InputError(
            'the reference does not know bounds with method = "metric"; use "clip", or leave them '
            "out."
        )
    R = controller.R_u_unfiltered
    if R.any() and np.linalg.matrix_rank(R) < len(R):
        raise InputError("the reference needs R_u_unfiltered to be positive definite, or zero.")
    require_linear(plant, "reference")
    require_kind(controller, "settings", (ControllerSettings,), "reference")
    require_parts(controller, "reference")
    ball_update(controller.update, controller.l_theta)
    return plant, controller


def _run(
    plant: Plant | PlantSchedule,
    settings: ControllerSettings,
    w: Array,
    x_0: ArrayLike | None,
    bits: int,
) -> ReferenceRun:
    with ball_precision(bits):
        controller, body = BallController(settings), BallPlant(plant, x_0)
    position, l_r = command_position(plant, settings.structure.l_r), settings.structure.l_r
    filter_form = settings.form == "filter"
    y_first = settings.measures_first or filter_form
    record: dict[str, list[arb_mat]] = {name: [] for name in ("u", "y", "z", "theta")}
    unknown = arb_mat(plant.l_u, 1)  # in place of u(k) where nothing depends on it
    for k, row in enumerate(w):
        with ball_precision(bits):  # of this step only, so that other threads have theirs, too
            w_k, r_k = (
                balls(row.reshape(-1, 1)),
                balls(row[position : position + l_r].reshape(-1, 1)),
            )
            body.begin(k)
            if y_first:
                y = body.y(unknown, w_k)
                controller.measure(y, r_k)
            if filter_form:
                controller.adapt(body.z(unknown, w_k))
            record["theta"].append(controller.theta)
            u = controller.control()
            if not y_first:
                y = body.y(u, w_k)
                controller.measure(y, r_k)
            z = body.z(u, w_k)
            if not filter_form:
                controller.adapt(z)
            controller.finish()
            body.advance(u, w_k)
            for name, value in (("u", u), ("y", y), ("z", z)):
                record[name].append(value)

    widths = {"u": plant.l_u, "y": plant.l_y, "z": plant.l_z, "theta": settings.structure.l_theta}
    rounded = {
        name: np.array([[float(b.mid()) for b in v.entries()] for v in values]).reshape(
            len(w), widths[name]
        )
        for name, values in record.items()
    }
    final = controller.theta.entries()
    size = max(abs(float(b.mid())) for b in final) or 1.0
    worst = max(b.rad() for b in final)  # as a ball: it may be below every float
    with ball_precision(bits):
        correct = float("inf") if worst == 0 else -float((worst / size).log() / arb(10).log())
    return ReferenceRun(
        plant=plant,
        settings=settings,
        w=w,
        u=rounded["u"],
        y=rounded["y"],
        z=rounded["z"],
        theta=rounded["theta"],
        theta_final=np.array([float(b.mid()) for b in final]),
        stride=1,
        outcome="completed",
        guard_count=0,
        guard_first_step=-1,
        u_applied=rounded["u"],
        x_0=None if x_0 is None else real_array(x_0, "x_0").reshape(-1),
        digits=correct,
    )
