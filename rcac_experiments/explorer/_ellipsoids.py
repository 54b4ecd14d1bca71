"""The ellipsoid of a case, in which the page can keep theta."""

from __future__ import annotations

import json
from importlib import resources
from typing import Any

import numpy as np

from compensator_theory.errors import CompensatorError
from rcac_experiments.explorer._encoding import in_base64
from rcac_numeric.analysis._certified_set import certified_set
from rcac_numeric.analysis._moving_gains import FIXED, perturbed_loop
from rcac_numeric.analysis._regressor_system import regressor_system
from rcac_numeric.controllers._bounds import CertifiedBounds
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.export._tables import ellipsoid_constants
from rcac_numeric.plants._linear import Plant

DATA = "ellipsoids.json"  # of the scenes; written by _compiling


def stored_ellipsoids() -> dict[str, Any]:
    """Return the ellipsoids of the built-in scenes, with the digest of the scenes."""
    file = resources.files("rcac_experiments.explorer").joinpath(DATA)
    table: dict[str, Any] = json.loads(file.read_text("ascii"))
    return table


def ellipsoid_of(plant: Plant, settings: ControllerSettings) -> dict[str, Any]:
    """Return the bounds of the settings, or the certified set about theta_0, as a page reads it.

    Without a set the table holds the reason alone.
    """
    bounds = settings.bounds
    if isinstance(bounds, CertifiedBounds):
        return {**_constants(bounds), "is_proved": _is_proved(plant, settings, bounds)}
    try:
        region = certified_set(plant, settings)
    except CompensatorError as error:
        return {"reason": str(error)}
    return {**_constants(region.bounds), "is_proved": True}


def _constants(bounds: CertifiedBounds) -> dict[str, Any]:
    center, inverse, radii = ellipsoid_constants(bounds, np.float64)
    return {
        "center": in_base64(np.array(center)),
        "inverse": in_base64(np.array(inverse)),
        "radii": in_base64(np.array(radii)),
        "factor": in_base64(bounds.factor),
    }


def _is_proved(plant: Plant, settings: ControllerSettings, bounds: CertifiedBounds) -> bool:
    """Whether no motion of theta in the bounds of a file destabilises its plant."""
    loop = perturbed_loop(regressor_system(plant, settings.structure, None), bounds.center, FIXED)
    bound = loop.bound(bounds.factor, np.ones(1), np.zeros(0), 1.0)
    return bound.certificate() is not None
