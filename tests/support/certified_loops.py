"""Loops that their theta_0 stabilises, for the tests of certified sets."""

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from rcac_numeric import UD, ControllerSettings, TargetModel, iir, standard_plant
from rcac_numeric.analysis._regressor_system import regressor_system
from tests.support.engine_cases import cases, engine_plants

WIDTHS = [(1, 1, 0), (2, 1, 1), (1, 2, 0), (2, 2, 1)]
PLANT = standard_plant("1/(q - 0.9)")


def first_order(**changed):
    """q = 0.9 with P_1 = 0.2 and Q_1 = -0.3, a loop at 0.55 +- 0.36j."""
    fields = {"structure": iir(1), "target": TargetModel([0, 1]), "update": UD(R_theta=100.0)}
    return ControllerSettings(**fields | {"theta_0": [0.2, -0.3]} | changed)


@st.composite
def loops(draw, radius=0.995):
    """(plant, settings) of a random structure, stable with theta_0."""
    l_u, l_y, l_r = draw(st.sampled_from(WIDTHS))
    chosen, _ = draw(cases(l_u, l_y, 1, l_r))
    plant = draw(engine_plants(l_u, l_y, 1, l_r))
    loop = regressor_system(plant, chosen.structure).loop_matrix(chosen.theta_0)
    assume(np.abs(np.linalg.eigvals(loop)).max() < radius)
    return plant, chosen
