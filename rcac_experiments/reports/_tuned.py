"""The report of a tuned design."""

from __future__ import annotations

from dataclasses import asdict, replace

from rcac_experiments.tuning._tuning import RULE, Candidate, Tuned
from rcac_numeric.reports._design import design_sheet
from rcac_numeric.reports._sheet import Section, Sheet, SheetTable, Text, cells

BEST = 8  # candidates in the table of a report


def tuned_sheet(tuned: Tuned) -> Sheet:
    """Return the report: gain by tuning, tests of the tuned design, candidates."""
    sheet, beside = design_sheet(tuned.design), tuned.beside_rule
    (k, n), (low, high) = beside.stable, beside.interval
    words = (
        f"Test plants: rms error of the tuned settings {beside.ratio:.3g} of that of the rule "
        f"({low:.3g} to {high:.3g}); {k} of {n} runs stable (rule: {beside.fixed_stable[0]})."
    )
    if tuned.chosen.name == RULE:
        count = len(tuned.candidates) - 2
        words = f"None of {count} candidates is significantly better than the rule."
    ranked = sorted(tuned.candidates, key=lambda one: (-one.rounds, one.order))
    rows = tuple(cells(*_candidate(one)) for one in ranked[:BEST])
    head = ("candidate", "rounds", "rms/fixed", "lost", "Ms", "N_0", "nu", "width", "order +",
            "lambda")  # fmt: skip
    record = [
        {"name": one.name, "rounds": one.rounds, "ratio": one.beside.ratio, "Ms": one.Ms,
         "stable": list(one.beside.stable),
         "parameters": asdict(one.parameters) if one.parameters else None}
        for one in ranked
    ]  # fmt: skip
    candidates = Section(
        "Candidates",
        (
            SheetTable(head, rows),
            Text("Simulated on the plants at the corners of the uncertainty."),
        ),
        {"candidates": record, "chosen": tuned.chosen.name},
    )
    verdict, *rest = sheet.health
    return replace(
        sheet, title="A tuned controller", health=(verdict, Text(words), *rest),
        sections=(*sheet.sections, candidates),
    )  # fmt: skip


def _candidate(one: Candidate) -> tuple[str, ...]:
    (k, n), parameters = one.beside.stable, one.parameters
    row = (one.name, str(one.rounds), f"{one.beside.ratio:.3g}", f"{n - k} of {n}",
             f"{one.Ms:.3g}")  # fmt: skip
    if parameters is None:
        return *row, "", "", "", "", ""
    samples = "default" if parameters.samples is None else f"{parameters.samples:.3g}"
    return (*row, samples, f"{parameters.nu:.3g}", f"{parameters.width:.3g}", str(parameters.spare),
            f"{parameters.forgetting:.6g}")  # fmt: skip
