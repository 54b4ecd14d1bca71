"""The table of public functions with the evidence for their answers, on the page of the ledger."""

import re
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path

from docs.constructions_page import constructions
from proofs.ledger.entries import Entry
from proofs.ledger.ledger import ledger
from proofs.output.coverage import strength

GROUPS = Path(__file__).resolve().parent / "reference_groups"
PACKAGES = ("compensator_theory", "rcac_numeric")


def public_functions() -> Iterator[str]:
    """List the public functions of the two libraries, as their reference does."""
    for package in PACKAGES:
        groups = tomllib.loads((GROUPS / f"{package}.toml").read_text(encoding="utf-8"))["group"]
        for name in dict.fromkeys(name for group in groups for name in group["names"]):
            last = name.rpartition(".")[2]
            if last[0].islower() and last != "strategies":
                yield f"{package}.{name}"


def evidence_of(function: str, entries: Iterable[Entry]) -> list[str]:
    """List the evidence for one function: statements of the ledger, then the oracle of its test."""
    package, _, name = function.partition(".")
    last = name.rpartition(".")[2]
    evidence = []
    for entry in entries:
        names = {f"{n.split('.')[0]}.{n.rpartition('.')[2]}" for n in entry.relied_on_by}
        if f"{package}.{last}" in names:
            draws = sum(claim.examples for claim in entry.properties)
            drawn = f", {draws} draws" if draws else ""
            evidence.append(f"[{entry.title}](#{entry.name}) ({strength(entry)}{drawn})")
    for one in constructions():
        paths = {f"{path.split('.')[0]}.{path.rpartition('.')[2]}" for path in one["functions"]}
        if f"{package}.{last}" in paths:
            evidence.append(f"oracle: {one['oracle']}")
    return evidence


def evidence_table() -> str:
    """Return all functions with their evidence, and those that ordinary tests alone hold."""
    entries = tuple(ledger())
    rows, others = [], []
    for function in public_functions():
        evidence = evidence_of(function, entries)
        name = f"`{function.rpartition('.')[2]}`"
        exact = "exact" if function.startswith("compensator_theory") else "numeric"
        if evidence:
            rows.append(f"| {name}, {exact} | {'; '.join(evidence)} |")
        else:
            others.append(f"{name}, {exact}" if exact == "numeric" else name)
    head = f"{len(rows)} functions.\n\n| function | evidence |\n|---|---|"
    rest = re.sub(r"`, numeric", "` (numeric)", ", ".join(others))
    return "\n".join([head, *rows, "", f"By tests of their folder alone, {len(others)}: {rest}."])
