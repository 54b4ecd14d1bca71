"""Random plants that switch, ramp, map their state and delay their input."""

import numpy as np
from hypothesis import strategies as st

from rcac_numeric import PlantChange, PlantSchedule
from tests.support.engine_cases import engine_plants
from tests.support.strategies import seeds


@st.composite
def schedules(draw, l_u, l_y, l_z):
    """Switches, ramps, mapped states of other orders, and input delays."""
    rng = np.random.default_rng(draw(seeds))
    first = draw(engine_plants(l_u, l_y, l_z))
    changes = [PlantChange(start=0, plant=first, delay=draw(st.integers(0, 2)))]
    for _ in range(draw(st.integers(1, 3))):
        before = changes[-1]
        n = before.plant.n
        kind = draw(st.sampled_from(["switch", "ramp", "map"]))
        after = draw(engine_plants(l_u, l_y, l_z, n=None if kind == "map" else n))
        if kind == "ramp":
            changes[-1] = PlantChange(
                start=before.start, plant=before.plant, ramp=True, state_map=before.state_map,
                delay=before.delay,
            )  # fmt: skip
        changes.append(
            PlantChange(
                start=before.start + draw(st.integers(1, 6)),
                plant=after,
                state_map=rng.standard_normal((after.n, n)) if kind == "map" else None,
                delay=draw(st.integers(0, 3)),
            )
        )
    return PlantSchedule(changes)
