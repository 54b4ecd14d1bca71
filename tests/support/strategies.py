"""Random plants, target models and controllers for the properties of the numeric half."""

import numpy as np
from hypothesis import strategies as st

from rcac_numeric import UD, ControllerSettings, Plant, TargetModel, fir, iir

sizes = st.integers(1, 3)
seeds = st.integers(0, 2**32 - 1)


@st.composite
def plants(draw, l_u=sizes, l_y=sizes, l_z=sizes, l_w=sizes, feedthrough=False):
    """A stable plant with the given numbers of signals, entries of order one."""
    rng = np.random.default_rng(draw(seeds))
    n, n_u, n_y = draw(st.integers(1, 4)), draw(l_u), draw(l_y)
    n_z, n_w = draw(l_z), draw(l_w)
    A = rng.standard_normal((n, n))
    A *= draw(st.floats(0.1, 0.9)) / max(np.abs(np.linalg.eigvals(A)).max(), 1e-3)
    return Plant(
        A=A,
        B=rng.standard_normal((n, n_u)),
        D_1=rng.standard_normal((n, n_w)),
        C=rng.standard_normal((n_y, n)),
        D_0=rng.standard_normal((n_y, n_u)) if feedthrough else None,
        D_2=rng.standard_normal((n_y, n_w)),
        E_1=rng.standard_normal((n_z, n)),
        E_2=rng.standard_normal((n_z, n_u)) if feedthrough else None,
        E_0=rng.standard_normal((n_z, n_w)),
    )


@st.composite
def targets(draw, l_z, l_u):
    """An IIR or FIR target model with stable poles."""
    rng = np.random.default_rng(draw(seeds))
    order = draw(st.integers(0, 3))
    numerator = rng.standard_normal((order + 1, l_z, l_u))
    denominator = np.zeros((order + 1, l_z, l_z))
    denominator[0] = np.eye(l_z)
    if draw(st.booleans()):
        denominator[1:] = rng.uniform(-0.3, 0.3, (order, l_z, l_z)) / l_z
    return TargetModel(numerator, denominator)


def starts(filled):
    """Control and update in any order, where one of them waits until the regressor is filled."""
    waits = st.fixed_dictionaries({"k_w": st.just(filled), "k_update": st.integers(0, filled + 2)})
    at_once = {"k_w": st.integers(0, filled), "k_update": st.just(filled)}
    return waits | st.fixed_dictionaries(at_once)


@st.composite
def controllers(draw, l_u, l_y, l_z, k_c=st.integers(0, 1)):
    """Settings with every weight, forgetting and any start-up."""
    rng = np.random.default_rng(draw(seeds))
    kind = draw(st.sampled_from([iir, fir]))
    structure = kind(draw(st.integers(1, 3)), l_u, l_y, k_c=draw(k_c))
    target = draw(targets(l_z, l_u))
    root = rng.standard_normal((l_z, l_z))
    k_w = max(structure.n_c, target.n_f) + draw(st.integers(0, 2))
    return ControllerSettings(
        structure=structure,
        target=target,
        update=UD(
            R_theta=draw(st.floats(0.5, 5)) * np.eye(structure.l_theta),
            lambda_=draw(st.sampled_from([1.0, 0.97, 0.9])),
        ),
        R_z=np.eye(l_z) + root @ root.T / 4,
        R_u=draw(st.sampled_from([0.0, 0.5])),
        **draw(starts(k_w)),
        k_filter=draw(st.sampled_from([0, 0, 1, k_w])),
        theta_0=0.1 * rng.standard_normal(structure.l_theta),
    )
