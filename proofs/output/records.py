"""The outcome of a run as JSON."""

import dataclasses
import json
from collections.abc import Iterable
from typing import Any

from ..formal.rocq_build import Compilation
from ..ledger.outcomes import Verified


def to_json(entries: Iterable[Verified], compilation: Compilation, *, quick: bool) -> str:
    """Write one JSON object: the run, the formal part, and every entry with its evidence.

    Examples
    --------
    >>> import json
    >>> from proofs.ledger.ledger import select
    >>> from proofs.output.records import to_json
    >>> from proofs.formal.rocq_build import NOT_COMPILED
    >>> from proofs.ledger.verification import verify
    >>> entries = verify(select(["lemma-1"]), NOT_COMPILED, quick=True)
    >>> record = json.loads(to_json(entries, NOT_COMPILED, quick=True))
    >>> record["holds"], record["effort"], record["entries"][0]["name"]
    (True, 'quick', 'lemma-1')
    """
    entries = tuple(entries)
    record = {
        "holds": all(entry.holds for entry in entries) and compilation.holds,
        "effort": "quick" if quick else "full",
        "formal": {"status": compilation.status, "detail": compilation.detail},
        "entries": [_entry(entry) for entry in entries],
    }
    return json.dumps(record, indent=2, allow_nan=False)


def _entry(verified: Verified) -> dict[str, Any]:
    entry = verified.entry
    return {
        "name": entry.name,
        "chapter": entry.chapter,
        "title": entry.title,
        "source": entry.source,
        "hypotheses": list(entry.hypotheses),
        "conclusion": list(entry.conclusion),
        "strengths": list(verified.strengths),
        "text": entry.text,
        "difference": entry.difference or None,
        "relied_on_by": list(entry.relied_on_by),
        "holds": verified.holds,
        "strength": verified.strength,
        "evidence": [dataclasses.asdict(outcome) for outcome in verified.outcomes],
    }
