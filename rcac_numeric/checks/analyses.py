"""The analyses that a check is made of, each as far as the inputs allow."""

from __future__ import annotations

from functools import partial

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.analysis.closed_loop import ClosedLoop
from rcac_numeric.checks.logs import ControllerLog
from rcac_numeric.checks.regressor import require_fit
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.controllers.structure import Structure
from rcac_numeric.experiments.measures.loop_analysis import attempted
from rcac_numeric.margins.classical import Margins, stability_margins
from rcac_numeric.plants.linear import Plant


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


def require_widths(log: ControllerLog, plant: Plant) -> None:
    """Refuse a log whose signals are not as wide as those of the plant."""
    for name in ("u", "y", "z", "w"):
        signal, width = getattr(log, name), getattr(plant, f"l_{name}")
        if signal is not None and signal.shape[1] != width:
            raise InputError(
                f"{log.source}: {name} has {signal.shape[1]} components; the plant has l_{name} = "
                f"{width}."
            )


def channel_margins(
    loop: ClosedLoop, sample_time: float | None = None, *, disk: bool = True
) -> tuple[dict[str, Margins], dict[str, str]]:
    """The margins at each component of u, and why there are none at the others.

    Of time the plant's own sample time is taken where none is given.
    """
    sample_time = loop.plant.sample_time if sample_time is None else sample_time
    found, reasons = {}, {}
    for i in range(loop.plant.l_u):
        name = "u" if loop.plant.l_u == 1 else f"u{i + 1}"
        margins, reason = attempted(
            partial(stability_margins, loop, channel=i, sample_time=sample_time, disk=disk)
        )
        if margins is None:
            reasons[f"margins at {name}"] = reason
        else:
            found[name] = margins
    return found, reasons
