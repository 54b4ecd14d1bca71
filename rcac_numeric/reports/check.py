"""The check of a controller in words and numbers, for the terminal."""

from __future__ import annotations

import io
from math import isnan
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape

from rcac_numeric.reports.check_record import margin_rows
from rcac_numeric.reports.tables import complex_list, table_of

if TYPE_CHECKING:
    from rcac_numeric.checks.check import ControllerCheck
    from rcac_numeric.margins.classical import Margins


def as_text(check: ControllerCheck) -> str:
    """The report without colours."""
    stream = io.StringIO()
    print_check(check, Console(file=stream, width=100, highlight=False, color_system=None))
    return stream.getvalue().strip("\n")


def print_check(check: ControllerCheck, console: Console | None = None) -> None:
    """Print what the log says, what the loop is, and what cannot be said."""
    out = console or Console(highlight=False)
    out.print(f"\n[bold]{escape(check.log.source)}[/bold]: {check.log.steps} steps")
    for finding, fine in (
        (check.replay, check.is_consistent),
        (check.drift, check.drift is None or check.drift.is_converged),
    ):
        if finding is not None:
            out.print(f"  {escape(str(finding))}", style=None if fine else "red")
    if not check.is_consistent:
        out.print("  What follows is about theta; the logged u came from something else.")
    _print_controller(out, check)
    if check.loop is not None:
        _print_loop(out, check)
        for name, margins in check.margins.items():
            _print_margins(out, name, margins)
        if check.disk is not None:
            out.print(f"  all of u at once: disk {check.disk}")
        _print_costs(out, check)
    if check.target is not None and check.loop is not None:
        _print_target(out, check)
    if check.unsaid:
        out.print("\n[bold]What cannot be said[/bold]")
        for name, reason in check.unsaid.items():
            out.print(f"  {escape(name)}: {escape(reason)}.", style="yellow")


def _print_controller(out: Console, check: ControllerCheck) -> None:
    out.print("\n[bold]The controller[/bold] at the end of the log")
    poles = check.compensator.poles()
    out.print(f"  poles: {complex_list(poles)}")
    if (largest := float(abs(poles).max(initial=0.0))) > 1 + 1e-9:
        out.print(f"  it is unstable by itself: spectral radius {largest:.6g}", style="yellow")
    for model in check.internal_models:
        left = ", ".join(f"{gain:.2g} from {name}" for name, gain in model.gains.items())
        left = f"; of these z keeps {left}" if left else ""
        out.print(
            f"  internal model: pole {complex_list([model.pole])} rejects {model.rejects}{left}"
        )


def _print_loop(out: Console, check: ControllerCheck) -> None:
    assert check.loop is not None
    radius = check.loop.spectral_radius
    stable = check.loop.is_stable
    out.print("\n[bold]The closed loop[/bold]")
    out.print(
        f"  {'stable' if stable else 'UNSTABLE'}, spectral radius {radius:.9g}",
        style=None if stable else "red",
    )
    assert check.poles is not None
    out.print(f"  poles: {complex_list(check.poles)}")
    for channel, zeros in check.zeros.items():
        out.print(f"  zeros from {escape(channel)} to z: {complex_list(zeros)}")


def _print_margins(out: Console, name: str, margins: Margins) -> None:
    out.print(f"\n[bold]Margins[/bold], the loop opened at {name}")
    if not margins.is_stable:
        out.print(f"  {margins}", style="red")
        return
    table = table_of("", "margin", "at rad/sample", "pole radius there")
    for label, found, unit in margin_rows(margins):
        value = f"{found.value:.6g}{unit}"
        omega = f"{found.omega:.6g}" if found.is_reached else ""
        there = f"{found.radius_at:.12f}" if found.is_reached else ""
        table.add_row(label, value, omega, there)
    disk = margins.disk
    assert disk is not None
    low, high = disk.gain
    table.add_row(
        "disk, S - T",
        f"{disk.alpha:.6g}: {low:.4g} to {high:.4g}, {disk.phase:.4g} deg",
        f"{disk.omega:.6g}",
        "" if isnan(disk.radius_at) else f"{disk.radius_at:.12f}",
    )
    out.print(table)
    out.print(
        f"  peaks: |S| {disk.S_peak:.4g} at {disk.S_omega:.4g}, |T| {disk.T_peak:.4g} at "
        f"{disk.T_omega:.4g} rad/sample"
    )


def _print_costs(out: Console, check: ControllerCheck) -> None:
    costs = check.costs
    assert costs is not None
    out.print("\n[bold]H2 cost[/bold] for white noise, with the share of each")
    shares = ", ".join(f"{name} {value:.6g}" for name, value in costs.reached.shares.items())
    out.print(f"  {costs.reached.value:.6g} ({escape(shares)})")
    if costs.least is None:
        out.print(f"  no LQG cost: {escape(costs.obstacle)}.", style="yellow")
    else:
        ratio = "" if costs.ratio is None else f"; ratio {costs.ratio:.6g}"
        out.print(f"  LQG: {costs.least.value:.6g}{ratio}")


def _print_target(out: Console, check: ControllerCheck) -> None:
    out.print("\n[bold]Against the target model[/bold]")
    if (comparison := check.comparison) is not None:
        table = table_of("pole of G_f", "closed-loop pole", "distance")
        for wanted, pole in comparison.assigned:
            table.add_row(
                complex_list([wanted]),
                complex_list([pole]),
                f"{abs(wanted - pole):.2e}",
            )
        out.print(table)
        if comparison.asked is None:
            out.print(f"  no exact prediction: {escape(comparison.obstacle)}", style="yellow")
        else:
            out.print(
                f"  distance of all poles from those the target asks for: "
                f"{comparison.spectrum_distance:.3g}"
            )
    if check.match is not None:
        out.print(
            f"  intercalated transfer function against G_f: worst relative error "
            f"{check.match.worst:.3g}, median {check.match.median:.3g}"
        )
    if check.split is not None:
        power = ", ".join(f"{name} {value:.3g}" for name, value in check.split.power().items())
        out.print(f"  mean squares of the split residual: {power}")
        if check.loop is not None and check.loop.is_stable:
            out.print(f"  the split holds to {check.split.identity_error:.1e} (4.14)")
