"""Sampling zeros near -1 that a target model has the controller cancel, and their mend."""

from __future__ import annotations

import numpy as np

from rcac_numeric.health.target_errors import TURNED, zeros_of
from rcac_numeric.plants.linear import Plant
from rcac_numeric.targets.model import TargetModel

RINGING = 0.9  # a cancelled zero of this modulus or more rings for tens of steps


def sampling_zero_mends(plant: Plant, target: TargetModel) -> tuple[str, ...]:
    """What to try where G_f asks for the cancellation of a zero of G_zu in (-1, -0.9].

    The controller pole that cancels it rings at half the sampling frequency, and a larger R_theta
    may make that worse: abs u from 2e4 to 9e4 for a second-order lag sampled at 10 Hz. Zeros
    elsewhere near the circle are left alone: telling those near 1 or near j made u larger
    wherever it was tried.

    Examples
    --------
    >>> from rcac_numeric import TargetModel, standard_plant
    >>> from rcac_numeric.health.sampling_zeros import sampling_zero_mends
    >>> plant = standard_plant("(q + 0.92)/((q - 0.8)*(q - 0.9))")
    >>> sampling_zero_mends(plant, TargetModel([0.0, 1.0]))[0][:55]
    'the zero -0.92 of the plant told as one on the unit cir'
    >>> sampling_zero_mends(plant, TargetModel([0.0, 1.0, 1.0]))  # told as -1
    ()
    """
    if (plant.l_u, plant.l_z, target.l_u, target.l_z) != (1, 1, 1, 1):
        return ()
    zeros = zeros_of(plant)
    real = zeros.real[np.abs(zeros.imag) < TURNED]
    near = np.sort(real[(real >= -1 - TURNED) & (real <= -RINGING)])
    modelled = np.roots(target.numerator[target.relative_degree :, 0, 0])
    told = int((np.abs(modelled + 1) <= 1 - RINGING + TURNED).sum())
    left = [f"{zero:.4g}" for zero in near[told:]]
    if not left:
        return ()
    words, on_circle = ", ".join(left), ", ".join(["-1"] * len(left))
    many, those = ("zeros", "ones") if len(left) > 1 else ("zero", "one")
    return (
        f"the {many} {words} of the plant told as {those} on the unit circle, nmp_zeros with "
        f"{on_circle}: with this G_f the controller cancels what rings, and a larger R_theta may "
        "make that worse",
    )
