"""What is said of a loop wherever one is reported: its match, the split residual."""

from __future__ import annotations

import numpy as np

from rcac_numeric.analysis.match import IntercalatedMatch
from rcac_numeric.analysis.residual_split import ResidualSplit
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.reports.sheets.sheet import Fact, Section, Text, power_text


def match_section(match: IntercalatedMatch | None, reason: str) -> Section:
    """The intercalated transfer function beside G_f."""
    if match is None:
        words = f"No match of the intercalated transfer function: {reason}."
        return Section(blocks=(Text(words),), record={"match": None})
    words = (
        "intercalated transfer function against G_f: worst relative error "
        f"{match.worst:.3g}, median {match.median:.3g}"
    )
    record = {"match": {"worst": match.worst, "median": match.median}}
    return Section(blocks=(Text(words),), record=record)


def split_section(split: ResidualSplit | None, reason: str, is_stable: bool) -> Section:
    """The mean squares of the residual and its parts; (4.14) only where the loop is stable."""
    if split is None:
        words = f"No split of the residual: {reason}."
        return Section(blocks=(Text(words),), record={"residual": None})
    power = split.power()
    facts = [Text(f"mean squares of the split residual: {power_text(power)}")]
    record: dict[str, float] = dict(power)
    if is_stable:
        record["identity_error"] = split.identity_error
        facts.append(Text(f"the split holds to {split.identity_error:.1e} (4.14)"))
    return Section(blocks=tuple(facts), record={"residual": record})


def fitted_section(D_f: Array | None) -> Section:
    """The denominator of the target model that was fitted with theta; nothing where none was."""
    if D_f is None:
        return Section()
    terms = [f"{d:+.6g} q^-{i}" for i, d in enumerate(D_f[1:], 1)]
    radius = float(np.abs(np.roots(D_f)).max(initial=0.0))
    words = " ".join(["1", *terms]) + f", largest root {radius:.6g} in modulus"
    record = {"D_f": D_f.tolist(), "D_f_spectral_radius": radius}
    return Section(blocks=(Fact("D_f, fitted with theta", words),), record=record)


def joined(title: str, *sections: Section, remark: str = "") -> Section:
    """Several sections under one title."""
    record: dict[str, object] = {}
    for section in sections:
        record |= section.record
    blocks = tuple(block for section in sections for block in section.blocks)
    return Section(title, blocks, record, remark)


def zeros_facts(zeros: dict[str, str]) -> tuple[Fact, ...]:
    """The zeros from each channel of w to z, in words."""
    return tuple(Fact(f"zeros from {channel} to z", words) for channel, words in zeros.items())
