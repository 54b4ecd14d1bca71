"""Figures of one or several runs: z and u in common axes, theta with its taps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._validation import instance_of, number, one_of
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.engine._runs import Run
from rcac_numeric.plots._coefficients import draw_theta, legend_above
from rcac_numeric.plots._library import Axes, Figure
from rcac_numeric.plots._style import (
    INK,
    NARROW,
    NARROWEST,
    axes_of,
    draw_over_decades,
    figure_of,
    label_words,
    line_style,
)
from rcac_numeric.plots._thinning import thinned

LONG = 200_000  # steps, above which a line has a point for the extremes of each block of them
SIGNALS = {
    "w": "exogenous $w$",
    "y": "measurement $y$",
    "z": "performance $z$",
    "u": "control $u$",
}
LETTER, MOST_LEGEND = 0.07, 0.3  # inches of a letter; the share of the width that names may take


def plot_runs(
    runs: Sequence[Run] | Mapping[str, Run],
    labels: Sequence[str] | None = None,
    *,
    width: float = 9.0,
    signals: Sequence[str] = ("z", "u", "theta"),
    ax: Axes | Sequence[Axes] | None = None,
) -> Figure:
    """Plot several runs in one figure: z and u in common axes, theta below each other.

    Over the step k, or in seconds where all runs have one sample time.

    A signal whose peak is a thousand times its usual size is drawn over decades (linear near
    zero, logarithmic beyond), so that both a burst and what comes after it are seen.

    Parameters
    ----------
    runs : sequence of Run, or dict of them by name
    labels : sequence of str, optional
        A name for each; "run 1", "run 2", ... by default, or the names of the dict.
    width : float
        Of the figure in inches; 3.5 fits the column of a journal, 7 its page.
    signals : sequence of {"w", "y", "z", "u", "theta"}
        What is drawn, from top to bottom; theta takes axes for each run that adapts.
    ax : Axes or sequence of Axes, optional
        Where it is drawn instead, in the same order; the rest of their figure is left as it is.

    Returns
    -------
    matplotlib.figure.Figure
        Not attached to a window; ``figure.savefig("runs.pdf")`` writes it.

    Raises
    ------
    InputError
        Where there is no run, or not a label for each, the figure is narrower than 3 inches, a
        signal is unknown, or there are not as many axes as are needed.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, Step, exogenous, fir_target, iir, servo_plant, simulate)
    >>> from rcac_numeric.plots import plot_runs
    >>> plant = servo_plant("(q - 0.85)/((q - 0.8)*(q - 0.9))")
    >>> w = exogenous([Step(), Step(0), Step(0)], steps=300)
    >>> runs = {}
    >>> for R_theta in (0.2, 20):
    ...     settings = ControllerSettings(
    ...         structure=iir(3), target=fir_target(plant), update=UD(R_theta))
    ...     runs[f"R_theta = {R_theta}"] = simulate(plant, settings, w)
    >>> figure = plot_runs(runs)
    >>> figure.axes[0].get_ylabel(), figure.axes[-1].get_xlabel()
    ('performance $z$', 'step $k$')
    """
    if isinstance(runs, Mapping):
        labels = list(runs) if labels is None else labels
        runs = list(runs.values())
    runs = [instance_of(run, "a run", Run) for run in runs]
    if not runs:
        raise InputError("there is no run to plot.")
    names = [f"run {i + 1}" for i in range(len(runs))] if labels is None else list(labels)
    if len(names) != len(runs):
        raise InputError(f"{len(runs)} runs have {len(names)} labels; give one for each.")
    names = [label_words(shortened(str(name), 60)) for name in names]
    adapting = [(run, name) for run, name in zip(runs, names, strict=True) if run.theta.shape[1]]
    if not number(width, "width") >= NARROWEST:
        raise InputError(f"width = {width} inches is too narrow; {NARROWEST} are needed.")
    narrow = width < NARROW
    panels: list[tuple[str, tuple[Run, str] | None]] = []
    for signal in signals:
        one_of(signal, "an entry of signals", (*SIGNALS, "theta"))
        panels += [(signal, None)] if signal in SIGNALS else [("theta", one) for one in adapting]
    if not panels:
        raise InputError("signals is empty, or no run adapts: there is nothing to draw.")
    period = _period(runs)
    if ax is not None:
        axes = axes_of(ax, len(panels))
        figure = figure_of(axes[0])
        room = axes[0].get_position().width * figure.get_figwidth()
        _draw_panels(axes, panels, runs, names, period, room if room < NARROW else 0.0)
        return figure
    longest = max(map(len, names)) if len(runs) > 1 else 0
    above = width if narrow or LETTER * longest > MOST_LEGEND * width else 0.0
    rows = len(panels)
    height = 0.6 + 1.75 * rows if narrow else 2.3 + 1.9 * rows
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = list(np.ravel(figure.subplots(rows, 1, sharex=True, squeeze=False)))
    _draw_panels(axes, panels, runs, names, period, above)
    for axis in axes:
        axis.grid(alpha=0.25)
        axis.spines[["top", "right"]].set_visible(False)
        if narrow:
            axis.tick_params(labelsize=8)
            axis.yaxis.label.set_fontsize(8)
    if narrow:
        axes[-1].xaxis.label.set_fontsize(8)
        axes[-1].locator_params(axis="x", nbins=4)  # steps may have six digits
        figure.align_ylabels(axes)
    return figure


def _period(runs: Sequence[Run]) -> float | None:
    """The common sample time of the runs; None without one."""
    periods = {run.sample_time for run in runs}
    return periods.pop() if len(periods) == 1 else None


def _draw_panels(
    axes: Sequence[Axes],
    panels: Sequence[tuple[str, tuple[Run, str] | None]],
    runs: Sequence[Run],
    names: Sequence[str],
    period: float | None,
    above: float,
) -> None:
    """Draw each panel in its axes, legends `above` in a picture of that width, or beside."""
    shown: list[list[str]] = []
    for axis, (signal, one) in zip(axes, panels, strict=True):
        if one is not None:
            title = one[1] if len(runs) > 1 else ""
            draw_theta(axis, one[0], title, above=above, period=period or 1.0)
            continue
        _draw_signals(axis, runs, names, signal, period or 1.0)
        axis.set_ylabel(SIGNALS[signal])
        written = axis.get_legend_handles_labels()[1]
        if written in shown:
            continue  # the same lines under the same names
        shown.append(written)
        if above:
            legend_above(axis, above)
        elif written:
            axis.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    axes[-1].set_xlabel("step $k$" if period is None else "time $t$, s")


def _draw_signals(
    axis: Axes, runs: Sequence[Run], names: Sequence[str], signal: str, period: float
) -> None:
    index = 0
    parts: list[np.ndarray] = []
    for run, name in zip(runs, names, strict=True):
        pairs = [(getattr(run, signal), "")]
        if signal == "u" and not np.array_equal(run.u, run.u_applied):
            pairs.append((run.u_applied, "applied"))
        for values, remark in pairs:
            for i, column in enumerate(values.T):
                component = f"${signal}_{i + 1}$" if values.shape[1] > 1 else ""
                prefix = name if len(runs) > 1 else ""
                label = " ".join(filter(None, (prefix, component, remark)))
                k, shown = thinned(run.k, column) if len(column) > LONG else (run.k, column)
                axis.step(k * period, shown, where="post", linewidth=1.1, label=label or None,
                          **line_style(index))  # fmt: skip
                index += 1
            parts.append(values)
        if run.outcome != "completed" and run.steps:
            axis.plot(run.k[-1] * period, getattr(run, signal)[-1, 0], "X", color=INK, ms=8,
                      label=f"{name}: {run.outcome}" if len(runs) > 1 else run.outcome)  # fmt: skip
    draw_over_decades(axis, parts)
