"""The target model of an experiment file."""

from __future__ import annotations

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import one_of
from rcac_numeric.experiments.files.sections import Section
from rcac_numeric.plants.linear import Plant
from rcac_numeric.targets.filters import target_model
from rcac_numeric.targets.high_authority import high_authority_target_model
from rcac_numeric.targets.markov import markov_target
from rcac_numeric.targets.model import TargetModel
from rcac_numeric.targets.modelling import ModellingInformation, modelling_information
from rcac_numeric.targets.output_subspaces import output_subspace_target
from rcac_numeric.targets.pole_placement import fir_target, pole_placement_target

# The keys that each target model reads.
TARGET_KEYS = {
    "fir": ("d_zu", "H", "nmp_zeros"),
    "pole placement": ("poles", "d_zu", "H", "nmp_zeros"),
    "markov": ("n_bar", "markov_parameters"),
    "high authority": (),
    "output subspace": (),
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
        return _with_relative_degree_of(plant, target)
    if model == "markov":
        if "markov_parameters" in section.table:
            parameters = section.table["markov_parameters"]
            target = markov_target(parameters, section.get("n_bar", None))
            return _with_relative_degree_of(plant, target)
        return markov_target(plant, section.require("n_bar"))
    if model == "high authority":
        return high_authority_target_model(plant)
    if model == "output subspace":
        return output_subspace_target(plant)
    given = section.given("d_zu", "H", "nmp_zeros")
    known = (
        ModellingInformation(**given)
        if {"d_zu", "H"} <= given.keys()
        else ModellingInformation(**{**vars(modelling_information(plant)), **given})
    )
    if model == "fir":
        return fir_target(known)
    return pole_placement_target(known, section.require("poles"))


def _with_relative_degree_of(plant: Plant, target: TargetModel) -> TargetModel:
    """The target itself, if its relative degree is that of a scalar G_zu."""
    if (plant.l_z, plant.l_u) != (1, 1):
        return target
    if target.relative_degree != (wanted := modelling_information(plant).d_zu):
        raise InputError(
            f"the target model G_f has relative degree {target.relative_degree}, the plant's "
            f"G_zu has {wanted}; the intercalated transfer function always has that of G_zu "
            "(4.18). Multiply G_f by a power of q."
        )
    return target
