"""The figure of an exact stability region of two gains."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import sympy

import compensator_theory as exact
from compensator_theory.errors import InputError
from compensator_theory.results import StabilityIntervals
from rcac_numeric.arrays._validation import instance_of
from rcac_numeric.plots._library import Axes, Figure
from rcac_numeric.plots._style import INK, REACHED

COLUMNS = 25
"""Values of the first gain in each slab at which the exact ends of the intervals are drawn."""


def plot_stability_region(
    region: exact.results.StabilityRegion, first: tuple[float, float], second: tuple[float, float]
) -> Figure:
    """Shade the pairs of gains for which all roots are stable.

    Parameters
    ----------
    region : StabilityRegion
        From ``compensator_theory.stability_region``.
    first, second : tuple of float
        The ranges to show, of the first and of the second gain.

    Returns
    -------
    matplotlib.figure.Figure
        Each slab of the exact decomposition is drawn by itself, so that no isolated part and no
        cusp is missed; the ends of the intervals in it are exact at 25 values and straight
        between. Not attached to a window; ``figure.savefig("region.pdf")`` writes it.

    Raises
    ------
    InputError
        If a range is no pair of finite numbers in ascending order, or there are more parameters.

    Examples
    --------
    >>> from compensator_theory import stability_region
    >>> from rcac_numeric.plots import plot_stability_region
    >>> region = stability_region("s*(s + 1)**3 + k_p*s + k_i", "k_p", "k_i")
    >>> figure = plot_stability_region(region, (-2, 9), (0, 3))
    >>> len(figure.axes[0].collections), figure.axes[0].get_xlabel()
    (1, '$k_{p}$')
    """
    region = instance_of(region, "a stability region", exact.results.StabilityRegion)
    if len(region.parameters) > 2:
        raise InputError(
            f"the parameters are {', '.join(map(str, region.parameters))}; draw a section "
            f"of it, region.section(value of {region.parameters[0]}), down to two."
        )
    low, high = _range(first, "first")
    bottom, top = _range(second, "second")
    figure = Figure(figsize=(6, 4.5), layout="constrained")
    axis = figure.subplots()
    for slab in region.slabs:
        if not slab.is_empty:
            left, right = max(low, float(slab.lower)), min(high, float(slab.upper))
            if left < right:
                _draw_slab(axis, region, (left, right), (bottom, top))
    axis.set_xlim(low, high)
    axis.set_ylim(bottom, top)
    horizontal, vertical = (f"${sympy.latex(parameter)}$" for parameter in region.parameters)
    axis.set_xlabel(horizontal)
    axis.set_ylabel(vertical)
    axis.grid(alpha=0.25)
    axis.spines[["top", "right"]].set_visible(False)
    return figure


def _draw_slab(
    axis: Axes,
    region: exact.results.StabilityRegion,
    across: tuple[float, float],
    shown: tuple[float, float],
) -> None:
    """Fill between the ends of each interval of a slab."""
    margin = (across[1] - across[0]) * 1e-6
    places = np.linspace(across[0] + margin, across[1] - margin, COLUMNS)
    sections = (region.section(Fraction(float(place))) for place in places)
    columns = [one.intervals for one in sections if isinstance(one, StabilityIntervals)]
    for ends in zip(*columns, strict=True):
        lower = [max(float(cell.lower), shown[0]) for cell in ends]
        upper = [min(float(cell.upper), shown[1]) for cell in ends]
        visible = np.array(lower) < np.array(upper)
        axis.fill_between(places, lower, upper, where=list(visible), color=REACHED, alpha=0.3,
                          edgecolor=INK, linewidth=0.8)  # fmt: skip


def _range(pair: tuple[float, float], name: str) -> tuple[float, float]:
    try:
        low, high = (float(end) for end in pair)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} = {pair!r} is no range; give (lowest, highest).") from error
    if not (np.isfinite([low, high]).all() and low < high):
        raise InputError(f"{name} = {pair!r} must be two finite numbers in ascending order.")
    return low, high
