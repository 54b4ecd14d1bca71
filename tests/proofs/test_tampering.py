"""Nothing is weakened unseen: every tampering differs from what is signed, or is refused."""

import shutil
from collections import Counter, defaultdict
from pathlib import Path

import pytest

from proofs.formal.rocq_sources import assumed
from proofs.ledger.code import ROOT, Code
from proofs.ledger.ledger import LedgerError, ledger
from proofs.ledger.mutants import checks_of, first_caught, mutants
from proofs.ledger.signatures import FILE, Tree

from .tamperings import (
    ERRATA,
    HARMLESS,
    around_the_checks,
    definitions,
    gutted,
    of_other_kinds,
    of_the_review,
)

ALL = [*of_the_review(ROOT), *of_other_kinds(), *around_the_checks(ROOT)]
CHECKS = list(dict.fromkeys(check for entry in ledger() for check in checks_of(entry)))


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy of what the signatures are about."""
    root = tmp_path_factory.mktemp("tree")
    remaining = shutil.ignore_patterns(
        "*.vo*", "*.glob", ".*", "__pycache__", "CoqMakefile*", "Check.v"
    )
    for folder in ("proofs", "compensator_theory/strategies", ERRATA):
        shutil.copytree(ROOT / folder, root / folder, ignore=remaining)
    return Tree(root)


@pytest.fixture
def edited(tree):
    """Edit the copy; what was there comes back."""
    texts = {}

    def edit(change):
        for path in tree.root.rglob("*"):
            if path.suffix in (".py", ".toml", ".v", ".txt"):
                texts[path] = path.read_bytes()
        change(tree.root)

    yield edit
    for path, text in texts.items():
        if not path.exists() or path.read_bytes() != text:
            path.write_bytes(text)


def is_caught(tree):
    """Whether the checks of a checkout, without Coq, see a difference or refuse it."""
    try:
        return bool(tree.differences() or assumed(tree.root / "proofs" / "rocq"))
    except (LedgerError, ValueError):
        return True


def test_every_statement_is_as_it_was_signed():
    assert Tree().differences() == {}, "python -m proofs.ledger.sign shows and signs what changed"


def test_there_are_those_of_the_review_and_forty_others():
    kinds = Counter(tampering.kind for tampering in of_the_review(ROOT))
    assert kinds["statement in Coq"] + kinds["types committed"] == 13
    assert kinds["properties gutted"] >= 28 and kinds["counterexamples gutted"] >= 35
    assert sum(kinds.values()) >= 109
    assert len(list(of_other_kinds())) >= 50
    assert len(list(around_the_checks(ROOT))) >= 60
    assert len({tampering.name for tampering in ALL}) == len(ALL)


@pytest.mark.costly
def test_a_tampering_of_every_kind_is_caught(tree, edited, in_full):
    by_kind = defaultdict(list)
    for tampering in ALL:
        by_kind[tampering.kind].append(tampering)
    chosen = ALL if in_full else [t for result in by_kind.values() for t in (result[0], result[-1])]
    unseen = []
    texts = {p: p.read_bytes() for p in tree.root.rglob("*") if p.is_file()}
    for tampering in chosen:
        tampering.edit(tree.root)
        if not is_caught(tree):
            unseen.append(tampering.name)
        for path in tree.root.rglob("*"):
            if path.is_file() and path not in texts:
                path.unlink()
        for path, text in texts.items():
            if path.read_bytes() != text:
                path.write_bytes(text)
    assert unseen == []


@pytest.mark.costly
@pytest.mark.parametrize("change", HARMLESS)
def test_what_claims_nothing_needs_no_signature(tree, edited, change):
    edited(change)
    assert not is_caught(tree)


def test_a_fingerprint_written_by_hand_is_refused(tree, edited):
    text = (tree.root / FILE).read_text()
    first = text.split()[0]
    edited(lambda root: (root / FILE).write_text(text.replace(first, "0" * 12, 1)))
    with pytest.raises(ValueError, match="not that of its parts"):
        tree.signed()


@pytest.mark.costly
@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check[1])
def test_every_check_has_mutants(check):
    """A check whose text leaves nothing to change claims nothing."""
    assert any(mutant.kind != "comparison" for mutant in mutants(*check))


@pytest.mark.costly
def test_a_mutant_of_every_check_is_caught(in_full):
    blind = [check for check in CHECKS[:: 1 if in_full else 26] if first_caught(*check) is None]
    assert blind == []


@pytest.mark.parametrize("package", ["symbolic", "properties", "counterexamples"])
def test_a_gutted_check_cannot_be_signed(tree, edited, package):
    """Where a check is left with its statement and an answer there is nothing to change."""
    file, node = next(definitions(tree.root, package))
    edited(gutted(file, node))
    check = f"{Path(file).stem}.{node.name}"
    assert [m for m in mutants(package, check, Code(tree.root)) if m.kind != "comparison"] == []
