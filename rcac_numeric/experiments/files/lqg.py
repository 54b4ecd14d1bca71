"""The LQG controller of an experiment file: a run in which nothing adapts."""

from __future__ import annotations

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import one_of
from rcac_numeric.controllers.fixed import FixedController
from rcac_numeric.experiments.files.sections import Section
from rcac_numeric.h2.lqg import FORMS, lqg
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.schedules import PlantSchedule


def lqg_settings(section: Section, plant: Plant | PlantSchedule) -> FixedController:
    """LQG as a controller that does not adapt."""
    section.only('structure = "lqg"', "structure", "form", "noise", "k_w")
    if isinstance(plant, PlantSchedule):
        raise InputError('structure = "lqg" is designed for one plant; this one changes.')
    form = one_of(section.text("form", "predictor"), "form", FORMS)
    compensator = lqg(plant, noise=section.get("noise", None), form=form).compensator
    return FixedController(compensator, **section.given("k_w"))
