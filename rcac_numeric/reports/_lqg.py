"""What is said of an LQG controller."""

from __future__ import annotations

import numpy as np

from rcac_numeric.analysis._lqg import LQG
from rcac_numeric.reports._sheet import Fact, Section, Sheet


def lqg_sheet(found: LQG) -> Sheet:
    """The cost with its evidence, how far the poles are inside, and the controller itself."""
    radii = {
        name: float(np.abs(part.poles).max(initial=0.0))
        for name, part in (("regulator", found.regulator), ("estimator", found.estimator))
    }
    own = found.spectral_radius
    facts = (
        Fact(
            "cost J", f"{found.cost.value:.6g}, by the Riccati solutions {found.cost_gap:.1e} off"
        ),
        *(Fact(f"{name}'s poles", f"radius {radius:.6g}") for name, radius in radii.items()),
        Fact("controller's poles", f"radius {own:.6g}", "plain" if own < 1 else "warning"),
    )
    record = {"cost": found.cost.value, "cost_gap": found.cost_gap, "controller_radius": own}
    record |= {f"{name}_radius": radius for name, radius in radii.items()}
    remark = f", {found.form} form, order {found.plant.n}"
    return Sheet("LQG", remark, sections=(Section("", facts, record),))
