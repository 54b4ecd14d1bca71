"""The report of an LQG controller."""

from __future__ import annotations

import numpy as np

from rcac_numeric.analysis._lqg import LQG
from rcac_numeric.reports._sheet import Fact, Section, Sheet


def lqg_sheet(design: LQG) -> Sheet:
    """The cost with its evidence, and the radii of all poles."""
    radii = {
        name: float(np.abs(part.poles).max(initial=0.0))
        for name, part in (("regulator", design.regulator), ("estimator", design.estimator))
    }
    radius = design.spectral_radius
    facts = (
        Fact(
            "cost J",
            f"{design.cost.value:.6g}; relative difference to the Riccati solutions "
            "{design.cost_gap:.1e}",
        ),
        *(Fact(f"{name}'s poles", f"radius {radius:.6g}") for name, radius in radii.items()),
        Fact("controller's poles", f"radius {radius:.6g}", "plain" if radius < 1 else "warning"),
    )
    record = {"cost": design.cost.value, "cost_gap": design.cost_gap, "controller_radius": radius}
    record |= {f"{name}_radius": radius for name, radius in radii.items()}
    remark = f", {design.form} form, order {design.plant.n}"
    return Sheet("LQG", remark, sections=(Section("", facts, record),))
