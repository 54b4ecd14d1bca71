"""The plants with limited achievable margins of Examples 1.1, 5.5 and 5.6."""

from __future__ import annotations

from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants.gallery._continuous import ContinuousPlant


def no_guaranteed_margins() -> ContinuousPlant:
    """The plant (1.1)-(1.2): LQG guarantees it no margin.

    x' = [1 1; 0 1] x + [0; 1] u,  y = x_1 + x_2

    Notes
    -----
    Without units. Poles 1 and 1, zero 0. Source: [1] of the text, J. C. Doyle, Guaranteed margins
    for LQG regulators, IEEE Trans. Automatic Control 23 (1978). The disturbance enters by
    D_1 = [1; 1], not with u; `no_guaranteed_margins_standard` has it.

    Errata: the text calls the plant minimum phase; its zero is at 0, on the boundary, and at 1 to
    all digits when it is sampled.

    Examples
    --------
    >>> from rcac_numeric.gallery import no_guaranteed_margins
    >>> no_guaranteed_margins().zeros(), no_guaranteed_margins().poles()
    (array([0.+0.j]), array([1.+0.j, 1.+0.j]))
    """
    return ContinuousPlant(A=[[1, 1], [0, 1]], B=[[0], [1]], C=[[1, 1]])


def no_guaranteed_margins_standard(h: float = 0.01) -> Plant:
    """The standard problem of (1.1)-(1.2), sampled; section 5.5 has h = 0.01 s.

    D_1 = [1 0; 1 0],  D_2 = [0 1]: w_1 drives the states as in (1.1), w_2 is the sensor noise.

    Parameters
    ----------
    h : float
        Sampling period, s.

    Notes
    -----
    D_1 is that of (1.1), sampled with a zero-order hold on w_1. (1.2) prints D_2 = 1 beside one
    column of D_1, so that one noise would be both; Doyle's two are independent, as here.

    Examples
    --------
    >>> from rcac_numeric.gallery import no_guaranteed_margins_standard
    >>> no_guaranteed_margins_standard()
    Plant(n=2, l_u=1, l_w=2, l_y=1, l_z=1)
    """
    continuous = no_guaranteed_margins()
    both = ContinuousPlant(continuous.A, [[0, 1], [1, 1]], continuous.C).sampled(h)
    return Plant(
        A=both.A, B=both.B[:, :1], D_1=[[both.B[0, 1], 0], [both.B[1, 1], 0]], C=both.C,
        D_2=[[0, 1]], blocks={"process": 1, "sensor": 1},
    )  # fmt: skip


def limited_delay_margin() -> ContinuousPlant:
    """The plant (1.3)-(1.4), whose delay margin is at most 18.51 s for every controller.

    Notes
    -----
    Without units but for time, in s. Its unstable pole p = 0.1081 is real, and no delay margin
    exceeds 2/p = 18.508 s. Source: [2] of the text;
    section 5.6 samples it at 0.1 s.

    Examples
    --------
    >>> from rcac_numeric.gallery import limited_delay_margin
    >>> round(float(max(limited_delay_margin().poles().real)), 4)
    0.1081
    """
    return ContinuousPlant(
        A=[[-0.08, -0.03, 0.2], [0.2, -0.04, -0.005], [-0.06, 0.2, -0.07]],
        B=[[-0.1], [-0.2], [0.1]],
        C=[[0, -1, 0]],
    )
