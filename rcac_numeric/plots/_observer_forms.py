"""The figure of observer-based forms: how each divides the closed-loop roots."""

from __future__ import annotations

import numpy as np

from rcac_numeric.analysis._observer_forms import NumericObserverForms
from rcac_numeric.plots._library import Figure
from rcac_numeric.plots._style import INK, draw_circle, line_style

MANY = 40  # forms that have a row each


def plot_observer_forms(forms: NumericObserverForms) -> Figure:
    """Plot the roots, with the best conditioned regulator circled, and cond(T) of each form."""
    figure = Figure(figsize=(10, 4.4), layout="constrained")
    roots, worth = figure.subplots(1, 2)
    everything = np.unique(np.round(np.concatenate(
        [forms.regulator_roots.ravel(), forms.observer_roots.ravel()]), 9))  # fmt: skip
    if forms.plant.variable.name in ("z", "q"):
        draw_circle(roots)
        roots.set_aspect("equal")
    else:
        roots.axvline(0, color=INK, linewidth=0.7)
    roots.plot(everything.real, everything.imag, "x", color=line_style(0)["color"], ms=9, mew=1.8)
    height = max(1.2 * float(np.abs(everything.imag).max(initial=0.0)), 1.0)
    roots.set(xlabel="real", ylabel="imaginary", ylim=(-height, height))
    roots.set_title("closed-loop roots", fontsize=10)
    worth.set(xlabel="form", ylabel="condition number of $T$")
    worth.set_title(f"{len(forms)} observer-based forms", fontsize=10)
    if len(forms):
        number = np.arange(1, len(forms) + 1)
        worth.semilogy(number, forms.condition, "o" if len(forms) <= MANY else ".",
                       color=line_style(1)["color"])  # fmt: skip
        best = int(np.argmin(forms.condition))
        regulator_roots = forms.regulator_roots[best]
        roots.plot(regulator_roots.real, regulator_roots.imag, "o", ms=15, mfc="none", mec=INK)
        circled = f"closed-loop roots, circled: the regulator of form {best + 1}"
        roots.set_title(circled, fontsize=10)
        worth.plot(best + 1, forms.condition[best], "o", ms=11, mfc="none", mec=INK)
        worth.locator_params(axis="x", integer=True)
    for axis in (roots, worth):
        axis.grid(alpha=0.25)
    return figure
