"""Pictures of a run: response, controller, poles and zeros, and the intercalated match."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from compensator_theory.errors import CompensatorError
from rcac_numeric.arrays.wording import shortened
from rcac_numeric.engine.runs import Run
from rcac_numeric.experiments.measures.analysed_run import AnalysedRun
from rcac_numeric.experiments.verdicts import Verification
from rcac_numeric.plots.style import (
    INK,
    REACHED,
    SECOND,
    WANTED,
    draw_history,
    draw_magnitude,
    draw_phase,
    draw_title,
)


def plot_sheet(repetition: AnalysedRun, title: str = "") -> Figure:
    """One sheet on one run.

    Left, over the step k: performance z, control u and controller coefficients theta. Right:
    closed-loop poles and zeros beside the poles that the target asks for, and the frequency
    responses of G_f and of the intercalated transfer function of the final controller. A run
    that diverged is drawn up to where it did.

    Parameters
    ----------
    repetition : AnalysedRun
        ``verify(experiment).main.first``, for example.
    title : str

    Returns
    -------
    matplotlib.figure.Figure
        Not attached to a window; ``figure.savefig("sheet.png")`` writes it.

    Examples
    --------
    >>> from rcac_numeric import load_example, plot_sheet, verify
    >>> figure = plot_sheet(verify(load_example("4.7")).main.first, "Example 4.7")
    >>> len(figure.axes)
    6
    """
    figure = Figure(figsize=(11, 8.5), layout="constrained")
    axes = figure.subplots(3, 2, width_ratios=[1.25, 1], height_ratios=[1.25, 1, 1])
    if title:
        draw_title(figure, title)
    run = repetition.run
    draw_history(axes[0, 0], run.z, "performance $z$", "z")
    draw_control(axes[1, 0], run)
    draw_coefficients(axes[2, 0], run)
    if run.outcome != "completed":
        for axis in axes[:, 0]:
            axis.set_yscale("symlog")
        axes[0, 0].set_title(f"diverged after step {run.steps - 1}", color=WANTED, fontsize=10)
    draw_pole_zero(axes[0, 1], repetition)
    try:
        match = repetition.match
    except CompensatorError as error:
        axes[1, 1].set_title(f"no intercalated match: {shortened(str(error), 60)}", fontsize=10)
    else:
        draw_magnitude(axes[1, 1], match)
        draw_phase(axes[2, 1], match)
    for axis in axes.ravel():
        axis.grid(alpha=0.25)
    return figure


def plot_verification(verification: Verification) -> Figure:
    """The sheet of the main run, under the name of the experiment."""
    experiment = verification.experiment
    title = f"{experiment.id}: {experiment.title}".strip(": ")
    return plot_sheet(verification.main.first, title)


def draw_control(axis: Axes, run: Run) -> None:
    """What the controller asked for and, where that differs, what the actuator applied."""
    draw_history(axis, run.u, "control $u$", "u")
    if run.u_applied is run.u or np.array_equal(run.u_applied, run.u):
        return
    for i, column in enumerate(run.u_applied.T):
        axis.step(np.arange(len(column)), column, where="post", linewidth=1.1, color=WANTED,
                  label="applied" if i == 0 else None)  # fmt: skip
    if run.u.shape[1] == 1:
        axis.lines[0].set(label="asked for", alpha=0.6)
    axis.legend(fontsize=8)


def draw_coefficients(axis: Axes, run: Run) -> None:
    """theta; the gains by name where the structure is P, I and D terms on one signal."""
    k = run.first_step + np.arange(len(run.theta)) * run.stride
    name = getattr(getattr(run.settings, "structure", None), "name", "")
    gains = name if set(name) <= set("PID") and len(name) == run.theta.shape[1] else ""
    lines = axis.plot(k, run.theta, linewidth=1.0)
    for line, gain in zip(lines, gains, strict=False):
        line.set_label(f"$K_{gain}$")
    if gains:
        axis.legend(fontsize=8)
    label = "gains" if gains else r"coefficients $\theta$"
    axis.set(xlabel="step $k$", ylabel=label)


def draw_pole_zero(axis: Axes, repetition: AnalysedRun) -> None:
    """Closed-loop poles and zeros of the final controller, and the poles that G_f asks for."""
    circle = np.exp(1j * np.linspace(0, 2 * np.pi, 400))
    axis.plot(circle.real, circle.imag, color=INK, linewidth=0.7)
    if repetition.is_scalar:
        comparison = repetition.comparison
        poles, wanted = comparison.poles, comparison.asked_poles
        zeros = np.concatenate([np.zeros(0), *comparison.zeros.values()])
        axis.plot(wanted.real, wanted.imag, "s", mfc="none", mec=WANTED, ms=10, label="asked for")
        axis.plot(zeros.real, zeros.imag, "o", mfc="none", mec=SECOND, ms=6, label="zeros")
    else:
        poles, zeros = repetition.loop.poles(), np.zeros(0)
        wanted = np.zeros(0, dtype=np.complex128)
        if repetition.run.plant.l_z == 1:
            zeros = np.concatenate([zeros, *repetition.zeros.values()])
            axis.plot(zeros.real, zeros.imag, "o", mfc="none", mec=SECOND, ms=6, label="zeros")
    axis.plot(poles.real, poles.imag, "x", color=REACHED, ms=7, mew=1.6, label="poles reached")
    span = max(1.15, 1.1 * np.abs(poles).max(initial=0.0)) if np.isfinite(poles).all() else 1.15
    span = min(span, 3.0)
    axis.set(xlim=(-span, span), ylim=(-span, span), xlabel="real", ylabel="imaginary")
    axis.set_aspect("equal")
    axis.set_title("closed loop with the final controller", fontsize=10)
    axis.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.02, 0.5), frameon=False)
    hidden = [
        f"{name} beyond: {count}"
        for name, values in (
            ("asked for", wanted),
            ("poles", poles),
            ("zeros", np.unique(np.round(zeros, 9))),
        )
        if (count := int((np.abs(values) > span).sum()))
    ]
    axis.annotate(", ".join(hidden), (0.02, 0.02), xycoords="axes fraction", fontsize=8)
