"""The analyses that a check is made of, each as far as the inputs allow."""

from __future__ import annotations

from typing import Any

import numpy as np

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.analysis.closed_loop import ClosedLoop
from rcac_numeric.analysis.exact_comparison import compare_exactly
from rcac_numeric.analysis.match import intercalated_match
from rcac_numeric.analysis.residual_split import split_residual
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.checks.logs import ControllerLog
from rcac_numeric.checks.replays import require_fit
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.controllers.structure import Structure
from rcac_numeric.margins.classical import Margins, stability_margins
from rcac_numeric.margins.disk import DiskMargin, multivariable_disk_margin
from rcac_numeric.plants.frozen import measuring_command
from rcac_numeric.plants.linear import Plant
from rcac_numeric.targets.model import TargetModel


def fixed_compensator(
    log: ControllerLog, structure: Structure | None, compensator: Compensator | None
) -> Compensator:
    """The controller at the end of the log."""
    if compensator is not None:
        return compensator
    if log.theta_final is not None and structure is not None:
        require_fit(log, structure)
        return structure.compensator(log.theta_final)
    if log.D_c is not None and log.N_c is not None:
        return _from_polynomials(log)
    what = "theta needs the structure it belongs to" if log.theta is not None else "no theta"
    raise InputError(
        f"{log.source}: {what}; give theta with a structure such as iir(n_c=4), D_c and N_c, or a "
        "Compensator."
    )


def _from_polynomials(log: ControllerLog) -> Compensator:
    D_c, N_c = np.trim_zeros(log.D_c, "f"), np.trim_zeros(log.N_c, "f")
    if not len(D_c) or len(N_c) > len(D_c):
        raise InputError(
            f"{log.source}: D_c has degree {len(D_c) - 1} and N_c degree {len(N_c) - 1}; the "
            "controller would use future values, or is none."
        )
    N_c = np.concatenate([np.zeros(len(D_c) - len(N_c)), N_c]) / D_c[0]
    return Compensator((-D_c[1:] / D_c[0])[:, None, None], N_c[:, None, None])


def with_plant(
    log: ControllerLog,
    fixed: Compensator,
    plant: Plant,
    target: TargetModel | None,
    unsaid: dict[str, str],
) -> dict[str, Any]:
    """Poles, zeros, comparison, match and split, as far as the inputs allow."""
    for name in ("u", "y", "z", "w"):
        signal, width = getattr(log, name), getattr(plant, f"l_{name}")
        if signal is not None and signal.shape[1] != width:
            raise InputError(
                f"{log.source}: {name} has {signal.shape[1]} components; the plant has l_{name} = "
                f"{width}."
            )
    y = log.y
    if fixed.l_y > plant.l_y:
        plant = measuring_command(plant)
        y = log.y if log.r is None else np.hstack([log.y, log.r])
    loop = ClosedLoop(plant, fixed)
    known: dict[str, Any] = {"loop": loop}
    if target is None:
        for name in ("target", "match", "split"):
            unsaid[name] = "the target model is not known"
    else:
        known |= _against_target(log, loop, target, y, unsaid)
    comparison = known.get("comparison")
    if comparison is not None:
        known["zeros"] = comparison.zeros
    elif plant.l_z == 1:
        known["zeros"] = loop.zeros()
    else:
        unsaid["zeros"] = f"they are for one z, and the plant has l_z = {plant.l_z}"
    return known


def _against_target(
    log: ControllerLog, loop: ClosedLoop, target: TargetModel, y: Array, unsaid: dict[str, str]
) -> dict[str, Any]:
    plant, fixed = loop.plant, loop.compensator
    known: dict[str, Any] = {}
    try:
        known["comparison"] = compare_exactly(plant, fixed, target)
    except CompensatorError as error:
        unsaid["exact poles"] = str(error).rstrip(".")
    try:
        known["match"] = intercalated_match(loop, target)
    except (CompensatorError, ValueError) as error:
        unsaid["match"] = str(error).rstrip(".")
    if log.w is None:
        unsaid["split"] = "the exogenous input w was not logged"
    elif log.z is None:
        unsaid["split"] = "the performance z was not logged"
    else:
        try:
            known["split"] = split_residual(plant, fixed, target, u=log.u, y=y, z=log.z, w=log.w)
        except CompensatorError as error:
            unsaid["split"] = str(error).rstrip(".")
    return known


def channel_margins(
    loop: ClosedLoop, sample_time: float | None, unsaid: dict[str, str]
) -> tuple[dict[str, Margins], DiskMargin | None]:
    """The margins at each component of u, and of several components at once."""
    found = {}
    for i in range(loop.plant.l_u):
        name = "u" if loop.plant.l_u == 1 else f"u{i + 1}"
        try:
            found[name] = stability_margins(loop, channel=i, sample_time=sample_time)
        except CompensatorError as error:
            unsaid[f"margins at {name}"] = str(error).rstrip(".")
    if loop.plant.l_u > 1 and loop.is_stable:
        return found, multivariable_disk_margin(loop)
    return found, None
