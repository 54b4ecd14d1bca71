"""A scalar controller beside the exact prediction, and what float64 says of any other."""

from __future__ import annotations

from rcac_numeric.analysis.exact_comparison import ExactComparison
from rcac_numeric.experiments.measures.analysed_run import AnalysedRun
from rcac_numeric.reports.loop import zeros_facts
from rcac_numeric.reports.sheets.numbers import complex_list, complex_text, exact_text, rounded
from rcac_numeric.reports.sheets.sheet import Block, Fact, Section, Table, Text, cells


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


def poles_section(found: AnalysedRun) -> Section:
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
