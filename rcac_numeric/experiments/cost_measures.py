"""The measures that hold a controller against the least H2 cost there is."""

from __future__ import annotations

import numpy as np

from rcac_numeric.analysis.closed_loop import ClosedLoop
from rcac_numeric.arrays.validation import number
from rcac_numeric.experiments.analysed_run import AnalysedRun
from rcac_numeric.h2 import costs as h2_costs
from rcac_numeric.h2.lqg import lqg
from rcac_numeric.h2.noise import NoiseIntensities, noise_inputs


def h2_cost(r: AnalysedRun, noise: NoiseIntensities | None = None) -> float:
    """Mean square of z with the final controller, for white noise w of these intensities.

    Parameters
    ----------
    noise : mapping, optional
        Intensities by block or channel of w, `{ d = 1, v = 0.25 }`; 1 for every channel where it
        is left out.
    """
    return float(h2_costs.h2_cost(r.loop.plant, r.loop.compensator, noise=noise))


def high_authority_cost(r: AnalysedRun, noise: NoiseIntensities | None = None) -> float:
    """The same with LQG, the least of a strictly proper controller; high authority if R_2 = 0."""
    return lqg(r.plant, noise=noise).cost.value


def cost_over_high_authority(r: AnalysedRun, noise: NoiseIntensities | None = None) -> float:
    """The H2 cost of the final controller over that of LQG; at least 1 if strictly proper."""
    return h2_cost(r, noise) / high_authority_cost(r, noise)


def high_authority_pole_distance(
    r: AnalysedRun, value: float, noise: NoiseIntensities | None = None
) -> float:
    """Distance from a real number to the nearest pole of the LQG controller.

    Parameters
    ----------
    value : float
        The number.
    """
    poles = np.linalg.eigvals(lqg(r.plant, noise=noise).state_space[0])
    return float(np.abs(poles - number(value, "value")).min())


def high_authority_response_distance(
    r: AnalysedRun, noise: NoiseIntensities | None = None
) -> float:
    """Median over frequency of the relative distance of abs(G_zw) to that of LQG."""
    omega = (np.arange(1000) + 0.5) * np.pi / 1000
    reached, best = (
        np.linalg.norm(_noise_response(loop, omega, noise), axis=(1, 2))
        for loop in (r.loop, lqg(r.plant, noise=noise).loop)
    )
    return float(np.median(np.abs(reached - best) / best))


def _noise_response(
    loop: ClosedLoop, omega: np.ndarray, noise: NoiseIntensities | None
) -> np.ndarray:
    return loop.frequency_response(omega) @ noise_inputs(loop.plant, noise).factor


COST_MEASURES = (
    h2_cost,
    high_authority_cost,
    cost_over_high_authority,
    high_authority_pole_distance,
    high_authority_response_distance,
)
