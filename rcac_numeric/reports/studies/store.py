"""What a check or a repair of a store found, as a report."""

from __future__ import annotations

from rcac_numeric.arrays.wording import shortened
from rcac_numeric.reports.sheets.sheet import Block, Fact, Section, Sheet, Text
from rcac_numeric.sweeps.store.care import StoreCheck

MOST_FAULTS = 20  # that a reader looks through


def store_sheet(check: StoreCheck) -> Sheet:
    """Whether a store is whole, what is wrong with it, and what became of that."""
    lost = sum(last - first + 1 for first, last in check.damaged)
    said = [Text("Everything in it is what was stored.", "good")]
    if not check.is_whole:
        said = [Text(f"It is damaged: {lost} runs are not what was stored.", "bad")]
    if check.repaired:
        said.append(
            Text("What was right is kept, and the rest is run again when the study is.", "good")
        )
    blocks: list[Block] = [
        Fact("runs stored and right", f"{check.done} of {check.total}"),
        Fact("of them failed", str(check.failed)),
        *(Text(shortened(words, 300), "bad") for words in check.faults[:MOST_FAULTS]),
    ]
    if (more := len(check.faults) - MOST_FAULTS) > 0:
        blocks.append(Text(f"and {more} others; --json has them all."))
    record = {
        "path": check.path,
        "is_whole": check.is_whole,
        "repaired": check.repaired,
        "done": check.done,
        "total": check.total,
        "failed": check.failed,
        "damaged": [list(runs) for runs in check.damaged],
        "faults": list(check.faults),
    }
    return Sheet(check.path, health=tuple(said), sections=(Section("", tuple(blocks), record),))
