"""The figure of a controller check."""

from __future__ import annotations

import numpy as np

from rcac_numeric.checks._check import ControllerCheck
from rcac_numeric.checks._logs import ControllerLog
from rcac_numeric.plots._coefficients import NAMED, draw_coefficients, structure_names
from rcac_numeric.plots._library import Axes, Figure
from rcac_numeric.plots._margins import draw_nyquist, loop_curve
from rcac_numeric.plots._pole_maps import PoleGroup, draw_plane, largest_counts
from rcac_numeric.plots._style import (
    INK,
    REACHED,
    REQUESTED,
    SECOND,
    draw_history,
    draw_magnitude,
    draw_phase,
    draw_title,
)


def plot_check(check: ControllerCheck) -> Figure:
    """Left: the signals and coefficients of the log. Right: poles, match, Nyquist curve.

    Undetermined panels are left out, and the sheet is narrower.
    """
    knows = check.loop is not None and check.is_consistent
    figure = Figure(figsize=(15 if knows else 9, 9), layout="constrained")
    draw_title(figure, check.log.source.rsplit("/", 1)[-1])
    grid = figure.add_gridspec(6, 3 if knows else 1)
    left = [figure.add_subplot(grid[2 * i : 2 * i + 2, 0]) for i in range(3)]
    _signals(left[0], left[1], check)
    _coefficients(left[2], check)
    for axis in left:
        axis.grid(alpha=0.25)
    if knows:
        _poles(figure.add_subplot(grid[:4, 1]), check)
        _nyquist(figure.add_subplot(grid[:4, 2]), check)
        _match(figure.add_subplot(grid[4:, 1]), figure.add_subplot(grid[4:, 2]), check)
    return figure


def _signals(upper: Axes, lower: Axes, check: ControllerCheck) -> None:
    log = check.log
    if log.z is not None:
        draw_history(upper, log.z, "performance $z$", "z")
    else:
        draw_history(upper, log.y, "measurement $y$", "y")
    draw_history(lower, log.u, "control $u$", "u")
    for axis in (upper, lower):
        _label_steps(axis, log)
    replay = check.replay
    if replay is not None:
        for i, column in enumerate(replay.u.T):
            lower.step(np.arange(len(column))[replay.start :], column[replay.start :], where="post",
                       color=REQUESTED, linewidth=0.9, linestyle="--",
                       label=r"$\Phi\theta$" if i == 0 else None)  # fmt: skip
        lower.legend(fontsize=8)
        word = "is" if replay.agrees else "is NOT"
        lower.set_title(
            rf"$u$ {word} $\Phi\theta$: worst relative difference {replay.worst:.1g}",
            fontsize=10, color=INK if replay.agrees else REQUESTED,
        )  # fmt: skip


def _label_steps(axis: Axes, log: ControllerLog) -> None:
    """Label an axis of steps, in seconds where the sample time is known."""
    period = log.sample_time
    if period is None:
        axis.set_xlabel("step $k$")
        return
    axis.set_xlabel("time $t$, s")
    axis.xaxis.set_major_formatter(lambda k, _: f"{k * period:.4g}")


def _coefficients(axis: Axes, check: ControllerCheck) -> None:
    log, drift = check.log, check.drift
    if log.theta is not None and log.theta.ndim == 2:
        k = np.arange(log.steps)
        draw_coefficients(axis, k, log.theta, _names(check, log.theta.shape[1]))
        _label_steps(axis, log)
        if drift is not None:
            axis.axvspan(drift.start, log.steps - 1, color=INK, alpha=0.08, linewidth=0)
            axis.set_title(f"last tenth: moved by {drift.relative:.1g} of its size", fontsize=10,
                           color=INK if drift.is_converged else REQUESTED)  # fmt: skip
        return
    values = log.theta_final
    if values is None:
        axis.set_axis_off()
        return
    axis.stem(np.arange(len(values)), values, linefmt=REACHED, markerfmt="o", basefmt=" ")
    axis.set(xlabel="entry", ylabel=r"last coefficients $\theta$")
    names = _names(check, len(values))
    if check.structure is not None and len(values) <= NAMED:
        axis.set_xticks(range(len(values)), [f"${name}$" for name in names], rotation=60)
        axis.set_xlabel("weighs")


def _names(check: ControllerCheck, count: int) -> list[str]:
    """The name of each coefficient, if the structure is known."""
    if check.structure is not None and check.structure.l_theta == count:
        return structure_names(check.structure)
    return [rf"\theta_{{{i + 1}}}" for i in range(count)]


def _poles(axis: Axes, check: ControllerCheck) -> None:
    groups = []
    if check.comparison is not None:
        groups.append(
            PoleGroup(
                "requested", "requested", check.comparison.requested_poles, "s", REQUESTED, 10
            )
        )
    zeros = largest_counts(check.zeros.values())
    groups.append(PoleGroup("zeros from w to z", "zero", zeros, "o", SECOND, 6))
    poles = check.compensator.poles()
    groups.append(PoleGroup("poles of the controller", "controller", poles, "+", INK, 8))
    assert check.poles is not None
    groups.append(PoleGroup("closed-loop poles", "pole", check.poles, "x", REACHED, 7))
    draw_plane(axis, groups)
    axis.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2,
                frameon=False)  # fmt: skip
    assert check.loop is not None
    stable = check.loop.is_stable
    title = f"closed loop, spectral radius {check.loop.spectral_radius:.6g}"
    axis.set_title(title, fontsize=9, color=INK if stable else REQUESTED)


def _match(gain: Axes, phase: Axes, check: ControllerCheck) -> None:
    """Draw the match with G_f; without a target model the response from w to z."""
    assert check.loop is not None
    if check.match is not None:
        draw_magnitude(gain, check.match)
        draw_phase(phase, check.match)
        phase.set_title("its phase", fontsize=10)
    else:
        omega = (np.arange(1000) + 0.5) * np.pi / 1000
        response = np.linalg.norm(check.loop.frequency_response(omega), axis=1)
        for name, values in zip(check.loop.plant.channels, response.T, strict=True):
            gain.semilogy(omega, values, linewidth=1.2, label=f"from {name}")
        gain.legend(fontsize=8)
        gain.set_title("closed-loop response from w to z", fontsize=10)
        phase.set_axis_off()
    for axis in (gain, phase):
        axis.set_xlabel(r"frequency $\omega$, rad/sample")
        axis.grid(alpha=0.25)


def _nyquist(axis: Axes, check: ControllerCheck) -> None:
    if not check.margins:
        axis.set_axis_off()
        return
    name, margins = next(iter(check.margins.items()))
    draw_nyquist(axis, loop_curve(margins))
    axis.grid(alpha=0.25)
    words = "unstable: no margins"
    up, down, phase = margins.gain_up, margins.gain_down, margins.phase
    if margins.is_stable and up is not None and down is not None and phase is not None:
        words = f"gain {down.value:.4g} to {up.value:.4g}, phase {phase.value:.3g} deg"
    axis.set_title(f"Nyquist, opened at {name}\n{words}", fontsize=9,
                   color=INK if margins.is_stable else REQUESTED)  # fmt: skip
