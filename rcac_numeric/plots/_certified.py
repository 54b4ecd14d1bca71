"""A certified set: the interval of each coefficient, and the radius over the decay rate."""

from __future__ import annotations

import numpy as np

from rcac_numeric.analysis._certified_set import CertifiedSet
from rcac_numeric.plots._library import Figure
from rcac_numeric.plots._style import INK, NARROW, REACHED, checked_width, tidy

RATES = 24  # decay rates of the curve


def plot_certified_set(region: CertifiedSet, *, width: float = 9.0) -> Figure:
    """The picture that `CertifiedSet.plot` describes."""
    width = checked_width(width)
    narrow = width < NARROW
    figure = Figure(figsize=(width, 7.0 if narrow else 3.6), layout="constrained")
    left, right = figure.subplots(2, 1) if narrow else figure.subplots(1, 2)
    intervals = region.intervals()
    ends, places = np.array(list(intervals.values())), np.arange(len(intervals))
    left.vlines(places, ends[:, 0], ends[:, 1], color=REACHED, linewidth=4, alpha=0.5)
    left.plot(places, region.center, "o", color=INK, ms=3, label=r"$\theta_0$")
    left.axhline(0, color=INK, linewidth=0.5)
    step = -(-len(places) // 16)
    left.set_xticks(places[::step], list(intervals)[::step], rotation=90, fontsize=8)
    left.set(xlabel="coefficient", ylabel="theta, without units")
    left.set_title("interval of each coefficient", fontsize=10)
    left.legend(fontsize=8, frameon=False)
    rates = np.linspace(min(max(region.spectral_radius, 0.01), region.rate), 1.0, RATES)
    shares = region.decay(rates.tolist())
    right.plot(list(shares), list(shares.values()), color=REACHED, linewidth=1.4)
    right.set(xlabel="decay rate of x(k)", ylabel="share of the radius", ylim=(0, None))
    right.set_title("radius that has the decay rate", fontsize=10)
    tidy(figure)
    return figure
