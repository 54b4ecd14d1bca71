"""The target model of an experiment file."""

from __future__ import annotations

from compensator_theory.errors import InputError
from rcac_numeric.experiment_files import Section
from rcac_numeric.modelling import ModellingInformation, modelling_information
from rcac_numeric.plants import Plant
from rcac_numeric.target_models import (
    TargetModel,
    fir_target,
    pole_placement_target,
    target_model,
)
from rcac_numeric.validation import one_of

# The keys that each target model reads.
TARGET_KEYS = {
    "fir": ("d_zu", "H", "nmp_zeros"),
    "pole placement": ("poles", "d_zu", "H", "nmp_zeros"),
    "filter": ("G_f", "numerator", "denominator"),
}


def target_of(section: Section, plant: Plant) -> TargetModel:
    """The target model; what the file does not say of G_zu is taken from the plant."""
    model = one_of(section.text("model"), "model", tuple(TARGET_KEYS))
    section.only(f'model = "{model}"', "model", *TARGET_KEYS[model])
    if model == "filter":
        if "numerator" in section.table:
            section.only('model = "filter" with numerator', "model", "numerator", "denominator")
            target = TargetModel(**section.given("numerator", "denominator"))
        else:
            section.only('model = "filter" with G_f', "model", "G_f")
            target = target_model(section.require("G_f"))
        if (plant.l_z, plant.l_u) != (1, 1):
            return target
        if target.relative_degree != (wanted := modelling_information(plant).d_zu):
            raise InputError(
                f"the target model G_f has relative degree {target.relative_degree}, the plant's "
                f"G_zu has {wanted}; the intercalated transfer function always has that of G_zu "
                "(4.18). Multiply G_f by a power of q."
            )
        return target
    given = section.given("d_zu", "H", "nmp_zeros")
    known = (
        ModellingInformation(**given)
        if {"d_zu", "H"} <= given.keys()
        else ModellingInformation(**{**vars(modelling_information(plant)), **given})
    )
    if model == "fir":
        return fir_target(known)
    return pole_placement_target(known, section.require("poles"))
