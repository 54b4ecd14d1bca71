"""``python -m proofs.ledger.sign``: what changed since the statements were signed.

With ``--write`` they are signed as they are now, but for a check of which no mutant is caught: that
one would hold whatever it says. ``--trusted-base`` lists the files on which every outcome depends.
"""

import sys

from .ledger import ledger
from .mutants import checks_of, first_caught
from .signatures import Tree


def main(arguments: list[str]) -> int:
    """Show the differences, and sign them where that is asked for."""
    tree = Tree()
    if "--trusted-base" in arguments:
        total = 0
        for path in tree.trusted_base():
            lines = len(path.read_text(encoding="utf-8").splitlines())
            total += lines
            print(f"{lines:5}  {path.relative_to(tree.root)}")
        print(f"{total:5}  lines; besides these Python, SymPy, python-flint, Hypothesis and Coq")
        return 0
    differences = tree.differences()
    for name, words in differences.items():
        print(f"{name}: " + "; ".join(words))
    if not differences:
        print("every statement is as it was signed")
        return 0
    if "--write" not in arguments:
        print("If that is what was meant: python -m proofs.ledger.sign --write, and read the diff.")
        return 1
    blind = _blind(differences)
    for check, reason in blind.items():
        print(f"NOT SIGNED: {check}: {reason}")
    if not blind:
        tree.sign()
        print(f"signed: {len(differences)} changed")
    return 1 if blind else 0


def _blind(differences: dict[str, list[str]]) -> dict[str, str]:
    """Say of each changed check, if so, that none of its mutants is caught."""
    changed = {name for name, words in differences.items()}
    blind = {}
    for entry in ledger():
        if entry.name in changed:
            words = " ".join(differences[entry.name])
            for kind, check in checks_of(entry):
                if check in words or "new" in differences[entry.name]:
                    caught = first_caught(kind, check)
                    if caught is None:
                        blind[check] = "no mutant of it is caught"
    return blind


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
