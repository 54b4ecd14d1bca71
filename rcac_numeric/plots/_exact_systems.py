"""Exact systems: step response, Bode's plot, Nyquist's curve, poles and zeros."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from compensator_theory import DelayedTransferFunction, stability_margins, step_response
from compensator_theory.errors import CompensatorError, InputError
from compensator_theory.polynomials._poly import is_rational
from compensator_theory.results import TimeResponse
from compensator_theory.roots._certified import Root, certified_roots
from compensator_theory.systems._transfer_functions import TransferFunction
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.plots._library import Axes, Figure
from rcac_numeric.plots._margins import LoopCurve, draw_bode, draw_nyquist, exact_curve
from rcac_numeric.plots._style import (
    INK,
    NARROW,
    QUIET,
    REACHED,
    REQUESTED,
    SECOND,
    axes_of,
    checked_width,
    draw_circle,
    figure_of,
    tidy,
)

POINTS = 600
GROWTH = 20.0  # times the size at the start: where the picture of an unstable response ends
VIEWS = {"all": 5, "step": 1, "bode": 2, "nyquist": 1, "poles": 1}


def plot_time_response(
    response: TimeResponse,
    until: float | None = None,
    *,
    ax: Axes | None = None,
    width: float = 6.0,
) -> Figure:
    """Draw a response in time, as `TimeResponse.plot` says."""
    if ax is not None:
        (axis,) = axes_of(ax, 1)
        draw_response(axis, response, until)
        return figure_of(axis)
    width = checked_width(width)
    figure = Figure(figsize=(width, 0.6 * width), layout="constrained")
    draw_response(figure.subplots(), response, until)
    tidy(figure)
    return figure


def plot_system(
    G: TransferFunction | DelayedTransferFunction,
    view: str = "all",
    *,
    ax: Axes | Sequence[Axes] | None = None,
    width: float = 11.0,
) -> Figure:
    """Draw one view of a system, or all, as `TransferFunction.plot` says."""
    if view not in VIEWS:
        raise InputError(f"view = {view!r} is none of {', '.join(VIEWS)}.")
    rational = _rational_part(G)
    if not (
        is_rational(rational.numerator)
        and is_rational(rational.denominator)
        and (isinstance(G, TransferFunction) or G.delay.is_Rational)
    ):
        raise InputError(f"{G} has symbols or irrational coefficients; give values by subs(...).")
    if ax is not None:
        axes = axes_of(ax, VIEWS[view])
        _draw(axes, view, G)
        return figure_of(axes[0])
    width = checked_width(width)
    narrow = width < NARROW
    if view == "all":
        figure = Figure(figsize=(width, 2.9 * width if narrow else 8.0), layout="constrained")
        grid = figure.add_gridspec(5 if narrow else 4, 1 if narrow else 2)
        places = [grid[k, 0] for k in range(5)] if narrow else [
            grid[:2, 0], grid[2, 0], grid[3, 0], grid[2:, 1], grid[:2, 1]
        ]  # fmt: skip
        axes = [figure.add_subplot(place) for place in places]
    else:
        width = min(width, 6.0)
        figure = Figure(figsize=(width, 0.8 * width), layout="constrained")
        axes = list(np.ravel(figure.subplots(VIEWS[view], 1, sharex=True)))
    _draw(axes, view, G)
    tidy(figure)
    return figure


def _rational_part(G: TransferFunction | DelayedTransferFunction) -> TransferFunction:
    return G.rational if isinstance(G, DelayedTransferFunction) else G


def _draw(axes: list[Axes], view: str, G: TransferFunction | DelayedTransferFunction) -> None:
    if view in ("step", "all"):
        draw_response(axes[0], step_response(G), None)
    if view in ("bode", "nyquist", "all"):
        curve = _curve_of(G)
        if view != "nyquist":
            draw_bode(axes[-4 if view == "all" else 0], axes[-3 if view == "all" else 1], curve)
        if view != "bode":
            draw_nyquist(axes[-2 if view == "all" else 0], curve)
    if view in ("poles", "all"):
        draw_poles_and_zeros(axes[-1], _rational_part(G))


def draw_response(axis: Axes, response: TimeResponse, until: float | None) -> None:
    """Draw a response, its final value, and where it settles within 2 %."""
    evaluate = _values_of(response)
    try:
        final = float(response.final_value)
        settled = float(response.settling_time())
    except CompensatorError:
        final, settled = None, None
    end = _horizon(response, settled, evaluate) if until is None else float(until)
    if not end > 0:
        raise InputError(f"until = {until!r} must be a positive time.")
    title = f"$y({response.time})$"
    if response.is_discrete:
        steps = np.arange(int(np.ceil(end)) + 1)
        axis.plot(steps, evaluate(steps), "o", ms=3.5, color=REACHED)
        axis.vlines(steps, 0, evaluate(steps), color=REACHED, linewidth=0.7)
    else:
        times = np.linspace(0, end, POINTS)
        axis.plot(times, evaluate(times), color=REACHED, linewidth=1.4)
    axis.axhline(0, color=INK, linewidth=0.5)
    if final is not None and settled is not None:
        axis.axhline(final, color=QUIET, linewidth=0.8, linestyle="--")
        axis.axhspan(0.98 * final, 1.02 * final, color=SECOND, alpha=0.15, linewidth=0)
        overshoot = float(response.overshoot())
        if settled <= end:
            axis.axvline(settled, color=SECOND, linewidth=0.9)
        unit = "steps" if response.is_discrete else "s"
        title += f": settles in {settled:.3g} {unit}, overshoot {100 * overshoot:.3g} %"
    axis.set(xlabel=f"{'step' if response.is_discrete else 'time'} ${response.time}$")
    axis.set_title(title, fontsize=10)


def draw_poles_and_zeros(axis: Axes, G: TransferFunction) -> None:
    """Draw the exact poles and zeros, multiplicities beside them, and the edge of stability."""
    groups = [(G.poles(), "x", REQUESTED, "poles")]
    if G.numerator.degree() > 0:
        groups.append((G.zeros(), "o", REACHED, "zeros"))
    for roots, marker, colour, label in groups:
        points = np.array([root.value for root in roots], dtype=complex)
        axis.plot(points.real, points.imag, marker, mfc="none", mec=colour, ms=8, mew=1.6,
                  linestyle="none", label=label)  # fmt: skip
        for root in roots:
            if root.multiplicity > 1:
                axis.annotate(f"{root.multiplicity}", (root.value.real, root.value.imag), (6, 5),
                              textcoords="offset points", fontsize=8, color=colour)  # fmt: skip
    if G.time == "discrete":
        draw_circle(axis)
    else:
        axis.axvline(0, color=INK, linewidth=0.7)
    axis.axhline(0, color=QUIET, linewidth=0.5)
    axis.set_aspect("equal", adjustable="datalim")
    axis.margins(0.25)
    axis.grid(alpha=0.25)
    axis.legend(fontsize=8, frameon=False)
    axis.set(xlabel="real", ylabel="imaginary")
    axis.set_title("poles and zeros", fontsize=10)


def _curve_of(G: TransferFunction | DelayedTransferFunction) -> LoopCurve:
    """The frequency response, with the margins of the loop closed by negative feedback."""
    return exact_curve(stability_margins(G, feedback=-1))


def _values_of(response: TimeResponse) -> Callable[[Any], Array]:
    """Return the response in float64, by its poles."""
    terms = []
    for mode in response.terms:
        if not all(map(is_rational, (mode.factor, *mode.coefficients))):
            raise InputError(
                "the response has symbols or irrational coefficients; give values by subs(...)."
            )
        roots: tuple[Root, ...] = certified_roots(mode.factor)
        for root in roots:
            values = [
                np.polyval([float(c) for c in c_j.all_coeffs()], root.value)
                for c_j in mode.coefficients
            ]
            terms.append((root.value, values))

    late = float(response.delay)

    def evaluate(times: Any) -> Array:
        t = np.maximum(np.asarray(times, dtype=float) - late, 0.0)
        total = np.zeros(t.shape, dtype=complex)
        for root, values in terms:
            binomial = np.ones_like(t)
            for j, c in enumerate(values):
                if response.is_discrete:
                    with np.errstate(all="ignore"):
                        power = np.where(t >= j, np.power(root, np.maximum(t - j, 0)), 0)
                    total += c * binomial * power
                    binomial = binomial * (t - j) / (j + 1)
                else:
                    total += c * binomial * np.exp(root * t)
                    binomial = binomial * t / (j + 1)
        return np.where(np.asarray(times) < late, 0.0, total.real)

    return evaluate


def _horizon(
    response: TimeResponse, settled: float | None, evaluate: Callable[[Any], Array]
) -> float:
    """Return where the picture ends: 1.5 settling times, some periods, or growth by 20."""
    roots = [root.value for mode in response.terms for root in certified_roots(mode.factor)]
    if response.is_discrete:
        if settled is not None:
            return max(10.0, 1.5 * settled)
        size = max([abs(root) for root in roots], default=0.0)
        return float(np.clip(np.log(GROWTH) / np.log(size), 10, 60)) if size > 1 else 40.0
    if settled:
        return 1.5 * settled
    rates = [abs(root) for root in roots if abs(root) > 1e-12]
    growth = max([root.real for root in roots], default=0.0)
    late = float(response.delay)
    if growth > 1e-9:
        return late + float(np.log(GROWTH) / growth)
    return late + 10 / min(rates) if rates else late + 1.0
