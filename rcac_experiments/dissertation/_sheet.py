"""The report of errata: printed text, correction and evidence."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from rcac_experiments.dissertation._checking import Checked
from rcac_experiments.dissertation._entries import EVIDENCE, Erratum
from rcac_numeric.reports._sheet import Block, Fact, Section, Sheet, Text


def errata_sheet(
    entries: Sequence[Erratum], where: str = "", checked: Mapping[str, Checked] | None = None
) -> Sheet:
    """Return the report of the errata of one place, or of all."""
    results = checked or {}
    place = f" at {where}" if where else ""
    remark = f": {len(entries)}{place}, {_counted(entries)}" if entries else f": none known{place}"
    failed = [name for name, result in results.items() if not result.holds]
    health = tuple(Text(f"The check of {name} fails.", "bad") for name in failed)
    if results and not failed:
        health = (Text(f"All checks hold ({len(results)}).", "good"),)
    sections = tuple(_section(entry, results.get(entry.name)) for entry in entries)
    record = {"errata": [_record(entry, results.get(entry.name)) for entry in entries]}
    return Sheet("Errata of the dissertation", remark, health, (Section(record=record), *sections))


def _section(entry: Erratum, checked: Checked | None) -> Section:
    blocks: list[Block] = [
        Fact("printed", entry.printed),
        Fact("correct", entry.true),
        Fact("favourable reading", entry.charity),
        Fact("evidence", entry.evidence.words),
    ]
    if checked is not None:
        blocks += [
            Text(
                f"{'confirmed' if fact.holds else 'NOT CONFIRMED'}: {fact.words}",
                "good" if fact.holds else "bad",
            )
            for fact in checked.facts
        ]
    return Section(entry.where, tuple(blocks), remark=f": {entry.kind}, {entry.name}")


def _record(entry: Erratum, checked: Checked | None) -> dict[str, object]:
    record: dict[str, object] = {
        "name": entry.name,
        "chapter": entry.chapter,
        "where": entry.where,
        "kind": entry.kind,
        "printed": entry.printed,
        "true": entry.true,
        "charity": entry.charity or None,
        "evidence": {"kind": entry.evidence.kind, "words": entry.evidence.words},
    }
    if checked is not None:
        record["holds"] = checked.holds
        record["facts"] = [{"words": fact.words, "holds": fact.holds} for fact in checked.facts]
    return record


def _counted(entries: Sequence[Erratum]) -> str:
    """Count the errata by kind of evidence."""
    count = Counter(entry.evidence.kind for entry in entries)
    return ", ".join(f"{count[kind]} {words}" for kind, words in EVIDENCE.items() if count[kind])
