"""The measures that hold a controller against the least H2 cost there is."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from compensator_theory.errors import UnitCircleError
from rcac_numeric.analysis import _costs as h2_costs
from rcac_numeric.analysis._closed_loop import ClosedLoop
from rcac_numeric.analysis._loop_analysis import LoopAnalysis
from rcac_numeric.analysis._lqg import LQG, lqg_controller
from rcac_numeric.analysis._noise import NoiseIntensities, noise_inputs
from rcac_numeric.arrays._validation import number
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.plants._linear import MATRICES, Plant

Key = tuple[tuple[str, tuple[int, ...], tuple[float, ...]], ...] | None


def h2_cost(r: LoopAnalysis, noise: NoiseIntensities | None = None, direct: bool = True) -> float:
    """Mean square of z with the final controller, for white noise w of these intensities.

    Parameters
    ----------
    noise : mapping, optional
        Intensities by block or channel of w, `{ d = 1, v = 0.25 }`; 1 for every channel where it
        is left out.
    direct : bool
        Whether what w adds to z directly, E_0 w, counts; (4.21) leaves it out.
    """
    return _reached(_counted(r.loop.plant, direct), r.loop.compensator, _key(noise))


def high_authority_cost(
    r: LoopAnalysis, noise: NoiseIntensities | None = None, direct: bool = True
) -> float:
    """H2 cost of LQG, the least of a strictly proper controller; high authority if R_2 = 0."""
    return _best(_counted(r.plant, direct), noise).cost.value


def cost_over_high_authority(
    r: LoopAnalysis, noise: NoiseIntensities | None = None, direct: bool = True
) -> float:
    """The H2 cost of the final controller over that of LQG; at least 1 if strictly proper."""
    return h2_cost(r, noise, direct) / high_authority_cost(r, noise, direct)


def high_authority_exists(r: LoopAnalysis, noise: NoiseIntensities | None = None) -> float:
    """1 where there is an LQG controller, 0 where one of its Riccati equations has no solution."""
    try:
        _best(r.plant, noise)
    except UnitCircleError:
        return 0.0
    return 1.0


def high_authority_pole_distance(
    r: LoopAnalysis, value: float, noise: NoiseIntensities | None = None
) -> float:
    """Distance from a real number to the nearest pole of the LQG controller.

    Parameters
    ----------
    value : float
        The number.
    """
    poles = np.linalg.eigvals(_best(r.plant, noise).state_space[0])
    return float(np.abs(poles - number(value, "value")).min())


def high_authority_response_distance(
    r: LoopAnalysis, noise: NoiseIntensities | None = None, response_from: str = ""
) -> float:
    """Median over frequency of the relative distance of abs(G_zw) to that of LQG.

    Parameters
    ----------
    response_from : str
        The block or channel of w whose response is compared; all noise where it is left out.
    """
    omega = (np.arange(1000) + 0.5) * np.pi / 1000
    inputs = {response_from: 1.0} if response_from else noise
    reached, best = (
        np.linalg.norm(_noise_response(loop, omega, inputs), axis=(1, 2))
        for loop in (r.loop, _best(r.plant, noise).loop)
    )
    return float(np.median(np.abs(reached - best) / best))


def _best(plant: Plant, noise: NoiseIntensities | None) -> LQG:
    return _designed(plant, _key(noise))


# One design serves all seeds of a run, and one cost all the claims on it.
@lru_cache(maxsize=16)
def _designed(plant: Plant, noise: Key) -> LQG:
    return lqg_controller(plant, noise=_intensities(noise))


@lru_cache(maxsize=64)
def _reached(plant: Plant, compensator: Compensator, noise: Key) -> float:
    return float(h2_costs.h2_cost(plant, compensator, noise=_intensities(noise)))


def _key(noise: NoiseIntensities | None) -> Key:
    """Intensities as a mapping."""
    if noise is None:
        return None
    values = {name: np.asarray(value, dtype=np.float64) for name, value in noise.items()}
    return tuple((name, value.shape, tuple(value.ravel())) for name, value in values.items())


def _intensities(noise: Key) -> NoiseIntensities | None:
    if noise is None:
        return None
    return {name: np.reshape(entries, shape) for name, shape, entries in noise}


def _counted(plant: Plant, direct: bool) -> Plant:
    """The plant, or one whose z holds nothing of w directly."""
    if direct:
        return plant
    matrices = {name: getattr(plant, name) for name in MATRICES}
    return Plant(**{**matrices, "E_0": 0 * plant.E_0}, blocks=plant.blocks)


def _noise_response(
    loop: ClosedLoop, omega: np.ndarray, noise: NoiseIntensities | None
) -> np.ndarray:
    return loop.frequency_response(omega) @ noise_inputs(loop.plant, noise).factor


COST_MEASURES = (
    h2_cost,
    high_authority_cost,
    cost_over_high_authority,
    high_authority_exists,
    high_authority_pole_distance,
    high_authority_response_distance,
)
