"""A verification in words and numbers: for the terminal and as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.markup import escape

from compensator_theory.errors import CompensatorError
from rcac_numeric.experiments.claims import CORRECTED, NOT_REPRODUCED, REPRODUCED
from rcac_numeric.experiments.verdicts import Verification
from rcac_numeric.reports.tables import complex_list, complex_text, finite_or_none, table_of

if TYPE_CHECKING:
    from rcac_numeric.analysis.exact_comparison import ExactComparison
    from rcac_numeric.experiments.analysed_run import AnalysedRun

COLOURS = {REPRODUCED: "green", CORRECTED: "yellow", NOT_REPRODUCED: "red"}


def print_report(verification: Verification, console: Console | None = None) -> None:
    """Print the problem, the claims with their verdicts, and the exact comparison."""
    out = console or Console(highlight=False, soft_wrap=False)
    experiment = verification.experiment
    out.print(f"\n[bold]{escape(experiment.id)}  {escape(experiment.title)}[/bold]")
    if experiment.source:
        out.print(escape(experiment.source), style="dim")
    for name, words in experiment.description.items():
        if words:
            out.print(f"  [dim]{name:<12}[/dim]{escape(words)}")
    if verification.verdicts:
        _print_claims(out, verification)
    if len(verification.results) > 1:
        _print_runs(out, verification)
    main = verification.main
    repetition = main.first
    if main.diverged:
        words = ", as it is known to" if main.as_expected else ""
        out.print(
            f"\n[red]The loop diverged after step {repetition.run.steps - 1}{words}; "
            "what follows is the controller of that step.[/red]"
        )
    out.print(f"\n[bold]The controller of run {escape(repr(main.specification.name))}[/bold]")
    if repetition.run.saturation is not None:
        out.print("  What follows is the linear loop, without the saturation.", style="yellow")
    if repetition.is_scalar:
        _print_comparison(out, repetition.comparison)
    else:
        _print_poles(out, repetition)
    _print_match(out, repetition)
    if experiment.notes:
        out.print(f"\n{escape(experiment.notes)}")


def as_dict(verification: Verification) -> dict[str, Any]:
    """The same as one JSON-ready dictionary."""
    repetition = verification.main.first
    result: dict[str, Any] = {
        "id": verification.experiment.id,
        "title": verification.experiment.title,
        "claims": [
            {
                "text": v.claim.text,
                "claimed": v.claim.claimed,
                "measured": v.measured,
                "verdict": v.verdict,
                "correction": v.claim.correction or None,
                "recorded": v.claim.recorded or None,
            }
            for v in verification.verdicts
        ],
        "runs": [
            {
                "name": name,
                "arithmetic": r.specification.arithmetic,
                "outcome": r.first.run.outcome,
                "expected": r.specification.expected,
                "steps": r.first.run.steps,
                "updates_decided_by_rounding": r.first.run.guard_count,
                "theta": r.first.run.theta_final.tolist(),
            }
            for name, r in verification.results.items()
        ],
    }
    match, _ = _analysed(repetition, "match")
    split, _ = _analysed(repetition, "split")
    result["match"] = match and {
        "worst": finite_or_none(match.worst),
        "median": finite_or_none(match.median),
    }
    result["residual"] = split and {name: finite_or_none(v) for name, v in split.power().items()}
    if repetition.is_scalar:
        c = repetition.comparison
        result |= {
            "poles": [[p.real, p.imag] for p in c.poles],
            "asked_poles": [[p.real, p.imag] for p in c.asked_poles],
            "zeros": {name: [[v.real, v.imag] for v in zeros] for name, zeros in c.zeros.items()},
            "characteristic_polynomial": {
                "asked": None if c.asked is None else [str(v) for v in c.asked.all_coeffs()],
                "reached": [float(v) for v in c.reached.all_coeffs()],
                "obstacle": c.obstacle or None,
            },
            "worst_pole_distance": c.worst_distance,
            "controller_distance": finite_or_none(c.controller_distance),
        }
    else:
        result["obstacle"] = repetition.obstacle
        result["poles"] = [[p.real, p.imag] for p in repetition.loop.poles()]
    return result


def _print_claims(out: Console, verification: Verification) -> None:
    table = table_of("claim", "claimed", "measured", "verdict")
    for v in verification.verdicts:
        verdict = f"[{COLOURS.get(v.verdict, 'magenta')}]{v.verdict}[/]"
        if v.claim.correction:
            verdict += f"\n[dim]{escape(v.claim.correction)}[/dim]"
        if v.has_changed:
            verdict += f"\n[red bold]was: {v.claim.recorded}[/red bold]"
        measured = "\n".join(map(str, v.results))
        table.add_row(escape(v.claim.text), escape(v.claim.claimed), escape(measured), verdict)
    out.print()
    out.print(table)


def _print_runs(out: Console, verification: Verification) -> None:
    """Every run side by side: what each arithmetic makes of the same data."""
    table = table_of("run", "arithmetic", "worst pole distance", "decided by rounding", "outcome")
    for name, result in verification.results.items():
        runs = result.repetitions
        distance = ""
        if result.first.is_scalar:
            values = sorted(r.comparison.worst_distance for r in runs)
            middle = values[len(values) // 2]
            distance = f"{middle:.3g}"
            if len(values) > 1:
                distance += f"  [dim]({values[0]:.2g} to {values[-1]:.2g} of {len(values)})[/dim]"
        first = result.first.run
        arithmetic = result.specification.arithmetic
        digits = getattr(first, "digits", None)
        if digits is not None:
            arithmetic += f", {digits:.0f} digits certified"
        guard = f"{first.guard_count} updates" if first.guard_count else "none"
        outcome = first.outcome
        if result.diverged:
            known = ", as expected" if result.as_expected else ""
            outcome = f"[{'dim' if known else 'red'}]diverged at {first.steps}{known}[/]"
        elif not result.as_expected:
            outcome += " [red]though expected to diverge[/red]"
        table.add_row(escape(name), arithmetic, distance, guard, outcome)
    out.print()
    out.print(table)


def _print_comparison(out: Console, c: ExactComparison) -> None:
    degree = c.reached.degree()
    table = table_of("power of q", "asked for, exact", "reached", "difference")
    for power in range(degree, -1, -1):
        reached = float(c.reached.nth(power))
        if c.asked is None:
            table.add_row(str(power), "", f"{reached:.12g}", "")
        else:
            asked = c.asked.nth(power)
            gap = float(c.reached.nth(power) - asked)
            table.add_row(str(power), _short(asked), f"{reached:.12g}", f"{gap:.1e}")
    out.print("Characteristic polynomial D D_c - N_yu N_c:")
    out.print(table)
    if c.asked is None:
        out.print(f"  No exact prediction: {escape(c.obstacle)}", style="yellow")
    table = table_of("pole of G_f", "closed-loop pole", "distance")
    for wanted, pole in c.assigned:
        table.add_row(complex_text(wanted), complex_text(pole), f"{abs(wanted - pole):.2e}")
    out.print(table)
    out.print(f"  other closed-loop poles:  {complex_list(c.unassigned)}")
    for channel, zeros in c.zeros.items():
        out.print(f"  zeros from {channel} to z:       {complex_list(zeros)}")
    out.print(f"  worst pole distance:      {c.worst_distance:.3g}")
    if c.compensators is not None:
        free = len(c.compensators.homogeneous)
        family = "the one compensator" if not free else f"the {free}-parameter family"
        out.print(f"  distance of (D_c, N_c) to {family} that places it: "
                  f"{c.controller_distance:.3g}")  # fmt: skip


def _print_poles(out: Console, repetition: AnalysedRun) -> None:
    """What float64 can say where the exact comparison does not apply."""
    out.print(f"  No exact comparison: {escape(repetition.obstacle)}.", style="yellow")
    out.print(f"  closed-loop poles:        {complex_list(repetition.loop.poles())}")
    out.print(f"  controller poles:         {complex_list(repetition.run.compensator.poles())}")
    if repetition.run.plant.l_z == 1:
        for channel, zeros in repetition.zeros.items():
            out.print(f"  zeros from {channel} to z:       {complex_list(zeros)}")


def _print_match(out: Console, repetition: AnalysedRun) -> None:
    match, obstacle = _analysed(repetition, "match")
    if match is None:
        out.print(f"  No match of the intercalated transfer function: {escape(obstacle)}.")
        return
    out.print(
        f"  intercalated transfer function against G_f: worst relative error {match.worst:.3g}, "
        f"median {match.median:.3g}"
    )
    split, obstacle = _analysed(repetition, "split")
    if split is None:
        out.print(f"  No split of the residual: {escape(obstacle)}.")
    else:
        power = ", ".join(
            f"{name} {value:.3g}" if value < float("inf") else f"{name} beyond float64"
            for name, value in split.power().items()
        )
        out.print(f"  mean squares of the split residual: {power}")
        if repetition.loop.is_stable:
            out.print(f"  the split holds to {split.identity_error:.1e} (4.14)")
    if repetition.run.guard_count:
        out.print(
            f"  [yellow]{repetition.run.guard_count} updates, the first at step "
            f"{repetition.run.guard_first_step}, were decided by rounding: the data cannot "
            "support this R_theta. Use a larger R_theta.[/yellow]"
        )


def _analysed(repetition: AnalysedRun, name: str) -> tuple[Any, str]:
    """An analysis of a run, or why there is none."""
    try:
        return getattr(repetition, name), ""
    except CompensatorError as error:
        return None, str(error).rstrip(".")


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 28 else f"{float(value):.12g}"
