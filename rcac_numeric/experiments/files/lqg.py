"""The LQG controller of an experiment file: a run in which nothing adapts."""

from __future__ import annotations

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import one_of
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.controllers.kinds import iir
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.controllers.structure import Structure
from rcac_numeric.experiments.files.sections import Section
from rcac_numeric.h2.lqg import FORMS, lqg
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.schedules import PlantSchedule
from rcac_numeric.targets.model import TargetModel


def lqg_settings(
    section: Section, target: TargetModel, plant: Plant | PlantSchedule
) -> ControllerSettings:
    """The settings of a controller that is LQG's from the first step to the last.

    An IIR controller with LQG's coefficients as theta(0) and an update that never runs: the run,
    the comparison with the target model and the measures are then those of any other controller.
    """
    section.only('structure = "lqg"', "structure", "form", "noise", "k_w")
    if isinstance(plant, PlantSchedule):
        raise InputError('structure = "lqg" is designed for one plant; this one changes.')
    form = one_of(section.text("form", "predictor"), "form", FORMS)
    compensator = lqg(plant, noise=section.get("noise", None), form=form).compensator
    structure = iir(
        compensator.n_c, plant.l_u, plant.l_y, k_c=0 if compensator.past_y[0].any() else 1
    )
    return ControllerSettings(
        structure=structure,
        target=target,
        R_theta=1.0,
        theta_0=_theta(structure, compensator),
        freeze=[(0, None)],
        **section.given("k_w"),
    )


def _theta(structure: Structure, compensator: Compensator) -> Array:
    """The coefficients in the order of the structure's taps, one column for each."""
    return np.concatenate(
        [
            compensator.past_u[tap.delay - 1][:, tap.component]
            if tap.signal == "u"
            else compensator.past_y[tap.delay][:, tap.component]
            for tap in structure.taps
        ]
    )
