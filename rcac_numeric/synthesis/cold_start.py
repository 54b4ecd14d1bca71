"""Settings where no model of the plant is there, only what RCAC must know of it."""

from __future__ import annotations

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import instance_of, integer
from rcac_numeric.controllers.kinds import iir
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.controllers.updates.recursive import UD
from rcac_numeric.targets.modelling import ModellingInformation
from rcac_numeric.targets.pole_placement import pole_placement_target
from rcac_numeric.targets.zero_directions import (
    DirectionInformation,
    zero_direction_target,
)

POLES = 15.0  # steps: the two time constants of the target
WAITS, LEAST_WAIT = 5, 50  # times the longest filter, and steps
SCALAR, SEVERAL = 1.0, 0.1  # R_theta over the square of H


def cold_start(
    information: ModellingInformation | DirectionInformation, *, order: int, stable: bool
) -> ControllerSettings:
    """Settings from modelling information alone, theta(0) = 0; with a model `design` is better.

    One input and output: the target has two poles exp(-1/15) and the NMP zeros, n_c = order + d_zu
    + 1, R_theta = H^2. Several: `zero_direction_target`, n_c = order + 2, R_theta = 0.1 norm(H)^2.
    A plant that is stable by itself is watched for 5 max(n_c, n_f) steps, at least 50, before RCAC
    takes it over: what acts on it fills the regressor.

    Parameters
    ----------
    information : ModellingInformation or DirectionInformation
        Of G_zu, which for e = r - y is minus that of the plant. Zeros inside the circle are better
        left out, also those near -1.
    order : int
        Of the plant, without its dead time; in doubt rather more.
    stable : bool
        Whether it stays where it is without control.

    Raises
    ------
    InputError
        Where this is no such information.

    Notes
    -----
    A start in the dark, and not safe: the guide says how often it ended well. With a log,
    `design(ControllerLog(u, y))` finds a model in its place.

    Examples
    --------
    >>> from rcac_numeric import ModellingInformation, cold_start
    >>> known = ModellingInformation(d_zu=3, H=-0.02, nmp_zeros=[1.5])
    >>> settings = cold_start(known, order=2, stable=True)
    >>> settings.structure.n_c, settings.k_w, round(settings.update.R_theta, 6)
    (6, 50, 0.0004)
    """
    integer(order, "order", at_least=1)
    instance_of(stable, "stable", bool)
    if isinstance(information, DirectionInformation):
        target = zero_direction_target(information)
        structure = iir(order + 2, target.l_u, target.l_z)
        R_theta = SEVERAL * float(np.linalg.norm(information.H, 2)) ** 2
    elif isinstance(information, ModellingInformation):
        pole = float(np.exp(-1 / POLES))
        target = pole_placement_target(information, [pole, pole])
        structure = iir(order + information.d_zu + 1)
        R_theta = SCALAR * float(target.numerator[target.relative_degree, 0, 0]) ** 2
    else:
        raise InputError(
            f"{information!r} is no modelling information: give ModellingInformation(d_zu, H, "
            "nmp_zeros), or DirectionInformation(H, zeros) of several signals; of a plant or a log "
            "design makes more."
        )
    filled = max(structure.n_c, target.n_f)
    k_w = max(WAITS * filled, LEAST_WAIT) if stable else filled
    return ControllerSettings(
        structure=structure, target=target, update=UD(R_theta=R_theta), k_w=k_w
    )
