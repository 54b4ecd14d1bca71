"""A scalar controller beside the exact prediction, and what float64 says of any other."""

from __future__ import annotations

from rcac_numeric.analysis.exact_comparison import ExactComparison
from rcac_numeric.experiments.measures.loop_analysis import LoopAnalysis
from rcac_numeric.reports.loop import zeros_facts
from rcac_numeric.reports.sheets.sheet import (
    Block,
    Fact,
    Section,
    Table,
    Text,
    cells,
    complex_list,
    complex_text,
    exact_text,
    rounded,
)

MISSED = 0.01  # a pole that is farther from the one asked for is not that pole


def missed_poles(c: ExactComparison | None) -> tuple[Text, ...]:
    """The line that a report begins with where poles asked for are not reached.

    A target model with all its poles at 0 asks for a finite response and not for poles.
    """
    if c is None or not c.target_poles.any():
        return ()
    missed = [(a, b) for a, b in c.assigned if not abs(a - b) <= MISSED]
    if not missed:
        return ()
    missed.sort(key=lambda pair: -abs(pair[0] - pair[1]))
    words = ", ".join(
        f"{complex_list([a])} by {abs(a - b):.2g} (the loop has {complex_list([b])})"
        for a, b in missed[:4]
    )
    more = f" and {len(missed) - 4} more" if len(missed) > 4 else ""
    count = f"{len(missed)} of {len(c.assigned)} poles asked for"
    return (Text(f"NOT reached: {count} are missed, {words}{more}.", "bad"),)


def comparison_section(c: ExactComparison) -> Section:
    """Coefficients, poles and zeros, reached and asked for."""
    blocks: list[Block] = [
        Text("Characteristic polynomial D D_c - N_yu N_c:"),
        _polynomial(c),
    ]
    if c.asked is None:
        blocks.append(Text(f"No exact prediction: {c.obstacle}", "warning"))
    pairs = tuple(
        cells(complex_text(wanted), complex_text(pole), f"{abs(wanted - pole):.2e}")
        for wanted, pole in c.assigned
    )
    blocks.append(Table(("pole of G_f", "closed-loop pole", "distance"), pairs))
    blocks.append(Fact("other closed-loop poles", complex_list(c.unassigned)))
    blocks += zeros_facts({channel: complex_list(zeros) for channel, zeros in c.zeros.items()})
    blocks.append(Fact("worst pole distance", f"{c.worst_distance:.3g}"))
    if c.compensators is not None:
        free = len(c.compensators.homogeneous)
        family = "the one compensator" if not free else f"the {free}-parameter family"
        far = f"{c.controller_distance:.3g}"
        words = f"distance of (D_c, N_c) to {family} that places it: {far}"
        blocks.append(Text(words))
    record = {
        "poles": c.poles,
        "asked_poles": c.asked_poles,
        "zeros": c.zeros,
        "characteristic_polynomial": {
            "asked": None if c.asked is None else [str(v) for v in c.asked.all_coeffs()],
            "reached": [rounded(v) for v in c.reached.all_coeffs()],
            "obstacle": c.obstacle or None,
        },
        "worst_pole_distance": c.worst_distance,
        "is_reached": not missed_poles(c),
        "controller_distance": c.controller_distance,
    }
    return Section(blocks=tuple(blocks), record=record)


def _polynomial(c: ExactComparison) -> Table:
    rows = []
    for power in range(c.reached.degree(), -1, -1):
        reached = c.reached.nth(power)
        row = [str(power), "", f"{rounded(reached):.12g}", ""]
        if c.asked is not None:
            asked = c.asked.nth(power)
            row[1], row[3] = exact_text(asked), f"{rounded(reached - asked):.1e}"
        rows.append(cells(*row))
    return Table(("power of q", "asked for, exact", "reached", "difference"), tuple(rows))


def poles_section(found: LoopAnalysis) -> Section:
    """What float64 can say where the exact comparison does not apply."""
    poles = found.loop.poles()
    blocks: list[Block] = [
        Text(f"No exact comparison: {found.obstacle}.", "warning"),
        Fact("closed-loop poles", complex_list(poles)),
        Fact("controller poles", complex_list(found.run.compensator.poles())),
    ]
    if found.run.plant.l_z == 1:
        zeros = {channel: complex_list(values) for channel, values in found.zeros.items()}
        blocks += zeros_facts(zeros)
    return Section(blocks=tuple(blocks), record={"obstacle": found.obstacle, "poles": poles})
