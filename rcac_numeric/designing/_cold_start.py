"""Settings from modelling information alone, without a model of the plant."""

from __future__ import annotations

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._validation import instance_of, integer, number
from rcac_numeric.controllers._kinds import iir
from rcac_numeric.controllers._recursive import UD
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.targets._modelling import ModellingInformation
from rcac_numeric.targets._pole_placement import pole_placement_target
from rcac_numeric.targets._zero_directions import (
    DirectionInformation,
    zero_direction_target,
)

POLES = 15.0  # steps: the two time constants of the target
WAITS, LEAST_WAIT = 5, 50  # times the longest filter, and steps
SCALAR, SEVERAL = 1.0, 10.0  # R_theta over the square of H, signals in units of their size


def cold_start(
    information: ModellingInformation | DirectionInformation, *, order: int, stable: bool,
    u: float = 1.0, y: float = 1.0,
) -> ControllerSettings:  # fmt: skip
    """Settings from modelling information alone, theta(0) = 0; with a model `design` is better.

    One input and output: the target has two poles exp(-1/15) and the NMP zeros, n_c = order + d_zu
    + 1, R_theta = (H u)^2 for the coefficients of past u and (H y)^2 for those of past y. Several:
    `zero_direction_target`, n_c = order + 2, 10 norm(H)^2 instead of H^2. RCAC controls a stable
    plant after 5 max(n_c, n_f) steps, at least 50, in which the signals that act on the plant fill
    the regressor.

    Parameters
    ----------
    information : ModellingInformation or DirectionInformation
        Of G_zu, which for e = r - y is minus that of the plant. Leave zeros inside the circle out,
        also those near -1.
    order : int
        Of the plant, without its dead time; if in doubt, larger.
    stable : bool
        Whether the plant is stable without control.
    u, y : float
        Size of the disturbance at the input, in units of u, and of its effect on y, in units of y:
        the loop is then the same in any units. Not needed for signals of size 1.

    Raises
    ------
    InputError
        If `information` is neither of the two classes, or a size is not positive.

    Notes
    -----
    Not safe: the guide has the share of good loops. No prior makes it safe: on 30 random plants
    R_theta of 1e-4, 1 and 1e4 times this ended stable and good (error below
    twice that of a fixed controller, peak below ten times) on 10, 30 and 33 %, `PriorSamples` of
    1e-4 to 100 samples on at most 13 %. With a log, `design(ControllerLog(u, y))` identifies a
    model.

    Examples
    --------
    >>> from rcac_numeric import ModellingInformation, cold_start
    >>> known = ModellingInformation(d_zu=3, H=-0.02, nmp_zeros=[1.5])
    >>> settings = cold_start(known, order=2, stable=True)
    >>> settings.structure.n_c, settings.k_w, settings.update.R_theta.diagonal().round(6)[[0, -1]]
    (6, 50, array([0.0004, 0.0004]))
    """
    integer(order, "order", at_least=1)
    instance_of(stable, "stable", bool)
    for name, size in (("u", u), ("y", y)):
        if not number(size, name) > 0:
            raise InputError(f"{name} = {size} must be positive: it is the size of a signal.")
    if isinstance(information, DirectionInformation):
        target = zero_direction_target(information)
        structure = iir(order + 2, target.l_u, target.l_z)
        weight = SEVERAL * float(np.linalg.norm(information.H, 2)) ** 2
    elif isinstance(information, ModellingInformation):
        pole = float(np.exp(-1 / POLES))
        target = pole_placement_target(information, [pole, pole])
        structure = iir(order + information.d_zu + 1)
        weight = SCALAR * float(target.numerator[target.relative_degree, 0, 0]) ** 2
    else:
        raise InputError(
            f"information = {information!r} must be ModellingInformation(d_zu, H, nmp_zeros), or "
            "DirectionInformation(H, zeros) for several signals; for a plant or a log call design."
        )
    sizes = [u if tap.signal == "u" else y for tap in structure.taps]
    R_theta = weight * np.diag(np.repeat(np.square(sizes), structure.l_u))
    filled = max(structure.n_c, target.n_f)
    k_w = max(WAITS * filled, LEAST_WAIT) if stable else filled
    return ControllerSettings(
        structure=structure, target=target, update=UD(R_theta=R_theta), k_w=k_w
    )
