"""The analyses that a check is made of, each as far as the inputs allow."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.analysis.closed_loop import ClosedLoop
from rcac_numeric.analysis.loop_analysis import LoopAnalysis, attempted
from rcac_numeric.checks.logs import ControllerLog
from rcac_numeric.checks.regressor import require_fit
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.controllers.structure import Structure
from rcac_numeric.margins.classical import Margins, stability_margins
from rcac_numeric.margins.disk import DiskMargin, multivariable_disk_margin
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
    assert log.D_c is not None and log.N_c is not None
    D_c, N_c = np.trim_zeros(log.D_c, "f"), np.trim_zeros(log.N_c, "f")
    if not len(D_c) or len(N_c) > len(D_c):
        raise InputError(
            f"{log.source}: D_c has degree {len(D_c) - 1} and N_c degree {len(N_c) - 1}; the "
            "controller would use future values, or is none."
        )
    with np.errstate(over="ignore"):
        N_c = np.concatenate([np.zeros(len(D_c) - len(N_c)), N_c]) / D_c[0]
        D_c = D_c / D_c[0]
    if not (np.isfinite(D_c).all() and np.isfinite(N_c).all()):
        raise InputError(
            f"{log.source}: the leading coefficient of D_c is so small that D_c and N_c divided by "
            "it leave float64; scale both."
        )
    return Compensator((-D_c[1:])[:, None, None], N_c[:, None, None])


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
    analysis = LoopAnalysis(plant, fixed, target)
    known: dict[str, Any] = {"loop": analysis.loop}
    if target is None:
        for name in ("target", "match", "split"):
            unsaid[name] = "the target model is not known"
    else:
        known |= _against_target(log, analysis, unsaid)
    if known.get("comparison") is not None or plant.l_z == 1:
        known["zeros"] = analysis.zeros
    else:
        unsaid["zeros"] = f"they are for one z, and the plant has l_z = {plant.l_z}"
    return known


def _against_target(
    log: ControllerLog, analysis: LoopAnalysis, unsaid: dict[str, str]
) -> dict[str, Any]:
    asked: dict[str, Any] = {
        "comparison": lambda: analysis.comparison,
        "match": lambda: analysis.match,
    }
    if log.w is None:
        unsaid["split"] = "the exogenous input w was not logged"
    elif log.z is None:
        unsaid["split"] = "the performance z was not logged"
    else:
        u, y, z, w, r = log.u, log.y, log.z, log.w, log.r
        asked["split"] = lambda: analysis.split(u=u, y=y, z=z, w=w, r=r)
    known = {}
    for name, ask in asked.items():
        known[name], reason = attempted(ask)
        if reason:
            unsaid["exact poles" if name == "comparison" else name] = reason
    return known


def channel_margins(
    loop: ClosedLoop, sample_time: float | None, unsaid: dict[str, str], *, disk: bool = True
) -> tuple[dict[str, Margins], DiskMargin | None]:
    """The margins at each component of u, and of several components at once.

    Of time the plant's own sample time is taken where none is given.
    """
    sample_time = loop.plant.sample_time if sample_time is None else sample_time
    found = {}
    for i in range(loop.plant.l_u):
        name = "u" if loop.plant.l_u == 1 else f"u{i + 1}"
        margins, reason = attempted(
            partial(stability_margins, loop, channel=i, sample_time=sample_time, disk=disk)
        )
        if margins is None:
            unsaid[f"margins at {name}"] = reason
        else:
            found[name] = margins
    if disk and loop.plant.l_u > 1 and loop.is_stable:
        return found, multivariable_disk_margin(loop)
    return found, None
