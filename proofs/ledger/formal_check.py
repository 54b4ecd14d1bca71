"""Every theorem of the ledger, asked of Coq; needs the standard library only.

``python -m proofs.ledger.formal_check`` is the last step of ``make -C proofs/rocq check``. It exits
with 1 if a theorem is missing, rests on an axiom or says something else than ``proofs/rocq/types``
commits, if a definition does, and if a file assumes instead of proving. With ``--write`` it commits
what the theorems and definitions say now.
"""

import sys
from collections.abc import Iterable, Mapping

from ..formal.rocq_build import examine
from ..formal.rocq_sources import assumed, defined
from ..formal.types import commit, committed, printed_statements
from .ledger import ledger, theorems


def report(answers: Mapping[str, str], faults: Iterable[str]) -> tuple[str, bool]:
    """Put the answers into words; the second value is whether all is well.

    Examples
    --------
    >>> from proofs.ledger.formal_check import report
    >>> text, is_well = report({"A.b": "", "A.c": "proofs/rocq has no file A.v"}, [])
    >>> print(text)
    no axioms  A.b
    FAILS      A.c: proofs/rocq has no file A.v
    1 of 2 theorems of the ledger are proved without axioms and say what is committed
    >>> is_well
    False
    """
    lines = [
        f"FAILS      {name}: {reason}" if reason else f"no axioms  {name}"
        for name, reason in answers.items()
    ]
    faults = tuple(faults)
    lines += [f"FAILS      {fault}" for fault in faults]
    proved = sum(not reason for reason in answers.values())
    lines.append(
        f"{proved} of {len(answers)} theorems of the ledger are proved without axioms and say "
        "what is committed"
    )
    return "\n".join(lines), proved == len(answers) and not faults


def rewrite() -> int:
    """Commit what every definition and every theorem of the ledger says now."""
    statements, complaint = printed_statements(theorems(ledger()), defined())
    if complaint or not all(statements.values()):
        print(complaint or "Coq does not print every statement")
        return 1
    before = committed()
    commit(statements)
    names = sorted(statements.keys() | before.keys())
    differ = [name for name in names if statements.get(name) != before.get(name)]
    print(f"{len(statements)} statements; changed, new or gone: {', '.join(differ) or 'none'}")
    return 0


def main() -> int:
    """Ask about every theorem of the ledger and print the answers."""
    names, definitions = theorems(ledger()), defined()
    answers, differs = examine(names)
    faults = [f"{file} assumes instead of proving" for file in assumed()]
    faults += [f"{name}: {reason}" for name, reason in differs.items() if reason]
    missing = committed().keys() - {*names, *definitions}
    faults += [f"{name}: is committed in proofs/rocq/types and gone" for name in sorted(missing)]
    text, is_well = report(answers, faults)
    print(text)
    if not is_well:
        print("If a new statement is what was meant: make -C proofs/rocq types, and read the diff.")
    return 0 if is_well else 1


if __name__ == "__main__":
    sys.exit(rewrite() if "--write" in sys.argv[1:] else main())
