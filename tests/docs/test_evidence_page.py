"""The table of functions with their evidence."""

from docs.evidence_page import evidence_of, evidence_table, public_functions
from proofs.ledger.ledger import ledger


def test_what_is_relied_on_is_shown():
    """The statements of the ledger reach the functions that they name."""
    entries = tuple(ledger())
    named = {n for entry in entries for n in entry.relied_on_by}
    shown = [path for path in public_functions() if evidence_of(path, entries)]
    direct = {n for n in named if n in set(public_functions())}
    assert direct <= set(shown)
    table = evidence_table()
    assert all(f"`{path.rpartition('.')[2]}`" in table for path in public_functions())
